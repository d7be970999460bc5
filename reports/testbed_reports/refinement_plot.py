"""Pictures of an adaptive approximation: the mesh coloured by level of refinement, and the history of its bounds."""

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from testbed.approximation.history import Approximation
from testbed.geometry.domain import lattice, side_points
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float, Int, cross, dot, norm, unit
from testbed_reports.plots import SETTINGS
from testbed_reports.styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Dots an inch.
RESOLUTION: Final = 160
#: Levels that have a colour of their own; the last stands for all above too, as in the thesis's table 5.1.
LEVELS: Final = 7
#: From dark to light, evenly to the eye with and without colour vision.
LEVEL_COLOURS: Final = "viridis"
#: Triangles drawn, about: patches are drawn finer where there are fewer.
TRIANGLES: Final = 30_000
#: Most and fewest steps of a drawn side.
STEPS: Final = (1, 10)
#: Direction to the viewer.
VIEW: Final = (0.72, -0.95, 0.55)
#: A surface faces one way if the mean of its normals, by area, is at least this long.
FACING: Final = 0.3
#: Share of the light that does not depend on the direction of the surface.
AMBIENT: Final = 0.85
#: Edges of the mesh: their colour, width in points, how far before the surface they are drawn, relative to its size.
LINE_COLOUR: Final = (0.12, 0.12, 0.12)
LINE_WIDTH: Final = 0.4
LIFT: Final = 0.004


def write_refinement_plot(directory: Path, found: Approximation, title: str) -> Path:
    """Write ``refinement.png``, the surface coloured by level of refinement, and return its path."""
    return _write(directory / "refinement.png", lambda: draw_refinement(found, title))


def write_history_plot(
    directory: Path, found: Approximation, title: str, epsilon_deg: float, distance: float | None
) -> Path:
    """Write ``history.png``, epsilon and distance against the number of faces, and return its path."""
    return _write(directory / "history.png", lambda: draw_history(found, title, epsilon_deg, distance))


def _write(path: Path, draw: Any) -> Path:
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        figure = draw()
        FigureCanvasAgg(figure)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
        path.write_bytes(stream.getvalue())
    return path


def level_colours() -> Float:
    """Return the colours (LEVELS, 3) of the levels of refinement, in [0, 1]."""
    import matplotlib as mpl

    colours: Float = mpl.colormaps[LEVEL_COLOURS](np.linspace(0.08, 1.0, LEVELS))[:, :3]
    return colours


def draw_refinement(found: Approximation, title: str) -> "Figure":
    """Return the picture: mesh edges on the surface, faces coloured by level; from two sides if it turns all ways."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    mesh, levels = found.mesh, found.levels.faces
    triangles, face, lines = _drawn(found.surface, mesh)
    views = _views(mesh)
    figure = Figure(figsize=(4.4 * len(views) + 1.3, 4.6))
    figure.suptitle(title, x=0.02, ha="left", fontsize=8.5)
    colours = level_colours()
    width = 4.4 / (4.4 * len(views) + 1.3)
    for number, view in enumerate(views):
        axes = figure.add_axes((number * width + 0.01, 0.02, width - 0.02, 0.88))
        _paint(axes, triangles, colours[np.minimum(levels[face], LEVELS - 1)], lines, view)
    counts = np.bincount(np.minimum(levels, LEVELS - 1), minlength=LEVELS)
    present = [level for level in range(LEVELS) if counts[level]]
    handles = [Patch(facecolor=tuple(colours[level]), edgecolor="#555555", linewidth=0.5) for level in present]
    names = [f"{level}{'+' if level == LEVELS - 1 else ''}: {counts[level]}" for level in present]
    figure.legend(handles, names, title="level: faces", loc="center right", bbox_to_anchor=(0.995, 0.5), frameon=False)
    return figure


def _drawn(surface: Surface | None, mesh: HermiteMesh) -> tuple[Float, Int, Float]:
    """Return triangles (T, 3, 3) of the surface, the mesh face of each (T,), and the mesh's edges on it (L, S, 3)."""
    if surface is None:
        return mesh.corner_points(), np.arange(len(mesh.faces)), mesh.points[mesh.edges]
    pieces, faces, lines = [], [], []
    for part in surface.parts:
        steps = int(np.clip(math.sqrt(TRIANGLES / max(1, surface.patch_count)), *STEPS))
        at = lattice(part.batch.sides, steps)
        points = part.batch.jets(at, 0).f
        corners = _cells(at, part.batch.sides, steps)
        pieces.append(points[:, corners].reshape(-1, 3, 3))
        faces.append(np.repeat(part.faces, len(corners)))
        lines.append(_outlines(part, mesh, steps))
    return np.concatenate(pieces), np.concatenate(faces), np.concatenate(lines)


