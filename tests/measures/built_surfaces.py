"""Surfaces built from Bezier patches by hand, with known properties."""

from collections.abc import Callable

import numpy as np

from testbed.geometry.bernstein import multi_indices, triangle_tables
from testbed.geometry.bezier import BezierTriangles, RationalBezierTriangles
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, norm, unit

OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTANTS = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


class UnitSphere(ExactSurface):
    """The unit sphere about the origin."""

    def closest(self, points: Float) -> Float:
        return unit(points)

    def normal(self, points: Float) -> Float:
        return points

    def second_form(self, points: Float) -> Float:
        W: Float = np.eye(3) - points[:, :, None] * points[:, None, :]
        return W


class Plane(ExactSurface):
    """The plane z = 0."""

    def closest(self, points: Float) -> Float:
        return points * np.array([1.0, 1.0, 0.0])

    def normal(self, points: Float) -> Float:
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), points.shape)

    def second_form(self, points: Float) -> Float:
        return np.zeros((len(points), 3, 3))


def flat(points: Float, faces: Int) -> Surface:
    """Triangles."""
    return Surface.over_faces(HermiteMesh(points, faces), BezierTriangles(np.asarray(points)[faces]))


def octahedron() -> Surface:
    return flat(OCTAHEDRON, OCTANTS)


def bumpy_octahedron(seed: int = 0) -> Surface:
    """Quartic patches over the octahedron, blown up to the sphere, without any symmetry, with gaps and kinks."""
    net = np.einsum("nk,fkd->fnd", np.array(multi_indices(4)) / 4.0, OCTAHEDRON[OCTANTS])
    net = net / norm(net)[..., None] + 0.05 * np.random.default_rng(seed).normal(size=net.shape)
    return Surface.over_faces(HermiteMesh(OCTAHEDRON, OCTANTS), BezierTriangles(net))


def graph(height: Callable[[Float, Float], Float], degree: int, corners: Float, faces: Int) -> Surface:
    """Polynomial graph z = height(x, y) of a degree over triangles with corners (V, 2): one patch each."""
    nodes = np.array(multi_indices(degree)) / degree
    xy = np.einsum("nk,fkd->fnd", nodes, np.asarray(corners)[faces])
    on_patch = np.concatenate([xy, height(xy[..., 0], xy[..., 1])[..., None]], axis=-1)
    table = triangle_tables(degree, nodes[:, 1:], 0)[0]
    points = np.concatenate([corners, height(corners[:, 0], corners[:, 1])[:, None]], axis=-1)
    return Surface.over_faces(HermiteMesh(points, faces), BezierTriangles(np.linalg.solve(table, on_patch)))


def one_graph(height: Callable[[Float, Float], Float], degree: int) -> Surface:
    """The graph over the triangle (0, 0), (1, 0), (0, 1), so that x, y are the patch's parameters."""
    return graph(height, degree, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.array([[0, 1, 2]]))


def exact_cap(steps: int = 3) -> Surface:
    """Rational quadratic patches that lie on the unit sphere: the stereographic image of a triangulated square.

    A point (s, t) goes to (2s, 2t, 1 - s^2 - t^2) / (1 + s^2 + t^2); control points are blossoms of these quadratics.
    """
    s, t = np.meshgrid(np.linspace(-0.6, 0.6, steps + 1), np.linspace(-0.5, 0.7, steps + 1), indexing="ij")
    plane = np.stack([s.ravel(), t.ravel()], axis=-1)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"))
    a = i * (steps + 1) + j
    b, c, d = a + steps + 1, a + steps + 2, a + 1
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    pairs = np.array([[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]])
    p, q = plane[faces][:, pairs[:, 0]], plane[faces][:, pairs[:, 1]]
    product = (p * q).sum(axis=-1, keepdims=True)
    weights = (1.0 + product)[..., 0]
    points = np.concatenate([p + q, 1.0 - product], axis=-1) / weights[..., None]
    vertices = np.concatenate([2.0 * plane, 1.0 - (plane**2).sum(axis=-1, keepdims=True)], axis=-1)
    vertices /= 1.0 + (plane**2).sum(axis=-1, keepdims=True)
    return Surface.over_faces(HermiteMesh(vertices, faces), RationalBezierTriangles(points, weights))


def place(text: object) -> Float:
    """Numbers of a ``*_bary`` column."""
    return np.array([float(number) for number in str(text).split(";")])
