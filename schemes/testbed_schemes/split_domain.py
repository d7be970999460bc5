"""Split domains: a triangle cut at its centre S into three quartic triangles, and how these join inside.

Sub-patch i of a face has corners V_j, V_k, S with j = i + 1 and k = i + 2 (mod 3): its side V_j V_k is the face's edge
opposite V_i. The names of the control points are those of Mann 1992, figure 2.5; all are quartic here:

    I_i1, I_i2, I_i3   the inner boundary from V_i to S, a *spoke*
    C_ij, C_ik         second row along edge i, next to V_j and next to V_k
    N_i                the point of sub-patch i inside the ring of its boundary and C_ij, C_ik
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float

#: Indices i + 1 and i + 2 (mod 3): what belongs to corner j or k of sub-patch i, gathered by i.
J = np.array([1, 2, 0])
K = np.array([2, 0, 1])


def corner_neighbours(curves: Float) -> tuple[Float, Float]:
    """Return the control points next to each corner on the edge to the next corner and on that to the previous one.

    Parameters
    ----------
    curves
        (F, 3, n, 3) control points of the edges opposite corner i, from corner i + 1 to corner i + 2.

    Returns
    -------
    towards_next, towards_previous
        (F, 3, 3) each, by corner.
    """
    return curves[:, K, 1], curves[:, J, -2]


def sum_near_corners(cross_points: tuple[Float, Float]) -> Float:
    """Return C_ji + C_ki by corner i, (F, 3, 3), of the pairs (C_ij, C_ik) by edge i, (F, 3, 3) each."""
    near_start, near_end = cross_points
    return near_end[:, J] + near_start[:, K]


@dataclass(frozen=True, slots=True)
class SplitFaces:
    """Control points of F faces, each split into three quartics.

    Parameters
    ----------
    boundary
        (F, 3, 5, 3) quartic edge opposite corner i, from corner i + 1 to corner i + 2.
    cross_points
        C_ij and C_ik by edge i, (F, 3, 3) each.
    spokes
        I_i1, I_i2, I_i3 by corner i, (F, 3, 3) each.
    inner
        (F, 3, 3) N_i.
    centre
        (F, 3) S.
    """

    boundary: Float
    cross_points: tuple[Float, Float]
    spokes: tuple[Float, Float, Float]
    inner: Float
    centre: Float

    def nets(self) -> Float:
        """Return the quartic nets (F, 3, 15, 3): sub-patch i of face f, with corners V_j, V_k, S."""
        first, second, third = self.spokes
        net = np.empty((len(self.boundary), 3, 15, 3))
        net[:, :, [0, 1, 3, 6, 10]] = self.boundary
        net[:, :, 2], net[:, :, 11] = first[:, J], first[:, K]
        net[:, :, 4], net[:, :, 7] = self.cross_points
        net[:, :, 5], net[:, :, 12] = second[:, J], second[:, K]
        net[:, :, 8] = self.inner
        net[:, :, 9], net[:, :, 13] = third[:, J], third[:, K]
        net[:, :, 14] = self.centre[:, None]
        return net


def c1_ring(boundary: Float, cross_points: tuple[Float, Float], inner: Float) -> SplitFaces:
    """Return split faces whose inner joins are C1, for any C_ij, C_ik and N_i.

    Every spoke point is the centroid of its three neighbours (Mann 1992, section 2.3.1, Jensen's scheme):
    I_i1 = (V_i + E_i,next + E_i,previous) / 3, I_i2 = (I_i1 + C_ji + C_ki) / 3, I_i3 = (I_i2 + N_j + N_k) / 3, and S is
    the mean of the I_i3. The parameters are those of :class:`SplitFaces`.
    """
    towards_next, towards_previous = corner_neighbours(boundary)
    first = (boundary[:, K, 0] + towards_next + towards_previous) / 3.0
    second = (first + sum_near_corners(cross_points)) / 3.0
    third = (second + inner[:, J] + inner[:, K]) / 3.0
    return SplitFaces(boundary, cross_points, (first, second, third), inner, third.mean(axis=1))
