"""Walton and Meek's boundary curves (1996): cubics whose legs bend with the normals at both ends.

With the chord a = p1 - p0, c = <n0, n1>, a0 = <n0, a> and a1 = <n1, a>,

    rho = 6 (2 a0 + c a1) / (4 - c^2),    sigma = 6 (2 a1 + c a0) / (4 - c^2),
    H1 = p0 + (6 a - 2 rho n0 + sigma n1) / 18,    H2 = p1 - (6 a + rho n0 - 2 sigma n1) / 18.

The legs are in the tangent planes for all normals, and the denominator is at least 3. Formulas: as printed, with the
chord's length multiplied out. **Fill**: there is no curve where a leg vanishes or does not run forward along the chord,
as when the chord is parallel to the normal.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, dot, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import PARALLEL, edge_normals


@dataclass(frozen=True)
class WaltonMeekCurve(BoundaryCurve):
    """Legs in the tangent planes that each bend with the other end's normal too."""

    name = "walton-meek"
    title = "Walton-Meek"
    reference = "Walton and Meek 1996"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = (
        "H1 = p0 + (6 a - 2 rho n0 + sigma n1) / 18, H2 = p1 - (6 a + rho n0 - 2 sigma n1) / 18, a = p1 - p0, "
        "rho = 6 (2 <n0, a> + c <n1, a>) / (4 - c^2), sigma = 6 (2 <n1, a> + c <n0, a>) / (4 - c^2), c = <n0, n1>."
    )
    status = "As printed; fill: refused where a leg vanishes or does not run forward along the chord."
    failures = (
        "Refused where a leg is not forward: a chord parallel to a normal, and under a hundredth of edges with random "
        "normals. Legs shrink on edges that turn by over 90 degrees: over a third of a circle the middle is 12% inside."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the curves (E, 4, 3); NaN rows where a leg does not run forward (``PARALLEL``)."""
        n0, n1 = edge_normals(edges)
        chord = edges.p1 - edges.p0
        leg0, leg1 = forward_leg(chord, n0, n1), forward_leg(-chord, n1, n0)
        return np.stack([edges.p0, edges.p0 + leg0, edges.p1 + leg1, edges.p1], axis=1), {}


def forward_leg(chord: Float, here: Float, there: Float) -> Float:
    """First leg (E, 3) of the curves along a chord from the end with normal ``here``; NaN where it is not forward."""
    c, height_here, height_there = dot(here, there), dot(here, chord), dot(there, chord)
    rho = 6.0 * (2.0 * height_here + c * height_there) / (4.0 - c**2)
    sigma = 6.0 * (2.0 * height_there + c * height_here) / (4.0 - c**2)
    leg = (6.0 * chord - 2.0 * rho[:, None] * here + sigma[:, None] * there) / 18.0
    # products of unit vectors: chords may have any length that a mesh may have
    length = norm(chord)
    with np.errstate(invalid="ignore", divide="ignore"):  # no chord: NaN, and the row is refused
        forward = dot(leg / length[:, None], chord / length[:, None]) > PARALLEL
    return np.where(forward[:, None], leg, np.nan)
