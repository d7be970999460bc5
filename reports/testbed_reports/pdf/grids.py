"""Tables of many columns: as wide as their numbers, and in as many parts as the page asks for."""

from collections.abc import Iterator, Sequence

from testbed_reports.formatting import counted
from testbed_reports.pdf import widths
from testbed_reports.pdf.blocks import Cell, Column, Name, Table, runs

#: Rows that stand for a scheme that has no numbers.
Trouble = str


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
    """
    wide = [
        widths.of_column(heading, [row[column] for row in rows if len(row) > column], size)
        for column, heading in enumerate(headings)
    ]
    found = widths.parts(wide, room - first_width) or [range(0)]
    for number, part in enumerate(found):
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
        yield Table(
            label if number == 0 else f"{label}-{number}",
            runs(told),
            (Column(width=first_width), *(Column("right", wide[column]) for column in part)),
            tuple(head),
            body,
            size,
        )


def _row(first: str | Cell, row: Sequence[str | Cell], part: range, trouble: str) -> tuple[str | Cell, ...]:
    if trouble:
        return (first, Cell(runs(trouble), max(len(part), 1), "left"))
    return (first, *(row[column] for column in part))


def _over(groups: Sequence[tuple[str, int]], part: range) -> list[tuple[str, int]]:
    """The headings over the columns of a part."""
    found, start = [], 0
    for text, width in groups:
        span = len(range(max(start, part.start), min(start + width, part.stop)))
        if span:
            found.append((text, span))
        start += width
    return found
