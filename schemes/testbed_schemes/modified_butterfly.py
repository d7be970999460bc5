"""The modified butterfly scheme (Zorin, Schroder and Sweldens 1996): C1 at vertices of every valence, up to a depth.

Where the ends of an edge are regular (valence 6), the butterfly's rule with w = 1/16. At a vertex v of another valence
K the new vertices on its edges come from its ring e_0, ..., e_(K-1), e_0 at the other end of the edge: 3/4 v +
sum s_j e_j, where s_j = (1/4 + cos(2 pi j / K) + cos(4 pi j / K) / 2) / K from valence 5 on. Between two such vertices
the mean of both. What is returned are the flat facets after ``depth`` steps: C0, without curvature; their vertices lie
on the limit surface. Normals are not read.

Formulas: as printed inside. On the boundary as in the authors' later course notes (Zorin and Schroder 2000, section
4.3), which public implementations follow: the four-point rule along the boundary, and rules of their own for edges that
leave regular vertices of the boundary (three faces) and others. **Fill**: the rule of an edge that crosses a strip one
face wide, whose weights could not be read anywhere: reflections for the missing wings, as in
:mod:`testbed_schemes.butterfly`.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.triangulation import Triangulation, following, preceding
from testbed.geometry.vectors import Bool, Float, Int
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.butterfly import MOST, check_depth, facets
from testbed_schemes.mathematics.butterfly_stencil import across, butterfly_rule, four_point_rule
from testbed_schemes.mathematics.triangle_subdivision import check_size, check_two_sided, triangulation

TENSION = 1.0 / 16.0


@dataclass(frozen=True)
class ModifiedButterfly(Scheme):
    """Facets of the modified butterfly scheme.

    Parameters
    ----------
    depth
        Steps of subdivision; a face becomes 4^depth facets.

    Raises
    ------
    SpecError
        ``depth`` is not between 0 and 7.
    """

    depth: int = 2

    name = "modified-butterfly"
    title = "Modified butterfly"
    reference = "Zorin, Schroder and Sweldens 1996; Zorin and Schroder 2000, section 4.3"
    formula = (
        "The butterfly's rule between vertices of valence 6; at others 3/4 v + sum s_j e_j over the ring, s_j = (1/4 + "
        "cos(2 pi j / K) + cos(4 pi j / K) / 2) / K from valence 5 on; flat facets after `depth` steps."
    )
    status = (
        "As printed inside, and on the boundary as in the later course notes. Fill: edges that cross a strip one face "
        "wide."
    )
    failures = (
        "Flat facets have no curvature, and their distance to a smooth surface falls with the square of the edge "
        "length only. Normals are ignored."
    )
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the depth."""
        check_depth(self, self.depth)

    @property
    def support(self) -> int | None:  # type: ignore[override]  # a claim that the depth decides
        """As for the butterfly: the rules for other valences reach no further than its wings."""
        return min(self.depth, 2)

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the facets; Refused if there were too many, or for two faces back to back."""
        check_size(self, len(mesh.faces), self.depth, MOST)
        check_two_sided(self, triangulation(mesh))
        return facets(mesh, self.depth, edge_vertices)


def edge_vertices(faces: Triangulation, points: Float) -> Float:
    """New vertices of all edges, (E, 3)."""
    forth, back = faces.half_edge, faces.twin[faces.half_edge]
    new = np.empty((len(forth), 3))
    inner = back >= 0
    new[~inner] = four_point_rule(faces, points, forth[~inner], TENSION)
    regular = faces.face_count == np.where(faces.on_boundary, 3, 6)
    start, end = inner & ~regular[faces.start[forth]], inner & ~regular[faces.end[forth]]
    new[start] = ring_rules(faces, points, forth[start])
    at_end = ring_rules(faces, points, back[end])
    new[end] = np.where(start[end, None], 0.5 * (new[end] + at_end), at_end)
    bounded = faces.on_boundary[faces.start[forth]], faces.on_boundary[faces.end[forth]]
    for chosen, half_edge, rule in (
        (~bounded[0] & ~bounded[1], forth, inner_rule),
        (bounded[0] & ~bounded[1], forth, inward_rule),
        (~bounded[0] & bounded[1], back, inward_rule),
        (bounded[0] & bounded[1], forth, crossing_rule),
    ):
        rows = inner & ~start & ~end & chosen
        new[rows] = rule(faces, points, half_edge[rows])
    return new


def inner_rule(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """Between vertices inside of valence 6: the butterfly's rule."""
    return butterfly_rule(faces, points, half_edge, TENSION)


