"""Free coefficients of A-patches: closed forms against least squares, quadrics kept, the paper's misprint."""

from itertools import product

import numpy as np
import pytest
from single_faces import nets_of, random_faces

from testbed.geometry.bernstein import multi_indices
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.simplex_bernstein import elevate_simplex, simplex_multi_indices, simplex_places
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, unit
from testbed_schemes.mathematics.a_patch_coefficients import LAYER_PLACES, FaceNets, face_nets, quadratic_layer
from testbed_schemes.mathematics.a_patch_free import (
    elevation_equations,
    nearest_quadratic,
    opposite_vertices,
    quadric_parameters,
    whole_layer0,
)

#: Quadrics x . A x = 1 by the diagonal of A: a sphere, an ellipsoid, a one-sheet hyperboloid.
QUADRICS = {"sphere": (1.0, 1.0, 1.0), "ellipsoid": (1.0, 0.25, 0.6), "hyperboloid": (1.0, 0.7, -0.5)}


def random_layers(count: int, seed: int) -> tuple[Float, Float]:
    """Layers 0 and 1 of cubics that vanish at the three corners."""
    random = np.random.default_rng(seed)
    layer0 = random.normal(size=(count, 10))
    layer0[:, (multi_indices(3) == 3).any(axis=1)] = 0.0
    return layer0, random.normal(size=(count, 6))


def layer_indices(degree: int) -> list[tuple[int, ...]]:
    """Exponents of layers 0 and 1 of a tetrahedron's net."""
    return [(*ijk, layer) for layer in range(2) for ijk in map(tuple, multi_indices(degree - layer).tolist())]


def elevation(degree: int, unknowns: list[tuple[int, ...]]) -> Float:
    """Equations of (4.13), degree 3, or (4.16), degree 2: f_l = sum of l_i / degree times p_(l - e_i), by loops."""
    rows = []
    for indices in layer_indices(degree):
        row = np.zeros(len(unknowns))
        for i in range(4):
            if indices[i]:
                row[unknowns.index(tuple(e - (k == i) for k, e in enumerate(indices)))] = indices[i] / degree
        rows.append(row)
    return np.array(rows)


def test_the_quadratic_layer_is_the_least_squares_solution_of_the_sixteen_equations() -> None:
    layer0, layer1 = random_layers(50, 1)
    matrix = elevation(3, layer_indices(2))
    assert matrix.shape == (16, 9)
    solution = np.linalg.lstsq(matrix, np.concatenate([layer0, layer1], axis=1).T, rcond=None)[0].T
    assert np.abs(quadratic_layer(layer0, layer1) - solution[:, 6:]).max() < 1e-14
    nearest = nearest_quadratic(layer0, layer1)
    places = simplex_places(np.array(layer_indices(2)))
    assert np.abs(nearest[:, places] - solution).max() < 1e-14
    assert (nearest[:, -1] == 0.0).all()
    assert elevation_equations().shape == (16, 9)


def default_of(layer0: Float, layer1: Float) -> Float:
    """The closed form of p0001."""
    return np.asarray(0.5 * layer1.sum(axis=1) - 0.2 * layer0.sum(axis=1))


def test_the_default_is_the_least_squares_solution_of_the_corrected_equations() -> None:
    """(4.16) with the sum 2 on the quadratic of (4.13)."""
    layer0, layer1 = random_layers(50, 2)
    quadratic = np.linalg.lstsq(elevation(3, layer_indices(2)), np.concatenate([layer0, layer1], axis=1).T, rcond=None)[
        0
    ]
    unknowns = layer_indices(1)
    linear = np.linalg.lstsq(elevation(2, unknowns), quadratic, rcond=None)[0]
    assert np.abs(linear[unknowns.index((0, 0, 0, 1))] - default_of(layer0, layer1)).max() < 1e-14


def test_the_nets_take_the_closed_form() -> None:
    nets = random_faces(40, 3)
    assert np.abs(nets.default - default_of(whole_layer0(nets), nets.layer1)).max() < 1e-14
    assert np.abs(nets.q - quadratic_layer(whole_layer0(nets), nets.layer1)).max() < 1e-14


