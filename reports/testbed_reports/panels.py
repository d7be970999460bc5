"""What the plots of a dataset show, free of drawing."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from testbed.harness.claims import SMOOTH_DEG
from testbed_reports.grid import Grid, Row
from testbed_reports.tables import CURVATURE_ROUNDING

#: Quantities whose convergence is drawn: column, title, label of the axis.
CONVERGING: Final = (
    ("distance_max", "Largest distance", "distance (length)"),
    ("normal_max_deg", "Largest normal error", "angle (degrees)"),
    ("gauss_error_rms", "Error of Gaussian curvature, rms", "K (1/length²)"),
    ("epsilon_deg", "Largest normal jump ε", "angle (degrees)"),
)
#: Schemes drawn together; more are drawn in groups.
TOGETHER: Final = 10
#: More reference slopes than this hide the data.
MOST_SLOPES: Final = 4


@dataclass(frozen=True)
class Line:
    """A scheme's values over the edge length.

    Parameters
    ----------
    position
        Position of the scheme in the plan.
    h, values
        A point a level.
    used
        Whether a level took part in the fit of the order; a point that did not is drawn hollow.
    dashed
        Whether the line is dashed: the lower of a pair.
    """

    position: int
    h: tuple[float, ...]
    values: tuple[float, ...]
    used: tuple[bool, ...]
    dashed: bool = False


@dataclass(frozen=True)
class Panel:
    """One plot.

    Parameters
    ----------
    title, label
        What it shows, and the label of its vertical axis with the unit.
    lines
        Its lines.
    logarithmic
        Whether the vertical axis is logarithmic; else values of both signs are shown.
    slopes
        Orders to draw for reference.
    smooth
        Values up to this count as none; None where nothing does.
    zeros
        Texts of the schemes that are zero on a level, which a logarithmic axis cannot show.
    rounding
        Differences up to this are rounding, and an axis that is not logarithmic does not resolve them.
    band
        Edge length, least and largest value over the schemes of all groups, a triple a level; empty for one group.
    """

    title: str
    label: str
    lines: tuple[Line, ...]
    logarithmic: bool = True
    slopes: tuple[int, ...] = ()
    smooth: float | None = None
    zeros: tuple[str, ...] = ()
    rounding: float = 0.0
    band: tuple[tuple[float, float, float], ...] = ()

    @property
    def lengths(self) -> tuple[float, ...]:
        """Edge lengths that the axis covers, rising; the same for all groups."""
        return tuple(sorted({h for line in self.lines for h in line.h} | {h for h, _, _ in self.band}))

    @property
    def values(self) -> tuple[float, ...]:
        """Values that the axis covers, rising; the same for all groups."""
        own = [value for line in self.lines for value in line.values]
        return tuple(sorted([*own, *(value for _, *ends in self.band for value in ends)]))


@dataclass(frozen=True)
class Group:
    """Schemes that are drawn together.

    Parameters
    ----------
    title
        What they have in common; empty where there is one group.
    positions
        Their positions in the plan.
    """

    title: str
    positions: tuple[int, ...]


def groups(grid: Grid) -> tuple[Group, ...]:
    """Return the groups that schemes are drawn in: by the joins they claim and whether they split faces.

    Of a scheme on several boundary curves, only that on its default curves is drawn, unless few schemes are there.
    """
    everyone = tuple(range(len(grid.schemes)))
    if len(everyone) <= TOGETHER:
        return (Group("", everyone),)
    families = {scheme.family for scheme in grid.plan.schemes}
    drawn = [p for p in everyone if grid.schemes[p] in families or grid.plan.schemes[p].family not in grid.schemes]
    split = _splits(grid)
    kinds = {
        "C0": [p for p in drawn if grid.plan.schemes[p].continuity == "C0"],
        "continuous tangent planes, several patches a face": [
            p for p in drawn if grid.plan.schemes[p].continuity != "C0" and p in split
        ],
        "continuous tangent planes, one patch a face": [
            p for p in drawn if grid.plan.schemes[p].continuity != "C0" and p not in split
        ],
    }
    found = []
    for title, positions in kinds.items():
        parts = -(-len(positions) // TOGETHER)
        for part in range(parts):
            number = f" ({part + 1} of {parts})" if parts > 1 else ""
            found.append(Group(f"{title}{number}", tuple(positions[part::parts])))
    return tuple(found)


def _splits(grid: Grid) -> frozenset[int]:
    """Positions of the schemes that have more patches than faces somewhere."""
    positions = {scheme: position for position, scheme in enumerate(grid.schemes)}
    return frozenset(
        positions[scheme]
        for (scheme, _, _), row in grid.cells.items()
        if row["status"] == "ok" and row.get("patches") and row.get("faces") and row["patches"] > row["faces"]
    )


def panels(grid: Grid, dataset: str, group: Group | None = None) -> tuple[Panel, ...]:
    """Return the plots of a dataset: convergence of what converges, and the extremes of the Gaussian curvature.

    Those of a group have the axes of all schemes together, and their range as a band.
    """
    found = (*(convergence(grid, dataset, *what) for what in CONVERGING), curvature(grid, dataset))
    if group is None or not group.title:
        return tuple(panel for panel in found if panel.lines)
    return tuple(_of_group(grid, panel, group) for panel in found if panel.lines)


def _of_group(grid: Grid, panel: Panel, group: Group) -> Panel:
    """Return a panel with the lines of a group, and all lines' range as its band."""
    ranges: dict[float, list[float]] = {}
    for line in panel.lines:
        for h, value in zip(line.h, line.values, strict=True):
            ranges.setdefault(h, []).append(value)
    band = tuple((h, min(values), max(values)) for h, values in sorted(ranges.items()))
    names = {grid.schemes[position] for position in group.positions}
    return replace(
        panel,
        lines=tuple(line for line in panel.lines if line.position in group.positions),
        zeros=tuple(name for name in panel.zeros if name in names),
        band=band,
    )


