"""``info``: everything about one plugin, and what comes of checking it if it is a scheme."""

import dataclasses
import json
import sys

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.cli.listing import record
from testbed.cli.tables import wide
from testbed.conformance.catalogue import Findings, card, findings, patch_words, stored_words
from testbed.conformance.subject import Status
from testbed.errors import SpecError
from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.not_built import NotBuilt
from testbed.plugins.scheme import Scheme
from testbed.plugins.spec import parse
from testbed.registry import KINDS, Registry, load


def info_command(name: str, *, as_json: bool) -> None:
    """Print everything a plugin says of itself, and of a scheme what comes of checking it."""
    registry = load()
    unbuilt = next((entry for entry in registry.not_built if entry.name == name), None)
    if unbuilt is not None:
        _print_not_built(unbuilt, as_json=as_json)
        return
    plugins = [(kind, parse(name, kind, registry)) for kind in _kinds(name, registry)]
    if as_json:
        json.dump([{"kind": KINDS[kind][1], **record(plugin)} for kind, plugin in plugins], sys.stdout, indent=1)
        sys.stdout.write("\n")
        return
    console = wide()
    for kind, plugin in plugins:
        _print(console, kind, plugin)


def _kinds(name: str, registry: Registry) -> list[type[Plugin]]:
    """Return the kinds that have a plugin of that name, parameters apart; SpecError if none has."""
    base = name.partition("[")[0].partition(":")[0].strip()
    kinds = [kind for kind, plugins in registry.classes.items() if base in plugins]
    if not kinds:
        import difflib

        names = sorted({known for plugins in registry.classes.values() for known in plugins})
        near = difflib.get_close_matches(base, names, n=1)
        guess = f"did you mean {near[0]}? " if near else ""
        raise SpecError(f"nothing registered is called {base!r}: {guess}testbed list shows everything")
    return kinds


def _print(console: Console, kind: type[Plugin], plugin: Plugin) -> None:
    told = card(plugin)
    console.print(f"[bold]{escape(told.title)}[/bold]  ({KINDS[kind][1]} {escape(str(plugin))})")
    console.print(escape(told.reference) + "\n")
    facts = [("what", told.summary), ("formula", told.formula), ("status", told.status), ("needs", told.needs)]
    if isinstance(plugin, Scheme):
        facts += [("claims", ", ".join(told.claims)), ("matches", told.matches), ("faces", told.faces)]
        facts += [("depends on", told.support), ("boundary", told.network)]
        facts += found_facts(findings(str(plugin)))
    elif isinstance(plugin, BoundaryCurve):
        facts.append(("matches", told.matches))
    facts.append(("known failures", told.failures))
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", no_wrap=True)
    grid.add_column()
    for heading, text in facts:
        if text:
            grid.add_row(heading, escape(text))
    console.print(grid)
    if told.parameters:
        table = Table("parameter", "value", "type", "meaning", box=None, pad_edge=False)
        for one in told.parameters:
            table.add_row(*map(escape, (one.name, one.default, one.type, one.meaning)))
        console.print()
        console.print(table)
    console.print(f"\n[dim]{escape(type(plugin).__module__)}[/dim]\n{escape(told.documentation)}\n")


def found_facts(result: Findings) -> list[tuple[str, str]]:
    """Return what came of checking a scheme, as headings and texts."""
    facts = []
    if result.profile is not None:
        facts += [("patches", patch_words(result.profile)), ("stored a face", stored_words(result.profile))]
        facts.append(("cost of a jet", f"{result.profile.cost:g} cubic triangles, timed here"))
    verdicts = [
        f"{one.property}: {one.status.value}" + (f", {one.detail}" if one.status is Status.FAILED else "")
        for one in result.outcomes
        if one.status in (Status.FAILED, Status.NOT_TESTABLE)
    ]
    passed = result.count(Status.PASSED)
    facts.append(("checks", "; ".join([f"{passed} of {passed + len(verdicts)} passed", *verdicts])))
    return facts


def _print_not_built(entry: NotBuilt, *, as_json: bool) -> None:
    if as_json:
        json.dump([{"kind": "not built", **dataclasses.asdict(entry)}], sys.stdout, indent=1)
        sys.stdout.write("\n")
        return
    console = wide()
    console.print(f"[bold]{escape(entry.title)}[/bold]  (published, not built)\n{escape(entry.reference)}\n")
    console.print(f"{escape(entry.why)}\nnearest  {escape(', '.join(entry.nearest))}", soft_wrap=False)
