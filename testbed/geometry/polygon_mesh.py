"""Meshes of polygons with any numbers of corners: control meshes, and the OBJ files they come in."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.edges import HalfEdges
from testbed.geometry.mesh_checks import checked_points
from testbed.geometry.vectors import Bool, Float, Int


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """An oriented manifold of polygons, with or without boundary; checked at construction, immutable.

    A *corner* is a vertex of a face, and the side that leaves it there: corners are numbered face by face. Arrays over
    the corners say how they hang together, so that nothing walks over faces.

    Parameters
    ----------
    points
        (V, 3) vertices, each of them in a face.
    faces
        Vertex ids of each face, three or more, counterclockwise seen from outside.

    Attributes
    ----------
    face, vertex
        (C,) face and vertex of each corner.
    following, previous
        (C,) the next corner of the same face and the one before.
    twin
        (C,) the corner whose side runs back along this one's, in the neighbouring face; -1 on the boundary.

    Raises
    ------
    MeshError
        One sentence that names the face, edge or vertex.
    """

    points: Float
    faces: tuple[tuple[int, ...], ...]
    face: Int
    vertex: Int
    following: Int
    previous: Int
    twin: Int

    def __init__(self, points: Float, faces: Sequence[Sequence[int]]) -> None:
        data = {"points": checked_points(points), "faces": tuple(tuple(int(i) for i in face) for face in faces)}
        vars(self).update(data)
        sizes = np.array([len(face) for face in self.faces], dtype=np.int64)
        if not len(sizes):
            raise MeshError("the control mesh is empty, it has no faces: give at least one face")
        if (sizes < 3).any():
            face = int(np.argmax(sizes < 3))
            raise MeshError(f"face {face} has {sizes[face]} vertices: give three or more")
        first = np.repeat(np.cumsum(sizes) - sizes, sizes)
        place, size = np.arange(sizes.sum()) - first, np.repeat(sizes, sizes)
        vertex = np.array([i for face in self.faces for i in face], dtype=np.int64)
        following = first + (place + 1) % size
        face_of = np.repeat(np.arange(len(sizes)), sizes)
        check_ids(vertex, face_of, len(self.points))
        halves = HalfEdges.between(vertex, vertex[following])
        check_edges(halves, face_of)
        corners = np.arange(len(vertex))
        along = halves.forward[halves.edge] == corners
        arrays = {
            "face": face_of,
            "vertex": vertex,
            "following": following,
            "previous": first + (place - 1) % size,
            "twin": np.where(along, halves.backward[halves.edge], halves.forward[halves.edge]),
        }
        for array in (self.points, *arrays.values()):
            array.flags.writeable = False
        vars(self).update(arrays)
        self._check_rings()

    def _check_rings(self) -> None:
        """Check that the corners at each vertex make one ring or one fan."""
        corners = np.arange(len(self.vertex))
        # the next corner about the vertex, counterclockwise, lies across the side that ends there
        around = self.twin[self.previous]
        lowest, step = corners, np.where(around < 0, corners, around)
        last = around < 0
        for _ in range(int(np.bincount(self.vertex).max()).bit_length()):
            lowest = np.minimum(lowest, lowest[step])
            step = step[step]
        # a fan is known by its last corner, a ring by its lowest
        piece = np.where(last[step], step, lowest)
        one = np.empty(len(self.points), dtype=np.int64)
        one[self.vertex] = piece
        torn = one[self.vertex] != piece
        if torn.any():
            raise MeshError(
                f"vertex {self.vertex[torn].min()} is not manifold, its faces make separate fans or rings: give each "
                "its own copy of the vertex"
            )

    @property
    def sizes(self) -> Int:
        """(F,) number of corners of each face."""
        return np.bincount(self.face).astype(np.int64, copy=False)

    @property
    def first_corner(self) -> Int:
        """(F,) the first corner of each face; the others follow."""
        return np.asarray(np.cumsum(self.sizes) - self.sizes)

    @property
    def inside(self) -> Bool:
        """(V,) true for vertices that are not on the boundary."""
        result = np.ones(len(self.points), dtype=np.bool_)
        boundary = self.twin < 0
        result[self.vertex[boundary]] = False
        result[self.vertex[self.following[boundary]]] = False
        return result

    @property
    def valence(self) -> Int:
        """(V,) number of faces at each vertex; that of edges too, inside."""
        return np.bincount(self.vertex, minlength=len(self.points)).astype(np.int64, copy=False)


def check_ids(vertex: Int, face: Int, vertices: int) -> None:
    """Check that corners hold ids of vertices, each face different ones, and that every vertex is in a face."""
    outside = (vertex < 0) | (vertex >= vertices)
    if outside.any():
        corner = int(np.argmax(outside))
        raise MeshError(
            f"face {face[corner]} has vertex {vertex[corner]}, but the vertices are 0 to {vertices - 1}: correct the "
            "index"
        )
    order = np.lexsort((vertex, face))
    twice = (np.diff(vertex[order]) == 0) & (np.diff(face[order]) == 0)
    if twice.any():
        corner = int(order[np.argmax(twice)])
        raise MeshError(f"face {face[corner]} has vertex {vertex[corner]} more than once: remove or mend the face")
    unused = np.bincount(vertex, minlength=vertices) == 0
    if unused.any():
        raise MeshError(f"vertex {int(np.argmax(unused))} is in no face: remove vertices without a face")


def check_edges(halves: HalfEdges, face: Int) -> None:
    """Check that each edge has two faces at most, which run along it in opposite directions."""
    if len(halves.repeated):
        edge = int(halves.edge[halves.repeated].min())
        i, j = halves.ids[edge].tolist()
        beside = face[halves.edge == edge].tolist()
        where = f"the edge between vertices {i} and {j}, a side of faces {', '.join(map(str, beside))},"
        if len(beside) > 2:
            raise MeshError(f"{where} is not manifold: leave two faces at most on an edge")
        raise MeshError(f"{where} is run along by both in the same direction: reverse the vertices of one of them")


def load_polygons(path: str | PathLike[str]) -> PolygonMesh:
    """Read a mesh of polygons from a Wavefront OBJ file, with its polygons as they are.

    Lines ``v`` and ``f`` are read, the latter with or without indices of textures and normals, relative indices too;
    everything else in the file is of no matter here.

    Raises
    ------
    MeshError
        One sentence that names the file, and the line where one is wrong.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise MeshError(f"{path} cannot be read ({error.strerror}): give the path of an OBJ file") from error
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(lines, start=1):
        kind, *words = line.split("#", 1)[0].split() or [""]
        try:
            if kind == "v":
                x, y, z = map(float, words[:3])
                points.append([x, y, z])
            elif kind == "f":
                ids = [int(word.split("/")[0]) for word in words]
                faces.append([index - 1 if index > 0 else len(points) + index for index in ids])
        except ValueError as error:
            raise MeshError(f"{path}: line {number} is no vertex or face: {line.strip()!r}, correct it") from error
    if not points or not faces:
        raise MeshError(f"{path} holds no faces: give a Wavefront OBJ file with lines v and f")
    try:
        return PolygonMesh(np.array(points), faces)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
