"""How low Bezier patches reach over a plane, guaranteed: a lower bound of an affine function over all their points.

An affine function of a Bezier patch is a Bernstein polynomial whose coefficients are the function's values at the
control points, so that no value is below the least of them. Patches that could still reach lower than the lowest point
known are cut in halves, until nothing is left to gain (:mod:`testbed.geometry.branch_and_bound`, with the divisor 1).
"""

import math
from collections.abc import Sequence

import numpy as np

from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.branch_and_bound import Front, Search
from testbed.geometry.enclosed_nets import TINY, UNIT, Degrees, EnclosedNets, gamma
from testbed.geometry.patches import PatchBatch
from testbed.geometry.quotient_bounds import Cells
from testbed.geometry.vectors import Float

#: a, b, c, d of the plane a x + b y + c z + d = 0.
Plane = tuple[float, float, float, float]

#: Patches of these kinds have bounds.
KINDS = (BezierTriangles, BezierQuads)
#: Gap to the lowest point known that is aimed at, relative to the largest distance at a control point; where that would
#: leave open on which side the lowest point is, half its distance, but no less than the second.
TOLERANCE, FINEST = 1e-5, 1e-10
#: Halvings one after the other, and pieces to be cut, at most.
ROUNDS, CUTS = 60, 20_000


def plane_length(plane: Plane) -> float:
    """Length of the normal (a, b, c)."""
    return math.hypot(*plane[:3])


def signed_distances(plane: Plane, points: Float) -> Float:
    """Distances (...) of points (..., 3) from the plane, positive on the side that (a, b, c) points to."""
    distances: Float = plane_values(plane, points) / plane_length(plane)
    return distances


def plane_values(plane: Plane, points: Float) -> Float:
    """Values a x + b y + c z + d (...) at points (..., 3)."""
    a, b, c, d = plane
    values: Float = a * points[..., 0] + b * points[..., 1] + c * points[..., 2] + d
    return values


def lowest_distance(
    batches: Sequence[PatchBatch],
    plane: Plane,
    known: float = math.inf,
    *,
    tolerance: float = TOLERANCE,
    rounds: int = ROUNDS,
    cuts: int = CUTS,
) -> float:
    """Return a number that no signed distance of a point of the patches from a plane is below, rounding included.

    The patches are those that their control points define; what evaluation rounds is not part of it.

    Parameters
    ----------
    batches
        Bezier triangles and tensor-product patches.
    plane
        The plane; its normal is finite and not zero.
    known
        A distance that is reached, or thought to be; it saves work and has no other influence.
    tolerance, rounds, cuts
        When to stop: see ``TOLERANCE``, ``ROUNDS``, ``CUTS``.

    Returns
    -------
    bound
        NaN where a control point is not finite; infinite without patches.

    Raises
    ------
    TypeError
        Some patches are of another kind.
    """
    for batch in batches:
        if not isinstance(batch, KINDS):
            raise TypeError(f"bounds over a plane are those of Bezier patches, not of {type(batch).__name__}")
    nets = [_values(batch, plane) for batch in batches if len(batch)]
    if not nets:
        return math.inf
    largest = max(TINY, *(float(np.abs(values).max()) for values, _, _ in nets))
    if not (math.isfinite(largest) and all(np.isfinite(error).all() for _, error, _ in nets)):
        return math.nan
    length = plane_length(plane)
    reached = min(known * length, *(_reached(*net) for net in nets))
    gap = max(min(tolerance * largest, 0.5 * abs(reached)), FINEST * largest)
    # infinite and so settled: the largest distance is not asked for, and what is known of it is the scale
    search = Search(np.array([[-reached], [largest]]), np.array([[-np.inf], [np.inf]]), gap / largest)
    lowest = math.inf
    for values, error, degrees in nets:
        least = _below(values.min(axis=0), error)
        hopeful = least < reached - gap
        lowest = min(lowest, float(least[~hopeful].min(initial=math.inf)))
        if not hopeful.any():
            continue
        net = EnclosedNets.of_coefficients(-values[:, hopeful], degrees, error[hopeful])
        cells = Cells.whole(net, EnclosedNets.one(degrees, net.patches), 2.0)
        zeros = np.zeros(net.patches)
        front = Front.of(cells, zeros, zeros.astype(np.int64), zeros.astype(np.bool_))
        search.run(front, rounds, cuts)
    lowest = min(lowest, -float(search.settled[0, 0]))
    bound = lowest / length
    # the length of the normal, and the division
    return bound - 8.0 * UNIT * abs(bound)


def _values(batch: PatchBatch, plane: Plane) -> tuple[Float, Float, Degrees]:
    """Values (n, P) at control points, bounds (P,) of their errors, and the degrees of the patches."""
    assert isinstance(batch, KINDS)  # noqa: S101 - see lowest_distance
    degrees = batch.degree if isinstance(batch, BezierQuads) else (batch.degree,)
    points = batch.control_points.reshape(len(batch), -1, 3)
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is NaN in the end
        values = plane_values(plane, points)
        moduli = plane_values(tuple(map(abs, plane)), np.abs(points)).max(axis=1)  # type: ignore[arg-type]
    present = [number for number in plane if number != 0.0]
    exact = len(present) == 1 and abs(math.frexp(present[0])[0]) == 0.5
    # a coordinate times a power of two is exact: what is on the plane z = 0 is not below it
    error = np.where(np.isfinite(moduli), 0.0, np.inf) if exact else gamma(6) * moduli + TINY
    return np.ascontiguousarray(values.T), error, degrees


def _reached(values: Float, error: Float, degrees: Degrees) -> float:
    """Return an upper bound of the lowest value: the least at corners of patches."""
    d = degrees[-1]
    count = len(values)
    corners = (0, count - d - 1, count - 1) if len(degrees) == 1 else (0, d, count - d - 1, count - 1)
    return float((values[corners, :] + error).min())


def _below(values: Float, error: Float) -> Float:
    """Values less their errors, rounded down."""
    low = values - error
    return np.where(error > 0.0, np.nextafter(low, -np.inf), low)
