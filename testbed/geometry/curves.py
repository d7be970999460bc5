"""Cubic curve networks: one Bezier curve on every mesh edge, built once, reversed bit for bit for the second face."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int


@dataclass(frozen=True)
class CurveNetwork:
    """A cubic Bezier curve on every edge of a mesh.

    Parameters
    ----------
    mesh
        The mesh whose edges carry the curves.
    control_points
        (E, 4, 3), each curve running from the lower vertex id to the higher.
    notes
        What had to be done differently and how often, as in ``{"curves without a root": 3}``; reported, never silent.
    """

    mesh: HermiteMesh
    control_points: Float
    notes: Mapping[str, int] = field(default_factory=dict)

    @property
    def end_legs(self) -> tuple[Float, Float]:
        """(E, 3) each: from the first control point to the second, and from the last to the one before it."""
        points = self.control_points
        return points[:, 1] - points[:, 0], points[:, 2] - points[:, 3]

    def along_sides(self, faces: slice | Int = slice(None)) -> Float:
        """(F, sides, 4, 3): the curve of side s of all faces, or of some, from corner s to corner s + 1."""
        curves = self.control_points[self.mesh.face_edges[faces]]
        return np.where(self.mesh.face_edge_forward[faces][..., None, None], curves, curves[:, :, ::-1])

    def opposite_vertices(self, faces: slice | Int = slice(None)) -> Float:
        """(F, 3, 4, 3): the curve of the edge opposite vertex i of each triangle, from corner i + 1 to corner i + 2."""
        return np.roll(self.along_sides(faces), -1, axis=1)
