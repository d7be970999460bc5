"""Guaranteed maxima of a polynomial over a power of a positive polynomial, by subdivision of its domain.

The quotient is f = a / q^p with p = 2 or 3/2, a and q in the Bernstein form of one degree. On a cell let q be between
q0 > 0 and q1. The power is convex, so that it lies above its tangent t(q) at a point between and, on the cell, below
its chord s(q); both are linear in q, so their Bernstein coefficients follow from those of q without a product. If a_i,
t_i and s_i are the coefficients, then

    f <= max_i max(a_i / t_i, a_i / s_i):

with c the right-hand side, a_i <= c t_i where a_i > 0 and a_i <= c s_i elsewhere; for c >= 0 therefore all
a_i <= c t_i, and a <= c t <= c q^p, while for c < 0 all a_i < 0 and a <= c s <= c q^p. The distance of the bound from
the maximum falls with the square of the size of a cell. A minimum is the maximum of -f.

Rounding is part of the bounds: coefficients are known within an error (see :mod:`testbed.geometry.enclosed_nets`), a
halving averages them and adds one rounding for each of its steps, and quotients are moved outwards by more than their
own roundings.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from testbed.geometry.enclosed_nets import (
    SLACK,
    TINY,
    UNIT,
    Degrees,
    EnclosedNets,
    coefficient_weights,
    exponents,
    gamma,
)
from testbed.geometry.vectors import Float, Int

#: Relative widening of quotients and powers of a few operations: twice what those here can lose.
WIDENED = 32.0 * UNIT
#: Smaller q count as 0: their powers leave the range of floats.
LEAST = 1e-140


@dataclass(frozen=True, eq=False)
class Cells:
    """Pieces of patches of one shape, with a and q over each of them.

    Parameters
    ----------
    nets
        (2, R, C, N) Bernstein coefficients of a and of q; for triangles entry [k, j] (see the modules above), anything
        beyond them.
    degrees
        Of both.
    error, size
        (2, N) bounds on the errors of the coefficients and on their absolute values.
    power
        p.
    """

    nets: Float
    degrees: Degrees
    error: Float
    size: Float
    power: float

    @classmethod
    def whole(cls, numerator: EnclosedNets, square: EnclosedNets, power: float) -> "Cells":
        """Return the patches themselves as cells."""
        both = (numerator, square.elevated(numerator.degrees))
        places = _table_places(numerator.degrees)
        nets = np.zeros((2, *_table_shape(numerator.degrees), numerator.patches))
        for net, one in zip(nets, both, strict=True):
            net[places] = one.coefficients
        return cls(
            nets,
            numerator.degrees,
            np.stack([one.error for one in both]),
            np.stack([one.size for one in both]),
            power,
        )

    def __len__(self) -> int:
        return int(self.nets.shape[-1])

    @classmethod
    def joined(cls, cells: "Sequence[Cells]") -> "Cells":
        """Return the cells of several of the same shape."""
        nets, error, size = (
            np.concatenate([getattr(one, name) for one in cells], axis=-1) for name in ("nets", "error", "size")
        )
        return cls(nets, cells[0].degrees, error, size, cells[0].power)

    def take(self, cells: Int) -> "Cells":
        """Return the chosen cells."""
        return Cells(self.nets[..., cells], self.degrees, self.error[:, cells], self.size[:, cells], self.power)

    def halved(self) -> "Cells":
        """Cut every cell in two: triangles from the newest corner, squares along u and v in turn.

        First halves come first, (2 N,).
        """
        nets = _halved_triangles(self.nets) if len(self.degrees) == 1 else _halved_squares(self.nets)
        # a step of the de Casteljau algorithm at the middle rounds a sum, and its halving is exact
        error = SLACK * (self.error + gamma(max(self.degrees) + 1) * self.size + TINY)
        return Cells(nets, self.degrees[::-1], np.tile(error, 2), np.tile(SLACK * self.size, 2), self.power)

    def corners(self) -> Float:
        """Values of a and q at the corners of the cells, (2, sides, N)."""
        rows, columns = self.nets.shape[1:3]
        places = [(0, 0), (0, columns - 1), (rows - 1, 0), (rows - 1, columns - 1)][: len(self.degrees) + 2]
        return np.stack([self.nets[:, r, c] for r, c in places], axis=1)

    def attained(self) -> tuple[Float, Float]:
        """Lower bounds (2, N) on the largest values of f and of -f at corners, and (N,) the smallest q there.

        -inf where q cannot be told from 0 at any corner.
        """
        numerator, square = self.corners()
        error, of_square = self.error[:, None]
        least = (square - of_square).min(axis=0)
        return np.stack(
            [lower_quotient(sign * numerator, error, square, of_square, self.power).max(axis=0) for sign in (1.0, -1.0)]
        ), least

    def bounds(self) -> tuple[Float, Float]:
        """Upper bounds (2, N) on f and on -f over the cells, inf where q may vanish; and the part that is rounding."""
        error, of_square = self.error
        numerator, square = (net[_table_places(self.degrees)] for net in self.nets)
        low, high = (
            (1.0 - WIDENED) * (square.min(axis=0) - of_square),
            (1.0 + WIDENED) * (square.max(axis=0) + of_square),
        )
        regular = low > LEAST
        low, high = np.where(regular, low, 1.0), np.where(regular, high, 1.0)
        (slope, below), (secant, above) = tangent(low, high, self.power), chord(low, high, self.power)
        widened = WIDENED * powered(high, self.power)
        lowest = slope * square - (below + widened + slope * of_square)
        highest = secant * square + (above + widened + secant * of_square)
        # the tangent, at no more than 3/2 of the least q, is at least half of the power there, but for rounding
        regular &= lowest.min(axis=0) > 0.25 * powered(low, self.power)
        lowest = np.where(regular, lowest, 1.0)
        smallest = np.reciprocal(np.maximum(highest, lowest, out=highest), out=highest)
        largest = np.reciprocal(lowest, out=lowest)
        steepest = largest.max(axis=0)
        found = []
        for sign in (1.0, -1.0):
            value = sign * numerator + error
            found.append(np.maximum((value * largest).max(axis=0), (value * smallest).max(axis=0)))
        raw = np.stack(found)
        bound = np.where(regular, raw + WIDENED * np.abs(raw) + TINY, np.inf)
        rounding = 2.0 * steepest * (error + np.abs(raw) * (widened + slope * of_square)) + WIDENED * np.abs(raw) + TINY
        return bound, np.where(regular, rounding, 0.0)


def powered(q: Float, power: float) -> Float:
    """Return q^p for p = 2 or 3/2, in two roundings whatever the array; a library's powers may depend on its length."""
    return q * q if power == 2.0 else q * np.sqrt(q)


