"""The scheme of Jensen (1987): three quartic Bezier triangles a face, C1 inside.

Matches position and normal at the corners. Across mesh edges it is the scheme of Shirman and Sequin: the same
Chiyokura-Kimura fields, with the quadratic scaling that Jensen introduced. Inside a face the joins are C1 where those
of Shirman and Sequin are G1, and both schemes have the same second rows along the edges if alpha_i2 = 9/4 there. The
curvature at the vertices is that of the construction, not the data's.

Formulas: Mann 1992, sections 2.2.3 and 2.3.1, as printed. **Fill**: N_i, which the C1 conditions leave free, keeps the
cubic where split cubics would fit; the thesis does not say how Jensen sets it, nor which C.
"""

from dataclasses import dataclass
from types import MappingProxyType

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
from testbed_schemes.mathematics.split_domain import (
    J,
    K,
    SplitFaces,
    c1_ring,
    corner_neighbours,
    cubic_reproducing_inner,
)


@dataclass(frozen=True)
class Jensen(Scheme):
    """Jensen's split quartics.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges.
    jensen_c
        Jensen's C, the relative size of the cross-boundary derivative half-way along an edge; 1 is Chiyokura and
        Kimura's linear field. Below 1/2 a patch may fold over its edges.

    Raises
    ------
    SpecError
        ``jensen_c`` is not finite.
    """

    boundary: BoundaryCurve = Projected()
    jensen_c: float = 1.0

    name = "jensen"
    title = "Jensen"
    reference = "Jensen 1987; Mann 1992, section 2.3.1"
    formula = (
        "Three quartics a face with cubic edges; second rows by Chiyokura-Kimura with k(1/2) = C (k(0) + k(1)) / 2; "
        "every spoke point is the centroid of its three neighbours."
    )
    status = (
        "As printed across the edges and on the spokes. Fill: the N_i, which are those of split cubics raised to "
        "quartics where such fit, and C = 1."
    )
    failures = (
        "Refused where normals fold the surface over, or are opposite as seen along their edge. With C = 1 the "
        "curvature of large faces varies: Gaussian from 0.37 to 2.6 on the octahedron, data of the unit sphere."
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
        """Build three quartics a face."""
        network = self.boundary.network(mesh)
        check_fields(self, network)
        curves, normals = network.opposite_vertices(), mesh.corner_normals()

        def nets(faces: slice) -> Float:
            return split_faces(curves[faces], normals[faces], self.jensen_c).nets()

        net = in_blocks(nets, len(curves))
        return Surface.over_split_faces(mesh, BezierTriangles(net.reshape(-1, *net.shape[2:])), network.notes)


def split_faces(curves: Float, normals: Float, jensen_c: float) -> SplitFaces:
    """Return the control points of the three quartics of each face.

    Parameters
    ----------
    curves
        (F, 3, 4, 3) cubic edge opposite corner i, from corner i + 1 to corner i + 2.
    normals
        (F, 3, 3) unit normals by corner.
    jensen_c
        Jensen's C.
    """
    boundary = elevate_curve(curves)
    towards_next, towards_previous = corner_neighbours(boundary)
    corner = boundary[:, K, 0]
    # to the first spoke points, the centroids of the corner and its neighbours
    leg = ((towards_next - corner) + (towards_previous - corner)) / 3.0
    cross_points = cross_boundary_points(curves, leg[:, J], leg[:, K], normals[:, J], normals[:, K], jensen_c)
    return c1_ring(boundary, cross_points, cubic_reproducing_inner(boundary, curves, cross_points))
