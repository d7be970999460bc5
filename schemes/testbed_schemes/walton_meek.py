"""Walton and Meek's triangular patch (1996): a Gregory quartic a face, with a quadratic cross-boundary field.

Matches position and normal at the corners; G1 across edges. The construction is that of the triangular Gregory patch
but for the field of tangent planes along an edge: its cross-boundary direction goes from C0 to C1 by way of the unit
vector along C0 + C1, where the Chiyokura-Kimura field has (C0 + C1) / 2. Both are the same where C0 = C1. At the
vertices the curvature depends on the direction.

Formulas: the published construction in the variables of the Chiyokura-Kimura condition. It measures the second row from
the middles of the raised boundary's legs, here it is measured from the cubic's points: the same surface.
"""

from dataclasses import dataclass

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, quadratic_field_points
from testbed_schemes.mathematics.blended_quartics import blended_surface, gregory_basis


@dataclass(frozen=True)
class WaltonMeek(Scheme):
    """Walton and Meek's G1 triangular Gregory patch.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges; Walton and Meek's own by default.
    """

    boundary: BoundaryCurve = WaltonMeekCurve()

    name = "walton-meek"
    title = "Walton-Meek"
    reference = "Walton and Meek 1996"
    formula = (
        "Quartic over the raised cubic edges, with I_i = (b_k I_ij + b_j I_ik) / (b_j + b_k) for its inner points; "
        "I_ij comes from the edge b_j = 0 and its cross-boundary field k(t) ((1 - t)^2 C0 + 2 t (1 - t) unit(C0 + C1) "
        "+ t^2 C1), k linear."
    )
    status = (
        "As published, but measured from the points of the cubic edges, not the middles of the raised ones' legs; the "
        "surface is the same."
    )
    failures = (
        "Curvature oscillates, and at the vertices depends on the direction: Gaussian curvature 0.46 to 2.25 on the "
        "octahedron, where 1 is right, -19 to 8 on a torus of 80 faces, where -4 to 2 is. Refused: normals on "
        "different sides of a face, conormals opposite to each other along an edge, and what the curves refuse."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one patch a face from 12 boundary and 6 inner control points."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        return blended_surface(network, gregory_basis, quadratic_field_points)
