"""The plot of a sweep: lines over one parameter, a map over two; a panel for each quantity and dataset."""

import io
import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from testbed.harness.objectives import Objective
from testbed.harness.parameters import Axis
from testbed.harness.sweep import Sweep, best_number, values
from testbed_reports.plots import SETTINGS, SIZE
from testbed_reports.styles import style

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Positive values are drawn on a logarithmic scale if the largest is this many times the smallest.
WIDE: Final = 20.0
#: On such a scale colours differ up to this many times the best value.
DEEP: Final = 200.0
#: Dots an inch of the PNG.
RESOLUTION: Final = 160
#: Contours of a map, about.
CONTOURS: Final = 7
#: From dark to light, evenly to the eye with and without colour vision.
COLOURS: Final = "viridis"


def write_sweep_plot(directory: Path, sweep: Sweep, table: "pd.DataFrame") -> tuple[Path, ...]:
    """Write ``sweep.svg`` and ``sweep.png``, the same bytes for the same values, and return their paths."""
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    paths = (directory / "sweep.svg", directory / "sweep.png")
    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        figure = draw_sweep(sweep, table)
        FigureCanvasAgg(figure)
        for path in paths:
            nothing: dict[str, Any] = {"Date": None, "Creator": None} if path.suffix == ".svg" else {"Software": None}
            stream = io.BytesIO()
            figure.savefig(stream, format=path.suffix[1:], dpi=RESOLUTION, metadata=nothing)
            path.write_bytes(stream.getvalue())
    return paths


def draw_sweep(sweep: Sweep, table: "pd.DataFrame") -> "Figure":
    """Return the figure: a row of panels for each quantity on one scale, a column for each dataset."""
    from matplotlib.figure import Figure

    across, line_of = _roles(sweep.axes)
    mapped = line_of is None and len(sweep.axes) == 2
    rows, columns = len(sweep.objectives), len(sweep.datasets)
    width, height = (1.35 * SIZE[0], 1.25 * SIZE[1]) if mapped else (1.25 * SIZE[0], 1.1 * SIZE[1])
    figure = Figure(figsize=(width * columns, height * rows + 0.35), layout="constrained")
    figure.suptitle(sweep.scheme, x=0.01, ha="left", fontsize=9.5)
    panels = figure.subplots(rows, columns, squeeze=False, sharey="row")
    for one, row in zip(sweep.objectives, panels, strict=True):
        numbers = [values(sweep, table, one, dataset) for dataset in sweep.datasets]
        # what is compared has one scale
        everywhere = [value for found, given in numbers for value in (*found, given)]
        for dataset, axes, (found, given) in zip(sweep.datasets, row, numbers, strict=True):
            axes.set_title(f"{dataset}, level {sweep.level}")
            axes.yaxis.set_tick_params(labelleft=True)
            statuses = table.loc[(table["dataset"] == dataset) & (table["setting"] >= 0), "status"].tolist()
            if mapped:
                _map(axes, sweep, one, found, everywhere)
            else:
                _lines(axes, sweep, one, (across, line_of), found, given, statuses)
                if _logarithmic(everywhere):
                    axes.set_yscale("log")
    return figure


def _roles(axes: Sequence[Axis]) -> tuple[int, int | None]:
    """Return which parameter goes across, and which one has a line for each value, if it is one of words."""
    if len(axes) == 1:
        return 0, None
    numeric = [axis.numbers is not None for axis in axes]
    return (numeric.index(True), numeric.index(False)) if sum(numeric) == 1 else (0, None)


def _label(one: Objective) -> str:
    # a meaning that is a formula says more than the name alone
    return f"{one.name}: {one.meaning}" if len(one.meaning) < 40 else one.name


