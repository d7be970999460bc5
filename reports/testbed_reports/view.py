"""Everything the page shows, free of markup: from results to texts, entries and plots to be drawn."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from testbed.harness.plan import PlannedDataset
from testbed.harness.results import Results
from testbed_reports.findings import Findings, findings
from testbed_reports.formatting import Entry, counted, seconds
from testbed_reports.grid import Grid, is_ok
from testbed_reports.orders import OrderRow, every_order, order_entry
from testbed_reports.panels import Panel, groups, panels
from testbed_reports.ranking import Ranking, rankings
from testbed_reports.styles import Style, style
from testbed_reports.summary import CONTESTS, Contest, contests, sentences
from testbed_reports.tables import (
    CONSTANT,
    Table,
    comparison,
    every_level,
    trouble,
    without_exact_surface,
)
from testbed_reports.verdicts import LEGEND, SYMBOLS, Matrix, matrix

#: How a page tells whether meshes of a dataset are closed.
CLOSED: Final[Mapping[bool | None, str]] = {True: "closed", False: "open", None: "closed or open, not declared"}


@dataclass(frozen=True)
class OverviewCell:
    """An order in the overview, with the verdict on the claim."""

    order: Entry
    verdict: str
    reason: str


@dataclass(frozen=True)
class Drawing:
    """Plots of a group of schemes on a dataset: the group's title, positions and texts of its schemes, the plots."""

    title: str
    schemes: tuple[tuple[int, str], ...]
    panels: tuple[Panel, ...]


@dataclass(frozen=True)
class Section:
    """A dataset.

    Parameters
    ----------
    dataset
        What it declares.
    closed
        Whether its meshes are, in words.
    remark
        What the reader has to know about its numbers; may be empty.
    drawings
        Its plots, by groups of schemes.
    level, size
        The level that schemes are compared at and its size in words, or None and nothing.
    constant
        Whether the exact surface has the same curvature everywhere, so that the spread of curvature is ranked.
    table
        The schemes at that level, or None where no cell is ok.
    levels, orders
        Every cell and every order.
    planned
        Levels of the plan.
    schemes
        Positions of the schemes that are computed on it.
    """

    dataset: PlannedDataset
    closed: str
    remark: str
    drawings: tuple[Drawing, ...]
    level: int | None
    size: str
    constant: bool
    table: Table | None
    levels: Table
    orders: tuple[OrderRow, ...]
    planned: tuple[int, ...]
    schemes: tuple[int, ...]


@dataclass(frozen=True)
class Trace:
    """A failed cell with its traceback."""

    cell: str
    text: str


@dataclass(frozen=True)
class Page:
    """All of the page.

    Parameters
    ----------
    sentences, contests, headings
        The summary in words, and the winners on each dataset under their headings.
    facts
        How the run was made: name and text.
    styles
        Colour and marker of each scheme.
    schemes
        Texts of the schemes.
    rankings, findings
        Who is best at what among schemes of the same faces, and what schemes and boundary curves do, None where there
        is nothing to compare.
    matrix, legend, symbols
        Verdicts on claims, what they mean, and their symbols.
    overview
        For each scheme the orders of the largest distance by dataset.
    sections
        The datasets.
    meanings
        Measures with the meaning of their columns.
    hashes
        Kinds of plugins with the source hash of each.
    missing
        Cells without a result.
    traces
        Tracebacks of failed cells.
    command
        The command that computes all of this.
    """

    sentences: tuple[str, ...]
    contests: tuple[Contest, ...]
    headings: tuple[str, ...]
    facts: tuple[tuple[str, str], ...]
    styles: tuple[Style, ...]
    schemes: tuple[str, ...]
    rankings: tuple[Ranking, ...]
    findings: Findings | None
    matrix: Matrix
    legend: tuple[tuple[str, str], ...]
    symbols: Mapping[str, str]
    overview: tuple[tuple[OverviewCell, ...], ...]
    sections: tuple[Section, ...]
    meanings: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    hashes: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    missing: tuple[str, ...]
    traces: tuple[Trace, ...]
    command: str


