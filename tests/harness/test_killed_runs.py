"""Runs that are killed, and runs that share a directory: nothing is lost, torn or computed twice."""

import random
import shutil
import sqlite3
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from conftest import Runs, wait_until

from testbed.harness.plan import Plan
from testbed.harness.results import END, read_results
from testbed.harness.run import run

Planning = Callable[..., Plan]
Making = Callable[[Plan, Path], Runs]


def lasting(directory: Path) -> pd.DataFrame:
    """Exported cells without the times they took."""
    return pd.read_csv(directory / "results.csv").drop(columns=list(END))


def recorded(directory: Path) -> int:
    """Cells in the journal, seen from outside."""
    if not (directory / "journal.sqlite").exists():
        return 0
    with closing(sqlite3.connect(directory / "journal.sqlite", timeout=10)) as database:
        try:
            return int(database.execute("SELECT count(*) FROM cells").fetchone()[0])
        except sqlite3.OperationalError:  # the tables are not there yet
            return 0


def test_a_run_killed_at_random_moments_ends_with_equal_results(
    toy_plan: Planning, toy_runs: Making, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = ["toy[act=exit,level=0,seconds=0.02]", "toy[act=nan,level=2]", "needy[seconds=0.05]"]
    schemes = [f"toy[seconds=0.05,tag={tag}]" for tag in range(8)] + bad
    plan = toy_plan(schemes, ["grid", "grid[forms=false]"], "0:2")
    monkeypatch.setenv("TOY_LOG", str(tmp_path / "log"))
    killed = toy_runs(plan, tmp_path / "killed")
    moments = random.Random(1992)  # noqa: S311 - moments, not secrets
    for _ in range(4):
        process = killed.start()
        time.sleep(moments.uniform(0.3, 1.6))
        killed.kill(process)
    killed.finish()
    attempts = Counter((tmp_path / "log").read_text().splitlines())
    monkeypatch.delenv("TOY_LOG")
    run(plan, tmp_path / "whole", jobs=2)
    pd.testing.assert_frame_equal(lasting(tmp_path / "killed"), lasting(tmp_path / "whole"))
    for name in ("orders.csv", "claims.csv"):
        assert (tmp_path / "killed" / name).read_text() == (tmp_path / "whole" / name).read_text()
    # a kill costs what was under way: two cells at most
    assert len(plan.cells) > sum(attempts.values()) - 2 * 4


def test_two_runs_share_the_work(
    toy_plan: Planning, toy_runs: Making, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = tmp_path / "log"
    monkeypatch.setenv("TOY_LOG", str(log))
    plan = toy_plan([f"toy[seconds=0.1,tag={tag}]" for tag in range(8)], ["grid"], "0:2")
    out = tmp_path / "out"
    runs = toy_runs(plan, out)
    both = [runs.start(jobs=2), runs.start(jobs=2)]
    assert [process.wait(timeout=60) for process in both] == [0, 0]
    lines = log.read_text().splitlines()
    assert len(lines) == len(set(lines)) == len(plan.cells)
    assert len(read_results(out).cells) == len(plan.cells)
    assert set(read_results(out).cells["status"]) == {"ok"}
    with closing(sqlite3.connect(out / "journal.sqlite")) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert len(database.execute("SELECT DISTINCT run FROM cells").fetchall()) == 2
        assert database.execute("SELECT count(*) FROM claims").fetchone() == (0,)


def test_a_run_takes_over_what_a_killed_one_had_claimed(toy_plan: Planning, toy_runs: Making, tmp_path: Path) -> None:
    out = tmp_path / "out"
    plan = toy_plan(["toy[seconds=1]"], ["grid"], "0")
    runs = toy_runs(plan, out)
    first = runs.start(jobs=1)
    wait_until(lambda: list(out.glob("runs/*/worker-0.log")) != [])
    time.sleep(0.8)  # the cell is claimed and under way
    second = runs.start(jobs=1)
    time.sleep(0.3)
    runs.kill(first)
    assert second.wait(timeout=30) == 0
    assert read_results(out).cells["status"].tolist() == ["ok"]


def test_workers_end_with_their_run(toy_plan: Planning, toy_runs: Making, tmp_path: Path) -> None:
    out = tmp_path / "out"
    runs = toy_runs(toy_plan(["toy[act=hang]"], ["grid"], "0"), out)
    process = runs.start(jobs=1)
    wait_until(lambda: len(children(process.pid)) > 0)
    time.sleep(0.8)
    workers = children(process.pid)
    process.kill()  # the run alone, not its group
    process.wait()
    wait_until(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers))


def children(pid: int) -> list[int]:
    """Return the processes that a process started, on Linux."""
    file = Path(f"/proc/{pid}/task/{pid}/children")
    if not file.exists():
        pytest.skip("needs /proc")
    return [int(child) for child in file.read_text().split()]


def test_the_journal_survives_torn_writes(toy_plan: Planning, toy_runs: Making, tmp_path: Path) -> None:
    out = tmp_path / "out"
    plan = toy_plan([f"toy[seconds=0.02,tag={tag}]" for tag in range(20)], ["grid"], "0:1")
    runs = toy_runs(plan, out)
    process = runs.start()
    wait_until(lambda: recorded(out) >= 10)
    runs.kill(process)
    log = out / "journal.sqlite-wal"
    size = log.stat().st_size
    assert size > 0
    whole = recorded(shutil.copytree(out, tmp_path / "whole"))
    kept = []
    for number, length in enumerate((size - 1, size // 2, 10)):
        torn = shutil.copytree(out, tmp_path / f"torn-{number}")
        with (torn / "journal.sqlite-wal").open("r+b") as file:
            file.truncate(length)
            file.seek(0, 2)
            file.write(b"\x5a" * 300)  # what stood on the disk before
        summary = run(plan, torn, jobs=1)
        assert summary.counts == {"ok": 40}
        kept.append(summary.reused)
    assert kept == sorted(kept, reverse=True)
    assert kept[0] <= whole
    assert kept[0] > 0