def convergence(grid: Grid, dataset: str, column: str, title: str, label: str) -> Panel:
    """Return the plot of a quantity against the edge length."""
    lines, zeros = [], []
    for position, scheme in enumerate(grid.schemes):
        rows = _with(grid.ok(scheme, dataset), [column])
        positive = [row for row in rows if math.isfinite(row[column]) and row[column] > 0.0]
        used = _used(grid, scheme, dataset, column)
        if any(row[column] == 0.0 for row in rows):
            zeros.append(scheme)
        if positive:
            values = tuple(float(row[column]) for row in positive)
            lines.append(Line(position, _lengths(positive), values, tuple(row["level"] in used for row in positive)))
    smooth = SMOOTH_DEG if column == "epsilon_deg" else None
    return Panel(title, label, tuple(lines), slopes=_slopes(grid, dataset, column), smooth=smooth, zeros=tuple(zeros))


def curvature(grid: Grid, dataset: str) -> Panel:
    """Return the plot of the extremes of the Gaussian curvature; the least values are dashed."""
    lines = []
    for position, scheme in enumerate(grid.schemes):
        rows = _with(grid.ok(scheme, dataset), ["gauss_max", "gauss_min"])
        rows = [row for row in rows if math.isfinite(row["gauss_max"]) and math.isfinite(row["gauss_min"])]
        if rows:
            for column in ("gauss_max", "gauss_min"):
                values = tuple(float(row[column]) for row in rows)
                lines.append(Line(position, _lengths(rows), values, (True,) * len(rows), column == "gauss_min"))
    longest = max((h for line in lines for h in line.h), default=1.0)
    rounding = CURVATURE_ROUNDING / longest**2
    return Panel("Gaussian curvature, max and min", "K (1/length²)", tuple(lines), logarithmic=False, rounding=rounding)


def _with(rows: Iterable[Row], columns: Sequence[str]) -> list[Row]:
    """Return the rows with a length and a value in every column."""
    return [row for row in rows if all(row.get(name) is not None for name in ("h", *columns)) and row["h"] > 0.0]


def _lengths(rows: Iterable[Row]) -> tuple[float, ...]:
    return tuple(float(row["h"]) for row in rows)


def _used(grid: Grid, scheme: str, dataset: str, column: str) -> frozenset[int]:
    row = grid.orders.get((scheme, dataset, column))
    return frozenset(map(int, str(row["levels_used"] or "").split())) if row else frozenset()


def _slopes(grid: Grid, dataset: str, column: str) -> tuple[int, ...]:
    """Return whole orders next to those estimated, spread over them if they are many; none where none was."""
    orders = [row["order"] for (_, on, quantity), row in grid.orders.items() if (on, quantity) == (dataset, column)]
    whole = sorted({round(order) for order in orders if order is not None and 0.5 < order < 12.5})
    if len(whole) > MOST_SLOPES:
        whole = [whole[round(i * (len(whole) - 1) / (MOST_SLOPES - 1))] for i in range(MOST_SLOPES)]
    return tuple(whole)