def tangent(low: Float, high: Float, power: float) -> tuple[Float, Float]:
    """Slope and minus the value at 0 of the tangent of q^p at a point of [low, high], positive at ``low``."""
    at = np.minimum(0.5 * (low + high), 1.5 * low)
    slope = power * (at if power == 2.0 else np.sqrt(at))
    return slope, (power - 1.0) * powered(at, power)


def chord(low: Float, high: Float, power: float) -> tuple[Float, Float]:
    """Slope and value at 0 of the chord of q^p over [low, high].

    However much its slope is rounded where they are close, it misses the power by a few roundings of it at most.
    """
    first, last = powered(low, power), powered(high, power)
    slope = np.maximum(last - first, 0.0) / np.maximum(high - low, TINY)
    # never steeper than the tangent at the end: close to each other, the difference is all rounding
    slope = np.minimum(slope, (1.0 + WIDENED) * power * (last / high))
    return slope, first - slope * low


def lower_quotient(numerator: Float, error: Float, square: Float, of_square: Float, power: float) -> Float:
    """Lower bound on a / q^p for a within ``error`` of ``numerator``, q within ``of_square`` of ``square``; or -inf."""
    low, high = (1.0 - WIDENED) * (square - of_square), (1.0 + WIDENED) * (square + of_square)
    regular = low > LEAST
    value = numerator - error
    divisor = np.where(value >= 0.0, high, low)
    divisor = powered(np.where(regular, divisor, 1.0), power)
    with np.errstate(over="ignore", under="ignore"):
        quotient = value / divisor
    return np.where(regular, quotient - WIDENED * np.abs(quotient) - TINY, -np.inf)


