"""Worker processes, one task at a time each: whatever a task does to its process costs that task only.

Every worker has a pipe of its own, so a process that dies, at whatever moment, holds no lock that others wait for, and
the task it had is known without being told. (A pool with one queue for all workers, as in :mod:`concurrent.futures` or
pebble, loses the pool or the task when a worker is killed while idle, or leaves with code 0.)
"""

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum, auto
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self, TypeAlias

from testbed.errors import TestbedError

#: One thread a worker, as the workers themselves are the parallelism, and one order of hashing, so that runs are equal.
ENVIRONMENT: Final = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
}
#: Seconds a worker may take to import the plugins.
STARTUP_LIMIT: Final = 120.0
#: How often a worker may die in a row before it has taken any task.
STARTUP_ATTEMPTS: Final = 3
#: What is kept of a dead worker's output, in characters.
LOG_KEPT: Final = 8000

Function: TypeAlias = Callable[..., Any]


@dataclass(frozen=True)
class Returned:
    """The task's function returned."""

    task: int
    value: Any


@dataclass(frozen=True)
class TimedOut:
    """The task took longer than its limit, and its process was killed."""

    task: int
    seconds: float


@dataclass(frozen=True)
class Died:
    """The process ended before the task did.

    Parameters
    ----------
    task
        The task.
    reason
        How, in words.
    log
        The last that the process wrote, with the places in the code if the interpreter could still write them.
    killed
        Whether it was killed from outside, so that another attempt may end otherwise.
    """

    task: int
    reason: str
    log: str
    killed: bool


Outcome: TypeAlias = Returned | TimedOut | Died


class _Sign(Enum):
    """What a worker says."""

    READY = auto()
    BEGUN = auto()
    DONE = auto()


@dataclass
class _Slot:
    """A place for a worker: its process, the pipe to it, and the task it has."""

    log: Path
    process: SpawnProcess
    connection: Connection
    deadline: float
    ready: bool = False
    begun: bool = False
    deaths: int = 0
    task: tuple[int, Function, tuple[Any, ...]] | None = None


class Workers:
    """Processes that run functions by reference; a context manager, at whose end they are gone.

    Parameters
    ----------
    count
        Worker processes.
    timeout
        Seconds a task may take; a worker's start does not count.
    directory
        Where the workers' output goes while they live; a temporary one if None.
    """

    def __init__(self, count: int, timeout: float, directory: Path | None = None) -> None:
        self._count = count
        self._timeout = timeout
        self._directory = directory
        self._slots: list[_Slot] = []
        self._cleanup = contextlib.ExitStack()

    def __enter__(self) -> Self:
        if self._directory is None:
            self._directory = Path(self._cleanup.enter_context(tempfile.TemporaryDirectory(prefix="testbed-")))
        self._directory.mkdir(parents=True, exist_ok=True)
        try:
            for number in range(self._count):
                self._slots.append(_start(self._directory / f"worker-{number}.log"))
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for slot in self._slots:
            slot.process.kill()
        for slot in self._slots:
            _discard(slot)
            slot.log.unlink(missing_ok=True)
        self._slots.clear()
        self._cleanup.close()

    @property
    def free(self) -> int:
        """How many more tasks can be submitted now."""
        return sum(slot.task is None for slot in self._slots)

    @property
    def tasks(self) -> tuple[int, ...]:
        """Tasks that are not finished."""
        return tuple(slot.task[0] for slot in self._slots if slot.task is not None)

    def submit(self, task: int, function: Function, *arguments: Any) -> None:
        """Give a task to a free worker, a started one if there is one; ValueError if none is free."""
        free = sorted((slot for slot in self._slots if slot.task is None), key=lambda slot: not slot.ready)
        if not free:
            raise ValueError("no worker is free")
        slot = free[0]
        slot.task = (task, function, arguments)
        if slot.ready:
            self._send(slot)

    def wait(self, seconds: float) -> list[Outcome]:
        """Return what finished, as soon as something has, or nothing after some seconds.

        Raises
        ------
        TestbedError
            Workers do not come up.
        """
        deadlines = [slot.deadline for slot in self._slots if slot.task is not None]
        limit = min([seconds, *(deadline - time.monotonic() for deadline in deadlines)])
        sources: list[Any] = []
        for slot in self._slots:
            sources += [slot.connection, slot.process.sentinel]
        fired = set(wait(sources, max(0.0, limit)))
        outcomes = []
        for slot in self._slots:
            outcome = None
            if slot.connection in fired or slot.process.sentinel in fired:
                outcome = self._hear(slot)
            elif time.monotonic() >= slot.deadline:
                outcome = self._too_late(slot)
            if outcome is not None:
                outcomes.append(outcome)
        return outcomes

    def _hear(self, slot: _Slot) -> Outcome | None:
        """Take a worker's message, or its death."""
        try:
            message = slot.connection.recv() if slot.connection.poll() else None
        except Exception:  # noqa: BLE001 - a torn message, of whatever kind, means that the process died or ran wild
            message = None
        if message is None:
            return self._bury(slot)
        sign, value = message
        if sign is _Sign.READY:
            slot.ready, slot.deadline = True, float("inf")
            if slot.task is not None:
                self._send(slot)
            return None
        if sign is _Sign.BEGUN:
            slot.begun, slot.deaths = True, 0
            return None
        assert slot.task is not None  # noqa: S101 - a result follows a task
        outcome = Returned(slot.task[0], value)
        slot.task, slot.begun, slot.deadline = None, False, float("inf")
        return outcome

    def _bury(self, slot: _Slot) -> Outcome | None:
        """Replace a worker that is gone; its task is lost, unless the worker had not begun it."""
        _discard(slot)
        code = slot.process.exitcode
        log = _tail(slot.log)
        if slot.ready and slot.task is None:
            self._replace(slot)
            return None
        if not slot.begun:
            if slot.deaths + 1 >= STARTUP_ATTEMPTS:
                raise TestbedError(
                    f"worker processes end ({_ending(code)}) while they import the plugins: "
                    f"{log.strip().splitlines()[-1] if log.strip() else 'run `testbed list` to see which plugin it is'}"
                )
            self._replace(slot, deaths=slot.deaths + 1)
            return None
        task = slot.task
        self._replace(slot, keep_task=False)
        assert task is not None  # noqa: S101 - what has begun is a task
        return Died(
            task[0], f"the worker process ended: {_ending(code)}", log, code in (-signal.SIGKILL, -signal.SIGTERM)
        )

    def _too_late(self, slot: _Slot) -> Outcome | None:
        if not slot.ready:
            raise TestbedError(
                f"a worker process did not come up within {STARTUP_LIMIT:g} seconds: a plugin may hang on import"
            )
        if slot.task is None:
            return None
        task = slot.task[0]
        slot.process.kill()
        _discard(slot)
        self._replace(slot, keep_task=False)
        return TimedOut(task, self._timeout)

    def _replace(self, slot: _Slot, deaths: int = 0, keep_task: bool = True) -> None:
        new = _start(slot.log)
        slot.process, slot.connection, slot.deadline = new.process, new.connection, new.deadline
        slot.ready, slot.begun, slot.deaths = False, False, deaths
        if not keep_task:
            slot.task = None

    def _send(self, slot: _Slot) -> None:
        assert slot.task is not None  # noqa: S101 - callers check
        slot.deadline = time.monotonic() + self._timeout
        with contextlib.suppress(OSError):  # it died while idle: the task goes to its successor
            slot.connection.send(slot.task[1:])


