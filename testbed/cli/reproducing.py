"""``reproduce``: published figures next to what we measure."""

import dataclasses
import json
import math
import sys
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.cli.running import run_with_progress
from testbed.cli.tables import wide
from testbed.errors import TestbedError
from testbed.harness.results import read_results
from testbed.harness.run import TIMEOUT
from testbed_reports.derived import compare_derived, measure_derived
from testbed_reports.published import PublishedRow, compare, published_plan, remark, subject, write_published
from testbed_reports.published_table import NotRemade, derived_of, figures_of, not_remade_of, published_table
from testbed_reports.redrawn import draw_again, pictures_of, records
from testbed_reports.reproduction import write_reproduction

_STYLES = {
    "agrees": "green",
    "differs": "yellow",
    "data lost": "yellow",
    "unexplained": "bold red",
    "no value": "bold red",
}


def reproduce_command(paper: str, directory: Path, jobs: int | None, *, as_json: bool) -> int:
    """Measure the figures of a paper and print them next to the printed ones.

    Returns
    -------
    code
        1 if a figure was not measured or differs without an explanation, 130 if interrupted, else 0.
    """
    console = wide(stderr=as_json)
    figures, derived = figures_of(paper), derived_of(paper)
    pictures, absent = pictures_of(paper), not_remade_of(paper)
    if directory.exists() and not directory.is_dir():
        raise TestbedError(f"{directory} is a file: name a directory with -o")
    # a paper may have pictures only
    planned = published_plan(figures) if figures else None
    approximations = {(one.dataset, one.scheme, one.epsilon) for one in derived if one.source == "approximation"}
    console.print(
        f"{len(figures) + len(derived)} published figures: {len(planned.cells) if planned else 0} cells, "
        f"{len(approximations)} approximations and {len(pictures)} pictures, in {directory}/",
        markup=False,
    )
    rows: tuple[PublishedRow, ...] = ()
    if planned is not None:
        summary = run_with_progress(console, planned, directory, jobs, TIMEOUT, retry_failed=False)
        if summary.interrupted:
            console.print("interrupted: run the same command again to go on from here")
            return 130
        rows = compare(figures, read_results(directory))
        seconds = f"in {summary.seconds:.0f} s"
        console.print(f"{summary.total} cells: {summary.computed} computed, {summary.reused} reused, {seconds}")
    with console.status("approximations"):
        rows = (*rows, *compare_derived(derived, measure_derived(derived, jobs)))
    directory.mkdir(parents=True, exist_ok=True)
    written = write_published(directory, rows)
    with console.status("pictures") as status:
        drawn = draw_again(directory, pictures, note=lambda one: status.update(f"pictures: {one.paper}, {one.place}"))
    page = write_reproduction(directory, rows, pictures, drawn, absent)
    if as_json:
        numbers = [
            {name: _plain(value) for name, value in {**dataclasses.asdict(row), "difference": row.difference}.items()}
            for row in rows
        ]
        found = {
            "figures": numbers,
            "pictures": records(pictures, drawn),
            "not_remade": [dataclasses.asdict(one) for one in absent],
            "written": str(written),
        }
        json.dump(found, sys.stdout, indent=1)
        sys.stdout.write("\n")
    else:
        _print_rows(console, rows, absent)
        for path in (written, page, *drawn):
            console.print(f"written: {path}", markup=False, soft_wrap=True)
    return int(any(row.agreement in ("unexplained", "no value") for row in rows))


def _print_rows(console: Console, rows: tuple[PublishedRow, ...], absent: tuple[NotRemade, ...]) -> None:
    """Print the rows of each paper, a table for each surface, with the explanations as numbered notes at the end."""
    citations = published_table().citations
    for paper in dict.fromkeys([*(row.paper for row in rows), *(one.paper for one in absent)]):
        own = [row for row in rows if row.paper == paper]
        notes = {text: number for number, text in enumerate(dict.fromkeys(filter(None, map(remark, own))), start=1)}
        console.print(f"\n{paper}: {citations[paper]}\n", markup=False, highlight=False, soft_wrap=True)
        for number, surface in enumerate(dict.fromkeys(map(subject, own))):
            here = [row for row in own if subject(row) == surface]
            console.print(_table(surface, here, notes, header=number == 0))
            console.print()
        for text, number in notes.items():
            console.print(f"({number}) {text}", markup=False, highlight=False)
        missing = [one for one in absent if one.paper == paper]
        if missing:
            console.print("\nnot made again:", highlight=False)
        for one in missing:
            console.print(f"  {one.place}: {one.what}. {one.reason}", markup=False, highlight=False)
        agreeing = sum(row.agreement == "agrees" for row in own)
        console.print(f"\n{agreeing} of {len(own)} agree at the printed digits")


def _table(surface: str, rows: list[PublishedRow], notes: dict[str, int], *, header: bool) -> Table:
    """Rows about one surface; the widths are those of all such tables, so that they line up."""
    table = Table(
        title=escape(surface), title_justify="left", title_style="bold", box=None, pad_edge=False, show_header=header
    )
    for heading, width in (("printed in", 36), ("quantity", 32)):
        table.add_column(heading, width=width)
    for heading, width in (("printed", 10), ("measured", 19), ("difference", 10)):
        table.add_column(heading, width=width, justify="right", no_wrap=True)
    table.add_column(no_wrap=True)
    for row in rows:
        told = remark(row)
        verdict = f"[{_STYLES[row.verdict]}]{row.verdict}{f' ({notes[told]})' if told else ''}[/]"
        cells = (row.place, row.quantity, row.shown_printed, row.shown, row.shown_difference)
        table.add_row(*map(escape, cells), verdict)
    return table


def _plain(value: str | float) -> str | float | None:
    """JSON has no NaN and no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
