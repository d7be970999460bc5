import numpy as np
import pytest

from testbed.geometry.cubic_roots import (
    bernstein,
    bernstein_slope,
    bracketed_roots,
    closed_form,
    extended_roots,
    first_roots,
    scaled_rows,
)
from testbed.geometry.vectors import Float

INF, NAN = np.inf, np.nan


def random_cubics(count: int, seed: int) -> Float:
    """Cubics with b_0 < 0: plain ones, and ones with tiny b_3, tiny b_0, tiny b_2 and b_3, any two of them."""
    rng = np.random.default_rng(seed)
    b = rng.normal(size=(count, 4))
    b[:, 0] = -np.abs(b[:, 0])
    fifth = count // 5
    for family, columns in enumerate(([3], [0], [2, 3], [0, 3]), start=1):
        chosen = slice(family * fifth, (family + 1) * fifth)
        b[chosen, columns] *= 10.0 ** rng.uniform(-18, 0, (fifth, len(columns)))
    return b


def from_roots(leading: float, *roots: complex) -> list[float]:
    """Bernstein coefficients of the cubic with these roots in s = t / (1 - t)."""
    monomials = leading * np.poly(roots).real
    padded = np.concatenate([np.zeros(4 - len(monomials)), monomials])
    a, b, c, d = padded.tolist()
    return [d, c / 3.0, b / 3.0, a]


def at(s: float) -> float:
    return s / (1.0 + s)


@pytest.fixture(scope="module")
def cubics() -> Float:
    return random_cubics(200_000, 1)


def test_closed_form_and_bracketing_agree(cubics: Float) -> None:
    closed, bracketed = first_roots(cubics), bracketed_roots(cubics)
    found = np.where(np.isnan(closed), bracketed, closed)
    slope = np.abs(bernstein_slope(cubics.T, found)) / np.abs(cubics).max(axis=1)
    simple = slope > 1e-3
    assert simple.sum() > 120_000
    np.testing.assert_array_equal(np.isnan(closed[simple]), np.isnan(bracketed[simple]))
    np.testing.assert_allclose(closed[simple], bracketed[simple], rtol=0.0, atol=1e-12)
    # where the slope is smaller, so is what rounding leaves of the root; and nobody sees a root the other does not
    both = ~np.isnan(closed) & ~np.isnan(bracketed)
    assert np.max((np.abs(closed - bracketed) * slope)[both]) < 1e-14
    np.testing.assert_array_equal(np.isnan(closed), np.isnan(bracketed))


def test_roots_are_the_first_ones(cubics: Float) -> None:
    some = cubics[::40]
    t = first_roots(some)
    samples = np.linspace(0.0, 1.0, 400, endpoint=False)[:, None]
    before = samples < np.where(np.isnan(t), 1.0, t - 1e-9)
    assert np.max(np.where(before, bernstein(some.T, samples), -1.0)) <= 1e-15


def test_small_roots_have_all_their_digits() -> None:
    rng = np.random.default_rng(2)
    b = rng.normal(size=(1000, 4))
    b[:, 0], b[:, 1] = -(10.0 ** rng.uniform(-300, -8, 1000)), rng.uniform(0.2, 1.0, 1000)
    # t = -b_0 / (3 b_1) + O(b_0^2)
    small = b[:, 0] > -1e-17
    expected = -b[:, 0] / (3.0 * b[:, 1])
    np.testing.assert_allclose(first_roots(b)[small], expected[small], rtol=1e-14)
    np.testing.assert_allclose(first_roots(b), bracketed_roots(b), rtol=1e-13)


