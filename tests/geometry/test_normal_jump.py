"""The largest angle along an edge: never below dense sampling, attained, inside its enclosure, whatever the patches."""

from fractions import Fraction
from itertools import zip_longest
from typing import Any

import numpy as np
import pytest
from random_patch_pairs import DEGREES, FAMILIES, PatchPairs, elevated, pairs

from testbed.geometry.normal_jump import NormalJumps, normal_jumps
from testbed.geometry.normal_pairs import NormalPairs
from testbed.geometry.polynomials import basis, combine, multiply_dot, real_roots
from testbed.geometry.vectors import Float

#: 42 kinds of pairs: 10,500 pairs in all.
COUNT = 250
STEPS = 1000
every_degree = pytest.mark.parametrize("degrees", DEGREES, ids=str)
#: Where rounding leaves the bounds together.
EVEN = tuple(family for family in FAMILIES if family != "uneven")
every_family = pytest.mark.parametrize("family", FAMILIES)


def solved(some: PatchPairs) -> NormalJumps:
    return normal_jumps(some.normals())


def rounding(some: PatchPairs) -> Any:
    """What double precision makes of the largest angles, (E,): more where a normal is short beside its coefficients."""
    found = solved(some)
    return 1e-15 + (found.angle - found.low)


@every_family
@every_degree
def test_the_angle_is_that_of_dense_sampling_and_inside_its_bounds(degrees: tuple[int, int, int], family: str) -> None:
    some = pairs(family, degrees, COUNT)
    found, slack = solved(some), rounding(some)
    sampled = some.sampled(STEPS)
    peak = sampled.argmax(axis=0)
    # never below the samples, nor below what extended precision finds around the largest of them
    refined = some.refined(peak / STEPS, 1.0 / STEPS)
    assert (found.angle >= sampled.max(axis=0) - slack).all()
    assert (found.angle >= refined - slack).all()
    # above them by no more than what lies between the samples: the angle is attained where it is said to be
    attained = some.extended(found.t)
    assert (np.abs(found.angle - attained) <= slack).all()
    # and the enclosure is never on the wrong side
    assert (found.low <= attained).all()
    assert (found.high >= refined).all()
    assert (found.high >= attained).all()
    assert (found.low <= found.angle).all()
    assert (found.angle <= found.high).all()


@every_degree
@pytest.mark.parametrize("family", ["bent", "hermite", "with a gap"])
def test_samples_fall_short_by_the_curvature_of_the_angle_between_them(
    degrees: tuple[int, int, int], family: str
) -> None:
    some = pairs(family, degrees, COUNT, seed=1)
    found = solved(some)
    sampled = some.sampled(STEPS)
    inner = np.clip(sampled.argmax(axis=0), 1, STEPS - 1)
    before, here, after = (sampled[inner + step, np.arange(COUNT)] for step in (-1, 0, 1))
    short = 0.15 * np.abs(before - 2.0 * here + after)
    # not so where two peaks are as good as equal, or the angle is zero between them
    assert np.mean(found.angle - sampled.max(axis=0) <= short + 1e-13) > 0.99
    assert (found.angle - sampled.max(axis=0)).max() < 1e-4


@every_degree
@pytest.mark.parametrize("family", ["bent", "hermite", "with a gap", "rounded"])
def test_the_gap_of_the_enclosure_is_a_billionth(degrees: tuple[int, int, int], family: str) -> None:
    found = solved(pairs(family, degrees, COUNT, seed=2))
    assert ((found.high - found.low) <= 2e-9 * found.angle + 1e-11).all()


@every_degree
def test_the_gap_of_near_zero_angles_is_rounding(degrees: tuple[int, int, int]) -> None:
    found = solved(pairs("nearly smooth", degrees, COUNT, seed=3))
    assert (found.angle < 1e-5).all()
    assert (found.high - found.low).max() < 1e-10
    assert np.median(found.high - found.low) < 1e-12


@pytest.mark.parametrize("family", EVEN)
def test_run_the_other_way_the_edge_has_the_same_angle(family: str) -> None:
    some = pairs(family, (2, 2, 2), COUNT, seed=4)
    one, other = solved(some), solved(some.turned())
    slack = 2.0 * rounding(some)
    assert (np.abs(one.angle - other.angle) <= slack).all()
    assert (np.abs(some.extended(1.0 - other.t) - one.angle) <= slack).all()


