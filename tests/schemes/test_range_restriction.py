"""Edges kept on one side of a plane: bounds and the G1 condition hold, nothing else changes, labels do not matter."""

import numpy as np
import pytest
from restricted_networks import UP, Problem, dry, noise, surrounded

from testbed.conformance.meshes import perturbed_icosahedron
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int, dot, norm, unit
from testbed_schemes.mathematics.linear_g1 import first_rows, free_vector
from testbed_schemes.mathematics.range_restriction import RestrictedEdges

TILTED = unit(np.array([0.3, -0.2, 1.0]))


def closed() -> Problem:
    """A closed mesh above a tilted plane close to it."""
    mesh = perturbed_icosahedron()
    return Problem.over(mesh, TILTED, 0.01 - float(dot(mesh.points, TILTED).min()))


PROBLEMS = {
    **{f"noise {seed}": noise(seed) for seed in range(4)},
    **{f"steep noise {seed}": noise(seed, 5.0, 0.001) for seed in (5, 6)},
    **{f"rainfall {seed}": dry(seed) for seed in (1, 2, 10)},
    "closed": closed(),
}
every_problem = pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())


@every_problem
def test_no_control_point_lies_below_its_bound(problem: Problem) -> None:
    found = problem.solve()
    assert not found.infeasible.any()
    faces = problem.network.faces
    bounds = np.where(faces >= 0, problem.bounds[faces], np.inf)
    assert (problem.above(found.boundary[:, 1:4]) + bounds.min(axis=1)[:, None]).min() >= -1e-15
    for side, row in enumerate((found.left, found.right)):
        low = problem.above(row) + bounds[:, side, None]
        assert np.isfinite(row).all(axis=(1, 2)).tolist() == (faces[:, side] >= 0).tolist()
        assert low[faces[:, side] >= 0].min() >= -1e-15


@every_problem
def test_without_restriction_some_are_below(problem: Problem) -> None:
    free, faces = problem.solve(restricted=False), problem.network.faces
    bounds = np.where(faces >= 0, problem.bounds[faces], np.inf)
    low = [(problem.above(row) + bounds[:, side, None]) for side, row in enumerate((free.left, free.right))]
    assert np.nanmin(low) < -1e-4
    assert sum(free.counts.values()) == 0


@every_problem
def test_second_rows_meet_the_g1_condition(problem: Problem) -> None:
    found = problem.solve()
    edge, g1 = problem.shared(found)
    inside = problem.network.interior
    left = np.concatenate([edge.p0[:, None], found.left[inside], edge.p3[:, None]], axis=1)
    right = np.concatenate([edge.q0[:, None], found.right[inside], edge.q3[:, None]], axis=1)
    vectors = left - edge.c[:, :4], right - edge.c[:, :4], np.diff(edge.c, axis=1)
    factor = np.stack([np.ones(len(edge.kappa)), edge.kappa], axis=1)
    residual, size = np.zeros((len(edge.kappa), 5, 3)), np.zeros((len(edge.kappa), 5))
    for of_ends, along in zip((g1.alpha, g1.beta, g1.gamma), vectors, strict=True):
        for j in range(4):
            for end, weight in ((0, 4.0 - j), (1, 1.0 + j)):
                term = weight * (of_ends * factor)[:, end, None] * along[:, j]
                residual[:, j + end] += term
                size[:, j + end] += norm(term)
    assert (norm(residual) / (size + np.abs(edge.c).max())).max() < 1e-14
    assert not g1.opposed.any()


@every_problem
def test_the_supplementary_conditions_hold(problem: Problem) -> None:
    found = problem.solve()
    edge, g1 = problem.shared(found)
    inside = problem.network.interior
    r1, r2 = problem.bounds[problem.network.faces[inside]].T
    start = problem.mesh.edges[inside, 0]

    def height(points: Float) -> Float:
        return np.asarray(problem.heights[start] + dot(points - problem.mesh.points[start], problem.direction))

    (alpha0, alpha1), (beta0, beta1) = g1.alpha.T, g1.beta.T
    R1, R3, R4 = height(g1.R1), height(g1.R3), dot(g1.R4, problem.direction)
    assert (R1 + alpha0 * r1 + beta0 * r2 >= -1e-14).all()
    assert (R3 + alpha1 * r1 + beta1 * r2 >= -1e-14).all()
    least = np.maximum(-(r1 + R1) / beta0, (-(r1 + R3) / beta1 - R4) / edge.kappa)
    greatest = np.minimum((r2 + R1) / alpha0, ((r2 + R3) / alpha1 - R4) / edge.kappa)
    assert (greatest - least >= -1e-13).all()
    # w1 is moved along the plane's normal only, to the nearest admissible height
    w1 = free_vector(edge, g1)
    shift = np.clip(dot(w1, problem.direction), least, np.maximum(least, greatest)) - dot(w1, problem.direction)
    assert found.shift[inside] == pytest.approx(shift, abs=1e-8)
    rows = first_rows(edge, g1, w1 + found.shift[inside][:, None] * problem.direction)
    for row, expected in zip(
        (*found.left[inside].transpose(1, 0, 2), *found.right[inside].transpose(1, 0, 2)), rows, strict=True
    ):
        assert row == pytest.approx(expected, abs=1e-13)


