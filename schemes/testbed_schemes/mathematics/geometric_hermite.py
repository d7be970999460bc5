"""What planar and non-planar geometric Hermite curves share: which of several pairs of Bezier legs is taken."""

from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.vectors import Float

#: ``best``: the most uniform speed; ``worst``: the least.
Root: TypeAlias = Literal["best", "worst"]

#: Two solutions of this difference in uniformity are equally uniform.
TIE = 1e-9


def check_guard(name: str, guard: tuple[float, ...]) -> None:
    """Raise SpecError unless ``guard`` is an interval of lengths."""
    if len(guard) != 2 or not 0.0 < guard[0] < guard[1]:
        raise SpecError(f"{name}: guard takes two lengths in chords, 0 < least < greatest, not {guard}")


def chosen_legs(solutions: Float, t0: Float, t1: Float, chord: Float, root: Root) -> Float:
    """One solution of each edge, (2, E), from all, (2, M, E); NaN where there is none.

    Parameters
    ----------
    solutions
        (2, M, E) Bezier legs over L, NaN where there are fewer than M.
    t0, t1
        (dim, E) unit tangents.
    chord
        (dim, E) or (dim, 1) unit chords.
    root
        Which of several solutions.
    """
    order = np.argsort(-solutions[0], axis=0)  # longer first leg first, NaN last
    chosen = np.take_along_axis(solutions, order[None, :1], axis=1)[:, 0]
    spread = chosen[0] - np.nanmin(np.where(np.isnan(solutions[0]), np.inf, solutions[0]), axis=0)
    several = np.flatnonzero(spread > TIE)
    candidates = np.take_along_axis(solutions[:, :, several], order[None, :, several], axis=1)
    chords = chord if chord.shape[1] == 1 else chord[:, several]
    score = speed_variation(candidates, t0[:, several], t1[:, several], chords)
    score = np.where(np.isnan(score), np.inf, score if root == "best" else -score)
    first = np.argmax(score <= score.min(axis=0) + TIE, axis=0)
    chosen[:, several] = np.take_along_axis(candidates, first[None, None], axis=1)[:, 0]
    return chosen


def speed_variation(legs: Float, t0: Float, t1: Float, chord: Float) -> Float:
    """Return the standard deviation of |C'| over its mean for cubics over unit chords; 0: uniform speed.

    Parameters
    ----------
    legs
        (2, M, E) Bezier legs.
    t0, t1
        (dim, E) unit tangents.
    chord
        (dim, E) or (dim, 1) unit chords.

    Returns
    -------
    variation
        (M, E); by Gauss quadrature with eight nodes.
    """
    first, last = legs[0] * t0[:, None], legs[1] * t1[:, None]
    middle = chord[:, None] - first - last
    nodes, weights = np.polynomial.legendre.leggauss(8)
    mean, mean_square = np.zeros(legs.shape[1:]), np.zeros(legs.shape[1:])
    for t, weight in zip((1.0 + nodes) / 2.0, weights / 2.0, strict=True):
        hodograph = (1.0 - t) ** 2 * first + 2.0 * t * (1.0 - t) * middle + t**2 * last
        square = (hodograph**2).sum(axis=0)
        mean += weight * np.sqrt(square)
        mean_square += weight * square
    variation: Float = np.sqrt(np.maximum(mean_square - mean**2, 0.0)) / mean
    return variation
