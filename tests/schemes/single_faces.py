"""Single faces with given vectors at their corners, and pairs of faces, for tests of A-patches' coefficients."""

import numpy as np

from testbed.geometry.vectors import Bool, Float, cross, dot, unit
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets, face_nets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets, edge_nets
from testbed_schemes.mathematics.a_patch_hull import apex_heights

#: The four points of the paper's figures 6 to 9, and its faces [p1 p2 p3] and [p2 p1 p4].
POINTS = np.array([[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, -1.0], [0.0, -4.0, -1.0]])
FACES = np.array([[0, 1, 2], [1, 0, 3]])
#: Vectors of figure 6, both faces convex; of figure 7, the second one not; of figure 9, neither.
FIGURE6 = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]])
FIGURE7 = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.5], [0.0, 1.0, 1.5]])
FIGURE9 = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, -1.0, 1.5], [0.0, 1.0, 1.5]])


def nets_of(base: Float, vectors: Float, split: Bool) -> FaceNets:
    """F over tetrahedra on faces (N, 3, 3) with vectors (N, 3, 3) at their corners."""
    normals = unit(cross(base[:, 1] - base[:, 0], base[:, 2] - base[:, 0]))
    heights = apex_heights(base, vectors, normals, 0.05)
    apex = base.mean(axis=1) + heights[:, None] * normals
    return face_nets(np.arange(len(base)), base, vectors, apex, split)


def figure(vectors: Float, split: tuple[bool, bool]) -> FaceNets:
    """F over the two faces of the figures."""
    return nets_of(POINTS[FACES], vectors[FACES], np.array(split))


def common_edge(nets: FaceNets, top: Float, vectors: Float) -> EdgeNets:
    """F over the tetrahedron of the edge of the figures' two faces."""
    ends, at_ends = (POINTS[:1], POINTS[1:2]), (vectors[:1], vectors[1:2])
    return edge_nets(nets, top, np.array([0]), ends, at_ends, np.array([[1, 0]]), np.array([[0, 0]]))


def random_faces(count: int, seed: int, noise: float = 0.2) -> FaceNets:
    """Faces of many shapes with vectors of many directions and lengths, half of them split."""
    random = np.random.default_rng(seed)
    base = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.9, 0.0]]) + 0.15 * random.normal(size=(2 * count, 3, 3))
    normals = unit(cross(base[:, 1] - base[:, 0], base[:, 2] - base[:, 0]))[:, None]
    bulge = random.uniform(-0.3, 0.7, (2 * count, 1, 1)) * (base - base.mean(axis=1, keepdims=True))
    vectors = unit(normals + bulge + noise * random.normal(size=base.shape)) * random.uniform(
        0.5, 2.0, (2 * count, 3, 1)
    )
    upright = np.flatnonzero((dot(vectors, normals) > 0.1).all(axis=1))[:count]
    return nets_of(base[upright], vectors[upright], np.arange(len(upright)) % 2 == 1)
