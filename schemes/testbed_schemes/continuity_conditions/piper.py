"""Tangent plane continuity of two quartic triangles across a quartic boundary: Piper's sufficient conditions.

The boundary has the control points H_0..H_4, the second rows on its sides are F_0..F_3 and G_0..G_3. The patches join
G1 if there are linear functions e, f, g, h with sum zero such that (Mann 1992, section 2.2.2)

    e I + f J + g K + h L = 0,                                                                            (2.2)
    I = sum_r B^3_r H_{r+1},  J = sum_r B^3_r H_r,  K = sum_r B^3_r F_r,  L = sum_r B^3_r G_r.

The points at the ends, two of H and one of each row, are given and lie in the tangent planes there; they fix e, f, g, h
at the ends up to a factor each. The Bernstein coefficients of (2.2) in between are three equations in the five points
H_2, F_1, F_2, G_1, G_2, of which the solution nearest to a candidate is taken.

Formulas: (2.2) as printed. **Fills**: the factors are chosen so that g + h = 1 and e + f = -1, which treats both
patches and both directions of the edge alike; and of the three equations the middle one is replaced by the coefficient
of t^4 in (2.2),

    (e_1 - e_0) D^4 H + (g_1 - g_0) D^3 (F - G) = 0,    D the forward difference,

which follows from all three and with the other two implies it. Divided by its factors it stays as good as the others
near the special case in which e, f, g, h are constant and it is void, where the printed equations lose their rank: that
is the numerical trouble which the thesis reports of this scheme. If the candidate is made of cubic patches, raised to
quartics, it holds from the start.
"""

import numpy as np

from testbed.geometry.bernstein import multiply_curves
from testbed.geometry.vectors import Bool, Float, cross, dot, norm

#: e, f, g, h count as constant if they change by no more than this from end to end: what the t^4 coefficient then
#: misses is as much smaller than the points' displacements, far below the rounding of normals.
CONSTANT = 1e-10


def end_values(boundary: Float, row: Float, other: Float) -> tuple[Float, Float, Float, Float]:
    """Return e, f, g, h at both ends, (..., 2) each, with g + h = 1 and e + f = -1.

    g and h are positive where the two patches are on different sides of the boundary's tangent.

    Parameters
    ----------
    boundary
        (..., 5, 3) control points H.
    row, other
        (..., 4, 3) second rows F and G; at the ends in one plane with the boundary's tangent.

    Returns
    -------
    e, f, g, h
        NaN where the boundary has no end tangent, or F_0 = G_0, or the like at the end; of any size where F_0 - G_0 is
        parallel to the tangent but for rounding.
    """
    with np.errstate(invalid="ignore", divide="ignore"):  # no plane: NaN
        beside0, row0, other0 = _towards_next(boundary[..., :2, :], row[..., 0, :], other[..., 0, :])
        beside1, row1, other1 = _towards_next(boundary[..., :-3:-1, :], row[..., -1, :], other[..., -1, :])
    e, f = np.stack([beside0, -1.0 - beside1], axis=-1), np.stack([-1.0 - beside0, beside1], axis=-1)
    return e, f, np.stack([row0, row1], axis=-1), np.stack([other0, other1], axis=-1)


def _towards_next(tangent: Float, row: Float, other: Float) -> tuple[Float, Float, Float]:
    """Factors x, g, h, (...) each, with x v + g a + h b = 0 and g + h = 1; v, a, b from the end to its neighbours."""
    v, a, b = (point - tangent[..., 0, :] for point in (tangent[..., 1, :], row, other))
    length = norm(v)[..., None]
    v, a, b = v / length, a / length, b / length  # so that fourth powers stay within the range of floats
    across_row, across_other = cross(v, a), cross(v, b)
    plane = across_row - across_other
    square = dot(plane, plane)
    g, h = -dot(plane, across_other) / square, dot(plane, across_row) / square
    return -(g * dot(v, a) + h * dot(v, b)), g, h


