"""Guaranteed bounds of a polynomial and its derivatives over boxes, and what follows: where its zero set can be.

Over a box of centre c and half widths r a polynomial is expanded about c, f(c + t) = sum f_a t^a, so that
|f - f(c)| <= sum |f_a| r^a over the box, likewise for derivatives; the excess over the true range falls with the square
of the box. The rounding of the expansion is bounded a priori and added.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, norm
from testbed_datasets.polynomial import Evaluated, arranged, horner

#: f, f_x, f_y, f_z, f_xx, f_xy, f_xz, f_yy, f_yz, f_zz as orders along the axes.
_ORDERS: Final = (
    *((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    *((2, 0, 0), (1, 1, 0), (1, 0, 1), (0, 2, 0), (0, 1, 1), (0, 0, 2)),
)

#: Numbers that the tables of a block of boxes hold together.
BLOCK: Final = 2_000_000
#: Units in the last place, times the degree, by which an expansion's coefficients are off at most, relative to the same
#: expansion with all signs positive: three axes, a sum and a product a step, and the coefficients' own rounding.
ROUNDING: Final = 16.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Bounds:
    """A polynomial over N boxes: what it is at the centres, and how far it gets from that at most.

    Attributes
    ----------
    value, gradient, hessian
        (N,), (N, 3) and (N, 3, 3) at the centres.
    value_radius, gradient_radius, hessian_radius
        Upper bounds of the moduli of the differences within the boxes, rounding included; of the same shapes.
    """

    value: Float
    gradient: Float
    hessian: Float
    value_radius: Float
    gradient_radius: Float
    hessian_radius: Float

    @property
    def may_vanish(self) -> Bool:
        """(N,) false where the polynomial has no zero in the box."""
        result: Bool = ~(np.abs(self.value) > self.value_radius)
        return result

    @property
    def least_gradient(self) -> Float:
        """Lower bounds (N,) of the gradient's length in the boxes; 0 where it may vanish."""
        by_axis = norm(np.maximum(np.abs(self.gradient) - self.gradient_radius, 0.0))
        return np.maximum(by_axis, norm(self.gradient) - norm(self.gradient_radius))

    @property
    def turn(self) -> Float:
        """Upper bounds (N,) of the sines of the angles of gradients with that at the centre; 1 if unknown."""
        with np.errstate(divide="ignore", invalid="ignore"):  # no gradient at the centre: unknown
            return np.fmin(norm(self.gradient_radius) / norm(self.gradient), 1.0)

    @property
    def curvature(self) -> Float:
        """Upper bounds (N,) of the moduli of level sets' principal curvatures in the boxes; infinite if unknown.

        They are eigenvalues of T H T / |g| with T = I - n n^T. With T and H about their values at the centre,
        |T H T| <= |T_c H_c T_c| + |H - H_c| + 2 s |H_c| + s^2 |H|, where s = |T - T_c| is the sine of the angle by
        which the gradient turns. Or simply |T H T| <= |H|.
        """
        length = norm(self.gradient)
        least = self.least_gradient
        with np.errstate(divide="ignore", invalid="ignore"):  # where the gradient may vanish, which is seen to below
            n = self.gradient / length[:, None]
            turn = self.turn
            tangential = np.eye(3) - n[:, :, None] * n[:, None, :]
            projected = _frobenius(tangential @ self.hessian @ tangential)
            centre, change = _frobenius(self.hessian), _frobenius(self.hessian_radius)
            about = projected + change + 2.0 * turn * centre + turn**2 * (centre + change)
            # a few units in the last place for the operations here
            bound = np.fmin(about, centre + change) / least * (1.0 + 1e-12)
        return np.where((least > 0.0) & np.isfinite(bound), bound, np.inf)


def _frobenius(matrices: Float) -> Float:
    """Frobenius norms (N,) of matrices (N, 3, 3), upper bounds of their spectral norms."""
    length: Float = np.sqrt(np.sum(matrices**2, axis=(1, 2)))
    return length


