"""Nagata's patch (2005): one quadratic Bezier triangle a face, from points and normals.

The curve of an edge is x(t) = V_i + (d - c) t + c t^2, d = V_j - V_i; of all vectors c that make it perpendicular to
both normals at its ends, c is the shortest. It lies in the span of the normals, and the middle control point
(V_i + V_j - c) / 2 is the point of both tangent planes nearest the midpoint of the edge.

Matches position and normal at the corners wherever such curves exist; a boundary curve depends on the data at its two
ends only, so the surface is C0. Parallel normals that are not perpendicular to the edge have no such curve: there
c = 0, as published; the edge is straight and misses the normals, and the notes count such edges. Formulas: as printed;
**fill**: how nearly parallel is parallel, and the refusal of corners that fold.
"""

from dataclasses import dataclass

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, dot, norm
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import STRAIGHT, edge_normals
from testbed_schemes.quadratic_interpolant import CORNERS, MIDDLES


@dataclass(frozen=True)
class Nagata(Scheme):
    """Nagata's quadratic patch.

    Parameters
    ----------
    parallel
        Sine of the angle of the normals at the ends of an edge up to which they count as parallel and the edge stays
        straight. Nearly parallel normals send the curve far to the side, as one over the sine.

    Raises
    ------
    SpecError
        ``parallel`` is not between 0 and 1.
    """

    parallel: float = 1e-6

    name = "nagata"
    title = "Nagata patch"
    reference = "Nagata 2005"
    formula = (
        "Quadratic Bezier triangle; middle points (V_i + V_j - c) / 2, c = [N_i N_j] [[1, a], [a, 1]]^-1 "
        "(<N_i, d>, -<N_j, d>), a = <N_i, N_j>, d = V_j - V_i; c = 0 where the normals are parallel."
    )
    status = "As printed. Fill: normals are parallel up to the sine `parallel`; data that fold a corner are refused."
    failures = (
        "Edges that bend both ways: parallel normals leave them straight and miss the normals there (26 degrees on a "
        "step with slope 1/2), nearly parallel ones send them far aside, until a corner folds and the data are refused."
    )
    needs = Data.POINTS | Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the threshold."""
        if not 0.0 <= self.parallel < 1.0:
            raise SpecError(f"{self.name}: parallel is a sine, at least 0 and below 1, and here it is {self.parallel}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the quadratic triangles; counts edges that stay straight although their normals ask for a bend."""
        edges = mesh.edge_data
        c, straightened = curvature_vectors(edges, self.parallel)
        middle = (edges.p0 + edges.p1 - c) / 2.0
        check_corners(self, mesh, middle - edges.p0, middle - edges.p1)
        check_sides(self, mesh, middle - edges.p0, middle - edges.p1)
        count = int(straightened.sum())
        return Surface.over_faces(
            mesh, quadratic_triangles(mesh, middle), {"edges left straight": count} if count else {}
        )


def curvature_vectors(edges: EdgeData, parallel: float) -> tuple[Float, Bool]:
    """Nagata's c of all edges (E, 3), and (E,) true where it is zero for want of a solution.

    c = al N_i + be N_j with <N_i, c> = <N_i, d> and <N_j, c> = -<N_j, d>. In the sum and the difference of the normals,
    which are perpendicular, the two equations come apart: nothing is lost by cancellation where a is near 1 or -1.
    """
    n0, n1 = edge_normals(edges)
    d = edges.p1 - edges.p0
    at0, at1 = dot(n0, d), dot(n1, d)
    added, difference = n0 + n1, n0 - n1
    with np.errstate(invalid="ignore", divide="ignore"):  # parallel normals: chosen below
        c = ((at0 - at1) / dot(added, added))[:, None] * added + ((at0 + at1) / dot(difference, difference))[
            :, None
        ] * difference
    as_one = ~(norm(cross(n0, n1)) > parallel)
    bends = np.maximum(np.abs(at0), np.abs(at1)) > STRAIGHT * norm(d)
    return np.where(as_one[:, None], 0.0, c), as_one & bends


def quadratic_triangles(mesh: HermiteMesh, middle: Float) -> BezierTriangles:
    """Quadratic triangles over the faces from the middle points of all edges, (E, 3)."""
    net = np.empty((len(mesh.faces), 6, 3))
    net[:, CORNERS] = mesh.corner_points()
    net[:, MIDDLES] = middle[mesh.face_edges]
    return BezierTriangles(net)
