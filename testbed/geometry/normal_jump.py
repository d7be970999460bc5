"""The largest angle between the normals of two patches along their edges, exactly and enclosed.

Normals along a side are polynomials (:mod:`testbed.geometry.normal_fields`). The largest angle is at an end or where it
is stationary: at a root of a polynomial (:mod:`testbed.geometry.normal_pairs`), all of which are found.

The enclosure does not rest on roots. The edge is cut at the place found; on an interval tan^2 = <V, V> / N^2 is at
most the largest ratio of their Bernstein coefficients, which is sharp where the interval begins at the maximum.
Intervals are halved until the bound is within :data:`GAP` of the angle found. Bounds contain a bound of all rounding
since the control points, which are taken as exact.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.normal_pairs import HALF_TURN, ROUNDING, SLACK, NormalPairs, merit
from testbed.geometry.polynomials import divide, multiply, multiply_dot
from testbed.geometry.vectors import Bool, Float, norm

#: The upper bound is at most so much larger than the angle found, relatively, where rounding allows it.
GAP = 1e-9
#: Halvings after which an interval's bound is taken as it is.
HALVINGS = 12
#: Intervals of an edge halved at the same time; of an edge with more, where a normal all but vanishes, the bounds are
#: taken as they are.
INTERVALS = 40
#: Edges whose enclosures are wider than this, relatively and absolutely, are divided: normals that are much shorter on
#: one part of an edge than on another lose digits there that they have on a part of its own.
WIDE = (1e-6, 1e-9)
#: Most divisions of an edge.
DIVISIONS = 12


@dataclass(frozen=True, eq=False)
class NormalJumps:
    """Largest angles between normals along E edges, radians; NaN where a normal vanishes or is not finite.

    Parameters
    ----------
    angle, t
        (E,) the largest angle and where it is; right to rounding, unless that leaves the bounds far apart: then the
        largest that is certain.
    low, high
        (E,) guaranteed bounds of the largest angle: what is attained at ``t`` less its rounding, and an upper bound.
    settled
        (E,) false where the search ended because the angle cannot be above the floor; ``angle`` may be too small then.
    """

    angle: Float
    t: Float
    low: Float
    high: Float
    settled: Bool


def normal_jumps(
    pairs: NormalPairs, floor: Float | float = 0.0, gap: float = GAP, divisions: int = DIVISIONS
) -> NormalJumps:
    """Find and enclose the largest angle along each edge.

    Parameters
    ----------
    pairs
        E edges.
    floor
        Angles up to this, for all edges or (E,), are of no interest: an edge whose angle cannot be larger may have less
        than its largest for ``angle``; ``low`` and ``high`` hold all the same.
    gap
        Largest relative width of the enclosure, where rounding allows it.
    divisions
        How many times an edge may be divided where its polynomials are too uneven for that.
    """
    floor = np.broadcast_to(floor, len(pairs))
    angle, t, rounding = pairs.sampled()
    angle = np.where(pairs.regular, angle, np.nan)
    high = pairs.first_bound()
    # false for NaN. Patches that join smoothly end here: where all is rounding, a root is anywhere
    undecided = high > angle + 2.0 * rounding
    (rows,) = np.nonzero(undecided & (high > floor))
    if len(rows):
        chosen = pairs[rows]
        found = solved(chosen, angle[rows], t[rows], rounding[rows])
        high[rows] = np.minimum(high[rows], enclosed(chosen, *found, floor[rows], gap))
        angle[rows], t[rows], rounding[rows] = found
        undecided[rows] = False
    low, high = np.maximum(angle - rounding, 0.0), np.where(np.isnan(angle), np.nan, np.maximum(high, angle))
    (uneven,) = np.nonzero(too_wide(low, high, floor))
    if divisions and len(uneven):
        parts = normal_jumps(pairs[uneven].halves(), np.tile(np.maximum(low, floor)[uneven], 2), gap, divisions - 1)
        for half in (0, 1):
            some = slice(half * len(uneven), (half + 1) * len(uneven))
            # what is certain decides; NaN is larger than all
            better = ~(parts.low[some] <= low[uneven])
            angle[uneven] = np.where(better, parts.angle[some], angle[uneven])
            t[uneven] = np.where(better, 0.5 * (half + parts.t[some]), t[uneven])
            low[uneven] = np.where(better, parts.low[some], low[uneven])
        # the smaller of both bounds: those of the halves, and that of the whole
        highest = parts.high.reshape(2, -1).max(axis=0)
        high[uneven] = np.minimum(high[uneven], np.maximum(highest, angle[uneven]))
    return NormalJumps(angle, t, low, high, ~undecided)


def too_wide(low: Float, high: Float, floor: Float | float = 0.0) -> Bool:
    """(E,) true where bounds are so far apart that the edge should be divided."""
    return np.asarray(high > np.maximum(low, floor) * (1.0 + WIDE[0]) + WIDE[1])


def solved(pairs: NormalPairs, angle: Float, t: Float, rounding: Float) -> tuple[Float, Float, Float]:
    """Return the largest angles (E,), their places (E,) and rounding (E,), from those given and the stationary ones."""
    row, place = pairs.stationary_places()
    value, error = pairs.angles(place, row)
    row = np.concatenate([np.arange(len(pairs)), row])
    columns = [np.concatenate(both) for both in ((angle, value), (t, place), (rounding, error))]
    # by row; the largest last, NaN for the largest; of equal ones the first place
    order = np.lexsort((-columns[1], merit(columns[0], columns[2]), row))
    last = order[np.searchsorted(row[order], np.arange(len(pairs)), side="right") - 1]
    value, place, error = (column[last] for column in columns)
    return value, place, error


def enclosed(
    pairs: NormalPairs, angle: Float, t: Float, rounding: Float, floor: Float | float = 0.0, gap: float = GAP
) -> Float:
    """Guaranteed upper bounds (E,) of the angles, from angles (E,) that are attained at (E,) but for rounding (E,)."""
    count, degree = len(pairs), len(pairs.cosine) - 1
    lengths = norm(np.moveaxis(pairs.sine, 1, -1)).max(axis=0), np.abs(pairs.cosine).max(axis=0)
    # errors of N, V^2 and N^2: first those of their coefficients, then those of each division
    errors = [pairs.error, *((2.0 * x + pairs.error) * pairs.error + _roundings(degree) * x * x for x in lengths)]
    growth = [6.0 * degree * ROUNDING * x for x in (lengths[1], lengths[0] ** 2, lengths[1] ** 2)]
    target = np.maximum(angle, floor) * (1.0 + gap) + rounding
    row = np.tile(np.arange(count), 2)
    high = angle.copy()
    forms = [pairs.cosine, multiply_dot(pairs.sine, pairs.sine), multiply(pairs.cosine, pairs.cosine)]
    at: Float | float = t
    for halving in range(HALVINGS + 1):
        forms = [np.concatenate(divide(form, at), axis=1) for form in forms]
        if halving == 0:
            # no interval before the beginning, none after the end
            (some,) = np.nonzero(np.concatenate([t > 0.0, t < 1.0]))
            row, forms = row[some], [form[:, some] for form in forms]
        # rounding does not shrink with the interval: it decides nothing, but stays in the bound
        errors = [error + more for error, more in zip(errors, growth, strict=True)]
        unsettled = _bounds(forms, [np.zeros(len(row))] * 3) > target[row]
        crowded = np.bincount(row[unsettled], minlength=count) > INTERVALS
        unsettled &= ~crowded[row] & (halving < HALVINGS)
        (done,) = np.nonzero(~unsettled)
        ended = _bounds([form[:, done] for form in forms], [error[row[done]] for error in errors])
        np.maximum.at(high, row[done], ended)
        (some,) = np.nonzero(unsettled)
        if not len(some):
            break
        row, forms, at = np.tile(row[some], 2), [form[:, some] for form in forms], 0.5
    return high


def _roundings(degree: int) -> float:
    """Bound of the rounding in products of polynomials of a degree, over the product of their largest coefficients."""
    return 8.0 * (degree + 8.0) * ROUNDING


def _bounds(forms: list[Float], errors: list[Float]) -> Float:
    """Upper bounds (R,) of the angle on R intervals: coefficients (k, R) of N, V^2, N^2, and their errors (R,)."""
    cosine, sine_squared, cosine_squared = forms
    least, most = cosine.min(axis=0, initial=np.inf) - errors[0], cosine.max(axis=0, initial=-np.inf) + errors[0]
    # between: N may vanish or change its sign, and the smallest V and N make the largest angle
    shortest = np.sqrt(np.maximum(sine_squared.min(axis=0, initial=np.inf) - errors[1], 0.0))
    bound = np.arctan2(shortest, np.minimum(least, -np.finfo(np.float64).tiny))
    (acute,), (obtuse,) = np.nonzero(least > 0.0), np.nonzero(most < 0.0)
    below = cosine_squared[:, acute] - errors[2][acute]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = ((sine_squared[:, acute] + errors[1][acute]) / below).max(axis=0, initial=0.0)
    bound[acute] = np.arctan(np.sqrt(np.where((below > 0.0).all(axis=0), ratio, np.inf)))
    above = cosine_squared[:, obtuse] + errors[2][obtuse]
    ratio = (np.maximum(sine_squared[:, obtuse] - errors[1][obtuse], 0.0) / above).min(axis=0, initial=np.inf)
    bound[obtuse] = np.pi - np.arctan(np.sqrt(ratio))
    return np.asarray(np.minimum(bound * (1.0 + SLACK), HALF_TURN))
