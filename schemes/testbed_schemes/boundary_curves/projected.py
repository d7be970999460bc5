"""Projected boundary curves (Mann 1992, section 2.4.3): the chord projected onto the tangent planes.

At each end the tangent is the chord's projection onto the tangent plane, scaled to the chord's length, so that the
Bezier legs are a third of the chord. The curve is not planar in general. Formulas: as printed, rescaling included.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import curve_from_legs, edge_normals, projected_tangents


@dataclass(frozen=True)
class Projected(BoundaryCurve):
    """Tangents along the projected chord, of the chord's length."""

    name = "projected"
    title = "Projected chord"
    reference = "Mann 1992, section 2.4.3"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = "H1 = p0 + L t0 / 3, H2 = p1 - L t1 / 3, t the unit projection of the chord on the tangent plane."
    status = "As printed, rescaling to the chord's length included."
    failures = (
        "Refused where a chord is parallel to a normal. Flat over long arcs: over a quarter of a circle the middle is "
        "4% inside, over a third 12%; the curvature at the ends is not the data's."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return p0, p0 + L t0 / 3, p1 - L t1 / 3, p1 with t the unit projected chord, (E, 4, 3)."""
        tangents, length = projected_tangents(edges.p1 - edges.p0, *edge_normals(edges))
        third = length / 3.0
        return curve_from_legs(edges, tangents, third, third), {}
