"""Batches of Bezier patches: right jets, whatever the points are shared with and the patches are evaluated beside."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry import bernstein, curvature
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Float, norm

few = settings(max_examples=25, deadline=None)
seeds = st.integers(0, 2**32 - 1)
KINDS = ("triangles", "rational", "quads")


def some_batch(kind: str, count: int, degree: int, seed: int = 0) -> PatchBatch:
    rng = np.random.default_rng(seed)
    points = rng.standard_normal((count, bernstein.point_count(degree), 3))
    if kind == "triangles":
        return BezierTriangles(points)
    if kind == "rational":
        return RationalBezierTriangles(points, rng.uniform(0.5, 2.0, points.shape[:2]))
    return BezierQuads(rng.standard_normal((count, degree + 1, 3, 3)))


def own(batch: PatchBatch, at: Float) -> Float:
    return np.broadcast_to(at, (len(batch), *at.shape))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("degree", [0, 1, 2, 3, 4, 6])
def test_shared_and_own_points_give_the_same_jets(kind: str, degree: int) -> None:
    batch = some_batch(kind, 5, degree)
    at = lattice(batch.sides, 4)
    for order in (0, 1, 2):
        shared, each = batch.jets(at, order), batch.jets(own(batch, at), order)
        assert shared.coefficients.shape == each.coefficients.shape == ((1, 3, 6)[order], 5, len(at), 3)
        np.testing.assert_allclose(each.coefficients, shared.coefficients, atol=1e-10)


def test_own_points_belong_to_their_patch() -> None:
    batch = some_batch("triangles", 40, 3)
    at = np.random.default_rng(1).random((40, 60, 2)) / 2
    jets = batch.jets(at).coefficients
    for patch in (0, 17, 39):
        one = batch.take(np.array([patch])).jets(at[patch]).coefficients
        np.testing.assert_allclose(jets[:, patch], one[:, 0], atol=1e-12)


@few
@given(st.sampled_from(KINDS), st.integers(1, 6), st.integers(1, 90), st.integers(1, 70), seeds)
def test_bits_depend_on_no_other_patch_and_no_other_point(
    kind: str, degree: int, patches: int, samples: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    batch = some_batch(kind, 150, degree)
    at = rng.random((80, 2)) * (0.5 if batch.sides == 3 else 1.0)
    chosen, points = rng.integers(0, 150, patches), rng.integers(0, 80, samples)
    order = int(rng.integers(0, 3))
    rows = (1, 3, 6)[order]
    whole = batch.jets(at).coefficients[:rows, chosen][:, :, points]
    np.testing.assert_array_equal(batch.take(chosen).jets(at[points], order).coefficients, whole)
    each = batch.jets(own(batch, at)).coefficients[:rows, chosen][:, :, points]
    part = batch.take(chosen)
    np.testing.assert_array_equal(part.jets(own(part, at[points]), order).coefficients, each)


def test_bits_do_not_depend_on_chunks_of_a_large_batch() -> None:
    batch = some_batch("triangles", 3000, 4)
    at = lattice(3, 10)
    whole = batch.jets(at).coefficients
    for start, stop in ((0, 1), (0, 250), (250, 999), (999, 2999), (2999, 3000)):
        part = batch.take(slice(start, stop)).jets(at).coefficients
        np.testing.assert_array_equal(part, whole[:, start:stop])


@pytest.mark.parametrize("kind", KINDS)
def test_empty_batches_and_no_points(kind: str) -> None:
    batch = some_batch(kind, 4, 2)
    nothing = batch.take(np.zeros(0, dtype=np.int64))
    assert len(nothing) == 0
    assert nothing.jets(np.zeros((5, 2))).coefficients.shape == (6, 0, 5, 3)
    assert batch.jets(np.zeros((0, 2)), 1).coefficients.shape == (3, 4, 0, 3)
    assert batch.jets(np.zeros((4, 0, 2)), 1).coefficients.shape == (3, 4, 0, 3)


@pytest.mark.parametrize("kind", KINDS)
def test_points_changed_in_place_are_new_points(kind: str) -> None:
    batch = some_batch(kind, 2, 3)
    at = lattice(batch.sides, 2)
    before = batch.jets(at).f.copy()
    at *= 0.5
    assert not np.array_equal(batch.jets(at).f, before)
    np.testing.assert_array_equal(batch.jets(at * 2.0).f, before)


def test_many_points_are_evaluated_as_few_are() -> None:
    batch = some_batch("triangles", 2, 3)
    at = np.random.default_rng(5).random((3000, 2)) / 2
    jets = batch.jets(at).coefficients
    np.testing.assert_array_equal(jets[:, :, 100:120], batch.jets(at[100:120]).coefficients)


@pytest.mark.parametrize("kind", KINDS)
def test_take_follows_numpy_indexing(kind: str) -> None:
    batch = some_batch(kind, 6, 3)
    at = lattice(batch.sides, 2)
    whole = batch.jets(at).coefficients
    for chosen in (np.array([3, 3, 0]), slice(1, 6, 2), slice(None, None, -1)):
        part = batch.take(chosen)
        assert type(part) is type(batch)
        np.testing.assert_array_equal(part.jets(at).coefficients, whole[:, chosen])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_patch_that_is_not_finite_is_known_and_spoils_no_other(kind: str, bad: float) -> None:
    batch = some_batch(kind, 5, 3)
    assert isinstance(batch, BezierTriangles | RationalBezierTriangles | BezierQuads)
    points = batch.control_points.copy()
    points[2, -1] = bad
    if isinstance(batch, RationalBezierTriangles):
        spoilt: PatchBatch = RationalBezierTriangles(points, batch.weights)
    else:
        spoilt = type(batch)(points)
    assert spoilt.finite.tolist() == [True, True, False, True, True]
    assert batch.finite.all()
    at = np.array([[0.2, 0.3], [0.6, 0.1]])
    kept = [0, 1, 3, 4]
    for points_at in (at, own(batch, at)):
        jets = spoilt.jets(points_at).coefficients
        np.testing.assert_array_equal(jets[:, kept], batch.jets(points_at).coefficients[:, kept])
        assert not np.isfinite(jets[0, 2]).any()


def test_weights_that_are_not_finite_are_found() -> None:
    assert not RationalBezierTriangles(np.ones((1, 3, 3)), np.array([[1.0, np.nan, 1.0]])).finite[0]


@few
@given(st.sampled_from(KINDS), seeds)
def test_affine_maps_of_the_control_points_are_affine_maps_of_the_patch(kind: str, seed: int) -> None:
    batch = some_batch(kind, 3, 3)
    assert isinstance(batch, BezierTriangles | RationalBezierTriangles | BezierQuads)
    rng = np.random.default_rng(seed)
    matrix, shift = rng.standard_normal((3, 3)), rng.standard_normal(3)
    points = batch.control_points @ matrix.T + shift
    if isinstance(batch, RationalBezierTriangles):
        moved: PatchBatch = RationalBezierTriangles(points, batch.weights)
    else:
        moved = type(batch)(points)
    at = lattice(batch.sides, 3)
    expected = batch.jets(at).coefficients @ matrix.T
    expected[0] += shift
    np.testing.assert_allclose(moved.jets(at).coefficients, expected, atol=1e-10)


def test_renaming_corners_permutes_the_derivatives() -> None:
    net = np.random.default_rng(2).standard_normal((1, 15, 3))
    at = lattice(3, 4)
    b = np.column_stack([1.0 - at.sum(axis=1), at])
    indices = bernstein.multi_indices(4)
    before = BezierTriangles(net).jets(at)
    # corners (1, 2, 0): the coordinate of the old corner 0 is the new b2
    places = [bernstein.index_of((row[2], row[0], row[1])) for row in indices.tolist()]
    turned = BezierTriangles(net[:, places]).jets(b[:, [2, 0]])
    np.testing.assert_allclose(turned.f, before.f, atol=1e-13)
    np.testing.assert_allclose(turned.fv, -before.fu, atol=1e-12)
    np.testing.assert_allclose(turned.fu, before.fv - before.fu, atol=1e-12)
    np.testing.assert_allclose(turned.fvv, before.fuu, atol=1e-11)
    np.testing.assert_allclose(turned.fuv, before.fuu - before.fuv, atol=1e-11)
    np.testing.assert_allclose(turned.fuu, before.fvv - 2.0 * before.fuv + before.fuu, atol=1e-11)
    # corners (0, 2, 1): u and v change places and the normal turns over
    places = [bernstein.index_of((row[0], row[2], row[1])) for row in indices.tolist()]
    mirrored = BezierTriangles(net[:, places]).jets(b[:, [2, 1]])
    np.testing.assert_allclose(mirrored.coefficients, before.coefficients[[0, 2, 1, 5, 4, 3]], atol=1e-11)
    np.testing.assert_allclose(mirrored.normal, -before.normal, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_corners_are_interpolated(kind: str) -> None:
    batch = some_batch(kind, 3, 3)
    assert isinstance(batch, BezierTriangles | RationalBezierTriangles | BezierQuads)
    points = batch.control_points
    corners = points[:, [0, 6, 9]] if batch.sides == 3 else points[:, [0, -1, -1, 0], [0, 0, -1, -1]]
    np.testing.assert_allclose(batch.jets(CORNERS[batch.sides], 0).f, corners, rtol=1e-15)


def test_quads_run_along_u_then_v() -> None:
    u, v = np.meshgrid([0.0, 0.5, 1.0], [0.0, 1.0], indexing="ij")
    batch = BezierQuads(np.stack([u, v, u * v], axis=-1)[None])
    assert batch.degree == (2, 1)
    at = lattice(4, 3)
    jet = batch.jets(at)
    np.testing.assert_allclose(jet.f[0], np.column_stack([at, at[:, 0] * at[:, 1]]), atol=1e-15)
    np.testing.assert_allclose(jet.fuv[0], np.tile([0.0, 0.0, 1.0], (len(at), 1)), atol=1e-14)
    np.testing.assert_allclose(jet.fuu[0], 0.0, atol=1e-14)


def test_equal_weights_make_a_polynomial_patch() -> None:
    points = np.random.default_rng(3).standard_normal((4, 10, 3))
    at = lattice(3, 5)
    rational = RationalBezierTriangles(points, np.full((4, 10), 3.0)).jets(at)
    np.testing.assert_allclose(rational.coefficients, BezierTriangles(points).jets(at).coefficients, atol=1e-12)


def test_rational_derivatives_are_those_of_the_taylor_series() -> None:
    batch = some_batch("rational", 1, 3)
    assert isinstance(batch, RationalBezierTriangles)
    count, radius = 24, 0.05
    roots = radius * np.exp(2j * np.pi * np.arange(count) / count)
    exponents = bernstein.multi_indices(3)
    for u, v in ((0.3, 0.2), (0.0, 0.6)):
        b1, b2 = np.meshgrid(u + roots, v + roots, indexing="ij")
        basis = np.stack(
            [
                math.factorial(3) / math.prod(map(math.factorial, (i, j, k))) * (1 - b1 - b2) ** i * b1**j * b2**k
                for i, j, k in exponents.tolist()
            ],
            axis=-1,
        )
        weighted = basis * batch.weights[0]
        series = np.fft.fft2(weighted @ batch.control_points[0] / weighted.sum(axis=-1)[..., None], axes=(0, 1))
        orders = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
        expected = [math.factorial(p) * math.factorial(q) * series[p, q].real / radius ** (p + q) for p, q in orders]
        jet = batch.jets(np.array([[u, v]])).coefficients[:, 0, 0]
        np.testing.assert_allclose(jet, np.array(expected) / count**2, atol=1e-10)


def sphere_pieces(corners: Float) -> RationalBezierTriangles:
    """Pieces of the unit sphere: rational quadratics, inverse stereographic images of plane triangles (P, 3, 2).

    (2 x, 2 y, 1 - r^2) / (1 + r^2); the control points are its blossom, x . y in place of r^2.
    """
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    a, b = (np.stack([corners[:, pair[end]] for pair in pairs], axis=1) for end in (0, 1))
    product = (a * b).sum(axis=-1)
    weights = 1.0 + product
    return RationalBezierTriangles(np.concatenate([a + b, 1.0 - product[..., None]], -1) / weights[..., None], weights)


@few
@given(seeds)
def test_pieces_of_the_sphere_are_exact(seed: int) -> None:
    corners = CORNERS[3] + np.random.default_rng(seed).uniform(-0.3, 0.3, (5, 3, 2))
    jet = sphere_pieces(corners).jets(lattice(3, 8))
    np.testing.assert_allclose(norm(jet.f), 1.0, rtol=1e-14)
    np.testing.assert_allclose(jet.normal, jet.f, atol=1e-13)
    analysis = curvature.analyse(jet)
    np.testing.assert_allclose(analysis.gauss, 1.0, rtol=1e-11)
    np.testing.assert_allclose(analysis.mean, 1.0, rtol=1e-11)
    # sides of the pieces are circles: plane sections of the sphere
    side = jet.f[:, lattice(3, 8)[:, 1] == 0.0]
    assert (np.linalg.svd(side - side[:, :1], compute_uv=False)[:, 2] < 1e-14).all()


def test_a_vanishing_denominator_is_not_finite_and_not_loud() -> None:
    batch = RationalBezierTriangles(np.ones((1, 3, 3)), np.array([[1.0, -1.0, 1.0]]))
    assert not np.isfinite(batch.jets(np.array([[0.5, 0.0]])).coefficients[0]).any()


@pytest.mark.parametrize(
    ("kind", "shape"),
    [("triangles", (2, 5, 3)), ("triangles", (10, 3)), ("triangles", (2, 10, 4)), ("quads", (2, 4, 3))],
)
def test_shapes_that_are_no_nets_are_refused(kind: str, shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"not \(|not 5"):
        (BezierTriangles if kind == "triangles" else BezierQuads)(np.zeros(shape))


def test_weights_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="weights"):
        RationalBezierTriangles(np.zeros((2, 10, 3)), np.ones((2, 6)))


def test_batches_are_immutable_and_do_not_follow_their_input() -> None:
    points = np.random.default_rng(4).standard_normal((2, 10, 3))
    before = points.copy()
    batch = BezierTriangles(points)
    points += 1.0
    np.testing.assert_array_equal(batch.control_points, before)
    with pytest.raises(ValueError, match="read-only"):
        batch.control_points[0] = 0.0
    with pytest.raises(AttributeError):
        batch.control_points = points  # type: ignore[misc]
