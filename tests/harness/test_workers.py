"""Workers: whatever a task does to its process costs that task only, whenever it happens."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from testbed import registry
from testbed.errors import TestbedError
from testbed.harness.workers import ENVIRONMENT, Died, Outcome, Returned, TimedOut, Workers


def all_of(workers: Workers) -> list[Outcome]:
    """Wait for all tasks."""
    outcomes = []
    while workers.tasks:
        outcomes += workers.wait(0.2)
    return outcomes


def test_a_worker_killed_while_idle_costs_nothing() -> None:
    with Workers(1, 10.0) as workers:
        workers.submit(0, os.getpid)
        (first,) = all_of(workers)
        assert isinstance(first, Returned)
        os.kill(first.value, signal.SIGKILL)
        workers.submit(1, os.getpid)  # perhaps before the death can be seen
        (second,) = all_of(workers)
        assert isinstance(second, Returned)
        os.kill(second.value, signal.SIGKILL)
        workers.wait(0.5)
        workers.submit(2, os.getpid)
        (third,) = all_of(workers)
        assert isinstance(third, Returned)
        assert len({first.value, second.value, third.value}) == 3


def test_deaths_and_limits_cost_their_tasks_only() -> None:
    with Workers(2, 0.5) as workers:
        outcomes: list[Outcome] = []
        waiting: list[tuple[int, tuple[Callable[..., Any], int]]] = [(number, (os._exit, 0)) for number in range(3)]
        waiting += [(number, (time.sleep, 30)) for number in (3, 4)]
        waiting += [(number, (abs, number)) for number in range(5, 30)]
        while waiting or workers.tasks:
            while workers.free and waiting:
                number, (function, argument) = waiting.pop(0)
                workers.submit(number, function, argument)
            outcomes += workers.wait(0.2)
    assert {outcome.task: type(outcome) for outcome in outcomes} == (
        dict.fromkeys(range(3), Died) | dict.fromkeys((3, 4), TimedOut) | dict.fromkeys(range(5, 30), Returned)
    )
    assert len(outcomes) == 30


def test_workers_have_one_thread_each_and_leave_the_environment_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with Workers(1, 10.0) as workers:
        for name in ENVIRONMENT:
            workers.submit(0, os.getenv, name)
            assert all_of(workers) == [Returned(0, ENVIRONMENT[name])]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_plugins_that_kill_every_worker_on_import_are_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "deadly_toys.py").write_text("import os, sys\nsys.stderr.write('the last words')\nos._exit(4)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv(registry.VARIABLE, "deadly_toys")
    with Workers(1, 10.0) as workers:
        workers.submit(0, os.getpid)
        with pytest.raises(TestbedError, match=r"exit code 4.*the last words"):
            all_of(workers)


def test_no_process_and_no_file_is_left(tmp_path: Path) -> None:
    with Workers(2, 10.0, tmp_path / "logs") as workers:
        workers.submit(0, os.getpid)
        (outcome,) = all_of(workers)
        workers.submit(1, time.sleep, 60)
    assert isinstance(outcome, Returned)
    with pytest.raises(ProcessLookupError):
        os.kill(outcome.value, 0)
    assert list((tmp_path / "logs").iterdir()) == []


def test_a_busy_pool_takes_no_more() -> None:
    with Workers(1, 10.0) as workers:
        workers.submit(0, time.sleep, 60)
        assert workers.free == 0
        with pytest.raises(ValueError, match="no worker is free"):
            workers.submit(1, os.getpid)
