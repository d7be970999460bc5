"""The ellipsoid 4x^2 + 2y^2 + z^2 = 4, which the thesis approximates by adaptive refinement."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import unit
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Shape
from testbed_datasets.halving import halved
from testbed_datasets.octahedron import axis_octahedron
from testbed_datasets.parameters import positive
from testbed_datasets.quadric import Quadric


@dataclass(frozen=True)
class Ellipsoid(Dataset):
    """Ellipsoid with semi-axes a, b, c along x, y, z, from the octahedron of its six vertices: 6 vertices, 8 faces.

    The thesis's start mesh is lost; the axis octahedron stands for it. The middles of edges are projected onto the
    surface from the centre. The mesh shares the symmetry planes of the surface, so some schemes show one order of
    convergence more than holds in general.

    Parameters
    ----------
    a, b, c
        Semi-axes.
    """

    a: float = 1.0
    b: float = 2.0**0.5
    c: float = 2.0

    name = "ellipsoid"
    title = "Ellipsoid"
    reference = "Mann 1992, figures 5.2 (page 81) and 5.7 (page 94); its start mesh is lost"
    closed = True
    shape = Shape.QUADRICS
    finest = 4

    def __post_init__(self) -> None:
        positive(self.name, a=self.a, b=self.b, c=self.c)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level; Refused if there is none."""
        # stretching the sphere's mesh along the axes projects middles from the centre exactly
        directions, faces = halved(
            *axis_octahedron(), level, name=self.name, middle=lambda start, end: unit(start + end)
        )
        return self.surface.sample(directions * np.array([self.a, self.b, self.c]), faces)

    @property
    def surface(self) -> Quadric:
        """The ellipsoid, normals outward."""
        return Quadric((self.a, self.b, self.c))
