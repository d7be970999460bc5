"""Clough-Tocher elements on heights over a triangulation of the plane: gradients, directions across edges, nets.

Everything here is heights z (V,) over points (V, 2) of the plane: a face is cut at its centroid S into three cubics,
sub-patch i with corners V_j, V_k, S (j = i + 1, k = i + 2), whose inner joins are C1
(:func:`testbed_schemes.mathematics.split_domain.c1_cubics`). What remains is the point of the second row, Q_i. The
derivative across edge i along a direction w_i is linear along the edge; the two faces at an edge take the same
direction, so that the join is C1. In a face, w_i = (S - V_j) + g_i (V_k - V_j), up to a factor (Alfeld 1984; Farin
1986).
"""

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, dot
from testbed_schemes.mathematics.split_domain import J, K


def least_bending_gradients(points: Float, heights: Float, edges: Int) -> Float:
    """Gradients (V, 2) with the least sum, over the edges, of the integral of the squared second derivative.

    The curves over the edges are cubics. With e from vertex i to j, L its length and d = e . g the slopes at its ends,
    edge (i, j) contributes e / L^3 times 4 d_i + 2 d_j - 6 (z_j - z_i) to the equations of i, and with i and j
    exchanged in the first two terms to those of j (Nielson 1983; Renka and Cline 1984). The system is positive definite
    wherever the edges at a vertex are not all on a line.

    Parameters
    ----------
    points
        (V, 2), of any scale; edges of a length near one are best.
    heights
        (V,).
    edges
        (E, 2) vertex ids.
    """
    from scipy.sparse import coo_array, diags_array
    from scipy.sparse.linalg import splu

    start, end = edges.T
    along = points[end] - points[start]
    weight = 1.0 / np.hypot(along[:, 0], along[:, 1]) ** 3
    block = weight[:, None, None] * along[:, :, None] * along[:, None, :]
    slope = (6.0 * weight * (heights[end] - heights[start]))[:, None] * along
    count = len(points)
    right = np.zeros((count, 2))
    np.add.at(right, start, slope)
    np.add.at(right, end, slope)
    vertices = np.concatenate([np.stack(pair) for pair in ((start, start), (end, end), (start, end), (end, start))], 1)
    blocks = np.concatenate([4.0 * block, 4.0 * block, 2.0 * block, 2.0 * block])
    row, column = np.broadcast_arrays(
        2 * vertices[0][:, None, None] + np.arange(2)[:, None], 2 * vertices[1][:, None, None] + np.arange(2)
    )
    shape = (2 * count, 2 * count)
    matrix = coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=shape).tocsc()
    # unknowns of comparable size: narrow faces have weights that differ by many powers of ten
    scale = 1.0 / np.sqrt(matrix.diagonal())
    scaling = diags_array(scale)
    solution = splu((scaling @ matrix @ scaling).tocsc()).solve(scale * right.ravel())
    gradients: Float = (scale * solution).reshape(count, 2)
    return gradients


def centroid_ratios(points: Float, mesh: HermiteMesh) -> Float:
    """Ratios g_i of the directions from centroid to centroid across the edges, (F, 3) by edge i opposite corner i.

    On the boundary the direction is that to the middle of the edge, g = -1/2. With the neighbour's centroid at
    barycentric coordinates c of the face, g_i = (2 c_k + c_j - 1) / (2 - 3 c_k - 3 c_j): where the line from S' to S
    meets the edge, measured from V_j to V_k, is -g_i. The choice is invariant under affine maps of the plane.
    """
    faces = mesh.faces
    own = np.arange(len(faces))[:, None]
    adjacent = mesh.edge_faces[mesh.face_edges[:, J]]  # side s runs from corner s to s + 1: edge i is side i + 1
    neighbour = np.where(adjacent[..., 0] == own, adjacent[..., 1], adjacent[..., 0])
    corners = points[faces]
    centroid = corners.mean(axis=1)
    offset = centroid[neighbour] - corners[:, J]  # from V_j
    across, along = corners - corners[:, J], corners[:, K] - corners[:, J]
    area = across[..., 0] * along[..., 1] - across[..., 1] * along[..., 0]
    own_weight = (offset[..., 0] * along[..., 1] - offset[..., 1] * along[..., 0]) / area
    end_weight = (across[..., 0] * offset[..., 1] - across[..., 1] * offset[..., 0]) / area
    on_boundary = neighbour < 0
    # the third coordinate is what the two leave of one
    ratios: Float = (end_weight - own_weight) / np.where(on_boundary, 1.0, 3.0 * own_weight - 1.0)
    return np.where(on_boundary, -0.5, ratios)


