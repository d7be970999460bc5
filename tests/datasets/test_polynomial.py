"""Polynomials: exact arithmetic, values and derivatives against exact ones, bounds over boxes, regular zero sets."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.vectors import Float, norm
from testbed_datasets.polynomial import Evaluated, Exponents, Polynomial
from testbed_datasets.polynomial_boxes import bounds
from testbed_datasets.polynomial_text import parse_polynomial
from testbed_datasets.polynomial_zeros import occupied, singular_place

exponents = st.tuples(*(3 * [st.integers(0, 3)]))
coefficients = st.fractions(-4, 4, max_denominator=9)
polynomials = st.dictionaries(exponents, coefficients, min_size=1, max_size=4).map(Polynomial.of)
rationals = st.fractions(-3, 3, max_denominator=16)
places = st.tuples(rationals, rationals, rationals)

LOW, HIGH = (-3.0, -3.0, -3.0), (3.0, 3.0, 3.0)


def over(text: str, low: tuple[float, float, float] = LOW, high: tuple[float, float, float] = HIGH) -> Evaluated:
    return Evaluated.over(parse_polynomial(text), low, high)


def largest(evaluated: Evaluated) -> Fraction:
    """What the polynomial was divided by."""
    x, y, z = map(Fraction, evaluated.centre)
    local = evaluated.polynomial.about((x, y, z), Fraction(evaluated.scale))
    return max(abs(value) for _, value in local.terms)


@settings(max_examples=40, deadline=None)
@given(polynomials, polynomials, places)
def test_arithmetic_is_that_of_values(p: Polynomial, q: Polynomial, at: tuple[Fraction, Fraction, Fraction]) -> None:
    assert (p + q)(*at) == p(*at) + q(*at)
    assert (p * q)(*at) == p(*at) * q(*at)
    assert (-p)(*at) == -p(*at)
    assert not (p + -p).terms


@settings(max_examples=40, deadline=None)
@given(polynomials, places, places, st.fractions(Fraction(1, 8), 4, max_denominator=8))
def test_an_expansion_about_a_centre_is_exact(
    p: Polynomial,
    centre: tuple[Fraction, Fraction, Fraction],
    t: tuple[Fraction, Fraction, Fraction],
    scale: Fraction,
) -> None:
    x, y, z = (c + scale * s for c, s in zip(centre, t, strict=True))
    assert p.about(centre, scale)(*t) == p(x, y, z)


@settings(max_examples=40, deadline=None)
@given(polynomials.filter(lambda p: p.degree > 0), places)
def test_values_and_derivatives_against_exact_ones(p: Polynomial, at: tuple[Fraction, Fraction, Fraction]) -> None:
    evaluated = Evaluated.over(p, (-3.0, -2.0, -1.0), (3.0, 4.0, 3.0))
    point = np.array([[float(value) for value in at]])
    x, y, z = (Fraction(value) for value in point[0].tolist())
    jet = evaluated.jets(point)
    by = largest(evaluated)
    assert evaluated.values(point)[0] == jet.value[0]
    assert jet.value[0] == pytest.approx(float(p(x, y, z) / by), abs=1e-12)
    for i in range(3):
        first = p.derivative(i)
        assert jet.gradient[0, i] == pytest.approx(float(first(x, y, z) / by), abs=1e-11)
        for j in range(3):
            assert jet.hessian[0, i, j] == pytest.approx(float(first.derivative(j)(x, y, z) / by), abs=1e-10)
    assert np.array_equal(jet.hessian, jet.hessian.swapaxes(-1, -2))


def test_derivatives_of_a_high_degree_by_complex_steps() -> None:
    text = "(x+y/3-z/7+1)^9*(x*y-z^2+2)^4*(z-x)^3"

    def value(x: complex, y: complex, z: complex) -> complex:
        return (x + y / 3 - z / 7 + 1) ** 9 * (x * y - z**2 + 2) ** 4 * (z - x) ** 3

    evaluated = over(text, (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 3))
    gradient = evaluated.jets(points).gradient * float(largest(evaluated))
    for axis in range(3):
        step = 1e-30j * np.eye(3)[axis]
        expected = np.array([value(*(point + step)).imag / 1e-30 for point in points])
        assert np.abs(gradient[:, axis] - expected).max() < 1e-11 * np.abs(expected).max()


def test_far_coordinates_keep_their_digits() -> None:
    # expanded, the coefficients are up to 4e12 and their sums lose all digits
    text = "(x-1000)^2+(y+1000)^2+(z-1000)^2-1"
    evaluated = over(f"({text})*({text})-1/2", (998.0, -1002.0, 998.0), (1002.0, -998.0, 1002.0))
    point = np.array([[1000.5, -1000.25, 1000.125]])
    exact = parse_polynomial(f"({text})*({text})-1/2")(*(Fraction(value) for value in point[0].tolist()))
    assert evaluated.values(point)[0] * float(largest(evaluated)) == pytest.approx(float(exact), rel=1e-14)


def test_values_depend_on_their_own_point_alone() -> None:
    points = np.random.default_rng(3).uniform(-2.0, 2.0, (9000, 3))
    evaluated = over("x^4*y-3*z^3*x+y^2-0.7")
    jet = evaluated.jets(points)
    some = np.arange(8999, 0, -171)
    again = evaluated.jets(points[some])
    assert np.array_equal(again.value, jet.value[some])
    assert np.array_equal(again.hessian, jet.hessian[some])


@settings(max_examples=40, deadline=None)
@given(polynomials.filter(lambda p: p.degree > 0), st.integers(0, 2**32), st.integers(0, 12))
def test_bounds_hold_in_boxes_of_all_sizes(p: Polynomial, seed: int, smaller: int) -> None:
    random = np.random.default_rng(seed)
    evaluated = Evaluated.over(p, LOW, HIGH)
    low = random.uniform(-4.0, 4.0, (5, 3))
    high = low + random.uniform(0.0, 2.0, (5, 3)) * 10.0**-smaller
    found = bounds(evaluated, low, high)
    by = largest(evaluated)
    for _ in range(4):
        inside = np.clip(low + (high - low) * random.integers(0, 5, (5, 3)) / 4.0, low, high)
        for row, point in enumerate(inside.tolist()):
            x, y, z = map(Fraction, point)  # exact values: rounding must be inside the bounds

            def check(exact: Fraction, value: float, radius: float) -> None:
                assert abs(exact / by - Fraction(value)) <= Fraction(radius)

            check(p(x, y, z), found.value[row], found.value_radius[row])
            for i in range(3):
                first = p.derivative(i)
                check(first(x, y, z), found.gradient[row, i], found.gradient_radius[row, i])
                for j in range(3):
                    second = first.derivative(j)
                    check(second(x, y, z), found.hessian[row, i, j], found.hessian_radius[row, i, j])


def test_bounds_are_sharp_in_small_boxes() -> None:
    evaluated = over("x^3*y-z^2+x*z+1")
    centre = np.random.default_rng(0).uniform(-2.0, 2.0, (100, 3))
    excess = []
    for half in (1e-2, 1e-3):
        found = bounds(evaluated, centre - half, centre + half)
        linear = half * np.abs(found.gradient).sum(axis=1)
        excess.append((found.value_radius - linear).max())
    assert excess[1] < 0.012 * excess[0]  # falls with the square


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("x^2+y^2-z^2", [0.0, 0.0, 0.0]),
        ("(x-1)^2+(y-0.5)^2-(z+2)^2", [1.0, 0.5, -2.0]),
        ("(x-3)^2+y^2-(z+3)^2", [3.0, 0.0, -3.0]),  # at a corner of the box
        ("y^2-x^2*(x+1)+z^2", [0.0, 0.0, 0.0]),
        ("x^2+y^2+z^2", [0.0, 0.0, 0.0]),
        ("x^3+y^3+z^3", [0.0, 0.0, 0.0]),
    ],
)
def test_a_singular_point_is_found(text: str, place: list[float]) -> None:
    doubt = singular_place(over(text), np.array(LOW), np.array(HIGH))
    assert doubt is not None
    assert doubt.proved
    assert np.abs(doubt.place - place).max() < 1e-6


@pytest.mark.parametrize(
    "text",
    [
        "x*y*z",
        "y^2-x^2*(x+1)",
        "(x^2+y^2+z^2-1)^2",
        "(x^2+y^2+z^2-1)^3",
        "(x^2+y^2-1)*(z-0.3)",
        "(x+2*y)^2",
        "x^5",
        "x*(x-z^3-x*z)",
    ],
)
def test_on_singular_curves_and_surfaces_a_point_is_found(text: str) -> None:
    evaluated = over(text)
    doubt = singular_place(evaluated, np.array(LOW), np.array(HIGH))
    assert doubt is not None
    assert doubt.proved
    jet = evaluated.jets(doubt.place[None])
    assert abs(jet.value[0]) < 1e-12
    assert norm(jet.gradient)[0] < 1e-7


@pytest.mark.parametrize(
    "text",
    [
        *("4*x^2+2*y^2+z^2-4", "x", "x^2+y^2-z^2-1e-10", "x^2+y^2-z^2+1e-10", "(x-3.01)^2+y^2-z^2", "x^2+y^2+z^2+1e-9"),
        *("x^4+y^4+z^4-4*(x^2+y^2+z^2)+5.5", "y^2-x^2*(x+1)+z", "1e-9*x-1e-9*y^3", "(x^2+y^2+z^2-1)*(x^2+y^2+z^2-4)"),
    ],
)
def test_a_regular_zero_set_is_proved_to_be_regular(text: str) -> None:
    assert singular_place(over(text), np.array(LOW), np.array(HIGH)) is None


@pytest.mark.parametrize("text", ["(x^2+y^2-1)^2-1e-9", "(x-1)*(x-1.0001)"])
def test_what_is_nearly_a_double_surface_is_in_doubt(text: str) -> None:
    doubt = singular_place(over(text), np.array(LOW), np.array(HIGH))
    assert doubt is not None
    assert not doubt.proved


@pytest.mark.parametrize("text", ["4*x^2+2*y^2+z^2-4", "z-x*y", "x^4+y^4+z^4-4*(x^2+y^2+z^2)+5.5"])
def test_occupied_boxes_cover_the_zero_set(text: str) -> None:
    evaluated = over(text)
    boxes = occupied(evaluated, np.array(LOW), np.array(HIGH))
    # zeros on random segments, by bisection
    random = np.random.default_rng(2)
    a, b = random.uniform(-3.0, 3.0, (2, 1000, 3))
    change = evaluated.values(a) * evaluated.values(b) < 0.0
    a, b = a[change], b[change]
    for _ in range(60):
        middle: Float = 0.5 * (a + b)
        same = (evaluated.values(middle) * evaluated.values(a) > 0.0)[:, None]
        a, b = np.where(same, middle, a), np.where(same, b, middle)
    inside = ((a[:, None] >= boxes.low - 1e-12) & (a[:, None] <= boxes.high + 1e-12)).all(axis=2).any(axis=1)
    assert len(a) > 50
    assert inside.all()


def test_no_box_is_occupied_without_zeros() -> None:
    assert len(occupied(over("x^2+y^2+z^2+1e-6"), np.array(LOW), np.array(HIGH))) == 0
    assert len(occupied(over("(x-4)^2+y^2+z^2-0.99"), np.array(LOW), np.array(HIGH))) == 0


def test_terms_are_sorted_and_without_zeros() -> None:
    terms: dict[Exponents, Fraction] = {(2, 0, 0): Fraction(1), (0, 0, 0): Fraction(-4), (0, 1, 0): Fraction(0)}
    assert Polynomial.of(terms).terms == (((0, 0, 0), Fraction(-4)), ((2, 0, 0), Fraction(1)))
