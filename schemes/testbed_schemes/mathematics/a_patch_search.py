"""Suprema of functions over triangles and squares, many at once: a lattice, then windows that close in on its peaks.

The functions need not be continuous, and may be -inf where nothing is asked of them: those of the bounds of A-patches
(Xu, Huang and Bajaj 2001, step 6) jump down where two extremes of a shooting polynomial cancel, and fall to -inf
towards the vertices. Suprema on sides and corners are met exactly, since lattice and windows have points there.

The result is a value that the function takes, up to rounding: never above the supremum. It is a search, not a proof:
a peak narrower than the lattice's steps can be missed.
"""

from collections.abc import Callable

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Bool, Float, Int

#: Values (n, S) of functions ``rows`` (n,) at their own points (n, S, 2).
Values = Callable[[Int, Float], Float]

# Steps of the first lattice along a side, peaks followed, and halves of a window's width before the search ends.
_STEPS, _PEAKS, _HALVINGS, _MOVES = 16, 4, 30, 90
_ROWS = 512
# What the last halvings must have gained less than, in units of the function's scale.
_ACCURACY = 1e-12
_WINDOW = np.stack(np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 5), indexing="ij"), axis=-1)


def suprema(values: Values, scale: Float, sides: int) -> Float:
    """Return the suprema (N,) of N functions over the triangle or the square.

    Parameters
    ----------
    values
        The functions. A value of one function must not depend on what is computed along with it.
    scale
        (N,) magnitude of each function; a search ends when it gains 1e-12 of that no more.
    sides
        3: the triangle u, v >= 0, u + v <= 1; 4: the square [0, 1]^2.

    Returns
    -------
    Float
        (N,): -inf where a function is that everywhere, NaN where one of its values on the lattice is.
    """
    result = np.empty(len(scale))
    for start in range(0, len(scale), _ROWS):
        rows = np.arange(start, min(start + _ROWS, len(scale)))
        result[rows] = _search(values, scale[rows], rows, sides)
    return result


def _search(values: Values, scale: Float, rows: Int, sides: int) -> Float:
    """Suprema of some of the functions."""
    points = lattice(sides, _STEPS)
    found = values(rows, np.broadcast_to(points, (len(rows), *points.shape)))
    best: Float = found.max(axis=1)
    owner, at = _peaks(points, found)
    high, width = best[owner], np.full(len(owner), 1.0 / _STEPS)
    previous = np.full(len(owner), np.inf)
    for _ in range(_MOVES):
        if not len(owner):
            break
        around = _clipped(at[:, None] + width[:, None, None] * _WINDOW.reshape(-1, 2), sides)
        there = values(rows[owner], around)
        place = there.argmax(axis=1)
        each = np.arange(len(owner))
        top = there[each, place]
        gain = np.maximum(top - high, 0.0)
        at = np.where((top > high)[:, None], around[each, place], at)
        # a peak at the window's rim may lie outside: follow it before closing in
        inner = (np.abs(around[each, place] - around[:, 12]) < 0.75 * width[:, None]).all(axis=1)
        settled = inner | (gain == 0.0)
        high = np.maximum(high, top)
        np.maximum.at(best, owner, high)
        width = np.where(settled, 0.5 * width, width)
        slow = np.maximum(gain, previous) <= _ACCURACY * scale[owner]
        done = (slow & (width < 2.0**-8)) | (width < 2.0 ** -(_HALVINGS + 4))
        # gains fall at least by half with the width: what is left is at most a few of them
        hopeless = (high + 8.0 * np.maximum(gain, previous) < best[owner]) & (width < 2.0**-7)
        previous = gain
        keep = ~(done | hopeless)
        owner, at, high, width, previous = owner[keep], at[keep], high[keep], width[keep], previous[keep]
    return best


def _peaks(points: Float, found: Float) -> tuple[Int, Float]:
    """Return the highest lattice points (at most _PEAKS) that no neighbour exceeds: their functions and themselves."""
    i, j = np.rint(points * _STEPS).astype(np.int64).T
    table = np.full((len(found), _STEPS + 3, _STEPS + 3), -np.inf)
    table[:, i + 1, j + 1] = found
    peak: Bool = np.isfinite(found)
    for di, dj in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, -1), (-1, 1)):
        peak &= found >= table[:, i + 1 + di, j + 1 + dj]
    heights = np.where(peak, found, -np.inf)
    order = np.argsort(-heights, axis=1, kind="stable")[:, :_PEAKS]
    owner, rank = np.nonzero(np.take_along_axis(heights, order, axis=1) > -np.inf)
    return owner, points[order[owner, rank]]


def _clipped(at: Float, sides: int) -> Float:
    """Points moved into the domain: onto its nearest side, along the axes or across u + v = 1."""
    if sides == 4:
        return np.clip(at, 0.0, 1.0)
    at = np.clip(at, 0.0, None)
    excess = 0.5 * np.maximum(at[..., 0] + at[..., 1] - 1.0, 0.0)
    u = np.clip(at[..., 0] - excess, 0.0, 1.0)
    v = np.minimum(np.maximum(at[..., 1] - excess, 0.0), 1.0 - u)
    return np.stack([u, v], axis=-1)
