"""Quadrics about the origin with their axes along the coordinate axes: exact closest points by one scalar root."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Float, Int, dot, norm

#: Enough for bisection alone to come from one to the smallest double.
MOST_STEPS = 1100
#: Coordinates below this count as zero, for the smallest doubles have few digits.
NEGLIGIBLE = 1e-280
#: A sum is zero to rounding where it is below this times the size of its terms.
ROUNDING = 4.0 * np.finfo(np.float64).eps


@dataclass(frozen=True)
class Quadric(PolynomialLevelSet):
    """The surface sum_i signs_i (x_i / axes_i)^2 = 1, normals along the gradient.

    Parameters
    ----------
    axes
        Semi-axes.
    signs
        +1 or -1 each, at least one +1: (1, 1, 1) is an ellipsoid, (1, 1, -1) a hyperboloid of one sheet about z.
    """

    axes: tuple[float, float, float]
    signs: tuple[int, int, int] = (1, 1, 1)
    nearest: ClassVar[bool] = True

    @property
    def _q(self) -> Float:
        q: Float = np.array(self.signs) / np.square(np.array(self.axes))
        return q

    @cached_property
    def polynomial(self) -> Trivariate:
        """The polynomial sum_i q_i x_i^2 - 1."""
        x, y, z = self._q.tolist()
        return Trivariate((((2, 0, 0), x), ((0, 2, 0), y), ((0, 0, 2), z), ((0, 0, 0), -1.0)))

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the principal curvatures' moduli within boxes with corners (N, 3).

        max |q_i| / |Q x|, and |Q x| >= sqrt(q) for the smallest positive q: on the quadric the terms q_i x_i^2 with
        positive q_i are at least 1 together.
        """
        q = self._q
        nearest = np.maximum(np.maximum(low, -high), 0.0)
        steep = np.maximum(norm(q * nearest), np.sqrt(q[q > 0.0].min()))
        bound: Float = (1.0 + 32.0 * np.finfo(np.float64).eps) * np.abs(q).max() / steep
        return bound

    def gradient(self, points: Float) -> Float:
        """Gradients 2 q_i x_i, (N, 3)."""
        return 2.0 * self._q * points

    def hessian(self, points: Float) -> Float:
        """The constant matrix 2 diag(q), (N, 3, 3)."""
        return np.broadcast_to(np.diag(2.0 * self._q), (len(points), 3, 3))

    def closest(self, points: Float) -> Float:
        """Nearest points of the whole quadric, (N, 3).

        With x_i = p_i / D_i, D_i = 1 + q_i t, the perpendicular at x runs through p, and x is the nearest point if all
        D_i >= 0. There g(t) = sum q_i x_i^2 - 1 falls strictly, so the root is unique. Where there is none, p lies on a
        plane of symmetry and two feet, or a circle of them, are equally near: of these, one on the first axis' positive
        side (negative for a coordinate -0.0). NaN for coordinates that are not finite, or overflow when squared.
        """
        feet = np.full(points.shape, np.nan)
        with np.errstate(all="ignore"):  # overflow of far points: NaN, as promised; 0/0 is seen to
            known = np.flatnonzero(np.isfinite(points).all(axis=1))
            p = points[known]
            p = np.where(np.abs(p) < NEGLIGIBLE, 0.0 * p, p)
            rises = dot(self._q * p, p) > 1.0  # g(0) > 0: the root is to the right of 0
            for side in (rises, ~rises):
                if side.any():
                    feet[known[side]] = self._one_sided(p[side], upward=bool(side is rises))
        return feet

    def _one_sided(self, p: Float, *, upward: bool) -> Float:
        """Feet of points whose root lies on one side of t = 0, towards the nearest pole there, where one D_i is zero.

        The nearer half of the way is measured from 0, the farther from the pole, D = offset + q s in both: so every D
        keeps its relative accuracy, however near to the pole the root is.
        """
        q = self._q
        offset = np.ones_like(p)
        towards = q < 0.0 if upward else q > 0.0
        if towards.any():
            pole = np.flatnonzero(towards)[np.argmin(np.square(self.axes)[towards])]
            half = -0.5 / q[pole]
            at_half = dot(q * p, p / (1.0 + q * half) ** 2) - 1.0
            far = at_half > 0.0 if upward else at_half < 0.0
            offset[far] = (q[pole] - q) / q[pole]
            # the terms against the pole's are bounded, for their D_i >= 1 on this side; where the pole's term alone
            # outweighs them, g has the pole's sign
            against = np.sum(np.where(q * q[pole] < 0.0, np.abs(q), 0.0) * p**2, axis=1)
            outweighed = np.maximum(against - 1.0, 1.0) if upward else against + 1.0
            end = np.abs(p[:, pole]) * np.sqrt(np.abs(q[pole]) / outweighed) / q[pole]
            start = np.where(far, -half, 0.0)
            end = np.where(far, end, half)
        else:  # no pole on this side: an ellipsoid seen from outside, where g <= (|p|_q / (1 + t min q))^2 - 1
            start, end = np.zeros(len(p)), (np.sqrt(dot(q * p, p)) - 1.0) / q.min()
        low, high = (start, end) if upward else (end, start)

        def excess(s: Float, chosen: Int) -> tuple[Float, Float, Float]:
            D = offset[chosen] + q * s[:, None]
            x = np.where(p[chosen] == 0.0, 0.0, p[chosen] / D)
            slope = -2.0 * np.sum(np.where(x == 0.0, 0.0, (q * x) ** 2 / D), axis=1)
            return dot(q * x, x) - 1.0, slope, 1.0 + dot(np.abs(q) * x, x)

        s = falling_root(excess, low, high, start)
        x = np.where(p == 0.0, 0.0, p / (offset + q * s[:, None]))
        x[np.isnan(s)] = np.nan
        if towards.any():
            # at the pole itself x_pole is free, and takes what the other terms leave
            split = np.flatnonzero(np.isnan(s) & far & (p[:, q == q[pole]] == 0.0).all(axis=1))
            x[split] = np.where(p[split] == 0.0, 0.0, p[split] / offset[split])
            free = np.sqrt((1.0 - dot(q * x[split], x[split])) / q[pole])
            x[split, pole] = np.copysign(free, p[split, pole])
        # the root's rounding moves x along the gradient; one Newton step puts it back on the surface
        gradient = q * x
        foot: Float = x - gradient * ((dot(gradient, x) - 1.0) / (2.0 * dot(gradient, gradient)))[:, None]
        return foot


