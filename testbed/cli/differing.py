"""``diff``: two results compared."""

import json
import math
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from testbed.cli.options import Json

if TYPE_CHECKING:
    from rich.table import Table

    from testbed.harness.differences import Comparison
    from testbed.harness.value_differences import Difference

_STYLES = {"regressed": "bold red", "vanished": "red", "changed": "yellow", "improved": "green", "appeared": "cyan"}


def diff(
    old: Annotated[Path, typer.Argument(metavar="OLD", help="A directory that a run has written, or a results.csv.")],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="The same, to be compared with it.")],
    *,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="REL", help="Relative difference up to which numbers are unchanged.")
    ] = 1e-6,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds", metavar="REL", help="Compare times too, with this tolerance. Default: leave them out."
        ),
    ] = None,
    fail_on: Annotated[
        str | None,
        typer.Option(
            "--fail-on",
            metavar="KIND",
            help="Exit with code 1 if something regressed (or vanished), or changed at all.",
        ),
    ] = None,
    rows: Annotated[int, typer.Option("--rows", min=0, metavar="N", help="Differences to show, the worst first.")] = 20,
    as_json: Json = False,
) -> None:
    """Compare two results: what improved, regressed, appeared, vanished or changed, the worst first.

    Numbers are compared where both cells are ok; orders differ where their intervals are apart.
    """
    from testbed.cli.tables import wide
    from testbed.errors import SpecError
    from testbed.harness.comparable import read_comparable
    from testbed.harness.differences import FAILING, compare

    if fail_on is not None and fail_on not in FAILING:
        raise SpecError(f"there is no condition {fail_on!r} to fail on: take {' or '.join(FAILING)}")
    for name, value in (("tolerance", tolerance), ("seconds", seconds)):
        if value is not None and not 0.0 <= value < math.inf:
            raise SpecError(f"--{name} cannot be {value:g}: give a number that is not negative, as 0.01")
    found = compare(read_comparable(old), read_comparable(new), tolerance, seconds)
    failed = fail_on is not None and found.fails(fail_on)
    if as_json:
        json.dump(_plain(found, old, new, failed=failed), sys.stdout, indent=1, allow_nan=False)
        sys.stdout.write("\n")
    else:
        console = wide()
        console.print(f"{old} -> {new}: {found.sentence()}", markup=False, soft_wrap=True)
        for note in found.notes:
            console.print(note, markup=False, soft_wrap=True)
        groups = _grouped(found.differences)
        if groups and rows:
            console.print()
            console.print(_table(groups[:rows]))
        if len(groups) > rows:
            console.print(f"and {len(groups) - rows} more: --rows {len(groups)} shows all", markup=False)
    raise typer.Exit(int(failed))


def _grouped(differences: "Iterable[Difference]") -> "list[tuple[Difference, int]]":
    """Return for each cell its worst difference and how many others it has; all others one by one."""
    first: dict[tuple[Any, ...], tuple[Difference, int]] = {}
    for one in differences:
        place = one.place[:-1] if one.what == "cell" else one.place
        worst, others = first.get(place, (one, -1))
        first[place] = worst, others + 1
    return list(first.values())


def _table(groups: "Iterable[tuple[Difference, int]]") -> "Table":
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for heading in ("", "", "scheme", "dataset", "level", "quantity"):
        table.add_column(heading, justify="right" if heading == "level" else "left", overflow="fold")
    for heading in ("old", "new", "times"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("")
    for one, others in groups:
        more = f"and {others} more of the cell" if others else one.reason
        level = "" if one.level is None else str(one.level)
        texts = (one.what, one.scheme, one.dataset, level, one.quantity, _text(one.old), _text(one.new))
        times = "" if math.isnan(one.factor) else f"{one.factor:.4g}"
        table.add_row(f"[{_STYLES[one.kind]}]{one.kind}[/]", *map(escape, texts), times, escape(more))
    return table


def _text(value: float | str | None) -> str:
    return "-" if value is None else value if isinstance(value, str) else f"{value:.6g}"


def _plain(found: "Comparison", old: Path, new: Path, *, failed: bool) -> dict[str, Any]:
    """Return a comparison as JSON holds it; infinite numbers as texts, as JSON has none."""

    def number(value: float | str | None) -> float | str | None:
        if not isinstance(value, float) or math.isfinite(value):
            return value
        return None if math.isnan(value) else str(value)

    return {
        "old": str(old),
        "new": str(new),
        "failed": failed,
        "sentence": found.sentence(),
        "cells": dict(sorted(found.cells.items())),
        "orders": dict(sorted(found.orders.items())),
        "claims": dict(sorted(found.claims.items())),
        "notes": list(found.notes),
        "differences": [{name: number(value) for name, value in vars(one).items()} for one in found.differences],
    }
