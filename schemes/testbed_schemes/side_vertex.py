"""The side-vertex method: curves from each vertex to the points of the opposite side, three patches blended.

Shared by the schemes that build a triangular patch in this way. Vertex i has the opposite side from vertex j = i + 1 to
vertex k = i + 2 (mod 3), with parameter s = b_k / (b_j + b_k); the radial curve from vertex i has parameter b_j + b_k.
The formulas are for arrays, hence for Taylors too; sums b_j + b_k stand where the papers have 1 - b_i, so that s does
not leave [0, 1] near the vertices.
"""

from collections.abc import Callable
from typing import TypeAlias

from testbed.geometry.vectors import Float

#: How near to a corner second derivatives are good: rounding leaves an error of about 1e-16 / distance^2 in them.
CORNER_MARGIN = 1e-4

#: ``patch(i, s, r)``: points (..., 3) of the patch of vertex i, at parameter r of its curve to the side's point at s.
SideVertexPatch: TypeAlias = Callable[[int, Float, Float], Float]


def side_vertex_blend(patch: SideVertexPatch, b0: Float, b1: Float, b2: Float) -> Float:
    """Blend three patches: sum of beta_i G_i, beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0).

    The result has the boundary curves, if all G_i have them, and along side i the tangent planes of G_i (Mann 1992,
    (2.12)).
    """
    b = (b0, b1, b2)
    products = [b[(i + 1) % 3] * b[(i + 2) % 3] for i in range(3)]
    total = products[0] + products[1] + products[2]
    pieces = []
    for i in range(3):
        r = b[(i + 1) % 3] + b[(i + 2) % 3]
        pieces.append((products[i] / total)[..., None] * patch(i, b[(i + 2) % 3] / r, r))
    return pieces[0] + pieces[1] + pieces[2]


def hermite(start: Float, chord: Float, tangent0: Float, tangent1: Float, t: Float) -> Float:
    """Cubic Hermite curve at ``t`` from ``start`` to ``start + chord`` with end tangents, (..., 3)."""
    r = 1.0 - t
    along, leaving, arriving = t * t * (3.0 - 2.0 * t), t * r * r, t * t * r
    return start + along[..., None] * chord + leaving[..., None] * tangent0 - arriving[..., None] * tangent1


def hermite_derivative(chord: Float, tangent0: Float, tangent1: Float, t: Float) -> Float:
    """Return the derivative of :func:`hermite`."""
    r = 1.0 - t
    along, leaving, arriving = 6.0 * t * r, r * (r - 2.0 * t), t * (t - 2.0 * r)
    return along[..., None] * chord + leaving[..., None] * tangent0 + arriving[..., None] * tangent1
