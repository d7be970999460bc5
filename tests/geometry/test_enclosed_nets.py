"""Bounds on rounding against exact rational arithmetic: every error is within its bound, and no bound is idle."""

from collections.abc import Callable
from fractions import Fraction
from math import comb
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.bernstein import multiply_triangles
from testbed.geometry.enclosed_nets import (
    Degrees,
    EnclosedNets,
    coefficient_weights,
    cross,
    dot,
    exponents,
    gamma,
    multiply,
    scale,
)
from testbed.geometry.vectors import Float

#: Fractions, or dictionaries of them by exponents.
Exact = Any
DEGREES: list[tuple[Degrees, Degrees]] = [((1,), (2,)), ((3,), (3,)), ((0,), (4,)), ((2, 1), (1, 3)), ((0, 2), (3, 0))]
every_degree = pytest.mark.parametrize(("first", "second"), DEGREES)
PATCHES = 7


def fractions(values: Float) -> Exact:
    return np.vectorize(Fraction, otypes=[object])(values)


def weight(row: list[int], degrees: Degrees) -> int:
    if len(degrees) == 1:
        return comb(degrees[0], row[0]) * comb(degrees[0] - row[0], row[1])
    return comb(degrees[0], row[1]) * comb(degrees[1], row[3])


def exact_product(a: Exact, of_a: Degrees, b: Exact, of_b: Degrees) -> Exact:
    """Coefficients (n, P) of the product of coefficients (n, P) of Fractions, by the definition of the basis."""
    total = tuple(m + n for m, n in zip(of_a, of_b, strict=True))
    rows = exponents(total).tolist()
    result = np.zeros((len(rows), a.shape[1]), dtype=object)
    for i, left in enumerate(exponents(of_a).tolist()):
        for j, right in enumerate(exponents(of_b).tolist()):
            both = [x + y for x, y in zip(left, right, strict=True)]
            factor = Fraction(weight(left, of_a) * weight(right, of_b), weight(both, total))
            result[rows.index(both)] += factor * a[i] * b[j]
    return result


def random_net(rng: np.random.Generator, degrees: Degrees, dimension: int) -> tuple[EnclosedNets, Exact]:
    """Computed coefficients of sizes from 1e-3 to 1e3, and exact ones that differ by as much as the error says."""
    shape = (dimension, len(exponents(degrees)), PATCHES)
    coefficients = rng.normal(size=shape) * 10.0 ** rng.uniform(-3.0, 3.0, PATCHES)
    error = np.abs(coefficients).max(axis=(0, 1)) * rng.choice([0.0, 1e-16, 1e-13], PATCHES)
    away = rng.normal(size=shape)
    away *= 0.99 * error / np.sqrt((away**2).sum(axis=0)).max(axis=0)
    exact = fractions(coefficients) + fractions(away)
    net = EnclosedNets.of_coefficients(coefficients if dimension > 1 else coefficients[0], degrees, error)
    return net, exact


def check(net: EnclosedNets, exact: Exact, reach: float = 1e-11) -> None:
    """Compare with exact coefficients (dim, n, P)."""
    computed = fractions(net.coefficients.reshape(exact.shape))
    for patch in range(PATCHES):
        squares = ((computed - exact)[..., patch] ** 2).sum(axis=0)
        assert max(squares) <= Fraction(net.error[patch]) ** 2
        for values in (computed, exact):
            assert max((values[..., patch] ** 2).sum(axis=0)) <= Fraction(net.size[patch]) ** 2
    # the bound is of use
    assert (net.error <= reach * net.size).all()


OPERATIONS: dict[str, tuple[int, int, Callable[..., EnclosedNets]]] = {
    "multiply": (1, 1, multiply),
    "dot": (3, 3, dot),
    "cross": (3, 3, cross),
    "scale": (1, 3, scale),
}


