"""Bernstein-Bezier algebra of curves and triangles: bases, elevation, derivatives, products.

A net of a triangle of degree d has n = (d + 1)(d + 2) / 2 control points, multi-indices (i, j, k), the exponents of the
barycentric coordinates b0, b1, b2, ordered by decreasing i, then decreasing j: 300 210 201 120 111 102 030 021 012 003.
The place of (i, j, k) in that order does not depend on d, so raising an exponent is a fixed shift (see :func:`raised`).

Every function is a batch: control points are (..., n, dim) for triangles and (..., d + 1, dim) for curves, any leading axes
and any dimension (homogeneous coordinates and scalar factors too). The formulas are the textbook ones (Farin, Curves and
Surfaces for CAGD, chapters 5, 6 and 17). Blossoms and subdivision are in :mod:`testbed.geometry.blossoms`.
"""

import math

import numpy as np

from testbed.geometry.domain import barycentric
from testbed.geometry.vectors import Float, Int


def point_count(degree: int) -> int:
    """Control points of a triangle of the degree, (d + 1)(d + 2) / 2."""
    return (degree + 1) * (degree + 2) // 2


def triangle_degree(count: int) -> int:
    """Degree of a triangle with ``count`` control points; ValueError if no degree has that many."""
    degree = (math.isqrt(8 * count + 1) - 3) // 2
    if count < 1 or point_count(degree) != count:
        raise ValueError(f"a Bezier triangle has 1, 3, 6, 10, 15, ... control points, not {count}")
    return degree


def multi_indices(degree: int) -> Int:
    """Exponents (i, j, k) of b0, b1, b2 in the order of the control points, (n, 3)."""
    return np.array([(degree - s, s - k, k) for s in range(degree + 1) for k in range(s + 1)], dtype=np.int64)


def index_of(indices: tuple[int, int, int]) -> int:
    """Place of the control point (i, j, k) in its net, whatever the degree i + j + k."""
    _, j, k = indices
    return (j + k) * (j + k + 1) // 2 + k


def raised(degree: int) -> tuple[Int, Int, Int]:
    """Places, in the net of degree + 1, of the multi-indices of ``degree`` with i, j or k raised by one, (n,) each."""
    row = degree - multi_indices(degree)[:, 0]
    place = np.arange(len(row))
    return place, place + row + 1, place + row + 2


def casteljau_step(net: Float, b: Float) -> Float:
    """One step of the de Casteljau algorithm: net (..., n, dim) of degree d at b (..., 3) to the net of degree d - 1.

    Leading axes broadcast. With a different ``b`` at each step this evaluates the blossom.
    """
    first, second, third = raised(triangle_degree(net.shape[-2]) - 1)
    b = b[..., None, :]
    stepped: Float = (
        b[..., :1] * net[..., first, :] + b[..., 1:2] * net[..., second, :] + b[..., 2:] * net[..., third, :]
    )
    return stepped


def _triangle_bases(degree: int, b: Float, lowest: int) -> list[Float]:
    """Bernstein polynomials of the degrees ``degree``, ``degree - 1``, ... ``lowest``, (..., n) each, by the recursion."""
    bases = [np.ones((*b.shape[:-1], 1))]
    for d in range(1, degree + 1):
        higher = np.zeros((*b.shape[:-1], point_count(d)))
        for direction, places in enumerate(raised(d - 1)):
            higher[..., places] += b[..., direction, None] * bases[-1]
        bases.append(higher)
    return bases[: None if lowest <= 0 else lowest - 1 : -1]


def triangle_tables(degree: int, at: Float, order: int = 2) -> Float:
    """Bernstein polynomials and their derivatives at triangle parameters.

    Parameters
    ----------
    degree
        Degree of the triangle.
    at
        Parameters (u, v) = (b1, b2), (..., 2).
    order
        0, 1 or 2.

    Returns
    -------
    Float
        (1 | 3 | 6, ..., n): B | B_u, B_v | B_uu, B_uv, B_vv, so that a table times a net is the jet.
    """
    lower = _triangle_bases(degree, barycentric(at), degree - order)
    table = np.zeros(((1, 3, 6)[order], *lower[0].shape))
    table[0] = lower[0]
    if order >= 1 and degree >= 1:
        for row, r in ((1, 1), (2, 2)):
            table[row] = _differentiated(lower[1], degree, (r,))
    if order >= 2 and degree >= 2:
        for row, pair in ((3, (1, 1)), (4, (1, 2)), (5, (2, 2))):
            table[row] = _differentiated(lower[2], degree, pair)
    return table


def _differentiated(lower: Float, degree: int, directions: tuple[int, ...]) -> Float:
    """Derivative along b_r - b_0, for each r of ``directions``, of the polynomials of ``degree``.

    ``lower`` holds the polynomials of degree - len(directions); each derivative is a difference of those, (..., n).
    """
    values = lower * math.perm(degree, len(directions))
    for level, r in enumerate(directions, start=degree - len(directions) + 1):
        places = raised(level - 1)
        higher = np.zeros((*values.shape[:-1], point_count(level)))
        higher[..., places[r]] += values
        higher[..., places[0]] -= values
        values = higher
    return values


