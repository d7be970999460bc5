"""Bernstein-Bezier algebra: every operation leaves the patch, or the product of the values, what it was."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry import bernstein
from testbed.geometry.domain import CORNERS, barycentric
from testbed.geometry.vectors import Float

DEGREES = range(7)
seeds = st.integers(0, 2**32 - 1)
degrees = st.integers(0, 6)
few = settings(max_examples=30, deadline=None)

# samples inside, on the sides and at the corners of the triangle
POINTS = np.vstack([CORNERS[3], [[0.5, 0.0], [0.25, 0.75], [0.0, 0.125], [1 / 3, 1 / 3], [0.7, 0.1], [0.05, 0.6]]])


def complex_casteljau(net: Float, u: complex, v: complex) -> Float:
    """Evaluate by the recursion on exponents, also off the real plane; knows no order of control points in memory."""
    degree = bernstein.triangle_degree(len(net))
    level = {tuple(m): point.astype(complex) for m, point in zip(bernstein.multi_indices(degree), net, strict=True)}
    for d in range(degree - 1, -1, -1):
        level = {
            (i, j, d - i - j): (1.0 - u - v) * level[i + 1, j, d - i - j]
            + u * level[i, j + 1, d - i - j]
            + v * level[i, j, d - i - j + 1]
            for i in range(d + 1)
            for j in range(d + 1 - i)
        }
    return np.asarray(level[0, 0, 0])


def cauchy_jet(net: Float, at: Float, count: int = 8, radius: float = 0.5) -> Float:
    """Six derivatives by Cauchy's integral on circles in u and v; exact for polynomials of degree below ``count``."""
    roots = np.exp(2j * np.pi * np.arange(count) / count)
    values = np.array([[complex_casteljau(net, at[0] + radius * a, at[1] + radius * b) for b in roots] for a in roots])
    taylor = np.fft.fft2(values, axes=(0, 1)) / count**2
    orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
    rows = [math.factorial(p) * math.factorial(q) * taylor[p, q] / radius ** (p + q) for p, q in orders]
    return np.array(rows).real


def jet_of(net: Float, at: Float) -> Float:
    return bernstein.triangle_tables(bernstein.triangle_degree(net.shape[-2]), at) @ net


def test_multi_indices_run_by_decreasing_i_then_decreasing_j() -> None:
    names = ["".join(map(str, row)) for row in bernstein.multi_indices(3)]
    assert names == ["300", "210", "201", "120", "111", "102", "030", "021", "012", "003"]


@pytest.mark.parametrize("degree", DEGREES)
def test_index_of_inverts_multi_indices(degree: int) -> None:
    indices = bernstein.multi_indices(degree)
    assert [bernstein.index_of((i, j, k)) for i, j, k in indices.tolist()] == list(range(len(indices)))
    assert len(indices) == bernstein.point_count(degree)
    assert bernstein.triangle_degree(len(indices)) == degree


@pytest.mark.parametrize("count", [-1, 0, 2, 4, 5, 9, 11])
def test_counts_that_are_no_triangle_are_refused(count: int) -> None:
    with pytest.raises(ValueError, match=f"not {count}"):
        bernstein.triangle_degree(count)


@pytest.mark.parametrize("degree", DEGREES)
def test_raised_indices_are_those_with_one_exponent_more(degree: int) -> None:
    higher = bernstein.multi_indices(degree + 1)
    first, second, third = bernstein.raised(degree)
    for direction, raised in enumerate((higher[first], higher[second], higher[third])):
        np.testing.assert_array_equal(raised, bernstein.multi_indices(degree) + np.eye(3, dtype=int)[direction])


