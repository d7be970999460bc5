"""Loop's subdivision (1987): its rules, its limits at the vertices, and the control vertices of a limit through points.

Inside, a step moves a vertex of valence K to (1 - K beta) v + beta (sum of its ring) and puts a vertex on every edge,
3/8 of its ends and 1/8 of the third vertices of its two faces; beta = (5/8 - (3/8 + cos(2 pi / K) / 4)^2) / K. On the
boundary, the cubic B-spline of the boundary vertices alone (Hoppe et al. 1994). **Fill**: a vertex of the boundary with
one face is a corner and stays where it is.
"""

import numpy as np

from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, Int


def subdivided(faces: Triangulation, points: Float) -> Float:
    """Points (V + E, dim) after a step, from the points (V, dim)."""
    return np.concatenate([moved_vertices(faces, points), edge_vertices(faces, points)])


def moved_vertices(faces: Triangulation, points: Float) -> Float:
    """New places of the vertices, (V, dim)."""
    beta, inside = weights(faces.face_count)[:, None], ~faces.on_boundary[:, None]
    averaged = (1.0 - faces.face_count[:, None] * beta) * points + beta * ring_sums(faces, points)
    moved = np.where(inside, averaged, points)
    smooth = smooth_boundary(faces)
    before, after = boundary_neighbours(faces, smooth)
    moved[smooth] = 0.75 * points[smooth] + 0.125 * (points[before] + points[after])
    return moved


def edge_vertices(faces: Triangulation, points: Float) -> Float:
    """New vertices of all edges, (E, dim)."""
    half_edge, twin = faces.half_edge, faces.twin[faces.half_edge]
    ends = points[faces.start[half_edge]] + points[faces.end[half_edge]]
    apexes = points[faces.apex[half_edge]] + points[faces.apex[twin]]
    return np.where((twin >= 0)[:, None], 0.375 * ends + 0.125 * apexes, 0.5 * ends)


def smooth_boundary(faces: Triangulation) -> Int:
    """Vertices (N,) of the boundary that are no corners."""
    return np.flatnonzero(faces.on_boundary & (faces.face_count > 1))


def weights(valence: Int) -> Float:
    """Loop's beta for valences (...)."""
    turn = 0.375 + 0.25 * np.cos(2.0 * np.pi / np.maximum(valence, 1))
    return np.asarray((0.625 - turn * turn) / np.maximum(valence, 1))


def limit_weights(valence: Int) -> Float:
    """Weights chi (...) of the ring in the limit (1 - K chi) v + chi (sum of the ring): 1 / (3 / (8 beta) + K)."""
    return np.asarray(1.0 / (0.375 / weights(valence) + valence))


def limit_points(faces: Triangulation, points: Float) -> Float:
    """Limits (V, dim) of the vertices."""
    chi, inside = limit_weights(faces.face_count)[:, None], ~faces.on_boundary[:, None]
    averaged = (1.0 - faces.face_count[:, None] * chi) * points + chi * ring_sums(faces, points)
    limit = np.where(inside, averaged, points)
    smooth = smooth_boundary(faces)
    before, after = boundary_neighbours(faces, smooth)
    limit[smooth] = (4.0 * points[smooth] + points[before] + points[after]) / 6.0
    return limit


def ring_sums(faces: Triangulation, points: Float) -> Float:
    """Sums of all neighbours of the vertices, (V, dim)."""
    a, b = faces.edges.T
    columns = [
        np.bincount(a, weights=column[b], minlength=faces.vertices)
        + np.bincount(b, weights=column[a], minlength=faces.vertices)
        for column in points.T
    ]
    return np.stack(columns, axis=-1).astype(np.float64, copy=False)


def boundary_neighbours(faces: Triangulation, vertex: Int) -> tuple[Int, Int]:
    """Return the neighbours (N,) of vertices (N,) along the boundary, before them and after them."""
    return faces.start[faces.arriving[vertex]], faces.end[faces.onward[vertex]]


def interpolating_vertices(faces: Triangulation, points: Float) -> Float:
    """Control vertices (V, 3) whose limits are the points (V, 3).

    There always are, and no others. The boundary is a B-spline curve, with a diagonally dominant matrix, by itself.
    Inside, each row divided by chi has the diagonal 3 / (8 beta) and ones for the neighbours; with A the adjacency,
    sum over faces (x_a + x_b + x_c)^2 >= 0 says that x.A x >= -sum K x^2 / 2, and 3 / (8 beta) > K / 2 at every
    valence, so that this matrix is symmetric and positive definite.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import splu

    every, smooth = np.arange(faces.vertices), smooth_boundary(faces)
    chi = limit_weights(faces.face_count)
    diagonal = np.where(faces.on_boundary, 1.0, 1.0 - faces.face_count * chi)
    diagonal[smooth] = 2.0 / 3.0
    a, b = np.concatenate([faces.edges, faces.edges[:, ::-1]]).T
    inside = ~faces.on_boundary[a]
    before, after = boundary_neighbours(faces, smooth)
    rows = np.concatenate([every, a[inside], smooth, smooth])
    columns = np.concatenate([every, b[inside], before, after])
    values = np.concatenate([diagonal, chi[a[inside]], np.full(2 * len(smooth), 1.0 / 6.0)])
    matrix = coo_array((values, (rows, columns)), shape=(faces.vertices, faces.vertices)).tocsc()
    solution: Float = splu(matrix).solve(points)
    return solution
