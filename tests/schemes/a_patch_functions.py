"""The function F of A-patches by its definition, sum after sum: a reference for what is computed in layers."""

import math

import numpy as np

from testbed.geometry.simplex_bernstein import simplex_multi_indices
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.a_patch_coefficients import FacePieces
from testbed_schemes.mathematics.a_patch_edges import EdgeNets

_STEPS = np.arange(4) / 3.0
_TO_BERNSTEIN = np.linalg.inv([[math.comb(3, s) * t**s * (1.0 - t) ** (3 - s) for s in range(4)] for t in _STEPS])


def polynomial(nets: Float, alpha: Float) -> Float:
    """Cubics (N, 20) over tetrahedra at barycentric coordinates (N | 1, S, 4), (N, S)."""
    powers = [np.ones(alpha.shape), alpha, alpha * alpha, alpha * alpha * alpha]
    total = np.zeros(np.broadcast_shapes((len(nets), 1), alpha.shape[:-1]))
    for coefficient, exponents in zip(nets.T, simplex_multi_indices(4, 3).tolist(), strict=True):
        factor = 6.0 / math.prod(math.factorial(e) for e in exponents)
        total += factor * coefficient[:, None] * math.prod(powers[e][..., i] for i, e in enumerate(exponents))
    return total


def on_faces(pieces: FacePieces, top: Float, alpha: Float) -> Float:
    """Return F of (4.1) at barycentric coordinates (R | 1, S, 4), (R, S)."""
    a = alpha[..., :3]
    pairs = np.stack([a[..., 1] * a[..., 2], a[..., 2] * a[..., 0], a[..., 0] * a[..., 1]], axis=-1)
    total, weighted = pairs.sum(axis=-1), (pieces.rational[:, None] * pairs).sum(axis=-1)
    value: Float = polynomial(pieces.nets(top), alpha) + 6.0 * a.prod(axis=-1) * weighted / np.where(
        total > 0.0, total, 1.0
    )
    return value


def on_edges(edges: EdgeNets, alpha: Float) -> Float:
    """Return F of (4.3), likewise."""
    a1, a2, a3, a4 = np.moveaxis(alpha, -1, 0)
    a1101, b1101, a1011, b1011 = (edges.rational[:, k, None] for k in range(4))
    weighted = a2 * (a1101 * a1 + b1101 * a4) + a3 * (a1011 * a1 + b1011 * a4)
    total = np.where(a1 + a4 > 0.0, a1 + a4, 1.0)
    value: Float = polynomial(edges.nets, alpha) + 6.0 * a1 * a4 * weighted / total
    return value


def face_rays(pieces: FacePieces, top: Float, q: Float) -> Float:
    """Bernstein coefficients (R, S, 4) of F on the rays from barycentric coordinates (S, 3) to the apexes."""
    start = np.concatenate([q, np.zeros((len(q), 1))], axis=1)
    values = [on_faces(pieces, top, ((1.0 - t) * start + t * np.eye(4)[3])[None]) for t in _STEPS]
    return np.asarray(np.stack(values, axis=-1) @ _TO_BERNSTEIN.T)


def edge_rays(edges: EdgeNets, at: Float) -> Float:
    """Bernstein coefficients (N, S, 4) of F on the rays from x p_i + (1 - x) p_j to y u_k + (1 - y) u_l, at (x, y)."""
    x, y = at[:, 0], at[:, 1]
    values = []
    for t in _STEPS:
        alpha = np.stack([(1.0 - y) * t, x * (1.0 - t), (1.0 - x) * (1.0 - t), y * t], axis=-1)
        values.append(on_edges(edges, alpha[None]))
    return np.asarray(np.stack(values, axis=-1) @ _TO_BERNSTEIN.T)
