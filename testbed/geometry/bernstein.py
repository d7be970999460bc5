"""Bernstein-Bezier algebra of curves and triangles: bases, blossoms, elevation, subdivision, derivatives, products.

A net of a triangle of degree d has n = (d + 1)(d + 2) / 2 control points, multi-indices (i, j, k), the exponents of the
barycentric coordinates b0, b1, b2, ordered by decreasing i, then decreasing j: 300 210 201 120 111 102 030 021 012 003.
The place of (i, j, k) in that order does not depend on d, so raising an exponent is a fixed shift (see :func:`raised`).

Every function is a batch: control points are (..., n, dim) for triangles and (..., d + 1, dim) for curves, with any
leading axes and any dimension (homogeneous coordinates and scalar factors too). The formulas are the textbook ones
(Farin, Curves and Surfaces for CAGD, the chapters on Bezier curves, blossoms and Bezier triangles).
"""

import math
from functools import cache

import numpy as np

from testbed.geometry.domain import barycentric
from testbed.geometry.vectors import Float, Int


def point_count(degree: int) -> int:
    """Control points of a triangle of the degree, (d + 1)(d + 2) / 2."""
    return (degree + 1) * (degree + 2) // 2


def triangle_degree(count: int) -> int:
    """Degree of a triangle with ``count`` control points; ValueError if no degree has that many."""
    degree = (math.isqrt(8 * max(count, 0) + 1) - 3) // 2
    if count < 1 or point_count(degree) != count:
        raise ValueError(f"a Bezier triangle has 1, 3, 6, 10, 15, ... control points, not {count}")
    return degree


@cache
def multi_indices(degree: int) -> Int:
    """Exponents (i, j, k) of b0, b1, b2 in the order of the control points, (n, 3), read-only."""
    indices = np.array([(degree - s, s - k, k) for s in range(degree + 1) for k in range(s + 1)], dtype=np.int64)
    indices.flags.writeable = False
    return indices


@cache
def _multinomials(degree: int) -> Float:
    """Multinomial coefficients d! / (i! j! k!) in the order of the control points, (n, 1), read-only."""
    coefficients = [math.comb(degree, i) * math.comb(degree - i, j) for i, j, _ in multi_indices(degree).tolist()]
    column = np.array(coefficients, dtype=np.float64)[:, None]
    column.flags.writeable = False
    return column


def index_of(indices: tuple[int, int, int]) -> int:
    """Place of the control point (i, j, k) in its net, whatever the degree i + j + k."""
    _, j, k = indices
    return (j + k) * (j + k + 1) // 2 + k


@cache
def raised(degree: int) -> tuple[slice, Int, Int]:
    """Places, in the net of degree + 1, of the multi-indices of ``degree`` with i, j or k raised by one.

    The first n; and two arrays (n,), read-only.
    """
    row = degree - multi_indices(degree)[:, 0]
    place = np.arange(len(row))
    second, third = place + row + 1, place + row + 2
    second.flags.writeable = third.flags.writeable = False
    return slice(len(row)), second, third


