"""Exact surfaces and datasets on which an approximation has to end in a certain way."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, unit
from testbed.plugins.dataset import Dataset

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTANTS = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


class Lens(ExactSurface):
    """Two caps of spheres that meet in a circle of radius 1 in the plane z = 0, at an angle."""

    height = 0.75

    def _radial(self, points: Float) -> tuple[Float, Float]:
        side = np.where(points[:, 2] >= 0.0, 1.0, -1.0)
        centre = np.zeros_like(points)
        centre[:, 2] = -self.height * side
        return centre, unit(points - centre)

    def closest(self, points: Float) -> Float:
        centre, direction = self._radial(points)
        foot: Float = centre + np.hypot(1.0, self.height) * direction
        return foot

    def normal(self, points: Float) -> Float:
        return self._radial(points)[1]

    def second_form(self, points: Float) -> Float:
        n = self.normal(points)
        form: Float = (np.eye(3) - n[:, :, None] * n[:, None, :]) / np.hypot(1.0, self.height)
        return form


class Holed(Lens):
    """The unit sphere, but for one octant where feet are not found."""

    height = 0.0

    def closest(self, points: Float) -> Float:
        feet = super().closest(points)
        feet[np.greater(points, 0.1).all(axis=1)] = np.nan
        return feet


@dataclass(frozen=True)
class LensData(Dataset):
    """Octahedron on a lens, squeezed to its height."""

    holed: bool = False

    name = "lens"
    title = "Lens"
    reference = "a test"
    closed = True
    finest = 0

    def mesh(self, level: int) -> HermiteMesh:
        assert level == 0
        return self.surface.sample(self.surface.closest(OCTAHEDRON), OCTANTS)

    @property
    def surface(self) -> Lens:
        return Holed() if self.holed else Lens()
