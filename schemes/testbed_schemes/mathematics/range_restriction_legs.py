"""How long tangents may be, and which kappa, so that control points on one side of a plane exist along all edges.

A vertex's tangents are multiplied by a common factor, which leaves alpha and gamma at its edges as they are. As both
ends' tangents get short, c2 tends to z = (B + kappa A) / (1 + kappa), A and B the heights of the vertices, and

    R1 -> A - gamma0 (z - A),   R3 -> B - (1 + gamma1) (B - z),   R4 -> 0.

If |gamma0| <= 1 and |1 + gamma1| <= 1, as with tangents of equal lengths at a vertex, some kappa makes both positive;
so edges with A, B > 0 become admissible in the end. Far from that end a large kappa is no cure: kappa multiplies the
tangents at the start and 1 / kappa those at the end, and control points are thrown far off.

Source: Si 2015, sections 5.2.2 and 5.3.2, of which only the outline is available. Fill: everything but the shortening
of single legs. Measured on 24 sets of scattered heights, slivers among their triangles, against shortening at both ends
by 0.8 until any kappa fits: where kappa times the tangents' factor is limited to 4, only those ends are shortened that
need it, and tangents turn at low vertices (:mod:`testbed_schemes.mathematics.range_restriction_turning`), the surface
is nearer to the unconstrained one by a third (rms), and 5 faces fold over somewhere instead of 29. Other limits from 2
to 16, smaller steps, tangents lengthened again afterwards, or kappa chosen by how little control points move make no
difference worth it.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.blocks import blocks
from testbed.geometry.vectors import Bool, Float, Int, dot, norm
from testbed_schemes.mathematics.linear_g1 import SharedEdge, boundary, linear_g1
from testbed_schemes.mathematics.range_restriction_heights import EdgeHeights
from testbed_schemes.mathematics.range_restriction_network import LegNetwork
from testbed_schemes.mathematics.range_restriction_turning import critical_ends, turned

#: Values of kappa above 1 in the order they are tried, each after its reciprocal or before: up to 2^20.
KAPPAS = 2.0 ** (np.arange(1, 41) / 2.0)
#: Greatest kappa times the factor of the tangents at the start, and 1 / kappa times that at the end, unless kappa = 1.
REACH = 4.0
#: Kappa and its reciprocal count as equally good if the widths of their intervals differ by less, relatively.
TIE = 1e-6
#: Greatest ratio of the factors of two tangents at a vertex at first: patches fold over between a short and a long one.
EVEN = 5.0
#: Tangents are shortened by powers of this factor, up to the number of steps at once.
FACTOR, STEPS = 0.8, 60
#: Tangents much longer than others at the vertex are cut to this part of the longest one.
CUT = 0.75
#: Rounds of shortening before edges are given up.
ROUNDS = 100
#: Which ends are shortened, and what a step costs.
ENDS = ((np.array([1.0, 0.0]), 1), (np.array([0.0, 1.0]), 1), (np.array([1.0, 1.0]), 2))


@dataclass(frozen=True, eq=False)
class Tangents:
    """Tangents and kappa.

    Attributes
    ----------
    legs
        (E, 2, 3) the given legs, some of them turned.
    turned
        (E, 2) true for those.
    shortening
        (E, 2) factors of the legs, 1 where their lengths are kept.
    kappa
        (E,) 1 on the boundary of the mesh.
    infeasible
        (E,) true where second rows above the bounds were not found.
    """

    legs: Float
    turned: Bool
    shortening: Float
    kappa: Float
    infeasible: Bool


def choose_tangents(
    network: LegNetwork, points: Float, normals: Float, legs: Float, direction: Float, vertex: Float, bounds: Float
) -> Tangents:
    """Turn and shorten legs and choose kappa until second rows above the bounds exist along all interior edges.

    Parameters
    ----------
    network
        The E edges.
    points, normals
        (V, 3) vertices and unit normals.
    legs
        (E, 2, 3) first legs of the quartic boundaries.
    direction
        (3,) unit normal of the plane.
    vertex, bounds
        (E, 2) heights of the ends of the edges, and bounds of their faces left and right, infinity where none.
    """
    given, inside = legs, np.flatnonzero(network.interior)

    def look(open_: Int, shortening: Float) -> tuple[EdgeHeights, Float, Bool]:
        edges = network[open_]
        shared = shared_edges(edges, points, normals, shortening[..., None] * legs, open_, np.ones(len(open_)))
        state = edge_heights(shared, direction, vertex[open_], bounds[open_])
        return state, *choose_kappa(state, factors_around(edges, shortening, open_))

    shortening = evened(network, first_shortening(vertex, dot(legs, direction), bounds.min(axis=1)))
    state, _, possible = look(inside, shortening)
    critical = critical_ends(state, possible)
    if critical.any():
        legs = turned(network, normals, given, (2 * inside[:, None] + np.arange(2))[critical])
        shortening = evened(network, first_shortening(vertex, dot(legs, direction), bounds.min(axis=1)))
    kappa, infeasible, open_ = np.ones(len(legs)), np.zeros(len(legs), dtype=np.bool_), inside
    for round_ in range(ROUNDS):
        state, kappa[open_], possible = look(open_, shortening)
        infeasible[open_] = ~possible
        bad = open_[~possible]
        if not len(bad) or round_ == ROUNDS - 1:
            break
        lengths = shortening * norm(legs)
        factors = further_shortening(network, bad, state[~possible], shortening, lengths)
        changed = np.zeros(len(points), dtype=np.bool_)
        changed[network.ends[factors < 1.0]] = True
        shortening = shortening * factors
        # an edge depends on the tangents at its ends alone; those that stay bad are looked at again
        open_ = np.flatnonzero(network.interior & (changed[network.ends].any(axis=1) | infeasible))
    return Tangents(legs, (legs != given).any(axis=2), shortening, kappa, infeasible)


def first_shortening(vertex: Float, leg: Float, bounds: Float) -> Float:
    """Return factors (E, 2) that end legs just above the bounds (E,) of their edges where they end below.

    Parameters
    ----------
    vertex, leg
        (E, 2) heights of the vertices and of the legs.
    """
    # not on the bound itself, where rounding would decide what else is possible
    room = vertex + (1.0 - TIE) * bounds[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(leg < -vertex - bounds[:, None], room / -leg, 1.0)


def evened(network: LegNetwork, shortening: Float) -> Float:
    """Return factors (E, 2) of legs, none of which is more than :data:`EVEN` times the least one at its vertex."""
    least = np.ones(int(network.ends.max(initial=-1)) + 1)
    np.minimum.at(least, network.ends, shortening)
    return np.minimum(shortening, EVEN * least[network.ends])


def shared_edges(
    edges: LegNetwork, points: Float, normals: Float, legs: Float, chosen: Int, kappa: Float
) -> SharedEdge:
    """Return interior edges with their boundaries and what is next to them.

    Parameters
    ----------
    edges
        The chosen edges.
    points, normals
        (V, 3).
    legs
        (E, 2, 3) of all edges.
    chosen
        (e,) ids of the chosen edges.
    kappa
        (e,) of the chosen edges.
    """
    left, right = edges.beside(legs)
    start, end = (points[edges.ends[:, s]] for s in (0, 1))
    n0, n1 = (normals[edges.ends[:, s]] for s in (0, 1))
    c = boundaries(start, end, legs[chosen], kappa)
    return SharedEdge(c, start + left[:, 0], end + left[:, 1], start + right[:, 0], end + right[:, 1], kappa, n0, n1)


def boundaries(start: Float, end: Float, legs: Float, kappa: Float) -> Float:
    """Return the control points (e, 5, 3) of boundaries with legs (e, 2, 3)."""
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
        (e, 2) heights of the ends, and bounds of the faces left and right.
    """
    coefficients = linear_g1(edges)
    c = edges.c
    legs = np.stack([dot(c[:, 1] - c[:, 0], direction), dot(c[:, 3] - c[:, 4], direction)], axis=1)
    across = np.stack([dot(edges.p0 - edges.q0, direction), dot(edges.p3 - edges.q3, direction)], axis=1)
    return EdgeHeights(vertex, legs, across, coefficients.alpha, coefficients.gamma, bounds)


