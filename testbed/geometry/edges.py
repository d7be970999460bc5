"""The edges of a complex of polygons, found from the ids at their corners: of a mesh's faces, of a surface's patches.

A half edge is a side of a polygon with its direction; two half edges between the same two ids, one running each way,
are the two sides of an interior edge.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.errors import PluginError
from testbed.geometry.vectors import Bool, Int


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Half edges sorted into edges.

    Parameters
    ----------
    ids
        (E, 2) ids at the ends of the edges, the lower first, in lexicographic order.
    edge
        (H,) the edge of each half edge.
    forward, backward
        (E,) the half edge from the lower id to the higher, and the one back; -1 where there is none.
    repeated
        (R,) half edges that run between the same ids in the same direction as another before them; none in a manifold
        with one orientation.
    """

    ids: Int
    edge: Int
    forward: Int
    backward: Int
    repeated: Int

    @classmethod
    def between(cls, start: Int, end: Int, strand: Int | None = None) -> "HalfEdges":
        """Sort the half edges from ids ``start`` (H,) to ids ``end`` (H,), which are not negative.

        Of several curves between the same ids, each makes an edge of its own, if ``strand`` (H,) tells which it is.
        """
        runs_back = start > end
        low, high = np.where(runs_back, end, start), np.where(runs_back, start, end)
        key = low * (high.max(initial=0) + 1) + high
        if strand is not None:
            key = key * (strand.max(initial=0) + 1) + strand
        key = key * 2 + runs_back
        order = np.argsort(key)
        key = key[order]
        first = np.ones(len(key), dtype=np.bool_)
        first[1:] = (key[1:] >> 1) != (key[:-1] >> 1)
        edge = np.empty(len(key), dtype=np.int64)
        edge[order] = np.cumsum(first) - 1
        representative = order[first]
        ids = np.stack([low[representative], high[representative]], axis=-1)
        forward, backward = np.full((2, len(ids)), -1, dtype=np.int64)
        half_edges = np.arange(len(key))
        forward[edge[~runs_back]] = half_edges[~runs_back]
        backward[edge[runs_back]] = half_edges[runs_back]
        return cls(ids, edge, forward, backward, order[1:][key[1:] == key[:-1]])


@dataclass(frozen=True, eq=False)
class PatchSides:
    """Sides of patches of a surface.

    Parameters
    ----------
    part
        (E,) index of the part, -1 where there is no patch.
    patch
        (E,) index of the patch in the part's batch, -1 where there is none.
    side
        (E,) side of the patch, from its corner ``side`` to the next, -1 where there is none.
    face
        (E,) mesh face the patch came from, -1 where there is none.
    """

    part: Int
    patch: Int
    side: Int
    face: Int

    def __len__(self) -> int:
        return len(self.part)

    def __getitem__(self, chosen: Int | Bool | slice) -> "PatchSides":
        return PatchSides(self.part[chosen], self.patch[chosen], self.side[chosen], self.face[chosen])

    def or_none(self, chosen: Int) -> "PatchSides":
        """Return the chosen sides, with -1 everywhere where ``chosen`` is -1."""
        none = chosen < 0
        return PatchSides(
            *(np.where(none, -1, values[chosen]) for values in (self.part, self.patch, self.side, self.face))
        )


@dataclass(frozen=True, eq=False)
class PatchEdges:
    """All edges of a surface's patches, the inner ones of split domains included.

    Parameters
    ----------
    ids
        (E, 2) corner ids at the start and the end of each edge, as the left side runs.
    left
        The side that runs along the edge; on interior edges from the lower id to the higher.
    right
        The side of the neighbour, which runs the other way: parameter t on the left is the same point as 1 - t here;
        part, patch, side and face are -1 on the boundary.
    """

    ids: Int
    left: PatchSides
    right: PatchSides

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, chosen: Int | Bool | slice) -> "PatchEdges":
        return PatchEdges(self.ids[chosen], self.left[chosen], self.right[chosen])

    @property
    def interior(self) -> Bool:
        """(E,) true where there is a patch on both sides."""
        return self.right.part >= 0

    @property
    def boundary(self) -> Bool:
        """(E,) true where there is a patch on one side only."""
        return self.right.part < 0

    @property
    def within_face(self) -> Bool:
        """(E,) true for the inner edges of split faces: both patches came from the same mesh face."""
        inner: Bool = self.left.face == self.right.face
        return inner


def patch_edges(corner_ids: Sequence[Int], faces: Sequence[Int], strands: Sequence[Int] | None = None) -> PatchEdges:
    """Find the edges of a surface from its parts' ``corner_ids`` (P, sides) and mesh ``faces`` (P,).

    A side with the same id at both ends is a point and makes no edge. Where several curves join the same corners, the
    parts' ``strands`` (P, sides) tell them apart.

    Raises
    ------
    PluginError
        Two patch sides run between the same corner ids in the same direction: three patches on an edge, or two of
        opposite orientation.
    """
    rows = [np.empty((7, 0), dtype=np.int64)]
    strands = [np.zeros_like(ids) for ids in corner_ids] if strands is None else strands
    for index, (ids, face, strand) in enumerate(zip(corner_ids, faces, strands, strict=True)):
        patch, side = np.indices(ids.shape)
        part, mesh_face = np.full_like(ids, index), np.broadcast_to(face[:, None], ids.shape)
        ahead = np.roll(ids, -1, axis=1)
        rows.append(np.stack([ids, ahead, strand, part, patch, side, mesh_face])[:, ids != ahead])
    start, end, strand, *place = np.concatenate(rows, axis=1)
    sides = PatchSides(*place)
    halves = HalfEdges.between(start, end, strand)
    if len(halves.repeated):
        bad = int(halves.repeated[0])
        beside = sides[halves.edge == halves.edge[bad]]
        found = ", ".join(
            f"patch {patch} of part {part} (mesh face {face})"
            for part, patch, face in zip(beside.part, beside.patch, beside.face, strict=True)
        )
        raise PluginError(
            f"the surface's patches do not fit together on the edge from corner {start[bad]} to corner {end[bad]}, "
            f"a side of {found}: give each edge at most one patch on either side, all of one orientation"
        )
    left = np.where(halves.forward >= 0, halves.forward, halves.backward)
    right = np.where(halves.forward >= 0, halves.backward, -1)
    return PatchEdges(np.stack([start[left], end[left]], axis=-1), sides[left], sides.or_none(right))
