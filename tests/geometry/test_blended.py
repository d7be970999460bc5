"""Blended triangles: jets of Bezier patches where the formula is polynomial, limits at the corners, bits by chunks."""

from math import factorial
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import testbed.geometry.blended as blended_module
from testbed.geometry.bernstein import multi_indices
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.domain import CORNERS, corner_distance, lattice, side_points
from testbed.geometry.vectors import Float

seeds = st.integers(0, 2**32 - 1)
INDICES: list[list[int]] = multi_indices(3).tolist()


def cubic(b0: Any, b1: Any, b2: Any, net: Any) -> Any:
    """A cubic Bezier triangle as a formula."""
    point = 0.0
    for place, (i, j, k) in enumerate(INDICES):
        binomial = 6.0 / (factorial(i) * factorial(j) * factorial(k))
        point = point + (binomial * b0**i * b1**j * b2**k)[..., None] * net[..., place, :]
    return point


def blended_cubic(b0: Any, b1: Any, b2: Any, net: Any) -> Any:
    """The same with three centres, blended rationally as in side-vertex methods: 0/0 at the corners."""
    weights = [b1 * b2, b2 * b0, b0 * b1]
    total = weights[0] + weights[1] + weights[2]
    point = cubic(b0, b1, b2, net)
    for corner, weight in enumerate(weights):
        point = point + (b0 * b1 * b2 * weight / total)[..., None] * net[..., corner, :]
    return point


def cubic_net(seed: int, patches: int = 4) -> Float:
    return np.random.default_rng(seed).normal(size=(patches, 10, 3))


def place(i: int, j: int, k: int) -> int:
    return INDICES.index([i, j, k])


def corner_legs(net: Float) -> Float:
    """Tangents at the corners of a cubic towards the next corner and the one after it, (P, 3, 2, 3)."""
    towards = []
    for corner in range(3):
        index = 3 * np.eye(3, dtype=int)[corner]
        for step in (1, 2):
            leg = index - np.eye(3, dtype=int)[corner] + np.eye(3, dtype=int)[(corner + step) % 3]
            towards.append(3.0 * (net[:, place(*leg.tolist())] - net[:, place(*index.tolist())]))
    return np.stack(towards, axis=1).reshape(-1, 3, 2, 3)


def batch(net: Float, formula: Any = blended_cubic) -> BlendedTriangles:
    corners = net[:, [place(3, 0, 0), place(0, 3, 0), place(0, 0, 3)]]
    return BlendedTriangles(formula, {"net": net}, corners, corner_legs(net), corner_margin=1e-6)


@pytest.mark.parametrize("order", [0, 1, 2])
@settings(max_examples=20)
@given(seed=seeds)
def test_polynomial_formula_has_the_jets_of_the_bezier_patch(order: int, seed: int) -> None:
    net = cubic_net(seed)
    at = lattice(3, 7)
    at = at[corner_distance(3, at) > 0.0]
    for points in (at, np.random.default_rng(seed).dirichlet(np.ones(3), (4, 9))[..., 1:]):
        result, expected = batch(net, cubic).jets(points, order), BezierTriangles(net).jets(points, order)
        assert result.coefficients.shape == expected.coefficients.shape
        np.testing.assert_allclose(result.coefficients, expected.coefficients, rtol=1e-12, atol=1e-12)


