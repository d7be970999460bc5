"""How patches join: the angle between the normals and the gap between the positions on the edges between patches."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar, TypeAlias

import numpy as np

from testbed.geometry.domain import side_points
from testbed.geometry.edges import PatchEdges, PatchSides
from testbed.geometry.jets import Jet
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between, norm
from testbed.measures.extremum import Extremum
from testbed.measures.sampling import CHUNK
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Jumps of Q kinds, (Q, E, T), at parameters (T,) or (E, T) of edges of a surface.
Jumps: TypeAlias = Callable[[Surface, PatchEdges, Float], Float]

#: Fewest and most intervals between the even samples of an edge; nine make the ten of Mann 1992, section 5.3.
INTERVALS = (9, 32)
#: Samples near both ends of an edge, where cross-boundary derivatives of blended patches vary fast.
NEAR_ENDS = (1e-3, 1e-2)
#: Parameters are multiples of this power of two, so that t on one side of an edge is exactly 1 - t on the other.
GRAIN = 2.0**-50
#: Points on the bracket of a maximum in each round, and rounds; a round narrows the bracket fourfold. After four rounds
#: the parabola through the largest value and its neighbours has its vertex within about 1e-8 of the maximum.
BRACKET = np.arange(1, 8) / 8.0
ROUNDS = 6
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
        edges = interior_edges(surface)
        t = edge_parameters(len(edges), self.budget)
        jumps = np.empty((2, len(edges), len(t)))
        step = max(1, CHUNK // len(t))
        for start in range(0, len(edges), step):
            some = slice(start, start + step)
            jumps[:, some] = edge_jumps(surface, edges[some], t)
        turn, gap = largest(surface, edges, t, jumps, self.candidates)
        sides = surface.mesh.sides
        result: dict[str, Value] = {
            "interior_edges": len(edges),
            "samples_per_edge": len(t),
            "epsilon_deg": float(np.degrees(turn.value)),
            "epsilon_face": turn.face,
            "epsilon_bary": turn.bary(sides) if len(edges) else "",
            "gap_max": gap.value,
            "gap_face": gap.face,
            "gap_bary": gap.bary(sides) if len(edges) else "",
        }
        peaks = np.degrees(jumps[0].max(axis=1))
        for name, threshold in THRESHOLDS:
            above = np.where(np.isnan(peaks), np.nan, peaks > threshold)
            result[name] = float(above.mean()) if len(edges) else 0.0
        return result


def interior_edges(surface: Surface) -> PatchEdges:
    """Return the edges between patches, by mesh face and corner ids: an order that does not depend on storage."""
    edges = surface.edges[surface.edges.interior]
    return edges[np.lexsort((*edges.ids.T[::-1], edges.left.face))]


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
    left, right = edge_jets(surface, edges, t)
    # patches that are not finite have NaN for a jump, without a warning
    with np.errstate(invalid="ignore", over="ignore"):
        return np.stack([angle_between(left.normal, right.normal), norm(left.f - right.f)])


def edge_jets(surface: Surface, edges: PatchEdges, t: Float, order: int = 1) -> tuple[Jet, Jet]:
    """Jets of the left and right patches, both evaluated at once where their parameters allow it."""
    if t.ndim == 1 and not np.array_equal(1.0 - t[::-1], t):
        return surface.edge_jets(edges, t, order)
    left, right = edges.left, edges.right
    both = PatchSides(*(np.concatenate([getattr(s, f.name) for s in (left, right)]) for f in fields(PatchSides)))
    # parameters run the other way on the right; shared ones are symmetric, and their samples are turned round instead
    jets = surface.side_jets(both, t if t.ndim == 1 else np.concatenate([t, 1.0 - t]), order).coefficients
    on_right = jets[:, len(edges) :]
    return Jet(jets[:, : len(edges)]), Jet(on_right[:, :, ::-1] if t.ndim == 1 else on_right)


def largest(
    surface: Surface, edges: PatchEdges, t: Float, sampled: Float, candidates: int, jumps: Jumps = edge_jumps
) -> list[Extremum]:
    """Return the largest jump of each kind over all edges from their samples (Q, E, T), searched beyond them.

    The brackets of the largest samples are searched on ever finer points, each candidate edge by itself.
    """
    if not len(edges):
        return [Extremum(0.0, -1, np.full(2, np.nan))] * len(sampled)
    peak, value = sampled.argmax(axis=2), sampled.max(axis=2)
    chosen = [
        np.flatnonzero(np.isnan(v))[:1] if np.isnan(v).any() else np.sort(np.argsort(-v, kind="stable")[:candidates])
        for v in value
    ]
    kind, edge = np.repeat(np.arange(len(chosen)), [len(c) for c in chosen]), np.concatenate(chosen)
    value, peak = value[kind, edge], peak[kind, edge]
    at = t[peak]
    known = ~np.isnan(value)
    if known.any():
        start = value[known], peak[known]
        value[known], at[known] = search(surface, edges[edge[known]], t, kind[known], *start, jumps)
    result = []
    for index in range(len(chosen)):
        winner = np.flatnonzero(kind == index)[[np.argmax(value[kind == index])]]
        side = edges.left[edge[winner]]
        place = side_points(surface.parts[side.part[0]].batch.sides, side.side, at[winner])
        face, place = surface.place(int(side.part[0]), side.patch, place)
        result.append(Extremum(float(value[winner[0]]), int(face[0]), place[0, 0]))
    return result


def search(
    surface: Surface, edges: PatchEdges, t: Float, kind: Int, value: Float, peak: Int, jumps: Jumps
) -> tuple[Float, Float]:
    """Return the largest jumps (N,) and their parameters (N,) on brackets around the samples ``t[peak]`` of N edges.

    A round evaluates even points on each bracket, and the vertex of the parabola through the largest one of the round
    before and its neighbours.
    """
    at, row = t[peak], np.arange(len(edges))
    low, high = t[np.maximum(peak - 1, 0)], t[np.minimum(peak + 1, len(t) - 1)]
    margin = max(batch.corner_margin for batch in surface.batches)
    # samples at the ends are exact; between them and their neighbours, normals of blended patches lose digits
    margin = max(margin, NEAR_ENDS[0]) if margin > 0.0 else 0.0
    vertex = at
    for _ in range(ROUNDS):
        points = np.concatenate([low[:, None] + (high - low)[:, None] * BRACKET, vertex[:, None]], axis=1)
        points = grained(np.clip(points, margin, 1.0 - margin))
        found = jumps(surface, edges, points)[kind, row]
        vertex = parabola_vertex(points[:, : len(BRACKET)], found[:, : len(BRACKET)])
        best = found.argmax(axis=1)
        # NaN wins the comparison too
        better = ~(found[row, best] <= value)
        value, at = np.where(better, found[row, best], value), np.where(better, points[row, best], at)
        reach = 0.125 * (high - low)
        low, high = np.maximum(at - reach, low), np.minimum(at + reach, high)
    return value, at


def parabola_vertex(t: Float, values: Float) -> Float:
    """Vertices (N,) of parabolas through the largest of values (N, K) and its neighbours at even points (N, K).

    The largest itself where it has no neighbour on one side, or the three are in line.
    """
    row, best = np.arange(len(t)), values.argmax(axis=1)
    inner = np.clip(best, 1, t.shape[1] - 2)
    before, here, after = (values[row, inner + offset] for offset in (-1, 0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        step = 0.5 * (before - after) / (before - 2.0 * here + after)
    step = np.where((best == inner) & (np.abs(step) <= 1.0), step, 0.0)
    vertex: Float = t[row, best] + step * (t[:, 1] - t[:, 0])
    return vertex
