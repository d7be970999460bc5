"""The butterfly scheme (Dyn, Levin and Gregory 1990): interpolating subdivision of triangles, stopped at a depth.

A step keeps the vertices and puts one on every edge, from the eight vertices of its stencil: the ends of the edge, the
third vertices of its two faces, and those of the four faces next to these. What is returned are the flat facets after
``depth`` steps, so that the surface is C0 and has no curvature. Their vertices lie on the limit surface, which is C1
except at vertices of valence 3 and from 8 on (:mod:`testbed_schemes.modified_butterfly` mends that) and has no second
derivatives anywhere. Normals are not read.

Formulas: as printed inside. **Fill**: the boundary. The four-point scheme, which is the same rule on curves, subdivides
the boundary by itself, and a wing of the stencil that lies beyond a boundary edge is the reflection a + b - c of the
third vertex c of the face in the midpoint of the edge.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float
from testbed.plugins.base import Plugin
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.butterfly_stencil import edge_vertices
from testbed_schemes.mathematics.triangle_subdivision import check_size, check_two_sided, refined_places, triangulation

#: Most facets of a surface: measuring these takes some 4 GB.
MOST = 1_000_000
#: Deepest subdivision.
DEEPEST = 7


@dataclass(frozen=True)
class Butterfly(Scheme):
    """Facets of the butterfly scheme.

    Parameters
    ----------
    depth
        Steps of subdivision; a face becomes 4^depth facets.
    tension
        The paper's w: at 0 new vertices are the midpoints of the edges, at 1/16 the scheme reproduces cubics on regular
        triangulations.

    Raises
    ------
    SpecError
        ``depth`` is not between 0 and 7, or ``tension`` not between 0 and 1/8.
    """

    depth: int = 2
    tension: float = 1.0 / 16.0

    name = "butterfly"
    title = "Butterfly"
    reference = "Dyn, Levin and Gregory 1990"
    formula = (
        "New vertex of an edge: (a + b) / 2 + 2 w (c + d) - w (sum of the 4 wings), w = 1/16; flat facets after "
        "`depth` steps."
    )
    status = "As printed inside. Fill: the four-point scheme on the boundary, and reflections for wings beyond it."
    failures = (
        "Flat facets have no curvature, and their distance to a smooth surface falls with the square of the edge "
        "length only. The limit surface is creased at vertices of valence 3 and from 8 on. Normals are ignored."
    )
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_depth(self, self.depth)
        if not 0.0 <= self.tension <= 0.125:
            raise SpecError(f"{self.name}: tension must be between 0 and 1/8, and here it is {self.tension}")

    @property
    def support(self) -> int | None:  # type: ignore[override]  # a claim that the depth decides
        """One ring of faces for the first step, and a second ring for all the following, which reach half as far."""
        return min(self.depth, 2)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the facets; Refused if there were too many, or for two faces back to back."""
        check_size(self, len(mesh.faces), self.depth, MOST)
        check_two_sided(self, triangulation(mesh))
        return facets(
            mesh, self.depth, lambda faces, points: edge_vertices(faces, points, faces.half_edge, self.tension)
        )


def check_depth(plugin: Plugin, depth: int) -> None:
    """Raise SpecError for a depth out of bounds."""
    if not 0 <= depth <= DEEPEST:
        raise SpecError(f"{plugin.name}: depth must be between 0 and {DEEPEST}, and here it is {depth}")


def facets(mesh: HermiteMesh, depth: int, new_vertices: Callable[[Triangulation, Float], Float]) -> Surface:
    """Flat triangles of an interpolating subdivision scheme after ``depth`` steps.

    Parameters
    ----------
    mesh
        A mesh of triangles.
    depth
        Number of steps.
    new_vertices
        The scheme: from a triangulation and its points (V, 3) to the vertices on its edges, (E, 3).
    """
    faces, points = triangulation(mesh), mesh.points
    places = np.broadcast_to(CORNERS[3], (len(mesh.faces), 3, 2))
    for _ in range(depth):
        points = np.concatenate([points, new_vertices(faces, points)])
        faces, places = faces.refined(), refined_places(places)
    origin = np.repeat(np.arange(len(mesh.faces)), 4**depth)
    return Surface(mesh, (Part(BezierTriangles(points[faces.faces]), faces.faces, origin, places),))
