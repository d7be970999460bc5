"""Hermite data: a mesh with, at its vertices, unit normals and second fundamental forms."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NoReturn, TypeAlias

import numpy as np

from testbed.geometry.edges import HalfEdges
from testbed.geometry.face_data import FaceData
from testbed.geometry.mesh_checks import (
    check_along,
    check_not_cancelled,
    check_shapes,
    checked_faces,
    checked_gradients,
    checked_half_edges,
    checked_normals,
    checked_points,
    checked_second_forms,
)
from testbed.geometry.vectors import Bool, Float, Int, angle_between, cross, norm, quadratic_form, unit

#: Where a mesh's normals come from.
NormalsFrom: TypeAlias = Literal["given", "file", "estimated"]


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
        Second fundamental forms there, (E, 3, 3), or None; where they differ from face to face those of one of the two
        faces at the edge.
    t0, t1
        Unit tangents there, (E, 3), both from p0 to p1, of the curve that the surface has to follow, NaN rows where
        none is given; None if no edge has one.
    """

    p0: Float
    p1: Float
    n0: Float | None
    n1: Float | None
    W0: Float | None
    W1: Float | None
    t0: Float | None = None
    t1: Float | None = None

    def __len__(self) -> int:
        return len(self.p0)

    def __getitem__(self, chosen: Int | Bool | slice) -> "EdgeData":
        """Return the data of the chosen edges."""
        columns = (self.p0, self.p1, self.n0, self.n1, self.W0, self.W1, self.t0, self.t1)
        p0, p1, *others = (None if column is None else column[chosen] for column in columns)
        assert p0 is not None  # noqa: S101 - points are always there
        assert p1 is not None  # noqa: S101 - likewise
        return EdgeData(p0, p1, *others)


