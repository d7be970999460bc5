"""Polynomial graphs z = f(x, y): normals, second forms and closest points."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Bool, Float, Int, norm

#: Newton's method takes about five steps from a point near the surface, many along steep valleys far outside the mesh.
MOST_STEPS = 200
#: After a Newton step below this, relative to the coordinates, the next error is below rounding.
LAST_STEP = 1e-9
#: A Hessian is relied on if the ratio of its eigenvalues is above the first; else no eigenvalue's modulus is taken for
#: less than the second times the other's.
UNRELIABLE, SINGULAR = 1e-12, 1e-6
#: Points projected at once, so that all that belongs to them stays in the processor's cache.
CHUNK = 4096

#: A polynomial's values and derivatives f, f_x, f_y, f_xx, f_xy, f_yy.
HeightJet = tuple[Float, Float, Float, Float, Float, Float]


@dataclass(frozen=True)
class HeightField(PolynomialLevelSet):
    """The graph of a polynomial over the whole plane, normals upward.

    Parameters
    ----------
    coefficients
        Row i, column j holds the coefficient of x^i y^j; rows may be ragged.
    reach
        The part of interest lies over |x|, |y| <= reach; beyond it high powers rise steeply.
    """

    coefficients: tuple[tuple[float, ...], ...]
    reach: float = 1.0
    steepness: ClassVar[float] = 1.0

    @cached_property
    def polynomial(self) -> Trivariate:
        """The polynomial z - f(x, y)."""
        terms = [
            ((i, j, 0), -coefficient)
            for i, row in enumerate(self.coefficients)
            for j, coefficient in enumerate(row)
            if coefficient != 0.0
        ]
        return Trivariate((((0, 0, 1), 1.0), *terms))

    def jet(self, x: Float, y: Float) -> HeightJet:
        """f, f_x, f_y, f_xx, f_xy, f_yy at (N,) places, by Horner's rule in x over Horner's rule in y."""
        zero = np.zeros_like(x)
        f, fx, fy, fxx, fxy, fyy = zero, zero, zero, zero, zero, zero
        for row in reversed(self.coefficients):
            g, gy, gyy = zero, zero, zero
            for coefficient in reversed(row):
                gyy = gyy * y + 2.0 * gy
                gy = gy * y + g
                g = g * y + coefficient
            fxx = fxx * x + 2.0 * fx
            fxy = fxy * x + fy
            fx = fx * x + f
            fyy = fyy * x + gyy
            fy = fy * x + gy
            f = f * x + g
        return f, fx, fy, fxx, fxy, fyy

    def height(self, x: Float, y: Float) -> Float:
        """Heights f at (N,) places."""
        f: Float = np.zeros_like(x)
        for row in reversed(self.coefficients):
            g = np.zeros_like(x)
            for coefficient in reversed(row):
                g = g * y + coefficient
            f = f * x + g
        return f

    def over(self, plane: Float) -> Float:
        """Points of the surface (N, 3) over points of the plane (N, 2)."""
        return np.column_stack([plane, self.height(plane[:, 0], plane[:, 1])])

    def gradient(self, points: Float) -> Float:
        """Gradients (-f_x, -f_y, 1) of z - f, (N, 3)."""
        _, fx, fy, _, _, _ = self.jet(points[:, 0], points[:, 1])
        return np.stack([-fx, -fy, np.ones_like(fx)], axis=-1)

    def hessian(self, points: Float) -> Float:
        """Second derivatives of z - f, (N, 3, 3)."""
        _, _, _, fxx, fxy, fyy = self.jet(points[:, 0], points[:, 1])
        result = np.zeros((len(points), 3, 3))
        result[:, 0, 0], result[:, 1, 1] = -fxx, -fyy
        result[:, 0, 1] = result[:, 1, 0] = -fxy
        return result

    def closest(self, points: Float) -> Float:
        """Feet reached downhill from straight above or below each point, (N, 3).

        The nearest points of the surface for points nearer to it than its smallest radius of curvature; farther away
        a foot that is nearest among its neighbours. The surface goes on beyond the mesh. NaN where no foot was found:
        at centres of symmetry between feet, and for some points at several times the mesh's size from the surface.
        """
        chunks = range(0, len(points), CHUNK)
        return np.concatenate([np.empty((0, 3)), *(self._feet(points[start : start + CHUNK]) for start in chunks)])

    def _feet(self, points: Float) -> Float:
        """Minimise half the squared distance over (x, y) by Newton's method, damped until it descends."""
        feet = np.full(points.shape, np.nan)
        active = np.flatnonzero(np.isfinite(points).all(axis=1))
        with np.errstate(all="ignore"):  # far points may overflow: they end as NaN, as promised
            x, y = self._start(points)
            for _ in range(MOST_STEPS):
                if not len(active):
                    break
                p = points[active]
                dx, dy, definite = self._newton_step(p, x[active], y[active])
                factor = self._damping(p, x[active], y[active], dx, dy)
                x[active] += factor * dx
                y[active] += factor * dy
                scale = 1.0 + np.abs(x[active]) + np.abs(y[active])
                last = definite & (factor == 1.0) & (np.hypot(dx, dy) <= LAST_STEP * scale)
                done = active[last]
                feet[done] = np.column_stack([x[done], y[done], self.height(x[done], y[done])])
                active = active[~last]
        return feet

    def _start(self, points: Float) -> tuple[Float, Float]:
        """Places (N,), (N,): the point's own, or the nearest within reach if the surface is nearer to it there."""
        x, y = points[:, 0], points[:, 1]
        inner_x, inner_y = np.clip(x, -self.reach, self.reach), np.clip(y, -self.reach, self.reach)
        below = np.abs(self.height(x, y) - points[:, 2])
        inner = np.hypot(np.hypot(inner_x - x, inner_y - y), self.height(inner_x, inner_y) - points[:, 2]) < below
        return np.where(inner, inner_x, x), np.where(inner, inner_y, y)

    def _newton_step(self, p: Float, x: Float, y: Float) -> tuple[Float, Float, Bool]:
        """Newton steps (N,), (N,), and whether the Hessian was positive definite.

        Where it was not, its eigenvalues' moduli serve: the step still leads downhill, away from saddles and maxima of
        the distance.
        """
        f, fx, fy, fxx, fxy, fyy = self.jet(x, y)
        above = f - p[:, 2]
        gx, gy = x - p[:, 0] + above * fx, y - p[:, 1] + above * fy
        a, b, c = 1.0 + fx * fx + above * fxx, fx * fy + above * fxy, 1.0 + fy * fy + above * fyy
        middle, radius = 0.5 * (a + c), np.hypot(0.5 * (a - c), b)
        low, high = middle - radius, middle + radius
        definite = low > UNRELIABLE * high
        # |H| = slope H + shift I has the eigenvalues |low|, |high|, neither too near to zero
        floor = SINGULAR * np.maximum(np.abs(low), np.abs(high))
        low_modulus, high_modulus = np.maximum(np.abs(low), floor), np.maximum(np.abs(high), floor)
        slope = np.where(definite | (radius == 0.0), 1.0, (high_modulus - low_modulus) / (2.0 * radius))
        shift = np.where(definite, 0.0, low_modulus - slope * low)
        a, b, c = slope * a + shift, slope * b, slope * c + shift
        determinant = a * c - b * b
        return (b * gy - c * gx) / determinant, (b * gx - a * gy) / determinant, definite

    def _damping(self, p: Float, x: Float, y: Float, dx: Float, dy: Float) -> Float:
        """Factors (N,) 1, 1/4, 1/16... with which a step does not lead away from the point, rounding aside."""

        def distance(chosen: Int, x: Float, y: Float) -> Float:
            return norm(np.stack([x, y, self.height(x, y)], axis=-1) - p[chosen])

        factor = np.ones(len(p))
        away = np.arange(len(p))
        now = distance(away, x, y)
        allowed = now + 1e-13 * (1.0 + now + np.abs(x) + np.abs(y))
        for _ in range(20):
            there = distance(away, x[away] + factor[away] * dx[away], y[away] + factor[away] * dy[away])
            away = away[~(there <= allowed[away])]
            if not len(away):
                break
            factor[away] *= 0.25
        return factor
