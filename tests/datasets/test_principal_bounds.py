"""Bounds of principal curvatures are on the right side on any patch, and close on small ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.bernstein import elevate_tensor, tensor_tables
from testbed.geometry.bezier import BezierQuads
from testbed.geometry.curvature import principal
from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float
from testbed_datasets.principal_bounds import bounded_extremes, highest_place, multiply, principal_bounds, quarters


def wavy(seed: int, count: int = 3, roughness: float = 0.15) -> Float:
    """Bicubic patches about a plane square, (count, 4, 4, 3)."""
    random = np.random.default_rng(seed)
    i, j = np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij")
    return np.stack([i, j, 0.0 * i], axis=-1) + roughness * random.normal(size=(count, 4, 4, 3))


def sampled(nets: Float, steps: int = 16) -> tuple[Float, Float]:
    """Least and greatest principal curvatures at samples, (P,) each, at most and at least zero."""
    k_max, k_min = principal(BezierQuads(nets).jets(lattice(4, steps)))
    return np.minimum(k_min.min(axis=1), 0.0), np.maximum(k_max.max(axis=1), 0.0)


@settings(max_examples=15, derandomize=True)
@given(seed=st.integers(0, 10**6), roughness=st.floats(0.0, 0.6), halvings=st.integers(0, 1))
def test_no_curvature_is_beyond_its_bounds(seed: int, roughness: float, halvings: int) -> None:
    nets = wavy(seed, roughness=roughness)
    for _ in range(halvings):
        nets = quarters(nets)
    low, high = principal_bounds(nets)
    least, greatest = sampled(nets)
    assert (low <= least).all()
    assert (greatest <= high).all()


def test_the_excess_falls_with_the_square_of_the_size() -> None:
    nets = np.concatenate([quarters(wavy(seed)) for seed in range(1)])
    means = []
    for _ in range(4):
        _, high = principal_bounds(nets)
        _, greatest = sampled(nets, 8)
        means.append(float(np.median((high - greatest)[greatest > 0.1])))
        nets = quarters(nets)
    assert means[3] < 0.3 * means[2]
    assert means[2] < 0.35 * means[1]


def test_a_parabolic_cylinder_is_bounded_exactly() -> None:
    # z = -x^2: curvature 2 along the vertex line, 2 / (1 + 4 x^2)^(3/2) elsewhere, and 0 across
    x = np.array([[-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]]).T
    z = np.array([[-1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]]).T
    nets = elevate_tensor(np.stack([x, np.array([[0.0, 1.0]] * 3), z], axis=-1)[None], (0, 1))
    low, high = bounded_extremes(nets, 0.0, 2.0)
    assert 2.0 <= high <= 2.0 + 1e-4
    assert -1e-4 <= low <= 0.0


def test_turning_a_patch_over_turns_its_bounds() -> None:
    nets = quarters(quarters(wavy(5)))
    low, high = principal_bounds(nets)
    turned_low, turned_high = principal_bounds(nets[:, ::-1])
    assert np.allclose(turned_low, -high, rtol=1e-9, atol=1e-9)
    assert np.allclose(turned_high, -low, rtol=1e-9, atol=1e-9)


def test_a_patch_without_tangent_plane_is_not_bounded() -> None:
    nets = wavy(1, 1)
    nets[0, 0] = nets[0, 0, :1]
    assert np.isinf(np.array(principal_bounds(nets))).all()


def test_products_are_products() -> None:
    random = np.random.default_rng(0)
    a, b = random.normal(size=(5, 3, 4)), random.normal(size=(5, 6, 2))
    at = random.uniform(size=(9, 2))

    def value(coefficients: Float) -> Float:
        m, n = coefficients.shape[1:]
        return np.asarray(np.einsum("sij,pij->ps", tensor_tables((m - 1, n - 1), at, 0)[0], coefficients))

    assert np.abs(value(multiply(a, b)) - value(a) * value(b)).max() < 1e-13
    one = np.ones((1, 3, 2))
    elevated = elevate_tensor(a[..., None], (2, 1))[..., 0]
    assert np.abs(multiply(a, one) - elevated).max() < 1e-14


@pytest.mark.parametrize("top", [(1.234, 0.777), (0.0, 2.0), (2.0, 1.1), (2.0, 0.0)])
def test_the_highest_place_is_found_inside_and_on_the_boundary(top: tuple[float, float]) -> None:
    def hill(at: Float) -> Float:
        away = at - np.array(top)
        height: Float = 3.0 - (away**2).sum(axis=1) + 0.3 * away.prod(axis=1) - away[:, 0] ** 4
        return height

    peak = highest_place(hill, 2.0)
    grid = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 2.0, 401)]), axis=-1).reshape(-1, 2)
    assert peak.value >= hill(grid).max()
    assert peak.value == hill(np.array([peak.at]))[0]
    assert np.abs(np.array(peak.at) - top).max() < 1e-6
