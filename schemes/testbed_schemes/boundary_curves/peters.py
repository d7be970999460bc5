"""Peters' boundary curves (1991; Mann 1992, section 2.3.1): as low a degree as the end data allow.

With sigma_0 = <n0, a> and sigma_1 = -<n1, a>, the heights of each end over the other's tangent plane (equation 2.11):
both zero give a straight line, one sign a parabola, two signs an inflected cubic, which is the projected curve. The
parabola's middle control point is the point of both tangent planes nearest the midpoint of the chord, which is that of
Nagata's curve.

Degrees as printed, but for two points. **Corrected**: the printed rule takes a parabola where sigma_0 sigma_1 >= 0; it
must be > 0, since one height of zero puts the middle point of planar data into a vertex, and the end tangent vanishes.
**Fill**: how different the heights may be (Mann 1992, section 2.4.5, asks for a cubic where their ratio is small, and
gives no number), and that the "minimal length" of the parabola is the distance of its middle point from the chord's.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.mathematics.planar_frame import PARALLEL, STRAIGHT, edge_normals
from testbed_schemes.nagata import curvature_vectors


@dataclass(frozen=True)
class PetersCurve(BoundaryCurve):
    """Lines, parabolas and inflected cubics, all as cubics.

    Parameters
    ----------
    ratio
        Least ratio of the smaller height to the larger, of one sign, for a parabola, from 0 to 1; lopsided ones become
        projected cubics, counted in the notes. Along n0 - n1 the middle point of a parabola lies no further from the
        midpoint of the chord than (1 - ratio) / (1 + ratio) of half its length; near 0 an end tangent may vanish.

    Raises
    ------
    SpecError
        ``ratio`` is not between 0 and 1.
    """

    ratio: float = 0.2

    name = "peters"
    title = "Peters"
    reference = "Peters 1991, Smooth mesh interpolation with cubic patches; Mann 1992, section 2.3.1"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = (
        "sigma_0 = <n0, a>, sigma_1 = -<n1, a>: a line if both are 0; if both have one sign, the parabola p0, Q, p1, Q "
        "the point of both tangent planes nearest the midpoint; else the projected cubic."
    )
    status = (
        "Corrected: a parabola where sigma_0 sigma_1 > 0, printed >= 0. Fill: the least ratio of the two for it, and "
        "the meaning of minimal length."
    )
    failures = (
        "Refused where a chord is parallel to a normal. A parabola is flat at its ends and sharp in the middle: over a "
        "quarter of the unit circle its curvature runs from 0.5 to 1.41."
    )

    def __post_init__(self) -> None:
        """Check the ratio."""
        if not 0.0 <= self.ratio <= 1.0:
            raise SpecError(f"{self.name}: ratio must be between 0 and 1, and here it is {self.ratio}")

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the curves raised to cubics, (E, 4, 3); counts parabolas that were too lopsided.

        A chord in both tangent planes is its own projection: lines need no case of their own.
        """
        n0, n1 = edge_normals(edges)
        cubic, _ = Projected().curves(edges)
        middle = tangent_planes_meet(edges)
        parabola = np.stack([edges.p0, edges.p0 + 2.0 * middle, edges.p1 + 2.0 * middle, edges.p1], axis=1)
        parabola[:, 1:3] /= 3.0
        chord = edges.p1 - edges.p0
        heights = np.stack([dot(n0, chord), -dot(n1, chord)])
        larger = np.abs(heights).max(axis=0)
        one_sign = (heights[0] * heights[1] > 0.0) & (larger > STRAIGHT * norm(chord))
        even = (np.abs(heights).min(axis=0) >= self.ratio * larger) & (norm(cross(n0, n1)) > PARALLEL)
        lopsided = one_sign & ~even & np.isfinite(cubic).all(axis=(1, 2))
        takes = (one_sign & even)[:, None, None] & np.isfinite(cubic)
        notes = {"lopsided parabolas made cubic": int(lopsided.sum())} if lopsided.any() else {}
        return np.where(takes, parabola, cubic), notes


def tangent_planes_meet(edges: EdgeData) -> Float:
    """Return the point of both tangent planes nearest the midpoint of each edge, (E, 3).

    Nagata's c is the shortest vector that makes (p0 + p1 - c) / 2 such a point. NaN or far away, and of no use, where
    the planes are parallel.
    """
    c, _ = curvature_vectors(edges, 0.0)
    return (edges.p0 + edges.p1 - c) / 2.0
