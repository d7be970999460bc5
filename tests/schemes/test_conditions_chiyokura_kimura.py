"""The Chiyokura-Kimura condition: two patches that see only their own data lie in one field of tangent planes."""

from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.bernstein import derivative_triangle, elevate_curve, triangle_tables
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, tangential, unit
from testbed_schemes.continuity_conditions.chiyokura_kimura import (
    conormal,
    cross_boundary_points,
    perpendicular_derivative,
    quadratic_field_points,
)

T = np.linspace(0.0, 1.0, 21)
seeds = st.integers(0, 2**32 - 1)
jensen_cs = st.floats(-3.0, 3.0)


def bernstein(coefficients: Float, t: Float = T) -> Float:
    """A Bezier curve with coefficients (n + 1, 3) at the parameters t."""
    n = len(coefficients) - 1
    basis = np.stack([comb(n, r) * t**r * (1.0 - t) ** (n - r) for r in range(n + 1)], axis=-1)
    values: Float = basis @ coefficients
    return values


class EdgeCase:
    """A random cubic boundary with end normals, and one leg at either end in the tangent plane there."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.curve = np.cumsum(self.rng.normal(loc=(1.0, 0.0, 0.0), size=(4, 3)), axis=0)
        self.n0 = unit(tangential(self.rng.normal(size=3), unit(self.curve[1] - self.curve[0])))
        self.n1 = unit(tangential(self.rng.normal(size=3), unit(self.curve[3] - self.curve[2])))

    def legs(self) -> tuple[Float, Float]:
        return tangential(self.rng.normal(size=3), self.n0), tangential(self.rng.normal(size=3), self.n1)

    def field(self, legs: tuple[Float, Float], jensen_c: float) -> Float:
        """Cubic coefficients (4, 3) of the cross-boundary field of a patch seen along the curve."""
        first, second = cross_boundary_points(self.curve, *legs, self.n0, self.n1, jensen_c)
        return np.stack([legs[0], first - self.curve[1], second - self.curve[2], legs[1]])

    def field_from_the_other_side(self, legs: tuple[Float, Float], jensen_c: float) -> Float:
        """The same of the neighbour, which runs along the reversed curve."""
        near_end, near_start = cross_boundary_points(
            self.curve[::-1], legs[1], legs[0], self.n1, self.n0, jensen_c=jensen_c
        )
        return np.stack([legs[0], near_start - self.curve[1], near_end - self.curve[2], legs[1]])

    def largest_determinant(self, f: Float, g: Float) -> float:
        """Of det(H', F, G) along the edge, over the product of the fields' sizes."""
        h, f, g = bernstein(np.diff(self.curve, axis=0)), bernstein(f), bernstein(g)
        size = np.prod([norm(field).max() for field in (h, f, g)])
        return float(np.abs(dot(h, cross(f, g))).max() / size)


@given(seeds, jensen_cs)
def test_both_fields_and_the_boundary_share_a_plane_along_the_whole_edge(seed: int, jensen_c: float) -> None:
    edge = EdgeCase(seed)
    f = edge.field(edge.legs(), jensen_c)
    g = edge.field_from_the_other_side(edge.legs(), jensen_c)
    assert edge.largest_determinant(f, g) < 1e-13


@given(seeds, jensen_cs, jensen_cs)
def test_the_field_of_planes_does_not_depend_on_c(seed: int, one: float, other: float) -> None:
    edge = EdgeCase(seed)
    legs = edge.legs()
    assert edge.largest_determinant(edge.field(legs, one), edge.field(edge.legs(), other)) < 1e-13


@given(seeds)
def test_a_point_moved_out_of_its_place_leaves_the_plane(seed: int) -> None:
    edge = EdgeCase(seed)
    f, g = edge.field(edge.legs(), 1.0), edge.field_from_the_other_side(edge.legs(), 1.0)
    f[1] += 1e-3 * norm(f).max() * unit(edge.rng.normal(size=3))
    assert edge.largest_determinant(f, g) > 1e-9


@given(seeds, jensen_cs)
def test_the_field_is_the_printed_one_with_jensens_quadratic(seed: int, jensen_c: float) -> None:
    """k* of Mann 1992, section 2.2.3; its k*(1/2) = C (k0 + k1) / 2 tells 2 C - 1 from Mann 1994's c_i."""
    edge = EdgeCase(seed)
    legs = edge.legs()
    v = np.diff(edge.curve, axis=0)
    c0, c1 = unit(cross(edge.n0, v[0])), unit(cross(edge.n1, v[2]))
    k0, k1 = dot(legs[0], c0), dot(legs[1], c1)
    h0, h1 = dot(legs[0], v[0]) / dot(v[0], v[0]), dot(legs[1], v[2]) / dot(v[2], v[2])
    k = k0 * (2 * T**2 - 3 * T + 1) + jensen_c * (k0 + k1) / 2 * (4 * T - 4 * T**2) + k1 * (2 * T**2 - T)
    h = (1 - T) * h0 + T * h1
    expected = k[:, None] * bernstein(np.stack([c0, c1])) + h[:, None] * bernstein(v)
    assert bernstein(edge.field(legs, jensen_c)) == pytest.approx(expected, abs=1e-12 * (1.0 + norm(expected).max()))


@given(seeds, jensen_cs)
def test_reversing_the_edge_swaps_the_points_bit_for_bit(seed: int, jensen_c: float) -> None:
    edge = EdgeCase(seed)
    legs = edge.legs()
    assert np.array_equal(edge.field(legs, jensen_c), edge.field_from_the_other_side(legs, jensen_c))


@given(seeds, st.floats(-1.0, 2.0))
def test_a_batch_gives_what_its_edges_give_alone(seed: int, jensen_c: float) -> None:
    rng = np.random.default_rng(seed)
    curve, legs, normals = (
        rng.normal(size=(5, 3, 4, 3)),
        rng.normal(size=(2, 5, 3, 3)),
        unit(rng.normal(size=(2, 5, 3, 3))),
    )
    batch = cross_boundary_points(curve, legs[0], legs[1], normals[0], normals[1], jensen_c)
    one, two = legs[:, 3, 1], normals[:, 3, 1]
    alone = cross_boundary_points(curve[3, 1], one[0], one[1], two[0], two[1], jensen_c)
    assert np.array_equal(batch[0][3, 1], alone[0])
    assert np.array_equal(batch[1][3, 1], alone[1])


def test_straight_edges_of_a_plane_give_the_points_of_linear_precision() -> None:
    corner, other, apex = np.array([[0.0, 0.0, 0.0], [3.0, 0.5, 0.0], [1.0, 2.0, 0.0]])
    curve = corner + np.linspace(0.0, 1.0, 4)[:, None] * (other - corner)
    up = np.array([0.0, 0.0, 1.0])
    row = corner + np.linspace(0.0, 0.75, 4)[:, None] * (other - corner) + (apex - corner) / 4.0
    first, second = cross_boundary_points(curve, row[0] - curve[0], row[3] - curve[3], up, up)
    assert np.stack([first, second]) == pytest.approx(row[1:3], abs=1e-15)


def test_the_conormal_stands_on_normal_and_tangent() -> None:
    rng = np.random.default_rng(7)
    normal, tangent = unit(rng.normal(size=(40, 3))), rng.normal(size=(40, 3))
    found = conormal(normal, tangent)
    assert angle_between(found, normal) == pytest.approx(np.full(40, np.pi / 2))
    assert angle_between(found, tangent) == pytest.approx(np.full(40, np.pi / 2))
    assert norm(found) == pytest.approx(np.ones(40))


def test_an_edge_without_an_end_tangent_gives_nan_and_no_point() -> None:
    edge = EdgeCase(3)
    edge.curve[1] = edge.curve[0]
    assert np.isnan(edge.field(edge.legs(), 1.0)[1:3]).all()


def quadratic_field(edge: EdgeCase, legs: tuple[Float, Float]) -> Float:
    """Walton and Meek's field (4, 3) of a patch along the curve."""
    first, second = quadratic_field_points(edge.curve, *legs, edge.n0, edge.n1)
    return np.stack([legs[0], first - edge.curve[1], second - edge.curve[2], legs[1]])


def quadratic_field_from_the_other_side(edge: EdgeCase, legs: tuple[Float, Float]) -> Float:
    near_end, near_start = quadratic_field_points(edge.curve[::-1], legs[1], legs[0], edge.n1, edge.n0)
    return np.stack([legs[0], near_start - edge.curve[1], near_end - edge.curve[2], legs[1]])


@given(seeds)
def test_walton_and_meeks_fields_on_both_sides_share_a_plane_with_the_boundary(seed: int) -> None:
    edge = EdgeCase(seed)
    f, g = quadratic_field(edge, edge.legs()), quadratic_field_from_the_other_side(edge, edge.legs())
    assert edge.largest_determinant(f, g) < 1e-13


def test_walton_and_meeks_planes_are_not_those_of_chiyokura_and_kimura() -> None:
    edge = EdgeCase(5)
    assert edge.largest_determinant(quadratic_field(edge, edge.legs()), edge.field(edge.legs(), 1.0)) > 1e-3


@given(seeds)
def test_walton_and_meeks_field_reverses_bit_for_bit(seed: int) -> None:
    edge = EdgeCase(seed)
    legs = edge.legs()
    assert np.array_equal(quadratic_field(edge, legs), quadratic_field_from_the_other_side(edge, legs))


@given(seeds)
def test_walton_and_meeks_published_form_gives_the_same_points(seed: int) -> None:
    """d_r is measured there from (p_r + p_{r + 1}) / 2 of the raised boundary p, with h along its leg and k across."""
    edge = EdgeCase(seed)
    legs = edge.legs()
    raised = elevate_curve(edge.curve)
    middle = (raised[:-1] + raised[1:]) / 2.0
    v = np.diff(edge.curve, axis=0)
    a0, a2 = unit(cross(edge.n0, v[0])), unit(cross(edge.n1, v[2]))
    a1 = unit(a0 + a2)
    d0, d3 = edge.curve[0] + legs[0] - middle[0], edge.curve[3] + legs[1] - middle[3]
    k0, k1 = dot(d0, a0), dot(d3, a2)
    h0, h1 = dot(d0, v[0]) / dot(v[0], v[0]), dot(d3, v[2]) / dot(v[2], v[2])
    first = middle[1] + (k1 * a0 + 2 * k0 * a1 + 2 * h0 * v[1] + h1 * v[0]) / 3.0
    second = middle[2] + (2 * k1 * a1 + k0 * a2 + h0 * v[2] + 2 * h1 * v[1]) / 3.0
    size = norm(quadratic_field(edge, legs)).max() + norm(edge.curve).max()
    found = quadratic_field_points(edge.curve, *legs, edge.n0, edge.n1)
    assert np.stack(found) == pytest.approx(np.stack([first, second]), abs=1e-14 * size)


@given(seeds)
def test_equal_conormals_make_walton_and_meeks_points_chiyokura_and_kimuras(seed: int) -> None:
    edge = EdgeCase(seed)
    edge.curve[:, 2] = 0.0
    v = np.diff(edge.curve, axis=0)
    edge.n0, edge.n1 = (unit(cross(leg, np.array([0.0, 0.0, 1.0]))) for leg in (v[0], v[2]))  # all in one plane
    legs = edge.legs()
    assert quadratic_field(edge, legs) == pytest.approx(edge.field(legs, 1.0), abs=1e-13 * (1.0 + float(norm(legs[0]))))


def test_opposite_conormals_give_nan_in_the_quadratic_field() -> None:
    edge = EdgeCase(3)
    edge.curve[:] = np.linspace(0.0, 1.0, 4)[:, None] * np.array([3.0, 0.0, 0.0])
    edge.n0 = np.array([0.0, 0.6, 0.8])
    edge.n1 = -edge.n0
    assert np.isnan(quadratic_field(edge, edge.legs())[1:3]).all()


@given(seeds, jensen_cs)
def test_herrons_reading_is_a_derivative_of_the_same_patch_in_turning_directions(seed: int, jensen_c: float) -> None:
    edge = EdgeCase(seed)
    legs = edge.legs()
    row = edge.curve + edge.field(legs, jensen_c)
    # b_0 = 0 along the edge, from corner 1 to corner 2; rows further in have no influence
    net = np.zeros((15, 3))
    net[[10, 11, 12, 13, 14]], net[[6, 7, 8, 9]] = elevate_curve(edge.curve), row
    field, along = perpendicular_derivative(edge.curve, 4 * legs[0], 4 * legs[1], edge.n0, edge.n1, jensen_c)
    h = (1.0 - T) * along[0] + T * along[1]
    directions = np.stack([np.ones_like(T), h - (1.0 - T), -h - T], axis=-1)
    table = triangle_tables(3, np.stack([1.0 - T, T], axis=-1), 0)[0]
    derivative = np.einsum("sn,snx->sx", table, derivative_triangle(net, directions))
    size = 1.0 + norm(derivative).max()
    assert bernstein(field) == pytest.approx(derivative, abs=1e-13 * size)
    ends = edge.curve[1] - edge.curve[0], edge.curve[3] - edge.curve[2]
    assert [dot(derivative[0], ends[0]), dot(derivative[-1], ends[1])] == pytest.approx([0.0, 0.0], abs=1e-12 * size)


def test_herrons_derivative_is_four_times_the_across_part_of_the_quartics_legs() -> None:
    edge = EdgeCase(11)
    legs = edge.legs()
    field, along = perpendicular_derivative(edge.curve, 4 * legs[0], 4 * legs[1], edge.n0, edge.n1)
    for place, (leg, normal, v) in enumerate(
        ((legs[0], edge.n0, edge.curve[1] - edge.curve[0]), (legs[1], edge.n1, edge.curve[3] - edge.curve[2]))
    ):
        c = unit(cross(normal, v))
        assert field[3 * place] == pytest.approx(4.0 * dot(leg, c) * c, abs=1e-14)
        assert along[place] == pytest.approx(4.0 * dot(leg, v) / (3.0 * dot(v, v)))
