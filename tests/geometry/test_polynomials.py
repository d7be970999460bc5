import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.polynomials import (
    basis,
    combine,
    divide,
    multiply,
    multiply_cross,
    multiply_dot,
    real_roots,
    sign_changes,
    wronskian,
)
from testbed.geometry.vectors import Float, cross, dot

T = np.linspace(0.0, 1.0, 23)


def at(p: Float, t: Float = T) -> Float:
    """Values (S, ..., R) at parameters (S,)."""
    return np.stack([combine(basis(len(p) - 1, np.full(1, one)), p) for one in t])


def derivative(p: Float) -> Float:
    return np.asarray((len(p) - 1) * np.diff(p, axis=0))


def random(seed: int, *shape: int) -> Float:
    return np.random.default_rng(seed).normal(size=shape)


def with_roots(roots: Float) -> Float:
    """Polynomials (n + 1, R) with the roots (n, R)."""
    p = np.ones((1, roots.shape[1]))
    for root in roots:
        p = multiply(p, np.stack([-root, 1.0 - root]))
    return p


@pytest.mark.parametrize(("m", "n"), [(0, 0), (0, 3), (2, 5), (8, 7)])
def test_products_are_those_of_the_values(m: int, n: int) -> None:
    p, q = random(0, m + 1, 3, 5), random(1, n + 1, 3, 5)
    np.testing.assert_allclose(at(multiply(p, q)), at(p) * at(q), atol=1e-13)
    np.testing.assert_allclose(at(multiply_dot(p, q)), (at(p) * at(q)).sum(axis=1), atol=1e-13)
    product = cross(np.moveaxis(at(p), 1, -1), np.moveaxis(at(q), 1, -1))
    np.testing.assert_allclose(np.moveaxis(at(multiply_cross(p, q)), 1, -1), product, atol=1e-13)
    assert dot(product, product).max() > 1e-3


@pytest.mark.parametrize("n", [0, 1, 4, 8])
def test_a_wronskian_is_written_with_its_true_degree(n: int) -> None:
    p, q = random(2, n + 1, 6), random(3, n + 1, 6)
    found = wronskian(p, q)
    assert len(found) == max(2 * n - 1, 1)
    expected = at(derivative(p)) * at(q) - at(p) * at(derivative(q)) if n else np.zeros((len(T), 6))
    np.testing.assert_allclose(at(found), expected, atol=1e-12)


@pytest.mark.parametrize("cut", [0.5, 0.125, 0.7])
def test_a_divided_polynomial_is_the_same_on_both_pieces(cut: float) -> None:
    p = random(4, 8, 5)
    before, after = divide(p, np.full(5, cut))
    np.testing.assert_allclose(at(before), at(p, cut * T), atol=1e-14)
    np.testing.assert_allclose(at(after), at(p, cut + (1.0 - cut) * T), atol=1e-14)
    np.testing.assert_array_equal(before[-1], after[0])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(-0.5, 1.5), min_size=1, max_size=12))
def test_descartes_rule_holds(roots: list[float]) -> None:
    column = np.array(roots)[:, None]
    inside = np.count_nonzero((column > 1e-9) & (column < 1.0 - 1e-9))
    assert sign_changes(with_roots(column))[0] >= inside - 2 * np.count_nonzero(np.abs(np.diff(np.sort(roots))) < 1e-3)


@pytest.mark.parametrize("inside", [0, 1, 3, 6])
def test_all_roots_are_found(inside: int) -> None:
    rng = np.random.default_rng(inside)
    count = 300
    # apart by 0.03 at least: how far a root is determined depends on its distance from the others
    spread = np.sort(rng.uniform(0.0, 1.0 - 0.03 * (inside + 1), size=(inside, count)), axis=0)
    roots = spread + 0.03 * np.arange(1, inside + 1)[:, None]
    outside = rng.choice([-1.0, 1.0], size=(4, count)) * rng.uniform(1.2, 3.0, size=(4, count)) + 0.5
    row, found = real_roots(with_roots(np.concatenate([roots, outside])))
    assert ((found >= 0.0) & (found <= 1.0)).all()
    for index in range(inside):
        nearest = np.full(count, np.inf)
        np.minimum.at(nearest, row, np.abs(found - roots[index][row]))
        assert nearest.max() < 1e-9


def test_roots_at_points_of_division_and_double_roots_are_found() -> None:
    roots = np.array([[0.5, 0.25, 0.3, 0.7], [2.0, 0.75, 0.3, 0.7], [-1.0, 0.5, 3.0, 0.7]])
    row, found = real_roots(with_roots(roots))
    for index in range(roots.shape[1]):
        inside = roots[(roots[:, index] > 0.0) & (roots[:, index] < 1.0), index]
        nearest = np.abs(found[row == index][:, None] - inside).min(axis=0)
        # a double root is a cluster of width 1e-8, a threefold one of 1e-5
        assert nearest.max() < 1e-4


def test_without_a_root_there_is_none() -> None:
    row, found = real_roots(np.array([[1.0, -1.0], [3.0, -2.0], [0.5, -1.0]]))
    assert len(row) == len(found) == 0


def test_rows_do_not_depend_on_each_other() -> None:
    p = random(5, 17, 200)
    row, found = real_roots(p)
    for chosen in (np.arange(0, 200, 7), np.arange(50)[::-1]):
        some, there = real_roots(p[:, chosen])
        for index, one in enumerate(chosen):
            np.testing.assert_array_equal(np.sort(there[some == index]), np.sort(found[row == one]))
