"""Edges with data for tests of boundary curves, and what is read off the curves."""

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, dot, norm, unit


def sampled_edges(count: int = 300, seed: int = 1) -> EdgeData:
    """Edges between points of a bent graph with data of that surface, nothing symmetric, lengths 0.1 to 1."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1.0, 1.0, (count, 2))
    angle, length = rng.uniform(0.0, 2 * np.pi, count), rng.uniform(0.1, 1.0, count)
    end = start + length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    data = [values for at in (start, end) for values in graph_data(at)]
    return EdgeData(data[0], data[3], data[1], data[4], data[2], data[5])


def graph_data(at: Float) -> tuple[Float, Float, Float]:
    """Points, normals and second forms of z = -(x^2 + x y / 2 + y^2) / 2 + x^3 / 10 - x y^2 / 15."""
    x, y = at.T
    z = -(x**2 + x * y / 2 + y**2) / 2 + x**3 / 10 - x * y**2 / 15
    slope = np.stack([-x - y / 4 + 3 * x**2 / 10 - y**2 / 15, -y - x / 4 - 2 * x * y / 15], axis=-1)
    hessian = np.empty((len(x), 2, 2))
    hessian[:, 0, 0], hessian[:, 1, 1] = -1 + 6 * x / 10, -1 - 2 * x / 15
    hessian[:, 0, 1] = hessian[:, 1, 0] = -1 / 4 - 2 * y / 15
    normal = unit(np.concatenate([-slope, np.ones((len(x), 1))], axis=1))
    onto = np.eye(3) - normal[:, :, None] * normal[:, None]
    W = -np.einsum("eia,eab,ejb->eij", onto[:, :, :2], hessian * normal[:, 2, None, None], onto[:, :, :2])
    return np.stack([x, y, z], axis=-1), normal, W


def moved(edges: EdgeData, rotation: Float, scale: float, shift: Float) -> EdgeData:
    points = [scale * p @ rotation.T + shift for p in (edges.p0, edges.p1)]
    normals = [n @ rotation.T for n in (edges.n0, edges.n1) if n is not None]
    forms = [rotation @ W @ rotation.T / scale for W in (edges.W0, edges.W1) if W is not None]
    return EdgeData(*points, *normals, *forms)


def reversed_edges(edges: EdgeData) -> EdgeData:
    return EdgeData(edges.p1, edges.p0, edges.n1, edges.n0, edges.W1, edges.W0)


def chosen(edges: EdgeData, which: slice) -> EdgeData:
    ends = (edges.n0, edges.n1, edges.W0, edges.W1)
    return EdgeData(edges.p0[which], edges.p1[which], *(None if a is None else a[which] for a in ends))


def arc(angle: float, radius: float = 1.0) -> EdgeData:
    """One edge over an arc of a great circle of a sphere."""
    n = np.array([[np.cos(t), np.sin(t), 0.0] for t in (0.0, angle)])
    W = (np.eye(3) - n[:, :, None] * n[:, None]) / radius
    return EdgeData(radius * n[:1], radius * n[1:], n[:1], n[1:], W[:1], W[1:])


def flat_edges() -> EdgeData:
    edges = sampled_edges(50)
    ends = [p * [1.0, 1.0, 0.0] for p in (edges.p0, edges.p1)]
    normal, W = np.broadcast_to([0.0, 0.0, 1.0], (50, 3)), np.zeros((50, 3, 3))
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return moved(EdgeData(ends[0], ends[1], normal, normal, W, W), rotation, 1.0, np.full(3, 5.0))


def lengths(edges: EdgeData) -> Float:
    return norm(edges.p1 - edges.p0)


def legs(curves: Float) -> tuple[Float, Float]:
    return norm(curves[:, 1] - curves[:, 0]), norm(curves[:, 3] - curves[:, 2])


def normal_curvatures(curves: Float, edges: EdgeData) -> tuple[Float, Float]:
    """-<C'', n> / |C'|^2 at both ends."""
    assert edges.n0 is not None
    assert edges.n1 is not None
    first, last = curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2]
    middle = curves[:, 2] - curves[:, 1]
    at_start = -6 * dot(middle - first, edges.n0) / (9 * dot(first, first))
    at_end = -6 * dot(last - middle, edges.n1) / (9 * dot(last, last))
    return at_start, at_end