def factors_around(edges: LegNetwork, shortening: Float, chosen: Int) -> Float:
    """Return the greatest factor of the three legs at both ends of the chosen edges, (e, 2)."""
    return np.maximum(shortening[chosen], np.maximum(*edges.beside(shortening)))


def choose_kappa(state: EdgeHeights, factors: Float) -> tuple[Float, Bool]:
    """Return for each edge the admissible kappa nearest to 1, and whether there is one.

    Of kappa and 1 / kappa the one with the wider interval; none of them if they are equally wide, as on edges that are
    symmetric, whose ends must not be told apart.

    Parameters
    ----------
    state
        Of e edges.
    factors
        (e, 2) of the legs at both ends, which limit kappa.
    """
    kappa, possible = np.ones(len(factors)), state.admissible(np.ones(len(factors)))
    open_ = np.flatnonzero(~possible)
    for block in blocks(len(open_)):
        chosen = open_[block]
        many = state[chosen].for_many()
        up, down = (
            np.where(within, many.width(kappas), -1.0)
            for kappas, within in (
                (KAPPAS, factors[chosen, :1] * KAPPAS <= REACH),
                (1.0 / KAPPAS, factors[chosen, 1:] * KAPPAS <= REACH),
            )
        )
        wider = np.maximum(up, down)
        good = (wider >= 0.0) & (np.abs(up - down) > TIE * wider)
        first = np.argmax(good, axis=1)[:, None]
        grows = np.take_along_axis(up > down, first, axis=1)[:, 0]
        nearest = KAPPAS[first[:, 0]]
        possible[chosen] = good.any(axis=1)
        kappa[chosen] = np.where(possible[chosen], np.where(grows, nearest, 1.0 / nearest), 1.0)
    return kappa, possible


