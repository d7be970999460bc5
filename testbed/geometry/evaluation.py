"""Evaluation of Bezier nets in bulk: jets of many patches at many points, the same bits however the work is divided.

Points shared by all patches: one matrix product, a table of Bernstein polynomials and their derivatives times the
control points. BLAS kernels round differently at ragged ends, so the rows of the table and the columns of the control
points are padded to whole blocks: a patch has the same bits whatever it is evaluated with, and so has a point.
Points of their own for each patch: the de Casteljau algorithm, element by element.
"""

from collections.abc import Iterator

import numpy as np

from testbed.geometry.bernstein import curve_tables, raised, tensor_tables, triangle_degree, triangle_tables
from testbed.geometry.jets import ROWS
from testbed.geometry.vectors import Float

# Whole blocks of every OpenBLAS kernel for x86-64, from SSE2 to AVX-512, on one thread and on two.
_BLOCK = 16
# Points at a time where patches have points of their own: a few nets' worth of them stays in the cache.
_RUN = 1024
# Points at a time where a table is shared: their jets stay in the cache until they are read.
_SHARED_RUN = 50_000
#: Orders of the derivatives along (u, v) in the rows of a jet.
PARTIALS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def runs(patches: int, samples: int) -> Iterator[slice]:
    """Yield slices of a batch of patches, each so short that its second-order jets at the samples stay in the cache."""
    step = max(1, _SHARED_RUN // max(1, samples))
    for start in range(0, patches, step):
        yield slice(start, min(start + step, patches))


def apply_table(table: Float, nets: Float) -> Float:
    """Multiply a table (rows, S, n) with nets (P, n, dim).

    Returns a view (rows, P, S, dim) of memory in which the patches are contiguous, one component after the other. Large
    results are bound by memory: evaluate some hundred patches at a time (see :func:`runs`).
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


def triangle_jets(nets: Float, at: Float, order: int) -> Float:
    """Jets of triangles (P, n, dim) at (S, 2), or at each patch's own points (P, S, 2), to (rows, P, S, dim)."""
    degree = triangle_degree(nets.shape[1])
    if at.ndim == 2:
        return apply_table(triangle_tables(degree, at, order), nets)
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
        table = tensor_tables((m, n), at, order)
        return apply_table(table.reshape(*table.shape[:2], -1), nets.reshape(len(nets), -1, nets.shape[-1]))
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
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a vanishing denominator is NaN or infinite
        f[0] = a[0] / w[0]
        if len(a) >= 3:
            for r in (1, 2):
                f[r] = (a[r] - w[r] * f[0]) / w[0]
        if len(a) == 6:
            for row, (r, s) in zip((3, 4, 5), ((1, 1), (1, 2), (2, 2)), strict=True):
                f[row] = (a[row] - w[r] * f[s] - w[s] * f[r] - w[row] * f[0]) / w[0]
    return f