def bounds(polynomial: Evaluated, low: Float, high: Float) -> Bounds:
    """Return bounds over boxes with corners ``low`` and ``high``, (N, 3); derivatives are those with respect to x.

    The half widths are rounded up; boxes may be points.
    """
    support = Support.of(polynomial)
    rows = max(1, BLOCK // len(support.exponents))
    parts = [
        _of_block(polynomial, support, low[start : start + rows], high[start : start + rows])
        for start in range(0, max(len(low), 1), rows)
    ]
    return Bounds(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _of_block(polynomial: Evaluated, support: "Support", low: Float, high: Float) -> tuple[Float, ...]:
    """Return the columns of :class:`Bounds` for one block of boxes."""
    centre = polynomial.local(0.5 * low + 0.5 * high)
    # local coordinates are off by rounding, relative to the coordinates that were subtracted
    reach = (np.abs(low) + np.abs(high) + np.abs(np.array(polynomial.centre))) / polynomial.scale
    half = 0.5 * (high - low) / polynomial.scale * (1.0 + 1e-15) + 1e-15 * reach
    with np.errstate(over="ignore", invalid="ignore"):  # far boxes: infinite radii, which bound nothing
        table = support.expanded(centre)
        spread, powers = np.abs(table), _powers(half, len(polynomial.coefficients))
        rounding = horner(polynomial.moduli, *(np.abs(centre) + half).T)
        values, radii = [], []
        for order, error in zip(_ORDERS, rounding, strict=True):
            row = np.flatnonzero((support.exponents == order).all(axis=1))
            value = math.prod(map(math.factorial, order)) * table[row].sum(axis=0)  # one row, or none: zero
            reached = np.ones_like(spread)
            for axis, times in enumerate(order):
                reached *= powers[times][axis, support.exponents[:, axis]]
            radius = np.sum(spread * reached, axis=0) - np.abs(value)
            radius += ROUNDING * len(polynomial.coefficients) * error
            values.append(value)
            radii.append(np.where(np.isnan(radius), np.inf, radius))
    return (*arranged(values, polynomial.scale), *arranged(radii, polynomial.scale))


def _powers(half: Float, size: int) -> tuple[Float, Float, Float]:
    """The powers r^k of (N, 3) numbers and their first two derivatives, (3, size, N) each."""
    k = np.arange(size)[:, None]
    power = half.T[:, None, :] ** k
    lower = np.concatenate([np.zeros((3, 2, len(half))), power], axis=1)
    return power, k * lower[:, 1:-1], k * (k - 1) * lower[:, :-2]


@dataclass(frozen=True)
class Support:
    """The powers that a polynomial has about any centre: those that divide one of its own.

    Attributes
    ----------
    exponents
        (M, 3).
    coefficients
        (M,).
    following
        Axis by axis, from the highest power down: rows of ``exponents`` with that power along the axis, and the rows
        with the next.
    """

    exponents: Int
    coefficients: Float
    following: tuple[tuple[tuple[Int, Int], ...], ...]

    @classmethod
    def of(cls, polynomial: Evaluated) -> "Support":
        """Return the powers of a polynomial."""
        divides = polynomial.coefficients != 0.0
        for axis in range(3):
            divides = np.flip(np.logical_or.accumulate(np.flip(divides, axis), axis=axis), axis)
        exponents = np.argwhere(divides)
        row = np.full(np.add(divides.shape, 1), -1)
        row[tuple(exponents.T)] = np.arange(len(exponents))
        following = []
        for axis in range(3):
            after = row[tuple((exponents + np.eye(3, dtype=np.int64)[axis]).T)]
            pairs = []
            for power in range(len(divides) - 2, -1, -1):
                here = np.flatnonzero((exponents[:, axis] == power) & (after >= 0))
                pairs.append((here, after[here]))
            following.append(tuple(pairs))
        return cls(exponents, polynomial.coefficients[divides], tuple(following))

    def expanded(self, centre: Float) -> Float:
        """Coefficients (M, N) of the polynomial about centres (N, 3), by repeated synthetic division."""
        table = np.repeat(self.coefficients[:, None], len(centre), axis=1)
        for axis, pairs in enumerate(self.following):
            # after the first pass the lowest power is final, and so on
            for last in range(len(pairs), 0, -1):
                for here, after in pairs[:last]:
                    if len(here):
                        table[here] += centre[:, axis] * table[after]
        return table
