"""Results as tables in the terminal: one a dataset, then the verdicts on the claims."""

import math
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.harness.results import Results

if TYPE_CHECKING:
    import pandas as pd

_STYLES = {"met": "green", "exceeded": "cyan", "missed": "bold red", "not testable": "yellow"}

#: Heading, columns of the results (a least and a greatest value are shown as a range), format.
_SHOWN = (
    ("distance", ("distance_max",), ".2e"),
    ("normal °", ("normal_max_deg",), ".3g"),
    ("K", ("gauss_min", "gauss_max"), ".3g"),
    ("H", ("mean_min", "mean_max"), ".3g"),
    ("epsilon °", ("epsilon_deg",), ".2g"),
)


def print_results(console: Console, results: Results) -> None:
    """Print a table for each dataset at its finest level, and the verdicts."""
    cells = results.cells
    for dataset in results.plan.datasets:
        own = cells[cells["dataset"] == dataset.spec]
        if not own.empty:
            console.print(_dataset_table(results, dataset.spec, own))
            console.print()
    console.print(_claims_table(results))
    for reason in _troubles(cells):
        console.print(reason, markup=False)


def wide(*, stderr: bool = False) -> Console:
    """Return the terminal's console; output that goes to a file is as wide as its tables."""
    console = Console(stderr=stderr)
    return console if console.is_terminal else Console(stderr=stderr, width=max(console.width, 160))


def _dataset_table(results: Results, dataset: str, own: "pd.DataFrame") -> Table:
    ok = own[own["status"] == "ok"]
    level = int((own if ok.empty else ok)["level"].max())
    faces = own.loc[own["level"] == level, "faces"].dropna()
    size = f", {int(faces.iloc[0])} faces" if len(faces) else ""
    table = Table(
        title=f"{escape(dataset)}, level {level}{size}",
        title_justify="left",
        title_style="bold",
        box=None,
        pad_edge=False,
    )
    table.add_column("scheme", no_wrap=True)
    shown = [one for one in _SHOWN if set(one[1]) <= set(own) and own[list(one[1])].notna().any(axis=None)]
    for heading, _, _ in shown:
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("order of distance", justify="right", no_wrap=True)
    orders = results.orders[(results.orders["dataset"] == dataset) & (results.orders["quantity"] == "distance_max")]
    for _, row in own[own["level"] == level].iterrows():
        if row["status"] != "ok":
            table.add_row(escape(row["scheme"]), f"[yellow]{row['status']}[/]", *[""] * (len(shown) - 1))
            continue
        numbers = [" .. ".join(_number(row[name], form) for name in names) for _, names, form in shown]
        table.add_row(escape(row["scheme"]), *numbers, _order(orders[orders["scheme"] == row["scheme"]]))
    return table


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)


def _order(rows: "pd.DataFrame") -> str:
    if rows.empty or math.isnan(rows["order"].iloc[0]):
        return "-"
    row = rows.iloc[0]
    return f"{row['order']:.2f} [{row['low']:.2f}, {row['high']:.2f}]"


def _claims_table(results: Results) -> Table:
    """Verdicts by scheme and claim, with the datasets that gave them."""
    table = Table(title="claims", title_justify="left", title_style="bold", box=None, pad_edge=False)
    for heading in ("scheme", "claim", "verdict", "on"):
        table.add_column(heading)
    judged = results.claims[~results.claims["claim"].str.startswith("matches")]
    for _, group in judged.groupby(["scheme", "claim", "verdict"], sort=False):
        scheme, claim, verdict = (str(group[name].iloc[0]) for name in ("scheme", "claim", "verdict"))
        datasets = ", ".join(name for name in group["dataset"] if name)
        style = _STYLES.get(verdict, "default")
        table.add_row(escape(scheme), escape(claim), f"[{style}]{verdict}[/]", escape(datasets))
    return table


def _troubles(cells: "pd.DataFrame") -> list[str]:
    """One line for each scheme and dataset with cells that are not ok: the levels, and the first reason."""
    bad = cells[cells["status"] != "ok"]
    lines = []
    for (status, scheme, dataset), group in bad.groupby(["status", "scheme", "dataset"], sort=False):
        levels = " ".join(str(level) for level in group["level"])
        lines.append(f"{status}: {scheme} on {dataset}, level {levels}: {group['reason'].iloc[0]}")
    return lines
