"""Published figures next to what the testbed measures.

``published.toml`` holds what papers print, where, and which cell of the harness measures the same; a later figure is a
row more there. The measured side is never written down: :func:`published_plan` is the grid that the rows need, and
:func:`compare` reads its results.
"""

import csv
import dataclasses
import difflib
import io
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, get_args

from testbed.errors import SpecError, TestbedError

if TYPE_CHECKING:
    import pandas as pd

    from testbed.harness.plan import Plan
    from testbed.harness.results import Results

#: What the comparison is called in a results directory.
NAME: Final = "published.csv"
#: In place of a paper: all of them.
ALL: Final = "all"

#: Where the data come from: see the head of ``published.toml``.
DataStatus: TypeAlias = Literal["given", "reconstructed", "lost", "general"]
#: ``differs`` is a difference with an explanation, ``unexplained`` one without; ``no value``: nothing was measured.
Agreement: TypeAlias = Literal["agrees", "differs", "unexplained", "no value"]


@dataclass(frozen=True)
class Figure:
    """A printed number and how it is measured here.

    Parameters
    ----------
    paper, place, quantity
        Where it is printed and what it is.
    scheme, dataset
        Texts of the plugins.
    column
        Column of the results.
    printed
        As printed, a decimal number; its last digit says how far it can be compared.
    data
        Where the data come from.
    level
        Level of the dataset; None for the order of convergence of ``column`` over all its levels.
    explanation
        Why ours is another number; empty where they agree.
    """

    paper: str
    place: str
    quantity: str
    scheme: str
    dataset: str
    column: str
    printed: str
    data: DataStatus
    level: int | None = None
    explanation: str = ""


@dataclass(frozen=True)
class PublishedTable:
    """All published figures.

    Parameters
    ----------
    citations
        Paper to citation.
    figures
        The figures, in the file's order.
    """

    citations: Mapping[str, str]
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class PublishedRow:
    """A published figure with what was measured; a row of ``published.csv``, all numbers to the last bit.

    Parameters
    ----------
    paper, place, quantity, scheme, dataset, column, printed, data, explanation
        As in :class:`Figure`.
    level
        Level, or for an order the levels that it was fitted to, ``"2 3 4"``.
    measured
        Our number; NaN if there is none.
    low, high
        Interval of an order; NaN for other quantities.
    agreement
        See :data:`Agreement`.
    reason
        Why nothing was measured; else empty.
    """

    paper: str
    place: str
    quantity: str
    scheme: str
    dataset: str
    level: str
    column: str
    printed: str
    measured: float
    low: float
    high: float
    agreement: Agreement
    data: DataStatus
    explanation: str
    reason: str

    @property
    def shown(self) -> str:
        """Our number with two digits more than the printed one, counts as they are, orders with their interval."""
        if math.isnan(self.measured):
            return "–"
        digits = decimals(self.printed) + 2
        if not math.isnan(self.low):
            return f"{self.measured:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"
        if self.measured.is_integer():
            return f"{self.measured:.0f}"
        return f"{self.measured:.{digits}f}" if abs(self.measured) >= 10.0**-digits else f"{self.measured:.3g}"


@cache
def published_table() -> PublishedTable:
    """Return the published figures of ``published.toml``.

    Raises
    ------
    TestbedError
        A row of the file is not a figure; the message names the row.
    """
    return parse_table(files("testbed_reports").joinpath("published.toml").read_text("utf-8"))


def parse_table(text: str) -> PublishedTable:
    """Return the figures of a table in the format of ``published.toml``; TestbedError for a row that is none."""
    content = tomllib.loads(text)
    citations = {name: str(paper["citation"]) for name, paper in content["papers"].items()}
    figures = tuple(_figure(number, row, citations) for number, row in enumerate(content["figures"], start=1))
    return PublishedTable(MappingProxyType(citations), figures)