def test_the_printed_equations_do_not_keep_linear_functions() -> None:
    """(4.16) prints the sum 3: then there is no p0001 to solve for, and half a sum of three is no degree elevation."""
    unknowns = sorted({tuple(e) for e in product(range(3), repeat=4) if sum(e) == 2 and e[3] < 2})
    assert (0, 0, 0, 1) not in unknowns
    printed = np.zeros((16, 9))
    for row, indices in enumerate(layer_indices(3)):
        for i in range(4):
            if indices[i]:
                printed[row, unknowns.index(tuple(e - (k == i) for k, e in enumerate(indices)))] = 0.5 * indices[i]
    corners = np.random.default_rng(4).normal(size=4)
    cubic = np.array(layer_indices(3)) @ corners / 3.0
    right = np.array(unknowns) @ corners / 2.0
    solution = np.linalg.lstsq(printed, cubic, rcond=None)[0]
    assert np.abs(solution - right).max() > 0.1
    quadratic = np.linalg.lstsq(elevation(3, layer_indices(2)), cubic, rcond=None)[0]
    linear = np.linalg.lstsq(elevation(2, layer_indices(1)), quadratic, rcond=None)[0]
    assert np.abs(linear - np.array(layer_indices(1)) @ corners).max() < 1e-14


def test_the_default_keeps_functions_that_are_linear() -> None:
    """Of those that vanish at the corners, the multiples of alpha_4."""
    slopes = np.random.default_rng(5).normal(size=7)
    cubic = np.array(layer_indices(3))[:, 3] / 3.0 * slopes[:, None]
    assert np.abs(default_of(cubic[:, :10], cubic[:, 10:]) - slopes).max() < 1e-14


def test_quadratics_are_their_own_nearest() -> None:
    quadratic = np.random.default_rng(6).normal(size=(30, 10))
    quadratic[:, -1] = 0.0
    cubic = elevate_simplex(quadratic[..., None], 4, 2)[..., 0]
    layer0, layer1 = (cubic[:, LAYER_PLACES[layer]] for layer in range(2))
    assert np.abs(nearest_quadratic(layer0, layer1) - quadratic).max() < 1e-13
    assert len(simplex_multi_indices(4, 2)) == 10


def test_whole_layers_of_split_faces_are_those_of_the_unsplit_ones() -> None:
    nets = random_faces(40, 7)
    split, whole = (
        face_nets(nets.faces, nets.base, nets.vectors, nets.apex, np.full(len(nets), cut)) for cut in (True, False)
    )
    assert np.abs(whole_layer0(split) - whole.layer0[:, 0]).max() < 1e-14
    assert np.array_equal(whole_layer0(whole), whole.layer0[:, 0])


def on_quadric(name: str, count: int, seed: int, side: int = 1) -> tuple[FaceNets, Float, Float, Float]:
    """Faces inscribed in a quadric with its gradients, vertices near them, the gradients there, and Q at the apexes."""
    random, A = np.random.default_rng(seed), np.array(QUADRICS[name])
    angle, height = random.uniform(0.0, 2.0 * np.pi, (count, 1)), random.uniform(-0.5, 0.5, (count, 1))
    ring = np.array([0.0, 2.0, 4.0, 3.0, 5.0, 1.0]) * np.pi / 3.0  # corners, and beyond the edges opposite them
    radius = np.array([0.3, 0.3, 0.3, 0.6, 0.6, 0.6]) * random.uniform(0.8, 1.2, (count, 6))
    t, z = angle + radius * np.cos(ring), height + radius * np.sin(ring)
    if name == "hyperboloid":
        points = np.stack([np.cosh(z) * np.cos(t), np.cosh(z) * np.sin(t), np.sinh(z)], axis=-1)
    else:
        points = np.stack([np.cos(z) * np.cos(t), np.cos(z) * np.sin(t), np.sin(z)], axis=-1)
    points = points / np.sqrt(np.abs(A))
    gradients = side * 2.0 * A * points
    base, vectors = points[:, :3], gradients[:, :3]
    if side < 0:
        base, vectors = base[:, ::-1], vectors[:, ::-1]
    nets = nets_of(base, vectors, np.arange(count) % 2 == 0)
    opposite, there = points[:, 3:], gradients[:, 3:]
    if side < 0:
        opposite, there = opposite[:, ::-1], there[:, ::-1]
    return nets, opposite, there, side * (dot(A * nets.apex, nets.apex) - 1.0)


