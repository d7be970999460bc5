"""The pictures of an approximation show its levels and its bounds, and are the same for the same approximation."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.legend import Legend

from testbed import registry
from testbed.approximation.approximate import Limits, Target, approximate
from testbed.approximation.history import Approximation
from testbed_reports.refinement_plot import (
    LEVELS,
    draw_history,
    draw_refinement,
    drawn_surface,
    level_colours,
    level_map,
    write_history_plot,
    write_refinement_plot,
)


@cache
def found(dataset: str, scheme: str = "cubic-interpolant", steps: int = 9) -> Approximation:
    target = Target(math.radians(0.2), 1e-3)
    return approximate(registry.dataset(dataset), registry.scheme(scheme), target, limits=Limits(steps=steps))


def legend_of(figure: Figure) -> Legend:
    (legend,) = figure.legends
    return legend


def test_the_legend_counts_the_faces_of_each_level_in_the_level_s_colour() -> None:
    one = found("ellipsoid")
    legend = legend_of(draw_refinement(one, "a title"))
    counts = np.bincount(one.levels.faces)
    present = np.flatnonzero(counts)
    assert legend.get_title().get_text() == "level: faces"
    assert [text.get_text() for text in legend.get_texts()] == [f"{level}: {counts[level]}" for level in present]
    shown = [to_rgb(patch.get_facecolor()) for patch in legend.get_patches()]
    assert np.abs(np.array(shown) - level_colours()[present]).max() < 1e-12


def test_colours_of_levels_are_told_apart_by_their_lightness() -> None:
    lightness = level_colours() @ np.array([0.2126, 0.7152, 0.0722])
    assert len(lightness) == LEVELS
    assert np.diff(lightness).min() > 0.05


def test_patches_have_the_colours_of_their_faces_levels() -> None:
    one = found("graph", "shirman-sequin", 3)
    surface = drawn_surface(one)
    (colours,) = level_map(one, surface)
    assert len(np.unique(one.levels.faces)) > 1
    np.testing.assert_array_equal(colours, np.repeat(level_colours()[one.levels.faces], 3, axis=0))


def test_closed_surfaces_are_shown_from_both_sides_and_open_ones_from_one() -> None:
    assert len(draw_refinement(found("ellipsoid"), "closed").axes) == 2
    assert len(draw_refinement(found("graph"), "open").axes) == 1


@pytest.mark.parametrize("scheme", ["shirman-sequin", "nielson", "peters-cubic"])
def test_split_faces_blends_and_refused_meshes_are_drawn(scheme: str, tmp_path: Path) -> None:
    one = found("ellipsoid", scheme, 1)
    assert (one.surface is None) == (scheme == "peters-cubic")
    assert write_refinement_plot(tmp_path, one, scheme).read_bytes().startswith(b"\x89PNG")


def test_the_history_has_both_quantities_and_the_bounds_asked_for() -> None:
    one = found("ellipsoid")
    left, right = draw_history(one, "a title", 0.2, 1e-3).axes
    faces = [step.faces for step in one.history]
    for axes, values, bound in (
        (left, [step.epsilon_deg for step in one.history], 0.2),
        (right, [step.distance for step in one.history], 1e-3),
    ):
        line = axes.get_lines()[0]
        assert list(line.get_xdata()) == faces  # type: ignore[arg-type]  # they are lists
        assert list(line.get_ydata()) == values  # type: ignore[arg-type]
        assert set(axes.get_lines()[-1].get_ydata()) == {bound}  # type: ignore[arg-type]
        assert axes.get_yscale() == "log"
    legend = right.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [
        "guaranteed bound",
        "largest found",
        "asked for",
    ]


def test_pictures_of_the_same_approximation_have_the_same_bytes(tmp_path: Path) -> None:
    one = found("ellipsoid")
    first = [
        path.read_bytes()
        for path in (
            write_refinement_plot(tmp_path, one, "x"),
            write_history_plot(tmp_path, one, "x", 0.2, None),
        )
    ]
    second = [
        path.read_bytes()
        for path in (
            write_refinement_plot(tmp_path, one, "x"),
            write_history_plot(tmp_path, one, "x", 0.2, None),
        )
    ]
    assert first == second
