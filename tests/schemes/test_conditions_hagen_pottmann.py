"""The tangent plane field and the curvature field along an edge: what they agree with, and what they depend on."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.vectors import Float, cross, dot, quadratic_form, tangential, unit
from testbed_schemes.continuity_conditions.hagen_pottmann import CurvatureField, EndField, curvature_field, end_field
from testbed_schemes.mathematics.quintic_hermite import quintic_derivatives

S = np.linspace(0.0, 1.0, 33)
seeds = st.integers(0, 2**32 - 1)


class EdgeCase:
    """Random data at both ends of an edge, and the quintic curve that has their normal curvatures."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.chord = np.array([1.0, 0.0, 0.0]) + 0.2 * rng.normal(size=3)
        self.normals = unit(np.array([0.0, 0.0, 1.0]) + 0.3 * rng.normal(size=(2, 3)))
        # the noise would turn some over or along the edge
        self.normals[np.abs(self.normals @ unit(self.chord)) > 0.8] = unit(cross(self.chord, np.array([0.3, 0.7, 0.2])))
        self.tangents = tangential(np.broadcast_to(self.chord, (2, 3)), self.normals)
        projections = np.eye(3) - self.normals[:, :, None] * self.normals[:, None, :]
        forms = rng.normal(size=(2, 3, 3))
        forms = projections @ (forms + forms.swapaxes(1, 2)) @ projections
        self.forms = 0.5 * (forms + forms.swapaxes(1, 2))
        # a tangential part changes nothing in the fields
        self.bends = -quadratic_form(self.tangents, self.forms, self.tangents)[:, None] * self.normals
        self.bends += rng.normal(size=(2, 1)) * self.tangents

    def reversed(self) -> "EdgeCase":
        other = EdgeCase.__new__(EdgeCase)
        other.chord, other.normals, other.forms = -self.chord, self.normals[::-1], self.forms[::-1]
        other.tangents, other.bends = -self.tangents[::-1], self.bends[::-1]
        return other

    def ends(self) -> tuple[EndField, EndField]:
        first, last = (end_field(self.normals[i], self.tangents[i], self.forms[i]) for i in range(2))
        return first, last

    def field(self, s: Float = S) -> CurvatureField:
        curve = np.stack([self.chord, *self.tangents, *self.bends])
        rest = s[::-1] if s is S else 1.0 - s
        return curvature_field(*quintic_derivatives(curve, s, rest), *self.ends(), s, rest)


def unit_normal(field: CurvatureField) -> Float:
    return unit(field.normal)


@given(seeds)
def test_the_field_at_both_ends_is_the_data(seed: int) -> None:
    edge = EdgeCase(seed)
    field = edge.field()
    directions = np.random.default_rng(seed).normal(size=(8, 1, 3))
    found = field.second_form(np.broadcast_to(directions, (8, *S.shape, 3)))
    for place, end in ((0, 0), (-1, 1)):
        np.testing.assert_allclose(unit_normal(field)[place], edge.normals[end], atol=1e-14)
        flat = tangential(directions[:, 0], edge.normals[end])
        expected = quadratic_form(flat, edge.forms[end], flat)
        np.testing.assert_allclose(found[:, place], expected, atol=1e-12 * np.abs(edge.forms).max() * 30)


@given(seeds)
def test_along_the_curve_the_form_is_that_of_the_curve(seed: int) -> None:
    field = EdgeCase(seed).field()
    expected = -dot(field.bend, unit_normal(field))
    np.testing.assert_allclose(field.second_form(field.tangent), expected, atol=1e-10 * np.abs(expected).max())


@given(seeds)
def test_the_mixed_value_is_what_the_tangent_planes_turn_by(seed: int) -> None:
    """II(X', D) = <n', D>, with n' by the central difference of neighbouring normals."""
    edge, step = EdgeCase(seed), 1e-5
    s = np.linspace(0.1, 0.9, 9)
    field = edge.field(s)
    n_after, n_before = unit_normal(edge.field(s + step)), unit_normal(edge.field(s - step))
    expected = dot((n_after - n_before) / (2 * step), field.across)
    both = [field.second_form(field.tangent + sign * field.across) for sign in (1.0, -1.0)]
    scale = np.abs(both).max() / dot(field.normal, field.normal).min()
    np.testing.assert_allclose(0.25 * (both[0] - both[1]), expected, atol=1e-6 * scale**2)


