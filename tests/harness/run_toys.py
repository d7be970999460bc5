"""Run a stored plan: ``run_toys.py PLAN DIRECTORY JOBS``."""

import sys
from pathlib import Path

from testbed.harness.plan import Plan
from testbed.harness.run import run

if __name__ == "__main__":
    stored, directory, jobs = sys.argv[1:]
    summary = run(Plan.from_json(Path(stored).read_text()), Path(directory), jobs=int(jobs))
    sys.exit(130 if summary.interrupted else 0)
