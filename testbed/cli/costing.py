"""``costs``: what S-patches cost to store and to evaluate, next to the tables of the thesis."""

import dataclasses
import json
import sys

from rich.table import Table

from testbed import registry
from testbed.cli.tables import wide
from testbed_reports.cost_tables import CostRow, cost_rows


def costs_command(dataset: str, triangles: int | None, *, as_json: bool) -> None:
    """Print storage and evaluation cost of a network of S-patches and of cubic triangles in its place.

    Parameters
    ----------
    dataset
        Text of a dataset of S-patches.
    triangles
        Cubic triangles of the approximation; as many as are printed for None.
    as_json
        Print JSON instead of a table.

    Raises
    ------
    TestbedError
        The dataset is no network of S-patches.
    """
    rows = cost_rows(registry.dataset(dataset), triangles)
    if as_json:
        json.dump([dataclasses.asdict(row) for row in rows], sys.stdout, indent=1)
        sys.stdout.write("\n")
        return
    console = wide()
    explanations = dict.fromkeys(row.explanation for row in rows if row.explanation)
    notes = {text: number for number, text in enumerate(explanations, start=1)}
    console.print(_table(rows, notes))
    for text, number in notes.items():
        console.print(f"({number}) {text}", markup=False, highlight=False)


def _table(rows: tuple[CostRow, ...], notes: dict[str, int]) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("patches", no_wrap=True)
    table.add_column("quantity", no_wrap=True)
    table.add_column("ours", justify="right", no_wrap=True)
    if printed := any(row.printed for row in rows):
        table.add_column("printed", justify="right", no_wrap=True)
        table.add_column(no_wrap=True)
    before = ""
    for row in rows:
        cells = [row.patches if row.patches != before else "", row.quantity, f"{row.measured:.6g}"]
        if printed:
            note = f" ({notes[row.explanation]})" if row.explanation else ""
            remark = "" if row.agrees else f"[yellow]differs{note}[/]"
            cells += [row.printed_text, remark]
        table.add_row(*cells)
        before = row.patches
    return table
