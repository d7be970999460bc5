"""Control nets, marks of extremes and pictures with colours of their own show what is there."""

from pathlib import Path

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import norm
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.figure import Additions, Subject, panels, write_figure
from testbed_reports.rendering.marks import extremes
from testbed_reports.rendering.nets import _quad_pairs, _triangle_pairs, control_net, control_points
from testbed_reports.rendering.picture import look, pixels, tinted
from testbed_reports.rendering.visibility import Buffer, rasterise

SIZE = 96


def fitted(scheme: str, dataset: str = "octahedron", level: int = 0) -> Surface:
    return registry.scheme(scheme).fit(registry.dataset(dataset).mesh(level))


@pytest.mark.parametrize(("degree", "count"), [(1, 3), (2, 9), (3, 18), (4, 30)])
def test_nets_of_triangles_have_the_sides_of_their_small_triangles(degree: int, count: int) -> None:
    # degree (degree + 1) / 2 small triangles stand upright and share no side
    assert len(_triangle_pairs(degree)) == count == 3 * degree * (degree + 1) // 2


def test_nets_of_quadrilaterals_are_grids() -> None:
    assert len(_quad_pairs(4, 4)) == 24
    assert {tuple(pair) for pair in _quad_pairs(2, 2).tolist()} == {(0, 1), (0, 2), (1, 3), (2, 3)}


@pytest.mark.parametrize(
    ("scheme", "dataset", "points"),
    [
        ("cubic-interpolant", "octahedron", 80),
        ("hansford", "octahedron", 360),
        ("zero-twist-bicubic", "quad-torus", 800),
    ],
)
def test_control_points_are_those_of_the_patches(scheme: str, dataset: str, points: int) -> None:
    surface = fitted(scheme, dataset)
    found = control_points(surface)
    assert len(found) == points
    # corners of nets are the vertices
    apart = norm(surface.mesh.points[:, None] - found[None]).min(axis=1)
    assert apart.max() < 1e-12


def test_a_net_outside_the_surface_is_seen_in_front_and_not_behind() -> None:
    surface = fitted("cubic-interpolant", level=1)
    facets = facets_of(surface)
    camera = Camera.around(control_points(surface), 20.0, 30.0)
    buffer, _ = rasterise(facets, camera, 480)
    net = control_net(surface, camera, buffer)
    assert net is not None
    depth = camera.screen(control_points(surface), 480)[:, 2]
    seen = {(round(x, 6), round(y, 6)) for x, y in net.points.tolist()}
    screen = camera.screen(control_points(surface), 480)
    shown = np.array([(round(x, 6), round(y, 6)) in seen for x, y in screen[:, :2].tolist()])
    assert shown[depth > 100].all()
    assert not shown[depth < -100].any()
    assert control_net(fitted("nielson"), camera, buffer) is None


def test_marks_are_at_the_extremes_of_the_measures() -> None:
    surface = fitted("shirman-sequin")
    measured = registry.measure(surface)
    one = look(surface, "gauss", SIZE)
    assert one.buffer is not None
    largest, smallest = extremes(surface, "gauss", one.camera, one.buffer)
    assert (largest.value, smallest.value) == (measured["gauss_max"], measured["gauss_min"])
    assert largest.largest
    assert not smallest.largest
    face, bary = np.array([measured["gauss_max_face"]]), str(measured["gauss_max_bary"]).split(";")
    point = surface.evaluate(face, np.array([[float(b) for b in bary]]), 0).f
    assert largest.place is not None
    np.testing.assert_allclose(one.camera.screen(point, SIZE)[0, :2], largest.place, atol=1e-9)
    assert extremes(surface, "shaded", one.camera, one.buffer) == ()
    around = {extremes(surface, "gauss", *side)[0].seen for side in seen_from_all_sides(surface)}
    assert around == {True, False}


def seen_from_all_sides(surface: Surface) -> list[tuple[Camera, Buffer]]:
    points = facets_of(surface).points
    cameras = [Camera.around(points, float(angle), 10.0) for angle in range(0, 360, 60)]
    return [(camera, rasterise(facets_of(surface), camera, SIZE)[0]) for camera in cameras]


def test_patches_have_the_colours_that_are_given() -> None:
    surface = fitted("flat", "octahedron")
    colours = np.zeros((8, 3))
    colours[:, 0] = np.arange(8) / 8.0
    one = look(surface, "shaded", SIZE)
    base = tinted(one.sights, (colours,))
    np.testing.assert_array_equal(base[:, 0] * 8.0, one.sights.patch)
    image = pixels(one, "shaded", panels([Subject("", surface)], "shaded", SIZE)[0].scale, base)
    middle = image[SIZE // 2 - 8 : SIZE // 2 + 8, SIZE // 2 - 8 : SIZE // 2 + 8]
    # no green and blue but what shines
    assert (middle[..., 1] <= 0.26).all()


def test_subjects_have_their_own_styles_and_sides_and_share_lengths_and_scales() -> None:
    flat, round_ = fitted("flat"), fitted("shirman-sequin")
    seen = panels(
        [
            Subject("a", round_, style="gauss", view=(0.0, 0.0)),
            Subject("b", flat),
            Subject("c", fitted("cubic-interpolant"), style="gauss", view=(10.0, 90.0)),
        ],
        "shaded",
        SIZE,
    )
    assert [one.style for one in seen] == ["gauss", "shaded", "gauss"]
    assert seen[0].scale == seen[2].scale
    assert seen[0].look.camera.width == seen[2].look.camera.width
    assert seen[0].look.camera.axes != seen[2].look.camera.axes


def test_the_picture_with_everything_has_the_same_bytes_again(tmp_path: Path) -> None:
    first, second = (
        write_figure(
            tmp_path / name,
            [Subject("<a>", fitted("cubic-interpolant")), Subject("b", fitted("nielson"))],
            "thesis",
            size=SIZE,
            additions=Additions(edges="mesh", net=True, extremes=True, key=(("red", (1.0, 0.0, 0.0)),)),
        ).read_bytes()
        for name in ("one.png", "two.png")
    )
    assert first == second