def further_shortening(network: LegNetwork, bad: Int, state: EdgeHeights, shortening: Float, lengths: Float) -> Float:
    """Return factors (E, 2) of legs at the ends of edges without admissible points; one a vertex, but for cuts.

    Parameters
    ----------
    network
        All edges.
    bad
        Ids of those without.
    state
        Of those.
    shortening, lengths
        (E, 2) factors of the legs up to now, and their lengths.
    """
    found, factors = sufficient_shortening(state, factors_around(network[bad], shortening, bad))
    ends = network.ends[bad]
    count = int(network.ends.max()) + 1
    longest, shortest, greatest, scale = np.zeros(count), np.full(count, np.inf), np.full(count, np.inf), np.ones(count)
    np.maximum.at(longest, network.ends, lengths)
    np.minimum.at(shortest, network.ends, lengths)
    # tangents of equal lengths make |gamma| <= 1: then shortening helps
    uneven = ~found[:, None] & (np.abs(state.gamma + np.array([0.0, 1.0])) > 1.0 + 1e-9)
    cut = ends[uneven]
    greatest[cut] = np.maximum(shortest, CUT * longest)[cut]
    factors[uneven.any(axis=1)] = 1.0
    np.minimum.at(scale, ends, factors)
    return np.minimum(1.0, greatest[network.ends] / lengths) * scale[network.ends]


def sufficient_shortening(state: EdgeHeights, factors: Float) -> tuple[Bool, Float]:
    """Return whether shortening the legs at the ends, one or both, is known to help, and factors (e, 2) that do.

    The least shortening of one end, or of both by the same factor; one step at both where none is known.

    Parameters
    ----------
    state
        Of e edges.
    factors
        (e, 2) of the legs up to now.
    """
    count = len(factors)
    cost, result = np.full(count, np.inf), np.full((count, 2), FACTOR)

    def helps(chosen: Int, ends: Float, step: int) -> tuple[Bool, Float]:
        scaled = np.broadcast_to(FACTOR ** (step * ends), (len(chosen), 2))
        return choose_kappa(state[chosen].scaled(scaled), factors[chosen] * scaled)[1], scaled[:1]

    # where the shortest tangents do not help there is no use in trying longer ones
    hopeful = np.any([helps(np.arange(count), ends, STEPS)[0] for ends, _ in ENDS], axis=0)
    for step in range(1, STEPS + 1):
        open_ = np.flatnonzero(hopeful & (cost > step))
        if not len(open_):
            break
        for ends, price in ENDS:
            possible, scale = helps(open_, ends, step)
            better, equal = (
                open_[possible & (price * step < cost[open_])],
                open_[possible & (price * step == cost[open_])],
            )
            cost[better], result[better] = price * step, scale
            # either end as well as the other: both, as nothing tells them apart
            result[equal] = np.minimum(result[equal], scale)
    return np.isfinite(cost), result
