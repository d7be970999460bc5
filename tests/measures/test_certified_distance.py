from typing import Any

import numpy as np
import pytest
from built_surfaces import UnitSphere, bumpy_octahedron

from testbed import registry
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.surface import Surface
from testbed.measures.certified_distance import CertifiedDistance
from testbed.measures.distance import Distance
from testbed.plugins.measure import Survey
from testbed_datasets.sphere import RoundSphere


def both(surface: Surface, exact: Any, **settings: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    survey = Survey(surface, exact)
    return dict(Distance().measure(survey)), dict(CertifiedDistance(**settings).measure(survey))


@pytest.mark.parametrize("scheme", ["flat", "cubic-interpolant", "shirman-sequin"])
@pytest.mark.parametrize("name", ["sphere", "torus", "ellipsoid", "hyperboloid", "graph"])
def test_the_searched_maximum_is_between_the_bounds(name: str, scheme: str) -> None:
    dataset = registry.dataset(name)
    found, bounds = both(registry.scheme(scheme).fit(dataset.mesh(0)), dataset.surface, pieces=20_000)
    assert bounds["distance_max_low"] <= found["distance_max"] * (1.0 + 1e-9)
    assert found["distance_max"] <= bounds["distance_max_high"] <= 1.25 * found["distance_max"]
    assert bounds["distance_max_low"] >= 0.8 * found["distance_max"]


@pytest.mark.parametrize("scheme", ["flat", "cubic-interpolant", "shirman-sequin"])
@pytest.mark.parametrize("level", [0, 1])
def test_samples_miss_the_bump_and_bounds_do_not(scheme: str, level: int) -> None:
    dataset = registry.dataset("bump")
    found, bounds = both(registry.scheme(scheme).fit(dataset.mesh(level)), dataset.surface)
    assert found["distance_max"] == 0.0
    # under the top the sides are nearer than the top, whose height is 0.03
    assert 0.006 < bounds["distance_max_low"] < bounds["distance_max_high"] < 0.008


def test_the_plane_is_at_no_distance() -> None:
    dataset = registry.dataset("plane")
    _, bounds = both(registry.scheme("cubic-interpolant").fit(dataset.mesh(0)), dataset.surface)
    assert bounds["distance_max_low"] == 0.0
    assert bounds["distance_max_high"] < 1e-13


def test_there_are_no_bounds_without_a_level_set_or_polynomials_or_for_many_patches() -> None:
    surface = bumpy_octahedron()
    assert both(surface, None)[1] == {}
    assert both(surface, UnitSphere())[1] == {}
    assert both(surface, RoundSphere(1.0), patches=7)[1] == {}
    assert both(surface, RoundSphere(1.0), patches=8)[1] != {}
    octahedron = registry.dataset("octahedron")
    assert both(registry.scheme("nielson").fit(octahedron.mesh(0)), octahedron.surface)[1] == {}


def test_bounds_far_apart_are_left_out() -> None:
    surface = bumpy_octahedron()
    assert both(surface, RoundSphere(1.0), pieces=8, widest=1.001)[1] == {}


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_control_point_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[3, 4] = bad
    assert both(Surface.over_faces(surface.mesh, BezierTriangles(points)), RoundSphere(1.0))[1] == {}
