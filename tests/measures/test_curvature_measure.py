from typing import Any

import numpy as np
import pytest
from built_surfaces import OCTAHEDRON, OCTANTS, bumpy_octahedron, exact_cap, octahedron, one_graph, place

from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.jets import Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.curvature import CurvatureExtremes
from testbed.plugins.measure import Survey

EXTREMES = ("gauss_min", "gauss_max", "mean_min", "mean_max")


def extremes(surface: Surface, **settings: Any) -> dict[str, Any]:
    return dict(CurvatureExtremes(**settings).measure(Survey(surface)))


def test_a_flat_surface_has_no_curvature() -> None:
    found = extremes(octahedron())
    assert [repr(found[name]) for name in EXTREMES] == ["0.0"] * 4


def test_a_sphere_has_curvature_one_everywhere() -> None:
    found = extremes(exact_cap())
    assert [found[name] for name in EXTREMES] == pytest.approx([1.0] * 4, abs=1e-12)


@pytest.mark.parametrize("budget", [0, 60_000])
def test_a_maximum_inside_a_patch_is_found_between_the_samples(budget: int) -> None:
    # the paraboloid's vertex: K = 9, H = 3
    found = extremes(one_graph(lambda x, y: -1.5 * ((x - 0.2371) ** 2 + (y - 0.3313) ** 2), 2), budget=budget)
    assert found["gauss_max"] == pytest.approx(9.0, rel=1e-9)
    assert found["mean_max"] == pytest.approx(3.0, rel=1e-9)
    np.testing.assert_allclose(place(found["gauss_max_bary"]), [0.4316, 0.2371, 0.3313], atol=1e-4)
    assert found["gauss_max_face"] == 0


@pytest.mark.parametrize("budget", [0, 60_000])
def test_a_maximum_on_the_boundary_is_found_between_the_samples(budget: int) -> None:
    # vertex outside the triangle, nearest to (0.3717, 0): K = 9 / (1 + 9 0.2^2)^2 there
    found = extremes(one_graph(lambda x, y: -1.5 * ((x - 0.3717) ** 2 + (y + 0.2) ** 2), 2), budget=budget)
    assert found["gauss_max"] == pytest.approx(9.0 / 1.36**2, rel=1e-9)
    np.testing.assert_allclose(place(found["gauss_max_bary"]), [0.6283, 0.3717, 0.0], atol=1e-4)


def test_a_maximum_on_the_slanted_boundary_is_found() -> None:
    # vertex 0.1 (1, 1) beyond the side x + y = 1, at (0.6717, 0.5283)
    found = extremes(one_graph(lambda x, y: -1.5 * ((x - 0.6717) ** 2 + (y - 0.5283) ** 2), 2), budget=0)
    assert found["gauss_max"] == pytest.approx(9.0 / (1.0 + 9.0 * 0.02) ** 2, rel=1e-9)


def test_a_minimum_at_a_corner_is_found() -> None:
    found = extremes(one_graph(lambda x, y: -1.5 * (x**2 + y**2), 2))
    assert found["gauss_min"] == pytest.approx(9.0 / 100.0, rel=1e-12)
    assert 1.0 in place(found["gauss_min_bary"])


@pytest.mark.parametrize("seed", range(5))
def test_extremes_reach_those_of_a_fifty_times_denser_lattice(seed: int) -> None:
    surface = bumpy_octahedron(seed)
    found = extremes(surface)
    dense = lattice(3, 100)
    assert len(dense) > 49 * found["samples_per_patch"]
    every = analyse(surface.batches[0].jets(dense))
    assert found["gauss_min"] <= every.gauss.min()
    assert found["gauss_max"] >= every.gauss.max()
    assert found["mean_min"] <= every.mean.min()
    assert found["mean_max"] >= every.mean.max()


@pytest.mark.parametrize("name", EXTREMES)
def test_the_place_is_where_the_extremum_is(name: str) -> None:
    surface = bumpy_octahedron()
    found = extremes(surface)
    there = analyse(surface.evaluate(np.array([found[f"{name}_face"]]), place(found[f"{name}_bary"])[None]))
    value = there.gauss if name.startswith("gauss") else there.mean
    assert value[0] == pytest.approx(found[name], rel=1e-9)


