"""What the tables of a dataset show: schemes at one level, and every level."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from testbed.harness.claims import CURVED, SMOOTH_DEG
from testbed.harness.plan import PlannedDataset
from testbed.harness.results import enclosures
from testbed.measures.convergence import FLOOR
from testbed_reports.formatting import Entry, entry, shorten
from testbed_reports.grid import Grid, Row, is_ok
from testbed_reports.orders import order_entry


@dataclass(frozen=True)
class Quantity:
    """A column of a table of schemes.

    Parameters
    ----------
    column
        Column of the results; :data:`ORDER` for the order of the largest distance, which belongs to all levels.
    group, heading
        What stands above it: the group's heading is shared by its neighbours, and may be empty.
    best
        Which value is best: the ``least``; that of the least ``spread`` between the group's two columns, where the
        exact surface's curvature is constant; or none.
    percent
        Whether it is a share, shown in percent.
    """

    column: str
    group: str
    heading: str
    best: Literal["least", "spread", "none"] = "none"
    percent: bool = False


ORDER: Final = ""
KNOWN: Final = (
    Quantity("patches", "", "patches"),
    Quantity("distance_max", "distance", "max", "least"),
    Quantity("distance_rms", "distance", "rms", "least"),
    Quantity(ORDER, "distance", "order"),
    Quantity("normal_max_deg", "", "normal error (°)", "least"),
    Quantity("gauss_min", "Gaussian curvature", "min", "spread"),
    Quantity("gauss_max", "Gaussian curvature", "max", "spread"),
    Quantity("mean_min", "mean curvature", "min", "spread"),
    Quantity("mean_max", "mean curvature", "max", "spread"),
    Quantity("gauss_error_rms", "error of Gaussian curvature", "rms", "least"),
    Quantity("gauss_error_max", "error of Gaussian curvature", "max", "least"),
    Quantity("epsilon_deg", "", "normal jump ε (°)", "least"),
    Quantity("curvature_jump_max", "", "curvature jump"),
    Quantity("gap_max", "", "gap"),
)
LAST: Final = (
    Quantity("curvature_corner_margin", "", "corner margin"),
    Quantity("fallbacks", "", "fall\N{SOFT HYPHEN}backs"),
    Quantity("fit_seconds", "", "fit (s)"),
)
#: Shapes of constant curvature.
CONSTANT: Final = ("spheres", "planes")
#: Gaussian curvature times the square of the edge length, and mean curvature times it, up to which they are rounding.
CURVATURE_ROUNDING: Final = 1e-10
#: Columns that count edges with a larger angle, named for it: ``edges_above_0p057_deg``.
_SHARE: Final = re.compile(r"edges_above_(\d+(?:p\d+)?)_deg")


@dataclass(frozen=True)
class SchemeRow:
    """A scheme in a table.

    Parameters
    ----------
    position
        Position of the scheme in the plan; its colour and marker follow from it.
    scheme
        Its text.
    entries
        An entry a column; empty where there is a trouble.
    trouble
        Why there are no numbers, beginning with the status; empty if there are.
    level
        The level, or None where the table is about one.
    """

    position: int
    scheme: str
    entries: tuple[Entry, ...]
    trouble: str = ""
    level: int | None = None


@dataclass(frozen=True)
class Table:
    """A table of schemes.

    Parameters
    ----------
    groups
        Headings over neighbouring columns, each with the number of columns; a column of no group has an empty one.
    headings
        A heading a column, with its meaning.
    rows
        Its rows.
    """

    groups: tuple[tuple[str, int], ...]
    headings: tuple[tuple[str, str], ...]
    rows: tuple[SchemeRow, ...]


def quantities(grid: Grid, dataset: str) -> tuple[Quantity, ...]:
    """Return the quantities that some cell of a dataset has a value for."""
    shares = [
        Quantity(match[0], "edges above (%)", f"{match[1].replace('p', '.')}°", "least", percent=True)
        for match in map(_SHARE.fullmatch, grid.columns)
        if match
    ]
    rows = list(grid.on(dataset))
    known = {name for name in grid.columns if any(row[name] is not None for row in rows)}
    known |= {ORDER} if "distance_max" in known else set()
    return tuple(one for one in (*KNOWN, *shares, *LAST) if one.column in known)


def comparison(grid: Grid, dataset: str, level: int) -> Table:
    """Return the table of the schemes at a level, with the best values marked and the order of the distance."""
    shown = quantities(grid, dataset)
    rows = grid.at(dataset, level)
    marks = {one.column: best(rows, one, grid.shape(dataset)) for one in shown}
    enclosed = enclosures(grid.columns)
    table = []
    for position, (scheme, row) in enumerate(zip(grid.schemes, rows, strict=True)):
        if not grid.planned(scheme, dataset):
            continue
        if row is None or row["status"] != "ok":
            table.append(SchemeRow(position, scheme, (), trouble(row)))
            continue
        order = order_entry(grid, scheme, dataset, "distance_max")
        order = replace(order, text=f"{order.text} {order.place}".strip(), place="")
        entries = (
            order if one.column == ORDER else _of(row, one.column, percent=one.percent, bounds=enclosed.get(one.column))
            for one in shown
        )
        marked = (replace(found, best=position in marks[one.column]) for found, one in zip(entries, shown, strict=True))
        table.append(SchemeRow(position, scheme, tuple(marked)))
    meanings = _meanings(grid)
    headings = [(one.heading, meanings.get(one.column, "")) for one in shown]
    groups: list[tuple[str, int]] = []
    for one in shown:
        if groups and one.group and groups[-1][0] == one.group:
            groups[-1] = (one.group, groups[-1][1] + 1)
        else:
            groups.append((one.group, 1))
    return Table(tuple(groups), tuple(headings), tuple(table))


def best(rows: Sequence[Row | None], quantity: Quantity, shape: str | None = None) -> frozenset[int]:
    """Return the positions of the best values, those that read the same included; none where most are as good.

    Cells that are not ok and missing numbers take no part. Values up to the rounding floor are equal.
    """
    scored = {position: score(row, quantity, shape) for position, row in enumerate(rows)}
    ranked = {position: value for position, value in scored.items() if value is not None}
    least = min(ranked.values(), default=0.0)
    chosen = {position for position, value in ranked.items() if shorten(value) == shorten(least)}
    return frozenset() if 2 * len(chosen) > len(ranked) else frozenset(chosen)


def score(row: Row | None, quantity: Quantity, shape: str | None = None) -> float | None:
    """Return what is to be least in a row: the value, or the spread of its pair; None if there is none to rank.

    The spread of curvatures is ranked on spheres and planes, where the exact surface has none. On spheres a surface
    without any curvature takes no part: its spread is zero, and wrong.
    """
    if row is None or not is_ok(row) or quantity.best == "none":
        return None
    if quantity.best == "spread":
        if shape not in CONSTANT:
            return None
        stem = quantity.column.rpartition("_")[0]
        low, high = row.get(f"{stem}_min"), row.get(f"{stem}_max")
        if low is None or high is None or (shape != "planes" and low == high == 0.0):
            return None
        spread = float(high) - float(low)
        power = 2 if stem == "gauss" else 1
        return 0.0 if spread * float(row["h"] or 0.0) ** power <= CURVATURE_ROUNDING else spread
    value = row.get(quantity.column)
    if value is None:
        return None
    return 0.0 if float(value) <= _floor(row, quantity.column) else float(value)


def _floor(row: Row, column: str) -> float:
    """Values up to this are as good as zero: rounding, or a normal jump that counts as none."""
    if column == "epsilon_deg":
        return SMOOTH_DEG
    if column == "curvature_jump_max":
        return CURVED
    if column.endswith("_deg"):
        return FLOOR * 180.0
    if column.startswith(("gauss_error", "mean_error")):
        return CURVATURE_ROUNDING / float(row["h"] or 1.0) ** (2 if column.startswith("gauss") else 1)
    return FLOOR * float(row["diameter"] or 0.0) if column.startswith("distance") else 0.0


def trouble(row: Row | None) -> str:
    """Return why a cell has no numbers."""
    if row is None:
        return "not computed yet"
    return f"{row['status']}: {row['reason'] or 'no reason was given'}"


def every_level(grid: Grid, dataset: str) -> Table:
    """Return the table of all cells of a dataset with all columns, the places of the extremes beside them."""
    rows = list(grid.on(dataset))
    hosts = _hosts(grid.columns)
    enclosed = enclosures(grid.columns)
    beside = {name for pairs in (hosts, enclosed) for pair in pairs.values() for name in pair}
    beside |= {"scheme", "dataset", "level", "status", "reason"}
    beside |= {"notes"} if "fallbacks" in grid.columns else set()
    names = [name for name in grid.columns if name not in beside and any(row[name] not in (None, "") for row in rows)]
    table = []
    positions = {scheme: position for position, scheme in enumerate(grid.schemes)}
    for row in rows:
        why = "" if is_ok(row) else trouble(row)
        entries = () if why else tuple(_of(row, name, hosts.get(name), bounds=enclosed.get(name)) for name in names)
        table.append(SchemeRow(positions[row["scheme"]], row["scheme"], entries, why, row["level"]))
    meanings = _meanings(grid)
    return Table((), tuple((name, meanings.get(name, "")) for name in names), tuple(table))


def _hosts(columns: Sequence[str]) -> Mapping[str, tuple[str, str]]:
    """Return for each column with a place the columns of its face and barycentric coordinates."""
    result = {}
    for face in columns:
        stem = face.removesuffix("_face")
        if face.endswith("_face") and f"{stem}_bary" in columns:
            host = next((name for name in (stem, f"{stem}_deg", f"{stem}_max") if name in columns), None)
            if host is not None:
                result[host] = (face, f"{stem}_bary")
    return result


def _of(
    row: Row,
    column: str,
    place: tuple[str, str] | None = None,
    *,
    percent: bool = False,
    bounds: tuple[str, str] | None = None,
) -> Entry:
    """Return the entry of a value, with its place beside it and its guaranteed bounds to point at."""
    where = ""
    if column == "fallbacks":
        where = str(row.get("notes") or "")
    elif place is not None and row[place[0]] not in (None, -1):
        coordinates = " ".join(_coordinate(text) for text in str(row[place[1]] or "").split(";"))
        where = f"face {row[place[0]]} ({coordinates})"
    found = entry(row[column], where, percent=percent)
    if bounds is None or any(row[bound] is None for bound in bounds):
        return found
    low, high = (float(row[bound]) for bound in bounds)
    return replace(found, exact=f"{found.exact}; guaranteed from {low!r} to {high!r}")


def _coordinate(text: str) -> str:
    try:
        return f"{float(text):.3f}"
    except ValueError:
        return text


def without_exact_surface(grid: Grid, dataset: PlannedDataset) -> bool:
    """Whether cells of a dataset are ok, and none has a value that needs the exact surface."""
    names = [column.name for column in grid.plan.columns if column.exact]
    rows = [row for row in grid.on(dataset.spec) if is_ok(row)]
    return bool(names and rows) and all(row[name] in (None, "") for row in rows for name in names)


def _meanings(grid: Grid) -> dict[str, str]:
    own = {"diameter": "diagonal of the box around the mesh", "fit_seconds": "time to build the surface, seconds"}
    own["measure_seconds"] = "time to measure it, seconds"
    own[ORDER] = "order of the largest distance over all levels, with its interval"
    return own | {column.name: column.meaning for column in grid.plan.columns}
