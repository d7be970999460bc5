"""The appendix: every number of every cell, every order, what was refused or failed and why, sources."""

from collections.abc import Iterator, Sequence
from typing import Final

from testbed_reports.formatting import NOTHING, Entry, counted
from testbed_reports.orders import OrderRow
from testbed_reports.pdf import lettering, widths
from testbed_reports.pdf.blocks import (
    LYING,
    Block,
    Cell,
    Column,
    Heading,
    Link,
    Name,
    Paragraph,
    Quotation,
    Sheet,
    Small,
    Table,
    Text,
    runs,
)
from testbed_reports.pdf.grids import named, numbers
from testbed_reports.pdf.opening import dataset_label, scheme
from testbed_reports.tables import SchemeRow
from testbed_reports.view import Page, Section

#: Significant digits of the numbers of cells.
DIGITS: Final = 5
#: Size of the type in points.
SIZE: Final = 6.0
#: Digits of a hash that are shown.
HASH: Final = 12


def appendix(page: Page) -> Iterator[Block]:
    """Yield the appendix."""
    yield Sheet(lying=True)
    yield Heading(1, runs("Appendix"), "appendix")
    yield from _troubles(page)
    yield Heading(2, runs("All numbers"), "all-numbers")
    yield Paragraph(
        runs(
            f"Numbers have {DIGITS} significant digits; ",
            Name("results.csv"),
            " has all of them. Columns that are the same for all schemes stand in a table by level.",
        ),
        small=True,
    )
    for number, section in enumerate(page.sections):
        yield from _cells(section, number)
    if any(section.orders for section in page.sections):
        yield Heading(2, runs("All orders"), "all-orders")
        for number, section in enumerate(page.sections):
            yield from _orders(section, number)
    yield Sheet(lying=False)
    yield from _meanings(page)
    yield from _hashes(page)
    yield from _traces(page)


def _troubles(page: Page) -> Iterator[Block]:
    yield Heading(2, runs("Cells that were refused or failed"), "troubles")
    found: dict[tuple[str, int, int], list[int]] = {}
    rows: dict[tuple[str, int, int], SchemeRow] = {}
    for number, section in enumerate(page.sections):
        for row in section.levels.rows:
            if row.trouble:
                key = (row.trouble, row.position, number)
                found.setdefault(key, []).append(row.level or 0)
                rows.setdefault(key, row)
    if not found:
        yield Paragraph(runs("None."))
    else:
        ordered = sorted(found.items(), key=lambda item: (item[0][1], item[0][2], item[1]))
        body = tuple(
            (
                scheme(position, rows[trouble, position, number].scheme),
                Cell(runs(Link(dataset_label(number), page.sections[number].dataset.spec))),
                " ".join(map(str, levels)),
                trouble.partition(": ")[0],
                trouble.partition(": ")[2],
            )
            for (trouble, position, number), levels in ordered
        )
        names = [rows[key].scheme for key, _ in ordered]
        sets = [section.dataset.spec for section in page.sections]
        yield Table(
            "trouble-table",
            runs("Every cell without numbers, with its reason; a row a scheme, dataset and reason."),
            (
                Column(width=named(names, 7.0)),
                Column(width=widths.of_names(sets, 7.0, swatch=False)),
                Column(width=36.0),
                Column(width=40.0),
                Column(),
            ),
            (("scheme", "dataset", "levels", "status", "reason"),),
            body,
            7.0,
        )
    if page.missing:
        yield Paragraph(runs(f"{counted(len(page.missing), 'cell')} without a result yet: {'; '.join(page.missing)}."))


def digits(entry: Entry, count: int = DIGITS) -> str:
    """Return the text of an entry with more digits, where it is a number that has them.

    >>> digits(Entry("0.123", "0.12345678; guaranteed from 0.1 to 0.2"))
    '0.12346'
    """
    try:
        number = float(entry.exact.partition(";")[0])
    except ValueError:
        return entry.text
    text = f"{number:.{count}g}"
    mantissa, power, exponent = text.partition("e")
    return lettering.number(f"{mantissa}{power}{int(exponent)}" if power else text)


def _cells(section: Section, number: int) -> Iterator[Block]:
    table, name = section.levels, section.dataset.spec
    if not table.rows:
        return
    yield Heading(3, runs("Every cell on ", Name(name)), f"cells-of-{number}")
    good = [row for row in table.rows if not row.trouble]
    shared: list[int] = []
    own: list[int] = []
    for column in range(len(table.headings)):
        (shared if _by_level(good, column) else own).append(column)
    names = [row.scheme for row in table.rows]
    headings = [heading for heading, _ in table.headings]
    yield from numbers(
        f"cells-{number}",
        f"Every cell on {name}.",
        [_first(row) for row in table.rows],
        named(names, SIZE),
        ["level", *(headings[column] for column in own)],
        [_values(row, own) for row in table.rows],
        LYING[0],
        SIZE,
        names=True,
        troubles=[f"level {row.level}, {row.trouble}" if row.trouble else "" for row in table.rows],
    )
    if shared and good:
        levels = {row.level: row for row in good}
        yield from numbers(
            f"levels-{number}",
            f"What is the same for all schemes on {name}, by level.",
            [str(level) for level in levels],
            30.0,
            [headings[column] for column in shared],
            [tuple(digits(row.entries[column]) for column in shared) for row in levels.values()],
            LYING[0],
            SIZE,
            first="level",
            names=True,
        )
    placed = [column for column in own + shared if any(row.entries[column].place for row in good)]
    if placed:
        yield from numbers(
            f"places-{number}",
            f"Where the extremes on {name} are: mesh faces with barycentric coordinates; of fallbacks the kinds.",
            [_first(row) for row in good],
            named(names, SIZE),
            ["level", *(headings[column] for column in placed)],
            [(str(row.level), *(_place(row.entries[column]) for column in placed)) for row in good],
            LYING[0],
            SIZE,
            names=True,
        )