def _lines(
    axes: "Axes",
    sweep: Sweep,
    one: Objective,
    roles: tuple[int, int | None],
    found: Sequence[float],
    given: float,
    statuses: Sequence[str],
) -> None:
    across, line_of = roles
    axis = sweep.axes[across]
    axes.set_xlabel(axis.name)
    axes.set_ylabel(_label(one))
    axes.grid(visible=True, color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    place = _places(axes.xaxis, axis)
    series = sweep.axes[line_of].texts if line_of is not None else ("",)
    for position, text in enumerate(series):
        chosen = [
            number for number, texts in enumerate(sweep.combinations) if line_of is None or texts[line_of] == text
        ]
        look = style(position)
        x = [place[axis.texts.index(sweep.combinations[number][across])] for number in chosen]
        shown = [found[number] for number in chosen]
        connected = "solid" if axis.numbers else "none"
        size = 3.5 if len(x) > 15 else 5.0
        axes.plot(
            x, shown, color=look.colour, linestyle=connected, marker=look.marker, markersize=size, label=text or None
        )
        for status, marker in (("refused", "x"), ("failed", "1"), ("timeout", "2")):
            there = [at for at, number in zip(x, chosen, strict=True) if statuses[number] == status]
            if there:
                axes.plot(
                    there,
                    [0.03 + 0.04 * position] * len(there),
                    color=look.colour,
                    linestyle="none",
                    marker=marker,
                    transform=axes.get_xaxis_transform(),
                    clip_on=False,
                    label=f"{text} {status}".strip(),
                )
    if math.isfinite(given):
        axes.axhline(given, color="#8a8a8a", linewidth=0.9, linestyle=(0, (1.0, 2.0)), zorder=1.5, label="as given")
    number = best_number(found, maximise=sweep.maximise)
    if number is not None:
        at = place[axis.texts.index(sweep.combinations[number][across])]
        axes.plot([at], [found[number]], **_star(f"best: {found[number]:.4g}"))
    axes.legend(fontsize=7.5, frameon=False)


def _map(axes: "Axes", sweep: Sweep, one: Objective, found: Sequence[float], everywhere: Sequence[float]) -> None:
    import numpy as np
    from matplotlib.colors import LogNorm, Normalize

    first, second = sweep.axes
    axes.set_xlabel(first.name)
    axes.set_ylabel(second.name)
    x, y = _places(axes.xaxis, first), _places(axes.yaxis, second)
    grid = np.ma.masked_invalid(np.array(found).reshape(len(x), len(y)).T)
    # what has no value: refused, failed, or not defined there
    axes.patch.set(hatch="////", facecolor="#f4f4f4", edgecolor="#b0b0b0")
    number = best_number(found, maximise=sweep.maximise)
    if number is None:
        axes.set_xlim(_edges(x)[0], _edges(x)[-1])
        axes.set_ylim(_edges(y)[0], _edges(y)[-1])
        axes.text(0.5, 0.5, "no setting has a value", transform=axes.transAxes, ha="center")
        return
    logarithmic = _logarithmic(everywhere)
    known = [value for value in everywhere if math.isfinite(value)]
    least, most = _limits(known, logarithmic, maximise=sweep.maximise)
    norm = LogNorm(least, most) if logarithmic else Normalize(least, most)
    # light is good
    colours = COLOURS if sweep.maximise else f"{COLOURS}_r"
    mesh = axes.pcolormesh(_edges(x), _edges(y), grid, norm=norm, cmap=colours, linewidth=0, rasterized=True)
    bar = axes.figure.colorbar(mesh, ax=axes, label=_label(one), extend=_beyond(grid, least, most))
    if first.numbers and second.numbers and min(grid.shape) > 1 and most > least:
        levels = np.geomspace(least, most, CONTOURS + 2) if logarithmic else np.linspace(least, most, CONTOURS + 2)
        inner = levels[1:-1]
        light = [(float(norm(level)) > 0.5) is sweep.maximise for level in inner]
        ink = ["black" if bright else "white" for bright in light]
        contours = axes.contour(x, y, grid, levels=inner, colors=ink, linewidths=0.6)
        axes.clabel(contours, fmt=lambda level: f"{level:.2g}", fontsize=6.5)
        bar.add_lines(contours)
    at = sweep.combinations[number]
    axes.plot(
        [x[first.texts.index(at[0])]],
        [y[second.texts.index(at[1])]],
        **_star(f"best: {found[number]:.4g}"),
        clip_on=False,
    )
    axes.legend(fontsize=7.5, loc="upper right", framealpha=0.85)


def _limits(numbers: Sequence[float], logarithmic: bool, *, maximise: bool) -> tuple[float, float]:
    """Return the ends of the colours: the bad ones of a wide range share one, so that the good ones differ."""
    least, most = min(numbers), max(numbers)
    if not logarithmic:
        return least, most
    return (max(least, most / DEEP), most) if maximise else (least, min(most, DEEP * least))


def _beyond(grid: Any, least: float, most: float) -> str:
    below, above = float(grid.min()) < least, float(grid.max()) > most
    return {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")


def _star(label: str) -> dict[str, Any]:
    return {
        "color": "white",
        "marker": "*",
        "markersize": 11.0,
        "markeredgecolor": "black",
        "linestyle": "none",
        "zorder": 4.0,
        "label": label,
    }


def _places(axis: Any, parameter: Axis) -> list[float]:
    """Return where a parameter's values are on an axis; words are put at whole numbers, and named there."""
    if parameter.numbers is not None:
        return list(parameter.numbers)
    places = [float(number) for number in range(len(parameter.texts))]
    axis.set_ticks(places, labels=parameter.texts)
    return places


def _edges(places: Sequence[float]) -> list[float]:
    """Return the borders of the cells around values: halfway between, and as far beyond the ends."""
    if len(places) == 1:
        return [places[0] - 0.5, places[0] + 0.5]
    middles = [(a + b) / 2.0 for a, b in itertools.pairwise(places)]
    return [2.0 * places[0] - middles[0], *middles, 2.0 * places[-1] - middles[-1]]


def _logarithmic(numbers: Sequence[float]) -> bool:
    finite = [number for number in numbers if math.isfinite(number)]
    return bool(finite) and min(finite) > 0.0 and max(finite) > WIDE * min(finite)
