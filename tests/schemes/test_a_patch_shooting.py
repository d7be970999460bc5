"""Thresholds of shooting polynomials: against their definition, the paper's lemma and the roots themselves."""

import numpy as np
import pytest

from testbed.geometry.cubic_roots import bracketed_roots
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.a_patch_shooting import shooting_bound


def polynomials(count: int, seed: int) -> Float:
    """Coefficients (4, count), b0 < 0."""
    b = np.random.default_rng(seed).normal(size=(4, count))
    b[0] = -np.abs(b[0])
    return b


def lemma_bound(b: Float) -> Float:
    """b_min of Lemma 2.3 for beta = 1, at the points where its two minima can be attained.

    The smaller of min max(-3 F2, -F3) / t^2 over [0, 1], and of min -F3 / t^2 where F1 <= 0; with sigma = (1 - t) / t.
    """
    b0, b1, b2, b3 = (row[:, None] for row in b)
    roots = np.array(
        [
            np.roots([2.0 * p[0], 3.0 * (p[0] + p[1]), 6.0 * p[1], 3.0 * p[2] - p[3]])
            for p in b.T  # a reference, one by one
        ]
    )
    end = np.maximum(0.0, -b1 / b0)
    real = (np.abs(roots.imag) < 1e-9) & (roots.real >= 0.0)
    sigma = np.concatenate([np.zeros(b0.shape), end, np.where(real, roots.real, np.nan)], axis=1)
    quadratic = -3.0 * (b0 * sigma**2 + 2.0 * b1 * sigma + b2)
    cubic = -(b0 * sigma**3 + 3.0 * b1 * sigma**2 + 3.0 * b2 * sigma + b3) / (1.0 + sigma)
    first = np.nanmin(np.maximum(quadratic, cubic), axis=1)
    second = np.nanmin(np.where(sigma >= end, cubic, np.nan), axis=1)
    lowest: Float = np.minimum(first, second)
    return lowest


def sampled_lemma(b: Float, t: Float) -> Float:
    """The same by its definition, on samples of (0, 1]."""
    b0, b1, b2, b3 = (row[:, None] for row in b)
    s = 1.0 - t
    F1, F2 = b0 * s + b1 * t, b0 * s * s + 2.0 * b1 * s * t + b2 * t * t
    F3 = b0 * s**3 + 3.0 * b1 * s * s * t + 3.0 * b2 * s * t * t + b3 * t**3
    first = np.maximum(-3.0 * F2, -F3) / (t * t)
    second = np.where(F1 <= 0.0, -F3 / (t * t), np.inf)
    lowest: Float = np.minimum(first.min(axis=1), second.min(axis=1))
    return lowest


def lifted(b: Float, free: Float) -> Float:
    """Coefficients (N, 4) with free t^2 added."""
    rows = b.T.copy()
    rows[:, 2] += free / 3.0
    rows[:, 3] += free
    return rows


def slopes(rows: Float, t: Float) -> Float:
    d0, d1, d2 = (rows[:, 1:] - rows[:, :-1]).T
    s = 1.0 - t
    slope: Float = 3.0 * (d0 * s * s + 2.0 * d1 * s * t + d2 * t * t)
    return slope


def test_above_it_the_first_root_exists_and_is_simple() -> None:
    b = polynomials(4000, 1)
    bound = shooting_bound(*b)
    for excess in (1e-6, 1e-2, 1.0, 100.0):
        rows = lifted(b, bound + excess)
        t = bracketed_roots(rows)
        assert (slopes(rows, t) > 0.0).all()


def test_just_below_it_the_root_is_gone_or_far_and_just_above_nearly_double() -> None:
    b = polynomials(4000, 2)
    bound = shooting_bound(*b)
    above, below = lifted(b, bound + 1e-9), lifted(b, bound - 1e-9)
    t = bracketed_roots(above)
    assert np.isfinite(t).all()
    after = bracketed_roots(below)
    inside = t < 1.0 - 1e-3  # else the threshold is -b3: the root leaves at t = 1, and is simple there
    assert 0.1 < inside.mean() < 0.9
    assert np.abs(slopes(above, t)[inside]).max() < 1e-2
    gone = np.isnan(after) | (after > t + 1e-5)
    assert gone[inside].all()
    leaving = ~inside & (np.abs(bound + b[3]) < 1e-12)
    assert np.isnan(after[leaving]).all()


