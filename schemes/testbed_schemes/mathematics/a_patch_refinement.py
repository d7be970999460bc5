"""Where tetrahedra of neighbouring A-patches cross, and the local refinement that parts them (XHB 2001, section 3.1).

About an edge p_i p_j stand, on one side of the mesh, the face p_k, the apex u_k of its tetrahedron, the apex u_l of the
other face's, and that face p_l. The tetrahedra of the faces are disjoint, and the tetrahedron of the edge fits between
them, if the angles from p_k on grow in this order and that of the edge is below pi. Edges where they do not are split
by the butterfly's rule, their faces divided, and normals and tetrahedra made again, a few times.

Formulas: the rule as printed. **Fill**: the test, which the paper leaves to the reader ("do not intersect"); divisions
of faces with several such edges; vectors at new vertices, of which the paper says that they are computed again: Loop's
limit normal of the refined mesh, as long as the mean of the vectors at the edge's ends; and a second way of refining
where the paper's does not end. Only neighbours are tested: tetrahedra of faces that share no edge may cross.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from testbed.errors import MeshError, Refused
from testbed.geometry.domain import CORNERS, barycentric
from testbed.geometry.loop_normals import loop_limit_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.subdomains import to_face
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm, tangential, unit
from testbed_schemes.mathematics.butterfly_stencil import edge_vertices

#: The butterfly's w with which it reproduces cubics on regular triangulations.
TENSION = 1.0 / 16.0
#: Diagonals whose lengths differ by less than this part count as equal.
TIE = 1e-9
#: Pieces of a triangle by the number of sides with a new vertex, as places in (corners a, b, c; middles of ab, bc, ca);
#: the sides with one come first, but for two of them the quadrilateral is divided either way.
PIECES = {
    0: [[0, 1, 2]],
    1: [[0, 3, 2], [3, 1, 2]],
    2: [[3, 1, 4], [0, 3, 2], [3, 4, 2]],
    -2: [[3, 1, 4], [0, 3, 4], [0, 4, 2]],
    3: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [4, 5, 3]],
}


@dataclass(frozen=True, eq=False)
class RefinedMesh:
    """A mesh of triangles some of whose edges were split.

    Attributes
    ----------
    mesh
        The refined mesh; the vertices of the original keep their ids.
    parent
        (F',) the face of the original mesh that each face is a piece of.
    corners_in_parent
        (F', 3, 2) parameters of its corners there.
    splits
        Edges split.
    beside
        Those of them at which no tetrahedra cross, a remedy that is not the paper's.
    """

    mesh: HermiteMesh
    parent: Int
    corners_in_parent: Float
    splits: int
    beside: int = 0

    @classmethod
    def unrefined(cls, mesh: HermiteMesh) -> "RefinedMesh":
        """Return a mesh no edge of which is split."""
        count = len(mesh.faces)
        return cls(mesh, np.arange(count), np.broadcast_to(CORNERS[3], (count, 3, 2)), 0)

    def followed_by(self, finer: "RefinedMesh") -> "RefinedMesh":
        """Return the refinement of the original mesh that a refinement of the refined mesh makes."""
        corners = to_face(self.corners_in_parent[finer.parent][:, None], finer.corners_in_parent)
        splits, beside = self.splits + finer.splits, self.beside + finer.beside
        return RefinedMesh(finer.mesh, self.parent[finer.parent], corners, splits, beside)


def wedge_angles(mesh: HermiteMesh, apexes: Float) -> Float:
    """Return angles about the edges on both sides of the mesh, (2, E, 3), in [0, 2 pi).

    Parameters
    ----------
    mesh
        Triangles.
    apexes
        (2, F, 3) apexes of the tetrahedra above and below the faces, NaN where there is none.

    Returns
    -------
    angles
        Of u_k, u_l and p_l from p_k, where k is the face that runs along the edge forward; measured through the
        positive side in the first row, through the negative one in the second. NaN where there is no apex or, on the
        boundary, no face.
    """
    (i, j), (forward, backward) = mesh.edges.T, mesh.edge_faces.T
    total = mesh.faces.sum(axis=1)
    third = np.where(mesh.edge_faces >= 0, total[mesh.edge_faces] - (i + j)[:, None], i[:, None])
    origin = mesh.points[i]
    axis = unit(mesh.points[j] - origin)
    across = unit(tangential(mesh.points[third[:, 0]] - origin, axis))
    up = cross(axis, across)

    def angle(point: Float, side: float) -> Float:
        away = point - origin
        return np.mod(np.arctan2(side * dot(away, up), dot(away, across)), 2.0 * np.pi)

    angles = [
        np.stack(
            [angle(above[forward], side), angle(above[backward], side), angle(mesh.points[third[:, 1]], side)], axis=-1
        )
        for above, side in zip(apexes, (1.0, -1.0), strict=True)
    ]
    return np.where(mesh.boundary_edges[:, None], np.nan, np.stack(angles))


def crossing_edges(mesh: HermiteMesh, apexes: Float) -> Bool:
    """Return the edges (E,) at which tetrahedra of the two faces cross, or that of the edge turns inside out.

    Needed are 0 < u_k < u_l < p_l and u_l - u_k < pi of the angles of :func:`wedge_angles`, for those of u_k and u_l
    that there are.
    """
    u_k, u_l, p_l = np.moveaxis(wedge_angles(mesh, apexes), -1, 0)
    apart = ~((u_l <= u_k) | (u_l - u_k >= np.pi))  # true where one is missing
    inside = [np.isnan(apex) | ((apex > 0.0) & (apex < p_l)) for apex in (u_k, u_l)]
    crossing: Bool = ~(apart & inside[0] & inside[1]).all(axis=0)
    return crossing


def split_edges(mesh: HermiteMesh, edges: Bool, *, loop: bool = False) -> RefinedMesh:
    """Split edges by the butterfly's rule, and divide their faces.

    Parameters
    ----------
    mesh
        Triangles.
    edges
        (E,) which edges to split.
    loop
        Whether all normals are Loop's limit normals, made again; otherwise those of the vertices that there are stay,
        and if the mesh has none the refined one has none.

    Raises
    ------
    MeshError
        Two faces lie back to back, a face degenerates, or Loop's limit surface has no normal; the message names the
        vertex or the face.
    """
    triangles = Triangulation(mesh.faces, len(mesh.points))
    folded = ~triangles.on_boundary & (triangles.face_count == 2)
    if folded.any():
        raise MeshError(
            f"no edge can be split at vertex {int(np.argmax(folded))}, where two faces lie back to back: remove them"
        )
    new = edge_vertices(triangles, mesh.points, triangles.half_edge[edges], TENSION)
    points = np.concatenate([mesh.points, new])
    middle = np.full(len(edges), -1)
    middle[edges] = np.arange(len(mesh.points), len(points))
    faces, parent, corners = divided_faces(points, mesh.faces, middle[mesh.face_edges])
    normals, gradients = refined_vectors(mesh, points, faces, mesh.edges[edges], loop=loop)
    finer = HermiteMesh(points, faces, normals, gradients=gradients)
    return RefinedMesh(finer, parent, corners, len(new))


def refined_vectors(
    mesh: HermiteMesh, points: Float, faces: Int, ends: Int, *, loop: bool
) -> tuple[Float | None, Float | None]:
    """Return normals and gradients (V', 3) of a refined mesh; ``ends`` (N, 2) are those of the split edges."""
    if mesh.normals is None and not loop:
        return None, None
    normals = loop_limit_normals(points, faces)
    if not loop:
        normals[: len(mesh.points)] = mesh.normals
    if mesh.gradients is None:
        return normals, None
    lengths = norm(mesh.gradients)
    gradients = np.concatenate([lengths, 0.5 * (lengths[ends[:, 0]] + lengths[ends[:, 1]])])[:, None] * normals
    if not loop:
        gradients[: len(mesh.points)] = mesh.gradients
    return normals, gradients


def divided_faces(points: Float, faces: Int, middles: Int) -> tuple[Int, Int, Float]:
    """Divide triangles some of whose sides have a new vertex.

    A side with one is joined to the opposite corner. Two are joined to each other, and the quadrilateral that is left
    is divided along its shorter diagonal, of two as long as each other along the one from the vertex of the side that
    comes first. Three make four triangles.

    Parameters
    ----------
    points
        (V', 3) vertices, old and new.
    faces
        (F, 3) vertices of the faces.
    middles
        (F, 3) the new vertices of their sides, -1 where there is none.

    Returns
    -------
    faces
        (F', 3) vertices of the pieces, face by face.
    parent
        (F',) their faces.
    corners_in_parent
        (F', 3, 2) parameters of their corners there.
    """
    split = middles >= 0
    count = split.sum(axis=1)
    # turned so that the one split side comes first, of two the one before the other
    first = np.where(count == 2, (np.argmin(split, axis=1) + 1) % 3, np.argmax(split, axis=1))
    turn = (first[:, None] + np.arange(3)) % 3
    nodes = np.concatenate([np.take_along_axis(faces, turn, axis=1), np.take_along_axis(middles, turn, axis=1)], axis=1)
    places = np.concatenate([CORNERS[3], 0.5 * (CORNERS[3] + np.roll(CORNERS[3], -1, axis=0))])
    places = places[np.concatenate([turn, 3 + turn], axis=1)]
    a, _, c, ab, bc, _ = np.moveaxis(points[nodes], 1, 0)
    other_way = (count == 2) & (norm(bc - a) < (1.0 - TIE) * norm(c - ab))
    pattern = np.where(other_way, -2, count)
    pieces, parent, corners = [], [], []
    for kind, chosen in PIECES.items():
        (rows,) = np.nonzero(pattern == kind)
        pieces.append(nodes[rows][:, chosen].reshape(-1, 3))
        parent.append(np.repeat(rows, len(chosen)))
        corners.append(places[rows][:, chosen].reshape(-1, 3, 2))
    order = np.argsort(np.concatenate(parent), kind="stable")
    return np.concatenate(pieces)[order], np.concatenate(parent)[order], np.concatenate(corners)[order]


def separated_hull(
    mesh: HermiteMesh, apexes: Callable[[HermiteMesh], Float], most: int, *, loop: bool = False
) -> RefinedMesh:
    """Refine a mesh until tetrahedra of neighbouring faces do not cross.

    The edges where they cross are split, as in the paper. If that does not part them, the mesh is refined anew with the
    longest sides of the faces at these edges split as well.

    Parameters
    ----------
    mesh
        Triangles.
    apexes
        From a mesh to the apexes (2, F, 3) of the tetrahedra above and below its faces, NaN where there is none;
        Refused where none can be found.
    most
        How often edges may be split in either way.
    loop
        See :func:`split_edges`.

    Raises
    ------
    Refused
        Tetrahedra still cross after that, or the refined mesh has none; the message names the edge of the mesh. Or the
        mesh itself has none.
    """
    crossing = crossing_edges(mesh, apexes(mesh))
    if not crossing.any():
        return RefinedMesh.unrefined(mesh)
    reasons = []
    for longest in (False, True) if most else ():
        try:
            return _parted(mesh, crossing, apexes, most, loop=loop, longest=longest)
        except (MeshError, Refused) as error:
            reasons.append(str(error))
    place = edge_place(mesh.faces, RefinedMesh.unrefined(mesh), int(np.argmax(crossing)))
    raise Refused(
        f"the tetrahedra on the faces at {place} cross ({int(crossing.sum())} such edges), and refinement does not "
        f"part them: {reasons[0] if reasons else 'it is not allowed'}; give a finer mesh or other normals there"
    )


def _parted(
    mesh: HermiteMesh,
    crossing: Bool,
    apexes: Callable[[HermiteMesh], Float],
    most: int,
    *,
    loop: bool,
    longest: bool,
) -> RefinedMesh:
    """Refine in one way; Refused, or MeshError, if that leads nowhere."""
    refined = RefinedMesh.unrefined(mesh)
    for level in range(1, most + 1):
        chosen = crossing | longest_sides(refined.mesh, crossing) if longest else crossing
        step = split_edges(refined.mesh, chosen, loop=loop)
        refined = refined.followed_by(replace(step, beside=int((chosen & ~crossing).sum())))
        try:
            found = apexes(refined.mesh)
        except Refused as error:  # in words about vertices that the mesh given does not have
            raise Refused(f"no tetrahedra stand on the mesh of step {level}") from error
        crossing = crossing_edges(refined.mesh, found)
        if not crossing.any():
            return refined
    place = edge_place(mesh.faces, refined, int(np.argmax(crossing)))
    raise Refused(f"in the mesh of step {most} they cross at {place}")


def longest_sides(mesh: HermiteMesh, edges: Bool) -> Bool:
    """Return the edges (E,) that are the longest side of a face at one of the edges (E,); all that are equally long."""
    lengths = norm(mesh.points[mesh.edges[:, 1]] - mesh.points[mesh.edges[:, 0]])[mesh.face_edges]
    beside: Bool = np.any(edges[mesh.face_edges], axis=1)
    chosen = np.zeros(len(edges), dtype=np.bool_)
    chosen[mesh.face_edges[beside[:, None] & (lengths >= (1.0 - TIE) * lengths.max(axis=1, keepdims=True))]] = True
    return chosen


def edge_place(faces: Int, refined: RefinedMesh, edge: int) -> str:
    """Say where an edge of a refined mesh lies in the original, of the given faces: along an edge, or inside a face."""
    finer = refined.mesh
    face = int(finer.edge_faces[edge].max())
    side = int(np.argmax(finer.face_edges[face] == edge))
    bary = barycentric(refined.corners_in_parent[face, [side, (side + 1) % 3]])
    parent = int(refined.parent[face])
    on_side: Bool = np.all(bary == 0.0, axis=0)  # exact: all places are sums of powers of 1/2
    vertices = faces[parent]
    if on_side.any():
        i, j = sorted(vertices[~on_side].tolist())
        piece = "the edge" if (bary.max(axis=1) == 1.0).all() else "a piece of the edge"
        return f"{piece} between vertices {i} and {j}"
    i, j, k = sorted(vertices.tolist())
    return f"an edge inside face {parent}, of vertices {i}, {j} and {k}"
