"""``run``, ``plan`` and ``report``: the main job and what is around it."""

import dataclasses
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn
from rich.table import Table

from testbed.cli.tables import print_results, wide
from testbed.errors import TestbedError
from testbed.harness.journal import read_entries
from testbed.harness.plan import Plan, make_plan
from testbed.harness.results import Results, read_results, write_parquet
from testbed.harness.run import Progress as State
from testbed.harness.run import RunSummary, run
from testbed.harness.selection import BUDGET
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.registry import catalogue, load, reports

#: Name of the report that ``--pdf`` asks for.
PDF = "pdf"


@dataclass(frozen=True)
class Grid:
    """The grid as asked for on the command line.

    Parameters
    ----------
    schemes, datasets
        Texts, or None for all.
    levels
        Text such as ``0:4``, or None for each dataset's own.
    boundaries
        Boundary curves on which schemes are computed besides their own.
    complete
        All levels also where nothing was chosen.
    """

    schemes: list[str] | None
    datasets: list[str] | None
    levels: str | None
    boundaries: list[str] | None = None
    complete: bool = False

    def plan(self) -> Plan:
        """Return the plan; its work is bounded if nothing was chosen."""
        plain = not (self.schemes or self.datasets or self.levels or self.boundaries or self.complete)
        return make_plan(
            self.schemes,
            self.datasets,
            self.levels,
            boundaries=self.boundaries or (),
            budget=BUDGET if plain else None,
        )


def left_out_lines(planned: Plan, asked: Grid) -> list[str]:
    """Return what a plan left out of what was asked for and how to get it, a line each."""
    lines = []
    unnamed = [name for name, one in catalogue(Dataset).items() if not one.compared]  # type: ignore[type-abstract]  # the kind
    if asked.datasets is None and unnamed:
        lines.append(f"left out, being made for one purpose: {', '.join(unnamed)}; -d {unnamed[0]} computes it")
    if planned.left_out:
        levels = ", ".join(f"{one.dataset} {' '.join(map(str, one.levels))}" for one in planned.left_out)
        lines.append(f"left out, to be done in minutes: levels {levels}; testbed run --all computes them")
    on_networks = [scheme.spec for scheme in planned.schemes if scheme.boundary]
    if on_networks and len({scheme.boundary for scheme in planned.schemes}) < len(catalogue(BoundaryCurve)):  # type: ignore[type-abstract]  # the kind
        lines.append(
            f"left out: other boundary curves for the {len(on_networks)} schemes that take them; -b all computes them "
            "(-b hermite -b planar some)"
        )
    apart = len(planned.schemes) * len(planned.datasets) - len(planned.pairs)
    if apart:
        lines.append(
            f"left out: {apart} pairs of a scheme and a dataset with other faces; name both to see the refusals"
        )
    return lines


def run_command(
    asked: Grid,
    jobs: int | None,
    directory: Path,
    timeout: float,
    *,
    retry_failed: bool,
    parquet: bool,
    pdf: bool,
    as_json: bool,
) -> int:
    """Run, report, and return the exit code: 1 if a cell failed or took too long, 130 if interrupted, else 0."""
    console = wide(stderr=as_json)
    for problem in load().problems:
        console.print(f"[red]not imported, and left out:[/red] {escape(problem.source)}: {escape(problem.message)}")
    if directory.exists() and not directory.is_dir():
        raise TestbedError(f"{directory} is a file: name a directory with -o")
    planned = asked.plan()
    grid = f"{len(planned.schemes)} schemes, {len(planned.datasets)} datasets: {len(planned.cells)} cells"
    console.print(f"{grid}, in {directory}/", markup=False)
    summary = run_with_progress(console, planned, directory, jobs, timeout, retry_failed=retry_failed)
    if summary.interrupted:
        console.print("interrupted: run the same command again to go on from here")
        return 130
    results = read_results(directory)
    written = _write_reports(console, directory, pdf=pdf)
    if parquet:
        write_parquet(results, directory / "results.parquet")
    if as_json:
        _print_json(results, summary, written)
    else:
        print_results(console, results)
        _print_end(console, summary, written)
        for line in left_out_lines(planned, asked):
            console.print(line, markup=False)
    return int(any(summary.counts.get(status) for status in ("failed", "timeout")))