@pytest.mark.parametrize(
    ("b", "expected"),
    [
        # a > 0, b >= 0: the only positive root, with two negative or two complex ones beside
        (from_roots(2.0, 0.5, -1.0, -3.0), 0.5),
        (from_roots(2.0, 0.5, -1.0 + 2.0j, -1.0 - 2.0j), 0.5),
        # a > 0, b < 0 < c: three positive roots, or one
        (from_roots(1.0, 0.25, 1.0, 3.0), 0.25),
        (from_roots(1.0, 0.25, 2.0 + 1.0j, 2.0 - 1.0j), 0.25),
        (from_roots(1.0, 4.0, 0.2 + 0.1j, 0.2 - 0.1j), 4.0),
        # a > 0, b < 0, c <= 0: one positive root, two negative ones
        (from_roots(1.0, 4.0, -0.5, -0.25), 4.0),
        (from_roots(1.0, 0.5, 0.5, 0.5), 0.5),
        # a < 0: the smaller of two positive roots
        (from_roots(-1.0, 0.5, 2.0, -1.0), 0.5),
        (from_roots(-1.0, 0.125, 0.25, -30.0), 0.125),
        (from_roots(-1.0, -0.5, -2.0, -1.0), NAN),
        (from_roots(-1.0, -0.5, 2.0 + 1.0j, 2.0 - 1.0j), NAN),
        # a negative root so small that rounding might move it to the start
        (from_roots(-1.0, -1e-18, 0.5 + 2.0j, 0.5 - 2.0j), NAN),
        (from_roots(1.0, -1e-18, -2.0, 0.5), 0.5),
        # b_3 = 0: a quadratic; b_2 = 0 too: linear; all that is left is constant
        (from_roots(1.0, 0.5, -2.0), 0.5),
        (from_roots(-1.0, 0.5, 2.0), 0.5),
        (from_roots(-1.0, -0.5, -2.0), NAN),
        (from_roots(-1.0, 0.5 + 1.0j, 0.5 - 1.0j), NAN),
        (from_roots(3.0, 0.5), 0.5),
        (from_roots(-3.0, -0.5), NAN),
        ([-1.0, 0.0, 0.0, 0.0], NAN),
        # pure powers
        ([-1.0, 0.0, 0.0, 8.0], 0.5),
        ([-3.0, 0.0, 4.0, 0.0], 0.5),
        # at the start; beyond it; not finite
        ([0.0, 1.0, 1.0, 1.0], 0.0),
        ([-0.0, -1.0, -1.0, -1.0], 0.0),
        ([0.0, 0.0, 0.0, 0.0], 0.0),
        ([1e-9, -1.0, -1.0, -1.0], NAN),
        ([-1.0, NAN, 1.0, 1.0], NAN),
        ([-1.0, 1.0, 1.0, INF], NAN),
        ([-INF, 1.0, 1.0, 1.0], NAN),
        ([NAN, 1.0, 1.0, 1.0], NAN),
        # a root at the end does not count
        ([-1.0, -1.0, -1.0, 0.0], NAN),
        ([-1.0, -1.0, -1.0, -1.0], NAN),
    ],
)
def test_each_case(b: list[float], expected: float) -> None:
    t = at(expected) if expected > 0.0 else expected
    for roots in (first_roots, bracketed_roots):
        # the triple root is known to a third of the digits
        tolerance = 1e-5 if b == from_roots(1.0, 0.5, 0.5, 0.5) else 1e-14
        np.testing.assert_allclose(roots(np.array(b)), t, rtol=tolerance, atol=0.0)


def test_simple_roots_in_general_position_need_no_bisection() -> None:
    b = np.random.default_rng(4).normal(size=(20_000, 4))
    b[:, 0] = -np.abs(b[:, 0])
    b[:10_000, 3] = 0.0
    b[:2_000, 2] = 0.0
    # positive leading coefficients: there is a root
    lead = np.where(b[:, 2] == 0.0, 1, np.where(b[:, 3] == 0.0, 2, 3))
    b[np.arange(len(b)), lead] = np.abs(b[np.arange(len(b)), lead])
    t, certain = closed_form(scaled_rows(b)[0])
    assert certain.mean() > 0.9999
    np.testing.assert_allclose(t[certain], bracketed_roots(b)[certain], atol=1e-9)


def test_a_cubic_that_touches_zero_first_has_one_of_its_two_roots() -> None:
    t = first_roots(np.array(from_roots(1.0, 1.0, 1.0, 3.0)))
    assert min(abs(t - at(1.0)), abs(t - at(3.0))) < 1e-7


def test_double_roots_are_where_the_number_of_roots_changes() -> None:
    # s^3 - 3 s + 2 = (s - 1)^2 (s + 2), mirrored: two roots just above, none just below
    touching = -np.array(from_roots(1.0, 1.0, 1.0, -2.0))
    b = touching + np.outer(np.array([1e-6, 1e-9, 1e-12, -1e-12, -1e-9, -1e-6]), [1.0, 0.0, 0.0, 0.0])
    t = first_roots(b)
    np.testing.assert_allclose(t[:3], 0.5, atol=2e-4)
    assert (t[:3] < 0.5).all()
    assert np.isnan(t[3:]).all()
    np.testing.assert_allclose(t, bracketed_roots(b), atol=1e-9)


