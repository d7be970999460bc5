"""All real roots of three quadrics: planted ones, counts by exact elimination, multiple roots, degenerate systems."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial import polynomial

from testbed.geometry.vectors import Float, Int, norm
from testbed_schemes.mathematics.three_quadrics import ROOTS, real_roots, values

Poly = list[Fraction]


def random_systems(count: int, seed: int) -> Float:
    half = np.random.default_rng(seed).normal(size=(count, 3, 4, 4))
    systems: Float = half + half.swapaxes(-1, -2)
    return systems


def numbers(roots: Float) -> Int:
    return np.asarray(np.isfinite(roots).all(axis=2).sum(axis=1))


def symmetric(product: Float) -> Float:
    half: Float = 0.5 * (product + product.swapaxes(-1, -2))
    return half


def moved(quadrics: Float, matrix: Float, shift: Float) -> Float:
    """Quadrics (N, 3, 4, 4) whose roots are matrix x + shift of the roots x of before."""
    there = np.eye(4)
    there[1:, 1:], there[1:, 0] = np.linalg.inv(matrix), -np.linalg.solve(matrix, shift)
    result: Float = np.einsum("ki,nqkl,lj->nqij", there, quadrics, there)
    return result


def test_a_planted_root_is_found_and_every_root_is_one() -> None:
    systems, planted = random_systems(400, 1), np.random.default_rng(2).normal(size=(400, 3))
    systems[:, :, 0, 0] -= values(systems, planted)[0]
    roots = real_roots(systems)
    assert np.nanmin(norm(roots - planted[:, None]), axis=1).max() < 1e-10
    value, terms = values(systems[:, None], np.nan_to_num(roots))
    assert (np.abs(value) <= 1e-12 * terms)[np.isfinite(roots[..., 0])].all()
    # complex ones come in pairs
    assert set(numbers(roots).tolist()) <= {2, 4, 6, 8}


def test_eight_planted_roots_are_all_found() -> None:
    random = np.random.default_rng(3)
    low, high = random.uniform(-1.0, -0.1, (200, 3)), random.uniform(0.1, 1.0, (200, 3))
    systems = np.zeros((200, 3, 4, 4))
    axes = np.arange(3)
    systems[:, axes, axes + 1, axes + 1] = 1.0
    systems[:, axes, 0, axes + 1] = systems[:, axes, axes + 1, 0] = -0.5 * (low + high)
    systems[:, axes, 0, 0] = low * high
    mixture = random.normal(size=(200, 3, 3))
    matrix, shift = random.normal(size=(3, 3)), random.normal(size=3)
    roots = real_roots(moved(np.einsum("npq,nqij->npij", mixture, systems), matrix, shift))
    assert (numbers(roots) == ROOTS).all()
    corners = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(8, 3)
    planted = np.where(corners, high[:, None], low[:, None]) @ matrix.T + shift
    assert norm(roots[:, :, None] - planted[:, None])[:, :8].min(axis=1).max() < 1e-7


def test_no_real_root_is_invented() -> None:
    # x^2 + 1, mixed with two others in the same way as planted ones
    systems = random_systems(100, 4)
    systems[:, 0] = np.diag([1.0, 1.0, 0.0, 0.0])
    systems = np.einsum("npq,nqij->npij", np.random.default_rng(5).normal(size=(100, 3, 3)), systems)
    assert not numbers(real_roots(systems)).any()


def multiply(*factors: Poly) -> Poly:
    product: Poly = [Fraction(1)]
    for factor in factors:
        product = [
            sum((product[i] * factor[k - i] for i in range(len(product)) if 0 <= k - i < len(factor)), Fraction(0))
            for k in range(len(product) + len(factor) - 1)
        ]
    return product


def add(*terms: Poly) -> Poly:
    return [sum((t[k] for t in terms if k < len(t)), Fraction(0)) for k in range(max(len(t) for t in terms))]


def negative(p: Poly) -> Poly:
    return [-c for c in p]


def sturm_count(p: Poly) -> int:
    """Number of different real roots."""

    def trimmed(q: Poly) -> Poly:
        while q and q[-1] == 0:
            q = q[:-1]
        return q

    def remainder(a: Poly, b: Poly) -> Poly:
        while len(a) >= len(b):
            factor, gap = a[-1] / b[-1], len(a) - len(b)
            a = trimmed([c - (factor * b[k - gap] if k >= gap else 0) for k, c in enumerate(a)])
        return a

    chain = [trimmed(p), trimmed([k * c for k, c in enumerate(p)][1:])]
    while chain[-1]:
        chain.append(negative(remainder(chain[-2], chain[-1])))
    chain.pop()

    def changes(sign: int) -> int:
        signs = [(q[-1] > 0) == (sign > 0 or len(q) % 2 == 1) for q in chain]
        return sum(one != other for one, other in pairwise(signs))

    return changes(-1) - changes(1)


def eliminated(system: Int) -> Poly:
    """The resultant in z of an integer system, exactly: x^2, xy, y^2 are made linear in x and y, and multiplied."""
    A = [[Fraction(int(c)) for c in row] for row in system.reshape(3, 16)]
    # columns x^2, xy, y^2 | x (1, z) | y (1, z) | 1, z, z^2
    rows = [[a[5], 2 * a[6], a[10], 2 * a[1], 2 * a[7], 2 * a[2], 2 * a[11], a[0], 2 * a[3], a[15]] for a in A]
    for k in range(3):
        pivot = next(r for r in range(k, 3) if rows[r][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [c / rows[k][k] for c in rows[k]]
        for r in range(3):
            if r != k:
                rows[r] = [c - rows[r][k] * d for c, d in zip(rows[r], rows[k], strict=True)]
    P, Q, R = ([negative(row[part]) for row in rows] for part in (slice(3, 5), slice(5, 7), slice(7, 10)))

    def linear(xx: Poly, xy: Poly, yy: Poly, x: Poly, y: Poly, one: Poly) -> list[Poly]:
        square = (xx, xy, yy)
        return [
            add(own, *(multiply(s, part) for s, part in zip(square, parts, strict=True)))
            for own, parts in ((x, P), (y, Q), (one, R))
        ]

    zero: Poly = [Fraction(0)]
    M = [
        linear(negative(P[1]), add(P[0], negative(Q[1])), Q[0], negative(R[1]), R[0], zero),
        linear(negative(P[2]), add(P[1], negative(Q[2])), Q[1], negative(R[2]), R[1], zero),
        linear(
            *(
                add(
                    multiply(a[1], b[1]),
                    multiply(b[1], a[1]),
                    negative(multiply(a[0], b[2])),
                    negative(multiply(b[0], a[2])),
                )
                if a is not b
                else add(multiply(a[1], a[1]), negative(multiply(a[0], a[2])))
                for a, b in ((P, P), (P, Q), (Q, Q), (P, R), (Q, R), (R, R))
            )
        ),
    ]
    cofactor = [
        add(multiply(M[1][a], M[2][b]), negative(multiply(M[1][b], M[2][a]))) for a, b in ((1, 2), (2, 0), (0, 1))
    ]
    return add(*(multiply(m, c) for m, c in zip(M[0], cofactor, strict=True)))


def test_numbers_of_roots_are_those_of_exact_elimination() -> None:
    half = np.random.default_rng(6).integers(-9, 10, size=(60, 3, 4, 4))
    systems = half + half.swapaxes(-1, -2)
    exact = [eliminated(system) for system in systems]
    assert {len(p) for p in exact} == {9}
    roots = real_roots(systems.astype(np.float64))
    assert numbers(roots).tolist() == [sturm_count(p) for p in exact]
    # and they are roots of the resultant
    for p, found in zip(exact, roots, strict=True):
        z = found[np.isfinite(found[:, 2]), 2]
        value = polynomial.polyval(z, np.array([float(c) for c in p]))
        scale = polynomial.polyval(np.abs(z), np.abs([float(c) for c in p]))
        assert (np.abs(value) < 1e-10 * scale).all()


@pytest.mark.parametrize(("rank", "accuracy"), [(3, 1e-9), (2, 1e-4), (1, 1e-4), (0, 1e-4)])
def test_a_multiple_root_is_found(rank: int, accuracy: float) -> None:
    """Of multiplicity 1, 2, 4 and 8: the gradients at the origin span a space of that rank."""
    random = np.random.default_rng(7)
    systems = random_systems(100, 8)
    gradients = random.normal(size=(100, 3, rank)) @ random.normal(size=(100, rank, 3))
    systems[:, :, 0, 0] = 0.0
    systems[:, :, 0, 1:] = systems[:, :, 1:, 0] = gradients
    place = np.array([0.3, -0.7, 0.2])
    roots = real_roots(moved(systems, random.normal(size=(3, 3)), place))
    assert np.nanmin(norm(roots - place), axis=1).max() < accuracy


def test_scales_of_quadrics_and_of_space_do_not_matter() -> None:
    systems, planted = random_systems(50, 9), np.random.default_rng(10).normal(size=(50, 3))
    systems[:, :, 0, 0] -= values(systems, planted)[0]
    scaled = systems * 10.0 ** np.random.default_rng(11).uniform(-150, 150, (50, 3, 1, 1))
    assert (numbers(real_roots(scaled)) == numbers(real_roots(systems))).all()
    small = moved(systems, 1e-3 * np.eye(3), np.zeros(3))
    assert np.nanmin(norm(real_roots(small) - 1e-3 * planted[:, None]), axis=1).max() < 1e-12


def test_degenerate_systems_give_roots_or_none() -> None:
    zero, circle, one = np.zeros((4, 4)), np.diag([-1.0, 1.0, 1.0, 0.0]), np.diag([1.0, 0.0, 0.0, 0.0])
    x, y = symmetric(np.outer(np.eye(4)[0], np.eye(4)[1])), symmetric(np.outer(np.eye(4)[0], np.eye(4)[2]))
    linear, infinity = symmetric(np.outer(np.eye(4)[0], [-3.0, 1.0, 2.0, 4.0])), np.full((4, 4), np.inf)
    nothing, contradiction, curve, surface, planes, infinite = real_roots(
        np.array([[zero] * 3, [one, x, y], [circle, circle, y], [circle, zero, zero], [x, y, linear], [infinity, x, y]])
    )
    assert np.array_equal(nothing[0], np.zeros(3))
    assert np.isnan(contradiction).all()
    assert np.isnan(infinite).all()
    for found, off in ((curve, np.abs(curve[:, 1])), (surface, np.zeros(len(surface)))):
        there = np.isfinite(found).all(axis=1)
        assert there.any()
        assert np.abs(found[there, 0] ** 2 + found[there, 1] ** 2 - 1.0).max() < 1e-11
        assert off[there].max() < 1e-11
    assert norm(planes[0] - [0.0, 0.0, 0.75]) < 1e-14
    assert np.isnan(planes[1:]).all()


def test_the_nearest_root_comes_first_and_each_comes_once() -> None:
    roots = real_roots(random_systems(200, 12))
    distance = norm(roots)
    count = numbers(roots)
    for row, found in zip(distance, count, strict=True):
        assert (np.diff(row[:found]) >= 0.0).all()
        assert np.isnan(row[found:]).all()
    apart = norm(roots[:, :, None] - roots[:, None]) + np.where(np.eye(10), np.inf, 0.0)
    assert np.nanmin(apart) > 1e-5


def test_no_bit_depends_on_the_other_systems() -> None:
    systems = random_systems(40, 13)
    roots = real_roots(systems)
    for chosen in ([7], [3, 39, 3], list(range(39, -1, -1))):
        assert np.array_equal(real_roots(systems[chosen]), roots[chosen], equal_nan=True)
