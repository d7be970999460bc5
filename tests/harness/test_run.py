"""Running a plan: every cell ends with a status and a reason, and the results do not depend on how they came about."""

import json
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from testbed.errors import TestbedError
from testbed.harness.plan import Plan
from testbed.harness.results import END, Results, read_results
from testbed.harness.run import Progress, run

Planning = Callable[..., Plan]


def lasting(results: Results) -> pd.DataFrame:
    """Cells without the times they took."""
    return results.cells.drop(columns=list(END))


#: What a scheme does -> the status and the reason of its cell.
ENDS = {
    "raise": ("failed", "scheme toy[act=raise]: ValueError: a toy broke"),
    "exit": ("failed", "the worker process ended: exit code 3"),
    "leave": ("failed", "the worker process ended: exit code 0"),
    "kill": ("failed", "the worker process ended: signal 9 (SIGKILL)"),
    "segfault": ("failed", "the worker process ended: signal 11 (SIGSEGV)"),
    "memory": ("failed", "scheme toy[act=memory]: out of memory"),
    "system-exit": ("failed", "scheme toy[act=system-exit]: SystemExit: 0"),
    "nan": ("failed", "NaN in total"),
    "refuse": ("refused", "the toy takes no such data at vertex 0"),
    "print": ("ok", ""),
}


def test_what_a_scheme_does_costs_its_own_cells_only(toy_plan: Planning, tmp_path: Path) -> None:
    good = [f"toy[tag={tag}]" for tag in range(1, 6)]
    plan = toy_plan([*(f"toy[act={act}]" for act in ENDS), *good], ["grid"], "0")
    run(plan, tmp_path, jobs=2)
    cells = read_results(tmp_path).cells.set_index("scheme")
    assert {act: tuple(cells.loc[f"toy[act={act}]", ["status", "reason"]]) for act in ENDS} == ENDS
    assert set(cells.loc[good, "status"]) == {"ok"}
    assert cells.loc[cells["status"] != "ok", ["total", "distance_max"]].isna().all(axis=None)
    # where they failed is kept
    traces = read_results(tmp_path).tracebacks
    assert 'raise ValueError("a toy' in traces["toy[act=raise]", "grid", 0]
    assert "Segmentation fault" in traces["toy[act=segfault]", "grid", 0]
    assert "toy_plugins.py" in traces["toy[act=segfault]", "grid", 0]


def test_a_cell_that_hangs_is_stopped_and_tried_again_by_the_next_run(toy_plan: Planning, tmp_path: Path) -> None:
    plan = toy_plan(["toy[act=hang,level=1]"], ["grid"], "0:2")
    assert run(plan, tmp_path, jobs=1, timeout=0.5).counts == {"ok": 2, "timeout": 1}
    assert read_results(tmp_path).cells["reason"].tolist() == ["", "stopped after 0.5 seconds", ""]
    again = run(plan, tmp_path, jobs=1, timeout=0.6)
    assert (again.computed, again.reused) == (1, 2)
    assert read_results(tmp_path).cells["reason"].tolist() == ["", "stopped after 0.6 seconds", ""]


def test_failures_are_kept_unless_they_may_be_the_machines(toy_plan: Planning, tmp_path: Path) -> None:
    plan = toy_plan([f"toy[act={act}]" for act in ("raise", "exit", "kill", "memory", "refuse")], ["grid"], "0")
    assert run(plan, tmp_path, jobs=1).computed == 5
    assert run(plan, tmp_path, jobs=1).computed == 2  # killed and out of memory
    assert run(plan, tmp_path, jobs=1, retry_failed=True).computed == 4


def test_a_dataset_costs_its_own_cells_only(toy_plan: Planning, tmp_path: Path) -> None:
    bad = ["grid[act=raise]", "grid[act=exit]", "grid[act=refuse]"]
    run(toy_plan(["toy", "needy"], [*bad, "grid[forms=false]", "grid[sides=4]", "grid"], "0"), tmp_path, jobs=1)
    cells = read_results(tmp_path).cells.set_index(["scheme", "dataset"])["status"]
    assert cells["toy"].to_dict() == cells["needy"].to_dict() | {"grid[forms=false]": "ok"}
    assert cells["needy"].tolist() == ["failed", "failed", "refused", "refused", "refused", "ok"]


