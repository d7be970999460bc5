"""Results made by hand: errors that fall as told, cells that are refused or missing where told, names of any kind."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from testbed.harness.cell import Outcome
from testbed.harness.plan import Cell, Plan, PlannedDataset, PlannedMeasure, PlannedScheme
from testbed.harness.results import Results, tabulate
from testbed.plugins.measure import Column

#: What can go wrong with a text on its way into a page.
HOSTILE: Final = "<img src=x onerror=alert(1)>\"'></title></style></script><script>alert(1)</script>{{ 7777 * 7 }}$x_1$"

COLUMNS: Final = (
    Column("faces", "faces of the mesh"),
    Column("epsilon_deg", "largest angle between neighbours, degrees", converges=True),
    Column("epsilon_face", "its face"),
    Column("epsilon_bary", "its place"),
    Column("gap_max", "largest gap"),
    Column("edges_above_0p1_deg", "share of the edges above 0.1 degrees"),
    Column("gauss_min", "smallest Gaussian curvature"),
    Column("gauss_max", "largest Gaussian curvature"),
    Column("distance_max", "largest distance", converges=True, exact=True),
    Column("normal_max_deg", "largest angle to the normal, degrees", converges=True, exact=True),
    Column("fallbacks", "fallbacks taken"),
    Column("notes", "the fallbacks by kind"),
)
RUN: Final[Mapping[str, Any]] = {
    "versions": {"testbed": "0.0", "numpy": "1.2.3"},
    "machine": {"system": "Hand", "processors": 3},
    "command": ["testbed", "run", "-o", "a directory"],
    "jobs": 2,
    "started": "2024-05-06T07:08:09+0000",
    "seconds": 61.0,
}

Make = Callable[[str, str, int], Outcome | None]


def good(scheme: str, dataset: str, level: int, **changed: Any) -> Outcome:
    """Return a cell that is ok: the error of ``p2`` falls with order 2, that of any other scheme with order 4."""
    h = 0.5**level
    error = h ** (2 if scheme == "p2" else 4)
    values: dict[str, Any] = {
        "faces": 8 * 4**level,
        "epsilon_deg": 10.0 * error,
        "epsilon_face": level,
        "epsilon_bary": "0.5;0.25;0.25",
        "gap_max": 0.0,
        "edges_above_0p1_deg": 0.125,
        "gauss_min": 1.0 - error,
        "gauss_max": 1.0 + 2.0 * error,
        "distance_max": 0.1 * error,
        "normal_max_deg": 5.0 * error,
        "fallbacks": 0,
        "notes": "",
    }
    del dataset
    return Outcome(
        "ok",
        faces=8 * 4**level,
        patches=24 * 4**level,
        h=h,
        diameter=2.0,
        values=values | changed,
        fit_seconds=0.25,
        measure_seconds=0.5,
    )


def results(
    schemes: Sequence[str] = ("p2", "p4"),
    datasets: Sequence[str] = ("ball",),
    levels: int = 4,
    make: Make = good,
    *,
    text: str = "a text",
    run: Mapping[str, Any] = RUN,
    shape: str | None = "spheres",
    columns: tuple[Column, ...] = COLUMNS,
) -> Results:
    """Return results of a grid.

    Parameters
    ----------
    schemes, datasets, levels
        The grid. Schemes claim C0, order 2 and spheres.
    make
        The outcome of a cell, or None for a cell without a result.
    text
        Titles, references and meanings.
    run, shape, columns
        The record of the run, the shape of the datasets, the columns.
    """
    plan = Plan(
        tuple(
            Cell(scheme, dataset, level, 8, "", f"{scheme}/{dataset}/{level}")
            for scheme in schemes
            for dataset in datasets
            for level in range(levels)
        ),
        tuple(PlannedScheme(one, text, text, "C0", 2.0, ("spheres",), ("POINTS",), "12ab") for one in schemes),
        tuple(PlannedDataset(one, text, text, closed=True, shape=shape, source="34cd") for one in datasets),
        (PlannedMeasure("by-hand", text, columns, "56ef"),),
    )
    made = {cell.key: make(cell.scheme, cell.dataset, cell.level) for cell in plan.cells}
    return tabulate(plan, {key: one for key, one in made.items() if one is not None}, run)


def without(outcome: Outcome, *names: str) -> Outcome:
    """Return a cell without some of its values."""
    values = {name: value for name, value in (outcome.values or {}).items() if name not in names}
    return Outcome(
        "ok",
        faces=outcome.faces,
        patches=outcome.patches,
        h=outcome.h,
        diameter=outcome.diameter,
        values=values,
        fit_seconds=outcome.fit_seconds,
    )
