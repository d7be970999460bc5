"""The plane with one smooth bump of bounded support: flat everywhere else, so that samples beside it show nothing."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.charted import Charts
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.level_bounds import EnclosedLevelSet, Expansion
from testbed.geometry.vectors import Float, Int
from testbed_datasets.quadric import falling_root

#: Rings of the bump between which feet are sought.
RINGS = 256
#: Most feet of a point on the bump that are looked at: a half circle's distance along it has no more minima.
FEET = 4
#: Points projected at once.
CHUNK = 2048
#: Exponents of the expansions to second order.
SECOND_ORDER = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0], [1, 1, 0], [0, 2, 0]])


@dataclass(frozen=True)
class BumpedPlane(EnclosedLevelSet):
    """The graph of b = height (1 - s)^4, s = |p - place|^2 / width^2, where s < 1, and of 0 elsewhere; normals upward.

    Three times continuously differentiable.

    Parameters
    ----------
    height
        Of the top; negative for a dent.
    width
        Radius of the foot.
    place
        (x, y) of the top.
    """

    height: float
    width: float
    place: tuple[float, float]
    steepness: ClassVar[float] = 1.0
    nearest: ClassVar[bool] = True

    def _powers(self, points: Float) -> tuple[Float, Float, Float]:
        """Offsets (N, 2) from the top over the width, s (N,), and 1 - s, which is 0 beside the bump."""
        offset = (points[:, :2] - np.array(self.place)) / self.width
        s = offset[:, 0] ** 2 + offset[:, 1] ** 2
        return offset, s, np.maximum(1.0 - s, 0.0)

    def over(self, plane: Float) -> Float:
        """Points of the surface (N, 3) over points of the plane (N, 2)."""
        return np.column_stack([plane, self.height * self._powers(plane)[2] ** 4])

    def slopes(self, points: Float) -> Float:
        """First derivatives (N, 2) of b."""
        offset, _, t = self._powers(points)
        slopes: Float = (-8.0 * self.height / self.width * t**3)[:, None] * offset
        return slopes

    def bending(self, points: Float) -> Float:
        """Second derivatives (N, 2, 2) of b."""
        offset, _, t = self._powers(points)
        factor = self.height / self.width**2
        outer = offset[:, :, None] * offset[:, None, :]
        second: Float = (48.0 * factor * t**2)[:, None, None] * outer - (8.0 * factor * t**3)[:, None, None] * np.eye(2)
        return second

    def gradient(self, points: Float) -> Float:
        """Gradients (-b_x, -b_y, 1) of z - b, (N, 3)."""
        return np.column_stack([-self.slopes(points), np.ones(len(points))])

    def hessian(self, points: Float) -> Float:
        """Second derivatives of z - b, (N, 3, 3)."""
        result = np.zeros((len(points), 3, 3))
        result[:, :2, :2] = -self.bending(points)
        return result

    def rings(self, low: Float, high: Float) -> tuple[Float, Float]:
        """Least and largest s (N,), (N,) over boxes with corners (N, 2 or 3), cut at 1."""
        low, high = low[:, :2] - np.array(self.place), high[:, :2] - np.array(self.place)
        nearest = np.maximum(np.maximum(low, -high), 0.0) / self.width
        farthest = np.maximum(np.abs(low), np.abs(high)) / self.width
        # widened by more than their rounding
        least = (nearest**2).sum(axis=1) * (1.0 - 1e-12)
        largest = (farthest**2).sum(axis=1) * (1.0 + 1e-12)
        return np.minimum(least, 1.0), np.minimum(largest, 1.0)

    def bending_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the norm of the second derivatives of b over boxes with corners (N, 2 or 3).

        Along circles 8 |height| (1 - s)^3 / width^2, across them (1 - s)^2 |1 - 7 s| for (1 - s)^3, which falls up to
        s = 1/7, rises up to 3/7 and falls.
        """
        least, largest = self.rings(low, high)
        across = np.maximum(_across(least), _across(largest))
        inside = (least < 3.0 / 7.0) & (largest > 3.0 / 7.0)
        across = np.where(inside, np.maximum(across, _across(np.array([3.0 / 7.0]))), across)
        factor = 8.0 * abs(self.height) / self.width**2 * (1.0 + 1e-12)
        bound: Float = factor * np.maximum((1.0 - least) ** 3, across)
        return bound

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the principal curvatures' moduli within boxes with corners (N, 3)."""
        return self.bending_bound(low, high)

    def expansion(self, points: Float, order: int) -> Expansion:
        """Expand z - b about points (N, 3) to second order."""
        del order
        first, second = -self.slopes(points), -self.bending(points)
        value = points[:, 2] - self.height * self._powers(points)[2] ** 4
        one = np.ones(len(points))
        quadratic = [0.5 * second[:, 0, 0], second[:, 0, 1], 0.5 * second[:, 1, 1]]
        return _BumpExpansion(self, points, np.stack([value, first[:, 0], first[:, 1], one, *quadratic]))

    def closest(self, points: Float) -> Float:
        """Nearest points, (N, 3): on the plane, or among the rings of the bump, one of them for points on its axis."""
        result = np.full(points.shape, np.nan)
        (known,) = np.nonzero(np.isfinite(points).all(axis=1))
        for start in range(0, len(known), CHUNK):
            some = known[start : start + CHUNK]
            result[some] = self._nearest(points[some])
        return result

    def _nearest(self, points: Float) -> Float:
        top = np.array(self.place)
        offset = points[:, :2] - top
        radius = np.hypot(offset[:, 0], offset[:, 1])
        outside = np.maximum(radius, self.width)
        feet, heights = outside.copy(), np.zeros(len(points))
        best = np.hypot(outside - radius, points[:, 2])
        # the bump is nowhere nearer than its foot is to the sides
        (near,) = np.nonzero(radius - self.width < np.abs(points[:, 2]))
        for ring in self._feet_on_bump(radius[near], points[near, 2]):
            height = self._profile(ring)[0]
            distance = np.hypot(ring - radius[near], height - points[near, 2])
            nearer = distance < best[near]  # false for NaN
            chosen = near[nearer]
            feet[chosen], heights[chosen], best[chosen] = ring[nearer], height[nearer], distance[nearer]
        with np.errstate(invalid="ignore", divide="ignore"):  # on the axis: any direction
            direction = np.where((radius > 0.0)[:, None], offset / radius[:, None], np.array([1.0, 0.0]))
        moved = top + feet[:, None] * direction
        # beside the bump a foot is straight below, to the last bit
        across = np.where((feet == radius)[:, None], points[:, :2], moved)
        return np.column_stack([across, heights])

    def _feet_on_bump(self, radius: Float, z: Float) -> list[Float]:
        """Radii (N,) of feet of points at radii (N,) and heights (N,): the top, and the minima between it and the rim.

        NaN for those there are not.
        """
        rings = np.linspace(0.0, self.width, RINGS + 1)
        height, slope, _ = self._profile(rings)
        rise = rings - radius[:, None] + (height - z[:, None]) * slope
        turns = (rise[:, :-1] < 0.0) & (rise[:, 1:] >= 0.0)
        count = np.cumsum(turns, axis=1)
        found = [np.zeros(len(radius))]
        for number in range(1, FEET + 1):
            turn = turns & (count == number)
            (rows,) = np.nonzero(turn.any(axis=1))
            if not len(rows):
                break
            at = turn[rows].argmax(axis=1)
            feet = np.full(len(radius), np.nan)
            feet[rows] = self._root(radius[rows], z[rows], rings[at], rings[at + 1])
            found.append(feet)
        return found

    def _root(self, radius: Float, z: Float, low: Float, high: Float) -> Float:
        def falling(r: Float, chosen: Int) -> tuple[Float, Float, Float]:
            height, slope, second = self._profile(r)
            above = height - z[chosen]
            value = r - radius[chosen] + above * slope
            size = r + radius[chosen] + (np.abs(height) + np.abs(z[chosen])) * np.abs(slope)
            return -value, -(1.0 + slope**2 + above * second), size

        with np.errstate(divide="ignore", invalid="ignore"):  # a step without a slope is not taken
            return falling_root(falling, low, high, 0.5 * (low + high))

    def _profile(self, r: Float) -> tuple[Float, Float, Float]:
        """Heights b at radii (...) and their first two derivatives."""
        rho = r / self.width
        t = np.maximum(1.0 - rho**2, 0.0)
        h, w = self.height, self.width
        return h * t**4, -8.0 * h / w * rho * t**3, 8.0 * h / w**2 * t**2 * (7.0 * rho**2 - 1.0)


