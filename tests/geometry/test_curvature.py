"""Curvature of surfaces whose curvature is known, and its invariances."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry import curvature
from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, dot, quadratic_form

few = settings(max_examples=30, deadline=None)
seeds = st.integers(0, 2**32 - 1)


def rows(*derivatives: tuple[Float | float, Float | float, Float | float]) -> Jet:
    return Jet(np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in derivatives]))


def ellipsoid(u: Float, v: Float, a: float, b: float, c: float) -> Jet:
    """(a cos u cos v, b sin u cos v, c sin v) with its outward normal."""
    cu, su, cv, sv = np.cos(u), np.sin(u), np.cos(v), np.sin(v)
    zero = np.zeros_like(u)
    return rows(
        (a * cu * cv, b * su * cv, c * sv),
        (-a * su * cv, b * cu * cv, zero),
        (-a * cu * sv, -b * su * sv, c * cv),
        (-a * cu * cv, -b * su * cv, zero),
        (a * su * sv, -b * cu * sv, zero),
        (-a * cu * cv, -b * su * cv, -c * sv),
    )


def some_points(count: int = 50) -> tuple[Float, Float]:
    rng = np.random.default_rng(0)
    return rng.uniform(0.0, 6.0, count), rng.uniform(-1.3, 1.3, count)


def some_jet(seed: int) -> Jet:
    return Jet(np.random.default_rng(seed).standard_normal((6, 7, 11, 3)))


def transformed(jet: Jet, seed: int, mirror: bool = False) -> Jet:
    """Return the jet after a change of parameters with random first and second derivatives, by the chain rule."""
    rng = np.random.default_rng(seed)
    # (u, v) as functions of (s, t): first derivatives [s, t] and second [ss, st, tt], the Jacobian positive
    first = np.eye(2) + rng.uniform(-0.4, 0.4, (2, 2))
    second = rng.standard_normal((3, 2))
    if mirror:
        first, second = first[::-1], second[::-1]
    du, dv = first[0], first[1]

    def along(p: Float, q: Float) -> Float:
        mixed: Float = p[0] * q[0] * jet.fuu + (p[0] * q[1] + p[1] * q[0]) * jet.fuv + p[1] * q[1] * jet.fvv
        return mixed

    pairs = ((du, du), (du, dv), (dv, dv))
    return Jet(
        np.stack(
            [jet.f, du[0] * jet.fu + du[1] * jet.fv, dv[0] * jet.fu + dv[1] * jet.fv]
            + [along(p, q) + w[0] * jet.fu + w[1] * jet.fv for (p, q), w in zip(pairs, second, strict=True)]
        )
    )


@pytest.mark.parametrize("radius", [1.0, 0.25, 1e6])
def test_sphere(radius: float) -> None:
    jet = ellipsoid(*some_points(), radius, radius, radius)
    analysis = curvature.analyse(jet)
    np.testing.assert_allclose(analysis.normal, jet.f / radius, atol=1e-14)
    np.testing.assert_allclose(analysis.gauss, radius**-2, rtol=1e-13)
    np.testing.assert_allclose(analysis.mean, 1.0 / radius, rtol=1e-13)
    # an umbilic: the square root of H^2 - K would leave only half the digits
    for k in curvature.principal(jet):
        np.testing.assert_allclose(k, 1.0 / radius, rtol=1e-13)
    n = analysis.normal
    expected = (np.eye(3) - n[..., :, None] * n[..., None, :]) / radius
    np.testing.assert_allclose(curvature.second_form_matrix(jet), expected, atol=1e-13 / radius)


def test_ellipsoid_gauss() -> None:
    a, b, c = 3.0, 2.0, 1.0
    jet = ellipsoid(*some_points(), a, b, c)
    x, y, z = np.moveaxis(jet.f, -1, 0)
    expected = 1.0 / (a * b * c * (x**2 / a**4 + y**2 / b**4 + z**2 / c**4)) ** 2
    np.testing.assert_allclose(curvature.gauss(jet), expected, rtol=1e-12)
    assert (curvature.principal(jet)[1] > 0.0).all()


def test_cylinder() -> None:
    u, v = some_points()
    cos, sin, zero = np.cos(u), np.sin(u), np.zeros_like(u)
    jet = rows(
        (2 * cos, 2 * sin, v),
        (-2 * sin, 2 * cos, zero),
        (zero, zero, 1.0),
        (-2 * cos, -2 * sin, zero),
        (zero, zero, zero),
        (zero, zero, zero),
    )
    np.testing.assert_allclose(curvature.gauss(jet), 0.0, atol=1e-16)
    np.testing.assert_allclose(curvature.mean(jet), 0.25, rtol=1e-14)
    k_max, k_min = curvature.principal(jet)
    np.testing.assert_allclose(k_max, 0.5, rtol=1e-14)
    np.testing.assert_allclose(k_min, 0.0, atol=1e-16)


def test_saddle_graph() -> None:
    u, v = some_points()
    one, zero = np.ones_like(u), np.zeros_like(u)
    jet = rows((u, v, u * v), (one, zero, v), (zero, one, u), (zero, zero, zero), (zero, zero, one), (zero, zero, zero))
    w = 1.0 + u * u + v * v
    np.testing.assert_allclose(curvature.gauss(jet), -(w**-2), rtol=1e-13)
    np.testing.assert_allclose(curvature.mean(jet), u * v / w**1.5, rtol=1e-13)


def test_bowl_bends_towards_its_normal_and_is_negative() -> None:
    jet = rows((0.0, 0.0, 0.0), (1.0, 0, 0), (0, 1.0, 0), (0, 0, 3.0), (0, 0, 0.0), (0, 0, 2.0))
    assert [float(k) for k in curvature.principal(jet)] == [-2.0, -3.0]
    assert curvature.mean(jet) == -2.5
    assert curvature.gauss(jet) == 6.0


@few
@given(seeds)
def test_one_pass_and_single_quantities_agree(seed: int) -> None:
    jet = some_jet(seed)
    analysis = curvature.analyse(jet)
    np.testing.assert_array_equal(analysis.gauss, curvature.gauss(jet))
    np.testing.assert_array_equal(analysis.mean, curvature.mean(jet))
    np.testing.assert_allclose(analysis.normal, jet.normal, atol=1e-14)
    E, F, G = jet.first_form
    np.testing.assert_allclose(analysis.area, np.linalg.norm(np.cross(jet.fu, jet.fv), axis=-1), rtol=1e-13)
    L, M, N = jet.second_form
    np.testing.assert_allclose(analysis.gauss * analysis.area**2, L * N - M * M, atol=1e-12)
    np.testing.assert_allclose(2.0 * analysis.mean * analysis.area**2, E * N - 2 * F * M + G * L, atol=1e-11)


@few
@given(seeds)
def test_principal_curvatures_are_the_eigenvalues_of_the_shape_operator(seed: int) -> None:
    jet = some_jet(seed)
    k_max, k_min = curvature.principal(jet)
    E, F, G = jet.first_form
    L, M, N = jet.second_form
    first = np.stack([np.stack([E, F], -1), np.stack([F, G], -1)], -1)
    second = np.stack([np.stack([L, M], -1), np.stack([M, N], -1)], -1)
    eigenvalues = np.sort(np.linalg.eigvals(np.linalg.solve(first, second)).real, axis=-1)
    scale = 1.0 + np.abs(eigenvalues).max(axis=-1)
    np.testing.assert_allclose(k_min / scale, eigenvalues[..., 0] / scale, atol=1e-7)
    np.testing.assert_allclose(k_max / scale, eigenvalues[..., 1] / scale, atol=1e-7)
    np.testing.assert_allclose(k_max * k_min / scale**2, curvature.gauss(jet) / scale**2, atol=1e-11)
    np.testing.assert_allclose((k_max + k_min) / scale, 2.0 * curvature.mean(jet) / scale, atol=1e-11)


@few
@given(seeds)
def test_second_form_in_space(seed: int) -> None:
    jet = some_jet(seed)
    W = curvature.second_form_matrix(jet)
    np.testing.assert_array_equal(W, W.swapaxes(-1, -2))
    scale = np.abs(W).max(axis=(-1, -2))
    np.testing.assert_allclose((W @ jet.normal[..., None])[..., 0] / scale[..., None], 0.0, atol=1e-11)
    L, M, N = jet.second_form
    size = scale * (1.0 + dot(jet.fu, jet.fu) + dot(jet.fv, jet.fv))
    for (a, b), value in zip(((jet.fu, jet.fu), (jet.fu, jet.fv), (jet.fv, jet.fv)), (L, M, N), strict=True):
        np.testing.assert_allclose(quadratic_form(a, W, b) / size, value / size, atol=1e-13)
    np.testing.assert_allclose(np.trace(W, axis1=-2, axis2=-1) / scale, 2 * curvature.mean(jet) / scale, atol=1e-11)


@few
@given(seeds, seeds)
def test_curvature_does_not_depend_on_the_parameters(seed: int, change: int) -> None:
    jet = ellipsoid(*some_points(), 3.0, 2.0, 1.0)
    jet = Jet(jet.coefficients + 0.1 * np.random.default_rng(seed).standard_normal((6, 50, 3)))
    other = transformed(jet, change)
    one, two = curvature.analyse(jet), curvature.analyse(other)
    k = np.abs(curvature.principal(jet)).max(axis=0)
    np.testing.assert_allclose(two.normal, one.normal, atol=1e-10)
    np.testing.assert_allclose(two.gauss / k**2, one.gauss / k**2, atol=1e-8)
    np.testing.assert_allclose(two.mean / k, one.mean / k, atol=1e-8)
    W = curvature.second_form_matrix(jet)
    np.testing.assert_allclose(curvature.second_form_matrix(other) / k[:, None, None], W / k[:, None, None], atol=1e-8)


@few
@given(seeds)
def test_turning_the_normal_over_changes_the_signs(seed: int) -> None:
    jet = some_jet(seed)
    mirrored = Jet(jet.coefficients[[0, 2, 1, 5, 4, 3]])
    one, two = curvature.analyse(jet), curvature.analyse(mirrored)
    np.testing.assert_allclose(two.normal, -one.normal, atol=1e-14)
    np.testing.assert_allclose(two.gauss, one.gauss, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(two.mean, -one.mean, rtol=1e-9, atol=1e-9)
    k_max, k_min = curvature.principal(jet)
    turned_max, turned_min = curvature.principal(mirrored)
    np.testing.assert_allclose(turned_max, -k_min, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(turned_min, -k_max, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("scale", [1e-60, 1e-3, 1e3, 1e60])
def test_curvature_scales_with_the_surface(scale: float) -> None:
    jet = ellipsoid(*some_points(), 3.0, 2.0, 1.0)
    scaled = Jet(jet.coefficients * scale)
    np.testing.assert_allclose(curvature.mean(scaled) * scale, curvature.mean(jet), rtol=1e-12)
    np.testing.assert_allclose(curvature.gauss(scaled) * scale * scale, curvature.gauss(jet), rtol=1e-12)
    for one, other in zip(curvature.principal(scaled), curvature.principal(jet), strict=True):
        np.testing.assert_allclose(one * scale, other, rtol=1e-11)


@pytest.mark.parametrize("spoil", ["vanishing", "parallel", "both vanishing"])
def test_a_degenerate_first_form_gives_nan_there_and_only_there(spoil: str) -> None:
    coefficients = ellipsoid(*some_points(), 3.0, 2.0, 1.0).coefficients.copy()
    if spoil == "parallel":
        coefficients[2, 7] = 2.0 * coefficients[1, 7]
    else:
        coefficients[2, 7] = 0.0
        coefficients[1, 7] *= spoil == "vanishing"
    jet = Jet(coefficients)
    analysis = curvature.analyse(jet)
    at_point = np.arange(50) == 7
    quantities = [analysis.gauss, analysis.mean, analysis.normal[:, 0], *curvature.principal(jet)]
    quantities.append(curvature.second_form_matrix(jet)[:, 0, 0])
    for quantity in quantities:
        np.testing.assert_array_equal(np.isnan(quantity), at_point)


def test_nothing_depends_on_the_memory_layout_or_the_company() -> None:
    jet = some_jet(3)
    planar = Jet(np.ascontiguousarray(jet.coefficients.transpose(0, 2, 3, 1)).transpose(0, 3, 1, 2))
    part = Jet(jet.coefficients[:, 2:3, 4:9])
    for quantity in (curvature.gauss, curvature.mean, curvature.second_form_matrix):
        np.testing.assert_array_equal(quantity(planar), quantity(jet))
        np.testing.assert_array_equal(quantity(part), quantity(jet)[2:3, 4:9])
    np.testing.assert_array_equal(curvature.principal(planar), curvature.principal(jet))
