"""The quartic box spline on regular triangulations, as Bezier triangles, and its reflection beyond boundaries.

Over a face whose corners have valence 6, Loop's limit surface is one polynomial of degree 4 of the twelve control
vertices of the face and of those next to it (Loop 1987; Stam 1998). They are ordered: corner 0; its ring from corner 1
on, counterclockwise; then, where they are not among these, the rings of corner 1 and of corner 2.

A triangulation with a boundary becomes regular there by reflections: beyond the boundary edge a, b of a face with third
vertex c lies a + b - c. Subdivision of the whole then gives the cubic B-spline along the boundary, at a vertex with
three faces, and fixed corners, at a vertex with one; and reflections stay reflections.
"""

import numpy as np

from testbed.geometry.evaluation import apply_table
from testbed.geometry.triangulation import Triangulation, following, preceding
from testbed.geometry.vectors import Float, Int

#: 24 times the Bezier points (15, by decreasing i, then decreasing j) from the control vertices (12).
_TABLE = (
    (12, 2, 2, 2, 2, 2, 2, 0, 0, 0, 0, 0),
    (12, 4, 3, 1, 0, 1, 3, 0, 0, 0, 0, 0),
    (12, 3, 4, 3, 1, 0, 1, 0, 0, 0, 0, 0),
    (8, 8, 4, 0, 0, 0, 4, 0, 0, 0, 0, 0),
    (10, 6, 6, 1, 0, 0, 1, 0, 0, 0, 0, 0),
    (8, 4, 8, 4, 0, 0, 0, 0, 0, 0, 0, 0),
    (4, 12, 3, 0, 0, 0, 3, 1, 0, 1, 0, 0),
    (6, 10, 6, 0, 0, 0, 1, 0, 0, 1, 0, 0),
    (6, 6, 10, 1, 0, 0, 0, 0, 0, 1, 0, 0),
    (4, 3, 12, 3, 0, 0, 0, 0, 0, 1, 0, 1),
    (2, 12, 2, 0, 0, 0, 2, 2, 2, 2, 0, 0),
    (3, 12, 4, 0, 0, 0, 1, 0, 1, 3, 0, 0),
    (4, 8, 8, 0, 0, 0, 0, 0, 0, 4, 0, 0),
    (3, 4, 12, 1, 0, 0, 0, 0, 0, 3, 1, 0),
    (2, 2, 12, 2, 0, 0, 0, 0, 0, 2, 2, 2),
)


def bezier_nets(control_vertices: Float) -> Float:
    """Quartic nets (N, 15, dim) of the patches over faces with control vertices (N, 12, dim)."""
    nets: Float = apply_table(np.array([_TABLE]) / 24.0, control_vertices)[0]
    return nets


def patch_vertices(faces: Triangulation, half_edge: Int) -> Int:
    """Control vertices (N, 12) of faces, given by the half edges (N,) that start at corner 0.

    The corners have valence 6, and their rings are complete.
    """
    first, second = following(half_edge), preceding(half_edge)
    return np.concatenate(
        [
            faces.start[half_edge][:, None],
            faces.ring(half_edge, 6),
            faces.ring(first, 6)[:, 3:],
            faces.ring(second, 5)[:, 3:],
        ],
        axis=1,
    )


def reflected(faces: Triangulation, points: Float) -> tuple[Triangulation, Float]:
    """Add the faces beyond the boundary, and their vertices, behind the others.

    Vertices of the boundary with three faces get the valence 6, and so do those with one, where the two neighbours are
    reflected in the vertex too.

    Parameters
    ----------
    faces
        The triangulation.
    points
        (V, dim).
    """
    (edge,) = np.nonzero(faces.twin < 0)
    if not len(edge):
        return faces, points
    a, b, c = faces.start[edge], faces.end[edge], faces.apex[edge]
    # the reflection beyond a boundary half edge, by its start
    beyond = np.full(faces.vertices, -1, dtype=np.int64)
    beyond[a] = faces.vertices + np.arange(len(edge))
    before = faces.start[faces.arriving[a]]
    added = [points[a] + points[b] - points[c]]
    new = [np.stack([b, a, beyond[a]], axis=-1)]
    single = faces.face_count[a] == 1
    new.append(np.stack([a, beyond[before], beyond[a]], axis=-1)[~single])
    corner, onward, back = a[single], b[single], before[single]
    added += [2.0 * points[corner] - points[onward], 2.0 * points[corner] - points[back]]
    first = faces.vertices + len(edge) + np.arange(len(corner))
    second = first + len(corner)
    fan = [beyond[back], first, second, beyond[corner]]
    new += [np.stack([corner, fan[step], fan[step + 1]], axis=-1) for step in range(3)]
    points = np.concatenate([points, *added])
    return Triangulation(np.concatenate([faces.faces, *new]), len(points)), points
