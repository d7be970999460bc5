"""The scheme of Shirman and Sequin (1987, corrected 1991): three quartic Bezier triangles a face.

Matches position and normal at the corners. Across mesh edges the Chiyokura-Kimura condition makes the join G1; inside a
face Farin's conditions do, with one ratio alpha_i2 a corner. The curvature at the vertices is that of the construction,
not the data's.

Formulas: Mann 1992, section 2.3.1, with Jensen's C (equation 2.6). As printed if alpha_i2 is the same everywhere;
**corrected** if not: the printed N_i, in the thesis and in Mann 1994, breaks the inner joins (:func:`inner_points`).
beta_i = 2 / alpha_i2 is Mann 1994's name; the default alpha_i2 = 9/4 is beta = 8/9 (its appendix A says 1/3).
"""

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.base import check_finite
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.chiyokura_kimura import check_fields, cross_boundary_points
from testbed_schemes.mathematics.split_domain import J, K, SplitFaces, corner_neighbours, sum_near_corners


@dataclass(frozen=True)
class ShirmanSequin(Scheme):
    """Shirman-Sequin's split quartics with Jensen's cross-boundary fields.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the cross-boundary derivative half-way along an edge; 1 is the original scheme.
        Below 1/2 a patch may fold over its edges.
    alpha2
        The thesis's alpha_i2 > 0 (alpha_i1 = 2 - alpha_i2), one for all vertices or one for each: where the first inner
        point lies between its corner and the neighbours on the two edges. At 9/4 the inner joins are C1.

    Raises
    ------
    SpecError
        ``alpha2`` is not positive and finite, or ``jensen_c`` not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0
    alpha2: float | tuple[float, ...] = 2.25

    name = "shirman-sequin"
    title = "Shirman-Séquin"
    reference = "Shirman and Séquin 1987, 1991; Mann 1992, section 2.3.1"
    formula = (
        "Cubic edges; second rows by Chiyokura-Kimura with k(1/2) = C (k(0) + k(1)) / 2; spokes V_i, I_i1, I_i2, S, "
        "joined inside by Farin's conditions with one ratio alpha_i2 a corner."
    )
    status = "As printed for equal alpha_i2; corrected for others: the printed N_i breaks the inner joins."
    failures = (
        "Curvature gathers near vertices and edges: Gaussian 0.28 to 2.51 on the octahedron, where 1 is right. Refused "
        "where normals fold the surface over. On geometric Hermite edges with a short leg it explodes and stays G1."
    )
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    bounds = MappingProxyType({"jensen_c": (0.5, 2.0), "alpha2": (1.0, 4.0)})

    def __post_init__(self) -> None:
        """Check the shape parameters."""
        alpha = np.asarray(self.alpha2, dtype=np.float64)
        if not (np.isfinite(alpha) & (alpha > 0.0)).all():
            raise SpecError(f"{self.name}: alpha2 must be positive and finite, and here it is {self.alpha2}")
        check_finite(self, "jensen_c")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build three quartics a face."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        curves, normals = network.opposite_vertices(), mesh.corner_normals()
        beta = np.broadcast_to(2.0 / self.corner_alphas(mesh)[..., None], (len(curves), 3, 1))

        def nets(faces: slice) -> Float:
            return split_faces(curves[faces], normals[faces], self.jensen_c, beta[faces]).nets()

        net = in_blocks(nets, len(curves))
        return Surface.over_split_faces(mesh, BezierTriangles(net.reshape(-1, *net.shape[2:])), network.notes)

    def corner_alphas(self, mesh: HermiteMesh) -> Float:
        """Return alpha_i2 by face corner, (F, 3), or (1, 1) if all are one; Refused if the count is not the mesh's."""
        if isinstance(self.alpha2, float | int):
            return np.full((1, 1), float(self.alpha2))
        if len(self.alpha2) != len(mesh.points):
            raise Refused(
                f"{self.name} has {len(self.alpha2)} values of alpha2 and the mesh has {len(mesh.points)} vertices: "
                "give one value for each vertex, or a single one for all"
            )
        return np.array(self.alpha2)[mesh.faces]


def split_faces(curves: Float, normals: Float, jensen_c: float, beta: Float) -> SplitFaces:
    """Return the control points of the three quartics of each face.

    Parameters
    ----------
    curves
        (F, 3, 4, 3) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    normals
        (F, 3, 3) unit normals by corner.
    jensen_c
        Jensen's C.
    beta
        (F, 3, 1): 2 / alpha_i2 by corner.
    """
    boundary = elevate_curve(curves)
    corner = curves[:, K, 0]
    towards_next, towards_previous = corner_neighbours(boundary)
    # the spokes are cubics, V_i, I_i1, I_i2, S; their first points from (2.9)
    first = (1.0 - beta) * corner + beta * (towards_previous + towards_next) / 2.0
    leg = 0.75 * (first - corner)
    cross_points = cross_boundary_points(curves, leg[:, J], leg[:, K], normals[:, J], normals[:, K], jensen_c)
    second = (
        3.0 * beta / 16.0 * corner
        + (1.0 - 27.0 * beta / 16.0) * first
        + 12.0 * beta / 16.0 * sum_near_corners(cross_points)
    )
    centre = second.mean(axis=1)
    inner = inner_points(first, second, centre, beta)
    spokes = (corner + leg, (first + second) / 2.0, (3.0 * second + centre[:, None]) / 4.0)
    return SplitFaces(boundary, cross_points, spokes, inner, centre)


def inner_points(first: Float, second: Float, centre: Float, beta: Float) -> Float:
    """Return N_i = (R_j + R_k - R_i) / 2, (F, 3, 3), where R_i = N_j + N_k is what the G1 join along spoke i asks for.

    R_i = -I_i1 / 2 + (5/2 - 2 / (3 beta_i)) I_i2 + 2 / (3 beta_i) S, from the third coefficient of Farin's condition
    along the cubic spoke V_i, I_i1, I_i2, S. **Corrected**: the printed N_i puts one corner's beta for all three.
    """
    ratio = 2.0 / (3.0 * beta)
    join = -0.5 * first + (2.5 - ratio) * second + ratio * centre[:, None]
    return (join[:, J] + join[:, K] - join) / 2.0
