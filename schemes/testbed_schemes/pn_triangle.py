"""PN triangles (Vlachos, Peters, Boyd and Mitchell 2001): one cubic Bezier triangle a face, from points and normals.

Matches position and normal at the three corners. A boundary curve depends on the data at its two ends only, so the
surface is C0; its normals jump across the edges (46 degrees on the octahedron). The quadratic normals that are shaded
with it are not its own and no part of the surface here. Formulas: as printed.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curves import CurveNetwork
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE, boundary_net
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import tangential
from testbed.plugins.corners import check_corners
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.planar_frame import edge_normals
from testbed_schemes.quadratic_precision import quadratic_precision_centre


@dataclass(frozen=True)
class PnTriangle(Scheme):
    """Curved PN triangles."""

    name = "pn-triangle"
    title = "PN triangle"
    reference = "Vlachos, Peters, Boyd and Mitchell 2001"
    needs = Data.POINTS | Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the cubic triangles over the projected thirds of the edges, with the centre E + (E - V) / 2."""
        network = projected_thirds(mesh)
        check_corners(self, mesh, *network.end_legs)
        net = boundary_net(network)
        net[:, CENTRE] = quadratic_precision_centre(net)
        return Surface.over_faces(mesh, BezierTriangles(net))


def projected_thirds(mesh: HermiteMesh) -> CurveNetwork:
    """b_iij = (2 P_i + P_j - <P_j - P_i, N_i> N_i) / 3: the edge's third point, dropped onto the tangent plane at P_i.

    Unlike in ``projected``, the leg is not scaled to a third of the edge: it shortens as the edge turns to the normal,
    to nothing where they are parallel; such data are refused.
    """
    edges = mesh.edge_data
    third = (edges.p1 - edges.p0) / 3.0
    n0, n1 = edge_normals(edges)
    curves = [edges.p0, edges.p0 + tangential(third, n0), edges.p1 - tangential(third, n1), edges.p1]
    return CurveNetwork(mesh, np.stack(curves, axis=1))