@pytest.mark.parametrize("family", EVEN)
def test_the_angle_does_not_depend_on_the_frame_and_the_scale(family: str) -> None:
    some = pairs(family, (2, 2, 2), COUNT, seed=5)
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    one = solved(some)
    turned = solved(PatchPairs(*(np.einsum("xy,kye->kxe", turn, field) for field in some.fields)))
    assert (np.abs(one.angle - turned.angle) <= 4.0 * rounding(some)).all()
    for scale in (2.0**-500, 2.0**500):
        scaled = solved(PatchPairs(*(scale * field for field in some.fields)))
        np.testing.assert_array_equal(scaled.angle, one.angle)
        np.testing.assert_array_equal(scaled.high, one.high)


@pytest.mark.parametrize("family", EVEN)
@every_degree
def test_with_more_coefficients_the_angle_is_the_same(degrees: tuple[int, int, int], family: str) -> None:
    """Their leading terms vanish, so that all polynomials have lower degrees than their coefficients say."""
    some = pairs(family, degrees, 50, seed=6)
    raised = PatchPairs(*(elevated(field) for field in some.fields))
    one, other = solved(some), solved(raised)
    assert (np.abs(one.angle - other.angle) <= 4.0 * (rounding(some) + rounding(raised))).all()


def test_edges_do_not_depend_on_each_other() -> None:
    whole = solved(pairs("wild", (2, 2, 2), 200, seed=7))
    for chosen in (np.arange(0, 200, 3), np.arange(40)[::-1]):
        part = solved(pairs("wild", (2, 2, 2), 200, seed=7)[chosen])
        for name in ("angle", "t", "low", "high"):
            np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[chosen])


def test_below_the_floor_edges_are_left_and_their_bounds_hold() -> None:
    some = pairs("bent", (2, 2, 2), 500, seed=8)
    exact = solved(some)
    floor = float(np.median(exact.angle))
    found = normal_jumps(some.normals(), floor)
    above = exact.angle > floor
    np.testing.assert_array_equal(found.angle[above], exact.angle[above])
    assert found.settled[above].all()
    assert not found.settled.all()
    assert (found.low <= exact.angle).all()
    assert (found.high >= exact.angle).all()


def test_patches_with_a_common_tangent_plane_have_rounding_for_an_angle() -> None:
    """Delta is identically zero: there is nothing to find, and nothing to search long for."""
    T, _, F, _ = pairs("bent", (2, 2, 2), COUNT, seed=9).fields
    found = solved(PatchPairs(T, T, F, 0.4 * T - F))
    assert found.angle.max() < 1e-15
    assert found.high.max() < 1e-11
    assert np.median(found.high) < 1e-13
    assert found.settled.all()


def test_flat_patches_have_one_angle_everywhere() -> None:
    bend = np.radians(np.linspace(0.0, 179.0, 60))
    T = np.broadcast_to(np.array([1.0, 0.0, 0.0])[:, None], (3, 3, 60)) * np.array([1.0, 2.0, 1.5])[:, None, None]
    F = np.zeros((3, 3, 60))
    F[:, 0], F[:, 1] = 0.3, 1.0
    G = np.stack([np.full(60, 0.1), -np.cos(bend), np.sin(bend)])[None] * np.ones((3, 1, 1))
    found = solved(PatchPairs(T, T, F, G))
    np.testing.assert_allclose(found.angle, bend, atol=1e-14)
    assert (found.high - found.low).max() < 1e-12


def test_a_fold_between_samples_reads_180_degrees() -> None:
    """Where the triple product vanishes and the cosine is negative, normals are opposite: no stationary place."""
    T = np.zeros((3, 3, 1))
    T[:, 0] = 1.0
    F = np.zeros((3, 3, 1))
    F[:, 1] = 1.0
    G = F.copy()
    G[:, 2, 0] = [-0.3, 0.2, 0.5]
    found = solved(PatchPairs(T, T, F, G))
    assert found.angle[0] == pytest.approx(np.pi, abs=1e-9)
    assert np.pi <= found.high[0] < np.pi + 1e-15
    assert 0.1 < found.t[0] < 0.9


