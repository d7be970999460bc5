"""Polynomials of the coordinates of patches, in Bernstein form, whose coefficients bound them over the whole patch.

A net is (n, ..., P): control points first, patches last, so that operations run along patches. Products are taken of
coefficients times binomials, whose products are mere convolutions; the binomials of the result are divided off once.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from testbed.geometry.bernstein import multi_indices, quarter_triangle, subdivide_tensor
from testbed.geometry.vectors import Float, Int


@dataclass(frozen=True)
class BernsteinBasis:
    """Bernstein polynomials of a degree over a triangle, or of a bidegree over the unit square.

    Parameters
    ----------
    degrees
        (d,) for triangles, (m, n) for squares.
    """

    degrees: tuple[int, ...]

    @property
    def exponents(self) -> Int:
        """(n, 2) the exponents of b1 and b2, or of u and v, that stand for a control point, in the order of the net."""
        if len(self.degrees) == 1:
            return multi_indices(self.degrees[0])[:, 1:]
        along_u, along_v = (np.arange(degree + 1) for degree in self.degrees)
        return np.stack(np.meshgrid(along_u, along_v, indexing="ij"), axis=-1).reshape(-1, 2)

    def __len__(self) -> int:
        return len(self.exponents)

    def power(self, k: int) -> "BernsteinBasis":
        """Return the basis that holds products of k polynomials of this one."""
        return BernsteinBasis(tuple(k * degree for degree in self.degrees))


@cache
def binomials(basis: BernsteinBasis) -> Float:
    """Factors (n,) of the Bernstein polynomials."""
    if len(basis.degrees) == 1:
        d = basis.degrees[0]
        factors = [math.comb(d, i) * math.comb(d - i, j) for i, j, _ in multi_indices(d).tolist()]
    else:
        m, n = basis.degrees
        factors = [math.comb(m, i) * math.comb(n, j) for i, j in basis.exponents.tolist()]
    return np.array(factors, dtype=np.float64)


@cache
def product_places(a: BernsteinBasis, b: BernsteinBasis) -> Int:
    """(n_a, n_b) where the product of two Bernstein polynomials stands in the net of the sum of degrees."""
    both = a.exponents[:, None] + b.exponents
    if len(a.degrees) == 1:
        row = both.sum(axis=-1)
        return np.asarray(row * (row + 1) // 2 + both[..., 1])
    return np.asarray(both[..., 0] * (a.degrees[1] + b.degrees[1] + 1) + both[..., 1])


def product(a: Float, b: Float, basis_a: BernsteinBasis, basis_b: BernsteinBasis) -> Float:
    """Product (n, ..., P) of nets times binomials (n_a, ..., P) and (n_b, ..., P)."""
    places = product_places(basis_a, basis_b)
    result = np.zeros((int(places.max()) + 1, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    for factor, where in zip(a, places, strict=True):
        result[where] += factor * b
    return result


def compose(
    offsets: Float, weights: Float | None, basis: BernsteinBasis, exponents: Int, coefficients: Float, order: int
) -> Float:
    """Bernstein coefficients of w^order sum_a c_a (h / w)^a for polynomial maps h to space, by Horner's rule.

    Parameters
    ----------
    offsets
        (n, 3, P) net of h.
    weights
        (n, P) net of w; None for 1.
    basis
        Of both.
    exponents, coefficients
        (T, 3) and (T, P): a and c_a, every divisor of each power included.
    order
        At least the largest total degree.

    Returns
    -------
    Float
        (N, P) in ``basis.power(order)``.
    """
    scaled = offsets * binomials(basis)[:, None, None]
    patches = offsets.shape[2]
    powers = [np.ones((1, patches))]
    for k in range(1, order + 1):
        if weights is None:
            powers.append(np.broadcast_to(binomials(basis.power(k))[:, None], (len(basis.power(k)), patches)))
        else:
            scaled_weights = weights * binomials(basis)[:, None]
            powers.append(product(scaled_weights, powers[-1], basis, basis.power(k - 1)))
    degree = exponents.sum(axis=1)
    # a power is the product of the axis of its last factor, in the order x, y, z, and of its parent
    last = np.array([0 if not power.any() else int(np.flatnonzero(power)[-1]) for power in exponents])
    parent = _parents(exponents, last)
    nets: Float | None = None
    for d in range(order, -1, -1):
        (nodes,) = np.nonzero(degree == d)
        own = powers[order - d][:, None] * coefficients[nodes]
        if nets is not None:
            children = np.flatnonzero(degree == d + 1)
            if len(children):
                terms = product(scaled[:, last[children]], nets, basis, basis.power(order - d - 1))
                for child, term in zip(children, np.moveaxis(terms, 1, 0), strict=True):
                    own[:, int(np.flatnonzero(nodes == parent[child])[0])] += term
        nets = own
    assert nets is not None  # noqa: S101 - the loop runs at least once
    result: Float = nets[:, 0] / binomials(basis.power(order))[:, None]
    return result


def _parents(exponents: Int, last: Int) -> Int:
    """(T,) rows of the powers without one factor of the axis ``last``; 0 for the constant."""
    place = {tuple(power): row for row, power in enumerate(exponents.tolist())}
    lowered = exponents - np.eye(3, dtype=np.int64)[last]
    return np.array([place.get(tuple(power), 0) for power in lowered.tolist()])


@cache
def elevation(basis: BernsteinBasis, k: int) -> Float:
    """Table (N, n) of the coefficients in ``basis.power(k)`` of each of the basis's polynomials."""
    size = len(basis)
    unit_nets = np.diag(binomials(basis))
    higher = basis.power(k - 1)
    ones = np.repeat(binomials(higher)[:, None], size, axis=1)
    raised: Float = product(unit_nets, ones, basis, higher) / binomials(basis.power(k))[:, None]
    return raised


@cache
def quartering(basis: BernsteinBasis) -> Float:
    """Table (4, n, n) from control points to those of the four quarters of the domain, halved along all sides."""
    size = len(basis)
    if len(basis.degrees) == 1:
        return quarter_triangle(np.eye(size))
    m, n = basis.degrees
    net = np.eye(size).reshape(m + 1, n + 1, size)
    quarters = [quarter for half in subdivide_tensor(net, 0) for quarter in subdivide_tensor(half, 1)]
    return np.stack(quarters).reshape(4, size, size)


def centre_weights(basis: BernsteinBasis) -> Float:
    """Values (n,) of the Bernstein polynomials at the centre of the domain."""
    parameter = 1.0 / 3.0 if len(basis.degrees) == 1 else 0.5
    weights: Float = binomials(basis) * parameter ** sum(basis.degrees)
    return weights
