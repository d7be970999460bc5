"""Nielson's side-vertex method with generalised conics (Hamann, Farin and Nielson 1991): a blended patch a face.

Matches position and normal at the vertices; neighbours share boundary curves and the normals along them, so the surface
is G1. The boundary curves are the scheme's own. At the vertices the curvature depends on the direction.

It is Nielson's scheme with rational cubics for g_v: with unit tangents t_0 and t_1 along the projected chord, the
chord's length L and the cosines c_0 and c_1 of its angles with them,

    points  P_0,   P_0 + L t_0 / (1 + 2 c_0),   P_1 - L t_1 / (1 + 2 c_1),   P_1
    weights 1,     (1 + 2 c_0) / 3,             (1 + 2 c_1) / 3,             1.

Where c_0 = c_1 and all is in one plane this is an arc of a circle, a conic raised by one degree: normals of a sphere
have great circles along the edges, and radial curves that are exact in the symmetries of a face. As the tangents are
projections, 0 < c <= 1: the weights are between 1/3 and 1, and the curve has inflections where the data ask for them.

Formulas: a **fill**. Mann 1992, section 2.3.2, only names the scheme and says that a generalised conic is a rational
cubic, without inflections a conic of raised degree. That is not so here unless c_0 = c_1: a conic through the
intersection of the tangents does not change smoothly into a curve with an inflection. The blend and g_n are Nielson's.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.composed import weighted_sum
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import edge_normals
from testbed_schemes.mathematics.side_vertex import CORNER_MARGIN, J, K, hermite_weights, side_vertex_blend
from testbed_schemes.nielson import check_middles, corner_tangents, edge_tangents


@dataclass(frozen=True)
class NielsonConic(Scheme):
    """Side-vertex patches of generalised conics."""

    name = "nielson-conic"
    title = "Nielson with conics"
    reference = "Hamann, Farin and Nielson 1991; Mann 1992, section 2.3.2"
    formula = (
        "Nielson's scheme with rational cubics P_0, P_0 + L t_0 / (1 + 2 c_0), P_1 - L t_1 / (1 + 2 c_1), P_1 of "
        "weights 1, (1 + 2 c_0) / 3, (1 + 2 c_1) / 3, 1; c the cosines between chord and tangents."
    )
    status = (
        "Fill: the original's weights are not in the sources surveyed; these give circles where the data are those of "
        "a circle, and no singularity elsewhere. Blend and side-vertex method as printed."
    )
    failures = (
        "On the octahedron K is in [0.91, 1.10], on the coarse torus in [-22, 10]: away from spheres no rounder than "
        "Nielson's cubics. Curvature at a vertex depends on the direction. Refuses edges along a normal of their ends."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one blended patch a face."""
        leaving, arriving = edge_tangents(self, mesh, 1.0, "chord")
        edges, half = mesh.edge_data, np.full(len(mesh.edges), 0.5)
        side = side_data(edges.p1 - edges.p0, leaving, arriving, *edge_normals(edges))
        check_middles(self, mesh, side_curve(**side, s=half, rest=half)[1])
        check_corners(self, mesh, leaving, -arriving)
        check_sides(self, mesh, leaving, -arriving)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        legs = corner_tangents(points, normals, 1.0, "chord")
        data = {"points": points, "normals": normals, "to_j": points[:, J] - points, "to_k": points[:, K] - points}
        data |= side_data(points[:, K] - points[:, J], legs[:, J, 0], -legs[:, K, 1], normals[:, J], normals[:, K])
        return Surface.over_faces(mesh, BlendedTriangles(conic_patch, data, points, legs, CORNER_MARGIN))