def _halved_triangles(nets: Float) -> Float:
    """Halve triangles (2, n, n, N), [k, j], from the middle of side 0 to corner 2, (2, n, n, 2 N).

    The halves have the corners 0, 2 and 1, 2 of the whole, and the middle as their corner 2: the next halving starts
    from it, so that pieces keep to two shapes up to an affine map.
    """
    d = nets.shape[1] - 1
    # a copy: the de Casteljau algorithm along the rows k, each of degree d - k, in place
    level = nets.copy()
    result = np.zeros((*nets.shape[:3], 2, nets.shape[3]))
    k = np.arange(d + 1)
    result[:, 0, :, 1] = level[:, k, d - k]
    for step in range(1, d + 1):
        rows = d + 1 - step
        level[:, :rows, step:] = 0.5 * (level[:, :rows, step - 1 : -1] + level[:, :rows, step:])
        # the last point of each level: `step` of the middle, the others of corner 1 and, in number k, of corner 2
        result[:, step, :rows, 1] = level[:, k[:rows], d - k[:rows]]
    result[:, :, :, 0] = level.swapaxes(1, 2)
    return result.reshape(*nets.shape[:3], -1)


def _halved_squares(nets: Float) -> Float:
    """Halve squares (2, R, C, N) along the rows' parameter, and transpose them, (2, C, R, 2 N)."""
    m = nets.shape[1] - 1
    level = nets.copy()
    result = np.empty((2, nets.shape[2], nets.shape[1], 2, nets.shape[3]))
    result[:, :, m, 1] = level[:, m]
    for step in range(1, m + 1):
        level[:, step:] = 0.5 * (level[:, step - 1 : -1] + level[:, step:])
        result[:, :, m - step, 1] = level[:, m]
    result[:, :, :, 0] = level.swapaxes(1, 2)
    return result.reshape(*result.shape[:3], -1)


@cache
def _table_places(degrees: Degrees) -> tuple[Int, Int]:
    """Rows and columns, (n,) each, of the coefficients in the table of a cell."""
    columns = exponents(degrees)[:, (2, 1) if len(degrees) == 1 else (1, 3)]
    return columns[:, 0], columns[:, 1]


def _table_shape(degrees: Degrees) -> tuple[int, int]:
    return degrees[0] + 1, degrees[-1] + 1


def values_at(net: EnclosedNets, at: Float) -> tuple[Float, Float]:
    """Values (N,) of scalar polynomials, each at its own point (N, 2) of the domain, and bounds on their errors.

    A value is that at a point of the domain, moved there by rounding: barycentric coordinates are taken as they are if
    they are not negative, and homogeneity says what a sum that differs from 1 by rounding does. The error is infinite
    at points that are farther outside.
    """
    at = np.maximum(at, 0.0)
    outside = np.zeros(len(at), dtype=np.bool_)
    if len(net.degrees) == 1:
        coordinates = [np.maximum(1.0 - (at[:, 0] + at[:, 1]), 0.0), at[:, 0], at[:, 1]]
        outside = at[:, 0] + at[:, 1] > 1.0 + 4.0 * UNIT
    else:
        at = np.minimum(at, 1.0)
        coordinates = [1.0 - at[:, 0], at[:, 0], 1.0 - at[:, 1], at[:, 1]]
    basis = np.repeat(coefficient_weights(net.degrees)[:, None], len(at), axis=1)
    for coordinate, exponent in zip(coordinates, exponents(net.degrees).T, strict=True):
        powers = np.cumprod(np.stack([np.ones_like(coordinate)] + [coordinate] * max(net.degrees)), axis=0)
        basis *= powers[exponent]
    value = (basis * net.coefficients).sum(axis=0)
    count = len(basis) + 8 * sum(net.degrees) + 16
    return value, np.where(outside, np.inf, SLACK * (net.error + gamma(count) * net.size + TINY))
