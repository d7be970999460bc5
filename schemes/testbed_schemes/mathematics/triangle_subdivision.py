"""One-to-four refinement of meshes of triangles by schemes: where the pieces lie, and what is refused.

Vertices, faces and half edges are numbered as in :mod:`testbed.geometry.triangulation`.
"""

import numpy as np

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float
from testbed.plugins.base import Plugin


def triangulation(mesh: HermiteMesh) -> Triangulation:
    """Return the faces of a mesh of triangles."""
    return Triangulation(mesh.faces, len(mesh.points))


def refined_places(corners: Float) -> Float:
    """Parameters (4 F, 3, 2) of the corners of the pieces of faces with corners (F, 3, 2) after one step."""
    a, b, c = np.moveaxis(corners, 1, 0)
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    pieces = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]]
    return np.stack([np.stack(piece, axis=1) for piece in pieces], axis=1).reshape(-1, 3, 2)


def check_two_sided(plugin: Plugin, faces: Triangulation) -> None:
    """Refuse two faces with the same three vertices, back to back: after a step two edges would have the same ends."""
    folded = ~faces.on_boundary & (faces.face_count == 2)
    if folded.any():
        raise Refused(
            f"{plugin} has no rule at vertex {int(np.argmax(folded))}, where two faces lie back to back: remove them"
        )


def check_size(plugin: Plugin, faces: int, depth: int, most: int) -> None:
    """Refuse refinements to more than ``most`` pieces."""
    pieces = faces * 4**depth
    if pieces > most:
        raise Refused(
            f"{plugin} makes {pieces} triangles of a mesh of {faces}, more than the {most} that it takes: "
            "lower the depth, or take a coarser mesh"
        )
