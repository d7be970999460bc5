"""Maxima over a surface: the best samples, driven to the local maximum within their patches.

A minimum is the maximum of the negative. The search keeps to the patch's domain (and off its corners by the patch's
corner margin) and never returns less than the best sample. All candidates advance at once, each by itself.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.geometry.domain import barycentric, corner_distance
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, Int

#: Values (Q, N, K) of Q quantities at K points (N, K, 2) of each of N patches of a part: (part, patches, at).
Quantities: TypeAlias = Callable[[int, Int, Float], Float]

#: Domain directions of the search: on a triangle, along its sides, so that the search can follow the boundary.
DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])
#: The search of a candidate ends when its step is below this fraction of the domain: its value is then within about the
#: square of it, relatively, of the local maximum.
SMALLEST_STEP = 1e-6
#: A bound on the rounds of a search, against slow walks along ridges.
ROUNDS = 40
#: Rounds for all candidates; then the best of each quantity, this many, go on to the end.
FIRST_ROUNDS = 3
FINALISTS = 16


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
    """

    value: float
    face: int
    place: Float

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
        How many patches, those with the best samples, the search looks into for each quantity.
    """
    order = patch_order(surface)
    part_of = np.repeat(np.arange(len(surface.parts)), [len(part.batch) for part in surface.parts])[order]
    patch_of = np.concatenate([np.arange(len(part.batch)) for part in surface.parts])[order]
    chosen = []
    for quantity in range(len(sampled[0]) if sampled else 0):
        best = [values[quantity].argmax(axis=1) for values in sampled]
        peak = np.concatenate([v[quantity][np.arange(len(b)), b] for v, b in zip(sampled, best, strict=True)])[order]
        at = np.concatenate([where[b] for where, b in zip(places, best, strict=True)])[order]
        # argmax takes NaN for the largest, and so does the order here: the first NaN leads
        keys = np.where(np.isnan(peak), -np.inf, -peak)
        lead = np.sort(np.argsort(keys, kind="stable")[:candidates])
        if np.isnan(peak).any():
            lead = np.flatnonzero(np.isnan(peak))[:1]
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
    at, value = start.at.copy(), start.value.copy()
    radius = np.array([1.0 / np.sqrt(len(where)) for where in places])[start.part]
    end = np.cumsum(counts)
    leading = np.isfinite(value)
    for rounds in (FIRST_ROUNDS, ROUNDS):
        for part in range(len(surface.parts)):
            (rows,) = np.nonzero(leading & (start.part == part))
            if len(rows):
                own = _of_part(quantities, part, start.patch[rows], start.quantity[rows])
                sides = surface.parts[part].batch.sides
                at[rows], value[rows], radius[rows] = climb(
                    own, at[rows], value[rows], radius[rows], sides, margins[part], rounds
                )
        leading[:] = False
        for first, last in zip(end - counts, end, strict=True):
            leading[first + np.argsort(-value[first:last], kind="stable")[:FINALISTS]] = True
    result = []
    for first, last in zip(end - counts, end, strict=True):
        # the first NaN if there is one, otherwise the first of the largest: candidates stand in the order of faces
        best = first + int(np.argmax(value[first:last])) if last > first else -1
        if best < 0:
            result.append(Extremum(float("nan"), -1, np.full(2, np.nan)))
            continue
        face, place = surface.place(int(start.part[best]), start.patch[[best]], at[[best]])
        result.append(Extremum(float(value[best]), int(face[0]), place[0]))
    return result


def _of_part(quantities: Quantities, part: int, patch: Int, quantity: Int) -> Callable[[Int, Float], Float]:
    """Values of each candidate's own quantity, for :func:`climb`."""

    def values(rows: Int, at: Float) -> Float:
        return quantities(part, patch[rows], at)[quantity[rows], np.arange(len(rows))]

    return values


