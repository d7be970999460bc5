"""Sweeps: a scheme at all combinations of the values of one or two parameters, as cells of an ordinary run."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from testbed import registry
from testbed.errors import SpecError
from testbed.harness.journal import read_entries, write_whole
from testbed.harness.objectives import Extremes, Objective, exact_extremes
from testbed.harness.parameters import Axis, parse_axis, value_of, with_values
from testbed.harness.plan import Plan, make_plan, parse_levels
from testbed.harness.results import tabulate_cells
from testbed.plugins.base import format_value

if TYPE_CHECKING:
    import pandas as pd

#: Settings of a sweep at most.
MOST: Final = 10_000


@dataclass(frozen=True)
class Sweep:
    """A study of one or two parameters; build one with :func:`make_sweep`.

    Parameters
    ----------
    scheme
        Canonical text of the scheme as given.
    axes
        The parameters and their values.
    settings
        Canonical texts of the scheme at all combinations of values, the last parameter changing fastest.
    objectives
        The quantities studied.
    maximise
        Whether large values are the good ones.
    level
        Level of the datasets.
    exact
        Curvature extremes of the exact surfaces by dataset, as far as the objectives need them.
    plan
        The cells: the settings, and the scheme as given to compare with, on all datasets.
    """

    scheme: str
    axes: tuple[Axis, ...]
    settings: tuple[str, ...]
    objectives: tuple[Objective, ...]
    maximise: bool
    level: int
    exact: Mapping[str, Extremes]
    plan: Plan

    @property
    def datasets(self) -> tuple[str, ...]:
        """Texts of the datasets."""
        return tuple(one.spec for one in self.plan.datasets)

    @property
    def combinations(self) -> tuple[tuple[str, ...], ...]:
        """Texts of the parameters' values, by setting."""
        return tuple(itertools.product(*(axis.texts for axis in self.axes)))


@dataclass(frozen=True)
class Best:
    """The best setting of a sweep by one objective.

    Parameters
    ----------
    objective
        Its name.
    datasets
        Where it is the best.
    setting
        Text of the scheme.
    values
        Its values on these datasets.
    given
        Values of the scheme as given; NaN where it has none.
    on_end
        Parameters whose value is the first or the last that was tried.
    worst_ratio
        How far its values are from the best on each dataset, as the worst quotient; 1 for a single dataset.
    """

    objective: str
    datasets: tuple[str, ...]
    setting: str
    values: tuple[float, ...]
    given: tuple[float, ...]
    on_end: tuple[str, ...]
    worst_ratio: float = 1.0


def make_sweep(
    scheme: str,
    over: Sequence[str],
    datasets: Sequence[str],
    level: str,
    objectives: Sequence[Objective],
    *,
    maximise: bool = False,
    measures: Sequence[str] | None = None,
) -> Sweep:
    """Return the sweep of a scheme over the values of one or two parameters.

    Parameters
    ----------
    scheme
        Text of the scheme; its other parameters stay.
    over
        One or two texts ``name=low:high:count`` or ``name=a,b,c``.
    datasets
        Texts of the datasets.
    level
        Their level, as text.
    objectives
        The quantities to study.
    maximise
        Whether large values are the good ones.
    measures
        Texts of the measures for the table, among them those that the objectives need; None for all.

    Raises
    ------
    SpecError
        A text cannot be read, or a dataset lacks the exact surface that an objective needs.
    """
    base = registry.scheme(scheme)
    if not 1 <= len(over) <= 2:
        raise SpecError(f"a sweep varies one or two parameters, and here are {len(over)}: give --over once or twice")
    axes = tuple(parse_axis(text, base) for text in over)
    if len({axis.name for axis in axes}) < len(axes):
        raise SpecError(f"--over names {axes[0].name} twice: list its values in one")
    count = math.prod(len(axis.texts) for axis in axes)
    if count > MOST:
        raise SpecError(f"these ranges make {count} settings: {MOST} are the most")
    names = [axis.name for axis in axes]
    combinations = itertools.product(*(axis.texts for axis in axes))
    settings = tuple(
        str(registry.scheme(with_values(base, dict(zip(names, texts, strict=True))))) for texts in combinations
    )
    (only,) = parse_single_level(level)
    plan = make_plan([*settings, str(base)], datasets, level, measures)
    exact = {one.spec: exact_extremes(one.spec, only, objectives) for one in plan.datasets}
    return Sweep(str(base), axes, settings, tuple(objectives), maximise, only, exact, plan)


def parse_single_level(text: str) -> tuple[int]:
    """Return the one level that a text names; SpecError for several."""
    levels = parse_levels(text)
    if len(levels) != 1:
        raise SpecError(f"a study looks at one level, and {text!r} are {len(levels)}: choose one")
    return (levels[0],)


def read_sweep(sweep: Sweep, directory: Path) -> "pd.DataFrame":
    """Return the table of a sweep that was run in a directory to its end, as :func:`tabulate` does."""
    entries = read_entries(directory, (cell.key for cell in sweep.plan.cells))
    return tabulate(sweep, tabulate_cells(sweep.plan, [(cell, entries[cell.key].outcome) for cell in sweep.plan.cells]))