@pytest.mark.parametrize("end", [0, -1])
def test_a_normal_that_vanishes_at_an_end_has_no_angle(end: int) -> None:
    some = pairs("bent", (2, 2, 2), 5)
    some.into_left[end, :, 2] = 0.0
    found = solved(some)
    others = [0, 1, 3, 4]
    for values in (found.angle, found.low, found.high):
        assert np.isnan(values[2])
        assert np.isfinite(values[others]).all()
    np.testing.assert_array_equal(found.angle[others], solved(pairs("bent", (2, 2, 2), 5)).angle[others])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_has_no_angle(bad: float) -> None:
    some = pairs("bent", (2, 2, 2), 5)
    some.right[1, 0, 3] = bad
    found = solved(some)
    assert np.isnan(found.angle[3])
    assert np.isnan(found.high[3])
    assert np.isfinite(found.angle[:3]).all()


def test_a_normal_that_nearly_vanishes_inside_leaves_an_honest_bound() -> None:
    """The normal of the left patch all but vanishes in the middle, and turns round there."""
    some = pairs("bent", (2, 2, 2), 1)
    F = some.into_left
    F[0], F[2] = np.array([[0.0], [1.0], [0.1]]), np.array([[0.0], [-1.0], [0.1]])
    F[1] = np.array([[0.0], [0.0], [-0.1 + 1e-13]])
    found = solved(some)
    dense = some.sampled(20_000).max()
    assert found.high[0] >= dense
    assert found.angle[0] >= dense - 1e-6


# --- the polynomials behind it ---


def test_the_derivative_of_cos_squared_has_the_triple_product_for_a_factor() -> None:
    """2 N' D^2 - N (D^2)' = -2 Delta Q, at many parameters."""
    normals = pairs("wild", (2, 2, 2), 50).normals()
    A, B, N = normals.left.normals, normals.right.normals, normals.cosine
    squares = multiply_dot(A, A), multiply_dot(B, B)
    delta, Q = normals.triple_product(), normals.reduced_factor()
    assert (len(delta), len(Q)) == (7, 17)
    for t in np.linspace(0.0, 1.0, 17):
        (a, a1), (b, b1), (n, n1) = (value_and_slope(p, t) for p in (*squares, N))
        printed = 2.0 * n1 * a * b - n * (a1 * b + a * b1)
        product = -2.0 * value_and_slope(delta, t)[0] * value_and_slope(Q, t)[0]
        np.testing.assert_allclose(printed, product, atol=1e-11 * np.abs(printed).max())


def value_and_slope(p: Float, t: float) -> tuple[Float, Float]:
    at = np.full(1, t)
    slope = (len(p) - 1) * np.diff(p, axis=0)
    return combine(basis(len(p) - 1, at), p), combine(basis(len(p) - 2, at), slope)


def test_the_printed_degree_19_is_22_and_the_reduced_one_16() -> None:
    """In rational numbers: 2 N' D^2 - N (D^2)' is -2 Delta Q to the last digit, of degree 22; Q has degree 16."""
    rng = np.random.default_rng(0)
    T, F, G = ([[Fraction(int(c)) for c in row] for row in rng.integers(-9, 10, size=(3, 3))] for _ in range(3))
    A, B = cross_exact(T, F), cross_exact(G, T)
    N, DD = dot_exact(A, B), product(dot_exact(A, A), dot_exact(B, B))
    printed = difference(product([Fraction(2)], product(slope(N), DD)), product(N, slope(DD)))
    delta, s = dot_exact(A, G), dot_exact(T, T)
    half = [c / 2 for c in slope(s)]
    Q = difference(
        product(total(product(half, delta), product(s, slope(delta))), N), product(product(s, delta), slope(N))
    )
    assert printed == product([Fraction(-2)], product(delta, Q))
    assert (degree(N), degree(delta), degree(Q), degree(printed)) == (8, 6, 16, 22)
    assert degree(printed) != 19


