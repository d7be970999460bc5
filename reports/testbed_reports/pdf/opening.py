"""The chapters before the datasets: summary, ranking, what curves do, verdicts and orders over all datasets."""

from collections.abc import Iterator, Sequence
from typing import Final

from testbed_reports.findings import Findings
from testbed_reports.formatting import NOTHING, Entry, listed
from testbed_reports.pdf import lettering, widths
from testbed_reports.pdf.blocks import (
    LYING,
    UPRIGHT,
    Block,
    Break,
    Bullets,
    Cell,
    Column,
    Folio,
    Heading,
    Link,
    Name,
    Paragraph,
    Run,
    Runs,
    Small,
    Strong,
    Swatch,
    Table,
    Text,
    Verdict,
    runs,
    value,
)
from testbed_reports.pdf.grids import named, numbers
from testbed_reports.ranking import Ranking
from testbed_reports.summary import Winner
from testbed_reports.verdicts import Judgement
from testbed_reports.view import OverviewCell, Page

#: What stands for an order where all errors are at the rounding floor.
EXACT: Final = "exact"


def dataset_label(number: int) -> str:
    """Label of a dataset's section."""
    return f"dataset-{number}"


def scheme_label(position: int) -> str:
    """Label of a scheme's section."""
    return f"scheme-{position}"


def mark(page: Page, verdict: str, *, word: bool = True) -> Verdict:
    """Return a verdict with its symbol."""
    return Verdict(page.symbols.get(verdict, "·"), verdict, word)


def scheme(position: int, text: str, *, linked: bool = False) -> Cell:
    """Return the cell of a scheme: its line and marker, and its text, which may lead to its section.

    A link makes typst set its cell again whenever a page number moves, so that large tables have none.
    """
    return Cell(runs(Swatch(position), Link(scheme_label(position), text) if linked else Name(text)))


def opening(page: Page) -> Iterator[Folio]:
    """Yield the pages: the words upright, the wide tables lying."""
    yield Folio(tuple(_summary(page)))
    yield Folio(tuple(_verdicts(page)), lying=True)
    if page.sections:
        yield Folio(tuple(_orders(page)), lying=True)


def _summary(page: Page) -> Iterator[Block]:
    """Yield what stands out."""
    yield Heading(1, runs("Summary"), "summary")
    yield Bullets(tuple(runs(sentence) for sentence in page.sentences))
    if page.contests:
        yield _contests(page)
    for number, ranking in enumerate(page.rankings):
        yield from _ranking(page, ranking, number)
    if page.findings:
        yield from _findings(page.findings)


def _contests(page: Page) -> Table:
    size = 8.0
    rows: tuple[tuple[str | Cell, ...], ...] = tuple(
        (
            Cell(runs(Link(dataset_label(contest.number), contest.dataset))),
            str(contest.level),
            *(Cell(_winner(winner)) for winner in contest.winners),
        )
        for contest in page.contests
    )
    columns = (
        Column(width=widths.of_names([one.dataset for one in page.contests], size, swatch=False)),
        Column("right", widths.of_column("level", (), size)),
        *(Column() for _ in page.headings),
    )
    caption = (
        "Best on each dataset, at the level where its schemes are compared. Values that read the same share the place; "
        "up to the rounding floor all are equal."
    )
    return Table("best", runs(caption), columns, (("dataset", "level", *page.headings),), rows, size)


def _winner(winner: Winner | None) -> Runs:
    if winner is None:
        return runs(NOTHING)
    if winner.alike:
        return runs(Strong(winner.value), f" {len(winner.schemes)} of {winner.ranked} alike")
    parts: list[str | Run] = [Strong(winner.value)]
    for place, (position, text) in enumerate(winner.schemes):
        parts += [", " if place else " ", Swatch(position), Name(text)]
    return runs(*parts)


def _places(places: Sequence[tuple[str, int]]) -> str:
    return ", ".join(f"{dataset} (level {level})" for dataset, level in places)


def _ranking(page: Page, ranking: Ranking, number: int) -> Iterator[Block]:
    count = len(ranking.rows) + len(ranking.unranked)
    yield Heading(2, runs("Ranking" if len(page.rankings) == 1 else f"Ranking of {count} schemes"), f"ranking-{number}")
    yield Bullets(tuple(runs(sentence) for sentence in ranking.sentences))
    caption = (
        "Errors against the exact surfaces as factors: on each dataset a scheme's error over the least that any scheme "
        f"has there, and of these the geometric mean over {_places(ranking.places)}. 1: best everywhere. "
        "K: Gaussian curvature. Order: of the largest distance, median over the datasets."
    )
    headings = [one.heading if one.where == "all" else f"{one.heading}, {one.where}" for one in ranking.criteria]
    yield from numbers(
        f"ranking-table-{number}",
        caption,
        [scheme(row.position, row.scheme, linked=True) for row in ranking.rows],
        named([row.scheme for row in ranking.rows], 7.5),
        ["joins", *headings, "order"],
        [(row.continuity, *map(value, row.factors), value(row.orders)) for row in ranking.rows],
        UPRIGHT[0],
        7.5,
    )
    if ranking.unranked:
        missing = ", ".join(ranking.unranked)
        yield Paragraph(runs(f"Not ranked, as they have no surface on some dataset: {missing}."), small=True)