def casteljau_step(net: Float, b: Float) -> Float:
    """One step of the de Casteljau algorithm: net (..., n, dim) of degree d at b (..., 3) to the net of degree d - 1.

    Leading axes broadcast. With a different ``b`` at each step this evaluates the blossom.
    """
    first, second, third = raised(triangle_degree(net.shape[-2]) - 1)
    b0, b1, b2 = (b[..., None, r, None] for r in range(3))
    stepped: Float = b0 * net[..., first, :] + b1 * net[..., second, :] + b2 * net[..., third, :]
    return stepped


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
    b = np.ascontiguousarray(np.moveaxis(barycentric(at), -1, 0))
    # powers[q, e, r]: q-th derivative of the e-th power of b_r
    powers = np.zeros((order + 1, degree + 1, *b.shape))
    powers[0, 0] = 1.0
    exponents = np.arange(1, degree + 1, dtype=np.float64).reshape(-1, *(1,) * b.ndim)
    for e in range(1, degree + 1):
        np.multiply(powers[0, e - 1], b, out=powers[0, e])
    for q in range(1, order + 1):
        np.multiply(powers[q - 1, :-1], exponents, out=powers[q, 1:])
    x, y, z = (powers[:, :, r].take(multi_indices(degree)[:, r], axis=1) for r in range(3))
    x *= _multinomials(degree).reshape(-1, *(1,) * (b.ndim - 1))
    table = np.empty(((1, 3, 6)[order], *x.shape[1:]))
    xy = x[0] * y[0]
    table[0] = xy * z[0]
    if order >= 1:
        # product rule; along u b1 grows and b0 shrinks, along v b2 grows and b0 shrinks
        xy_u = x[0] * y[1] - x[1] * y[0]
        table[1] = xy_u * z[0]
        table[2] = xy * z[1] - x[1] * y[0] * z[0]
    if order == 2:
        xy_w = x[2] * y[0] - x[1] * y[1]
        table[3] = (xy_w - x[1] * y[1] + x[0] * y[2]) * z[0]
        table[4] = xy_w * z[0] + xy_u * z[1]
        table[5] = x[2] * y[0] * z[0] - 2.0 * (x[1] * y[0] * z[1]) + xy * z[2]
    return np.moveaxis(table, 1, -1)


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


def evaluate_curve(control_points: Float, t: Float, order: int = 0) -> Float:
    """Points and derivatives of curves at parameters.

    Parameters
    ----------
    control_points
        (..., d + 1, dim).
    t
        (S,) for all curves, or (..., S).
    order
        0, 1 or 2.

    Returns
    -------
    Float
        (1 | 2 | 3, ..., S, dim).
    """
    degree = control_points.shape[-2] - 1
    t = np.broadcast_to(t, np.broadcast_shapes(t.shape, (*control_points.shape[:-2], 1)))
    table = curve_tables(degree, t, order)
    points: Float = table[..., 0, None] * control_points[..., 0, None, :]
    for i in range(1, degree + 1):
        points += table[..., i, None] * control_points[..., i, None, :]
    return points


def blossom_curve(control_points: Float, arguments: Float) -> Float:
    """Blossom of curves (..., d + 1, dim) at d parameters each, (..., d), to (..., dim); leading axes broadcast."""
    for step in range(control_points.shape[-2] - 1):
        t = arguments[..., step, None, None]
        control_points = (1.0 - t) * control_points[..., :-1, :] + t * control_points[..., 1:, :]
    point: Float = control_points[..., 0, :]
    return point


def blossom_triangle(net: Float, arguments: Float) -> Float:
    """Blossom of triangles: the symmetric multi-affine form whose diagonal is the patch.

    Parameters
    ----------
    net
        (..., n, dim), degree d.
    arguments
        (..., d, 3): d barycentric points, or directions (sum zero). Leading axes broadcast with the net's.

    Returns
    -------
    Float
        (..., dim). With all arguments equal, the point of the patch there (the de Casteljau algorithm).
    """
    for step in range(triangle_degree(net.shape[-2])):
        net = casteljau_step(net, arguments[..., step, :])
    point: Float = net[..., 0, :]
    return point


def reparametrise_triangle(net: Float, corners: Float) -> Float:
    """Net of the same polynomials over another triangle of the parameter plane.

    Parameters
    ----------
    net
        (..., n, dim).
    corners
        (..., 3, 3) barycentric coordinates of the new corners; leading axes broadcast.

    Returns
    -------
    Float
        (..., n, dim): control point (i, j, k) is the blossom at i times corner 0, j times corner 1, k times corner 2.
    """
    exponents = multi_indices(triangle_degree(net.shape[-2]))
    labels = np.stack([np.repeat(np.arange(3), row) for row in exponents])
    return blossom_triangle(net[..., None, :, :], corners[..., labels, :])


