"""What the tests of the harness share: the toys registered, runs in processes of their own, tables to compare."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from testbed import registry
from testbed.harness.plan import Plan, make_plan

HERE = Path(__file__).parent


@pytest.fixture(autouse=True)
def toys(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Register the toy plugins, in this process and in the workers."""
    monkeypatch.setenv(registry.VARIABLE, "toy_plugins")
    monkeypatch.syspath_prepend(str(HERE))
    registry.load.cache_clear()
    yield
    registry.load.cache_clear()


@pytest.fixture
def toy_plan() -> Callable[..., Plan]:
    """Plan toys, measured by toys."""

    def plan(schemes: list[str], datasets: list[str] | None = None, levels: str | None = None) -> Plan:
        return make_plan(schemes, datasets or ["grid"], levels, ["sums", "words"])

    return plan


class Runs:
    """Runs of one plan in processes of their own, each the leader of a group."""

    def __init__(self, plan: Plan, directory: Path) -> None:
        self.directory = directory
        self._plan = directory.with_suffix(".plan")
        self._plan.write_text(plan.to_json())
        self.started: list[subprocess.Popen[bytes]] = []

    def start(self, jobs: int = 2) -> subprocess.Popen[bytes]:
        """Start a run into the directory."""
        path = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
        process = subprocess.Popen(  # noqa: S603 - our own script
            [sys.executable, str(HERE / "run_toys.py"), str(self._plan), str(self.directory), str(jobs)],
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": path},
        )
        self.started.append(process)
        return process

    def kill(self, process: subprocess.Popen[bytes]) -> None:
        """Kill a run and its workers at once."""
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def finish(self, jobs: int = 2) -> None:
        """Run to the end."""
        assert self.start(jobs).wait(timeout=60) == 0


@pytest.fixture
def toy_runs() -> Iterator[Callable[[Plan, Path], Runs]]:
    """Make runs, and leave none behind."""
    made: list[Runs] = []

    def make(plan: Plan, directory: Path) -> Runs:
        made.append(Runs(plan, directory))
        return made[-1]

    yield make
    for runs in made:
        for process in runs.started:
            if process.poll() is None:
                runs.kill(process)


def wait_until(true: Callable[[], bool], seconds: float = 20.0) -> None:
    """Wait for a condition; fail if it does not come about."""
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)
