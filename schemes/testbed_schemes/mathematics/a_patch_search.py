"""Suprema of functions over triangles and squares, many at once: a lattice, then windows that close in on its peaks.

The functions need not be continuous, and may be -inf where nothing is asked of them: those of the bounds of A-patches
(Xu, Huang and Bajaj 2001, step 6) jump down where two extremes of a shooting polynomial cancel, and fall to -inf
towards the vertices. Suprema on sides and corners are met exactly, since lattice and windows have points there. The
lattice is denser towards sides and corners, where thin parts of the domain can be all that counts.

The result is a value that the function takes, up to rounding: never above the supremum. It is a search, not a proof:
a peak narrower than the lattice's steps can be missed.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Bool, Float, Int

#: Values (n, S) of functions ``rows`` (n,) at their own points (n, S, 2).
Values = Callable[[Int, Float], Float]

# Steps of the first lattice along a side, how its coordinates are bent towards the sides, and peaks that are followed.
_STEPS, _BEND, _PEAKS = 24, 1.5, 4
# Functions at a time: a few thousand values of each kind stay in the cache.
_ROWS = 256
# A search ends when halving the window promises less than this part of the function's scale, or at this half width.
_ACCURACY, _NARROWEST = 1e-11, 2.0**-36
# Rounds at most: halvings, and moves of windows whose peak was at the rim.
_ROUNDS = 120
# Offsets of a window's points, the centre in the middle.
_WINDOW = np.stack(np.meshgrid(np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 5), indexing="ij"), axis=-1).reshape(
    -1, 2
)
_NEIGHBOURS = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, -1), (-1, 1))


def suprema(values: Values, scale: Float, sides: int) -> Float:
    """Return the suprema (N,) of N functions over the triangle or the square.

    Parameters
    ----------
    values
        The functions. A value of one function must not depend on what is computed along with it.
    scale
        (N,) magnitude of each function; a search ends when it promises no more than 1e-11 of that.
    sides
        3: the triangle u, v >= 0, u + v <= 1; 4: the square [0, 1]^2.

    Returns
    -------
    Float
        (N,): -inf where a function is that everywhere, NaN where one of its values met is.
    """
    result = np.empty(len(scale))
    for start in range(0, len(scale), _ROWS):
        rows = np.arange(start, min(start + _ROWS, len(scale)))
        result[rows] = _search(values, scale[rows], rows, sides)
    return result


def _search(values: Values, scale: Float, rows: Int, sides: int) -> Float:
    """Suprema of some of the functions."""
    points, spacing = _bent_lattice(sides)
    found = values(rows, np.broadcast_to(points, (len(rows), *points.shape)))
    best: Float = found.max(axis=1)
    owner, place = _peaks(found, sides)
    at, width, high = points[place], spacing[place], found[owner, place]
    promise = scale[owner]
    for _ in range(_ROUNDS):
        if not len(owner):
            break
        around = _clipped(at[:, None] + width[:, None, None] * _WINDOW, sides)
        there = values(rows[owner], around)
        each, place = np.arange(len(owner)), there.argmax(axis=1)
        top, peak = there[each, place], around[each, place]
        better = ~(top <= high)  # NaN is taken, and stays
        # a peak at the window's rim may lie outside: followed before closing in
        at_rim = better & (np.abs(peak - at) > 0.75 * width[:, None]).any(axis=1)
        # halving the window divides what it can gain by four; by more than five in two of three rounds is luck
        promise = np.maximum(np.where(better, top - high, 0.0), promise / 5.0)
        at, high = np.where(better[:, None], peak, at), np.where(better, top, high)
        width = np.where(at_rim, width, 0.5 * width)
        with np.errstate(invalid="ignore"):  # NaN stays
            np.maximum.at(best, owner, high)
        done = (promise <= _ACCURACY * scale[owner]) | (width < _NARROWEST) | (high + 8.0 * promise < best[owner])
        going = ~done
        owner, at, high, width, promise = owner[going], at[going], high[going], width[going], promise[going]
    return best


@cache
def _bent_lattice(sides: int) -> tuple[Float, Float]:
    """Points (S, 2) of the first lattice, and (S,) how far the farthest neighbour is; read-only."""
    at = lattice(sides, _STEPS)
    if sides == 3:
        weights = np.column_stack([1.0 - at.sum(axis=1), at]).clip(0.0) ** _BEND
        points = weights[:, 1:] / weights.sum(axis=1, keepdims=True)
    else:
        points = at**_BEND / (at**_BEND + (1.0 - at) ** _BEND)
    i, j = np.rint(at * _STEPS).astype(np.int64).T
    table = np.full((_STEPS + 3, _STEPS + 3, 2), np.nan)
    table[i + 1, j + 1] = points
    steps = [np.abs(table[i + 1 + di, j + 1 + dj] - points).max(axis=1) for di, dj in _NEIGHBOURS]
    spacing = np.nan_to_num(np.stack(steps)).max(axis=0)
    points.flags.writeable = spacing.flags.writeable = False
    return points, spacing


def _peaks(found: Float, sides: int) -> tuple[Int, Int]:
    """Return the highest lattice points (at most _PEAKS) that no neighbour exceeds: their functions and places."""
    i, j = np.rint(lattice(sides, _STEPS) * _STEPS).astype(np.int64).T
    table = np.full((len(found), _STEPS + 3, _STEPS + 3), -np.inf)
    table[:, i + 1, j + 1] = found
    peak: Bool = np.isfinite(found)
    for di, dj in _NEIGHBOURS:
        peak &= found >= table[:, i + 1 + di, j + 1 + dj]
    heights = np.where(peak, found, -np.inf)
    order = np.argsort(-heights, axis=1, kind="stable")[:, :_PEAKS]
    owner, rank = np.nonzero(np.take_along_axis(heights, order, axis=1) > -np.inf)
    return owner, order[owner, rank]


def _clipped(at: Float, sides: int) -> Float:
    """Points moved into the domain: along the axes, and across u + v = 1."""
    if sides == 4:
        return np.clip(at, 0.0, 1.0)
    at = np.clip(at, 0.0, None)
    excess = 0.5 * np.maximum(at[..., 0] + at[..., 1] - 1.0, 0.0)
    u = np.clip(at[..., 0] - excess, 0.0, 1.0)
    v = np.minimum(np.maximum(at[..., 1] - excess, 0.0), 1.0 - u)
    return np.stack([u, v], axis=-1)
