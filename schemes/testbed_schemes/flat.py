"""The flat faces themselves: one linear Bezier triangle a face, what every other scheme is compared with.

Matches the points and nothing else; neighbours share their edges, so the surface is C0. Sampled from a smooth surface,
its distance falls with the square of the edge length, and that cannot be improved.
"""

from dataclasses import dataclass

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape


@dataclass(frozen=True)
class Flat(Scheme):
    """Flat triangles."""

    name = "flat"
    title = "Flat triangles"
    reference = "piecewise linear interpolation"
    formula = "b_0 V_0 + b_1 V_1 + b_2 V_2"
    status = "As everybody knows it; what the other schemes are compared with."
    failures = "Has no curvature and ignores the normals."
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = 2
    reproduces = (Shape.PLANES,)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the faces as Bezier triangles of degree one."""
        return Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()))