def tabulate(sweep: Sweep, found: "pd.DataFrame") -> "pd.DataFrame":
    """Return a row for each setting and dataset: the parameters, the cell's columns, the derived quantities.

    Rows are ordered by dataset, then by setting, which are numbered from 0. The last row of each dataset, setting -1,
    is the scheme as given.
    """
    import pandas as pd

    position = {place: number for number, place in enumerate(zip(found["dataset"], found["scheme"], strict=True))}
    names = [axis.name for axis in sweep.axes]
    base = registry.scheme(sweep.scheme)
    given = {name: format_value(value_of(base, name)) for name in names}
    beginning, chosen = [], []
    for dataset in sweep.datasets:
        for number, (setting, texts) in enumerate(zip(sweep.settings, sweep.combinations, strict=True)):
            beginning.append({"setting": number, **dict(zip(names, texts, strict=True))})
            chosen.append(position[dataset, setting])
        beginning.append({"setting": -1, **given})
        chosen.append(position[dataset, sweep.scheme])
    table = pd.concat([pd.DataFrame(beginning), found.iloc[chosen].reset_index(drop=True)], axis=1)
    for one in sweep.objectives:
        if one.name not in table:
            table[one.name] = [_value(sweep, one, row) for row in _records(table)]
    return table


def values(sweep: Sweep, table: "pd.DataFrame", one: Objective, dataset: str) -> tuple[list[float], float]:
    """Return an objective's values by setting, NaN where it has none, and that of the scheme as given."""
    own = table[table["dataset"] == dataset]
    found = [_value(sweep, one, row) for row in _records(own)]
    return found[:-1], found[-1]


def best(sweep: Sweep, table: "pd.DataFrame") -> list[Best]:
    """Return the best settings: for each objective one a dataset, and one for all datasets together.

    The last is the setting whose worst quotient, over the datasets, by the best value there is the smallest; it is left
    out where a best value is not positive. Settings without a value are never the best.
    """
    found = []
    for one in sweep.objectives:
        by_dataset = {dataset: values(sweep, table, one, dataset) for dataset in sweep.datasets}
        chosen = {dataset: best_number(own, maximise=sweep.maximise) for dataset, (own, _) in by_dataset.items()}
        for dataset, number in chosen.items():
            if number is not None:
                found.append(_best(sweep, one, by_dataset, (dataset,), number))
        tops = [by_dataset[dataset][0][number] for dataset, number in chosen.items() if number is not None]
        if len(tops) < 2 or len(tops) < len(sweep.datasets) or min(tops) <= 0.0:
            continue
        rows = zip(*(own for own, _ in by_dataset.values()), strict=True)
        ratios = [_worst_ratio(row, tops, maximise=sweep.maximise) for row in rows]
        number = best_number(ratios)
        if number is not None:
            found.append(_best(sweep, one, by_dataset, sweep.datasets, number, ratios[number]))
    return found


def best_number(numbers: Sequence[float], *, maximise: bool = False) -> int | None:
    """Return the position of the best number, the first of equals; NaN never is, None if there is nothing else."""
    sign = -1.0 if maximise else 1.0
    finite = [position for position, number in enumerate(numbers) if math.isfinite(number)]
    return min(finite, key=lambda position: sign * numbers[position], default=None)


def write_sweep(directory: Path, table: "pd.DataFrame") -> Path:
    """Write ``sweep.csv``, whole or not at all, and return its path; times are left out, so that bytes repeat."""
    path = directory / "sweep.csv"
    lasting = table.drop(columns=["fit_seconds", "measure_seconds"])
    write_whole(path, lasting.to_csv(index=False, lineterminator="\n"))
    return path


def _best(
    sweep: Sweep,
    one: Objective,
    by_dataset: Mapping[str, tuple[list[float], float]],
    datasets: tuple[str, ...],
    number: int,
    ratio: float = 1.0,
) -> Best:
    texts = sweep.combinations[number]
    on_end = tuple(
        axis.name
        for axis, text in zip(sweep.axes, texts, strict=True)
        if axis.numbers and len(axis.texts) > 2 and text in (axis.texts[0], axis.texts[-1])
    )
    return Best(
        one.name,
        datasets,
        sweep.settings[number],
        tuple(by_dataset[dataset][0][number] for dataset in datasets),
        tuple(by_dataset[dataset][1] for dataset in datasets),
        on_end,
        ratio,
    )


def _worst_ratio(row: Sequence[float], tops: Sequence[float], *, maximise: bool) -> float:
    """Return the worst quotient of values and the best ones; NaN if there is none."""
    if not all(math.isfinite(value) for value in row):
        return math.nan
    if not maximise:
        return max(value / top for value, top in zip(row, tops, strict=True))
    return max(top / value if value > 0.0 else math.inf for value, top in zip(row, tops, strict=True))


def _value(sweep: Sweep, one: Objective, row: Mapping[str, Any]) -> float:
    return one.value(row, sweep.exact[row["dataset"]]) if row["status"] == "ok" else math.nan


def _records(table: "pd.DataFrame") -> list[dict[str, Any]]:
    """Return the rows as dictionaries; what is missing is None."""
    absent = table.isna().to_numpy()
    names = [str(name) for name in table.columns]
    return [
        {name: None if gone else value for name, value, gone in zip(names, row, lacks, strict=True)}
        for row, lacks in zip(table.itertuples(index=False, name=None), absent, strict=True)
    ]
