"""Normals at the vertices of triangles from the faces about them, the small ones counting most (Si 2015, section 2.6).

With unit normals n_i and areas A_i of the faces at a vertex, and n_i*, A_i* of the face across the edge of face i that
is opposite to the vertex, n_i* = n_i and A_i* = 0 where there is none, the normal points along

    inside            sum n_i / A_i
    on the boundary   sum [(2 A_i + A_i*) n_i - A_i n_i*] / (A_i + A_i*) / A_i.

The second one is sum (2 n_i - e_i) / A_i with e_i = (A_i* n_i + A_i n_i*) / (A_i + A_i*) the mean by inverse areas on
that edge: an extrapolation from there through the face to the vertex.

Formulas: corrected. As printed, n_i* is the cross product of the edges of face i itself, which is -n_i; the third
vertex of the face across is meant, with the orientation of n_i. Fill: the extrapolation may point away from a face at
the vertex where the data are steep. Then the mean is taken on the boundary, too, and where that does so the direction
from which the faces are seen best (:mod:`testbed.geometry.cone_axes`), if there is one.
"""

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.cone_axes import cone_axes, face_normals, fans
from testbed.geometry.triangulation import Triangulation, following
from testbed.geometry.vectors import Bool, Float, Int, dot, norm

#: A sum of unit vectors that is shorter than this times the sum of their weights has no direction.
CANCELLED = 1e-12


def inverse_area_normals(points: Float, faces: Int) -> Float:
    """Return the unit normals (V, 3), outward for faces counterclockwise from outside.

    Parameters
    ----------
    points
        (V, 3) vertices.
    faces
        (F, 3) vertex ids of an oriented manifold, with or without boundary; each vertex belongs to a face.

    Raises
    ------
    MeshError
        Normals about a vertex cancel out; the message names it. Quadrilaterals.
    """
    if faces.shape[1] != 3:
        raise MeshError("normals by inverse areas are those of triangles, and the faces have four vertices: split them")
    complex_ = Triangulation(faces, len(points))
    of_faces, areas = face_normals(points, faces)
    weights = np.repeat(areas.min() / areas, 3)
    own = np.repeat(of_faces, 3, axis=0)
    inside = sums(complex_, weights, own)
    outside = sums(complex_, weights, 2.0 * own - across(complex_, of_faces, areas))
    normals = np.where(complex_.on_boundary[:, None], outside, inside)
    normals = np.where(sees_all(complex_, of_faces, normals)[:, None], normals, inside)
    hidden = np.flatnonzero(~sees_all(complex_, of_faces, normals))
    axes, cosines = cone_axes(of_faces[fans(complex_, hidden)])
    normals[hidden] = np.where((cosines > 0.0)[:, None], axes, normals[hidden])
    length = norm(normals)
    least = CANCELLED * sums(complex_, weights, np.ones((len(weights), 1)))[:, 0]
    if not (length > least).all():  # written so that NaN is refused
        vertex = int(np.argmin(length > least))
        raise MeshError(
            f"the normals of the faces at vertex {vertex} cancel out: give normals, or move it or its neighbours"
        )
    return normals / length[:, None]


def across(faces: Triangulation, normals: Float, areas: Float) -> Float:
    """Return the means e (3 F, 3) on the edge opposite to the corner that each half edge starts from."""
    own = np.repeat(np.arange(len(areas)), 3)
    twin = faces.twin[following(np.arange(3 * len(areas)))]
    other = np.where(twin >= 0, twin // 3, own)
    size, other_size = areas[own][:, None], np.where(twin >= 0, areas[other], 0.0)[:, None]
    mean: Float = (other_size * normals[own] + size * normals[other]) / (size + other_size)
    return mean


def sums(faces: Triangulation, weights: Float, values: Float) -> Float:
    """Return weighted sums (V, k) over the corners at each vertex, of (3 F,) weights and (3 F, k) values."""
    columns = [np.bincount(faces.start, weights=weights * column, minlength=faces.vertices) for column in values.T]
    return np.stack(columns, axis=-1)


def sees_all(faces: Triangulation, of_faces: Float, normals: Float) -> Bool:
    """(V,) true where a vector points to the outer side of all faces at the vertex."""
    behind = ~(dot(normals[faces.faces], of_faces[:, None]) > 0.0)
    result = np.ones(faces.vertices, dtype=np.bool_)
    result[faces.faces[behind]] = False
    return result
