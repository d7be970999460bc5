"""How patches join: the angle between the normals and the gap between the positions on the edges between patches."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.domain import side_points
from testbed.geometry.edges import PatchEdges
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.measures.extremum import Extremum
from testbed.measures.sampling import CHUNK
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Fewest and most intervals between the even samples of an edge; nine make the ten of Mann 1992, section 5.3.
INTERVALS = (9, 32)
#: Samples near both ends of an edge, where cross-boundary derivatives of blended patches vary fast.
NEAR_ENDS = (1e-3, 1e-2)
#: Parameters are multiples of this power of two, so that t on one side of an edge is exactly 1 - t on the other.
GRAIN = 2.0**-50
#: Points on the bracket of a maximum in each round, and rounds; a round narrows the bracket fourfold.
BRACKET = np.arange(1, 8) / 8.0
ROUNDS = 10
#: Edges counted by their jump: the columns' names and the angles in degrees; 0.057 is a thousandth of a radian.
THRESHOLDS = (
    ("edges_above_0p057_deg", 0.057),
    ("edges_above_0p1_deg", 0.1),
    ("edges_above_0p5_deg", 0.5),
    ("edges_above_1_deg", 1.0),
)


@dataclass(frozen=True)
class Continuity(Measure):
    """Largest normal angle (epsilon) and position gap over all edges between patches, inner edges of split faces too.

    Angles are between oriented normals, by atan2: a fold reads 180 degrees, and 1e-12 degrees are not lost. Each edge
    is sampled, its ends included; the edges with the largest samples are searched further, on blended patches (with a
    corner margin) not between an end and its neighbouring sample at 0.001, where rounding of the blend would be found.
    A surface without edges between patches has nothing that could jump: its maxima are 0 and ``interior_edges`` is 0.

    Parameters
    ----------
    budget
        Samples on all edges together, about; an edge has at least 14.
    candidates
        Edges in which a maximum is searched for.
    """

    budget: int = 120_000
    candidates: int = 32

    name: ClassVar[str] = "continuity"
    title: ClassVar[str] = "Normal jump and gap between patches"
    reference: ClassVar[str] = "Mann 1992, chapter 5"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("interior_edges", "edges between two patches"),
        Column("samples_per_edge", "samples of an edge, before the maxima are driven beyond them"),
        Column("epsilon_deg", "largest angle between the normals of neighbouring patches, degrees", converges=True),
        Column("epsilon_face", "mesh face of the largest angle, on the left of the edge; -1 for none"),
        Column("epsilon_bary", "place of the largest angle in the face"),
        Column("gap_max", "largest distance between neighbouring patches at the same point of an edge"),
        Column("gap_face", "mesh face of the largest gap, on the left of the edge; -1 for none"),
        Column("gap_bary", "place of the largest gap in the face"),
        *(Column(name, f"share of the edges with a sampled angle above {angle} degrees") for name, angle in THRESHOLDS),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        surface = survey.surface
        edges = surface.edges[surface.edges.interior]
        # an order that does not depend on how patches are stored: ties go to the lowest face
        edges = edges[np.lexsort((*edges.ids.T[::-1], edges.left.face))]
        t = edge_parameters(len(edges), self.budget)
        jumps = np.empty((2, len(edges), len(t)))
        step = max(1, CHUNK // len(t))
        for start in range(0, len(edges), step):
            some = slice(start, start + step)
            jumps[:, some] = edge_jumps(surface, edges[some], t)
        angle, gap = (largest(surface, edges, t, jumps[index], index, self.candidates) for index in (0, 1))
        sides = surface.mesh.sides
        result: dict[str, Value] = {
            "interior_edges": len(edges),
            "samples_per_edge": len(t),
            "epsilon_deg": float(np.degrees(angle.value)),
            "epsilon_face": angle.face,
            "epsilon_bary": angle.bary(sides) if len(edges) else "",
            "gap_max": gap.value,
            "gap_face": gap.face,
            "gap_bary": gap.bary(sides) if len(edges) else "",
        }
        peaks = np.degrees(jumps[0].max(axis=1))
        for name, threshold in THRESHOLDS:
            above = np.where(np.isnan(peaks), np.nan, peaks > threshold)
            result[name] = float(above.mean()) if len(edges) else 0.0
        return result


def edge_parameters(edges: int, budget: int) -> Float:
    """Parameters (T,) of the samples of every edge, ends included, symmetric under t -> 1 - t to the last bit."""
    low, high = INTERVALS
    intervals = int(np.clip(budget // max(edges, 1) - 1 - 2 * len(NEAR_ENDS), low, high))
    half = np.concatenate([np.arange(intervals // 2 + 1) / intervals, NEAR_ENDS])
    half = np.unique(grained(half))
    return np.unique(np.concatenate([half, 1.0 - half]))


def grained(t: Float) -> Float:
    """Parameters rounded so that 1 - (1 - t) is t."""
    return np.round(t / GRAIN) * GRAIN


def edge_jumps(surface: Surface, edges: PatchEdges, t: Float) -> Float:
    """Return normal angles in radians and position gaps, (2, E, T), at parameters (T,) or (E, T) of edges."""
    left, right = surface.edge_jets(edges, t, 1)
    # patches that are not finite have NaN for a jump, without a warning
    with np.errstate(invalid="ignore", over="ignore"):
        return np.stack([angle_between(left.normal, right.normal), norm(left.f - right.f)])


def largest(surface: Surface, edges: PatchEdges, t: Float, sampled: Float, index: int, candidates: int) -> Extremum:
    """Return the largest jump of kind ``index`` over all edges from its samples (E, T), searched beyond them.

    The brackets of the largest samples are searched on ever finer points, each candidate edge by itself.
    """
    if not len(edges):
        return Extremum(0.0, -1, np.full(2, np.nan))
    peak = sampled.argmax(axis=1)
    value = sampled.max(axis=1)
    if np.isnan(value).any():
        chosen = np.flatnonzero(np.isnan(value))[:1]
    else:
        chosen = np.sort(np.argsort(-value, kind="stable")[:candidates])
    at, value, peak = t[peak[chosen]], value[chosen], peak[chosen]
    low, high = t[np.maximum(peak - 1, 0)], t[np.minimum(peak + 1, len(t) - 1)]
    if not np.isnan(value).any():
        row = np.arange(len(chosen))
        margin = max(batch.corner_margin for batch in surface.batches)
        # samples at the ends are exact; between them and their neighbours, normals of blended patches lose digits
        margin = max(margin, NEAR_ENDS[0]) if margin > 0.0 else 0.0
        for _ in range(ROUNDS):
            points = np.clip(low[:, None] + (high - low)[:, None] * BRACKET, margin, 1.0 - margin)
            points = grained(points)
            found = edge_jumps(surface, edges[chosen], points)[index]
            best = found.argmax(axis=1)
            # NaN wins the comparison too
            better = ~(found[row, best] <= value)
            value, at = np.where(better, found[row, best], value), np.where(better, points[row, best], at)
            reach = 0.125 * (high - low)
            low, high = np.maximum(at - reach, low), np.minimum(at + reach, high)
    winner = int(np.argmax(value))
    side = edges.left[chosen[[winner]]]
    place = side_points(surface.parts[side.part[0]].batch.sides, side.side, at[[winner]])
    face, place = surface.place(int(side.part[0]), side.patch, place)
    return Extremum(float(value[winner]), int(face[0]), place[0, 0])