def cross_exact(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[list[Fraction]]:
    return [difference(product(a[k - 2], b[k - 1]), product(a[k - 1], b[k - 2])) for k in range(3)]


def dot_exact(a: list[list[Fraction]], b: list[list[Fraction]]) -> list[Fraction]:
    return total(*(product(p, q) for p, q in zip(a, b, strict=True)))


def product(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    """Coefficients of powers, the constant first."""
    result = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, one in enumerate(p):
        for j, other in enumerate(q):
            result[i + j] += one * other
    return trimmed(result)


def total(*terms: list[Fraction]) -> list[Fraction]:
    return trimmed([sum(some, Fraction(0)) for some in zip_longest(*terms, fillvalue=Fraction(0))])


def difference(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    return total(p, [-c for c in q])


def slope(p: list[Fraction]) -> list[Fraction]:
    return [i * c for i, c in enumerate(p)][1:]


def trimmed(p: list[Fraction]) -> list[Fraction]:
    while len(p) > 1 and p[-1] == 0:
        p = p[:-1]
    return p


def degree(p: list[Fraction]) -> int:
    return len(trimmed(p)) - 1


def test_with_common_tangent_planes_at_the_ends_the_triple_product_vanishes_there() -> None:
    delta = pairs("hermite", (2, 2, 2), 50).normals().triple_product()
    assert np.abs(delta[[0, -1]]).max() < 1e-14
    assert np.abs(delta[1:-1]).max() > 1e-2


@every_degree
def test_both_factors_vanish_where_the_angle_is_stationary(degrees: tuple[int, int, int]) -> None:
    """Of any two patches <V, V'N - VN'> has the sign; with a common boundary curve it is Delta Q."""
    normals = pairs("wild", degrees, 40).normals()
    m, p, q = degrees
    assert len(normals.reduced_factor()) == max(5 * m + 2 * p + 2 * q - 1, 1)
    t = np.full(1, 0.37)
    general, delta, Q = (
        combine(basis(len(f) - 1, t), f)
        for f in (normals.general_factor(), normals.triple_product(), normals.reduced_factor())
    )
    np.testing.assert_allclose(general, delta * Q, atol=1e-11 * np.abs(general).max())


def test_at_the_roots_of_the_cosine_the_angle_passes_through_90_degrees() -> None:
    """The thesis looks there as well; no largest angle is there."""
    some = pairs("wild", (2, 2, 2), 400, seed=10)
    normals = some.normals()
    row, t = real_roots(normals.cosine)
    found = solved(some)
    angle = normals.angles(t, row)[0]
    at_roots = np.abs(angle - np.pi / 2) < 1e-9
    assert at_roots.sum() > 100
    assert (angle <= found.angle[row] + 1e-12).all()
    assert (found.angle[row[at_roots]] > np.pi / 2).all()


def test_the_bound_of_rounding_is_one() -> None:
    """Coefficients of N and V in rational numbers, also where the derivatives are of very different lengths."""
    wild = pairs("wild", (2, 2, 2), 8, seed=11)
    lengths = np.array([1.0, 1e-6, 1e3])[:, None, None]
    normals = PatchPairs(*(lengths * field for field in wild.fields)).normals()
    for edge in range(8):
        exact = exact_coefficients(normals, edge)
        scale = Fraction(float(normals.error[edge]))
        for k in range(9):
            wrong = [
                Fraction(float(normals.cosine[k, edge])) - exact[0][k],
                *(Fraction(float(normals.sine[k, x, edge])) - exact[1 + x][k] for x in range(3)),
            ]
            assert abs(wrong[0]) <= scale
            assert sum(w * w for w in wrong[1:]) <= scale * scale


def exact_coefficients(normals: NormalPairs, edge: int) -> list[list[Fraction]]:
    """Bernstein coefficients of N and of the components of V, from the derivatives as floats."""

    def powers(field: Float | None) -> list[list[Fraction]]:
        assert field is not None
        c = [[Fraction(float(x)) for x in row] for row in field[..., edge]]
        return [[c[0][x], 2 * (c[1][x] - c[0][x]), c[2][x] - 2 * c[1][x] + c[0][x]] for x in range(3)]

    A = cross_exact(powers(normals.left.tangents), powers(normals.left.across))
    B = cross_exact(powers(normals.right.tangents), powers(normals.right.across))
    return [bernstein(p, 8) for p in (dot_exact(A, B), *cross_exact(A, B))]


def bernstein(p: list[Fraction], n: int) -> list[Fraction]:
    """Coefficients in Bernstein form of degree n of a polynomial in powers."""
    p = p + [Fraction(0)] * (n + 1 - len(p))
    return [
        sum((Fraction(binomial(k, i), binomial(n, i)) * p[i] for i in range(k + 1)), Fraction(0)) for k in range(n + 1)
    ]


def binomial(n: int, k: int) -> int:
    result = 1
    for i in range(k):
        result = result * (n - i) // (i + 1)
    return result