@pytest.mark.parametrize(("name", "side"), [("sphere", 1), ("ellipsoid", 1), ("hyperboloid", 1), ("hyperboloid", -1)])
def test_quadrics_are_kept(name: str, side: int) -> None:
    nets, opposite, there, exact = on_quadric(name, 60, 8, side)
    found = quadric_parameters(nets, opposite, there)
    assert np.abs(found - exact).max() < 1e-12
    assert np.abs(nets.default - exact).max() > 1e-2


@pytest.mark.parametrize("known", [(0,), (1,), (0, 2)])
def test_one_neighbour_is_enough(known: tuple[int, ...]) -> None:
    nets, opposite, there, exact = on_quadric("ellipsoid", 40, 9)
    for s in set(range(3)) - set(known):
        opposite[:, s] = there[:, s] = np.nan
    assert np.abs(quadric_parameters(nets, opposite, there) - exact).max() < 1e-12


def test_without_neighbours_it_is_the_default() -> None:
    nets, opposite, there, _ = on_quadric("ellipsoid", 10, 10)
    assert np.array_equal(quadric_parameters(nets, np.full_like(opposite, np.nan), there), nets.default)


def test_neighbours_in_the_plane_of_the_face_determine_nothing() -> None:
    nets, opposite, there, _ = on_quadric("ellipsoid", 10, 11)
    normal = unit(cross(nets.base[:, 1] - nets.base[:, 0], nets.base[:, 2] - nets.base[:, 0]))[:, None]
    flat = opposite - dot(opposite - nets.base[:, :1], normal)[..., None] * normal
    assert np.array_equal(quadric_parameters(nets, flat, there), nets.default)


def test_neighbours_nearly_in_the_plane_of_the_face_count_only_if_the_quadric_meets_them() -> None:
    # the vertex beyond, slid along the quadric towards the plane of the face, on a curve through a corner of the face
    nets, opposite, there, exact = on_quadric("sphere", 10, 12)
    corner = nets.base[:, 1]
    upright = unit(cross(nets.base[:, 1] - nets.base[:, 0], nets.base[:, 2] - nets.base[:, 0]))
    around = unit(cross(upright, corner))
    near = unit(corner + 1e-3 * around + 1e-3 * upright)
    opposite[:], there[:] = np.nan, np.nan
    opposite[:, 0], there[:, 0] = near, 2.0 * near
    height = dot(near - nets.base[:, 0], upright) / dot(nets.apex - nets.base[:, 0], upright)
    assert (np.abs(height) < 0.05).all()
    assert np.abs(quadric_parameters(nets, opposite, there) - exact).max() < 1e-9
    there[:, 0] += 1e-4 * around
    assert np.array_equal(quadric_parameters(nets, opposite, there), nets.default)


def test_it_is_the_least_squares_solution_of_its_equations() -> None:
    """On data of no quadric, by lstsq on differences of the polynomial itself."""
    nets = random_faces(20, 12)
    random = np.random.default_rng(13)
    opposite = 2.0 * nets.base.mean(axis=1, keepdims=True) - nets.base + 0.2 * random.normal(size=nets.base.shape)
    there = random.normal(size=nets.base.shape)
    q = nearest_quadratic(whole_layer0(nets), nets.layer1)
    length = norm(np.roll(nets.base, 1, axis=1) - nets.base).mean(axis=1)

    def quadratic(net: Float, row: int, x: Float) -> Float:
        corners = np.vstack([nets.base[row], nets.apex[row]])
        alpha = np.linalg.solve(np.vstack([corners.T, np.ones(4)]), np.append(x, 1.0))
        exponents = simplex_multi_indices(4, 2)
        return np.asarray((np.where((exponents == 2).any(axis=1), 1.0, 2.0) * (alpha**exponents).prod(axis=1)) @ net)

    found = quadric_parameters(nets, opposite, there)
    for row in range(len(nets)):
        left, right = [], []
        for s, axis in product(range(3), range(4)):
            step = np.zeros(3) if axis == 3 else 0.5 * np.eye(3)[axis]  # central differences of quadratics are exact
            parts = []
            for net in (q[row], np.eye(10)[9]):
                ahead, back = (quadratic(net, row, opposite[row, s] + sign * step) for sign in (1.0, -1.0))
                parts.append(ahead if axis == 3 else length[row] * (ahead - back))
            left.append(parts[1])
            right.append((0.0 if axis == 3 else length[row] * there[row, s, axis]) - parts[0])
        expected = np.linalg.lstsq(np.array(left)[:, None], np.array(right), rcond=None)[0][0]
        assert abs(found[row] - expected) < 1e-10 * (1.0 + abs(expected))