@settings(max_examples=20)
@given(seed=seeds)
def test_corners_have_point_and_tangents_and_no_second_derivatives(seed: int) -> None:
    net = cubic_net(seed)
    result, expected = batch(net).jets(CORNERS[3]), BezierTriangles(net).jets(CORNERS[3])
    np.testing.assert_allclose(result.coefficients[:3], expected.coefficients[:3], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(result.f, batch(net).corner_points)
    assert np.isnan(result.coefficients[3:]).all()
    for order in (0, 1):
        lower = batch(net).jets(CORNERS[3], order)
        np.testing.assert_array_equal(lower.coefficients, result.coefficients[: (1, 3)[order]])


def test_corners_are_the_limits_of_the_formula() -> None:
    blended = batch(cubic_net(5))
    centre = np.full(2, 1.0 / 3.0)
    for corner in CORNERS[3]:
        near = blended.jets((corner + 1e-7 * (centre - corner))[None], 1)
        np.testing.assert_allclose(near.coefficients, blended.jets(corner[None], 1).coefficients, atol=1e-4)


def test_points_that_cannot_be_told_from_a_corner_are_the_corner() -> None:
    blended = batch(cubic_net(6))
    tiny = np.array([[1e-200, 1e-200], [1e-17, 0.0], [1.0, 1e-200], [1e-300, 1.0]])
    corners = CORNERS[3][[0, 0, 1, 2]]
    np.testing.assert_array_equal(blended.jets(tiny).coefficients, blended.jets(corners).coefficients)


@settings(max_examples=20)
@given(seed=seeds)
def test_edges_are_the_boundary_curves(seed: int) -> None:
    net = cubic_net(seed)
    for side in range(3):
        at = side_points(3, np.array([side]), np.linspace(0.0, 1.0, 30)[1:-1])[0]
        np.testing.assert_allclose(batch(net).jets(at, 0).f, BezierTriangles(net).jets(at, 0).f, atol=1e-13)


def test_derivatives_of_a_rational_blend_agree_with_difference_quotients() -> None:
    blended = batch(cubic_net(8))
    at = np.array([[0.2, 0.3], [0.5, 0.1], [0.05, 0.9]])
    step = 1e-5
    along_u, along_v = np.array([step, 0.0]), np.array([0.0, step])
    jet = blended.jets(at)
    by_u = (blended.jets(at + along_u, 1).coefficients - blended.jets(at - along_u, 1).coefficients) / (2 * step)
    by_v = (blended.jets(at + along_v, 1).coefficients - blended.jets(at - along_v, 1).coefficients) / (2 * step)
    np.testing.assert_allclose(jet.coefficients[[1, 3, 4]], by_u, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(jet.coefficients[[2, 4, 5]], by_v, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("chunk", [1, 7, 64, 10**6])
def test_chunks_do_not_change_a_bit(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    blended, at = batch(cubic_net(9, patches=9)), lattice(3, 3)
    whole = blended.jets(at).coefficients
    monkeypatch.setattr(blended_module, "CHUNK", chunk)
    np.testing.assert_array_equal(blended.jets(at).coefficients, whole)
    per_patch = np.broadcast_to(at, (9, *at.shape))
    np.testing.assert_array_equal(blended.jets(per_patch).coefficients, whole)


def test_a_patch_and_a_point_have_the_same_bits_in_any_company() -> None:
    blended, at = batch(cubic_net(10, patches=11)), lattice(3, 4)
    whole = blended.jets(at).coefficients
    chosen = np.array([7, 0, 7])
    np.testing.assert_array_equal(blended.take(chosen).jets(at[[3, 1]]).coefficients, whole[:, chosen][:, :, [3, 1]])
    np.testing.assert_array_equal(blended.take(slice(4, 5)).jets(at).coefficients, whole[:, 4:5])


def test_no_points_and_no_patches_are_empty_jets() -> None:
    blended = batch(cubic_net(11))
    assert blended.jets(np.zeros((0, 2))).coefficients.shape == (6, 4, 0, 3)
    assert blended.take(slice(0, 0)).jets(lattice(3, 2)).coefficients.shape == (6, 0, 6, 3)


def test_finite_sees_data_corners_and_tangents() -> None:
    whole = batch(cubic_net(12, patches=5))
    assert whole.finite.all()
    net, corners, tangents = whole.data["net"].copy(), whole.corner_points.copy(), whole.corner_tangents.copy()
    net[0, 4, 1], corners[1, 2, 0], tangents[3, 0, 1, 2] = np.nan, np.inf, np.nan
    spoiled = BlendedTriangles(blended_cubic, {"net": net}, corners, tangents)
    np.testing.assert_array_equal(spoiled.finite, [False, False, True, False, True])


def test_data_cannot_be_changed_through_the_batch() -> None:
    blended = batch(cubic_net(13))
    for array in (blended.data["net"], blended.corner_points, blended.corner_tangents):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_wrong_shapes_are_told() -> None:
    net = cubic_net(14)
    with pytest.raises(ValueError, match=r"corner tangents \(P, 3, 2, 3\)"):
        BlendedTriangles(cubic, {"net": net}, net[:, :3], net[:, :3])
    with pytest.raises(ValueError, match="'net' has 3 entries for 4 patches"):
        BlendedTriangles(cubic, {"net": net[:3]}, net[:, :3], corner_legs(net))
