"""``list`` and ``info``: what is registered."""

import dataclasses
import inspect
import json
import sys
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from testbed.errors import SpecError
from testbed.plugins.base import Plugin, format_value
from testbed.plugins.scheme import Data, Scheme
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
        listed = {name: [_record(plugin) for plugin in plugins.values()] for name, plugins in chosen.items()}
        problems = [dataclasses.asdict(problem) for problem in registry.problems]
        json.dump({**listed, "problems": problems}, sys.stdout, indent=1)
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
            extra = (_claims(plugin()), _needs(plugin())) if issubclass(plugin, Scheme) else ()
            table.add_row(*map(escape, (plugin.name, plugin.title, *extra, plugin.reference)))
        console.print(table)
        console.print()
    for problem in registry.problems:
        console.print(f"[red]not imported:[/red] {escape(problem.source)}: {escape(problem.message)}")


def info_command(name: str, *, as_json: bool) -> None:
    """Print everything a plugin says of itself."""
    registry = load()
    found = [(kind, plugins[name]) for kind, plugins in registry.classes.items() if name in plugins]
    if not found:
        import difflib

        names = sorted({known for plugins in registry.classes.values() for known in plugins})
        near = difflib.get_close_matches(name, names, n=1)
        guess = f"did you mean {near[0]}? " if near else ""
        raise SpecError(f"nothing registered is called {name!r}: {guess}testbed list shows everything")
    if as_json:
        json.dump([{"kind": KINDS[kind][1], **_record(plugin)} for kind, plugin in found], sys.stdout, indent=1)
        sys.stdout.write("\n")
        return
    console = Console()
    for kind, plugin in found:
        console.print(f"[bold]{escape(plugin.title)}[/bold]  ({KINDS[kind][1]} {plugin.name})")
        console.print(f"{escape(plugin.reference)}\n")
        if issubclass(plugin, Scheme):
            console.print(f"claims   {escape(_claims(plugin()))}\nneeds    {escape(_needs(plugin()))}\n")
        parameters = dataclasses.fields(plugin)
        if parameters:
            table = Table("parameter", "default", "type", box=None, pad_edge=False)
            for field in parameters:
                kind_of = inspect.formatannotation(field.type) if not isinstance(field.type, str) else field.type
                table.add_row(*map(escape, (field.name, format_value(field.default), kind_of)))
            console.print(table)
            console.print()
        console.print(escape(inspect.cleandoc(plugin.__doc__ or "")))
        module = sys.modules[plugin.__module__]
        console.print(f"\n[dim]{escape(plugin.__module__)}[/dim]\n{escape(inspect.cleandoc(module.__doc__ or ''))}\n")


def _needs(scheme: Scheme) -> str:
    needs = Data.POINTS
    for plugin in scheme.nested():
        needs |= getattr(plugin, "needs", Data.POINTS)
    return _words(needs)


def _words(data: Data) -> str:
    return ", ".join(str(flag.name).lower().replace("_", " ") for flag in data)


def _claims(scheme: Scheme) -> str:
    claims = [scheme.continuity.value, *([f"order {scheme.order:g}"] if scheme.order is not None else [])]
    return ", ".join([*claims, *(shape.value for shape in scheme.reproduces)])


def _record(plugin: type[Plugin]) -> dict[str, Any]:
    record: dict[str, Any] = {
        "name": plugin.name,
        "title": plugin.title,
        "reference": plugin.reference,
        "module": plugin.__module__,
        "parameters": {field.name: format_value(field.default) for field in dataclasses.fields(plugin)},
        "documentation": inspect.cleandoc(plugin.__doc__ or ""),
    }
    if issubclass(plugin, Scheme):
        scheme = plugin()
        record |= {
            "continuity": scheme.continuity.value,
            "order": scheme.order,
            "reproduces": [shape.value for shape in scheme.reproduces],
            "matches": _words(scheme.matches),
            "needs": _needs(scheme),
            "domain": list(scheme.domain),
            "support": scheme.support,
        }
    return record
