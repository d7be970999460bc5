"""Curvature of Bezier patches in decimal arithmetic of 60 digits, from the definitions: arrays of Decimals."""

from collections.abc import Callable
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from testbed.geometry.bernstein import casteljau_step, triangle_degree
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Bool, Float, cross, dot

DIGITS = 60
#: Arrays of Decimals.
Decimals = Any

ZERO: Decimals = Decimal(0)
ONE: Decimals = Decimal(1)

decimal: Callable[[Any], Decimals] = np.vectorize(Decimal, otypes=[object])


def curvatures(batch: PatchBatch, at: Decimals) -> Decimals:
    """K and H (2, P, S) at points (P, S, 2) of Decimals."""
    with localcontext() as context:
        context.prec = DIGITS
        return _curvatures(*_jets(batch, at))


def _curvatures(fu: Decimals, fv: Decimals, fuu: Decimals, fuv: Decimals, fvv: Decimals) -> Decimals:
    n = cross(fu, fv)
    square = dot(n, n)
    L, M, N = dot(fuu, n), dot(fuv, n), dot(fvv, n)
    E, F, G = dot(fu, fu), dot(fu, fv), dot(fv, fv)
    return np.stack([(L * N - M * M) / square**2, -(E * N - 2 * F * M + G * L) / (2 * square * np.sqrt(square))])


def _jets(batch: PatchBatch, at: Decimals) -> list[Decimals]:
    if isinstance(batch, BezierQuads):
        return [_tensor(batch.control_points, at, *order) for order in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))]
    if isinstance(batch, BezierTriangles):
        return _triangle(decimal(batch.control_points), at)[1:]
    assert isinstance(batch, RationalBezierTriangles)
    weights = decimal(batch.weights)[..., None]
    A, Au, Av, Auu, Auv, Avv = _triangle(decimal(batch.control_points) * weights, at)
    w, wu, wv, wuu, wuv, wvv = _triangle(weights, at)
    f = A / w
    fu, fv = (Au - wu * f) / w, (Av - wv * f) / w
    fuu = (Auu - 2 * wu * fu - wuu * f) / w
    fuv = (Auv - wu * fv - wv * fu - wuv * f) / w
    fvv = (Avv - 2 * wv * fv - wvv * f) / w
    return [fu, fv, fuu, fuv, fvv]


def _triangle(net: Decimals, at: Decimals) -> list[Decimals]:
    """f, f_u, f_v, f_uu, f_uv, f_vv (P, S, dim) of nets (P, n, dim)."""
    degree = triangle_degree(net.shape[1])
    point = np.concatenate([1 - at.sum(axis=-1, keepdims=True), at], axis=-1)
    along_u, along_v = decimal([-1, 1, 0]), decimal([-1, 0, 1])
    result = []
    for directions in ((), (along_u,), (along_v,), (along_u, along_u), (along_u, along_v), (along_v, along_v)):
        value = net[:, None]
        for step in range(degree):
            # more derivatives than the degree has are zero: differences of what is left
            value = casteljau_step(value, directions[step] if step < len(directions) else point)
        if len(directions) > degree:
            value = value * 0
        factor = [1, degree, degree * (degree - 1)][len(directions)]
        result.append(np.broadcast_to(factor * value[..., 0, :], (*at.shape[:2], net.shape[-1])))
    return result


def _tensor(net: Float, at: Decimals, order_u: int, order_v: int) -> Decimals:
    along_v = _curve(np.moveaxis(decimal(net)[:, None], 3, 0), at[..., 1, None, None], order_v)
    return _curve(np.moveaxis(along_v, 2, 0), at[..., 0, None], order_u)


def _curve(points: Decimals, t: Decimals, order: int) -> Decimals:
    """Derivative of curves with control points along the first axis."""
    factor, degree = 1, len(points) - 1
    for taken in range(order):
        factor *= degree - taken
        points = points[1:] - points[:-1] if len(points) > 1 else points * 0
    while len(points) > 1:
        points = (1 - t) * points[:-1] + t * points[1:]
    return factor * points[0]


def refined_extreme(batch: PatchBatch, quantity: int, sign: int) -> tuple[Decimals, Decimals]:
    """Points (P, 2) and values (P,) of the largest ``sign`` K (0) or H (1) of each patch, to 30 digits or so.

    A float search on shrinking grids, then Newton steps within the domain, or along its boundary where the search ended
    there; a step that loses is not made.
    """
    at = _grid_search(batch, quantity, sign)
    free = _free_directions(batch.sides, at)
    with localcontext() as context:
        context.prec = DIGITS
        place = decimal(at)
        place = _onto_boundary(batch.sides, place, at)
        value = sign * curvatures(batch, place[:, None])[quantity][:, 0]
        for h in (Decimal("1e-8"), Decimal("1e-12"), Decimal("1e-14")):
            moved = place + _newton_step(batch, quantity, sign, place, free, h)
            higher = sign * curvatures(batch, moved[:, None])[quantity][:, 0]
            better = (higher > value) & _inside(batch.sides, moved)
            place = np.where(better[:, None], moved, place)
            value = np.where(better, higher, value)
    return place, value


