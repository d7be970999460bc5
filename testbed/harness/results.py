"""The results of a plan as tables, free of presentation: cells, orders of convergence, verdicts on claims."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.claims import Verdict, verdicts
from testbed.harness.journal import read_entries, write_whole
from testbed.harness.plan import Cell, Plan
from testbed.measures.convergence import OrderEstimate, estimate_order, verdict
from testbed.plugins.measure import Column

if TYPE_CHECKING:
    import pandas as pd

#: Columns that every row begins with, and ends with.
BEGINNING: Final = ("scheme", "dataset", "level", "status", "reason", "faces", "patches", "h", "diameter")
END: Final = ("fit_seconds", "measure_seconds")
ORDER_COLUMNS: Final = (
    "scheme",
    "dataset",
    "quantity",
    "order",
    "low",
    "high",
    "levels_used",
    "claimed",
    "verdict",
    "reason",
)
#: The quantities that a scheme's claimed order is about.
CLAIMED: Final = ("distance_max", "distance_rms")


@dataclass(frozen=True)
class Results:
    """What is known about a plan.

    Parameters
    ----------
    plan
        The plan; it holds what the schemes and datasets declare, and the meaning of the columns.
    cells
        A row a cell, in the plan's order: ``BEGINNING``, the measured columns, ``END``. Numbers that a cell does not
        have are missing (NaN or NA), texts are empty. Counts are Int64, other numbers float64.
    orders
        A row for each scheme, dataset and converging quantity: ``ORDER_COLUMNS``.
    claims
        A row for each claim and dataset: the fields of :class:`testbed.harness.claims.Verdict`.
    run
        What ``run.json`` says: versions, machine, command line, times, source hashes; empty before a run has ended.
    tracebacks
        Where failed cells failed, by scheme, dataset and level.
    missing
        Cells that have no result yet; they have no row.
    """

    plan: Plan
    cells: "pd.DataFrame"
    orders: "pd.DataFrame"
    claims: "pd.DataFrame"
    run: Mapping[str, Any]
    tracebacks: Mapping[tuple[str, str, int], str]
    missing: tuple[Cell, ...]


def read_results(directory: Path) -> Results:
    """Return the results of the plan that was last run in a directory, finished or not.

    Raises
    ------
    TestbedError
        The directory holds no plan or no journal.
    """
    path = directory / "plan.json"
    try:
        plan = Plan.from_json(path.read_text("utf-8"))
    except FileNotFoundError:
        raise TestbedError(f"{directory} holds no results: run `testbed run -o {directory}` first") from None
    except (ValueError, TypeError, KeyError) as error:
        raise TestbedError(f"{path} is not a plan of this version ({error}): run again into this directory") from error
    record_path = directory / "run.json"
    record = json.loads(record_path.read_text("utf-8")) if record_path.exists() else {}
    entries = read_entries(directory, (cell.key for cell in plan.cells))
    return tabulate(plan, {key: entry.outcome for key, entry in entries.items()}, record)


def tabulate(plan: Plan, outcomes: Mapping[str, Outcome], record: Mapping[str, Any]) -> Results:
    """Return the results of a plan from outcomes by key."""
    import pandas as pd

    done = [(cell, outcomes[cell.key]) for cell in plan.cells if cell.key in outcomes]
    cells = tabulate_cells(plan, done)
    orders = pd.DataFrame(list(_orders(plan, cells)), columns=list(ORDER_COLUMNS))
    judged = verdicts(plan, cells, orders)
    names = [field.name for field in fields(Verdict)]
    claims = pd.DataFrame([[getattr(one, name) for name in names] for one in judged], columns=names)
    return Results(
        plan,
        cells,
        orders,
        claims,
        record,
        {(cell.scheme, cell.dataset, cell.level): outcome.traceback for cell, outcome in done if outcome.traceback},
        tuple(cell for cell in plan.cells if cell.key not in outcomes),
    )


def export(directory: Path, record: Mapping[str, Any], *, parquet: bool = False) -> Results:
    """Write ``results.csv``, ``orders.csv``, ``claims.csv`` and ``run.json``, each whole or not at all.

    Parameters
    ----------
    directory
        The results directory.
    record
        What ``run.json`` is to say.
    parquet
        Write ``results.parquet`` too; needs pyarrow.
    """
    write_record(directory, record)
    results = read_results(directory)
    for name, table in (("results", results.cells), ("orders", results.orders), ("claims", results.claims)):
        # floats as repr, so that they read back to the last bit
        write_whole(directory / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))
    if parquet:
        write_parquet(results, directory / "results.parquet")
    return results


def write_record(directory: Path, record: Mapping[str, Any]) -> None:
    """Write ``run.json``, whole or not at all."""
    write_whole(directory / "run.json", json.dumps(record, indent=1))


def write_parquet(results: Results, path: Path) -> None:
    """Write the cells as parquet; TestbedError without pyarrow."""
    temporary = path.with_name(f".{path.name}.part")
    try:
        results.cells.to_parquet(temporary, engine="pyarrow", index=False)
        temporary.replace(path)
    except ImportError as error:
        raise TestbedError("parquet needs pyarrow: install surface-testbed[parquet]") from error
    finally:
        temporary.unlink(missing_ok=True)


def tabulate_cells(plan: Plan, done: Sequence[tuple[Cell, Outcome]]) -> "pd.DataFrame":
    """Return a row for each cell that is done, as :attr:`Results.cells`."""
    import pandas as pd

    data: dict[str, Any] = {
        "scheme": pd.Series([cell.scheme for cell, _ in done], dtype="str"),
        "dataset": pd.Series([cell.dataset for cell, _ in done], dtype="str"),
        "level": pd.Series([cell.level for cell, _ in done], dtype="int64"),
        "status": pd.Series([outcome.status for _, outcome in done], dtype="str"),
        "reason": pd.Series([outcome.reason for _, outcome in done], dtype="str"),
        "faces": pd.Series([outcome.faces for _, outcome in done], dtype="Int64"),
        "patches": pd.Series([outcome.patches for _, outcome in done], dtype="Int64"),
        "h": pd.Series([outcome.h for _, outcome in done], dtype="float64"),
        "diameter": pd.Series([outcome.diameter for _, outcome in done], dtype="float64"),
    }
    for column in plan.columns:
        if column.name not in data:
            data[column.name] = _series([(outcome.values or {}).get(column.name) for _, outcome in done])
    for name in END:
        data[name] = pd.Series([getattr(outcome, name) for _, outcome in done], dtype="float64")
    return _within_bounds(pd.DataFrame(data))


def enclosures(columns: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """Return for each column with guaranteed bounds the columns of its lower and its upper bound.

    >>> enclosures(("gauss_max", "gauss_max_low", "gauss_max_high", "epsilon_deg", "epsilon_low_deg"))
    {'gauss_max': ('gauss_max_low', 'gauss_max_high')}
    """
    result = {}
    for name in columns:
        stem, unit = (name.removesuffix("_deg"), "_deg") if name.endswith("_deg") else (name, "")
        pair = (f"{stem}_low{unit}", f"{stem}_high{unit}")
        if all(bound in columns for bound in pair):
            result[name] = pair
    return result


def _within_bounds(cells: "pd.DataFrame") -> "pd.DataFrame":
    """Move extremes that a search missed to the value that a guaranteed bound proves; their place is not known then."""
    for name, (low, high) in enclosures([str(column) for column in cells]).items():
        is_minimum = "_min" in name
        proven = cells[high if is_minimum else low]
        # false where there are no bounds; the other side is not asked: jumps of smooth surfaces are rounding
        missed = (cells[name] > proven) if is_minimum else (cells[name] < proven)
        if missed.any():
            cells[name] = cells[name].mask(missed, proven)
            stem = name.removesuffix("_deg")
            if f"{stem}_face" in cells:
                cells[f"{stem}_face"] = cells[f"{stem}_face"].mask(missed, -1)
                cells[f"{stem}_bary"] = cells[f"{stem}_bary"].mask(missed, "")
    return cells


def _series(values: list[Any]) -> "pd.Series[Any]":
    """Return a column of the type its values have in common."""
    import pandas as pd

    present = [value for value in values if value is not None]
    if any(isinstance(value, str) for value in present):
        return pd.Series(["" if value is None else str(value) for value in values], dtype="str")
    if present and all(isinstance(value, int) for value in present):
        return pd.Series(values, dtype="Int64")
    return pd.Series([nan if value is None else value for value in values], dtype="float64")


def _orders(plan: Plan, cells: "pd.DataFrame") -> Iterator[tuple[Any, ...]]:
    claimed = {scheme.spec: scheme.order for scheme in plan.schemes}
    for scheme in plan.schemes:
        for dataset in plan.datasets:
            if (scheme.spec, dataset.spec) not in plan.pairs:
                continue
            own = cells[(cells["scheme"] == scheme.spec) & (cells["dataset"] == dataset.spec)]
            ok = own[own["status"] == "ok"].sort_values("level")
            for column in plan.columns:
                if column.converges:
                    claim = claimed[scheme.spec] if column.name in CLAIMED else None
                    yield (scheme.spec, dataset.spec, column.name, *_order(ok, column, claim))


def _order(ok: "pd.DataFrame", column: Column, claim: float | None) -> tuple[Any, ...]:
    """Return order, low, high, levels_used, claimed, verdict and reason of a quantity on a dataset's cells."""
    values = ok[column.name].to_numpy(dtype="float64")
    levels = ok["level"].tolist()
    if column.exact and not ok.empty and ok[column.name].isna().all():
        estimate = _unknown("the dataset has no exact surface")
    elif ok.empty:
        estimate = _unknown("no cell is ok")
    else:
        scale = 180.0 if column.name.endswith("_deg") else float(ok["diameter"].max())
        try:
            estimate = estimate_order(ok["h"].to_numpy(), values, scale)
        except ValueError as error:
            estimate = _unknown(str(error))
    left_out = [f"level {levels[position]}: {why}" for position, why in sorted(estimate.left_out.items())]
    used = " ".join(str(levels[position]) for position in estimate.levels_used)
    reason = "; ".join(filter(None, [estimate.reason, *left_out]))
    judged = verdict(claim, estimate)
    return estimate.order, estimate.low, estimate.high, used, nan if claim is None else claim, judged, reason


def _unknown(reason: str) -> OrderEstimate:
    return OrderEstimate("not testable", nan, nan, nan, reason=reason)
