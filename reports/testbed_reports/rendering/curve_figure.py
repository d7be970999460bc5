"""Pictures of boundary curves side by side: combs of curvature on one scale, inflections, dots at equal parameters."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, norm
from testbed_reports.rendering.camera import VIEW, Camera
from testbed_reports.rendering.colouring import rounded_up
from testbed_reports.rendering.combs import Combs, combs
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.lines import BEHIND
from testbed_reports.rendering.png import DPI, write_png
from testbed_reports.rendering.visibility import GRID, Buffer, rasterise

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Inches above a picture for its title and below it for its remark.
ABOVE: Final = 0.52
BELOW: Final = 0.4
#: A full tooth, as a share of the picture's width; longer ones than so many full teeth are cut.
TOOTH: Final = 0.07
LONGEST: Final = 2.0
#: Share of teeth that the full tooth is not below.
COVERED: Final = 0.95
#: Colours: curves in front and behind, combs, teeth that were cut, dots, inflections.
CURVE: Final = (0.10, 0.10, 0.12)
HIDDEN: Final = (0.80, 0.80, 0.82)
COMB: Final = (0.0, 0.45, 0.70)
CUT: Final = (0.84, 0.37, 0.0)
INFLECTION: Final = (0.80, 0.10, 0.45)


@dataclass(frozen=True, eq=False)
class CurveSubject:
    """What one picture shows.

    Parameters
    ----------
    title
        Above the picture.
    network
        The curves.
    """

    title: str
    network: CurveNetwork


@dataclass(frozen=True, eq=False)
class CurveLook:
    """Curves as a camera sees them.

    Parameters
    ----------
    subject, combs, camera
        What is seen, and from where.
    seen
        (E, TEETH) which points of the curves are in front.
    """

    subject: CurveSubject
    combs: Combs
    camera: Camera
    seen: Bool


def write_curve_figure(
    path: Path,
    subjects: Sequence[CurveSubject],
    *,
    size: int = 480,
    view: tuple[float, float] | None = None,
    limit: float | None = None,
    columns: int = 4,
    title: str = "",
) -> Path:
    """Write a PNG file with a picture of each network, all from one side, with one scale of the combs.

    Parameters
    ----------
    path
        The file.
    subjects
        At least one.
    size
        Pixels along a side of a picture.
    view
        Azimuth and elevation in degrees; None for the usual view.
    limit
        Curvature of a full tooth; None for one that suits all pictures.
    columns
        Pictures in a row, at most.
    title
        Above the whole figure.
    """
    looks = see_curves(subjects, size, view)
    full = limit or full_tooth(looks)
    return write_png(path, lambda: draw_curves(looks, full, size, columns, title))


def see_curves(
    subjects: Sequence[CurveSubject], size: int, view: tuple[float, float] | None = None
) -> tuple[CurveLook, ...]:
    """See networks from one side."""
    found = [combs(one.network) for one in subjects]
    points = np.concatenate([one.points.reshape(-1, 3) for one in found])
    camera = Camera.around(points[np.isfinite(points).all(axis=-1)], *(view or VIEW))
    # room for the teeth
    camera = replace(camera, width=camera.width * (1.0 + 2.0 * TOOTH))
    return tuple(
        CurveLook(one, comb, camera, _in_front(comb, one.network.mesh, camera, size))
        for one, comb in zip(subjects, found, strict=True)
    )


def full_tooth(looks: Sequence[CurveLook]) -> float:
    """Return the round curvature that most teeth of all pictures do not exceed."""
    values = np.abs(np.concatenate([one.combs.curvature.ravel() for one in looks]))
    known = values[np.isfinite(values)]
    return rounded_up(float(np.quantile(known, COVERED)) if len(known) else 1.0)


def _in_front(comb: Combs, mesh: HermiteMesh, camera: Camera, size: int) -> Bool:
    """(E, TEETH) true where curves are not behind the plane faces of their mesh, by more than they bulge."""
    corners = mesh.corner_points()
    batch = BezierTriangles(corners) if mesh.sides == 3 else BezierQuads(corners[:, [0, 3, 1, 2]].reshape(-1, 2, 2, 3))
    facets = facets_of(Surface.over_faces(mesh, batch))
    buffer, _ = rasterise(facets, camera, size)
    ends = comb.points[:, [0, -1]]
    t = np.linspace(0.0, 1.0, comb.points.shape[1])[:, None]
    bulge = norm(comb.points - (ends[:, :1] * (1.0 - t) + ends[:, 1:] * t))
    screen = camera.screen(comb.points.reshape(-1, 3), size).reshape(comb.points.shape)
    return _not_behind(screen, buffer, float(np.nanmax(bulge, initial=0.0)) * size / camera.width + BEHIND)


def _not_behind(screen: Float, buffer: Buffer, slack: float) -> Bool:
    last = len(buffer.facet) - 1
    with np.errstate(invalid="ignore"):
        column, row = (np.nan_to_num(screen[..., i] * GRID).clip(0, last).astype(np.int64) for i in (0, 1))
        seen: Bool = screen[..., 2] >= buffer.depth[row, column] - slack
    return seen


def draw_curves(looks: Sequence[CurveLook], full: float, size: int, columns: int, title: str) -> "Figure":
    """Return the figure; a full tooth is the curvature ``full``."""
    from matplotlib.figure import Figure

    rows = -(-len(looks) // columns)
    columns = -(-len(looks) // rows)
    side, strip = size / DPI, _strip(looks, full, size)
    tall = (strip[1] - strip[0]) / DPI
    told = (
        f"{title} Combs of curvature: a tooth as long as the blue bar is {full:g} per length, outwards where the curve "
        f"bends away from the surface's normal; cut at {LONGEST:g} times that (orange tips). Dots: equal steps of the "
        "parameter. Diamonds: inflections. Pale: behind the mesh."
    ).strip()
    lines = textwrap.wrap(told, max(20, int(columns * side * 11.5)))
    head = 0.12 + 0.2 * len(lines)
    width, height = columns * side, rows * (tall + ABOVE + BELOW) + head
    figure = Figure(figsize=(width, height))
    figure.text(0.08 / width, 1.0 - 0.1 / height, "\n".join(lines), va="top", fontsize=10)
    for number, one in enumerate(looks):
        row, column = divmod(number, columns)
        bottom = height - head - (row + 1) * (tall + ABOVE + BELOW) + BELOW
        axes = figure.add_axes((column * side / width, bottom / height, side / width, tall / height))
        _paint(axes, one, full, size, strip)
        name = "\n".join(textwrap.wrap(one.subject.title, int(side * 12.5))[:2])
        middle = (column + 0.5) * side / width
        figure.text(middle, (bottom + tall + 0.06) / height, name, ha="center", fontsize=9)
        figure.text(middle, (bottom - 0.06) / height, _remark(one), ha="center", va="top", fontsize=7.5)
    return figure


def _remark(one: CurveLook) -> str:
    known = one.combs.curvature[np.isfinite(one.combs.curvature)]
    count = len(one.combs.inflections)
    told = f"{len(one.combs.points)} curves: curvature {known.min():.3g} to {known.max():.3g}" if len(known) else "none"
    return f"{told}, {count} inflection{'s' * (count != 1)}"


def _strip(looks: Sequence[CurveLook], full: float, size: int) -> tuple[int, int]:
    """The rows of pixels that hold all teeth, and the bars below them."""
    rows = np.concatenate([_screen(_tips(one, full)[0], one.camera, size)[..., 1].ravel() for one in looks])
    rows = rows[np.isfinite(rows)]
    first, last = (int(rows.min()), int(rows.max())) if len(rows) else (0, size)
    return max(0, first - size // 40), min(size, max(last, first + size // 3) + size // 10)


def _paint(axes: "Axes", one: CurveLook, full: float, size: int, strip: tuple[int, int]) -> None:
    from matplotlib.collections import LineCollection

    flat = _screen(one.combs.points, one.camera, size)
    tips, cut = _tips(one, full)
    tips = _screen(tips, one.camera, size)
    pieces = np.stack([flat[:, :-1], flat[:, 1:]], axis=2)
    seen = one.seen[:, :-1] & one.seen[:, 1:]
    known = one.seen & np.isfinite(tips).all(axis=-1)
    teeth = np.stack([flat, tips], axis=2)
    envelope = np.stack([tips[:, :-1], tips[:, 1:]], axis=2)
    axes.add_collection(LineCollection(list(pieces[~seen]), colors=[HIDDEN], linewidths=0.7, zorder=1))
    axes.add_collection(LineCollection(list(teeth[known]), colors=[(*COMB, 0.45)], linewidths=0.4, zorder=2))
    axes.add_collection(
        LineCollection(list(envelope[known[:, :-1] & known[:, 1:]]), colors=[COMB], linewidths=0.6, zorder=2)
    )
    axes.add_collection(LineCollection(list(pieces[seen]), colors=[CURVE], linewidths=1.1, zorder=3))
    axes.plot(*tips[cut & known].T, ".", color=CUT, markersize=2.5, zorder=4)
    dots = _screen(one.combs.dots, one.camera, size)
    # dots lie at every so many teeth
    every = (one.combs.points.shape[1] - 1) // (dots.shape[1] - 1)
    axes.plot(*dots[one.seen[:, ::every]].T, "o", color=CURVE, markersize=2.4, markeredgewidth=0.0, zorder=4)
    inflections = _screen(one.combs.inflections, one.camera, size)
    step = np.round(one.combs.inflected_at * (one.seen.shape[1] - 1)).astype(np.int64)
    axes.plot(
        *inflections[one.seen[one.combs.inflected, step]].T,
        "D",
        color=INFLECTION,
        markersize=4.0,
        markerfacecolor="#ffffff",
        zorder=5,
    )
    _bars(axes, one.camera, size, strip[1])
    axes.set_axis_off()
    axes.set_xlim(0, size)
    axes.set_ylim(strip[1], strip[0])


def _tips(one: CurveLook, full: float) -> tuple[Float, Bool]:
    """Ends (E, TEETH, 3) of the teeth, and which were cut."""
    length = np.abs(one.combs.curvature) / full
    cut = length > LONGEST
    with np.errstate(invalid="ignore", divide="ignore"):
        away = -one.combs.vectors / norm(one.combs.vectors)[..., None]
    away = np.where((length == 0.0)[..., None], 0.0, away)
    return one.combs.points + (length.clip(None, LONGEST) * TOOTH * one.camera.width)[..., None] * away, cut


def _screen(points: Float, camera: Camera, size: int) -> Float:
    """Pixels (..., 2) to the right and downwards of points (..., 3)."""
    return camera.screen(points.reshape(-1, 3), size)[:, :2].reshape(*points.shape[:-1], 2)


def _bars(axes: "Axes", camera: Camera, size: int, bottom: int) -> None:
    """A length with its number, and a full tooth."""
    length = rounded_up(camera.width / 7.0)
    left, low = 0.03 * size, bottom - 0.02 * size
    axes.plot([left, left + length / camera.width * size], [low, low], color="#444444", linewidth=1.4)
    axes.text(left, low - 0.012 * size, f"{length:g}", fontsize=7, color="#444444", va="bottom")
    axes.plot([0.97 * size] * 2, [low, low - TOOTH * size], color=COMB, linewidth=1.6)
