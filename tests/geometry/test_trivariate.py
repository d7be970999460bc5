from fractions import Fraction
from math import prod

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.trivariate import Trivariate

powers = st.tuples(st.integers(0, 3), st.integers(0, 3), st.integers(0, 2))
polynomials = st.dictionaries(powers, st.integers(-9, 9).map(float), min_size=1, max_size=8).map(
    lambda terms: Trivariate(tuple(terms.items()))
)
places = st.tuples(*(3 * [st.integers(-16, 16).map(lambda n: n / 8.0)]))


def exact(polynomial: Trivariate, point: tuple[Fraction, ...]) -> Fraction:
    return sum(
        (Fraction(c) * prod((x**e for x, e in zip(point, powers, strict=True)), start=Fraction(1)))
        for powers, c in polynomial.terms
    ) + Fraction(0)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(polynomial=polynomials, point=places, offset=places)
def test_an_expansion_is_the_polynomial_elsewhere(
    polynomial: Trivariate, point: tuple[float, ...], offset: tuple[float, ...]
) -> None:
    # dyadic numbers of few digits: exact in floating point too
    coefficients = polynomial.expansion(np.array([point]))[:, 0]
    there = sum(
        Fraction(c) * prod((Fraction(d) ** int(e) for d, e in zip(offset, powers, strict=True)), start=Fraction(1))
        for powers, c in zip(polynomial.exponents.tolist(), coefficients.tolist(), strict=True)
    )
    assert there == exact(polynomial, tuple(Fraction(x) + Fraction(d) for x, d in zip(point, offset, strict=True)))


def test_magnitudes_are_those_of_all_terms_with_one_sign() -> None:
    # x^2 y - 3 z at (1, -2, 1): terms 2 and 3, derivatives 2 x y, x^2, 3
    value, gradient = Trivariate((((2, 1, 0), 1.0), ((0, 0, 1), -3.0))).magnitudes(np.array([[1.0, -2.0, 1.0]]))
    assert value[0] == 5.0
    assert gradient[0].tolist() == [4.0, 1.0, 3.0]


def test_a_constant_has_degree_zero() -> None:
    constant = Trivariate((((0, 0, 0), 2.5),))
    assert constant.degree == 0
    assert constant.expansion(np.zeros((2, 3))).tolist() == [[2.5, 2.5]]
