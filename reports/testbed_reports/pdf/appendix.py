"""The appendix: every number of every cell, every order, what was refused or failed and why, sources."""

from collections.abc import Iterator, Sequence
from typing import Final

from testbed_reports.formatting import NOTHING, Entry, counted
from testbed_reports.orders import OrderRow
from testbed_reports.pdf import lettering, widths
from testbed_reports.pdf.blocks import (
    LYING,
    Block,
    Bullets,
    Cell,
    Column,
    Folio,
    Heading,
    Name,
    Paragraph,
    Quotation,
    Reference,
    Small,
    Table,
    Text,
    runs,
)
from testbed_reports.pdf.grids import named, numbers
from testbed_reports.pdf.opening import scheme
from testbed_reports.tables import SchemeRow
from testbed_reports.view import Page, Section

#: Significant digits of the numbers of cells.
DIGITS: Final = 5
#: Size of the type in points.
SIZE: Final = 6.0
#: Longer texts than this are told below the table.
LONGEST: Final = 16
#: Characters of a place, face and barycentric coordinates; what is longer is none.
PLACE: Final = 40
#: Digits of a hash that are shown.
HASH: Final = 12


def appendix(page: Page) -> Iterator[Folio]:
    """Yield the pages of the appendix."""
    yield Folio((Heading(1, runs("Appendix"), "appendix"), *_troubles(page)), lying=True)
    for number, section in enumerate(page.sections):
        if section.levels.rows:
            yield Folio((*_cells(section, number), *_orders(section, number)), lying=True)
    yield Folio((*_meanings(page), *_hashes(page), *_traces(page)))


def _troubles(page: Page) -> Iterator[Block]:
    yield Heading(2, runs("Cells that were refused or failed"), "troubles")
    # reasons that differ in their numbers only are told once
    found: dict[tuple[int, int, str], list[SchemeRow]] = {}
    for number, section in enumerate(page.sections):
        for row in section.levels.rows:
            if row.trouble:
                found.setdefault((row.position, number, lettering.numberless(row.trouble)), []).append(row)
    if not found:
        yield Paragraph(runs("None."))
    else:
        ordered = [(number, rows) for (_, number, _), rows in sorted(found.items(), key=lambda item: item[0])]
        yield _trouble_table(page, ordered)
    if page.missing:
        yield Paragraph(runs(f"{counted(len(page.missing), 'cell')} without a result yet: {'; '.join(page.missing)}."))


def _trouble_table(page: Page, found: Sequence[tuple[int, Sequence[SchemeRow]]]) -> Table:
    size = 7.0
    body = []
    for number, rows in found:
        status, _, reason = rows[0].trouble.partition(": ")
        levels = " ".join(str(row.level) for row in rows)
        dataset = Cell(runs(Name(page.sections[number].dataset.spec)))
        body.append((scheme(rows[0].position, rows[0].scheme), dataset, levels, status, reason))
    columns = (
        Column(width=named([rows[0].scheme for _, rows in found], size)),
        Column(width=widths.of_names([page.sections[number].dataset.spec for number, _ in found], size, swatch=False)),
        Column(width=40.0),
        Column(width=40.0),
        Column(),
    )
    return Table(
        "trouble-table",
        runs(
            "Every cell without numbers, with its reason; where the reasons of several levels differ in numbers only, "
            "that of the first level."
        ),
        columns,
        (("scheme", "dataset", "levels", "status", "reason"),),
        tuple(body),
        size,
    )


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
    yield Heading(2, runs("All numbers on ", Name(name)), f"numbers-of-{number}")
    yield Paragraph(
        runs(
            f"Numbers have {DIGITS} significant digits; ",
            Name("results.csv"),
            " has all of them. Columns that are the same for all schemes stand in a table by level.",
        ),
        small=True,
    )
    good = [row for row in table.rows if not row.trouble]
    if len(good) < len(table.rows):
        left_out = counted(len(table.rows) - len(good), "cell")
        yield Paragraph(runs(f"{left_out} without numbers: see ", Reference("trouble-table"), "."), small=True)
    if not good:
        return
    headings = [heading for heading, _ in table.headings]
    every = range(len(headings))
    words = [column for column in every if any(len(row.entries[column].text) > LONGEST for row in good)]
    words += [column for column in every if headings[column] == "fallbacks" and column not in words]
    shared = [column for column in every if column not in words and _by_level(good, column)]
    own = [column for column in every if column not in words and column not in shared]
    fallbacks = [column for column in words if headings[column] == "fallbacks"]
    first = [scheme(row.position, row.scheme) for row in good]
    width = named([row.scheme for row in good], SIZE)
    yield from numbers(
        f"cells-{number}",
        f"Every cell on {name}.",
        first,
        width,
        ["level", *(headings[column] for column in own + fallbacks)],
        [(str(row.level), *(digits(row.entries[column]) for column in own + fallbacks)) for row in good],
        LYING[0],
        SIZE,
        names=True,
        together=True,
        repeated=1,
    )
    if shared:
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
            f"Where the extremes on {name} are: mesh faces, with barycentric coordinates in brackets.",
            first,
            width,
            ["level", *(headings[column] for column in placed)],
            [(str(row.level), *(_place(row.entries[column]) for column in placed)) for row in good],
            LYING[0],
            SIZE,
            names=True,
            together=True,
            repeated=1,
        )
    for column in words:
        yield from _told(headings[column], column, good)


def _told(heading: str, column: int, rows: Sequence[SchemeRow]) -> Iterator[Block]:
    """Yield what a column says in words, a line for all cells that say the same."""
    found: dict[str, list[str]] = {}
    for row in rows:
        entry = row.entries[column]
        text = entry.place if heading == "fallbacks" else entry.text
        if text and text != NOTHING:
            found.setdefault(text, []).append(f"{row.scheme} {row.level}")
    if found:
        yield Paragraph(runs(Name(heading), ", of schemes at levels:"), small=True)
        yield Bullets(tuple(runs(Small(f"{', '.join(who)}: {text}")) for text, who in found.items()))


def _by_level(rows: Sequence[SchemeRow], column: int) -> bool:
    """Whether all schemes have the same in a column, by level, and more than one scheme says so."""
    found: dict[int | None, Entry] = {}
    same = all(found.setdefault(row.level, row.entries[column]) == row.entries[column] for row in rows)
    return same and len(rows) > len(found)


def _place(entry: Entry) -> str | Cell:
    return lettering.shortened(entry.place.removeprefix("face "), PLACE) or NOTHING


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
    told = list(_without_order(section.orders, len(quantities)))
    if told:
        yield Paragraph(runs("No order can be told where the reason is:"), small=True)
        yield Bullets(tuple(runs(Small(line)) for line in told))


def _without_order(rows: Sequence[OrderRow], count: int) -> Iterator[str]:
    """Yield for each reason why there is no order the schemes, and the quantities if they are not all."""
    reasons: dict[str, dict[str, list[str]]] = {}
    for row in rows:
        if row.order.text == NOTHING and row.reason:
            reasons.setdefault(row.reason, {}).setdefault(row.scheme, []).append(row.quantity)
    for reason, schemes in reasons.items():
        alike: dict[tuple[str, ...], list[str]] = {}
        for who, quantities in schemes.items():
            alike.setdefault(tuple(quantities), []).append(who)
        parts = [
            f"{', '.join(who)} (all quantities)" if len(some) == count else f"{', '.join(who)} ({', '.join(some)})"
            for some, who in alike.items()
        ]
        yield f"{reason}: {'; '.join(parts)}"


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
