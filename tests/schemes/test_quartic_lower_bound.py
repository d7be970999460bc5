"""The lower bound on ordinates of quartic triangles: safe, sharp, homogeneous, and the one known for functions."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy.optimize import brentq

from testbed.geometry.bernstein import triangle_tables
from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.quartic_lower_bound import lower_ordinate

#: Ordinates of the corners in the order of the package: 400, 040, 004.
CORNER_PLACES = [0, 10, 14]
KNOWN = [
    ((1.0, 1.0, 1.0), 1.0 / 26.0),
    ((1.0, 2.0, 3.0), 0.06787608915365591),
    ((0.01, 1.0, 1.0), 0.004386889373784991),
    ((0.3, 0.7, 0.05), 0.0071059912752193515),
]


def random_corners(count: int, seed: int = 1) -> Float:
    """Corners (3, count) over many orders of magnitude."""
    return np.exp(np.random.default_rng(seed).uniform(-12.0, 3.0, (3, count)))


@pytest.mark.parametrize(("corners", "expected"), KNOWN)
def test_known_numbers(corners: tuple[float, float, float], expected: float) -> None:
    assert lower_ordinate(*(np.array([corner]) for corner in corners)) == pytest.approx([expected], rel=2e-14)


def excess(corners: Float, r: float) -> Decimal:
    """Return G(1 / r) - 1 in 200 digits."""
    with localcontext() as context:
        context.prec = 200
        power = Decimal(-1) / Decimal(3)
        s = 1 / Decimal(r)
        return sum(((1 + Decimal(float(corner)) * s) ** power for corner in corners), Decimal(-1))


def test_the_bound_holds_in_exact_arithmetic_and_hardly_more_would_not() -> None:
    corners = random_corners(60)
    extreme = np.array([[1e-300, 1e-9, 1.0], [1e-300, 1.0, 1.0], [5e-324, 1.0, 1e200], [1e-200, 1e-200, 3e-200]]).T
    for of_one in np.concatenate([corners, extreme], axis=1).T:
        r = float(lower_ordinate(*of_one[:, None])[0])
        if r > 0.0:
            assert excess(of_one, r) <= 0
            assert excess(of_one, r * (1.0 + 1e-13)) > 0
        else:  # the least corner vanishes beside the greatest
            assert of_one.min() / of_one.max() == 0.0


def test_the_bound_is_sharp() -> None:
    corners = random_corners(200)
    r = lower_ordinate(*corners)
    weights = (corners + r) ** (-1.0 / 3.0)
    b = (weights / weights.sum(axis=0)).T
    values = np.sum((corners + r).T * b**4, axis=1) - r
    assert np.abs(values / corners.max(axis=0)).max() < 1e-15


def test_quartics_on_the_bound_are_nowhere_negative() -> None:
    corners = random_corners(50, seed=2)
    net = np.repeat(-lower_ordinate(*corners)[:, None], 15, axis=1)
    net[:, CORNER_PLACES] = corners.T
    values = np.einsum("ln,pn->pl", triangle_tables(4, lattice(3, 60), 0)[0], net)
    assert values.min() >= -1e-15 * corners.max()
    assert values.min() < 1e-4


def test_it_is_the_condition_known_for_functions() -> None:
    # Piah, Saaban and Abd. Majid 2006: ordinates >= -r with 1 / r the root of sum of 1 / cbrt(1 + corner s) = 1, found
    # there between 26 / greatest and 26 / least corner by any method
    for of_one in random_corners(40, seed=3).T:

        def condition(s: float, corners: Float = of_one) -> float:
            return float(np.sum(1.0 / np.cbrt(1.0 + corners * s)) - 1.0)

        bracket = 25.9 / of_one.max(), 26.1 / of_one.min()
        expected = 1.0 / brentq(condition, *bracket, xtol=1e-300, rtol=1e-14)
        assert lower_ordinate(*of_one[:, None]) == pytest.approx([expected], rel=1e-11)


def test_it_lies_between_the_least_and_the_greatest_corner_over_26_and_does_not_fall() -> None:
    A, B, C = random_corners(500, seed=4)
    r = lower_ordinate(A, B, C)
    least, greatest = np.minimum(np.minimum(A, B), C) / 26.0, np.maximum(np.maximum(A, B), C) / 26.0
    assert (r >= least * (1.0 - 1e-13)).all()
    assert (r <= greatest).all()
    assert (lower_ordinate(1.5 * A, B, C) > r).all()


def test_it_is_symmetric_homogeneous_and_the_same_in_any_batch() -> None:
    A, B, C = random_corners(300, seed=5)
    r = lower_ordinate(A, B, C)
    for other in ((B, C, A), (C, A, B), (B, A, C), (C, B, A), (A, C, B)):
        assert np.array_equal(lower_ordinate(*other), r)
    assert np.array_equal(lower_ordinate(8.0 * A, 8.0 * B, 8.0 * C), 8.0 * r)
    assert lower_ordinate(3.7 * A, 3.7 * B, 3.7 * C) == pytest.approx(3.7 * r, rel=1e-13)
    assert np.array_equal(lower_ordinate(A[17:18], B[17:18], C[17:18]), r[17:18])
    assert np.array_equal(lower_ordinate(*(x.reshape(20, 15) for x in (A, B, C))), r.reshape(20, 15))


def test_a_corner_on_the_plane_leaves_no_room_and_one_below_has_no_bound() -> None:
    A = np.array([0.0, 0.0, 1.0, -1e-9, np.nan, np.inf])
    B = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    C = np.array([2.0, 0.0, 5.0, 1.0, 1.0, 1.0])
    np.testing.assert_array_equal(lower_ordinate(A, B, C), [0.0, 0.0, 0.0, np.nan, np.nan, np.nan])
    assert lower_ordinate(A[:0], B[:0], C[:0]).shape == (0,)