def curve_tables(degree: int, t: Float, order: int = 2) -> Float:
    """Bernstein polynomials of curves and their derivatives at parameters t (...), to (1 | 2 | 3, ..., degree + 1)."""
    t = np.asarray(t, dtype=np.float64)[..., None]
    bases = [np.ones(t.shape)]
    for d in range(1, degree + 1):
        higher = np.zeros((*t.shape[:-1], d + 1))
        higher[..., :-1] += (1.0 - t) * bases[-1]
        higher[..., 1:] += t * bases[-1]
        bases.append(higher)
    rows = [bases[degree]]
    for taken in range(1, order + 1):
        values = bases[degree - taken] * math.perm(degree, taken) if taken <= degree else np.zeros((*t.shape[:-1], 1))
        for level in range(max(degree - taken, 0), degree):
            higher = np.zeros((*t.shape[:-1], level + 2))
            higher[..., 1:] += values
            higher[..., :-1] -= values
            values = higher
        rows.append(values)
    return np.stack(rows)


def tensor_tables(degrees: tuple[int, int], at: Float, order: int = 2) -> Float:
    """Tensor-product Bernstein polynomials at (u, v) (..., 2), to (1 | 3 | 6, ..., m + 1, n + 1) as in a jet."""
    along_u = curve_tables(degrees[0], at[..., 0], order)
    along_v = curve_tables(degrees[1], at[..., 1], order)
    pairs = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))[: (1, 3, 6)[order]]
    return np.stack([along_u[r][..., :, None] * along_v[s][..., None, :] for r, s in pairs])


def elevate_curve(control_points: Float, steps: int = 1) -> Float:
    """Control points (..., d + 1, dim) of the same curve written with degree d + steps.

    Symmetric in the direction of the curve to the last bit: elevating the reversed curve gives the reversed points.
    """
    for _ in range(steps):
        raised_degree = control_points.shape[-2]
        i = np.arange(1, raised_degree)[:, None]
        inner = (i * control_points[..., :-1, :] + (raised_degree - i) * control_points[..., 1:, :]) / raised_degree
        control_points = np.concatenate([control_points[..., :1, :], inner, control_points[..., -1:, :]], axis=-2)
    return control_points


def elevate_triangle(net: Float, steps: int = 1) -> Float:
    """Net (..., n, dim) of the same patch written with degree d + steps."""
    for _ in range(steps):
        degree = triangle_degree(net.shape[-2])
        exponents = multi_indices(degree) + 1
        total = np.zeros((*net.shape[:-2], point_count(degree + 1), net.shape[-1]))
        for direction, places in enumerate(raised(degree)):
            total[..., places, :] += exponents[:, direction, None] * net
        net = total / (degree + 1)
    return net


def elevate_tensor(net: Float, steps: tuple[int, int] = (1, 1)) -> Float:
    """Net (..., m + 1, n + 1, dim) of the same tensor-product patch with degrees (m, n) + steps."""
    along_v = elevate_curve(net, steps[1])
    return elevate_curve(along_v.swapaxes(-3, -2), steps[0]).swapaxes(-3, -2)


def derivative_curve(control_points: Float) -> Float:
    """Control points (..., d, dim) of the derivative of a curve of degree d >= 1."""
    return (control_points.shape[-2] - 1) * np.diff(control_points, axis=-2)


def derivative_triangle(net: Float, direction: Float) -> Float:
    """Net of the derivative of a triangle of degree d >= 1 along a barycentric direction (..., 3) whose sum is zero.

    (-1, 1, 0) is d/du and (-1, 0, 1) is d/dv. Leading axes broadcast; the result has degree d - 1.
    """
    return triangle_degree(net.shape[-2]) * casteljau_step(net, direction)


def multiply_curves(a: Float, b: Float) -> Float:
    """Control points of the product of two curves of degrees m and n, written with degree m + n.

    (..., m + 1, dim) and (..., n + 1, dim); components multiply one by one, a dimension of 1 being a scalar factor.
    """
    m, n = a.shape[-2] - 1, b.shape[-2] - 1
    shape = np.broadcast_shapes(a[..., 0, :].shape, b[..., 0, :].shape)
    product = np.zeros((*shape[:-1], m + n + 1, shape[-1]))
    weight = np.array([math.comb(n, j) for j in range(n + 1)], dtype=np.float64)[:, None]
    for i in range(m + 1):
        product[..., i : i + n + 1, :] += math.comb(m, i) * a[..., i : i + 1, :] * (weight * b)
    return product / np.array([math.comb(m + n, k) for k in range(m + n + 1)], dtype=np.float64)[:, None]


def multiply_triangles(a: Float, b: Float) -> Float:
    """Net of the product of two triangles of degrees m and n, written with degree m + n.

    (..., n_m, dim) and (..., n_n, dim); components multiply one by one, a dimension of 1 being a scalar factor.
    """
    m, n = triangle_degree(a.shape[-2]), triangle_degree(b.shape[-2])
    shape = np.broadcast_shapes(a[..., 0, :].shape, b[..., 0, :].shape)
    product = np.zeros((*shape[:-1], point_count(m + n), shape[-1]))
    weighted = _multinomials(n) * b
    factors = _multinomials(m) * a
    for i, exponents in enumerate(multi_indices(m)):
        both = exponents + multi_indices(n)
        places = (both[:, 1] + both[:, 2]) * (both[:, 1] + both[:, 2] + 1) // 2 + both[:, 2]
        product[..., places, :] += factors[..., i : i + 1, :] * weighted
    return product / _multinomials(m + n)


def _multinomials(degree: int) -> Float:
    """d! / (i! j! k!) in the order of the control points, (n, 1)."""
    return np.array(
        [math.comb(degree, i) * math.comb(degree - i, j) for i, j, _ in multi_indices(degree).tolist()],
        dtype=np.float64,
    )[:, None]
