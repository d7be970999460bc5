"""Herron's scheme (1985): three quartics a face, blended as Nielson blends his patches.

Patch F_i has the face's boundary and, along edges j and k, no particular tangent planes; along edge i, opposite V_i, it
has those of the Chiyokura-Kimura condition, which sets its inner points near V_j and V_k. The third, C_i near V_i, is
free. The blend sum of beta_i F_i with beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0) is G1 across all edges. Matches
position and normal at the corners; the curvature there depends on the direction.

Written as one quartic, its inner point near V_i is beta_i C_i + beta_j I_ij + beta_k I_ik, with I_ij the
Chiyokura-Kimura point of edge j there. Of the C_i only their sum has an influence on the surface.

Formulas: Mann 1992, equation (2.13) as printed. Appendix A **corrected**, r_ji and r_ki with their signs turned, and
simplified: the sum of its C_i is half that of the six I, so that C_i = (I_ij + I_ik) / 2 gives the same surface. As
printed the signs break linear precision, which continuity, met by any C_i, cannot show.
"""

from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.base import check_finite
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, cross_boundary_points
from testbed_schemes.mathematics.blended_quartics import blended_basis, blended_surface


@dataclass(frozen=True)
class Herron(Scheme):
    """Herron's blend of three quartics, with Jensen's cross-boundary fields.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the cross-boundary derivative half-way along an edge; 1 is the original scheme.
        Below 1/2 a patch may fold over its edges.

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0

    name = "herron"
    title = "Herron"
    reference = "Herron 1985; Mann 1992, section 2.3.2 and appendix A"
    formula = (
        "Quartic over the raised cubic edges, with I_i = beta_i (I_ij + I_ik) / 2 + beta_j I_ij + beta_k I_ik for its "
        "inner points, beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0); I_ij is the Chiyokura-Kimura point near V_i "
        "of the edge b_j = 0."
    )
    status = (
        "Corrected: r_ji and r_ki of the thesis's appendix A have the wrong sign; its C_i are then replaced by a mean "
        "that gives the same surface. Jensen's C (as printed) in place of C = 1 is an option."
    )
    failures = (
        "Curvature oscillates, and at the vertices depends on the direction: Gaussian curvature 0.42 to 2.91 on the "
        "octahedron, where 1 is right, -22 to 12 on a torus of 80 faces, where -4 to 2 is. Refused: normals on "
        "different sides of a face, conormals opposite to each other along an edge. Folds may occur for jensen_c < 1/2."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    bounds = MappingProxyType({"jensen_c": (0.5, 2.0)})

    def __post_init__(self) -> None:
        """Check the shape parameter."""
        check_finite(self, "jensen_c")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one patch a face from 12 boundary and 6 inner control points."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        return blended_surface(network, herron_basis, partial(cross_boundary_points, jensen_c=self.jensen_c))


def herron_basis(b0: Any, b1: Any, b2: Any) -> list[Any]:
    """Return the functions of the control points: I_ij has the share beta_j + beta_i / 2, I_ik beta_k + beta_i / 2."""
    return blended_basis(b0, b1, b2, lambda bi, bj, bk: ((2 * bi + bj) * bk, (2 * bi + bk) * bj))
