"""Heights over the plane: flat ground with smooth bumps that do not meet, and random heights without a surface."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.level_bounds import EnclosedLevelSet, Expansion
from testbed.geometry.vectors import Float, norm
from testbed_datasets.bumped_plane import SECOND_ORDER, BumpedPlane

#: Width of the peak.
PEAK = 0.5
#: Most showers of a rainfall, least and most radius, and height over radius; tries to place one beside the others.
SHOWERS, RADII, RAIN, TRIES = 6, (0.15, 0.35), (0.6, 2.0), 200
#: The generators of places and heights are apart from that of the sites.
STREAM_OF_BUMPS, STREAM_OF_HEIGHTS = 1, 2
#: By how much the middle of an edge differs from the mean of its ends, relatively, on the first step of a refinement.
ROUGHNESS = 0.5


@dataclass(frozen=True)
class BumpField(EnclosedLevelSet):
    """The graph of ground + the sum of bumps (see :class:`BumpedPlane`) of disjoint supports, normals upward.

    Three times continuously differentiable, and flat beside the bumps.

    Parameters
    ----------
    bumps
        Bumps of positive height on the plane z = 0; no two supports overlap.
    ground
        Height of the ground.
    """

    bumps: tuple[BumpedPlane, ...]
    ground: float
    steepness: ClassVar[float] = 1.0
    nearest: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for number, one in enumerate(self.bumps):
            if not one.height > 0.0:
                raise ValueError(f"bump {number} has the height {one.height}: give positive heights")
            for other in self.bumps[:number]:
                (x, y), (a, b) = one.place, other.place
                if np.hypot(x - a, y - b) < one.width + other.width:
                    raise ValueError(f"bump {number} at ({x}, {y}) overlaps that at ({a}, {b}): move one")

    def _on_ground(self, points: Float) -> Float:
        """Points (N, 3) with heights above the ground."""
        above: Float = points - np.array([0.0, 0.0, self.ground])
        return above

    def height(self, plane: Float) -> Float:
        """Heights (N,) over points of the plane (N, 2)."""
        total = np.full(len(plane), self.ground)
        for bump in self.bumps:
            total += bump.over(plane)[:, 2]
        return total

    def over(self, plane: Float) -> Float:
        """Points of the surface (N, 3) over points of the plane (N, 2)."""
        return np.column_stack([plane, self.height(plane)])

    def slopes(self, points: Float) -> Float:
        """First derivatives (N, 2) of the heights at points (N, 2 or 3)."""
        total = np.zeros((len(points), 2))
        for bump in self.bumps:
            total += bump.slopes(points)
        return total

    def bending(self, points: Float) -> Float:
        """Second derivatives (N, 2, 2) of the heights at points (N, 2 or 3)."""
        total = np.zeros((len(points), 2, 2))
        for bump in self.bumps:
            total += bump.bending(points)
        return total

    def gradient(self, points: Float) -> Float:
        """Gradients (-f_x, -f_y, 1) of z - f, (N, 3)."""
        # adding zero: on flat ground 0, not -0
        return np.column_stack([0.0 - self.slopes(points), np.ones(len(points))])

    def hessian(self, points: Float) -> Float:
        """Second derivatives of z - f, (N, 3, 3)."""
        result = np.zeros((len(points), 3, 3))
        result[:, :2, :2] = 0.0 - self.bending(points)
        return result

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the principal curvatures' moduli within boxes with corners (N, 3)."""
        bound = np.zeros(len(low))
        for bump in self.bumps:
            bound = np.maximum(bound, bump.bending_bound(low, high))
        return bound

    def expansion(self, points: Float, order: int) -> Expansion:
        """Expand z - f about points (N, 3) to second order: the sum of the bumps' expansions."""
        above = self._on_ground(points)
        plane = np.zeros((len(SECOND_ORDER), len(points)))
        plane[0], plane[3] = above[:, 2], 1.0
        return _SummedExpansion(plane, tuple(bump.expansion(above, order) for bump in self.bumps), above)

    def closest(self, points: Float) -> Float:
        """Nearest points, (N, 3); one of them for points on the axes of bumps, NaN for points that are not finite.

        Each bump by itself knows the nearest points of its own plane. Where that foot is on the bump, it is a point of
        this surface; straight below a point beside all bumps is another. The nearest of these is the nearest of all:
        what a foot in the flat part of its own plane hides, farther on the bump, is no nearer than the surface over
        the support that the foot is in, or than its rim.
        """
        above = self._on_ground(points)
        feet = np.column_stack([above[:, :2], np.zeros(len(above))])
        radius = [np.hypot(above[:, 0] - bump.place[0], above[:, 1] - bump.place[1]) for bump in self.bumps]
        feet[~np.isfinite(above).all(axis=1)] = np.nan
        best = np.abs(above[:, 2])
        # first the bump that a point is over: the others are then seldom near enough
        for bump, away in zip(self.bumps, radius, strict=True):
            (over,) = np.nonzero(away < bump.width)
            feet[over] = bump.closest(above[over])
            best[over] = norm(above[over] - feet[over])
        for bump, away in zip(self.bumps, radius, strict=True):
            with np.errstate(invalid="ignore"):  # points that are not finite: false
                (near,) = np.nonzero((away >= bump.width) & (away - bump.width < best))
            other = bump.closest(above[near])
            distance = norm(above[near] - other)
            nearer = (distance < best[near]) & (other[:, 2] > 0.0)
            feet[near[nearer]], best[near[nearer]] = other[nearer], distance[nearer]
        feet[:, 2] += self.ground
        return feet


