"""How wide tables are: columns as wide as their numbers, and tables that are too wide for a page in parts."""

from collections.abc import Sequence
from typing import Final

from testbed_reports.pdf import lettering
from testbed_reports.pdf.blocks import Cell, Small, Strong, Text

#: Width of a letter over the size of the type: of digits and words, of words that stand out, and of names.
LETTER: Final = 0.5
NAMES: Final = 0.53
#: What a column needs beside its text, in points.
GUTTER: Final = 6.0
#: The widest column of names, in points; longer ones take several lines.
WIDEST_NAME: Final = 130.0
#: Width of a swatch, in points.
SWATCH: Final = 17.0


def of_names(names: Sequence[str], size: float, *, swatch: bool = True) -> float:
    """Return the width in points of a column of names."""
    longest = max((len(lettering.printable(name)) for name in names), default=0)
    return min(longest * NAMES * size + (SWATCH if swatch else 0.0), WIDEST_NAME) + GUTTER


def of_column(heading: str, cells: Sequence[str | Cell], size: float) -> float:
    """Return the width in points that numbers and the longest word of a heading need."""
    words = max((len(word) for word in lettering.name(heading).replace(lettering.BREAK, " ").split()), default=0)
    return max([words * LETTER * size, *(_width(cell, size) for cell in cells)]) + GUTTER


def _width(cell: str | Cell, size: float) -> float:
    if isinstance(cell, str):
        return len(cell) * LETTER * size
    if cell.span > 1:
        return 0.0
    sizes = [
        (run.text, 0.8 * size if isinstance(run, Small) else 1.06 * size)
        for run in cell.runs
        if isinstance(run, Text | Strong | Small)
    ]
    # a place below a number breaks between its words
    lengths = [max(map(len, text.split()), default=0) if letters < size else len(text) for text, letters in sizes]
    return max((length * LETTER * letters for length, (_, letters) in zip(lengths, sizes, strict=True)), default=0.0)


def parts(widths: Sequence[float], room: float) -> list[range]:
    """Return runs of neighbouring columns that fit into a room, about equally wide and as few as can be."""
    total = sum(widths)
    count = 1
    while True:
        found = _filled(widths, room, total / count)
        if len(found) <= count or count >= len(widths):
            return found
        count += 1


def _filled(widths: Sequence[float], room: float, target: float) -> list[range]:
    found, start, used = [], 0, 0.0
    for column, width in enumerate(widths):
        over = used + width > room or (used + 0.5 * width > target and used > 0.0)
        if column > start and over:
            found.append(range(start, column))
            start, used = column, 0.0
        used += width
    return [*found, range(start, len(widths))] if len(widths) else []
