"""Pictures side by side, with titles, a colour bar that they share, and a length to compare with."""

import io
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed_reports.plots import SETTINGS
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.colouring import (
    EXACT,
    ISOPHOTE_DEG,
    LABELS,
    PATCHES,
    Scale,
    Style,
    mapped,
    palette,
    rounded_up,
)
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.picture import Look, common_scale, look, pixels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Pixels of the figure an inch; titles and labels are in points.
DPI: Final = 120
#: Inches above a picture for its title, below it for its remark, and beside the last for the colour bar.
ABOVE: Final = 0.52
BELOW: Final = 0.34
BESIDE: Final = 1.45
#: Edges between patches: colour and width in points.
EDGE_COLOUR: Final = (0.1, 0.1, 0.12)
EDGE_WIDTH: Final = 0.5
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
    """

    title: str
    surface: Surface
    exact: ExactSurface | None = None


def write_figure(
    path: Path,
    subjects: Sequence[Subject],
    style: Style,
    *,
    size: int = 480,
    view: tuple[float, float] | None = None,
    edges: bool | None = None,
    limit: float | None = None,
    columns: int = 4,
    title: str = "",
) -> Path:
    """Write a PNG file with a picture of each subject, all seen from one side, in one style with one scale.

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
    edges
        Whether edges of patches are drawn; None for where the style wants it.
    limit
        Upper limit of the scale; None for one that suits all pictures.
    columns
        Pictures in a row, at most.
    title
        Above the whole figure.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    points = [facets_of(one.surface, 4000).points for one in subjects]
    everything = np.concatenate(points)
    camera = Camera.around(everything[np.isfinite(everything).all(axis=-1)], *(view or ()))
    looks = [look(one.surface, style, size, camera, one.exact) for one in subjects]
    scale = common_scale(looks, style)
    if limit is not None:
        scale = Scale(-limit if scale.low < 0.0 else 0.0, limit)
    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        figure = draw_figure(subjects, looks, style, scale, edges=edges, columns=columns, title=title)
        FigureCanvasAgg(figure)
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(stream.getvalue())
    return path


