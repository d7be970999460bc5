"""Split domains: a triangle cut at its centre S into three quartic triangles, and how these join inside.

Sub-patch i of a face has corners V_j, V_k, S with j = i + 1 and k = i + 2 (mod 3): its side V_j V_k is the face's edge
opposite V_i. The names of the control points are those of Mann 1992, figure 2.5; all are quartic here:

    I_i1, I_i2, I_i3   the inner boundary from V_i to S, a *spoke*
    C_ij, C_ik         second row along edge i, next to V_j and next to V_k
    N_i                the point of sub-patch i inside the ring of its boundary and C_ij, C_ik

Split cubics have fewer: two points I_i1, I_i2 on a spoke and one, Q_i, in the second row (:func:`c1_cubics`).

Control points are vectors of any dimension d: points of space, or homogeneous coordinates with d = 4.
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
        (F, 3, n, d) control points of the edges opposite corner i, from corner i + 1 to corner i + 2.

    Returns
    -------
    towards_next, towards_previous
        (F, 3, d) each, by corner.
    """
    return curves[:, K, 1], curves[:, J, -2]


def sum_near_corners(cross_points: tuple[Float, Float]) -> Float:
    """Return C_ji + C_ki by corner i, (F, 3, d), of the pairs (C_ij, C_ik) by edge i, (F, 3, d) each."""
    near_start, near_end = cross_points
    return near_end[:, J] + near_start[:, K]


@dataclass(frozen=True, slots=True)
class SplitFaces:
    """Control points of F faces, each split into three quartics.

    Parameters
    ----------
    boundary
        (F, 3, 5, d) quartic edge opposite corner i, from corner i + 1 to corner i + 2.
    cross_points
        C_ij and C_ik by edge i, (F, 3, d) each.
    spokes
        I_i1, I_i2, I_i3 by corner i, (F, 3, d) each.
    inner
        (F, 3, d) N_i.
    centre
        (F, d) S.
    """

    boundary: Float
    cross_points: tuple[Float, Float]
    spokes: tuple[Float, Float, Float]
    inner: Float
    centre: Float

    def nets(self) -> Float:
        """Return the quartic nets (F, 3, 15, d): sub-patch i of face f, with corners V_j, V_k, S."""
        first, second, third = self.spokes
        net = np.empty((len(self.boundary), 3, 15, self.boundary.shape[-1]))
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


def cubic_reproducing_inner(boundary: Float, curves: Float, cross_points: tuple[Float, Float]) -> Float:
    """Return N_i such that split cubics, raised to degree 4, keep theirs, (F, 3, d).

    **Fill**: the sources leave N_i free (Jensen) or do not give it. Each quartic C_ij would be (2 Q_i + I_j1 + H_1) / 4
    if its sub-patch were a cubic with first spoke points I_j1 and centre Q_i. The mean of the two Q_i so found is the
    centre of a cubic sub-patch, I_i2 = (I_i1 + Q_j + Q_k) / 3 its second spoke point, and its quartic N_i is
    (I_j2 + I_k2 + 2 Q_i) / 4.

    Parameters
    ----------
    boundary
        (F, 3, 5, d) quartic edge opposite corner i, from corner i + 1 to corner i + 2.
    curves
        (F, 3, 4, d) the cubics that these were raised from, or come nearest to.
    cross_points
        C_ij and C_ik by edge i, (F, 3, d) each.
    """
    first = _cubic_spokes(boundary)
    centre = nearest_cubic_points(boundary, curves, cross_points)
    second = (first + (centre[:, J] + centre[:, K])) / 3.0
    inner: Float = (second[:, J] + second[:, K] + 2.0 * centre) / 4.0
    return inner


def nearest_cubic_points(boundary: Float, curves: Float, cross_points: tuple[Float, Float]) -> Float:
    """Return the Q_i of split cubics whose raised second rows come nearest to the C_ij and C_ik, (F, 3, d).

    The mean of (4 C_ij - I_j1 - H_1) / 2 and (4 C_ik - I_k1 - H_2) / 2, which are equal if they are split cubics; the
    parameters are those of :func:`cubic_reproducing_inner`.
    """
    first, (near_start, near_end) = _cubic_spokes(boundary), cross_points
    centre: Float = near_start + near_end - ((first[:, J] + first[:, K]) + (curves[:, :, 1] + curves[:, :, 2])) / 4.0
    return centre


def _cubic_spokes(boundary: Float) -> Float:
    """First spoke points of split cubics with these boundaries raised to quartics: a cubic's leg is 4/3 as long."""
    corner = boundary[:, K, 0]
    towards_next, towards_previous = corner_neighbours(boundary)
    first: Float = corner + 4.0 / 9.0 * ((towards_next - corner) + (towards_previous - corner))
    return first


def c1_cubics(curves: Float, cross_points: Float) -> Float:
    """Return nets (F, 3, 10, d) of split cubics whose inner joins are C1: sub-patch i has the corners V_j, V_k, S.

    Every spoke point is the centroid of its three neighbours: I_i1 = (V_i + H_i,next + H_i,previous) / 3,
    I_i2 = (I_i1 + Q_j + Q_k) / 3, and S is the mean of the I_i2 (Mann 1992, section 2.3.1, Peters' scheme).

    Parameters
    ----------
    curves
        (F, 3, 4, d) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    cross_points
        (F, 3, d) Q_i, the inner point of sub-patch i.
    """
    towards_next, towards_previous = corner_neighbours(curves)
    first = (curves[:, K, 0] + (towards_next + towards_previous)) / 3.0
    second = (first + (cross_points[:, J] + cross_points[:, K])) / 3.0
    net = np.empty((len(curves), 3, 10, curves.shape[-1]))
    net[:, :, [0, 1, 3, 6]] = curves
    net[:, :, 2], net[:, :, 7] = first[:, J], first[:, K]
    net[:, :, 4] = cross_points
    net[:, :, 5], net[:, :, 8] = second[:, J], second[:, K]
    net[:, :, 9] = second.mean(axis=1)[:, None]
    return net


def subdivided_cubics(curves: Float, centre: Float) -> Float:
    """Return nets (F, 3, 10, d) of cubic triangles cut at their centroids, sub-patch i with the corners V_j, V_k, S.

    Parameters
    ----------
    curves
        (F, 3, 4, d) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    centre
        (F, d) P111.
    """
    return c1_cubics(curves, (curves[:, :, 1] + curves[:, :, 2] + centre[:, None]) / 3.0)
