"""How wide tables are: columns as wide as their numbers, and tables that are too wide for a page in parts."""

from collections.abc import Sequence
from typing import Final

from testbed_reports.pdf import lettering
from testbed_reports.pdf.blocks import Break, Cell, Link, Name, Run, Small, Strong, Swatch, Verdict

#: Width of a letter over the size of the type: of digits and words, of words that stand out, and of names.
LETTER: Final = 0.47
NAMES: Final = 0.53
#: Width of the narrowest column over the size of the type: wide letters, as in NaN, are exceptions.
LEAST: Final = 2.0
#: What a column needs beside its text, in points.
GUTTER: Final = 6.0
#: The widest column of names, and of numbers, in points; longer ones take several lines.
WIDEST_NAME: Final = 130.0
WIDEST: Final = 150.0
#: Letters of the heading of a column of names.
SHORT: Final = 8
#: Width of a swatch, in points.
SWATCH: Final = 17.0


def of_names(names: Sequence[str], size: float, *, swatch: bool = True) -> float:
    """Return the width in points of a column of names, or of its heading, a short word."""
    longest = max(SHORT, *(len(lettering.printable(name)) for name in names), 0)
    return min(longest * NAMES * size + (SWATCH if swatch else 0.0), WIDEST_NAME) + GUTTER


def of_column(heading: str, cells: Sequence[str | Cell], size: float) -> float:
    """Return the width in points that numbers and the longest word of a heading need."""
    words = max((len(word) for word in lettering.name(heading).replace(lettering.BREAK, " ").split()), default=0)
    return min(max([words * LETTER * size, LEAST * size, *(_width(cell, size) for cell in cells)]), WIDEST) + GUTTER


def _width(cell: str | Cell, size: float) -> float:
    if isinstance(cell, str):
        return len(cell) * LETTER * size
    if cell.span > 1:
        return 0.0
    lines = [0.0]
    for run in cell.runs:
        if isinstance(run, Break) or (isinstance(run, Small) and run.apart):
            lines.append(0.0)
        lines[-1] += _length(run, size)
    return max(lines)


def is_line(cell: str | Cell, width: float, size: float) -> bool:
    """Whether a cell takes one line of a column."""
    if isinstance(cell, str):
        return len(cell) * LETTER * size <= width
    if cell.span > 1 or any(isinstance(run, Break) or (isinstance(run, Small) and run.apart) for run in cell.runs):
        return False
    return sum(_length(run, size) for run in cell.runs) + GUTTER <= width


def _length(run: Run, size: float) -> float:
    """Width in points of a run that is not broken."""
    match run:
        case Break():
            return 0.0
        case Swatch():
            return SWATCH
        case Verdict(word=False):
            return size
        case Verdict():
            return size + len(run.text) * size * LETTER
        case Name() | Link():
            return len(lettering.printable(run.text)) * size * NAMES
        case Small():
            return len(run.text) * 0.8 * size * LETTER
        case Strong():
            return len(run.text) * 1.06 * size * LETTER
        case _:
            return len(run.text) * size * LETTER


def parts(widths: Sequence[float], room: float) -> list[range]:
    """Return runs of neighbouring columns that fit into a room, as few as can be and about equally wide."""
    if not widths:
        return []
    fewest = len(_filled(widths, room))
    total, widest = sum(widths), max(widths)
    for share in range(1, 21):
        found = _filled(widths, max(widest, total / fewest * (1.0 + share / 20.0)))
        if len(found) <= fewest:
            return (
                found
                if all(sum(widths[column] for column in part) <= room for part in found)
                else _filled(widths, room)
            )
    return _filled(widths, room)


def _filled(widths: Sequence[float], room: float) -> list[range]:
    """Fill one part after the other; a column that is wider than the room has a part of its own."""
    found, start, used = [], 0, 0.0
    for column, width in enumerate(widths):
        if column > start and used + width > room:
            found.append(range(start, column))
            start, used = column, 0.0
        used += width
    return [*found, range(start, len(widths))]
