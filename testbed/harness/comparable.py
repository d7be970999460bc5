"""Results as plain rows by key, to compare: from a results directory, or from its CSV files alone."""

import csv
import math
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from testbed.errors import TestbedError
from testbed.harness.plan import Plan
from testbed.harness.results import read_results

if TYPE_CHECKING:
    import pandas as pd

#: What a place in a table holds; None for a missing number or an empty text.
Value: TypeAlias = float | str | None
Row: TypeAlias = Mapping[str, Value]
#: Scheme, dataset and level.
Key: TypeAlias = tuple[str, str, int]

#: Columns that a table of cells has at least.
NEEDED: Final = ("scheme", "dataset", "level", "status")
#: Columns that tell the rows of the other tables apart.
ORDER_KEY: Final = ("scheme", "dataset", "quantity")
CLAIM_KEY: Final = ("scheme", "claim", "dataset")


@dataclass(frozen=True)
class Comparable:
    """Results.

    Parameters
    ----------
    name
        Where they are from.
    columns
        The columns of the cells, in order.
    cells
        Rows by scheme, dataset and level.
    orders
        Rows by scheme, dataset and quantity.
    claims
        Rows by scheme, claim and dataset.
    is_judged
        Whether orders and claims are known.
    shapes
        What the exact surfaces of datasets are declared to be, as far as that is known.
    converging
        Columns that are declared to converge to zero.
    notes
        What is to be said about them, a sentence each.
    """

    name: str
    columns: tuple[str, ...]
    cells: Mapping[Key, Row]
    orders: Mapping[tuple[str, ...], Row] = field(default_factory=dict)
    claims: Mapping[tuple[str, ...], Row] = field(default_factory=dict)
    is_judged: bool = False
    shapes: Mapping[str, str | None] = field(default_factory=dict)
    converging: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()


def read_comparable(path: Path) -> Comparable:
    """Read results.

    Parameters
    ----------
    path
        A results directory, whole or interrupted; a directory with ``results.csv`` and, where there are,
        ``orders.csv``, ``claims.csv`` and ``plan.json``; or a CSV file of cells.

    Raises
    ------
    TestbedError
        There are no results, or they are not of this kind; one sentence that names the file.
    """
    try:
        return _read(path)
    except OSError as error:
        raise TestbedError(f"{path} cannot be read ({error.strerror}): check the path") from error


def _read(path: Path) -> Comparable:
    if path.is_file():
        columns, cells = _csv_cells(path)
        return Comparable(str(path), columns, cells)
    if not path.is_dir():
        raise TestbedError(f"{path} does not exist: name a results directory, or a results.csv")
    if (path / "journal.sqlite").exists() and (path / "plan.json").exists():
        return _recorded(path)
    if not (path / "results.csv").exists():
        raise TestbedError(f"{path} holds no results: run `testbed run -o {path}` first")
    columns, cells = _csv_cells(path / "results.csv")
    judged = [path / f"{name}.csv" for name in ("orders", "claims")]
    if not all(file.exists() for file in judged):
        return Comparable(str(path), columns, cells, **_declared(path))
    orders, claims = (
        _keyed(_csv_rows(file, key)[1], key, file) for file, key in zip(judged, (ORDER_KEY, CLAIM_KEY), strict=True)
    )
    return Comparable(str(path), columns, cells, orders, claims, is_judged=True, **_declared(path))


def _recorded(directory: Path) -> Comparable:
    """Results of a run, finished or not."""
    try:
        results = read_results(directory)
    except (sqlite3.Error, ValueError, TypeError, KeyError, AttributeError) as error:
        reason = " ".join(str(error).split())
        raise TestbedError(
            f"{directory} holds results that cannot be read ({reason}): compare its results.csv, or run again"
        ) from error
    notes: tuple[str, ...] = ()
    if results.missing:
        notes = (f"{directory} is not finished: {len(results.missing)} of its cells are not computed yet",)
    columns, rows = _frame_rows(results.cells)
    tables = ((results.orders, ORDER_KEY), (results.claims, CLAIM_KEY))
    orders, claims = (_keyed(_frame_rows(table)[1], key, directory) for table, key in tables)
    cells = _cells_of(rows, directory)
    return Comparable(str(directory), columns, cells, orders, claims, True, *_declarations(results.plan), notes)  # noqa: FBT003


