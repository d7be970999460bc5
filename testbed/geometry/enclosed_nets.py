"""Bernstein polynomials whose rounding is known: nets of coefficients, and how far from the exact ones they can be.

A net is a polynomial over the triangle, degree (d,), or over the unit square, degrees (m, n), for each patch of a
batch. Coefficients stand in the order of :mod:`testbed.geometry.bernstein`, those of a square row by row, with the
patches along the last axis.

Rounding is bounded a priori, once for a patch and not for each coefficient. A Bernstein coefficient of a product is an
average of products of coefficients (Vandermonde's identity), hence no larger than the product of the largest ones; what
rounding does to a sum of N products is at most gamma(N + 1) times the sum of their absolute values, whatever the order
of summation (Higham, Accuracy and Stability of Numerical Algorithms, section 3.1). So each net carries two numbers,
``size``, a bound on its exact and its computed coefficients, and ``error``, a bound on their difference; for vectors
both are Euclidean lengths. Underflow costs less than ``TINY`` in each operation as long as sizes are within 1e100,
which is why :mod:`testbed.geometry.curvature_polynomials` starts from patches scaled by powers of two.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import comb
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from testbed.geometry.bernstein import multi_indices
from testbed.geometry.vectors import Float, Int

if TYPE_CHECKING:
    from scipy.sparse import csr_array

#: (d,) of a triangle, (m, n) of a tensor-product patch.
Degrees: TypeAlias = tuple[int, ...]

#: Unit roundoff of float64.
UNIT = 2.0**-53
#: More than underflow takes in any sum that is formed here.
TINY = 1e-300
#: The arithmetic of the bounds is itself rounded: each is enlarged by this factor, far beyond what that can take.
SLACK = 1.0 + 2.0**-30


def gamma(operations: int) -> float:
    """Bound on the relative error of so many roundings, k u / (1 - k u), a little enlarged."""
    return SLACK * operations * UNIT / (1.0 - operations * UNIT)


@cache
def exponents(degrees: Degrees) -> Int:
    """Exponents of b0, b1, b2, or of 1 - u, u, 1 - v, v, for each coefficient, (n, 3 | 4), read-only."""
    if len(degrees) == 1:
        return multi_indices(degrees[0])
    m, n = degrees
    i, j = (index.ravel() for index in np.indices((m + 1, n + 1)))
    table = np.stack([m - i, i, n - j, j], axis=-1)
    table.flags.writeable = False
    return table


@cache
def coefficient_weights(degrees: Degrees) -> Float:
    """Multinomial coefficients, or products of binomial ones, (n,), read-only; right to three roundings."""
    rows = exponents(degrees).tolist()
    if len(degrees) == 1:
        values = [comb(degrees[0], i) * comb(degrees[0] - i, j) for i, j, _ in rows]
    else:
        values = [comb(degrees[0], i) * comb(degrees[1], j) for _, i, _, j in rows]
    table = np.array(values, dtype=np.float64)
    table.flags.writeable = False
    return table


def _places(rows: Int, degrees: Degrees) -> Int:
    """Places (...) of exponents (..., 3 | 4) in a net."""
    if len(degrees) == 1:
        j, k = rows[..., 1], rows[..., 2]
        return np.asarray((j + k) * (j + k + 1) // 2 + k)
    return np.asarray(rows[..., 1] * (degrees[1] + 1) + rows[..., 3])


@cache
def _averages(a: Degrees, b: Degrees, copies: int) -> "csr_array[Any, Any]":
    """Matrix from products a_i b_j, i running slowest, to the coefficients of the product; weights to 8 roundings.

    With ``copies`` such blocks of products side by side, as many are added.
    """
    from scipy.sparse import csr_array

    total = tuple(m + n for m, n in zip(a, b, strict=True))
    target = _places(exponents(a)[:, None] + exponents(b), total).ravel()
    weight = (
        np.multiply.outer(coefficient_weights(a), coefficient_weights(b)).ravel() / coefficient_weights(total)[target]
    )
    count = len(target)
    columns = np.arange(copies * count)
    return csr_array(
        (np.tile(weight, copies), (np.tile(target, copies), columns)), shape=(len(exponents(total)), copies * count)
    )


@dataclass(frozen=True, eq=False)
class EnclosedNets:
    """Polynomials of one degree with rounding bounds, one for each of P patches.

    Parameters
    ----------
    coefficients
        Computed Bernstein coefficients, (n, P), or (3, n, P) of vectors.
    degrees
        (d,) or (m, n).
    size
        (P,) bound on the absolute values of exact and of computed coefficients.
    error
        (P,) bound on the distance between exact and computed ones.
    """

    coefficients: Float
    degrees: Degrees
    size: Float
    error: Float

    @classmethod
    def of_coefficients(cls, coefficients: Float, degrees: Degrees, error: Float) -> "EnclosedNets":
        """Take coefficients (n, P) or (3, n, P) that are within ``error`` (P,) of the exact ones."""
        return cls(coefficients, degrees, SLACK * (largest(coefficients) + error) + TINY, error)

    @classmethod
    def one(cls, degrees: Degrees, patches: int) -> "EnclosedNets":
        """The constant 1 written with a degree."""
        ones = np.ones((len(exponents(degrees)), patches))
        return cls(ones, degrees, np.ones(patches), np.zeros(patches))

    @property
    def patches(self) -> int:
        """Number of patches, P."""
        return int(self.coefficients.shape[-1])

    def halved(self) -> "EnclosedNets":
        """Return half of the polynomials, without rounding."""
        return EnclosedNets(0.5 * self.coefficients, self.degrees, 0.5 * self.size, 0.5 * self.error + TINY)

    def elevated(self, degrees: Degrees) -> "EnclosedNets":
        """Return the same polynomials written with a degree that is not lower."""
        if degrees == self.degrees:
            return self
        difference = tuple(high - low for high, low in zip(degrees, self.degrees, strict=True))
        return multiply(self, EnclosedNets.one(difference, self.patches))

    def __add__(self, other: "EnclosedNets") -> "EnclosedNets":
        """Sum, written with the higher degree of the two."""
        return self._sum(other, 1)

    def __sub__(self, other: "EnclosedNets") -> "EnclosedNets":
        """Difference, written with the higher degree of the two."""
        return self._sum(other, -1)

    def _sum(self, other: "EnclosedNets", sign: int) -> "EnclosedNets":
        degrees = tuple(np.maximum(self.degrees, other.degrees).tolist())
        a, b = self.elevated(degrees), other.elevated(degrees)
        total = a.coefficients + b.coefficients if sign > 0 else a.coefficients - b.coefficients
        size = a.size + b.size
        error = a.error + b.error + gamma(2) * size
        return EnclosedNets(total, degrees, SLACK * (size + error), SLACK * error)


def largest(coefficients: Float) -> Float:
    """(P,) largest length of vectors (3, n, P), or absolute value of scalars (n, P); a few roundings off."""
    lengths = np.sqrt(np.square(coefficients).sum(axis=0)) if coefficients.ndim == 3 else np.abs(coefficients)
    # the addition is for squares that underflow
    most: Float = lengths.max(axis=0) + np.sqrt(TINY)
    return most


def _averaged(a: EnclosedNets, b: EnclosedNets, products: Sequence[Float] | Float, roundings: int) -> EnclosedNets:
    """Add up blocks of products (copies, n_a, n_b, P), with bounds: averages of products of lengths; see the module."""
    products = np.asarray(products)
    copies, first, second, patches = products.shape
    matrix = _averages(a.degrees, b.degrees, copies)
    total: Float = matrix @ products.reshape(copies * first * second, patches)
    degrees = tuple(m + n for m, n in zip(a.degrees, b.degrees, strict=True))
    terms = copies * min(first, second)
    size = a.size * b.size
    error = a.size * b.error + b.size * a.error + gamma(terms + roundings + 10) * size + TINY
    return EnclosedNets(total, degrees, SLACK * (size + error), SLACK * error)


def multiply(a: EnclosedNets, b: EnclosedNets) -> EnclosedNets:
    """Product of scalars; of degree the sum of the degrees."""
    return _averaged(a, b, (a.coefficients[:, None] * b.coefficients)[None], 1)


def dot(a: EnclosedNets, b: EnclosedNets) -> EnclosedNets:
    """Scalar product of vectors."""
    return _averaged(a, b, a.coefficients[:, :, None] * b.coefficients[:, None], 1)


def scale(a: EnclosedNets, b: EnclosedNets) -> EnclosedNets:
    """Product of scalars ``a`` and vectors ``b``."""
    parts = [_averaged(a, b, (a.coefficients[:, None] * component)[None], 1) for component in b.coefficients]
    return _stacked(parts)


def cross(a: EnclosedNets, b: EnclosedNets) -> EnclosedNets:
    """Vector product of vectors.

    A component is an average of terms |a_y b_z| + |a_z b_y| <= |a| |b|, so each has the rounding of a product, and the
    vector at most the square root of three of it.
    """
    terms = min(a.coefficients.shape[1], b.coefficients.shape[1])
    parts = []
    for y, z in ((1, 2), (2, 0), (0, 1)):
        products = a.coefficients[y][:, None] * b.coefficients[z]
        products -= a.coefficients[z][:, None] * b.coefficients[y]
        parts.append(_averaged(a, b, products[None], terms + 12))
    return _stacked(parts)


def _stacked(parts: Sequence[EnclosedNets]) -> EnclosedNets:
    """Components as vectors; their bounds, which are equal, are already those of the vectors."""
    return EnclosedNets(
        np.stack([part.coefficients for part in parts]), parts[0].degrees, parts[0].size, parts[0].error
    )
