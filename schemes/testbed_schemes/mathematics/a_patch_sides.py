"""The two sides of an A-patch surface: which tetrahedra stand on a mesh, and F over them.

On the positive side, where the vectors point to, stand the tetrahedra of positive convex and nonconvex faces and edges;
on the negative side those of negative convex and nonconvex ones. Each side is computed in a frame of its own, with
vectors and face normals that point away from the mesh on it; only the surface's patches know the sign of F.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, Int, cross, unit
from testbed_schemes.mathematics.a_patch_classes import Convexity, edge_convexity, face_convexity
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets, face_nets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets, edge_nets
from testbed_schemes.mathematics.a_patch_hull import apex_heights

#: Signs of the sides, the positive one first; what is stored by side is stored in this order.
SIDES = (1.0, -1.0)
#: Faces and edges that have a tetrahedron on each side.
STANDING = ((Convexity.POSITIVE, Convexity.NONCONVEX), (Convexity.NEGATIVE, Convexity.NONCONVEX))


@dataclass(frozen=True, slots=True)
class Hull:
    """A triangle mesh with vectors, its classes and the apexes above and below its faces.

    Attributes
    ----------
    mesh
        The mesh; its gradients are the vectors, pointing to the positive side.
    edges, faces
        (E,) and (F,) classes.
    apexes
        (2, F, 3) by side, NaN where a face has no tetrahedron.
    """

    mesh: HermiteMesh
    edges: Int
    faces: Int
    apexes: Float

    @property
    def vectors(self) -> Float:
        """(V, 3) vectors at the vertices."""
        assert self.mesh.gradients is not None  # noqa: S101 - it is made with them
        return self.mesh.gradients

    def standing_faces(self, side: int) -> Int:
        """Return the faces with a tetrahedron on a side, 0 or 1."""
        return np.flatnonzero(np.isin(self.faces, STANDING[side]))

    def standing_edges(self, side: int) -> Int:
        """Return the edges with a tetrahedron on a side: edges of that class between two faces."""
        return np.flatnonzero(np.isin(self.edges, STANDING[side]) & ~self.mesh.boundary_edges)


def face_normals(corners: Float) -> Float:
    """Unit normals (F, 3) of triangles (F, 3, 3)."""
    return unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def hull(mesh: HermiteMesh, epsilon: float, tolerance: float) -> Hull:
    """Return classes and apexes of a mesh with gradients.

    Parameters
    ----------
    mesh
        Triangles, <n_ijk, n_l> > 0 for every face and its vertices.
    epsilon
        See :func:`~testbed_schemes.mathematics.a_patch_hull.apex_heights`.
    tolerance
        See :func:`~testbed_schemes.mathematics.a_patch_classes.edge_convexity`.
    """
    assert mesh.gradients is not None  # noqa: S101 - as said above
    vectors, (start, end) = mesh.gradients, mesh.edges.T
    edges = edge_convexity((mesh.points[start], mesh.points[end]), (vectors[start], vectors[end]), tolerance)
    faces = face_convexity(edges[mesh.face_edges])
    corners = mesh.corner_points()
    at_corners, normals = vectors[mesh.faces], face_normals(corners)
    apexes = np.full((2, len(faces), 3), np.nan)
    for side, sign in enumerate(SIDES):
        here = np.isin(faces, STANDING[side])
        heights = apex_heights(corners[here], sign * at_corners[here], sign * normals[here], epsilon)
        apexes[side, here] = corners[here].mean(axis=1) + heights[:, None] * (sign * normals[here])
    return Hull(mesh, edges, faces, apexes)


def nets_of_faces(found: Hull, side: int, split: Bool, turns: Float | None = None) -> FaceNets:
    """Return F over the tetrahedra of faces on a side, in its frame.

    Parameters
    ----------
    found
        The hull.
    side
        0 or 1.
    split
        (F,) faces on which F is three cubics.
    turns
        (F, 3, 3) by edge s of a face, pointing to the positive side; see
        :func:`~testbed_schemes.mathematics.a_patch_coefficients.middle_coefficient`.
    """
    faces, sign = found.standing_faces(side), SIDES[side]
    corners = found.mesh.faces[faces]
    return face_nets(
        faces,
        found.mesh.points[corners],
        sign * found.vectors[corners],
        found.apexes[side, faces],
        split[faces],
        None if turns is None else sign * turns[faces],
    )


def nets_of_edges(found: Hull, side: int, nets: FaceNets, top: Float) -> EdgeNets:
    """Return F over the tetrahedra of edges on a side, in its frame, for f0003 = ``top`` in the faces of ``nets``."""
    mesh, edges, sign = found.mesh, found.standing_edges(side), SIDES[side]
    pair = mesh.edge_faces[edges][:, ::-1]  # the face that runs back comes first
    sides = np.argmax(mesh.face_edges[pair] == edges[:, None, None], axis=2)
    start, end = mesh.edges[edges].T
    return edge_nets(
        nets,
        top,
        edges,
        (mesh.points[start], mesh.points[end]),
        (sign * found.vectors[start], sign * found.vectors[end]),
        nets.rows(len(mesh.faces))[pair],
        sides,
    )
