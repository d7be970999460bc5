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

from testbed.geometry.vectors import Float

#: How near to a corner second derivatives are good: rounding leaves an error of about 1e-16 / distance in them.
CORNER_MARGIN = 1e-6

#: ``deviation(i, r, rest, s, rest_s)``: how far (..., 3) the patch of vertex i is from the flat triangle, at r on the
#: curve from the vertex to the opposite side's point at s, with rest = 1 - r and rest_s = 1 - s.
Deviation: TypeAlias = Callable[[int, Float, Float, Float, Float], Float]


def side_vertex_blend(deviation: Deviation, points: Float, b0: Float, b1: Float, b2: Float) -> Float:
    """Blend three patches: sum of beta_i G_i, beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0), (..., 3).

    The result has the boundary curves, if all G_i have them, and along side i the tangent planes of G_i (Mann 1992,
    (2.12)). ``points`` (..., 3, 3) are the vertices.
    """
    b = (b0, b1, b2)
    products = [b[(i + 1) % 3] * b[(i + 2) % 3] for i in range(3)]
    total = products[0] + products[1] + products[2]
    result = b0[..., None] * points[..., 0, :] + b1[..., None] * points[..., 1, :] + b2[..., None] * points[..., 2, :]
    for i in range(3):
        bj, bk = b[(i + 1) % 3], b[(i + 2) % 3]
        r = bj + bk
        result = result + (products[i] / total)[..., None] * deviation(i, r, b[i], bk / r, bj / r)
    return result


def hermite_deviation(chord: Float, tangent0: Float, tangent1: Float, t: Float, rest: Float) -> Float:
    """How far a cubic Hermite curve with these end tangents is from its chord at ``t`` = 1 - ``rest``, (..., 3)."""
    product = t * rest
    along, leaving, arriving = product * (t - rest), product * rest, product * t
    return along[..., None] * chord + leaving[..., None] * tangent0 - arriving[..., None] * tangent1


def hermite_derivative(chord: Float, tangent0: Float, tangent1: Float, t: Float, rest: Float) -> Float:
    """Derivative of the cubic Hermite curve at ``t`` = 1 - ``rest``, (..., 3)."""
    along, leaving, arriving = 6.0 * t * rest, rest * (rest - 2.0 * t), t * (t - 2.0 * rest)
    return along[..., None] * chord + leaving[..., None] * tangent0 + arriving[..., None] * tangent1