def climb(
    values: Callable[[Int, Float], Float],
    at: Float,
    value: Float,
    radius: Float,
    sides: int,
    margin: float,
    rounds: int = ROUNDS,
) -> tuple[Float, Float, Float]:
    """Drive points to local maxima.

    Each round looks at six neighbours at distance ``radius`` and at the maxima of the parabolas along three lines and
    of the quadratic that they define; the best point is the next centre, and the radius shrinks fourfold unless that
    point is as far away as the radius. The neighbours alone make it a convergent pattern search; the parabolas make it
    quick.

    Parameters
    ----------
    values
        ``values(rows, at)``: (n, K) at points (n, K, 2) of chosen candidates (n,); a NaN there becomes the maximum.
    at, value
        (N, 2) starting points in the domain and (N,) the values there.
    radius
        (N,) first step lengths.
    sides, margin
        The domain, and the corner distance to keep.
    rounds
        Rounds at most.

    Returns
    -------
    at, value, radius
        (N, 2), (N,), (N,), to go on from.
    """
    at, value, radius = at.copy(), value.copy(), radius.copy()
    rows: Int = np.arange(len(at))
    for _ in range(rounds):
        rows = rows[(radius[rows] > SMALLEST_STEP) & ~np.isnan(value[rows])]
        if not len(rows):
            break
        centre, step = at[rows, None], radius[rows, None, None]
        ring = move(centre, step * np.concatenate([DIRECTIONS, -DIRECTIONS]), sides, margin)
        around = values(rows, ring)
        proposed = move(centre, peaks(centre, value[rows], ring, around, step[..., 0]), sides, margin)
        points = np.concatenate([centre, ring, proposed], axis=1)
        found = np.concatenate([value[rows, None], around, values(rows, proposed)], axis=1)
        best = np.argmax(found, axis=1)
        index = np.arange(len(rows))
        at[rows], value[rows] = points[index, best], found[index, best]
        far = np.abs(at[rows] - centre[:, 0]).max(axis=-1) >= 0.99 * radius[rows]
        radius[rows] *= np.where(far, 1.0, 0.25)
    return at, value, radius


def peaks(centre: Float, value: Float, ring: Float, around: Float, limit: Float) -> Float:
    """Return the steps (N, 4, 2) from centres (N, 1, 2) to the maxima of the quadratic and parabolas through a ring.

    Zero where there is no maximum; steps longer than ``limit`` (N, 1) are cut to it.
    """
    ahead, behind = (_along(ring[:, some] - centre) for some in (slice(0, 3), slice(3, 6)))
    up, down = around[:, :3] - value[:, None], around[:, 3:] - value[:, None]
    # divisions by zero mean a ring cut at the boundary or a flat spot: no step
    with np.errstate(all="ignore"):
        behind = np.abs(behind)
        slope = (up * behind / ahead - down * ahead / behind) / (ahead + behind)
        bend = 2.0 * (up / ahead + down / behind) / (ahead + behind)
        line = np.where(bend < 0.0, -slope / bend, 0.0)[..., None] * DIRECTIONS
        mixed = 0.5 * (bend[:, 0] + bend[:, 1] - bend[:, 2])
        determinant = bend[:, 0] * bend[:, 1] - mixed**2
        newton = np.stack(
            [mixed * slope[:, 1] - bend[:, 1] * slope[:, 0], mixed * slope[:, 0] - bend[:, 0] * slope[:, 1]], axis=-1
        )
        newton = np.where(((determinant > 0.0) & (bend[:, 0] < 0.0))[:, None], newton / determinant[:, None], 0.0)
    steps = np.nan_to_num(np.concatenate([newton[:, None], line], axis=1), nan=0.0, posinf=0.0, neginf=0.0)
    length = np.abs(steps).max(axis=-1, keepdims=True)
    shortened: Float = steps * np.minimum(1.0, limit[..., None] / np.maximum(length, np.finfo(float).tiny))
    return shortened


def _along(steps: Float) -> Float:
    """Signed lengths (N, 3) of steps (N, 3, 2) in units of the three directions."""
    return np.stack([steps[:, 0, 0], steps[:, 1, 1], steps[:, 2, 1]], axis=-1)


def move(centre: Float, step: Float, sides: int, margin: float) -> Float:
    """Return ``centre + step`` (N, K, 2), cut where it leaves the domain or comes within ``margin`` of a corner.

    A step that ends within the margin all the same, because it starts there or crosses into it on a square, is not
    made.
    """
    if sides == 3:
        start, change = barycentric(centre), np.concatenate([-step.sum(axis=-1, keepdims=True), step], axis=-1)
    else:
        start, change = centre, step
    with np.errstate(divide="ignore", invalid="ignore"):
        room = np.where(change > 0.0, (1.0 - (margin if sides == 3 else 0.0) - start) / change, -start / change)
    room = np.where(change == 0.0, np.inf, room).min(axis=-1, keepdims=True)
    moved: Float = np.clip(centre + np.clip(room, 0.0, 1.0) * step, 0.0, 1.0)
    if margin > 0.0:
        near: Bool = corner_distance(sides, moved) < margin * (1.0 - 1e-9)
        moved = np.where(near[..., None], centre, moved)
    return moved
