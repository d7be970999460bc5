"""Quartic boundaries and second rows on one side of a plane, joined G1 with linear coefficients (Si 2015, chapter 5).

A quartic whose control points lie at most r below the plane, except for those at its corners, stays above it
(:mod:`testbed_schemes.mathematics.quartic_lower_bound`). Boundaries start with legs in the tangent planes; a leg that
ends too low is shortened. Along an interior edge kappa is chosen so that second rows exist which stay above their
bounds; where there is no such kappa, the legs at both ends are shortened, and kappa is chosen anew. Of the free vector
w1 by least squares only the height is changed, to the nearest admissible one.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, dot, norm
from testbed_schemes.mathematics.linear_g1 import (
    SharedEdge,
    boundary,
    first_rows,
    free_vector,
    linear_g1,
    parallel_row,
)
from testbed_schemes.mathematics.range_restriction_heights import EdgeHeights
from testbed_schemes.mathematics.range_restriction_network import LegNetwork

#: Values of kappa in the order they are tried, the nearest to 1 first: powers of the square root of 2 to 2^20, 2^-20.
KAPPAS = np.array([2.0 ** (sign * k / 2.0) for k in range(41) for sign in ((1, -1) if k else (1,))])
#: Part of the bounds that is left to rounding errors.
SPARE = 1e-9
#: Rounds of shortening before edges are given up.
ROUNDS = 400


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
    shortening
        (E, 2) what each given leg was multiplied by, 1 where it was kept.
    shift
        (E,) how far w1 was moved along the direction, 0 on the boundary of the mesh.
    raised
        (E, 2) how far the two points of the second row were raised along the direction on the boundary of the mesh, 0
        inside.
    infeasible
        (E,) true where no admissible points were found; other values are meaningless there.
    """

    legs: Float
    kappa: Float
    boundary: Float
    left: Float
    right: Float
    shortening: Float
    shift: Float
    raised: Float
    infeasible: Bool

    @property
    def counts(self) -> dict[str, int]:
        """How many edges needed what: shortened legs, kappa other than 1, moved and raised second rows."""
        return {
            "edges with shortened tangents": int((self.shortening < 1.0).any(axis=1).sum()),
            "edges with kappa other than 1": int((self.kappa != 1.0).sum()),
            "edges with moved inner points": int(((self.shift != 0.0) | (self.raised != 0.0).any(axis=1)).sum()),
        }


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

    Legs keep their directions. Bounds of infinity restrict nothing: that is the unconstrained surface. The result does
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
    given, vertex = legs, heights[network.ends]
    shortening = first_shortening(vertex, dot(given, direction), sides.min(axis=1))
    inside, outside = np.flatnonzero(network.interior), np.flatnonzero(~network.interior)
    inner = network[inside]
    kappa, infeasible = np.ones(len(given)), np.zeros(len(given), dtype=np.bool_)
    for _ in range(ROUNDS):
        legs = shortening[..., None] * given
        edges = shared_edges(inner, points, normals, legs, inside, kappa[inside])
        state = edge_heights(edges, direction, vertex[inside], sides[inside])
        kappa[inside], possible = choose_kappa(state)
        infeasible[inside] = ~possible
        if possible.all():
            break
        shortening *= further_shortening(network, inside[~possible], state.gamma[~possible], norm(legs))
    result = RestrictedEdges(
        legs, kappa, *np.full((1, len(given), 5, 3), np.nan), *np.full((2, len(given), 2, 3), np.nan), shortening,
        np.zeros(len(given)), np.zeros((len(given), 2)), infeasible,
    )  # fmt: skip
    inner_rows(result, shared_edges(inner, points, normals, legs, inside, kappa[inside]), state, inside, direction)
    outer_rows(result, network[outside], points, outside, direction, vertex[outside], sides[outside])
    return result


