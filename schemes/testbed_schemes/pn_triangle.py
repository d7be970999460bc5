"""PN triangles (Vlachos, Peters, Boyd and Mitchell 2001): one cubic Bezier triangle a face, from points and normals.

Matches position and normal at the three corners. A boundary curve depends on the data at its two ends only, so the
surface is C0; its normals jump across the edges (46 degrees on the octahedron). The quadratic normals that are shaded
with it are not its own and no part of the surface here. Its edges are those of the boundary curves called ``piper``.
Formulas: as printed.
"""

from dataclasses import dataclass

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE, boundary_net
from testbed.geometry.surface import Surface
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.piper import PiperCurve
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre


@dataclass(frozen=True)
class PnTriangle(Scheme):
    """Curved PN triangles."""

    name = "pn-triangle"
    title = "PN triangle"
    reference = "Vlachos, Peters, Boyd and Mitchell 2001"
    formula = (
        "b_iij = (2 P_i + P_j - <P_j - P_i, N_i> N_i) / 3; centre b_111 = E + (E - V) / 2, E the mean of the b_iij "
        "and V that of the P_i."
    )
    status = "As printed; the quadratic normals shaded with it are left out, they are not the surface's."
    failures = "Normals jump by 46 degrees on the octahedron. Refused where an edge is parallel to a normal at its end."
    needs = Data.POINTS | Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the cubic triangles over the projected thirds of the edges, with the centre E + (E - V) / 2."""
        network = PiperCurve().network(mesh)  # b_iij = (2 P_i + P_j - <P_j - P_i, N_i> N_i) / 3
        net = boundary_net(network)
        net[:, CENTRE] = quadratic_precision_centre(net)
        return Surface.over_faces(mesh, BezierTriangles(net))
