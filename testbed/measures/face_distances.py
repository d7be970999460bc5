"""Guaranteed bounds of the largest distance of each mesh face's patches to the exact surface, by branch and bound.

Patches are quartered where their bounds do not suffice, all at once, round by round. What is between sample points is
not missed: the bounds are of whole patches (:mod:`testbed.geometry.distance_bounds`).
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.composition import BernsteinBasis, quartering
from testbed.geometry.distance_bounds import PatchNets, distance_bounds
from testbed.geometry.evaluation import apply_table
from testbed.geometry.exact import ExactSurface
from testbed.geometry.level_bounds import EPSILON, EnclosedLevelSet
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int

#: Most times that a patch is quartered.
ROUNDS = 16
#: Most pieces whose bounds are computed: so many for each patch, and so many in any case.
PIECES_A_PATCH = 64
#: Likewise for faces on a surface that is no level set, where bounds gain less from smaller pieces. Each needs a foot,
#: and yet fewer cost more: faces whose bounds stay loose are split for nothing (an offset to 1e-3: 6378 faces in 12 s
#: with 8 pieces a patch, 129 in 12 s with 256).
PIECES_WITH_FEET_A_PATCH = 256
PIECES_WITH_FEET = 100_000
PIECES = 20_000
#: Bounds that are but the size of pieces are good for something if they are at most this many times what was aimed at.
USEFUL = 2.0
#: Bounds this many times closer than what rounding makes of their difference are not asked for.
NOISE = 2.0


@dataclass(frozen=True, eq=False)
class FaceDistances:
    """Bounds of the largest distance of the patches of each mesh face to the exact surface.

    Parameters
    ----------
    low, high
        (F,) bounds, 0 for faces without patches. ``high`` is guaranteed, and infinite where there is no useful
        guarantee: for patches that are neither polynomial nor rational, whose weights are not positive or that are not
        finite; and where only the size of the pieces bounds the distance, near the boundary of a surface or on one
        whose curvature is not known, if that is far above what was asked for. ``low`` is guaranteed for level sets with
        expansions; for other surfaces it is as good as their ``closest``.
    """

    low: Float
    high: Float

    @property
    def certified(self) -> bool:
        """Whether every face has a bound."""
        return bool(np.isfinite(self.high).all())


def face_distances(
    surface: Surface, exact: ExactSurface, tolerance: float, *, threshold: float | None = None
) -> FaceDistances:
    """Bound the largest distance of the patches of every mesh face to the exact surface.

    Parameters
    ----------
    tolerance
        A length: bounds are refined until no face's differ by more, as far as the limits on work and rounding allow.
    threshold
        A face is also left alone once its upper bound is at most this length, or its lower bound above it: enough to
        tell which faces are nearer than that. None for the tolerance everywhere.
    """
    faces = len(surface.mesh.faces)
    aim = Aim(tolerance, 0.0, threshold)
    low, high = np.zeros((2, faces))
    for batch, group in zip(surface.batches, (part.faces for part in surface.parts), strict=True):
        pieces = max(PIECES_WITH_FEET, PIECES_WITH_FEET_A_PATCH * len(batch))
        if isinstance(exact, EnclosedLevelSet):
            pieces = max(PIECES, PIECES_A_PATCH * len(batch))
        part_low, part_high = bounds_by_group(exact, batch, group, faces, aim, low, pieces)
        low, high = np.maximum(low, part_low), np.maximum(high, part_high)
    return FaceDistances(low, high)


@dataclass(frozen=True)
class Aim:
    """How close bounds have to come.

    Parameters
    ----------
    tolerance
        Largest difference of the bounds, a length.
    ratio
        Or the upper bound at most 1 + ratio times the lower.
    threshold
        Or both on one side of this length, if it is not None.
    """

    tolerance: float
    ratio: float = 0.0
    threshold: float | None = None

    def ceiling(self, low: Float) -> Float:
        """Upper bounds (N,) that are good enough for pieces of a group whose largest distance is at least ``low``."""
        enough: Float = np.maximum(low + self.tolerance, low * (1.0 + self.ratio))
        if self.threshold is not None:
            enough = np.where(low > self.threshold, np.inf, np.maximum(enough, self.threshold))
        return enough


def nets_of(batch: PatchBatch) -> PatchNets | None:
    """Return the control points of polynomial and rational patches, or None for others."""
    if isinstance(batch, RationalBezierTriangles):
        return PatchNets(BernsteinBasis((batch.degree,)), batch.homogeneous, _slack(batch.control_points))
    if isinstance(batch, BezierTriangles):
        return PatchNets(BernsteinBasis((batch.degree,)), batch.control_points, np.zeros(len(batch)))
    if isinstance(batch, BezierQuads):
        points = batch.control_points.reshape(len(batch), -1, 3)
        return PatchNets(BernsteinBasis(batch.degree), points, np.zeros(len(batch)))
    return None


def _slack(points: Float) -> Float:
    """Rounding (P,) of homogeneous coordinates."""
    largest: Float = np.abs(points).max(axis=(1, 2))
    return 4.0 * EPSILON * largest


def bounds_by_group(
    exact: ExactSurface, batch: PatchBatch, group: Int, groups: int, aim: Aim, known: Float, pieces: int
) -> tuple[Float, Float]:
    """Bound the largest distances of groups of patches.

    Parameters
    ----------
    group
        (P,) the group each patch is in, 0 to ``groups - 1``.
    known
        (G,) distances that the groups are known or supposed to reach elsewhere: no work is done on pieces that are
        nearer. The upper bounds hold whether or not this is so.
    pieces
        Most pieces of patches whose bounds are computed, if there are not more patches.

    Returns
    -------
    low, high
        (G,) bounds; 0 for groups without patches.
    """
    low, high = np.zeros((2, groups))
    nets = nets_of(batch)
    if nets is None:
        np.maximum.at(high, group, np.inf)
        return low, high
    known = known.copy()
    left = pieces
    for round_ in range(ROUNDS + 1):
        bounds = distance_bounds(exact, nets)
        left -= len(nets)
        np.maximum.at(low, group, bounds.low)
        np.maximum.at(known, group, bounds.seen)
        room = aim.ceiling(known[group]) + NOISE * bounds.noise
        wide = ~(bounds.high <= room)
        open_ = wide & np.isfinite(nets.points).all(axis=(1, 2)) & (round_ < ROUNDS)
        # where not all can be quartered, those that stand out most
        if 4 * np.count_nonzero(open_) > left:
            worst = np.argsort(np.where(open_, room - bounds.high, np.inf), kind="stable")[: max(left // 4, 0)]
            open_[np.setdiff1d(np.arange(len(open_)), worst)] = False
        useless = wide & bounds.crude & ~(bounds.high <= USEFUL * room)
        np.maximum.at(high, group[~open_], np.where(useless, np.inf, bounds.high)[~open_])
        if not open_.any():
            break
        nets, group = quartered(nets.take(open_)), np.repeat(group[open_], 4)
    return low, high


def quartered(nets: PatchNets) -> PatchNets:
    """Quarters of all patches, those of a patch in a row, (4 P, n, dim)."""
    quarters = apply_table(quartering(nets.basis), nets.points)
    count, size = len(nets), len(nets.basis)
    points = np.ascontiguousarray(quarters.transpose(1, 0, 2, 3)).reshape(4 * count, size, nets.points.shape[2])
    # the sums of the table's product round
    slack = nets.slack + 2.0 * size * EPSILON * np.abs(nets.points).max(axis=(1, 2))
    return PatchNets(nets.basis, points, np.repeat(slack, 4))


def largest_distance(
    surface: Surface, exact: ExactSurface, aim: Aim, farthest: Float | None = None, pieces: int = PIECES
) -> tuple[float, float]:
    """Bound the largest distance of a whole surface to the exact one.

    Parameters
    ----------
    farthest
        A point (3,) of the surface, to rounding, that is as far away as any that is known: no work is done on what is
        nearer. None if there is none.
    pieces
        Most pieces of the patches of each part whose bounds are computed.
    """
    low, high, supposed = 0.0, 0.0, 0.0
    if farthest is not None:
        # a patch of degree 0; evaluation rounds
        slack = 64.0 * EPSILON * np.abs(farthest).max(keepdims=True)
        there = distance_bounds(exact, PatchNets(BernsteinBasis((0,)), farthest[None, None], slack))
        low, supposed = float(there.low[0]), float(there.seen[0])
    for batch in surface.batches:
        known = np.array([max(low, supposed)])
        group = np.zeros(len(batch), dtype=np.int64)
        one_low, one_high = bounds_by_group(exact, batch, group, 1, aim, known, pieces)
        low, high = float(np.maximum(low, one_low[0])), float(np.maximum(high, one_high[0]))
    return low, high
