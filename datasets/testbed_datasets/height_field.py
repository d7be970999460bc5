"""Polynomial graphs z = f(x, y): normals, second forms and closest points."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.exact import LevelSet
from testbed.geometry.vectors import Bool, Float

#: Newton's method takes about five steps from a point near the surface.
MOST_STEPS = 60
#: After a Newton step below this, relative to the coordinates, the next error is below rounding.
LAST_STEP = 1e-9
#: Points projected at once, so that all that belongs to them stays in the processor's cache.
CHUNK = 4096

#: A polynomial's values and derivatives f, f_x, f_y, f_xx, f_xy, f_yy.
HeightJet = tuple[Float, Float, Float, Float, Float, Float]


@dataclass(frozen=True)
class HeightField(LevelSet):
    """The graph of a polynomial over the whole plane, normals upward.

    Parameters
    ----------
    coefficients
        Row i, column j holds the coefficient of x^i y^j; rows may be ragged.
    """

    coefficients: tuple[tuple[float, ...], ...]

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
        return self.jet(x, y)[0]

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
        a foot that is nearest among its neighbours. The surface goes on beyond the mesh. NaN where no foot was found.
        """
        chunks = range(0, len(points), CHUNK)
        return np.concatenate([np.empty((0, 3)), *(self._feet(points[start : start + CHUNK]) for start in chunks)])

    def _feet(self, points: Float) -> Float:
        """Minimise half the squared distance over (x, y) by Newton's method, damped until it descends."""
        feet = np.full(points.shape, np.nan)
        active = np.flatnonzero(np.isfinite(points).all(axis=1))
        x, y = points[:, 0].copy(), points[:, 1].copy()
        with np.errstate(all="ignore"):  # far points may overflow: they end as NaN, as promised
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

    def _newton_step(self, p: Float, x: Float, y: Float) -> tuple[Float, Float, Bool]:
        """Newton steps (N,), (N,) and whether the Hessian was positive definite; Gauss-Newton steps where not."""
        f, fx, fy, fxx, fxy, fyy = self.jet(x, y)
        above = f - p[:, 2]
        gx, gy = x - p[:, 0] + above * fx, y - p[:, 1] + above * fy
        a, b, c = 1.0 + fx * fx, fx * fy, 1.0 + fy * fy
        ha, hb, hc = a + above * fxx, b + above * fxy, c + above * fyy
        definite = (ha > 0.0) & (ha * hc - hb * hb > 1e-8 * (ha * ha + hc * hc))
        a, b, c = np.where(definite, ha, a), np.where(definite, hb, b), np.where(definite, hc, c)
        determinant = a * c - b * b
        return (b * gy - c * gx) / determinant, (b * gx - a * gy) / determinant, definite

    def _damping(self, p: Float, x: Float, y: Float, dx: Float, dy: Float) -> Float:
        """Factors (N,) 1, 1/2, 1/4... with which a step does not lead away from the point, rounding aside."""

        def distance(x: Float, y: Float) -> Float:
            return np.hypot(np.hypot(x - p[:, 0], y - p[:, 1]), self.height(x, y) - p[:, 2])

        factor = np.ones(len(p))
        now = distance(x, y)
        allowed = now + 1e-12 * (1.0 + now + np.abs(x) + np.abs(y))
        for _ in range(30):
            away = ~(distance(x + factor * dx, y + factor * dy) <= allowed)
            if not away.any():
                break
            factor[away] *= 0.5
        return factor
