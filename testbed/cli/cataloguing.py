"""``catalogue``: a page of everything registered, with what comes of checking it."""

from pathlib import Path
from typing import Any

from rich.markup import escape
from rich.progress import Progress

from testbed.cli.tables import wide
from testbed.conformance.catalogue import card, findings
from testbed.harness.journal import write_whole
from testbed.harness.run import processors
from testbed.harness.workers import Died, Returned, TimedOut, Workers
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Scheme
from testbed.registry import catalogue, load
from testbed_reports.catalogue import SchemeEntry, render, to_json

#: Seconds that the checks of one scheme may take.
LIMIT = 300.0


def catalogue_command(directory: Path, jobs: int | None) -> int:
    """Check every scheme, write ``catalogue.html`` and ``catalogue.json``, and return 1 if a check failed, else 0."""
    console = wide()
    schemes = [kind() for kind in catalogue(Scheme).values()]  # type: ignore[type-abstract]  # the kind is abstract
    entries: dict[int, SchemeEntry] = {}
    with (
        Progress(console=console, transient=True, disable=not console.is_terminal) as bar,
        Workers(min(jobs or processors(), len(schemes)), LIMIT) as workers,
    ):
        task = bar.add_task("checking", total=len(schemes))
        waiting = list(enumerate(schemes))[::-1]
        while waiting or workers.tasks:
            while waiting and workers.free:
                number, one = waiting.pop()
                workers.submit(number, findings, str(one))
            for outcome in workers.wait(0.25):
                found, trouble = _answer(outcome)
                entries[outcome.task] = SchemeEntry(card(schemes[outcome.task]), found, trouble)
                bar.update(task, completed=len(entries))
    told = [entries[number] for number in range(len(schemes))]
    curves = [card(kind()) for kind in catalogue(BoundaryCurve).values()]  # type: ignore[type-abstract]  # as above
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in (
        ("catalogue.html", render(told, curves, load().not_built)),
        ("catalogue.json", to_json(told, curves, load().not_built)),
    ):
        write_whole(directory / name, text)
        console.print(f"written: {directory / name}", markup=False, soft_wrap=True)
    bad = [entry for entry in told if entry.findings is None or "failed" in entry.verdict]
    for entry in bad:
        console.print(f"[red]{escape(entry.card.name)}:[/red] {escape(entry.verdict)}")
    console.print(f"{len(told)} schemes, {len(told) - len(bad)} with every check passed; {len(curves)} boundary curves")
    return int(bool(bad))


def _answer(outcome: Any) -> tuple[Any, str]:
    """Return what a worker found, or why it found nothing."""
    match outcome:
        case Returned(_, value):
            return value, ""
        case TimedOut(_, seconds):
            return None, f"not checked: stopped after {seconds:g} seconds"
        case Died(_, reason, _, _):
            return None, f"not checked: {reason}"
        case _:
            raise TypeError(f"a worker answered with {outcome!r}")
