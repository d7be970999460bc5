"""Generalised B-spline networks of S-patches from control meshes: the thesis's branch and ring, and those of files."""

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

from testbed.geometry.charted import ChartedMesh
from testbed.geometry.charted_surface import ChartedSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.network_charts import charted_network
from testbed.geometry.polygon_mesh import load_polygons
from testbed.geometry.spline_network import SplineNetwork, spline_network
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import check_level

#: The control meshes that come with the package.
BRANCH: Final = Path(__file__).with_name("branch.obj")
RING: Final = Path(__file__).with_name("ring.obj")
CUSHION: Final = Path(__file__).with_name("cushion.obj")


@dataclass(frozen=True)
class NetworkMesh(Dataset):
    """Triangles on a network of S-patches: level 0 joins each patch's centre to its corners, triangles stay whole.

    The network has one tangent plane everywhere, but second fundamental forms of its own on either side of the edges of
    patches that are not quadrilateral: vertices there have one form for each face. The edges of the patches are curves
    that the interpolating patches follow.
    """

    effort: ClassVar[float] = 18.0  # nearest points of S-patches by Newton's method

    @abstractmethod
    def control_mesh(self) -> Path:
        """Return the file of the control mesh."""

    def files(self) -> tuple[Path, ...]:
        """Return the file of the control mesh."""
        return (self.control_mesh(),)

    def network(self) -> SplineNetwork:
        """Return the patches.

        Raises
        ------
        MeshError
            The control mesh cannot be read, or carries no network.
        """
        return spline_network(load_polygons(self.control_mesh()))

    def charted(self) -> ChartedMesh:
        """Return level 0 in the charts that the patches are."""
        return charted_network(self.network())

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the parameters of the patches; Refused if there is none."""
        coarsest = self.charted()
        check_level(level, len(coarsest.faces), self.name)
        return coarsest.halved(level).sampled()

    @property
    def surface(self) -> ChartedSurface:
        """The network."""
        return ChartedSurface(self.charted().charts)


@dataclass(frozen=True)
class Branch(NetworkMesh):
    """Three tubes that meet: 20 bicubic and 4 five-sided S-patches, 55 vertices, 100 faces.

    The published control mesh is lost; this one gives exactly its numbers of patches and control points. It is a
    sphere with three holes: with four edges at every vertex the sides of all patches say so.
    """

    name = "branch"
    title = "Branch"
    reference = "Mann 1992, figures 5.4 and 5.9 and table 5.2; the control mesh is a reconstruction"
    closed = False
    finest = 3

    def control_mesh(self) -> Path:
        """Return the file that comes with the package."""
        return BRANCH


@dataclass(frozen=True)
class Ring(NetworkMesh):
    """A ring like a signet: 31 bicubic, 4 three-sided and 2 six-sided S-patches, 70 vertices, 140 faces.

    The published control mesh is lost; this one gives exactly its numbers of patches. It is a closed torus. Level 0 has
    angles down to 10 degrees, in the six-sided patches.
    """

    name = "ring"
    title = "Ring"
    reference = "Mann 1992, figures 5.5 and 5.10 and table 5.3; the control mesh is a reconstruction"
    closed = True
    finest = 3

    def control_mesh(self) -> Path:
        """Return the file that comes with the package."""
        return RING


@dataclass(frozen=True)
class NetworkFile(NetworkMesh):
    """Spline network of a control mesh in a file, ``network:PATH``; plain ``network`` is a cushion.

    Parameters
    ----------
    path
        A Wavefront OBJ file of polygons, relative to the current folder. Four edges meet at every vertex inside; faces
        with a vertex on the boundary are there for control only. Without one, a small example that comes with the
        package: a closed surface of 8 three-sided and 6 bicubic patches.
    """

    path: str = ""

    name = "network"
    title = "Spline network of a control mesh"
    reference = "The file; the construction of Loop and DeRose 1990"
    positional: ClassVar[str | None] = "path"
    closed: ClassVar[bool | None] = None
    finest = 3

    def control_mesh(self) -> Path:
        """Return the file."""
        return Path(self.path) if self.path else CUSHION
