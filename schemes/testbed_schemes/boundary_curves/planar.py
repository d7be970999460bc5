"""Planar boundary curves (Mann 1992, section 2.4.3): chord-length tangents in the plane of the mean normal.

The plane holds the chord and n0 + n1; the tangents are its intersections with the tangent planes, scaled to the chord's
length, so that the Bezier legs are a third of the chord. Formulas: as printed.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import curve_from_legs, planar_frame


@dataclass(frozen=True)
class Planar(BoundaryCurve):
    """Planar cubics with tangents of the chord's length."""

    name = "planar"
    title = "Planar"
    reference = "Mann 1992, section 2.4.3"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = (
        "H1 = p0 + L t0 / 3, H2 = p1 - L t1 / 3, t the unit tangent in the plane of the chord and n0 + n1, forward."
    )
    status = "As printed."
    failures = (
        "Refused where n0 + n1 is parallel to the chord or a tangent perpendicular to it. Flat over long arcs, as "
        "projected curves are: over a quarter of a circle the middle is 4% inside."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return p0, p0 + L t0 / 3, p1 - L t1 / 3, p1, (E, 4, 3), all in one plane."""
        frame = planar_frame(edges)
        third = frame.length / 3.0
        return curve_from_legs(edges, (frame.t0, frame.t1), third, third), {}
