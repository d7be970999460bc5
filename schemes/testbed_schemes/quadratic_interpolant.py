"""The quadratic interpolant (Mann 1992, section 3.1): one quadratic Bezier triangle a face.

Matches position and normal at the three corners; neighbours share their boundary curves, so the surface is C0. The
middle point of an edge lies on both tangent planes and in the plane of the chord and n0 + n1: it is where the two
tangent lines of the planar boundary curve meet. An edge that must bend both ways has no such point, and the data are
refused. Construction: as printed; **fill**: the plane, which the thesis chooses for the cubic interpolant only.
"""

from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.corners import check_corners
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import STRAIGHT, planar_coefficients, planar_frame

#: Control points of a quadratic triangle beside its corners 200, 020, 002: the middles of the sides 01, 12, 20.
CORNERS, MIDDLES = [0, 3, 5], [1, 4, 2]


@dataclass(frozen=True)
class QuadraticInterpolant(Scheme):
    """Quadratic interpolant."""

    name = "quadratic-interpolant"
    title = "Quadratic interpolant"
    reference = "Mann 1992, section 3.1"
    formula = (
        "Middle point of an edge: where its tangents meet, p0 + d0 t0 = p1 - d1 t1, in the plane of chord and n0 + n1."
    )
    status = "As printed; fill: the plane, which the thesis chooses for the cubic interpolant only."
    failures = (
        "Refused where an edge has to bend both ways, so on most surfaces with negative Gaussian curvature (the monkey "
        "saddle, a pebble with estimated normals)."
    )
    needs = Data.POINTS | Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.C0
    order = 3  # Prenter 1975, as cited in section 3.4
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the quadratic triangles; Refused if the tangents of an edge do not meet between its ends."""
        middle = tangents_meet(mesh)
        missing = ~np.isfinite(middle).all(axis=1)
        if missing.any():
            edge = int(np.argmax(missing))
            i, j = mesh.edges[edge].tolist()
            face = int(mesh.edge_faces[edge].max())
            raise Refused(
                f"{self} has no middle point for {int(missing.sum())} of {len(mesh.edges)} edges, the first from "
                f"vertex {i} to vertex {j} of face {face}: the tangents there are parallel or meet behind an end, so "
                "that the edge has to bend both ways; put a vertex on it, or use a cubic scheme"
            )
        ends = mesh.points[mesh.edges]
        check_corners(self, mesh, middle - ends[:, 0], middle - ends[:, 1])
        net = np.empty((len(mesh.faces), 6, 3))
        net[:, CORNERS] = mesh.corner_points()
        net[:, MIDDLES] = middle[mesh.face_edges]
        return Surface.over_faces(mesh, BezierTriangles(net))


def tangents_meet(mesh: HermiteMesh) -> Float:
    """Where the tangent lines of the planar boundary curve of each edge meet, (E, 3).

    p0 + d0 t0 = p1 - d1 t1, that is d0 = (a x t1) / (t0 x t1) and d1 = (t0 x a) / (t0 x t1), both to be positive. On a
    straight edge, with both tangents along the chord, every point would do: the midpoint. NaN where there is none.
    """
    edges = mesh.edge_data
    frame = planar_frame(edges)
    turn, (offset0, offset1) = planar_coefficients(frame)
    straight = np.max(np.abs([turn, offset0, offset1]), axis=0) <= STRAIGHT
    with np.errstate(invalid="ignore", divide="ignore"):  # parallel tangents meet nowhere
        legs = np.stack([offset1, offset0]) / turn * frame.length
    ahead = ((legs > 0.0) & np.isfinite(legs)).all(axis=0)
    d0, d1 = np.where(ahead, legs, np.nan)
    # from both ends, so that the point is the same for the reversed edge
    meeting = (edges.p0 + d0[:, None] * frame.t0 + edges.p1 - d1[:, None] * frame.t1) / 2.0
    middle = (edges.p0 + edges.p1) / 2.0
    return np.where(straight[:, None], middle, meeting)