def falling_root(
    function: Callable[[Float, Int], tuple[Float, Float, Float]], low: Float, high: Float, start: Float
) -> Float:
    """Roots of N falling functions by Newton's method, kept inside brackets by bisection.

    Parameters
    ----------
    function
        Called with arguments (A,) and the indices (A,) they belong to; returns values, derivatives and the sizes of
        what was summed, against which the values' rounding is judged.
    low, high
        (N,) brackets.
    start
        (N,) where Newton's method starts, in the brackets.

    Returns
    -------
    Float
        (N,) roots to rounding; NaN where the values at the ends of the bracket do not differ in sign.
    """
    everyone = np.arange(len(start))
    (at_low, _, low_size), (at_high, _, high_size) = function(low, everyone), function(high, everyone)
    root = np.where((at_low >= -ROUNDING * low_size) & (at_high <= ROUNDING * high_size), start, np.nan)
    active = np.flatnonzero(~np.isnan(root))
    low, high = low.copy(), high.copy()
    for _ in range(MOST_STEPS):
        s = root[active]
        value, slope, size = function(s, active)
        open_ = np.abs(value) > ROUNDING * size
        active, s, value, slope = active[open_], s[open_], value[open_], slope[open_]
        if not len(active):
            return root
        low[active] = np.where(value > 0.0, s, low[active])
        high[active] = np.where(value < 0.0, s, high[active])
        newton = s - value / slope
        inside = (newton > low[active]) & (newton < high[active])
        root[active] = np.where(inside, newton, 0.5 * (low[active] + high[active]))
        active = active[root[active] != s]  # a bracket of two neighbouring numbers is closed
    root[active] = np.nan
    return root
