"""The triangular Gregory patch (Longhi 1986): one quartic triangle a face, its inner control points blended rationally.

Matches position and normal at the corners; G1 across edges by the Chiyokura-Kimura condition with Jensen's C. That asks
for two inner points at each corner, one from either edge; near the corner their blend depends on the direction, and so
does the curvature at the vertices. Position and tangent plane have limits.

Formulas: Mann 1992, section 2.3.2, with the blend **corrected**: as printed, the two points of a corner change places,
and the normals jump by some twenty degrees.
"""

from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Literal

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.base import check_finite
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, cross_boundary_points
from testbed_schemes.mathematics.blended_quartics import blended_basis, blended_surface, gregory_basis


@dataclass(frozen=True)
class TriangularGregory(Scheme):
    """Longhi's triangular Gregory patch with Jensen's cross-boundary fields.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the cross-boundary derivative half-way along an edge; 1 is the original scheme.
        Below 1/2 a patch may fold over its edges.
    blend
        Shares of I_ij and I_ik: ``longhi``, b_k (1 - b_j) : b_j (1 - b_k), or ``simple``, b_k : b_j, which is Gregory's
        on the square and one degree lower. The surfaces agree on the edges with their tangent planes, and at the
        corners also in the limits of curvature; inside they differ.

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0
    blend: Literal["longhi", "simple"] = "longhi"

    name = "triangular-gregory"
    title = "Triangular Gregory"
    reference = "Longhi 1986; Mann 1992, section 2.3.2"
    formula = (
        "Quartic over the raised cubic edges, with I_i = (b_k (1 - b_j) I_ij + b_j (1 - b_k) I_ik) / (b_k (1 - b_j) + "
        "b_j (1 - b_k)) for its inner points; I_ij is the Chiyokura-Kimura point near V_i of the edge b_j = 0."
    )
    status = (
        "Corrected: the printed blend exchanges I_ij and I_ik. Jensen's C (as printed) in place of C = 1, and the "
        "simple blend, are options."
    )
    failures = (
        "Curvature oscillates, and at the vertices depends on the direction: Gaussian curvature 0.38 to 2.71 on the "
        "octahedron, where 1 is right, -21 to 12 on a torus of 80 faces, where -4 to 2 is. Refused: normals on "
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
        basis = longhi_basis if self.blend == "longhi" else gregory_basis
        return blended_surface(network, basis, partial(cross_boundary_points, jensen_c=self.jensen_c))


def longhi_basis(b0: Any, b1: Any, b2: Any) -> list[Any]:
    """Return the functions of the control points with the shares b_k (1 - b_j) of I_ij and b_j (1 - b_k) of I_ik.

    On the edge b_j = 0 I_ij alone counts. **Corrected**: printed with the shares exchanged.
    """
    return blended_basis(b0, b1, b2, lambda bi, bj, bk: (bk * (bk + bi), bj * (bj + bi)))
