"""Run a plan: compute what the journal does not have, in worker processes, and record every cell as it is done."""

import os
import platform
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any, Final, TypeAlias

from testbed import __version__
from testbed.errors import TestbedError
from testbed.harness.cell import Outcome, SourceChanged, compute
from testbed.harness.journal import Claim, Entry, Journal, write_whole
from testbed.harness.plan import Cell, Plan
from testbed.harness.results import export, write_record
from testbed.harness.selection import cell_weight
from testbed.harness.workers import Died, Returned, TimedOut, Workers
from testbed.harness.workers import Outcome as WorkerOutcome

#: Seconds a cell may take.
TIMEOUT: Final = 300.0
#: Seconds between looks at cells that another run has claimed, and between reports of progress.
TICK: Final = 0.25

#: Libraries that take part in the numbers.
LIBRARIES: Final = ("numpy", "scipy", "pandas", "trimesh", "pluggy", "filelock")


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Parameters
    ----------
    total, done, reused
        Cells of the plan, those that have a result, and how many of these had one before the run began.
    counts
        Cells done by status.
    running
        Cells being computed by this run.
    waiting
        Cells being computed by other runs on the same directory.
    seconds_left
        An estimate, or None while there is nothing to base it on.
    finished
        The cell that has just been done, or None.
    outcome
        What came of it.
    """

    total: int
    done: int
    reused: int
    counts: Mapping[str, int]
    running: tuple[Cell, ...]
    waiting: int
    seconds_left: float | None
    finished: Cell | None = None
    outcome: Outcome | None = None


#: Called in the run's own thread, for every cell done and a few times a second.
Callback: TypeAlias = Callable[[Progress], None]


@dataclass(frozen=True)
class RunSummary:
    """What a run did.

    Parameters
    ----------
    directory
        Where the results are.
    total, computed, reused, shared
        Cells of the plan; computed by this run; found in the journal; computed meanwhile by other runs.
    counts
        Cells by status.
    seconds
        How long it took.
    interrupted
        Whether it was interrupted; then nothing was exported, and another run goes on from here.
    """

    directory: Path
    total: int
    computed: int
    reused: int
    shared: int
    counts: Mapping[str, int]
    seconds: float
    interrupted: bool


@dataclass
class _Grid:
    """State of a run: what is done, what is to do, what is under way."""

    plan: Plan
    reused: int
    done: dict[str, Outcome]
    superseded: dict[str, tuple[str, float]]
    todo: deque[Cell]
    taken: list[Cell] = field(default_factory=list)
    running: dict[int, tuple[Cell, float]] = field(default_factory=dict)
    changed: list[str] = field(default_factory=list)
    computed: int = 0
    shared: int = 0

    @property
    def unfinished(self) -> bool:
        return bool(self.todo or self.taken or self.running)


def run(
    plan: Plan,
    directory: Path,
    *,
    jobs: int | None = None,
    timeout: float = TIMEOUT,
    retry_failed: bool = False,
    progress: Callback | None = None,
    command: Sequence[str] = (),
    tables: bool = True,
) -> RunSummary:
    """Compute a plan's cells into a directory, and export the results there.

    Cells that the journal has under their key are reused. Timeouts, cells out of memory and cells whose worker was
    killed from outside are computed again, since the machine had a part in them; other failures stay until a source
    changes, or ``retry_failed`` is given. Results do not depend on ``jobs``: one job, too, runs in a worker process.

    Parameters
    ----------
    plan
        The grid.
    directory
        Where the journal and the exports go; several runs may use it at once and share the work.
    jobs
        Worker processes; None for one a processor.
    timeout
        Seconds a cell may take.
    retry_failed
        Compute all failed cells again.
    progress
        Called with how far the run is.
    command
        The command line, for ``run.json``.
    tables
        Whether to export ``results.csv``, ``orders.csv`` and ``claims.csv``; studies have tables of their own.

    Raises
    ------
    TestbedError
        The directory holds no journal of this version, workers do not come up, or a source changed during the run.
    """
    started = time.time()
    directory.mkdir(parents=True, exist_ok=True)
    interrupted = False
    with Journal(directory) as journal:
        record = environment(plan, command, jobs or processors(), timeout)
        journal.begin(record)
        write_whole(directory / "plan.json", plan.to_json())
        entries = journal.entries(cell.key for cell in plan.cells)
        grid = _grid(plan, entries, retry_failed)
        try:
            if grid.todo:
                count = min(jobs or processors(), len(grid.todo))
                with Workers(count, timeout, journal.worker_directory) as workers:
                    _work(grid, journal, workers, progress or _silent)
        except KeyboardInterrupt:
            interrupted = True
    if grid.changed:
        raise TestbedError(
            f"the source of {grid.changed[0]} changed while the run was under way, and {len(grid.changed)} of "
            f"{len(plan.cells)} cells are not computed: run again"
        )
    seconds = time.time() - started
    counts = _counts(grid)
    summary = RunSummary(
        directory, len(plan.cells), grid.computed, grid.reused, grid.shared, counts, seconds, interrupted
    )
    if not interrupted:
        cells = {"total": summary.total, "computed": summary.computed, "reused": summary.reused}
        times = {"started": _stamp(started), "finished": _stamp(time.time()), "seconds": round(seconds, 3)}
        record = {**record, **times, "cells": {**cells, "shared": summary.shared, **counts}}
        if tables:
            export(directory, record)
        else:
            write_record(directory, record)
    return summary


def processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def environment(plan: Plan, command: Sequence[str], jobs: int, timeout: float) -> dict[str, Any]:
    """Return what ``run.json`` says of a run beforehand: versions, machine, command line, source hashes."""
    versions = {name: metadata.version(name) for name in LIBRARIES}
    return {
        "versions": {"testbed": __version__, "python": platform.python_version(), **versions},
        "machine": {
            "system": platform.system(),
            "release": platform.release(),
            "architecture": platform.machine(),
            "processors": processors(),
        },
        "command": list(command),
        "jobs": jobs,
        "timeout": timeout,
        "left_out": {one.dataset: list(one.levels) for one in plan.left_out},
        "sources": {
            "schemes": {one.spec: one.source for one in plan.schemes},
            "datasets": {one.spec: one.source for one in plan.datasets},
            "measures": {one.spec: one.source for one in plan.measures},
        },
    }


def _grid(plan: Plan, entries: Mapping[str, Entry], retry_failed: bool) -> _Grid:
    again = {
        key: entry.attempt
        for key, entry in entries.items()
        if entry.outcome.status == "timeout"
        or entry.outcome.retry
        or (retry_failed and entry.outcome.status == "failed")
    }
    done = {key: entry.outcome for key, entry in entries.items() if key not in again}
    missing = [cell for cell in plan.cells if cell.key not in done]
    # the largest first, so that no worker is left alone with one at the end; unknown sizes before all
    missing.sort(key=lambda cell: -1 if cell.faces is None else 1 / (1 + cell.faces))
    return _Grid(plan, len(plan.cells) - len(missing), done, again, deque(missing))


def _work(grid: _Grid, journal: Journal, workers: Workers, progress: Callback) -> None:
    """Claim, compute and record until every cell has a result."""
    clock = _Clock(grid)
    number = 0
    progress(clock.progress())
    while grid.unfinished:
        while workers.free and grid.todo:
            cell = grid.todo.popleft()
            match journal.claim(cell.key, grid.superseded.get(cell.key)):
                case Claim.GRANTED:
                    number += 1
                    grid.running[number] = (cell, time.time())
                    workers.submit(number, compute, grid.plan.task(cell))
                case Claim.TAKEN:
                    grid.taken.append(cell)
                case Claim.DONE:
                    grid.done[cell.key] = journal.entries([cell.key])[cell.key].outcome
                    grid.shared += 1
        for result in workers.wait(TICK):
            cell, began = grid.running.pop(result.task)
            outcome = outcome_of(result)
            if isinstance(outcome, SourceChanged):
                grid.changed.append(outcome.plugin)
                continue
            journal.record(cell.key, (cell.scheme, cell.dataset, cell.level), outcome, began)
            grid.done[cell.key] = outcome
            grid.computed += 1
            clock.note(cell, time.time() - began)
            progress(clock.progress(cell, outcome))
        progress(clock.progress())
        # what another run was computing may be done by now, or free because that run is dead
        grid.todo.extend(grid.taken)
        grid.taken.clear()


def _counts(grid: _Grid) -> dict[str, int]:
    return dict(sorted(Counter(str(outcome.status) for outcome in grid.done.values()).items()))


def outcome_of(result: WorkerOutcome) -> Outcome | SourceChanged:
    """Return what came of a cell whose computation a worker has ended, in whatever way."""
    match result:
        case Returned(_, (Outcome() | SourceChanged()) as outcome):
            return outcome
        case TimedOut(_, seconds):
            return Outcome("timeout", f"stopped after {seconds:g} seconds", retry=True)
        case Died(_, reason, log, killed):
            return Outcome("failed", reason, log, retry=killed)
        case _:
            raise TypeError(f"a worker answered with {result!r}")


class _Clock:
    """Estimates the time left from what cells of a scheme took so far, by face."""

    def __init__(self, grid: _Grid) -> None:
        self._grid = grid
        self._spent: dict[str, list[float]] = {}

    def note(self, cell: Cell, seconds: float) -> None:
        """Learn from a finished cell."""
        for name in (cell.scheme, ""):
            total = self._spent.setdefault(name, [0.0, 0.0])
            total[0] += seconds
            total[1] += cell_weight(cell.faces)

    def progress(self, finished: Cell | None = None, outcome: Outcome | None = None) -> Progress:
        """Return how far the run is."""
        grid = self._grid
        running = tuple(cell for cell, _ in grid.running.values())
        return Progress(
            len(grid.plan.cells),
            len(grid.plan.cells) - len(grid.todo) - len(grid.taken) - len(running),
            grid.reused,
            _counts(grid),
            running,
            len(grid.taken),
            self._left(),
            finished,
            outcome,
        )

    def _left(self) -> float | None:
        if "" not in self._spent:
            return None
        grid, now = self._grid, time.time()

        def expected(cell: Cell) -> float:
            seconds, weight = self._spent.get(cell.scheme, self._spent[""])
            return seconds / weight * cell_weight(cell.faces)

        ahead = sum(expected(cell) for cell in (*grid.todo, *grid.taken))
        under_way = [max(0.0, expected(cell) - (now - began)) for cell, began in grid.running.values()]
        return (ahead + sum(under_way)) / max(1, len(under_way))


def _silent(progress: Progress) -> None:
    del progress


def _stamp(seconds: float) -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%S%z", time.localtime(seconds))