def exact_result(operation: str, a: Exact, of_a: Degrees, b: Exact, of_b: Degrees) -> Exact:
    def product(i: int, j: int) -> Exact:
        return exact_product(a[i], of_a, b[j], of_b)

    if operation == "multiply":
        return np.stack([product(0, 0)])
    if operation == "scale":
        return np.stack([product(0, axis) for axis in range(3)])
    if operation == "dot":
        return np.stack([product(0, 0) + product(1, 1) + product(2, 2)])
    return np.stack([product(y, z) - product(z, y) for y, z in ((1, 2), (2, 0), (0, 1))])


@every_degree
@pytest.mark.parametrize("operation", OPERATIONS)
@pytest.mark.parametrize("seed", range(3))
def test_products_are_within_their_bounds(first: Degrees, second: Degrees, operation: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    left, right, compute = OPERATIONS[operation]
    (a, exact_a), (b, exact_b) = random_net(rng, first, left), random_net(rng, second, right)
    check(compute(a, b), exact_result(operation, exact_a, first, exact_b, second))


@every_degree
@pytest.mark.parametrize("seed", range(3))
def test_sums_of_any_degrees_are_within_their_bounds(first: Degrees, second: Degrees, seed: int) -> None:
    rng = np.random.default_rng(seed)
    (a, exact_a), (b, exact_b) = random_net(rng, first, 1), random_net(rng, second, 1)
    degrees = tuple(max(pair) for pair in zip(first, second, strict=True))

    def elevated(exact: Exact, of: Degrees) -> Exact:
        rest = tuple(m - n for m, n in zip(degrees, of, strict=True))
        ones = np.full((len(exponents(rest)), PATCHES), Fraction(1), dtype=object)
        return exact_product(ones, rest, exact[0], of)[None]

    one, other = elevated(exact_a, first), elevated(exact_b, second)
    check(a + b, one + other)
    check(a - b, one - other)
    check(a.halved(), exact_a / 2)


def test_a_chain_of_products_and_differences_is_within_its_bounds() -> None:
    rng = np.random.default_rng(5)
    (a, exact_a), (b, exact_b) = random_net(rng, (2,), 3), random_net(rng, (1,), 3)
    n, exact_n = cross(a, b), exact_result("cross", exact_a, (2,), exact_b, (1,))
    square, exact_square = dot(n, n), exact_result("dot", exact_n, (3,), exact_n, (3,))
    check(square, exact_square)
    # cancels to nothing but errors
    check(multiply(square, square) - multiply(square, square), np.zeros((1, len(exponents((12,))), PATCHES), object))


def test_products_agree_with_the_algebra_of_bezier_triangles() -> None:
    rng = np.random.default_rng(6)
    (a, _), (b, _) = random_net(rng, (3,), 1), random_net(rng, (4,), 1)
    expected = multiply_triangles(a.coefficients.T[..., None], b.coefficients.T[..., None])[..., 0].T
    np.testing.assert_allclose(multiply(a, b).coefficients, expected, rtol=0.0, atol=1e-14 * (a.size * b.size).max())


@given(st.integers(1, 400), st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=60))
def test_gamma_bounds_the_error_of_sums(extra: int, values: list[float]) -> None:
    total = 0.0
    for value in values:
        total += value
    exact = sum(map(Fraction, values), Fraction(0))
    bound = Fraction(gamma(len(values))) * sum(abs(Fraction(value)) for value in values)
    assert abs(Fraction(total) - exact) <= bound
    assert gamma(extra + 1) > gamma(extra) >= extra * 2.0**-53


@pytest.mark.parametrize("degrees", [(0,), (3,), (40,), (0, 0), (2, 5), (14, 14)])
def test_weights_sum_to_the_number_of_words(degrees: Degrees) -> None:
    words = 3.0 ** degrees[0] if len(degrees) == 1 else 2.0 ** sum(degrees)
    assert coefficient_weights(degrees).sum() == pytest.approx(words, rel=1e-14)
    assert len(exponents(degrees)) == len(coefficient_weights(degrees))
