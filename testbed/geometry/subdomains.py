"""Where a patch lies in the domain of its mesh face: maps from patch parameters to face parameters and back.

A patch that covers its face has the face's own parameters. A patch of a split face lies there by the affine map that
sends its corners to their places; for a patch over a square, the bilinear one. Corners are (..., sides, 2) points of
the face's domain.
"""

import numpy as np

from testbed.geometry.domain import CORNERS
from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Bool, Float

#: Newton steps after the closed form of the inverse of a bilinear map, against cancellation in it.
POLISHING = 2


def to_face(corners: Float, at: Float) -> Float:
    """Face parameters (..., 2) of patch parameters ``at`` (..., 2)."""
    u, v = at[..., :1], at[..., 1:]
    if corners.shape[-2] == 3:
        return (1.0 - u - v) * corners[..., 0, :] + u * corners[..., 1, :] + v * corners[..., 2, :]
    lower = (1.0 - u) * corners[..., 0, :] + u * corners[..., 1, :]
    upper = (1.0 - u) * corners[..., 3, :] + u * corners[..., 2, :]
    return (1.0 - v) * lower + v * upper


def derivative(corners: Float, at: Float) -> Float:
    """Differentiate :func:`to_face`: entry [i, k] of (..., 2, 2) is face parameter i along patch parameter k."""
    if corners.shape[-2] == 3:
        along_u, along_v = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    else:
        u, v = at[..., :1], at[..., 1:]
        along_u = (1.0 - v) * (corners[..., 1, :] - corners[..., 0, :]) + v * (corners[..., 2, :] - corners[..., 3, :])
        along_v = (1.0 - u) * (corners[..., 3, :] - corners[..., 0, :]) + u * (corners[..., 2, :] - corners[..., 1, :])
    along_u, along_v = np.broadcast_arrays(along_u, along_v)
    return np.stack([along_u, along_v], axis=-1)


def from_face(corners: Float, at: Float) -> Float:
    """Patch parameters (..., 2) of face parameters ``at`` (..., 2); NaN where there are none."""
    if corners.shape[-2] == 3:
        return solve(derivative(corners, at), at - corners[..., 0, :])
    with np.errstate(invalid="ignore", divide="ignore"):  # outside of the patch there may be no solution
        place = bilinear_inverse(corners, at)
        for _ in range(POLISHING):
            place = place + solve(derivative(corners, place), at - to_face(corners, place))
    return place


def bilinear_inverse(corners: Float, at: Float) -> Float:
    """Parameters (..., 2) of points in convex quadrilaterals, counterclockwise, from the quadratic equation for u.

    With d = at - p0, legs e and g at p0, and twist h, d = u e + v g + u v h, so that (d - u e) x (g + u h) = 0; of the
    two roots, the one with positive Jacobian (e + v h) x (g + u h).
    """
    p0, p1, p2, p3 = (corners[..., i, :] for i in range(4))
    d, e, g, h = at - p0, p1 - p0, p3 - p0, p0 - p1 + p2 - p3
    a, b, c = -_area(e, h), _area(d, h) - _area(e, g), _area(d, g)
    root = np.sqrt(b * b - 4.0 * a * c)
    u = np.where(b < 0.0, 2.0 * c / (root - b), -(b + root) / (2.0 * a))[..., None]
    along = g + u * h
    v = ((d - u * e) * along).sum(axis=-1, keepdims=True) / (along * along).sum(axis=-1, keepdims=True)
    return np.concatenate([u, v], axis=-1)


def _area(a: Float, b: Float) -> Float:
    product: Float = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def solve(matrix: Float, right: Float) -> Float:
    """Solutions (..., 2) of 2 x 2 systems (..., 2, 2), by Cramer's rule."""
    (a, b), (c, d) = np.moveaxis(matrix, (-2, -1), (0, 1))
    x, y = right[..., 0], right[..., 1]
    solution: Float = np.stack([d * x - b * y, a * y - c * x], axis=-1) / (a * d - b * c)[..., None]
    return solution


def covers_face(corners: Float) -> Bool:
    """(...) true where a patch with corners (..., sides, 2) covers its whole face, corner for corner."""
    whole: Bool = (corners == CORNERS[corners.shape[-2]]).all(axis=(-2, -1))
    return whole


def inside(sides: int, at: Float) -> Float:
    """How far inside its domain a point is, (...): its smallest barycentric coordinate or distance from a side."""
    u, v = at[..., 0], at[..., 1]
    bounds = [1.0 - u - v, u, v] if sides == 3 else [u, v, 1.0 - u, 1.0 - v]
    least: Float = np.minimum.reduce(bounds)
    return least


def in_face_parameters(jet: Jet, corners: Float, at: Float) -> Jet:
    """Convert jets in patch parameters at ``at`` (N, 2) to jets in face parameters; coefficients (rows, N, 3).

    With p the patch's and q the face's parameters, f_q = f_p A for A = (dq/dp)^-1, and
    f_qq = A^T (f_pp - sum_i f_q_i d^2 q_i / dp dp) A, whose last sum only bilinear maps have.
    """
    rows = [jet.f]
    if jet.order > 0:
        forward = derivative(corners, at)
        inverse = np.stack([solve(forward, np.broadcast_to(axis, at.shape)) for axis in np.eye(2)], axis=-1)
        first = np.einsum("kni,nkj->jni", jet.coefficients[1:3], inverse)
        rows += list(first)
    if jet.order > 1:
        fuv = jet.fuv
        if corners.shape[-2] == 4:
            twist = corners[..., 0, :] - corners[..., 1, :] + corners[..., 2, :] - corners[..., 3, :]
            fuv = fuv - np.einsum("jni,nj->ni", first, twist)
        second = np.stack([np.stack([jet.fuu, fuv]), np.stack([fuv, jet.fvv])])
        second = np.einsum("nka,klni,nlb->abni", inverse, second, inverse)
        rows += [second[0, 0], second[0, 1], second[1, 1]]
    return Jet(np.stack(rows))
