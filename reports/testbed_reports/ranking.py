"""Who is best at what over all datasets: each scheme's errors as factors on the least error any scheme has there."""

import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from testbed.measures.convergence import FLOOR
from testbed_reports.formatting import NOTHING, Entry, counted, listed, shorten
from testbed_reports.grid import Grid, Row, is_ok

#: Datasets that a criterion is about.
Where: TypeAlias = Literal["all", "spheres", "other surfaces"]


@dataclass(frozen=True)
class Criterion:
    """What schemes are ranked by: a column, its heading, its name in a sentence, and the datasets it is about."""

    column: str
    heading: str
    phrase: str
    where: Where = "all"


#: Spheres apart: what fits them may fit nothing else.
CRITERIA: Final = (
    Criterion("gauss_error_rms", "K error rms", "the least error of the Gaussian curvature, root mean square"),
    Criterion("gauss_error_rms", "K error rms", "the least error of the Gaussian curvature", "spheres"),
    Criterion("gauss_error_rms", "K error rms", "the least error of the Gaussian curvature", "other surfaces"),
    Criterion("gauss_error_max", "K error max", "the least largest error of the Gaussian curvature"),
    Criterion("distance_max", "distance max", "the least largest distance"),
    Criterion("distance_max", "distance max", "the least largest distance", "spheres"),
    Criterion("distance_max", "distance max", "the least largest distance", "other surfaces"),
    Criterion("normal_max_deg", "normal error max", "the least largest normal error"),
)
#: As many schemes are named as the best at something.
NAMED: Final = 3


@dataclass(frozen=True)
class RankedScheme:
    """A scheme in the ranking.

    Parameters
    ----------
    position, scheme
        Position in the plan, and text.
    continuity
        What it claims of the joins.
    factors
        Its entry for each criterion: geometric mean over the datasets of its error over the least one there.
    orders
        Median of its orders of the largest distance over the datasets.
    """

    position: int
    scheme: str
    continuity: str
    factors: tuple[Entry, ...]
    orders: Entry


@dataclass(frozen=True)
class Ranking:
    """The ranking.

    Parameters
    ----------
    criteria
        The criteria that the results have columns for.
    places
        Datasets with the level compared at.
    rows
        Schemes that are ok on all of them, the best by the first criterion first.
    unranked
        Schemes that are not, with the first dataset where, in words.
    sentences
        Who is best at what.
    """

    criteria: tuple[Criterion, ...]
    places: tuple[tuple[str, int], ...]
    rows: tuple[RankedScheme, ...]
    unranked: tuple[str, ...]
    sentences: tuple[str, ...]


def rankings(grid: Grid) -> tuple[Ranking, ...]:
    """Return the rankings of a run: schemes that share no dataset, as they take other faces, have one each.

    There is none of fewer than two schemes, nor of schemes without a dataset to rank them on.
    """
    made = (_ranking(grid, positions, datasets) for positions, datasets in grid.circles())
    return tuple(one for one in made if one is not None)


def _ranking(grid: Grid, positions: Sequence[int], datasets: Sequence[str]) -> Ranking | None:
    columns = {one.column for one in CRITERIA}
    places = tuple(
        (dataset, level)
        for dataset in datasets
        if grid.shape(dataset) != "planes"
        and (level := grid.compared(dataset)) is not None
        and any(_values(grid.at(dataset, level), column) for column in columns)
    )
    spheres = [place for place in places if grid.shape(place[0]) == "spheres"]
    others = [place for place in places if place not in spheres]
    about: dict[Where, Sequence[tuple[str, int]]] = {"all": places}
    if spheres and others:
        about |= {"spheres": spheres, "other surfaces": others}
    criteria = tuple(one for one in CRITERIA if one.column in grid.columns and one.where in about)
    if not criteria or not places or len(positions) < 2:
        return None
    present = [
        position for position in positions if all(is_ok(grid.at(dataset, level)[position]) for dataset, level in places)
    ]
    factors = {one: mean_factors(grid, about[one.where], present, one.column) for one in criteria}
    order = sorted(present, key=lambda position: (factors[criteria[0]].get(position, math.inf), position))
    rows = tuple(_row(grid, position, criteria, factors) for position in order)
    unranked = tuple(_missing(grid, position, places) for position in positions if position not in present)
    return Ranking(criteria, places, rows, unranked, tuple(_sentences(grid, criteria, factors)))


