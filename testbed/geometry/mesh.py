"""Hermite data: a mesh with, at its vertices, unit normals and second fundamental forms."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, as_float, norm, quadratic_form


@dataclass(frozen=True, slots=True)
class EdgeData:
    """What a boundary curve is built from: the data at both ends of E edges, lower vertex id first.

    Attributes
    ----------
    p0, p1
        End points, (E, 3).
    n0, n1
        Unit normals there, (E, 3), or None if the mesh has none.
    W0, W1
        Second fundamental forms there, (E, 3, 3), or None.
    """

    p0: Float
    p1: Float
    n0: Float | None
    n1: Float | None
    W0: Float | None
    W1: Float | None


class HermiteMesh:
    """A mesh of triangles or of quadrilaterals with Hermite data at its vertices; checked at construction, immutable.

    Parameters
    ----------
    points
        (V, 3) vertices.
    faces
        (F, 3) or (F, 4) vertex ids, counterclockwise seen from the side the normals point to.
    normals
        (V, 3) normals, scaled to length one here, or None.
    second_forms
        (V, 3, 3) symmetric matrices W with W n = 0 and II(u, v) = u . W v, positive where the surface bends away from
        its normal, or None; needs normals.

    Raises
    ------
    MeshError
        One sentence that names the face or vertex, for data that no surface can be built on.
    """

    def __init__(self, points: Any, faces: Any, normals: Any = None, second_forms: Any = None) -> None:
        self.points: Float = as_float(points)
        self.faces: Int = np.ascontiguousarray(faces, dtype=np.int64)
        self.normals: Float | None = None if normals is None else as_float(normals)
        self.second_forms: Float | None = None if second_forms is None else as_float(second_forms)
        if self.normals is not None:
            self.normals = self.normals / norm(self.normals)[:, None]

    @property
    def sides(self) -> int:
        """Vertices of a face, 3 or 4."""
        return self.faces.shape[1]

    @cached_property
    def _edge_table(self) -> tuple[Int, Int]:
        start, end = self.faces, np.roll(self.faces, -1, axis=1)
        both = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=-1).reshape(-1, 2)
        edges, inverse = np.unique(both, axis=0, return_inverse=True)
        return edges, inverse.reshape(self.faces.shape)

    @property
    def edges(self) -> Int:
        """(E, 2) vertex ids, the lower first, in lexicographic order."""
        return self._edge_table[0]

    @property
    def face_edges(self) -> Int:
        """(F, sides) edge of side s of each face, the side from corner s to corner s + 1."""
        return self._edge_table[1]

    @cached_property
    def face_edge_forward(self) -> Bool:
        """(F, sides) true where the face runs along the edge from its lower vertex id to its higher."""
        return self.faces < np.roll(self.faces, -1, axis=1)

    @cached_property
    def edge_faces(self) -> Int:
        """(E, 2) the face that runs along the edge forward and the face that runs back, -1 where there is none."""
        result = np.full((len(self.edges), 2), -1, dtype=np.int64)
        face = np.broadcast_to(np.arange(len(self.faces))[:, None], self.faces.shape)
        result[self.face_edges, np.where(self.face_edge_forward, 0, 1)] = face
        return result

    @property
    def boundary_edges(self) -> Bool:
        """(E,) true for edges with one face only."""
        on_boundary: Bool = (self.edge_faces < 0).any(axis=1)
        return on_boundary

    @property
    def h(self) -> float:
        """Length of the longest edge."""
        return float(norm(np.diff(self.points[self.edges], axis=1)[:, 0]).max())

    @cached_property
    def edge_data(self) -> EdgeData:
        """The data at both ends of every edge."""

        def ends(values: Float | None) -> tuple[Float | None, Float | None]:
            return (None, None) if values is None else (values[self.edges[:, 0]], values[self.edges[:, 1]])

        p0, p1 = self.points[self.edges[:, 0]], self.points[self.edges[:, 1]]
        return EdgeData(p0, p1, *ends(self.normals), *ends(self.second_forms))

    def corner_points(self) -> Float:
        """(F, sides, 3) vertices by face corner."""
        return self.points[self.faces]

    def corner_normals(self) -> Float:
        """(F, sides, 3) unit normals by face corner; raises ValueError if the mesh has none."""
        if self.normals is None:
            raise ValueError("this mesh has no normals")
        return self.normals[self.faces]

    def second_form(self, u: Float, v: Float) -> Float:
        """II(u, v) at the face corners, (F, sides), of vectors (F, sides, 3); ValueError without second forms."""
        if self.second_forms is None:
            raise ValueError("this mesh has no second fundamental forms")
        return quadratic_form(u, self.second_forms[self.faces], v)
