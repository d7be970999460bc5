"""``sweep`` and ``tune``: what the free parameters of a scheme do, and where they are best."""

import dataclasses
import json
import math
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from testbed import registry
from testbed.cli.running import run_with_progress
from testbed.cli.tables import wide
from testbed.errors import TestbedError
from testbed.harness.journal import write_whole
from testbed.harness.objectives import exact_extremes, measures_for, objective
from testbed.harness.parameters import free_parameters, parse_interval
from testbed.harness.plan import make_plan
from testbed.harness.run import TIMEOUT
from testbed.harness.sweep import Best, Sweep, best, make_sweep, parse_single_level, read_sweep, write_sweep
from testbed.harness.trials import Callback, Trial, Trials
from testbed.harness.tune import Tuned, trace, tune
from testbed_reports.sweep_plot import write_sweep_plot

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Study:
    """A study as asked for on the command line.

    Parameters
    ----------
    scheme, datasets, level
        Texts.
    over
        Parameters with their values or bounds, as texts.
    measures
        Names of the quantities looked at.
    maximise
        Whether they are to be large.
    jobs
        Worker processes, or None.
    directory
        Where the results go.
    """

    scheme: str
    datasets: list[str]
    level: str
    over: list[str]
    measures: list[str]
    maximise: bool
    jobs: int | None
    directory: Path


def sweep_command(study: Study, *, as_json: bool) -> int:
    """Run a sweep, write its table and plot, and print the best settings.

    Returns
    -------
    code
        1 if a cell failed or took too long, 130 if interrupted, else 0.
    """
    console = wide(stderr=as_json)
    _check_directory(study.directory)
    objectives = [objective(name) for name in dict.fromkeys(study.measures)]
    sweep = make_sweep(study.scheme, study.over, study.datasets, study.level, objectives, maximise=study.maximise)
    values = " x ".join(f"{len(axis.texts)} values of {axis.name}" for axis in sweep.axes)
    console.print(f"{sweep.scheme}: {values}, {len(sweep.plan.cells)} cells, in {study.directory}/", markup=False)
    summary = run_with_progress(
        console, sweep.plan, study.directory, study.jobs, TIMEOUT, retry_failed=False, tables=False
    )
    if summary.interrupted:
        console.print("interrupted: run the same command again to go on from here")
        return 130
    table = read_sweep(sweep, study.directory)
    found = best(sweep, table)
    written = [write_sweep(study.directory, table), *write_sweep_plot(study.directory, sweep, table)]
    if as_json:
        _dump(
            {
                "scheme": sweep.scheme,
                "parameters": {axis.name: axis.texts for axis in sweep.axes},
                "best": [_plain(dataclasses.asdict(one)) for one in found],
                "counts": dict(summary.counts),
                "written": list(map(str, written)),
            }
        )
    else:
        _print_best(console, sweep, found)
        _print_troubles(console, table)
        counts = ", ".join(f"{count} {status}" for status, count in summary.counts.items())
        console.print(
            f"{summary.total} cells: {counts}; {summary.computed} computed, {summary.reused} reused, "
            f"in {summary.seconds:.0f} s"
        )
        for path in written:
            console.print(f"written: {path}", markup=False, soft_wrap=True)
    return int(any(summary.counts.get(status) for status in ("failed", "timeout")))


