"""Phong tessellation (Boubekeur and Alexa 2008): one quadratic Bezier triangle a face, from points and normals.

The points of the flat face are projected onto the tangent planes of the three corners; the mean of the projections,
weighted with the barycentric coordinates, is a quadratic triangle, and ``alpha`` mixes it with the flat face. The patch
passes through the corners but does not have their normals (11 degrees off on the octahedron). A boundary curve depends
on the data at its two ends only, so the surface is C0.

The projections alone bend twice as much as a surface through fine data, so that alpha = 1/2 has its curvature; the
published 3/4 bends 3/2 times as much, and is meant for the looks of coarse meshes. Formulas: as printed.
"""

from dataclasses import dataclass

from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, tangential
from testbed.plugins.base import check_finite
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import edge_normals
from testbed_schemes.nagata import quadratic_triangles


@dataclass(frozen=True)
class Phong(Scheme):
    """Phong tessellation.

    Parameters
    ----------
    alpha
        Share of the projections; 0 is the flat face.

    Raises
    ------
    SpecError
        ``alpha`` is not finite.
    """

    alpha: float = 0.75

    name = "phong"
    title = "Phong tessellation"
    reference = "Boubekeur and Alexa 2008"
    formula = (
        "Quadratic Bezier triangle; middle points (1 - alpha) (V_i + V_j) / 2 + alpha (pi_i(V_j) + pi_j(V_i)) / 2, "
        "pi_i the orthogonal projection onto the tangent plane at V_i."
    )
    status = "As printed."
    failures = (
        "Misses the normals it is given. On fine meshes the default bends 3/2 times as much as the surface (Gaussian "
        "curvature 9/4 on the unit sphere) and its distance falls with the square of the edge length only, as for "
        "flat faces; alpha = 1/2 bends right."
    )
    needs = Data.POINTS | Data.NORMALS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check alpha."""
        check_finite(self, "alpha")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the quadratic triangles."""
        return Surface.over_faces(mesh, quadratic_triangles(mesh, middle_points(mesh.edge_data, self.alpha)))


def middle_points(edges: EdgeData, alpha: float) -> Float:
    """Middle control points of all edges, (E, 3).

    pi_i(V_j) = V_i + the part of V_j - V_i in the tangent plane at V_i.
    """
    n0, n1 = edge_normals(edges)
    d = edges.p1 - edges.p0
    projections = edges.p0 + tangential(d, n0) + (edges.p1 - tangential(d, n1))
    return (1.0 - alpha) * (edges.p0 + edges.p1) / 2.0 + alpha * projections / 2.0
