"""Exact surfaces: what datasets are sampled from and what distances are measured against."""

from abc import ABC, abstractmethod

import numpy as np

from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int, norm, unit


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
        """Second fundamental forms W (N, 3, 3) at points on it; positive where it bends away from the normal."""

    def curvature_bound(self, low: Float, high: Float) -> Float:
        """Upper bounds (N,) of the moduli of the principal curvatures of the surface within boxes.

        Parameters
        ----------
        low, high
            (N, 3) corners of the boxes.

        Returns
        -------
        bounds
            True bounds, rounding included; infinite where none is known, as for all boxes of a surface that does not
            define this.
        """
        del high
        return np.full(len(low), np.inf)

    def may_end(self, low: Float, high: Float) -> Bool:
        """Whether the surface may have a boundary within boxes (N, 3), (N,): true, unless a surface knows better.

        Where it has none, a bound of its curvature tells how far it goes on.
        """
        del high
        return np.ones(len(low), dtype=np.bool_)

    def middles(self, start: Float, end: Float, boundary: Bool) -> Float:
        """Points (E, 3) of the surface between points of it (E, 3) and (E, 3): new vertices on the edges of a mesh.

        Here the feet of the perpendiculars from the middles of the chords; a surface that is cut off has to put those
        of boundary edges onto its boundary.

        Parameters
        ----------
        start, end
            The ends of the edges.
        boundary
            (E,) true for edges on the boundary of the mesh.

        Returns
        -------
        points
            NaN where none was found.
        """
        del boundary
        return self.closest(0.5 * (start + end))

    def sample(self, points: Float, faces: Int, centres: Float | None = None) -> HermiteMesh:
        """Return the mesh of ``points`` (V, 3), which lie on the surface, with its normals and second forms there.

        Likewise at the centres of the faces, if points of the surface are given for them, (F, 3).
        """
        of_faces = FaceData()
        if centres is not None:
            of_faces = FaceData(Centres(centres, self.normal(centres), self.second_form(centres)))
        return HermiteMesh(
            points,
            faces,
            self.normal(points),
            self.second_form(points),
            face_data=of_faces,
            gradients=self.sampled_gradients(points),
        )

    def sampled_gradients(self, points: Float) -> Float | None:
        """Gradients (V, 3), at points on it, of the function whose zero set the surface is; None without such."""
        del points
        return None


class LevelSet(ExactSurface):
    """The zero set of a smooth function g whose gradient points to the side of the normal."""

    @abstractmethod
    def gradient(self, points: Float) -> Float:
        """Gradients of g, (N, 3) at points (N, 3)."""

    @abstractmethod
    def hessian(self, points: Float) -> Float:
        """Second derivatives of g, (N, 3, 3) at points (N, 3)."""

    def sampled_gradients(self, points: Float) -> Float | None:
        """Gradients of g, (V, 3)."""
        return self.gradient(points)

    def may_end(self, low: Float, high: Float) -> Bool:
        """False for all boxes, (N,): where the gradient does not vanish, a level set has no boundary."""
        del high
        return np.zeros(len(low), dtype=np.bool_)

    def normal(self, points: Float) -> Float:
        """Unit normals (N, 3): the gradient scaled to length one."""
        return unit(self.gradient(points))

    def second_form(self, points: Float) -> Float:
        """Second fundamental forms (N, 3, 3): W = P H P / |grad g|, P = I - n n^T.

        Differentiating g = 0 twice along the surface gives <grad g, D_uv S> + u . H v = 0, and II(u, v) = -<D_uv S, n>.
        """
        gradient = self.gradient(points)
        length = norm(gradient)
        n = gradient / length[:, None]
        tangential = np.eye(3) - n[:, :, None] * n[:, None, :]
        projected = tangential @ self.hessian(points) @ tangential / length[:, None, None]
        # the two products round differently; a second form is symmetric to the last bit
        symmetric: Float = 0.5 * (projected + projected.swapaxes(-1, -2))
        return symmetric