def mean_factors(
    grid: Grid, places: Sequence[tuple[str, int]], present: Sequence[int], column: str
) -> Mapping[int, float]:
    """Return by scheme the geometric mean over datasets of its value over the least one; all schemes are ok there."""
    logs: dict[int, list[float]] = {position: [] for position in present}
    for dataset, level in places:
        rows = grid.at(dataset, level)
        values = {position: _floored(rows[position], column) for position in present}
        known = {position: value for position, value in values.items() if value is not None}
        if len(known) < len(present) or not known:
            continue  # a dataset without an exact surface has no such column
        least = min(known.values())
        for position, value in known.items():
            logs[position].append(math.log(value / least))
    return {position: math.exp(statistics.fmean(some)) for position, some in logs.items() if some}


def _floored(row: Row | None, column: str) -> float | None:
    """Return a value of a cell, not less than rounding, so that it has a logarithm."""
    value = None if row is None else row.get(column)
    if row is None or value is None:
        return None
    scale = float(row["diameter"] or 1.0)
    if column.endswith("_deg"):
        least = FLOOR * 180.0
    elif column.startswith("gauss"):
        least = FLOOR / scale**2
    else:
        least = FLOOR / scale if column.startswith("mean") else FLOOR * scale
    return max(float(value), least)


def _values(rows: Sequence[Row | None], column: str) -> list[float]:
    return [float(row[column]) for row in rows if row is not None and is_ok(row) and row.get(column) is not None]


def _row(
    grid: Grid, position: int, criteria: Sequence[Criterion], factors: Mapping[Criterion, Mapping[int, float]]
) -> RankedScheme:
    entries = []
    for one in criteria:
        value = factors[one].get(position)
        least = min(factors[one].values(), default=math.nan)
        entries.append(
            Entry(NOTHING)
            if value is None
            else Entry(f"{shorten(value)}", repr(value), best=shorten(value) == shorten(least))
        )
    scheme = grid.schemes[position]
    found = [
        float(row["order"])
        for dataset in grid.datasets
        if (row := grid.orders.get((scheme, dataset, "distance_max"))) is not None
        and row["order"] is not None
        and math.isfinite(row["order"])
        and grid.shape(dataset) != "planes"
    ]
    orders = (
        Entry(f"{statistics.median(found):.2f}", f"median of {counted(len(found), 'dataset')}")
        if found
        else Entry(NOTHING)
    )
    return RankedScheme(position, scheme, grid.plan.schemes[position].continuity, tuple(entries), orders)


def _missing(grid: Grid, position: int, places: Sequence[tuple[str, int]]) -> str:
    scheme = grid.schemes[position]
    for dataset, level in places:
        row = grid.at(dataset, level)[position]
        if not is_ok(row):
            return f"{scheme} ({row['status'] if row else 'not computed'} on {dataset})"
    return scheme


def _sentences(
    grid: Grid, criteria: Sequence[Criterion], factors: Mapping[Criterion, Mapping[int, float]]
) -> "list[str]":
    """Return who is best at what, among all schemes and among those whose joins are smooth."""
    smooth = {position for position, scheme in enumerate(grid.plan.schemes) if scheme.continuity != "C0"}
    sentences = []
    for one in criteria:
        ranked = sorted((value, position) for position, value in factors[one].items())
        if len(ranked) < 2:
            continue
        parts = [_best(grid, ranked)]
        among = [(value, position) for value, position in ranked if position in smooth]
        if len(among) > 1 and among[0] != ranked[0]:
            parts.append(f"of those with continuous tangent planes {_best(grid, among)}")
        where = "" if one.where == "all" else f" on {one.where}"
        sentences.append(f"{one.phrase[0].upper()}{one.phrase[1:]}{where}: {'; '.join(parts)}.")
    return sentences


def _best(grid: Grid, ranked: Sequence[tuple[float, int]]) -> str:
    return listed([f"{grid.schemes[position]} ({shorten(value)})" for value, position in ranked[:NAMED]])
