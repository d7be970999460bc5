"""Triangle meshes on a smooth surface made even: short edges collapsed, edges flipped, vertices moved along it.

Every pass works on all edges at once and changes a set of places that do not touch each other.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.geometry.edges import HalfEdges
from testbed.geometry.vectors import Bool, Float, Int, angle_between, cross, dot, norm, tangential, unit

#: Edges shorter than this times the wanted length are collapsed.
SHORT: Final = 0.6
#: Rounds of collapsing, flipping and moving, passes of the first two at most, and steps of the last.
ROUNDS, PASSES, MOVES = 4, 30, 3
#: Least cosine of the angle between a face and the surface's normals at its corners, after a change.
FACING: Final = 0.3
#: An edge is flipped if the angles opposite to it sum up to more than pi by this, in radians.
FLIP: Final = 1e-3


@dataclass(frozen=True)
class SurfaceMesh:
    """A triangle mesh on a surface that is cut off by planes x = const, y = const and z = const.

    Parameters
    ----------
    points
        (V, 3) vertices on the surface.
    faces
        (F, 3) vertex ids.
    held
        (V, 3) coordinates in which a vertex lies on a cutting plane and stays there.
    project
        Puts points (N, 3) onto the surface, keeping the coordinates (N, 3) that are held.
    normal
        Unit normals (N, 3) of the surface at points (N, 3).
    """

    points: Float
    faces: Int
    held: Bool
    project: Callable[[Float, Bool], Float]
    normal: Callable[[Float], Float]

    def facing(self, corners: Float) -> Float:
        """Least cosines (N,) of the angles of triangles (N, 3, 3) with the normals at their corners; NaN if flat."""
        n = self.normal(corners.reshape(-1, 3)).reshape(corners.shape)
        flat = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
        least: Float = dot(n, flat[:, None]).min(axis=1)
        return least


def evened(mesh: SurfaceMesh, length: float) -> SurfaceMesh:
    """Return the mesh with edges of about a wanted length, of the same topology, without needles.

    Changes that would turn a face away from the surface's normals are left out.
    """
    for _ in range(ROUNDS):
        mesh = _until_settled(lambda one: collapsed(one, SHORT * length), mesh)
        mesh = _until_settled(flipped, mesh)
        for _ in range(MOVES):
            mesh = moved(mesh)
    return mesh


def _until_settled(change: Callable[[SurfaceMesh], SurfaceMesh], mesh: SurfaceMesh) -> SurfaceMesh:
    """Repeat a change of faces until it changes nothing."""
    for _ in range(PASSES):
        changed = change(mesh)
        if np.array_equal(changed.faces, mesh.faces):
            break
        mesh = changed
    return mesh


def _edges(faces: Int) -> HalfEdges:
    return HalfEdges.between(faces.ravel(), np.roll(faces, -1, axis=1).ravel())


def _ring_faces(faces: Int, vertices: int, of: Int) -> tuple[Int, Int]:
    """Pairs (rows of ``of``, faces) of all faces at given vertices."""
    order = np.argsort(faces.ravel(), kind="stable")
    count = np.bincount(faces.ravel(), minlength=vertices)
    first = np.cumsum(count) - count
    row = np.repeat(np.arange(len(of)), count[of])
    within = np.arange(len(row)) - np.repeat(np.cumsum(count[of]) - count[of], count[of])
    return row, order[first[of][row] + within] // 3


def _apart(row: Int, face: Int, rank: Int, faces: int) -> Bool:
    """Rows that have the lowest rank at each of their faces; ranks are all different."""
    best = np.full(faces, len(rank))
    np.minimum.at(best, face, rank[row])
    won: Bool = np.ones(len(rank), dtype=np.bool_)
    won[row[best[face] != rank[row]]] = False
    return won


def collapsed(mesh: SurfaceMesh, shortest: float) -> SurfaceMesh:
    """Collapse edges below a length, the shortest first, as far as the mesh stays a manifold of the same topology.

    The vertex that is left is the middle of the edge on the surface, or the end that is on more cutting planes; an edge
    is left whose ends are on different ones, or which joins two places of the boundary.
    """
    faces, count = mesh.faces, len(mesh.points)
    halves = _edges(faces)
    i, j = halves.ids.T
    length = norm(mesh.points[i] - mesh.points[j])
    boundary = (halves.forward < 0) | (halves.backward < 0)
    edge = np.flatnonzero((length < shortest) & _may_collapse(mesh, halves, boundary))
    edge = edge[np.argsort(length[edge], kind="stable")]
    i, j = i[edge], j[edge]
    # where the vertex goes that is left
    more_i, more_j = (mesh.held[i] & ~mesh.held[j]).any(axis=1), (mesh.held[j] & ~mesh.held[i]).any(axis=1)
    middle = 0.5 * (mesh.points[i] + mesh.points[j])
    held = mesh.held[i] | mesh.held[j]
    target = np.where(more_i[:, None], mesh.points[i], np.where(more_j[:, None], mesh.points[j], middle))
    target = np.where((more_i | more_j)[:, None], target, mesh.project(target, held))
    row, face = (np.concatenate(pair) for pair in zip(*(_ring_faces(faces, count, end) for end in (i, j)), strict=True))
    # faces at the edge vanish, the others must not turn over or become needles
    at_i, at_j = faces[face] == i[row, None], faces[face] == j[row, None]
    stays = ~(at_i.any(axis=1) & at_j.any(axis=1))
    corners = np.where((at_i | at_j)[..., None], target[row, None], mesh.points[faces[face]])
    good = np.array(np.isfinite(target).all(axis=1))
    bad = stays & ~(mesh.facing(corners) > np.fmin(FACING, mesh.facing(mesh.points[faces[face]])))
    good[row[bad]] = False
    chosen = np.flatnonzero(good)
    kept = good[row]
    renumbered = np.cumsum(good) - 1
    winner = chosen[_apart(renumbered[row[kept]], face[kept], np.arange(len(chosen)), len(faces))]
    points, new_held, name = mesh.points.copy(), mesh.held.copy(), np.arange(count)
    points[i[winner]], new_held[i[winner]], name[j[winner]] = target[winner], held[winner], i[winner]
    merged = name[faces]
    merged = merged[(merged != np.roll(merged, -1, axis=1)).all(axis=1)]
    used, new = np.unique(merged, return_inverse=True)
    return SurfaceMesh(points[used], new.reshape(merged.shape), new_held[used], mesh.project, mesh.normal)


def _may_collapse(mesh: SurfaceMesh, halves: HalfEdges, boundary: Bool) -> Bool:
    """(E,) edges whose collapse keeps the topology: the ends have no neighbours in common but those of their faces."""
    faces, count = mesh.faces, len(mesh.points)
    i, j = halves.ids.T
    rim = np.zeros(count, dtype=np.bool_)
    rim[halves.ids[boundary]] = True
    valence = np.bincount(halves.ids.ravel(), minlength=count)
    more_i, more_j = (mesh.held[i] & ~mesh.held[j]).any(axis=1), (mesh.held[j] & ~mesh.held[i]).any(axis=1)
    good: Bool = ~(rim[i] & rim[j] & ~boundary) & ~(more_i & more_j)
    both = mesh.held[i] & mesh.held[j]
    good &= (~both | (mesh.points[i] == mesh.points[j])).all(axis=1) & (both.sum(axis=1) < 2)
    opposite = np.full((len(halves.ids), 2), -1)
    for column, half in enumerate((halves.forward, halves.backward)):
        there = half >= 0
        opposite[there, column] = faces[half[there] // 3, (half[there] % 3 + 2) % 3]
    for column in range(2):
        there = opposite[:, column] >= 0
        at = opposite[there, column]
        good[there] &= valence[at] > np.where(rim[at], 2, 3)
    common = _common_neighbours(halves.ids, count)
    good &= common == (opposite >= 0).sum(axis=1)
    return good


def _common_neighbours(edges: Int, count: int) -> Int:
    """Numbers (E,) of vertices that are neighbours of both ends of an edge."""
    from scipy.sparse import csr_array  # slow to import

    ends = np.concatenate([edges, edges[:, ::-1]])
    adjacent = csr_array((np.ones(len(ends), dtype=np.int64), (ends[:, 0], ends[:, 1])), shape=(count, count))
    return np.asarray((adjacent[edges[:, 0]] * adjacent[edges[:, 1]]).sum(axis=1)).ravel()


def flipped(mesh: SurfaceMesh) -> SurfaceMesh:
    """Flip edges whose opposite angles sum up to more than pi, where the new faces follow the surface."""
    faces, points = mesh.faces, mesh.points
    halves = _edges(faces)
    edge = np.flatnonzero((halves.forward >= 0) & (halves.backward >= 0))
    one, other = halves.forward[edge], halves.backward[edge]
    a, b = halves.ids[edge].T
    c, d = faces[one // 3, (one % 3 + 2) % 3], faces[other // 3, (other % 3 + 2) % 3]

    def angle(at: Int, p: Int, q: Int) -> Float:
        u, v = points[p] - points[at], points[q] - points[at]
        return angle_between(u, v)

    excess = angle(c, a, b) + angle(d, a, b) - np.pi
    keys = halves.ids[:, 0] * len(points) + halves.ids[:, 1]
    exists = np.isin(np.minimum(c, d) * len(points) + np.maximum(c, d), keys)
    valence = np.bincount(halves.ids.ravel(), minlength=len(points))
    rim = np.array(mesh.held.any(axis=1))  # an edge between two places of the boundary would cut it off
    good = (excess > FLIP) & ~exists & (valence[a] > 3) & (valence[b] > 3) & ~(rim[c] & rim[d])
    # face (a, b, c) runs along the edge forward, (b, a, d) back: they become (a, d, c) and (d, b, c)
    first, second = np.stack([a, d, c], axis=-1), np.stack([d, b, c], axis=-1)
    now = np.minimum(mesh.facing(points[faces[one // 3]]), mesh.facing(points[faces[other // 3]]))
    then = np.minimum(mesh.facing(points[first]), mesh.facing(points[second]))
    good &= then > np.fmin(FACING, now)
    chosen = np.flatnonzero(good)
    chosen = chosen[np.argsort(-excess[chosen], kind="stable")]
    row = np.concatenate([np.arange(len(chosen))] * 2)
    face = np.concatenate([one[chosen] // 3, other[chosen] // 3])
    # two flips beside each other could make the same edge: faces around count as touched too
    winner = chosen[_apart(*_widened(faces, len(points), row, face), np.arange(len(chosen)), len(faces))]
    changed = faces.copy()
    changed[one[winner] // 3], changed[other[winner] // 3] = first[winner], second[winner]
    return SurfaceMesh(points, changed, mesh.held, mesh.project, mesh.normal)


def _widened(faces: Int, vertices: int, row: Int, face: Int) -> tuple[Int, Int]:
    """Pairs of rows and faces, and of the same rows and the faces at the corners of those."""
    at, around = _ring_faces(faces, vertices, faces[face].ravel())
    return row[at // 3], around


def moved(mesh: SurfaceMesh) -> SurfaceMesh:
    """Move vertices halfway to the mean of their neighbours, along the surface, those on the boundary along that.

    A vertex stays if a face there would turn away from the normals.
    """
    halves = _edges(mesh.faces)
    i, j = halves.ids.T
    points, count = mesh.points, len(mesh.points)
    boundary = (halves.forward < 0) | (halves.backward < 0)
    rim = np.zeros(count, dtype=np.bool_)
    rim[halves.ids[boundary]] = True
    # boundary vertices look at their neighbours along the boundary only
    total, number = np.zeros((count, 3)), np.zeros(count)
    for at, to in ((i, j), (j, i)):
        counts = boundary | ~rim[at]
        np.add.at(total, at[counts], points[to[counts]])
        np.add.at(number, at[counts], 1.0)
    fixed = (mesh.held.sum(axis=1) > 1) | (rim & (mesh.held.sum(axis=1) == 0))
    way = np.where(mesh.held, 0.0, total / number[:, None] - points)
    there = mesh.project(points + 0.5 * tangential(way, mesh.normal(points)) * ~mesh.held, mesh.held)
    there = np.where((fixed | ~np.isfinite(there).all(axis=1))[:, None], points, there)
    for _ in range(PASSES):
        turned = ~(mesh.facing(there[mesh.faces]) > np.fmin(FACING, mesh.facing(points[mesh.faces])))
        back = np.zeros(count, dtype=np.bool_)
        back[mesh.faces[turned]] = True
        back = np.array(back & np.any(there != points, axis=1))
        if not back.any():
            break
        there = np.where(back[:, None], points, there)
    return SurfaceMesh(there, mesh.faces, mesh.held, mesh.project, mesh.normal)
