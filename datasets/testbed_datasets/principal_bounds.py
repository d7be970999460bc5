"""Guaranteed bounds of the principal curvatures of tensor-product Bezier patches, and where curvature is extreme.

The largest principal curvature of a patch stays below c >= 0 if the form c I - II is positive definite everywhere.
II = L' / w with L' = -<S_uu, a>, a = S_u x S_v, w = |a|, and so on; w >= <a, n> for any one unit vector n, so it is
enough that c <a, n> I - (L', M', N') is positive definite, and that is the sign of two polynomials. A polynomial is
positive where all its Bernstein coefficients are. With n the normal at the middle the bound exceeds the curvature by
little: the excess falls with the square of the size of a patch.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from testbed.geometry.bernstein import subdivide_tensor
from testbed.geometry.vectors import Float, Int, unit

#: Rounding of products' coefficients, relative to the largest, and of halved patches' control points: a hundred times
#: what it is.
ROUNDING, PLACES = 1e-13, 1e-14
#: Bounds of extreme curvatures are this near, relatively, to curvatures that were found.
TOLERANCE = 1e-5
#: Patches of one size that are examined to bound extreme curvatures.
MOST_PATCHES = 2048
#: Steps a side of the lattices in which extremes are searched for, the peaks followed and how often they are zoomed at.
STEPS, PEAKS, ZOOMS = 48, 8, 30


@cache
def _binomials(m: int, n: int) -> Float:
    """Products of binomial coefficients (m + 1, n + 1), read-only."""
    rows, columns = ([float(math.comb(d, k)) for k in range(d + 1)] for d in (m, n))
    table: Float = np.outer(rows, columns)
    table.flags.writeable = False
    return table


def multiply(a: Float, b: Float) -> Float:
    """Bernstein coefficients of products of tensor-product polynomials, (P, m + 1, n + 1) each."""
    if a[0].size > b[0].size:
        a, b = b, a
    (m, n), (p, q) = a.shape[1:], b.shape[1:]
    weighted, others = a * _binomials(m - 1, n - 1), b * _binomials(p - 1, q - 1)
    product = np.zeros((max(len(a), len(b)), m + p - 1, n + q - 1))
    for i in range(m):
        for j in range(n):
            product[:, i : i + p, j : j + q] += weighted[:, i, j, None, None] * others
    product /= _binomials(m + p - 2, n + q - 2)
    return product


def _scalar_product(a: Float, b: Float) -> Float:
    return multiply(a[..., 0], b[..., 0]) + multiply(a[..., 1], b[..., 1]) + multiply(a[..., 2], b[..., 2])


def _derivative(net: Float, axis: int) -> Float:
    """Coefficients of the derivative along u (axis 1) or v (axis 2), over the patch's own unit square."""
    derivative: Float = (net.shape[axis] - 1) * np.diff(net, axis=axis)
    return derivative


def area_vectors(nets: Float) -> Float:
    """Coefficients (P, 2 m, 2 n, 3) of S_u x S_v for nets (P, m + 1, n + 1, 3)."""
    along_u, along_v = _derivative(nets, 1), _derivative(nets, 2)
    planes = [
        multiply(along_u[..., i], along_v[..., j]) - multiply(along_u[..., j], along_v[..., i])
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]
    return np.stack(planes, axis=-1)


def middle_normals(area: Float) -> Float:
    """Unit vectors (P, 3) near the normals of patches, from the coefficients of their area vectors."""
    return unit(area.mean(axis=(1, 2)))


def principal_bounds(nets: Float) -> tuple[Float, Float]:
    """True bounds (P,) of the principal curvatures of patches (P, m + 1, n + 1, 3): none is lower, none is higher.

    The degrees are at least 2. The lower bound is at most 0 and the upper at least 0; infinite where a patch turns too
    much, or is not regular. Rounding is allowed for. Curvature is positive where a patch bends away from S_u x S_v.
    """
    along_u, along_v = _derivative(nets, 1), _derivative(nets, 2)
    area = area_vectors(nets)
    w = np.einsum("pijx,px->pij", area, middle_normals(area))
    pairs = ((along_u, along_u), (along_u, along_v), (along_v, along_v))
    first = tuple(multiply(w, _scalar_product(*pair)) for pair in pairs)
    # the second form's polynomials are of lower degree than those they are compared with, by that of the patch
    one = np.ones((1, *nets.shape[1:3]))
    twice = (_derivative(along_u, 1), _derivative(along_u, 2), _derivative(along_v, 2))
    second = tuple(-multiply(_scalar_product(derivative, area), one) for derivative in twice)
    # second differences of the control points, however small, carry the rounding of the points' coordinates
    degree = max(nets.shape[1:3]) - 1
    slack = PLACES * 4.0 * degree**2 * largest(nets) * largest(area)
    return -_upper(first, tuple(-form for form in second), slack), _upper(first, second, slack)


