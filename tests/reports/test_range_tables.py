"""The comparison above planes: its file, its rows, what they say, creases, pictures and the page."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from range_examples import CLOSED, GOOD, ROWS, SCHEMES, SHARP, WILD, WITH_TRUTH, WITHOUT

from testbed import registry
from testbed.errors import TestbedError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed_reports.range_comparison import comparison, parse_comparison
from testbed_reports.range_creases import largest_crease
from testbed_reports.range_page import render
from testbed_reports.range_pictures import draw_set
from testbed_reports.range_sections import PlaneView, section
from testbed_reports.range_summary import sentences, summaries
from testbed_reports.range_tables import MeasuredSet, measure_set, moved, rows_as_csv
from testbed_schemes.mathematics.clipped_triangles import ClippedTriangles


def test_the_file_compares_on_twenty_sets_and_every_name_in_it_is_registered() -> None:
    asked = comparison()
    assert len(asked.sets) >= 20
    assert len({str(one) for one in asked.sets}) == len(asked.sets)
    kinds = [registry.dataset(one.dataset_text) for one in asked.sets]
    assert sum(kind.closed is False for kind in kinds) >= 16
    assert sum(not kind.mesh(0).boundary_edges.any() for kind in kinds) >= 4
    for one in asked.schemes:
        assert registry.scheme(one.scheme.replace("{plane}", asked.sets[0].plane_text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[[schemes]]\nlabel = "a"\nscheme = "flat"\ncolour = "red"', "scheme 1 has other fields"),
        ('[[schemes]]\nlabel = "a"\nscheme = "flat"\nuses = "forms"', "uses is 'forms'"),
        ('[[schemes]]\nlabel = "a"\nscheme = "flat"\nagainst = "b"', "against 'b': put that scheme before"),
        (2 * '[[schemes]]\nlabel = "a"\nscheme = "flat"\n', "scheme 2 is called 'a', as another"),
        ("[[sets]]\nlevel = 1", "set 1 has other fields"),
        ('[[sets]]\ndataset = "a"\nplane = [0, 0, 0, 1]', "no plane: give a, b, c, d"),
    ],
)
def test_a_row_of_the_file_that_is_none_is_named(text: str, words: str) -> None:
    with pytest.raises(TestbedError, match=words):
        parse_comparison(text)


def test_a_set_is_measured_scheme_by_scheme() -> None:
    rows = {row.label: row for row in measure_set(WITH_TRUTH, SCHEMES).rows}
    assert [*rows] == [one.label for one in SCHEMES]
    plain, clipped, flat = rows["plain"], rows["clipped"], rows["flat"]
    assert plain.lowest < 0.0
    assert plain.lowest_bound <= plain.lowest
    assert not plain.above
    assert plain.smooth
    assert clipped.lowest == 0.0
    assert clipped.guaranteed
    assert clipped.epsilon_deg < 1e-6 < 1.0 < clipped.crease_deg
    assert not clipped.smooth
    # what was cut off is how far it moved, in sizes of the data
    mesh = registry.dataset(WITH_TRUTH.dataset).mesh(0)
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    assert clipped.moved == pytest.approx(-plain.lowest / size, rel=0.05)
    assert flat.lowest == mesh.points[:, 2].min()
    assert flat.epsilon_deg > 1.0
    assert flat.crease_deg == 0.0
    assert math.isnan(flat.moved)
    for row in rows.values():
        assert row.data_max < 1e-15
        assert 0.0 < row.rms < row.distance_max
        assert row.seconds > 0.0


def test_schemes_that_use_normals_are_left_out_without_them_and_refusals_are_rows() -> None:
    rows = measure_set(WITHOUT, SCHEMES).rows
    assert [row.label for row in rows] == ["plain", "clipped", "flat"]
    assert all(math.isnan(row.rms) for row in rows)
    closed = {row.label: row for row in measure_set(CLOSED, SCHEMES).rows}
    assert closed["plain"].status == "refused"
    assert "heights over the (x, y) plane" in closed["plain"].reason
    assert closed["flat"].status == "ok"
    assert closed["flat"].lowest > 0.0
    assert closed["flat"].plane == "(0.3 -0.2 1.0 0.1)"


def test_a_set_that_is_none_fails_with_its_reason() -> None:
    rows = measure_set(replace(CLOSED, dataset="joined-faces", level=3), SCHEMES).rows
    assert {row.status for row in rows} == {"failed"}
    assert "joined-faces has no level 3" in rows[0].reason


def test_rows_are_written_with_every_digit_and_nothing_for_no_number() -> None:
    read = list(csv.DictReader(io.StringIO(rows_as_csv([GOOD, replace(GOOD, lowest=1 / 3, rms=math.nan)]))))
    assert float(read[1]["lowest"]) == 1 / 3
    assert read[1]["rms"] == ""
    assert read[0]["label"] == "good"


def tent(angle: float) -> Surface:
    """Return a triangle that is level for x < 1/3 and rises beyond by an angle: creased inside."""
    slope = math.tan(angle)
    points = np.array([[0, 0, -slope / 3], [1, 0, slope * 2 / 3], [0, 1, -slope / 3]])
    return Surface.over_faces(HermiteMesh(points, [[0, 1, 2]]), ClippedTriangles(BezierTriangles(points[None])))


@pytest.mark.parametrize("degrees", [0.01, 1.0, 60.0])
def test_a_crease_is_found_with_its_angle(degrees: float) -> None:
    assert largest_crease(tent(math.radians(degrees))) == pytest.approx(degrees, rel=1e-6)


def test_smooth_patches_have_no_crease_however_curved() -> None:
    mesh = registry.dataset("scattered[field=noise,normals=none]").mesh(0)
    assert largest_crease(registry.scheme("clough-tocher").fit(mesh)) == 0.0
    ball = registry.dataset("octahedron").mesh(0)
    assert largest_crease(registry.scheme("nielson").fit(ball)) == 0.0


def test_a_patch_without_a_normal_is_no_smooth_one() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64)
    surface = Surface.over_faces(HermiteMesh(points, [[0, 1, 2]]), BezierTriangles(points[None, [0, 0, 0]]))
    assert math.isnan(largest_crease(surface))


def test_how_far_a_surface_moved_is_relative_to_the_size() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    surface = registry.scheme("flat").fit(mesh)
    (batch,) = surface.batches
    assert isinstance(batch, BezierTriangles)
    up = Surface.over_faces(mesh, BezierTriangles(batch.control_points + np.array([0.0, 0.0, 0.2])))
    assert moved(surface, surface) == 0.0
    assert moved(up, surface) == pytest.approx(0.2 / math.sqrt(12.0))


def test_the_summary_counts_and_tells() -> None:
    good, wild, sharp = summaries(ROWS)
    assert (good.sets, good.built, good.above, good.guaranteed, good.smooth) == (2, 2, 2, 2, 2)
    assert (wild.above, wild.lowest, wild.factor, wild.nearest, wild.known) == (0, -0.5, 1.0, 1, 1)
    assert (sharp.refused, sharp.built, sharp.above, sharp.guaranteed, sharp.smooth) == (1, 1, 1, 0, 0)
    assert good.factor == pytest.approx(2.0)
    assert good.moved == pytest.approx(0.04)
    assert good.most_moved == 0.05
    assert good.branches == (("edges with shortened tangents", 4), ("faces kept", 6))
    text = " ".join(sentences(ROWS))
    for part in (
        "good stays above on 2 of 2 sets, which is proved",
        "wild crosses the plane on 2 of 2 sets, down to -0.500",
        "sharp was found below on none of 1, not proved",
        "Who stays smooth: good and wild on all sets",
        "sharp jumps by up to 30.0° inside patches",
        "over the 1 set where it is known and all have a surface): wild 1.00 (nearest on 1), good 2.00 (nearest on 0)",
        "good by 4.00 % of the size (at most 5.00 % of the size)",
    ):
        assert part in text


def test_who_is_nearer_is_told_from_sets_where_all_have_a_surface() -> None:
    further = (
        replace(GOOD, dataset="third", rms=0.001),
        replace(WILD, dataset="third", rms=0.01),
        replace(SHARP, dataset="third", status="refused", rms=math.nan),
    )
    good, wild, sharp = summaries(ROWS + further)
    assert (good.known, wild.known, sharp.known) == (1, 1, 1)
    assert [good.factor, wild.factor, sharp.factor] == pytest.approx([2.0, 1.0, 4.0])


def test_nan_is_never_above_nor_smooth() -> None:
    assert not replace(GOOD, lowest=math.nan).above
    assert not replace(GOOD, lowest_bound=math.nan).guaranteed
    assert not replace(GOOD, crease_deg=math.nan).smooth
    assert not replace(GOOD, epsilon_deg=math.nan).smooth
    (one,) = summaries([replace(GOOD, lowest=math.nan), GOOD])
    assert math.isnan(one.lowest)
    assert one.above == 1


def test_pictures_show_what_lies_below_in_its_own_colour_and_are_the_same_bytes_again() -> None:
    surface = registry.scheme("clough-tocher").fit(registry.dataset(WITH_TRUTH.dataset).mesh(0))
    views = [PlaneView("a", "", surface)]
    below = draw_set(views, (0.0, 0.0, 1.0, -0.2), "a title")
    assert below.startswith(b"\x89PNG")
    assert below == draw_set(views, (0.0, 0.0, 2.0, -0.4), "a title")
    assert orange(below) > orange(draw_set(views, (0.0, 0.0, 1.0, 1.0), "a title")) + 1000


def orange(content: bytes) -> int:
    """Pixels of the colour of what lies below the plane, a little shaded or not."""
    from matplotlib.image import imread

    red, green, blue = np.moveaxis(np.asarray(imread(io.BytesIO(content)))[..., :3], -1, 0)
    return int(np.count_nonzero((red > 0.5) & (np.abs(0.835 * green - 0.369 * red) < 0.03) & (blue < 0.05)))


def test_sections_are_where_triangles_meet_the_plane() -> None:
    triangles = np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 4]], [[5, 5, 0], [6, 5, 0], [5, 6, 0]]], dtype=np.float64)
    ends = section(triangles, np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
    assert sorted(ends[0].tolist()) == [[1.0, 0.0, 0.0], [1.0, 1.0, 2.0]]
    assert len(ends) == 1


def test_the_page_holds_everything_and_escapes_what_it_is_given() -> None:
    page = render([MeasuredSet(ROWS[:3], b"\x89PNG"), MeasuredSet(ROWS[3:])])
    for part in (
        "data:image/png;base64,iVBORw==",
        "sharp &lt;takes&gt; no such data",
        "4 edges with shortened tangents",
    ):
        assert part in page
    assert "good[plane=PLANE]" in page
    assert page.count("<figure>") == 1
    assert "<takes>" not in page
    assert "http" not in page.replace("http-equiv", "")
