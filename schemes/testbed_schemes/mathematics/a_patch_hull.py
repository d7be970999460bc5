"""Apexes of the tetrahedra on the faces of A-patches (Xu, Huang and Bajaj 2001, section 3.1).

The apex of a face stands above its centre c, u = c + t_max n with the face's unit normal n, as high as needed for the
number 1 coefficients of layer 1 to be positive and its number 3 coefficients not to be negative. Below the face it is
the same with face normal and vectors reversed.

Formulas: **corrected**: the paper's t_max = max(0, ...) is zero where all conditions hold below the face, and the
tetrahedron then degenerates; here it is at least epsilon. **Fill**: epsilon, which the paper leaves open, is given as
part of the mean edge length.
"""

import numpy as np

from testbed.geometry.vectors import Float, dot, norm
from testbed_schemes.mathematics.a_patch_coefficients import foot_weight
from testbed_schemes.mathematics.split_domain import J, K


def apex_heights(corners: Float, vectors: Float, normals: Float, epsilon: float) -> Float:
    """Return t_max (N,) of faces, in the frame of one side.

    Parameters
    ----------
    corners, vectors
        (N, 3, 3) vertices and vectors there; <vectors, normals> > 0.
    normals
        (N, 3) unit normals of the faces.
    epsilon
        Margin above the heights t_l, and least height, as part of the mean edge length.
    """
    single, pair = height_conditions(corners, vectors, normals)
    lengths = norm(corners[:, K] - corners[:, J])
    margin = epsilon * (lengths[:, 0] + lengths[:, 1] + lengths[:, 2]) / 3.0
    height: Float = np.maximum(np.maximum(single.max(axis=1), 0.0) + margin, pair.max(axis=1))
    return height


def height_conditions(corners: Float, vectors: Float, normals: Float) -> tuple[Float, Float]:
    """Return t_l by corner l, and t_lm by edge opposite corner s, (N, 3) each.

    At height t_l the coefficient at p_l towards the apex is zero; at t_lm, that of the triangle p_l p_m u.
    """
    centre = corners.mean(axis=1)[:, None]
    slope = dot(normals[:, None], vectors)
    single = dot(corners - centre, vectors) / slope
    p, q, n_p, n_q = corners[:, J], corners[:, K], vectors[:, J], vectors[:, K]
    alpha = foot_weight(centre, p, q)[..., None]
    pair = dot(p - centre + alpha * (p - q), n_p) + dot(q - centre + (1.0 - alpha) * (q - p), n_q)
    return single, pair / (slope[:, J] + slope[:, K])
