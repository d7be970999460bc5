"""The triangular Gregory patch (Longhi 1986): one quartic triangle a face, its inner control points blended rationally.

Matches position and normal at the corners; G1 across edges by the Chiyokura-Kimura condition with Jensen's C. That asks
for two inner points at each corner, one from either edge; near the corner their blend depends on the direction, and so
does the curvature at the vertices. Position and tangent plane have limits.

Formulas: Mann 1992, section 2.3.2, with the blend **corrected**: as printed, the two points of a corner change places,
and the normals jump by some twenty degrees.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.bernstein import multi_indices, triangle_tables
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import boundary_net, corner_legs, inner_indices
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, cross_boundary_points
from testbed_schemes.split_domain import J, K

#: Places of the twelve boundary control points in the net of a quartic.
BOUNDARY = np.delete(np.arange(15), inner_indices(4))

#: How near to a corner second derivatives are good: they lose 1e-16 / distance to rounding.
CORNER_MARGIN = 1e-6


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

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0

    name = "triangular-gregory"
    title = "Triangular Gregory"
    reference = "Longhi 1986; Mann 1992, section 2.3.2"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the shape parameter."""
        if not np.isfinite(self.jensen_c):
            raise SpecError(f"{self.name}: jensen_c must be finite, and here it is {self.jensen_c}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one patch a face from 12 boundary and 6 inner control points."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        net = boundary_net(network, degree=4)
        inner = inner_points(network.opposite_vertices(), net, mesh.corner_normals(), self.jensen_c)
        control_points = np.concatenate([net[:, BOUNDARY], inner], axis=1)
        patches = TabulatedTriangles(gregory_basis, control_points, corner_table(), CORNER_MARGIN)
        return Surface.over_faces(mesh, patches, network.notes)


def inner_points(curves: Float, net: Float, normals: Float, jensen_c: float) -> Float:
    """Return the inner control points I_ij and I_ik by corner i, from the edges opposite j and k, (F, 6, 3).

    Parameters
    ----------
    curves
        (F, 3, 4, 3) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    net
        (F, 15, 3) the same as quartics, in a net.
    normals
        (F, 3, 3) unit normals by corner.
    jensen_c
        Jensen's C.
    """
    _, towards_next, towards_previous = corner_legs(net)
    # along edge i, the second row of the net starts on the edge from V_j to V_i and ends on that from V_k to V_i
    near_start, near_end = cross_boundary_points(
        curves, towards_previous[:, J], towards_next[:, K], normals[:, J], normals[:, K], jensen_c
    )
    return np.stack([near_end[:, J], near_start[:, K]], axis=2).reshape(-1, 6, 3)


def gregory_basis(b0: Any, b1: Any, b2: Any) -> list[Any]:
    """Return the functions of the 18 control points: 12 quartic Bernstein polynomials and 6 blends of three others.

    I_ij takes the share b_k (1 - b_j) / (b_k (1 - b_j) + b_j (1 - b_k)) of the polynomial 12 b_i^2 b_j b_k, and I_ik
    the rest, so that on the edge b_j = 0 I_ij alone counts. **Corrected**: printed with the shares exchanged.
    """
    # all three corners, and all three sides from corner i to corner j, at once
    bi, bj, bk = (np.stack(b, axis=-1) for b in ((b0, b1, b2), (b1, b2, b0), (b2, b0, b1)))
    square_i, square_j = bi * bi, bj * bj
    sides = {4: square_i * square_i, 3: 4 * square_i * bi * bj, 2: 6 * square_i * square_j, 1: 4 * bi * square_j * bj}
    functions = []
    for exponents in multi_indices(4)[BOUNDARY].tolist():
        # of the corners with an exponent, the first of the side they are on
        i = next(i for i in range(3) if exponents[i] > 0 and exponents[(i + 2) % 3] == 0)
        functions.append(sides[exponents[i]][..., i])
    share_j, share_k = bk * (bk + bi), bj * (bj + bi)  # b_k (1 - b_j), b_j (1 - b_k)
    polynomials = 12 * square_i * bj * bk / (share_j + share_k)
    blends = polynomials * share_j, polynomials * share_k
    return functions + [blend[..., i] for i in range(3) for blend in blends]


def corner_table() -> Float:
    """Return values and first derivatives of the functions at the corners, (3, 3, 18); those of the blends vanish."""
    polynomials = triangle_tables(4, CORNERS[3], order=1)[..., BOUNDARY]
    return np.concatenate([polynomials, np.zeros((3, 3, 6))], axis=-1)