def _findings(found: Findings) -> Iterator[Block]:
    yield Heading(2, runs("Scheme or boundary curves?"), "findings")
    yield Bullets(tuple(runs(sentence) for sentence in found.sentences))
    headings = [f"{dataset}, level {level}" for dataset, level in found.places]
    for number, one in enumerate(found.comparisons):
        quantity = f"{one.quantity[0].upper()}{one.quantity[1:]}"
        for kind, rows, caption in (
            (
                "boundary curve",
                one.curves,
                f"{quantity}, of the schemes with continuous tangent planes that stand on a curve network: on each "
                f"boundary curve over that on {found.base}, median of the schemes and range. Below 1 the curve helps; "
                "bold: by a fifth or more.",
            ),
            (
                "scheme",
                one.schemes,
                f"{quantity}: each scheme on {found.base} curves over the median of the schemes there.",
            ),
        ):
            names = [row.name for row in rows]
            yield from numbers(
                f"findings-{number}-{kind[0]}",
                caption,
                [Cell(runs(Name(name))) for name in names],
                widths.of_names(names, 7.5, swatch=False),
                headings,
                [tuple(map(value, row.entries)) for row in rows],
                UPRIGHT[0],
                7.5,
                first=kind,
            )


def _verdicts(page: Page) -> Iterator[Block]:
    """Yield the matrix of claims."""
    yield Heading(1, runs("Verdicts on claims"), "verdicts")
    legend: list[str | Run] = []
    for verdict, meaning in page.legend:
        legend += [mark(page, verdict), f" {meaning}.  "]
    yield Paragraph(runs(*legend, f"{NOTHING} claims nothing of the kind."), small=True)
    if not page.matrix.kinds:
        yield Paragraph(runs("No claim can be judged yet."))
        return
    size = 7.5
    rows = tuple(
        (
            scheme(row.position, row.scheme, linked=True),
            *(Cell(tuple(_judgements(page, cell))) if cell else NOTHING for cell in row.cells),
        )
        for row in page.matrix.rows
    )
    yield Table(
        "verdict-matrix",
        runs("Schemes against what they claim; in each place the worst verdict first, with the datasets."),
        (Column(width=named(page.schemes, size)), *(Column() for _ in page.matrix.kinds)),
        (("scheme", *page.matrix.kinds),),
        rows,
        size,
    )


def _judgements(page: Page, cell: Sequence[Judgement]) -> Iterator[Run]:
    for place, one in enumerate(cell):
        if place:
            yield Break()
        yield mark(page, one.verdict)
        yield Strong(f" {', '.join(one.claims)}")
        where = f"on all {len(one.datasets)}" if one.everywhere else f"on {', '.join(one.datasets)}"
        if one.datasets:
            yield Small(f" {where}")


def _orders(page: Page) -> Iterator[Block]:
    """Yield the orders of convergence of all schemes on all datasets."""
    yield Heading(1, runs("Orders of convergence"), "orders")
    every = range(len(page.sections))
    kept = [number for number in every if any(_is_told(row[number].order) for row in page.overview)]
    names = [page.sections[number].dataset.spec for number in every if number not in kept]
    if names:
        yield Paragraph(runs(f"No order of the distance can be told on {listed(names)}."), small=True)
    if not kept:
        return
    yield from numbers(
        "orders-table",
        "Order at which the largest distance to the exact surface falls with the longest edge, with its interval "
        "and the symbol of the verdict on the claimed order. A dash: no order can be told; the appendix has the "
        "reasons. Nothing: the scheme takes other faces than the dataset has.",
        [scheme(position, text, linked=True) for position, text in enumerate(page.schemes)],
        named(page.schemes, 7.0),
        [page.sections[number].dataset.spec for number in kept],
        [tuple(_overview(page, row[number]) for number in kept) for row in page.overview],
        LYING[0],
        7.0,
    )


def _is_told(order: Entry) -> bool:
    """Whether there is an order: a number with its interval, or none as all errors are rounding."""
    return bool(order.place) or order.text == EXACT


def _overview(page: Page, cell: OverviewCell) -> str | Cell:
    if not _is_told(cell.order) and cell.verdict in ("", "not claimed"):
        return cell.order.text
    known = cell.verdict in page.symbols and cell.verdict != "not claimed"
    symbol = (mark(page, cell.verdict, word=False), Text(" ")) if known else ()
    interval = (Small(f" {lettering.number(cell.order.place)}"),) if cell.order.place else ()
    return Cell((*symbol, Text(lettering.number(cell.order.text)), *interval))
