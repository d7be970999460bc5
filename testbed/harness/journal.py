"""The record of a results directory: one SQLite row a cell, written in one transaction, under the cell's key.

Several runs may share a directory. A run holds a lock file as long as it lives; before it computes a cell it claims the
cell's key in the journal, so that no other run computes it too. The lock falls when its holder dies, however it dies,
and its claims with it. The database is in WAL mode: a process killed at any moment leaves it whole. WAL needs a file
system that this machine alone writes to.
"""

import contextlib
import json
import os
import secrets
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from enum import Enum, auto
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from filelock import FileLock, Timeout

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome

#: Version of the tables; a journal of another version is not touched.
SCHEMA: Final = 1
#: Seconds to wait for another run's transaction.
BUSY_SECONDS: Final = 60.0

_TABLES: Final = """
CREATE TABLE IF NOT EXISTS cells (
    key TEXT PRIMARY KEY, scheme TEXT NOT NULL, dataset TEXT NOT NULL, level INTEGER NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('ok', 'refused', 'failed', 'timeout')), reason TEXT NOT NULL,
    outcome TEXT NOT NULL, run TEXT NOT NULL, started REAL NOT NULL, finished REAL NOT NULL
) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS claims (key TEXT PRIMARY KEY, run TEXT NOT NULL, since REAL NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS runs (id TEXT PRIMARY KEY, started REAL NOT NULL, record TEXT NOT NULL) WITHOUT ROWID;
"""


class Claim(Enum):
    """Answer to a claim."""

    GRANTED = auto()
    DONE = auto()
    TAKEN = auto()


@dataclass(frozen=True)
class Entry:
    """A recorded cell: its outcome, and which attempt (run and time) it is from, to tell it from a later one."""

    outcome: Outcome
    attempt: tuple[str, float]


