"""Published figures that no cell of a run holds: of approximations, costs, ways of surfaces, and constructions."""

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from testbed.errors import TestbedError
from testbed_reports.cost_tables import cost_rows
from testbed_reports.published import Agreement, PublishedRow, comes_out, farthest
from testbed_reports.published_table import DerivedFigure

#: Seconds that an approximation may take.
LIMIT: Final = 600.0


@dataclass(frozen=True)
class Measured:
    """Our number for a figure; NaN with the reason why there is none.

    Parameters
    ----------
    value
        The number; of several the one farthest from what is printed.
    reason
        Why there is none.
    values
        All of several numbers.
    """

    value: float
    reason: str = ""
    values: tuple[float, ...] = ()


def measure_derived(figures: Sequence[DerivedFigure], jobs: int | None = None) -> tuple[Measured, ...]:
    """Return our numbers, each approximation computed once, in worker processes.

    Parameters
    ----------
    figures
        What to measure.
    jobs
        Worker processes; one a processor if None.
    """
    wanted = sorted({(one.dataset, one.scheme, one.epsilon) for one in figures if one.source == "approximation"})
    found = dict(zip(wanted, _approximated(wanted, jobs), strict=True))
    costs = _costs(sorted({one.dataset for one in figures if one.source == "cost"}))
    measured = []
    for one in figures:
        match one.source:
            case "approximation":
                measured.append(_of_history(one, found[one.dataset, one.scheme, one.epsilon]))
            case "cost":
                measured.append(_of_cost(one, costs))
            case "surface":
                measured.append(_of_surface(one))
            case "construction":
                measured.append(_of_construction(one))
    return tuple(measured)


def approximation(dataset: str, scheme: str, epsilon: float) -> tuple[Mapping[str, float], str]:
    """Return the last step's columns and, where the bound was not reached, why; runs in a worker."""
    from testbed import registry
    from testbed.approximation.approximate import Target, approximate
    from testbed.approximation.templates import Template

    target = Target(math.radians(epsilon), None, "sampled")
    try:
        done = approximate(registry.dataset(dataset), registry.scheme(scheme), target, splitting=Template())
    except TestbedError as error:
        return {}, str(error)
    last = {} if not done.history else dataclasses.asdict(done.history[-1])
    columns = {name: math.nan if value is None else float(value) for name, value in last.items()}
    return columns, "" if done.reached else done.reason


def _approximated(wanted: Iterable[tuple[str, str, float]], jobs: int | None) -> list[tuple[Mapping[str, float], str]]:
    from testbed.harness.run import processors
    from testbed.harness.workers import Died, Returned, TimedOut, Workers

    tasks = list(wanted)
    result: list[tuple[Mapping[str, float], str]] = [({}, "not computed")] * len(tasks)
    waiting = list(enumerate(tasks))
    if not tasks:
        return result
    with Workers(min(jobs or processors(), len(tasks)), LIMIT) as workers:
        while waiting or workers.tasks:
            while waiting and workers.free > 0:
                number, task = waiting.pop(0)
                workers.submit(number, approximation, *task)
            for outcome in workers.wait(1.0):
                match outcome:
                    case Returned(task=number, value=value):
                        result[number] = value
                    case TimedOut(task=number):
                        result[number] = ({}, f"it takes more than {LIMIT:g} s")
                    case Died(task=number, reason=reason):
                        result[number] = ({}, reason)
    return result


def _of_history(figure: DerivedFigure, found: tuple[Mapping[str, float], str]) -> Measured:
    columns, reason = found
    if reason:
        return Measured(math.nan, reason)
    value = columns.get(figure.column, math.nan)
    return Measured(value, f"the history has no {figure.column}" if math.isnan(value) else "")


def _of_cost(figure: DerivedFigure, costs: Mapping[tuple[str, str, str], float]) -> Measured:
    key = (figure.dataset, figure.patches, figure.column)
    return (
        Measured(costs[key]) if key in costs else Measured(math.nan, f"there is no {figure.column} of {figure.patches}")
    )


def _of_surface(figure: DerivedFigure) -> Measured:
    from testbed import registry

    try:
        surface = registry.scheme(figure.scheme).fit(registry.dataset(figure.dataset).mesh(0))
    except TestbedError as error:
        return Measured(math.nan, str(error))
    if figure.column not in surface.branches:
        return Measured(math.nan, f"{figure.scheme} does not count {figure.column}")
    return Measured(float(surface.branches[figure.column]))


def _of_construction(figure: DerivedFigure) -> Measured:
    from testbed_reports.constructions import CONSTRUCTIONS

    if figure.column not in CONSTRUCTIONS:
        return Measured(math.nan, f"there is no construction {figure.column}")
    values = tuple(CONSTRUCTIONS[figure.column]())
    if len(values) != len(figure.printed.split()):
        return Measured(math.nan, f"{figure.column} are {len(values)} numbers")
    return Measured(farthest(values, figure.printed), "", values)


def _costs(datasets: Iterable[str]) -> Mapping[tuple[str, str, str], float]:
    """Return our counts by dataset, patches and quantity."""
    from testbed import registry

    return {
        (name, row.patches, row.quantity): float(row.measured)
        for name in datasets
        for row in cost_rows(registry.dataset(name))
    }


def compare_derived(figures: Sequence[DerivedFigure], measured: Sequence[Measured]) -> tuple[PublishedRow, ...]:
    """Return the figures of approximations and costs next to our numbers for them."""
    rows = []
    for figure, ours in zip(figures, measured, strict=True):
        if math.isnan(ours.value):
            agreement: Agreement = "no value"
        elif comes_out(ours.values or (ours.value,), figure.printed, figure.within):
            agreement = "agrees"
        else:
            agreement = "differs" if figure.explanation else "unexplained"
        names = ("paper", "place", "quantity", "scheme", "dataset", "level", "column", "printed", "data", "explanation")
        taken = {name: getattr(figure, name) for name in names}
        rows.append(
            PublishedRow(
                **taken,
                measured=ours.value,
                low=math.nan,
                high=math.nan,
                agreement=agreement,
                reason=ours.reason,
                within=math.nan if figure.within is None else figure.within,
                ours=" ".join(map(repr, ours.values)) if len(ours.values) > 1 else "",
            )
        )
    return tuple(rows)