@given(seeds)
def test_across_the_curve_the_form_goes_from_one_end_to_the_other(seed: int) -> None:
    edge = EdgeCase(seed)
    field, (first, last) = edge.field(), edge.ends()
    expected = ((1 - S) * first.curvature + S * last.curvature) * dot(field.across, field.across)
    np.testing.assert_allclose(field.second_form(field.across), expected, atol=1e-11 * (1 + np.abs(expected).max()))


@given(seeds)
def test_the_parts_of_directions_along_the_normal_do_not_count(seed: int) -> None:
    field = EdgeCase(seed).field()
    direction = np.random.default_rng(seed).normal(size=(len(S), 3))
    moved = direction + 3.0 * unit_normal(field)
    found = field.second_form(direction)
    np.testing.assert_allclose(field.second_form(moved), found, rtol=1e-9, atol=1e-9 * np.abs(found).max())


@given(seeds)
def test_the_reversed_edge_has_the_same_fields(seed: int) -> None:
    edge = EdgeCase(seed)
    one, other = edge.field(), edge.reversed().field()
    np.testing.assert_allclose(unit_normal(other)[::-1], unit_normal(one), atol=1e-13)
    direction = np.random.default_rng(seed).normal(size=3)
    found = one.second_form(np.broadcast_to(direction, (len(S), 3)))
    back = other.second_form(np.broadcast_to(direction, (len(S), 3)))
    np.testing.assert_allclose(back[::-1], found, atol=1e-11 * (1.0 + np.abs(found).max()))


@given(seeds)
def test_the_ends_of_the_reversed_edge_are_the_same_bit_for_bit(seed: int) -> None:
    edge = EdgeCase(seed)
    for mine, theirs in zip(edge.ends(), edge.reversed().ends()[::-1], strict=True):
        np.testing.assert_array_equal(theirs.across, -mine.across)
        np.testing.assert_array_equal(theirs.turn, mine.turn)
        assert theirs.curvature == mine.curvature


def test_on_a_great_circle_the_field_is_the_sphere() -> None:
    """Along a curve that is a circle to second order at its ends, with conormals that do not turn."""
    angle = 0.7
    normals = np.array([[0.0, 0.0, 1.0], [np.sin(angle), 0.0, np.cos(angle)]])
    tangents = angle * np.array([[1.0, 0.0, 0.0], [np.cos(angle), 0.0, -np.sin(angle)]])
    forms = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    first, last = (end_field(normals[i], tangents[i], forms[i]) for i in range(2))
    circle = np.stack([np.sin(angle * S), 0 * S, np.cos(angle * S)], axis=-1)
    slope = angle * np.stack([np.cos(angle * S), 0 * S, -np.sin(angle * S)], axis=-1)
    field = curvature_field(slope, -(angle**2) * circle, first, last, S, S[::-1])
    np.testing.assert_allclose(unit_normal(field), circle, atol=1e-14)
    for direction in (field.tangent, field.across, field.tangent - 2.0 * field.across):
        np.testing.assert_allclose(field.second_form(direction), dot(direction, direction), rtol=1e-13)


def test_the_sign_is_that_of_a_surface_that_bends_away_from_its_normal() -> None:
    """A sphere is positive: with the sign turned, as another convention has it, the curve bends to the wrong side."""
    normal, tangent = np.array([0.0, 0.0, 1.0]), np.array([0.5, 0.0, 0.0])
    end = end_field(normal, tangent, np.diag([1.0, 1.0, 0.0]))
    assert end.curvature == 1.0
    skew = end_field(normal, tangent, np.array([[0.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    # D = (0, 1, 0), II(X', D) = 1, so that D turns away from the normal as the normal turns towards D
    np.testing.assert_array_equal(skew.across, [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(skew.turn, [0.0, 0.0, -1.0])
