"""Tangent plane continuity across a cubic boundary: the Chiyokura-Kimura condition and its variants.

A quartic triangle has the cubic boundary H0..H3. Its second row of control points is F0..F3, and G0..G3 is the row of
the patch on the other side. Both are chosen so that the cross-boundary derivatives lie in one field of tangent planes,
which depends on the boundary and the end normals alone (Mann 1992, section 2.2.3, equations 2.3 to 2.7):

    sum_r B^3_r(t) (F_r - H_r) = k(t) C(t) + h(t) sum_r B^2_r(t) (H_{r+1} - H_r),    C(t) = (1 - t) C0 + t C1,

with C0 and C1 unit vectors perpendicular to the end normals and end tangents, and h linear. No patch reads the other's
data: the join is G1 whatever stands across the edge. The product k C is a cubic, so that one of its factors is free:

    Chiyokura and Kimura   k and C linear
    Jensen                 k quadratic, k(1/2) = C (k(0) + k(1)) / 2 with his scalar C
    Walton and Meek        C quadratic, with the unit vector along C0 + C1 in the middle

Herron has the field of Chiyokura and Kimura in another reading, see :func:`perpendicular_derivative`.

Formulas: as printed, but for the left side of (2.3), which is only proportional to that of (2.4): the radial derivative
of the quartic points outwards and carries the factor -4. The sign of C0 and C1 is that of normal x tangent on both
sides of the edge, where the source turns it so that k > 0; the field of planes is the same.
"""

from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, unit
from testbed.plugins.corners import check_sides
from testbed.plugins.scheme import Scheme
from testbed_schemes.mathematics.planar_frame import PARALLEL, edge_normals


def check_fields(scheme: Scheme, network: CurveNetwork) -> None:
    """Refuse curves along which the cross-boundary fields would turn a patch over or vanish half-way.

    Raises
    ------
    Refused
        Normals stand on different sides of a face, or C0 and C1 are opposite; the message names the vertices.
    """
    mesh, (start, end) = network.mesh, network.end_legs
    check_sides(scheme, mesh, start, end)
    normal0, normal1 = edge_normals(mesh.edge_data)
    vanishes: Bool = np.less_equal(norm(conormal(normal0, start) + conormal(normal1, -end)), PARALLEL)
    if vanishes.any():
        i, j = mesh.edges[vanishes][0].tolist()
        raise Refused(
            f"{scheme} has no tangent plane half-way on {int(vanishes.sum())} of {len(mesh.edges)} edges, the first "
            f"from vertex {i} to vertex {j}: as seen along the edge its normals are opposite, turn one or move a vertex"
        )


def conormal(normal: Float, tangent: Float) -> Float:
    """Return the unit vectors along normal x tangent, in the tangent plane, (..., 3); NaN where the tangent is zero."""
    return unit(cross(normal, tangent))


@dataclass(frozen=True, slots=True)
class FieldEnds:
    """Cross-boundary vectors at both ends of edges, in the conormals and the edges' first legs: k_i C_i + h_i v_i.

    Attributes
    ----------
    c0, c1
        Conormals C0 and C1, (..., 3).
    k0, k1
        Components along them, (..., 1).
    h0, h1
        Components along the legs H1 - H0 and H3 - H2, in units of these, (..., 1).
    """

    c0: Float
    c1: Float
    k0: Float
    k1: Float
    h0: Float
    h1: Float


def field_ends(curve: Float, start: Float, end: Float, start_normal: Float, end_normal: Float) -> FieldEnds:
    """Return the components of cross-boundary vectors at both ends, (2.4) and (2.5).

    Parameters
    ----------
    curve
        (..., 4, 3) control points H of the boundary.
    start, end
        (..., 3) the vectors, in the tangent planes at the ends, in any one scale; k and h have the same.
    start_normal, end_normal
        (..., 3) unit normals at the ends.
    """
    v0, v2 = curve[..., 1, :] - curve[..., 0, :], curve[..., 3, :] - curve[..., 2, :]
    c0, c1 = conormal(start_normal, v0), conormal(end_normal, v2)
    with np.errstate(invalid="ignore", divide="ignore"):  # no tangent: NaN, as in the conormal
        h0, h1 = dot(start, v0) / dot(v0, v0), dot(end, v2) / dot(v2, v2)
    return FieldEnds(c0, c1, dot(start, c0)[..., None], dot(end, c1)[..., None], h0[..., None], h1[..., None])