def tune_command(study: Study, *, as_json: bool) -> int:
    """Search for the best setting of a scheme's parameters, and print it with what it gains.

    Returns
    -------
    code
        1 if a cell failed or took too long, 130 if interrupted, else 0.
    """
    console = wide(stderr=as_json)
    _check_directory(study.directory)
    sought = objective(study.measures[0])
    base = registry.scheme(study.scheme)
    intervals = tuple(parse_interval(text, base) for text in study.over) or free_parameters(base)
    (level,) = parse_single_level(study.level)
    plan = make_plan([str(base)], study.datasets, study.level, measures_for([sought]))
    exact = {one.spec: exact_extremes(one.spec, level, [sought]) for one in plan.datasets}
    ranges = ", ".join(f"{one.name} from {one.low:g} to {one.high:g}" for one in intervals)
    datasets = tuple(one.spec for one in plan.datasets)
    aim = "maximise" if study.maximise else "minimise"
    console.print(f"{base} on {', '.join(datasets)}, level {level}", markup=False)
    console.print(f"{aim} {sought.name} ({sought.meaning}) over {ranges}", markup=False)
    study.directory.mkdir(parents=True, exist_ok=True)
    with _showing(console, len(datasets), maximise=study.maximise) as note:
        trials = Trials(
            plan, sought, exact, study.directory, jobs=study.jobs, command=["testbed", *sys.argv[1:]], note=note
        )
        try:
            with trials:
                tuned = tune(str(base), intervals, trials, maximise=study.maximise)
        except KeyboardInterrupt:
            console.print("interrupted: run the same command again to go on from here")
            return 130
    record = {
        "scheme": str(base),
        "datasets": datasets,
        "level": level,
        "objective": {"name": sought.name, "meaning": sought.meaning, "aim": aim},
        "bounds": {one.name: (one.low, one.high) for one in intervals},
        "given": _record(tuned.given, datasets),
        "best": _record(tuned.best, datasets) | {"parameters": dict(tuned.parameters), "on_bound": tuned.on_bound},
        "gain": tuned.gain,
        "settings": tuned.settings,
        "without_value": tuned.without_value,
    }
    written = [study.directory / "tune.json", study.directory / "tune.csv"]
    write_whole(written[0], json.dumps(_plain(record), indent=1) + "\n")
    write_whole(written[1], trace(trials, intervals).to_csv(index=False, lineterminator="\n"))
    failed = [
        f"{outcome.status}: {trial.setting} on {dataset}: {outcome.reason}"
        for trial in trials.done.values()
        for dataset, outcome in zip(datasets, trial.outcomes, strict=True)
        if outcome.status in ("failed", "timeout")
    ]
    if as_json:
        _dump(_plain(record) | {"written": list(map(str, written))})
        return int(bool(failed))
    _print_tuned(console, tuned, datasets, sought.name)
    for name in tuned.on_bound:
        console.print(f"the best {name} lies on a bound: widen it with --over {name}=low:high to see what is beyond")
    console.print(
        f"{tuned.settings} settings tried, {tuned.without_value} of them without a value: "
        f"{trials.computed} cells computed, {trials.reused} reused"
    )
    if failed:
        more = f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""
        console.print(f"{failed[0]}{more}", markup=False)
    for path in written:
        console.print(f"written: {path}", markup=False, soft_wrap=True)
    return int(bool(failed))


def _check_directory(directory: Path) -> None:
    if directory.exists() and not directory.is_dir():
        raise TestbedError(f"{directory} is a file: name a directory with -o")


