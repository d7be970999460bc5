"""The largest angle between the normals along each edge: exact and enclosed where normals are polynomials.

Polynomial and rational Bezier patches have polynomial normals along their sides
(:mod:`testbed.geometry.normal_jump`); edges of other patches are sampled, and searched as ``epsilon_deg`` is.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from testbed.geometry.blocks import blocks
from testbed.geometry.edges import PatchEdges, PatchSides
from testbed.geometry.normal_fields import NormalFields, along_sides, have_polynomial_normals
from testbed.geometry.normal_jump import DIVISIONS, GAP, normal_jumps, too_wide
from testbed.geometry.normal_pairs import NormalPairs
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int
from testbed.measures.continuity import edge_jumps, edge_parameters, interior_edges, search
from testbed.measures.sampling import CHUNK


@dataclass(frozen=True, eq=False)
class EdgeAngles:
    """Largest angles between the normals on the two sides of E edges, radians; NaN where there is no normal.

    Parameters
    ----------
    edges
        The edges between patches, in the order of :func:`testbed.measures.continuity.interior_edges`.
    angle
        (E,) the largest angle along each edge.
    t
        (E,) where it is, along the edge as its left side runs.
    low, high
        (E,) bounds of the largest angle. Where the edge is not ``exact`` nothing is guaranteed but what was attained:
        ``low`` is that and ``high`` infinite.
    exact
        (E,) true where both patches have polynomial normals: the angle is right to rounding, the bounds are guaranteed.
    """

    edges: PatchEdges
    angle: Float
    t: Float
    low: Float
    high: Float
    exact: Bool

    def __len__(self) -> int:
        return len(self.edges)

    @property
    def certified(self) -> bool:
        """Whether the bounds of all edges are guaranteed."""
        return bool(self.exact.all())


def edge_angles(surface: Surface, edges: PatchEdges | None = None, gap: float = GAP) -> EdgeAngles:
    """Return the largest angle along every edge between patches.

    Parameters
    ----------
    surface
        Any surface.
    edges
        Interior edges of the surface; all of them by default.
    gap
        Largest relative width of the enclosures, where rounding allows it.
    """
    if edges is None:
        edges = interior_edges(surface)
    exact = have_exact_angles(surface, edges)
    angle, t, low, high = np.full((4, len(edges)), np.nan)
    rows = np.flatnonzero(exact)
    for divisions in (0, DIVISIONS):
        # few edges need to be divided: those of all blocks together
        for some, pairs in normal_pairs(surface, edges, rows):
            found = normal_jumps(pairs, gap=gap, divisions=divisions)
            angle[some], t[some], low[some], high[some] = found.angle, found.t, found.low, found.high
        rows = np.flatnonzero(too_wide(low, high))
    (others,) = np.nonzero(~exact)
    angle[others], t[others] = searched(surface, edges[others])
    low[others], high[others] = angle[others], np.where(np.isnan(angle[others]), np.nan, np.inf)
    return EdgeAngles(edges, angle, t, low, high, exact)


def have_exact_angles(surface: Surface, edges: PatchEdges) -> Bool:
    """(E,) true where both patches of an edge have polynomial normals along it."""
    polynomial = np.array([have_polynomial_normals(batch) for batch in surface.batches], dtype=np.bool_)
    both: Bool = polynomial[edges.left.part] & polynomial[edges.right.part]
    return both


def normal_pairs(surface: Surface, edges: PatchEdges, rows: Int) -> Iterator[tuple[Int, NormalPairs]]:
    """Yield blocks of some rows (R,) of edges, and the normals on their two sides; each row once."""
    left, right = edges.left[rows], edges.right[rows]
    # edges of one kind have normals of the same degrees: part and, on tensor-product patches, direction on both sides
    kind = np.zeros(len(rows), dtype=np.int64)
    for sides in (left, right):
        corners = np.array([batch.sides for batch in surface.batches], dtype=np.int64)[sides.part]
        kind = 2 * (len(surface.batches) * kind + sides.part) + np.where(corners == 4, sides.side % 2, 0)
    for one_kind in np.unique(kind):
        (alike,) = np.nonzero(kind == one_kind)
        for block in blocks(len(alike)):
            chosen = alike[block]
            one, other = _normals(surface, left[chosen]), _normals(surface, right[chosen])
            yield rows[chosen], NormalPairs.of(one, other.reversed())


def _normals(surface: Surface, sides: PatchSides) -> NormalFields:
    """Normals along sides of patches of one part."""
    batch: PatchBatch = surface.batches[int(sides.part[0])]
    return along_sides(batch, sides.patch, sides.side)


def searched(surface: Surface, edges: PatchEdges) -> tuple[Float, Float]:
    """Largest angles (E,) on edges from samples and a search around the largest of them, and their parameters (E,)."""
    t = edge_parameters(len(edges), 0)
    angle, place = np.empty((2, len(edges)))
    step = max(1, CHUNK // len(t))
    for start in range(0, len(edges), step):
        some = edges[start : start + step]
        jumps = edge_jumps(surface, some, t)[0]
        peak, value = jumps.argmax(axis=1), jumps.max(axis=1)
        at, kind = t[peak], np.zeros(len(some), dtype=np.int64)
        (known,) = np.nonzero(~np.isnan(value))
        value[known], at[known] = search(surface, some[known], t, kind[known], value[known], peak[known], edge_jumps)
        angle[start : start + step], place[start : start + step] = value, at
    return angle, place
