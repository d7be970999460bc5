"""Pictures show what is there: silhouettes, hidden surfaces, exact values where pixels look, the same bytes again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_reports.rendering.camera import MARGIN, Camera
from testbed_reports.rendering.colouring import BACKGROUND, INNER, MISSING, Scale, Style, palette, rounded_up
from testbed_reports.rendering.facets import Facets, facets_of, lattice_facets, steps_of
from testbed_reports.rendering.fields import Fields
from testbed_reports.rendering.figure import Subject, write_figure
from testbed_reports.rendering.lines import PIECES
from testbed_reports.rendering.picture import common_scale, look, pixels
from testbed_reports.rendering.visibility import GRID, rasterise, sights

SIZE = 96


def sphere(scheme: str = "shirman-sequin", level: int = 1) -> Surface:
    return registry.scheme(scheme).fit(registry.dataset("octahedron").mesh(level))


def linear(points: Float, faces: list[list[int]]) -> Surface:
    mesh = HermiteMesh(points, faces)
    return Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()))


def squares(*heights: float) -> Surface:
    """Squares of side 2 over each other, upwards, the first the largest."""
    points = [[x, y, z] for number, z in enumerate(heights) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    shrink = np.repeat(0.5 ** np.arange(len(heights)), 4)[:, None] * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
    faces = [[4 * n + i for i in half] for n in range(len(heights)) for half in ((0, 1, 2), (0, 2, 3))]
    return linear(np.array(points, dtype=np.float64) * shrink, faces)


@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("steps", [1, 2, 7])
def test_facets_cover_the_domain_once_counterclockwise(sides: int, steps: int) -> None:
    corners = lattice(sides, steps)[lattice_facets(sides, steps)]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    np.testing.assert_allclose(area, (0.5 if sides == 3 else 1.0) / len(corners), rtol=1e-12)
    assert len(corners) == (sides - 2) * steps**2


def test_facets_lie_on_their_patches_where_they_say() -> None:
    surface = sphere()
    facets = facets_of(surface, 2000)
    assert len(facets) == 3 * 32 * steps_of(surface, 2000) ** 2
    jets = surface.parts[0].batch.take(facets.patch).jets(facets.at, 0)
    np.testing.assert_allclose(jets.f, facets.points[facets.corners], rtol=0, atol=1e-15)


def test_the_silhouette_of_a_sphere_is_a_disc_within_the_margin() -> None:
    facets = facets_of(sphere("cubic-interpolant", 2))
    camera = Camera.around(facets.points, 17.0, 40.0)
    buffer, weights = rasterise(facets, camera, SIZE)
    seen = buffer.facet >= 0
    radius = 0.5 * (1.0 - 2.0 * MARGIN) * SIZE * GRID
    assert seen.sum() == pytest.approx(np.pi * radius**2, rel=2e-3)
    row, column = np.nonzero(seen)
    assert np.hypot(row + 0.5 - 0.5 * GRID * SIZE, column + 0.5 - 0.5 * GRID * SIZE).max() < radius + 0.1
    place = np.arange(GRID * SIZE)
    everywhere = weights[place[:, None], place[None]]
    assert (np.isnan(everywhere).any(axis=-1) == ~seen).all()
    assert everywhere[seen].min() >= 0.0
    np.testing.assert_allclose(everywhere[seen].sum(axis=-1), 1.0, rtol=0, atol=1e-12)


def test_samples_see_the_nearest_of_all_triangles_over_them() -> None:
    # triangles in all positions, large and small, facing both ways, one without an area
    rng = np.random.default_rng(5)
    count = 300
    points = rng.uniform(-1.0, 1.0, (count, 1, 3)) + rng.normal(size=(count, 3, 3)) * rng.uniform(
        0.01, 0.7, (count, 1, 1)
    )
    points[7, 2] = points[7, 1]
    corners = np.arange(3 * count).reshape(-1, 3)
    patch = np.arange(count)
    facets = Facets(points.reshape(-1, 3), corners, 0 * patch, patch, np.zeros((count, 3, 2)))
    camera = Camera.around(facets.points, 10.0, 70.0)
    size = 40
    buffer, weights = rasterise(facets, camera, size)
    screen = camera.screen(facets.points, GRID * size)[corners]
    row, column = np.indices((GRID * size, GRID * size))
    place = np.stack([column + 0.5, row + 0.5], axis=-1)
    a, b, c = (screen[:, i, :2] for i in range(3))

    def turn(p: Float, q: Float, r: Float) -> Float:
        result: Float = (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (
            r[..., 0] - p[..., 0]
        )
        return result

    with np.errstate(invalid="ignore", divide="ignore"):
        area = turn(a, b, c)
        shares = np.stack(
            [turn(b, c, place[:, :, None]), turn(c, a, place[:, :, None]), turn(a, b, place[:, :, None])], -1
        )
        shares /= area[:, None]
        depth = np.where((shares >= 0.0).all(axis=-1), (shares * screen[:, :, 2]).sum(axis=-1), -np.inf)
    nearest = depth.max(axis=-1)
    np.testing.assert_array_equal(buffer.facet, np.where(np.isfinite(nearest), depth.argmax(axis=-1), -1))
    known = np.isfinite(nearest)
    np.testing.assert_allclose(buffer.depth[known] * GRID, nearest[known], rtol=0, atol=1e-6)
    own = np.take_along_axis(shares, buffer.facet[..., None, None], axis=2)[:, :, 0]
    np.testing.assert_allclose(weights[row, column][known], own[known], rtol=0, atol=1e-9)


def test_what_is_nearer_hides_what_is_farther_whatever_the_order() -> None:
    for heights in ((0.0, 1.0, 2.0), (2.0, 1.0, 0.0)):
        surface = squares(*heights)
        facets = facets_of(surface, 100)
        camera = Camera.around(facets.points, 0.0, 90.0)
        buffer, _ = rasterise(facets, camera, SIZE)
        middle = facets.patch[buffer.facet[GRID * SIZE // 2 + 3, GRID * SIZE // 2 + 5]]
        assert middle // 2 == int(np.argmax(heights))
        shown = {int(patch) // 2 for patch in facets.patch[buffer.facet[buffer.facet >= 0]]}
        assert shown == ({0, 1, 2} if heights[0] == 0.0 else {0})


def test_pixels_look_at_the_points_that_they_show() -> None:
    surface = sphere("nielson")
    facets = facets_of(surface)
    camera = Camera.around(facets.points)
    buffer, weights = rasterise(facets, camera, SIZE)
    for every_sample in (False, True):
        seen = sights(facets, buffer, weights, every_sample=every_sample)
        points = surface.parts[0].batch.take(seen.patch).jets(seen.at[:, None], 0).f[:, 0]
        screen = camera.screen(points, SIZE)
        row, column = np.divmod(seen.pixel, SIZE)
        # facets are chords: where the surface is seen edge on they are off by a little more than half a pixel
        off = np.hypot(screen[:, 0] - column - 0.5, screen[:, 1] - row - 0.5)
        assert np.quantile(off, 0.99) < 0.5
        assert off.max() < 0.9
        share = np.bincount(seen.pixel, weights=seen.share, minlength=SIZE * SIZE)
        covered = (buffer.facet >= 0).reshape(SIZE, GRID, SIZE, GRID).mean(axis=(1, 3)).ravel()
        np.testing.assert_allclose(share, covered, rtol=0, atol=1e-12)


def test_normals_and_curvatures_are_those_of_the_patches_and_not_of_the_facets() -> None:
    surface = registry.scheme("a-patch[free=quadric]").fit(registry.dataset("icosahedron").mesh(0))
    one = look(surface, "gauss", SIZE)
    assert np.quantile(np.abs(one.fields.gauss - 1.0), 0.99) < 1e-6
    assert norm(one.fields.normals).min() == pytest.approx(1.0, abs=1e-12)


def test_a_closed_surface_shows_its_outer_side_and_a_bowl_both() -> None:
    closed = look(sphere(), "shaded", SIZE)
    assert (dot(closed.fields.normals, closed.camera.towards) > -0.05).all()
    below = look(squares(0.0), "shaded", SIZE, Camera.around(squares(0.0).mesh.points, 0.0, -60.0))
    image = pixels(below, "shaded", Scale(0.0, 1.0))
    middle = image[SIZE // 2, SIZE // 2]
    assert middle[0] > middle[2]
    assert INNER[0] > INNER[2]


def test_maps_have_the_colours_of_their_values_and_lines_beyond_the_limits() -> None:
    one = look(sphere("cubic-interpolant", 2), "gauss", SIZE)
    image = pixels(one, "gauss", Scale(-2.0, 2.0))
    top = palette("gauss")[round(0.75 * 255)]
    middle = image[SIZE // 2 - 12, SIZE // 2 - 8]
    np.testing.assert_allclose(middle / middle.max(), top / top.max(), atol=0.02)
    clamped = pixels(one, "gauss", Scale(-0.5, 0.5))
    inner = clamped[SIZE // 2 - 12 : SIZE // 2 + 12, SIZE // 2 - 12 : SIZE // 2 + 12].sum(axis=-1)
    dark = inner < 0.6 * np.median(inner)
    assert 0.1 < dark.mean() < 0.25
    within = image[SIZE // 2 - 12 : SIZE // 2 + 12, SIZE // 2 - 12 : SIZE // 2 + 12].sum(axis=-1)
    assert not (within < 0.8 * np.median(within)).any()


@pytest.mark.parametrize("style", ["shaded", "patches", "gauss", "isophotes", "zebra", "jump"])
def test_a_place_without_a_value_is_seen_as_such(style: Style) -> None:
    one = look(sphere("flat"), style, SIZE)
    nothing = np.full(len(one.sights), np.nan)
    lost = replace(one, fields=Fields(np.full((len(one.sights), 3), np.nan), nothing, nothing, nothing))
    image = pixels(lost, style, Scale(-1.0, 1.0))
    np.testing.assert_array_equal(image[0, 0], BACKGROUND)
    np.testing.assert_allclose(image[SIZE // 2, SIZE // 2], MISSING, rtol=0, atol=1e-12)


def test_scales_are_round_symmetric_for_curvature_and_common() -> None:
    looks = [look(sphere(scheme), "gauss", SIZE) for scheme in ("shirman-sequin", "flat")]
    scale = common_scale(looks, "gauss")
    assert scale.low == -scale.high
    assert scale.high == rounded_up(scale.high)
    assert Scale.of("thesis", np.array([9.0])) == Scale(-4.0, 4.0)
    assert Scale.of("distance", np.array([0.0, 0.011, np.nan])) == Scale(0.0, 0.015)
    assert [rounded_up(value) for value in (1.0, 1.2, 2.9, 0.071, 8.0, 0.0)] == [1.0, 1.5, 3.0, 0.1, 10.0, 1.0]


def test_hidden_edges_are_not_drawn() -> None:
    flat = registry.scheme("flat").fit(registry.dataset("octahedron").mesh(0))
    one = look(flat, "patches", SIZE, Camera.around(flat.mesh.points, 30.0, 35.0))
    # of an octahedron seen askew nine of its twelve edges are in front
    drawn = norm(one.lines.ends[:, 1] - one.lines.ends[:, 0]).sum()
    screen = one.camera.screen(flat.mesh.points, SIZE)[:, :2]
    ends = screen[flat.mesh.edges]
    faces = flat.mesh.corner_points()
    front = dot(cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), one.camera.towards) > 0
    beside = front[flat.mesh.edge_faces].any(axis=1)
    assert beside.sum() == 9
    assert drawn == pytest.approx(norm(ends[beside, 1] - ends[beside, 0]).sum(), rel=0.06)
    assert np.nanmax(one.lines.angle_deg) == pytest.approx(70.528779, abs=1e-5)


@pytest.mark.parametrize("style", ["gauss", "patches", "jump", "zebra", "distance"])
def test_the_same_surfaces_make_the_same_bytes(tmp_path: Path, style: Style) -> None:
    dataset = registry.dataset("octahedron")
    mesh = dataset.mesh(0)
    again = mesh.with_face_order(np.arange(len(mesh.faces)))
    scheme = registry.scheme("cubic-interpolant")
    written = [
        write_figure(
            tmp_path / f"{number}.png",
            [Subject("<cubic> & co", scheme.fit(data), dataset.surface)],
            style,
            size=SIZE,
            title="A title that takes more than one line because it is so long, as titles sometimes are",
        ).read_bytes()
        for number, data in enumerate((mesh, again))
    ]
    assert written[0] == written[1]
    assert written[0].startswith(b"\x89PNG")


def test_a_view_is_two_numbers() -> None:
    with pytest.raises(SpecError, match="does not exist"):
        Camera.around(np.zeros((1, 3)), float("nan"), 0.0)


def test_edges_along_the_outline_are_drawn_whole_and_those_behind_it_not_at_all() -> None:
    surface = registry.scheme("cubic-interpolant").fit(registry.dataset("octahedron").mesh(0))
    points = facets_of(surface).points
    along = look(surface, "patches", 480, Camera.around(points, 0.0, 0.0)).lines
    # four edges on the outline, and of the eight others the four in front
    assert len(along.ends) == 8 * PIECES
    behind = look(surface, "patches", 480, Camera.around(points, 12.0, 17.0))
    assert len(behind.lines.ends) < 9.5 * PIECES
    # lines are pieces without gaps: where one ends another begins, but for few ends
    ends = behind.lines.ends.reshape(-1, 2)
    apart = norm(ends[:, None] - ends[None]) + 1e9 * np.eye(len(ends))
    assert (apart.min(axis=1) > 1e-6).sum() <= 8