def _across(s: Float) -> Float:
    values: Float = (1.0 - s) ** 2 * np.abs(1.0 - 7.0 * s)
    return values


class _BumpExpansion(Expansion):
    """Second-order expansions of z - b, with bounds of its third derivatives."""

    exponents = SECOND_ORDER
    operations = 32

    def __init__(self, surface: BumpedPlane, points: Float, coefficients: Float) -> None:
        self.coefficients = coefficients
        self._surface = surface
        self._points = points

    def _third(self, radii: Float) -> Float:
        """Bounds (N,) of the third derivatives of b over boxes.

        Along a unit vector at angle a to the radius the third derivative is height / width^3 times
        (1 - s) x (144 (1 - s) - 192 x^2), x = cos a sqrt(s).
        """
        least, largest = self._surface.rings(self._points - radii, self._points + radii)
        scale = abs(self._surface.height) / self._surface.width**3
        bound: Float = np.maximum(192.0 * largest, 144.0 * (1.0 - least))
        return bound * ((1.0 - least) * np.sqrt(largest)) * (scale * (1.0 + 1e-12))

    def remainder(self, radii: Float) -> Float:
        """Taylor's bound; or where the point is beside the bump and all coefficients are those of the plane, b."""
        reach = np.hypot(radii[:, 0], radii[:, 1])
        taylor = self._third(radii) * reach**3 / 6.0
        least, _ = self._surface.rings(self._points - radii, self._points + radii)
        beside = self._surface.rings(self._points, self._points)[0] >= 1.0
        highest = abs(self._surface.height) * (1.0 - least) ** 4 * (1.0 + 1e-12)
        bound: Float = np.where(beside, np.minimum(taylor, highest), taylor)
        return bound

    def gradient_remainder(self, radii: Float) -> Float:
        """Taylor's bound."""
        bound: Float = 0.5 * self._third(radii) * np.hypot(radii[:, 0], radii[:, 1]) ** 2
        return bound

    def magnitudes(self, radii: Float) -> tuple[Float, Float]:
        """Size of z, and of b and its first derivatives where a box meets the bump."""
        least, _ = self._surface.rings(self._points - radii, self._points + radii)
        high = np.where(least < 1.0, 64.0 * abs(self._surface.height), 0.0)
        wide = 1.0 + np.hypot(radii[:, 0], radii[:, 1]) / self._surface.width
        z = np.abs(self._points[:, 2]) + radii[:, 2]
        return z + high * wide**2, 1.0 + high / self._surface.width * wide


@dataclass(frozen=True)
class BumpChart(Charts):
    """The one chart (x, y, b) over the square [-1, 1]^2."""

    surface: BumpedPlane

    def __len__(self) -> int:
        return 1

    def polygon(self, chart: int) -> Float:
        """The square's corners."""
        del chart
        return np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        """Jets at (x, y) (N, 2)."""
        del chart
        rows = np.zeros((ROWS[order], len(at), 3))
        rows[0] = self.surface.over(at)
        if order >= 1:
            slopes = self.surface.slopes(at)
            rows[1, :, 0] = rows[2, :, 1] = 1.0
            rows[1, :, 2], rows[2, :, 2] = slopes.T
        if order == 2:
            second = self.surface.bending(at)
            rows[3, :, 2], rows[4, :, 2], rows[5, :, 2] = second[:, 0, 0], second[:, 0, 1], second[:, 1, 1]
        return Jet(rows)
