"""One quartic a face whose inner control points are blended rationally: Gregory's idea on triangles.

The Chiyokura-Kimura condition asks for two control points of the second row along each edge, hence for two inner points
at each corner i: I_ij from the edge opposite j, on which b_j = 0, and I_ik from the edge opposite k. A quartic has one
place for them, which gets a mean of both that depends on the parameters and is I_ij alone on b_j = 0, to first order.
The patches then have the tangent planes asked for along all edges. Schemes differ in the shares of the mean.

Near corner i every such mean with shares that tend to b_k : b_j depends on the direction only: point and tangent plane
have limits, second derivatives have one in each direction, and these limits differ unless I_ij = I_ik.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from testbed.geometry.bernstein import elevate_curve, triangle_tables
from testbed.geometry.blocks import in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.domain import CORNERS
from testbed.geometry.nets import side_indices
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import Basis, TabulatedTriangles
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.split_domain import J, K, corner_neighbours

#: How near to a corner second derivatives are good: they lose 1e-16 / distance to rounding.
CORNER_MARGIN = 1e-6

#: ``row(curve, start_leg, end_leg, start_normal, end_normal)``: second row of a quartic along a cubic edge.
SecondRow: TypeAlias = Callable[[Float, Float, Float, Float, Float], tuple[Float, Float]]
#: ``shares(bi, bj, bk)``: shares of I_ij and I_ik in the inner point of corner i, up to a common factor.
Shares: TypeAlias = Callable[[Any, Any, Any], tuple[Any, Any]]


def blended_surface(network: CurveNetwork, basis: Basis, second_row: SecondRow) -> Surface:
    """Build one patch a face.

    Parameters
    ----------
    network
        Cubic curves on the edges of a mesh of triangles with normals.
    basis
        The functions of the 18 control points, see :func:`blended_basis`.
    second_row
        From edges (..., 4, 3), with the quartic's first legs across and the unit normals at both ends, (..., 3) each,
        to the two points of the second row between.
    """
    curves, normals = network.opposite_vertices(), network.mesh.corner_normals()

    def points(faces: slice) -> Float:
        return control_points(curves[faces], normals[faces], second_row)

    patches = TabulatedTriangles(basis, in_blocks(points, len(curves)), corner_table(), CORNER_MARGIN)
    return Surface.over_faces(network.mesh, patches, network.notes)


def control_points(curves: Float, normals: Float, second_row: SecondRow) -> Float:
    """Return 12 boundary points in order, side by side from corner 0, and I_ij, I_ik by corner i, (F, 18, 3).

    Parameters
    ----------
    curves
        (F, 3, 4, 3) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    normals
        (F, 3, 3) unit normals by corner.
    second_row
        As for :func:`blended_surface`.
    """
    boundary, corner = elevate_curve(curves), curves[:, K, 0]
    # along edge i, the second row starts on the edge from V_j to V_i and ends on that from V_k to V_i
    towards_next, towards_previous = (point - corner for point in corner_neighbours(boundary))
    near_start, near_end = second_row(curves, towards_previous[:, J], towards_next[:, K], normals[:, J], normals[:, K])
    points = np.empty((len(curves), 18, 3))
    points[:, :12] = boundary[:, K, :4].reshape(-1, 12, 3)
    points[:, 12::2], points[:, 13::2] = near_end[:, J], near_start[:, K]
    return points


def blended_basis(b0: Any, b1: Any, b2: Any, shares: Shares) -> list[Any]:
    """Return the functions of the 18 control points: 12 quartic Bernstein polynomials and 6 blends of three others.

    I_ij and I_ik divide the polynomial 12 b_i^2 b_j b_k between them.

    Parameters
    ----------
    b0, b1, b2
        Barycentric coordinates, arrays or Taylors of one shape.
    shares
        How they divide it. On b_j = 0 that of I_ik has to vanish and that of I_ij not, on b_k = 0 the other way round.
    """
    # all three corners, and all three sides from corner i to corner j, at once
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    square_i, square_j = bi * bi, bj * bj
    sides = square_i * square_i, 4 * square_i * bi * bj, 6 * square_i * square_j, 4 * bi * square_j * bj
    share_j, share_k = shares(bi, bj, bk)
    polynomials = 12 * square_i * bj * bk / (share_j + share_k)
    inner = polynomials * share_j, polynomials * share_k
    return [function[..., i] for functions in (sides, inner) for i in range(3) for function in functions]


def gregory_basis(b0: Any, b1: Any, b2: Any) -> list[Any]:
    """Return :func:`blended_basis` with the shares b_k : b_j, as in Gregory's square and in Walton and Meek's patch."""
    return blended_basis(b0, b1, b2, lambda _, bj, bk: (bk, bj))


def corner_table() -> Float:
    """Return values and first derivatives of the functions at the corners, (3, 3, 18); those of the blends vanish."""
    polynomials = triangle_tables(4, CORNERS[3], order=1)[..., side_indices(4)[:, :4].ravel()]
    return np.concatenate([polynomials, np.zeros((3, 3, 6))], axis=-1)