@every_problem
def test_legs_stay_in_their_tangent_planes_and_nothing_folds(problem: Problem) -> None:
    found, mesh = problem.solve(), problem.mesh
    assert mesh.normals is not None
    assert np.abs(dot(found.legs, mesh.normals[mesh.edges])).max() < 1e-15 * np.abs(problem.legs).max() * 16
    assert norm(found.legs) == pytest.approx(found.shortening * norm(problem.legs), rel=1e-12)
    kept = ~found.turned
    assert found.legs[kept] == pytest.approx((found.shortening[..., None] * problem.legs)[kept], abs=1e-16)
    assert (found.shortening > 1e-6).all()
    assert (found.shortening <= 1.0).all()


def test_data_that_meet_the_bounds_stay_as_they_are_bit_by_bit() -> None:
    for seed in range(3):
        problem = noise(seed, ground=10.0)
        found, free = problem.solve(), problem.solve(restricted=False)
        assert sum(found.counts.values()) == 0
        for name in ("legs", "kappa", "boundary", "left", "right"):
            np.testing.assert_array_equal(getattr(found, name), getattr(free, name))


def test_what_is_far_from_trouble_stays_as_it_is() -> None:
    # two pieces of one mesh, the second one far above the plane
    low, high = noise(2), noise(2, ground=10.0)
    move = np.array([100.0, 0.0, 0.0])
    count = len(low.mesh.points)
    assert low.mesh.normals is not None
    assert high.mesh.normals is not None
    both = HermiteMesh(
        np.concatenate([low.mesh.points, high.mesh.points + move]),
        np.concatenate([low.mesh.faces, high.mesh.faces + count]),
        np.concatenate([low.mesh.normals, high.mesh.normals]),
    )
    found, alone = Problem.over(both, along=UP).solve(), low.solve()
    edges = len(low.mesh.edges)
    for name in ("legs", "kappa", "boundary", "left", "right", "shift"):
        np.testing.assert_array_equal(getattr(found, name)[:edges], getattr(alone, name))
    assert (found.shortening[edges:] == 1.0).all()
    assert (found.kappa[edges:] == 1.0).all()


def compare(
    found: RestrictedEdges, expected: RestrictedEdges, mesh: HermiteMesh, mapped: HermiteMesh, new: Int
) -> None:
    """Check that edges of a relabelled mesh have what those of the mesh have; vertex i is now ``new[i]``."""
    ids = {tuple(edge): place for place, edge in enumerate(mapped.edges.tolist())}
    ends = new[mesh.edges]
    place = np.array([ids[min(i, j), max(i, j)] for i, j in ends.tolist()])
    back = (ends[:, 0] > ends[:, 1])[:, None, None]

    def turned(values: Float) -> Float:
        return np.asarray(np.where(back, values[place][:, ::-1], values[place]))

    assert turned(found.boundary) == pytest.approx(expected.boundary, abs=1e-9, nan_ok=True)
    assert turned(found.legs) == pytest.approx(expected.legs, abs=1e-9, nan_ok=True)
    left, right = turned(found.left), turned(found.right)
    assert np.where(back, right, left) == pytest.approx(expected.left, abs=1e-9, nan_ok=True)
    assert np.where(back, left, right) == pytest.approx(expected.right, abs=1e-9, nan_ok=True)
    kappa = np.where(back[:, 0, 0], 1.0 / found.kappa[place], found.kappa[place])
    assert kappa == pytest.approx(expected.kappa, rel=1e-9)