class HermiteMesh:
    """A mesh of triangles or of quadrilaterals with Hermite data at its vertices; checked at construction, immutable.

    Its faces make an oriented manifold, with or without boundary, of any number of components.

    Parameters
    ----------
    points
        (V, 3) vertices; copied, like all the data.
    faces
        (F, 3) or (F, 4) vertex ids, counterclockwise seen from the side the normals point to. Quadrilaterals need not
        be plane but turn the same way at all corners.
    normals
        (V, 3) normals, scaled to length one here, or None.
    second_forms
        (V, 3, 3) symmetric matrices W with W n = 0 and II(u, v) = u . W v, positive where the surface bends away from
        its normal, or None; needs normals. Single precision is made good, worse refused.
    normals_from
        Where the normals come from: ``given``, ``file`` or ``estimated``; a remark for reports.
    face_data
        Data that belong to faces, if there are any.
    gradients
        (V, 3) vectors along the normals whose lengths matter, too: the gradients of the function whose zero set the
        surface is, or None. Without normals they give these.

    Attributes
    ----------
    points, faces, normals, second_forms, face_data, gradients
        As above, read-only; float64 and int64.
    normals_from
        As above, None without normals.

    Raises
    ------
    MeshError
        One sentence that names the face or vertex, for data that no surface can be built on.
    """

    points: Float
    faces: Int
    normals: Float | None
    second_forms: Float | None
    normals_from: NormalsFrom | None
    face_data: FaceData
    gradients: Float | None

    def __init__(
        self,
        points: Any,
        faces: Any,
        normals: Any = None,
        second_forms: Any = None,
        *,
        normals_from: NormalsFrom = "given",
        face_data: FaceData | None = None,
        gradients: Any = None,
    ) -> None:
        data = vars(self)
        data["points"] = checked_points(points)
        data["faces"] = checked_faces(faces, len(self.points))
        data["_half_edges"] = checked_half_edges(self.faces)
        check_shapes(self.points, self.faces)
        count = len(self.points)
        gradients = None if gradients is None else checked_gradients(gradients, count)
        normals = gradients if normals is None else normals
        data["normals"] = None if normals is None else checked_normals(normals, count)
        data["gradients"] = None if gradients is None else check_along(gradients, self.normals)
        data["second_forms"] = (
            None if second_forms is None else checked_second_forms(second_forms, self.normals, count, self.h)
        )
        data["normals_from"] = None if normals is None else normals_from
        data["face_data"] = (face_data or FaceData()).checked(self.faces, self.normals, self.h)
        self._lock()

    _half_edges: HalfEdges

    def _lock(self) -> None:
        of_faces = self.face_data.arrays().values()
        for array in (
            *(self.points, self.faces, self.normals, self.second_forms, self.gradients, self._half_edges.ids),
            *of_faces,
        ):
            if array is not None:
                array.flags.writeable = False

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a mesh is immutable: make a new one instead of setting {name}")

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._lock()  # copies that come out of a pickle are writeable

    def __repr__(self) -> str:
        kind = "triangles" if self.sides == 3 else "quadrilaterals"
        data = [name for name in ("normals", "second_forms") if getattr(self, name) is not None]
        return (
            f"<HermiteMesh: {len(self.points)} vertices, {len(self.faces)} {kind}, {' and '.join(['points', *data])}>"
        )

    @property
    def sides(self) -> int:
        """Vertices of a face, 3 or 4."""
        return int(self.faces.shape[1])

    @property
    def edges(self) -> Int:
        """(E, 2) vertex ids, the lower first, in lexicographic order."""
        return self._half_edges.ids

    @cached_property
    def face_edges(self) -> Int:
        """(F, sides) edge of side s of each face, the side from corner s to corner s + 1."""
        return locked_ids(self._half_edges.edge.reshape(self.faces.shape))

    @cached_property
    def face_edge_forward(self) -> Bool:
        """(F, sides) true where the face runs along the edge from its lower vertex id to its higher."""
        forward: Bool = np.less(self.faces, np.roll(self.faces, -1, axis=1))
        forward.flags.writeable = False
        return forward

    @cached_property
    def edge_faces(self) -> Int:
        """(E, 2) the face that runs along the edge forward and the face that runs back, -1 where there is none."""
        halves = np.stack([self._half_edges.forward, self._half_edges.backward], axis=-1)
        return locked_ids(halves // self.sides)  # -1 stays -1

    @property
    def boundary_edges(self) -> Bool:
        """(E,) true for edges with one face only."""
        on_boundary: Bool = np.any(self.edge_faces < 0, axis=1)
        return on_boundary

    @property
    def boundary_vertices(self) -> Bool:
        """(V,) true for vertices on the boundary."""
        result = np.zeros(len(self.points), dtype=np.bool_)
        result[self.edges[self.boundary_edges]] = True
        return result

    @property
    def valence(self) -> Int:
        """(V,) number of edges at each vertex."""
        return np.bincount(self.edges.ravel(), minlength=len(self.points)).astype(np.int64, copy=False)

    @cached_property
    def h(self) -> float:
        """Length of the longest edge."""
        p0, p1 = self.points[self.edges[:, 0]], self.points[self.edges[:, 1]]
        return float(norm(p1 - p0).max())

    @cached_property
    def edge_data(self) -> EdgeData:
        """The data at both ends of every edge."""

        def ends(values: Float | None) -> tuple[Float | None, Float | None]:
            return (None, None) if values is None else (values[self.edges[:, 0]], values[self.edges[:, 1]])

        p0, p1 = self.points[self.edges[:, 0]], self.points[self.edges[:, 1]]
        forms, by_corner, tangents = self.second_forms, self.face_data.corner_second_forms, self.face_data.side_tangents
        W0, W1 = ends(forms) if by_corner is None else self._of_adjacent_faces(by_corner)
        t0, t1 = (None, None) if tangents is None else self._along_edges(tangents)
        return EdgeData(p0, p1, *ends(self.normals), W0, W1, t0, t1)

    def _of_adjacent_faces(self, by_corner: Float) -> tuple[Float, Float]:
        """Values (F, sides, ...) at corners of faces, those of one face at both ends of each edge, (E, ...) each."""
        flat = by_corner.reshape(-1, *by_corner.shape[2:])
        forward, backward = self._half_edges.forward, self._half_edges.backward
        half = np.where(forward >= 0, forward, backward)
        start, end = flat[half], flat[half - half % self.sides + (half + 1) % self.sides]
        runs_back = (forward < 0).reshape(-1, *(1,) * (flat.ndim - 1))
        return np.where(runs_back, end, start), np.where(runs_back, start, end)

    def _along_edges(self, tangents: Float) -> tuple[Float, Float]:
        """Tangents (F, sides, 2, 3) of sides as the edges run, from the lower vertex id to the higher, (E, 3) each."""
        flat = tangents.reshape(-1, 2, 3)
        forward, backward = self._half_edges.forward, self._half_edges.backward
        both = np.where((forward >= 0)[:, None, None], flat[forward], -flat[backward][:, ::-1])
        return both[:, 0], both[:, 1]

    def corner_points(self) -> Float:
        """(F, sides, 3) vertices by face corner."""
        return self.points[self.faces]

    def corner_normals(self, faces: slice | Int = slice(None)) -> Float:
        """(F, sides, 3) unit normals by corner of all faces, or of some; raises ValueError if the mesh has none."""
        if self.normals is None:
            raise ValueError("this mesh has no normals")
        return self.normals[self.faces[faces]]

    def second_form(self, u: Float, v: Float, faces: slice = slice(None)) -> Float:
        """II(u, v) at the corners of all faces, or of some, (F, sides), of vectors (F, sides, 3).

        Raises ValueError if the mesh has no second forms.
        """
        return quadratic_form(u, self.corner_second_forms(faces), v)

    def corner_second_forms(self, faces: slice | Int = slice(None)) -> Float:
        """(F, sides, 3, 3) second forms by corner of all faces, or of some; raises ValueError if the mesh has none."""
        by_corner = self.face_data.corner_second_forms
        if by_corner is not None:
            return by_corner[faces]
        if self.second_forms is None:
            raise ValueError("this mesh has no second fundamental forms")
        return self.second_forms[self.faces[faces]]

    def _changed(self, **data: Any) -> "HermiteMesh":
        names = ("points", "faces", "normals", "second_forms", "face_data", "gradients")
        kept = {name: getattr(self, name) for name in names}
        return HermiteMesh(**{**kept, **data}, normals_from=self.normals_from or "given")

    def _of_vertices(self, vertices: Int, faces: Int, face_data: FaceData) -> "HermiteMesh":
        """Return the mesh of some vertices in an order, with faces that hold the new ids."""
        normals = None if self.normals is None else self.normals[vertices]
        forms = None if self.second_forms is None else self.second_forms[vertices]
        gradients = None if self.gradients is None else self.gradients[vertices]
        return self._changed(
            points=self.points[vertices],
            faces=faces,
            normals=normals,
            second_forms=forms,
            face_data=face_data,
            gradients=gradients,
        )

    def transformed(
        self, rotation: Any = ((1, 0, 0), (0, 1, 0), (0, 0, 1)), translation: Any = (0, 0, 0), scale: float = 1.0
    ) -> "HermiteMesh":
        """Rotate by a matrix (3, 3), scale by a positive number and then move by a vector (3,).

        Normals turn along; second forms and gradients turn and are divided by the scale. ValueError if it is not a
        rotation.
        """
        R = np.asarray(rotation, dtype=np.float64)
        if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-9) or not np.linalg.det(R) > 0:
            raise ValueError(f"{R.tolist()} is not a rotation matrix")
        if not (np.isfinite(scale) and scale > 0):
            raise ValueError(f"the scale {scale} is not a positive number")
        normals = None if self.normals is None else self.normals @ R.T
        forms = None
        if self.second_forms is not None:
            turned = R @ self.second_forms @ R.T / scale
            # the two products round differently; a second form is symmetric to the last bit
            forms = 0.5 * (turned + turned.swapaxes(-1, -2))
        vector = np.asarray(translation, dtype=np.float64)
        points = scale * (self.points @ R.T) + vector
        of_faces = self.face_data.transformed(R, vector, scale)
        gradients = None if self.gradients is None else self.gradients @ R.T / scale
        return self._changed(
            points=points, normals=normals, second_forms=forms, face_data=of_faces, gradients=gradients
        )

    def relabelled(self, order: Int) -> "HermiteMesh":
        """Put the vertices in another order: vertex ``i`` of the new mesh is vertex ``order[i]`` of this one."""
        new_id = inverse_permutation(order, len(self.points))
        return self._of_vertices(order, new_id[self.faces], self.face_data)

    def with_face_order(self, order: Int) -> "HermiteMesh":
        """Put the faces in another order: face ``i`` of the new mesh is face ``order[i]`` of this one."""
        inverse_permutation(order, len(self.faces))
        return self._changed(faces=self.faces[order], face_data=self.face_data.take(order))

    def rotated_corners(self, shift: int | Int = 1) -> "HermiteMesh":
        """Start each face at another corner, at ``shift`` of before; ``shift`` is one number or (F,)."""
        columns = (np.arange(self.sides) + np.reshape(shift, (-1, 1))) % self.sides
        columns = np.broadcast_to(columns, self.faces.shape)
        faces = np.take_along_axis(self.faces, columns, axis=1)
        return self._changed(faces=faces, face_data=self.face_data.rotated(columns))

    def flipped(self) -> "HermiteMesh":
        """Turn the surface inside out: faces run the other way; normals, second forms and gradients are negated."""
        normals = None if self.normals is None else -self.normals
        forms = None if self.second_forms is None else -self.second_forms
        gradients = None if self.gradients is None else -self.gradients
        return self._changed(
            faces=self.faces[:, ::-1],
            normals=normals,
            second_forms=forms,
            face_data=self.face_data.flipped(),
            gradients=gradients,
        )

    def without_second_forms(self) -> "HermiteMesh":
        """Return the mesh with points and normals only."""
        return self._changed(second_forms=None, face_data=self.face_data.without_second_forms())

    def without_normals(self) -> "HermiteMesh":
        """Return the mesh with points only."""
        return self._changed(normals=None, second_forms=None, face_data=FaceData(), gradients=None)

    def with_estimated_normals(self) -> "HermiteMesh":
        """Return the mesh with normals that are means of the faces' normals, weighted with the angles at the vertex.

        Second forms are left out, they belong to other normals. MeshError where the normals about a vertex cancel.
        """
        normals = angle_weighted_normals(self.points, self.faces)
        return HermiteMesh(self.points, self.faces, normals, normals_from="estimated")

    def submesh(self, faces: Int | Bool) -> "HermiteMesh":
        """Return the mesh of some faces, in the order chosen, and their vertices, in the order they have here.

        Raises MeshError if those faces touch in a vertex only.
        """
        chosen = self.faces[faces]
        vertices, new = np.unique(chosen, return_inverse=True)
        return self._of_vertices(vertices, new.reshape(chosen.shape), self.face_data.take(faces))


def angle_weighted_normals(points: Float, faces: Int) -> Float:
    """Return means (V, 3) of the faces' unit normals, weighted with the angles at the vertices; not of length one."""
    corners = points[faces]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    weighted = unit(cross(unit(ahead), unit(back))) * angle_between(unit(ahead), unit(back))[..., None]
    sums = [np.bincount(faces.ravel(), weights=weighted[..., axis].ravel(), minlength=len(points)) for axis in range(3)]
    total: Float = np.stack(sums, axis=-1).astype(np.float64, copy=False)
    check_not_cancelled(total)
    return total


def locked_ids(array: Int) -> Int:
    """Return the array, read-only from now on."""
    array.flags.writeable = False
    return array


def inverse_permutation(order: Int, count: int) -> Int:
    """Return the inverse of a permutation of 0 to count - 1; ValueError if it is none."""
    order = np.asarray(order)
    if not np.array_equal(np.sort(order), np.arange(count)):
        raise ValueError(f"the order is not a permutation of 0 to {count - 1}")
    inverse = np.empty(count, dtype=np.int64)
    inverse[order] = np.arange(count)
    return inverse
