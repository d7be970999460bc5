"""Quartic boundaries and second rows on one side of a plane, joined G1 with linear coefficients (Si 2015, chapter 5).

A quartic whose control points lie at most r below the plane, except for those at its corners, stays above it
(:mod:`testbed_schemes.mathematics.quartic_lower_bound`). Boundaries start with legs in the tangent planes; a leg that
ends too low is shortened. Along an interior edge kappa is chosen so that second rows exist which stay above their
bounds; where there is none, tangents are shortened (:mod:`testbed_schemes.mathematics.range_restriction_legs`).
Of the free vector w1 by least squares only the height is changed, to the nearest admissible one. On the boundary of the
mesh nothing has to be joined: points that are too low are raised. What is on the right side already stays as it is.

Source: the outline of Si 2015, chapter 5; derived anew, with fills that the modules named here tell.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, dot
from testbed_schemes.mathematics.linear_g1 import first_rows, free_vector, linear_g1, parallel_row
from testbed_schemes.mathematics.range_restriction_legs import (
    boundaries,
    choose_tangents,
    edge_heights,
    shared_edges,
)
from testbed_schemes.mathematics.range_restriction_network import LegNetwork

#: Part of the bounds that is left to rounding errors.
SPARE = 1e-9


@dataclass(frozen=True, eq=False)
class RestrictedEdges:
    """Boundary curves and second rows of quartics along E edges.

    Attributes
    ----------
    legs
        (E, 2, 3) first legs at both ends, c1 - c0 and c3 - c4.
    kappa
        (E,) the relative factor of the condition at both ends; of the reversed edge it is 1 / kappa. 1 on the boundary
        of the mesh.
    boundary
        (E, 5, 3) quartic control points c0 to c4 of the common boundary.
    left, right
        (E, 2, 3) the inner control points p1, p2 of the second row in the patch on the left, and q1, q2 on the right,
        in the order of the edge; NaN where there is no face.
    turned
        (E, 2) true for legs that were turned.
    shortening
        (E, 2) what each given leg was multiplied by, 1 where it was kept.
    shift
        (E,) how far w1 was moved along the direction, 0 on the boundary of the mesh.
    raised
        (E, 3) how far c2 and the two points of the second row were raised along the direction on the boundary of the
        mesh, 0 inside.
    infeasible
        (E,) true where no admissible points were found; other values are meaningless there.
    """

    legs: Float
    kappa: Float
    boundary: Float
    left: Float
    right: Float
    turned: Bool
    shortening: Float
    shift: Float
    raised: Float
    infeasible: Bool

    @property
    def counts(self) -> dict[str, int]:
        """How many edges needed what; an edge may count more than once."""
        needs = {
            "edges with turned tangents": self.turned.any(axis=1),
            "edges with shortened tangents": (self.shortening < 1.0).any(axis=1),
            "edges with kappa other than 1": self.kappa != 1.0,
            "edges with moved inner points": self.shift != 0.0,
            "boundary edges with raised points": (self.raised != 0.0).any(axis=1),
        }
        return {need: int(edges.sum()) for need, edges in needs.items()}


def restrict_range(
    network: LegNetwork,
    points: Float,
    normals: Float,
    legs: Float,
    direction: Float,
    heights: Float,
    bounds: Float,
) -> RestrictedEdges:
    """Return boundaries and second rows whose control points lie at most ``bounds`` below a plane.

    Bounds of infinity restrict nothing: that is the unconstrained surface. The result does
    not depend on the order and orientation of the edges.

    Parameters
    ----------
    network
        The E edges.
    points, normals
        (V, 3) vertices and unit normals.
    legs
        (E, 2, 3) first legs of the quartic boundaries at both ends, each from its vertex towards the other one, in the
        tangent planes.
    direction
        (3,) unit normal of the plane, towards the side on which the points are.
    heights
        (V,) signed distances of the vertices from the plane, not negative.
    bounds
        (F,) how far below the plane the control points of each face may lie, see
        :mod:`testbed_schemes.mathematics.quartic_lower_bound`.
    """
    sides = np.where(network.faces >= 0, bounds[network.faces], np.inf) * (1.0 - SPARE)
    vertex = heights[network.ends]
    tangents = choose_tangents(network, points, normals, legs, direction, vertex, sides)
    legs = tangents.shortening[..., None] * tangents.legs
    count = len(legs)
    c, left, right = np.empty((count, 5, 3)), *np.full((2, count, 2, 3), np.nan)
    shift, raised = np.zeros(count), np.zeros((count, 3))
    data = (network, points, legs, direction, vertex, sides)
    at = np.flatnonzero(network.interior)
    c[at], left[at], right[at], shift[at] = inner_rows(*data, normals, at, tangents.kappa[at])
    at = np.flatnonzero(~network.interior)
    c[at], left[at], right[at], raised[at] = outer_rows(*data, at)
    return RestrictedEdges(
        legs,
        tangents.kappa,
        c,
        left,
        right,
        tangents.turned,
        tangents.shortening,
        shift,
        raised,
        tangents.infeasible,
    )


def inner_rows(
    network: LegNetwork,
    points: Float,
    legs: Float,
    direction: Float,
    vertex: Float,
    bounds: Float,
    normals: Float,
    at: Int,
    kappa: Float,
) -> tuple[Float, Float, Float, Float]:
    """Return boundaries, second rows left and right, and the shift of w1, of the interior edges with ids ``at``."""
    edges = shared_edges(network[at], points, normals, legs, at, kappa)
    least, greatest = edge_heights(edges, direction, vertex[at], bounds[at]).interval(kappa)
    coefficients = linear_g1(edges)
    w1 = free_vector(edges, coefficients)
    height = dot(w1, direction)
    shift = np.where(height < least, least - height, np.where(height > greatest, greatest - height, 0.0))
    p1, p2, q1, q2 = first_rows(edges, coefficients, w1 + shift[:, None] * direction)
    return edges.c, np.stack([p1, p2], axis=1), np.stack([q1, q2], axis=1), shift


def outer_rows(
    network: LegNetwork, points: Float, legs: Float, direction: Float, vertex: Float, bounds: Float, at: Int
) -> tuple[Float, Float, Float, Float]:
    """Return boundaries, second rows left and right, and what was raised, of the mesh's boundary edges ``at``.

    Raised cubics, and legs across that go linearly from end to end.
    """
    edges, bound = network[at], bounds[at].min(axis=1)
    start, end = (points[edges.ends[:, s]] for s in (0, 1))
    c = boundaries(start, end, legs[at], np.ones(len(at)))

    def lift(point: Float) -> Float:
        short = -bound - (vertex[at, 0] + dot(point - start, direction))
        return np.where(short > 0.0, short, 0.0)

    raised = np.zeros((len(at), 3))
    raised[:, 0] = lift(c[:, 2])
    c[:, 2] += raised[:, :1] * direction
    rows = []
    for beside in edges.beside(legs):
        # the same from both ends, whichever way the edge runs
        row = np.stack(parallel_row(c, start + beside[:, 0], end + beside[:, 1]), axis=1)
        lifts = np.stack([lift(row[:, 0]), lift(row[:, 1])], axis=1)
        raised[:, 1:] += lifts
        rows.append(row + lifts[..., None] * direction)
    return c, rows[0], rows[1], raised
