"""Plots as SVG that stands in a page: same data, same bytes; through matplotlib's objects, without its global state."""

import io
import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from testbed_reports.panels import Panel
from testbed_reports.styles import Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Inches. The page scales a plot to its column; the letters then have the size of the page's small print.
SIZE: Final = (3.3, 2.75)
SETTINGS: Final[Mapping[Any, Any]] = {
    "svg.fonttype": "none",  # text stays text: small, searchable, in the page's font
    "svg.hashsalt": "surface-testbed",
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "lines.linewidth": 1.2,
    "lines.markersize": 5.0,
    "path.simplify": False,
}
#: A logarithmic axis does not go farther below its largest value than by this factor.
LEAST: Final = 1e-25
#: Curvatures within this many times their median are drawn on a linear axis.
LINEAR: Final = 12.0
_SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def draw(panels: tuple[Panel, ...], styles: Sequence[Style], prefix: str) -> tuple[str, ...]:
    """Return an ``<svg>`` element for each panel.

    Parameters
    ----------
    panels
        What to draw.
    styles
        The style of each scheme, by its position in the plan.
    prefix
        Begins the ids in the elements; keep it unique within a page.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    drawn = []
    with mpl.rc_context():
        mpl.rcdefaults()  # a user's settings would change the bytes
        mpl.rcParams.update(SETTINGS)
        for number, panel in enumerate(panels):
            figure = Figure(figsize=SIZE, layout=None)
            FigureCanvasSVG(figure)
            # fixed margins: a layout engine draws everything once more to measure it
            axes = figure.add_axes((0.19, 0.165, 0.79, 0.745))
            _fill(axes, panel, styles)
            stream = io.StringIO()
            nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
            figure.savefig(stream, format="svg", metadata=nothing, transparent=True)
            drawn.append(embeddable(stream.getvalue(), f"{prefix}-{number}"))
    return tuple(drawn)


def embeddable(svg: str, prefix: str) -> str:
    """Return the ``<svg>`` element of a file: without prologue, metadata and size, its ids unique in a page."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    head, rest = svg.split(">", 1)
    view = re.search(r'viewBox="[^"]*"', head)
    pointed = set(re.findall(r'(?:href="|url\()#([^")]+)', rest))
    rest = re.sub(r' id="([^"]*)"', lambda match: f' id="{prefix}-{match[1]}"' if match[1] in pointed else "", rest)
    rest = re.sub(r'(href="|url\()#', rf"\1#{prefix}-", rest).replace("xlink:href", "href")
    rest = re.sub(r"<!--.*?-->\s*|(?<=>)\s*\n\s*(?=<)", "", rest, flags=re.DOTALL)
    return f'<svg {view[0] if view else ""} aria-hidden="true">{rest.strip()}'


