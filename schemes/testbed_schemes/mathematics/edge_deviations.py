"""Patches that are linear in a cubic curve network and its cross-boundary fields, as deviations from flat triangles.

Boundary curves and Chiyokura-Kimura fields are cubics: a patch built from them with functions of the parameters alone
combines 15 vectors a face, each measured from what it would be on the flat triangle with the same corners:

    V_i              the corners
    d_ij, d_ik       derivatives at V_i of the curves to V_j and V_k, less the chords V_j - V_i and V_k - V_i
    g_i1, g_i2       inner Bezier coefficients of the field along edge i, less those of V_i - (1 - s) V_j - s V_k

with j = i + 1, k = i + 2 (mod 3) and edge i opposite V_i, running from V_j to V_k. The field along edge i is the
derivative towards V_i: d_ji and d_ki are its end values, so deviations too. The functions of V_i are the barycentric
coordinates, without rounding; those of the others are blends, whose second derivatives near a corner grow like
1 / distance term by term before they cancel, and so does the rounding of what they multiply: of deviations here, not of
coordinates.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from testbed.geometry.blocks import in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import Basis, TabulatedTriangles
from testbed.geometry.vectors import Float
from testbed_schemes.continuity_conditions.chiyokura_kimura import cross_boundary_points
from testbed_schemes.mathematics.split_domain import J, K, corner_neighbours

#: How near to a corner second derivatives are good: rounding leaves an error of about 1e-16 / distance in them.
CORNER_MARGIN = 1e-6


@dataclass(frozen=True, slots=True)
class CornerFunctions:
    """Functions (..., 3) of the deviations in the patch of corner i, on the last axis; zero where it does not have one.

    Attributes
    ----------
    ij, ik, ji, jk, ki, kj
        Of d_ij, d_ik and so on.
    along_i, along_j, along_k
        Of the two inner coefficients of the fields along edges i, j and k, as the edges run.
    """

    ij: Any
    ik: Any
    ji: Any
    jk: Any
    ki: Any
    kj: Any
    along_i: tuple[Any, Any] = (0, 0)
    along_j: tuple[Any, Any] = (0, 0)
    along_k: tuple[Any, Any] = (0, 0)


#: ``patch(bi, bj, bk)``: the functions of the patches of all three corners, multiplied by their shares in the blend.
CornerPatches: TypeAlias = Callable[[Any, Any, Any], CornerFunctions]


def blended_basis(b0: Any, b1: Any, b2: Any, patches: CornerPatches) -> Sequence[Any]:
    """Return the functions of the 15 vectors: V, d_i,i+1, d_i,i+2, g_i1 and g_i2, three each.

    Parameters
    ----------
    b0, b1, b2
        Barycentric coordinates, arrays or Taylors of one shape.
    patches
        The three patches that are summed, on the last axis.
    """
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    at = patches(bi, bj, bk)
    # what belongs to corner or edge a is with patch a in the part of i, with a - 1 in that of j, a - 2 in that of k
    onward, back = _gathered(at.ij, at.jk, at.ki), _gathered(at.ik, at.ji, at.kj)
    first, second = (_gathered(*parts) for parts in zip(at.along_i, at.along_j, at.along_k, strict=True))
    return [b0, b1, b2, *(function[..., i] for function in (onward, back, first, second) for i in range(3))]


def _gathered(of_i: Any, of_j: Any, of_k: Any) -> Any:
    """Sum over the three patches, (..., 3), of functions given by role: those that are plain numbers are zero."""
    roles = ((of_i, [0, 1, 2]), (of_j, [2, 0, 1]), (of_k, [1, 2, 0]))
    total: Any = 0
    for functions, patch in roles:
        total = total + (functions if isinstance(functions, int) else functions[..., patch])
    return total


def deviation_surface(network: CurveNetwork, basis: Basis, jensen_c: float) -> Surface:
    """Build one patch a face from a network with Chiyokura-Kimura fields and Jensen's C.

    Parameters
    ----------
    network
        Cubic curves on the edges of a mesh of triangles with normals.
    basis
        See :func:`blended_basis`.
    jensen_c
        Jensen's C.
    """
    curves, normals = network.opposite_vertices(), network.mesh.corner_normals()

    def vectors(faces: slice) -> Float:
        return edge_deviations(curves[faces], normals[faces], jensen_c)

    patches = TabulatedTriangles(basis, in_blocks(vectors, len(curves)), corner_table(), CORNER_MARGIN)
    return Surface.over_faces(network.mesh, patches, network.notes)


def edge_deviations(curves: Float, normals: Float, jensen_c: float) -> Float:
    """Return the 15 vectors of each face in the order of :func:`blended_basis`, (F, 15, 3).

    Parameters
    ----------
    curves
        (F, 3, 4, 3) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    normals
        (F, 3, 3) unit normals by corner.
    jensen_c
        Jensen's C.
    """
    corner = curves[:, K, 0]
    to_next, to_previous = (3.0 * (point - corner) for point in corner_neighbours(curves))
    # along edge i, at V_j and V_k: what crosses it goes from V_j to its previous corner and from V_k to its next one
    crossing = to_previous[:, J], to_next[:, K]
    seen_from_start = curves - curves[:, :, :1]
    points = cross_boundary_points(seen_from_start, *crossing, normals[:, J], normals[:, K], jensen_c)
    flat0, flat1 = corner - corner[:, J], corner - corner[:, K]
    result = np.empty((len(curves), 15, 3))
    result[:, :3] = corner
    result[:, 3:6] = to_next - (corner[:, J] - corner)
    result[:, 6:9] = to_previous - (corner[:, K] - corner)
    result[:, 9:12] = points[0] - seen_from_start[:, :, 1] - (2.0 * flat0 + flat1) / 3.0
    result[:, 12:] = points[1] - seen_from_start[:, :, 2] - (flat0 + 2.0 * flat1) / 3.0
    return result


def corner_table() -> Float:
    """Return values and first derivatives of the functions at the corners, (3, 3, 15).

    There a patch that has the boundary curves has their derivatives: d_i,i+1 counts as b_i+1, d_i,i+2 as b_i+2.
    """
    gradient = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]).T
    table = np.zeros((3, 3, 15))
    table[0, :, :3] = np.eye(3)
    table[1:, :, :3] = gradient[:, None]
    corner = np.arange(3)
    table[1:, corner, 3 + corner] = gradient[:, J]
    table[1:, corner, 6 + corner] = gradient[:, K]
    return table
