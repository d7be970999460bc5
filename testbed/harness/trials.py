"""Trials: settings of a scheme computed as a search asks for them, each once, in workers that stay up meanwhile."""

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Final, Self, TypeAlias

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome, SourceChanged, Task, compute
from testbed.harness.journal import Claim, Entry, Journal
from testbed.harness.objectives import Extremes, Objective
from testbed.harness.plan import Cell, Plan, cell_key
from testbed.harness.run import TICK, TIMEOUT, environment, outcome_of, processors
from testbed.harness.workers import Workers


@dataclass(frozen=True)
class Trial:
    """A setting and what came of it.

    Parameters
    ----------
    setting
        Canonical text of the scheme.
    outcomes
        What came of its cells, by dataset.
    values
        The objective by dataset, NaN where it has none: refused, failed, or not defined there.
    """

    setting: str
    outcomes: tuple[Outcome, ...]
    values: tuple[float, ...]

    @property
    def valid(self) -> bool:
        """Whether the objective has a value on every dataset."""
        return all(map(math.isfinite, self.values))


#: Called after every trial.
Callback: TypeAlias = Callable[[Trial], None]


class Trials:
    """Computes settings on the cells of a plan's datasets; a context manager, at whose end the workers are gone.

    The journal of the directory keeps the outcomes, so that a search which is interrupted goes on where it was.

    Parameters
    ----------
    plan
        A plan of one scheme; settings differ from it in plain parameters only, so that its source is theirs.
    objective
        The objective.
    exact
        Exact curvature extremes by dataset, as far as the objective needs them.
    directory
        Where the journal is.
    jobs
        Worker processes; None for one a processor.
    timeout
        Seconds a cell may take.
    command
        The command line, for the journal.
    note
        Called after every new trial.
    """

    def __init__(
        self,
        plan: Plan,
        objective: Objective,
        exact: Mapping[str, Extremes],
        directory: Path,
        *,
        jobs: int | None = None,
        timeout: float = TIMEOUT,
        command: Sequence[str] = (),
        note: Callback | None = None,
    ) -> None:
        self._plan, self._exact = plan, exact
        self.objective: Final = objective
        #: texts of the datasets
        self.datasets: Final = tuple(one.spec for one in plan.datasets)
        self._jobs, self._timeout, self._command, self._note = jobs or processors(), timeout, command, note
        self._journal: Final = Journal(directory)
        self._cleanup = contextlib.ExitStack()
        self._number = 0
        #: all trials by setting, in the order they were asked for
        self.done: Final[dict[str, Trial]] = {}
        #: cells computed, and cells found in the journal
        self.computed = self.reused = 0

    def __enter__(self) -> Self:
        with contextlib.ExitStack() as stack:
            stack.enter_context(self._journal)
            self._journal.begin(environment(self._plan, self._command, self._jobs, self._timeout))
            self._workers = stack.enter_context(Workers(self._jobs, self._timeout, self._journal.worker_directory))
            self._cleanup = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._cleanup.__exit__(kind, error, trace)

    def all(self, settings: Sequence[str]) -> list[Trial]:
        """Return the trials of settings, computing those that are new, as many at once as there are workers."""
        new = [setting for setting in dict.fromkeys(settings) if setting not in self.done]
        cells = self._plan.cells
        for start in range(0, len(new), group := 4 * self._jobs):  # in groups, so that there is progress to show
            chosen = new[start : start + group]
            outcomes = self._outcomes([self._task(setting, cell) for setting in chosen for cell in cells])
            for position, setting in enumerate(chosen):
                own = tuple(outcomes[position * len(cells) : (position + 1) * len(cells)])
                self.done[setting] = Trial(setting, own, tuple(map(self._value, own, cells)))
                if self._note:
                    self._note(self.done[setting])
        return [self.done[setting] for setting in settings]

    def _task(self, setting: str, cell: Cell) -> tuple[str, Task]:
        """Return the key and the task of a setting's cell."""
        plan = self._plan
        scheme = replace(plan.schemes[0], spec=setting)
        dataset = next(one for one in plan.datasets if one.spec == cell.dataset)
        return cell_key(scheme, dataset, cell.level, plan.measures), replace(plan.task(cell), scheme=setting)

    def _outcomes(self, tasks: Sequence[tuple[str, Task]]) -> list[Outcome]:
        """Return the outcomes of tasks, from the journal where it has them."""
        known = self._journal.entries(key for key, _ in tasks)
        found = {key: entry.outcome for key, entry in known.items() if not _again(entry)}
        self.reused += len(found)
        waiting = deque((key, task) for key, task in dict(tasks).items() if key not in found)
        running: dict[int, tuple[str, Task, float]] = {}
        while waiting or running:
            while waiting and self._workers.free:
                key, task = waiting.popleft()
                # where another process is at it, both compute, and the other one records
                superseded = known[key].attempt if key in known else None
                if self._journal.claim(key, superseded) is Claim.DONE:
                    found[key] = self._journal.entries([key])[key].outcome
                    self.reused += 1
                    continue
                self._number += 1
                running[self._number] = (key, task, time.time())
                self._workers.submit(self._number, compute, task)
            for result in self._workers.wait(TICK):
                key, task, began = running.pop(result.task)
                outcome = outcome_of(result)
                if isinstance(outcome, SourceChanged):
                    raise TestbedError(f"the source of {outcome.plugin} changed during the search: run again")
                self._journal.record(key, (task.scheme, task.dataset, task.level), outcome, began)
                found[key] = outcome
                self.computed += 1
        return [found[key] for key, _ in tasks]

    def _value(self, outcome: Outcome, cell: Cell) -> float:
        if outcome.status != "ok":
            return math.nan
        return self.objective.value(outcome.values or {}, self._exact[cell.dataset])


def _again(entry: Entry) -> bool:
    """Whether an outcome may be the machine's, so that it is computed again."""
    return entry.outcome.status == "timeout" or entry.outcome.retry
