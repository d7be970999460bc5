"""Triangles of surfaces: on the patches, with their exact values, watertight where the surface is."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import TestbedError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import principal
from testbed.geometry.domain import lattice, side_points
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_reports.export.tessellation import side_places, steps_within, tessellate
from testbed_reports.export.vertices import by_patch, by_place, facet_normals

#: Schemes of all kinds of patches, with a dataset whose meshes are closed and their Euler characteristic.
CLOSED_SURFACES = [
    ("flat", "octahedron", 2),
    ("cubic-interpolant", "torus", 0),
    ("shirman-sequin", "octahedron", 2),
    ("peters", "torus", 0),
    ("hansford", "octahedron", 2),
    ("nielson", "torus", 0),
    ("triangular-gregory", "octahedron", 2),
    ("hagen-pottmann", "octahedron", 2),
    ("loop", "octahedron", 2),
    ("butterfly", "octahedron", 2),
    ("a-patch", "octahedron", 2),
    ("zero-twist-bicubic", "quad-torus", 0),
]


def fitted(scheme: str, dataset: str, level: int = 0) -> Surface:
    return registry.scheme(scheme).fit(registry.dataset(dataset).mesh(level))


def euler_characteristic(triangles: np.ndarray) -> int:
    """V - E + F, after a look whether every edge has two triangles, one of each direction."""
    halves = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)])
    assert len(np.unique(halves, axis=0)) == len(halves)
    assert len(np.unique(np.sort(halves, axis=1), axis=0)) * 2 == len(halves)
    return len(np.unique(triangles)) - len(halves) // 2 + len(triangles)


@pytest.mark.parametrize(("scheme", "dataset", "characteristic"), CLOSED_SURFACES)
@pytest.mark.parametrize("budget", [1, 2000])
def test_triangles_of_a_closed_surface_are_watertight(
    scheme: str, dataset: str, characteristic: int, budget: int
) -> None:
    surface = fitted(scheme, dataset)
    one = tessellate(surface, budget)
    vertices = by_place(one)
    assert euler_characteristic(vertices.triangles) == characteristic
    assert len(np.unique(vertices.triangles)) == len(vertices.points)
    # places that are not one are apart, and those that are, are to the last bit
    assert len(np.unique(one.points, axis=0)) == len(vertices.points)
    np.testing.assert_array_equal(vertices.points[one.place], one.points)


@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("steps", [1, 2, 5])
def test_the_points_along_a_side_are_those_of_the_lattice(sides: int, steps: int) -> None:
    along = lattice(sides, steps)[side_places(sides, steps)]
    expected = side_points(sides, np.arange(sides), np.arange(steps + 1) / steps)
    np.testing.assert_allclose(along, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("scheme", "dataset"), [("hagen-pottmann", "torus"), ("shirman-sequin", "torus")])
def test_points_normals_and_curvatures_are_the_patches_own(scheme: str, dataset: str) -> None:
    surface = fitted(scheme, dataset)
    one = tessellate(surface, 5000)
    steps = steps_within(surface, 5000)
    at = lattice(3, steps)
    jet = surface.batches[0].jets(at, 2)
    np.testing.assert_allclose(one.points, jet.f.reshape(-1, 3), rtol=0, atol=1e-12)
    np.testing.assert_allclose(one.normals, jet.normal.reshape(-1, 3), rtol=0, atol=1e-15)
    larger, smaller = principal(jet)
    np.testing.assert_allclose(one.gauss, (larger * smaller).ravel(), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(one.mean, 0.5 * (larger + smaller).ravel(), rtol=1e-9, atol=1e-9)
    # triangles look where the normals do, and lie on the patches that they name
    np.testing.assert_array_equal(one.face, surface.parts[0].faces[one.patch])
    np.testing.assert_array_equal(one.triangles // len(at), np.repeat(one.patch[:, None], 3, axis=1))
    corner = one.points[one.triangles]
    facing = dot(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), one.normals[one.triangles[:, 0]])
    assert (facing > 0.0).all()


def test_distances_are_from_the_exact_surface() -> None:
    dataset = registry.dataset("octahedron")
    one = tessellate(fitted("shirman-sequin", "octahedron"), 2000, dataset.surface)
    assert one.distance is not None
    np.testing.assert_allclose(one.distance, np.abs(norm(one.points) - 1.0), rtol=0, atol=1e-14)
    assert one.distance.max() > 1e-3


@pytest.mark.parametrize(("budget", "expected"), [(1, 8), (8, 8), (31, 8), (32, 32), (71, 32), (72, 72)])
def test_there_are_no_more_triangles_than_asked_for_if_one_a_patch_allows_it(budget: int, expected: int) -> None:
    assert len(tessellate(fitted("flat", "octahedron"), budget).triangles) == expected


def two_faces(lift: float) -> Surface:
    """Two flat triangles with a common edge; the second is lifted off the first by a distance."""
    mesh = HermiteMesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.5]]), np.array([[0, 1, 2], [2, 1, 3]]))
    nets = mesh.corner_points().copy()
    nets[1, :, 2] += lift
    return Surface.over_faces(mesh, BezierTriangles(nets))


def test_neighbours_share_points_where_they_agree_and_a_gap_stays() -> None:
    joined, apart = (tessellate(two_faces(lift), 18) for lift in (1e-15, 1e-6))
    assert joined.place.max() + 1 == 2 * 10 - 4
    assert apart.place.max() + 1 == 2 * 10
    np.testing.assert_array_equal(apart.points[10:, 2].min(), 1e-6)


def test_a_shared_vertex_has_the_mean_of_the_patches_and_tells_how_far_they_are_off() -> None:
    one = tessellate(two_faces(0.0), 18)
    vertices = by_place(one)
    shared = np.bincount(one.place) == 2
    angle = np.degrees(np.arccos(dot(one.normals[0], one.normals[-1])))
    np.testing.assert_allclose(vertices.scalars["normal_deviation_deg"][shared], 0.5 * angle, rtol=1e-12)
    assert (vertices.scalars["normal_deviation_deg"][~shared] == 0.0).all()
    np.testing.assert_allclose(norm(vertices.normals), 1.0, rtol=0, atol=1e-15)
    own = by_patch(one)
    assert len(own.points) == 20
    np.testing.assert_array_equal(own.normals, one.normals)


def test_what_one_patch_does_not_know_its_vertex_does_not() -> None:
    one = tessellate(fitted("nielson", "octahedron"), 500)
    vertices = by_place(one)
    assert np.isnan(one.gauss).sum() == 3 * 8
    lacking = np.isnan(vertices.scalars["gauss"])
    assert lacking.sum() == 6
    assert np.isnan(vertices.scalars["gauss_deviation"][lacking]).all()
    assert np.isfinite(vertices.normals).all()
    np.testing.assert_allclose(np.abs(vertices.points[lacking]).max(axis=1), 1.0)


def test_vertices_of_smooth_surfaces_have_no_deviation_of_the_normal() -> None:
    bent = by_place(tessellate(fitted("shirman-sequin", "torus"), 3000)).scalars["normal_deviation_deg"]
    assert bent.max() < 1e-8
    creased = by_place(tessellate(fitted("flat", "torus"), 3000)).scalars["normal_deviation_deg"]
    assert creased.max() > 5.0


def test_normals_of_facets_are_weighted_by_area() -> None:
    points: Float = np.array([[0.0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1], [9, 9, 9]])
    found = facet_normals(points, np.array([[0, 1, 2], [0, 2, 3]]))
    np.testing.assert_allclose(found[0], np.array([1.0, 0, 2]) / np.sqrt(5.0))
    np.testing.assert_allclose(found[1], [0, 0, 1])
    assert np.isnan(found[4]).all()


def test_a_patch_that_is_no_number_is_refused_by_its_face() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    nets = mesh.corner_points().copy()
    nets[5, 1] = np.nan
    with pytest.raises(TestbedError, match="patch on face 5 has points that are no numbers"):
        tessellate(Surface.over_faces(mesh, BezierTriangles(nets)))


def test_collapsed_sides_make_no_triangles_without_area() -> None:
    surface = fitted("a-patch", "octahedron")
    assert [part.batch.collapsed for part in surface.parts] == [(), (1, 3)]
    one = tessellate(surface, 4000)
    corner = one.points[one.triangles]
    area = norm(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    assert area.min() > 0.0
    steps = steps_within(surface, 4000)
    assert len(area) == (8 + 2 * 12) * steps**2 - 12 * 2 * steps
