"""Schemes: from a mesh with Hermite data to a piecewise surface, with claims that are checked."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, Flag, auto
from types import MappingProxyType
from typing import ClassVar, final

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.base import Plugin


class Data(Flag):
    """Data of a mesh: what a scheme needs, and what its surface matches.

    The first three are at the vertices; ``CENTRES`` are points, normals and second forms at the centres of the faces.
    """

    POINTS = auto()
    NORMALS = auto()
    SECOND_FORMS = auto()
    CENTRES = auto()


class Continuity(Enum):
    """How neighbouring patches join."""

    C0 = "C0"
    G1 = "G1"
    G2 = "G2"
    C1 = "C1"


class Shape(Enum):
    """Surfaces that a scheme may claim to reproduce exactly."""

    PLANES = "planes"
    SPHERES = "spheres"
    QUADRICS = "quadrics"


def check_needs(plugin: Plugin, needs: Data, mesh: HermiteMesh) -> None:
    """Refuse a mesh that lacks data the plugin needs."""
    if Data.NORMALS in needs and mesh.normals is None:
        raise Refused(
            f"{plugin} needs vertex normals and the mesh has none: give normals, or let load_mesh estimate them"
        )
    if Data.SECOND_FORMS in needs and mesh.second_forms is None:
        raise Refused(
            f"{plugin} needs second fundamental forms at the vertices and the mesh has none: give second_forms"
        )
    if Data.CENTRES in needs and mesh.face_data.centres is None:
        raise Refused(
            f"{plugin} needs samples at the centres of the faces and the mesh has none: give face_data with centres"
        )


@dataclass(frozen=True)
class Scheme(Plugin):
    """An interpolation scheme; a frozen dataclass whose fields are its parameters.

    A claim that the parameters decide may be a property; claims are read from objects, not from the class.

    Attributes
    ----------
    domain
        Vertices of the faces it takes, ``(3,)``, ``(4,)`` or both.
    needs
        Data it reads at the vertices, besides what its boundary curves read.
    matches
        Data its surface interpolates at the vertices (claim).
    continuity
        How its patches join (claim).
    order
        Claimed order of convergence of the distance, or None.
    reproduces
        Surfaces it claims to reproduce when the data are sampled from them.
    support
        Rings of neighbouring faces whose data a face's surface depends on (claim): 0 when its own vertices decide, None
        when the whole mesh does.
    restricted
        Takes special data only, and says so: most meshes are refused.
    vertical
        Takes z for heights over the plane z = 0: its surface moves with the data in motions of that plane only.
    bounds
        Ranges (low, high) of its free real parameters within which a search for better values makes sense.
    """

    domain: ClassVar[tuple[int, ...]] = (3,)
    needs: ClassVar[Data]
    matches: ClassVar[Data]
    continuity: ClassVar[Continuity]
    order: ClassVar[float | None]
    reproduces: ClassVar[tuple[Shape, ...]]
    support: ClassVar[int | None] = 0
    restricted: ClassVar[bool] = False
    vertical: ClassVar[bool] = False
    bounds: ClassVar[Mapping[str, tuple[float, float]]] = MappingProxyType({})
    required: ClassVar[tuple[str, ...]] = (
        *Plugin.required,
        "needs",
        "matches",
        "continuity",
        "order",
        "reproduces",
    )

    @abstractmethod
    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build the surface; the mesh has all the data declared in ``needs``. Refused for data it cannot take."""

    @final
    def fit(self, mesh: HermiteMesh) -> Surface:
        """Return the surface through the mesh.

        Raises
        ------
        Refused
            The data are not for this scheme; a finite surface or none.
        """
        if mesh.sides not in self.domain:
            kinds = " or ".join({3: "triangles", 4: "quadrilaterals"}[n] for n in self.domain)
            raise Refused(
                f"{self} takes meshes of {kinds}, and this mesh's faces have {mesh.sides} sides: make {kinds} of them"
            )
        check_needs(self, self.needs, mesh)
        surface = self.construct(mesh)
        for part in surface.parts:
            if not part.batch.finite.all():
                face = int(part.faces[~part.batch.finite][0])
                raise Refused(
                    f"{self} finds no finite patch for face {face} (vertices {', '.join(map(str, mesh.faces[face]))}): "
                    "check the size of the data there"
                )
        return surface
