"""Random Bezier patches, not far from flat ones, in random places and of random sizes."""

import numpy as np

from testbed.geometry.bernstein import multi_indices
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Float


def triangles(degree: int, count: int, seed: int = 0, roughness: float = 0.05) -> BezierTriangles:
    rng = np.random.default_rng(seed)
    nodes = multi_indices(degree) / degree
    net = np.concatenate([nodes[:, 1:], np.zeros((len(nodes), 1))], axis=1)
    net = net + roughness * rng.normal(size=(count, len(nodes), 3))
    return BezierTriangles(
        net @ rotation(rng) * np.exp(rng.normal(size=(count, 1, 1))) + rng.normal(size=(count, 1, 3))
    )


def quads(degrees: tuple[int, int], count: int, seed: int = 0, roughness: float = 0.05) -> BezierQuads:
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(*(np.linspace(0.0, 1.0, degree + 1) for degree in degrees), indexing="ij")
    net = np.stack([x, y, 0.0 * x], axis=-1) + roughness * rng.normal(size=(count, *x.shape, 3))
    return BezierQuads(net @ rotation(rng) + rng.normal(size=(count, 1, 1, 3)))


def rational(degree: int, count: int, seed: int = 0) -> RationalBezierTriangles:
    points = triangles(degree, count, seed).control_points
    return RationalBezierTriangles(points, np.random.default_rng(seed).uniform(0.7, 1.4, points.shape[:2]))


def rotation(rng: np.random.Generator) -> Float:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turned: Float = q * np.sign(np.linalg.det(q))
    return turned


#: Two hundred patches, and rational ones beside.
KINDS: dict[str, PatchBatch] = {
    "quadratic triangles": triangles(2, 50, 1),
    "cubic triangles": triangles(3, 50, 2),
    "quartic triangles": triangles(4, 50, 3),
    "bicubic patches": quads((3, 3), 50, 4),
    "rational quadratic triangles": rational(2, 20, 5),
    "rational cubic triangles": rational(3, 8, 6),
}
