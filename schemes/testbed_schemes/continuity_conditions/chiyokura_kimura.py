"""Tangent plane continuity across a cubic boundary: the Chiyokura-Kimura condition with Jensen's shape parameter C.

A quartic triangle has the cubic boundary H0..H3. Its second row of control points is F0..F3, and G0..G3 is the row of
the patch on the other side. Both are chosen so that the cross-boundary derivatives lie in one field of tangent planes,
which depends on the boundary and the end normals alone (Mann 1992, section 2.2.3, equations 2.3 to 2.7):

    sum_r B^3_r(t) (F_r - H_r) = k(t) C(t) + h(t) sum_r B^2_r(t) (H_{r+1} - H_r),    C(t) = (1 - t) C0 + t C1,

with C0 and C1 unit vectors perpendicular to the end normals and end tangents, h linear, and k linear (Chiyokura and
Kimura) or quadratic (Jensen: k(1/2) = C (k(0) + k(1)) / 2). No patch reads the other's data: the join is G1 for every C
and whatever stands across the edge.

Formulas: as printed, but for the left side of (2.3), which is only proportional to that of (2.4): the radial derivative
of the quartic points outwards and carries the factor -4. The sign of C0 and C1 is that of normal x tangent on both
sides of the edge, where the source turns it so that k > 0; the field of planes is the same.
"""

import numpy as np

from testbed.errors import Refused
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, unit
from testbed.plugins.corners import check_sides
from testbed.plugins.scheme import Scheme
from testbed_schemes.planar_frame import PARALLEL, edge_normals


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
    v0, v1, v2 = (curve[..., r + 1, :] - curve[..., r, :] for r in range(3))
    c0, c1 = conormal(start_normal, v0), conormal(end_normal, v2)
    k0, k1 = dot(start_leg, c0)[..., None], dot(end_leg, c1)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):  # no tangent: NaN, as in the conormal
        h0, h1 = (dot(start_leg, v0) / dot(v0, v0))[..., None], (dot(end_leg, v2) / dot(v2, v2))[..., None]
    middle = (2.0 * jensen_c - 1.0) * (k0 + k1)
    # the same order of terms in both, as seen from the nearer end, so that reversal is exact
    first = curve[..., 1, :] + (middle * c0 + k0 * c1 + 2.0 * h0 * v1 + h1 * v0) / 3.0
    second = curve[..., 2, :] + (middle * c1 + k1 * c0 + 2.0 * h1 * v1 + h0 * v2) / 3.0
    return first, second