def _cells(at: Float, sides: int, steps: int) -> Int:
    """Triangles (C, 3) of a sample lattice, counterclockwise."""
    place = {(round(u * steps), round(v * steps)): number for number, (u, v) in enumerate(at.tolist())}
    cells = []
    for i in range(steps):
        for j in range(steps if sides == 4 else steps - i):
            here, right, up = place[i, j], place[i + 1, j], place[i, j + 1]
            cells.append((here, right, up))
            if (i + 1, j + 1) in place:
                cells.append((right, place[i + 1, j + 1], up))
    return np.array(cells)


def _outlines(part: Part, mesh: HermiteMesh, steps: int) -> Float:
    """Sides (L, steps + 1, 3) of patches that are edges of the mesh, not inner ones of split faces."""
    ids = part.corner_ids
    known = mesh.edges @ np.array([len(mesh.points), 1])
    t = np.linspace(0.0, 1.0, steps + 1)
    lines = [np.empty((0, steps + 1, 3))]
    for side in range(part.batch.sides):
        low, high = np.sort(np.stack([ids[:, side], ids[:, (side + 1) % part.batch.sides]]), axis=0)
        own = (high < len(mesh.points)) & np.isin(low * len(mesh.points) + high, known)
        at = side_points(part.batch.sides, np.array([side]), t)[0]
        lines.append(part.batch.take(np.flatnonzero(own)).jets(at, 0).f)
    return np.concatenate(lines)


def _views(mesh: HermiteMesh) -> list[Float]:
    """Directions to the viewer: two for a surface that turns all ways, one that faces a surface that does not."""
    view = unit(np.array(VIEW))
    corners = mesh.corner_points()
    normals = cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
    mean = normals.sum(axis=0)
    if norm(mean) < FACING * norm(normals).sum():
        return [view, -view]
    # from above the surface, a little from the side
    return [unit(unit(mean) + 0.6 * view)]


def _paint(axes: "Axes", triangles: Float, colours: Float, lines: Float, view: Float) -> None:
    """Draw triangles (T, 3, 3) with colours (T, 3) and lines (L, S, 3) from far to near."""
    from matplotlib.collections import PolyCollection

    right = unit(cross(np.array([0.0, 0.0, 1.0]) if abs(view[2]) < 0.98 else np.array([0.0, 1.0, 0.0]), view))
    frame = np.stack([right, cross(view, right)])
    normal = unit(cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
    light = unit(view + 0.35 * frame[1] - 0.25 * frame[0])
    # both sides of an open surface are lit
    shade = AMBIENT + (1.0 - AMBIENT) * np.abs(np.nan_to_num(dot(normal, light)))
    shown = np.clip(colours * shade[:, None], 0.0, 1.0)
    # segments of lines are flat triangles that are drawn with their outline, just before the faces beside them
    segments = np.stack([lines[:, :-1], lines[:, 1:], lines[:, 1:]], axis=2).reshape(-1, 3, 3)
    size = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    depth = np.concatenate([dot(triangles.mean(axis=1), view), dot(segments.mean(axis=1), view) + LIFT * size])
    order = np.argsort(depth, kind="stable")
    outline = np.concatenate([shown, np.broadcast_to(LINE_COLOUR, (len(segments), 3))])
    flat = np.concatenate([triangles, segments]) @ frame.T
    thick = np.concatenate([np.full(len(triangles), 0.3), np.full(len(segments), LINE_WIDTH)])
    axes.add_collection(
        PolyCollection(
            list(flat[order]),
            facecolors=outline[order].tolist(),
            edgecolors=outline[order].tolist(),
            linewidths=thick[order].tolist(),
            joinstyle="round",
        )
    )
    low, high = flat.reshape(-1, 2).min(axis=0), flat.reshape(-1, 2).max(axis=0)
    middle, reach = 0.5 * (low + high), 0.52 * float((high - low).max())
    axes.set_xlim(middle[0] - reach, middle[0] + reach)
    axes.set_ylim(middle[1] - reach, middle[1] + reach)
    axes.set_aspect("equal")
    axes.set_axis_off()


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
