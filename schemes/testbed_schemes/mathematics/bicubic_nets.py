"""Nets of bicubic patches over quadrilaterals: boundary, legs at the corners, twist points, the quarter at the centre.

A net holds C_ij, i along u and j along v. Its inner control points are 11, 12, 21, 22, in this order, next to the
corners 00, 03, 30, 33, which are corners 0, 3, 1, 2 of the face.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from testbed.errors import Refused
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_checks import named
from testbed.geometry.vectors import Float, dot, norm, quadratic_form
from testbed.plugins.scheme import Scheme

#: How far an inner control point may be moved from zero twist, in sides of the face: at the inverse of the machine
#: precision nothing is left of the normals of the patch, here six of their digits.
FARTHEST = 1e10
#: i and j of the inner control points, and of the corners next to them.
I, J = np.array([[1, 1, 2, 2], [1, 2, 1, 2]])  # noqa: E741 - the subscripts' names
CORNER_I, CORNER_J = np.array([[0, 0, 3, 3], [0, 3, 0, 3]])
#: Corners of the face in this order.
CORNERS: Final = np.array([0, 3, 1, 2])

#: Bernstein coefficients of a cubic's first half, as weights of the cubic's: its control points 1, 2 and 3.
_HALF = np.array([[1.0, 1.0, 0.0, 0.0], [0.5, 1.0, 0.5, 0.0], [0.25, 0.75, 0.75, 0.25]]) / 2.0
#: Weights (4, 4) of the control points at the corner of the quarter [0, 1/2]^2 that is the patch's centre (4.1): the
#: centre p, t1 and c1 before it along v, t2 and c2 along u, and m between t1 and t2.
QUARTER: Final[Mapping[str, Float]] = MappingProxyType(
    {
        name: np.outer(_HALF[i - 1], _HALF[j - 1])
        for name, (i, j) in {"p": (3, 3), "t1": (3, 2), "t2": (2, 3), "c1": (3, 1), "c2": (1, 3), "m": (2, 2)}.items()
    }
)


def boundary_nets(network: CurveNetwork, faces: slice = slice(None)) -> Float:
    """Nets (F, 4, 4, 3) of quadrilaterals bounded by the curves of a network; the inner control points are NaN."""
    south, east, north, west = np.moveaxis(network.along_sides(faces), 1, 0)
    net = np.full((len(south), 4, 4, 3), np.nan)
    net[:, :, 0], net[:, 3], net[:, ::-1, 3], net[:, 0, ::-1] = south, east, north, west
    return net


def corner_legs(net: Float) -> tuple[Float, Float, Float]:
    """Corners next to the inner control points, and the legs of the boundary there along u and along v, (F, 4, 3)."""
    corner = net[:, CORNER_I, CORNER_J]
    return corner, net[:, I, CORNER_J] - corner, net[:, CORNER_I, J] - corner


def zero_twist_points(net: Float, normals: Float, second_forms: Float) -> Float:
    """Inner control points (F, 4, 3), C10 + C01 - C00 and so on, moved as in :func:`in_tangent_planes`."""
    corner, along_u, along_v = corner_legs(net)
    return in_tangent_planes(net, corner + along_u + along_v, normals, second_forms)


def adini_points(net: Float) -> Float:
    """Inner control points (F, 4, 3) of the bilinearly blended Coons patch of the boundary, Adini's twist."""
    s, t = (I / 3.0)[:, None], (J / 3.0)[:, None]
    across = (1.0 - s) * net[:, 0, J] + s * net[:, 3, J] + (1.0 - t) * net[:, I, 0] + t * net[:, I, 3]
    corners = (1.0 - t) * ((1.0 - s) * net[:, :1, 0] + s * net[:, 3:, 0]) + t * (
        (1.0 - s) * net[:, :1, 3] + s * net[:, 3:, 3]
    )
    points: Float = across - corners
    return points


def in_tangent_planes(net: Float, points: Float, normals: Float, second_forms: Float) -> Float:
    """Points (F, 4, 3) moved along the normals until the patch has the second form's mixed part at its corners.

    <C11 - C00, N00> = -II00(C10 - C00, C01 - C00), and so on: (4.4) to (4.7). **Corrected**: the thesis prints the
    right-hand side for the opposite sign of II.

    Parameters
    ----------
    net
        (F, 4, 4, 3) nets; their inner control points are not read.
    points
        (F, 4, 3) inner control points.
    normals, second_forms
        (F, 4, 3) and (F, 4, 3, 3) at the corners next to them.
    """
    corner, along_u, along_v = corner_legs(net)
    height = dot(points - corner, normals) + quadratic_form(along_u, second_forms, along_v)
    moved: Float = points - height[..., None] * normals
    return moved


def face_sizes(mesh: HermiteMesh, faces: slice = slice(None)) -> Float:
    """Mean lengths (F,) of the sides of faces."""
    corners = mesh.corner_points()[faces]
    size: Float = norm(np.roll(corners, -1, axis=1) - corners).mean(axis=1)
    return size


def check_inner_points(scheme: Scheme, mesh: HermiteMesh, net: Float) -> None:
    """Refuse data that move an inner control point away by more than ``FARTHEST``; the message names the face."""
    corner, along_u, along_v = corner_legs(net)
    moved = norm(net[:, I, J] - corner - along_u - along_v).max(axis=1) / face_sizes(mesh)
    far = ~(moved <= FARTHEST)
    if far.any():
        face = int(np.argmax(far))
        raise Refused(
            f"{scheme} moves an inner control point of {named(mesh.faces, face)} by {moved[face]:.0e} of its sides to "
            "match the second fundamental forms there: check their size, or refine the mesh"
        )
