"""F of A-patches at any points of its tetrahedra, for tests: by its formula, gradients by complex arithmetic."""

import math
from collections.abc import Callable

import numpy as np

from testbed.conformance.meshes import torus
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.simplex_bernstein import simplex_multi_indices
from testbed.geometry.vectors import Bool, Float, Int
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull, nets_of_edges, nets_of_faces

#: Step of complex differentiation: its square vanishes beside everything.
STEP = 1e-30
INDICES = simplex_multi_indices(4, 3)
COUNTS = np.array([6 // math.prod(math.factorial(e) for e in index) for index in INDICES.tolist()], dtype=np.float64)


def cubic(net: Float, at: Float) -> Float:
    """Sum of f B over the twenty coefficients (N, 20) at barycentric coordinates (N, S, 4), real or complex."""
    powers = np.prod(at[..., None, :] ** INDICES, axis=-1)
    value: Float = (net[:, None] * COUNTS * powers).sum(axis=-1)
    return value


def face_term(rational: Float, at: Float) -> Float:
    """The rational term of (4.1), coefficients (N, 3)."""
    a, b, c = (at[..., s] for s in range(3))
    top = rational[:, None, 0] * b * c + rational[:, None, 1] * a * c + rational[:, None, 2] * a * b
    below = b * c + a * c + a * b
    two = np.sort(np.abs(at[..., :3]), axis=-1)[..., 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        value: Float = np.where(two < 1e-12, 0.0, 6.0 * a * b * c * top / below)
    return value


def edge_term(rational: Float, at: Float) -> Float:
    """The rational terms of (4.3), coefficients a1101, b1101, a1011, b1011, (N, 4)."""
    one, two, three, four = (at[..., s] for s in range(4))
    a1101, b1101, a1011, b1011 = (rational[:, None, s] for s in range(4))
    top = two * (a1101 * one + b1101 * four) + three * (a1011 * one + b1011 * four)
    with np.errstate(invalid="ignore", divide="ignore"):
        value: Float = np.where(np.abs(one) + np.abs(four) < 1e-12, 0.0, 6.0 * one * four * top / (one + four))
    return value


def directions(corners: Float) -> Float:
    """Derivatives (N, 3, 4) of the barycentric coordinates of tetrahedra (N, 4, 3) along x, y and z."""
    edges = corners[:, 1:] - corners[:, :1]
    slopes = np.linalg.inv(edges).swapaxes(-1, -2)  # rows: gradients of coordinates 1 to 3
    rows = np.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)
    result: Float = np.ascontiguousarray(rows.swapaxes(-1, -2))
    return result


def value_and_gradient(net: Float, rational: Float, corners: Float, points: Float) -> tuple[Float, Float]:
    """F and its gradient, (N, S) and (N, S, 3), at points (N, S, 3); the term is told by the width of ``rational``."""
    slopes = directions(corners)
    at = np.einsum("nxa,nsx->nsa", slopes, points - corners[:, None, 0]) + np.eye(4)[0]
    term = face_term if rational.shape[1] == 3 else edge_term
    value = cubic(net, at) + term(rational, at)
    columns = []
    for axis in range(3):
        moved = at + 1j * STEP * slopes[:, None, axis]
        columns.append((cubic(net, moved) + term(rational, moved)).imag / STEP)
    return value, np.stack(columns, axis=-1)


def face_tetrahedra(nets: FaceNets, top: Float) -> tuple[Float, Float, Float, tuple[Int, Int]]:
    """Corners (R, 4, 3), coefficients (R, 20) and (R, 3) of all pieces, and their owners and thirds."""
    pieces = nets.pieces()
    corners = np.concatenate([pieces.base, nets.apex[pieces.owner, None]], axis=1)
    return corners, pieces.nets(top[pieces.owner]), pieces.rational, (pieces.owner, pieces.corner)


def edge_corners(nets: EdgeNets) -> Float:
    """Corners (N, 4, 3) of the tetrahedra of edges."""
    return np.stack([nets.apexes[:, 0], nets.ends[:, 0], nets.ends[:, 1], nets.apexes[:, 1]], axis=1)


def noisy_torus(around: int = 16, across: int = 8, seed: int = 1) -> HermiteMesh:
    """A torus of 2 * around * across faces, noise in its vertices and vectors: most faces nonconvex, none flat."""
    rng, smooth = np.random.default_rng(seed), torus(around, across, 3)
    assert smooth.normals is not None
    points = smooth.points + 0.02 * rng.normal(size=smooth.points.shape)
    return HermiteMesh(points, smooth.faces, gradients=smooth.normals + 0.2 * rng.normal(size=points.shape))


def gradient_jumps(
    found: Hull, split: Bool, turns: Float | None = None, change: Callable[[FaceNets], FaceNets] = lambda nets: nets
) -> dict[str, float]:
    """Worst jumps of F and its gradient across the faces between tetrahedra, relative, by the kind of the faces.

    The free coefficients are the paper's default; ``change`` alters coefficients before edges take theirs from them.
    """
    mesh, rng = found.mesh, np.random.default_rng(5)
    vertices, faces = len(mesh.points), len(mesh.faces)
    ids, where, coefficients = [], [], []
    for side, sign in enumerate(SIDES):
        nets = change(nets_of_faces(found, side, split, turns))
        corners, net, rational, (owner, third) = face_tetrahedra(nets, nets.default)
        face = nets.faces[owner]
        names = np.column_stack([mesh.faces[face], vertices + faces * (1 + side) + face])
        (inner,) = np.nonzero(third >= 0)
        names[inner, third[inner]] = vertices + face[inner]
        edges = nets_of_edges(found, side, nets, nets.default)
        apexes = vertices + faces * (1 + side) + mesh.edge_faces[edges.edges]
        start, end = mesh.edges[edges.edges].T
        ids += [names, np.column_stack([apexes[:, 1], start, end, apexes[:, 0]])]
        where += [corners, edge_corners(edges)]
        coefficients += [(sign * net, sign * rational), (sign * edges.nets, sign * edges.rational)]
    kinds = ("F+", "E+", "F-", "E-")
    shared: dict[tuple[int, ...], list[tuple[int, int, int]]] = {}
    for kind, names in enumerate(ids):
        for row, name in enumerate(names.tolist()):
            for omitted in range(4):
                key = tuple(sorted(name[:omitted] + name[omitted + 1 :]))
                shared.setdefault(key, []).append((kind, row, omitted))
    pairs: dict[str, list[tuple[int, int, int, int]]] = {}
    for members in shared.values():
        if len(members) == 2:
            (k1, r1, _), (k2, r2, _) = members
            pairs.setdefault(kinds[k1] + kinds[k2], []).append((k1, r1, k2, r2))
    worst = {}
    for name, members4 in pairs.items():
        k1, r1, k2, r2 = np.array(members4).T
        one, other = where[k1[0]][r1], where[k2[0]][r2]
        common = np.array(
            [
                [i for i, p in enumerate(a) if (np.abs(b - p).sum(axis=1) == 0.0).any()]
                for a, b in zip(one, other, strict=True)
            ]
        )
        weights = rng.dirichlet(np.ones(3), (len(one), 5))
        points = np.einsum("nsk,nkx->nsx", weights, np.take_along_axis(one, common[..., None], axis=1))
        jumps, size = [], np.zeros(1)
        for kind, row, corners in ((k1[0], r1, one), (k2[0], r2, other)):
            net, rational = coefficients[kind]
            value, gradient = value_and_gradient(net[row], rational[row], corners, points)
            jumps.append((value, gradient))
            size = np.abs(gradient).max(axis=(1, 2))
        gap = np.abs(jumps[0][0] - jumps[1][0]).max(axis=1)
        turn = np.abs(jumps[0][1] - jumps[1][1]).max(axis=(1, 2))
        worst[name] = float((np.maximum(gap, turn) / size).max())
    return worst
