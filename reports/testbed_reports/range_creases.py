"""Creases inside patches: where the normal jumps off the edges between them."""

from typing import Final

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, angle_between

#: Samples on the whole surface, about; fewest and most steps of a patch's side.
BUDGET: Final = 60_000
STEPS: Final = (6, 32)
#: Samples keep off the corners of a patch, where blends are 0/0, by this share of the way to its middle.
INSET: Final = 1e-3
#: Segments that are searched, those whose ends' normals differ most, and halvings of each.
CANDIDATES: Final = 4096
HALVINGS: Final = 22
#: A normal that turns by less over such a short way, in degrees, turns smoothly.
SMOOTH_DEG: Final = 1e-3


def largest_crease(surface: Surface) -> float:
    """Return the largest angle in degrees by which a normal jumps inside a patch, as found; 0 for none.

    Between neighbouring samples the half over which the normal turns more is taken again and again. On a smooth patch
    next to nothing is left of the angle, at a crease all. Edges between patches are not looked at. NaN where a patch
    has no normal.
    """
    count = max(surface.patch_count, 1)
    worst = 0.0
    for batch in surface.batches:
        steps = [n for n in range(STEPS[0], STEPS[1] + 1) if count * len(lattice(batch.sides, n)) <= BUDGET]
        worst = float(np.maximum(worst, _largest_in(batch, max(steps, default=STEPS[0]))))
    # written so that NaN is no pass
    return 0.0 if worst <= SMOOTH_DEG else worst


def _largest_in(batch: PatchBatch, steps: int) -> float:
    """Return the largest angle in degrees that is left of those between neighbours of a lattice in each patch."""
    if not len(batch):
        return 0.0
    at = lattice(batch.sides, steps)
    pairs = _neighbours(at, steps)
    middle = np.full(2, 1.0 / 3.0) if batch.sides == 3 else np.full(2, 0.5)
    at = (1.0 - INSET) * at + INSET * middle
    normals = batch.jets(at, 1).normal
    angles = angle_between(normals[:, pairs[:, 0]], normals[:, pairs[:, 1]])
    order = np.argsort(-np.nan_to_num(angles, nan=np.inf), axis=None)[:CANDIDATES]
    patch, pair = np.unravel_index(order, angles.shape)
    chosen = batch.take(patch)
    low, high = at[pairs[pair, 0]], at[pairs[pair, 1]]
    first, last = normals[patch, pairs[pair, 0]], normals[patch, pairs[pair, 1]]
    for _ in range(HALVINGS):
        half = 0.5 * (low + high)
        between = chosen.jets(half[:, None], 1).normal[:, 0]
        # a half without a normal is the one to keep: NaN is no pass
        before = ~(angle_between(first, between) <= angle_between(between, last))[:, None]
        low, first = np.where(before, low, half), np.where(before, first, between)
        high, last = np.where(before, half, high), np.where(before, between, last)
    return float(np.degrees(angle_between(first, last)).max())


def _neighbours(at: Float, steps: int) -> Int:
    """Pairs (M, 2) of neighbours along rows, columns and diagonals of a lattice."""
    number = np.full((steps + 2, steps + 2), -1)
    i, j = np.rint(at * steps).astype(np.int64).T
    number[i, j] = np.arange(len(at))
    pairs = [np.stack([number[i, j], number[i + di, j + dj]], axis=-1) for di, dj in ((1, 0), (0, 1), (1, -1))]
    both = np.concatenate(pairs)
    return both[both[:, 1] >= 0]