def draw_figure(
    subjects: Sequence[Subject],
    looks: Sequence[Look],
    style: Style,
    scale: Scale,
    *,
    edges: bool | None,
    columns: int,
    title: str,
) -> "Figure":
    """Return the figure of surfaces as seen."""
    from matplotlib.figure import Figure

    rows = -(-len(subjects) // columns)
    columns = -(-len(subjects) // rows)
    side, strip = looks[0].sights.size / DPI, _strip(looks)
    tall = (strip[1] - strip[0]) / DPI
    beside = BESIDE if style in (*LABELS, "jump", "patches") else 0.0
    lines = textwrap.wrap(title, _letters(columns * side + beside))
    head = 0.12 + 0.2 * len(lines)
    width, height = columns * side + beside, rows * (tall + ABOVE + BELOW) + head
    figure = Figure(figsize=(width, height))
    if title:
        figure.text(0.08 / width, 1.0 - 0.1 / height, "\n".join(lines), va="top", fontsize=10)
    widest = rounded_up(max((float(np.nanmax(one.lines.angle_deg, initial=0.0)) for one in looks), default=0.0))
    for number, (subject, one) in enumerate(zip(subjects, looks, strict=True)):
        row, column = divmod(number, columns)
        bottom = height - head - (row + 1) * (tall + ABOVE + BELOW) + BELOW
        axes = figure.add_axes((column * side / width, bottom / height, side / width, tall / height))
        _paint(axes, one, style, scale, widest, edges=edges)
        axes.set_ylim(strip[1], strip[0])
        _ruler(axes, one, strip[1])
        name = "\n".join(textwrap.wrap(subject.title, int(side * 12.5))[:2])
        figure.text((column + 0.5) * side / width, (bottom + tall + 0.06) / height, name, ha="center", fontsize=9)
        remark = _remark(style, one, subject)
        figure.text(
            (column + 0.5) * side / width, (bottom - 0.06) / height, remark, ha="center", va="top", fontsize=7.5
        )
    if beside:
        bar = min(tall, 3.0)
        box = ((columns * side + 0.22) / width, 1 - (head + ABOVE + 0.5 * (tall + bar)) / height, 0.16 / width)
        _legend(figure, (*box, bar / height), style, scale, widest)
    return figure


def _paint(axes: "Axes", one: Look, style: Style, scale: Scale, widest: float, *, edges: bool | None) -> None:
    from matplotlib.collections import LineCollection

    size = one.sights.size
    axes.imshow(pixels(one, style, scale), extent=(0, size, size, 0), interpolation="none")
    axes.set_axis_off()
    if style == "jump":
        angle = np.nan_to_num(one.lines.angle_deg, nan=0.0)
        bent = angle > SMOOTH_DEG
        colours = palette(style)[(angle[bent] / widest * 255).clip(0, 255).astype(np.int64)]
        axes.add_collection(LineCollection(list(one.lines.ends[~bent]), colors=[(0.6, 0.6, 0.62)], linewidths=0.4))
        axes.add_collection(LineCollection(list(one.lines.ends[bent]), colors=colours, linewidths=1.6))
    elif edges or (edges is None and style == "patches"):
        axes.add_collection(LineCollection(list(one.lines.ends), colors=[EDGE_COLOUR], linewidths=EDGE_WIDTH))
    axes.set_xlim(0, size)


def _letters(inches: float) -> int:
    """Letters of a title that fit into a line."""
    return max(20, int(inches * 11.5))


def _strip(looks: Sequence[Look]) -> tuple[int, int]:
    """The rows of pixels, from the first to before the last, that hold all the surfaces and a ruler below them."""
    size = looks[0].sights.size
    rows = np.concatenate([one.sights.pixel // size for one in looks])
    first, last = (int(rows.min()), int(rows.max())) if len(rows) else (0, size - 1)
    return max(0, first - size // 40), min(size, max(last, first + size // 3) + size // 11)


def _ruler(axes: "Axes", one: Look, bottom: int) -> None:
    """A length of about a fifth of the picture, with its number."""
    size, width = one.sights.size, one.camera.width
    length = rounded_up(width / 7.0)
    left, low = 0.03 * size, bottom - 0.02 * size
    axes.plot([left, left + length / width * size], [low, low], color="#444444", linewidth=1.4, solid_capstyle="butt")
    axes.text(left, low - 0.012 * size, f"{length:g}", fontsize=7, color="#444444", va="bottom")


def _remark(style: Style, one: Look, subject: Subject) -> str:
    """What stands below a picture: the range of what is seen, or what there is to say."""
    if style == "jump":
        known = one.lines.angle_deg[np.isfinite(one.lines.angle_deg)]
        return f"largest angle seen: {known.max():.3g}°" if len(known) else "one patch: nothing joins"
    if style in EXACT and subject.exact is None:
        return "no exact surface"
    if style in LABELS:
        values = mapped(style, one.fields)
        known = values[np.isfinite(values)]
        return f"seen: {known.min():.3g} to {known.max():.3g}" if len(known) else "no values"
    faces = len(subject.surface.mesh.faces)
    return f"{faces} face{'s' * (faces != 1)}, {subject.surface.patch_count} patches"


def _legend(figure: "Figure", box: tuple[float, ...], style: Style, scale: Scale, widest: float) -> None:
    from matplotlib.patches import Patch

    if style == "patches":
        names = ("on a face", "beside the faces")
        handles: list[Any] = [
            Patch(facecolor=tuple(colour), edgecolor="#555555", linewidth=0.5, label=name)
            for colour, name in zip(PATCHES, names, strict=False)
        ]
        figure.legend(
            handles=handles, loc="center left", bbox_to_anchor=(box[0] - 0.01, box[1] + box[3] / 2), fontsize=8
        )
        return
    axes = figure.add_axes(box)  # type: ignore[arg-type]  # a tuple of four
    low, high = (0.0, widest) if style == "jump" else (scale.low, scale.high)
    axes.imshow(palette(style)[::-1, None], extent=(0, 1, low, high), aspect="auto", interpolation="nearest")
    axes.set_xticks([])
    axes.yaxis.tick_right()
    axes.yaxis.set_label_position("right")
    axes.tick_params(labelsize=8)
    label = "angle between normals (degrees)" if style == "jump" else LABELS[style]
    axes.set_ylabel(label, fontsize=8)
    if style != "jump":
        axes.set_xlabel("striped:\nbeyond", fontsize=7)


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
