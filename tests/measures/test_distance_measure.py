from typing import Any

import numpy as np
import pytest
from built_surfaces import Plane, UnitSphere, bumpy_octahedron, exact_cap, flat, octahedron, one_graph, place

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed.measures.distance import Distance, deviations
from testbed.plugins.measure import Survey


def distances(surface: Surface, exact: ExactSurface | None, **settings: Any) -> dict[str, Any]:
    return dict(Distance(**settings).measure(Survey(surface, exact)))


def test_without_an_exact_surface_there_are_no_distances() -> None:
    assert distances(octahedron(), None) == {}


def test_exact_patches_are_at_no_distance() -> None:
    found = distances(exact_cap(), UnitSphere())
    assert found["distance_max"] < 1e-15
    assert found["distance_rms"] < 1e-15
    assert found["normal_max_deg"] < 1e-12


@pytest.mark.parametrize("budget", [0, 60_000])
def test_the_flat_octahedron_is_farthest_from_the_sphere_at_its_face_centres(budget: int) -> None:
    found = distances(octahedron(), UnitSphere(), budget=budget)
    assert found["distance_max"] == pytest.approx(1.0 - 1.0 / np.sqrt(3.0), abs=1e-12)
    np.testing.assert_allclose(place(found["distance_max_bary"]), 1.0 / 3.0, atol=1e-6)
    # at a vertex, between (1, 0, 0) and (1, 1, 1) / sqrt(3)
    assert found["normal_max_deg"] == pytest.approx(np.degrees(np.arccos(1.0 / np.sqrt(3.0))), abs=1e-10)
    assert 1.0 in place(found["normal_max_bary"])


def test_the_root_mean_square_of_a_linear_distance_is_exact() -> None:
    surface = one_graph(lambda x, _: 3.0 * x, 1)
    found = distances(surface, Plane())
    # mean of (3 x)^2 over the triangle: 9 * 2 / 12
    assert found["distance_rms"] == pytest.approx(np.sqrt(1.5), rel=1e-14)
    assert found["distance_max"] == pytest.approx(3.0, rel=1e-15)


@pytest.mark.parametrize("budget", [0, 60_000])
def test_a_maximum_between_the_samples_is_found(budget: int) -> None:
    # x (1 - x - y) y^2: largest at b = (1/4, 1/4, 1/2)
    found = distances(one_graph(lambda x, y: x * (1.0 - x - y) * y**2, 4), Plane(), budget=budget)
    assert found["distance_max"] == pytest.approx(1.0 / 64.0, rel=1e-9)
    np.testing.assert_allclose(place(found["distance_max_bary"]), [0.25, 0.25, 0.5], atol=1e-5)


@pytest.mark.parametrize("seed", range(3))
def test_maxima_reach_those_of_a_fifty_times_denser_lattice(seed: int) -> None:
    surface = bumpy_octahedron(seed)
    found = distances(surface, UnitSphere())
    jet = surface.batches[0].jets(lattice(3, 100), 1)
    distance, angle = deviations(UnitSphere(), jet.f, jet.normal)
    assert found["distance_max"] >= distance.max()
    assert found["normal_max_deg"] >= np.degrees(angle.max())


def test_the_root_mean_square_is_weighted_by_area() -> None:
    # distance 0 on a triangle of area 4.5, b2 on one of area 1.5 sqrt(2)
    corners = np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0], [-3.0, 0.0, 0.0], [1.0, 0.0, 1.0]])
    found = distances(flat(corners, np.array([[0, 1, 2], [1, 0, 3]])), Plane())
    small = 1.5 * np.sqrt(2.0)
    assert found["distance_rms"] == pytest.approx(np.sqrt(small / 6.0 / (4.5 + small)), rel=1e-13)


def test_a_point_without_a_foot_is_never_a_pass() -> None:
    class Blind(UnitSphere):
        def closest(self, points: Float) -> Float:
            feet = super().closest(points)
            feet[points[:, 0] > 0.9] = np.nan
            return feet

    found = distances(octahedron(), Blind())
    assert np.isnan(found["distance_max"])
    assert np.isnan(found["distance_rms"])
    assert np.isnan(found["normal_max_deg"])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_control_point_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[3, 4] = bad
    found = distances(Surface.over_faces(surface.mesh, BezierTriangles(points)), UnitSphere())
    assert not any(np.isfinite(found[name]) for name in ("distance_max", "distance_rms", "normal_max_deg"))
    assert found["distance_max_face"] == found["normal_max_face"] == 3


def test_a_collapsed_corner_costs_the_normals_only() -> None:
    surface = one_graph(lambda x, y: x * y, 3)
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[0, 1] = points[0, 0]
    found = distances(Surface.over_faces(surface.mesh, BezierTriangles(points)), Plane())
    assert np.isnan(found["normal_max_deg"])
    assert place(found["normal_max_bary"])[0] == 1.0
    assert np.isfinite(found["distance_max"])


def test_the_place_is_where_the_maximum_is() -> None:
    surface = bumpy_octahedron(7)
    found = distances(surface, UnitSphere())
    at = surface.evaluate(np.array([found["distance_max_face"]]), place(found["distance_max_bary"])[None], 0).f
    assert abs(norm(at)[0] - 1.0) == pytest.approx(found["distance_max"], rel=1e-12)
