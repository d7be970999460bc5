"""Shooting in extended precision, straight from the definitions, and its derivatives by differences.

Nothing but the net, the apexes and a first guess of the root is taken from the batches.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from tetrahedra import FACTORS, INDICES

from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.shooting_quads import ShootingQuads
from testbed.geometry.vectors import Float

Long: TypeAlias = NDArray[np.longdouble]
Weights: TypeAlias = tuple[tuple[int, int], ...]
#: Steps of the differences: of fourth order, with errors and rounding of about 1e-12.
STEP = np.longdouble(2.0) ** -12


def value(net: Long, rational: Long, alpha: Long) -> Long:
    """F (N,) on one tetrahedron at barycentric coordinates (4, N); the term of a face or of an edge."""
    total = np.zeros(alpha.shape[1], dtype=np.longdouble)
    for factor, coefficient, row in zip(FACTORS, net, INDICES, strict=True):
        total += factor * coefficient * (alpha ** row[:, None]).prod(axis=0)
    a, b, c, d = alpha
    if len(rational) == 3:
        term = a * b * c * (rational[0] * b * c + rational[1] * c * a + rational[2] * a * b) / (b * c + c * a + a * b)
    else:
        term = a * d * (b * (rational[0] * a + rational[1] * d) + c * (rational[2] * a + rational[3] * d)) / (a + d)
    return np.asarray(total + 6.0 * term, dtype=np.longdouble)


def root(f: Callable[[Long], Long], t: Long) -> Long:
    step = np.longdouble(1e-6)
    for _ in range(4):
        t = t - f(t) * (2.0 * step) / (f(t + step) - f(t - step))
    return t


def face_points(batch: ShootingTriangles, side: int, at: Long) -> Long:
    """Points (N, 3) of patch 0 over domain points (N, 2), by rays to one side."""
    weights = np.stack([1.0 - at[:, 0] - at[:, 1], at[:, 0], at[:, 1]])
    corners, base = (values[0].astype(np.longdouble) for values in (batch.corners, batch.base))
    beta = (weights[:, :, None] * corners[:, None, :]).sum(axis=0).T
    q = (beta[:, :, None] * base[:, None, :]).sum(axis=0)
    tip = batch.apexes[0, side].astype(np.longdouble)
    guess = parameters(batch.jets(at.astype(np.float64), 0).f[0], q, np.broadcast_to(tip, q.shape))
    net, rational = (values[0, side].astype(np.longdouble) for values in (batch.nets, batch.rational))
    t = root(lambda t: value(net, rational, np.concatenate([(1.0 - t) * beta, t[None]])), guess)[:, None]
    points: Long = (1.0 - t) * q + t * tip
    return points


def edge_points(batch: ShootingQuads, side: int, at: Long) -> Long:
    """Points (N, 3) of patch 0 over domain points (N, 2), by rays to one side."""
    u, v = at.T
    start, end = batch.span[0].astype(np.longdouble)
    x = start + (end - start) * u
    ends, tips = batch.ends[0].astype(np.longdouble), batch.apexes[0, side].astype(np.longdouble)
    q = (1.0 - x)[:, None] * ends[0] + x[:, None] * ends[1]
    tip = (1.0 - v)[:, None] * tips[0] + v[:, None] * tips[1]
    guess = parameters(batch.jets(at.astype(np.float64), 0).f[0], q, tip)
    net, rational = (values[0, side].astype(np.longdouble) for values in (batch.nets, batch.rational))

    def alpha(t: Long) -> Long:
        return np.stack([(1.0 - v) * t, (1.0 - x) * (1.0 - t), x * (1.0 - t), v * t])

    t = root(lambda t: value(net, rational, alpha(t)), guess)[:, None]
    points: Long = (1.0 - t) * q + t * tip
    return points


def parameters(points: Float, start: Long, end: Long) -> Long:
    along = end - start
    ratio: Long = ((points - start) * along).sum(axis=1) / (along * along).sum(axis=1)
    return ratio


def differences(points: Callable[[Long], Long], at: Float) -> Long:
    """Jets (6, N, 3) of a map from domain points (N, 2), by central differences of fourth order."""
    middle = at.astype(np.longdouble)
    first = ((-2, 1), (-1, -8), (1, 8), (2, -1))
    second = ((-2, -1), (-1, 16), (0, -30), (1, 16), (2, -1))

    def by_u(weights: Weights, j: int = 0) -> Long:
        return combined([(w, points(middle + STEP * np.array([i, j]))) for i, w in weights])

    def by_v(weights: Weights) -> Long:
        return combined([(w, points(middle + STEP * np.array([0, j]))) for j, w in weights])

    mixed = combined([(w, by_u(first, j)) for j, w in first])
    once, twice = 12 * STEP, 12 * STEP**2
    rows = by_u(first) / once, by_v(first) / once, by_u(second) / twice, mixed / once**2, by_v(second) / twice
    return np.stack([points(middle), *rows])


def combined(parts: list[tuple[int, Long]]) -> Long:
    """Sum of multiples."""
    total = np.zeros_like(parts[0][1])
    for weight, part in parts:
        total += weight * part
    return total