def inward_rule(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """From a regular vertex c of the boundary, with boundary neighbours b and b', to a regular one i inside.

    (10 i + 6 c + b + 3 d - w - 2 x - b') / 16, where b and d are the third vertices of the two faces of the edge, and w
    and x lie across their sides b i and d i.
    """
    c, i, twin = faces.start[half_edge], faces.end[half_edge], faces.twin[half_edge]
    at_left = beside_boundary(faces, half_edge)[:, None]
    left, right = points[faces.apex[half_edge]], points[faces.apex[twin]]
    left_wing, right_wing = across(faces, points, following(half_edge)), across(faces, points, preceding(twin))
    b, d = np.where(at_left, left, right), np.where(at_left, right, left)
    w, x = np.where(at_left, left_wing, right_wing), np.where(at_left, right_wing, left_wing)
    return (
        10.0 * points[i] + 6.0 * points[c] + b + 3.0 * d - w - 2.0 * x - far_neighbour(faces, points, half_edge)
    ) / 16.0


def crossing_rule(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """Between two regular vertices a, b of the boundary, through the inside.

    With f and g their boundary neighbours that are in neither face of the edge: if the edge cuts off a corner,
    (a + b) / 2 + d / 4 - (f + g) / 8, d the third vertex away from the corner; if it crosses a strip, (a + b) / 2 +
    (c + d - f - g) / 16, c and d the third vertices.
    """
    twin = faces.twin[half_edge]
    ends = points[faces.start[half_edge]] + points[faces.end[half_edge]]
    left, right = points[faces.apex[half_edge]], points[faces.apex[twin]]
    far = far_neighbour(faces, points, half_edge) + far_neighbour(faces, points, twin)
    corner_at_left = beside_boundary(faces, half_edge)
    cuts_corner = corner_at_left != beside_boundary(faces, twin)
    away = np.where(corner_at_left[:, None], right, left)
    return 0.5 * ends + np.where(cuts_corner[:, None], (2.0 * away - far) / 8.0, (left + right - far) / 16.0)


def beside_boundary(faces: Triangulation, half_edge: Int) -> Bool:
    """(N,) true where the next edge counterclockwise about the start of a half edge is on the boundary, else false."""
    at_left: Bool = faces.twin[preceding(half_edge)] < 0
    return at_left


def far_neighbour(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """Of the two boundary neighbours of a half edge's start, the one that is in none of its two faces, (N, 3)."""
    start = faces.start[half_edge]
    before, after = faces.start[faces.arriving[start]], faces.end[faces.onward[start]]
    return points[np.where(beside_boundary(faces, half_edge), after, before)]


def ring_rules(faces: Triangulation, points: Float, half_edge: Int) -> Float:
    """New vertices (N, 3) on half edges that leave irregular vertices, from the rings of these."""
    new = np.empty((len(half_edge), 3))
    vertex = faces.start[half_edge]
    for bounded in (False, True):
        rows = faces.on_boundary[vertex] == bounded
        for count in np.unique(faces.face_count[vertex[rows]]).tolist():
            (chosen,) = np.nonzero(rows & (faces.face_count[vertex] == count))
            if bounded:
                place = faces.fan_place(half_edge[chosen])
                ring = points[faces.ring(faces.onward[vertex[chosen]], count + 1)]
                own, weights = boundary_weights(count)
                own, weights = own[place], weights[place]
            else:
                ring = points[faces.ring(half_edge[chosen], count)]
                own, weights = np.full(len(chosen), 0.75), np.broadcast_to(inner_weights(count), (len(chosen), count))
            new[chosen] = own[:, None] * points[vertex[chosen]]
            for weight, neighbour in zip(weights.T, np.moveaxis(ring, 1, 0), strict=True):
                new[chosen] += weight[:, None] * neighbour
    return new


def inner_weights(valence: int) -> Float:
    """Weights s_j (K,) of the ring of a vertex inside, from the new vertex's edge on."""
    if valence == 3:
        return np.array([5.0, -1.0, -1.0]) / 12.0
    if valence == 4:
        return np.array([3.0, 0.0, -1.0, 0.0]) / 8.0
    turn = 2.0 * np.pi * np.arange(valence) / valence
    return np.asarray((0.25 + np.cos(turn) + 0.5 * np.cos(2.0 * turn)) / valence)


def boundary_weights(faces: int) -> tuple[Float, Float]:
    """Weights for new vertices on the inner edges i = 1, ..., k - 1 of a vertex of the boundary with k faces.

    With theta = pi / k: 1 - sin(theta) sin(i theta) / (k (1 - cos(theta))) at the vertex, (sin(i theta) sin(j theta) +
    sin(2 i theta) sin(2 j theta) / 2) / k at its inner neighbours j, and at the first and the last, with opposite
    signs, cos(i theta) / 4 - sin(2 theta) sin(2 i theta) / (4 k (cos(theta) - cos(2 theta))).

    Returns
    -------
    own
        (k + 1,) weights of the vertex by i; those of the boundary edges are not used.
    ring
        (k + 1, k + 1) weights of its neighbours by i and j.
    """
    theta = np.pi / faces
    angle = theta * np.arange(faces + 1)
    sine, double = np.sin(angle), np.sin(2.0 * angle)
    own = 1.0 - np.sin(theta) * sine / (faces * (1.0 - np.cos(theta)))
    ring = (sine[:, None] * sine + 0.5 * double[:, None] * double) / faces
    last = 0.25 * np.cos(angle) - np.sin(2.0 * theta) * double / (4.0 * faces * (np.cos(theta) - np.cos(2.0 * theta)))
    ring[:, 0], ring[:, -1] = last, -last
    return own, ring
