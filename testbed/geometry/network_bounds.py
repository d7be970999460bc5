"""Guaranteed bounds of the principal curvatures of S-patches, piece by piece.

Over a triangle of its polygon an S-patch is a rational Bezier triangle of degree d (n - 2): the products pi_i are
polynomials of degree n - 2 in Bernstein form, and the de Casteljau algorithm runs on such polynomials as well as on
numbers. Halving a triangle halves its rows of control points.

On a small piece let f be the patch in a frame (e_1, e_2, n_0) at a point c of it, in parameters s, t for which
f_s = e_1 and f_t = e_2 there. With homogeneous coordinates (X, W), X = (f - c) W,

    f_s = X_s / W - f W_s / W,    f_ss = X_ss / W - 2 f_s W_s / W - f W_ss / W,

and the range of each quotient is that of the quotients of Bernstein coefficients, as W > 0. Then |k| <= |II| / l with
the least eigenvalue l of the first form, and <f_ss, n> is <f_ss, n_0> within |f_ss| |n - n_0|. The bounds exceed the
curvatures by a part that falls with the size of the piece.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bernstein import (
    index_of,
    multi_indices,
    multiply_triangles,
    raised,
    subdivide_curve,
    triangle_degree,
    triangle_tables,
)
from testbed.geometry.charted import triangle_fan
from testbed.geometry.charted_surface import CurvedBoxes
from testbed.geometry.curvature import principal
from testbed.geometry.evaluation import project
from testbed.geometry.jets import Jet
from testbed.geometry.polygon_coordinates import corner_areas
from testbed.geometry.s_patches import SPatches
from testbed.geometry.simplex_bernstein import simplex_raised
from testbed.geometry.vectors import Float, cross, norm, unit

#: Halvings of the triangles from a polygon's centre to its sides, for the boxes; and more, at most, for their bounds.
BOXED, ROUNDS = 4, 10
#: Control points of the pieces that are halved in a round, at most: so many are a hundred megabytes.
MOST = 1 << 22
#: Bounds are good enough within this factor of a curvature in the same box, or of a part of the largest of all.
FACTOR, PART = 1.5, 0.5
#: Errors of Bernstein coefficients relative to the largest, a hundred times what they are.
ROUNDING = 1e-12
#: Control points of the pieces that are bounded together, so that they stay in the cache.
RUN = 1 << 15


def curved_boxes(patches: SPatches) -> CurvedBoxes:
    """Boxes that together contain patches, with bounds of the curvatures on the piece in each; rounding is included."""
    nets = rational_triangles(patches)
    for _ in range(BOXED):
        nets = halved(nets)
    corners = nets[..., :3] / nets[..., 3:]
    loose = ROUNDING * np.abs(corners).max(initial=0.0)
    low, high = corners.min(axis=1) - loose, corners.max(axis=1) + loose
    return CurvedBoxes(low, high, bounds_of_boxes(nets))


def bounds_of_boxes(nets: Float) -> Float:
    """Bounds (B,) of the curvatures on rational triangles (B, N, 4), halved until they are good, or often enough."""
    bound, found = np.zeros((2, len(nets)))
    box = np.arange(len(nets))
    for left in range(ROUNDS, -1, -1):
        upper, attained = curvature_bounds(nets).T
        np.maximum.at(found, box, attained)
        good = upper <= FACTOR * np.maximum(found[box], PART * found.max(initial=0.0))
        good |= (left == 0) | (2 * np.count_nonzero(~good) * nets.shape[1] > MOST)
        np.maximum.at(bound, box[good], upper[good])
        if good.all():
            break
        nets, box = halved(nets[~good]), np.tile(box[~good], 2)
    return bound


def rational_triangles(patches: SPatches) -> Float:
    """Homogeneous nets (n P, N, 4) of S-patches over the triangles from the sides to the centre of the polygon.

    Corners of the triangles as of :func:`~testbed.geometry.charted.triangle_fan`, the triangles of a patch after one
    another. Weights are scaled to at most one.
    """
    sides, depth, polygon = patches.sides, patches.depth, patches.corners
    fan, _ = triangle_fan(polygon)
    following = np.roll(polygon, -1, axis=0)
    edge = following - polygon
    away = fan[:, None] - polygon[:, None]
    # double areas (fan, side, corner of the triangle): linear functions in Bernstein form; zero where a corner is on
    # the side
    alpha = edge[:, None, 0] * away[..., 1] - edge[:, None, 1] * away[..., 0]
    i = np.arange(sides)
    alpha[i, i, 0] = alpha[i, i, 1] = 0.0
    alpha[i, i - 1, 0] = alpha[i, (i + 1) % sides, 1] = 0.0
    products = np.broadcast_to(corner_areas(polygon)[:, None, None], (sides, sides, 1, 1))
    for step in range(1, sides - 1):
        products = multiply_triangles(products, alpha[:, (i + step) % sides][..., None])
    products = products / products.sum(axis=1, keepdims=True).max(axis=(1, 2, 3), keepdims=True)
    # (P, fan, control points, Bernstein coefficients, 4)
    points = np.concatenate([patches.control_points, np.ones((*patches.control_points.shape[:2], 1))], axis=-1)
    net = np.broadcast_to(points[:, None, :, None], (len(patches), sides, points.shape[1], 1, 4))
    for degree in range(depth - 1, -1, -1):
        raised = simplex_raised(sides, degree)
        terms = (multiply_triangles(net[:, :, raised[r]], products[:, r, None]) for r in range(sides))
        net = sum(terms, start=np.zeros(4))
    return net.reshape(-1, *net.shape[-2:])


def halved(nets: Float) -> Float:
    """Halve triangles (P, N, dim) from the middle of side 0 to corner 2, to (2 P, N, dim).

    The middle becomes corner 2 of both halves, so that the next halving cuts their sides that are whole.
    """
    degree = triangle_degree(nets.shape[1])
    first, second = np.empty_like(nets), np.empty_like(nets)
    for k in range(degree + 1):
        row = [index_of((degree - k - j, j, k)) for j in range(degree - k + 1)]
        first[:, row], second[:, row] = subdivide_curve(nets[:, row])
    # corners (0, m, 2) to (2, 0, m), and (m, 1, 2) to (1, 2, m)
    exponents = multi_indices(degree).tolist()
    to_first = [index_of((j, k, i)) for i, j, k in exponents]
    to_second = [index_of((k, i, j)) for i, j, k in exponents]
    return np.concatenate([first[:, to_first], second[:, to_second]])


@dataclass(frozen=True, eq=False)
class Interval:
    """Numbers between two others, (...)."""

    low: Float
    high: Float

    def __add__(self, other: "Interval") -> "Interval":
        return Interval(self.low + other.low, self.high + other.high)

    def __sub__(self, other: "Interval") -> "Interval":
        return Interval(self.low - other.high, self.high - other.low)

    def __mul__(self, other: "Interval") -> "Interval":
        ends = np.stack(
            np.broadcast_arrays(
                self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high
            )
        )
        return Interval(ends.min(axis=0), ends.max(axis=0))

    def __getitem__(self, key: slice | int) -> "Interval":
        return Interval(self.low[key], self.high[key])

    @property
    def size(self) -> Float:
        """Largest modulus."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def middle(self) -> Float:
        """The number half-way."""
        return 0.5 * (self.low + self.high)

    @property
    def radius(self) -> Float:
        """Half the length."""
        return 0.5 * (self.high - self.low)