def residual(boundary: Float, row: Float, other: Float) -> Float:
    """Return the Bernstein coefficients of (2.2), (..., 5, 3), with e, f, g, h from the ends: zero for Piper's joins.

    The first and last vanish if the end points are in planes. The parameters are those of :func:`end_values`.
    """
    factors = end_values(boundary, row, other)
    curves = (boundary[..., 1:, :], boundary[..., :-1, :], row, other)
    origin = boundary[..., :1, :]  # the factors sum to zero; near the origin nothing cancels
    total = np.zeros(boundary.shape)
    for factor, curve in zip(factors, curves, strict=True):
        total = total + multiply_curves(factor[..., None], curve - origin)
    return total


def nearest_join(boundary: Float, row: Float, other: Float) -> tuple[Float, Float, Float, Bool]:
    """Return the quartic boundary and second rows nearest to a candidate that fulfil Piper's conditions.

    H_2, F_1, F_2, G_1 and G_2 are moved by the least sum of squares, the others stay. Exchanging the rows, or reversing
    the edge, exchanges or reverses the result.

    Parameters
    ----------
    boundary, row, other
        The candidate, as for :func:`end_values`.

    Returns
    -------
    boundary, row, other
        (..., 5, 3) and twice (..., 4, 3); NaN where :func:`end_values` is.
    constant
        (...) where e, f, g, h are constant and only two of the three equations count.
    """
    e, f, g, h = end_values(boundary, row, other)
    change = np.stack([e[..., 1] - e[..., 0], g[..., 1] - g[..., 0]])
    size = np.hypot(*change)
    constant: Bool = np.less_equal(size, CONSTANT)
    along, across = np.where(constant, 0.0, change / np.where(constant, 1.0, size))
    missing = residual(boundary, row, other)
    highest = along[..., None] * _difference(boundary, 4) + across[..., None] * _difference(row - other, 3)
    # the coefficients 1 and 3 of (2.2) and that of t^4, whose unknowns are H2, F1, F2, G1, G2
    none = np.zeros_like(along)
    equations = np.stack(
        [
            np.stack([e[..., 0], g[..., 0], none, h[..., 0], none], axis=-1),
            np.stack([f[..., 1], none, g[..., 1], none, h[..., 1]], axis=-1),
            np.stack([2.0 * along, across, -across, -across, across], axis=-1),
        ],
        axis=-2,
    )
    values = np.stack([4.0 * missing[..., 1, :], 4.0 * missing[..., 3, :], highest], axis=-2) / -3.0
    moves = _least_norm(equations, values)
    joined = boundary.copy(), row.copy(), other.copy()
    joined[0][..., 2, :] += moves[..., 0, :]
    joined[1][..., 1:3, :] += moves[..., 1:3, :]
    joined[2][..., 1:3, :] += moves[..., 3:, :]
    return *joined, constant


def _difference(points: Float, order: int) -> Float:
    """Forward difference (..., 3) of the highest order of points (..., order + 1, 3)."""
    return np.asarray(np.diff(points, order, axis=-2)[..., 0, :])


def _least_norm(equations: Float, values: Float) -> Float:
    """Least-norm solutions (..., 5, 3) of independent equations (..., 3, 5), void ones zero, right sides (..., 3, 3).

    By orthogonal rows (Gram and Schmidt), which keeps the digits that the normal equations would square away.
    """
    orthonormal: list[tuple[Float, Float]] = []
    for place in range(equations.shape[-2]):
        row, value = equations[..., place, :], values[..., place, :]
        for earlier, known in orthonormal:
            along = dot(row, earlier)[..., None]
            row, value = row - along * earlier, value - along * known
        length = norm(row)[..., None]
        length = np.where(length == 0.0, 1.0, length)
        orthonormal.append((row / length, value / length))
    return np.asarray(sum(row[..., :, None] * value[..., None, :] for row, value in orthonormal))
