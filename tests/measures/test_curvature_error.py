"""Curvature against the exact surface: zero where exact, known where flat or a graph, NaN where unknown."""

from typing import Any

import numpy as np
import pytest
from built_surfaces import Plane, UnitSphere, bumpy_octahedron, exact_cap, octahedron, one_graph, place
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import invariants
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.curvature_error import CurvatureError
from testbed.plugins.measure import Survey


def errors(surface: Surface, exact: ExactSurface | None, **settings: Any) -> dict[str, Any]:
    return dict(CurvatureError(**settings).measure(Survey(surface, exact)))


def test_without_an_exact_surface_there_is_nothing_to_compare_with() -> None:
    assert errors(octahedron(), None) == {}


def test_exact_patches_have_the_exact_curvature() -> None:
    found = errors(exact_cap(), UnitSphere())
    assert found["gauss_error_max"] < 1e-12
    assert found["mean_error_rms"] < 1e-12


@pytest.mark.parametrize("budget", [0, 60_000])
def test_flat_faces_lack_all_of_the_sphere_s_curvature(budget: int) -> None:
    found = errors(octahedron(), UnitSphere(), budget=budget)
    for name in ("gauss_error_max", "gauss_error_rms", "mean_error_max", "mean_error_rms"):
        assert found[name] == pytest.approx(1.0, abs=1e-13)


def test_the_error_of_a_graph_over_its_plane_is_its_own_curvature() -> None:
    # z = x y has K = -1 / (1 + x^2 + y^2)^2: largest in size at the corner (0, 0)
    found = errors(one_graph(lambda x, y: x * y, 2), Plane())
    assert found["gauss_error_max"] == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(place(found["gauss_error_bary"]), [1.0, 0.0, 0.0], atol=1e-12)
    assert found["gauss_error_rms"] < found["gauss_error_max"]


@pytest.mark.parametrize("seed", range(3))
def test_the_mean_lies_below_the_maximum(seed: int) -> None:
    found = errors(bumpy_octahedron(seed), UnitSphere())
    assert 0.0 < found["gauss_error_rms"] <= found["gauss_error_max"]
    assert 0.0 < found["mean_error_rms"] <= found["mean_error_max"]


def test_a_patch_that_is_not_finite_makes_all_of_it_unknown() -> None:
    surface = octahedron()
    (part,) = surface.parts
    assert isinstance(part.batch, BezierTriangles)
    points = part.batch.control_points.copy()
    points[3, 0, 0] = np.nan
    broken = Surface.over_faces(surface.mesh, BezierTriangles(points))
    found = errors(broken, UnitSphere())
    assert all(np.isnan(found[name]) for name in ("gauss_error_max", "gauss_error_rms", "mean_error_max"))
    assert found["gauss_error_face"] == 3


@given(st.integers(0, 2**32 - 1))
def test_invariants_are_those_of_the_principal_curvatures(seed: int) -> None:
    random = np.random.default_rng(seed)
    frame, _ = np.linalg.qr(random.normal(size=(5, 3, 3)))
    first, second = random.normal(size=(2, 5))
    forms: Float = (frame * np.stack([first, second, np.zeros(5)], axis=-1)[:, None]) @ frame.swapaxes(-1, -2)
    gauss, mean = invariants(forms)
    np.testing.assert_allclose(gauss, first * second, atol=1e-13)
    np.testing.assert_allclose(mean, 0.5 * (first + second), atol=1e-13)
