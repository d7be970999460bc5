"""Conic boundary curves: the cubic with the end tangents and the shoulder point of a conic in the edge's plane.

The conic and its weight are those of :mod:`mathematics.edge_conics`: the tangents in the plane of the chord and
n0 + n1 meet in Q1, the weight is w = L / (A + B). Networks carry polynomial cubics, so this is the cubic with the legs
lambda (Q1 - p), lambda = 4 w / (3 (1 + w)), which passes through the conic's shoulder point at t = 1/2 and is the usual
cubic for a circular arc where the conic is a circle. Edges without a conic take the planar curve, and are counted.
All a **fill**; the scheme `hansford` has the conics themselves.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.edge_conics import edge_conics
from testbed_schemes.mathematics.planar_frame import curve_from_legs, planar_frame


@dataclass(frozen=True)
class ConicCurve(BoundaryCurve):
    """Planar cubics through the shoulder points of conics."""

    name = "conic"
    title = "Conic"
    reference = "fill: a cubic for the conic with weight L / (A + B), after the conics of Hansford 1991"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    formula = (
        "Q1 = p0 + A t0 = p1 - B t1 where the planar tangents meet, w = L / (A + B); legs 4 w / (3 (1 + w)) (Q1 - p0), "
        "(Q1 - p1), so that the cubic passes through the conic's shoulder point."
    )
    status = "Fill: the survey says only that Hansford's scheme fits conics to the edges."
    failures = (
        "Refused where the plane of chord and mean normal or a tangent in it is undefined. Edges with an inflection, "
        "or bent at one end only, have no conic (8 of 120 on a coarse torus): there the legs jump to L / 3, and near "
        "them the curve is far from the data: distances to a graph with asymptotic lines fall with third order, "
        "and K is between -200 and 140 on a torus of 50 points (projected: -15 to 5)."
    )

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the curves (E, 4, 3); planar curves with legs of L / 3, counted, where there is no conic."""
        frame = planar_frame(edges)
        conics = edge_conics(frame)
        d0, d1 = np.where(conics.exists, conics.cubic_legs(), 1.0 / 3.0) * frame.length
        control_points = curve_from_legs(edges, (frame.t0, frame.t1), d0, d1)
        missing = ~conics.exists & np.isfinite(control_points).all(axis=(1, 2))
        return control_points, {"curves without a conic": int(missing.sum())} if missing.any() else {}
