"""Normals of Loop's limit surface (1987) at the vertices of its control mesh: t1 x t2 of two tangents each.

Inside, with the K vertices p_j around the vertex, counterclockwise, t1 = sum cos(2 pi j / K) p_j and t2 = sum
sin(2 pi j / K) p_j. On the boundary (Hoppe et al. 1994), with p_1, ..., p_k the neighbours of the vertex p, the first
and the last along the boundary, t1 = p_1 - p_k and inwards

    k = 2      t2 = p_1 + p_2 - 2 p
    k = 3      t2 = p_2 - p
    k = 4      t2 = 2 (p_2 + p_3 - p) - p_1 - p_4
    k >= 5     t2 = 2 (1 - cos(theta)) sum sin((i - 1) theta) p_i - sin(theta) (p_1 + p_k), theta = pi / (k - 1)

Formulas: as printed, the signs of t2 turned inwards. From k = 5 on these belong to the authors' own rule for boundary
edges next to such a vertex, 3/8 of it and 5/8 of its neighbour in place of the midpoint, with which there is a tangent
plane at every valence; :mod:`testbed.geometry.loop_subdivision` keeps the midpoint, and its limits have other normals
there. The neighbours of such a vertex along the boundary take the masks of vertices farther from it. A vertex of the
mesh is not a point of its limit surface: this is an estimate of normals, exact on planes.
"""

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Bool, Float, Int, cross, norm

#: A tangent shorter than this times the longest edge at the vertex, or two that enclose a smaller angle, are rounding.
VANISHED = 1e-12


def loop_limit_normals(points: Float, faces: Int) -> Float:
    """Return the unit normals (V, 3) of Loop's limit surface, outward for faces counterclockwise from outside.

    Parameters
    ----------
    points
        (V, 3) vertices.
    faces
        (F, 3) vertex ids of an oriented manifold, with or without boundary.

    Raises
    ------
    MeshError
        The two tangents at a vertex are parallel, or one vanishes; the message names the vertex. Quadrilaterals.
    """
    if faces.shape[1] != 3:
        raise MeshError("Loop's normals are those of triangles, and the faces have four vertices: split them")
    along, inward, longest = limit_tangents(Triangulation(faces, len(points)), points)
    with np.errstate(invalid="ignore", divide="ignore"):  # zero by zero: NaN, refused below
        t1, t2 = along / norm(along)[:, None], inward / norm(inward)[:, None]
    normals = cross(t1, t2)
    length = norm(normals)
    # written so that NaN is refused
    sound = (norm(along) > VANISHED * longest) & (norm(inward) > VANISHED * longest) & (length > VANISHED)
    if not sound.all():
        vertex = int(np.argmin(sound))
        raise MeshError(
            f"Loop's limit surface has no normal at vertex {vertex}, where its tangents are parallel or vanish: "
            "give normals, or move the vertex or its neighbours"
        )
    return normals / length[:, None]


def limit_tangents(faces: Triangulation, points: Float) -> tuple[Float, Float, Float]:
    """Return t1 and t2 (V, 3) at all vertices, and the longest edge (V,) at each."""
    count = len(points)
    neighbours = faces.face_count + faces.on_boundary
    along, inward, longest = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros(count)
    vertex, half_edge = np.arange(count), faces.outgoing
    place = 0
    while len(vertex):  # once around all vertices together
        # differences, so that far from the origin nothing cancels; the weights of a tangent sum to zero with the centre
        spoke = points[_ends(faces, vertex, half_edge)] - points[vertex]
        along_weight, inward_weight = tangent_weights(neighbours[vertex], faces.on_boundary[vertex], place)
        along[vertex] += along_weight[:, None] * spoke
        inward[vertex] += inward_weight[:, None] * spoke
        longest[vertex] = np.maximum(longest[vertex], norm(spoke))
        place += 1
        ahead = np.where(half_edge >= 0, faces.counterclockwise(half_edge), -1)
        left = place < neighbours[vertex]
        vertex, half_edge = vertex[left], ahead[left]
    return along, inward, longest


def _ends(faces: Triangulation, vertex: Int, half_edge: Int) -> Int:
    """Neighbours (N,) of vertices at the ends of half edges; -1 stands for the edge that closes a fan."""
    closing = faces.start[faces.arriving[vertex]]
    return np.where(half_edge >= 0, faces.end[half_edge], closing)


def tangent_weights(neighbours: Int, on_boundary: Bool, place: int) -> tuple[Float, Float]:
    """Weights (N,) in t1 and in t2 of the neighbour at a place in the ring, counted from 0.

    Parameters
    ----------
    neighbours
        (N,) how many there are.
    on_boundary
        (N,) whether the vertex is on the boundary; the first and the last neighbour then are, too.
    place
        Which neighbour.
    """
    turn = 2.0 * np.pi * place / neighbours
    last = place == neighbours - 1
    first = np.full(len(neighbours), place == 0)
    theta = np.pi / np.maximum(neighbours - 1, 1)
    ends = first | last
    inner = np.where(ends, -np.sin(theta), 2.0 * (1.0 - np.cos(theta)) * np.sin(place * theta))
    for count, at_end, between in ((2, 1.0, 0.0), (3, 0.0, 1.0), (4, -1.0, 2.0)):
        inner = np.where(neighbours == count, np.where(ends, at_end, between), inner)
    bounded = np.where(first, 1.0, np.where(last, -1.0, 0.0)), inner
    along = np.where(on_boundary, bounded[0], np.cos(turn))
    inward = np.where(on_boundary, bounded[1], np.sin(turn))
    return along, inward