def cross_boundary_points(
    curve: Float,
    start_leg: Float,
    end_leg: Float,
    start_normal: Float,
    end_normal: Float,
    jensen_c: float = 1.0,
) -> tuple[Float, Float]:
    """Return the inner points F1 and F2 of a quartic patch's second row along a cubic boundary, (2.6) and (2.7).

    Reversing the edge, with ends and legs swapped, swaps the two points bit for bit.

    Parameters
    ----------
    curve
        (..., 4, 3) control points H of the boundary.
    start_leg, end_leg
        (..., 3) F0 - H0 and F3 - H3, in the tangent planes at the ends.
    start_normal, end_normal
        (..., 3) unit normals at the ends.
    jensen_c
        Jensen's C; 1 is Chiyokura and Kimura's linear k. The factor of k0 + k1 is 2 C - 1 (Mann 1994 calls that c_i).
        From C = 1/2 on, k keeps the sign of its end values; below, k may vanish on the edge, and the patch fold there.

    Returns
    -------
    F1, F2
        (..., 3) each; NaN where an end tangent of the boundary is zero.
    """
    ends = field_ends(curve, start_leg, end_leg, start_normal, end_normal)
    return _second_row(curve, ends, *_linear_field(ends, jensen_c))


def quadratic_field_points(
    curve: Float, start_leg: Float, end_leg: Float, start_normal: Float, end_normal: Float
) -> tuple[Float, Float]:
    """Return F1 and F2 as :func:`cross_boundary_points` does, by Walton and Meek's field.

    C(t) = (1 - t)^2 C0 + 2 t (1 - t) unit(C0 + C1) + t^2 C1 and k is linear; where C0 = C1 the points are the same.
    NaN also where C0 = -C1. The published form measures from the middles of the raised boundary's legs, which adds
    3/8 (2 t - 1) to h and changes no point.
    """
    ends = field_ends(curve, start_leg, end_leg, start_normal, end_normal)
    middle = unit(ends.c0 + ends.c1)
    return _second_row(
        curve, ends, 2.0 * ends.k0 * middle + ends.k1 * ends.c0, 2.0 * ends.k1 * middle + ends.k0 * ends.c1
    )


def perpendicular_derivative(
    curve: Float,
    start_tangent: Float,
    end_tangent: Float,
    start_normal: Float,
    end_normal: Float,
    jensen_c: float = 1.0,
) -> tuple[Float, Float]:
    """Return Herron's R(t) = k(t) C(t) and the directions in which it is the patch's derivative (appendix A).

    With V_i opposite the boundary, from V_j to V_k, the direction at t is 1 in b_i, h(t) - (1 - t) in b_j and -h(t) - t
    in b_k: inwards, and so that the derivative is perpendicular to the boundary at both ends. A patch with this
    derivative has the second row of :func:`cross_boundary_points`.

    Parameters
    ----------
    curve, start_normal, end_normal, jensen_c
        As for :func:`cross_boundary_points`.
    start_tangent, end_tangent
        (..., 3) derivatives at V_j and V_k along the curves to V_i: four times a quartic's legs.

    Returns
    -------
    derivative
        (..., 4, 3) Bezier coefficients of R.
    along
        (..., 2) h(0) and h(1); h is linear.
    """
    ends = field_ends(curve, start_tangent, end_tangent, start_normal, end_normal)
    first, second = _linear_field(ends, jensen_c)
    field = np.stack([ends.k0 * ends.c0, first / 3.0, second / 3.0, ends.k1 * ends.c1], axis=-2)
    return field, np.concatenate([ends.h0, ends.h1], axis=-1) / 3.0  # the derivative of the curve is three legs


def _linear_field(ends: FieldEnds, jensen_c: float) -> tuple[Float, Float]:
    """Three times the inner Bezier coefficients of k C, C linear and k linear or Jensen's quadratic, (..., 3) each."""
    middle = (2.0 * jensen_c - 1.0) * (ends.k0 + ends.k1)
    return middle * ends.c0 + ends.k0 * ends.c1, middle * ends.c1 + ends.k1 * ends.c0


def _second_row(curve: Float, ends: FieldEnds, first: Float, second: Float) -> tuple[Float, Float]:
    """F1 and F2 from three times the inner coefficients of k C."""
    v0, v1, v2 = (curve[..., r + 1, :] - curve[..., r, :] for r in range(3))
    # the same order of terms in both, as seen from the nearer end, so that reversal is exact
    return (
        curve[..., 1, :] + (first + 2.0 * ends.h0 * v1 + ends.h1 * v0) / 3.0,
        curve[..., 2, :] + (second + 2.0 * ends.h1 * v1 + ends.h0 * v2) / 3.0,
    )
