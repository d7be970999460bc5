"""Bounds of quotients on pieces, against exact rational arithmetic."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_enclosed_nets import fractions, weight

from testbed.geometry.curvature_bounds import POWERS
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.enclosed_nets import Degrees, EnclosedNets, exponents
from testbed.geometry.quotient_bounds import Cells, chord, lower_quotient, powered, tangent, values_at
from testbed.geometry.vectors import Float

Exact = Any
COUNT = 6
DEGREES: list[Degrees] = [(2,), (5,), (0,), (2, 3), (3, 1), (1, 0)]
every_degree = pytest.mark.parametrize("degrees", DEGREES)
every_power = pytest.mark.parametrize("power", POWERS)


def net(degrees: Degrees, seed: int, lift: float = 0.0) -> EnclosedNets:
    rng = np.random.default_rng(seed)
    coefficients = lift + rng.normal(size=(len(exponents(degrees)), COUNT)) * np.exp(rng.normal(size=COUNT))
    return EnclosedNets.of_coefficients(coefficients, degrees, np.zeros(COUNT))


def exact_values(one: EnclosedNets, at: Exact) -> Exact:
    """Values (P,) of computed coefficients, taken as exact, at points (P, 2) of Fractions."""
    u, v = at[:, 0], at[:, 1]
    coordinates = [1 - u - v, u, v] if len(one.degrees) == 1 else [1 - u, u, 1 - v, v]
    total = np.zeros(len(at), dtype=object)
    for row, values in zip(exponents(one.degrees).tolist(), fractions(one.coefficients), strict=True):
        term = values * weight(row, one.degrees)
        for coordinate, exponent in zip(coordinates, row, strict=True):
            term = term * coordinate**exponent
        total = total + term
    return total


@every_degree
@pytest.mark.parametrize("seed", range(3))
def test_values_at_points_are_within_their_errors(degrees: Degrees, seed: int) -> None:
    one = net(degrees, seed)
    rng = np.random.default_rng(seed)
    at = rng.dirichlet(np.ones(3), COUNT)[:, 1:] if len(degrees) == 1 else rng.uniform(size=(COUNT, 2))
    value, error = values_at(one, at)
    assert (np.abs(fractions(value) - exact_values(one, fractions(at))) <= fractions(error)).all()
    assert (error <= 1e-13 * one.size).all()


def test_the_error_is_infinite_outside_of_the_triangle() -> None:
    assert np.isinf(values_at(net((2,), 0), np.full((COUNT, 2), 0.51))[1]).all()


@every_degree
@pytest.mark.parametrize("rounds", [1, 2, 5])
def test_halves_are_the_same_polynomials_on_the_pieces(degrees: Degrees, rounds: int) -> None:
    numerator, square = net(degrees, 1), net(degrees, 2, 5.0)
    cells, pieces = Cells.whole(numerator, square, 2.0), [CORNERS[len(degrees) + 2]] * COUNT
    owner = np.arange(COUNT)
    for round_ in range(rounds):
        cells, owner = cells.halved(), np.tile(owner, 2)
        pieces = [half(piece, which, round_) for which in (0, 1) for piece in pieces]
    values = fractions(cells.corners())
    error = fractions(cells.error)
    places = np.stack(pieces)
    if len(degrees) == 2:
        # places in a table run along u first, and rows and columns change places with every halving
        order = [0, 3, 1, 2] if rounds % 2 == 0 else [0, 1, 3, 2]
        places = places[:, order]
    for which, whole in enumerate((numerator, square)):
        taken = EnclosedNets(whole.coefficients[:, owner], degrees, whole.size[owner], whole.error[owner])
        for corner in range(places.shape[1]):
            expected = exact_values(taken, fractions(places[:, corner]))
            assert (np.abs(values[which, corner] - expected) <= error[which]).all()
    assert (cells.error <= 1e-13 * cells.size).all()


def half(piece: Float, which: int, round_: int) -> Float:
    """Corners of a half: of triangles as the halving numbers them, of squares counterclockwise."""
    if len(piece) == 3:
        middle = 0.5 * (piece[0] + piece[1])
        return np.stack([piece[which], piece[2], middle])
    axis = round_ % 2
    result = piece.copy()
    middle_of_axis = 0.5 * (piece[:, axis].min() + piece[:, axis].max())
    moved = piece[:, axis] == (piece[:, axis].max() if which == 0 else piece[:, axis].min())
    result[moved, axis] = middle_of_axis
    return result


@every_degree
@every_power
@pytest.mark.parametrize("seed", range(4))
def test_no_value_is_beyond_the_bounds(degrees: Degrees, power: float, seed: int) -> None:
    numerator, square = net(degrees, seed), net(degrees, seed + 10, 9.0)
    cells = Cells.whole(numerator, square, power)
    bound, rounding = cells.bounds()
    attained, _ = cells.attained()
    best = np.full((2, COUNT), -np.inf)
    for point in lattice(len(degrees) + 2, 6):
        # points of the lattice are as exact as they are: floats
        at = np.broadcast_to(fractions(point), (COUNT, 2))
        a, q = exact_values(numerator, at), exact_values(square, at)
        finite = np.isfinite(bound[0])
        for side, sign in enumerate((1, -1)):
            # c >= a / q^p on squares: a^2 <= c^2 q^2p where both are positive, without roots
            holds = [
                not ok or at_most(sign * x, y, power, Fraction(c))
                for x, y, c, ok in zip(a, q, bound[side], finite, strict=True)
            ]
            assert all(holds)
        floats = np.array([float(x) / float(y) ** power if y > 0 else np.nan for x, y in zip(a, q, strict=True)])
        best = np.fmax(best, np.stack([floats, -floats]))
    # what is attained at corners is no more than what the lattice reaches
    assert (attained <= best + 1e-12 * np.abs(best)).all()
    assert (rounding[np.isfinite(bound)] <= 1e-10 * np.abs(bound[np.isfinite(bound)]) + 1e-12).all()


def at_most(a: Fraction, q: Fraction, power: float, c: Fraction) -> bool:
    """Whether a / q^p <= c, exactly; q > 0, and p is a multiple of 1/2."""
    if q <= 0:
        return False
    right = c * abs(c) * q ** int(2 * power)
    return a * abs(a) <= right


@given(st.floats(1e-6, 1e6), st.floats(0.0, 10.0), st.sampled_from(POWERS), st.floats(0.0, 1.0))
def test_tangents_are_below_and_chords_above(low: float, width: float, power: float, t: float) -> None:
    high = np.array([low * (1.0 + width) * (1.0 + 2.0**-48)])
    lows = np.array([low])
    q = min(max(low + t * (float(high[0]) - low), low), float(high[0]))
    (slope, below), (secant, above) = tangent(lows, high, power), chord(lows, high, power)
    room = Fraction(float(32.0 * 2.0**-53 * powered(high, power)[0]))
    exact_q = Fraction(q)
    under = Fraction(float(slope[0])) * exact_q - Fraction(float(below[0])) - room
    over = Fraction(float(secant[0])) * exact_q + Fraction(float(above[0])) + room
    square = exact_q ** int(2 * power)
    assert under <= 0 or under**2 <= square
    assert over > 0
    assert over**2 >= square
    # at the least q, the tangent is positive
    assert slope[0] * low - below[0] > 0.25 * powered(lows, power)[0]


@given(st.floats(-1e3, 1e3), st.floats(0.0, 1e-3), st.floats(1e-3, 1e3), st.floats(0.0, 1e-4), st.sampled_from(POWERS))
def test_lower_quotients_are_lower(a: float, error: float, q: float, of_q: float, power: float) -> None:
    low = lower_quotient(np.array([a]), np.array([error]), np.array([q]), np.array([of_q]), power)[0]
    for shift in (-1, 1):
        for of_shift in (-1, 1):
            x, y = Fraction(a) + shift * Fraction(error), Fraction(q) + of_shift * Fraction(of_q)
            assert at_most(-x, y, power, -Fraction(float(low)))


def test_where_the_divisor_may_vanish_there_is_no_bound() -> None:
    cells = Cells.whole(net((2,), 0), net((2,), 1), 2.0)
    bound, _ = cells.bounds()
    assert np.isinf(bound).any()
    zero = EnclosedNets.of_coefficients(np.zeros((6, COUNT)), (2,), np.zeros(COUNT))
    cells = Cells.whole(net((2,), 0), zero, 1.5)
    assert np.isposinf(cells.bounds()[0]).all()
    assert np.isneginf(cells.attained()[0]).all()
    assert (cells.attained()[1] <= 0.0).all()
