"""Peters' scheme (1991) on triangles: three cubic Bezier triangles a face where that can be, else three quartics.

Matches position and normal at the corners. Every boundary curve of degree two or less carries second rows of its own;
a cubic one gets those of both sides at once, from a linear system that has no good solution where the two sides are
alike. There the edge takes the quartic points of Chiyokura and Kimura and both faces become quartic: symmetric data
give the scheme of Jensen. Which edges do is decided edge by edge, so that the two faces of an edge agree. Inside a face
all joins are C1.

Formulas: Mann 1992, sections 2.2.4 and 2.3.1, restricted there to triangles; spokes and (2.8) as printed, "cubic
patches with quartic boundaries" in section 2.2.3 read as quartic patches with cubic ones. **Fill**: the system for
cubic boundaries, how near to singular is too near, the inner points N_i of quartic faces, which keep a split cubic, and
cubic edges on the boundary of the mesh: they have no other side, and take Chiyokura and Kimura's points in quartic
faces, and in cubic ones the points nearest to those.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Bool, Float, Int, norm
from testbed.plugins.base import check_finite
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, cross_boundary_points
from testbed_schemes.continuity_conditions.peters import CubicJoin, quadratic_boundary_point
from testbed_schemes.mathematics.planar_frame import edge_normals
from testbed_schemes.mathematics.split_domain import (
    J,
    K,
    c1_cubics,
    c1_ring,
    corner_neighbours,
    cubic_reproducing_inner,
    nearest_cubic_points,
)

#: A curve is a quadratic if its third difference is smaller than this part of its chord, or than rounding of its
#: coordinates: normals on its two sides then differ by no more than that.
THIRD_DIFFERENCE = (1e-12, 16.0 * float(np.finfo(np.float64).eps))


@dataclass(frozen=True)
class Peters(Scheme):
    """Peters' split cubics, quartics where cubics have no good solution.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges; curves that are quadratics raised to cubics are found by their third
        difference.
    tol
        Least determinant of the system of a cubic edge, above 0; it lies between 0 (the two sides alike) and 1. The
        control points grow as its inverse. From 1 on every cubic edge between two faces is quartic.
    jensen_c
        Jensen's C on the edges that take quartic points.

    Raises
    ------
    SpecError
        ``tol`` is not positive and finite, or ``jensen_c`` not finite.
    """

    boundary: BoundaryCurve = PetersCurve()
    tol: float = 0.1
    jensen_c: float = 1.0

    name = "peters"
    title = "Peters"
    reference = "Peters 1991, Smooth mesh interpolation with cubic patches; Mann 1992, sections 2.2.4 and 2.3.1"
    formula = (
        "Three cubics a face, every spoke point the centroid of its neighbours; Q_i by (2.8) on quadratic edges, on "
        "cubic ones from a H' = b F + c G with a, b, c linear; where |b_0 c_1 - b_1 c_0| < tol, Jensen's quartics."
    )
    status = (
        "As printed on quadratic edges and spokes; fill: the system of cubic edges with b + c = 1, tol, N_i of quartic "
        "faces, cubic edges on the boundary of the mesh."
    )
    failures = (
        "Cubics next to singular edges have control points that grow as 1 / tol: on a torus of 100 faces with "
        "projected curves K is in [-13, 7] at tol = 0.1, where all faces are quartic, and in [-40, 28] at 0.05. On "
        "smooth data nearly every cubic edge is that near to singular, so that cubic faces come from quadratic edges, "
        "which are flat at their ends and sharp in the middle. Refused where the normals of an edge are "
        "opposite as seen along it."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    bounds = MappingProxyType({"jensen_c": (0.5, 2.0)})
    support = 1  # a cubic edge reads the faces on its two sides

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not (np.isfinite(self.tol) and self.tol > 0.0):
            raise SpecError(f"{self.name}: tol must be positive and finite, and here it is {self.tol}")
        check_finite(self, "jensen_c")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build three cubics a face, or three quartics; counts the quartic faces."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        rows = SecondRows.of(network, self.tol)
        raised = rows.quartic[mesh.face_edges].any(axis=1)
        parts = [
            _part(mesh, faces, partial(nets, rows))
            for faces, nets in ((np.flatnonzero(~raised), self.cubics), (np.flatnonzero(raised), self.quartics))
            if len(faces)
        ]
        count = int(raised.sum())
        return Surface(mesh, tuple(parts), {**network.notes, **({"faces made quartic": count} if count else {})})

    def cubics(self, rows: "SecondRows", faces: Int) -> Float:
        """Return the nets of faces without quartic edges, (N, 3, 10, 3)."""
        sides = rows.sides(faces)
        return c1_cubics(sides.curves, self.cross_points(sides))

    def quartics(self, rows: "SecondRows", faces: Int) -> Float:
        """Return the nets of faces with a quartic edge, (N, 3, 15, 3).

        The rows of solved and of quadratic edges are raised cubics; free ones may as well be quartic.
        """
        sides = rows.sides(faces)
        centre, first = self.cross_points(sides), sides.curves[:, K, 0] + sides.legs
        quartic = (sides.quartic | sides.free)[..., None]
        near = zip(sides.quartic_points(self.jensen_c), (J, K), (1, 2), strict=True)
        start, end = (
            np.where(quartic, point, (2.0 * centre + first[:, corner] + sides.curves[:, :, r]) / 4.0)
            for point, corner, r in near
        )
        boundary = elevate_curve(sides.curves)
        return c1_ring(boundary, (start, end), cubic_reproducing_inner(boundary, sides.curves, (start, end))).nets()

    def cross_points(self, sides: "Sides") -> Float:
        """Return Q_i, (N, 3, 3); NaN on quartic edges."""
        legs, normals = (sides.legs[:, J], sides.legs[:, K]), (sides.normals[:, J], sides.normals[:, K])
        alone = quadratic_boundary_point(sides.curves, *legs, *normals)
        points = np.where(sides.quadratic[..., None], alone, sides.solved)
        if sides.free.any():
            boundary = elevate_curve(sides.curves)
            nearest = nearest_cubic_points(boundary, sides.curves, sides.quartic_points(self.jensen_c))
            points = np.where(sides.free[..., None], nearest, points)
        return points


def _part(mesh: HermiteMesh, faces: Int, nets: Callable[[Int], Float]) -> Part:
    """Three patches for each of some faces (N,), from their nets (N, 3, n, 3)."""
    net = in_blocks(lambda block: nets(faces[block]), len(faces))
    return Part.of_split_faces(mesh, BezierTriangles(net.reshape(-1, *net.shape[2:])), faces)


@dataclass(frozen=True, slots=True)
class Sides:
    """The edges of N faces as seen from them: entry i belongs to the edge opposite corner i, from i + 1 to i + 2.

    Parameters
    ----------
    curves
        (N, 3, 4, 3) boundary curves.
    normals
        (N, 3, 3) unit normals by corner.
    quadratic, quartic, free
        (N, 3) true where the edge is a quadratic; where the second row is quartic; where it is a cubic without another
        side.
    solved
        (N, 3, 3) Q_i of cubic edges that have been solved for, NaN on others.
    """

    curves: Float
    normals: Float
    quadratic: Bool
    quartic: Bool
    free: Bool
    solved: Float

    @property
    def legs(self) -> Float:
        """From the corners to the first spoke points of cubics, the centroids of corner and neighbours, (N, 3, 3)."""
        return spoke_legs(self.curves)

    def quartic_points(self, jensen_c: float) -> tuple[Float, Float]:
        """C_ij and C_ik by Chiyokura and Kimura, (N, 3, 3) each; a quartic's legs are three quarters of a cubic's."""
        legs, normals = 0.75 * self.legs, self.normals
        return cross_boundary_points(
            self.curves, legs[:, J], legs[:, K], normals[:, J], normals[:, K], jensen_c=jensen_c
        )


@dataclass(frozen=True, slots=True)
class SecondRows:
    """What becomes of each edge's second rows.

    Parameters
    ----------
    network
        The boundary curves.
    quadratic
        (E,) true for quadratics.
    quartic
        (E,) true for cubics whose system is too near to singular.
    solved
        (2, E, 3) the middle points of the other cubics' second rows: of the face that runs along the edge forward, and
        of the face that runs back. NaN elsewhere.
    """

    network: CurveNetwork
    quadratic: Bool
    quartic: Bool
    solved: Float

    @classmethod
    def of(cls, network: CurveNetwork, tol: float) -> "SecondRows":
        """Solve for the cubic edges between two faces; those of a determinant below ``tol`` are quartic."""
        mesh = network.mesh
        quadratic = is_quadratic(network.control_points)
        quartic, solved = np.zeros(len(mesh.edges), dtype=np.bool_), np.full((2, len(mesh.edges), 3), np.nan)
        chosen = np.flatnonzero(~quadratic & ~mesh.boundary_edges)
        if len(chosen):
            legs = in_blocks(lambda faces: spoke_legs(network.opposite_vertices(faces)), len(mesh.faces))
            forward, back = legs_by_edge(mesh, legs)[:, :, chosen]
            normals = edge_normals(mesh.edge_data[chosen])
            join = CubicJoin.between(network.control_points[chosen], forward, back, normals)
            quartic[chosen] = ~(np.abs(join.determinant) >= tol)
            solved[:, chosen] = np.where(quartic[chosen, None], np.nan, join.points())
        return cls(network, quadratic, quartic, solved)

    def sides(self, faces: Int) -> Sides:
        """Return what belongs to the edges of some faces (N,)."""
        mesh = self.network.mesh
        own = np.roll(mesh.face_edges[faces], -1, axis=1)
        side = np.where(np.roll(mesh.face_edge_forward[faces], -1, axis=1), 0, 1)
        return Sides(
            self.network.opposite_vertices(faces),
            mesh.corner_normals(faces),
            self.quadratic[own],
            self.quartic[own],
            ~self.quadratic[own] & mesh.boundary_edges[own],
            self.solved[side, own],
        )


def spoke_legs(curves: Float) -> Float:
    """From each corner to the centroid of the corner and its two neighbours on the curves (F, 3, n, 3), (F, 3, 3)."""
    corner = curves[:, K, 0]
    towards_next, towards_previous = corner_neighbours(curves)
    return ((towards_next - corner) + (towards_previous - corner)) / 3.0


def legs_by_edge(mesh: HermiteMesh, legs: Float) -> Float:
    """Sort vectors by face corner (F, 3, 3) by edge, (2, 2, E, 3); NaN where an edge has no such face.

    Axis 0: of the face that runs along the edge forward, and of the one that runs back; axis 1: at the lower vertex id
    and at the higher.
    """
    result = np.full((2, 2, len(mesh.edges), 3), np.nan)
    forward, onward = mesh.face_edge_forward, np.roll(legs, -1, axis=1)
    side = np.where(forward, 0, 1)
    result[side, 0, mesh.face_edges] = np.where(forward[..., None], legs, onward)
    result[side, 1, mesh.face_edges] = np.where(forward[..., None], onward, legs)
    return result


def is_quadratic(curves: Float) -> Bool:
    """Whether cubics (E, 4, 3) are quadratics raised, (E,): no third difference but rounding (``THIRD_DIFFERENCE``)."""
    third = norm((curves[:, 3] - curves[:, 0]) - 3.0 * (curves[:, 2] - curves[:, 1]))
    of_chord, of_place = THIRD_DIFFERENCE
    small = of_chord * norm(curves[:, 3] - curves[:, 0]) + of_place * np.abs(curves).max(axis=(1, 2))
    quadratic: Bool = third <= small
    return quadratic
