import numpy as np
import pytest
from precise_shooting import differences, edge_points
from tetrahedra import (
    FLAT,
    PINCH,
    POINTS,
    edge_batch,
    joining_edge,
    nonconvex_edge,
    on_side,
    place,
    random_face,
    sphere_edge,
)

from testbed.geometry import shooting_rays
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.shooting_quads import ShootingQuads, bernstein_rows
from testbed.geometry.vectors import Float, norm, unit

FIELDS = ("ends", "apexes", "nets", "rational", "span")
INNER = lattice(4, 7)[(lattice(4, 7)[:, 0] > 0.0) & (lattice(4, 7)[:, 0] < 1.0)]
#: Along both collapsed sides.
COLLAPSED = np.array([[u, v] for u in (0.0, 1.0) for v in (0.0, 0.3, 0.5, 1.0)])


def random_edge(seed: int = 0, roughness: float = 0.05) -> ShootingQuads:
    """Near the unit sphere, with rational terms."""
    return joining_edge(random_face(seed, roughness), seed, roughness)


def tangent_edge(seed: int = 0) -> ShootingQuads:
    """F touches zero along the edge at its start: the normal there is perpendicular to the edge."""
    batch = random_edge(seed, 0.02)
    net = batch.nets[0, 0].copy()
    net[place(0, 2, 1, 0)] = 0.0
    return edge_batch(net, batch.rational[0, 0])


#: One of each: whole edges, one that starts tangentially, and both parts of a nonconvex one.
KINDS = {
    "sphere": sphere_edge(),
    "random": random_edge(1),
    "tangent": tangent_edge(2),
    "before the pinch": nonconvex_edge((0.0, PINCH)),
    "after the pinch": nonconvex_edge((PINCH, 1.0)),
}


def many() -> ShootingQuads:
    kinds = list(KINDS.values())
    return ShootingQuads(*(np.concatenate([getattr(kind, name) for kind in kinds]) for name in FIELDS))


