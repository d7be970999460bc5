"""The butterfly's stencil (Dyn, Levin and Gregory 1990): where new vertices on edges lie, interpolating.

**Fill**: the boundary. The four-point scheme, which is the same rule on curves, subdivides the boundary by itself, and
a wing of the stencil that lies beyond a boundary edge is the reflection a + b - c of the third vertex c of the face in
the midpoint of the edge.
"""

import numpy as np

from testbed.geometry.triangulation import Triangulation, following, preceding
from testbed.geometry.vectors import Float, Int


def edge_vertices(faces: Triangulation, points: Float, half_edge: Int, tension: float) -> Float:
    """New vertices (N, 3) on edges given by half edges (N,): butterfly's and, on the boundary, four-point rule."""
    new = np.empty((len(half_edge), 3))
    inner = faces.twin[half_edge] >= 0
    new[inner] = butterfly_rule(faces, points, half_edge[inner], tension)
    new[~inner] = four_point_rule(faces, points, half_edge[~inner], tension)
    return new


def butterfly_rule(faces: Triangulation, points: Float, half_edge: Int, tension: float) -> Float:
    """(a + b) / 2 + 2 w (c + d) - w (wings), (N, 3), at interior half edges (N,)."""
    twin = faces.twin[half_edge]
    ends = points[faces.start[half_edge]] + points[faces.end[half_edge]]
    apexes = points[faces.apex[half_edge]] + points[faces.apex[twin]]
    left = across(faces, points, following(half_edge)) + across(faces, points, preceding(half_edge))
    right = across(faces, points, following(twin)) + across(faces, points, preceding(twin))
    return 0.5 * ends + tension * (2.0 * apexes - (left + right))


def four_point_rule(faces: Triangulation, points: Float, half_edge: Int, tension: float) -> Float:
    """(1/2 + w) (a + b) - w (neighbours along the boundary), (N, 3), at half edges (N,) of the boundary."""
    a, b = faces.start[half_edge], faces.end[half_edge]
    before, after = faces.start[faces.arriving[a]], faces.end[faces.onward[b]]
    return (0.5 + tension) * (points[a] + points[b]) - tension * (points[before] + points[after])


def across(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """Third vertices of the faces across half edges (N,), (N, 3); beyond the boundary the reflections of our own."""
    twin = faces.twin[half_edge]
    reflected = points[faces.start[half_edge]] + points[faces.end[half_edge]] - points[faces.apex[half_edge]]
    return np.where((twin >= 0)[:, None], points[faces.apex[twin]], reflected)
