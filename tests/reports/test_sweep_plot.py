"""The plot of a sweep shows what was found, says what was refused, and is the same for the same values."""

import math
import re
from pathlib import Path

import matplotlib as mpl
import pandas as pd
import pytest
from matplotlib.figure import Figure

from testbed.harness.objectives import objective
from testbed.harness.parameters import Axis
from testbed.harness.plan import Plan, PlannedDataset
from testbed.harness.sweep import Sweep
from testbed_reports.sweep_plot import draw_sweep, write_sweep_plot

C = Axis("jensen_c", ("1.0", "1.1", "1.2", "1.3"), (1.0, 1.1, 1.2, 1.3))
ALPHA = Axis("alpha2", ("1.5", "2.0", "3.0"), (1.5, 2.0, 3.0))
CURVE = Axis("boundary", ("projected", "hermite"), None)
GIVEN = 4.0


def swept(axes: tuple[Axis, ...], numbers: list[float], *, maximise: bool = False) -> tuple[Sweep, pd.DataFrame]:
    """Tell a sweep on two datasets; NaN is a refusal."""
    datasets = tuple(
        PlannedDataset(name, "a title", "none", closed=True, shape="spheres", source="12") for name in ("ball", "egg")
    )
    settings = tuple(f"scheme[setting={number}]" for number in range(len(numbers)))
    plan = Plan((), (), datasets, ())
    sweep = Sweep("scheme", axes, settings, (objective("gauss_max"),), maximise, 0, {"ball": {}, "egg": {}}, plan)
    rows = [
        {
            "setting": number if number < len(numbers) else -1,
            "dataset": dataset.spec,
            "status": "refused" if math.isnan(value) else "ok",
            "gauss_max": value,
        }
        for dataset in datasets
        for number, value in enumerate([*numbers, GIVEN])
    ]
    return sweep, pd.DataFrame(rows)


def texts(figure: Figure) -> list[str]:
    legends = [axes.get_legend() for axes in figure.axes]
    return [text.get_text() for legend in legends if legend for text in legend.get_texts()]


def test_one_parameter_is_a_line_with_its_refusals_the_scheme_as_given_and_the_best() -> None:
    figure = draw_sweep(*swept((C,), [3.0, 1.25, math.nan, 2.0]))
    assert [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes] == ["ball, level 0", "egg, level 0"]
    axes = figure.axes[0]
    assert axes.get_xlabel() == "jensen_c"
    assert axes.get_ylabel().startswith("gauss_max")
    line, refused, given, best = axes.get_lines()
    assert list(line.get_xdata()) == [1.0, 1.1, 1.2, 1.3]  # type: ignore[arg-type]  # they are lists
    assert (list(refused.get_xdata()), refused.get_label()) == ([1.2], "refused")  # type: ignore[arg-type]
    assert set(given.get_ydata()) == {GIVEN}  # type: ignore[arg-type]
    assert (list(best.get_xdata()), list(best.get_ydata())) == ([1.1], [1.25])  # type: ignore[arg-type]
    assert "best: 1.25" in texts(figure)


def test_words_are_lines_of_their_own_and_alone_they_are_named_on_the_axis() -> None:
    figure = draw_sweep(*swept((CURVE, C), [3.0, 1.25, 1.5, 2.0, 3.5, 1.0, 1.5, 2.0]))
    assert texts(figure)[:2] == ["projected", "hermite"]
    assert list(figure.axes[0].get_lines()[1].get_ydata()) == [3.5, 1.0, 1.5, 2.0]  # type: ignore[arg-type]
    alone = draw_sweep(*swept((CURVE,), [3.0, 1.25]))
    assert [label.get_text() for label in alone.axes[0].get_xticklabels()] == ["projected", "hermite"]


MAP = [3.0, 2.0, 9.0, 2.5, 1.0, 8.0, math.nan, 1.5, 7.0, 4.0, 3.0, 6.0]


def test_two_numbers_are_a_map_with_a_labelled_bar_and_the_best_marked() -> None:
    figure = draw_sweep(*swept((C, ALPHA), MAP))
    axes, bar = figure.axes[0], figure.axes[2]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("jensen_c", "alpha2")
    assert bar.get_ylabel().startswith("gauss_max")
    (best,) = axes.get_lines()
    assert (list(best.get_xdata()), list(best.get_ydata())) == ([1.1], [2.0])  # type: ignore[arg-type]
    mesh = axes.collections[0]
    shown = mesh.get_array()
    assert shown is not None
    # rows go along the second parameter; the refusal is left open, and the hatched ground shows
    assert shown[1].tolist() == [2.0, 1.0, 1.5, 3.0]
    assert shown[0].tolist() == [3.0, 2.5, None, 4.0]
    assert axes.patch.get_hatch()


def test_large_values_are_the_best_where_they_are_sought() -> None:
    (best,) = draw_sweep(*swept((C, ALPHA), MAP, maximise=True)).axes[0].get_lines()
    assert (list(best.get_xdata()), list(best.get_ydata())) == ([1.0], [3.0])  # type: ignore[arg-type]


@pytest.mark.parametrize("axes", [(C,), (C, ALPHA), (CURVE, CURVE)])
@pytest.mark.parametrize("value", [math.nan, 2.0])
def test_values_that_are_all_equal_or_absent_are_drawn(axes: tuple[Axis, ...], value: float) -> None:
    figure = draw_sweep(*swept(axes, [value] * math.prod(len(axis.texts) for axis in axes)))
    figure.draw_without_rendering()
    shown = "no setting has a value" in [text.get_text() for text in figure.axes[0].texts]
    assert shown is (math.isnan(value) and len(axes) == 2)


@pytest.mark.parametrize("numbers", [MAP, [-(10.0**power) for power in range(12)]])
def test_the_same_bytes_whatever_the_users_settings(numbers: list[float], tmp_path: Path) -> None:
    first = [path.read_bytes() for path in write_sweep_plot(tmp_path, *swept((C, ALPHA), numbers))]
    with mpl.rc_context({"font.size": 20.0, "svg.hashsalt": None, "savefig.dpi": 10}):
        assert [path.read_bytes() for path in write_sweep_plot(tmp_path, *swept((C, ALPHA), numbers))] == first
    svg = first[0].decode()
    assert "best:" in svg
    assert not re.search(r"\d{4}-\d\d-\d\dT", svg)
    assert b"Software" not in first[1]