def _float_curvature(batch: PatchBatch, at: Float, quantity: int) -> Float:
    from testbed.geometry.curvature import analyse

    found = analyse(batch.jets(at))
    return found.gauss if quantity == 0 else found.mean


def _grid_search(batch: PatchBatch, quantity: int, sign: int) -> Float:
    start = lattice(batch.sides, 60)
    best = start[np.argmax(sign * _float_curvature(batch, start, quantity), axis=1)]
    offsets = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 9)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    radius = 2.0 / 60
    for _ in range(24):
        at = np.clip(best[:, None] + radius * offsets, 0.0, 1.0)
        if batch.sides == 3:
            beyond = np.maximum(at.sum(axis=-1, keepdims=True) - 1.0, 0.0)
            at = np.clip(at - 0.5 * beyond, 0.0, 1.0)
        at = np.concatenate([best[:, None], at], axis=1)
        best = at[np.arange(len(at)), np.argmax(sign * _float_curvature(batch, at, quantity), axis=1)]
        radius *= 0.5
    found: Float = best
    return found


def _active(sides: int, at: Float) -> Bool:
    """(P, sides) which of the lines u = 0, v = 0 and u + v = 1, or u = 1, v = 1, the points are on."""
    u, v = at[:, 0], at[:, 1]
    room = [u, v, 1.0 - u - v] if sides == 3 else [u, v, 1.0 - u, 1.0 - v]
    near: Bool = np.stack(room, axis=-1) < 1e-6
    return near


def _free_directions(sides: int, at: Float) -> Float:
    """(P, 2, 2) two directions, the second or both zero on the boundary or at a corner."""
    active = _active(sides, at)
    result = np.broadcast_to(np.eye(2), (len(at), 2, 2)).copy()
    along = np.array([[0.0, 1.0], [1.0, 0.0], [-1.0, 1.0]] if sides == 3 else [[0, 1.0], [1.0, 0], [0, 1.0], [1.0, 0]])
    for side in range(active.shape[1]):
        result[active[:, side]] = [along[side], [0.0, 0.0]]
    result[active.sum(axis=1) > 1] = 0.0
    return result


def _onto_boundary(sides: int, place: Decimals, at: Float) -> Decimals:
    active = _active(sides, at)
    u, v = place[:, 0], place[:, 1]
    u, v = np.where(active[:, 0], ZERO, u), np.where(active[:, 1], ZERO, v)
    if sides == 4:
        u, v = np.where(active[:, 2], ONE, u), np.where(active[:, 3], ONE, v)
    else:
        v = np.where(active[:, 2] & ~active[:, 1], 1 - u, v)
        u = np.where(active[:, 2] & active[:, 1], 1 - v, u)
    return np.stack([u, v], axis=-1)


def _inside(sides: int, at: Decimals) -> Bool:
    u, v = at[:, 0], at[:, 1]
    beyond = u + v > 1 if sides == 3 else (u > 1) | (v > 1)
    return np.asarray(~((u < 0) | (v < 0) | beyond).astype(np.bool_))


def _newton_step(batch: PatchBatch, quantity: int, sign: int, place: Decimals, free: Float, h: Decimal) -> Decimals:
    """Newton's step (P, 2) towards a maximum from central differences along the free directions."""
    one, other = decimal(free[:, 0]), decimal(free[:, 1])
    steps = [0 * one, one, -one, other, -other, one + other, -one - other]
    at = np.stack([place + h * step for step in steps], axis=1)
    f, a, b, c, d, e, g = np.moveaxis(sign * curvatures(batch, at)[quantity], 1, 0)
    fx, fy = (a - b) / (2 * h), (c - d) / (2 * h)
    fxx, fyy = (a - 2 * f + b) / h**2, (c - 2 * f + d) / h**2
    fxy = ((e - 2 * f + g) / h**2 - fxx - fyy) / 2
    still = ~free[:, 0].any(axis=1)
    line = ~still & ~free[:, 1].any(axis=1)
    one_fxx = np.where(still | (fxx == 0), ONE, fxx)
    determinant = np.where(line | still, ONE, fxx * fyy - fxy * fxy)
    determinant = np.where(determinant == 0, ONE, determinant)
    x = np.where(line, -fx / one_fxx, (fxy * fy - fyy * fx) / determinant)
    y = np.where(line, ZERO, (fxy * fx - fxx * fy) / determinant)
    x, y = np.where(still, ZERO, x), np.where(still, ZERO, y)
    return x[:, None] * one + y[:, None] * other
