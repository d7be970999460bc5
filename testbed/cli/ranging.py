"""``ranges``: surfaces over data above a plane compared: who stays above, who stays smooth, who is nearer the truth."""

import dataclasses
import json
import math
import sys
import textwrap
from pathlib import Path
from typing import Any, get_args

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from testbed.cli.tables import wide
from testbed.errors import TestbedError
from testbed_reports.formatting import shorten
from testbed_reports.range_comparison import Uses, comparison
from testbed_reports.range_page import write_page
from testbed_reports.range_summary import SchemeSummary, sentences, summaries
from testbed_reports.range_tables import RangeRow, measure_sets, write_rows


def ranges_command(directory: Path, most: int | None, jobs: int | None, *, pictures: bool, as_json: bool) -> int:
    """Compare, write ``ranges.csv`` and ``ranges.html``, and print tables and a summary.

    Parameters
    ----------
    directory
        Where the results go.
    most
        How many of the sets, the first ones; all for None.
    jobs
        Worker processes; one a processor for None.
    pictures
        Whether the page has pictures.
    as_json
        Print JSON instead of tables.

    Returns
    -------
    code
        1 if a surface failed, else 0; a refusal is a result.
    """
    console = wide(stderr=as_json)
    if directory.exists() and not directory.is_dir():
        raise TestbedError(f"{directory} is a file: name a directory with -o")
    asked = comparison()
    sets = asked.sets[:most]
    console.print(f"{len(sets)} sets of data, {len(asked.schemes)} schemes, in {directory}/", markup=False)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("comparing", total=len(sets))
        found = measure_sets(
            sets, asked.schemes, jobs, lambda done: bar.update(task, completed=done), pictures=pictures
        )
    directory.mkdir(parents=True, exist_ok=True)
    rows = tuple(row for one in found for row in one.rows)
    written = [write_rows(directory, rows), write_page(directory, found)]
    if as_json:
        record = {
            "rows": [_plain(row) for row in rows],
            "summary": sentences(rows),
            "written": list(map(str, written)),
        }
        json.dump(record, sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        _print(console, rows)
        for path in written:
            console.print(f"written: {path}", markup=False, soft_wrap=True)
    return int(any(row.status == "failed" for row in rows))


def _plain(row: RangeRow) -> dict[str, Any]:
    """JSON has no NaN and no infinity."""
    values = dataclasses.asdict(row)
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in values.items()
    }


def _print(console: Console, rows: tuple[RangeRow, ...]) -> None:
    for uses in get_args(Uses):
        if own := tuple(row for row in rows if row.uses == uses):
            console.print(_lowest(own, uses))
            console.print()
    console.print(_schemes(summaries(rows)))
    console.print()
    for one in summaries(rows):
        if one.branches:
            counts = ", ".join(f"{count} {kind}" for kind, count in one.branches)
            console.print(f"{one.label}: {counts}", markup=False, highlight=False)
    for label, status in dict.fromkeys((row.label, row.status) for row in rows if row.status != "ok"):
        without = [row for row in rows if (row.label, row.status) == (label, status)]
        where = f"{len(without)} sets, the first {without[0].place}" if len(without) > 1 else without[0].place
        console.print(f"{status}: {label} on {where}: {without[0].reason}", markup=False, highlight=False)
    console.print()
    for sentence in sentences(rows):
        console.print(sentence, markup=False, highlight=False)


def _lowest(rows: tuple[RangeRow, ...], uses: str) -> Table:
    """Return the table of the lowest signed distances, a set a row."""
    table = Table(
        title=f"lowest signed distance from the plane: from the {uses}", title_justify="left", box=None, pad_edge=False
    )
    table.add_column("set", no_wrap=True)
    labels = tuple(dict.fromkeys(row.label for row in rows))
    for label in labels:
        table.add_column("\n".join(textwrap.wrap(label, 14)), justify="right", no_wrap=True)
    for place, plane in dict.fromkeys((row.place, row.plane) for row in rows):
        own = {row.label: row for row in rows if (row.place, row.plane) == (place, plane)}
        table.add_row(escape(place), *(_cell(own.get(label)) for label in labels))
    return table


def _cell(row: RangeRow | None) -> str:
    """Return the lowest distance: green where it is proved not to be negative, red where it is negative."""
    if row is None:
        return "-"
    if row.status != "ok":
        return f"[yellow]{row.status}[/]"
    style = "green" if row.guaranteed else "default" if row.above else "red"
    return f"[{style}]{shorten(row.lowest)}[/]"


def _schemes(found: tuple[SchemeSummary, ...]) -> Table:
    table = Table(title="schemes over all sets", title_justify="left", box=None, pad_edge=False)
    headings = ("scheme", "built", "above", "proved", "smooth", "lowest", "edges °", "patches °", "data", "rms factor")
    for heading in (*headings, "nearest", "moved", "at most", "seconds"):
        table.add_column(heading, justify="left" if heading == "scheme" else "right", no_wrap=True)
    for one in found:
        table.add_row(
            escape(one.label),
            f"{one.built}/{one.sets}",
            str(one.above),
            str(one.guaranteed),
            str(one.smooth),
            *(shorten(value) for value in (one.lowest, one.epsilon_deg, one.crease_deg, one.data_max)),
            _number(one.factor),
            f"{one.nearest}/{one.known}" if one.known else "-",
            *(_number(value) for value in (one.moved, one.most_moved, one.seconds)),
        )
    return table


def _number(value: float) -> str:
    return "-" if math.isnan(value) else shorten(value)
