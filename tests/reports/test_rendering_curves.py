"""Combs, inflections and dots of boundary curves."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed import registry
from testbed.geometry.vectors import Float, dot, norm
from testbed_reports.rendering.combs import DOTS, TEETH, combs, combs_of
from testbed_reports.rendering.curve_figure import (
    COMB,
    TOOTH,
    CurveSubject,
    draw_curves,
    full_tooth,
    see_curves,
    write_curve_figure,
)

UP = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]])


def plane(*points: tuple[float, float]) -> Float:
    """A curve in the plane of x and z."""
    return np.array([[(x, 0.0, z) for x, z in points]])


def test_a_parabola_has_its_curvature_and_no_inflection() -> None:
    # z = x (2 - x): at the top the curvature is 2
    found = combs_of(plane((0.0, 0.0), (1.0, 2.0), (2.0, 0.0)), UP)
    assert found.points.shape == (1, TEETH, 3)
    x = found.points[0, :, 0]
    np.testing.assert_allclose(found.points[0, :, 2], x * (2.0 - x), atol=1e-14)
    np.testing.assert_allclose(found.curvature[0], 2.0 / (1.0 + (2.0 - 2.0 * x) ** 2) ** 1.5, rtol=1e-12)
    assert not len(found.inflections)
    # seen from the other side it bends towards the normal
    np.testing.assert_array_equal(combs_of(plane((0.0, 0.0), (1.0, 2.0), (2.0, 0.0)), -UP).curvature, -found.curvature)


@given(st.floats(0.2, 0.8), st.floats(-2.0, 2.0).filter(lambda slope: abs(slope) > 0.1))
def test_the_inflection_of_a_cubic_is_where_it_is(place: float, slope: float) -> None:
    # z = (x - place)^3 as a Bezier curve over [0, 1], turned by a shear
    value = [(0.0 - place) ** 3, 0.0, 0.0, (1.0 - place) ** 3]
    value[1] = value[0] + 3.0 * place**2 / 3.0
    value[2] = value[3] - 3.0 * (1.0 - place) ** 2 / 3.0
    curve = plane(*((i / 3.0, v + slope * i / 3.0) for i, v in enumerate(value)))
    found = combs_of(curve, UP)
    assert found.inflected.tolist() == [0]
    # between two teeth, to the second order
    assert found.inflections[0, 0] == pytest.approx(place, abs=2e-3)
    assert found.inflected_at[0] == pytest.approx(place, abs=2e-3)


def test_straight_curves_have_no_comb_and_no_inflection() -> None:
    found = combs_of(plane((0.0, 0.0), (1.0, 0.3), (2.0, 0.6), (3.0, 0.9)), UP)
    assert np.abs(found.curvature).max() < 1e-14
    assert not len(found.inflections)


def test_teeth_are_upright_on_the_curve_and_dots_on_it() -> None:
    network = registry.boundary_curve("projected").network(registry.dataset("torus").mesh(0))
    found = combs(network)
    along = np.gradient(found.points, axis=1)
    # differences of neighbours are tangents but for the third order
    lean = dot(along, found.vectors) / (norm(along) * norm(found.vectors))
    assert np.nanmax(np.abs(lean[:, 1:-1])) < 0.02
    np.testing.assert_array_equal(found.dots[:, [0, -1]], network.control_points[:, [0, -1]])
    assert found.dots.shape[1] == DOTS
    assert (TEETH - 1) % (DOTS - 1) == 0


def test_curves_of_a_sphere_are_positive_and_uniform_where_they_match_its_curvature() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    hermite, projected = (combs(registry.boundary_curve(name).network(mesh)) for name in ("hermite", "projected"))
    np.testing.assert_allclose(hermite.curvature[:, [0, -1]], 1.0, rtol=1e-12)
    assert np.ptp(hermite.curvature) < 0.1 * np.ptp(projected.curvature)
    assert projected.curvature.min() > 0.0


def test_a_curve_that_stands_still_has_no_curvature_there() -> None:
    found = combs_of(plane((0.0, 0.0), (0.0, 0.0), (1.0, 1.0), (2.0, 0.0)), UP)
    assert np.isnan(found.curvature[0, 0])
    assert np.isfinite(found.curvature[0, 1:]).all()


def test_curves_behind_their_mesh_are_hidden() -> None:
    network = registry.boundary_curve("hermite").network(registry.dataset("octahedron").mesh(0))
    (one,) = see_curves([CurveSubject("hermite", network)], 240, (30.0, 35.0))
    middle = one.seen[:, TEETH // 2]
    # nine edges are in front, and curves near the outline, that bulge out behind it
    assert 9 <= middle.sum() <= 10
    depth = one.camera.screen(one.combs.points[:, TEETH // 2], 240)[:, 2]
    assert depth[middle].min() > depth[~middle].max()


def test_pictures_have_one_scale_and_say_it() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    subjects = [CurveSubject(n, registry.boundary_curve(n).network(mesh)) for n in ("hermite", "projected")]
    looks = see_curves(subjects, 240)
    full = full_tooth(looks)
    assert full == 1.5 or full == 2.0
    figure = draw_curves(looks, full, 240, 4, "")
    assert f"is {full:g} per length" in figure.texts[0].get_text()
    for axes in figure.axes:
        (bar,) = [line for line in axes.get_lines() if line.get_color() == COMB]
        assert np.ptp(np.asarray(bar.get_ydata(), dtype=np.float64)) == pytest.approx(TOOTH * 240)
    assert len({one.camera.width for one in looks}) == 1


def test_pictures_of_curves_have_the_same_bytes_again(tmp_path: Path) -> None:
    mesh = registry.dataset("quad-torus").mesh(0)
    subject = CurveSubject("<hermite>", registry.boundary_curve("hermite").network(mesh))
    first, second = (write_curve_figure(tmp_path / f"{i}.png", [subject], size=96).read_bytes() for i in (1, 2))
    assert first == second
    assert first.startswith(b"\x89PNG")
