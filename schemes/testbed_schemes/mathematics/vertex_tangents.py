"""End tangents of boundary curves from chords projected onto the tangent planes (Si 2015, section 5.2).

At a vertex with normal N the tangent along an edge is its chord d projected along a direction h,

    T = d - (d . N) / (h . N) h,

orthogonally if h = N. Projected triangles of neighbouring faces overlap, and surfaces over them fold, unless h points
to the same side of all faces at the vertex as of the tangent plane: then h is replaced by the axis of the narrowest
cone about the faces' normals and N.

Formulas: as printed for h = N, but for the fold, of which the source shows a figure and no remedy: a fill. So is the
projection along one direction everywhere: with it and the exact normals of z = q(x, y), q quadratic, curves along z
over chords are those of the graph.
"""

import numpy as np

from testbed.geometry.cone_axes import cone_axes, face_normals, fans
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Bool, Float, Int, dot

#: The least cosine of the angle between h and the normals of the faces, and between h and N where it is another vector.
LEAST = 0.05


def projections(points: Float, faces: Int, normals: Float, along: Float | None = None) -> tuple[Float, Bool]:
    """Return the directions h (V, 3) and where they are not the one asked for (V,).

    Where no direction keeps projected faces apart the normal is returned: faces fold, or normals are turned over.

    Parameters
    ----------
    points, normals
        (V, 3) vertices and unit normals.
    faces
        (F, 3) vertex ids.
    along
        (3,) unit vector to project along where it keeps faces apart; None asks for the normals.
    """
    of_faces, _ = face_normals(points, faces)
    steep = steepness(faces, of_faces, normals, normals)
    directions = normals.copy()
    replaced = steep <= LEAST
    if along is not None:
        usable = steepness(faces, of_faces, normals, np.broadcast_to(along, normals.shape)) > LEAST
        directions[usable] = along
        replaced = ~usable
        steep = np.where(usable, np.inf, steep)
    folded = np.flatnonzero(~(steep > LEAST))
    around = of_faces[fans(Triangulation(faces, len(points)), folded)]
    axes, cosines = cone_axes(np.concatenate([around, normals[folded, None]], axis=1))
    found = cosines > 0.0
    directions[folded[found]] = axes[found]
    return directions, replaced


def steepness(faces: Int, of_faces: Float, normals: Float, directions: Float) -> Float:
    """(V,) the least cosine of a direction, or its opposite, with the normals of the faces at a vertex and its own.

    Not positive where these are seen from different sides.
    """
    cosines = dot(directions[faces], of_faces[:, None])
    least = dot(directions, normals)
    most = least.copy()
    np.minimum.at(least, faces, cosines)
    np.maximum.at(most, faces, cosines)
    return np.asarray(np.maximum(least, -most))


def project(chord: Float, normal: Float, direction: Float) -> Float:
    """Return chords (..., 3) projected along directions onto the planes perpendicular to unit normals."""
    return chord - (dot(chord, normal) / dot(direction, normal))[..., None] * direction