def _by_level(rows: Sequence[SchemeRow], column: int) -> bool:
    """Whether all schemes have the same in a column, by level, and more than one scheme says so."""
    found: dict[int | None, Entry] = {}
    same = all(found.setdefault(row.level, row.entries[column]) == row.entries[column] for row in rows)
    return same and len(rows) > len(found)


def _first(row: SchemeRow) -> Cell:
    return scheme(row.position, row.scheme)


def _values(row: SchemeRow, columns: Sequence[int]) -> tuple[str | Cell, ...]:
    return () if row.trouble else (str(row.level), *(digits(row.entries[column]) for column in columns))


def _place(entry: Entry) -> str | Cell:
    face, space, coordinates = entry.place.partition(" (")
    return Cell((Text(face), Small(coordinates.rstrip(")"), apart=True))) if space else entry.place or NOTHING


def _orders(section: Section, number: int) -> Iterator[Block]:
    if not section.orders:
        return
    quantities = list(dict.fromkeys(row.quantity for row in section.orders))
    by_scheme: dict[tuple[int, str], dict[str, OrderRow]] = {}
    for row in section.orders:
        by_scheme.setdefault((row.position, row.scheme), {})[row.quantity] = row
    names = [text for _, text in by_scheme]
    yield from numbers(
        f"orders-{number}",
        f"Orders of convergence on {section.dataset.spec}: of each quantity the order, its interval and the levels it "
        "comes from. A dash: no order can be told.",
        [scheme(position, text) for position, text in by_scheme],
        named(names, SIZE + 0.5),
        quantities,
        [tuple(_order(rows.get(quantity)) for quantity in quantities) for rows in by_scheme.values()],
        LYING[0],
        SIZE + 0.5,
        names=True,
    )
    reasons: dict[str, list[str]] = {}
    for row in section.orders:
        if row.order.text == NOTHING and row.reason:
            reasons.setdefault(row.reason, []).append(f"{row.scheme} {row.quantity}")
    if reasons:
        told = ". ".join(f"{reason[0].upper()}{reason[1:]}: {', '.join(who)}" for reason, who in reasons.items())
        yield Paragraph(runs(f"No order: {told}."), small=True)


def _order(row: OrderRow | None) -> str | Cell:
    if row is None:
        return ""
    if not row.order.place:
        return row.order.text
    below = f"{lettering.number(row.order.place)} {row.levels_used.replace(' ', ',')}"
    return Cell((Text(lettering.number(row.order.text)), Small(below, apart=True)))


def _meanings(page: Page) -> Iterator[Block]:
    if not any(columns for _, columns in page.meanings):
        return
    yield Heading(2, runs("What the columns mean"), "meanings")
    for number, (title, columns) in enumerate(page.meanings):
        if columns:
            yield Table(
                f"meanings-{number}",
                runs(f"Columns of the measure: {title}."),
                (Column(width=150.0), Column()),
                (("column", "meaning"),),
                tuple((Cell(runs(Name(name))), meaning) for name, meaning in columns),
                8.0,
            )


def _hashes(page: Page) -> Iterator[Block]:
    yield Heading(2, runs("Sources"), "sources")
    yield Paragraph(
        runs(
            f"First {HASH} digits of the SHA-256 of the source files that results depend on; ",
            Name("plan.json"),
            " has all.",
        ),
        small=True,
    )
    for kind, hashes in page.hashes:
        pairs = [hashes[start : start + 2] for start in range(0, len(hashes), 2)]
        yield Table(
            f"sources-{kind}",
            runs(f"Sources of the {kind}."),
            (Column(), Column(width=80.0), Column(), Column(width=80.0)),
            (("name", "source") * 2,),
            tuple(
                _padded([Cell(runs(Name(part))) for pair in some for part in (pair[0], pair[1][:HASH])])
                for some in pairs
            ),
            7.5,
        )


def _padded(cells: list[Cell]) -> tuple[str | Cell, ...]:
    return (*cells, *("" for _ in range(4 - len(cells))))


def _traces(page: Page) -> Iterator[Block]:
    if not page.traces:
        return
    yield Heading(2, runs("Tracebacks"), "tracebacks")
    for trace in page.traces:
        yield Paragraph(runs(Name(trace.cell)))
        yield Quotation(tuple(trace.text.splitlines()))
