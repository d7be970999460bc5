"""Sections of surfaces upright on a plane, through the point that is deepest below it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed_reports.rendering.facets import facets_of
from testbed_reports.styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Inches that the sections take at the foot of a figure.
SECTIONS: Final = 2.3
#: Colour of what lies below the plane.
BELOW: Final = (0.835, 0.369, 0.0)
#: Facets of a section, about.
FACETS: Final = 40_000


@dataclass(frozen=True, eq=False)
class PlaneView:
    """A surface to be drawn.

    Parameters
    ----------
    title, remark
        Above the picture, in two lines.
    surface
        The surface.
    group
        What it is made from; surfaces of one group are in one row and one section.
    colour
        Number of its colour in sections.
    truth
        Whether it is what the others approximate.
    """

    title: str
    remark: str
    surface: Surface
    group: str = ""
    colour: int = 0
    truth: bool = False


def draw_sections(figure: "Figure", views: Sequence[PlaneView], normal: Float, offset: float) -> None:
    """Draw sections upright on the plane through the deepest point: whole, and near the plane group by group."""
    cut = [facets_of(one.surface, FACETS) for one in views]
    distances = [dot(one.points, normal) + offset for one in cut]
    own = [number for number, one in enumerate(views) if not one.truth]
    deepest = min(own, key=lambda number: float(np.nanmin(distances[number])))
    origin = cut[deepest].points[int(np.nanargmin(distances[deepest]))]
    along = _direction(views[0].surface, origin, normal)
    lines = []
    for one in cut:
        ends = section(one.points[one.corners], origin, cross(normal, along))
        lines.append(np.stack([dot(ends - origin, along), dot(ends, normal) + offset], axis=-1))
    reach = float(np.nanmax(distances[deepest]))
    depth = max(-float(np.nanmin(distances[deepest])), 0.01 * reach)
    groups = list(dict.fromkeys(one.group for one in views))
    width, height = figure.get_size_inches()
    panel = (width - 0.4) / 3.0
    for number, group in enumerate((groups[0], *groups[:2])):
        left, wide = 0.5 + number * panel, panel - (0.75 if number == 0 else 2.15)
        axes = figure.add_axes((left / width, 0.42 / height, wide / width, (SECTIONS - 0.75) / height))
        shown = [(view, line) for view, line in zip(views, lines, strict=True) if view.truth or view.group == group]
        _draw_section(axes, shown)
        axes.set_title(f"section, from {group}" if number == 0 else f"near the plane, from {group}", fontsize=8)
        low, high = _limits([line for _, line in shown])
        axes.set_xlim(low[0], high[0])
        axes.set_ylim((low[1], high[1]) if number == 0 else (-1.5 * depth, 3.0 * depth))
        if number > 0:
            axes.legend(
                loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=6.5, frameon=False, handlelength=1.6,
                handletextpad=0.5,
            )  # fmt: skip


def _direction(surface: Surface, origin: Float, normal: Float) -> Float:
    """Unit vector (3,) in the plane from a point towards the vertex highest above it."""
    points = surface.mesh.points
    towards = points[int(np.argmax(dot(points, normal)))] - origin
    along = towards - dot(towards, normal) * normal
    if not norm(along) > 1e-3 * norm(towards):
        along = cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    return unit(along)


def _draw_section(axes: "Axes", shown: Sequence[tuple[PlaneView, Float]]) -> None:
    """Draw the segments (N, 2, 2) of each surface, and the plane."""
    from matplotlib.collections import LineCollection

    for view, segments in shown:
        colour = "#b0b0b0" if view.truth else COLOURS[view.colour % len(COLOURS)]
        lines = LineCollection(
            list(segments), colors=colour, linewidths=3.2 if view.truth else 1.1, label=view.title,
            zorder=1.5 if view.truth else 2.0,
        )  # fmt: skip
        axes.add_collection(lines)
    axes.axhspan(-1e9, 0.0, color=(*BELOW, 0.12), linewidth=0)
    axes.axhline(0.0, color="#000000", linewidth=0.8)
    axes.tick_params(labelsize=7)


def _limits(lines: Sequence[Float]) -> tuple[Float, Float]:
    """Lower left and upper right corner (2,) of what holds most of all segments, with a margin."""
    everything = np.concatenate([one.reshape(-1, 2) for one in lines])
    low, high = everything.min(axis=0), everything.max(axis=0)
    margin = 0.04 * (high - low)
    return low - margin, high + margin


def section(triangles: Float, origin: Float, across: Float) -> Float:
    """Return the segments (N, 2, 3) in which triangles (T, 3, 3) meet the plane through a point across a direction."""
    side = dot(triangles - origin, across)
    positive = side > 0.0
    crossed = positive.any(axis=1) & ~positive.all(axis=1) & np.isfinite(side).all(axis=1)
    triangles, side, positive = triangles[crossed], side[crossed], positive[crossed]
    # the corner that is alone on its side of the plane
    lone = np.where(positive.sum(axis=1) == 1, positive.argmax(axis=1), (~positive).argmax(axis=1))
    rows = np.arange(len(side))
    ends = []
    for step in (1, 2):
        other = (lone + step) % 3
        share = side[rows, lone] / (side[rows, lone] - side[rows, other])
        ends.append(triangles[rows, lone] + share[:, None] * (triangles[rows, other] - triangles[rows, lone]))
    return np.stack(ends, axis=1)