def _figure(number: int, row: Mapping[str, Any], citations: Mapping[str, str]) -> Figure:
    try:
        figure = Figure(**row)
    except TypeError as error:
        raise TestbedError(f"published figure {number} has other fields than it should: {error}") from error
    where = f"published figure {number} ({figure.place})"
    for field in dataclasses.fields(Figure):
        value = getattr(figure, field.name)
        expected = int if field.name == "level" else str
        if not (isinstance(value, expected) or (field.name == "level" and value is None)):
            raise TestbedError(f"{where}: {field.name} is {value!r}, and should be a {expected.__name__}")
    if figure.paper not in citations:
        raise TestbedError(f"{where}: there is no paper {figure.paper!r}: name one of {', '.join(citations)}")
    if figure.data not in get_args(DataStatus):
        raise TestbedError(f"{where}: data cannot be {figure.data!r}: give one of {', '.join(get_args(DataStatus))}")
    try:
        finite = Decimal(figure.printed).is_finite()
    except ArithmeticError:
        finite = False
    if not finite:
        raise TestbedError(f"{where}: printed is {figure.printed!r}: give a decimal number in figures")
    return figure


def figures_of(paper: str) -> tuple[Figure, ...]:
    """Return the figures of a paper, or of all for ``"all"``; SpecError for an unknown paper, with the nearest."""
    table = published_table()
    if paper == ALL:
        return table.figures
    if paper not in table.citations:
        near = difflib.get_close_matches(paper, [*table.citations, ALL], n=1)
        guess = f"did you mean {near[0]}? " if near else ""
        raise SpecError(f"there are no figures of a paper {paper!r}: {guess}papers are {', '.join(table.citations)}")
    return tuple(figure for figure in table.figures if figure.paper == paper)


def published_plan(figures: Sequence[Figure]) -> "Plan":
    """Return the grid with the cells that figures need, and no others.

    Raises
    ------
    SpecError
        A figure names nothing registered, or a level above the dataset's finest.
    """
    from testbed import registry
    from testbed.harness.plan import make_plan

    wanted = set()
    for figure in figures:
        dataset = registry.dataset(figure.dataset)
        if figure.level is not None and not 0 <= figure.level <= dataset.finest:
            raise SpecError(
                f"a published figure needs level {figure.level} of {dataset}, whose levels are 0 to {dataset.finest}"
            )
        levels = range(dataset.finest + 1) if figure.level is None else [figure.level]
        wanted |= {(str(registry.scheme(figure.scheme)), str(dataset), level) for level in levels}
    grid = make_plan([figure.scheme for figure in figures], [figure.dataset for figure in figures])
    cells = tuple(cell for cell in grid.cells if (cell.scheme, cell.dataset, cell.level) in wanted)
    return dataclasses.replace(grid, cells=cells)


def compare(figures: Iterable[Figure], results: "Results") -> tuple[PublishedRow, ...]:
    """Return the figures next to what results say; those that the results do not have come with a reason.

    Parameters
    ----------
    figures
        Published figures.
    results
        Results of :func:`published_plan`, or of any other run.
    """
    return tuple(_row(figure, results) for figure in figures)


def _row(figure: Figure, results: "Results") -> PublishedRow:
    from testbed import registry

    scheme, dataset = str(registry.scheme(figure.scheme)), str(registry.dataset(figure.dataset))
    if figure.level is None:
        level, measured, low, high, reason = _order(figure, _of(results.orders, scheme, dataset))
    else:
        level, low, high = str(figure.level), math.nan, math.nan
        measured, reason = _value(figure, _of(results.cells, scheme, dataset))
    agreement = _agreement(figure, measured, low, high)
    names = ("paper", "place", "quantity", "column", "printed", "data", "explanation")
    taken = {name: getattr(figure, name) for name in names}
    return PublishedRow(
        **taken,
        scheme=scheme,
        dataset=dataset,
        level=level,
        measured=measured,
        low=low,
        high=high,
        agreement=agreement,
        reason=reason,
    )


def _of(table: "pd.DataFrame", scheme: str, dataset: str) -> "pd.DataFrame":
    return table[(table["scheme"] == scheme) & (table["dataset"] == dataset)]