@pytest.mark.parametrize("degree", DEGREES)
def test_partition_of_unity_and_positivity(degree: int) -> None:
    table = bernstein.triangle_tables(degree, POINTS)
    np.testing.assert_allclose(table[0].sum(axis=-1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(table[1:].sum(axis=-1), 0.0, atol=1e-13)
    assert (table[0] >= -1e-17).all()  # b0 of a point on the side 1 2 may be a rounding error below zero


@pytest.mark.parametrize("degree", DEGREES[1:])
def test_linear_precision(degree: int) -> None:
    net = bernstein.multi_indices(degree) / degree
    jet = jet_of(net, POINTS)
    np.testing.assert_allclose(jet[0], barycentric(POINTS), atol=1e-15)
    np.testing.assert_allclose(jet[1], np.tile([-1.0, 1.0, 0.0], (len(POINTS), 1)), atol=1e-14)
    np.testing.assert_allclose(jet[2], np.tile([-1.0, 0.0, 1.0], (len(POINTS), 1)), atol=1e-14)
    np.testing.assert_allclose(jet[3:], 0.0, atol=1e-12)


@pytest.mark.parametrize("degree", DEGREES)
def test_tables_and_cauchy_integrals_of_complex_casteljau_agree(degree: int) -> None:
    net = np.random.default_rng(degree).standard_normal((bernstein.point_count(degree), 3))
    for at in POINTS:
        np.testing.assert_allclose(jet_of(net, at), cauchy_jet(net, at), atol=1e-11)


@pytest.mark.parametrize("degree", DEGREES)
def test_lower_orders_are_the_first_rows(degree: int) -> None:
    full = bernstein.triangle_tables(degree, POINTS, 2)
    for order, rows in ((0, 1), (1, 3)):
        np.testing.assert_array_equal(bernstein.triangle_tables(degree, POINTS, order), full[:rows])


def test_tables_take_any_leading_axes() -> None:
    at = np.random.default_rng(1).random((4, 5, 2)) / 2
    np.testing.assert_array_equal(
        bernstein.triangle_tables(3, at).reshape(6, 20, 10), bernstein.triangle_tables(3, at.reshape(20, 2))
    )
    np.testing.assert_array_equal(bernstein.triangle_tables(3, at[0, 0]), bernstein.triangle_tables(3, at)[:, 0, 0])


def test_corners_are_interpolated_to_the_last_bit() -> None:
    net = np.random.default_rng(2).standard_normal((15, 3))
    np.testing.assert_array_equal(jet_of(net, CORNERS[3])[0], net[[0, 10, 14]])


@few
@given(seeds, degrees)
def test_diagonal_of_the_blossom_is_the_patch(seed: int, degree: int) -> None:
    rng = np.random.default_rng(seed)
    nets = rng.standard_normal((4, bernstein.point_count(degree), 3))
    at = rng.random((4, 2)) / 2
    arguments = np.repeat(barycentric(at)[:, None], degree, axis=1)
    expected = np.stack([jet_of(net, point)[0] for net, point in zip(nets, at, strict=True)])
    np.testing.assert_allclose(bernstein.blossom_triangle(nets, arguments), expected, atol=1e-13)


@few
@given(seeds, st.integers(1, 4))
def test_blossom_is_symmetric_and_affine_in_each_argument(seed: int, degree: int) -> None:
    rng = np.random.default_rng(seed)
    net = rng.standard_normal((bernstein.point_count(degree), 2))
    arguments = barycentric(rng.standard_normal((degree, 2)))
    value = bernstein.blossom_triangle(net, arguments)
    for order in itertools.permutations(range(degree)):
        np.testing.assert_allclose(bernstein.blossom_triangle(net, arguments[list(order)]), value, atol=1e-11)
    other = arguments.copy()
    other[-1] = barycentric(rng.standard_normal(2))
    between = 0.3 * arguments + 0.7 * other
    expected = 0.3 * value + 0.7 * bernstein.blossom_triangle(net, other)
    np.testing.assert_allclose(bernstein.blossom_triangle(net, between), expected, atol=1e-11)


def test_blossoms_at_corners_are_the_control_points() -> None:
    net = np.random.default_rng(3).standard_normal((10, 3))
    for (i, j, k), point in zip(bernstein.multi_indices(3), net, strict=True):
        arguments = np.repeat(np.eye(3), [i, j, k], axis=0)
        np.testing.assert_array_equal(bernstein.blossom_triangle(net, arguments), point)


@few
@given(seeds, degrees, st.integers(0, 3))
def test_elevation_leaves_the_patch_unchanged(seed: int, degree: int, steps: int) -> None:
    net = np.random.default_rng(seed).standard_normal((2, bernstein.point_count(degree), 3))
    higher = bernstein.elevate_triangle(net, steps)
    assert bernstein.triangle_degree(higher.shape[-2]) == degree + steps
    for before, after in zip(net, higher, strict=True):
        np.testing.assert_allclose(jet_of(after, POINTS), jet_of(before, POINTS), atol=1e-11)


def test_boundary_of_the_raised_patch_is_the_raised_boundary_to_the_last_bit() -> None:
    net = np.random.default_rng(4).standard_normal((10, 3))
    net[4] = np.nan  # an open centre does not reach the boundary
    raised = bernstein.elevate_triangle(net)
    side = [bernstein.index_of((3 - r, r, 0)) for r in range(4)]
    raised_side = [bernstein.index_of((4 - r, r, 0)) for r in range(5)]
    np.testing.assert_array_equal(raised[raised_side], bernstein.elevate_curve(net[side]))


@few
@given(seeds, degrees, st.integers(1, 3))
def test_raised_reversed_curve_is_the_reversed_raised_curve_to_the_last_bit(seed: int, degree: int, steps: int) -> None:
    curve = np.random.default_rng(seed).standard_normal((5, degree + 1, 3))
    raised = bernstein.elevate_curve(curve, steps)
    np.testing.assert_array_equal(bernstein.elevate_curve(curve[:, ::-1], steps), raised[:, ::-1])
    t = np.linspace(0.0, 1.0, 7)
    np.testing.assert_allclose(
        bernstein.evaluate_curve(raised, t, 2), bernstein.evaluate_curve(curve, t, 2), atol=1e-11
    )


@pytest.mark.parametrize("degree", DEGREES)
def test_curve_derivatives_are_those_of_the_power_form(degree: int) -> None:
    points = np.random.default_rng(degree).standard_normal(degree + 1)
    power = np.polynomial.Polynomial([0.0])
    t = np.polynomial.Polynomial([0.0, 1.0])
    for i, point in enumerate(points):
        power += point * math.comb(degree, i) * t**i * (1.0 - t) ** (degree - i)
    at = np.linspace(0.0, 1.0, 6)
    rows = bernstein.evaluate_curve(points[:, None], at, 2)[..., 0]
    for derivative, row in enumerate(rows):
        np.testing.assert_allclose(row, power.deriv(derivative)(at), atol=1e-10)


def test_curves_are_evaluated_at_their_own_parameters() -> None:
    rng = np.random.default_rng(5)
    curves, t = rng.standard_normal((4, 4, 3)), rng.random((4, 6))
    own = bernstein.evaluate_curve(curves, t, 1)
    for row, (curve, parameters) in enumerate(zip(curves, t, strict=True)):
        np.testing.assert_array_equal(own[:, row], bernstein.evaluate_curve(curve, parameters, 1))
        arguments = np.repeat(parameters[:, None], 3, axis=1)
        np.testing.assert_allclose(own[0, row], bernstein.blossom_curve(curve, arguments), atol=1e-15)


@few
@given(seeds, degrees)
def test_reparametrised_patch_is_the_patch_over_the_other_triangle(seed: int, degree: int) -> None:
    rng = np.random.default_rng(seed)
    net = rng.standard_normal((bernstein.point_count(degree), 3))
    corners = barycentric(rng.random((3, 2)))
    pieces = bernstein.reparametrise_triangle(net, corners)
    inside = barycentric(POINTS) @ corners[:, 1:]
    whole, piece = jet_of(net, inside), jet_of(pieces, POINTS)
    (a, b), (c, d) = corners[1, 1:] - corners[0, 1:], corners[2, 1:] - corners[0, 1:]
    np.testing.assert_allclose(piece[0], whole[0], atol=1e-11)
    np.testing.assert_allclose(piece[1], a * whole[1] + b * whole[2], atol=1e-10)
    np.testing.assert_allclose(piece[2], c * whole[1] + d * whole[2], atol=1e-10)
    np.testing.assert_allclose(piece[4], a * c * whole[3] + (a * d + b * c) * whole[4] + b * d * whole[5], atol=1e-9)


def corners_of(net: Float) -> Float:
    degree = bernstein.triangle_degree(net.shape[-2])
    return net[..., [0, bernstein.index_of((0, degree, 0)), bernstein.index_of((0, 0, degree))], :]


#: A net whose patch is the identity: its pieces' corners are their places in the domain.
IDENTITY = bernstein.multi_indices(3) / 3.0


def test_pieces_lie_where_they_are_said_to() -> None:
    at = np.array([0.2, 0.3, 0.5])
    three = corners_of(bernstein.subdivide_triangle(IDENTITY, at))
    e = np.eye(3)
    np.testing.assert_allclose(three, [[e[1], e[2], at], [e[2], e[0], at], [e[0], e[1], at]], atol=1e-15)
    np.testing.assert_allclose(corners_of(bernstein.subdivide_triangle(IDENTITY))[:, 2], 1.0 / 3.0, atol=1e-15)
    four = corners_of(bernstein.quarter_triangle(IDENTITY))
    m = [(e[1] + e[2]) / 2, (e[2] + e[0]) / 2, (e[0] + e[1]) / 2]
    expected = [[e[0], m[2], m[1]], [m[2], e[1], m[0]], [m[1], m[0], e[2]], m]
    np.testing.assert_allclose(four, expected, atol=1e-15)
    two = corners_of(bernstein.halve_triangle(IDENTITY, 1))
    np.testing.assert_allclose(two, [[e[0], e[1], m[0]], [e[0], m[0], e[2]]], atol=1e-15)


@pytest.mark.parametrize("pieces", ["subdivide", "quarter", "halve"])
@pytest.mark.parametrize("degree", [1, 3, 4])
def test_pieces_are_parts_of_the_patch(pieces: str, degree: int) -> None:
    splits: dict[str, Callable[[Float], Float]] = {
        "subdivide": bernstein.subdivide_triangle,
        "quarter": bernstein.quarter_triangle,
        "halve": lambda net: bernstein.halve_triangle(net, 2),
    }
    split = splits[pieces]
    nets = np.random.default_rng(degree).standard_normal((3, bernstein.point_count(degree), 3))
    places = split(bernstein.multi_indices(degree) / degree)
    for net, parts in zip(nets, split(nets), strict=True):
        for part, place in zip(parts, places, strict=True):
            at = jet_of(place, POINTS)[0][:, 1:]
            np.testing.assert_allclose(jet_of(part, POINTS)[0], jet_of(net, at)[0], atol=1e-13)


def test_three_pieces_share_sides_and_keep_the_boundary_to_the_last_bit() -> None:
    net = np.random.default_rng(6).standard_normal((15, 3))
    pieces = bernstein.subdivide_triangle(net, np.array([0.21, 0.33, 0.46]))

    def side(piece: int, start: int, end: int) -> Float:
        indices = []
        for r in range(5):
            exponents = [0, 0, 0]
            exponents[start], exponents[end] = 4 - r, r
            indices.append(bernstein.index_of((exponents[0], exponents[1], exponents[2])))
        return pieces[piece, indices] if piece >= 0 else net[indices]

    for i in range(3):
        np.testing.assert_array_equal(side(i, 1, 2), side((i + 1) % 3, 0, 2))
        np.testing.assert_array_equal(side(i, 0, 1), side(-1, (i + 1) % 3, (i + 2) % 3))


@few
@given(seeds, degrees, st.floats(0.0, 1.0))
def test_parts_of_curves_and_tensor_patches_are_parts(seed: int, degree: int, t: float) -> None:
    rng = np.random.default_rng(seed)
    curve = rng.standard_normal((2, degree + 1, 3))
    s = np.linspace(0.0, 1.0, 5)
    before, after = bernstein.subdivide_curve(curve, t)
    np.testing.assert_allclose(bernstein.evaluate_curve(before, s), bernstein.evaluate_curve(curve, t * s), atol=1e-12)
    np.testing.assert_allclose(
        bernstein.evaluate_curve(after, s), bernstein.evaluate_curve(curve, t + (1.0 - t) * s), atol=1e-12
    )
    net = rng.standard_normal((degree + 1, 3, 3))
    at = rng.random((5, 2))
    for axis in (0, 1):
        low, high = bernstein.subdivide_tensor(net, axis, t)
        for part, start, end in ((low, 0.0, t), (high, t, 1.0)):
            inside = at.copy()
            inside[:, axis] = start + (end - start) * at[:, axis]
            expected = np.einsum("sij,ijc->sc", bernstein.tensor_tables((degree, 2), inside, 0)[0], net)
            actual = np.einsum("sij,ijc->sc", bernstein.tensor_tables((degree, 2), at, 0)[0], part)
            np.testing.assert_allclose(actual, expected, atol=1e-12)


@few
@given(seeds, st.integers(0, 4), st.integers(0, 4), st.sampled_from([1, 3]))
def test_product_of_forms_is_the_product_of_values(seed: int, m: int, n: int, dim: int) -> None:
    rng = np.random.default_rng(seed)
    a = rng.standard_normal((2, bernstein.point_count(m), dim))
    b = rng.standard_normal((2, bernstein.point_count(n), 3))
    expected = jet_of(a[0], POINTS)[0] * jet_of(b[0], POINTS)[0]
    np.testing.assert_allclose(jet_of(bernstein.multiply_triangles(a, b)[0], POINTS)[0], expected, atol=1e-12)
    p, q = rng.standard_normal((2, m + 1, dim)), rng.standard_normal((2, n + 1, 3))
    t = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(
        bernstein.evaluate_curve(bernstein.multiply_curves(p, q), t),
        bernstein.evaluate_curve(p, t) * bernstein.evaluate_curve(q, t),
        atol=1e-12,
    )


@pytest.mark.parametrize("degree", DEGREES[1:])
def test_derivative_nets_are_the_derivatives(degree: int) -> None:
    rng = np.random.default_rng(degree)
    net = rng.standard_normal((bernstein.point_count(degree), 3))
    along_u = bernstein.derivative_triangle(net, np.array([-1.0, 1.0, 0.0]))
    along_v = bernstein.derivative_triangle(net, np.array([-1.0, 0.0, 1.0]))
    jet = jet_of(net, POINTS)
    np.testing.assert_allclose(jet_of(along_u, POINTS)[0], jet[1], atol=1e-12)
    np.testing.assert_allclose(jet_of(along_v, POINTS)[0], jet[2], atol=1e-12)
    np.testing.assert_allclose(jet_of(along_u, POINTS)[2], jet[4], atol=1e-11)
    curve = rng.standard_normal((2, degree + 1, 3))
    t = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(
        bernstein.evaluate_curve(bernstein.derivative_curve(curve), t)[0],
        bernstein.evaluate_curve(curve, t, 1)[1],
        atol=1e-12,
    )


def test_raised_tensor_patch_is_the_patch() -> None:
    rng = np.random.default_rng(7)
    net, at = rng.standard_normal((3, 4, 3)), rng.random((6, 2))
    raised = bernstein.elevate_tensor(net, (2, 1))
    assert raised.shape == (5, 5, 3)
    before = np.einsum("rsij,ijc->rsc", bernstein.tensor_tables((2, 3), at), net)
    after = np.einsum("rsij,ijc->rsc", bernstein.tensor_tables((4, 4), at), raised)
    np.testing.assert_allclose(after, before, atol=1e-12)
