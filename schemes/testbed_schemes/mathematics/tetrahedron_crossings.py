"""Which of many tetrahedra cross: pairs whose boxes meet, found by sweeping, and separating planes between them.

Two convex polyhedra have no inner point in common if and only if a plane parallel to a face of one of them, or to an
edge of each, has them on its two sides; for tetrahedra 8 + 36 directions decide. Tetrahedra that only touch, in a
common vertex, edge or face for instance, do not cross.

The tetrahedra of an A-patch surface must not cross. Xu, Huang and Bajaj 2001 see to it for neighbours only; here all
are looked at. On the testbed's meshes there were no crossings wherever neighbours were apart, except after refinement
that left hardly any room between vectors and faces.
"""

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm
from testbed_schemes.mathematics.a_patch_sides import Hull

#: Corners of the faces and of the edges of a tetrahedron.
FACES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
#: Tetrahedra that enter each other by less than this part of their size touch.
TOUCH = 1e-9
#: Pairs looked at together.
CHUNK = 8192
#: Directions shorter than this, of vectors of length one, are those of parallel edges and say nothing.
PARALLEL = 1e-9


def hull_tetrahedra(found: Hull) -> Float:
    """Return the tetrahedra (N, 4, 3) of a hull: for each side those of its faces, then those of its edges."""
    mesh, result = found.mesh, []
    for side in range(2):
        faces, edges = found.standing_faces(side), found.standing_edges(side)
        above = found.apexes[side]
        ends, beside = mesh.points[mesh.edges[edges]], above[mesh.edge_faces[edges]]
        result.append(np.concatenate([mesh.points[mesh.faces[faces]], above[faces, None]], axis=1))
        result.append(np.concatenate([ends, beside], axis=1))
    return np.concatenate(result)


def crossing_pairs(tetrahedra: Float) -> Int:
    """Return the pairs (M, 2) of tetrahedra (N, 4, 3) that have inner points in common, in lexicographic order."""
    chunks = _pairs_of_boxes(tetrahedra.min(axis=1), tetrahedra.max(axis=1))
    found = [pairs[cross_each_other(tetrahedra[pairs[:, 0]], tetrahedra[pairs[:, 1]])] for pairs in chunks]
    pairs = np.sort(np.concatenate([np.empty((0, 2), dtype=np.int64), *found]), axis=1)
    return pairs[np.lexsort(pairs.T[::-1])]


def cross_each_other(one: Float, other: Float) -> Bool:
    """Return whether tetrahedra (N, 4, 3) and (N, 4, 3) have inner points in common, row by row."""
    size = np.maximum(*(norm(corners - corners[:, :1]).max(axis=1) for corners in (one, other)))
    scaled = [(corners - one[:, :1]) / size[:, None, None] for corners in (one, other)]
    edges = []
    separated = np.zeros(len(one), dtype=np.bool_)
    for corners in scaled:
        first, second, third = np.moveaxis(corners[:, FACES], 2, 0)
        separated |= _separate(cross(second - first, third - first), *scaled)
        along = corners[:, EDGES[:, 1]] - corners[:, EDGES[:, 0]]
        edges.append(along / norm(along)[..., None])
    (left,) = np.nonzero(~separated)
    axes = cross(edges[0][left, :, None], edges[1][left, None]).reshape(-1, 36, 3)
    separated[left] = _separate(axes, *(corners[left] for corners in scaled))
    return ~separated


def _separate(axes: Float, one: Float, other: Float) -> Bool:
    """Return whether one of the directions (N, A, 3) parts tetrahedra of size one."""
    length = norm(axes)
    along = [dot(axes[:, :, None], corners[:, None]) for corners in (one, other)]
    depth = np.minimum(
        along[0].max(axis=2) - along[1].min(axis=2), along[1].max(axis=2) - along[0].min(axis=2)
    )  # how far they overlap
    parted: Bool = np.any((length > PARALLEL) & (depth <= TOUCH * length), axis=1)
    return parted


def _pairs_of_boxes(low: Float, high: Float) -> list[Int]:
    """Pairs (M, 2) of boxes from ``low`` to ``high`` (N, 3) that meet, in chunks."""
    order = np.argsort(low[:, 0], kind="stable")
    low, high = low[order], high[order]
    # in this order, those that begin before a box ends follow it directly
    count = np.searchsorted(low[:, 0], high[:, 0], side="right") - np.arange(len(low)) - 1
    found = []
    start = 0
    total = np.concatenate([[0], np.cumsum(count)])
    while start < len(low):
        end = int(np.searchsorted(total, total[start] + 64 * CHUNK, side="right")) - 1
        end = min(max(end, start + 1), len(low))
        first = np.repeat(np.arange(start, end), count[start:end])
        second = first + 1 + np.arange(len(first)) - np.repeat(total[start:end] - total[start], count[start:end])
        meet: Bool = np.all((low[first] <= high[second]) & (low[second] <= high[first]), axis=1)
        pairs = np.stack([order[first[meet]], order[second[meet]]], axis=-1)
        found.extend(np.array_split(pairs, max(1, -(-len(pairs) // CHUNK))))
        start = end
    return found