def test_it_is_the_first_minimum_of_h_sampled_from_the_start() -> None:
    b = polynomials(300, 3)
    t = np.linspace(2e-3, 1.0, 20001)
    s = 1.0 - t
    b0, b1, b2, b3 = (row[:, None] for row in b)
    h = -(b0 * s**3 + 3.0 * b1 * s * s * t + 3.0 * b2 * s * t * t + b3 * t**3) / (t * t)
    rises = np.diff(h, axis=1) > 0.0
    first = np.where(rises.any(axis=1), rises.argmax(axis=1), len(t) - 1)
    sampled = h[np.arange(300), first]
    assert (np.abs(sampled - shooting_bound(*b)) < 1e-5 * (1.0 + np.abs(sampled))).all()


def test_the_lemma_is_never_below_and_mostly_the_same() -> None:
    b = polynomials(4000, 4)
    lemma, bound = lemma_bound(b), shooting_bound(*b)
    sampled = sampled_lemma(b[:, :300], np.linspace(1e-3, 1.0, 20001))
    # a minimum of a maximum has corners: samples are above it by a step's length at most
    assert (np.abs(sampled - lemma[:300]) < 2e-2 * (1.0 + np.abs(sampled))).all()
    assert (lemma - bound > -1e-9 * (1.0 + np.abs(bound))).all()
    same = np.abs(lemma - bound) <= 1e-9 * (1.0 + np.abs(bound))
    assert 0.87 < same.mean() < 0.92


def test_a_root_exists_just_above_it_where_the_lemma_asks_for_more() -> None:
    b = polynomials(4000, 5)
    bound = shooting_bound(*b)
    lower = lemma_bound(b) > bound + 1e-3
    assert lower.sum() > 100
    rows = lifted(b[:, lower], bound[lower] + 1e-4)
    assert (slopes(rows, bracketed_roots(rows)) > 0.0).all()


def test_it_scales_with_the_polynomial_and_against_the_factor() -> None:
    b, factor = polynomials(500, 6), np.random.default_rng(7).uniform(0.1, 10.0, 500)
    bound = shooting_bound(*b)
    assert np.abs(shooting_bound(*(2.0**40 * b)) / (2.0**40 * bound) - 1.0).max() < 1e-12
    assert np.abs(shooting_bound(b[0], b[1], b[2], b[3], factor) * factor / bound - 1.0).max() < 1e-12
    assert np.abs(shooting_bound(*(1e-200 * b)) / (1e-200 * bound) - 1.0).max() < 1e-12


def test_it_falls_without_limit_where_the_ray_starts_on_the_surface() -> None:
    """For b0 -> 0 and b1 > 0, like -9 b1^2 / (4 |b0|)."""
    b0 = -np.logspace(-300, -6, 50)
    b1, b2, b3 = 0.7, -1.3, 0.4
    bound = shooting_bound(b0, np.full(50, b1), np.full(50, b2), np.full(50, b3))
    near = -9.0 * b1 * b1 / (4.0 * np.abs(b0))
    seen = b0 < -1e-130
    assert np.abs(bound / near - 1.0)[seen].max() < 1e-4
    assert (bound[~seen] < -1e130).all()


@pytest.mark.parametrize("b", [(0.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0), (np.nan, 1.0, 1.0, 1.0)])
def test_nothing_is_said_where_the_ray_does_not_start_below(b: tuple[float, ...]) -> None:
    assert np.isnan(shooting_bound(*(np.array([one]) for one in b))).all()


def test_a_factor_that_is_not_positive_gives_no_number() -> None:
    b = polynomials(3, 8)
    assert np.isnan(shooting_bound(b[0], b[1], b[2], b[3], np.array([0.0, -1.0, np.nan]))).all()


def test_other_coefficients_that_are_not_finite_give_no_number() -> None:
    rows = np.array([[-1.0, np.nan, 1.0, 1.0], [-1.0, 1.0, np.nan, 1.0], [-1.0, 1.0, 1.0, np.nan]]).T
    assert np.isnan(shooting_bound(*rows)).all()


def test_no_bit_depends_on_the_other_polynomials() -> None:
    b = polynomials(1000, 9)
    bound = shooting_bound(*b)
    for chosen in ([17], [999, 3, 3, 500], list(range(999, -1, -1)), list(range(0, 1000, 7))):
        assert np.array_equal(shooting_bound(*b[:, chosen]), bound[chosen])
