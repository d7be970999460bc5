"""Tuning: the values of a scheme's real parameters at which an objective is best on one or several datasets.

Objectives are maxima over a surface, so that their graphs have kinks, and a best value mostly lies in one; the search
takes no derivatives. It first looks at points spread over the bounds, then goes down from the best of them: with one
parameter by Brent's bounded search between the neighbours, else by Nelder and Mead's simplex, started anew from where
it ends until that gains nothing, since a simplex may collapse in a kink. All of it is deterministic.

On several datasets the value of a setting is the worst, over the datasets, of its quotient by the value of the scheme
as given: a setting is as good as the least of its gains. Settings that a dataset refuses count as worst.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from testbed import registry
from testbed.errors import SpecError, TestbedError
from testbed.geometry.vectors import Float
from testbed.harness.parameters import Interval, value_of, with_values
from testbed.harness.trials import Trial, Trials

if TYPE_CHECKING:
    import pandas as pd

    from testbed.plugins.scheme import Scheme

#: Significant digits of the values that are tried; much finer than the precision, lest a search sees steps.
DIGITS: Final = 8
#: Digits to which the best values are rounded if that costs no more than a share of the value, the fewest first.
FEWER: Final = (3, 4, 5, 6)
ROUNDING: Final = 1e-3
#: Points looked at first, for one parameter and for each of several.
SCAN_ONE: Final = 25
SCAN_EACH: Final = 24
#: How many of them are starting points.
STARTS: Final = 3
#: Where a search stops, in shares of the ranges.
PRECISION: Final = 2e-5
#: Gain of the simplex below which it is not started anew, relative to the value.
LITTLE: Final = 1e-4
#: How often it is at most.
RESTARTS: Final = 8
#: What a setting without a value costs; more than any that has one, and finite, as searches compute with it.
WORST: Final = 1e30


@dataclass(frozen=True)
class Tuned:
    """The end of a search.

    Parameters
    ----------
    given, best
        The scheme as given, and the best setting found.
    parameters
        Values of the parameters at the best setting.
    on_bound
        Parameters of which the best value lies on a bound, so that the optimum may be beyond it.
    gain
        The share of the value as given that the best setting saves, or adds where it is to be large; on the dataset
        where that is least. None where the scheme as given has no positive value.
    settings
        Settings tried.
    without_value
        Those of them that were refused, failed or have no such value on a dataset.
    """

    given: Trial
    best: Trial
    parameters: tuple[tuple[str, float], ...]
    on_bound: tuple[str, ...]
    gain: float | None
    settings: int
    without_value: int


def tune(scheme: str, intervals: Sequence[Interval], trials: Trials, *, maximise: bool = False) -> Tuned:
    """Search for the best values of parameters.

    Parameters
    ----------
    scheme
        Text of the scheme; its other parameters stay.
    intervals
        The parameters with their bounds.
    trials
        What computes settings.
    maximise
        Whether the objective is to be large.

    Raises
    ------
    SpecError
        A parameter is named twice.
    TestbedError
        No setting has a value, or there are several datasets and the scheme as given has no positive value on one.
    """
    base = registry.scheme(scheme)
    names = [one.name for one in intervals]
    repeated = [name for position, name in enumerate(names) if name in names[:position]]
    if repeated:
        raise SpecError(f"--over names {repeated[0]} twice: give its bounds once")
    (given,) = trials.all([str(base)])
    scale = _scale(given)
    sign = -1.0 if maximise else 1.0

    def costs(points: Float) -> list[float]:
        """Return the costs of points (N, parameters) of the unit cube, computed together."""
        settings = [str(registry.scheme(with_values(base, _texts(intervals, point)))) for point in points]
        return [cost(trial) for trial in trials.all(settings)]

    def cost(trial: Trial) -> float:
        if not trial.valid:
            return WORST
        return max(sign * value / one for value, one in zip(trial.values, scale, strict=True))

    starts = _spread(len(intervals))
    own = _within(base, intervals)
    if own is not None:
        starts = np.concatenate([starts, [own]])
    first = costs(starts)
    (_search_line if len(intervals) == 1 else _search_space)(costs, starts, first)
    best = _shortened(base, intervals, trials, cost)
    if not best.valid:
        reason = next((outcome.reason for outcome in given.outcomes if outcome.reason), "it is not defined")
        raise TestbedError(f"no setting of {base} has a value; as given: {reason}")
    found = registry.scheme(best.setting)
    parameters = tuple((one.name, float(value_of(found, one.name))) for one in intervals)
    on_bound = tuple(
        one.name for one, (_, value) in zip(intervals, parameters, strict=True) if value in (one.low, one.high)
    )
    gain = None
    if given.valid and min(given.values) > 0.0:
        gain = min(sign * (1.0 - value / one) for value, one in zip(best.values, given.values, strict=True))
    without = sum(not trial.valid for trial in trials.done.values())
    return Tuned(given, best, parameters, on_bound, gain, len(trials.done), without)


def trace(trials: Trials, intervals: Sequence[Interval]) -> "pd.DataFrame":
    """Return a row for each setting tried and dataset, in the order of the search: parameters, status, columns."""
    import pandas as pd

    rows = []
    for number, trial in enumerate(trials.done.values()):
        scheme = registry.scheme(trial.setting)
        parameters = {one.name: value_of(scheme, one.name) for one in intervals}
        for dataset, outcome, value in zip(trials.datasets, trial.outcomes, trial.values, strict=True):
            what = {"dataset": dataset, "status": outcome.status, "reason": outcome.reason}
            own = {trials.objective.name: value, **(outcome.values or {})}
            rows.append({"number": number, **parameters, "scheme": trial.setting, **what, **own})
    return pd.DataFrame(rows)


def _shortened(base: "Scheme", intervals: Sequence[Interval], trials: Trials, cost: Callable[[Trial], float]) -> Trial:
    """Return the best trial, or one with fewer digits that is all but as good."""
    best = min(trials.done.values(), key=cost)
    found = registry.scheme(best.setting)
    if not best.valid or best.setting == str(base):
        return best
    for digits in FEWER:
        values = [float(f"{value_of(found, one.name):.{digits}g}") for one in intervals]
        if all(one.low <= value <= one.high for one, value in zip(intervals, values, strict=True)):
            texts = {one.name: repr(value) for one, value in zip(intervals, values, strict=True)}
            (shorter,) = trials.all([str(registry.scheme(with_values(base, texts)))])
            if cost(shorter) <= cost(best) + ROUNDING * abs(cost(best)):
                return shorter
    return best


def _scale(given: Trial) -> tuple[float, ...]:
    """Return what values are divided by: nothing on one dataset, on several those of the scheme as given."""
    if len(given.values) == 1:
        return (1.0,)
    for value, outcome in zip(given.values, given.outcomes, strict=True):
        if not value > 0.0:
            why = outcome.reason or f"its value is {value:g}"
            raise TestbedError(
                f"several datasets are weighed by the values of {given.setting}, and on one it has no positive value "
                f"({why}): give the scheme other parameters, or tune on one dataset"
            )
    return given.values


def _texts(intervals: Sequence[Interval], point: Float) -> dict[str, str]:
    """Return the values at a point of the unit cube, rounded, and the bounds exactly where it is on them."""
    texts = {}
    for one, share in zip(intervals, np.clip(point, 0.0, 1.0).tolist(), strict=True):
        rounded = float(f"{one.low + (one.high - one.low) * share:.{DIGITS}g}")
        texts[one.name] = repr({0.0: one.low, 1.0: one.high}.get(share, min(max(rounded, one.low), one.high)))
    return texts


def _within(base: "Scheme", intervals: Sequence[Interval]) -> list[float] | None:
    """Return the point of the unit cube that is the scheme as given, or None if it is not within the bounds."""
    point = []
    for one in intervals:
        value: Any = value_of(base, one.name)
        if not isinstance(value, int | float) or not one.low <= value <= one.high:
            return None
        point.append((value - one.low) / (one.high - one.low))
    return point


def _spread(count: int) -> Float:
    """Return points of the unit cube to look at first: evenly spaced, or a Halton sequence with its corners."""
    if count == 1:
        return np.linspace(0.0, 1.0, SCAN_ONE)[:, None]
    from scipy.stats import qmc

    inside: Float = qmc.Halton(count, scramble=False).random(SCAN_EACH * count)
    # its first point is the origin, a corner as well
    corners = np.stack(np.meshgrid(*[[0.0, 1.0]] * min(count, 4), indexing="ij"), axis=-1).reshape(-1, min(count, 4))
    padded = np.full((len(corners), count), 0.5)
    padded[:, : corners.shape[1]] = corners
    return np.concatenate([padded, inside[1:]])


def _search_line(costs: Callable[[Float], list[float]], points: Float, values: Sequence[float]) -> None:
    """Refine the best local minima of a scan, each between its neighbours."""
    from scipy.optimize import minimize_scalar

    order = np.argsort(points[:, 0], kind="stable")
    place, value = points[order, 0], np.array(values)[order]
    low, high = np.r_[value[0], value[:-1]], np.r_[value[1:], value[-1]]
    valleys = np.flatnonzero((value <= low) & (value <= high) & (value < WORST))
    for valley in valleys[np.argsort(value[valleys], kind="stable")][:STARTS].tolist():
        bounds = place[max(valley - 1, 0)], place[min(valley + 1, len(place) - 1)]
        minimize_scalar(
            lambda share: costs(np.array([[share]]))[0],
            bounds=bounds,
            method="bounded",
            options={"xatol": PRECISION, "maxiter": 60},
        )


def _search_space(costs: Callable[[Float], list[float]], points: Float, values: Sequence[float]) -> None:
    """Go down from the best points by Nelder and Mead's simplex, started anew as long as that gains something."""
    from scipy import optimize

    simplex: Callable[..., Any] = optimize.minimize  # the overloads of its stubs do not take a plain point
    for start in np.argsort(values, kind="stable")[:STARTS].tolist():
        point, value = points[start], values[start]
        if value >= WORST:
            continue
        size = 0.15
        for _ in range(RESTARTS):
            # by the arguments alone: values next to a kink differ more than arguments do
            options = {
                "xatol": PRECISION,
                "fatol": math.inf,
                "maxfev": 400,
                "initial_simplex": _simplex(point, size),
            }
            found = simplex(
                lambda place: costs(place[None])[0],
                point,
                method="Nelder-Mead",
                bounds=[(0.0, 1.0)] * len(point),
                options=options,
            )
            gain = value - float(found.fun)
            point, value = found.x, min(value, float(found.fun))
            if gain <= LITTLE * abs(value):
                break
            size = max(0.4 * size, 0.01)


def _simplex(point: Float, size: float) -> Float:
    """Return a point and its neighbours along the axes, (n + 1, n), towards the middle of the unit cube."""
    steps = np.where(point > 0.5, -size, size)
    return np.concatenate([point[None], point + np.diag(steps)])
