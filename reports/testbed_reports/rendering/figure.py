"""Pictures side by side, with titles, a colour bar that they share, and a length to compare with."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed_reports.rendering.camera import VIEW, Camera
from testbed_reports.rendering.colouring import EXACT, ISOPHOTE_DEG, LABELS, Scale, Style, mapped, palette, rounded_up
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.legends import KEYED, KINDS, Key, draw_legend
from testbed_reports.rendering.marks import Mark, extremes
from testbed_reports.rendering.nets import Net, control_net, control_points
from testbed_reports.rendering.picture import Look, common_scale, look, pixels, tinted
from testbed_reports.rendering.png import DPI, write_png

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Inches above a picture for its title, below it for its remark, and beside the last for the colour bar.
ABOVE: Final = 0.52
BELOW: Final = 0.34
BESIDE: Final = 1.45
#: Edges between patches: colour and width in points; control nets likewise.
EDGE_COLOUR: Final = (0.1, 0.1, 0.12)
EDGE_WIDTH: Final = 0.5
INNER_COLOUR: Final = (0.62, 0.62, 0.64)
HIGHLIGHT: Final = 2.4
NET_COLOUR: Final = (0.72, 0.16, 0.09)
NET_WIDTH: Final = 0.6
#: A picture is made wider for control nets up to this many times.
WIDEST: Final = 2.0
#: Which edges are drawn; see :class:`Additions`.
Edges: TypeAlias = bool | Literal["mesh", "kinds"] | None
#: Normal angles up to this many degrees are drawn as none.
SMOOTH_DEG: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Subject:
    """What one picture of a figure shows.

    Parameters
    ----------
    title
        Above the picture.
    surface
        The surface.
    exact
        The surface it approximates, or None.
    style
        Its colouring; None for the figure's.
    view
        Azimuth and elevation in degrees; None for the figure's.
    colours
        For each part of the surface the colours (P, 3) of its patches, from 0 to 1, to be shaded instead of the usual
        one; None for that.
    remark
        Below the picture, in place of what the style says there; None for that.
    highlight
        Edges of the mesh, as pairs of vertices, that are drawn thick.
    edges
        As in :class:`Additions`, for this picture; None for the figure's.
    """

    title: str
    surface: Surface
    exact: ExactSurface | None = None
    style: Style | None = None
    view: tuple[float, float] | None = None
    colours: tuple[Float, ...] | None = None
    remark: str | None = None
    highlight: tuple[tuple[int, int], ...] = ()
    edges: Edges = None


@dataclass(frozen=True)
class Additions:
    """What figures show besides surfaces.

    Parameters
    ----------
    edges
        Whether edges of patches are drawn; None for where the style wants it; ``mesh`` for those of the mesh only,
        ``kinds`` for these, and lightly those within its faces.
    net
        Whether control nets are drawn, where patches have any.
    extremes
        Whether the largest and the smallest curvature are marked, where the style shows curvature.
    key, heading
        Colours with their names, for pictures with colours of their own, and what stands above them.
    """

    edges: Edges = None
    net: bool = False
    extremes: bool = False
    key: tuple[Key, ...] = ()
    heading: str = ""


@dataclass(frozen=True, eq=False)
class Panel:
    """A picture of a figure, before it is drawn."""

    subject: Subject
    style: Style
    look: Look
    scale: Scale
    net: Net | None = None
    marks: tuple[Mark, ...] = ()


def write_figure(
    path: Path,
    subjects: Sequence[Subject],
    style: Style,
    *,
    size: int = 480,
    view: tuple[float, float] | None = None,
    limit: float | None = None,
    columns: int = 4,
    title: str = "",
    additions: Additions = Additions(),
) -> Path:
    """Write a PNG file with a picture of each subject; those of one style have one scale, and all the same lengths.

    Parameters
    ----------
    path
        The file.
    subjects
        At least one.
    style
        The colouring of subjects that name none.
    size
        Pixels along a side of a picture.
    view
        Azimuth and elevation in degrees of subjects that name none; None for the usual view.
    limit
        Upper limit of the scales; None for ones that suit all pictures.
    columns
        Pictures in a row, at most.
    title
        Above the whole figure.
    additions
        What else is drawn.
    """
    seen = panels(subjects, style, size, view, limit, additions)
    return write_png(path, lambda: draw_figure(seen, columns=columns, title=title, additions=additions))


def panels(
    subjects: Sequence[Subject],
    style: Style,
    size: int,
    view: tuple[float, float] | None = None,
    limit: float | None = None,
    additions: Additions = Additions(),
) -> list[Panel]:
    """See subjects as :func:`write_figure` shows them."""
    points = _finite(np.concatenate([facets_of(one.surface, 4000).points for one in subjects]))
    nets = _finite(np.concatenate([control_points(one.surface) for one in subjects if additions.net] or [points]))
    views = [one.view or view or VIEW for one in subjects]
    cameras = {angles: Camera.around(points, *angles) for angles in views}
    # lengths compare across pictures from different sides too
    width = max(camera.width for camera in cameras.values())
    for angles in cameras if additions.net else ():
        around = Camera.around(np.concatenate([points, nets]), *angles)
        if around.width <= WIDEST * width:
            cameras[angles] = around
    width = max(camera.width for camera in cameras.values())
    seen = []
    for one, angles in zip(subjects, views, strict=True):
        own = one.style or style
        found = look(one.surface, own, size, replace(cameras[angles], width=width), one.exact)
        net = control_net(one.surface, found.camera, found.buffer) if additions.net and found.buffer else None
        marks = extremes(one.surface, own, found.camera, found.buffer) if additions.extremes and found.buffer else ()
        seen.append(Panel(one, own, found, Scale(0.0, 1.0), net, marks))
    scales = {own: common_scale([one.look for one in seen if one.style == own], own) for own in {p.style for p in seen}}
    if limit is not None:
        scales = {own: Scale(-limit if scale.low < 0.0 else 0.0, limit) for own, scale in scales.items()}
    return [replace(one, scale=scales[one.style]) for one in seen]


def _finite(points: Float) -> Float:
    """Return those of points (N, 3) that are."""
    found: Float = points[np.isfinite(points).all(axis=-1)]
    return found


def draw_figure(seen: Sequence[Panel], *, columns: int, title: str, additions: Additions = Additions()) -> "Figure":
    """Return the figure of surfaces as seen."""
    from matplotlib.figure import Figure

    rows = -(-len(seen) // columns)
    columns = -(-len(seen) // rows)
    side, strip = seen[0].look.sights.size / DPI, _strip(seen)
    tall = (strip[1] - strip[0]) / DPI
    beside = BESIDE if additions.key or any(one.style in KEYED for one in seen) else 0.0
    lines = [line for part in title.split("\n") for line in textwrap.wrap(part, _letters(columns * side + beside))]
    head = 0.12 + 0.2 * len(lines)
    width, height = columns * side + beside, rows * (tall + ABOVE + BELOW) + head
    figure = Figure(figsize=(width, height))
    if title:
        figure.text(0.08 / width, 1.0 - 0.1 / height, "\n".join(lines), va="top", fontsize=10)
    widest = rounded_up(max((float(np.nanmax(one.look.lines.angle_deg, initial=0.0)) for one in seen), default=0.0))
    for number, one in enumerate(seen):
        row, column = divmod(number, columns)
        bottom = height - head - (row + 1) * (tall + ABOVE + BELOW) + BELOW
        axes = figure.add_axes((column * side / width, bottom / height, side / width, tall / height))
        _paint(axes, one, widest, additions)
        axes.set_ylim(strip[1], strip[0])
        _ruler(axes, one.look, strip[1])
        name = "\n".join(textwrap.wrap(one.subject.title, int(side * 12.5))[:2])
        middle = (column + 0.5) * side / width
        figure.text(middle, (bottom + tall + 0.06) / height, name, ha="center", fontsize=9)
        figure.text(middle, (bottom - 0.06) / height, _remark(one, additions), ha="center", va="top", fontsize=7.5)
    if beside:
        _legends(figure, seen, columns, widest, additions, (columns * side, head + ABOVE, tall, tall + ABOVE + BELOW))
    return figure


def _legends(
    figure: "Figure",
    seen: Sequence[Panel],
    columns: int,
    widest: float,
    additions: Additions,
    place: tuple[float, float, float, float],
) -> None:
    """Draw the legend of each style beside the row where it comes first; several there share its height."""
    left, top, tall, period = place
    width, height = figure.get_size_inches()
    first: dict[int, list[Panel]] = {}
    known: set[Style] = set()
    for number, one in enumerate(seen):
        if one.style in KEYED or (additions.key and one.subject.colours is not None):
            if one.style not in known:
                first.setdefault(number // columns, []).append(one)
            known.add(one.style)
    for row, here in first.items():
        for place_in_row, one in enumerate(here):
            room = tall / len(here)
            bar = min(room - 0.35 * (len(here) > 1), 3.0)
            middle = top + row * period + (place_in_row + 0.5) * room
            box = ((left + 0.22) / width, 1.0 - (middle + 0.5 * bar) / height, 0.16 / width, bar / height)
            key = additions.key if one.subject.colours is not None else _kinds(seen) if one.style == "patches" else ()
            draw_legend(figure, box, one.style, one.scale, widest, key, additions.heading)


def _kinds(seen: Sequence[Panel]) -> tuple[Key, ...]:
    """The kinds of patches that there are, with their colours."""
    groups = {int(group) for one in seen if one.style == "patches" for group in np.unique(one.look.group)}
    return tuple(KINDS[group] for group in sorted(groups))


def _paint(axes: "Axes", one: Panel, widest: float, additions: Additions) -> None:
    from matplotlib.collections import LineCollection

    seen, size = one.look, one.look.sights.size
    base = None if one.subject.colours is None else tinted(one.look.sights, one.subject.colours)
    axes.imshow(pixels(seen, one.style, one.scale, base), extent=(0, size, size, 0), interpolation="none")
    axes.set_axis_off()
    edges = additions.edges if one.subject.edges is None else one.subject.edges
    if one.style == "jump":
        angle = np.nan_to_num(seen.lines.angle_deg, nan=0.0)
        bent = angle > SMOOTH_DEG
        colours = palette(one.style)[(angle[bent] / widest * 255).clip(0, 255).astype(np.int64)]
        axes.add_collection(LineCollection(list(seen.lines.ends[~bent]), colors=[(0.6, 0.6, 0.62)], linewidths=0.4))
        axes.add_collection(LineCollection(list(seen.lines.ends[bent]), colors=colours, linewidths=1.6))
    elif edges or (edges is None and one.style == "patches"):
        outer = ~seen.lines.inner if edges in ("mesh", "kinds") else np.ones(len(seen.lines.ends), dtype=np.bool_)
        axes.add_collection(LineCollection(list(seen.lines.ends[outer]), colors=[EDGE_COLOUR], linewidths=EDGE_WIDTH))
        if edges == "kinds":
            light = list(seen.lines.ends[~outer])
            axes.add_collection(LineCollection(light, colors=[INNER_COLOUR], linewidths=EDGE_WIDTH, zorder=0.9))
    if one.subject.highlight and seen.lines.edge is not None:
        ids = np.sort(one.subject.surface.edges.ids[seen.lines.edge], axis=1)
        pairs = np.sort(np.array(one.subject.highlight), axis=1)
        chosen = (ids[:, None] == pairs[None]).all(axis=-1).any(axis=1)
        axes.add_collection(LineCollection(list(seen.lines.ends[chosen]), colors=[EDGE_COLOUR], linewidths=HIGHLIGHT))
    if one.net is not None:
        axes.add_collection(LineCollection(list(one.net.ends), colors=[NET_COLOUR], linewidths=NET_WIDTH))
        axes.plot(*one.net.points.T, "s", color=NET_COLOUR, markersize=1.8, markeredgewidth=0.0)
    for mark in one.marks:
        if mark.place is not None:
            shape = "^" if mark.largest else "v"
            axes.plot(*mark.place, shape, color="#ffffff", markersize=9.5, markerfacecolor="none", markeredgewidth=2.4)
            inner = "#000000" if mark.seen else "none"
            axes.plot(*mark.place, shape, color="#000000", markersize=8.0, markerfacecolor=inner, markeredgewidth=1.0)
    axes.set_xlim(0, size)


def _letters(inches: float) -> int:
    """Letters of a title that fit into a line."""
    return max(20, int(inches * 11.5))


def _strip(seen: Sequence[Panel]) -> tuple[int, int]:
    """The rows of pixels, from the first to before the last, that hold all that is seen and a ruler below it."""
    size = seen[0].look.sights.size
    rows = np.concatenate(
        [
            *(one.look.sights.pixel // size for one in seen),
            *(one.net.points[:, 1] for one in seen if one.net is not None),
        ]
    )
    first, last = (int(rows.min()), int(rows.max())) if len(rows) else (0, size - 1)
    return max(0, first - size // 40), min(size, max(last, first + size // 3) + size // 11)


def _ruler(axes: "Axes", one: Look, bottom: int) -> None:
    """A length of about a fifth of the picture, with its number."""
    size, width = one.sights.size, one.camera.width
    length = rounded_up(width / 7.0)
    left, low = 0.03 * size, bottom - 0.02 * size
    axes.plot([left, left + length / width * size], [low, low], color="#444444", linewidth=1.4, solid_capstyle="butt")
    axes.text(left, low - 0.012 * size, f"{length:g}", fontsize=7, color="#444444", va="bottom")


def _remark(one: Panel, additions: Additions) -> str:
    """What stands below a picture: the range of what is seen, or what there is to say."""
    remarks = [_told(one) if one.subject.remark is None else one.subject.remark]
    if one.marks:
        remarks = [
            f"{'▲' if mark.largest else '▼'} {mark.value:.4g}"
            + ("" if mark.seen else " (hidden)" if mark.place is not None else " (no place)")
            for mark in one.marks
        ]
    if additions.net and one.net is None:
        remarks.append("no control net: patches are not Bézier patches")
    return ", ".join(remarks)


def _told(one: Panel) -> str:
    """The range of what is seen, or how many patches there are."""
    if one.style == "jump":
        known = one.look.lines.angle_deg[np.isfinite(one.look.lines.angle_deg)]
        return f"largest angle seen: {known.max():.3g}°" if len(known) else "one patch: nothing joins"
    if one.style in EXACT and one.subject.exact is None:
        return "no exact surface"
    if one.style in LABELS:
        values = mapped(one.style, one.look.fields)
        known = values[np.isfinite(values)]
        return f"seen: {known.min():.3g} to {known.max():.3g}" if len(known) else "no values"
    faces = len(one.subject.surface.mesh.faces)
    return f"{faces} face{'s' * (faces != 1)}, {one.subject.surface.patch_count} patches"


def caption(style: Style) -> str:
    """What a style shows, in one sentence."""
    return {
        "shaded": "Shaded, with the light above the viewer's left shoulder.",
        "patches": "Patches and their edges, those beside the faces in a colour of their own.",
        "gauss": "Gaussian curvature, zero in grey.",
        "mean": "Mean curvature, zero in grey; positive where the surface bends away from its normal.",
        "distance": "Distance from the exact surface.",
        "isophotes": f"Isophotes: bands of {ISOPHOTE_DEG:g} degrees of the angle between normal and light.",
        "zebra": "Reflection lines: horizontal stripes around the surface, mirrored in it.",
        "thesis": "Gaussian curvature as in Mann 1992: red at 4 and above, green at 0, blue at -4 and below.",
        "jump": "Angle between the normals of neighbouring patches along their edges.",
    }[style]