def _start(log: Path) -> _Slot:
    """Start a worker process."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    log.write_bytes(b"")
    process = context.Process(target=_serve, args=(there, str(log)), name="testbed worker", daemon=True)
    with _environment():
        process.start()
    there.close()  # so that the end of the process is the end of the pipe
    return _Slot(log, process, here, time.monotonic() + STARTUP_LIMIT)


@contextlib.contextmanager
def _environment() -> Iterator[None]:
    """Let processes that start meanwhile see ``ENVIRONMENT``: libraries read it when they are loaded."""
    before = {name: os.environ.get(name) for name in ENVIRONMENT}
    os.environ.update(ENVIRONMENT)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _discard(slot: _Slot) -> None:
    """End a process for certain, and close its pipe."""
    if slot.process.is_alive():
        slot.process.join(0.2)  # the pipe closes a moment before the process ends
        slot.process.kill()
    slot.process.join()
    slot.connection.close()


def _tail(log: Path) -> str:
    return log.read_text("utf-8", "replace")[-LOG_KEPT:]


def _ending(code: int | None) -> str:
    if code is None or code >= 0:
        return f"exit code {code}"
    try:
        return f"signal {-code} ({signal.Signals(-code).name})"
    except ValueError:
        return f"signal {-code}"


def _serve(connection: Connection, log: str) -> None:
    """Run tasks until the pipe closes; runs in the worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is for the run, which then ends its workers
    threading.Thread(target=_end_with_parent, daemon=True).start()
    output = os.open(log, os.O_WRONLY | os.O_APPEND)
    os.dup2(output, 1)
    os.dup2(output, 2)
    faulthandler.enable(2)
    import testbed.registry

    testbed.registry.load()
    _keep_freed_memory()
    connection.send((_Sign.READY, None))
    while True:
        try:
            function, arguments = connection.recv()
        except EOFError:
            return
        connection.send((_Sign.BEGUN, None))
        os.ftruncate(output, 0)  # what is found in the log belongs to the task that was running
        value = function(*arguments)
        sys.stdout.flush()
        connection.send((_Sign.DONE, value))


def _keep_freed_memory() -> None:
    """Have the C library keep freed memory, instead of returning and faulting it in again for every large array.

    glibc keeps blocks as large as the largest one freed so far, up to 32 MB; one that is never touched costs nothing.
    """
    import numpy as np

    np.empty(4_000_000)


def _end_with_parent() -> None:
    """Leave no orphan, whatever the process is doing when its parent is killed."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)
