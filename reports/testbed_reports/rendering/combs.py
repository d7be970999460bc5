"""Combs of curvature on the curves of a network, their inflections, and dots at equal steps of the parameter.

The curvature vector of a curve C is kappa = (C'' - (C'' . T) T) / |C'|^2, T the unit tangent. Its sign, for a curve on
an oriented surface, is that of -kappa . m, m the mean of the normals at the ends turned upright on T: positive where
the curve bends away from the surface's normal, as curvatures have it elsewhere here.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bernstein import evaluate_curve
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.vectors import Float, Int, cross, dot, norm, unit

#: Teeth of a comb, and dots at steps of a tenth of the parameter.
TEETH = 41
DOTS = 11
#: Curvature times the length of the chord up to which a change of sign is rounding.
STRAIGHT = 1e-9


@dataclass(frozen=True, eq=False)
class Combs:
    """Curves with their curvature.

    Parameters
    ----------
    points
        (E, TEETH, 3) points at equal steps of the parameter.
    curvature
        (E, TEETH) signed curvature; NaN where a curve stands still.
    vectors
        (E, TEETH, 3) the curvature vectors, from the curve to its centre of curvature.
    dots
        (E, DOTS, 3) points at equal, wider steps of the parameter.
    inflections
        (I, 3) points where the signed curvature changes its sign, edge by edge.
    inflected, inflected_at
        (I,) the edge and the parameter of each.
    """

    points: Float
    curvature: Float
    vectors: Float
    dots: Float
    inflections: Float
    inflected: Int
    inflected_at: Float


def combs(network: CurveNetwork) -> Combs:
    """Return the combs of all curves of a network."""
    mesh = network.mesh
    normals = None if mesh.normals is None else mesh.normals[mesh.edges]
    return combs_of(network.control_points, normals)


def combs_of(control_points: Float, normals: Float | None = None) -> Combs:
    """Return the combs of Bezier curves.

    Parameters
    ----------
    control_points
        (E, n, 3).
    normals
        (E, 2, 3) normals of the surface at both ends, or None: curvatures have no sign then, and there are no
        inflections.
    """
    t = np.linspace(0.0, 1.0, TEETH)
    points, first, second = evaluate_curve(control_points, t, 2)
    # a curve with equal control points stands still at its end
    with np.errstate(invalid="ignore", divide="ignore"):
        tangent = unit(first)
        vectors = (second - dot(second, tangent)[..., None] * tangent) / dot(first, first)[..., None]
        if normals is None:
            signed: Float = norm(vectors)
        else:
            mean = normals.sum(axis=1, keepdims=True)
            signed = -dot(vectors, unit(mean - dot(mean, tangent)[..., None] * tangent))
    size = norm(control_points[:, -1] - control_points[:, 0])
    edge, place = sign_changes(signed, size, t)
    where = evaluate_curve(control_points[edge], place[:, None])[0][:, 0] if len(edge) else np.empty((0, 3))
    length = np.where(np.isfinite(signed), np.copysign(norm(vectors), signed), np.nan)
    dots = evaluate_curve(control_points, np.linspace(0.0, 1.0, DOTS))[0]
    return Combs(points, length, vectors, dots, where, edge, place)


def sign_changes(signed: Float, size: Float, t: Float) -> tuple[Int, Float]:
    """Edges (I,) and parameters (I,) where signed curvatures (E, S) change their signs, from linear interpolation."""
    clear = np.abs(signed) * size[:, None] > STRAIGHT
    sign = np.where(clear, np.sign(signed), 0.0)
    # across straight pieces a change counts once, at their end
    for place in range(1, sign.shape[1]):
        sign[:, place] = np.where(sign[:, place] == 0.0, sign[:, place - 1], sign[:, place])
    edge, step = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0.0)
    before, after = signed[edge, step], signed[edge, step + 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.nan_to_num(before / (before - after), nan=0.5).clip(0.0, 1.0)
    return edge, t[step] + share * (t[step + 1] - t[step])


def across_plane(curve: Float) -> Float:
    """Two unit vectors (2, 3) in which a plane Bezier curve (n, 3) is drawn: along its chord, and the bulge upwards."""
    along = unit(curve[-1] - curve[0])
    middle = evaluate_curve(curve, np.array([0.5]))[0, 0] - 0.5 * (curve[0] + curve[-1])
    up = middle - dot(middle, along) * along
    if norm(up) < 1e-12 * norm(curve[-1] - curve[0]):
        up = cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    return np.stack([along, unit(up)])
