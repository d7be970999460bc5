"""Evaluation of Bezier nets in bulk: jets of many patches at many points, the same bits however the work is divided.

Points shared by all patches: one matrix product, a table of Bernstein polynomials and their derivatives times the
control points. BLAS kernels round differently at ragged ends, so the rows of the table and the columns of the control
points are padded to whole blocks: a patch has the same bits whatever it is evaluated with, and so has a point.
Points of their own for each patch: the de Casteljau algorithm, element by element.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from testbed.geometry.bernstein import curve_tables, raised, tensor_tables, triangle_degree, triangle_tables
from testbed.geometry.jets import ROWS
from testbed.geometry.vectors import Float

# Whole blocks of the OpenBLAS kernels for Prescott, Nehalem, Sandybridge, Haswell, Zen and SkylakeX, on one thread and
# on two. Rows in blocks of 8 are not enough for Nehalem on two threads.
_BLOCK = 16
# Tables for at most so many points are remembered: a batch is evaluated chunk by chunk at the same points.
_REMEMBERED = 1024
# Points at a time where patches have points of their own: a few nets' worth of them stays in the cache.
_RUN = 1024
#: Orders of the derivatives along (u, v) in the rows of a jet.
PARTIALS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def apply_table(table: Float, nets: Float) -> Float:
    """Multiply a table (rows, S, n) with nets (P, n, dim).

    Returns a view (rows, P, S, dim) of memory in which the patches are contiguous, one component after the other. Large
    results are bound by memory: with some hundred patches at a time they are still in the cache when they are read.
    """
    rows, samples, n = table.shape
    patches, _, dim = nets.shape
    padded_table = np.zeros((_blocks(rows * samples), n))
    padded_table[: rows * samples].reshape(rows, samples, n)[:] = table
    width = dim * patches
    columns = np.zeros((n, _blocks(width)))
    columns[:, :width].reshape(n, dim, patches)[:] = nets.transpose(1, 2, 0)
    with np.errstate(invalid="ignore", over="ignore"):  # a patch that is not finite stays so, for the caller to find
        product = padded_table @ columns
    return product[: rows * samples, :width].reshape(rows, samples, dim, patches).transpose(0, 3, 1, 2)


def _blocks(count: int) -> int:
    """Round up to whole blocks; one more where rows of that length would all fall into the same lines of the cache."""
    whole = -(-count // _BLOCK) * _BLOCK
    return whole + _BLOCK if whole and whole % 256 == 0 else whole


def _table(degrees: tuple[int] | tuple[int, int], order: int, at: Float) -> Float:
    """Table (rows, S, n) of triangles (one degree) or tensor-product patches (two) at points (S, 2)."""
    tabulate = _tabulate if len(at) <= _REMEMBERED else _tabulate.__wrapped__
    return tabulate(degrees, order, np.asarray(at, dtype=np.float64).tobytes())


@lru_cache(maxsize=16)
def _tabulate(degrees: tuple[int] | tuple[int, int], order: int, points: bytes) -> Float:
    """Tabulate at points given by their bytes, so that equal points find the table made before."""
    at = np.frombuffer(points).reshape(-1, 2)
    if len(degrees) == 1:
        table = np.ascontiguousarray(triangle_tables(degrees[0], at, order))
    else:
        table = tensor_tables(degrees, at, order)
        table = table.reshape(*table.shape[:2], table.shape[2] * table.shape[3])
    table.flags.writeable = False
    return table


def triangle_jets(nets: Float, at: Float, order: int) -> Float:
    """Jets of triangles (P, n, dim) at (S, 2), or at each patch's own points (P, S, 2), to (rows, P, S, dim)."""
    degree = triangle_degree(nets.shape[1])
    if at.ndim == 2:
        return apply_table(_table((degree,), order, at), nets)
    result = np.zeros((ROWS[order], nets.shape[-1], *at.shape[:2]))
    with np.errstate(invalid="ignore", over="ignore"):
        for patches, net, (u, v) in _planar(nets, at):
            _casteljau(net, u, v, result[:, :, patches])
    return result.transpose(0, 2, 3, 1)


