from functools import partial

import numpy as np
import pytest
from precise_shooting import differences, face_points
from tetrahedra import (
    ABOVE,
    BELOW,
    FACES,
    face_batch,
    face_corners,
    nonconvex_face,
    on_side,
    place,
    quadric_net,
    random_face,
    sphere_face,
)

from testbed.geometry import shooting_rays
from testbed.geometry.curvature import analyse, second_form_matrix
from testbed.geometry.domain import CORNERS, barycentric, corner_distance, lattice
from testbed.geometry.shooting import ShootingTriangles
from testbed.geometry.vectors import Float, cross, dot, norm, unit

INNER = lattice(3, 9)[corner_distance(3, lattice(3, 9)) > 0.0]
#: Corners of a part of a triangle: its corner 2, a point inside, and one on the side from corner 1 to corner 2.
PART = np.array([[0.0, 0.0, 1.0], [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.0, 0.6, 0.4]])


def scattered(count: int, seed: int) -> Float:
    """Points of the domain not nearer to its boundary than the differences reach."""
    weights = 0.02 + 0.94 * np.random.default_rng(seed).dirichlet(np.ones(3), count)
    return weights[:, 1:]


def test_a_quadric_is_reproduced() -> None:
    batch = sphere_face()
    jet = batch.jets(lattice(3, 9))
    np.testing.assert_allclose(norm(jet.f), 1.0, atol=4e-16)
    np.testing.assert_allclose(jet.normal, jet.f, atol=2e-15)
    found = analyse(jet)
    # no rational term: there are second derivatives at the corners, too
    np.testing.assert_allclose(found.gauss, 1.0, atol=1e-13)
    np.testing.assert_allclose(found.mean, 1.0, atol=1e-13)
    np.testing.assert_allclose(batch.jets(CORNERS[3]).f[0], FACES[0], atol=2e-15)


