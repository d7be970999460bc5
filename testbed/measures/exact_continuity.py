"""Epsilon without sampling: the largest normal angle over all edges of polynomial patches, with guaranteed bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.domain import side_points
from testbed.geometry.edges import PatchEdges
from testbed.geometry.normal_jump import normal_jumps
from testbed.geometry.normal_pairs import HALF_TURN
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Int
from testbed.measures.continuity import interior_edges
from testbed.measures.edge_angles import have_exact_angles, normal_pairs
from testbed.measures.extremum import Extremum
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Edges that are solved first, those with the largest bounds: few others can then hold the maximum.
FIRST = 64


@dataclass(frozen=True)
class ExactContinuity(Measure):
    """Largest normal angle over all edges between patches, exact and enclosed, of polynomial patches.

    The sampled ``epsilon_deg`` is a lower bound of the same number, but for rounding, and is there for all patches.
    Where patches join smoothly it is nothing but the rounding of their jets, relative to the size of the coordinates,
    and may lie above the bound, which takes the control points for exact. The columns are left out where a patch is
    neither polynomial nor rational with positive weights. Only edges whose bounds admit the maximum are solved. A
    surface without edges between patches has no angle: 0.
    """

    name: ClassVar[str] = "exact-continuity"
    title: ClassVar[str] = "Exact normal jump between polynomial patches"
    reference: ClassVar[str] = "Mann 1992, section 5.3.1, corrected"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("epsilon_exact_deg", "largest angle between normals along the edges, right to rounding", optional=True),
        Column("epsilon_exact_face", "mesh face of that angle, on the left of the edge; -1 for none", optional=True),
        Column("epsilon_exact_bary", "place of that angle in the face", optional=True),
        Column("epsilon_low_deg", "guaranteed lower bound of the largest angle, degrees", optional=True),
        Column("epsilon_high_deg", "guaranteed upper bound of the largest angle, degrees", optional=True),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none where some edge's angle is not exact."""
        surface = survey.surface
        edges = interior_edges(surface)
        if not have_exact_angles(surface, edges).all():
            return {}
        largest, low, high = largest_angle(surface, edges)
        low, high = np.degrees([low, high]).tolist()
        return {
            "epsilon_exact_deg": float(np.degrees(largest.value)),
            "epsilon_exact_face": largest.face,
            "epsilon_exact_bary": largest.bary(surface.mesh.sides) if len(edges) else "",
            # the conversion to degrees is rounded too
            "epsilon_low_deg": float(np.nextafter(low, -np.inf)) if low > 0.0 else low,
            "epsilon_high_deg": float(np.nextafter(high, np.inf)) if high > 0.0 else high,
        }


def largest_angle(surface: Surface, edges: PatchEdges) -> tuple[Extremum, float, float]:
    """Return the largest angle over edges with polynomial normals, and a lower and an upper bound of it, radians."""
    if not len(edges):
        return Extremum(0.0, -1, np.full(2, np.nan)), 0.0, 0.0
    found = [np.empty(len(edges)) for _ in range(4)]
    settled = np.empty(len(edges), dtype=np.bool_)

    def solve(chosen: Int, floor: float) -> None:
        for rows, pairs in normal_pairs(surface, edges, chosen):
            jumps = normal_jumps(pairs, floor)
            for column, values in zip(found, (jumps.angle, jumps.t, jumps.low, jumps.high), strict=True):
                column[rows] = values
            settled[rows] = jumps.settled

    # no angle is above half a turn: first bounds only
    solve(np.arange(len(edges)), HALF_TURN)
    angle, t, low, high = found
    for count in (FIRST, len(edges)):
        # false for NaN, which nothing exceeds
        (admitted,) = np.nonzero(~settled & (high > angle.max()))
        solve(admitted[np.argsort(-high[admitted], kind="stable")[:count]], float(angle.max()))
    winner = np.array([angle.argmax()])
    side = edges.left[winner]
    place = side_points(surface.parts[side.part[0]].batch.sides, side.side, t[winner])
    face, place = surface.place(int(side.part[0]), side.patch, place)
    largest = Extremum(float(angle[winner[0]]), int(face[0]), place[0, 0])
    return largest, float(low.max()), float(high.max())
