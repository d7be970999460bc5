"""What boundary curves must satisfy at the corners of the faces they bound, before a patch can be regular there."""

import numpy as np

from testbed.errors import Refused
from testbed.geometry.blocks import blocks
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_checks import FLATNESS, named
from testbed.geometry.vectors import Bool, Float, cross, dot
from testbed.plugins.base import Plugin

#: Two tangents are on one line if the sine of their angle is this much smaller than at the corner of the face itself:
#: rounding of tangents that are projected along a normal in the plane of the face, and lose half of their digits.
IN_PLANE = 1e-8


def check_corners(plugin: Plugin, mesh: HermiteMesh, start: Float, end: Float) -> None:
    """Refuse boundary curves that leave a corner of a face along one line: no patch has a tangent plane there.

    Parameters
    ----------
    plugin
        Whom the message names.
    mesh
        The mesh.
    start, end
        (E, 3) tangents of the curves at the lower and at the higher vertex id of each edge, both away from their
        vertex, scaled as one wishes.

    Raises
    ------
    Refused
        The message names the first such corner.
    """
    tangents, place = _planar(start, end), dot(mesh.points, mesh.points)

    def singular(faces: slice) -> Bool:
        # squares: they stay within the range of floats for all lengths that a mesh may have
        sine, least = _square_sine(*_corner_tangents(mesh, faces, tangents))
        with np.errstate(invalid="ignore", divide="ignore"):  # no tangent: singular
            rounding = FLATNESS**2 * np.maximum(1.0, place[mesh.faces[faces]] / least)
        unfit: Bool = ~(sine > np.maximum(rounding, IN_PLANE**2))  # NaN is unfit
        if unfit.any():  # unless the corner of the face is as narrow
            corners = mesh.corner_points()[faces]
            flat_sine, _ = _square_sine(np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners)
            unfit = ~(sine > np.maximum(rounding, IN_PLANE**2 * flat_sine))
        return unfit

    _refuse(
        plugin,
        mesh,
        np.concatenate([singular(faces) for faces in blocks(len(mesh.faces))]),
        "leaves no tangent plane at {corner}, where the curves along its sides start along one line or do not start at "
        "all: the normal may lie in the face or along an edge, turn it or move the vertex",
    )


def check_sides(plugin: Plugin, mesh: HermiteMesh, start: Float, end: Float) -> None:
    """Refuse normals on different sides of neighbouring faces or of one face, as the boundary curves see it.

    Where tangent planes are continuous, the normal turns along an edge from the one given at its start to the one given
    at its end. A patch whose own normal agrees with one and is opposite to the other is singular somewhere between, and
    two patches of which one agrees and one is opposite lie over each other along their edge.

    Parameters
    ----------
    plugin, mesh, start, end
        As for :func:`check_corners`; the mesh has normals.

    Raises
    ------
    Refused
        The message names the first such corner.
    """
    normals, tangents = mesh.corner_normals(), _planar(start, end)

    def agrees(faces: slice) -> Bool:
        onward, back = _corner_tangents(mesh, faces, tangents)
        return np.greater(dot(cross(onward, back), normals[faces]), 0.0)

    outward = np.concatenate([agrees(faces) for faces in blocks(len(mesh.faces))])
    if outward.all() or not outward.any():  # as it should be
        return
    vertex = np.empty(len(mesh.points), dtype=np.bool_)
    vertex[mesh.faces] = outward
    differs = outward != vertex[mesh.faces]
    vertex[:] = False
    vertex[mesh.faces[differs]] = True
    mixed = vertex[mesh.faces] | (outward != outward[:, :1]).any(axis=1, keepdims=True)
    # the fewer of those that disagree are the ones to mend
    _refuse(
        plugin,
        mesh,
        mixed & (outward != (np.count_nonzero(outward[mixed]) * 2 >= np.count_nonzero(mixed))),
        "folds over at {corner}: there the face turns about the normal the other way than at other corners next to it, "
        "turn the normal round or move the vertex",
    )


def _planar(start: Float, end: Float) -> Float:
    """Tangents at the lower vertex ids of all edges, then those at the higher, (2 E, 3), each component contiguous."""
    return np.ascontiguousarray(np.concatenate([start, end]).T).T


def _corner_tangents(mesh: HermiteMesh, faces: slice, tangents: Float) -> tuple[Float, Float]:
    """Tangents (F, sides, 3) at the corners of some faces, along the side to the next corner and to the previous."""
    edges, forward = mesh.face_edges[faces], mesh.face_edge_forward[faces]
    opposite = edges + len(mesh.edges)
    onward, back = np.where(forward, edges, opposite), np.roll(np.where(forward, opposite, edges), 1, axis=1)
    return np.moveaxis(tangents.T.take(onward, axis=1), 0, -1), np.moveaxis(tangents.T.take(back, axis=1), 0, -1)


def _square_sine(a: Float, b: Float) -> tuple[Float, Float]:
    """Squares of the sine of the angle between vectors and of the length of the shorter one."""
    normal, sizes = cross(a, b), (dot(a, a), dot(b, b))
    with np.errstate(invalid="ignore", divide="ignore"):  # no tangent: NaN
        return dot(normal, normal) / (sizes[0] * sizes[1]), np.minimum(*sizes)


def _refuse(plugin: Plugin, mesh: HermiteMesh, corners: Bool, why: str) -> None:
    """Raise Refused if any corner (F, sides) is unfit."""
    if corners.any():
        face, corner = (int(index[0]) for index in np.nonzero(corners))
        where = f"vertex {mesh.faces[face, corner]} of {named(mesh.faces, face)}"
        first = f"{where}, the first of {int(corners.sum())} such corners" if corners.sum() > 1 else where
        raise Refused(f"{plugin} {why.format(corner=first)}")