@pytest.mark.parametrize("seed", range(4))
def test_jets_are_the_derivatives_of_the_points(seed: int) -> None:
    whole = random_face(seed, 0.05)
    for batch in (whole, face_batch(whole.nets[0, 0], whole.rational[0, 0], corners=PART)):
        at = scattered(12, seed)
        expected = differences(partial(face_points, batch, 0), at).astype(np.float64)
        np.testing.assert_allclose(batch.jets(at).coefficients[:, 0], expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_curvatures_are_those_of_the_implicit_function(seed: int) -> None:
    batch = random_face(seed, 0.05)
    found, (gauss, mean) = analyse(batch.jets(INNER)), batch.curvatures(INNER)
    np.testing.assert_allclose(found.gauss, gauss, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found.normal, unit(batch.gradient(INNER)), atol=1e-14)


def test_second_derivatives_can_be_trusted_up_to_the_margin() -> None:
    batch = random_face(5, 0.05)
    for distance in (batch.corner_margin, 10.0 * batch.corner_margin, 1e-2):
        inward = np.array([[0.3, 0.7], [1.0, 0.0], [0.0, 1.0]])
        at = np.concatenate(
            [corner + distance * inward @ np.array(turn) for corner, turn in zip(CORNERS[3], TURNS, strict=True)]
        )
        found, (gauss, mean) = analyse(batch.jets(at)), batch.curvatures(at)
        np.testing.assert_allclose(found.gauss, gauss, rtol=1e-9)
        np.testing.assert_allclose(found.mean, mean, rtol=1e-9)


#: From corner i towards the next corner and the one before.
TURNS = ([[1, 0], [0, 1]], [[-1, 1], [-1, 0]], [[0, -1], [1, -1]])


def test_corners_interpolate_and_have_exact_tangents() -> None:
    batch = random_face(6, 0.05)
    jet = batch.jets(CORNERS[3])
    np.testing.assert_array_equal(jet.f[0], FACES[0])
    gradient = batch.gradient(CORNERS[3])
    for derivative in (jet.fu, jet.fv):
        np.testing.assert_allclose(dot(derivative, unit(gradient)), 0.0, atol=1e-15)
    # no second derivatives: the rational term's depend on the direction
    assert np.isnan(jet.coefficients[3:]).all()
    assert np.isnan(np.stack(batch.curvatures(CORNERS[3]))).all()
    lower = batch.jets(CORNERS[3], 1)
    np.testing.assert_array_equal(lower.coefficients, jet.coefficients[:3])
    # limits along both sides, and in between
    for corner, turn in zip(CORNERS[3], TURNS, strict=True):
        for towards in (np.array(turn), np.array(turn).mean(axis=0, keepdims=True)):
            near = batch.jets(corner + 1e-8 * towards, 1)
            index = int(np.flatnonzero((CORNERS[3] == corner).all(axis=1))[0])
            limit = np.broadcast_to(jet.coefficients[:3, :, index : index + 1], near.coefficients.shape)
            np.testing.assert_allclose(near.coefficients, limit, atol=1e-4)


def test_second_forms_at_a_corner_depend_on_the_direction_but_not_on_the_distance() -> None:
    batch = random_face(7, 0.05)
    towards = np.array([[0.9, 0.1], [0.5, 0.5], [0.1, 0.9]])
    near, nearer = (second_form_matrix(batch.jets(step * towards))[0] for step in (4e-6, 2e-6))
    np.testing.assert_allclose(near, nearer, atol=1e-3)
    assert np.abs(near[0] - near[2]).max() > 1e-2


def test_a_part_is_part_of_the_patch() -> None:
    whole = random_face(8, 0.05)
    part = face_batch(whole.nets[0, 0], whole.rational[0, 0], corners=PART)
    weights = barycentric(INNER) @ PART
    there = weights[:, 1:]
    np.testing.assert_allclose(part.jets(INNER).f, whole.jets(there).f, atol=1e-15)
    forms = second_form_matrix(part.jets(INNER)), second_form_matrix(whole.jets(there))
    np.testing.assert_allclose(forms[0], forms[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(part.jets(CORNERS[3][:1]).f[0, 0], FACES[0][2])
    # a part turned the other way round has the opposite normals
    turned = face_batch(whole.nets[0, 0], whole.rational[0, 0], corners=PART[[0, 2, 1]])
    np.testing.assert_allclose(turned.jets(INNER[:, ::-1]).normal, -part.jets(INNER).normal, atol=1e-14)


def test_the_negative_side_is_the_mirror_image_of_the_positive_one() -> None:
    """F and the orientation reversed: the same surface from the same tetrahedron, seen from the other side."""
    above = random_face(9, 0.05)
    swap = [1, 0, 2]
    moved = np.array([place(*np.array(e)[[1, 0, 2, 3]]) for e in np.ndindex(4, 4, 4, 4) if sum(e) == 3])
    order = np.array([place(*e) for e in np.ndindex(4, 4, 4, 4) if sum(e) == 3])
    net = np.empty(20)
    net[moved] = -above.nets[0, 0][order]
    below = ShootingTriangles(
        above.base[:, swap],
        on_side(above.apexes[0, 0], above=False),
        on_side(net, above=False),
        on_side(-above.rational[0, 0][swap], above=False),
        np.eye(3)[None],
    )
    # the parameters of the same point once corners 0 and 1 are exchanged
    there = np.stack([1.0 - INNER.sum(axis=1), INNER[:, 1]], axis=1)
    np.testing.assert_allclose(below.jets(there).f, above.jets(INNER).f, atol=1e-15)
    np.testing.assert_allclose(below.jets(there).normal, -above.jets(INNER).normal, atol=1e-14)
    found, expected = analyse(below.jets(there)), analyse(above.jets(INNER))
    np.testing.assert_allclose(found.mean, -expected.mean, rtol=1e-9)
    np.testing.assert_allclose(below.gradient(there), -above.gradient(INNER), rtol=1e-12)


def test_rays_are_followed_backwards_where_the_face_is_beyond_the_surface() -> None:
    # a sphere around the face's corners from inside: on the face F < 0; with F and the sides reversed F > 0 there
    outside = sphere_face()
    net = quadric_net(face_corners(above=False), np.eye(3), 1.0)
    behind = ShootingTriangles(
        outside.base,
        np.stack([BELOW[0], np.full(3, np.nan)])[None],
        np.stack([-net, np.full(20, np.nan)])[None],
        np.zeros((1, 2, 3)),
        outside.corners,
    )
    # rays to the apex below, backwards from the face: they meet the sphere above it
    jet = behind.jets(lattice(3, 6))
    np.testing.assert_allclose(norm(jet.f), 1.0, atol=1e-15)
    np.testing.assert_allclose(jet.normal, jet.f, atol=1e-14)
    above = dot(jet.f - FACES[0][0], cross(FACES[0][1] - FACES[0][0], FACES[0][2] - FACES[0][0]))
    assert (above[0, corner_distance(3, lattice(3, 6)) > 0.0] > 0.0).all()
    np.testing.assert_allclose(analyse(jet).gauss, 1.0, atol=1e-12)


def test_a_nonconvex_face_is_crossed_with_one_normal() -> None:
    batch = nonconvex_face()
    at = lattice(3, 20)
    jet = batch.jets(at)
    height = dot(jet.f[0] - FACES[0][0], unit(cross(FACES[0][1] - FACES[0][0], FACES[0][2] - FACES[0][0])))
    assert (height > 1e-3).sum() > 20
    assert (height < -1e-3).sum() > 20
    np.testing.assert_allclose(jet.normal, unit(batch.gradient(at)), atol=1e-13)
    # across the curve F = 0 on the face, found by bisection along lines of the domain
    start, end = np.array([0.3, 0.05]), np.array([0.3, 0.6])
    for _ in range(60):
        middle = 0.5 * (start + end)
        f = batch.jets(middle[None], 0).f[0, 0]
        above = dot(f - FACES[0][0], cross(FACES[0][1] - FACES[0][0], FACES[0][2] - FACES[0][0])) > 0.0
        start, end = (middle, end) if above else (start, middle)
    sides = [batch.jets(end + step, 1) for step in np.array([[[0.0, -1e-9]], [[0.0, 1e-9]]])]
    np.testing.assert_allclose(sides[0].f, sides[1].f, atol=1e-8)
    np.testing.assert_allclose(sides[0].normal, sides[1].normal, atol=1e-7)
    # the parametrisation is another one on the other side
    assert np.abs(sides[0].fv - sides[1].fv).max() > 1e-2


def test_corners_of_a_nonconvex_face_have_the_tangents_of_both_sides() -> None:
    batch = nonconvex_face()
    jet = batch.jets(CORNERS[3])
    np.testing.assert_array_equal(jet.f[0], FACES[0])
    for index, (corner, turn) in enumerate(zip(CORNERS[3], TURNS, strict=True)):
        for direction in np.array(turn, dtype=np.float64):
            near = batch.jets((corner + 1e-9 * direction)[None], 1).coefficients[:, 0, 0]
            slope = direction @ near[1:3]
            np.testing.assert_allclose(direction @ jet.coefficients[1:3, 0, index], slope, atol=1e-7)
    np.testing.assert_allclose(jet.normal, unit(batch.gradient(CORNERS[3])), atol=1e-14)
    # corner 0: above along side 0, below along side 2, no second derivatives; corners 1 and 2: one side each
    one_side = np.isfinite(jet.coefficients[3:]).all(axis=(0, 1, 3))
    np.testing.assert_array_equal(one_side, [False, True, True])


@pytest.mark.parametrize("noise", [0.0, 1e-17, -1e-17])
@pytest.mark.parametrize("middle", [0.03, -0.03])
@pytest.mark.parametrize("touching", [False, True])
def test_on_a_side_that_lies_on_the_surface_rays_are_those_from_within(
    noise: float, middle: float, touching: bool
) -> None:
    # F = 0 along p_0 p_1 but for rounding; inside it grows or falls, at once or with the square of the distance
    near = 0.0 if touching else 0.5 * middle
    sides = ((noise, -noise), (near, middle), (middle, near))
    batch = nonconvex_face(2, sides, 0.0 if touching else middle)
    at = np.linspace(0.1, 0.9, 9)[:, None] * np.array([1.0, 0.0])
    inside = batch.jets(at + np.array([0.0, 1e-7]))
    on_side = batch.jets(at)
    np.testing.assert_allclose(on_side.coefficients, inside.coefficients, atol=1e-4)
    np.testing.assert_allclose(on_side.f[0], barycentric(at) @ FACES[0], atol=2e-16)
    # at the ends it is the other side that decides
    corners, close = CORNERS[3][:2], CORNERS[3][:2] + 1e-7 * np.array([[1.0, 1.0], [-2.0, 1.0]])
    np.testing.assert_allclose(batch.jets(corners).coefficients, batch.jets(close).coefficients, atol=1e-4)


def test_a_side_that_touches_the_surface_at_a_corner_goes_where_it_goes() -> None:
    for noise in (1e-17, -1e-17):
        # along p_0 p_1 F has no slope at p_0, and falls; along p_0 p_2 it grows
        batch = nonconvex_face(3, ((noise, -0.04), (-0.04, 0.05), (0.05, 0.02)))
        jet, near = batch.jets(CORNERS[3][:1], 1), batch.jets(np.array([[1e-8, 0.0], [0.0, 1e-8]]), 1)
        np.testing.assert_allclose(jet.fu[0, 0], near.fu[0, 0], atol=1e-6)
        np.testing.assert_allclose(jet.fv[0, 0], near.fv[0, 1], atol=1e-6)


def test_the_start_of_a_ray_on_the_surface_is_its_own_point() -> None:
    # F linear over the face, zero on a line through it: starts on it are dyadic, F there exactly zero
    net = np.zeros((2, 20))
    for e in np.ndindex(4, 4, 4, 4):
        if sum(e) == 3:
            linear = (e[0] - e[1]) / 3.0
            net[:, place(*e)] = linear + e[3] * np.array([1.0, -1.0]) / 3.0
    batch = ShootingTriangles(
        FACES[0][None], np.stack([ABOVE[0], BELOW[0]])[None], net[None], np.zeros((1, 2, 3)), np.eye(3)[None]
    )
    at = np.array([[0.25, 0.5], [0.375, 0.25], [0.5, 0.0]])
    jet = batch.jets(at)
    np.testing.assert_array_equal(jet.f[0], barycentric(at) @ FACES[0])
    # the lines of the domain through its centre stay on the surface: the positive side, where b_0 <= 0
    near = batch.jets(at + np.array([[1e-7, 0.0]])).coefficients
    np.testing.assert_allclose(jet.coefficients[:3], near[:3], atol=1e-5)


@pytest.mark.parametrize("chunk", [1, 7, 64, 10**6])
def test_chunks_do_not_change_a_bit(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    batch, at = many(), lattice(3, 4)
    whole = batch.jets(at).coefficients
    curvatures = np.stack(batch.curvatures(at))
    monkeypatch.setattr(shooting_rays, "CHUNK", chunk)
    np.testing.assert_array_equal(batch.jets(at).coefficients, whole)
    np.testing.assert_array_equal(batch.jets(np.broadcast_to(at, (len(batch), *at.shape))).coefficients, whole)
    np.testing.assert_array_equal(np.stack(batch.curvatures(at)), curvatures)


def test_a_patch_and_a_point_have_the_same_bits_in_any_company() -> None:
    batch, at = many(), lattice(3, 4)
    whole = batch.jets(at).coefficients
    chosen = np.array([4, 0, 4, 2])
    np.testing.assert_array_equal(batch.take(chosen).jets(at[[3, 1]]).coefficients, whole[:, chosen][:, :, [3, 1]])
    np.testing.assert_array_equal(batch.take(slice(1, 2)).jets(at).coefficients, whole[:, 1:2])
    for order in (0, 1):
        np.testing.assert_array_equal(batch.jets(at, order).coefficients, whole[: (1, 3)[order]])
    assert batch.jets(np.zeros((0, 2))).coefficients.shape == (6, len(batch), 0, 3)
    assert batch.take(slice(0, 0)).jets(at).coefficients.shape == (6, 0, len(at), 3)


def many() -> ShootingTriangles:
    """Patches with tetrahedra above, below and on both sides, with rational terms and without."""
    kinds = [sphere_face(), random_face(1), nonconvex_face(), random_face(2, 0.05), nonconvex_face(1)]
    names = ("base", "apexes", "nets", "rational", "corners")
    return ShootingTriangles(*(np.concatenate([getattr(kind, name) for kind in kinds]) for name in names))


def test_finite_asks_for_one_whole_side_and_no_broken_one() -> None:
    batch = many()
    assert batch.finite.all()
    np.testing.assert_array_equal(batch.present[:3], [[True, False], [True, False], [True, True]])
    arrays = {name: getattr(batch, name).copy() for name in ("base", "apexes", "nets", "rational", "corners")}
    arrays["nets"][0, 0, 3] = np.inf
    arrays["rational"][1, 0, 0] = np.nan
    arrays["nets"][2, 1, 7] = np.nan
    arrays["apexes"][3, 0, 1] = np.nan
    spoiled = ShootingTriangles(**arrays)
    np.testing.assert_array_equal(spoiled.finite, [False, False, False, False, True])
    assert np.isnan(spoiled.jets(INNER).f[[0, 1, 3]]).any(axis=(1, 2)).all()
    np.testing.assert_array_equal(spoiled.jets(INNER).f[4], batch.jets(INNER).f[4])
    arrays["base"][4, 0, 0] = np.nan
    assert not ShootingTriangles(**arrays).finite[4]


def test_a_ray_that_meets_nothing_has_no_point() -> None:
    # below zero everywhere
    batch = face_batch(-np.ones(20), np.zeros(3))
    assert np.isnan(batch.jets(INNER).coefficients).all()


def test_data_cannot_be_changed_through_the_batch_and_wrong_shapes_are_told() -> None:
    batch = many()
    with pytest.raises(ValueError, match="read-only"):
        batch.nets[0] = 0.0
    with pytest.raises(ValueError, match=r"rational of 5 patches has the shape \(5, 2, 3\), not \(5, 2, 4\)"):
        ShootingTriangles(batch.base, batch.apexes, batch.nets, np.zeros((5, 2, 4)), batch.corners)