def edge_ordinates(points: Float, heights: Float, gradients: Float) -> Float:
    """Bezier ordinates (F, 3, 4) of the cubics over edge i, from corner i + 1 to corner i + 2.

    Parameters
    ----------
    points, heights, gradients
        (F, 3, 2), (F, 3) and (F, 3, 2) at the corners of the faces.
    """
    along = points[:, K] - points[:, J]
    first = heights[:, J] + dot(gradients[:, J], along) / 3.0
    last = heights[:, K] - dot(gradients[:, K], along) / 3.0
    return np.stack([heights[:, J], first, last, heights[:, K]], axis=-1)


def second_row(curves: Float, ratios: Float) -> Float:
    """Ordinates Q_i, (F, 3), that make the derivative across edge i along w_i linear along the edge.

    2 Q_i = (I_j1 + I_k1 - z_j + 2 H_1 - H_2) + g_i (-z_j + 3 H_1 - 3 H_2 + z_k), H_1 and H_2 the inner ordinates of the
    edge, I_i1 = (z_i + H_i,next + H_i,previous) / 3 the first ordinates of the spokes.

    Parameters
    ----------
    curves
        (F, 3, 4) ordinates of edge i, from corner i + 1 to corner i + 2.
    ratios
        (F, 3) g_i.
    """
    z_j, first, last, z_k = np.moveaxis(curves, -1, 0)
    # by corner: the point next to it on the edge to the next corner is on edge i + 2, to the previous on edge i + 1
    spoke = (z_j[:, K] + curves[:, K, 1] + curves[:, J, 2]) / 3.0
    straight = spoke[:, J] + spoke[:, K] - z_j + 2.0 * first - last
    result: Float = 0.5 * (straight + ratios * (3.0 * (first - last) - z_j + z_k))
    return result


def positive_shares(
    points: Float, heights: Float, gradients: Float, ratios: Float, mesh: HermiteMesh
) -> tuple[Float, Float]:
    """Return shares (V,) of the gradients that leave no Bezier ordinate below zero, and the Q_i without gradients.

    Every ordinate of the three cubics is a mean of those over the edges and of the Q_i, and these are sums a + b of a
    part a without gradients and a part b of each vertex's gradient. Where a >= 0, no shares up to a / sum max(-b, 0)
    make one negative, whatever the others are: the least of these over the faces at a vertex is its share, at most one.
    **Fill**: in the manner of monotone curve interpolation; one pass, sufficient and not necessary.

    Parameters
    ----------
    points, heights, gradients, ratios
        (V, 2), (V,) not negative, (V, 2) and (F, 3), as in the other functions.
    mesh
        The triangulation.

    Returns
    -------
    shares
        (V,) in [0, 1].
    rows
        (F, 3) Q_i of vanishing gradients; where one is negative, no share helps.
    """
    at, z, slopes = points[mesh.faces], heights[mesh.faces], gradients[mesh.faces]
    without = _free_ordinates(at, z, np.zeros_like(slopes), ratios)
    alone = [slopes * (np.arange(3) == corner)[:, None] for corner in range(3)]
    fall = [np.maximum(-_free_ordinates(at, np.zeros_like(z), one, ratios), 0.0) for one in alone]
    allowed = np.maximum(without, 0.0) / np.where(sum(fall) > 0.0, sum(fall), 1.0)
    shares = np.ones(len(points))
    for corner in range(3):
        least = np.where(fall[corner] > 0.0, allowed, 1.0).min(axis=1)
        np.minimum.at(shares, mesh.faces[:, corner], least)
    return shares, without[:, 6:]


def _free_ordinates(points: Float, heights: Float, gradients: Float, ratios: Float) -> Float:
    """Ordinates (F, 9) of faces that gradients at corners (F, 3, 2) decide: H_1 of the edges, H_2, and Q."""
    curves = edge_ordinates(points, heights, gradients)
    return np.concatenate([curves[..., 1], curves[..., 2], second_row(curves, ratios)], axis=1)
