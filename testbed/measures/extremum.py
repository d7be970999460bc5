"""Maxima over a surface: the best samples, driven to the local maximum within their patches.

A minimum is the maximum of the negative. The search keeps to the patch's domain (and off its corners by the patch's
corner margin) and never returns less than the best sample. All candidates advance at once, each by itself.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.geometry.domain import barycentric
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int
from testbed.measures.climb import Climb

#: Values (Q, N, K) of Q quantities at K points (N, K, 2) of each of N patches of a part: (part, patches, at).
Quantities: TypeAlias = Callable[[int, Int, Float], Float]

#: A bound on the rounds of a search, against slow walks along ridges.
ROUNDS = 40
#: Rounds for all candidates; then the best of each quantity go on to the end: this many by their values, and as many by
#: what their models promise.
FIRST_ROUNDS = 2
FINALISTS = 32
#: Samples are neighbours up to this distance, in units of the square root of one over their number.
NEIGHBOURS = 1.5


@dataclass(frozen=True)
class PatchPlace:
    """A place in a patch.

    Parameters
    ----------
    part, patch
        Which part of the surface, and which of its patches.
    at
        (2,) parameters in the patch.
    """

    part: int
    patch: int
    at: Float


@dataclass(frozen=True)
class Extremum:
    """A maximum over a surface and where it is.

    Parameters
    ----------
    value
        The maximum; NaN if any sample was NaN.
    face
        Mesh face; the lowest of those that reach it. -1 on a surface without patches.
    place
        (2,) parameters in the face; of the first NaN sample if the value is NaN.
    within
        The patch and the place in it, where that is known.
    """

    value: float
    face: int
    place: Float
    within: PatchPlace | None = None

    def bary(self, sides: int) -> str:
        """Barycentric coordinates in a triangle, parameters in a square, as text: exact floats joined by ``;``."""
        place = barycentric(self.place) if sides == 3 else self.place
        return ";".join(repr(float(number)) for number in place)


@dataclass(frozen=True)
class _Candidates:
    """Patches and places to start from; one row for each, in the order of mesh faces."""

    quantity: Int
    part: Int
    patch: Int
    at: Float
    value: Float


def maxima(
    surface: Surface,
    sampled: Sequence[Float],
    places: Sequence[Float],
    quantities: Quantities,
    margins: Sequence[float],
    candidates: int,
) -> list[Extremum]:
    """Return the maxima of several quantities over a surface.

    Parameters
    ----------
    sampled
        For each part of the surface (Q, P, S) sampled quantities.
    places
        For each part (S, 2) the samples' domain points.
    quantities
        The quantities anywhere: ``quantities(part, patches, at)``.
    margins
        For each part the corner distance to keep.
    candidates
        From how many samples the search starts for each quantity: the best of each patch, and where there are fewer
        patches every sample that is as good as its neighbours, because the highest sample may be beside a lower peak.
    """
    order = patch_order(surface)
    rank = np.empty(len(order), dtype=np.intp)
    rank[order] = np.arange(len(order))
    first = np.cumsum([0, *(len(part.batch) for part in surface.parts)])
    chosen = []
    for quantity in range(len(sampled[0]) if sampled else 0):
        starts = []
        for part, (values, where) in enumerate(zip(sampled, places, strict=True)):
            found = _starts(values[quantity], where, several=len(order) <= candidates)
            starts.append((np.full(len(found[0]), part), *found, values[quantity][found], where[found[1]]))
        part_of, patch_of, sample, peak, at = (np.concatenate(pieces) for pieces in zip(*starts, strict=True))
        # by mesh face, and then by sample, as long as values are equal
        by_face = np.lexsort((sample, rank[first[part_of] + patch_of]))
        # argmax takes NaN for the largest, and so does the order here: the first NaN leads
        keys = np.where(np.isnan(peak), -np.inf, -peak)[by_face]
        lead = by_face[np.sort(np.argsort(keys, kind="stable")[:candidates])]
        if np.isnan(peak).any():
            lead = by_face[np.flatnonzero(np.isnan(peak[by_face]))[:1]]
        chosen.append(_Candidates(np.full(len(lead), quantity), part_of[lead], patch_of[lead], at[lead], peak[lead]))
    if not chosen:
        return []
    start = _Candidates(
        *(
            np.concatenate([getattr(one, name) for one in chosen])
            for name in ("quantity", "part", "patch", "at", "value")
        )
    )
    return _refined(surface, start, [len(one.value) for one in chosen], quantities, margins, places)


def _starts(values: Float, places: Float, *, several: bool) -> tuple[Int, Int]:
    """Return patches and samples to start from: the best of each patch, or all that no neighbour is better than.

    Parameters
    ----------
    values
        (P, S) at the samples of patches.
    places
        (S, 2) the samples' domain points.
    several
        Whether to return all peaks of a patch.
    """
    best: Int = values.argmax(axis=1)
    if not several:
        return np.arange(len(values)), best
    apart = np.hypot(*np.moveaxis(places[:, None] - places, -1, 0))
    near = apart <= NEIGHBOURS / np.sqrt(len(places))
    peaks = ((values[:, :, None] >= values[:, None]) | ~near).all(axis=2)
    # NaN is no peak, and has to lead
    peaks[np.arange(len(values)), best] = True
    patches, samples = np.nonzero(peaks)
    return patches, samples


def patch_order(surface: Surface) -> Int:
    """Return the order of all patches by mesh face and corner ids, which does not depend on how they are stored."""
    faces = np.concatenate([part.faces for part in surface.parts])
    width = max(part.corner_ids.shape[1] for part in surface.parts)
    ids = np.concatenate(
        [
            np.pad(part.corner_ids, ((0, 0), (0, width - part.corner_ids.shape[1])), mode="edge")
            for part in surface.parts
        ]
    )
    order: Int = np.lexsort((*ids.T[::-1], faces))
    return order


def _refined(
    surface: Surface,
    start: _Candidates,
    counts: Sequence[int],
    quantities: Quantities,
    margins: Sequence[float],
    places: Sequence[Float],
) -> list[Extremum]:
    radius = np.array([1.0 / np.sqrt(len(where)) for where in places])[start.part]
    climb = Climb.start(start.at, start.value, radius)
    end = np.cumsum(counts)
    leading = np.ones(len(start.value), dtype=np.bool_)
    for round_ in range(ROUNDS):
        if round_ == FIRST_ROUNDS:
            leading[:] = False
            for first, last in zip(end - counts, end, strict=True):
                for merit in (climb.value[first:last], climb.promise[first:last]):
                    leading[first + np.argsort(-merit, kind="stable")[:FINALISTS]] = True
        moving = leading & climb.active
        if not moving.any():
            break
        for part, of_surface in enumerate(surface.parts):
            (rows,) = np.nonzero(moving & (start.part == part))
            if len(rows):
                own = _of_part(quantities, part, start.patch[rows], start.quantity[rows])
                batch = of_surface.batch
                climb.advance(rows, own, batch.sides, margins[part], batch.collapsed)
    value = climb.value
    result = []
    for first, last in zip(end - counts, end, strict=True):
        # the first NaN if there is one, otherwise the first of the largest: candidates stand in the order of faces
        best = first + int(np.argmax(value[first:last])) if last > first else -1
        if best < 0:
            result.append(Extremum(float("nan"), -1, np.full(2, np.nan)))
            continue
        within = PatchPlace(int(start.part[best]), int(start.patch[best]), climb.at[best].copy())
        face, place = surface.place(within.part, start.patch[[best]], climb.at[[best]])
        result.append(Extremum(float(value[best]), int(face[0]), place[0], within))
    return result


def _of_part(quantities: Quantities, part: int, patch: Int, quantity: Int) -> Callable[[Float], Float]:
    """Values of each candidate's own quantity."""

    def values(at: Float) -> Float:
        return quantities(part, patch, at)[quantity, np.arange(len(patch))]

    return values
