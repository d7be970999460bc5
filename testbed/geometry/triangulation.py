"""Triangulations: who meets whom in a mesh of triangles, and its one-to-four refinement.

Half edge 3 f + s is side s of face f, from its corner s to the next; its twin runs the other way in the neighbouring
face and is -1 on the boundary. A step of refinement keeps the vertices, with their ids, and puts a vertex on every
edge, with ids from V on. Face f becomes the faces 4 f + i, of which the first three keep corner i as their corner i and
the last one joins the new vertices, its corner i opposite corner i of f. Nothing here knows where points are.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.geometry.edges import HalfEdges
from testbed.geometry.vectors import Bool, Int


@dataclass(frozen=True, eq=False)
class Triangulation:
    """An oriented manifold of triangles, with or without boundary.

    Parameters
    ----------
    faces
        (F, 3) vertex ids, counterclockwise.
    vertices
        Number of vertices, V.
    """

    faces: Int
    vertices: int

    @cached_property
    def _half_edges(self) -> HalfEdges:
        return HalfEdges.between(self.start, self.end)

    @cached_property
    def start(self) -> Int:
        """(3 F,) vertex each half edge starts from."""
        return self.faces.reshape(-1)

    @cached_property
    def end(self) -> Int:
        """(3 F,) vertex each half edge ends at."""
        return self.start[following(np.arange(self.faces.size))]

    @cached_property
    def apex(self) -> Int:
        """(3 F,) third vertex of the face of each half edge."""
        return self.start[preceding(np.arange(self.faces.size))]

    @property
    def edges(self) -> Int:
        """(E, 2) vertex ids, the lower first, in lexicographic order."""
        return self._half_edges.ids

    @property
    def edge(self) -> Int:
        """(3 F,) edge of each half edge."""
        return self._half_edges.edge

    @cached_property
    def half_edge(self) -> Int:
        """(E,) a half edge of each edge: the one from the lower vertex id to the higher where there is one."""
        return np.where(self._half_edges.forward >= 0, self._half_edges.forward, self._half_edges.backward)

    @cached_property
    def twin(self) -> Int:
        """(3 F,) the half edge that runs the other way, -1 on the boundary."""
        forward, backward = self._half_edges.forward[self.edge], self._half_edges.backward[self.edge]
        both = (forward >= 0) & (backward >= 0)
        return np.where(both, forward + backward - np.arange(self.faces.size), -1)

    @cached_property
    def face_count(self) -> Int:
        """(V,) faces at each vertex."""
        return np.bincount(self.start, minlength=self.vertices).astype(np.int64, copy=False)

    @cached_property
    def onward(self) -> Int:
        """(V,) the half edge of the boundary that starts at a vertex, -1 inside."""
        return self._along_boundary(self.start)

    @cached_property
    def arriving(self) -> Int:
        """(V,) the half edge of the boundary that ends at a vertex, -1 inside."""
        return self._along_boundary(self.end)

    def _along_boundary(self, vertex: Int) -> Int:
        (boundary,) = np.nonzero(self.twin < 0)
        result = np.full(self.vertices, -1, dtype=np.int64)
        result[vertex[boundary]] = boundary
        return result

    @property
    def on_boundary(self) -> Bool:
        """(V,) true for vertices on the boundary."""
        bounding: Bool = self.onward >= 0
        return bounding

    @cached_property
    def outgoing(self) -> Int:
        """(V,) a half edge from each vertex, on the boundary the one with no face to its right."""
        result = np.full(self.vertices, -1, dtype=np.int64)
        result[self.start] = np.arange(self.faces.size)
        return np.where(self.on_boundary, self.onward, result)

    def counterclockwise(self, half_edge: Int) -> Int:
        """Return the next half edges from the same vertices, -1 where the boundary is in between."""
        return self.twin[preceding(half_edge)]

    def clockwise(self, half_edge: Int) -> Int:
        """Return the half edges before them from the same vertices, -1 where the boundary is in between."""
        twin = self.twin[half_edge]
        return np.where(twin < 0, -1, following(twin))

    def ring(self, half_edge: Int, count: int) -> Int:
        """Ends (N, count) of ``count`` half edges counterclockwise about the starts of (N,) half edges, these first.

        About a vertex on the boundary the last one may be the end of the boundary edge that closes its fan.
        """
        result = np.empty((len(half_edge), count), dtype=np.int64)
        for step in range(count):
            result[:, step] = self.end[half_edge]
            ahead = self.counterclockwise(half_edge)
            if step + 2 == count and (ahead < 0).any():
                closing = self.apex[half_edge]
                result[:, -1] = np.where(ahead < 0, closing, self.end[ahead])
                break
            half_edge = ahead
        return result

    def fan_place(self, half_edge: Int) -> Int:
        """Places (N,) of half edges in the fans of their starts: 0 on the boundary, -1 about vertices inside."""
        bounding = self.on_boundary[self.start[half_edge]]
        place = np.where(bounding, 0, -1)
        behind = np.where(bounding, self.clockwise(half_edge), -1)
        while (behind >= 0).any():
            place += behind >= 0
            behind = np.where(behind >= 0, self.clockwise(behind), -1)
        return place

    def refined(self) -> "Triangulation":
        """Return the faces after one step."""
        middle = self.vertices + self.edge.reshape(-1, 3)
        a, b, c = self.faces.T
        ab, bc, ca = middle.T
        pieces = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
        faces = np.stack([np.stack(piece, axis=-1) for piece in pieces], axis=1)
        return Triangulation(faces.reshape(-1, 3), self.vertices + len(self.edges))


def following(half_edge: Int) -> Int:
    """Return the next half edges in the same faces."""
    return np.asarray(np.where(half_edge % 3 == 2, half_edge - 2, half_edge + 1))


def preceding(half_edge: Int) -> Int:
    """Return the half edges before them in the same faces."""
    return np.asarray(np.where(half_edge % 3 == 0, half_edge + 2, half_edge - 1))
