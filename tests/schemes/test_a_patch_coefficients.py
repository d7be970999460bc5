"""F over the tetrahedra of A-patches: C1 everywhere, data interpolated, quadrics kept; what was misprinted fails."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trivariate_functions import (
    edge_corners,
    face_tetrahedra,
    gradient_jumps,
    noisy_torus,
    value_and_gradient,
)

from testbed.conformance.meshes import icosahedron
from testbed.geometry.bernstein import index_of
from testbed.geometry.loop_normals import loop_limit_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.simplex_bernstein import simplex_multi_indices
from testbed.geometry.vectors import Bool, Float, Int, dot
from testbed_datasets.joined_faces import Case, JoinedFaces
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_coefficients import (
    FaceNets,
    clough_tocher,
    face_nets,
    foot_weight,
    middle_coefficient,
    quadratic_layer,
)
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull, hull, nets_of_edges, nets_of_faces
from testbed_schemes.mathematics.split_domain import J, K

CASES: tuple[Case, ...] = ("convex", "mixed", "nonconvex", "flat")


def example(case: Case) -> Hull:
    return hull(JoinedFaces(case).mesh(0), 0.05, 1e-12)


def nonconvex(found: Hull) -> Bool:
    return np.asarray(found.faces == Convexity.NONCONVEX)


@pytest.mark.parametrize("case", CASES)
def test_f_is_c1_on_the_papers_examples(case: Case) -> None:
    found = example(case)
    jumps = gradient_jumps(found, nonconvex(found))
    expected = {
        "convex": {"F+E+"},
        "mixed": {"F+E+", "F+F+", "F+F-", "F-F-"},
        "nonconvex": {"F+E+", "F+F+", "F+F-", "F-F-", "F-E-"},
        "flat": {"F+F+", "F+F-", "F-F-"},
    }
    assert set(jumps) == expected[case]
    assert max(jumps.values()) <= 1e-14


@pytest.mark.parametrize("normals", ["noisy", "loop"])
def test_f_is_c1_on_a_noisy_torus(normals: str) -> None:
    mesh = noisy_torus()
    if normals == "loop":
        mesh = HermiteMesh(mesh.points, mesh.faces, gradients=loop_limit_normals(mesh.points, mesh.faces))
    found = hull(mesh, 0.05, 1e-12)
    assert all((found.faces == kind).sum() > 20 for kind in (Convexity.POSITIVE, Convexity.NONCONVEX))
    assert all((found.edges == kind).sum() > 20 for kind in (1, 2, 3))
    jumps = gradient_jumps(found, nonconvex(found))
    assert set(jumps) == {"F+E+", "F-E-", "F+F-", "F+F+", "F-F-"}
    assert max(jumps.values()) <= 1e-12


def test_f_interpolates_values_and_gradients_at_the_vertices() -> None:
    found = hull(noisy_torus(), 0.05, 1e-12)
    for side, sign in enumerate(SIDES):
        nets = nets_of_faces(found, side, nonconvex(found))
        corners, net, rational, (owner, third) = face_tetrahedra(nets, nets.default)
        value, gradient = value_and_gradient(net, rational, corners, corners[:, :3])
        given_vectors = sign * found.vectors[found.mesh.faces[nets.faces[owner]]]
        own = third[:, None] != np.arange(3)  # the centre of a split face is no vertex
        assert np.abs(value)[own].max() <= 1e-13
        assert np.abs(gradient - given_vectors)[own].max() <= 1e-12
        edges = nets_of_edges(found, side, nets, nets.default)
        corners = edge_corners(edges)
        value, gradient = value_and_gradient(edges.nets, edges.rational, corners, corners[:, 1:3])
        assert np.abs(value).max() <= 1e-13
        assert gradient == pytest.approx(sign * found.vectors[found.mesh.edges[edges.edges]], abs=1e-12)


def test_half_way_along_edges_derivatives_across_are_means_of_those_at_the_ends() -> None:
    found = hull(noisy_torus(), 0.05, 1e-12)
    nets = nets_of_faces(found, 0, nonconvex(found))
    corners, net, rational, (_, third) = face_tetrahedra(nets, nets.default)
    for s in range(3):
        rows = (third == s) | (third < 0)
        p, q = corners[rows][:, J[s]], corners[rows][:, K[s]]
        _, gradient = value_and_gradient(net[rows], rational[rows], corners[rows], 0.5 * (p + q)[:, None])
        vectors = nets.vectors[face_tetrahedra(nets, nets.default)[3][0][rows]]
        turn = gradient[:, 0] - 0.5 * (vectors[:, J[s]] + vectors[:, K[s]])
        along = q - p
        across = turn - (dot(turn, along) / dot(along, along))[:, None] * along
        assert np.abs(across).max() <= 1e-12


@pytest.mark.parametrize(
    ("case", "side", "expected"),
    [
        ("convex", 0, (3.30555556, 3.30555556)),
        ("mixed", 0, (4.09126984, 4.38492063)),
        ("mixed", 1, (3.71790846,)),
        ("nonconvex", 0, (3.30600370, 3.30600370)),
        ("nonconvex", 1, (3.32716049, 3.32716049)),
        ("flat", 0, (1.13933703,)),
        ("flat", 1, (2.86076560,)),
    ],
)
def test_the_default_coefficients_of_the_papers_examples(case: Case, side: int, expected: tuple[float, ...]) -> None:
    found = example(case)
    assert nets_of_faces(found, side, nonconvex(found)).default == pytest.approx(expected, abs=5e-9)


def random_face_nets(seed: int, *, split: bool, quadric: bool = False) -> tuple[FaceNets, Float]:
    """Ten tetrahedra, and the value at the apex of the quadric whose data they have, if they have."""
    rng = np.random.default_rng(seed)
    base, apex = rng.normal(size=(10, 3, 3)), 2.0 * rng.normal(size=(10, 3))
    vectors, at_apex = rng.normal(size=(10, 3, 3)), np.zeros(10)
    if quadric:
        q = quadrics(rng, base)
        vectors, at_apex = q(base)[1], q(apex[:, None])[0][:, 0]
    return face_nets(np.arange(10), base, vectors, apex, np.full(10, split)), at_apex


def quadrics(rng: np.random.Generator, base: Float) -> Callable[[Float], tuple[Float, Float]]:
    """Quadratics (N,) that vanish at three points each (N, 3, 3): values and gradients at points (N, S, 3)."""
    matrix = rng.normal(size=(len(base), 3, 3))
    matrix = matrix + matrix.swapaxes(1, 2)
    square = np.einsum("nsx,nxy,nsy->ns", base, matrix, base)
    # linear part and constant by least norm
    linear = -np.einsum(
        "nks,ns->nk", np.linalg.pinv(np.concatenate([base, np.ones((len(base), 3, 1))], axis=2)), square
    )

    def q(x: Float) -> tuple[Float, Float]:
        value = np.einsum("nsx,nxy,nsy->ns", x, matrix, x) + np.einsum("nsx,nx->ns", x, linear[:, :3])
        return value + linear[:, 3:], 2.0 * np.einsum("nxy,nsy->nsx", matrix, x) + linear[:, None, :3]

    return q


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=30, deadline=None)
def test_with_data_of_a_quadric_f_is_it_plus_a_multiple_of_the_square_of_the_apexs_coordinate(
    seed: int, split: bool
) -> None:
    """Theorem 4.2: F = Q + (f0003 - Q(u)) alpha_4^2, for split faces, too."""
    rng = np.random.default_rng(seed)
    base, apex = rng.normal(size=(10, 3, 3)), 2.0 * rng.normal(size=(10, 3))
    q = quadrics(rng, base)
    nets = face_nets(np.arange(10), base, q(base)[1], apex, np.full(10, split))
    corners, net, rational, _ = face_tetrahedra(nets, q(apex[:, None])[0][:, 0] + 0.7)
    weights = rng.dirichlet(np.ones(4), (len(corners), 6))
    points = np.einsum("nsk,nkx->nsx", weights, corners)
    value, _ = value_and_gradient(net, rational, corners, points)
    expected = q(points.reshape(10, -1, 3))[0].reshape(value.shape)
    size = np.abs(net).max(axis=1)[:, None]
    # flat triangles lose digits to the weights (3.1)
    digits = (np.linalg.cond(corners[:, 1:] - corners[:, :1]) ** 2)[:, None]
    assert (np.abs(value - expected - 0.7 * weights[..., 3] ** 2) <= 1e-13 * digits * size).all()


def test_unsplit_data_of_a_quadric_need_no_rational_term() -> None:
    nets, _ = random_face_nets(3, split=False, quadric=True)
    assert np.abs(nets.rational).max() <= 1e-12 * np.abs(nets.layer0).max()
    nets, _ = random_face_nets(3, split=False)
    assert np.abs(nets.rational).max() > 1e-2
    assert nets.rational.sum(axis=1) == pytest.approx(np.zeros(10), abs=1e-13)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_layer_two_and_the_default_are_least_squares(seed: int) -> None:
    """(4.13), sixteen equations, and (4.16) with the sum corrected to 2, ten minus one of them, by a general solver."""
    nets, _ = random_face_nets(seed, split=False)
    elevation, names3, names2 = elevation_matrix(3)
    rows, columns = names3[:, 3] <= 1, names2[:, 3] <= 1
    layers = np.zeros((10, 20))
    layers[:, names3[:, 3] == 0], layers[:, names3[:, 3] == 1] = nets.layer0[:, 0], nets.layer1
    q = np.linalg.lstsq(elevation[np.ix_(rows, columns)], layers[:, rows].T, rcond=None)[0].T
    kept = names2[columns]
    assert q[:, kept[:, 3] == 1] == pytest.approx(nets.q, abs=1e-12)
    lower, _, names1 = elevation_matrix(2)
    p = np.linalg.lstsq(lower[names2[:, 3] <= 1], q.T, rcond=None)[0].T
    assert p[:, np.flatnonzero(names1[:, 3] == 1)[0]] == pytest.approx(nets.default, abs=1e-12)


def elevation_matrix(degree: int) -> tuple[Float, Int, Int]:
    """From coefficients of degree - 1 over a tetrahedron to those of ``degree``, by multi-indices of both."""
    high, low = simplex_multi_indices(4, degree), simplex_multi_indices(4, degree - 1)
    matrix = np.zeros((len(high), len(low)))
    for row, exponents in enumerate(high):
        for column, lower in enumerate(low):
            raised = exponents - lower
            if raised.min() >= 0:
                matrix[row, column] = exponents[raised.argmax()] / degree
    return matrix, high, low


@given(st.integers(0, 2**32 - 1), st.booleans())
@settings(max_examples=20, deadline=None)
def test_the_corners_of_a_face_have_equal_rights(seed: int, split: bool) -> None:
    nets, _ = random_face_nets(seed, split=split)
    turn = [2, 0, 1]
    turned = face_nets(nets.faces, nets.base[:, turn], nets.vectors[:, turn], nets.apex, nets.split)
    assert turned.q == pytest.approx(nets.q[:, turn], abs=1e-11 * np.abs(nets.q).max())
    assert turned.rational == pytest.approx(nets.rational[:, turn], abs=1e-11 * np.abs(nets.layer0).max())
    assert turned.default == pytest.approx(nets.default, abs=1e-11 * np.abs(nets.layer1).max())


def test_the_weight_of_the_foot() -> None:
    p, q = np.array([[1.0, 0.0, 0.0]]), np.array([[4.0, 0.0, 0.0]])
    x = np.array([[2.0, 5.0, -1.0]])  # the foot is 2/3 p + 1/3 q
    assert foot_weight(x, p, q) == pytest.approx([3.0 * 2.0 / 3.0 - 1.0])
    assert foot_weight(x, p, q) + foot_weight(x, q, p) == pytest.approx([1.0])


# ---- what is printed, and fails


def printed_f1011(nets: FaceNets) -> FaceNets:
    """The third formula of step 4 with f2100 for f2010; (k, i, j) are the corners (0, 1, 2)."""
    base, vectors, apex = nets.base, nets.vectors, nets.apex
    p_k, p_i, p_j = base[:, 0], base[:, 1], base[:, 2]
    n_k, n_j = vectors[:, 0], vectors[:, 2]
    alpha = foot_weight(apex, p_j, p_k)
    f1020, f2100 = dot(p_k - p_j, n_j) / 3.0, dot(p_i - p_k, n_k) / 3.0
    f2001, f0021 = dot(apex - p_k, n_k) / 3.0, dot(apex - p_j, n_j) / 3.0
    layer1 = nets.layer1.copy()
    layer1[:, index_of((1, 0, 1))] = 0.5 * (f2001 + f0021 + alpha * f1020 + (1.0 - alpha) * f2100)
    return dataclasses.replace(nets, layer1=layer1, q=quadratic_layer(nets.layer0[:, 0], layer1))


def printed_b1110(nets: FaceNets) -> FaceNets:
    """(4.12) with the line about alpha(p_j, p_i, p_k) that stands in it."""
    p_k, p_i, p_j = nets.base[:, 0], nets.base[:, 1], nets.base[:, 2]
    f2100 = dot(p_i - p_k, nets.vectors[:, 0]) / 3.0
    rational = nets.rational.copy()
    rational[:, 1] += 0.5 * (1.0 - foot_weight(p_j, p_i, p_k)) * f2100
    return dataclasses.replace(nets, rational=rational)


def printed_split(nets: FaceNets) -> FaceNets:
    """Step 3 for split faces with alpha alone replaced: f1200 and f1020 stay those of the whole face."""
    base, vectors = nets.base, nets.vectors
    centre = np.broadcast_to(base.mean(axis=1)[:, None], base.shape)
    wrong = 0.5 * dot(base - centre, vectors[:, J] + vectors[:, K]) / 3.0
    layer0 = nets.layer0.copy()
    for s in range(3):
        layer0[:, s, index_of((1, 1, 1))] += wrong[:, s]
    return dataclasses.replace(nets, layer0=layer0)


def test_the_printed_number_3_coefficient_breaks_c1() -> None:
    found = hull(noisy_torus(), 0.05, 1e-12)
    jumps = gradient_jumps(found, nonconvex(found), change=printed_f1011)
    assert min(jumps[name] for name in ("F+E+", "F-E-", "F+F-")) > 1e-2


def test_the_printed_line_in_the_number_2_coefficients_breaks_c1() -> None:
    mesh = icosahedron()
    found = hull(HermiteMesh(mesh.points, mesh.faces, gradients=2.0 * mesh.points), 0.05, 1e-12)
    none = np.zeros(20, dtype=bool)
    assert gradient_jumps(found, none)["F+E+"] <= 1e-14
    assert gradient_jumps(found, none, change=printed_b1110)["F+E+"] > 1e-2


def test_in_split_faces_replacing_alpha_alone_breaks_c1() -> None:
    found = example("nonconvex")
    jumps = gradient_jumps(found, nonconvex(found), change=printed_split)
    assert jumps["F+E+"] > 1e-2
    assert jumps["F-E-"] > 1e-2


def test_the_printed_sum_in_the_default_belongs_to_no_linear_function() -> None:
    """(4.16) with sum 3: half the sum of lambda_i p does not raise a linear function; with sum 2 it does."""
    printed, names, _ = elevation_matrix(3)
    corrected, _, _ = elevation_matrix(2)
    constant = np.ones(4)
    raised = corrected @ constant
    assert raised == pytest.approx(np.ones(10))
    half = 0.5 * 3.0 * printed @ raised
    assert half == pytest.approx(np.full(len(names), 1.5))
    # and what it is for: where F is linear, the default is its value at the apex
    rng = np.random.default_rng(2)
    base, apex = rng.normal(size=(10, 3, 3)), rng.normal(size=(10, 3))
    normal = np.cross(base[:, 1] - base[:, 0], base[:, 2] - base[:, 0])
    nets = face_nets(np.arange(10), base, np.repeat(normal[:, None], 3, axis=1), apex, np.zeros(10, dtype=bool))
    assert nets.default == pytest.approx(dot(apex - base[:, 0], normal), abs=1e-12)


def test_the_clough_tocher_layer_is_c1_inside_and_meets_the_edges() -> None:
    nets, _ = random_face_nets(4, split=True)
    net = clough_tocher(
        nets.base,
        nets.vectors,
        dot(nets.base[:, None] - nets.base[:, :, None], nets.vectors[:, :, None]) / 3.0,
        nets.base.mean(axis=1),
        None,
    )
    assert np.array_equal(net, nets.layer0)
    centre = nets.base.mean(axis=1)
    for s in range(3):
        i, j = int(J[s]), int(K[s])
        p, q, n_p, n_q = nets.base[:, i], nets.base[:, j], nets.vectors[:, i], nets.vectors[:, j]
        value = middle_coefficient(centre, (p, q), (n_p, n_q))
        assert net[:, s, index_of((1, 1, 1))] == pytest.approx(value)
        # affine in the third point: the mean over the corners is the value at the centre
        corners = [middle_coefficient(nets.base[:, r], (p, q), (n_p, n_q)) for r in range(3)]
        assert sum(corners) / 3.0 == pytest.approx(value)
