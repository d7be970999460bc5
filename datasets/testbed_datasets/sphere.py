"""The sphere, and the latitude-longitude mesh of it on which the thesis shows its lumpy interpolants."""

from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Float, Int, unit
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Shape
from testbed_datasets.halving import halved
from testbed_datasets.parameters import positive


@dataclass(frozen=True)
class RoundSphere(PolynomialLevelSet):
    """The sphere of a radius about the origin, normals outward."""

    radius: float
    nearest: ClassVar[bool] = True

    @cached_property
    def polynomial(self) -> Trivariate:
        """The polynomial x^2 + y^2 + z^2 - r^2."""
        return Trivariate((((2, 0, 0), 1.0), ((0, 2, 0), 1.0), ((0, 0, 2), 1.0), ((0, 0, 0), -(self.radius**2))))

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """1 / r for all boxes, (N,)."""
        del high
        return np.full(len(low), (1.0 + 4.0 * np.finfo(np.float64).eps) / self.radius)

    def closest(self, points: Float) -> Float:
        """Feet r p / |p|, (N, 3); NaN at the centre, to which every point of the sphere is as near."""
        foot: Float = self.radius * unit(points)
        foot[~np.isfinite(foot).all(axis=1)] = np.nan  # an infinite coordinate leaves the others finite
        return foot

    def normal(self, points: Float) -> Float:
        """Unit normals p / |p|, (N, 3)."""
        return unit(points)

    def second_form(self, points: Float) -> Float:
        """Second fundamental forms (I - n n^T) / r, (N, 3, 3)."""
        n = unit(points)
        form: Float = (np.eye(3) - n[:, :, None] * n[:, None, :]) / self.radius
        return form


@dataclass(frozen=True)
class SphereMesh(Dataset):
    """A mesh with its vertices on a sphere; the middles of edges are projected onto it from the centre.

    Parameters
    ----------
    radius
        Radius of the sphere.
    """

    radius: float = 1.0

    closed: ClassVar[bool | None] = True
    shape: ClassVar[Shape | None] = Shape.SPHERES

    def __post_init__(self) -> None:
        positive(self.name, radius=self.radius)

    @abstractmethod
    def coarsest(self) -> tuple[Float, Int]:
        """Unit vertices (V, 3) and faces (F, 3) of level 0."""

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level; Refused if there is none."""
        directions, faces = halved(*self.coarsest(), level, name=self.name, middle=lambda start, end: unit(start + end))
        return self.surface.sample(self.radius * directions, faces)

    @property
    def surface(self) -> RoundSphere:
        """The sphere."""
        return RoundSphere(self.radius)


@dataclass(frozen=True)
class Sphere(SphereMesh):
    """Sphere, latitude-longitude: 6 meridians, rings at -30 and +30 degrees, two poles; 14 vertices, 24 faces.

    Parameters
    ----------
    radius
        Radius of the sphere.
    """

    name = "sphere"
    title = "Sphere, latitude-longitude"
    reference = (
        "Mann 1992, figures 2.11b (page 30) and 2.18 (page 42); the mesh was found by matching printed curvatures"
    )
    finest = 4

    def coarsest(self) -> tuple[Float, Int]:
        """South pole, lower ring, upper ring, north pole; the direction of the diagonals is not known to matter."""
        steps = 6
        meridian = np.arange(steps)
        angle = 2.0 * np.pi * meridian / steps
        height = np.full(steps, 0.5)
        ring = np.stack([np.sqrt(0.75) * np.cos(angle), np.sqrt(0.75) * np.sin(angle), height], axis=-1)
        pole = np.array([[0.0, 0.0, 1.0]])
        points = np.concatenate([-pole, ring * [1.0, 1.0, -1.0], ring, pole])
        low, high = 1 + meridian, 1 + steps + meridian
        next_low, next_high = np.roll(low, -1), np.roll(high, -1)
        south, north = np.zeros_like(low), np.full_like(low, 2 * steps + 1)
        corners = [(south, next_low, low), (low, next_low, next_high), (low, next_high, high), (high, next_high, north)]
        return points, np.concatenate([np.stack(face, axis=-1) for face in corners])
