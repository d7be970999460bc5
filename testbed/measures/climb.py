"""The local search for maxima within patches: a pattern search with quadratic models, one evaluation a round.

All candidates advance at once, each by itself. A round evaluates a ring of six points around a centre, and with it the
maxima that the model of the round before predicted; the model is the quadratic through the ring and its centre, which
is the most promising of these predictions. The ring alone makes it a convergent pattern search, the models make it
quick.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.geometry.domain import barycentric, corner_distance
from testbed.geometry.vectors import Bool, Float, Int

#: Domain directions of the search: on a triangle, along its sides, so that the search can follow the boundary.
DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])
#: The search of a candidate ends when its step is below this fraction of the domain.
SMALLEST_STEP = 1e-6
#: A step shrinks to its square, which is the order of the error of a model's maximum, but not beyond these factors.
SHRINK = (1.0 / 16.0, 0.25)
#: It grows by this factor where the best point is as far away as the step, but not beyond this length.
GROWTH = 2.0
LARGEST_STEP = 0.2
#: A gain smaller than this fraction of the value is rounding, and not followed.
LEAST_GAIN = 1e-13


@dataclass(frozen=True)
class Climb:
    """Where N candidates are; the arrays are advanced in place.

    Parameters
    ----------
    at, value
        (N, 2) the best points so far in the domain and (N,) the values there, NaN once one was met.
    radius
        (N,) step lengths.
    proposed, predicted
        (N, 4, 2) points where models have their maxima, and (N, 4) the values there according to the models; -inf where
        there is none.
    """

    at: Float
    value: Float
    radius: Float
    proposed: Float
    predicted: Float

    @classmethod
    def start(cls, at: Float, value: Float, radius: Float) -> "Climb":
        """Start from points with known values."""
        return cls(
            at.copy(), value.copy(), radius.copy(), np.repeat(at[:, None], 4, axis=1), np.full((len(at), 4), -np.inf)
        )

    @property
    def active(self) -> Bool:
        """(N,) true where the search has not ended."""
        moving: Bool = (self.radius > SMALLEST_STEP) & np.isfinite(self.value)
        return moving

    @property
    def promise(self) -> Float:
        """(N,) the values, or what models predict if that is more."""
        most: Float = np.maximum(self.value, self.predicted.max(axis=1))
        return most

    def advance(
        self, rows: Int, values: Callable[[Float], Float], sides: int, margin: float, collapsed: tuple[int, ...] = ()
    ) -> None:
        """Go one round with the candidates ``rows`` (n,).

        Parameters
        ----------
        values
            (n, K) at points (n, K, 2) of these candidates; a NaN there becomes the maximum.
        sides, margin, collapsed
            The domain, and the distance to keep from its corners and from its collapsed sides.
        """
        at, value, radius, each = self.at[rows], self.value[rows], self.radius[rows], np.arange(len(rows))
        candidates = np.concatenate([at[:, None], self.proposed[rows]], axis=1)
        choice = np.argmax(np.concatenate([value[:, None], self.predicted[rows]], axis=1), axis=1)
        centre = candidates[each, choice][:, None]
        ring = move(centre, radius[:, None, None] * ring_steps(centre[:, 0], sides), sides, margin, collapsed)
        proposals = np.isfinite(self.predicted[rows]).any()
        found = values(np.concatenate([ring, self.proposed[rows]], axis=1) if proposals else ring)
        around, tried = found[:, :6], found[:, 6:]
        known = np.concatenate([value[:, None], tried], axis=1)
        points = np.concatenate([candidates[:, : known.shape[1]], ring], axis=1)
        every = np.concatenate([known, around], axis=1)
        best = np.argmax(every, axis=1)
        self.at[rows], self.value[rows] = points[each, best], every[each, best]
        level = known[each, choice]
        proposed, gain = predictions(centre, level, ring, around, radius, sides, margin, collapsed)
        misled = (best == 0) & (choice != 0)
        self.radius[rows] = radius * np.where(
            misled,
            SHRINK[1],
            factors(
                radius,
                np.where(best >= known.shape[1], radius, lengths(points[each, best] - centre[:, 0])),
                np.where(gain.max(axis=1) > 0.0, lengths(proposed[each, gain.argmax(axis=1)] - centre[:, 0]), 0.0),
                self.value[rows] > value + LEAST_GAIN * np.abs(value),
            ),
        )
        # a centre that was predicted to be better, and is not, predicts nothing: the next ring is around the best point
        self.proposed[rows] = proposed
        self.predicted[rows] = np.where(misled[:, None], -np.inf, level[:, None] + gain)


def factors(radius: Float, moved: Float, ahead: Float, gained: Bool) -> Float:
    """Factors (N,) on the steps ``radius`` (N,).

    Parameters
    ----------
    moved, ahead
        (N,) how far the best point is from the centre, and the next one that is predicted.
    gained
        (N,) whether the round found more than before.
    """
    far = gained & (moved >= 0.99 * radius)
    grown = np.clip(LARGEST_STEP / radius, 1.0, GROWTH)
    shrunk = np.clip(np.maximum(radius, ahead / radius), *SHRINK)
    return np.where(far, grown, np.where(gained & (ahead >= 0.99 * radius), 1.0, shrunk))


def lengths(steps: Float) -> Float:
    """Lengths (...) of steps (..., 2): the larger component."""
    longest: Float = np.abs(steps).max(axis=-1)
    return longest


def ring_steps(centre: Float, sides: int) -> Float:
    """Steps (N, 6, 2) of a ring of radius 1 around centres (N, 2).

    On a triangle the step along a side is in proportion to the length of the line through the centre in that direction:
    near a corner the ring is narrow, because functions of the direction from the corner vary as fast there.
    """
    steps = np.broadcast_to(DIRECTIONS, (len(centre), 3, 2))
    if sides == 3:
        u, v = centre[:, 0], centre[:, 1]
        steps = np.stack([1.0 - v, 1.0 - u, u + v], axis=-1)[..., None] * DIRECTIONS
    return np.concatenate([steps, -steps], axis=1)


def predictions(
    centre: Float,
    value: Float,
    ring: Float,
    around: Float,
    limit: Float,
    sides: int,
    margin: float,
    collapsed: tuple[int, ...] = (),
) -> tuple[Float, Float]:
    """Return the maxima (N, 4, 2) of the quadratic and of the parabolas through a ring, and what they gain (N, 4).

    The gain is -inf where there is no maximum; steps longer than ``limit`` (N,) are cut to it, and at the boundary.
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
    steps = steps * np.minimum(1.0, limit[:, None, None] / np.maximum(length, np.finfo(float).tiny))
    moved = move(centre, steps, sides, margin, collapsed)
    with np.errstate(all="ignore"):
        x, y = np.moveaxis(moved[:, 0] - centre[:, 0], -1, 0)
        t = _along(moved[:, 1:] - centre)
        whole = slope[:, 0] * x + slope[:, 1] * y + 0.5 * (bend[:, 0] * x * x + bend[:, 1] * y * y) + mixed * x * y
        gain = np.concatenate([whole[:, None], slope * t + 0.5 * bend * t * t], axis=1)
    return moved, np.where(np.isfinite(gain) & (gain > 0.0), gain, -np.inf)


def _along(steps: Float) -> Float:
    """Signed lengths (N, 3) of steps (N, 3, 2) in units of the three directions."""
    return np.stack([steps[:, 0, 0], steps[:, 1, 1], steps[:, 2, 1]], axis=-1)


def move(centre: Float, step: Float, sides: int, margin: float, collapsed: tuple[int, ...] = ()) -> Float:
    """Return ``centre + step`` (N, K, 2), cut where it leaves the domain or comes within ``margin`` of a corner.

    A step that ends within the margin all the same, because it starts there or crosses into it on a square, is not
    made; nor is one into the margin of a collapsed side.
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
        near: Bool = corner_distance(sides, moved, collapsed) < margin * (1.0 - 1e-9)
        moved = np.where(near[..., None], centre, moved)
    return moved
