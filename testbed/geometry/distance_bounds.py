"""Guaranteed bounds of how far polynomial and rational patches are from an exact surface, everywhere in the patch.

Level sets (Taylor form, then Bernstein form). Let g be expanded about the patch's centre. Its composition with the
patch is a polynomial on the patch, whose Bernstein coefficients bound it; |grad g| has a linear lower bound. From x the
flow of grad g reaches the level set after a way of at most |g(x)| / min |grad g| as long as |grad g| does not fall
below that minimum there. So the distance is at most the quotient, whatever else the surface does elsewhere.

Other surfaces (by curvature). About a point y of the surface with normal n, the surface is a graph over the disc of
radius r of the tangent plane if all its principal curvatures are at most k < 1 / r, with heights of at most
k r^2 / (1 + sqrt(1 - k^2 r^2)), those of a sphere: so a point at tangential offset r is at most that and |<x - y, n>|
away. This is so where the surface
does not end. In any case the distance is at most that from y.

Rounding is included: everything computed is widened by a bound of what it may be off by.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.composition import BernsteinBasis, centre_weights, compose, elevation
from testbed.geometry.exact import ExactSurface
from testbed.geometry.level_bounds import EPSILON, EnclosedLevelSet, Expansion
from testbed.geometry.vectors import Bool, Float, dot, norm

#: Highest order of expansions: those of polynomials up to this degree are exact.
ORDER = 4
#: A lower bound of at least this part of |g| / |grad g| needs no foot to be improved.
CLOSE = 0.9
#: How far lower bounds are sought, in units of |g| / |grad g|.
REACHES = (2.0, 1.0, 0.5)
#: Patches bounded at once, so that all that belongs to them stays in the processor's cache.
BLOCK = 512


@dataclass(frozen=True, eq=False)
class PatchNets:
    """Control points of patches over one domain.

    Parameters
    ----------
    basis
        Degree, or bidegree.
    points
        (P, n, 3), or (P, n, 4) homogeneous ones (w x, w y, w z, w) with positive weights.
    slack
        (P,) how far the patch that is meant may be from the one with these control points.
    """

    basis: BernsteinBasis
    points: Float
    slack: Float

    def __len__(self) -> int:
        return len(self.points)

    def take(self, chosen: slice | Bool) -> "PatchNets":
        """Return some of them."""
        return PatchNets(self.basis, self.points[chosen], self.slack[chosen])


@dataclass(frozen=True, eq=False)
class DistanceBounds:
    """Bounds of the largest distance of each patch to a surface.

    Parameters
    ----------
    low, high
        (P,) bounds; the largest distance is at least ``low`` because the patch's centre is that far away.
    seen
        (P,) the centre's distance by what is known without a guarantee, if that is more than ``low``.
    noise
        (P,) what rounding alone makes of the difference of the bounds.
    crude
        (P,) whether the upper bound is but the size of the patch about a foot: it falls with the size itself, others
        with its square.
    """

    low: Float
    high: Float
    seen: Float
    noise: Float
    crude: Bool


def distance_bounds(exact: ExactSurface, nets: PatchNets) -> DistanceBounds:
    """Bound the largest distances of patches to a surface; infinite where nothing is known.

    Lower bounds are guaranteed for level sets with expansions; for others they are as good as ``closest``, which may
    have found a foot that is not the nearest point of the surface.
    """
    result = np.empty((5, len(nets)))
    for start in range(0, len(nets), BLOCK):
        some = slice(start, min(start + BLOCK, len(nets)))
        # overflow and coordinates that are not finite give bounds that are not, which are taken for infinite below
        with np.errstate(all="ignore"):
            result[:, some] = _bounds_of_block(exact, nets.take(some))
    low, high, seen, noise, crude = result
    # written so that NaN is no bound
    low, high = np.where(low > 0.0, low, 0.0), np.where(high >= 0.0, high, np.inf)
    return DistanceBounds(low, high, np.where(seen > low, seen, low), noise, crude > 0.0)


def _bounds_of_block(exact: ExactSurface, nets: PatchNets) -> Float:
    homogeneous = nets.points.shape[2] == 4
    weights = nets.points[..., 3] if homogeneous else None
    points = nets.points[..., :3] / weights[..., None] if weights is not None else nets.points
    centre = _centres(nets)
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), np.abs(centre).max(axis=1))
    slack = nets.slack + (8.0 + 4.0 * len(nets.basis)) * EPSILON * scale
    if isinstance(exact, EnclosedLevelSet):
        low, high, noise, first_order = _by_level_set(exact, nets.basis, points, weights, centre)
        # the foot of the centre says more where the surface bends or |grad g| changes much on the way to it
        with_feet = ~((high <= norm(points - centre[:, None]).max(axis=1)) & (low + noise >= CLOSE * first_order))
    else:
        low, high, noise = np.zeros((3, len(nets)))
        high[:] = np.inf
        with_feet = np.ones(len(nets), dtype=np.bool_)
    seen, crude = low.copy(), np.zeros(len(nets), dtype=np.bool_)
    if with_feet.any():
        near, far, rounding, rough = _by_feet(exact, points[with_feet], centre[with_feet])
        # fmax, fmin: a foot that is not found bounds nothing
        seen[with_feet] = np.fmax(low[with_feet], near)
        if not isinstance(exact, EnclosedLevelSet) or exact.nearest:
            low = seen
        crude[with_feet] = rough & ~(high[with_feet] < far)
        high[with_feet] = np.fmin(high[with_feet], far)
        noise[with_feet] = np.maximum(noise[with_feet], np.nan_to_num(rounding))
    if weights is not None:
        high[~(weights > 0.0).all(axis=1)] = np.inf
    return np.stack([low - slack, high + slack, seen - slack, noise + 2.0 * slack, crude])


def _centres(nets: PatchNets) -> Float:
    """Points (P, 3) of the patches at the centres of their domains."""
    weights = centre_weights(nets.basis)
    total = np.zeros((len(nets), nets.points.shape[2]))
    for index, weight in enumerate(weights):
        total += weight * nets.points[:, index]
    return total[:, :3] / total[:, 3:] if total.shape[1] == 4 else total


def _by_level_set(
    exact: EnclosedLevelSet, basis: BernsteinBasis, points: Float, weights: Float | None, centre: Float
) -> tuple[Float, Float, Float, Float]:
    """Lower and upper bounds, their noise and the quotient at the centre (P,), from |g| / |grad g|."""
    about = exact.expansion(centre, ORDER)
    order = about.order
    offsets = points - centre[:, None]
    radii = np.abs(offsets).max(axis=1)
    planar = np.ascontiguousarray(offsets.transpose(1, 2, 0))
    w = None if weights is None else np.ascontiguousarray(weights.T)
    values = compose(planar if w is None else planar * w[:, None], w, basis, about.exponents, about.coefficients, order)
    denominator = np.ones_like(values) if w is None else _power(w, basis, order)
    # twice the operations that a coefficient goes through: the expansion's, then a sum over the net for each order
    operations = 2.0 * (about.operations + order * (len(basis) + 8) + 8)
    value_size, gradient_size = about.magnitudes(radii)
    rounding, gradient_rounding = operations * EPSILON * value_size, operations * EPSILON * gradient_size
    excess = about.remainder(radii) * (1.0 + 1e-12) + rounding
    largest = np.abs(values) + excess * denominator

    # |grad g(x + z)| >= <a + H d + H z + ..., a> / |a|, linear in the offset d of x
    gradient, hessian = about.gradient, about.hessian
    steep = norm(gradient)
    direction = gradient / steep[:, None]
    bending = np.einsum("pij,pj->pi", hessian, direction)
    slope = np.zeros((len(basis), len(centre)))
    for axis in range(3):
        slope += bending[:, axis] * planar[:, axis]
    slope += steep
    linear = elevate_form(slope if w is None else slope * w, w, basis, order)
    reach = 1.5 * np.max(largest / linear, axis=0) + 1e-300
    loss = norm(bending) * reach + about.gradient_remainder(radii + reach[:, None])
    loss = loss * (1.0 + 1e-12) + gradient_rounding
    lower = linear - loss * denominator
    high = np.max(largest / lower, axis=0)
    high[~((lower > 0.0).all(axis=0) & (high <= reach))] = np.inf
    if exact.steepness > 0.0:
        high = np.fmin(high, np.max(largest / denominator, axis=0) / exact.steepness)
    noise = np.where(np.isfinite(high), 2.0 * rounding / np.maximum(steep - loss, exact.steepness), 0.0)
    low = _nearest_zero(about)
    return low, high * (1.0 + 16.0 * EPSILON), noise, np.abs(about.coefficients[0]) / steep


def _power(w: Float, basis: BernsteinBasis, order: int) -> Float:
    """Coefficients (N, P) of w^order from those of w, (n, P)."""
    ones = np.zeros((1, 3), dtype=np.int64)
    return compose(np.zeros((len(basis), 3, w.shape[1])), w, basis, ones, np.ones((1, w.shape[1])), order)


def elevate_form(net: Float, w: Float | None, basis: BernsteinBasis, order: int) -> Float:
    """Coefficients (N, P) of net (n, P) times w^(order - 1), in ``basis.power(order)``; w is 1 if None."""
    if order == 1:
        return net
    if w is None:
        table = elevation(basis, order)
        total = np.zeros((len(table), net.shape[1]))
        for column, values in zip(table.T, net, strict=True):
            (present,) = np.nonzero(column)
            total[present] += column[present, None] * values
        return total
    # a polynomial of degree 1 in one offset
    linear = np.array([[0, 0, 0], [1, 0, 0]], dtype=np.int64)
    offsets = np.zeros((len(basis), 3, net.shape[1]))
    offsets[:, 0] = net
    coefficients = np.stack([np.zeros(net.shape[1]), np.ones(net.shape[1])])
    return compose(offsets, w, basis, linear, coefficients, order)


def _nearest_zero(about: Expansion) -> Float:
    """Lower bounds (P,) of the distances of the centres to the level set.

    Along any way of length t from the centre s g, s the sign of g there, is at least |g| - |a| t + l t^2 / 2 - the
    remainder, l the smallest eigenvalue of s H.
    """
    value = about.coefficients[0]
    sign = np.where(value < 0.0, -1.0, 1.0)
    steep = norm(about.gradient)
    finite: Bool = np.asarray(np.isfinite(about.hessian).all(axis=(1, 2)))
    forms = np.where(finite[:, None, None], sign[:, None, None] * about.hessian, 0.0)
    bend = np.linalg.eigvalsh(forms)[:, 0]
    low = np.zeros(len(value))
    # each within a reach, in first-order distances: what holds near by is sharper
    for factor in REACHES:
        reach = np.where(steep > 0.0, factor * np.abs(value) / steep, 0.0)
        around = np.repeat(reach[:, None], 3, axis=1)
        value_size, gradient_size = about.magnitudes(around)
        left = about.gradient_remainder(around) * reach * (1.0 + 1e-12)
        # rounding of g, grad g and H, and of the eigenvalue
        rounding = 4.0 * (about.operations + 8) * EPSILON * (value_size + gradient_size * reach)
        known = np.maximum(np.abs(value) - left - rounding, 0.0)
        root = steep**2 - 2.0 * bend * known
        t = np.where(root >= 0.0, 2.0 * known / (steep + np.sqrt(np.maximum(root, 0.0))), np.inf)
        low = np.fmax(low, np.minimum(t, reach) * (1.0 - 16.0 * EPSILON))
    return np.where(finite, low, 0.0)


def _by_feet(exact: ExactSurface, points: Float, centre: Float) -> tuple[Float, Float, Float, Bool]:
    """Lower and upper bounds, their noise and whether they are crude (P,).

    From the foot of the centre, its normal and a bound of curvature.
    """
    foot = np.full(centre.shape, np.nan)
    known = np.isfinite(points).all(axis=(1, 2))
    foot[known] = exact.closest(centre[known])
    near = norm(centre - foot)
    # any foot bounds the distance from above: that of a corner where the centre has none
    missing = known & ~np.isfinite(foot).all(axis=1)
    if missing.any():
        foot[missing] = exact.closest(points[missing, 0])
    known = np.isfinite(foot).all(axis=1)
    scale = np.maximum(np.abs(points).max(axis=(1, 2)), np.abs(foot).max(axis=1))
    rounding = 64.0 * EPSILON * scale
    offsets = points - foot[:, None]
    length = norm(offsets)
    farthest = length.max(axis=1)
    high, crude = farthest.copy(), np.ones(len(centre), dtype=np.bool_)
    if known.any():
        normal = np.full(centre.shape, np.nan)
        normal[known] = exact.normal(foot[known])
        height = dot(offsets, normal[:, None])
        # not by Pythagoras: the difference of squares would lose digits
        sideways = norm(offsets - height[..., None] * normal[:, None]).max(axis=1)
        above = np.abs(height).max(axis=1) + rounding
        sideways = sideways * (1.0 + 64.0 * EPSILON) + rounding
        # the graph over the disc is within a ball of radius sqrt(2) r
        reach = 1.5 * sideways[known, None]
        curvature = np.full(len(centre), np.inf)
        box = foot[known] - reach, foot[known] + reach
        curvature[known] = np.where(exact.may_end(*box), np.inf, exact.curvature_bound(*box))
        bend = curvature * sideways
        inside = bend < 1.0
        sphere = np.where(inside, bend * sideways / (1.0 + np.sqrt(np.where(inside, 1.0 - bend**2, 0.0))), np.inf)
        curved = above + sphere * (1.0 + 64.0 * EPSILON)
        crude = ~(curved < high)
        high = np.fmin(high, curved)
    return near - rounding, high + rounding, 2.0 * rounding, crude
