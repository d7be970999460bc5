"""A-patches (Xu, Huang and Bajaj 2001): the surface is a sheet of the zero set of a piecewise rational function F.

On the faces and edges of the mesh stand tetrahedra, above it, below it or on both sides, and F is a cubic on each, with
a rational term, or three cubics. F is C1, vanishes at the vertices and has the given vectors as its gradients there;
half-way along an edge its derivatives across are the mean of those at the ends. The surface is met by rays from the
faces towards the apexes of their tetrahedra; it is G1 and has one sheet. Plane faces with perpendicular normals remain,
and are joined smoothly. The construction does not read second fundamental forms, and the surface's curvature jumps
where tetrahedra meet: along the curves between face and edge patches, within nonconvex faces, and at the vertices,
where it depends on the direction.

**The lengths of the vectors matter.** Gradients of a quadric, all with one factor, and ``free=quadric`` give the
quadric back; unit normals of an ellipsoid do not.

Formulas: the ten steps of section 4.2 with corrected misprints; what the paper leaves open is said in the modules
:mod:`testbed_schemes.mathematics.a_patch_hull`, ``a_patch_coefficients``, ``a_patch_edges``, ``a_patch_bounds``,
``a_patch_free``, ``a_patch_single`` and ``a_patch_refinement``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Literal

import numpy as np

from testbed.errors import MeshError, Refused, SpecError
from testbed.geometry.loop_normals import loop_limit_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import dot, norm
from testbed.plugins.base import check_finite
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.a_patch_assembly import Places, SideNets, parts_of
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_parameters import free_coefficients
from testbed_schemes.mathematics.a_patch_refinement import RefinedMesh, edge_place, separated_hull
from testbed_schemes.mathematics.a_patch_sides import Hull, face_normals, hull, nets_of_edges, nets_of_faces
from testbed_schemes.mathematics.a_patch_single import SingleCubics, single_cubics


@dataclass(frozen=True)
class APatch(Scheme):
    """Implicit rational cubics over tetrahedra on faces and edges: A-patches.

    Parameters
    ----------
    free
        Free coefficient of each face, F at the apex of its tetrahedron: ``default`` makes the cubic nearly linear,
        ``quadric`` keeps quadrics, a number is taken for all faces, a vector's length times a distance. Raised where it
        is not above its bound.
    normals
        ``data``: the mesh's gradients or normals, and Loop's limit normals where it has none; ``loop``: these anyway.
    lengths
        ``data``: gradients with their lengths where the mesh has gradients; ``unit``: length one everywhere.
    split
        F on nonconvex faces: ``three`` cubics, or ``single`` ones where the paper's conditions allow it and no ray
        starts on the wrong side of the surface.
    epsilon
        Margin of the tetrahedra's heights, as part of the face's mean edge length.
    tolerance
        Up to which part of its length an edge's rise over a tangent plane counts as zero.
    modifications
        How often edges at which tetrahedra cross are split before the mesh is refused.

    Raises
    ------
    SpecError
        A number is not finite, ``epsilon`` not positive, or ``tolerance`` or ``modifications`` negative.
    """

    free: Literal["default", "quadric"] | float = "default"
    normals: Literal["data", "loop"] = "data"
    lengths: Literal["data", "unit"] = "data"
    split: Literal["three", "single"] = "three"
    epsilon: float = 0.05
    tolerance: float = 1e-12
    modifications: int = 3

    name = "a-patch"
    title = "A-patches"
    reference = "Xu, Huang and Bajaj 2001"
    formula = (
        "F(p) = 0 on tetrahedra [p_k p_i p_j u] and [u_l p_i p_j u_k]: cubics plus rational terms that carry the "
        "derivative across each edge, C1 with F = 0 and grad F = n_i at the vertices; p = (1 - t) q + t u, t least."
    )
    status = (
        "Corrected: f1011 of step 4, (4.12), (4.16), number 2 of split faces, height 0 of t_max. Fills: epsilon, "
        "layers of split faces, the margin above bounds, sharper bounds, the choice that keeps quadrics."
    )
    failures = (
        "Refused where a vertex normal points below a face there, where tetrahedra of neighbours cross after splits "
        "(needle faces), and at ridges with nu_1 + mu_4 <= -2. The default misses the sphere by 3.1 % on the "
        "icosahedron; its distances fall with orders of 2.5 to 3.5. Curvature jumps between patches."
    )
    needs = Data.POINTS
    continuity = Continuity.G1
    order = None
    bounds = MappingProxyType({"epsilon": (0.01, 0.5)})

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_finite(self, "epsilon", "tolerance")
        if not isinstance(self.free, str):
            check_finite(self, "free")
        if not self.epsilon > 0.0:
            raise SpecError(f"{self.name}: epsilon must be positive, and here it is {self.epsilon}")
        for name in ("tolerance", "modifications"):
            if getattr(self, name) < 0:
                raise SpecError(f"{self.name}: {name} must not be negative, and here it is {getattr(self, name)}")

    @property
    def matches(self) -> Data:  # type: ignore[override]  # a claim that the parameters decide
        """Points, and the data's normals if they are taken."""
        return Data.POINTS | Data.NORMALS if self.normals == "data" else Data.POINTS

    @property
    def reproduces(self) -> tuple[Shape, ...]:  # type: ignore[override]  # likewise
        """Planes; with ``free=quadric`` spheres, and all quadrics from gradients."""
        if self.free != "quadric" or self.normals != "data":
            return (Shape.PLANES,)
        return (Shape.PLANES, Shape.SPHERES, *((Shape.QUADRICS,) if self.lengths == "data" else ()))

    @property
    def support(self) -> int | None:  # type: ignore[override]  # likewise
        """The faces next to it, unless single cubics spread or Loop's normals are taken.

        Splits of edges where tetrahedra cross, and raises at sharp ridges, can reach further.
        """
        return 1 if self.split == "three" and self.normals == "data" else None

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Classify, build the tetrahedra and F over them, and cut the surface into patches."""
        refined = self._refined(mesh)
        found = self._hull(refined.mesh)
        nonconvex = found.faces == Convexity.NONCONVEX
        single = single_cubics(found) if self.split == "single" else None
        split = nonconvex if single is None else nonconvex & ~single.single
        place = partial(edge_place, mesh.faces, refined)
        sides, raised, searched = [], 0, 0
        for side in range(2):
            nets = nets_of_faces(found, side, split, None if single is None else single.turns)
            free = free_coefficients(found, side, nets, self.free, place)
            sides.append(SideNets(nets, free.top, nets_of_edges(found, side, nets, free.top)))
            raised, searched = raised + int(free.raised.sum()), searched + free.searched
        places = Places(refined.parent, refined.corners_in_parent)
        parts = parts_of(found, (sides[0], sides[1]), split, places)
        notes = {"edges split where tetrahedra cross": refined.splits} if refined.splits else {}
        if self.free == "quadric" and raised:
            notes["free coefficients above those of quadrics"] = raised
        return Surface(mesh, parts, notes, _branches(found, sides, refined, single, raised, searched))

    def _with_vectors(self, mesh: HermiteMesh) -> HermiteMesh:
        """Return the mesh with the vectors that F's gradients are to be, as its gradients."""
        if self.normals == "loop" or mesh.normals is None:
            try:
                vectors = loop_limit_normals(mesh.points, mesh.faces)
            except MeshError as error:
                raise Refused(f"{self.name} needs normals, and there are none to be had: {error}") from error
        else:
            vectors = mesh.normals
            if mesh.gradients is not None and self.lengths == "data":
                vectors = mesh.gradients
        return HermiteMesh(mesh.points, mesh.faces, gradients=vectors)

    def _refined(self, mesh: HermiteMesh) -> RefinedMesh:
        """Return the mesh with vectors, refined where tetrahedra of neighbours cross."""
        loop = self.normals == "loop" or mesh.normals is None
        return separated_hull(
            self._with_vectors(mesh), lambda finer: self._hull(finer).apexes, self.modifications, loop=loop
        )

    def _hull(self, mesh: HermiteMesh) -> Hull:
        """Return classes and apexes; Refused where a vector points below a face."""
        assert mesh.gradients is not None  # noqa: S101 - it is made with them
        vectors = mesh.gradients[mesh.faces]
        upright = dot(face_normals(mesh.corner_points())[:, None], vectors) > self.tolerance * norm(vectors)
        if not upright.all():
            face, corner = (int(one) for one in np.argwhere(~upright)[0])
            raise Refused(
                f"{self.name} needs vertex normals that point to the outer side of every face at the vertex, and that "
                f"of vertex {mesh.faces[face, corner]} does not on face {face} (vertices "
                f"{', '.join(map(str, mesh.faces[face]))}): give a finer mesh or other normals"
            )
        return hull(mesh, self.epsilon, self.tolerance)


def _branches(
    found: Hull,
    sides: Sequence[SideNets],
    refined: RefinedMesh,
    single: SingleCubics | None,
    raised: int,
    searched: int,
) -> dict[str, int]:
    """Count the ways that the construction took."""
    words = {
        Convexity.POSITIVE: "positive",
        Convexity.NEGATIVE: "negative",
        Convexity.NONCONVEX: "nonconvex",
        Convexity.ZERO: "flat",
    }
    counts = {f"{word} faces": int((found.faces == convexity).sum()) for convexity, word in words.items()}
    counts |= {f"{word} edges": int((found.edges == convexity).sum()) for convexity, word in words.items()}
    counts["tetrahedra of faces"] = sum(len(one.faces.pieces().owner) for one in sides)
    counts["tetrahedra of edges"] = sum(len(one.edges.edges) for one in sides)
    counts["searches for bounds"] = searched
    counts["free coefficients raised to their bounds"] = raised
    counts["hull modifications"] = refined.splits
    if single is not None:
        counts["single cubics"] = int(single.single.sum())
        counts["nonconvex faces that single cubics would tear"] = single.given_up
    return counts