def plan_command(asked: Grid, directory: Path, *, as_json: bool) -> None:
    """Print the grid with what is known already and the refusals that can be foreseen."""
    planned = asked.plan()
    known: set[str] = set()
    if (directory / "journal.sqlite").exists():
        known = set(read_entries(directory, (cell.key for cell in planned.cells)))
    if as_json:
        cells = [
            {
                "scheme": cell.scheme,
                "dataset": cell.dataset,
                "level": cell.level,
                "faces": cell.faces,
                "known": cell.key in known,
                "foreseen": cell.foreseen,
            }
            for cell in planned.cells
        ]
        _dump({"cells": cells, "left_out": [dataclasses.asdict(one) for one in planned.left_out]})
        return
    console = wide()
    table = Table("dataset", "level", "faces", "to compute", "known", "refused, as foreseen", box=None, pad_edge=False)
    for dataset in planned.datasets:
        for level in sorted({cell.level for cell in planned.cells if cell.dataset == dataset.spec}):
            row = [cell for cell in planned.cells if (cell.dataset, cell.level) == (dataset.spec, level)]
            faces = next((str(cell.faces) for cell in row if cell.faces is not None), "?")
            fresh = [cell for cell in row if cell.key not in known]
            refused = ", ".join(cell.scheme for cell in row if cell.foreseen)
            table.add_row(
                escape(dataset.spec), str(level), faces, str(len(fresh)), str(len(row) - len(fresh)), escape(refused)
            )
    console.print(table)
    new = sum(cell.key not in known for cell in planned.cells)
    names = ", ".join(scheme.spec for scheme in planned.schemes)
    console.print(f"\nschemes: {names}", markup=False)
    console.print(f"{len(planned.cells)} cells, {new} to compute, {len(planned.cells) - new} known in {directory}/")
    for reason in sorted(
        {f"{cell.scheme} on {cell.dataset}: {cell.foreseen}" for cell in planned.cells if cell.foreseen}
    ):
        console.print(f"refused: {reason}", markup=False)
    for line in left_out_lines(planned, asked):
        console.print(line, markup=False)


def report_command(directory: Path, *, pdf: bool, as_json: bool) -> int:
    """Write the reports of a results directory again; return 1 if a cell of it failed, else 0."""
    console = wide(stderr=as_json)
    results = read_results(directory)
    written = _write_reports(console, directory, pdf=pdf)
    if as_json:
        _print_json(results, None, written)
    else:
        print_results(console, results)
        _print_end(console, None, written)
    return int(results.cells["status"].isin(["failed", "timeout"]).any())


def run_with_progress(
    console: Console,
    planned: Plan,
    directory: Path,
    jobs: int | None,
    timeout: float,
    *,
    retry_failed: bool,
    tables: bool = True,
) -> RunSummary:
    """Run a plan with a progress bar, or with a line now and then where there is no terminal; failures are printed."""
    columns = (
        SpinnerColumn(),
        BarColumn(bar_width=24),
        MofNCompleteColumn(),
        TextColumn("{task.fields[left]}"),
        TextColumn("[dim]{task.fields[current]}"),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("", total=len(planned.cells), left="", current="starting workers")
        last = time.monotonic()

        def show(state: State) -> None:
            nonlocal last
            running = "; ".join(map(str, state.running)) or ("waiting for another run" if state.waiting else "")
            left = "" if state.seconds_left is None else _duration(state.seconds_left)
            bar.update(task, completed=state.done, left=left, current=escape(running))
            if (
                state.finished is not None
                and state.outcome is not None
                and state.outcome.status in ("failed", "timeout")
            ):
                console.print(
                    f"[red]{state.outcome.status}[/red] {escape(f'{state.finished}: {state.outcome.reason}')}"
                )
            # without a terminal a line now and then says as much as the bar
            if not console.is_terminal and time.monotonic() - last > 15.0:
                last = time.monotonic()
                console.print(
                    f"{state.done} of {state.total} cells done, {left or 'time left unknown'}: {running}", markup=False
                )

        return run(
            planned,
            directory,
            jobs=jobs,
            timeout=timeout,
            retry_failed=retry_failed,
            progress=show,
            command=["testbed", *sys.argv[1:]],
            tables=tables,
        )


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s left" if minutes else f"{rest} s left"


def _write_reports(console: Console, directory: Path, *, pdf: bool) -> list[Path]:
    """Let every registered report write, the PDF if asked for; one that fails costs itself only, and says so."""
    written: list[Path] = []
    for report in reports():
        if report.on_request and not (pdf and report.name == PDF):
            continue
        try:
            written.extend(report.write(directory))
        except TestbedError:
            raise
        except Exception as error:  # noqa: BLE001 - a third party's report must not cost the run its other ends
            console.print(
                f"[red]report {escape(str(report))} failed:[/red] {escape(f'{type(error).__name__}: {error}')}"
            )
            if "--traceback" in sys.argv:
                console.print_exception()
    return written


def _print_end(console: Console, summary: RunSummary | None, written: Sequence[Path]) -> None:
    if summary is not None:
        counts = ", ".join(f"{count} {status}" for status, count in summary.counts.items())
        console.print(
            f"{summary.total} cells: {counts}; {summary.computed} computed, {summary.reused} reused, "
            f"in {summary.seconds:.0f} s"
        )
    for path in written:
        console.print(f"written: {path}", markup=False, soft_wrap=True)


def _print_json(results: Results, summary: RunSummary | None, written: Sequence[Path]) -> None:
    tables = {
        name: json.loads(getattr(results, name).to_json(orient="records")) for name in ("cells", "orders", "claims")
    }
    counts = dict(results.cells["status"].value_counts()) if summary is None else dict(summary.counts)
    _dump(
        {**tables, "counts": {name: int(count) for name, count in counts.items()}, "written": list(map(str, written))}
    )


def _dump(value: Any) -> None:
    json.dump(value, sys.stdout, indent=1)
    sys.stdout.write("\n")