def test_turning_the_surface_over_negates_the_mean_curvature_and_keeps_the_gaussian() -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    # swapping corners 1 and 2 swaps exponents j and k
    swapped = np.array([0, 2, 1, 5, 4, 3, 9, 8, 7, 6, 14, 13, 12, 11, 10])
    over = Surface.over_faces(
        HermiteMesh(OCTAHEDRON, OCTANTS[:, [0, 2, 1]]), BezierTriangles(batch.control_points[:, swapped])
    )
    up, down = extremes(surface), extremes(over)
    assert down["gauss_min"] == pytest.approx(up["gauss_min"], rel=1e-9)
    assert down["gauss_max"] == pytest.approx(up["gauss_max"], rel=1e-9)
    assert down["mean_min"] == pytest.approx(-up["mean_max"], rel=1e-9)
    assert down["mean_max"] == pytest.approx(-up["mean_min"], rel=1e-9)


class SingularCorners(BezierTriangles):
    """Polynomial patches without second derivatives at their corners, as blended patches have none."""

    corner_margin = 0.01

    def jets(self, at: Float, order: int = 2) -> Jet:
        coefficients = super().jets(at, order).coefficients.copy()
        corner = np.broadcast_to((barycentric(at) == 0.0).sum(axis=-1) == 2, coefficients.shape[1:3])
        coefficients[3:, corner] = np.nan
        return Jet(coefficients)


def test_corners_of_blended_patches_are_kept_off_by_the_margin_that_is_stated() -> None:
    plain = one_graph(lambda x, y: -1.5 * (x**2 + 2.0 * y**2), 2)
    batch = plain.batches[0]
    assert isinstance(batch, BezierTriangles)
    found = extremes(Surface.over_faces(plain.mesh, SingularCorners(batch.control_points)))
    assert found["curvature_corner_margin"] == 0.01
    # largest at corner 0, so on the margin: at x + y = 0.01, of the points there K is largest near y = 0.002
    x, y = np.linspace(0.0, 0.01, 10001), 0.01 - np.linspace(0.0, 0.01, 10001)
    expected = (18.0 / (1.0 + 9.0 * x**2 + 36.0 * y**2) ** 2).max()
    assert found["gauss_max"] == pytest.approx(expected, rel=1e-9)
    assert place(found["gauss_max_bary"])[0] == pytest.approx(0.99, abs=1e-12)
    assert extremes(plain)["gauss_max"] == pytest.approx(18.0, rel=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_patch_that_is_not_finite_is_the_extremum_and_names_the_face(bad: float) -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[5, 7, 1] = bad
    found = extremes(Surface.over_faces(surface.mesh, BezierTriangles(points)))
    for name in EXTREMES:
        assert np.isnan(found[name])
        assert found[f"{name}_face"] == 5


def test_a_patch_that_collapses_at_a_corner_has_no_curvature() -> None:
    surface = one_graph(lambda x, y: x * y, 3)
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[0, 1] = points[0, 0]
    assert np.isnan(extremes(Surface.over_faces(surface.mesh, BezierTriangles(points)))["gauss_max"])


def test_squares_are_searched_in_their_own_parameters() -> None:
    # z = -1.5 ((x - 0.4371)^2 + (y - 0.8313)^2) on the unit square as a biquadratic
    def form(centre: float) -> Float:
        return np.array([centre**2, centre**2 - centre, (1.0 - centre) ** 2])

    x, y = np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij")
    net = np.stack([x, y, -1.5 * (form(0.4371)[:, None] + form(0.8313)[None])], axis=-1)[None]
    mesh = HermiteMesh(net[0, [0, 2, 2, 0], [0, 0, 2, 2]], np.array([[0, 1, 2, 3]]))
    found = extremes(Surface.over_faces(mesh, BezierQuads(net)))
    assert found["gauss_max"] == pytest.approx(9.0, rel=1e-9)
    np.testing.assert_allclose(place(found["gauss_max_bary"]), [0.4371, 0.8313], atol=1e-4)
