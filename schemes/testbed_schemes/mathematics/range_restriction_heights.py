"""When second rows of two adjoining quartics exist that stay above their bounds (Si 2015, chapter 4, supplement).

Distances from a plane, "heights" here, are affine, so the conditions on control points that join two quartics G1 with
linear coefficients (:mod:`testbed_schemes.mathematics.linear_g1`) hold for their heights as well. With w the height of
the free vector w1, the second rows have the heights

    p1 = R1 + beta0 w,   q1 = R1 - alpha0 w,   p2 = R3 + beta1 (kappa w + R4),   q2 = R3 - alpha1 (kappa w + R4).

Each is to be at least -r, r that of its own patch: four bounds on w, which leave an interval or nothing. That it is
not empty restricts the boundary curve, as R1 and R3 depend on it; bounds on the control points alone do not suffice.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int


@dataclass(frozen=True, eq=False)
class EdgeHeights:
    """Heights of what is given at both ends of interior edges; arrays (E, 2): at the start, at the end.

    Parameters
    ----------
    vertex
        Of the vertices.
    leg
        Of the boundary's first legs, c1 - c0 and c3 - c4.
    across
        Of the legs on the left less those on the right.
    alpha, gamma
        The coefficients at both ends, alpha + beta = 1.
    bounds
        How far below the plane control points may be: in the left patch, in the right patch.
    """

    vertex: Float
    leg: Float
    across: Float
    alpha: Float
    gamma: Float
    bounds: Float

    def __getitem__(self, chosen: Int | Bool) -> "EdgeHeights":
        """Return the chosen edges."""
        return self._each(lambda values: values[chosen])

    def for_many(self) -> "EdgeHeights":
        """Return the same with an axis more, for several kappas (k,) or (E, k) an edge."""
        return self._each(lambda values: values[:, :, None])

    def _each(self, change: Callable[[Float], Float]) -> "EdgeHeights":
        values = (self.vertex, self.leg, self.across, self.alpha, self.gamma, self.bounds)
        return EdgeHeights(*(change(value) for value in values))

    def scaled(self, factors: Float) -> "EdgeHeights":
        """Return the same with all legs at both ends multiplied by factors (E, 2): alpha and gamma stay."""
        return EdgeHeights(self.vertex, factors * self.leg, factors * self.across, self.alpha, self.gamma, self.bounds)

    def middle(self, kappa: Float) -> Float:
        """Height of the boundary's control point c2."""
        (first, last), (leg0, leg1) = self._outer(), self._legs()
        return (3.0 * kappa * last + 3.0 * kappa**2 * first + leg1 + kappa**3 * leg0) / (3.0 * kappa * (1.0 + kappa))

    def _legs(self) -> tuple[Float, Float]:
        return self.leg[:, 0], self.leg[:, 1]

    def _outer(self) -> tuple[Float, Float]:
        """Heights of c1 and c3."""
        return self.vertex[:, 0] + self.leg[:, 0], self.vertex[:, 1] + self.leg[:, 1]

    def means(self, kappa: Float) -> tuple[Float, Float, Float]:
        """Heights of R1, R3 and R4."""
        (first, last), (leg0, leg1), middle = self._outer(), self._legs(), self.middle(kappa)
        turn, change = self.alpha[:, 1] - self.alpha[:, 0], self.gamma[:, 1] - self.gamma[:, 0]
        across0, across1 = self.across[:, 0], self.across[:, 1]
        R1 = first - self.gamma[:, 0] * (middle - first) - kappa / 3.0 * (turn * across0 + change * leg0)
        R3 = middle - self.gamma[:, 1] * (last - middle) + (turn * across1 - change * leg1) / (3.0 * kappa)
        return R1, R3, across1 / (3.0 * kappa) - kappa**2 * across0 / 3.0

    def interval(self, kappa: Float) -> tuple[Float, Float]:
        """Return the least and the greatest admissible height w of w1; the interval is empty where least > greatest.

        Empty too where the boundary's middle control point lies below the bound of either patch.
        """
        R1, R3, R4 = self.means(kappa)
        alpha0, alpha1 = self.alpha[:, 0], self.alpha[:, 1]
        left, right = self.bounds[:, 0], self.bounds[:, 1]
        least, greatest = np.full(np.shape(R1), -np.inf), np.full(np.shape(R1), np.inf)
        for slope, height, bound in (
            (1.0 - alpha0, R1, left),
            (-alpha0, R1, right),
            (kappa * (1.0 - alpha1), R3 + (1.0 - alpha1) * R4, left),
            (-kappa * alpha1, R3 - alpha1 * R4, right),
        ):
            # slope * w + height >= -bound; without slope it holds for all w or for none
            with np.errstate(divide="ignore", invalid="ignore"):
                limit = -(bound + height) / slope
            least = np.where(slope > 0.0, np.maximum(least, limit), least)
            greatest = np.where(slope < 0.0, np.minimum(greatest, limit), greatest)
            greatest = np.where((slope == 0.0) & ~(height >= -bound), -np.inf, greatest)
        greatest = np.where(self.middle(kappa) >= -np.minimum(left, right), greatest, -np.inf)
        return least, greatest

    def admissible(self, kappa: Float) -> Bool:
        """Tell whether second rows exist that stay above their bounds."""
        least, greatest = self.interval(kappa)
        possible: Bool = np.less_equal(least, greatest)
        return possible

    def width(self, kappa: Float) -> Float:
        """Return the width of the interval times the root of kappa, which is the same for the reversed edge.

        -1 where the interval is empty.
        """
        least, greatest = self.interval(kappa)
        with np.errstate(invalid="ignore"):  # both infinite
            return np.where(least <= greatest, (greatest - least) * np.sqrt(kappa), -1.0)
