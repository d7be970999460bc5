"""The plane with a bump: nearest points against brute force, derivatives, the chart, and who misses it."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry.vectors import Float, norm, tangential
from testbed_datasets.bump import Bump
from testbed_datasets.bumped_plane import BumpedPlane

SHAPES = [(0.03, 0.009), (0.3, 0.4), (-0.2, 0.3), (2.0, 0.1), (1e-6, 0.5)]
every_shape = pytest.mark.parametrize(("height", "width"), SHAPES)


def around(surface: BumpedPlane, count: int, seed: int = 0) -> Float:
    random = np.random.default_rng(seed)
    scale = np.array([surface.width, surface.width, max(surface.width, abs(surface.height))])
    points: Float = np.array([*surface.place, 0.0]) + random.uniform(-1.5, 1.5, (count, 3)) * scale
    return points


@every_shape
def test_feet_are_nearest(height: float, width: float) -> None:
    surface = BumpedPlane(height, width, (0.1, -0.2))
    points = around(surface, 400)
    feet = surface.closest(points)
    found = norm(points - feet)
    assert norm(feet - surface.over(feet[:, :2])).max() < 1e-15 * (1.0 + abs(height))
    # in the half plane of the point and the axis, as the surface is one of revolution
    radius = np.linspace(0.0, 4.0 * (width + abs(height)), 40_001)
    profile = height * np.maximum(1.0 - (radius / width) ** 2, 0.0) ** 4
    own = norm(points[:, :2] - np.array(surface.place))
    for rows in np.array_split(np.arange(len(points)), 8):
        brute = np.hypot(radius - own[rows, None], profile - points[rows, 2:]).min(axis=1)
        assert (found[rows] <= brute + 1e-14).all()
    across = tangential(points - feet, surface.normal(feet))
    assert norm(across).max() < 1e-9 * (width + abs(height))


def test_feet_on_the_axis_are_one_of_a_circle() -> None:
    surface = BumpedPlane(0.3, 0.1, (0.25, 0.5))
    point = np.array([[0.25, 0.5, 0.0]])
    foot = surface.closest(point)
    assert norm(foot - surface.over(foot[:, :2]))[0] < 1e-16
    assert 0.01 < norm(foot - point)[0] < 0.1
    assert np.array_equal(surface.closest(np.array([[0.25, 0.5, 7.0]])), [[0.25, 0.5, 0.3]])
    assert np.isnan(surface.closest(np.array([[np.nan, 0.0, 0.0]]))).all()


@every_shape
def test_the_chart_is_the_surface(height: float, width: float) -> None:
    dataset = Bump(height, width, 0.3, -0.2)
    mesh, surface = dataset.charted(), dataset.surface
    at = np.clip(around(surface, 300)[:, :2], -1.0, 1.0)
    jet = mesh.charts.jets(np.zeros(300, dtype=np.int64), at)
    assert np.array_equal(jet.f, surface.over(at))
    assert np.abs(jet.normal - surface.normal(jet.f)).max() < 1e-14
    step = 1e-5 * width
    for row, axis in ((1, 0), (2, 1)):
        move = step * np.eye(2)[axis]
        beside = mesh.charts.jets(np.zeros(600, dtype=np.int64), np.concatenate([at + move, at - move]), 1)
        first = (beside.f[:300] - beside.f[300:]) / (2.0 * step)
        assert np.abs(first - jet.coefficients[row])[:, 2].max() < 1e-8 * (abs(height) / width + 1e-2 / width)
        second = (beside.fu[:300] - beside.fu[300:]) / (2.0 * step)
        assert np.abs(second - jet.coefficients[2 + row])[:, 2].max() < 1e-6 * abs(height) / width**2
    assert np.array_equal(mesh.sampled().points, dataset.mesh(0).points)
    assert mesh.followed.sum() == len(dataset.mesh(0).boundary_edges.nonzero()[0])


def test_no_vertex_of_the_coarse_meshes_is_on_the_bump() -> None:
    dataset = registry.dataset("bump")
    for level in (0, 1):
        assert not dataset.mesh(level).points[:, 2].any()


@pytest.mark.parametrize("parameter", ["width=0", "x=0.995", "y=-2", "height=inf", "width=1e-200"])
def test_bumps_that_are_none_are_refused_in_one_sentence(parameter: str) -> None:
    with pytest.raises(SpecError, match="of bump cannot be") as refusal:
        registry.dataset(f"bump[{parameter}]")
    assert "\n" not in str(refusal.value)
