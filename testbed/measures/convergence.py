"""Order of convergence over the levels of a dataset: an estimate with an interval, and the verdict on a claimed order.

An error C h^p (1 + O(h)) + rounding shows the order p on some levels only: coarse levels are not asymptotic yet, fine
levels are down at the rounding floor. A fit over all levels is biased by both, so levels are chosen, and the ones left
out are named. Local orders, between neighbouring levels, are

    p_i = log(e_i / e_{i+1}) / log(h_i / h_{i+1}).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from testbed.geometry.vectors import Float

Verdict: TypeAlias = Literal["met", "missed", "exceeded", "not testable", "not claimed"]

#: Errors up to this, relative to the scale of the model, are rounding.
FLOOR = 1e-13
#: Below this, relatively, a local order that collapses is a sign of rounding too; above it, of a lower order.
NEAR_FLOOR = 1e-10
#: A local order that falls by more than this near the floor has collapsed.
COLLAPSE = 0.25
#: A coarse level belongs to the window if its local order is no farther than this from the range of those after it.
SETTLED = 0.15
#: Levels that an estimate needs at least: with two there is one local order and no sign of whether it has settled.
FEWEST = 3
#: Probability of the interval about the fitted slope, two-sided, from the t distribution.
CONFIDENCE = 0.9
#: Slack of a verdict: orders are quoted to a tenth.
SLACK = 0.1


@dataclass(frozen=True)
class OrderEstimate:
    """An order of convergence.

    Parameters
    ----------
    status
        ``estimated``; ``exact`` where all errors are rounding, and the order is infinite; ``not testable``.
    order, low, high
        The order and an interval for it; NaN where it is not testable. The interval holds the confidence interval of
        the slope, all local orders of the levels used, and the limit of their drift: last local order plus last change,
        where orders arrive that approach their limit in first order of h, halved from level to level.
    levels_used
        The levels fitted, by position.
    left_out
        The other levels and why, by position.
    local_orders
        Between each level and the next, NaN where an error is zero.
    reason
        Why the order is not testable; empty where it is.
    """

    status: Literal["estimated", "exact", "not testable"]
    order: float
    low: float
    high: float
    levels_used: tuple[int, ...] = ()
    left_out: dict[int, str] = field(default_factory=dict)
    local_orders: tuple[float, ...] = ()
    reason: str = ""


def estimate_order(h: Sequence[float] | Float, error: Sequence[float] | Float, scale: float) -> OrderEstimate:
    """Estimate the order at which an error goes to zero with the edge length.

    Parameters
    ----------
    h
        (L,) edge lengths, strictly decreasing.
    error
        (L,) errors, not negative. An error that is not finite makes the order not testable.
    scale
        Size of what the error is measured on: of the model for distances, 180 for angles in degrees. Rounding is judged
        relative to it.

    Raises
    ------
    ValueError
        Shapes differ, an edge length does not decrease, an error is negative, or the scale is not positive.
    """
    length, size = np.asarray(h, dtype=np.float64), np.asarray(error, dtype=np.float64)
    _check(length, size, scale)
    unusable = np.flatnonzero(~np.isfinite(size))
    if len(unusable):
        return _not_testable(f"the error is {size[unusable[0]]} at level {unusable[0]}", {}, _local(length, size))
    local = _local(length, size)
    if len(size) and (size <= FLOOR * scale).all():
        left_out = dict.fromkeys(range(len(size)), "rounding floor")
        return OrderEstimate("exact", math.inf, math.inf, math.inf, (), left_out, tuple(local.tolist()))
    end = _first_at_floor(size, local, scale)
    left_out = dict.fromkeys(range(end, len(size)), "rounding floor")
    if end < FEWEST:
        word = "level" if end == 1 else "levels"
        return _not_testable(f"{end} usable {word} of {len(size)}, and an order needs {FEWEST}", left_out, local)
    start = _first_settled(local[: end - 1])
    left_out = {**dict.fromkeys(range(start), "local order not settled yet"), **left_out}
    order, low, high = _fit(np.log(length[start:end]), np.log(size[start:end]), local[start : end - 1])
    return OrderEstimate("estimated", order, low, high, tuple(range(start, end)), left_out, tuple(local.tolist()))


def verdict(claimed: float | None, estimate: OrderEstimate) -> Verdict:
    """Judge a claimed order.

    Met if the interval, with a slack of a tenth, holds the claim and neither the claim less one nor the claim plus one:
    an interval that cannot tell these apart is no test. Exact reproduction exceeds every order.
    """
    if claimed is None:
        return "not claimed"
    if estimate.status == "not testable":
        return "not testable"
    if estimate.low - SLACK > claimed:
        return "exceeded"
    if estimate.high + SLACK < claimed:
        return "missed"
    return "met" if claimed - 1.0 < estimate.low and estimate.high < claimed + 1.0 else "not testable"


def _check(h: Float, error: Float, scale: float) -> None:
    if h.ndim != 1 or h.shape != error.shape:
        raise ValueError(f"h has shape {h.shape} and error {error.shape}: give one of each for every level")
    if not (np.isfinite(h).all() and (h > 0.0).all() and (np.diff(h) < 0.0).all()):
        raise ValueError(
            f"edge lengths {h.tolist()} do not decrease from level to level: give positive, decreasing ones"
        )
    if (error < 0.0).any():
        raise ValueError(f"error {error[error < 0.0][0]} is negative: give absolute values")
    if not 0.0 < scale < math.inf:
        raise ValueError(f"scale {scale} is not a positive number: give the size of the model")


def _not_testable(reason: str, left_out: dict[int, str], local: Float) -> OrderEstimate:
    nan = math.nan
    return OrderEstimate("not testable", nan, nan, nan, (), left_out, tuple(local.tolist()), reason)


def _local(h: Float, error: Float) -> Float:
    # an error that is zero or not finite has no logarithm, and no local order
    with np.errstate(divide="ignore", invalid="ignore"):
        orders = np.diff(np.log(error)) / np.diff(np.log(h))
    return np.where(np.isfinite(orders), orders, np.nan)


def _first_at_floor(error: Float, local: Float, scale: float) -> int:
    """First level that is rounding: all finer ones are, for rounding errors need not fall."""
    floor = error <= FLOOR * scale
    fallen = local[1:] < local[:-1] - COLLAPSE
    floor[2:] |= fallen & (error[2:] <= NEAR_FLOOR * scale)
    return int(np.argmax(floor)) if floor.any() else len(error)


def _first_settled(local: Float) -> int:
    """First level of the window, which grows from the finest levels to coarser ones while local orders stay close."""
    start = len(local) - (FEWEST - 1)
    low, high = local[start:].min(), local[start:].max()
    while start > 0 and low - SETTLED <= local[start - 1] <= high + SETTLED:
        start -= 1
        low, high = min(low, local[start]), max(high, local[start])
    return start


def _fit(x: Float, y: Float, local: Float) -> tuple[float, float, float]:
    from scipy.special import stdtrit

    x, y = x - x.mean(), y - y.mean()
    order = float(x @ y / (x @ x))
    freedom = len(x) - 2
    deviation = math.sqrt(float(((y - order * x) ** 2).sum()) / freedom / float(x @ x))
    reach = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE)) * deviation
    drift = float(local[-1] + (local[-1] - local[-2]))
    orders = (order - reach, order + reach, float(local.min()), float(local.max()), drift)
    return order, min(orders), max(orders)
