"""Edges of triangles with the tangents around them: the four control points that meet a quartic boundary's ends.

At both ends of an edge, three first legs of boundary curves, quartic control point less vertex, lie in the tangent
plane: the edge's own, and those of the next edges in the face on its left and in the face on its right. Half edge
2 e + s leaves end s of edge e; its leg is row (e, s) of an array (E, 2, 3).
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int


@dataclass(frozen=True, eq=False)
class LegNetwork:
    """How the half edges of E edges lie next to each other.

    Parameters
    ----------
    ends
        (E, 2) vertex ids at the start and at the end.
    left, right
        (E, 2) half edges that leave both ends towards the third vertex of the face on the left, which runs along the
        edge from start to end, and of the face on the right, which runs back; -1 where there is no face.
    faces
        (E, 2) ids of the left and of the right face, -1 where there is none.
    """

    ends: Int
    left: Int
    right: Int
    faces: Int

    @classmethod
    def of_mesh(cls, mesh: HermiteMesh) -> "LegNetwork":
        """Return the network of the edges of a mesh of triangles, in its order, each from the lower vertex id."""
        forward = mesh.face_edge_forward
        leaving = 2 * mesh.face_edges + ~forward  # the half edge of each side at the side's first corner
        arriving = 2 * mesh.face_edges + forward
        # seen along side s: from its first corner to the third vertex runs side s + 2 back, from its second side s + 1
        at_start, at_end = np.roll(arriving, -2, axis=1), np.roll(leaving, -1, axis=1)
        left, right = np.full((2, len(mesh.edges), 2), -1, dtype=np.int64)
        left[mesh.face_edges[forward]] = np.stack([at_start[forward], at_end[forward]], axis=-1)
        right[mesh.face_edges[~forward]] = np.stack([at_end[~forward], at_start[~forward]], axis=-1)
        return cls(mesh.edges, left, right, mesh.edge_faces)

    @property
    def interior(self) -> Bool:
        """(E,) true for edges with a face on either side."""
        inside: Bool = np.all(self.faces >= 0, axis=1)
        return inside

    @property
    def around(self) -> tuple[Int, Int]:
        """(2 E,) the next half edge at the same vertex counterclockwise of each one, and clockwise; -1 for none."""
        # seen from the end, left and right are exchanged
        ahead = np.stack([self.left[:, 0], self.right[:, 1]], axis=1)
        back = np.stack([self.right[:, 0], self.left[:, 1]], axis=1)
        return ahead.ravel(), back.ravel()

    def __getitem__(self, chosen: Int | Bool) -> "LegNetwork":
        """Return the chosen edges; half edges and faces keep their ids."""
        return LegNetwork(self.ends[chosen], self.left[chosen], self.right[chosen], self.faces[chosen])

    def beside(self, legs: Float) -> tuple[Float, Float]:
        """Return the legs on the left and on the right at both ends, (E, 2, ...) each, NaN where there is no face.

        Parameters
        ----------
        legs
            (all edges, 2, ...) one row for each half edge.
        """
        flat = legs.reshape(-1, *legs.shape[2:])
        shape = (-1, 2, *(1,) * (legs.ndim - 2))
        left, right = (np.where((at >= 0).reshape(shape), flat[at], np.nan) for at in (self.left, self.right))
        return left, right
