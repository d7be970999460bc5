"""The side-vertex method: curves from each vertex to the points of the opposite side, three patches blended.

Shared by the schemes that build a triangular patch in this way. Vertex i has the opposite side from vertex j = i + 1 to
vertex k = i + 2 (mod 3), with parameter s = b_k / (b_j + b_k); the radial curve from vertex i has parameter
r = b_j + b_k. The formulas are for arrays, hence for Taylors too.

Everything is built as a deviation from the flat triangle P = b_0 V_0 + b_1 V_1 + b_2 V_2. The derivatives of the
blending functions grow without limit towards the vertices, and with them whatever rounding has left in what is blended;
the deviations vanish there, and so do their errors. Complements of parameters are given, never computed as one minus:
1 - s is b_j / (b_j + b_k) and 1 - r is b_i.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from testbed.geometry.vectors import Float

#: How near to a corner second derivatives are good: rounding leaves an error of about 1e-16 / distance in them.
CORNER_MARGIN = 1e-6

#: Corners j = i + 1 and k = i + 2 for i = 0, 1, 2.
J, K = [1, 2, 0], [2, 0, 1]

#: ``deviation(r, rest, s, rest_s)``: how far (..., 3, 3) the patches of the three vertices are from the flat triangle,
#: at r (..., 3) on the curve from each vertex to the opposite side's point at s, with rest = 1 - r and rest_s = 1 - s.
Deviation: TypeAlias = Callable[[Float, Float, Float, Float], Float]


def side_vertex_blend(deviation: Deviation, points: Float, b0: Float, b1: Float, b2: Float) -> Float:
    """Blend three patches: sum of beta_i G_i, beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0), (..., 3).

    The result has the boundary curves, if all G_i have them, and along side i the tangent planes of G_i (Mann 1992,
    (2.12)). ``points`` (..., 3, 3) are the vertices. The three are evaluated together, on an axis of their own.
    """
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    products, r = bj * bk, bj + bk
    shares = products / products.sum(axis=-1, keepdims=True)
    blended = shares[..., None] * deviation(r, bi, bk / r, bj / r)
    result: Float = np.sum(bi[..., None] * points, axis=-2) + np.sum(blended, axis=-2)
    return result


def hermite_weights(t: Float, rest: Float) -> tuple[Float, Float, Float]:
    """Weights (...) of chord and end tangents in :func:`hermite_deviation`; the last one is subtracted."""
    product = t * rest
    return product * (t - rest), product * rest, product * t


def hermite_deviation(chord: Float, tangent0: Float, tangent1: Float, t: Float, rest: Float) -> Float:
    """How far a cubic Hermite curve with these end tangents is from its chord at ``t`` = 1 - ``rest``, (..., 3)."""
    along, leaving, arriving = hermite_weights(t, rest)
    return along[..., None] * chord + leaving[..., None] * tangent0 - arriving[..., None] * tangent1


def hermite_derivative(chord: Float, tangent0: Float, tangent1: Float, t: Float, rest: Float) -> Float:
    """Derivative of the cubic Hermite curve at ``t`` = 1 - ``rest``, (..., 3)."""
    along, leaving, arriving = 6.0 * t * rest, rest * (rest - 2.0 * t), t * (t - 2.0 * rest)
    return along[..., None] * chord + leaving[..., None] * tangent0 + arriving[..., None] * tangent1
