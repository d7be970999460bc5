"""The pictures that papers print: rows that can be drawn, and are; planes, levels, parts of surfaces, curves."""

from pathlib import Path

import numpy as np
import pytest

from testbed import registry
from testbed.errors import SpecError, TestbedError
from testbed.geometry.vectors import dot, norm
from testbed_reports.redrawn import Redrawn, attempt, draw_again, parse_redrawn, pictures_of, redrawn_table
from testbed_reports.redrawn_curves import arc, curve_plot
from testbed_reports.redrawn_surfaces import PLANE, approximation, of_faces, subjects_of, with_plane
from testbed_reports.rendering.curve_plots import curvature, draw_curve_plots

ROW = """
[[pictures]]
paper = "xu-huang-bajaj-2001"
place = "figure 1"
file = "one"
title = "One"
view = [0, 90]
size = 64
data = "given"
shows = [{ title = "flat", scheme = "flat", dataset = "octahedron", level = 0 }]
"""
CURVE = """
[[pictures]]
paper = "mann-1992"
place = "figure 2"
file = "two"
title = "Two"
kind = "curves"
data = "lost"
shows = [
    { title = "an arc", curve = "projected", arc = 120.0 },
    { title = "an edge", curve = "hermite", dataset = "octahedron", edge = [2, 0] },
]
"""


@pytest.mark.parametrize("picture", redrawn_table(), ids=lambda picture: f"{picture.paper}-{picture.file}")
def test_every_picture_shows_what_is_registered(picture: Redrawn) -> None:
    if picture.kind == "curves":
        assert all(np.isfinite(curve_plot(shown).control_points).all() for shown in picture.shows)
        return
    for shown in picture.shows:
        dataset, scheme = registry.dataset(shown.dataset), registry.scheme(shown.scheme)
        if shown.epsilon == 0.0:
            mesh = dataset.mesh(shown.level)
            # what takes long is drawn by `testbed reproduce` only
            assert len(mesh.faces) > 300 or scheme.fit(mesh).patch_count
            edges = {tuple(edge) for edge in mesh.edges.tolist()}
            assert all((min(pair), max(pair)) in edges for pair in shown.highlight)
            assert all(0 <= face < len(mesh.faces) for face in shown.faces)


def test_papers_have_their_pictures() -> None:
    for paper in ("mann-1992", "mann-1994", "xu-huang-bajaj-2001", "si-ping-2015"):
        assert {one.paper for one in pictures_of(paper)} == {paper}
    assert pictures_of("all") == redrawn_table()
    with pytest.raises(SpecError, match="did you mean xu-huang-bajaj-2001"):
        pictures_of("xu-huang-bajaj-2002")


def test_pictures_are_drawn_into_a_folder_of_their_paper_the_same_each_time(tmp_path: Path) -> None:
    pictures = parse_redrawn(ROW + CURVE)
    noted: list[str] = []
    paths = draw_again(tmp_path, pictures, 2, note=lambda one: noted.append(one.file))
    assert paths == (
        tmp_path / "figures" / "xu-huang-bajaj-2001" / "one.png",
        tmp_path / "figures" / "mann-1992" / "two.png",
    )
    assert sorted(noted) == ["one", "two"]
    again = draw_again(tmp_path / "again", pictures, 1)
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in again]
    assert draw_again(tmp_path, ()) == ()


def test_a_picture_that_cannot_be_drawn_says_which_and_why(tmp_path: Path) -> None:
    (picture,) = parse_redrawn(ROW.replace('"flat", dataset', '"bicubic-interpolant", dataset'))
    assert "quadrilaterals" in attempt(tmp_path, picture)[1]
    with pytest.raises(TestbedError, match=r"the picture one of xu-huang-bajaj-2001 cannot be drawn: .*quadrilaterals"):
        draw_again(tmp_path, [picture], 1)


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        (ROW.replace("size = 64", 'style = "stripes"'), "style is 'stripes'"),
        (ROW.replace("size = 64", 'kind = "films"'), "kind is 'films': give one of surfaces, curves"),
        (ROW.replace("size = 64", 'edges = "some"'), "edges is 'some'"),
        (ROW.replace("2001", "1999"), "paper is 'xu-huang-bajaj-1999'"),
        (ROW.replace('data = "given"', 'data = "found"'), "data is 'found'"),
        (ROW.replace("view = [0, 90]", "view = [0]"), "picture 1 has other fields"),
        (ROW.replace("file =", "name ="), "picture 1 has other fields"),
        (ROW.replace("level = 0", "levels = 0"), "picture 1 has other fields"),
        (ROW.replace("level = 0", 'style = "stripes"'), "style is 'stripes'"),
        (ROW.replace("level = 0", 'colour = "levels"'), "no levels of refinement"),
        (ROW.replace("level = 0", "plane = [0, 0, 1]"), "plane has 3 numbers: give 4"),
        (ROW.replace("level = 0", "view = [0, 0, 1]"), "view has 3 numbers: give 2"),
        (ROW.replace("level = 0", "highlight = [[1]]"), "pairs of vertices"),
        (ROW.replace('scheme = "flat", ', ""), "is no surface: give scheme and dataset"),
        (CURVE.replace("arc = 120.0", "arc = 0.0"), "'an arc' is no curve"),
        (CURVE.replace("edge = [2, 0]", "edge = [2]"), "'an edge' is no curve"),
        (ROW + ROW, "are called one"),
    ],
)
def test_rows_that_are_no_pictures_are_named(row: str, sentence: str) -> None:
    with pytest.raises(TestbedError, match=sentence):
        parse_redrawn(row)


