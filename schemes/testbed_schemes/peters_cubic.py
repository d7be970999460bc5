"""Peters' single cubics (1991): one cubic Bezier triangle a face, whose normal turns linearly along every edge.

Matches position and normal at the corners. Along an edge the patches on both sides are perpendicular to
(1 - t) N_j + t N_k, so that they join G1 without reading each other. That asks for curves without inflections, whose
end tangents the two normals decide, and at each corner for legs and normals that fit a common second fundamental form.
Data from few surfaces do; all others are refused, with the residual of the equations for the centre.

**Fill**: the thesis (Mann 1992, section 2.3.3) names the construction and its restrictions and gives no formulas. Here
the equations are written out from the linear normal; the directions of the end tangents, along the projected chord, and
the centre where the normals leave it open, next to the point of quadratic precision, are choices of ours.
"""

from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import blocks, in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.mesh_checks import named
from testbed.geometry.nets import CENTRE, boundary_net, corner_legs
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, dot, norm
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import (
    PARALLEL,
    STRAIGHT,
    curve_from_legs,
    edge_normals,
    projected_tangents,
)
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre


@dataclass(frozen=True)
class PetersCubic(Scheme):
    """Peters' cubics with linearly varying boundary normals.

    Parameters
    ----------
    tol
        Largest residual, in lengths of the face's longest edge, of the equations for the centre, above 0. The normals
        of neighbouring patches differ by about as much, in radians.

    Raises
    ------
    SpecError
        ``tol`` is not positive and finite.
    """

    tol: float = 1e-11

    name = "peters-cubic"
    title = "Peters' cubics"
    reference = "Peters 1991, Local cubic and bicubic C1 surface interpolation; Mann 1992, section 2.3.3"
    formula = (
        "One cubic a face, every edge with <H', (1 - t) N_j + t N_k> = 0; at each corner j the centre Q has "
        "<Q - V_j, N_j> = -<y, N_k> / 2 = -<x, N_i> / 2, x and y the legs towards k and i."
    )
    status = (
        "Fill: the source names the construction only. Equations derived from the linear normal; tangents along the "
        "projected chord."
    )
    failures = (
        "Takes data of planes, and of spheres where every corner of a face is right-angled or has two sides of one "
        "length (the regular polyhedra, bipyramids over an equator). Refuses nearly all else: every dataset beyond the "
        "plane and the coarsest octahedron and icosahedron, for a residual between 1e-4 and 5e-2 edges or for an "
        "inflected edge."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    restricted = True

    def __post_init__(self) -> None:
        """Check the tolerance."""
        if not (np.isfinite(self.tol) and self.tol > 0.0):
            raise SpecError(f"{self.name}: tol must be positive and finite, and here it is {self.tol}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the cubics; Refused for an edge without its curve, or a face whose equations contradict each other."""
        curves = in_blocks(lambda edges: linear_normal_curves(mesh.edge_data[edges]), len(mesh.edges))
        network = CurveNetwork(mesh, curves)
        self.check_curves(network)
        check_corners(self, mesh, *network.end_legs)
        check_sides(self, mesh, *network.end_legs)
        net = boundary_net(network)
        residual = np.empty(len(net))
        for faces in blocks(len(net)):
            net[faces, CENTRE], residual[faces] = centre_points(net[faces], mesh.corner_normals(faces))
        self.check_residual(mesh, residual)
        return Surface.over_faces(mesh, BezierTriangles(net))

    def check_curves(self, network: CurveNetwork) -> None:
        """Refuse edges that have no curve with a linear normal and no inflection; the message names the first."""
        missing = ~np.isfinite(network.control_points).all(axis=(1, 2))
        if missing.any():
            edge = int(np.argmax(missing))
            i, j = network.mesh.edges[edge].tolist()
            face = int(network.mesh.edge_faces[edge].max())
            raise Refused(
                f"{self} has no curve for {int(missing.sum())} of {len(network.mesh.edges)} edges, the first from "
                f"vertex {i} to vertex {j} of face {face}, as no cubic without inflection has a normal that turns "
                "linearly from one to the other: use a scheme that is not restricted, as peters"
            )

    def check_residual(self, mesh: HermiteMesh, residual: Float) -> None:
        """Refuse faces whose residual is above ``tol``; the message names the one of the largest."""
        unfit = ~(residual <= self.tol)  # NaN is unfit
        if unfit.any():
            face = int(np.argmax(residual))  # the first NaN where there is one
            raise Refused(
                f"{self} has no centre for {int(unfit.sum())} of {len(residual)} faces, the worst of them "
                f"{named(mesh.faces, face)}, whose equations leave a residual of {residual[face]:.2g} edge lengths, as "
                "the data have no common curvature at the corners: use a scheme that is not restricted, as peters"
            )


def linear_normal_curves(edges: EdgeData) -> Float:
    """Return cubics with <H', (1 - t) N0 + t N1> = 0 along the whole edge, (E, 4, 3).

    With unit end tangents t0, t1 along the projected chord e, and legs a and b, the middle coefficients of that product
    are 2 <v_1, N0> + <v_0, N1> = 0 and <v_2, N0> + 2 <v_1, N1> = 0, that is

        a <t0, N1> = (4 <e, N1> + 2 <e, N0>) / 3,    b <t1, N0> = (4 <e, N0> + 2 <e, N1>) / 3.

    A chord in both tangent planes leaves a and b open, and is the curve. NaN where a leg is not above zero, infinite,
    or a normal parallel to the chord.
    """
    n0, n1 = edge_normals(edges)
    chord = edges.p1 - edges.p0
    (t0, t1), length = projected_tangents(chord, n0, n1)
    height0, height1 = dot(chord, n0), dot(chord, n1)
    straight = np.maximum(np.abs(height0), np.abs(height1)) <= STRAIGHT * length
    with np.errstate(invalid="ignore", divide="ignore"):  # parallel normals: no leg
        a = (4.0 * height1 + 2.0 * height0) / (3.0 * dot(t0, n1))
        b = (4.0 * height0 + 2.0 * height1) / (3.0 * dot(t1, n0))
    legs = (np.where(straight, length / 3.0, np.where((leg > 0.0) & np.isfinite(leg), leg, np.nan)) for leg in (a, b))
    return curve_from_legs(edges, (t0, t1), *legs)


def centre_points(net: Float, normals: Float) -> tuple[Float, Float]:
    """Return the centres (F, 3) of cubic nets over linear normals, and the residuals of their equations, (F,).

    Along the edge from corner j to k, sum_r B^2_r (F_r - H_r) perpendicular to the normal has the middle coefficients
    2 <Q - H_1, N_j> + <F_0 - H_0, N_k> = 0 and <F_2 - H_2, N_j> + 2 <Q - H_1, N_k> = 0: six equations on three edges.
    On boundary curves with linear normals those of two edges at a corner have one left side,

        <Q - V_j, N_j> = -<y, N_k> / 2    and    <Q - V_j, N_j> = -<x, N_i> / 2,

    with x and y the legs from V_j towards the next corner k and the previous i. Solved in least squares, about the
    point of quadratic precision where the normals are dependent.

    Parameters
    ----------
    net
        (F, 10, 3) cubic nets with their boundaries.
    normals
        (F, 3, 3) unit normals by corner.

    Returns
    -------
    centres
        (F, 3).
    residual
        The largest of the six, over the longest side of the face.
    """
    vertex, towards_next, towards_previous = corner_legs(net)
    guess = quadratic_precision_centre(net)
    height = dot(vertex - guess[:, None], normals)
    one = height - dot(towards_previous, np.roll(normals, -1, axis=1)) / 2.0
    other = height - dot(towards_next, np.roll(normals, 1, axis=1)) / 2.0
    # each normal stands in two equations, of equal weight: their mean has the same least squares
    inverse = np.linalg.pinv(normals, rcond=PARALLEL)
    moved = np.einsum("fij,fj->fi", inverse, (one + other) / 2.0)
    found = np.einsum("fji,fi->fj", normals, moved)
    misfit = np.maximum(np.abs(found - one), np.abs(found - other)).max(axis=1)
    size = norm(np.roll(vertex, -1, axis=1) - vertex).max(axis=1)
    return guess + moved, misfit / size
