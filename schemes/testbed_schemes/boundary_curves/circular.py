"""Circular boundary curves: tangents along the projected chord, as long as those of a circle's arc.

With c = <t, a> / L the cosine of the angle between tangent and chord, the tangent has length 2 L / (1 + c) and the
Bezier leg is a third of it. Where both angles are equal and in one plane this is the usual cubic for a circular arc:
leg 4/3 R tan(angle / 4), middle on the circle. Formula: a fill, not from the surveyed papers.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, dot
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.planar_frame import curve_from_legs, edge_normals, projected_tangents


@dataclass(frozen=True)
class Circular(BoundaryCurve):
    """Tangents along the projected chord, of a circular arc's length."""

    name = "circular"
    title = "Circular arc"
    reference = "fill: the cubic approximation of a circular arc, end by end"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = "H1 = p0 + d0 t0, H2 = p1 - d1 t1, t the unit projected chord, d = 2 L / (3 (1 + c)), c = <t, chord> / L."
    status = "Fill: in none of the surveyed papers; the usual cubic for an arc, end by end."
    failures = (
        "Refused where a chord is parallel to a normal; the curvature at the ends is that of an arc, not the data's."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return p0, p0 + d0 t0, p1 - d1 t1, p1 with d = 2 L / (3 (1 + c)), (E, 4, 3)."""
        chord = edges.p1 - edges.p0
        (t0, t1), length = projected_tangents(chord, *edge_normals(edges))
        d0, d1 = (2.0 * length**2 / (3.0 * (length + dot(t, chord))) for t in (t0, t1))
        return curve_from_legs(edges, (t0, t1), d0, d1), {}
