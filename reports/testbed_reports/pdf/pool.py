"""The same function on many tasks, in worker processes; results do not depend on how many there are."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, Self

from testbed.harness.workers import Died, Returned, TimedOut, Workers

#: Seconds that a task may take.
LIMIT: Final = 600.0


@dataclass(frozen=True)
class Lost:
    """What there is instead of a result where a task ended its process or took too long: the reason."""

    reason: str


class Pool:
    """Worker processes, a context manager; with ``jobs`` 1 the tasks run in this process.

    Parameters
    ----------
    jobs
        How many; one a processor if None.
    """

    def __init__(self, jobs: int | None = None) -> None:
        from testbed.harness.run import processors

        count = jobs or processors()
        self._workers = Workers(count, LIMIT) if count > 1 else None

    def __enter__(self) -> Self:
        if self._workers is not None:
            self._workers.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._workers is not None:
            self._workers.__exit__(kind, error, trace)

    def map(self, function: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> list[Any]:
        """Return the function's value for each task, or :class:`Lost`.

        Raises
        ------
        TestbedError
            Workers do not come up.
        """
        if self._workers is None:
            return [function(*task) for task in tasks]
        found: dict[int, Any] = {}
        waiting = list(enumerate(tasks))
        while waiting or self._workers.tasks:
            while waiting and self._workers.free > 0:
                number, task = waiting.pop(0)
                self._workers.submit(number, function, *task)
            for outcome in self._workers.wait(1.0):
                match outcome:
                    case Returned(task=number, value=value):
                        found[number] = value
                    case TimedOut(task=number):
                        found[number] = Lost(f"it takes more than {LIMIT:g} s")
                    case Died(task=number, reason=reason, log=log):
                        found[number] = Lost("; ".join([reason, *log.strip().splitlines()[-1:]]))
        return [found[number] for number in range(len(tasks))]