def _casteljau(net: Float, u: Float, v: Float, rows: Float) -> None:
    """Fill the rows of a jet (rows, dim, P, S) by the de Casteljau algorithm; net (n, dim, P, 1), parameters (P, S)."""
    degree = triangle_degree(len(net))
    w = 1.0 - (u + v)
    for d in range(degree, -1, -1):
        # the last levels hold what the derivatives are differences of
        if d == 2 and len(rows) > 3:
            p00, p01, p02, p11, p12, p22 = net
            rows[3] = p11 - 2.0 * p01 + p00
            rows[4] = (p12 - p02) - (p01 - p00)
            rows[5] = p22 - 2.0 * p02 + p00
            rows[3:] *= degree * (degree - 1)
        elif d == 1 and len(rows) > 1:
            rows[1], rows[2] = degree * (net[1] - net[0]), degree * (net[2] - net[0])
        if d > 0:
            first, second, third = raised(d - 1)
            net = w * net[first] + u * net[second] + v * net[third]
    rows[0] = net[0]


def tensor_jets(nets: Float, at: Float, order: int) -> Float:
    """Jets of tensor-product patches (P, m + 1, n + 1, dim) at (S, 2) or (P, S, 2), to (rows, P, S, dim)."""
    m, n = nets.shape[1] - 1, nets.shape[2] - 1
    if at.ndim == 2:
        return apply_table(_table((m, n), order, at), nets.reshape(len(nets), (m + 1) * (n + 1), nets.shape[-1]))
    result = np.zeros((ROWS[order], nets.shape[-1], *at.shape[:2]))
    with np.errstate(invalid="ignore", over="ignore"):
        for patches, net, (u, v) in _planar(nets, at):
            along_u = np.moveaxis(curve_tables(m, u, order), -1, 1)
            along_v = np.moveaxis(curve_tables(n, v, order), -1, 1)
            curves = [_combine(table, np.moveaxis(net, 1, 0)) for table in along_v]
            for row, (r, s) in zip(result, PARTIALS, strict=False):
                row[:, patches] = _combine(along_u[r], curves[s])
    return result.transpose(0, 2, 3, 1)


def _combine(weights: Float, points: Float) -> Float:
    """Sum over the first axis of weights (k, P, S) times points (k, ..., P, S), term after term."""
    total: Float = weights[0] * points[0]
    for weight, point in zip(weights[1:], points[1:], strict=True):
        total += weight * point
    return total


def _planar(nets: Float, at: Float) -> Iterator[tuple[slice, Float, Float]]:
    """Yield runs of patches: which, their nets (..., dim, P, 1) and their parameters (2, P, S)."""
    run = max(1, _RUN // max(1, at.shape[1]))
    for start in range(0, len(nets), run):
        patches = slice(start, start + run)
        net = np.ascontiguousarray(np.moveaxis(nets[patches], 0, -1))[..., None]
        yield patches, net, np.ascontiguousarray(np.moveaxis(at[patches], -1, 0))


def project(homogeneous: Float) -> Float:
    """Jets (rows, ..., 4) in homogeneous coordinates (w f, w) to jets (rows, ..., 3) of f, by the quotient rule."""
    a, w = homogeneous[..., :3], homogeneous[..., 3:]
    f = np.empty_like(a)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a vanishing denominator is not finite
        inverse = 1.0 / w[0]
        f[0] = a[0] * inverse
        if len(a) >= 3:
            for r in (1, 2):
                f[r] = (a[r] - w[r] * f[0]) * inverse
        if len(a) == 6:
            for row, (r, s) in zip((3, 4, 5), ((1, 1), (1, 2), (2, 2)), strict=True):
                f[row] = (a[row] - w[r] * f[s] - w[s] * f[r] - w[row] * f[0]) * inverse
    return f
