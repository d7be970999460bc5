"""Published figures next to what the testbed measures.

``published.toml`` holds what papers print, where, and which cell of the harness measures the same; a later figure is a
row more there. The measured side is never written down: :func:`published_plan` is the grid that the rows need, and
:func:`compare` reads its results.
"""

import csv
import dataclasses
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from testbed.errors import SpecError, TestbedError
from testbed_reports.published_table import ALL, DataStatus, Figure

if TYPE_CHECKING:
    import pandas as pd

    from testbed.harness.plan import Plan
    from testbed.harness.results import Results

#: What the comparison is called in a results directory.
NAME: Final = "published.csv"
#: ``differs`` is a difference with an explanation, ``unexplained`` one without; ``no value``: nothing was measured.
Agreement: TypeAlias = Literal["agrees", "differs", "unexplained", "no value"]


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
    within
        How far ours may be off; NaN for half a unit of the last printed digit.
    ours
        Where several numbers are printed, all of ours, with blanks between them; ``measured`` is then the one that is
        farthest off.
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
    within: float = math.nan
    ours: str = ""

    @property
    def difference(self) -> float:
        """Our number less the printed one, of several the one farthest off; NaN if there is none."""
        return self.measured - float(self._compared)

    @property
    def _compared(self) -> str:
        """The printed number that ours is compared with."""
        numbers = self.printed.split()
        if not self.ours:
            return numbers[0]
        return numbers[_farthest([float(number) for number in self.ours.split()], numbers)]

    @property
    def verdict(self) -> str:
        """The agreement in words; differences that are due to data that are lost are called so."""
        return "data lost" if self.agreement == "differs" and self.data == "lost" else self.agreement

    @property
    def shown_printed(self) -> str:
        """The printed number, or how many they are."""
        numbers = self.printed.split()
        return self.printed if len(numbers) == 1 else f"{len(numbers)} numbers"

    @property
    def shown_difference(self) -> str:
        """The difference with two digits."""
        if math.isnan(self.difference):
            return "–"
        return "0" if self.difference == 0.0 else f"{self.difference:+.2g}"

    @property
    def shown(self) -> str:
        """Our number with two digits more than the printed one, counts as they are, orders with their interval."""
        if math.isnan(self.measured):
            return "–"
        if self.ours and self.agreement == "agrees":
            return "the same"
        digits = decimals(self._compared) + 2
        if not math.isnan(self.low):
            return f"{self.measured:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"
        if self.measured.is_integer():
            return f"{self.measured:.0f}"
        return f"{self.measured:.{digits}f}" if abs(self.measured) >= 10.0**-digits else f"{self.measured:.3g}"


def subject(row: PublishedRow) -> str:
    """What a figure was measured on: ``flat on octahedron, level 0; data given``."""
    if not row.scheme:
        return row.dataset
    bound = row.level.startswith("epsilon")
    levels = f", {row.level}" if bound else f", level{'s' if ' ' in row.level else ''} {row.level}" if row.level else ""
    return f"{row.scheme} on {row.dataset}{levels}" + ("" if row.data == "general" else f"; data {row.data}")


def remark(row: PublishedRow) -> str:
    """What there is to say of a figure: why ours is another, or why there is none; else empty."""
    return row.reason if row.agreement == "no value" else row.explanation


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
        within=math.nan if figure.within is None else figure.within,
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
    agrees = comes_out([measured], figure.printed, figure.within)
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


def comes_out(values: Sequence[float], printed: str, within: float | None = None) -> bool:
    """Whether values are the printed numbers: at their digits, or within a distance."""
    numbers = printed.split()
    if len(numbers) != len(values):
        return False
    if within is None:
        return all(rounds_to(value, number) for value, number in zip(values, numbers, strict=True))
    return all(abs(value - float(number)) <= within for value, number in zip(values, numbers, strict=True))


def farthest(values: Sequence[float], printed: str) -> float:
    """Return of values the one that is farthest from its printed number; NaN if their numbers differ."""
    numbers = printed.split()
    return values[_farthest(values, numbers)] if values and len(values) == len(numbers) else math.nan


def _farthest(values: Sequence[float], numbers: Sequence[str]) -> int:
    apart = [abs(value - float(number)) for value, number in zip(values, numbers, strict=True)]
    # NaN is farther than anything
    return max(range(len(apart)), key=lambda place: math.inf if math.isnan(apart[place]) else apart[place])


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
    numbers = ("measured", "low", "high", "within")
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
