"""The side-vertex method: curves from each vertex to the points of the opposite side, three patches blended.

Shared by the schemes that build a triangular patch in this way. Vertex i has the opposite side from vertex j = i + 1 to
vertex k = i + 2 (mod 3), with parameter s = b_k / (b_j + b_k); the radial curve from vertex i has parameter
r = b_j + b_k. The formulas are for arrays, hence for Taylors too; what is computed from s alone is then differentiated
with respect to s only, until it meets something else (:mod:`testbed.geometry.composed`).

Everything is built as a deviation from the flat triangle P = b_0 V_0 + b_1 V_1 + b_2 V_2. The derivatives of the
blending functions grow without limit towards the vertices, and with them whatever rounding has left in what is blended;
the deviations vanish there, and so do their errors. Complements of parameters are given, never computed as one minus:
1 - s is b_j / (b_j + b_k) and 1 - r is b_i.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from testbed.geometry.composed import in_one_parameter, weighted_sum
from testbed.geometry.vectors import Float

#: How near to a corner second derivatives are good: rounding leaves an error of about 1e-16 / distance in them.
CORNER_MARGIN = 1e-6

#: Corners j = i + 1 and k = i + 2 for i = 0, 1, 2.
J, K = [1, 2, 0], [2, 0, 1]

#: ``deviation(r, rest, s, rest_s)``: how far (..., 3, 3) the patches of the three vertices are from the flat triangle,
#: at r (..., 3) on the curve from each vertex to the opposite side's point at s, with rest = 1 - r and rest_s = 1 - s.
Deviation: TypeAlias = Callable[[Float, Float, Float, Float], Float]

#: ``terms(r, rest, s, rest_s)``: the same as weights (..., 3) and vectors (..., 3, 3), whose products add up to it.
Terms: TypeAlias = Callable[[Float, Float, Float, Float], tuple[Sequence[Float], Sequence[Float]]]


def side_vertex_blend(deviation: Deviation, points: Float, b0: Float, b1: Float, b2: Float) -> Float:
    """Blend three patches: sum of beta_i G_i, beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0), (..., 3).

    The result has the boundary curves, if all G_i have them, and along side i the tangent planes of G_i (Mann 1992,
    (2.12)). ``points`` (..., 3, 3) are the vertices. The three are evaluated together, on an axis of their own.
    """
    return separable_blend(lambda *at: ([np.ones(3)], [deviation(*at)]), points, b0, b1, b2)


def separable_blend(terms: Terms, points: Float, b0: Float, b1: Float, b2: Float, exponent: int = 1) -> Float:
    """Blend three patches as :func:`side_vertex_blend` does, from weights that depend on r and vectors that do on s.

    The weights, with beta_i in them, are then the same for all patches at shared points, and each vector is multiplied
    once. ``exponent`` is that of the products in beta_i: with 2 the result has the second derivatives of G_i on side i
    too (Mann 1992, (2.14)).
    """
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    products, r = (bj * bk) ** exponent if exponent > 1 else bj * bk, bj + bk
    shares = products / products.sum(axis=-1, keepdims=True)
    weights, vectors = terms(r, bi, *in_one_parameter(bk / r, bj / r))
    blended = weighted_sum([shares * weight for weight in weights], vectors)
    result: Float = np.sum(bi[..., None] * points, axis=-2) + np.sum(blended, axis=-2)
    return result


def hermite_weights(t: Float, rest: Float) -> tuple[Float, Float, Float]:
    """Weights (...) of chord, first and last tangent in a cubic Hermite curve's deviation from its chord."""
    product = t * rest
    return product * (t - rest), product * rest, -product * t
