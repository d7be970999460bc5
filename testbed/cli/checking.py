"""``check``: the conformance suite over schemes."""

import dataclasses
import json
import sys

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.conformance.subject import Outcome, Status
from testbed.conformance.suite import check
from testbed.registry import scheme

_STYLES = {Status.PASSED: "green", Status.FAILED: "bold red", Status.NOT_CLAIMED: "dim", Status.NOT_TESTABLE: "yellow"}


def check_command(names: list[str], *, as_json: bool) -> int:
    """Check schemes, print each property, and return 1 if one failed, else 0."""
    outcomes = {str(one): check(one) for one in map(scheme, names)}
    if as_json:
        json.dump(
            {name: [_record(outcome) for outcome in found] for name, found in outcomes.items()}, sys.stdout, indent=1
        )
        sys.stdout.write("\n")
    else:
        console = Console()
        for name, found in outcomes.items():
            table = Table(title=name, title_justify="left", title_style="bold", box=None, pad_edge=False)
            table.add_column("property", no_wrap=True)
            table.add_column("status", no_wrap=True)
            table.add_column("worst value, or witness")
            for one in found:
                status = f"[{_STYLES[one.status]}]{one.status.value}[/]"
                table.add_row(escape(one.property), status, escape(one.detail))
            console.print(table)
            console.print(_summary(found))
            console.print()
    return int(any(one.status is Status.FAILED for found in outcomes.values() for one in found))


def _summary(outcomes: tuple[Outcome, ...]) -> str:
    counts = {status: sum(one.status is status for one in outcomes) for status in Status}
    return ", ".join(f"{count} {status.value}" for status, count in counts.items() if count)


def _record(outcome: Outcome) -> dict[str, str]:
    return {**dataclasses.asdict(outcome), "status": outcome.status.value}
