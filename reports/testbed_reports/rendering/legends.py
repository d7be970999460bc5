"""Legends beside pictures: the scale of a map, the kinds of patches, colours with names."""

from typing import TYPE_CHECKING, Any, Final, TypeAlias

from testbed_reports.rendering.colouring import LABELS, PATCHES, Scale, Style, palette

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: A name and its colour.
Key: TypeAlias = tuple[str, tuple[float, float, float]]
#: Styles that need a legend.
KEYED: Final = (*LABELS, "jump", "patches")
#: What the colours of ``patches`` mean.
KINDS: Final[tuple[Key, ...]] = tuple(
    (name, (float(r), float(g), float(b)))
    for name, (r, g, b) in zip(("on a face", "beside the faces"), PATCHES, strict=False)
)


def draw_legend(
    figure: "Figure",
    box: tuple[float, float, float, float],
    style: Style,
    scale: Scale,
    widest: float,
    key: tuple[Key, ...] = (),
    heading: str = "",
) -> None:
    """Draw the legend of a style.

    Parameters
    ----------
    figure
        The figure.
    box
        Left, bottom, width and height of the colour bar, as shares of the figure.
    style, scale
        The colouring and its limits.
    widest
        Upper limit of angles between normals, degrees.
    key
        Names and colours in its place; what ``patches`` has.
    heading
        What stands above names.
    """
    if style == "patches" or key:
        _names(figure, box, key or KINDS, heading)
        return
    axes = figure.add_axes(box)
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


def _names(figure: "Figure", box: tuple[float, float, float, float], key: tuple[Key, ...], heading: str) -> None:
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(facecolor=colour, edgecolor="#555555", linewidth=0.5, label=name) for name, colour in key
    ]
    figure.legend(
        handles=handles,
        loc="center left",
        bbox_to_anchor=(box[0], box[1] + box[3] / 2),
        fontsize=7.5,
        title=heading or None,
        title_fontsize=7.5,
        alignment="left",
        handlelength=1.2,
        borderaxespad=0.0,
        frameon=False,
    )
