"""Bicubic B-spline surfaces over squares of unit cells, as Bezier patches, with derivatives up to the third."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from testbed.geometry.vectors import Float

#: Orders of differentiation (along u, along v) of the rows of a jet of order 3.
PARTIALS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
#: Rows of a jet of order 0, 1, 2, 3.
ROWS = (1, 3, 6, 10)

#: Numbers of extended precision, where there are such.
LongFloat: TypeAlias = NDArray[np.longdouble]
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
        return self.precise_patches().astype(np.float64)

    def precise_patches(self) -> LongFloat:
        """Bezier nets as :meth:`patches` has them, in extended precision where the machine has it.

        What is left of a third derivative when control points are subtracted has then all digits of double precision.
        """
        along_u = as_bezier(np.array(self.control_points, dtype=np.longdouble))
        return np.moveaxis(as_bezier(np.moveaxis(along_u, 2, 0)), (0, 1), (1, 3))

    def jet(self, at: Float, order: int) -> Float:
        """Derivatives up to ``order``, at most 3, at parameters (N, 2): (rows, N, 3).

        f | f_u, f_v | f_uu, f_uv, f_vv | f_uuu, f_uuv, f_uvv, f_vvv.
        """
        cell = np.searchsorted(np.arange(1.0, self.cells), at, side="right")
        u, v = at[:, 0] - cell[:, 0], at[:, 1] - cell[:, 1]
        powers = monomials(self)[..., cell[:, 0] * self.cells + cell[:, 1]]
        curves = derivatives(powers, v, order)  # along v, each still a polynomial in u
        by_curve = [derivatives(curve, u, order - s) for s, curve in enumerate(curves)]
        return np.moveaxis(np.stack([by_curve[s][r] for r, s in PARTIALS[: ROWS[order]]]), 1, -1)


def derivatives(powers: Float, t: Float, order: int) -> list[Float]:
    """Value and derivatives up to ``order`` of cubics with coefficients (4, ..., N), by Horner's rule."""
    c0, c1, c2, c3 = powers
    a = c3 * t
    b = a + c2
    result = [(b * t + c1) * t + c0]
    if order >= 1:
        result.append((2.0 * b + a) * t + c1)
    if order >= 2:
        result.append(2.0 * (b + 2.0 * a))
    if order >= 3:
        result.append(6.0 * c3)
    return result


@lru_cache(maxsize=8)
def monomials(spline: BicubicSpline) -> Float:
    """Coefficients of v^j u^i in each cell, cells last: (4 powers of v, 4 of u, 3, cells^2), read-only; remembered."""
    to_powers = np.array([[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
    powers = np.einsum("is,jt,abstx->jixab", to_powers, to_powers, spline.precise_patches())
    powers = np.ascontiguousarray(powers.reshape(4, 4, 3, -1), dtype=np.float64)
    powers.flags.writeable = False
    return powers


def as_bezier(control_points: LongFloat) -> LongFloat:
    """Bezier points (m, 4, ...) of the m cells of cubic splines with control points (m + 3, ...).

    They are the values of the cells' blossoms at repeated ends, by de Boor's recursion.
    """
    cells = len(control_points) - 3
    knots = np.clip(np.arange(-3, cells + 4), 0, cells)
    cell = np.arange(cells)
    points = []
    for ends in range(4):  # how many of the blossom's arguments are the cell's end
        active = [control_points[cell + i] for i in range(4)]
        for step in range(1, 4):
            argument = cell + (step <= ends)
            for i in range(3, step - 1, -1):
                low, high = knots[cell + i], knots[cell + i + 4 - step]
                weight = (argument - low).astype(np.longdouble) / (high - low)
                weight = weight.reshape(-1, *(1,) * (control_points.ndim - 1))
                active[i] = (1 - weight) * active[i - 1] + weight * active[i]
        points.append(active[3])
    return np.stack(points, axis=1)