def test_results_do_not_depend_on_the_number_of_workers(toy_plan: Planning, tmp_path: Path) -> None:
    schemes = ["toy", "toy[tag=1,act=nan,level=1]", "needy", "toy[act=exit,level=2]"]
    plan = toy_plan(schemes, ["grid", "grid[forms=false]"])
    for jobs in (1, 3):
        run(plan, tmp_path / str(jobs), jobs=jobs)
    pd.testing.assert_frame_equal(lasting(read_results(tmp_path / "1")), lasting(read_results(tmp_path / "3")))
    for name in ("orders.csv", "claims.csv"):
        assert (tmp_path / "1" / name).read_text() == (tmp_path / "3" / name).read_text()


def test_only_what_is_missing_is_computed(toy_plan: Planning, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "log"
    monkeypatch.setenv("TOY_LOG", str(log))
    out = tmp_path / "out"
    assert run(toy_plan(["toy"], levels="0:1"), out, jobs=2).computed == 2
    summary = run(toy_plan(["toy", "toy[tag=1]"], levels="0:2"), out, jobs=2)
    assert (summary.computed, summary.reused) == (4, 2)
    assert len(log.read_text().splitlines()) == len(set(log.read_text().splitlines())) == 6
    # another plan of the same directory shows its own cells only
    run(toy_plan(["toy[tag=1]"], levels="1"), out, jobs=2)
    assert read_results(out).cells[["scheme", "level"]].to_numpy().tolist() == [["toy[tag=1]", 1]]


def test_an_interrupt_keeps_what_is_done(toy_plan: Planning, tmp_path: Path) -> None:
    plan = toy_plan(["toy", "toy[act=hang]"], ["grid"], "0:1")

    def interrupt(progress: Progress) -> None:
        if progress.counts.get("ok") == 2:
            raise KeyboardInterrupt

    summary = run(plan, tmp_path, jobs=2, progress=interrupt)
    assert summary.interrupted
    assert not (tmp_path / "results.csv").exists()
    results = read_results(tmp_path)
    assert set(results.cells["status"]) == {"ok"}
    assert len(results.missing) == 2
    again = run(plan, tmp_path, jobs=2, timeout=0.3)
    assert (again.reused, again.computed) == (2, 2)


def test_ctrl_c_in_the_terminal_ends_a_run_cleanly(
    toy_plan: Planning, toy_runs: Callable[..., Any], tmp_path: Path
) -> None:
    out = tmp_path / "out"
    runs = toy_runs(toy_plan(["toy[act=hang]", "toy"], ["grid"], "0"), out)
    process = runs.start()
    deadline = time.monotonic() + 20
    while not list(out.glob("runs/*/worker-*.log")) and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.3)
    os.killpg(process.pid, signal.SIGINT)
    assert process.wait(timeout=10) == 130
    assert [file.name for file in (out / "runs").iterdir()] == ["opening.lock"]


def test_progress_is_told(toy_plan: Planning, tmp_path: Path) -> None:
    plan = toy_plan(["toy[seconds=0.05]"])
    told: list[Progress] = []
    run(plan, tmp_path, jobs=1, progress=told.append)
    assert told[0].done == 0
    assert told[-1].done == told[-1].total == 3
    assert [progress.finished.level for progress in told if progress.finished] == [2, 1, 0]  # the largest first
    assert all(left is not None and left >= 0 for left in [progress.seconds_left for progress in told[-2:]])


def test_no_lock_or_log_is_left_behind(toy_plan: Planning, tmp_path: Path) -> None:
    run(toy_plan(["toy", "toy[act=exit]"], levels="0"), tmp_path, jobs=2)
    assert [file.name for file in (tmp_path / "runs").iterdir()] == ["opening.lock"]
    assert not [thread for thread in threading.enumerate() if "worker" in thread.name]


def test_a_file_that_is_no_journal_is_not_overwritten(toy_plan: Planning, tmp_path: Path) -> None:
    (tmp_path / "journal.sqlite").write_text("something else, and long enough to look like a header" * 100)
    with pytest.raises(TestbedError, match=r"journal\.sqlite is not a journal"):
        run(toy_plan(["toy"], levels="0"), tmp_path)
    assert (tmp_path / "journal.sqlite").read_text().startswith("something else")


def test_the_record_of_a_run(toy_plan: Planning, tmp_path: Path) -> None:
    plan = toy_plan(["toy"], levels="0")
    run(plan, tmp_path, jobs=1, command=["testbed", "run"])
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["command"] == ["testbed", "run"]
    assert {"testbed", "python", "numpy", "scipy"} <= record["versions"].keys()
    assert record["cells"] == {"total": 1, "computed": 1, "reused": 0, "shared": 0, "ok": 1}
    assert record["sources"]["schemes"] == {"toy": plan.schemes[0].source}