def view(results: Results) -> Page:
    """Return what the page shows of results, finished or not."""
    grid = Grid.of(results)
    plan = results.plan
    kinds = (("schemes", plan.schemes), ("datasets", plan.datasets), ("measures", plan.measures))
    return Page(
        sentences(grid, len(results.missing)),
        contests(grid),
        tuple(heading for heading, _, _ in CONTESTS),
        facts(results.run),
        _styles(grid),
        grid.schemes,
        rankings(grid),
        findings(grid),
        matrix(grid),
        LEGEND,
        SYMBOLS,
        tuple(tuple(_overview(grid, scheme, dataset) for dataset in grid.datasets) for scheme in grid.schemes),
        tuple(_section(grid, dataset) for dataset in plan.datasets),
        tuple((one.title, tuple((column.name, column.meaning) for column in one.columns)) for one in plan.measures),
        tuple((kind, tuple((one.spec, one.source) for one in found)) for kind, found in kinds),
        tuple(map(str, results.missing)),
        tuple(
            Trace(f"{scheme} on {dataset}, level {level}", text)
            for (scheme, dataset, level), text in results.tracebacks.items()
        ),
        shlex.join(map(str, results.run.get("command", ("testbed", "run")))),
    )


def facts(run: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return how a run was made as names and texts; only what its record says."""
    found = []
    if "command" in run:
        found.append(("Command", shlex.join(map(str, run["command"]))))
    if "started" in run:
        found.append(("Run", f"{run['started']}{_took(run)}"))
    if run.get("left_out"):
        levels = "; ".join(f"{name}, levels {' '.join(map(str, some))}" for name, some in run["left_out"].items())
        found.append(("Left out", f"{levels}: testbed run --all computes them"))
    if "versions" in run:
        found.append(("Versions", ", ".join(f"{name} {version}" for name, version in run["versions"].items())))
    if "machine" in run:
        found.append(("Machine", ", ".join(_machine(run["machine"]))))
    if not run:
        found.append(("Run", "not ended yet: there is no record of it"))
    return tuple(found)


def _took(run: Mapping[str, Any]) -> str:
    jobs = f", {counted(run['jobs'], 'worker')}" if isinstance(run.get("jobs"), int) else ""
    return f", {seconds(float(run['seconds']))}{jobs}" if "seconds" in run else jobs


def _machine(machine: Mapping[str, Any]) -> list[str]:
    known = {"processors": "{} processors"}
    return [known.get(name, "{}").format(value) for name, value in machine.items()]


def _overview(grid: Grid, scheme: str, dataset: str) -> OverviewCell:
    if not grid.planned(scheme, dataset):
        return OverviewCell(Entry("", "the scheme takes other faces than this dataset has"), "", "")
    row = grid.orders.get((scheme, dataset, "distance_max"))
    bad = [cell for cell in grid.on(dataset) if cell["scheme"] == scheme and not is_ok(cell)]
    if bad and not grid.ok(scheme, dataset):
        return OverviewCell(Entry(bad[0]["status"], trouble(bad[0])), "", trouble(bad[0]))
    verdict, reason = (str(row["verdict"]), str(row["reason"] or "")) if row else ("", "")
    return OverviewCell(order_entry(grid, scheme, dataset, "distance_max"), verdict, reason)


def _styles(grid: Grid) -> tuple[Style, ...]:
    """Return the style of each scheme: those drawn together have the most different ones."""
    drawn = [position for group in groups(grid) for position in group.positions]
    order = [*drawn, *(position for position in range(len(grid.schemes)) if position not in set(drawn))]
    number = {position: place for place, position in enumerate(order)}
    return tuple(style(number[position]) for position in range(len(grid.schemes)))


def _drawings(grid: Grid, dataset: str) -> tuple[Drawing, ...]:
    found = []
    for group in groups(grid):
        plots = panels(grid, dataset, group)
        if any(panel.lines for panel in plots):
            drawn = ((p, grid.schemes[p]) for p in group.positions if grid.planned(grid.schemes[p], dataset))
            found.append(Drawing(group.title, tuple(drawn), plots))
    return tuple(found)


def _section(grid: Grid, dataset: PlannedDataset) -> Section:
    level = grid.compared(dataset.spec)
    remarks = []
    if without_exact_surface(grid, dataset):
        remarks.append("It has no exact surface: there are no distances, normal errors and orders of them.")
    planned = grid.levels(dataset.spec)
    if level is not None and planned and level != planned[-1]:
        remarks.append(f"Schemes are compared at level {level}: finer ones have fewer results.")
    faces = next((row["faces"] for row in grid.at(dataset.spec, level or 0) if is_ok(row) and row), None)
    size = f"{counted(faces, 'face')}" if faces is not None else ""
    return Section(
        dataset,
        CLOSED[dataset.closed],
        " ".join(remarks),
        _drawings(grid, dataset.spec),
        level,
        size,
        dataset.shape in CONSTANT,
        None if level is None else comparison(grid, dataset.spec, level),
        every_level(grid, dataset.spec),
        every_order(grid, dataset.spec),
        planned,
        tuple(position for position, scheme in enumerate(grid.schemes) if grid.planned(scheme, dataset.spec)),
    )
