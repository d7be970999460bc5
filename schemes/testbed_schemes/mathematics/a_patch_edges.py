"""F over the tetrahedra of edges of A-patches (Xu, Huang and Bajaj 2001, steps 7 and 9).

The tetrahedron [u_l p_i p_j u_k] of an edge joins the apexes of its two faces: p_i is the edge's lower vertex, p_j its
higher, u_k the apex of the face that runs along the edge forward, u_l that of the face that runs back. F is a cubic
there plus the rational term (4.3); all its coefficients follow from those of the two faces. Names of coefficients as in
:mod:`testbed_schemes.mathematics.a_patch_coefficients`.

Formulas: as printed. They hold unchanged for split faces, with the weights (4.15) of the whole faces, since only layers
1 to 3 enter.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.simplex_bernstein import simplex_places
from testbed.geometry.vectors import Float, Int, cross, dot
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.split_domain import J, K


def tetrahedron_place(*corners: int) -> int:
    """Place, among the twenty coefficients over a tetrahedron, of the one that stands for these three corners."""
    return int(simplex_places(np.array([corners.count(corner) for corner in range(4)])))


@dataclass(frozen=True, slots=True)
class EdgeNets:
    """F over the tetrahedra [u_l p_i p_j u_k] of N edges on one side.

    Attributes
    ----------
    edges
        (N,) mesh edges.
    ends
        (N, 2, 3) p_i, p_j.
    apexes
        (N, 2, 3) u_l, u_k.
    rows
        (N, 2) rows of the :class:`FaceNets` of the faces l and k.
    nu, mu
        (N, 4) weights of u_k over [u_l p_i p_j p_l] and of u_l over [p_k p_i p_j u_k], (4.15).
    nets
        (N, 20) coefficients over [u_l p_i p_j u_k], the rational terms left out.
    rational
        (N, 4) a1101, b1101, a1011, b1011 of (4.3).
    """

    edges: Int
    ends: Float
    apexes: Float
    rows: Int
    nu: Float
    mu: Float
    nets: Float
    rational: Float


def barycentric_weights(x: Float, a: Float, b: Float, c: Float, d: Float) -> Float:
    """Weights (..., 4), sum 1, of the points x over tetrahedra [a b c d]."""
    ab, ac, ad, ax = b - a, c - a, d - a, x - a
    volume = dot(ab, cross(ac, ad))
    weights = [dot(ax, cross(ac, ad)) / volume, dot(ab, cross(ax, ad)) / volume, dot(ab, cross(ac, ax)) / volume]
    return np.stack([1.0 - (weights[0] + weights[1] + weights[2]), *weights], axis=-1)


@dataclass(frozen=True, slots=True)
class _AtEdge:
    """Layers of one face's tetrahedra as an edge sees them: i, j its ends, k the corner opposite, u the apex."""

    far: Float
    apex: Float
    iiu: Float
    iju: Float
    jju: Float
    iku: Float
    jku: Float
    iuu: Float
    juu: Float
    kuu: Float
    top: Float

    @classmethod
    def of(cls, nets: FaceNets, top: Float, row: Int, side: Int, forward: bool) -> "_AtEdge":
        """Read the layers of rows (N,) at sides (N,), which run from p_i to p_j or back."""
        start, end, k = side, J[side], K[side]
        i, j = (start, end) if forward else (end, start)
        layer2 = (top[:, None] + 2.0 * nets.q) / 3.0

        def up(a: Int, b: Int) -> Float:
            low, high = np.minimum(a, b), np.maximum(a, b)
            # 200 110 101 020 011 002
            value: Float = nets.layer1[row, np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])[low, high]]
            return value

        return cls(
            nets.base[row, k],
            nets.apex[row],
            up(i, i),
            up(i, j),
            up(j, j),
            up(i, k),
            up(j, k),
            layer2[row, i],
            layer2[row, j],
            layer2[row, k],
            top[row],
        )


def edge_nets(
    nets: FaceNets,
    top: Float,
    edges: Int,
    ends: tuple[Float, Float],
    vectors: tuple[Float, Float],
    rows: Int,
    sides: Int,
) -> EdgeNets:
    """Return F over the tetrahedra of edges.

    Parameters
    ----------
    nets
        F over the tetrahedra of the faces on this side.
    top
        (faces of ``nets``,) their f0003.
    edges
        (N,) mesh edges with two faces, both of which have a tetrahedron on this side.
    ends, vectors
        p_i, p_j and the gradients of F there, in the frame of the side, (N, 3) each.
    rows
        (N, 2) rows, in ``nets``, of the face that runs back and of the face that runs forward.
    sides
        (N, 2) the side of these faces along which the edge lies.
    """
    (p_i, p_j), (n_i, n_j) = ends, vectors
    back = _AtEdge.of(nets, top, rows[:, 0], sides[:, 0], forward=False)
    ahead = _AtEdge.of(nets, top, rows[:, 1], sides[:, 1], forward=True)
    mu = barycentric_weights(back.apex, ahead.far, p_i, p_j, ahead.apex)
    nu = barycentric_weights(ahead.apex, back.apex, p_i, p_j, back.far)

    def by_mu(k: Float, i: Float, j: Float, u: Float) -> Float:
        return mu[:, 0] * k + mu[:, 1] * i + mu[:, 2] * j + mu[:, 3] * u

    def by_nu(u: Float, i: Float, j: Float, far: Float) -> Float:
        return nu[:, 0] * u + nu[:, 1] * i + nu[:, 2] * j + nu[:, 3] * far

    rational = np.stack(
        [
            by_nu(back.iuu, back.iiu, back.iju, back.iku),
            by_mu(ahead.iku, ahead.iiu, ahead.iju, ahead.iuu),
            by_nu(back.juu, back.iju, back.jju, back.jku),
            by_mu(ahead.jku, ahead.iju, ahead.jju, ahead.juu),
        ],
        axis=-1,
    )
    # corners 0 u_l, 1 p_i, 2 p_j, 3 u_k; numbers 0 and 5 are zero
    coefficients = {
        (1, 1, 2): dot(p_j - p_i, n_i) / 3.0,
        (1, 2, 2): dot(p_i - p_j, n_j) / 3.0,
        (1, 1, 3): ahead.iiu,
        (1, 2, 3): ahead.iju,
        (2, 2, 3): ahead.jju,
        (1, 3, 3): ahead.iuu,
        (2, 3, 3): ahead.juu,
        (3, 3, 3): ahead.top,
        (0, 1, 1): back.iiu,
        (0, 1, 2): back.iju,
        (0, 2, 2): back.jju,
        (0, 0, 1): back.iuu,
        (0, 0, 2): back.juu,
        (0, 0, 0): back.top,
        (0, 3, 3): by_mu(ahead.kuu, ahead.iuu, ahead.juu, ahead.top),
        (0, 0, 3): by_nu(back.top, back.iuu, back.juu, back.kuu),
    }
    net = np.zeros((len(edges), 20))
    for corners, values in coefficients.items():
        net[:, tetrahedron_place(*corners)] = values
    apexes = np.stack([back.apex, ahead.apex], axis=1)
    return EdgeNets(edges, np.stack([p_i, p_j], axis=1), apexes, rows, nu, mu, net, rational)