def first_shortening(vertex: Float, leg: Float, bounds: Float) -> Float:
    """Return factors (E, 2) of legs that put their ends on the bounds (E,) of their edges where they are below.

    Parameters
    ----------
    vertex, leg
        (E, 2) heights of the vertices and of the legs.
    """
    room = vertex + bounds[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(leg < -room, room / -leg, 1.0)


def shared_edges(
    network: LegNetwork, points: Float, normals: Float, legs: Float, chosen: Int, kappa: Float
) -> SharedEdge:
    """Return interior edges with what is next to them.

    Parameters
    ----------
    network
        The chosen edges.
    points, normals
        (V, 3).
    legs
        (E, 2, 3) of all edges.
    chosen
        Ids of the chosen edges.
    kappa
        Of the chosen edges.
    """
    left, right = network.beside(legs)
    start, end = (points[network.ends[:, s]] for s in (0, 1))
    n0, n1 = (normals[network.ends[:, s]] for s in (0, 1))
    c = boundaries(start, end, legs[chosen], kappa)
    return SharedEdge(c, start + left[:, 0], end + left[:, 1], start + right[:, 0], end + right[:, 1], kappa, n0, n1)


def boundaries(start: Float, end: Float, legs: Float, kappa: Float) -> Float:
    """Return the control points (E, 5, 3) of boundaries with legs (E, 2, 3)."""
    first, last = start + legs[:, 0], end + legs[:, 1]
    return np.stack([start, first, boundary(start, first, last, end, kappa), last, end], axis=1)


def edge_heights(edges: SharedEdge, direction: Float, vertex: Float, bounds: Float) -> EdgeHeights:
    """Return what the conditions of interior edges are made of.

    Parameters
    ----------
    edges
        With any kappa.
    direction
        (3,) unit normal of the plane.
    vertex, bounds
        (E, 2) heights of the ends, and bounds of the faces left and right.
    """
    coefficients = linear_g1(edges)
    c = edges.c
    legs = np.stack([dot(c[:, 1] - c[:, 0], direction), dot(c[:, 3] - c[:, 4], direction)], axis=1)
    across = np.stack([dot(edges.p0 - edges.q0, direction), dot(edges.p3 - edges.q3, direction)], axis=1)
    return EdgeHeights(vertex, legs, across, coefficients.alpha, coefficients.gamma, bounds)


def choose_kappa(state: EdgeHeights) -> tuple[Float, Bool]:
    """Return for each edge the first admissible one of :data:`KAPPAS`, and whether there is one."""
    kappa, possible = np.ones(len(state.vertex)), state.admissible(np.ones(len(state.vertex)))
    open_ = np.flatnonzero(~possible)
    admissible = state[open_].__getitem__((slice(None), slice(None), None)).admissible(KAPPAS)
    kappa[open_] = KAPPAS[np.argmax(admissible, axis=1)]
    possible[open_] = admissible.any(axis=1)
    return kappa, possible


def further_shortening(network: LegNetwork, bad: Int, gamma: Float, lengths: Float) -> Float:
    """Return factors (E, 2) of legs at the ends of edges without admissible points.

    Parameters
    ----------
    network
        All edges.
    bad
        Ids of those without.
    gamma
        Their coefficients, (bad, 2).
    lengths
        (E, 2) of the legs.
    """
    count = int(network.ends.max(initial=-1)) + 1
    longest, shortest, cap, scale = np.zeros(count), np.full(count, np.inf), np.full(count, np.inf), np.ones(count)
    np.maximum.at(longest, network.ends, lengths)
    np.minimum.at(shortest, network.ends, lengths)
    uneven = np.abs(gamma + np.array([0.0, 1.0])) > 1.0 + 1e-9
    ends = network.ends[bad]
    cap[ends[uneven]] = np.maximum(shortest, 0.75 * longest)[ends[uneven]]
    scale[ends[~uneven.any(axis=1)]] = 0.8
    return np.minimum(1.0, cap[network.ends] / lengths) * scale[network.ends]


def inner_rows(result: RestrictedEdges, edges: SharedEdge, state: EdgeHeights, at: Int, direction: Float) -> None:
    """Fill in boundary and second rows of the interior edges with ids ``at``."""
    coefficients = linear_g1(edges)
    w1 = free_vector(edges, coefficients)
    least, greatest = state.interval(edges.kappa)
    height = dot(w1, direction)
    shift = np.minimum(np.maximum(height, least), greatest) - height
    p1, p2, q1, q2 = first_rows(edges, coefficients, w1 + shift[:, None] * direction)
    result.boundary[at], result.shift[at] = edges.c, shift
    result.left[at], result.right[at] = np.stack([p1, p2], axis=1), np.stack([q1, q2], axis=1)


def outer_rows(
    result: RestrictedEdges, network: LegNetwork, points: Float, at: Int, direction: Float, vertex: Float, sides: Float
) -> None:
    """Fill in boundary and second rows of the boundary's edges with ids ``at``, raised to the bounds."""
    legs = result.legs[at]
    start, end = (points[network.ends[:, s]] for s in (0, 1))
    c = boundaries(start, end, legs, np.ones(len(at)))
    bound = sides.min(axis=1)
    c[:, 2] += lift(c[:, 2] - start, vertex[:, 0], bound, direction)[:, None] * direction
    result.boundary[at] = c
    for row, beside in zip((result.left, result.right), network.beside(result.legs), strict=True):
        points_ = np.stack(parallel_row(c, start + beside[:, 0], end + beside[:, 1]), axis=1)
        raised = lift(points_ - start[:, None], vertex[:, :1], bound[:, None], direction)
        row[at] = points_ + raised[..., None] * direction
        result.raised[at] += np.where(np.isnan(raised), 0.0, raised)


def lift(vectors: Float, heights: Float, bounds: Float, direction: Float) -> Float:
    """Return how far points, given as vectors from others with heights, have to be raised to their bounds."""
    short = -bounds - (heights + dot(vectors, direction))
    return np.where(short < 0.0, 0.0, short)


def inner_points(first: Float, second: Float) -> Float:
    """Return the three inner control points of the three quartics of each face, (F, 3, 3, 3): quartic s, at corner i.

    Quartic s is the one that meets the neighbour along side s, from corner s to corner s + 1. Its points at these two
    corners are those of its second row; its third one, at corner s + 2, is the mean of that of the two others.

    Parameters
    ----------
    first, second
        (F, 3, 3) inner points of the second row along side s in the direction of the face, next to corner s and next to
        corner s + 1.
    """
    points = np.empty((len(first), 3, 3, 3))
    s = np.arange(3)
    points[:, s, s], points[:, s, (s + 1) % 3] = first, second
    points[:, s, (s + 2) % 3] = 0.5 * (np.roll(second, -1, axis=1) + np.roll(first, -2, axis=1))
    return points
