"""The rules of differentiation for functions of one parameter, and for the parameter's own dependence on (u, v).

Coefficients in one parameter t are arrays (1 | 2 | 3, ...) with rows f | f' | f'': derivatives, not divided by
factorials. One row alone is a constant, or an evaluation of order 0. The parameter itself has the rows of
:mod:`testbed.geometry.truncated`, t | t_u, t_v | t_uu, t_uv, t_vv. The other axes broadcast, element by element.
"""

import numpy as np

from testbed.geometry import truncated
from testbed.geometry.elementary import OneVariable
from testbed.geometry.jets import ROWS
from testbed.geometry.vectors import Float


def multiply(p: Float, q: Float) -> Float:
    """Product, by Leibniz's rule."""
    result: Float = p * q[:1] if len(p) >= len(q) else p[:1] * q
    if len(p) == 1 or len(q) == 1:
        return result
    result[1:] += p[:1] * q[1:]
    if len(result) == 3:
        mixed = p[1] * q[1]
        mixed += mixed
        result[2] += mixed
    return result


def divide(p: Float, q: Float) -> Float:
    """Quotient r: from p = r q follow r' = (p' - r q') / q and r'' = (p'' - 2 r' q' - r q'') / q."""
    if len(q) == 1:
        return p / q
    result = np.zeros((len(q), *np.broadcast_shapes(p.shape[1:], q.shape[1:])))
    result[: len(p)] = p
    result[0] /= q[0]
    result[1:] -= result[:1] * q[1:]
    result[1] /= q[0]
    if len(result) == 3:
        mixed = result[1] * q[1]
        mixed += mixed
        result[2] -= mixed
        result[2] /= q[0]
    return result


def compose(function: OneVariable, p: Float) -> Float:
    """g(p) with derivatives g' p' and g' p'' + g'' p' p'."""
    # contiguous, because numpy's loops for transcendental functions on strided data may round differently
    derivatives = function(np.asarray(p[0], order="C"))
    result = np.empty(p.shape)
    result[0] = next(derivatives)
    if len(p) > 1:
        result[1:] = next(derivatives) * p[1:]
    if len(p) == 3:
        result[2] += next(derivatives) * (p[1] * p[1])
    return result


def expand(p: Float, t: Float) -> Float:
    """Derivatives along (u, v) of p(t(u, v)), by the chain rule."""
    result = np.empty((ROWS[len(p) - 1], *np.broadcast_shapes(p.shape[1:], t.shape[1:])))
    result[0] = p[0]
    if len(p) > 1:
        result[1:] = p[1] * t[1:]
    if len(p) == 3:
        result[3:] += p[2] * _squares(t)
    return result


def add_expanded_product(total: Float, w: Float, p: Float, t: Float) -> None:
    """Add to ``total`` the product of w, known along (u, v), and p(t(u, v)): the rules of product and chain in one.

    What multiplies p' and p'' is made from w and t alone, which often stand for many patches at once.
    """
    total += w * p[:1]
    if len(p) > 1:
        slope = t.copy()
        slope[0] = 0.0
        total[1:] += truncated.multiply(w, slope)[1:] * p[1]
    if len(p) == 3:
        total[3:] += (w[0] * _squares(t)) * p[2]


def _squares(t: Float) -> Float:
    """t_u t_u, t_u t_v, t_v t_v."""
    return np.stack([t[1] * t[1], t[1] * t[2], t[2] * t[2]])
