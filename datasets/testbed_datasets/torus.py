"""The torus: positive, negative and zero Gaussian curvature on one closed surface."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Float
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import halved
from testbed_datasets.parameters import finite, positive

#: Steps of level 0 around the axis and around the tube.
STEPS = np.array([10.0, 5.0])


@dataclass(frozen=True)
class RoundTorus(PolynomialLevelSet):
    """The torus about the z axis, normals out of the tube."""

    major: float
    minor: float
    nearest: ClassVar[bool] = True

    @cached_property
    def polynomial(self) -> Trivariate:
        """The polynomial (s + R^2 - r^2)^2 - 4 R^2 (x^2 + y^2), s = x^2 + y^2 + z^2."""
        inner = (self.major - self.minor) * (self.major + self.minor)
        across, along = -2.0 * (self.major**2 + self.minor**2), 2.0 * inner
        squares = [((2, 0, 0), across), ((0, 2, 0), across), ((0, 0, 2), along)]
        fourth = [((4, 0, 0), 1.0), ((0, 4, 0), 1.0), ((0, 0, 4), 1.0)]
        mixed = [((2, 2, 0), 2.0), ((2, 0, 2), 2.0), ((0, 2, 2), 2.0)]
        return Trivariate((((0, 0, 0), inner**2), *squares, *fourth, *mixed))

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """The larger of 1 / r along meridians and 1 / (R - r) along the inner equator, for all boxes, (N,)."""
        del high
        largest = max(1.0 / self.minor, 1.0 / (self.major - self.minor))
        return np.full(len(low), (1.0 + 4.0 * np.finfo(np.float64).eps) * largest)

    def closest(self, points: Float) -> Float:
        """Feet in the half plane of the point and the axis, (N, 3); the nearest points of the whole torus.

        NaN on the axis and on the core circle, to which a whole circle of the torus is as near.
        """
        with np.errstate(invalid="ignore", divide="ignore"):  # 0/0 on the axis and the core circle: the NaN promised
            rho = np.hypot(points[:, 0], points[:, 1])
            beyond = rho - self.major
            from_core = np.hypot(beyond, points[:, 2])
            distance = self.major + self.minor * (beyond / from_core)
            across = points[:, :2] / rho[:, None] * distance[:, None]
            foot: Float = np.column_stack([across, self.minor * (points[:, 2] / from_core)])
        foot[~np.isfinite(foot).all(axis=1)] = np.nan
        return foot

    def _frame(self, points: Float) -> tuple[Float, Float, Float, Float]:
        """Cosine of the tube angle, distance from the axis, unit normal and unit tangent of the parallel."""
        rho = np.hypot(points[:, 0], points[:, 1])
        beyond = rho - self.major
        from_core = np.hypot(beyond, points[:, 2])
        cosine, x, y = beyond / from_core, points[:, 0] / rho, points[:, 1] / rho
        n = np.stack([cosine * x, cosine * y, points[:, 2] / from_core], axis=-1)
        return cosine, rho, n, np.stack([-y, x, np.zeros_like(x)], axis=-1)

    def normal(self, points: Float) -> Float:
        """Unit normals away from the core circle, (N, 3)."""
        return self._frame(points)[2]

    def second_form(self, points: Float) -> Float:
        """Second fundamental forms (N, 3, 3): 1 / r along the meridian, cos v / (R + r cos v) along the parallel."""
        cosine, rho, n, parallel = self._frame(points)
        along_parallel = parallel[:, :, None] * parallel[:, None, :]
        along_meridian = np.eye(3) - n[:, :, None] * n[:, None, :] - along_parallel
        form: Float = along_meridian / self.minor + (cosine / rho)[:, None, None] * along_parallel
        return form


@dataclass(frozen=True)
class Torus(Dataset):
    """Torus, 10 steps around the axis and 5 around the tube: 50 vertices, 100 faces.

    The published mesh is ``torus[phase=0]``: one row on the outer equator. Its finer levels have rows exactly on the
    top and bottom circles, where the normals at both ends of an edge are equal and the tangents parallel: geometric
    Hermite curves do not exist there and orders of convergence drop. On its level 0, 20 diagonals have no such curve.
    The default phase keeps the rows of every level at least a tenth of a row step away from those circles, and every
    edge of levels 0 to 5 has a geometric Hermite cubic, with minor = 0.5 and with minor = 0.4.

    Parameters
    ----------
    major
        Radius R of the core circle; 1 is the most plausible reading of the pictures.
    minor
        Radius r of the tube, less than ``major``; 0.5 likewise.
    phase
        Shift of the rows around the tube, from the outer equator upward, as a fraction of level 0's row step of 72
        degrees; 0 <= phase < 1.
    """

    major: float = 1.0
    minor: float = 0.5
    phase: float = 0.15

    name = "torus"
    title = "Torus"
    reference = "Mann 1992, figures 2.11c (page 30), 2.19 (page 44) and 3.5 (page 60), with phase=0; radii not printed"
    closed = True
    finest = 4

    def __post_init__(self) -> None:
        positive(self.name, major=self.major, minor=self.minor)
        finite(self.name, phase=self.phase)
        if self.minor >= self.major:
            raise SpecError(
                f"parameter minor of torus cannot be {self.minor}: the tube meets itself, give less than "
                f"major = {self.major}"
            )
        if not 0.0 <= self.phase < 1.0:
            raise SpecError(f"parameter phase of torus cannot be {self.phase}: give a fraction from 0 to below 1")

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the two angles; Refused if there is none."""
        columns, rows = (int(steps) for steps in STEPS)
        column, row = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
        next_column, next_row = (column + 1) % columns, (row + 1) % rows
        corners = [
            [column * rows + row, next_column * rows + row, next_column * rows + next_row],
            [column * rows + row, next_column * rows + next_row, column * rows + next_row],
        ]
        faces = np.concatenate([np.stack(face, axis=-1) for face in corners])
        # counted in steps of level 0, all coordinates are dyadic fractions: no rounding before the angles
        steps, faces = halved(
            np.stack([column, row], axis=-1).astype(np.float64), faces, level, name=self.name, middle=around
        )
        u, v = (2.0 * np.pi * (steps + np.array([0.0, self.phase])) / STEPS).T
        rho = self.major + self.minor * np.cos(v)
        points = np.stack([rho * np.cos(u), rho * np.sin(u), self.minor * np.sin(v)], axis=-1)
        return self.surface.sample(points, faces)

    @property
    def surface(self) -> RoundTorus:
        """The torus."""
        return RoundTorus(self.major, self.minor)


def around(start: Float, end: Float) -> Float:
    """Middles of edges on the doubly periodic grid, the short way round, (E, 2)."""
    forward = np.mod(end - start + 0.5 * STEPS, STEPS) - 0.5 * STEPS
    middle: Float = np.mod(start + 0.5 * forward, STEPS)
    return middle
