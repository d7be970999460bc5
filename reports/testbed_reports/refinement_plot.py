"""Pictures of an adaptive approximation: the mesh coloured by level of refinement, and the history of its bounds."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from testbed.approximation.history import Approximation
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, norm, unit
from testbed_reports.rendering.figure import Additions, Subject, draw_figure, panels
from testbed_reports.rendering.legends import Key
from testbed_reports.rendering.png import write_png
from testbed_reports.styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Dots an inch of the plot of the history.
RESOLUTION: Final = 160
#: Pixels along a side of a picture of the surface.
SIZE: Final = 560
#: Levels that have a colour of their own; the last stands for all above too, as in the thesis's table 5.1.
LEVELS: Final = 7
#: From dark to light, evenly to the eye with and without colour vision.
LEVEL_COLOURS: Final = "viridis"
#: Direction to the viewer.
VIEW: Final = (0.72, -0.95, 0.55)
#: A surface faces one way if the mean of its normals, by area, is at least this long.
FACING: Final = 0.3


def write_refinement_plot(directory: Path, found: Approximation, title: str) -> Path:
    """Write ``refinement.png``, the surface coloured by level of refinement, and return its path."""
    return write_png(directory / "refinement.png", lambda: draw_refinement(found, title))


def write_history_plot(
    directory: Path, found: Approximation, title: str, epsilon_deg: float, distance: float | None
) -> Path:
    """Write ``history.png``, epsilon and distance against the number of faces, and return its path."""
    return write_png(directory / "history.png", lambda: draw_history(found, title, epsilon_deg, distance), RESOLUTION)


def level_colours() -> Float:
    """Return the colours (LEVELS, 3) of the levels of refinement, in [0, 1]."""
    import matplotlib as mpl

    colours: Float = mpl.colormaps[LEVEL_COLOURS](np.linspace(0.08, 1.0, LEVELS))[:, :3]
    return colours


def draw_refinement(found: Approximation, title: str, size: int = SIZE) -> "Figure":
    """Return the picture: mesh edges on the surface, faces coloured by level; from two sides if it turns all ways."""
    surface = drawn_surface(found)
    subjects = [
        Subject("", surface, view=view, colours=level_map(found, surface), remark="") for view in views_of(found.mesh)
    ]
    additions = Additions(edges="mesh", key=level_key(found), heading="level: faces")
    return draw_figure(
        panels(subjects, "shaded", size, additions=additions), columns=2, title=title, additions=additions
    )


def drawn_surface(found: Approximation) -> Surface:
    """Return the surface of an approximation; the plane faces of its mesh where the scheme refused that."""
    if found.surface is not None:
        return found.surface
    corners = found.mesh.corner_points()
    return Surface.over_faces(found.mesh, BezierTriangles(corners))


def level_map(found: Approximation, surface: Surface) -> tuple[Float, ...]:
    """Return the colours (P, 3) of the patches of each part of a surface, by the levels of their faces."""
    colours = level_colours()
    levels = np.minimum(found.levels.faces, LEVELS - 1)
    return tuple(colours[levels[part.faces]] for part in surface.parts)


def level_key(found: Approximation) -> tuple[Key, ...]:
    """Return names and colours of the levels that there are, with the numbers of their faces."""
    counts = np.bincount(np.minimum(found.levels.faces, LEVELS - 1), minlength=LEVELS)
    return tuple(
        (f"{level}{'+' if level == LEVELS - 1 else ''}: {counts[level]}", (float(r), float(g), float(b)))
        for level, (r, g, b) in enumerate(level_colours())
        if counts[level]
    )


def views_of(mesh: HermiteMesh) -> list[tuple[float, float]]:
    """Azimuth and elevation: two for a surface that turns all ways, one that faces a surface that does not."""
    view = unit(np.array(VIEW))
    corners = mesh.corner_points()
    normals = cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    mean = normals.sum(axis=0)
    if norm(mean) < FACING * norm(normals).sum():
        return [_angles(view), _angles(-view)]
    # from above the surface, a little from the side
    return [_angles(unit(unit(mean) + 0.6 * view))]


def _angles(towards: Float) -> tuple[float, float]:
    """Azimuth and elevation in degrees of a unit vector."""
    x, y, z = towards.tolist()
    return math.degrees(math.atan2(y, x)), math.degrees(math.asin(z))


def draw_history(found: Approximation, title: str, epsilon_deg: float, distance: float | None) -> "Figure":
    """Return the plot: epsilon and distance of every mesh against its faces, with the bounds asked for."""
    from matplotlib.figure import Figure

    faces = [step.faces for step in found.history]
    figure = Figure(figsize=(7.6, 3.1), layout="constrained")
    figure.suptitle(f"{title}: {found.stop}", x=0.01, ha="left", fontsize=8.5)
    left, right = figure.subplots(1, 2)
    angles = {
        "largest on the edges": [step.epsilon_deg for step in found.history],
        "at ten samples": [step.epsilon_sampled_deg for step in found.history],
    }
    certified = all(step.distance_certified for step in found.history)
    name = "guaranteed bound" if certified else "largest found"
    apart = {name: [step.distance for step in found.history]}
    if certified:
        apart["largest found"] = [step.distance_found for step in found.history]
    _curves(left, faces, angles, epsilon_deg, "epsilon (degrees)")
    _curves(right, faces, apart, distance, "distance")
    return figure


def _curves(
    axes: "Axes", faces: Sequence[int], values: dict[str, list[float]], target: float | None, label: str
) -> None:
    """Draw quantities against the number of faces, on logarithmic scales where they allow it."""
    from matplotlib.ticker import FuncFormatter

    axes.set_xlabel("faces")
    axes.set_ylabel(label)
    axes.grid(visible=True, color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    for number, (name, ordinates) in enumerate(values.items()):
        # the first line in front of the others, which often lie on it
        axes.plot(
            faces,
            ordinates,
            color=COLOURS[number],
            marker="os"[number],
            markersize=(4.0, 6.5)[number],
            markerfacecolor=(COLOURS[0], "none")[number],
            linestyle=("solid", "dotted")[number],
            zorder=3.0 - number,
            label=name,
        )
    if target is not None:
        axes.axhline(target, color="#8a8a8a", linewidth=0.9, linestyle=(0, (4.0, 2.0)), label="asked for", zorder=1.5)
    axes.set_xscale("log")
    # as many labels as have room
    first_digits = "125" if faces[-1] > 20 * faces[0] else "1234567"

    def counted(count: float, position: int | None = None) -> str:
        del position
        return f"{count:,.0f}".replace(",", " ") if f"{count:e}"[0] in first_digits else ""

    axes.xaxis.set_major_formatter(FuncFormatter(counted))
    axes.xaxis.set_minor_formatter(FuncFormatter(counted))
    everything = [value for ordinates in values.values() for value in ordinates]
    # on a logarithmic scale zero would not be seen
    if min(everything) > 0.0:
        axes.set_yscale("log")
    axes.legend(fontsize=7.5)