def _order(figure: Figure, orders: "pd.DataFrame") -> tuple[str, float, float, float, str]:
    """Return levels, order, interval and why there is none."""
    chosen = orders[orders["quantity"] == figure.column]
    if chosen.empty:
        return "", math.nan, math.nan, math.nan, f"the results have no order of {figure.column}"
    row = chosen.iloc[0]
    order, low, high = (float(row[name]) for name in ("order", "low", "high"))
    return str(row["levels_used"]), order, low, high, str(row["reason"]) if math.isnan(order) else ""


def _value(figure: Figure, cells: "pd.DataFrame") -> tuple[float, str]:
    """Return the value of a cell, or NaN and why there is none."""
    chosen = cells[cells["level"] == figure.level]
    if chosen.empty:
        return math.nan, "not computed"
    row = chosen.iloc[0]
    if row["status"] != "ok":
        return math.nan, f"{row['status']}: {row['reason']}"
    if figure.column not in chosen or bool(chosen[figure.column].isna().iloc[0]):
        return math.nan, f"the cell has no {figure.column}"
    return float(row[figure.column]), ""


def _agreement(figure: Figure, measured: float, low: float, high: float) -> Agreement:
    from testbed.measures.convergence import OrderEstimate, verdict

    if math.isnan(measured):
        return "no value"
    agrees = rounds_to(measured, figure.printed)
    if figure.level is None:
        # an interval that holds the order above or below as well says nothing for this one
        estimate = OrderEstimate("estimated", measured, low, high)
        agrees = agrees and verdict(float(figure.printed), estimate) == "met"
    if agrees:
        return "agrees"
    return "differs" if figure.explanation else "unexplained"


def decimals(printed: str) -> int:
    """Digits behind the point of a printed number."""
    exponent = Decimal(printed).as_tuple().exponent
    return max(0, -int(exponent))


def rounds_to(value: float, printed: str) -> bool:
    """Whether a value rounds to a printed number at its digits; half-way between two it does to both.

    >>> [rounds_to(1.4459, "1.4"), rounds_to(0.7448, "0.75"), rounds_to(2.45, "2.5"), rounds_to(234.6, "235")]
    [True, False, True, True]
    """
    if not math.isfinite(value):
        return False
    number = Decimal(printed)
    half = Decimal((0, (5,), int(number.as_tuple().exponent) - 1))
    # the shortest decimal that is this float: 2.45 is half-way, whatever its binary digits are
    return abs(Decimal(repr(value)) - number) <= half


def write_published(directory: Path, rows: Iterable[PublishedRow]) -> Path:
    """Write ``published.csv`` into a directory, whole or not at all, and return its path."""
    from testbed.harness.journal import write_whole

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [field.name for field in dataclasses.fields(PublishedRow)]
    writer.writerow(names)
    for row in rows:
        values = [getattr(row, name) for name in names]
        # an empty field for a number that is not there, as in results.csv
        writer.writerow(["" if isinstance(value, float) and math.isnan(value) else value for value in values])
    path = directory / NAME
    write_whole(path, text.getvalue())
    return path


def published_rows(directory: Path) -> tuple[PublishedRow, ...]:
    """Return the rows of a directory's ``published.csv``, or none where nothing was reproduced.

    Raises
    ------
    TestbedError
        The file cannot be read as such.
    """
    path = directory / NAME
    if not path.exists():
        return ()
    numbers = ("measured", "low", "high")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            records = list(csv.DictReader(file, strict=True))
        return tuple(
            # texts and numbers mixed, which the type of a row's columns does not tell apart
            PublishedRow(**{**record, **{name: float(record[name] or "nan") for name in numbers}})  # type: ignore[arg-type]
            for record in records
        )
    except (ValueError, TypeError, KeyError, csv.Error) as error:
        raise TestbedError(
            f"{path} cannot be read ({error}): write it again with `testbed reproduce {ALL} -o {directory}`"
        ) from error
