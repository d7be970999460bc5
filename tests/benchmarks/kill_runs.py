# ruff: noqa: T201 - a script that talks
"""Kill a real run ten times at random moments, and compare what it ends with to an undisturbed run.

python tests/benchmarks/kill_runs.py [KILLS] [LEVELS] [SEED]

Prints how long each attempt lived and how many cells it left behind; exit code 0 if the final tables are equal to the
last bit, times apart. Not part of the tests, which do the same with toys.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from testbed.harness.journal import read_entries
from testbed.harness.plan import Plan, make_plan
from testbed.harness.results import END, read_results
from testbed.harness.run import run

#: Bound of the run's work, which two processors do in about half a minute.
WORK = 2e6


def main(kills: int = 10, levels: str = "0:1", seed: int = 1992) -> int:
    """Kill, resume, compare."""
    plan = make_plan(levels=levels, budget=WORK)
    moments = random.Random(seed)  # noqa: S311 - moments, not secrets
    with tempfile.TemporaryDirectory() as folder:
        stored, killed, whole = Path(folder, "plan"), Path(folder, "killed"), Path(folder, "whole")
        stored.write_text(plan.to_json())
        start = time.monotonic()
        run(plan, whole)
        length = time.monotonic() - start
        print(f"{len(plan.cells)} cells, undisturbed {length:.1f} s")
        for attempt in range(kills):
            # the moments cover the whole run: each attempt lives for a fraction of what is left, or dies while starting
            lifetime = moments.uniform(0.2, 2.5 * length / kills)
            process = subprocess.Popen(  # noqa: S603 - this script
                [sys.executable, __file__, "--into", str(stored), str(killed)], start_new_session=True
            )
            try:
                process.wait(lifetime)
                ended = True
            except subprocess.TimeoutExpired:
                ended = False
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            journal = killed / "journal.sqlite"
            done = len(read_entries(killed, [cell.key for cell in plan.cells])) if journal.exists() else 0
            print(f"{attempt + 1}: {'ended' if ended else 'killed'} after {lifetime:.2f} s, {done} cells recorded")
        summary = run(plan, killed)
        print(f"last: {summary.reused} cells reused, {summary.computed} computed")
        tables = [read_results(directory) for directory in (killed, whole)]
        cells = [results.cells.drop(columns=list(END)) for results in tables]
        equal = cells[0].equals(cells[1]) and tables[0].orders.equals(tables[1].orders)
    print("equal" if equal else "NOT EQUAL")
    return 0 if equal else 1


if __name__ == "__main__":
    if sys.argv[1:2] == ["--into"]:
        run(Plan.from_json(Path(sys.argv[2]).read_text()), Path(sys.argv[3]))
    else:
        arguments = sys.argv[1:]
        sys.exit(main(*map(int, arguments[:1]), *arguments[1:2], *map(int, arguments[2:3])))
