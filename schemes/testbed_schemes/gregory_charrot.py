"""The scheme of Gregory and Charrot (1980): three two-sided interpolants a face, blended.

Matches position and normal at the vertices; neighbours share boundary curves and tangent planes along them, so the
surface is G1. At the vertices the curvature depends on the direction.

P_i is the Boolean sum of the two edges at V_i. With X_k(t) the curve from V_i to V_j, t = b_j, and f_k(t) the
derivative across it in the direction in which b_k grows and b_j stays, and X_j, f_j likewise from V_i to V_k,

    P_i = X_k(b_j) + b_k f_k(b_j) + X_j(b_k) + b_j f_j(b_k) - V_i - b_k f_k(0) - b_j f_j(0)
          - b_j b_k (b_j f_j'(0) + b_k f_k'(0)) / (b_j + b_k).

It has both curves and both derivatives; the two twists at V_i need not agree. The surface is sum alpha_i P_i with
alpha_i = b_i^2 (3 - 2 b_i + 6 b_j b_k), which vanishes twice on edge i, the one that P_i knows nothing of, and adds up
to one. f_k is the Chiyokura-Kimura field along the edge, which points from it to V_k: turned into that direction by
adding t X_k'(t).

Formulas: P_i as printed in Mann 1992, section 2.3.2, where f_{a,b} is the derivative of f_b with respect to w_a; the
weights **corrected**. Printed are those of Nielson, b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0), which are 1 on the edge
where P_i is wrong and vanish where it is right; these are Gregory and Charrot's own. The field is section 2.2.3's.
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
class GregoryCharrot(Scheme):
    """Gregory and Charrot's blended Boolean sums.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the cross-boundary derivative half-way along an edge; 1 makes k linear. Below
        1/2 a patch may fold over its edges.

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0

    name = "gregory-charrot"
    title = "Gregory-Charrot"
    reference = "Gregory and Charrot 1980; Mann 1992, section 2.3.2"
    formula = (
        "sum alpha_i P_i, P_i the Boolean sum of the curves and Chiyokura-Kimura fields on the two edges at V_i with "
        "its twists blended; alpha_i = b_i^2 (3 - 2 b_i + 6 b_j b_k)."
    )
    status = (
        "Corrected: the printed weights are Nielson's, which favour P_i on the edge it does not interpolate; these are "
        "Gregory and Charrot's of 1980. The printed f_{a,b} is read as the derivative of f_b with respect to w_a."
    )
    failures = (
        "Dented where edges turn far: K on the octahedron of radius 1 is in [0.36, 2.68], with boundary=hermite and "
        "jensen_c=1.234 in [0.87, 1.04]. On needle faces that C folds patches. Curvature at a vertex depends on the "
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
        return deviation_surface(network, boolean_sum_basis, self.jensen_c)


def boolean_sum_basis(b0: Any, b1: Any, b2: Any) -> Any:
    """Return the functions of the corners and deviations, see :func:`mathematics.edge_deviations.blended_basis`."""
    return blended_basis(b0, b1, b2, boolean_sums)


def boolean_sums(bi: Any, bj: Any, bk: Any) -> CornerFunctions:
    """Return the functions in alpha_i P_i.

    The deviation of P_i from the flat triangle is the sum of two halves, one for each edge at V_i; see
    :func:`half_sum`.
    """
    alpha = bi * bi * (1 + 2 * (bj + bk) + 6 * bj * bk)
    ij, ik, ji, jk, *along_k = half_sum(alpha, bi, bj, bk)
    and_ik, and_ij, ki, kj, *along_j = half_sum(alpha, bi, bk, bj)
    return CornerFunctions(
        ij=ij + and_ij,
        ik=ik + and_ik,
        ji=ji,
        jk=jk,
        ki=ki,
        kj=kj,
        # edge k runs from V_i to V_j, edge j from V_k to V_i
        along_j=(along_j[1], along_j[0]),
        along_k=(along_k[0], along_k[1]),
    )


def half_sum(alpha: Any, bi: Any, t: Any, across: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return the functions of d_ij, d_ik, d_ji, d_jk and of the field's inner coefficients next to V_i and to V_j.

    In alpha times the deviation of edge k's half of P_i, which is, with t = b_j, x(t) the deviation of the curve and
    g(t) that of the natural field, f_k = g + t x',

        x(t) + b_k (g(t) - g(0) + t x'(t)) - b_j b_k b_k / (b_j + b_k) (g'(0) + x'(0)).
    """
    rest = bi + across
    twist = alpha * t * across * across / (t + across)
    crossing = alpha * across
    square, rest2 = t * t, rest * rest
    # x = t (1 - t) ((1 - t) d_ij + t d_ji), g = sum B^3_r g_r with g_0 = d_ik, g_3 = d_jk
    along_ij = alpha * t * rest2 + crossing * t * rest * (rest - 2 * t) - twist
    along_ji = alpha * square * rest + crossing * square * (2 * rest - t)
    # B^3_0 - 1 = (1 - t)^3 - 1 = -t ((1 - t)^2 + (1 - t) + 1)
    return (
        along_ij,
        3 * twist - crossing * t * (rest2 + rest + 1),
        along_ji,
        crossing * square * t,
        3 * (crossing * t * rest2 - twist),
        3 * crossing * square * rest,
    )
