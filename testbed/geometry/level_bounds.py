"""Level sets with enclosures: Taylor expansions of g with bounds of what they leave out, for guaranteed distances."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from testbed.geometry.exact import LevelSet
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Float, Int, norm

EPSILON = float(np.finfo(np.float64).eps)


class Expansion(ABC):
    """Taylor polynomials of a function g about N points, and bounds of the rest.

    Attributes
    ----------
    exponents
        (T, 3) powers of the offsets d, by total degree, with every divisor of each; (0, 0, 0) first.
    coefficients
        (T, N) their coefficients.
    operations
        Roundings that a coefficient goes through, at most.
    """

    exponents: Int
    coefficients: Float
    operations: int

    @abstractmethod
    def remainder(self, radii: Float) -> Float:
        """Bounds (N,) of what g and its Taylor polynomial differ by where |d_i| <= radii (N, 3)."""

    @abstractmethod
    def gradient_remainder(self, radii: Float) -> Float:
        """Bounds (N,) of the length of grad g(y + d) - grad g(y) - H(y) d where |d_i| <= radii (N, 3)."""

    @abstractmethod
    def magnitudes(self, radii: Float) -> tuple[Float, Float]:
        """Sizes (N,), (N,) of the terms of g and grad g there: rounding is in proportion to them."""

    @cached_property
    def order(self) -> int:
        """Order of the Taylor polynomials."""
        return int(self.exponents.sum(axis=1).max())

    @cached_property
    def gradient(self) -> Float:
        """Gradients of g at the points, (N, 3)."""
        return self._derivatives(np.eye(3, dtype=np.int64)).T

    @cached_property
    def hessian(self) -> Float:
        """Second derivatives of g at the points, (N, 3, 3)."""
        unit_powers = np.eye(3, dtype=np.int64)
        pairs = (unit_powers[:, None] + unit_powers).reshape(9, 3)
        values = self._derivatives(pairs) * np.where(np.eye(3, dtype=np.bool_), 2.0, 1.0).reshape(9, 1)
        return np.ascontiguousarray(values.T).reshape(-1, 3, 3)

    def _derivatives(self, powers: Int) -> Float:
        """Coefficients (k, N) of powers (k, 3), zero for those that are not there."""
        place = {tuple(one): row for row, one in enumerate(self.exponents.tolist())}
        rows = [place.get(tuple(one)) for one in powers.tolist()]
        zero = np.zeros(self.coefficients.shape[1])
        return np.stack([zero if row is None else self.coefficients[row] for row in rows])


class EnclosedLevelSet(LevelSet):
    """A level set whose function can be expanded with bounds of the rest, so that distances can be guaranteed.

    Attributes
    ----------
    steepness
        A number that |grad g| is nowhere less than; 0 where it may vanish.
    nearest
        Whether ``closest`` returns nearest points of the whole surface, however far away.
    """

    steepness: ClassVar[float] = 0.0
    nearest: ClassVar[bool] = False

    @abstractmethod
    def expansion(self, points: Float, order: int) -> Expansion:
        """Expand g about points (N, 3), to an order of at most ``order`` >= 2."""


@dataclass(frozen=True, eq=False)
class PolynomialExpansion(Expansion):
    """Taylor polynomials of a polynomial: the terms left out are known, and their moduli bound the rest.

    Parameters
    ----------
    polynomial
        g.
    points
        (N, 3).
    exponents, coefficients
        Of the terms up to the order asked for.
    higher_exponents, higher
        (S, 3) and (S, N), moduli of the coefficients, of those above order 2.
    first_left_out
        How many of these belong to the Taylor polynomial.
    """

    polynomial: Trivariate
    points: Float
    exponents: Int
    coefficients: Float
    higher_exponents: Int
    higher: Float
    first_left_out: int

    @property
    def operations(self) -> int:  # type: ignore[override]
        """Terms of the sum that a coefficient is, and factors of a term."""
        return len(self.polynomial.exponents) + self.polynomial.degree + 4

    def remainder(self, radii: Float) -> Float:
        """Sum of the moduli of the terms left out."""
        of = powers(radii, self.polynomial.degree)
        total = np.zeros(len(radii))
        left_out = slice(self.first_left_out, None)
        for (i, j, k), size in zip(self.higher_exponents[left_out].tolist(), self.higher[left_out], strict=True):
            total += size * of[i, 0] * of[j, 1] * of[k, 2]
        return total

    def gradient_remainder(self, radii: Float) -> Float:
        """Length of the vector of the bounds of its components."""
        of = powers(radii, self.polynomial.degree)
        x, y, z = np.zeros((3, len(radii)))
        for (i, j, k), size in zip(self.higher_exponents.tolist(), self.higher, strict=True):
            if i:
                x += i * size * of[i - 1, 0] * of[j, 1] * of[k, 2]
            if j:
                y += j * size * of[i, 0] * of[j - 1, 1] * of[k, 2]
            if k:
                z += k * size * of[i, 0] * of[j, 1] * of[k - 1, 2]
        length: Float = np.sqrt(x * x + y * y + z * z)
        return length

    def hessian_remainder(self, radii: Float) -> Float:
        """Bounds (N,) of the norm of H(y + d) - H(y) where |d_i| <= radii (N, 3)."""
        of = powers(radii, self.polynomial.degree)
        squares = np.zeros((3, 3, len(radii)))
        for a, b in np.ndindex(3, 3):
            for power, size in zip(self.higher_exponents, self.higher, strict=True):
                rest = power.copy()
                rest[a] -= 1
                rest[b] -= 1
                if (rest >= 0).all():
                    factor = power[a] * (power[b] - (a == b))
                    squares[a, b] += factor * size * of[rest[0], 0] * of[rest[1], 1] * of[rest[2], 2]
        frobenius: Float = np.sqrt((squares**2).sum(axis=(0, 1)))
        return frobenius

    def magnitudes(self, radii: Float) -> tuple[Float, Float]:
        """Sums of the moduli of the terms where they are largest."""
        value, gradient = self.polynomial.magnitudes(np.abs(self.points) + radii)
        return value, norm(gradient)


def powers(values: Float, highest: int) -> Float:
    """Powers 0 to ``highest`` of values (N, k), (highest + 1, k, N)."""
    result = np.ones((highest + 1, values.shape[1], len(values)))
    for e in range(1, highest + 1):
        result[e] = result[e - 1] * values.T
    return result


class PolynomialLevelSet(EnclosedLevelSet):
    """The zero set of a polynomial in x, y and z whose gradient points to the side of the normal."""

    @property
    @abstractmethod
    def polynomial(self) -> Trivariate:
        """The polynomial g."""

    def expansion(self, points: Float, order: int) -> PolynomialExpansion:
        """Expand g about points (N, 3); the whole of g if its degree is not above ``order``."""
        polynomial = self.polynomial
        exponents, coefficients = polynomial.exponents, polynomial.expansion(points)
        degrees = exponents.sum(axis=1)
        taken, quadratic = int(np.searchsorted(degrees, order, "right")), int(np.searchsorted(degrees, 2, "right"))
        return PolynomialExpansion(
            polynomial,
            points,
            exponents[:taken],
            coefficients[:taken],
            exponents[quadratic:],
            np.abs(coefficients[quadratic:]),
            taken - quadratic,
        )

    def gradient(self, points: Float) -> Float:
        """Gradients of g, (N, 3) at points (N, 3)."""
        return self.expansion(points, 2).gradient

    def hessian(self, points: Float) -> Float:
        """Second derivatives of g, (N, 3, 3) at points (N, 3)."""
        return self.expansion(points, 2).hessian

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the principal curvatures' moduli within boxes with corners (N, 3).

        Infinite for boxes too large for the expansion about their centres. The curvatures are eigenvalues of
        P H P / |grad g|, so |H| / |grad g| bounds them; H from its expansion about the box's centre, |grad g| likewise,
        or the surface's ``steepness``.
        """
        centre = 0.5 * (low + high)
        radii = np.maximum(high - centre, centre - low) + 4.0 * EPSILON * np.maximum(np.abs(low), np.abs(high))
        about = self.expansion(centre, 2)
        assert isinstance(about, PolynomialExpansion)  # noqa: S101 - see expansion
        reach = norm(radii)
        hessian = np.abs(np.linalg.eigvalsh(about.hessian)).max(axis=1)
        rounding = 4.0 * about.operations * EPSILON
        farthest = np.abs(centre) + radii
        largest = hessian + about.hessian_remainder(radii) + rounding * self.polynomial.hessian_magnitude(farthest)
        steep = norm(about.gradient) - largest * reach - rounding * norm(self.polynomial.magnitudes(farthest)[1])
        steep = np.maximum(steep * (1.0 - 1e-12), self.steepness)
        with np.errstate(divide="ignore", invalid="ignore"):
            bound: Float = np.where(steep > 0.0, largest / steep * (1.0 + 1e-12), np.inf)
        return bound