@every_problem
def test_nothing_depends_on_labels_orders_or_which_way_edges_run(problem: Problem) -> None:
    expected = problem.solve()
    random = np.random.default_rng(7)
    order = random.permutation(len(problem.mesh.points))
    mesh = problem.mesh.relabelled(order).with_face_order(random.permutation(len(problem.mesh.faces)))
    mesh = mesh.rotated_corners(random.integers(0, 3, len(mesh.faces)))
    new = np.argsort(order)
    # legs are laid on the new edges as they are, so that no rounding of their making interferes
    old = {tuple(edge): place for place, edge in enumerate(problem.mesh.edges.tolist())}
    ends = order[mesh.edges]
    at = np.array([old[min(i, j), max(i, j)] for i, j in ends.tolist()])
    legs = np.where((ends[:, 0] > ends[:, 1])[:, None, None], problem.legs[at][:, ::-1], problem.legs[at])
    found = Problem(mesh, legs, problem.direction, problem.heights[order]).solve()
    compare(found, expected, problem.mesh, mesh, new)


@every_problem
def test_the_side_below_is_the_mirror_image(problem: Problem) -> None:
    mesh, mirror = problem.mesh, np.array([1.0, 1.0, -1.0])
    assert mesh.normals is not None
    image = HermiteMesh(mesh.points * mirror, mesh.faces[:, ::-1], mesh.normals * mirror)
    found = Problem(image, problem.legs * mirror, problem.direction * mirror, problem.heights).solve()
    expected = problem.solve()
    for one, other in (("boundary", "boundary"), ("left", "right"), ("right", "left")):
        reflected = getattr(expected, other) * mirror
        assert getattr(found, one) == pytest.approx(reflected, abs=1e-9, nan_ok=True)
    assert found.kappa == pytest.approx(expected.kappa, rel=1e-12)


@every_problem
def test_scaled_and_moved_data_give_the_scaled_and_moved_result(problem: Problem) -> None:
    expected, move = problem.solve(), np.array([3.0, -2.0, 1.0])
    for scale, shift in ((8.0, 0.0 * move), (0.3, move)):
        mesh = problem.mesh.transformed(translation=shift, scale=scale)
        found = Problem(mesh, scale * problem.legs, problem.direction, scale * problem.heights).solve()
        for name in ("boundary", "left", "right"):
            image = scale * getattr(expected, name) + shift
            assert getattr(found, name) == pytest.approx(image, abs=1e-9 * scale, nan_ok=True)
        assert found.shortening == pytest.approx(expected.shortening, rel=1e-9)


@pytest.mark.parametrize(("height", "centre", "fall"), [(0.3, 0.02, 2.0), (0.02, 0.3, 0.5), (0.1, 0.001, 1.0)])
def test_symmetric_data_give_a_symmetric_result(height: float, centre: float, fall: float) -> None:
    problem = surrounded(np.full(6, height), centre, fall)
    found = problem.solve()
    assert not found.infeasible.any()
    assert sum(found.counts.values()) > 0
    turn = np.array([[0.5, -np.sqrt(0.75), 0.0], [np.sqrt(0.75), 0.5, 0.0], [0.0, 0.0, 1.0]])
    inside = problem.network.interior
    for points in (found.boundary[inside], found.left[inside], found.right[inside]):
        assert points[1:] == pytest.approx(points[:-1] @ turn.T, abs=1e-9)
    # the first spoke lies in the plane y = 0
    mirrored = found.left[inside][0] * np.array([1.0, -1.0, 1.0])
    assert mirrored == pytest.approx(found.right[inside][0], abs=1e-9)


def test_a_vertex_on_the_plane_with_three_neighbours_has_no_admissible_points() -> None:
    # opposite its edges the two other tangents always are more than a half turn apart
    found = surrounded(np.ones(3), 0.0).solve()
    assert found.infeasible.sum() == 3
    assert not surrounded(np.ones(3), 0.05).solve().infeasible.any()
    assert not surrounded(np.ones(6), 0.0).solve().infeasible.any()


def test_legs_at_a_vertex_are_shortened_alike_to_a_factor_of_five() -> None:
    for problem in PROBLEMS.values():
        found = problem.solve()
        factors, ends = found.shortening.ravel(), problem.mesh.edges.ravel()
        least, greatest = np.ones(len(problem.mesh.points)), np.zeros(len(problem.mesh.points))
        np.minimum.at(least, ends, factors)
        np.maximum.at(greatest, ends, factors)
        assert (greatest <= 5.0 * least * (1.0 + 1e-12)).all()


def test_flat_data_on_the_plane_stay_flat() -> None:
    found = surrounded(np.zeros(6), 0.0).solve()
    assert sum(found.counts.values()) == 0
    assert np.nanmax(np.abs(found.left[..., 2])) == 0.0