def side_data(chord: Float, leaving: Float, arriving: Float, normal0: Float, normal1: Float) -> dict[str, Float]:
    """What :func:`side_curve` takes, from the chord, the tangents of its length and the normals at its ends, (..., 3).

    Returns
    -------
    dict
        ``chord``, ``leaving`` and ``arriving``, the tangents less the chord, ``across0`` and ``across1``, N x X' at the
        ends, (..., 3) each; ``defect0`` and ``defect1``, 1 - c at the ends, (...).
    """

    def defect(normal: Float) -> Float:
        sine2 = dot(chord, normal) ** 2 / dot(chord, chord)
        return sine2 / (1.0 + np.sqrt(np.maximum(1.0 - sine2, 0.0)))

    return {
        "chord": chord,
        "leaving": leaving - chord,
        "arriving": arriving - chord,
        "across0": cross(normal0, leaving),
        "across1": cross(normal1, arriving),
        "defect0": defect(normal0),
        "defect1": defect(normal1),
    }


def side_curve(
    chord: Float,
    leaving: Float,
    arriving: Float,
    across0: Float,
    across1: Float,
    defect0: Float,
    defect1: Float,
    s: Float,
    rest: Float,
) -> tuple[Float, Float]:
    """Return how far the curve is from its chord at ``s`` = 1 - ``rest``, and the normal there, not of length one.

    With m = 1 - c the homogeneous coordinate of the curve is w(s) = 1 - 2 s (1 - s) ((1 - s) m_0 + s m_1), and
    w (X - chord) = D with D = s (1 - s) ((1 - s) (X'(0) - chord) - s (X'(1) - chord)) + 2 s^2 (1 - s)^2 (m_0 - m_1)
    chord; w^2 X' = w^2 chord + w D' - w' D.
    """
    product, slope0, slope1 = s * rest, rest * (rest - 2.0 * s), s * (2.0 * rest - s)
    skew = (defect0 - defect1)[..., None] * chord
    w = 1.0 - 2.0 * product * (rest * defect0 + s * defect1)
    dw = -2.0 * (slope0 * defect0 + slope1 * defect1)
    d = weighted_sum((product * rest, -product * s, 2.0 * product * product), (leaving, arriving, skew))
    dd = weighted_sum((slope0, -slope1, 4.0 * product * (rest - s)), (leaving, arriving, skew))
    velocity = (w * w)[..., None] * chord + w[..., None] * dd - dw[..., None] * d
    normal: Float = np.cross(velocity, weighted_sum((rest, s), (across0, across1)))
    return (1.0 / w)[..., None] * d, normal


def conic_patch(
    b0: Float,
    b1: Float,
    b2: Float,
    points: Float,
    normals: Float,
    to_j: Float,
    to_k: Float,
    **side: Float,
) -> Float:
    """Points (..., 3) of the patch.

    Parameters
    ----------
    points, normals
        (..., 3, 3) at the vertices.
    to_j, to_k
        (..., 3, 3) chords from each vertex to the next two.
    **side
        :func:`side_data` of the side opposite to each vertex.
    """

    def deviation(r: Float, rest: Float, s: Float, rest_s: Float) -> Float:
        # the side's point, seen from the flat side and from the vertex, and its normal
        off_side, normal = side_curve(**side, s=s, rest=rest_s)
        chord = weighted_sum((rest_s, s), (to_j, to_k)) + off_side
        # tangents of the curve to it; by Pythagoras the cosine to the chord is that of the sine height / |chord| |n|
        square, size = np.vecdot(chord, chord), np.vecdot(normal, normal)
        height0, height1 = np.vecdot(chord, normals), np.vecdot(chord, normal)
        sine0, sine1 = height0**2 / square, height1**2 / (square * size)
        cosine0, cosine1 = np.sqrt(1.0 - sine0), np.sqrt(1.0 - sine1)
        first = (1.0 / cosine0)[..., None] * (chord - height0[..., None] * normals)
        last = (1.0 / cosine1)[..., None] * (chord - (height1 / size)[..., None] * normal)
        # the curve, as in side_curve
        defect0, defect1 = sine0 / (1.0 + cosine0), sine1 / (1.0 + cosine1)
        product = r * rest
        w = 1.0 - 2.0 * product * (rest * defect0 + r * defect1)
        skew = (defect0 - defect1)[..., None] * chord
        d = weighted_sum((*hermite_weights(r, rest), 2.0 * product * product), (chord, first, last, skew))
        result: Float = r[..., None] * off_side + (1.0 / w)[..., None] * d
        return result

    return side_vertex_blend(deviation, points, b0, b1, b2)