def _fill(axes: "Axes", panel: Panel, styles: Sequence[Style]) -> None:
    axes.set_title(panel.title)
    axes.set_xlabel("longest edge h (length)", labelpad=2.0)
    axes.set_ylabel(panel.label)
    axes.yaxis.set_label_coords(-0.165, 0.5)  # the same on every plot, however long the numbers
    axes.grid(visible=True, color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    values = list(panel.values)
    _length_axis(axes, list(panel.lengths))
    if panel.logarithmic:
        _power_axis(axes, max(values[0], LEAST * values[-1]), values[-1])
        _references(axes, panel)
    else:
        _signed_axis(axes, values, panel.rounding)
    if panel.band:
        lengths, least, most = zip(*panel.band, strict=True)
        axes.fill_between(lengths, least, most, color="#e9e9e9", linewidth=0, zorder=0.6)
    for line in panel.lines:
        look = styles[line.position]
        dashes = (0, (3.0, 1.5)) if line.dashed else "solid"
        axes.plot(line.h, line.values, color=look.colour, linestyle=dashes, zorder=2.5)
        for filled in (True, False):
            chosen = [used is filled for used in line.used]
            if any(chosen):
                axes.plot(
                    [h for h, wanted in zip(line.h, chosen, strict=True) if wanted],
                    [value for value, wanted in zip(line.values, chosen, strict=True) if wanted],
                    color=look.colour,
                    linestyle="none",
                    marker=look.marker,
                    markerfacecolor=look.colour if filled and not line.dashed else "white",
                    zorder=3.0,
                )


def _length_axis(axes: "Axes", lengths: list[float]) -> None:
    """Logarithmic, with ticks at the levels' own lengths as far as they leave room for each other."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    axes.set_xscale("log")
    margin = 1.25
    axes.set_xlim(lengths[0] / margin**2, lengths[-1] * margin)
    apart = (math.log(lengths[-1] / lengths[0]) + 3.0 * math.log(margin)) / 7.0
    ticks: list[float] = []
    for length in reversed(lengths):
        if not ticks or math.log(ticks[-1] / length) >= apart:
            ticks.append(length)
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(FixedFormatter([f"{tick:.2g}" for tick in ticks]))
    axes.xaxis.set_minor_locator(NullLocator())


def _power_axis(axes: "Axes", least: float, most: float) -> None:
    """Logarithmic, with powers of ten."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    axes.set_yscale("log")
    most = max(most, least)
    decades = max(math.log10(most / least), 0.5)
    low, high = math.log10(least) - 0.07 * decades - 0.1, math.log10(most) + 0.07 * decades + 0.1
    axes.set_ylim(10.0**low, 10.0**high)
    step = max(1, math.ceil((high - low) / 7.0))
    powers = [power for power in range(math.ceil(low), math.floor(high) + 1) if power % step == 0]
    axes.yaxis.set_major_locator(FixedLocator([10.0**power for power in powers]))
    axes.yaxis.set_major_formatter(FixedFormatter([_power(power) for power in powers]))
    axes.yaxis.set_minor_locator(NullLocator())


def _power(power: int) -> str:
    return "1" if power == 0 else "10" if power == 1 else "10" + str(power).translate(_SUPERSCRIPTS)


def _signed_axis(axes: "Axes", values: list[float], rounding: float) -> None:
    """Linear, or where a few values dwarf the others logarithmic on both sides of a linear middle."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter, MaxNLocator, NullLocator

    sizes = sorted(abs(value) for value in values if abs(value) > rounding)
    if not sizes:
        reach = max(rounding, LEAST)
        axes.set_ylim(-reach, reach)
        axes.yaxis.set_major_locator(FixedLocator([0.0]))
        axes.yaxis.set_major_formatter(FixedFormatter(["0"]))
        return
    usual, largest = sizes[len(sizes) // 2], sizes[-1]
    if largest <= LINEAR * usual:
        axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−")))
        low, high = values[0], max(values[-1], values[0] + rounding)
        axes.set_ylim(low - 0.07 * (high - low), high + 0.07 * (high - low))
        return
    middle = 10.0 ** math.floor(math.log10(usual))
    axes.set_yscale("symlog", linthresh=middle, linscale=1.0)
    decades = range(round(math.log10(middle)), math.ceil(math.log10(largest)) + 1)
    decades = decades[:: max(1, math.ceil(len(decades) / 5))]
    ticks = [0.0] + [sign * 10.0**power for power in decades for sign in (-1.0, 1.0)]
    ticks = [tick for tick in sorted(ticks) if min(values[0], 0.0) * 1.5 <= tick <= max(values[-1], 0.0) * 1.5]
    labels = [_signed(tick) for tick in ticks]
    axes.set_ylim(min(values[0] * 1.6, -0.2 * middle), max(values[-1] * 1.6, 0.2 * middle))
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_major_formatter(FixedFormatter(labels))
    axes.yaxis.set_minor_locator(NullLocator())


def _signed(tick: float) -> str:
    """Return a power of ten with its sign, or zero."""
    sign = "−" if tick < 0.0 else ""
    return sign + _power(round(math.log10(abs(tick)))) if tick else "0"


def _references(axes: "Axes", panel: Panel) -> None:
    """Draw slopes for comparison, and the band of values that count as none."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    if panel.smooth is not None and bottom < panel.smooth:
        axes.axhspan(bottom, min(panel.smooth, top), color="#f0f0f0", zorder=0.5, linewidth=0)
        # at the end of the band where the finest level's values leave more room
        ceiling = min(panel.smooth, top)
        within = [line.values[-1] for line in panel.lines if line.values[-1] <= ceiling]
        above = math.log(ceiling / max(within, default=bottom)) > math.log(min(within, default=ceiling) / bottom)
        height, side = (ceiling / 1.5, "top") if above else (bottom * 1.2, "bottom")
        axes.text(left * 1.04, height, "counts as none", color="#555555", fontsize=7.5, va=side)
    end, *_, start = (*panel.lengths[:1], *panel.lengths)
    if end == start:
        return
    anchor = panel.values[-1]
    for slope in panel.slopes:
        # to the finest level, or as far down as the axis goes
        h = max(end, start * (bottom * (top / bottom) ** 0.05 / anchor) ** (1.0 / slope))
        value = anchor * (h / start) ** slope
        axes.plot([start, h], [anchor, value], color="#8a8a8a", linewidth=0.8, linestyle=(0, (1.0, 2.0)), zorder=1.5)
        axes.annotate(
            "h" + str(slope).translate(_SUPERSCRIPTS),
            (h, value),
            xytext=(-3.0, 0.0),
            textcoords="offset points",
            color="#555555",
            fontsize=8.0,
            ha="right",
            va="center",
        )
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
