"""Conics on mesh edges: one rational quadratic over each chord, in the plane of the chord and the mean normal.

The tangents of the planar frame meet in Q1 = p0 + A t0 = p1 - B t1; with Q1 at weight w and the ends at weight 1 the
conic has the end points and tangent lines of the data. Its one free number is w = L / (A + B), the cosine of the angle
between chord and tangent where both ends have the same: a circle's arc there. Straight data have Q1 in the middle of
the chord and w = 1. Lines that are parallel or meet on the wrong side, as on edges with an inflection, have no conic,
and neither have those that meet next to an end, on data that turn at one end only. All of this is a **fill**: Hansford
1991 fits conics to edges, and the thesis does not say how.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Bool, Float
from testbed_schemes.mathematics.planar_frame import STRAIGHT, PlanarFrame, planar_coefficients

#: Least distance, in chords, of the tangents' intersection from an end.
LEAST_OFFSET = 0.05


@dataclass(frozen=True, slots=True)
class EdgeConics:
    """The conics of E edges; NaN where there is none.

    Attributes
    ----------
    offsets
        A / L and B / L, (2, E).
    weight
        w, (E,).
    """

    offsets: Float
    weight: Float

    @property
    def exists(self) -> Bool:
        """(E,) true where there is a conic."""
        return np.isfinite(self.weight)

    def middle(self, edges: EdgeData, frame: PlanarFrame) -> Float:
        """Q1, (E, 3): the mean of what both ends say, so that the reversed edge has the same, bit for bit."""
        from_start = edges.p0 + (self.offsets[0] * frame.length)[:, None] * frame.t0
        from_end = edges.p1 - (self.offsets[1] * frame.length)[:, None] * frame.t1
        mean: Float = (from_start + from_end) / 2.0
        return mean

    def cubic_legs(self) -> Float:
        """Bezier legs over L, (2, E), of the cubic with the conic's end tangents and its shoulder point at t = 1/2.

        The conic's shoulder point is M + w / (1 + w) (Q1 - M), M the middle of the chord; that of a cubic with the legs
        lambda (Q1 - p) is M + 3/4 lambda (Q1 - M). Hence lambda = 4 w / (3 (1 + w)).
        """
        legs: Float = 4.0 * self.weight / (3.0 * (1.0 + self.weight)) * self.offsets
        return legs


def edge_conics(frame: PlanarFrame) -> EdgeConics:
    """Return the conics of edges with these planar frames."""
    turn, (from_start, from_end) = planar_coefficients(frame)
    straight = np.max(np.abs([turn, from_start, from_end]), axis=0) <= STRAIGHT
    # parallel tangents: infinite, and no conic
    with np.errstate(invalid="ignore", divide="ignore"):
        offsets = np.where(straight, 0.5, np.stack([from_end, from_start]) / turn)
        meet = np.logical_and(*(offsets > LEAST_OFFSET)) & np.isfinite(offsets).all(axis=0)
    offsets = np.where(meet, offsets, np.nan)
    return EdgeConics(offsets, 1.0 / (offsets[0] + offsets[1]))