@contextmanager
def _showing(console: Console, datasets: int, *, maximise: bool) -> Iterator[Callback]:
    """Show how far a search is: a line that changes, or one now and then where there is no terminal."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting workers", total=None)
        last = time.monotonic()
        tried, best_value = 0, math.nan

        def note(trial: Trial) -> None:
            nonlocal last, tried, best_value
            tried += 1
            value = trial.values[0]
            if trial.valid and not (best_value >= value if maximise else best_value <= value):
                best_value = value
            # on several datasets it is not the value of one that counts
            text = f"{tried} settings tried" + (f", best so far {best_value:.4g}" if datasets == 1 else "")
            bar.update(task, description=text)
            if not console.is_terminal and time.monotonic() - last > 15.0:
                last = time.monotonic()
                console.print(text, markup=False)

        yield note


def _print_best(console: Console, sweep: Sweep, found: list[Best]) -> None:
    """Print the best settings, a table for each quantity."""
    for one in sweep.objectives:
        most = "largest" if sweep.maximise else "smallest"
        console.print(
            f"[bold]{most} {one.name}[/bold] ({escape(one.meaning)}), level {sweep.level}",
            highlight=False,
            soft_wrap=True,
        )
        table = _table()
        table.add_column("on", no_wrap=True)
        table.add_column("best", justify="right", no_wrap=True)
        table.add_column("as given", justify="right", no_wrap=True)
        table.add_column("setting", overflow="fold")
        own = [row for row in found if row.objective == one.name]
        for row in own:
            if len(row.datasets) == 1:
                table.add_row(
                    escape(row.datasets[0]), _number(row.values[0]), _number(row.given[0]), escape(row.setting)
                )
        console.print(table)
        for row in own:
            if len(row.datasets) > 1:
                values = ", ".join(
                    f"{_number(value)} on {on}" for value, on in zip(row.values, row.datasets, strict=True)
                )
                console.print(
                    f"best on all: {row.setting}, {values}: {row.worst_ratio:.3g} times the best at worst", markup=False
                )
            for name in row.on_end:
                console.print(f"{name} of {row.setting} is at the end of its range: try a wider one", markup=False)
        if not own:
            console.print("no setting has a value")
        console.print()


def _print_troubles(console: Console, table: "pd.DataFrame") -> None:
    """Print why cells have no result, each reason once."""
    bad = table[table["status"] != "ok"]
    for (status, dataset, reason), group in bad.groupby(["status", "dataset", "reason"], sort=False):
        more = f" and {len(group) - 1} more" if len(group) > 1 else ""
        console.print(f"{status}: {group['scheme'].iloc[0]}{more} on {dataset}: {reason}", markup=False)


def _print_tuned(console: Console, tuned: Tuned, datasets: Sequence[str], name: str) -> None:
    table = _table()
    table.add_column("on", no_wrap=True)
    for heading in (f"{name} as given", "at best", "K as given", "at best"):
        table.add_column(heading, justify="right", no_wrap=True)
    for number, dataset in enumerate(datasets):
        values = [_number(trial.values[number]) for trial in (tuned.given, tuned.best)]
        ranges = [_range(trial, number) for trial in (tuned.given, tuned.best)]
        table.add_row(escape(dataset), *values, *ranges)
    console.print(table)
    for dataset, outcome in zip(datasets, tuned.given.outcomes, strict=True):
        if outcome.reason:
            console.print(f"as given, {outcome.status} on {dataset}: {outcome.reason}", markup=False)
    console.print()
    console.print(f"best setting  {tuned.best.setting}", markup=False, highlight=False, soft_wrap=True)
    if tuned.gain is not None:
        worst = ", on the dataset that gains least" if len(datasets) > 1 else ""
        console.print(f"gain          {100.0 * tuned.gain:.1f} %{worst}", highlight=False)


def _table() -> Table:
    return Table(box=None, pad_edge=False)


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.4g}"


def _range(trial: Trial, number: int) -> str:
    """Return the range of the Gaussian curvature, if the objective's measures have it."""
    measured = trial.outcomes[number].values or {}
    ends = [measured.get(name) for name in ("gauss_min", "gauss_max")]
    return " .. ".join(f"{end:.4f}" for end in ends if isinstance(end, int | float)) or "-"


def _record(trial: Trial, datasets: Sequence[str]) -> dict[str, Any]:
    outcomes = [
        {"dataset": on, "status": one.status, "reason": one.reason, "value": value, "measured": one.values or {}}
        for on, one, value in zip(datasets, trial.outcomes, trial.values, strict=True)
    ]
    return {"setting": trial.setting, "outcomes": outcomes}


def _plain(value: Any) -> Any:
    """Return a value as JSON has it, without NaN and infinity."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _dump(value: Any) -> None:
    json.dump(value, sys.stdout, indent=1)
    sys.stdout.write("\n")