@pytest.mark.parametrize("exponent", [-1000, -500, -498, 1, 498, 500, 1000])
def test_scale_does_not_matter(exponent: int, cubics: Float) -> None:
    # powers of two: about 1e-300, 1e-150, 1e150, 1e300; to the last bit as long as no coefficient underflows
    b = cubics[:40_000:4]
    np.testing.assert_array_equal(first_roots(np.ldexp(b, exponent)), first_roots(b))
    np.testing.assert_array_equal(bracketed_roots(np.ldexp(b, exponent)), bracketed_roots(b))
    mirrored = b * [-1.0, 1.0, 1.0, 1.0]
    np.testing.assert_array_equal(extended_roots(np.ldexp(mirrored, exponent)), extended_roots(mirrored))


@pytest.mark.parametrize("roots", [first_roots, bracketed_roots, extended_roots])
def test_company_and_shape_do_not_change_a_bit(roots: object, cubics: Float) -> None:
    assert callable(roots)
    b = cubics[::97].copy()
    b[::2, 0] *= -1.0 if roots is extended_roots else 1.0
    whole = roots(b)
    shuffled = np.random.default_rng(3).permutation(len(b))
    np.testing.assert_array_equal(roots(b[shuffled]), whole[shuffled])
    for size in (1, 2, 3, 7, 1000):
        parts = [roots(b[start : start + size]) for start in range(0, min(len(b), 50 * size), size)]
        np.testing.assert_array_equal(np.concatenate(parts), whole[: 50 * size])
    np.testing.assert_array_equal(roots(b[:60].reshape(3, 5, 4, 4)), whole[:60].reshape(3, 5, 4))
    np.testing.assert_array_equal(roots(np.asfortranarray(b)), whole)
    assert roots(b[0]).shape == ()
    assert roots(np.zeros((0, 4))).shape == (0,)


def test_roots_behind_the_start_are_the_nearest_ones() -> None:
    # s in (-1, 0) is t < 0: roots at s = -0.5 and -0.9 are t = -1 and -9
    b = np.array(
        [
            from_roots(1.0, -0.5, -0.9, -3.0),
            from_roots(1.0, -0.5, 2.0, 3.0),
            from_roots(-1.0, -0.2, -0.9, 3.0),
            from_roots(1.0, -1.5, -2.0, -3.0),
            from_roots(1.0, -4.0, 1.0 + 1.0j, 1.0 - 1.0j),
        ]
    )
    assert (b[:, 0] > 0.0).all()
    np.testing.assert_allclose(extended_roots(b), [-1.0, -1.0, -0.25, NAN, NAN], rtol=1e-13)
    np.testing.assert_array_equal(extended_roots(np.array([[0.0, 1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, 1.0]])), [0.0, NAN])


def test_roots_behind_the_start_are_roots(cubics: Float) -> None:
    b = cubics[::10] * np.array([-1.0, 1.0, 1.0, 1.0])
    t = extended_roots(b)
    found = ~np.isnan(t)
    assert found.mean() > 0.3
    assert (t[found] <= 0.0).all()
    # far away on the ray, terms are large: they are compared with their own size
    near = found & (t > -100.0)
    size = sum(np.abs(term) for term in terms(b[near], t[near]))
    assert np.max(np.abs(sum(terms(b[near], t[near]))) / size) < 1e-13
    # and nothing is nearer
    for fraction in np.linspace(0.0, 0.999, 50):
        assert (bernstein(b[near].T, fraction * t[near]) > -1e-15 * np.abs(b[near]).max(axis=1)).all()


def terms(b: Float, t: Float) -> list[Float]:
    return [c * b[:, s] * t**s * (1.0 - t) ** (3 - s) for s, c in enumerate((1.0, 3.0, 3.0, 1.0))]


def test_roots_pass_through_the_start_without_a_jump() -> None:
    step = 1e-9
    ahead, behind = first_roots(np.array([-step, 1.0, 0.5, 2.0])), extended_roots(np.array([step, 1.0, 0.5, 2.0]))
    assert ahead > 0.0 > behind
    np.testing.assert_allclose(ahead, -behind, rtol=1e-8)
