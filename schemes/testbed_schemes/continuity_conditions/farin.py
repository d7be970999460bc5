"""Tangent plane continuity of two Bezier triangles of any degree: Farin's sufficient conditions.

Two triangles of degree n share a boundary of degree n - 1 with control points H_0..H_{n-1}; F_0..F_{n-1} and
G_0..G_{n-1} are their second rows. They join G1 if one number alpha serves the whole edge (Mann 1992, section 2.2.1):

    G_0     = alpha_1 H_0 + alpha_2 H_1 + alpha F_0,                  alpha_1 + alpha_2 + alpha = 1
    G_{n-1} = alpha_3 H_{n-2} + alpha_4 H_{n-1} + alpha F_{n-1},      alpha_3 + alpha_4 + alpha = 1        (2.1)
    G_i     = (1 - s) (alpha_1 H_i + alpha_2 H_{i+1}) + s (alpha_3 H_{i-1} + alpha_4 H_i) + alpha F_i,  s = i / (n - 1)

that is, G(t) - H(t) = alpha (F(t) - H(t)) + a linear function times H'(t). alpha is minus the ratio of the areas of the
end triangles H_0 H_1 G_0 and H_0 H_1 F_0, and the same at the other end. With alpha_1 = alpha_4 the linear function is
constant and the join is C1.

Formulas: as printed. H_n and H_{-1}, which the indices reach with the factor zero, do not exist and are left out.
"""

import numpy as np

from testbed.geometry.vectors import Float, dot


def end_weights(boundary: Float, row: Float, other: Float) -> tuple[Float, Float]:
    """Return (alpha_1, alpha_2, alpha) and (alpha_3, alpha_4, alpha), (..., 3) each, nearest to fulfilling (2.1).

    alpha is the mean of what the two ends ask for, each in least squares; alpha_2 and alpha_3 follow.

    Parameters
    ----------
    boundary
        (..., n, d) control points H.
    row, other
        (..., n, d) second rows F and G.

    Returns
    -------
    start, end
        NaN where H_0, H_1, F_0 are on a line, or the like at the end.
    """
    ends = []
    for here, beside in ((0, 1), (-1, -2)):
        corner = boundary[..., here, :]
        v, f, g = boundary[..., beside, :] - corner, row[..., here, :] - corner, other[..., here, :] - corner
        with np.errstate(invalid="ignore", divide="ignore"):  # on a line: NaN
            f_along, g_along = dot(f, v) / dot(v, v), dot(g, v) / dot(v, v)
            f_across = f - f_along[..., None] * v
            ends.append((f_along, g_along, dot(g, f_across) / dot(f_across, f_across)))
    alpha = (ends[0][2] + ends[1][2]) / 2.0
    towards = [g_along - alpha * f_along for f_along, g_along, _ in ends]
    start = np.stack([1.0 - towards[0] - alpha, towards[0], alpha], axis=-1)
    end = np.stack([towards[1], 1.0 - towards[1] - alpha, alpha], axis=-1)
    return start, end


def matching_row(boundary: Float, row: Float, start: Float, end: Float) -> Float:
    """Return the row G that makes the join with a patch of row F tangent plane continuous, (..., n, d).

    Parameters
    ----------
    boundary, row
        (..., n, d) H and F, n >= 2.
    start, end
        (alpha_1, alpha_2, alpha) and (alpha_3, alpha_4, alpha), (..., 3) each, with the same alpha.

    Raises
    ------
    ValueError
        The two alphas differ anywhere; the join would not be tangent plane continuous.
    """
    if not np.array_equal(start[..., 2], end[..., 2], equal_nan=True):
        raise ValueError("alpha at the start of an edge differs from alpha at its end: give one for both")
    a1, a2, alpha = (start[..., None, None, i] for i in range(3))
    a3, a4 = (end[..., None, None, i] for i in range(2))
    count = boundary.shape[-2]
    s = np.arange(count)[:, None] / (count - 1)
    other = alpha * row + ((1.0 - s) * a1 + s * a4) * boundary
    other[..., :-1, :] += (1.0 - s[:-1]) * a2 * boundary[..., 1:, :]
    other[..., 1:, :] += s[1:] * a3 * boundary[..., :-1, :]
    return np.asarray(other)


def residual(boundary: Float, row: Float, other: Float) -> Float:
    """Return by how much the row G misses Farin's conditions with the weights of :func:`end_weights`, (..., n, d).

    Zero, up to rounding, if and only if the conditions hold for some weights. Then the patches join G1; the converse is
    not true, the conditions are sufficient only.
    """
    return np.asarray(other - matching_row(boundary, row, *end_weights(boundary, row, other)))