def largest(*coefficients: Float) -> Float:
    """Largest moduli of the coefficients that belong to each patch, (P, 1, 1)."""
    sizes: Float = np.max([np.abs(one).reshape(len(one), -1).max(axis=1) for one in coefficients], axis=0)
    return sizes[:, None, None]


def _upper(first: tuple[Float, ...], second: tuple[Float, ...], slack: Float) -> Float:
    """Smallest c >= 0 (P,) from which on c first - second is positive definite, as its coefficients show.

    ``first`` is E, F, G and ``second`` L, M, N, whose coefficients are wrong by at most ``slack`` (P, 1, 1).
    """
    (E, F, G), (L, M, N) = first, second
    size, bending = largest(*first), largest(*second) + slack
    # the determinant is c^2 square - c linear + constant
    square = multiply(E, G) - multiply(F, F) - ROUNDING * size**2
    linear = multiply(E, N) + multiply(G, L) - 2.0 * multiply(F, M) + 4.0 * size * (slack + ROUNDING * bending)
    constant = multiply(L, N) - multiply(M, M) - 4.0 * bending * (slack + ROUNDING * bending)
    with np.errstate(all="ignore"):  # coefficients that are not positive bound nothing: infinite, below
        root = (linear + np.sqrt(np.maximum(linear**2 - 4.0 * square * constant, 0.0))) / (2.0 * square)
        bounds = [np.where(square > 0.0, root, np.inf)]
        for of_first, of_second in ((E, L), (G, N)):
            positive = of_first - ROUNDING * size
            bounds.append(np.where(positive > 0.0, (of_second + slack) / positive, np.inf))
    by_patch = [np.where(np.isnan(one), np.inf, one).max(axis=(1, 2)) for one in bounds]
    # the operations above round too
    highest: Float = np.max(np.stack([*by_patch, np.zeros(len(E))]), axis=0) * (1.0 + ROUNDING)
    return highest


def quarters(nets: Float) -> Float:
    """Halve patches (P, m + 1, n + 1, 3) both ways, to (4 P, m + 1, n + 1, 3)."""
    halves = np.concatenate(subdivide_tensor(nets, 0))
    return np.concatenate(subdivide_tensor(halves, 1))


def bounded_extremes(nets: Float, low: float, high: float) -> tuple[float, float]:
    """Guaranteed bounds of the principal curvatures of all patches, close to curvatures ``low`` and ``high`` they have.

    Patches that may have more than these by ``TOLERANCE``, relative to the larger, are halved, as long as they are few.
    As with :func:`principal_bounds` the lower bound is at most 0 and the upper at least 0.
    """
    beyond = TOLERANCE * max(abs(low), abs(high))
    low, high = min(low - beyond, 0.0), max(high + beyond, 0.0)
    while True:
        lower, upper = principal_bounds(nets)
        beyond_bounds = (lower < low) | (upper > high)
        if not beyond_bounds.any():
            return low, high
        if 4 * beyond_bounds.sum() > MOST_PATCHES:
            return min(low, float(lower.min())), max(high, float(upper.max()))
        nets = quarters(nets[beyond_bounds])


@dataclass(frozen=True)
class Peak:
    """An extreme value and the parameters (u, v) of where it was found."""

    value: float
    at: tuple[float, float]


def highest_place(function: Callable[[Float], Float], side: float) -> Peak:
    """Largest value of a function (N, 2) -> (N,) on the square [0, side]^2: a lattice, then zooming at its peaks."""
    lattice = np.stack(np.meshgrid(*2 * [np.linspace(0.0, side, STEPS + 1)], indexing="ij"), axis=-1)
    values = function(lattice.reshape(-1, 2)).reshape(lattice.shape[:2])
    around = np.pad(values, 1, constant_values=-np.inf)
    beside = [around[1 + i : STEPS + 2 + i, 1 + j : STEPS + 2 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    peaks = np.flatnonzero(values >= np.max(np.stack(beside), axis=0))
    centres = lattice.reshape(-1, 2)[peaks[np.argsort(-values.ravel()[peaks], kind="stable")][:PEAKS]]
    offsets = np.stack(np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 5)], indexing="ij"), axis=-1).reshape(-1, 2)
    for zoom in range(ZOOMS):
        places = np.clip(centres[:, None] + offsets * (side / STEPS) * 0.6**zoom, 0.0, side)
        best: Int = function(places.reshape(-1, 2)).reshape(places.shape[:2]).argmax(axis=1)
        centres = places[np.arange(len(places)), best]
    values = function(centres)
    best_peak = int(values.argmax())
    return Peak(float(values[best_peak]), (float(centres[best_peak, 0]), float(centres[best_peak, 1])))
