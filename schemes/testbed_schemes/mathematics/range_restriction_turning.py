"""Turning tangents in the tangent planes of low vertices whose neighbours span more than a half turn.

At the lower end of an edge, with heights A < B, the means of the second rows tend to A - gamma0 (z - A) with z between
A and B as tangents get short (:mod:`testbed_schemes.mathematics.range_restriction_legs`). Where gamma0 > 0, that is
where the next tangents on the left and on the right are more than a half turn apart, and A is small, only a kappa near
gamma0 B / A helps; where A = 0, on the plane itself, none does. Turning the two tangents towards the edge's own helps,
as directions alone decide the sign of gamma0.

Fill: not in the source. Of 12 sets of 34 scattered heights with zeros among them, 3 have edges without admissible
points if no tangents turn; with turned tangents none has. No turning is enough at vertices with three neighbours, or at
all tangents of four.
"""

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int, cross, dot
from testbed_schemes.mathematics.range_restriction_heights import EdgeHeights
from testbed_schemes.mathematics.range_restriction_network import LegNetwork

#: By how much less than a half turn the next tangents are to be apart; and the least angle of neighbouring tangents and
#: by how much less than a half turn they are apart, unless they were nearer to that before; radians.
SLACK, APART = 0.02, 0.1
#: Greatest turn of a tangent, in terms of the least angle to a neighbour at the edge's other end: slivers would fold.
LIMIT = 1.0
#: Rounds in which tangents are turned, each by a mean of what the conditions ask for.
ROUNDS = 300


def critical_ends(state: EdgeHeights, possible: Bool) -> Bool:
    """Return the ends (e, 2) of edges without admissible points at which short tangents are in the way.

    There gamma is so large that kappa = 1 remains impossible however short the tangents.

    Parameters
    ----------
    state
        Of e edges.
    possible
        (e,) true for edges that have admissible points.
    """
    gamma = np.stack([state.gamma[:, 0], -1.0 - state.gamma[:, 1]], axis=1)
    rise = state.vertex[:, ::-1] - state.vertex
    return ~possible[:, None] & (gamma * rise > 2.0 * state.vertex)


def turned(network: LegNetwork, normals: Float, legs: Float, critical: Int) -> Float:
    """Return legs (E, 2, 3), those next to the critical ones turned about the normals about as little as is enough.

    At vertices where nothing is enough the legs stay as they are.

    Parameters
    ----------
    network
        The E edges.
    normals
        (V, 3) unit normals.
    legs
        (E, 2, 3) in the tangent planes.
    critical
        Half edges of interior edges, whose next ones are to be less than a half turn apart.
    """
    vertex, (ahead, back) = network.ends.ravel(), network.around
    flat = legs.reshape(-1, 3)
    concerned = np.zeros(len(normals), dtype=np.bool_)
    concerned[vertex[critical]] = True
    near = concerned[network.ends].any(axis=1).repeat(2)  # half edges that leave or reach these vertices
    angles = np.full(len(flat), np.inf)
    of_faces = np.flatnonzero((ahead >= 0) & (near | near[ahead]))
    angles[of_faces] = turn_between(flat[of_faces], flat[ahead[of_faces]], normals[vertex[of_faces]])
    # where the edge arrives, too, it is to keep away from its neighbours
    other = np.arange(len(flat)) ^ 1
    limit = LIMIT * np.minimum(angles[other], np.where(back[other] >= 0, angles[back[other]], np.inf))
    moving = np.flatnonzero(concerned[vertex] & (ahead >= 0))
    angle = angles[moving]
    least, most = np.minimum(APART, angle), np.maximum(np.pi - APART, angle)
    span = angles[critical] + angles[back[critical]]
    turns = np.zeros(len(flat))
    for _ in range(ROUNDS):
        # each condition moves the two legs it is about alike; a leg takes the mean of its moves
        excess = span + turns[ahead[critical]] - turns[back[critical]] - (np.pi - SLACK)
        now = angle + turns[ahead[moving]] - turns[moving]
        broken = (now < 0.5 * least) | (now > 0.5 * (most + np.pi))
        if (excess <= 0.5 * SLACK).all() and not broken.any():
            break
        moves, counts = np.zeros((2, len(flat)))
        conditions = (
            (back[critical], ahead[critical], excess),
            (ahead[moving], moving, least - now),
            (moving, ahead[moving], now - most),
        )
        for first, second, too_much in conditions:
            on = too_much > 0.0
            for legs_moved, sign in ((first[on], 0.5), (second[on], -0.5)):
                np.add.at(moves, legs_moved, sign * too_much[on])
                np.add.at(counts, legs_moved, 1.0)
        turns = np.clip(turns + moves / np.maximum(counts, 1.0), -limit, limit)
    else:
        failed = np.zeros(len(normals), dtype=np.bool_)
        failed[vertex[critical[excess > 0.5 * SLACK]]] = True
        failed[vertex[moving[broken]]] = True
        turns[failed[vertex]] = 0.0
    normal, turns = normals[vertex], turns[:, None]
    rotated = np.where(turns == 0.0, flat, np.cos(turns) * flat + np.sin(turns) * cross(normal, flat))
    return rotated.reshape(legs.shape)


def turn_between(start: Float, end: Float, normal: Float) -> Float:
    """Return the angle (n,) from one vector (n, 3) to another about a unit normal, counterclockwise, from 0 to 2 pi."""
    return np.arctan2(dot(cross(start, end), normal), dot(start, end)) % (2.0 * np.pi)
