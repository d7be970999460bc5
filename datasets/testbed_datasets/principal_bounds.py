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

#: Rounding of coefficients, relative to the largest of their polynomial.
ROUNDING = 1e-12
#: Bounds of extreme curvatures are this near, relatively, to curvatures that were found.
TOLERANCE = 1e-6
#: Patches are halved at most so often.
MOST_HALVINGS = 14
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

    The lower is at most 0 and the upper at least 0; infinite where a patch turns too much, or is not regular. Rounding
    is allowed for. Curvature is positive where a patch bends away from S_u x S_v.
    """
    along_u, along_v = _derivative(nets, 1), _derivative(nets, 2)
    area = area_vectors(nets)
    w = np.einsum("pijx,px->pij", area, middle_normals(area))
    one = np.ones((1, *(size - along for size, along in zip(w.shape[1:], (2, 2), strict=True))))
    # the forms are of lower degree than those they are compared with
    pairs = ((along_u, along_u), (along_u, along_v), (along_v, along_v))
    E, F, G = (multiply(w, _scalar_product(*pair)) for pair in pairs)
    twice = (_derivative(along_u, 1), _derivative(along_u, 2), _derivative(along_v, 2))
    L, M, N = (-multiply(_scalar_product(second, area), one) for second in twice)
    square, linear = multiply(E, G) - multiply(F, F), multiply(E, N) + multiply(G, L) - 2.0 * multiply(F, M)
    constant = multiply(L, N) - multiply(M, M)
    upper = _upper(E, G, L, N, square, linear, constant)
    return -_upper(E, G, -L, -N, square, -linear, constant), upper


def _upper(E: Float, G: Float, L: Float, N: Float, square: Float, linear: Float, constant: Float) -> Float:
    """Smallest c >= 0 (P,) from which on c E - L, c G - N and c^2 square - c linear + constant are positive."""

    def slack(*polynomials: Float) -> Float:
        sizes = [np.abs(one).max(axis=(1, 2), keepdims=True) for one in polynomials]
        size: Float = np.max(np.stack(sizes), axis=0)
        return ROUNDING * size

    with np.errstate(all="ignore"):  # coefficients that are not positive bound nothing: infinite, below
        simple = [
            np.where(first > 0.0, (second + slack(second)) / first, np.inf)
            for first, second in ((E - slack(E), L), (G - slack(G), N))
        ]
        leading, last = square - slack(square), constant - slack(constant)
        middle = linear + slack(linear)
        root = (middle + np.sqrt(np.maximum(middle * middle - 4.0 * leading * last, 0.0))) / (2.0 * leading)
        simple.append(np.where(leading > 0.0, root, np.inf))
    bounds = [np.where(np.isnan(one), np.inf, one).max(axis=(1, 2)) for one in simple]
    # the operations above round too
    highest: Float = np.max(np.stack([*bounds, np.zeros(len(E))]), axis=0) * (1.0 + 1e-12)
    return highest


def quarters(nets: Float) -> Float:
    """Halve patches (P, m + 1, n + 1, 3) both ways, to (4 P, m + 1, n + 1, 3)."""
    halves = np.concatenate(subdivide_tensor(nets, 0))
    return np.concatenate(subdivide_tensor(halves, 1))


def bounded_extremes(nets: Float, low: float, high: float) -> tuple[float, float]:
    """Guaranteed bounds of the principal curvatures of all patches, close to curvatures ``low`` and ``high`` they have.

    Patches that may have more than these by ``TOLERANCE`` are halved. As with :func:`principal_bounds` the lower bound
    is at most 0 and the upper at least 0.
    """
    bounds = [low - TOLERANCE * abs(low), high + TOLERANCE * abs(high)]
    bounds = [min(bounds[0], 0.0), max(bounds[1], 0.0)]
    for _ in range(MOST_HALVINGS):
        lower, upper = principal_bounds(nets)
        nets = nets[(lower < bounds[0]) | (upper > bounds[1])]
        if not len(nets):
            return bounds[0], bounds[1]
        nets = quarters(nets)
    lower, upper = principal_bounds(nets)
    return min(bounds[0], float(lower.min())), max(bounds[1], float(upper.max()))


@dataclass(frozen=True)
class Peak:
    """An extreme value and the parameters (u, v) of where it was found."""

    value: float
    at: tuple[float, float]


def highest(function: Callable[[Float], Float], side: float) -> Peak:
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
