"""Functions on tetrahedra over faces and edges: quadrics, random cubics with rational terms, and pairs that join C1."""

import math

import numpy as np

from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.shooting_quads import ShootingQuads
from testbed.geometry.simplex_bernstein import elevate_simplex, simplex_multi_indices, simplex_places
from testbed.geometry.vectors import Float, cross, unit

INDICES = simplex_multi_indices(4, 3)
FACTORS = np.array([6 / math.prod(math.factorial(e) for e in row) for row in INDICES.tolist()])
#: Two triangles, p_0 p_1 p_2 and p_1 p_0 p_3, with corners on the unit sphere.
POINTS = unit(np.array([[1.0, 0.1, 0.2], [0.1, 1.0, -0.1], [0.1, 0.2, 1.0], [0.9, 0.9, -1.0]]))
NONE = np.nan


def place(*index: int) -> int:
    return int(simplex_places(np.array(index)))


def quadric_net(corners: Float, form: Float, constant: float) -> Float:
    """Coefficients (20,) of x . form x - constant on a tetrahedron with corners (4, 3)."""
    net = []
    for row in simplex_multi_indices(4, 2).tolist():
        first, second = (corner for corner in range(4) for _ in range(row[corner]))
        net.append(corners[first] @ form @ corners[second] - constant)
    raised: Float = elevate_simplex(np.array(net)[:, None], 4, 2)[:, 0]
    return raised


def apex(face: Float, height: float) -> Float:
    point: Float = face.mean(axis=0) + height * unit(cross(face[1] - face[0], face[2] - face[0]))
    return point


FACES = (POINTS[[0, 1, 2]], POINTS[[1, 0, 3]])
ABOVE = tuple(apex(face, 1.5) for face in FACES)
BELOW = tuple(apex(face, -1.5) for face in FACES)


def face_batch(net: Float, rational: Float, above: bool = True, corners: Float | None = None) -> ShootingTriangles:
    """Patch of the face p_0 p_1 p_2 with a tetrahedron on one side; net (20,), rational (3,)."""
    tip = ABOVE[0] if above else BELOW[0]
    return ShootingTriangles(
        FACES[0][None],
        on_side(tip, above),
        on_side(net, above),
        on_side(rational, above),
        (np.eye(3) if corners is None else corners)[None],
    )


def edge_batch(
    net: Float, rational: Float, above: bool = True, span: tuple[float, float] = (0.0, 1.0)
) -> ShootingQuads:
    """Patch of the edge p_0 p_1, which the face p_0 p_1 p_2 follows forward, with tetrahedra on one side."""
    tips = np.stack(ABOVE[::-1] if above else BELOW[::-1])
    return ShootingQuads(
        POINTS[None, :2], on_side(tips, above), on_side(net, above), on_side(rational, above), np.array([span])
    )


def on_side(values: Float, above: bool) -> Float:
    """One patch (1, 2, ...) with these values on one side, NaN on the other."""
    nothing = np.full_like(values, NONE)
    return np.stack([values, nothing] if above else [nothing, values])[None]


def edge_corners(above: bool = True) -> Float:
    second, first = ABOVE if above else BELOW
    return np.stack([first, POINTS[0], POINTS[1], second])


def face_corners(above: bool = True) -> Float:
    return np.concatenate([FACES[0], (ABOVE if above else BELOW)[0][None]])


def sphere_face(above: bool = True) -> ShootingTriangles:
    return face_batch(quadric_net(face_corners(above), np.eye(3), 1.0), np.zeros(3), above)


def sphere_edge() -> ShootingQuads:
    return edge_batch(quadric_net(edge_corners(), np.eye(3), 1.0), np.zeros(4))


def random_face(seed: int = 0, roughness: float = 0.02) -> ShootingTriangles:
    """Near the unit sphere, through its corners, with a rational term."""
    rng = np.random.default_rng(seed)
    net = quadric_net(face_corners(), np.eye(3), 1.0) + roughness * rng.normal(size=20)
    net[[place(3, 0, 0, 0), place(0, 3, 0, 0), place(0, 0, 3, 0)]] = 0.0
    return face_batch(net, 10.0 * roughness * rng.normal(size=3))


