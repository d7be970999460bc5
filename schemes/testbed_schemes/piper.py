"""The scheme of Piper (1987): three quartic Bezier triangles a face, whose edges are quartic and know both faces.

Matches position and normal at the corners. A cubic triangle on each face is cut at its centroid and raised to
quartics; these candidates are moved as little as possible, along each mesh edge both neighbours and their common
boundary at once, until Piper's conditions hold there. Then the spokes are set so that the joins inside are C1. The
curvature at the vertices is that of the construction, not the data's.

Formulas: Mann 1992, sections 2.2.2 and 2.3.1, which give the steps and not all formulas. **Fills**: the centre of the
cubic triangle is that of quadratic precision; how the factors of the conditions are normalised and which of the
equations are solved (:mod:`~testbed_schemes.continuity_conditions.piper`); edges on the boundary of the mesh, and the
second rows along them, stay as in the candidate.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bernstein import elevate_curve, elevate_triangle
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import blocks, in_blocks
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import boundary_net
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.corners import check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.piper import nearest_join
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre
from testbed_schemes.mathematics.split_domain import c1_ring, subdivided_cubics

#: Places in a quartic sub-patch: the second row along its edge, and N_i.
ROW, INNER = [2, 4, 7, 11], 8


@dataclass(frozen=True)
class Piper(Scheme):
    """Piper's split quartics.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges, for the candidate: the middle point of the quartic edge moves. Piper's own
        curves have shorter end tangents; with ``piper`` the Gaussian curvature of the octahedron rises from 3.4 to 16.
    """

    boundary: BoundaryCurve = Projected()

    name = "piper"
    title = "Piper"
    reference = "Piper 1987; Mann 1992, section 2.3.1"
    formula = (
        "Cubic triangles cut at their centroids and raised to quartics; on each mesh edge H2, F1, F2, G1, G2 move to "
        "the nearest solution of e I + f J + g K + h L = 0 with e, f, g, h linear; every spoke point is the centroid "
        "of its three neighbours."
    )
    status = (
        "The thesis's steps as printed. Fill: the cubic centre, of quadratic precision; e + f = -1 and g + h = 1; the "
        "equations are solved in a form that does not lose its rank; edges on the boundary of the mesh stay."
    )
    failures = (
        "Refused where normals fold the surface over. Edges that turn by a quarter of a circle or more: the Gaussian "
        "curvature falls below zero along them, on the octahedron (-0.02 to 3.4) and the tetrahedron (-0.12 to 8.1)."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    support = 1

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build three quartics a face; counts the edges along which the factors of the conditions are constant."""
        network = self.boundary.network(mesh)
        check_sides(self, mesh, *network.end_legs)
        curves, centres = network.opposite_vertices(), quadratic_precision_centre(boundary_net(network))

        def rows_and_inner(faces: slice) -> Float:
            candidate = elevate_triangle(subdivided_cubics(curves[faces], centres[faces]))
            return candidate[:, :, [*ROW, INNER]]

        points = in_blocks(rows_and_inner, len(curves))
        boundary, cross_points, constant = joined_edges(network, points[:, :, :4])

        def nets(faces: slice) -> Float:
            pair = cross_points[faces, :, 0], cross_points[faces, :, 1]
            return c1_ring(boundary[faces], pair, points[faces, :, 4]).nets()

        net = in_blocks(nets, len(curves))
        notes = {**network.notes, "edges with constant factors": constant} if constant else network.notes
        return Surface.over_split_faces(mesh, BezierTriangles(net.reshape(-1, *net.shape[2:])), notes)


def joined_edges(network: CurveNetwork, rows: Float) -> tuple[Float, Float, int]:
    """Move the points about every inner edge to the nearest join, once for both faces; others stay.

    Parameters
    ----------
    network
        Cubic boundary curves of the candidate.
    rows
        (F, 3, 4, 3) its quartic second rows along the edge opposite corner i, from corner i + 1 to corner i + 2.

    Returns
    -------
    boundary
        (F, 3, 5, 3) quartic edge opposite corner i.
    cross_points
        (F, 3, 2, 3) C_ij and C_ik.
    constant
        Number of inner edges along which e, f, g, h are constant.
    """
    mesh = network.mesh
    edge, forward = (np.roll(by_side, -1, axis=1) for by_side in (mesh.face_edges, mesh.face_edge_forward))
    # the row of the face that runs along the edge from its lower vertex id to its higher, and that of the one back
    place = np.full((len(mesh.edges), 2), -1)
    place[edge, np.where(forward, 0, 1)] = np.arange(edge.size).reshape(edge.shape)
    inner = np.flatnonzero(~mesh.boundary_edges)
    curves, by_place = elevate_curve(network.control_points), rows.reshape(-1, 4, 3)
    cross_points = by_place[:, 1:3].copy()
    constant = 0
    for block in blocks(len(inner)):
        edges = inner[block]
        ahead, back = place[edges].T
        curve, row, other, unvaried = nearest_join(curves[edges], by_place[ahead], by_place[back, ::-1])
        curves[edges], cross_points[ahead], cross_points[back] = curve, row[:, 1:3], other[:, 2:0:-1]
        constant += int(unvaried.sum())
    boundary = np.where(forward[..., None, None], curves[edge], curves[edge, ::-1])
    return boundary, cross_points.reshape(*edge.shape, 2, 3), constant
