"""Polynomials in x, y and z: values, derivatives and Taylor expansions at many points at once."""

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.geometry.vectors import Float, Int


@dataclass(frozen=True)
class Trivariate:
    """A polynomial in x, y and z.

    Parameters
    ----------
    terms
        Exponents (i, j, k) of x, y, z and the coefficient of each monomial; no exponents twice.
    """

    terms: tuple[tuple[tuple[int, int, int], float], ...]

    @cached_property
    def degree(self) -> int:
        """Total degree; 0 without terms."""
        return max((sum(exponents) for exponents, _ in self.terms), default=0)

    @cached_property
    def exponents(self) -> Int:
        """Exponents (T, 3) of all monomials that divide one of the polynomial's, by total degree, then falling."""
        found = {(0, 0, 0)}
        for (i, j, k), _ in self.terms:
            found.update(itertools.product(range(i + 1), range(j + 1), range(k + 1)))
        ordered = sorted(found, key=lambda e: (sum(e), tuple(-part for part in e)))
        array = np.array(ordered, dtype=np.int64)
        array.flags.writeable = False
        return array

    @cached_property
    def _table(self) -> Float:
        """Factors of y^b (row b) in the coefficients of d^a (column a) in g(y + d): c_(a + b) times a + b over a."""
        place = {tuple(exponents): row for row, exponents in enumerate(self.exponents.tolist())}
        table = np.zeros((len(place), len(place)))
        for exponents, coefficient in self.terms:
            for part in itertools.product(*(range(e + 1) for e in exponents)):
                rest = tuple(e - p for e, p in zip(exponents, part, strict=True))
                factor = math.prod(math.comb(e, p) for e, p in zip(exponents, part, strict=True))
                table[place[rest], place[part]] = coefficient * factor
        return table

    def monomials(self, points: Float) -> Float:
        """Values (T, N) of the monomials of ``exponents`` at points (N, 3)."""
        powers = np.ones((int(self.exponents.max()) + 1, 3, len(points)))
        for e in range(1, len(powers)):
            powers[e] = powers[e - 1] * points.T
        i, j, k = self.exponents.T
        values: Float = powers[i, 0] * powers[j, 1] * powers[k, 2]
        return values

    def expansion(self, points: Float) -> Float:
        """Taylor coefficients (T, N) of the powers ``exponents`` of d in g(y + d), at points y (N, 3)."""
        monomials = self.monomials(points)
        coefficients = np.zeros_like(monomials)
        # term after term, so that the bits do not depend on how many points there are
        for factors, values in zip(self._table, monomials, strict=True):
            (present,) = np.nonzero(factors)
            coefficients[present] += factors[present, None] * values
        return coefficients

    def magnitudes(self, points: Float) -> tuple[Float, Float]:
        """Return sums of moduli at points (N, 3), to which rounding is in proportion.

        Of the terms (N,), and of those of the derivatives along x, y and z, (N, 3).
        """
        monomials = self.monomials(np.abs(points))
        place = {tuple(power): row for row, power in enumerate(self.exponents.tolist())}
        columns = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        sums = np.zeros((4, len(points)))
        for index, column in enumerate(columns):
            if column in place:
                factors = np.abs(self._table[:, place[column]])
                for row in np.flatnonzero(factors):
                    sums[index] += factors[row] * monomials[row]
        return sums[0], sums[1:].T

    def hessian_magnitude(self, points: Float) -> Float:
        """Return a bound (N,) of the sums of moduli of the terms of all second derivatives at points (N, 3)."""
        monomials = self.monomials(np.abs(points))
        second = self.exponents.sum(axis=1) == 2
        factors = 2.0 * np.abs(self._table[:, second]).sum(axis=1)
        total = np.zeros(len(points))
        for row in np.flatnonzero(factors):
            total += factors[row] * monomials[row]
        return total