def curvature_bounds(nets: Float) -> Float:
    """Upper bounds of the moduli of the principal curvatures of rational triangles (P, N, 4), and that at the middle.

    (P, 2); the bounds are infinite where the weights may vanish or the parametrisation may be singular.
    """
    result = np.empty((len(nets), 2))
    run = max(1, RUN // nets.shape[1])
    for start in range(0, len(nets), run):
        with np.errstate(all="ignore"):  # singular pieces become NaN, which bounds nothing
            result[start : start + run] = _bounds(nets[start : start + run])
    return result


def _bounds(nets: Float) -> Float:
    """Bounds and curvatures (P, 2) of a few pieces."""
    degree = triangle_degree(nets.shape[1])
    table = triangle_tables(degree, np.full((1, 2), 1.0 / 3.0))[:, 0]
    jet = project(np.einsum("rn,pnx->rpx", table, nets))
    attained = np.nan_to_num(np.abs(np.stack(principal(Jet(jet)))).max(axis=0), posinf=0.0)
    e1, n0 = unit(jet[1]), unit(cross(jet[1], jet[2]))
    frame = np.stack([e1, cross(n0, e1), n0], axis=-1)
    jacobian = np.einsum("zpx,pxr->prz", jet[1:3], frame[..., :2])
    inverse = np.linalg.inv(np.where(np.isfinite(jacobian) & (jet[1, :, :1, None] != 0.0), jacobian, np.eye(2)))
    # barycentric directions (3, P) in which f_s = e_1 and f_t = e_2 at the middle
    along = [np.stack([-inverse[:, :, z].sum(axis=1), inverse[:, 0, z], inverse[:, 1, z]]) for z in (0, 1)]
    # patches last, so that operations run along them
    homogeneous = np.empty((nets.shape[1], 4, len(nets)))
    homogeneous[:, 3] = nets[..., 3].T
    moved = nets[..., :3] - jet[0][:, None] * nets[..., 3:]
    homogeneous[:, :3] = np.einsum("pnx,pxr->nrp", moved, frame)
    size = np.abs(nets).max(axis=1)
    error = ROUNDING * np.stack([*3 * [size[:, :3].max(axis=1)], size[:, 3]])
    bound = _bound(homogeneous, along, error)
    unknown = np.isnan(bound) | ~(homogeneous[:, 3].min(axis=0) > 0.0)
    return np.stack([np.where(unknown, np.inf, bound * (1.0 + ROUNDING)), attained], axis=-1)


def _bound(net: Float, along: list[Float], error: Float) -> Float:
    """Bound (P,) from nets (N, 4, P) of X and W, whose coefficients are wrong by ``error`` (4, P) at most."""
    degree = triangle_degree(len(net))
    W = net[:, 3:]
    least_weight = W[:, 0].min(axis=0)
    # a derivative has the degree of W again if the net is elevated before
    once = _elevated(net, degree)
    twice = _elevated(once, degree + 1)

    def range_of(derivative: Float, directions: tuple[int, ...]) -> tuple[Interval, Interval]:
        """Ranges over W of the derivatives of X, (3, P), and of W, (1, P)."""
        quotients = derivative / W
        grown = error
        for z in directions:
            grown = grown * (degree + 2) * np.abs(along[z]).sum(axis=0)
        low, high = quotients.min(axis=0), quotients.max(axis=0)
        loose = grown / least_weight + ROUNDING * np.maximum(np.abs(low), np.abs(high))
        hull = Interval(low - loose, high + loose)
        return hull[:3], hull[3:]

    f, _ = range_of(net, ())
    first, growth = zip(*(range_of(_derivative(once, degree + 1, along[z]), (z,)) for z in (0, 1)), strict=True)
    tangents = [first[z] - f * growth[z] for z in (0, 1)]
    slopes = [_derivative(twice, degree + 2, direction) for direction in along]
    bends = []
    for z, w in ((0, 0), (0, 1), (1, 1)):
        second, weight = range_of(_derivative(slopes[z], degree + 1, along[w]), (z, w))
        bends.append(second - tangents[z] * growth[w] - tangents[w] * growth[z] - f * weight)
    E, F, G = (_dot(tangents[z], tangents[w]) for z, w in ((0, 0), (0, 1), (1, 1)))
    least = np.minimum(E.low, G.low) - F.size
    # every unit tangent is within this sine of the middle's tangent plane, and so is the normal of n_0
    sine = np.hypot(tangents[0].size[2], tangents[1].size[2]) / np.sqrt(least)
    turned = np.where(sine < 1.0, np.sqrt(2.0) * sine, np.nan)
    L, M, N = (bend[2] for bend in bends)
    slack = [form.radius + turned * norm(bend.size.T) for form, bend in zip((L, M, N), bends, strict=True)]
    middle, half = 0.5 * (L.middle + N.middle), 0.5 * (L.middle - N.middle)
    largest = np.abs(middle) + np.hypot(half, M.middle)
    spread = np.sqrt(slack[0] ** 2 + 2.0 * slack[1] ** 2 + slack[2] ** 2)
    bound: Float = np.where(least > 0.0, (largest + spread) / least, np.nan)
    return bound


def _elevated(net: Float, degree: int) -> Float:
    """Nets (N, dim, P) of a degree, written with one more."""
    exponents = (multi_indices(degree) + 1.0) / (degree + 1.0)
    total = np.zeros((len(multi_indices(degree + 1)), *net.shape[1:]))
    first, second, third = raised(degree)
    total[first] += exponents[:, 0, None, None] * net
    total[second] += exponents[:, 1, None, None] * net
    total[third] += exponents[:, 2, None, None] * net
    return total


def _derivative(net: Float, degree: int, along: Float) -> Float:
    """Derivatives of nets (N, dim, P) of a degree in barycentric directions (3, P)."""
    first, second, third = raised(degree - 1)
    slope: Float = along[0] * net[first] + along[1] * net[second] + along[2] * net[third]
    slope *= degree
    return slope


def _dot(a: Interval, b: Interval) -> Interval:
    products = a * b
    return Interval(products.low.sum(axis=0), products.high.sum(axis=0))