def test_a_quadric_is_reproduced() -> None:
    jet = sphere_edge().jets(lattice(4, 8))
    np.testing.assert_allclose(norm(jet.f), 1.0, atol=4e-16)
    # at the collapsed sides, too
    np.testing.assert_allclose(jet.normal, jet.f, atol=2e-15)
    found = analyse(sphere_edge().jets(INNER))
    np.testing.assert_allclose(found.gauss, 1.0, atol=1e-13)
    np.testing.assert_allclose(found.mean, 1.0, atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_jets_are_the_derivatives_of_the_points(kind: str) -> None:
    batch = KINDS[kind]
    at = 0.02 + 0.96 * np.random.default_rng(3).uniform(size=(12, 2))
    side = 1 if kind == "after the pinch" else 0
    expected = differences(lambda at: edge_points(batch, side, at), at).astype(np.float64)
    np.testing.assert_allclose(batch.jets(at).coefficients[:, 0], expected, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_curvatures_are_those_of_the_implicit_function(kind: str) -> None:
    batch = KINDS[kind]
    found, (gauss, mean) = analyse(batch.jets(INNER)), batch.curvatures(INNER)
    np.testing.assert_allclose(found.gauss, gauss, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(found.mean, mean, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(found.normal, unit(batch.gradient(INNER)), atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_second_derivatives_can_be_trusted_up_to_the_margin(kind: str) -> None:
    batch = KINDS[kind]
    for distance in (batch.corner_margin, 10.0 * batch.corner_margin, 1e-2):
        at = np.array([[u, v] for u in (distance, 1.0 - distance) for v in (0.0, 0.4, 1.0)])
        found, (gauss, mean) = analyse(batch.jets(at)), batch.curvatures(at)
        size = np.abs(mean).max() + np.sqrt(np.abs(gauss)).max()
        # where t is of second order, rounding is 1e-16 over the square of the distance, else over the distance
        tolerance = 1e-6 if kind == "tangent" else 1e-9
        assert np.abs(found.gauss - gauss).max() < tolerance * size**2
        assert np.abs(found.mean - mean).max() < tolerance * size


@pytest.mark.parametrize("kind", KINDS)
def test_collapsed_sides_have_the_limits_of_the_derivatives(kind: str) -> None:
    batch = KINDS[kind]
    jet = batch.jets(COLLAPSED)
    assert np.isnan(jet.coefficients[3:]).all()
    np.testing.assert_array_equal(batch.jets(COLLAPSED, 1).coefficients, jet.coefficients[:3])
    for index, (u, v) in enumerate(COLLAPSED):
        distance, order = 1e-5, 2 if kind == "tangent" and u == 0.0 else 1
        near = batch.jets(np.array([[abs(u - distance), v]]), 1)
        scale = np.abs(jet.coefficients[:3, 0, index]).max()
        np.testing.assert_allclose(near.fu[0, 0], jet.fu[0, index], atol=1e-2 * scale)
        np.testing.assert_allclose(near.fv[0, 0] / distance**order, jet.fv[0, index], atol=1e-2 * scale)
        np.testing.assert_allclose(near.normal[0, 0], jet.normal[0, index], atol=1e-3)
    # one point, one normal along each side, that of F
    np.testing.assert_allclose(jet.normal, unit(batch.gradient(COLLAPSED)), atol=1e-13)
    start, end = batch.span[0]
    for half, x in ((slice(0, 4), start), (slice(4, 8), end)):
        there = (1.0 - x) * batch.ends[0, 0] + x * batch.ends[0, 1]
        np.testing.assert_allclose(jet.f[0, half], np.broadcast_to(there, (4, 3)), atol=2e-16)
        assert (np.ptp(jet.f[0, half], axis=0) == 0.0).all()
        np.testing.assert_allclose(jet.normal[0, half], np.broadcast_to(jet.normal[0, half][:1], (4, 3)), atol=1e-13)


@pytest.mark.parametrize(
    ("kind", "u"), [("random", 2.0**-45), ("random", 1.0 - 2.0**-45), ("after the pinch", 1.0 - 2.0**-45)]
)
def test_rays_next_to_a_vertex_have_all_the_digits_of_their_length(kind: str, u: float) -> None:
    at = np.array([[u, 0.4]])
    distance = min(u, 1.0 - u)
    limit = KINDS[kind].jets(np.round(at * [1, 10]) / [1, 10], 1).fv
    np.testing.assert_allclose(KINDS[kind].jets(at, 1).fv / distance, limit, rtol=1e-9)


@pytest.mark.parametrize("kind", ["random", "sphere"])
def test_whole_edges_end_exactly_in_vertices(kind: str) -> None:
    f = KINDS[kind].jets(CORNERS[4], 0).f[0]
    np.testing.assert_array_equal(f, POINTS[[0, 1, 1, 0]])


@pytest.mark.parametrize("seed", range(4))
def test_the_rim_is_that_of_the_face_with_equal_normals(seed: int) -> None:
    face = random_face(seed, 0.05)
    edge = joining_edge(face, seed, 0.05)
    x = np.linspace(0.0, 1.0, 41)
    on_face = face.jets(np.stack([x, np.zeros_like(x)], axis=1), 1)
    on_edge = edge.jets(np.stack([x, np.ones_like(x)], axis=1), 1)
    np.testing.assert_allclose(on_edge.f, on_face.f, atol=1e-15)
    np.testing.assert_allclose(on_edge.fu, on_face.fu, atol=1e-13)
    np.testing.assert_allclose(on_edge.normal, on_face.normal, atol=1e-13)
    gradients = face.gradient(np.stack([x, np.zeros_like(x)], axis=1)), edge.gradient(np.stack([x, x * 0 + 1], axis=1))
    np.testing.assert_allclose(*gradients, atol=1e-14)
    # that is the rational terms' doing: without them normals differ
    rough = edge_batch(edge.nets[0, 0], np.zeros(4)).jets(np.stack([x, np.ones_like(x)], axis=1), 1)
    assert np.abs(rough.normal - on_face.normal).max() > 1e-4


def test_parts_of_a_nonconvex_edge_lie_on_both_sides_and_meet_with_one_normal() -> None:
    before, after = KINDS["before the pinch"], KINDS["after the pinch"]
    for batch, sign in ((before, 1.0), (after, -1.0)):
        f = batch.jets(INNER, 0).f[0]
        assert (sign * f[:, 2] > 0.0).all()
        # both are seen from above, like the mesh
        assert (batch.jets(INNER, 1).normal[..., 2] > 0.5).all()
    v = np.linspace(0.0, 1.0, 5)
    end, start = before.jets(np.stack([v * 0 + 1, v], axis=1), 1), after.jets(np.stack([v * 0, v], axis=1), 1)
    np.testing.assert_array_equal(end.f, start.f)
    np.testing.assert_array_equal(end.f[0, 0], (1.0 - PINCH) * FLAT[0] + PINCH * FLAT[1])
    np.testing.assert_allclose(end.normal, start.normal, atol=1e-14)
    # F is z + 3 x (1 - x) (0.07 x - 0.02) there to first order
    slope = 3.0 * (PINCH * (1.0 - PINCH)) * (0.05 + 0.02)
    expected = unit(np.array([slope, 0.0, 1.0]))
    np.testing.assert_allclose(end.normal[0], np.broadcast_to(expected, (5, 3)), atol=1e-14)


def test_a_pinch_that_is_known_to_rounding_only_is_a_pinch() -> None:
    nearby = PINCH + 3e-16 * np.arange(-2, 3)
    for pinch in nearby:
        for batch in (nonconvex_edge((0.0, pinch)), nonconvex_edge((pinch, 1.0))):
            jet = batch.jets(COLLAPSED, 1)
            assert (jet.normal[..., 2] > 0.5).all()
            near = batch.jets(np.array([[1e-9, 0.5], [1.0 - 1e-9, 0.5]]), 1)
            assert (near.normal[..., 2] > 0.5).all()


def test_a_span_runs_over_a_part_of_the_edge() -> None:
    # two sign changes at 1 / 4 and 3 / 4 leave an inner part that ends in points, too; F negative there
    batch = random_edge(4)
    net = batch.nets[0, 0].copy()
    x = np.array([0.0, 0.25, 0.75, 1.0])
    values = (x - 0.25) * (x - 0.75)
    assert values[1] == values[2] == 0.0
    # as a cubic in Bernstein form: the quadratic with coefficients 3 / 16, -5 / 16, 3 / 16, elevated
    quadratic = np.array([3.0, -5.0, 3.0]) / 16.0
    cubic = [quadratic[0], (quadratic[0] + 2 * quadratic[1]) / 3, (2 * quadratic[1] + quadratic[2]) / 3, quadratic[2]]
    for k, value in enumerate(cubic):
        net[place(0, 3 - k, k, 0)] = value
    part = edge_batch(net, batch.rational[0, 0], span=(0.25, 0.75))
    jet = part.jets(lattice(4, 4))
    assert np.isfinite(jet.f).all()
    np.testing.assert_allclose(jet.normal, unit(part.gradient(lattice(4, 4))), atol=1e-13)
    np.testing.assert_array_equal(jet.f[0, 0], 0.75 * POINTS[0] + 0.25 * POINTS[1])


def test_a_span_that_does_not_end_where_f_is_zero_is_told() -> None:
    batch = random_edge(5)
    with pytest.raises(ValueError, match=r"at parameter 0.4 of the edge of patch 0, which should end in a point there"):
        edge_batch(batch.nets[0, 0], batch.rational[0, 0], span=(0.0, 0.4))


def test_the_negative_side_is_the_mirror_image_of_the_positive_one() -> None:
    """F reversed and the edge run backwards, which swaps the faces: the same points, seen from the other side."""
    above = random_edge(6)
    order = np.array([place(*e) for e in np.ndindex(4, 4, 4, 4) if sum(e) == 3])
    moved = np.array([place(*np.array(e)[[0, 2, 1, 3]]) for e in np.ndindex(4, 4, 4, 4) if sum(e) == 3])
    net = np.empty(20)
    net[moved] = -above.nets[0, 0][order]
    rational = -above.rational[0, 0][[2, 3, 0, 1]]
    below = ShootingQuads(
        above.ends[:, ::-1],
        on_side(above.apexes[0, 0], above=False),
        on_side(net, above=False),
        on_side(rational, above=False),
        above.span,
    )
    there = np.stack([1.0 - INNER[:, 0], INNER[:, 1]], axis=1)
    np.testing.assert_allclose(below.jets(there).f, above.jets(INNER).f, atol=1e-15)
    np.testing.assert_allclose(below.jets(there).normal, -above.jets(INNER).normal, atol=1e-13)
    found, expected = analyse(below.jets(there)), analyse(above.jets(INNER))
    np.testing.assert_allclose(found.gauss, expected.gauss, rtol=1e-9)
    np.testing.assert_allclose(found.mean, -expected.mean, rtol=1e-9)


@pytest.mark.parametrize("chunk", [1, 7, 64, 10**6])
def test_chunks_do_not_change_a_bit(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    batch, at = many(), lattice(4, 4)
    whole, curvatures = batch.jets(at).coefficients, np.stack(batch.curvatures(INNER))
    monkeypatch.setattr(shooting_rays, "CHUNK", chunk)
    np.testing.assert_array_equal(batch.jets(at).coefficients, whole)
    np.testing.assert_array_equal(batch.jets(np.broadcast_to(at, (len(batch), *at.shape))).coefficients, whole)
    np.testing.assert_array_equal(np.stack(batch.curvatures(INNER)), curvatures)


def test_a_patch_and_a_point_have_the_same_bits_in_any_company() -> None:
    batch, at = many(), lattice(4, 4)
    whole = batch.jets(at).coefficients
    chosen = np.array([4, 0, 4, 2])
    np.testing.assert_array_equal(batch.take(chosen).jets(at[[3, 7]]).coefficients, whole[:, chosen][:, :, [3, 7]])
    np.testing.assert_array_equal(batch.take(slice(1, 2)).jets(at).coefficients, whole[:, 1:2])
    for order in (0, 1):
        np.testing.assert_array_equal(batch.jets(at, order).coefficients, whole[: (1, 3)[order]])
    assert batch.jets(np.zeros((0, 2))).coefficients.shape == (6, len(batch), 0, 3)
    assert batch.take(slice(0, 0)).jets(at).coefficients.shape == (6, 0, len(at), 3)


def test_finite_asks_for_one_whole_side_and_no_broken_one() -> None:
    batch = many()
    assert batch.finite.all()
    arrays = {name: getattr(batch, name).copy() for name in FIELDS}
    arrays["nets"][0, 0, 3] = np.inf
    arrays["rational"][1, 0, 0] = np.nan
    arrays["span"][2, 1] = np.nan
    arrays["nets"][3, 1, 7] = np.nan
    np.testing.assert_array_equal(ShootingQuads(**arrays).finite, [False, False, False, False, True])


def test_wrong_shapes_are_told() -> None:
    batch = many()
    with pytest.raises(ValueError, match=r"span of 5 patches has the shape \(5, 2\), not \(5, 3\)"):
        ShootingQuads(batch.ends, batch.apexes, batch.nets, batch.rational, np.zeros((5, 3)))
    with pytest.raises(ValueError, match="read-only"):
        batch.span[0] = 0.0


def test_polynomials_have_all_their_digits_at_both_ends() -> None:
    def exact(x: Float) -> Float:
        # 3 x (1 - x)^2 at 1 - x
        return 3.0 * (1.0 - x) * x**2

    rest = np.array([1e-20, 1e-9, 0.25])
    rows = bernstein_rows(3, 1.0 - rest, rest, 2)
    np.testing.assert_allclose(rows[0, 1], exact(rest), rtol=1e-15)
    # derivatives of 3 (1 - r) r^2 along x = 1 - r
    np.testing.assert_allclose(rows[1, 1], -6.0 * rest + 9.0 * rest**2, rtol=1e-14)
    np.testing.assert_allclose(rows[2, 1], 6.0 - 18.0 * rest, rtol=1e-14)
    np.testing.assert_allclose(rows.sum(axis=1), [[1.0] * 3, [0.0] * 3, [0.0] * 3], atol=1e-15)
