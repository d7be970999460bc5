"""Polynomials in x, y, z: exact coefficients, and values with two derivatives in floating point."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

import numpy as np

from testbed.geometry.vectors import Float

#: Exponents of x, y and z.
Exponents: TypeAlias = tuple[int, int, int]
#: ``rows[i][j][k]`` is the coefficient of x^i y^j z^k; rows may be ragged.
Rows: TypeAlias = tuple[tuple[tuple[float, ...], ...], ...]
#: Points evaluated at once, so that all that belongs to them stays in the processor's cache.
CHUNK = 4096


@dataclass(frozen=True)
class Polynomial:
    """A polynomial with rational coefficients.

    Parameters
    ----------
    terms
        Exponents and coefficients, sorted by exponents, none of them zero; see :meth:`of`.
    """

    terms: tuple[tuple[Exponents, Fraction], ...] = ()

    @classmethod
    def of(cls, coefficients: Mapping[Exponents, Fraction]) -> "Polynomial":
        """Return the polynomial with these coefficients; zeros are left out."""
        return cls(tuple(sorted((powers, value) for powers, value in coefficients.items() if value)))

    @classmethod
    def constant(cls, value: Fraction | int) -> "Polynomial":
        """Return a constant polynomial."""
        return cls.of({(0, 0, 0): Fraction(value)})

    @classmethod
    def variable(cls, axis: int) -> "Polynomial":
        """Return x, y or z, for axis 0, 1 or 2."""
        return cls.of({(int(axis == 0), int(axis == 1), int(axis == 2)): Fraction(1)})

    @property
    def degree(self) -> int:
        """Total degree; 0 for the zero polynomial too."""
        return max((sum(powers) for powers, _ in self.terms), default=0)

    def __add__(self, other: "Polynomial") -> "Polynomial":
        total = dict(self.terms)
        for powers, value in other.terms:
            total[powers] = total.get(powers, Fraction(0)) + value
        return Polynomial.of(total)

    def __mul__(self, other: "Polynomial") -> "Polynomial":
        product: dict[Exponents, Fraction] = {}
        for (i, j, k), value in self.terms:
            for (a, b, c), by in other.terms:
                powers = (i + a, j + b, k + c)
                product[powers] = product.get(powers, Fraction(0)) + value * by
        return Polynomial.of(product)

    def __neg__(self) -> "Polynomial":
        return self * Polynomial.constant(-1)

    def __call__(self, x: Fraction, y: Fraction, z: Fraction) -> Fraction:
        """Exact value at a rational point."""
        return sum((value * x**i * y**j * z**k for (i, j, k), value in self.terms), Fraction(0))

    def derivative(self, axis: int) -> "Polynomial":
        """Return the derivative with respect to x, y or z, for axis 0, 1 or 2."""
        lower = [tuple(power - (at == axis) for at, power in enumerate(powers)) for powers, _ in self.terms]
        return Polynomial.of(
            {(i, j, k): value * powers[axis] for (i, j, k), (powers, value) in zip(lower, self.terms, strict=True)}
        )

    def about(self, centre: tuple[Fraction, Fraction, Fraction], scale: Fraction) -> "Polynomial":
        """Return the polynomial Q with Q(t) = P(centre + scale t), exactly."""
        current = dict(self.terms)
        for axis in range(3):
            shifted: dict[Exponents, Fraction] = {}
            for powers, value in current.items():
                n = powers[axis]
                for m in range(n + 1):
                    others = list(powers)
                    others[axis] = m
                    key = (others[0], others[1], others[2])
                    part = value * math.comb(n, m) * centre[axis] ** (n - m) * scale**m
                    shifted[key] = shifted.get(key, Fraction(0)) + part
            current = shifted
        return Polynomial.of(current)


@dataclass(frozen=True)
class PolynomialJet:
    """Values and derivatives at N points.

    Attributes
    ----------
    value
        (N,).
    gradient
        (N, 3).
    hessian
        (N, 3, 3).
    """

    value: Float
    gradient: Float
    hessian: Float


@dataclass(frozen=True)
class Evaluated:
    """A polynomial evaluated in floating point in coordinates t = (x - centre) / scale, |t| about 1 where it matters.

    Coordinates about a far centre have lost no digits, for the polynomial is expanded there exactly; and it is divided
    by its largest coefficient there, so that nothing overflows.

    Parameters
    ----------
    polynomial
        The polynomial of x; not zero.
    centre
        The origin of t.
    scale
        A power of two.
    """

    polynomial: Polynomial
    centre: tuple[float, float, float]
    scale: float

    @classmethod
    def over(
        cls, polynomial: Polynomial, low: tuple[float, float, float], high: tuple[float, float, float]
    ) -> "Evaluated":
        """Return the polynomial prepared for a box."""
        middle = [0.5 * a + 0.5 * b for a, b in zip(low, high, strict=True)]
        half = max(0.5 * b - 0.5 * a for a, b in zip(low, high, strict=True))
        return cls(polynomial, (middle[0], middle[1], middle[2]), 2.0 ** math.frexp(half)[1])

    @cached_property
    def coefficients(self) -> Float:
        """(d + 1, d + 1, d + 1) coefficients of the powers of t, the largest of modulus 1; d is the total degree."""
        x, y, z = (Fraction(value) for value in self.centre)
        local = self.polynomial.about((x, y, z), Fraction(self.scale))
        largest = max(abs(value) for _, value in local.terms)
        size = self.polynomial.degree + 1
        table = np.zeros((size, size, size))
        for powers, value in local.terms:
            table[powers] = float(value / largest)
        return table

    @cached_property
    def rows(self) -> Rows:
        """The coefficients as ragged rows, for :func:`horner`."""
        return ragged(self.coefficients)

    @cached_property
    def moduli(self) -> Rows:
        """The moduli of the coefficients as ragged rows: what bounds the rounding of values."""
        return ragged(np.abs(self.coefficients))

    def local(self, points: Float) -> Float:
        """Coordinates t (N, 3) of points (N, 3)."""
        moved: Float = (points - np.array(self.centre)) / self.scale
        return moved

    def values(self, points: Float) -> Float:
        """Values (N,) at points (N, 3); where they overflow, infinite or NaN."""
        result = np.empty(len(points))
        for start in range(0, len(points), CHUNK):
            x, y, z = self.local(points[start : start + CHUNK]).T
            f: Float = np.zeros_like(x)
            for layer in reversed(self.rows):
                g = np.zeros_like(x)
                for row in reversed(layer):
                    h = np.zeros_like(x)
                    for coefficient in reversed(row):
                        h = h * z + coefficient
                    g = g * y + h
                f = f * x + g
            result[start : start + CHUNK] = f
        return result

    def jets(self, points: Float) -> PolynomialJet:
        """Values and derivatives with respect to x at points (N, 3); where they overflow, infinite or NaN."""
        jet = PolynomialJet(np.empty(len(points)), np.empty((len(points), 3)), np.empty((len(points), 3, 3)))
        for start in range(0, len(points), CHUNK):
            chunk = slice(start, start + CHUNK)
            columns = horner(self.rows, *self.local(points[chunk]).T)
            jet.value[chunk], jet.gradient[chunk], jet.hessian[chunk] = arranged(columns, self.scale)
        return jet


def horner(
    rows: Rows, x: Float, y: Float, z: Float
) -> tuple[Float, Float, Float, Float, Float, Float, Float, Float, Float, Float]:
    """f, f_x, f_y, f_z, f_xx, f_xy, f_xz, f_yy, f_yz, f_zz at (N,) places, Horner's rule in x over y over z.

    Parameters
    ----------
    rows
        The coefficients.
    x, y, z
        (N,) coordinates.
    """
    zero = np.zeros_like(x)
    f, fx, fy, fz, fxx, fxy, fxz, fyy, fyz, fzz = (zero,) * 10
    for layer in reversed(rows):
        g, gy, gz, gyy, gyz, gzz = (zero,) * 6
        for row in reversed(layer):
            h, hz, hzz = (zero,) * 3
            for coefficient in reversed(row):
                hzz = hzz * z + 2.0 * hz
                hz = hz * z + h
                h = h * z + coefficient
            gyy = gyy * y + 2.0 * gy
            gyz = gyz * y + gz
            gy = gy * y + g
            gzz = gzz * y + hzz
            gz = gz * y + hz
            g = g * y + h
        fxx = fxx * x + 2.0 * fx
        fxy = fxy * x + fy
        fxz = fxz * x + fz
        fx = fx * x + f
        fyy = fyy * x + gyy
        fyz = fyz * x + gyz
        fzz = fzz * x + gzz
        fy = fy * x + gy
        fz = fz * x + gz
        f = f * x + g
    return f, fx, fy, fz, fxx, fxy, fxz, fyy, fyz, fzz


def arranged(columns: Sequence[Float], scale: float) -> tuple[Float, Float, Float]:
    """Values (N,), gradients (N, 3) and Hessians (N, 3, 3) from ten columns (N,) in coordinates that are x / scale."""
    f, fx, fy, fz, fxx, fxy, fxz, fyy, fyz, fzz = columns
    rows = ((fxx, fxy, fxz), (fxy, fyy, fyz), (fxz, fyz, fzz))
    hessian = np.stack([np.stack(row, axis=-1) for row in rows], axis=1) / scale**2
    return f, np.stack([fx, fy, fz], axis=-1) / scale, hessian


def ragged(table: Float) -> Rows:
    """Return coefficients (n, n, n) as rows without the zeros at their ends."""
    filled = table != 0.0
    layers = []
    for layer, present in zip(table.tolist(), filled, strict=True):
        lengths = [int(np.flatnonzero(row).max(initial=-1)) + 1 for row in present]
        kept = [tuple(row[:length]) for row, length in zip(layer, lengths, strict=True)]
        layers.append(tuple(kept[: int(np.flatnonzero(lengths).max(initial=-1)) + 1]))
    return tuple(layers[: max((at + 1 for at, layer in enumerate(layers) if layer), default=0)])
