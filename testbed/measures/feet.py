"""Feet of the samples on the exact surface, which several measures share, and sums that do not depend on the order."""

import math

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.vectors import Float
from testbed.measures.sampling import chunks, sample
from testbed.plugins.measure import Survey


def projected(exact: ExactSurface, points: Float) -> Float:
    """Feet (..., 3) of the perpendiculars from points (..., 3); NaN where a point is not finite or has none."""
    flat = points.reshape(-1, 3)
    # a point that is not finite has no foot, whatever the exact surface makes of it
    known = np.isfinite(flat).all(axis=-1)
    foot = np.full(flat.shape, np.nan)
    foot[known] = exact.closest(flat[known])
    return foot.reshape(points.shape)


def feet(survey: Survey, budget: int) -> tuple[Float, ...]:
    """Feet (P, S, 3) of the samples of every part; ask for them as ``survey.shared(feet, budget)``.

    The survey has an exact surface.
    """
    exact = survey.exact
    assert exact is not None  # noqa: S101 - callers ask where there is one
    result = []
    for one in survey.shared(sample, budget):
        foot = np.empty(one.points.shape)
        for some in chunks(*one.points.shape[:2]):
            foot[some] = projected(exact, one.points[some])
        result.append(foot)
    return tuple(result)


def exact_sum(terms: list[float]) -> float:
    """Sum rounded once, which does not depend on the order; not finite where the terms or the sum are not."""
    try:
        return math.fsum(terms)
    except (OverflowError, ValueError):  # beyond the range of floats, or infinities of both signs
        return float(np.sum(terms))
