"""Barycentric coordinates of convex polygons, rational functions of the point, and their derivatives.

With alpha_i the double signed area of the triangle p, p_i, p_{i+1} and w_i that of p_{i-1}, p_i, p_{i+1},

    pi_i = w_i * product of alpha_j over j not in {i - 1, i},     l_i = pi_i / (pi_0 + ... + pi_{n-1}).

They are not negative in the polygon, sum to one, reproduce linear functions (sum l_i p_i = p), and on the side from p_i
to p_{i+1} only l_i and l_{i+1} are not zero, and linear. The denominator vanishes nowhere in the closed polygon, so
derivatives exist at corners too. On a triangle they are its barycentric coordinates, on a parallelogram bilinear.

Source: Loop and DeRose 1989, for regular polygons, where the weights w_i cancel; Wachspress's weights for the others
(the areas that the text of Mann 1992, appendix B, divides the alpha_i by are not those, and do for regular ones only).
"""

from functools import cache

import numpy as np

from testbed.geometry.jets import ROWS
from testbed.geometry.vectors import Float


@cache
def regular_polygon(sides: int) -> Float:
    """Corners (cos 2 pi k / n, sin 2 pi k / n), k = 0 .. n - 1, (n, 2), counterclockwise, read-only."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    corners.flags.writeable = False
    return corners


def corner_areas(corners: Float) -> Float:
    """Double signed areas of the triangles p_{i-1}, p_i, p_{i+1} of polygons (n, 2), (n,): all positive if convex."""
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    areas: Float = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return areas


def polygon_coordinates(corners: Float, at: Float, order: int = 2) -> Float:
    """Barycentric coordinates of points in a convex polygon, and their derivatives.

    Parameters
    ----------
    corners
        (n, 2), counterclockwise.
    at
        Points (..., 2).
    order
        0, 1 or 2.

    Returns
    -------
    Float
        (1 | 3 | 6, n, ...): l | l_x, l_y | l_xx, l_xy, l_yy.
    """
    following = np.roll(corners, -1, axis=0)
    x, y = at[..., 0], at[..., 1]
    # per side (n, 1 ...): alpha is linear, from the side's start so that it is small near the side
    column = (slice(None), *(None,) * x.ndim)
    along_x, along_y = (corners[:, 1] - following[:, 1])[column], (following[:, 0] - corners[:, 0])[column]
    alpha = (x - corners[:, 0][column]) * along_x + (y - corners[:, 1][column]) * along_y
    sides = len(corners)
    products = np.zeros((ROWS[order], sides, *x.shape))
    products[0] = corner_areas(corners)[column]
    for step in range(1, sides - 1):
        side = (np.arange(sides) + step) % sides
        _times_linear(products, alpha[side], along_x[side], along_y[side])
    total = products.sum(axis=1)
    return _divided(products, total)


def _times_linear(f: Float, a: Float, a_x: Float, a_y: Float) -> None:
    """Multiply jets f (rows, ...) with a linear function of value a and slopes a_x, a_y, in place."""
    if len(f) == 6:
        f[3] = f[3] * a + 2.0 * f[1] * a_x
        f[4] = f[4] * a + (f[1] * a_y + f[2] * a_x)
        f[5] = f[5] * a + 2.0 * f[2] * a_y
    if len(f) >= 3:
        f[1] = f[1] * a + f[0] * a_x
        f[2] = f[2] * a + f[0] * a_y
    f[0] *= a


def _divided(f: Float, w: Float) -> Float:
    """Jets of f / w by the quotient rule, f (rows, n, ...) and w (rows, ...)."""
    result = np.empty_like(f)
    result[0] = f[0] / w[0]
    for z in (1, 2) if len(f) >= 3 else ():
        result[z] = (f[z] - result[0] * w[z]) / w[0]
    if len(f) == 6:
        for row, (z, s) in zip((3, 4, 5), ((1, 1), (1, 2), (2, 2)), strict=True):
            result[row] = (f[row] - w[z] * result[s] - w[s] * result[z] - w[row] * result[0]) / w[0]
    return result