def test_scale_lengths_and_corners_do_not_matter() -> None:
    nets, opposite, there, _ = on_quadric("ellipsoid", 30, 14)
    there = there + 0.1 * np.random.default_rng(15).normal(size=there.shape)
    found = quadric_parameters(nets, opposite, there)
    scaled = face_nets(nets.faces, 1e-3 * nets.base, 5.0 * nets.vectors, 1e-3 * nets.apex, nets.split)
    assert np.abs(quadric_parameters(scaled, 1e-3 * opposite, 5.0 * there) / (5e-3 * found) - 1.0).max() < 1e-9
    base, vectors = nets.base[:, ::-1], nets.vectors[:, ::-1]
    turned = face_nets(nets.faces, base, vectors, nets.apex, nets.split)
    assert np.abs(quadric_parameters(turned, opposite[:, ::-1], there[:, ::-1]) - found).max() < 1e-12


def test_no_bit_depends_on_the_other_faces() -> None:
    nets, opposite, there, _ = on_quadric("hyperboloid", 50, 16)
    found = quadric_parameters(nets, opposite, there)
    for rows in (np.array([7]), np.array([40, 2, 2]), np.arange(49, -1, -1)):
        chosen = face_nets(nets.faces[rows], nets.base[rows], nets.vectors[rows], nets.apex[rows], nets.split[rows])
        assert np.array_equal(quadric_parameters(chosen, opposite[rows], there[rows]), found[rows])


def test_opposite_vertices_are_those_beyond_the_edges() -> None:
    faces = np.array([[0, 1, 2], [2, 1, 3], [4, 2, 3], [0, 2, 5]])
    points = np.random.default_rng(17).normal(size=(6, 3))
    mesh = HermiteMesh(points, faces)
    found = opposite_vertices(mesh.faces, mesh.edges, mesh.face_edges, mesh.edge_faces)
    assert found.tolist() == [[3, 5, -1], [-1, 4, 0], [1, -1, -1], [-1, -1, 1]]


def sphere_mesh() -> HermiteMesh:
    golden = 0.5 * (1.0 + 5.0**0.5)
    signs = np.array(list(product((-1.0, 1.0), repeat=2)))
    flat = np.column_stack([np.zeros(4), signs[:, 0], golden * signs[:, 1]])
    points = unit(np.concatenate([np.roll(flat, shift, axis=1) for shift in range(3)]))
    near: Bool = norm(points[:, None] - points) < 1.2
    faces = [
        (i, j, k)
        for i, j, k in product(range(12), repeat=3)
        if i < min(j, k) and near[i, j] and near[j, k] and near[k, i]
        if np.linalg.det(points[[i, j, k]]) > 0.0
    ]
    return HermiteMesh(points, np.array(faces), gradients=2.0 * points)


def test_the_icosahedron_has_the_default_and_the_sphere_of_the_paper() -> None:
    mesh = sphere_mesh()
    assert mesh.gradients is not None
    nets = nets_of(mesh.points[mesh.faces], mesh.gradients[mesh.faces], np.zeros(20, dtype=np.bool_))
    beyond = opposite_vertices(mesh.faces, mesh.edges, mesh.face_edges, mesh.edge_faces)
    found = quadric_parameters(nets, mesh.points[beyond], mesh.gradients[beyond])
    assert np.abs(nets.default - 0.8291796).max() < 1e-7
    assert np.abs(found - 1.5799560).max() < 1e-7
    assert np.abs(found - (dot(nets.apex, nets.apex) - 1.0)).max() < 1e-14
