"""``list``: what is registered."""

import dataclasses
import inspect
import json
import sys
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.conformance.catalogue import (
    card,
    claims,
    data_words,
    needs,
)
from testbed.errors import SpecError
from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Scheme
from testbed.registry import KINDS, load

#: What the command line calls the kinds.
_PLURALS = {name.rsplit(" ", 1)[-1] + "s": kind for kind, (_, name) in KINDS.items()}


def list_command(kind: str | None, *, as_json: bool) -> None:
    """Print the plugins of one kind or of all, and what could not be imported."""
    if kind is not None and kind not in _PLURALS:
        raise SpecError(f"there is no kind {kind!r}: kinds are {', '.join(_PLURALS)}")
    registry = load()
    chosen = {name: registry.classes[found] for name, found in _PLURALS.items() if kind in (None, name)}
    if as_json:
        listed = {name: [record(plugin()) for plugin in plugins.values()] for name, plugins in chosen.items()}
        problems = [dataclasses.asdict(problem) for problem in registry.problems]
        unbuilt = [dataclasses.asdict(entry) for entry in registry.not_built] if kind in (None, "schemes") else []
        json.dump({**listed, "not_built": unbuilt, "problems": problems}, sys.stdout, indent=1)
        sys.stdout.write("\n")
        return
    console = Console()
    for name, plugins in chosen.items():
        table = Table(title=name, title_justify="left", title_style="bold", box=None, pad_edge=False)
        table.add_column("name", no_wrap=True)
        table.add_column("title")
        if name == "schemes":
            for heading in ("claims", "needs"):
                table.add_column(heading)
        table.add_column("reference", style="dim")
        for plugin in plugins.values():
            one = plugin()
            extra = (", ".join(claims(one)), data_words(needs(one))) if isinstance(one, Scheme) else ()
            table.add_row(*map(escape, (plugin.name, plugin.title, *extra, plugin.reference)))
        console.print(table)
        console.print()
    if kind in (None, "schemes") and registry.not_built:
        console.print(f"published, not built: {', '.join(entry.name for entry in registry.not_built)}", markup=False)
        console.print("(testbed info NAME says why)\n")
    for problem in registry.problems:
        console.print(f"[red]not imported:[/red] {escape(problem.source)}: {escape(problem.message)}")


def record(plugin: Plugin) -> dict[str, Any]:
    """Return what a plugin says of itself, as plain values."""
    kind = type(plugin)
    record: dict[str, Any] = {
        "name": kind.name,
        "spec": str(plugin),
        "title": kind.title,
        "reference": kind.reference,
        "module": kind.__module__,
        "parameters": {one.name: one.default for one in card(plugin).parameters},
        "documentation": inspect.cleandoc(kind.__doc__ or ""),
    }
    if isinstance(plugin, Scheme | BoundaryCurve):
        told = card(plugin)
        record |= {"formula": told.formula, "status": told.status, "failures": told.failures}
        record |= {"needs": told.needs, "matches": told.matches}
    if isinstance(plugin, Scheme):
        record |= {
            "continuity": plugin.continuity.value,
            "order": plugin.order,
            "reproduces": [shape.value for shape in plugin.reproduces],
            "domain": list(plugin.domain),
            "support": plugin.support,
        }
    return record
