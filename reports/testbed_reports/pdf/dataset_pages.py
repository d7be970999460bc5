"""The chapter of the datasets: of each its surfaces, a table of the schemes at one level, and plots."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from testbed_reports.formatting import shorten
from testbed_reports.pdf import lettering
from testbed_reports.pdf.blocks import (
    LYING,
    Bar,
    Block,
    Folio,
    Heading,
    Name,
    Paragraph,
    Picture,
    Pictures,
    Plots,
    Reference,
    Run,
    runs,
    value,
)
from testbed_reports.pdf.figures import Figures, picture_file, plot_file
from testbed_reports.pdf.grids import named, numbers
from testbed_reports.pdf.opening import dataset_label, scheme
from testbed_reports.pdf.strips import Shot, Strip
from testbed_reports.rendering.colouring import palette
from testbed_reports.view import Page, Section

#: Pictures in a row: the fewest that let all stand on a page, and no more.
IN_ROW: Final = range(7, 11)
#: Points that a title and a remark take besides their picture, and the words around the rows.
LETTERED: Final = 27.0
WORDS: Final = 140.0
#: Characters of titles and remarks of pictures.
TITLE: Final = 54
REMARK: Final = 130
#: Characters of a name in the key to plots.
KEY: Final = 90
#: Colours of a bar.
STOPS: Final = 33


def datasets(page: Page, drawn: Sequence[Figures]) -> Iterator[Folio]:
    """Yield the pages of each dataset."""
    for number, section in enumerate(page.sections):
        chapter = () if number else (Heading(1, runs("Datasets"), "datasets"),)
        yield Folio((*chapter, *_dataset(section, number, drawn[number])), lying=True)


def _dataset(section: Section, number: int, drawn: Figures) -> Iterator[Block]:
    yield Heading(2, runs(f"{section.dataset.title} ", Name(section.dataset.spec)), dataset_label(number))
    parts: list[str | Run] = [f"{section.closed.capitalize()}. {section.dataset.reference}."]
    if section.remark:
        parts.append(f" {section.remark}")
    figures = list(_strips(section, number, drawn))
    pointers: list[str | Run] = []
    if figures:
        pointers += [" Surfaces: ", Reference(figures[0].label), "."]
    if section.table:
        pointers += [" Schemes compared: ", Reference(f"compared-{number}"), "."]
    if section.drawings:
        pointers += [" Convergence: ", Reference(f"plots-{number}-0"), "."]
    if section.levels.rows:
        pointers += [" All numbers: ", Reference(f"numbers-of-{number}"), "."]
    yield Paragraph(runs(*parts, *pointers))
    if drawn.reason:
        yield Paragraph(runs(f"There are no pictures of the surfaces: {drawn.reason}."))
    yield from figures
    yield from _compared(section, number)
    yield from _plots(section, number)


def _strips(section: Section, number: int, drawn: Figures) -> Iterator[Pictures]:
    if drawn.strip is None or not any(shot.images for shot in drawn.strip.shots):
        return
    strip, name = drawn.strip, section.dataset.spec
    columns, count = _arranged(len(strip.shots), strip.aspect)
    length = f"Width of a picture: {strip.length:.3g}."
    high = _limit(strip.limit)
    curved = (
        f"Gaussian curvature of the surfaces on {name}, level {strip.level}, from {_limit(-strip.limit)} (blue) over "
        f"zero (grey) to {high} (red), the same scale for all; striped: beyond it. Below each picture the range "
        "that is seen."
    )
    shaded = f"Surfaces on {name}, level {strip.level}, shaded, all seen from one side. {length}"
    for style, (key, caption) in enumerate((("shaded", shaded), ("curved", curved))):
        for part, start in enumerate(range(0, len(strip.shots), count)):
            some = range(start, min(start + count, len(strip.shots)))
            told = caption if len(strip.shots) <= count else f"{caption} Schemes {start + 1} to {some.stop}."
            yield Pictures(
                f"{key}-{number}-{part}",
                runs(told),
                tuple(_picture(strip.shots[place], number, place, style) for place in some),
                columns,
                strip.aspect,
                _bar(strip) if style else None,
            )


def _arranged(count: int, aspect: float) -> tuple[int, int]:
    """Return how many pictures stand in a row and on a page."""
    columns = rows = 1
    for columns in IN_ROW:
        rows = max(1, int((LYING[1] - WORDS) / (LYING[0] / columns * aspect + LETTERED)))
        if rows * columns >= count:
            break
    return max(min(columns, count), 4), rows * columns


def _picture(shot: Shot, number: int, place: int, style: int) -> Picture:
    title = lettering.shortened(shot.scheme, TITLE)
    if not shot.images:
        return Picture(title, "", lettering.shortened(shot.reason, REMARK))
    remark = ""
    if style and shot.least is not None and shot.most is not None:
        remark = f"{_limit(shot.least)} to {_limit(shot.most)}"
    return Picture(title, picture_file(number, place, style), remark)


def _limit(value: float) -> str:
    return lettering.number(f"{value:.3g}" if math.isfinite(value) else shorten(value))


def _bar(strip: Strip) -> Bar:
    colours = tuple("#" + "".join(f"{round(255 * part):02x}" for part in colour) for colour in palette("gauss", STOPS))
    return Bar(colours, _limit(-strip.limit), "0", _limit(strip.limit), "Gaussian curvature K (1/length²)")


def _compared(section: Section, number: int) -> Iterator[Block]:
    table = section.table
    if table is None:
        yield Paragraph(runs("No cell of this dataset is ok: the appendix says why."))
        return
    size = 7.0
    size_in_words = f", {section.size}" if section.size else ""
    pair = ", of curvatures the pair closest together" if section.constant else ""
    caption = (
        f"Schemes on {section.dataset.spec}, level {section.level}{size_in_words}. Bold: best of its column{pair}; "
        "values that read the same are equally good, and where most are, none is marked."
    )
    names = [row.scheme for row in table.rows]
    yield from numbers(
        f"compared-{number}",
        caption,
        [scheme(row.position, row.scheme, linked=True) for row in table.rows],
        named(names, size),
        [heading for heading, _ in table.headings],
        [() if row.trouble else tuple(value(entry, place=False) for entry in row.entries) for row in table.rows],
        LYING[0],
        size,
        groups=table.groups,
        troubles=[row.trouble for row in table.rows],
    )
    noted = [
        (row.scheme, entry.place)
        for row in table.rows
        for (heading, _), entry in zip(table.headings, row.entries, strict=False)
        if entry.place and heading == "fall\N{SOFT HYPHEN}backs"
    ]
    if noted:
        told = "; ".join(f"{who}: {what}" for who, what in noted)
        yield Paragraph(runs(f"Fallbacks taken: {told}."), small=True)


def _plots(section: Section, number: int) -> Iterator[Block]:
    name = section.dataset.spec
    for group, drawing in enumerate(section.drawings):
        title = f": {drawing.title}" if drawing.title else ""
        caption = (
            f"The schemes on {name} over the longest edge{title}. Filled: levels in the fit of the order; hollow: "
            "left out of it. Dotted: slopes for reference. Curvature: largest values filled on a full line, smallest "
            "hollow on a dashed one."
        )
        if drawing.title:
            caption += " Grey: the range of all schemes, on the same axes in each group."
        for panel in drawing.panels:
            if panel.zeros:
                caption += f" {panel.title} is 0 and not drawn on a level for {', '.join(panel.zeros)}."
        yield Plots(
            f"plots-{number}-{group}",
            runs(caption),
            tuple(plot_file(number, group, panel) for panel in range(len(drawing.panels))),
            tuple((position, lettering.shortened(text, KEY)) for position, text in drawing.schemes),
            f"{', '.join(panel.title for panel in drawing.panels)} of the schemes on {name} over the longest edge",
        )
