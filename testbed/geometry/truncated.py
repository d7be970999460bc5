"""The rules of differentiation on arrays of Taylor coefficients: sum, product, quotient, composition.

Coefficients are arrays (1 | 3 | 6, ...) with rows f | f_u, f_v | f_uu, f_uv, f_vv: derivatives, not divided by
factorials. One row alone is a constant, or an evaluation of order 0. The other axes broadcast, element by element.
"""

from collections.abc import Callable

import numpy as np

from testbed.geometry.elementary import OneVariable, TwoVariables
from testbed.geometry.vectors import Float


def _empty(p: Float, q: Float) -> Float:
    return np.empty((max(len(p), len(q)), *np.broadcast_shapes(p.shape[1:], q.shape[1:])))


def _add_products_of_first(result: Float, p: Float, q: Float, sign: Callable[..., Float] = np.add) -> None:
    """Add to second derivatives (or subtract) what first ones make: 2 p_u q_u, p_u q_v + p_v q_u, 2 p_v q_v."""
    products = p[1:3, None] * q[1:3]
    mixed = products[0, 1] + products[1, 0]
    pure = products.reshape(4, *mixed.shape)[::3]
    pure += pure
    sign(result[3::2], pure, out=result[3::2])
    sign(result[4:5], mixed, out=result[4:5])


def linear(ufunc: Callable[..., Float], p: Float, q: Float) -> Float:
    """Sum or difference."""
    if len(p) == len(q):
        return ufunc(p, q)
    result = _empty(p, q)
    result[0] = ufunc(p[0], q[0])
    result[1:] = p[1:] if len(q) == 1 else ufunc(0.0, q[1:])
    return result


def multiply(p: Float, q: Float) -> Float:
    """Product, by Leibniz's rule."""
    if len(p) == 1 or len(q) == 1:
        return p * q
    result: Float = p * q[:1]
    result[1:] += p[:1] * q[1:]
    if len(result) == 6:
        _add_products_of_first(result, p, q)
    return result


def divide(p: Float, q: Float) -> Float:
    """Quotient r: from p = r q follow r' = (p' - r q') / q and r'' = (p'' - 2 r' q' - r q'') / q."""
    if len(q) == 1:
        return p / q
    result = _empty(p, q)
    result[: len(p)] = p
    result[len(p) :] = 0.0
    result[0] /= q[0]
    result[1:] -= result[:1] * q[1:]
    result[1:3] /= q[0]
    if len(result) == 6:
        _add_products_of_first(result, result, q, np.subtract)
        result[3:] /= q[0]
    return result


def compose(function: OneVariable, p: Float) -> Float:
    """g(p) with derivatives g' p' and g' p'' + g'' p' p'."""
    # contiguous, because numpy's loops for transcendental functions on strided data may round differently
    derivatives = function(np.asarray(p[0], order="C"))
    result = np.empty(p.shape)
    result[0] = next(derivatives)
    if len(p) > 1:
        result[1:] = next(derivatives) * p[1:]
    if len(p) == 6:
        second = next(derivatives)
        by_u, by_v = second * p[1], second * p[2]
        result[3] += by_u * p[1]
        result[4] += by_u * p[2]
        result[5] += by_v * p[2]
    return result


def compose_two(function: TwoVariables, p: Float, q: Float) -> Float:
    """g(p, q), by the chain rule."""
    result = _empty(p, q)
    rows, *shape = result.shape
    p, q = (np.concatenate([x, np.zeros((rows - len(x), *x.shape[1:]))]) for x in (p, q))
    derivatives = function(*(np.asarray(np.broadcast_to(x[0], shape), order="C") for x in (p, q)))
    (result[0],) = next(derivatives)
    if rows > 1:
        gp, gq = next(derivatives)
        result[1:] = gp * p[1:] + gq * q[1:]
    if rows == 6:
        gpp, gpq, gqq = next(derivatives)
        for row, (x, y) in enumerate(((1, 1), (1, 2), (2, 2)), start=3):
            result[row] += gpp * (p[x] * p[y]) + gpq * (p[x] * q[y] + p[y] * q[x]) + gqq * (q[x] * q[y])
    return result


def hypot(p: Float, q: Float) -> Float:
    """Return h = sqrt(p^2 + q^2) without overflow; NaN derivatives at 0.

    The gradient is the direction (c, s) = (p, q) / h, the Hessian of rank one: (-s, c) (-s, c)^T / h.
    """
    result = _empty(p, q)
    rows, *shape = result.shape
    h = np.hypot(np.broadcast_to(p[0], shape), np.broadcast_to(q[0], shape))
    result[0] = h
    if rows == 1:
        return result
    c, s = p[0] / h, q[0] / h
    result[1:] = _derivatives(c, p, rows) + _derivatives(s, q, rows)
    if rows == 6:
        across = _derivatives(c, q, 3) - _derivatives(s, p, 3)
        scaled = across / h
        result[3] += across[0] * scaled[0]
        result[4] += across[0] * scaled[1]
        result[5] += across[1] * scaled[1]
    return result


def _derivatives(factor: Float, p: Float, rows: int) -> Float:
    """Return factor times the derivative rows of p, zeros for a constant."""
    if len(p) == 1:
        return np.zeros((rows - 1, *np.broadcast_shapes(factor.shape, p.shape[1:])))
    return factor * p[1:rows]
