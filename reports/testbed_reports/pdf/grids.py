"""Tables of many columns: as wide as their numbers, and in as many parts as the page asks for."""

from collections.abc import Iterator, Sequence
from typing import Final

from testbed_reports.formatting import counted
from testbed_reports.pdf import widths
from testbed_reports.pdf.blocks import Cell, Column, Name, Table, runs

#: Rows that are set together, at most: a typesetter's cell costs more than its number.
BAND: Final = 8


def named(names: Sequence[str], size: float) -> float:
    """Return the width of a column of schemes with their swatches."""
    return widths.of_names(names, size)


def numbers(
    label: str,
    caption: str,
    firsts: Sequence[str | Cell],
    first_width: float,
    headings: Sequence[str],
    rows: Sequence[Sequence[str | Cell]],
    room: float,
    size: float,
    *,
    first: str = "scheme",
    groups: Sequence[tuple[str, int]] = (),
    troubles: Sequence[str] | None = None,
    names: bool = False,
    together: bool = False,
    repeated: int = 0,
) -> Iterator[Table]:
    """Yield a table, in parts where it is wider than the page; every part begins with the first column.

    Parameters
    ----------
    label, caption
        Of the table; parts after the first have a number each.
    firsts, first_width, first
        Cells of the first column, its width in points, and its heading.
    headings, rows
        Of the other columns.
    room
        Width of the page in points.
    size
        Of the type, in points.
    groups
        Headings over neighbouring columns, each with the number of columns.
    troubles
        For each row why it has no numbers, or nothing.
    names
        Whether the headings are columns of the results, to be read letter by letter.
    together
        Whether neighbouring rows with the same first cell are set together, under that cell.
    repeated
        How many of the other columns every part begins with.
    """
    wide = [
        widths.of_column(heading, [row[column] for row in rows if len(row) > column], size)
        for column, heading in enumerate(headings)
    ]
    kept = range(repeated)
    found = widths.parts(wide[repeated:], room - first_width - sum(wide[:repeated])) or [range(0)]
    for number, others in enumerate(found):
        part = [*kept, *(column + repeated for column in others)]
        head: list[tuple[str | Cell, ...]] = []
        over = _over(groups, part)
        if any(text for text, _ in over):
            head.append(("", *(Cell(runs(text), span, "center") for text, span in over)))
        titles = [Cell(runs(Name(headings[column])), align="right") if names else headings[column] for column in part]
        head.append((first, *titles))
        body = tuple(
            _row(firsts[place], row, part, troubles[place] if troubles else "") for place, row in enumerate(rows)
        )
        told = caption if len(found) == 1 else f"{caption} Part {number + 1} of {counted(len(found), 'part')}."
        columns = (Column(width=first_width), *(Column("right", wide[column]) for column in part))
        name = label if number == 0 else f"{label}-{number}"
        if together:
            sizes = _runs_of(firsts)
            yield Table(name, runs(told), columns, tuple(head), _once(body, sizes), size, sizes)
        else:
            yield Table(name, runs(told), columns, tuple(head), body, size, bands(body, columns, size))


def bands(rows: Sequence[Sequence[str | Cell]], columns: Sequence[Column], size: float) -> tuple[int, ...]:
    """Return how many rows of a table are set together: up to :data:`BAND` neighbours of one line each."""
    found: list[int] = []
    filling = False
    for row in rows:
        plain = len(row) == len(columns) and all(
            widths.is_line(cell, column.width, size) for cell, column in zip(row, columns, strict=True)
        )
        if plain and filling and found[-1] < BAND:
            found[-1] += 1
        else:
            found.append(1)
        filling = plain
    return tuple(found)


def _runs_of(firsts: Sequence[str | Cell]) -> tuple[int, ...]:
    """How many neighbours are the same, one after the other."""
    found: list[int] = []
    for place, one in enumerate(firsts):
        if place and one == firsts[place - 1]:
            found[-1] += 1
        else:
            found.append(1)
    return tuple(found)


def _once(rows: Sequence[tuple[str | Cell, ...]], sizes: Sequence[int]) -> tuple[tuple[str | Cell, ...], ...]:
    """Rows whose first cell stands in the first of each run only."""
    found: list[tuple[str | Cell, ...]] = []
    for size in sizes:
        run = rows[len(found) : len(found) + size]
        found += [run[0], *(("", *row[1:]) for row in run[1:])]
    return tuple(found)


def _row(first: str | Cell, row: Sequence[str | Cell], part: Sequence[int], trouble: str) -> tuple[str | Cell, ...]:
    if trouble:
        return (first, Cell(runs(trouble), max(len(part), 1), "left"))
    return (first, *(row[column] for column in part))


def _over(groups: Sequence[tuple[str, int]], part: Sequence[int]) -> list[tuple[str, int]]:
    """The headings over the columns of a part."""
    found, start = [], 0
    for text, width in groups:
        span = sum(start <= column < start + width for column in part)
        if span:
            found.append((text, span))
        start += width
    return found
