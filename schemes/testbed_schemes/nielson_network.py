"""Nielson's side-vertex patch on a given curve network: radial cubics, fields of tangent planes after Chiyokura-Kimura.

Matches position and normal at the vertices; neighbours share boundary curves and tangent planes along them, so the
surface is G1, whatever cubic network it is given. At the vertices the curvature depends on the direction.

As in Nielson's scheme, three patches are blended; G_i joins V_i to the points X(s) of the opposite side, s = b_k /
(b_j + b_k), by cubics with parameter b_j + b_k. Their end tangents at V_i are (1 - s) T_ij + s T_ik, T_ij being the
derivative at V_i of the curve to V_j. Those at X(s) are a Chiyokura-Kimura field k C + h X' that has the derivatives of
the two other sides at s = 0 and 1, where the radial curves are these sides. In Nielson's own scheme the curves depend
on points and normals in one way only, and that way decides the sides; this one takes the sides from elsewhere.

Formulas: a **fill**. The side-vertex method and the blend (2.12) are Nielson's (Mann 1992, section 2.3.2), whose
transfinite version takes any boundary curves with normals; the field for cubic curves is section 2.2.3's.
"""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.base import check_finite
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields
from testbed_schemes.mathematics.edge_deviations import CornerFunctions, blended_basis, deviation_surface


@dataclass(frozen=True)
class NielsonNetwork(Scheme):
    """Nielson's side-vertex method on a curve network.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the radial end tangents half-way along an edge; 1 makes k linear. Below 1/2 a
        patch may fold over its edges.

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0

    name = "nielson-network"
    title = "Nielson on a network"
    reference = "fill: Nielson 1987 with the fields of Chiyokura and Kimura 1983; Mann 1992, sections 2.2.3 and 2.3.2"
    formula = (
        "sum beta_i G_i, G_i cubics from V_i to the opposite side's points X(s), with tangents (1 - s) T_ij + s T_ik "
        "at V_i and k C + h X' at X(s); beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0)."
    )
    status = (
        "Fill: blend and side-vertex method as printed; the radial curves' end tangents from the Chiyokura-Kimura "
        "field, so that they fit into any cubic network. Jensen's C is an option."
    )
    failures = (
        "Dented where edges turn far: K on the octahedron of radius 1 is in [0.40, 2.72], with boundary=hermite and "
        "jensen_c=1.234 in [0.91, 1.04]. On needle faces that C folds patches. Curvature at a vertex depends on the "
        "direction."
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
        """Build one patch a face."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        return deviation_surface(network, side_vertex_basis, self.jensen_c)


def side_vertex_basis(b0: Any, b1: Any, b2: Any) -> Any:
    """Return the functions of the corners and deviations, see :func:`mathematics.edge_deviations.blended_basis`."""
    return blended_basis(b0, b1, b2, side_vertex_patches)


def side_vertex_patches(bi: Any, bj: Any, bk: Any) -> CornerFunctions:
    """Return the functions in beta_i G_i.

    With r = b_j + b_k, s = b_k / r and E(s) the field towards V_i, the deviation of G_i from the flat triangle is

        r^2 (1 + 2 b_i) x(s) + r b_i^2 ((1 - s) d_ij + s d_ik) + r^2 b_i e(s),

    with x(s) = s (1 - s) ((1 - s) d_jk + s d_kj) that of the side and e(s) = sum B^3_r(s) g_r that of the field: cubic
    Hermite curves with values 0 and x, and derivatives (1 - s) d_ij + s d_ik and -e.
    """
    products = bj * bk
    shares = products / products.sum(axis=-1, keepdims=True)
    at_vertex, at_side = shares * bi * bi, shares / (bj + bk)
    side, field = at_side * (1 + 2 * bi) * products, at_side * bi
    return CornerFunctions(
        ij=at_vertex * bj,
        ik=at_vertex * bk,
        ji=field * bj * bj * bj,
        jk=side * bj,
        ki=field * bk * bk * bk,
        kj=side * bk,
        along_i=(3 * field * products * bj, 3 * field * products * bk),
    )