def _declared(directory: Path) -> dict[str, Any]:
    """What a plan beside CSV files declares; nothing without a plan."""
    try:
        plan = Plan.from_json((directory / "plan.json").read_text("utf-8"))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return {}
    shapes, converging = _declarations(plan)
    return {"shapes": shapes, "converging": converging}


def _declarations(plan: Plan) -> tuple[Mapping[str, str | None], frozenset[str]]:
    shapes = {dataset.spec: dataset.shape for dataset in plan.datasets}
    return shapes, frozenset(column.name for column in plan.columns if column.converges)


def _frame_rows(table: "pd.DataFrame") -> tuple[tuple[str, ...], list[dict[str, Value]]]:
    records = table.to_dict("records")
    return tuple(map(str, table.columns)), [{str(name): _value(one) for name, one in row.items()} for row in records]


def _value(found: Any) -> Value:
    """Return a number as a float, a text as it is, and None for what is missing."""
    if isinstance(found, str):
        return found or None
    try:
        number = float(found)
    except (TypeError, ValueError):  # pandas' NA
        return None
    return None if math.isnan(number) else number


def _csv_cells(path: Path) -> tuple[tuple[str, ...], Mapping[Key, Row]]:
    columns, rows = _csv_rows(path, NEEDED)
    return columns, _cells_of(rows, path)


def _csv_rows(path: Path, needed: Iterable[str]) -> tuple[tuple[str, ...], list[dict[str, Value]]]:
    """Columns and rows of a CSV file; columns whose entries are numbers hold numbers."""
    try:
        with path.open(encoding="utf-8", newline="") as file:
            header, *lines = list(csv.reader(file, strict=True)) or [[]]
    except (UnicodeDecodeError, csv.Error) as error:
        raise TestbedError(f"{path} is no table of results ({error}): name a results.csv") from error
    absent = [name for name in needed if name not in header]
    if absent or len(set(header)) < len(header):
        reason = f"it has no column {absent[0]}" if absent else "two of its columns have one name"
        raise TestbedError(f"{path} is no table of results ({reason}): name a results.csv")
    for number, line in enumerate(lines, 2):
        if len(line) != len(header):
            raise TestbedError(
                f"{path} is cut off or damaged: record {number} has {len(line)} entries for {len(header)} columns"
            )
    numeric = [all(_is_number(line[place]) for line in lines) for place in range(len(header))]
    return tuple(header), [
        {
            name: _value(float(text) if is_numeric and text else text)
            for name, text, is_numeric in zip(header, line, numeric, strict=True)
        }
        for line in lines
    ]


def _is_number(text: str) -> bool:
    try:
        float(text or 0.0)
    except ValueError:
        return False
    return True


def _cells_of(rows: list[dict[str, Value]], path: Path) -> Mapping[Key, Row]:
    cells: dict[Key, Row] = {}
    for row in rows:
        level = row["level"]
        if not isinstance(level, float) or not level.is_integer():
            raise TestbedError(
                f"{path} is no table of results (level {level!r} is no whole number): name a results.csv"
            )
        key = (str(row["scheme"] or ""), str(row["dataset"] or ""), int(level))
        if key in cells:
            raise TestbedError(f"{path} has two rows for {key[0]} on {key[1]}, level {key[2]}: remove one")
        cells[key] = row
    return cells


def _keyed(rows: list[dict[str, Value]], key: tuple[str, ...], path: Path) -> Mapping[tuple[str, ...], Row]:
    keyed = {tuple(str(row[name] or "") for name in key): row for row in rows}
    if len(keyed) < len(rows):
        raise TestbedError(f"{path} has two rows of one {' and '.join(key)}: write it again with `testbed report`")
    return keyed
