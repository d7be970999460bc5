"""Plane Bezier curves with their control points and, below each, a plot of its curvature over the length of its arc."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from testbed.geometry.bernstein import evaluate_curve
from testbed.geometry.vectors import Float, norm
from testbed_reports.rendering.combs import across_plane, sign_changes
from testbed_reports.rendering.png import write_png

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Inches: width of a curve with its plot, and where there is one in a row, height of both, room for titles.
WIDTH: Final = 2.9
ALONE: Final = 4.4
CURVE: Final = 1.5
PLOT: Final = 1.35
ABOVE: Final = 0.45
BETWEEN: Final = 0.32
BELOW: Final = 0.48
#: Points of a drawn curve, and dots at equal steps of the parameter.
FINE: Final = 401
DOTS: Final = 11
#: Plots end at this many times the largest curvature that the data have.
MOST: Final = 4.0
INK: Final = (0.10, 0.10, 0.12)
BLUE: Final = (0.0, 0.45, 0.70)
GREY: Final = (0.55, 0.55, 0.57)


@dataclass(frozen=True, eq=False)
class CurvePlot:
    """A curve and what is known of it.

    Parameters
    ----------
    title
        Above it.
    control_points
        (n, 3) of a plane Bezier curve.
    given
        Curvatures of the data at both ends, positive where the curve bends the way it bulges.
    """

    title: str
    control_points: Float
    given: tuple[float, float]


def write_curve_plots(path: Path, plots: Sequence[CurvePlot], columns: int = 3, title: str = "") -> Path:
    """Write a PNG file with curves, and plots of their curvature on one scale.

    Parameters
    ----------
    path
        The file.
    plots
        At least one.
    columns
        Curves in a row, at most.
    title
        Above the figure.
    """
    return write_png(path, lambda: draw_curve_plots(plots, columns, title))


def draw_curve_plots(plots: Sequence[CurvePlot], columns: int, title: str) -> "Figure":
    """Return the figure."""
    from matplotlib.figure import Figure

    rows = -(-len(plots) // columns)
    columns = -(-len(plots) // rows)
    wide = WIDTH if columns > 1 else ALONE
    told = (
        f"{title} Crosses: control points. Dots: equal steps of the parameter. Below: curvature over the length of the "
        "arc, grey line the curvature of the data."
    ).strip()
    lines = textwrap.wrap(told, max(30, int(columns * wide * 12.5)))
    head = 0.16 + 0.19 * len(lines)
    period = ABOVE + CURVE + BETWEEN + PLOT + BELOW
    width, height = columns * wide, rows * period + head
    figure = Figure(figsize=(width, height))
    figure.text(0.1 / width, 1.0 - 0.1 / height, "\n".join(lines), va="top", fontsize=9.5)
    top = MOST * max(abs(value) for one in plots for value in one.given)
    values = np.concatenate([curvature(one)[1] for one in plots])
    values = values[np.isfinite(values)].clip(-top, top)
    low, high = min(0.0, float(values.min(initial=0.0))), max(float(values.max(initial=0.0)), 0.0)
    for number, one in enumerate(plots):
        row, column = divmod(number, columns)
        left = column * wide + 0.5
        under = height - head - row * period - ABOVE - CURVE
        box = (left / width, under / height, (wide - 0.65) / width, CURVE / height)
        axes = figure.add_axes(box)
        _curve(axes, one)
        name = "\n".join(textwrap.wrap(one.title, 40)[:2])
        figure.text(
            (left + 0.5 * wide - 0.33) / width, (under + CURVE + 0.05) / height, name, ha="center", fontsize=8.5
        )
        box = (left / width, (under - BETWEEN - PLOT) / height, (wide - 0.65) / width, PLOT / height)
        below = figure.add_axes(box)
        _plot(below, one)
        below.set_ylim(low - 0.05 * (high - low or 1.0), high + 0.08 * (high - low or 1.0))
    return figure


def curvature(one: CurvePlot) -> tuple[Float, Float]:
    """Share of the arc's length, from 0 to 1, and signed curvature there, (FINE,) each."""
    t = np.linspace(0.0, 1.0, FINE)
    axes = across_plane(one.control_points)
    flat = one.control_points @ axes.T
    points, first, second = evaluate_curve(flat, t, 2)
    with np.errstate(invalid="ignore", divide="ignore"):
        turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        # a curve that bulges upwards turns clockwise
        signed: Float = -turn / norm(first) ** 3
    length = np.concatenate([[0.0], np.cumsum(norm(np.diff(points, axis=0)))])
    return length / length[-1], signed


def _curve(axes: "Axes", one: CurvePlot) -> None:
    plane = across_plane(one.control_points)
    origin = one.control_points[0] @ plane.T
    net = one.control_points @ plane.T - origin
    points = evaluate_curve(net, np.linspace(0.0, 1.0, FINE))[0]
    dots = evaluate_curve(net, np.linspace(0.0, 1.0, DOTS))[0]
    axes.plot(*net.T, "-", color=GREY, linewidth=0.5)
    axes.plot(*net.T, "x", color=BLUE, markersize=6.0, markeredgewidth=1.3, zorder=4)
    axes.plot(*points.T, color=INK, linewidth=1.3)
    axes.plot(*dots.T, "o", color=INK, markersize=3.2, markeredgewidth=0.0, zorder=3)
    t = np.linspace(0.0, 1.0, FINE)
    _, places = sign_changes(curvature(one)[1][None], norm(net[None, -1] - net[None, 0]), t)
    inflections = evaluate_curve(net, places)[0]
    axes.plot(*inflections.T, "D", color=(0.8, 0.1, 0.45), markersize=4.5, markerfacecolor="#ffffff", zorder=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_axis_off()


def _plot(axes: "Axes", one: CurvePlot) -> None:
    along, signed = curvature(one)
    axes.plot((0.0, 1.0), one.given, color=GREY, linewidth=1.0)
    axes.plot(along, signed, color=BLUE, linewidth=1.2)
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks([0.0, 0.5, 1.0], ["0", "½", "1"])
    axes.tick_params(labelsize=7)
    known = signed[np.isfinite(signed)]
    axes.set_xlabel(f"curvature {known.min():.3g} to {known.max():.3g}", fontsize=7.5)
