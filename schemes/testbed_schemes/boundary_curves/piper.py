"""Piper's boundary curves (Piper 1987; Mann 1992, section 2.4.3): the chord's projections as tangents, not rescaled.

At each end the tangent is the chord's projection onto the tangent plane at its own length, shorter than the chord; the
Bezier leg is a third of it, the point at a third of the chord dropped onto the tangent plane. Directions as printed;
**fill**: the length, of which the thesis says only that it is less than that of the projected curves. The legs are
those of PN triangles.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, norm, tangential
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import PARALLEL, edge_normals


@dataclass(frozen=True)
class PiperCurve(BoundaryCurve):
    """Tangents that are the chord's projections, of their own length."""

    name = "piper"
    title = "Piper"
    reference = "Piper 1987; Mann 1992, section 2.4.3"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = "H1 = p0 + (a - <a, n0> n0) / 3, H2 = p1 - (a - <a, n1> n1) / 3, with the chord a = p1 - p0."
    status = "Directions as printed; fill: the length, which the thesis only calls shorter than the chord."
    failures = (
        "Refused where a chord is parallel to a normal. Legs shrink as edges turn: over a quarter of a circle the "
        "middle is 12% inside (projected: 4%), over a third 31%."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the curves (E, 4, 3); NaN rows where the chord is parallel to a normal (``PARALLEL``)."""
        third = (edges.p1 - edges.p0) / 3.0
        least = PARALLEL * norm(third)
        leg0, leg1 = (_longer(tangential(third, normal), least) for normal in edge_normals(edges))
        return np.stack([edges.p0, edges.p0 + leg0, edges.p1 - leg1, edges.p1], axis=1), {}


def _longer(a: Float, least: Float) -> Float:
    """Vectors (E, 3), NaN where they are not longer than ``least`` (E,)."""
    return np.where((norm(a) > least)[:, None], a, np.nan)