class _SummedExpansion(Expansion):
    """Second-order expansions of z - f, from those of z - b for the bumps b."""

    exponents = SECOND_ORDER

    def __init__(self, plane: Float, parts: tuple[Expansion, ...], points: Float) -> None:
        self.coefficients = plane + sum((part.coefficients - plane for part in parts), np.zeros_like(plane))
        self.operations = sum(part.operations + 2 for part in parts) + 2
        self._parts = parts
        self._height = np.abs(points[:, 2])

    def remainder(self, radii: Float) -> Float:
        """Sum of the bumps' bounds."""
        return sum((part.remainder(radii) for part in self._parts), np.zeros(len(radii)))

    def gradient_remainder(self, radii: Float) -> Float:
        """Sum of the bumps' bounds."""
        return sum((part.gradient_remainder(radii) for part in self._parts), np.zeros(len(radii)))

    def magnitudes(self, radii: Float) -> tuple[Float, Float]:
        """Sums of the bumps' sizes, and those of the plane."""
        value, gradient = self._height + radii[:, 2], np.ones(len(radii))
        for part in self._parts:
            of_value, of_gradient = part.magnitudes(radii)
            value, gradient = value + of_value, gradient + of_gradient
        return value, gradient


def random_heights(seed: int, count: int, height: float, ground: float) -> Float:
    """Independent heights (N,) up to ``height`` above the ground, most of them low: fourth powers of uniform ones."""
    heights: Float = ground + height * np.random.default_rng([seed, STREAM_OF_HEIGHTS]).uniform(size=count) ** 4
    return heights


def rough_middles(seed: int, step: int, start: Float, end: Float, ground: float) -> Float:
    """Middles (E, 3) of edges between points (E, 3): above the ground their means, by random parts more or less.

    The parts are at most ``ROUGHNESS``, and half of that on each further step, so that slopes remain of one size.
    """
    random = np.random.default_rng([seed, STREAM_OF_HEIGHTS, step]).uniform(-1.0, 1.0, len(start))
    middle: Float = 0.5 * (start + end)
    middle[:, 2] += (middle[:, 2] - ground) * (ROUGHNESS * 0.5**step) * random
    return middle


def peak(seed: int, height: float, ground: float) -> BumpField:
    """Return flat ground with one peak, its top near the middle of the unit square."""
    x, y = np.random.default_rng([seed, STREAM_OF_BUMPS]).uniform(0.35, 0.65, 2).tolist()
    return BumpField((BumpedPlane(height, PEAK, (x, y)),), ground)


def rainfall(seed: int, height: float, ground: float) -> BumpField:
    """Return showers over dry ground: up to ``SHOWERS`` bumps about places of the unit square.

    Each next one is made smaller to fit beside those before; their heights are ``height`` times ``RAIN`` of radii.
    """
    random = np.random.default_rng([seed, STREAM_OF_BUMPS])
    draws = random.uniform(size=(TRIES, 4))
    bumps: list[BumpedPlane] = []
    for x, y, size, amount in draws.tolist():
        room = min((np.hypot(x - one.place[0], y - one.place[1]) - one.width for one in bumps), default=np.inf)
        width = min(RADII[0] + size * (RADII[1] - RADII[0]), 0.999 * float(room))
        if width >= RADII[0] and len(bumps) < SHOWERS:
            steepness = height * (RAIN[0] + amount * (RAIN[1] - RAIN[0]))
            bumps.append(BumpedPlane(steepness * width, width, (x, y)))
    return BumpField(tuple(bumps), ground)