def joining_edge(face: ShootingTriangles, seed: int = 0, roughness: float = 0.02) -> ShootingQuads:
    """Patch of the edge p_0 p_1 that joins the patch of p_0 p_1 p_2 C1 along its side v = 1.

    On the shared triangle [p_0 p_1 u] both rational terms have the derivatives of polynomials: on the face that of
    coefficient 2, as if it were part of 1110, on the edge those of b_1101 and b_1011.
    """
    rng = np.random.default_rng(seed)
    on_face = face.nets[0, 0].copy()
    on_face[place(1, 1, 1, 0)] += face.rational[0, 0, 2]
    corners = face_corners()
    # the apex over the other face in the barycentric coordinates of the tetrahedron over this one
    system = np.concatenate([corners.T, np.ones((1, 4))])
    mu = np.linalg.solve(system, np.append(ABOVE[1], 1.0))
    net = quadric_net(edge_corners(), np.eye(3), 1.0) + roughness * rng.normal(size=20)
    rational = np.zeros(4)
    for e in INDICES.tolist():
        other, i, j, tip = e
        # the corners of the face's tetrahedron are p_0 = p_i, p_1 = p_j, p_2 and u
        if other == 0:
            net[place(*e)] = on_face[place(i, j, 0, tip)]
        elif other == 1:
            raised = ((i + 1, j, 0, tip), (i, j + 1, 0, tip), (i, j, 1, tip), (i, j, 0, tip + 1))
            net[place(*e)] = sum(mu[k] * on_face[place(*index)] for k, index in enumerate(raised))
    # part of two coefficients into the rational terms, which do not see how it is divided
    for k, index in enumerate(((1, 1, 0, 1), (1, 0, 1, 1))):
        moved = roughness * rng.normal()
        net[place(*index)] -= moved
        rational[2 * k : 2 * k + 2] = roughness * rng.normal(), moved
    return edge_batch(net, rational)


#: F on the sides of a face that crosses the surface: pairs of coefficients on p_0 p_1, p_1 p_2 and p_2 p_0.
CROSSING = ((-0.04, -0.04), (-0.01, 0.05), (0.05, 0.02))


def nonconvex_face(
    seed: int = 0, sides: tuple[tuple[float, float], ...] = CROSSING, middle: float = 0.01
) -> ShootingTriangles:
    """Patch of the face p_0 p_1 p_2 that crosses the face: F < 0 on it near the side p_0 p_1, F > 0 near p_2.

    F and its gradient are the same on both sides of the face, coefficients at least two steps away from it are rough.
    """
    rng = np.random.default_rng(seed)
    nets = []
    slope = unit(cross(FACES[0][1] - FACES[0][0], FACES[0][2] - FACES[0][0]))
    for tip in (ABOVE[0], BELOW[0]):
        corners = np.concatenate([FACES[0], tip[None]])
        net = np.zeros(20)
        # layer 0, and layer 1 from the derivative across the face: a linear function
        for i, pair in enumerate(sides):
            two, one = np.roll([2, 1, 0], i), np.roll([1, 2, 0], i)
            net[place(*two, 0)], net[place(*one, 0)] = pair
        net[place(1, 1, 1, 0)] = middle
        across = (corners[3] - corners[:3].mean(axis=0)) @ slope / 3.0
        for i in range(3):
            for j in range(i, 3):
                lower = np.zeros(4, dtype=np.int64)
                lower[i] += 1
                lower[j] += 1
                # F at (q, q, apex): the mean of the three neighbours on the face plus the slope across it
                neighbours = [net[place(*(lower + unit_index))] for unit_index in np.eye(4, dtype=np.int64)[:3]]
                net[place(*lower[:3], 1)] = np.mean(neighbours) + across
        sign = 1.0 if tip is ABOVE[0] else -1.0
        for e in INDICES.tolist():
            if e[3] >= 2:
                net[place(*e)] = sign * (0.6 + 0.1 * rng.uniform())
        nets.append(net)
    return ShootingTriangles(
        FACES[0][None], np.stack([ABOVE[0], BELOW[0]])[None], np.stack(nets)[None], np.zeros((1, 2, 3)), np.eye(3)[None]
    )


#: Two triangles that are nearly in one plane: p_0 p_1 p_2 and p_1 p_0 p_3.
FLAT = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.6, 0.9, 0.1], [0.45, -0.8, 0.05]])
#: Where F changes its sign between p_0 and p_1 there.
PINCH = 2.0 / 7.0


def nonconvex_edge(span: tuple[float, float], seed: int = 0) -> ShootingQuads:
    """Patch over a part of the edge p_0 p_1 of the flat pair, F < 0 on it before the pinch and F > 0 after it.

    F is z plus a cubic of x, but for the coefficients at least two steps away from the edge, which are rough: gradients
    on the edge are the same in both tetrahedra.
    """
    rng = np.random.default_rng(seed)
    on_edge = np.array([0.0, -0.02, 0.05, 0.0])
    faces = FLAT[[0, 1, 2]], FLAT[[1, 0, 3]]
    tips, nets = [], []
    for height in (0.4, -0.4):
        first, second = apex(faces[1], height), apex(faces[0], height)
        net = np.zeros(20)
        for e in INDICES.tolist():
            rise = (e[0] * first[2] + e[3] * second[2]) / 3.0
            if e[0] + e[3] == 0:
                net[place(*e)] = on_edge[e[2]]
            elif e[0] + e[3] == 1:
                x = first[0] if e[0] else second[0]
                net[place(*e)] = rise + (1.0 - x) * on_edge[e[2]] + x * on_edge[e[2] + 1]
            else:
                net[place(*e)] = rise + 0.05 * rng.normal()
        tips.append(np.stack([first, second]))
        nets.append(net)
    rational = 0.05 * rng.normal(size=(1, 2, 4))
    # C1 across the edge needs no rational terms there: they vanish on it with their gradients
    return ShootingQuads(FLAT[None, :2], np.stack(tips)[None], np.stack(nets)[None], rational, np.array([span]))