class Journal:
    """The journal of a directory, open for a run; a context manager.

    Parameters
    ----------
    directory
        The results directory; made if it does not exist.

    Raises
    ------
    TestbedError
        On entering, for a file that is not a journal of this version.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._locks = directory / "runs"
        self.path: Final = directory / "journal.sqlite"
        self.run: Final = f"{time.strftime('%Y%m%d-%H%M%S')}-{secrets.token_hex(4)}"
        self._lock = FileLock(self._locks / f"{self.run}.lock")

    def __enter__(self) -> Self:
        self._locks.mkdir(parents=True, exist_ok=True)
        # one at a time: nobody sweeps away a lock file that is not locked yet, or creates the same tables
        with FileLock(self._locks / "opening.lock"):
            self._lock.acquire()
            try:
                self._database = _open(self.path)
                self._sweep()
            except BaseException:
                self._lock.release()
                raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._database.execute("DELETE FROM claims WHERE run = ?", (self.run,))
            self._database.close()
        finally:
            self._lock.release()
            self._remove_files(self.run)

    @property
    def worker_directory(self) -> Path:
        """Where this run's workers may write while they live."""
        return self._locks / self.run

    def begin(self, record: Mapping[str, Any]) -> None:
        """Record the run: versions, command line and the like."""
        values = (self.run, time.time(), json.dumps(record))
        self._database.execute("INSERT INTO runs VALUES (?, ?, ?)", values)

    def entries(self, keys: Iterable[str]) -> dict[str, Entry]:
        """Return what is recorded of some keys."""
        wanted = set(keys)
        rows = self._database.execute("SELECT key, outcome, run, finished FROM cells").fetchall()
        return {key: Entry(_outcome(text), (run, finished)) for key, text, run, finished in rows if key in wanted}

    def claim(self, key: str, superseded: tuple[str, float] | None = None) -> Claim:
        """Claim a cell for this run.

        Parameters
        ----------
        key
            The cell's key.
        superseded
            An attempt that does not count as a result; any other does.
        """
        with self._transaction():
            row = self._database.execute("SELECT run, finished FROM cells WHERE key = ?", (key,)).fetchone()
            if row is not None and tuple(row) != superseded:
                return Claim.DONE
            holder = self._database.execute("SELECT run FROM claims WHERE key = ?", (key,)).fetchone()
            if holder is not None and holder[0] != self.run and self._alive(holder[0]):
                return Claim.TAKEN
            self._database.execute("INSERT OR REPLACE INTO claims VALUES (?, ?, ?)", (key, self.run, time.time()))
            return Claim.GRANTED

    def record(self, key: str, cell: tuple[str, str, int], outcome: Outcome, started: float) -> None:
        """Store a cell's outcome and give up the claim, in one transaction; only for cells that this run holds.

        Parameters
        ----------
        cell
            Scheme, dataset and level, for whoever reads the database.
        started
            When its computation began, seconds since the epoch.
        """
        text = json.dumps(asdict(outcome))
        row = (key, *cell, outcome.status, outcome.reason, text, self.run, started, time.time())
        with self._transaction():
            holder = self._database.execute("SELECT run FROM claims WHERE key = ?", (key,)).fetchone()
            if holder is not None and holder[0] == self.run:
                places = ",".join("?" * len(row))
                self._database.execute(f"INSERT OR REPLACE INTO cells VALUES ({places})", row)  # noqa: S608 - no values
                self._database.execute("DELETE FROM claims WHERE key = ?", (key,))

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[None]:
        self._database.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._database.execute("ROLLBACK")
            raise
        self._database.execute("COMMIT")

    def _lock_file(self, run: str) -> Path:
        return self._locks / f"{run}.lock"

    def _alive(self, run: str) -> bool:
        """Whether a run's lock is held; only its holder's end lets it go."""
        if not self._lock_file(run).exists():
            return False
        probe = FileLock(self._lock_file(run))
        try:
            probe.acquire(timeout=0)
        except Timeout:
            return True
        probe.release()
        return False

    def _sweep(self) -> None:
        """Remove what dead runs left behind: claims, lock files, workers' output."""
        for file in self._locks.glob("*.lock"):
            run = file.stem
            if run in (self.run, "opening") or self._alive(run):
                continue
            self._database.execute("DELETE FROM claims WHERE run = ?", (run,))
            self._remove_files(run)

    def _remove_files(self, run: str) -> None:
        for log in (self._locks / run).glob("*"):
            log.unlink(missing_ok=True)
        with contextlib.suppress(OSError):  # there may be none
            (self._locks / run).rmdir()
        self._lock_file(run).unlink(missing_ok=True)


def _open(path: Path) -> sqlite3.Connection:
    try:
        database = sqlite3.connect(path, timeout=BUSY_SECONDS, isolation_level=None)
        version = database.execute("PRAGMA user_version").fetchone()[0]
        if version not in (0, SCHEMA):
            raise TestbedError(
                f"{path} was written by another version of the testbed (journal {version}, this one writes {SCHEMA}): "
                "choose another directory"
            )
        database.execute("PRAGMA journal_mode = WAL")
        database.execute("PRAGMA synchronous = NORMAL")
        database.executescript(_TABLES)
        database.execute(f"PRAGMA user_version = {SCHEMA}")
    except sqlite3.DatabaseError as error:
        raise TestbedError(f"{path} is not a journal ({error}): move it away, or choose another directory") from error
    return database


def read_entries(directory: Path, keys: Iterable[str]) -> dict[str, Entry]:
    """Return what a directory's journal has of some keys, without taking part as a run.

    Raises
    ------
    TestbedError
        There is no journal, or it cannot be read.
    """
    path = directory / "journal.sqlite"
    if not path.exists():
        raise TestbedError(f"{directory} holds no results: run `testbed run -o {directory}` first")
    wanted = set(keys)
    with contextlib.closing(_open(path)) as database:
        rows = database.execute("SELECT key, outcome, run, finished FROM cells").fetchall()
    return {key: Entry(_outcome(text), (run, finished)) for key, text, run, finished in rows if key in wanted}


def _outcome(text: str) -> Outcome:
    return Outcome(**json.loads(text))


def write_whole(path: Path, text: str) -> None:
    """Write a file at once: readers see the old text or the new, never a part."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(4)}")
    try:
        temporary.write_text(text, "utf-8", newline="\n")
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