def subdivide_triangle(net: Float, at: Float | None = None) -> Float:
    """Split triangles (..., n, dim) at an inner point into three, (..., 3, n, dim).

    Piece i has the corners i + 1, i + 2 and the point ``at`` (..., 3), barycentric, the centroid by default. The sides
    of the whole are kept to the last bit, and pieces share the points of their common sides to the last bit.
    """
    point = np.full(3, 1.0 / 3.0) if at is None else np.asarray(at, dtype=np.float64)
    kept = np.stack([np.roll(np.eye(3), -(i + 1), axis=0)[:2] for i in range(3)])
    new = np.broadcast_to(point[..., None, None, :], (*point.shape[:-1], 3, 1, 3))
    corners = np.concatenate([np.broadcast_to(kept, (*point.shape[:-1], 3, 2, 3)), new], axis=-2)
    return reparametrise_triangle(net[..., None, :, :], corners)


def quarter_triangle(net: Float) -> Float:
    """Split triangles (..., n, dim) at the midpoints of their sides into four, (..., 4, n, dim).

    Piece i < 3 keeps corner i as its corner i; piece 3 is the middle one, its corner i opposite corner i of the whole.
    """
    corner = np.eye(3)
    around_corners = 0.5 * (corner[:, None] + corner)
    middle = 0.5 * (1.0 - corner)
    pieces = np.concatenate([around_corners, middle[None]])
    return reparametrise_triangle(net[..., None, :, :], pieces)


def halve_triangle(net: Float, side: int) -> Float:
    """Split triangles (..., n, dim) from the midpoint of a side to the corner opposite, (..., 2, n, dim).

    Side s runs from corner s to s + 1: the midpoint replaces corner s + 1 in the first piece, corner s in the second.
    """
    start, end = side, (side + 1) % 3
    corners = np.stack([np.eye(3), np.eye(3)])
    corners[0, end] = corners[1, start] = 0.5 * (np.eye(3)[start] + np.eye(3)[end])
    return reparametrise_triangle(net[..., None, :, :], corners)


def subdivide_curve(control_points: Float, t: float = 0.5) -> tuple[Float, Float]:
    """Split curves (..., d + 1, dim) at a parameter into control points of the part before it and the part after it."""
    first, last = [control_points[..., 0, :]], [control_points[..., -1, :]]
    while control_points.shape[-2] > 1:
        control_points = (1.0 - t) * control_points[..., :-1, :] + t * control_points[..., 1:, :]
        first.append(control_points[..., 0, :])
        last.append(control_points[..., -1, :])
    return np.stack(first, axis=-2), np.stack(last[::-1], axis=-2)


def subdivide_tensor(net: Float, axis: int, t: float = 0.5) -> tuple[Float, Float]:
    """Split tensor-product patches (..., m + 1, n + 1, dim) at u = t (axis 0) or v = t (axis 1)."""
    if axis == 1:
        return subdivide_curve(net, t)
    before, after = subdivide_curve(net.swapaxes(-3, -2), t)
    return before.swapaxes(-3, -2), after.swapaxes(-3, -2)


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
        first, second, third = raised(degree)
        total[..., first, :] = exponents[:, 0, None] * net
        total[..., second, :] += exponents[:, 1, None] * net
        total[..., third, :] += exponents[:, 2, None] * net
        total /= degree + 1
        net = total
    return net


def elevate_tensor(net: Float, steps: tuple[int, int] = (1, 1)) -> Float:
    """Net (..., m + 1, n + 1, dim) of the same tensor-product patch with degrees (m, n) + steps."""
    along_v = elevate_curve(net, steps[1])
    return elevate_curve(along_v.swapaxes(-3, -2), steps[0]).swapaxes(-3, -2)


def derivative_curve(control_points: Float) -> Float:
    """Control points (..., d, dim) of the derivative of a curve of degree d >= 1."""
    return np.asarray((control_points.shape[-2] - 1) * np.diff(control_points, axis=-2))


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
    product /= np.array([math.comb(m + n, k) for k in range(m + n + 1)], dtype=np.float64)[:, None]
    return product


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
    product /= _multinomials(m + n)
    return product
