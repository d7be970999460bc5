"""Bicubic B-spline surfaces over squares of unit cells, as Bezier patches, with derivatives up to the third."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from testbed.geometry.bernstein import curve_tables
from testbed.geometry.vectors import Float

#: Orders of differentiation (along u, along v) of the rows of a jet of order 3.
PARTIALS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
#: Rows of a jet of order 0, 1, 2, 3.
ROWS = (1, 3, 6, 10)

#: A net of control points, rows along u: [i][j] is (x, y, z).
Net = tuple[tuple[tuple[float, float, float], ...], ...]


@dataclass(frozen=True)
class BicubicSpline:
    """A bicubic B-spline surface with knots 0, 0, 0, 0, 1, 2, ..., m, m, m, m along both parameters.

    Its second derivatives are continuous, its third jump at the knots. The cells at the boundary go on beyond it as the
    polynomials that they are.

    Parameters
    ----------
    control_points
        (m + 3) x (m + 3) points.
    """

    control_points: Net

    @property
    def cells(self) -> int:
        """Cells m along each parameter; the surface lies over [0, m]^2."""
        return len(self.control_points) - 3

    def patches(self) -> Float:
        """Bezier nets of the cells, (m, m, 4, 4, 3): cells along u and v, control points along u and v."""
        columns = as_bezier(np.array(self.control_points))
        net = as_bezier(columns.swapaxes(0, 1)).swapaxes(0, 1)
        place = 3 * np.arange(self.cells)[:, None] + np.arange(4)
        patches: Float = net[place[:, None, :, None], place[None, :, None, :]]
        return patches

    def jet(self, at: Float, order: int) -> Float:
        """Derivatives up to ``order``, at most 3, at parameters (N, 2): (rows, N, 3).

        f | f_u, f_v | f_uu, f_uv, f_vv | f_uuu, f_uuv, f_uvv, f_vvv, each sum one term after the other.
        """
        cell = np.searchsorted(np.arange(1.0, self.cells), at, side="right")
        tables = [np.moveaxis(curve_tables(3, at[:, axis] - cell[:, axis], order), -1, 1) for axis in range(2)]
        net = planar_patches(self)[..., cell[:, 0] * self.cells + cell[:, 1]]
        curves = [_combined(table, net.swapaxes(0, 1)) for table in tables[1]]
        rows = [_combined(tables[0][r], curves[s]) for r, s in PARTIALS[: ROWS[order]]]
        return np.moveaxis(np.stack(rows), 1, -1)


def _combined(weights: Float, points: Float) -> Float:
    """Sum over the first axis of weights (k, N) times points (k, ..., N), term after term."""
    total: Float = weights[0] * points[0]
    for weight, point in zip(weights[1:], points[1:], strict=True):
        total += weight * point
    return total


@lru_cache(maxsize=8)
def planar_patches(spline: BicubicSpline) -> Float:
    """Return the Bezier nets of a spline, cells last and contiguous: (4, 4, 3, cells^2), read-only; remembered."""
    nets = np.ascontiguousarray(np.moveaxis(spline.patches().reshape(-1, 4, 4, 3), 0, -1))
    nets.flags.writeable = False
    return nets


def as_bezier(control_points: Float) -> Float:
    """Bezier points (3 m + 1, ...) of cubic splines with control points (m + 3, ...): inner knots made triple."""
    from scipy.interpolate import BSpline  # takes longer to import than all else here

    cells = len(control_points) - 3
    knots = np.concatenate([np.zeros(3), np.arange(cells + 1.0), np.full(3, float(cells))])
    spline = BSpline(knots, control_points, 3)
    for knot in range(1, cells):
        for _ in range(2):
            spline = spline.insert_knot(float(knot))
    points: Float = spline.c
    return points
