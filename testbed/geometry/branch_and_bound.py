"""Branch and bound over the pieces of many patches at once: maxima of quotients and of their negatives.

A round halves every piece that could still change a maximum by more than the tolerance and bounds the halves; there is
no loop over pieces. Patches belong to groups that share their maxima: each patch by itself, or all of a surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.geometry.quotient_bounds import Cells
from testbed.geometry.vectors import Bool, Float, Int

#: What rounding does to a bound is not made less by cutting: pieces whose gap is no more than this many times that are
#: left alone.
ROUNDING = 4.0


def scaled(values: Float, exponent: Float, outwards: float) -> Float:
    """Multiply bounds by powers of two; what that rounds moves them outwards, up (1.0) or down (-1.0)."""
    with np.errstate(over="ignore", under="ignore"):
        product: Float = np.ldexp(values, np.clip(exponent, -5000, 5000).astype(np.intc))
    # an upper bound that overflows upwards is infinite, but downwards the lowest number
    overflown = np.isfinite(values) & (product == -outwards * np.inf)
    product = np.where(overflown, -outwards * np.finfo(np.float64).max, product)
    return np.where(np.isfinite(product), np.nextafter(product, outwards * np.inf), product)


@dataclass(frozen=True, eq=False)
class Front:
    """Pieces that may be cut.

    Parameters
    ----------
    cells
        N pieces.
    exponent
        (N,) powers of two that scale their quotients.
    group
        (N,) groups that share maxima.
    hopeless
        (N,) true where there is no bound and will be none.
    bound
        (2, N) upper bounds known of f and of -f, inf at first.
    """

    cells: Cells
    exponent: Float
    group: Int
    hopeless: Bool
    bound: Float

    @classmethod
    def of(cls, cells: Cells, exponent: Float, group: Int, hopeless: Bool) -> "Front":
        """Return pieces that nothing is known about yet."""
        return cls(cells, exponent, group, hopeless, np.full((2, len(cells)), np.inf))

    @classmethod
    def joined(cls, fronts: "Sequence[Front]") -> "Front":
        """Return the pieces of several of the same shape."""
        return cls(
            Cells.joined([one.cells for one in fronts]),
            np.concatenate([one.exponent for one in fronts]),
            np.concatenate([one.group for one in fronts]),
            np.concatenate([one.hopeless for one in fronts]),
            np.concatenate([one.bound for one in fronts], axis=1),
        )

    def take(self, some: Int) -> "Front":
        """Return the chosen pieces."""
        return Front(
            self.cells.take(some), self.exponent[some], self.group[some], self.hopeless[some], self.bound[:, some]
        )

    def halved(self) -> "Front":
        """Return the halves of all pieces."""
        return Front(
            self.cells.halved(),
            np.tile(self.exponent, 2),
            np.tile(self.group, 2),
            np.tile(self.hopeless, 2),
            np.tile(self.bound, 2),
        )


@dataclass(frozen=True, eq=False)
class Search:
    """What is known about the maxima of f and of -f in G groups; the arrays are advanced in place.

    Parameters
    ----------
    best
        (2, G) lower bounds: attained values.
    settled
        (2, G) upper bounds over all pieces that are not cut any more.
    tolerance
        Gap aimed at, relative to the largest absolute value known.
    """

    best: Float
    settled: Float
    tolerance: float

    def entered(self, front: Front) -> Front:
        """Bound pieces, and return those that have to be cut; the others are settled."""
        return self._kept(*self._bounded(front), None)

    def run(self, front: Front, rounds: int, cuts: int) -> None:
        """Cut pieces until nothing is left to gain, or for so many rounds and ``cuts`` in all."""
        # when they were bounded, the attained values of others were not all known
        front = self._kept(*self._bounded(front), cuts if rounds else 0)
        for round_ in range(rounds):
            if not len(front.cells):
                return
            cuts -= len(front.cells)
            front = self._kept(*self._bounded(front.halved()), cuts if round_ + 1 < rounds else 0)

    def _bounded(self, front: Front) -> tuple[Front, Float]:
        """Return pieces with their bounds, and what is rounding in these (2, N); notes attained values."""
        attained, least = front.cells.attained()
        bound, rounding = front.cells.bounds()
        attained = scaled(np.where(front.hopeless, -np.inf, attained), front.exponent, -1.0)
        bound = scaled(np.where(front.hopeless, np.inf, bound), front.exponent, 1.0)
        for best, found in zip(self.best, attained, strict=True):
            np.maximum.at(best, front.group, found)
        # next to a point where q cannot be told from 0 no bound will ever be finite
        hopeless = front.hopeless | (least <= 0.0)
        # the bounds of the whole are bounds of its halves
        bound = np.minimum(bound, front.bound)
        return Front(front.cells, front.exponent, front.group, hopeless, bound), scaled(rounding, front.exponent, 1.0)

    def _kept(self, front: Front, rounding: Float, cuts: int | None) -> Front:
        """Return the pieces that are worth cutting, no more than ``cuts``; the others are settled."""
        self._settle(front, front.hopeless)
        gain = np.where(front.hopeless, 0.0, self._gain(front.bound, rounding, front.group))
        worth = gain > 0.0
        if cuts is not None and np.count_nonzero(worth) > cuts:
            worth[np.argsort(-gain, kind="stable")[max(cuts, 0) :]] = False
        self._settle(front, ~worth)
        return front.take(np.flatnonzero(worth))

    def _settle(self, front: Front, some: Bool) -> None:
        for settled, found in zip(self.settled, front.bound, strict=True):
            np.maximum.at(settled, front.group[some], found[some])

    def _gain(self, bound: Float, rounding: Float, group: Int) -> Float:
        """What cutting a piece has to gain (N,), relative to the largest absolute value known; 0 for too little."""
        largest = np.abs(self.best).max(axis=0)
        largest = np.where(np.isfinite(largest), largest, 0.0)[group]
        best, settled = self.best[:, group], self.settled[:, group]
        # an infinite bound, nothing attained, curvature 0: what compares as NaN is not worth cutting
        with np.errstate(invalid="ignore", over="ignore"):
            aim = np.maximum(best + np.maximum(self.tolerance * largest, ROUNDING * rounding), settled)
            gain = (bound - best) / np.maximum(largest, np.finfo(np.float64).tiny)
        worth: Float = np.where(bound > aim, np.nan_to_num(gain, nan=np.inf, posinf=np.inf), 0.0).max(axis=0)
        return worth
