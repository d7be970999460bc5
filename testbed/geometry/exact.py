"""Exact surfaces: what datasets are sampled from and what distances are measured against."""

from abc import ABC, abstractmethod

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int


class ExactSurface(ABC):
    """A smooth surface with a closest-point projection, normals and second fundamental forms; stateless."""

    @abstractmethod
    def closest(self, points: Float) -> Float:
        """Feet of the perpendiculars from points (N, 3) near the surface, (N, 3), to rounding.

        NaN where a foot was not found: a NaN is never a pass.
        """

    @abstractmethod
    def normal(self, points: Float) -> Float:
        """Unit normals (N, 3) at points (N, 3) on the surface."""

    @abstractmethod
    def second_form(self, points: Float) -> Float:
        """Second fundamental forms W (N, 3, 3) at points on the surface; positive where it bends away from the normal."""

    def sample(self, points: Float, faces: Int) -> HermiteMesh:
        """Return the mesh of ``points`` (V, 3), which lie on the surface, with its normals and second forms there."""
        return HermiteMesh(points, faces, self.normal(points), self.second_form(points))
