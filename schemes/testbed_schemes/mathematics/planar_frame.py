"""What boundary curve constructions share: end tangents of an edge, and the plane of a planar curve.

Edges run from p0 to p1 with chord a = p1 - p0 of length L and unit normals n0, n1. Reversing an edge swaps the ends and
negates the tangents; the expressions are written so that this holds to rounding.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, cross, dot, norm, quadratic_form, tangential

#: Sine of the angle below which two directions count as parallel: a direction made from their difference has lost half
#: of its digits there, and more below.
PARALLEL = 1e-8
#: Turning angle, and curvature times length, below which an edge is straight: the rounding noise of a plane whose
#: coordinates are a hundred thousand times the edge.
STRAIGHT = 1e-10


def edge_normals(edges: EdgeData) -> tuple[Float, Float]:
    """Return the unit normals at both ends, (E, 3) each; ValueError if the mesh has none."""
    if edges.n0 is None or edges.n1 is None:
        raise ValueError("these edges have no normals")
    return edges.n0, edges.n1


def edge_second_forms(edges: EdgeData) -> tuple[Float, Float]:
    """Return the second fundamental forms at both ends, (E, 3, 3) each; ValueError if the mesh has none."""
    if edges.W0 is None or edges.W1 is None:
        raise ValueError("these edges have no second fundamental forms")
    return edges.W0, edges.W1


def scaled_to_one(a: Float, least: Float) -> Float:
    """Vectors (E, 3) scaled to length one; NaN where they are not longer than ``least`` (E,)."""
    length = norm(a)
    length = np.where(length > least, length, np.nan)
    return a / length[:, None]


def projected_tangents(chord: Float, n0: Float, n1: Float) -> tuple[tuple[Float, Float], Float]:
    """Return the unit projections of the chord onto the tangent planes at both ends, and the chord's length.

    NaN rows where the chord is parallel to the normal (``PARALLEL``) or has no length.

    Returns
    -------
    tangents
        t0 and t1, (E, 3) each, both running from p0 to p1.
    length
        (E,).
    """
    length = norm(chord)
    least = PARALLEL * length
    t0, t1 = (scaled_to_one(tangential(chord, normal), least) for normal in (n0, n1))
    return (t0, t1), length


@dataclass(frozen=True, slots=True)
class PlanarFrame:
    """The plane of a planar boundary curve and the end tangents in it.

    Attributes
    ----------
    length
        L, (E,).
    along, across
        Unit vectors of the plane, (E, 3): along the chord, and that turned by +90 degrees.
    t0, t1
        Unit tangents at both ends, (E, 3), in the plane and in the tangent planes, running from p0 to p1.
    """

    length: Float
    along: Float
    across: Float
    t0: Float
    t1: Float

    def components(self, a: Float) -> Float:
        """Coordinates (E, 2) in the plane, of vectors (E, 3)."""
        return np.stack([dot(a, self.along), dot(a, self.across)], axis=-1)

    def turned(self, a: Float) -> Float:
        """Vectors of the plane (E, 3) turned by +90 degrees in it."""
        x, y = dot(a, self.along)[:, None], dot(a, self.across)[:, None]
        return x * self.across - y * self.along


def planar_frame(edges: EdgeData) -> PlanarFrame:
    """Plane through the chord with normal m = (n0 + n1) x a, and t = +-(m x n) with <t, a> > 0 (Mann 1992, 2.4.3).

    NaN rows where there is no such plane or tangent: n0 + n1 parallel to the chord or zero, a normal equal to m, or a
    tangent perpendicular to the chord, which runs from p0 to p1 as little as back (``PARALLEL``).
    """
    n0, n1 = edge_normals(edges)
    chord = edges.p1 - edges.p0
    length = norm(chord)
    with np.errstate(invalid="ignore", divide="ignore"):  # no chord: NaN, and the row is refused
        along = chord / length[:, None]
    small = np.full(len(chord), PARALLEL)
    plane_normal = scaled_to_one(cross(n0 + n1, along), small)

    def tangent(normal: Float) -> Float:
        t = scaled_to_one(cross(plane_normal, normal), small)
        forward = dot(t, along)
        return np.where(np.abs(forward) > PARALLEL, np.sign(forward), np.nan)[:, None] * t

    return PlanarFrame(length, along, cross(plane_normal, along), tangent(n0), tangent(n1))


def planar_coefficients(frame: PlanarFrame) -> tuple[Float, Float]:
    """Return the cross products t0 x t1, (E,), and t0 x a and a x t1, (2, E), in the plane, of the unit chord a."""
    t0, t1 = frame.components(frame.t0).T, frame.components(frame.t1).T
    return t0[0] * t1[1] - t0[1] * t1[0], np.stack([-t0[1], t1[1]])


def plane_curvatures(frame: PlanarFrame, normals: tuple[Float, Float], second_forms: tuple[Float, Float]) -> Float:
    """Return the signed curvatures (2, E) of planar curves that have the data's normal curvature at the ends.

    k = -II(t, t) / <nu, n> with nu the tangent turned by +90 degrees (Meusnier; Mann 1992, section 3.2).
    """
    k0, k1 = (
        -quadratic_form(t, W, t) / dot(frame.turned(t), normal)
        for t, normal, W in zip((frame.t0, frame.t1), normals, second_forms, strict=True)
    )
    return np.stack([k0, k1])


def curve_from_legs(edges: EdgeData, tangents: tuple[Float, Float], d0: Float, d1: Float) -> Float:
    """Cubic p0, p0 + d0 t0, p1 - d1 t1, p1, (E, 4, 3), of unit tangents (E, 3) and Bezier legs (E,)."""
    t0, t1 = tangents
    return np.stack([edges.p0, edges.p0 + d0[:, None] * t0, edges.p1 - d1[:, None] * t1, edges.p1], axis=1)