@pytest.mark.parametrize("plane", [(0.0, 0.0, 2.0, 1.0), (1.0, 2.0, -3.0, 4.0)])
def test_a_plane_is_one_patch_more_that_lies_in_it_and_reaches_beyond_the_mesh(plane: tuple[float, ...]) -> None:
    surface = registry.scheme("flat").fit(registry.dataset("octahedron").mesh(0))
    both = with_plane(surface, plane)
    assert both.patch_count == surface.patch_count + 1
    piece = both.parts[-1].batch
    jet = piece.jets(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]), 1)
    normal = np.array(plane[:3])
    assert np.abs(dot(jet.f[0], normal) + plane[3]).max() < 1e-12
    assert dot(jet.normal[0], normal).min() == pytest.approx(norm(normal))
    # every vertex falls onto it along the normal
    edges = both.edges
    assert edges.boundary.sum() == 4
    foot = surface.mesh.points - ((dot(surface.mesh.points, normal) + plane[3]) / dot(normal, normal))[:, None] * normal
    u, v = jet.f[0, 1] - jet.f[0, 0], jet.f[0, 2] - jet.f[0, 0]
    at = np.stack([dot(foot - jet.f[0, 0], u) / dot(u, u), dot(foot - jet.f[0, 0], v) / dot(v, v)])
    assert at.min() > 0.0
    assert at.max() < 1.0


def test_faces_can_be_shown_by_themselves() -> None:
    surface = registry.scheme("shirman-sequin").fit(registry.dataset("octahedron").mesh(0))
    assert of_faces(surface, (3, 5)).patch_count == 6
    with pytest.raises(TestbedError, match="no patches on faces 8"):
        of_faces(surface, (8,))


def test_approximations_have_as_many_refinements_as_are_asked_for() -> None:
    assert [len(approximation("ellipsoid", 0.4, step).mesh.faces) for step in (0, 1)] == [8, 32]
    assert approximation("ellipsoid", 0.4).reached
    with pytest.raises(TestbedError, match=r"reaches 0\.4 degrees after 2 refinements"):
        approximation("ellipsoid", 0.4, 3)


def test_what_a_row_says_is_what_is_shown() -> None:
    shows = """
    { title = "a", scheme = "flat", dataset = "ellipsoid", epsilon = 0.4, step = 1, colour = "levels", edges = "none" },
    { title = "b", scheme = "flat", dataset = "octahedron", plane = [0, 0, 1, 2], view = [0, 10], style = "jump" },
    { title = "d", scheme = "shirman-sequin", dataset = "octahedron", faces = [3, 4] },
    { title = "c", scheme = "flat", dataset = "octahedron", highlight = [[0, 2]], remark = "so it is" },
    """
    (picture,) = parse_redrawn(ROW.replace("shows = [", f"shows = [{shows}"))
    a, b, d, c, plain = subjects_of(picture)
    assert a.colours is not None
    assert len(np.unique(a.colours[0], axis=0)) == 1
    assert a.edges is False
    assert b.colours is not None
    np.testing.assert_array_equal(b.colours[1], PLANE[None])
    assert (b.remark, d.remark) == ("8 faces", "6 patches on 2 of 8 faces")
    assert (b.view, b.style) == ((0.0, 10.0), "jump")
    assert (c.highlight, c.remark) == (((0, 2),), "so it is")
    assert (plain.colours, plain.view, plain.edges, plain.remark) == (None, None, None, None)


@pytest.mark.parametrize("degrees", [30.0, 120.0])
def test_arcs_have_the_circles_data(degrees: float) -> None:
    edge = arc(degrees)
    assert norm(edge.p1 - edge.p0)[0] == pytest.approx(2.0 * np.sin(np.radians(degrees / 2.0)))
    (picture,) = parse_redrawn(CURVE.replace("120.0", str(degrees)).replace("projected", "hermite"))
    for shown in picture.shows:
        plot = curve_plot(shown)
        assert plot.given == pytest.approx((1.0, 1.0))
        along, signed = curvature(plot)
        assert (along[0], along[-1]) == (0.0, 1.0)
        assert (np.diff(along) > 0.0).all()
        # geometric Hermite curves match the data at both ends
        np.testing.assert_allclose(signed[[0, -1]], 1.0, rtol=1e-9)


def test_an_edge_that_is_none_is_named() -> None:
    (picture,) = parse_redrawn(CURVE.replace("[2, 0]", "[0, 3]"))
    with pytest.raises(TestbedError, match="octahedron has no edge"):
        curve_plot(picture.shows[1])


def test_plots_of_curves_have_one_scale() -> None:
    (picture,) = parse_redrawn(CURVE)
    figure = draw_curve_plots([curve_plot(one) for one in picture.shows], 2, "A title")
    curves, plots = figure.axes[::2], figure.axes[1::2]
    assert len({axes.get_ylim() for axes in plots}) == 1
    for axes in curves:
        net, dots = axes.get_lines()[1], axes.get_lines()[3]
        assert len(np.asarray(net.get_xdata())) == 4
        assert len(np.asarray(dots.get_xdata())) == 11
    assert "A title" in figure.texts[0].get_text()
