"""Boundary curves: what each matches, and that it depends on its own edge only, in any position, size and direction."""

import dataclasses

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.vectors import Float, cross, dot, norm, quadratic_form, tangential, unit
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed.registry import catalogue
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.conic import ConicCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.hermite_space import HermiteSpace, end_equations
from testbed_schemes.boundary_curves.optimized import Optimized, best_speeds
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.boundary_curves.piper import PiperCurve
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve
from testbed_schemes.edge_conics import edge_conics
from testbed_schemes.geometric_hermite import speed_variation
from testbed_schemes.planar_frame import planar_frame

CURVES = [
    Projected(),
    Planar(),
    Circular(),
    Hermite(),
    Hermite(root="worst"),
    Optimized(),
    HermiteSpace(),
    HermiteSpace(root="worst"),
    PetersCurve(),
    PiperCurve(),
    WaltonMeekCurve(),
    ConicCurve(),
]
every_curve = pytest.mark.parametrize("boundary", CURVES, ids=str)
PLANAR = [Planar(), Hermite(), Hermite(root="worst"), Optimized(), ConicCurve()]
#: Constructions by formulas alone, without a search for roots or minima.
CLOSED = [Projected(), Planar(), Circular(), PiperCurve(), WaltonMeekCurve(), ConicCurve()]


def sampled_edges(count: int = 300, seed: int = 1) -> EdgeData:
    """Edges between points of a bent graph with data of that surface, nothing symmetric, lengths 0.1 to 1."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1.0, 1.0, (count, 2))
    angle, length = rng.uniform(0.0, 2 * np.pi, count), rng.uniform(0.1, 1.0, count)
    end = start + length[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    data = [values for at in (start, end) for values in graph_data(at)]
    return EdgeData(data[0], data[3], data[1], data[4], data[2], data[5])


def graph_data(at: Float) -> tuple[Float, Float, Float]:
    """Points, normals and second forms of z = -(x^2 + x y / 2 + y^2) / 2 + x^3 / 10 - x y^2 / 15."""
    x, y = at.T
    z = -(x**2 + x * y / 2 + y**2) / 2 + x**3 / 10 - x * y**2 / 15
    slope = np.stack([-x - y / 4 + 3 * x**2 / 10 - y**2 / 15, -y - x / 4 - 2 * x * y / 15], axis=-1)
    hessian = np.empty((len(x), 2, 2))
    hessian[:, 0, 0], hessian[:, 1, 1] = -1 + 6 * x / 10, -1 - 2 * x / 15
    hessian[:, 0, 1] = hessian[:, 1, 0] = -1 / 4 - 2 * y / 15
    normal = unit(np.concatenate([-slope, np.ones((len(x), 1))], axis=1))
    onto = np.eye(3) - normal[:, :, None] * normal[:, None]
    W = -np.einsum("eia,eab,ejb->eij", onto[:, :, :2], hessian * normal[:, 2, None, None], onto[:, :, :2])
    return np.stack([x, y, z], axis=-1), normal, W


def moved(edges: EdgeData, rotation: Float, scale: float, shift: Float) -> EdgeData:
    points = [scale * p @ rotation.T + shift for p in (edges.p0, edges.p1)]
    normals = [n @ rotation.T for n in (edges.n0, edges.n1) if n is not None]
    forms = [rotation @ W @ rotation.T / scale for W in (edges.W0, edges.W1) if W is not None]
    return EdgeData(*points, *normals, *forms)


def reversed_edges(edges: EdgeData) -> EdgeData:
    return EdgeData(edges.p1, edges.p0, edges.n1, edges.n0, edges.W1, edges.W0)


def chosen(edges: EdgeData, which: slice) -> EdgeData:
    ends = (edges.n0, edges.n1, edges.W0, edges.W1)
    return EdgeData(edges.p0[which], edges.p1[which], *(None if a is None else a[which] for a in ends))


def arc(angle: float, radius: float = 1.0) -> EdgeData:
    """One edge over an arc of a great circle of a sphere."""
    n = np.array([[np.cos(t), np.sin(t), 0.0] for t in (0.0, angle)])
    W = (np.eye(3) - n[:, :, None] * n[:, None]) / radius
    return EdgeData(radius * n[:1], radius * n[1:], n[:1], n[1:], W[:1], W[1:])


def flat_edges() -> EdgeData:
    edges = sampled_edges(50)
    ends = [p * [1.0, 1.0, 0.0] for p in (edges.p0, edges.p1)]
    normal, W = np.broadcast_to([0.0, 0.0, 1.0], (50, 3)), np.zeros((50, 3, 3))
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return moved(EdgeData(ends[0], ends[1], normal, normal, W, W), rotation, 1.0, np.full(3, 5.0))


def lengths(edges: EdgeData) -> Float:
    return norm(edges.p1 - edges.p0)


def legs(curves: Float) -> tuple[Float, Float]:
    return norm(curves[:, 1] - curves[:, 0]), norm(curves[:, 3] - curves[:, 2])


def normal_curvatures(curves: Float, edges: EdgeData) -> tuple[Float, Float]:
    """-<C'', n> / |C'|^2 at both ends."""
    assert edges.n0 is not None
    assert edges.n1 is not None
    first, last = curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2]
    middle = curves[:, 2] - curves[:, 1]
    at_start = -6 * dot(middle - first, edges.n0) / (9 * dot(first, first))
    at_end = -6 * dot(last - middle, edges.n1) / (9 * dot(last, last))
    return at_start, at_end


@every_curve
def test_a_curve_ends_in_the_data_with_tangents_in_the_tangent_planes(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    curves, _ = boundary.curves(edges)
    assert np.array_equal(curves[:, 0], edges.p0)
    assert np.array_equal(curves[:, 3], edges.p1)
    chord = edges.p1 - edges.p0
    for leg, normal in ((curves[:, 1] - curves[:, 0], edges.n0), (curves[:, 3] - curves[:, 2], edges.n1)):
        assert normal is not None
        assert np.abs(dot(leg, normal)).max() < 1e-14
        assert (dot(leg, chord) > 0.0).all()


@pytest.mark.parametrize("boundary", PLANAR, ids=str)
def test_a_planar_construction_stays_in_the_plane_of_chord_and_mean_normal(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    assert edges.n0 is not None
    assert edges.n1 is not None
    curves, _ = boundary.curves(edges)
    plane = unit(cross(edges.n0 + edges.n1, edges.p1 - edges.p0))
    assert np.abs(dot(curves - curves[:, :1], plane[:, None])).max() < 1e-14


@every_curve
@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e7])
def test_a_curve_moves_with_its_data(boundary: BoundaryCurve, scale: float) -> None:
    edges = sampled_edges()
    rotation = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    curves, notes = boundary.curves(edges)
    images, image_notes = boundary.curves(moved(edges, rotation, scale, np.zeros(3)))
    assert image_notes == notes
    off = images / scale - curves @ rotation.T
    assert norm(off[:, [0, 3]]).max() < 1e-14
    # where two solutions nearly merge, rounding, amplified, moves inner points along their legs, and not off them
    legs = unit(np.stack([curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2]], axis=1) @ rotation.T)
    along = dot(off[:, 1:3], legs)
    assert norm(off[:, 1:3] - along[..., None] * legs).max() < 1e-13
    assert np.abs(along).max() < 1e-9


@every_curve
def test_the_reversed_edge_has_the_reversed_curve(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    there, back = boundary.curves(edges)[0], boundary.curves(reversed_edges(edges))[0]
    assert norm(there - back[:, ::-1]).max() < 1e-10


@pytest.mark.parametrize("boundary", CLOSED, ids=str)
def test_a_formula_gives_the_reversed_curve_bit_for_bit(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    assert np.array_equal(boundary.curves(edges)[0], boundary.curves(reversed_edges(edges))[0][:, ::-1])


@every_curve
def test_both_faces_of_an_edge_have_the_same_curve_bit_for_bit(boundary: BoundaryCurve) -> None:
    mesh = registry.dataset("icosahedron").mesh(0)
    curves = boundary.network(mesh).opposite_vertices().reshape(-1, 4, 3)
    ends = np.roll(mesh.faces, -1, axis=1)[..., None][:, :, [0, 0]]
    ends[..., 1] = np.roll(mesh.faces, -2, axis=1)
    ends = ends.reshape(-1, 2)
    partner = [np.flatnonzero((ends == end[::-1]).all(axis=1))[0] for end in ends]
    assert np.array_equal(curves, curves[partner][:, ::-1])


@every_curve
def test_a_curve_sees_its_own_edge_only(boundary: BoundaryCurve) -> None:
    edges = sampled_edges()
    curves, _ = boundary.curves(edges)
    for which in (slice(17, 18), slice(5, 90), slice(None, None, -1)):
        assert np.array_equal(boundary.curves(chosen(edges, which))[0], curves[which])


@every_curve
def test_flat_data_give_straight_edges_and_nothing_to_note(boundary: BoundaryCurve) -> None:
    edges = flat_edges()
    curves, notes = boundary.curves(edges)
    t = np.array([0.0, 1.0, 2.0, 3.0])[None, :, None] / 3.0
    assert norm(curves - (edges.p0[:, None] * (1.0 - t) + edges.p1[:, None] * t)).max() < 1e-13
    assert notes == {}


@every_curve
def test_a_chord_along_a_normal_is_refused_by_the_vertices(boundary: BoundaryCurve) -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    W = np.zeros((3, 3, 3))
    with pytest.raises(Refused, match="from vertex 0 to vertex 2"):
        boundary.network(HermiteMesh(points, [[0, 1, 2]], normals, W))


@every_curve
@pytest.mark.parametrize("off", [0.0, 1e-14, 1e-10])
def test_a_chord_nearly_along_a_normal_has_no_curve_and_its_neighbour_has_one(
    boundary: BoundaryCurve, off: float
) -> None:
    edges = sampled_edges(2)
    n0 = np.array(edges.n0)
    n0[0] = unit(edges.p1[0] - edges.p0[0] + np.array([off, 0.0, 0.0]))
    W0 = np.zeros((2, 3, 3))
    curves, _ = boundary.curves(EdgeData(edges.p0, edges.p1, n0, edges.n1, W0, edges.W1))
    assert np.isnan(curves[0]).any()
    assert np.isfinite(curves[1]).all()


@pytest.mark.parametrize("boundary", CURVES, ids=str)
def test_the_registry_reads_back_what_a_curve_calls_itself(boundary: BoundaryCurve) -> None:
    assert registry.boundary_curve(str(boundary)) == boundary


def test_projected_and_planar_legs_are_a_third_of_the_chord() -> None:
    edges = sampled_edges()
    for boundary in (Projected(), Planar()):
        for leg in legs(boundary.curves(edges)[0]):
            assert np.allclose(leg, lengths(edges) / 3.0, rtol=1e-13)


def test_projected_tangents_are_the_projected_chord() -> None:
    edges = sampled_edges()
    assert edges.n0 is not None
    curves, _ = Projected().curves(edges)
    direction = unit(tangential(edges.p1 - edges.p0, edges.n0))
    assert norm(unit(curves[:, 1] - curves[:, 0]) - direction).max() < 1e-13


@pytest.mark.parametrize("degrees", [5.0, 45.0, 90.0, 170.0])
def test_a_circular_curve_over_an_arc_has_its_middle_on_the_circle(degrees: float) -> None:
    angle = np.radians(degrees)
    curve = Circular().curves(arc(angle, radius=2.0))[0]
    assert legs(curve)[0][0] == pytest.approx(8.0 / 3.0 * np.tan(angle / 4.0), rel=1e-13)
    middle = curve[0] * np.array([1.0, 3.0, 3.0, 1.0])[:, None] / 8.0
    assert norm(middle.sum(axis=0)) == pytest.approx(2.0, rel=1e-13)


def test_every_registered_curve_is_tested_here() -> None:
    assert {type(curve) for curve in CURVES} >= set(catalogue(BoundaryCurve).values())  # type: ignore[type-abstract]


@pytest.mark.parametrize("boundary", [curve for curve in CURVES if Data.SECOND_FORMS not in curve.matches], ids=str)
def test_what_does_not_claim_the_curvature_of_the_data_does_not_have_it(boundary: BoundaryCurve) -> None:
    edges = sampled_edges(200)
    assert edges.W0 is not None
    curves, _ = boundary.curves(edges)
    t0 = unit(curves[:, 1] - curves[:, 0])
    assert np.abs(normal_curvatures(curves, edges)[0] - quadratic_form(t0, edges.W0, t0)).max() > 1e-3


@pytest.mark.parametrize("boundary", [curve for curve in CURVES if Data.SECOND_FORMS in curve.matches], ids=str)
def test_what_claims_the_normal_curvature_of_the_data_has_it(boundary: BoundaryCurve) -> None:
    edges = sampled_edges(2000)
    assert edges.W0 is not None
    assert edges.W1 is not None
    curves, notes = boundary.curves(edges)
    assert notes == {}
    at_start, at_end = normal_curvatures(curves, edges)
    t0, t1 = unit(curves[:, 1] - curves[:, 0]), unit(curves[:, 3] - curves[:, 2])
    # relative to the legs: a leg d and an error e in a point change the curvature by e / d^2
    small0, small1 = (np.minimum(leg / lengths(edges), 1.0 / 3.0) ** 2 for leg in legs(curves))
    assert (np.abs(at_start - quadratic_form(t0, edges.W0, t0)) * small0).max() < 1e-12
    assert (np.abs(at_end - quadratic_form(t1, edges.W1, t1)) * small1).max() < 1e-12


@pytest.mark.parametrize("degrees", [1.0, 10.0, 30.0, 51.3, 59.9])
def test_an_arc_below_sixty_degrees_has_three_solutions(degrees: float) -> None:
    angle = np.radians(degrees)
    symmetric, lopsided = (Hermite(root=root).curves(arc(angle))[0] for root in ("best", "worst"))
    # the three solutions are angle / 3.5 apart, so that rounding shows more the shorter the arc
    assert legs(symmetric)[0] == pytest.approx(legs(symmetric)[1], rel=1e-7)
    expected = np.sin(angle) / 3.0 + np.array([1.0, -1.0]) * (1.0 - np.cos(angle)) / np.sqrt(3.0)
    assert np.ravel(legs(lopsided)) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("degrees", [60.0, 60.1, 90.0, 150.0])
def test_an_arc_from_sixty_degrees_on_has_one_solution(degrees: float) -> None:
    angle = np.radians(degrees)
    best, worst = (Hermite(root=root).curves(arc(angle)) for root in ("best", "worst"))
    assert norm(best[0] - worst[0]).max() < 1e-12
    assert best[1] == worst[1] == {}


def test_the_leg_on_the_octahedron() -> None:
    curves = Hermite().curves(arc(np.pi / 2))[0]
    assert legs(curves) == pytest.approx(((np.sqrt(7.0) - 1.0) / 3.0,) * 2, rel=1e-14)


def test_a_short_edge_has_the_middle_of_its_arc_to_sixth_order() -> None:
    angles = np.array([0.8, 0.4, 0.2])
    middles = [Hermite().curves(arc(a))[0][0] * np.array([1.0, 3.0, 3.0, 1.0])[:, None] / 8.0 for a in angles]
    errors = np.array([abs(float(norm(m.sum(axis=0))) - 1.0) for m in middles])
    assert (np.log2(errors[:-1] / errors[1:]) > 5.8).all()


def test_the_worst_root_on_the_published_sphere_changes_the_ring_edges_only() -> None:
    mesh = registry.dataset("sphere").mesh(0)
    best, worst = (Hermite(root=root).network(mesh).control_points for root in ("best", "worst"))
    changed = norm(best - worst).max(axis=1) > 1e-9
    z = mesh.points[mesh.edges][:, :, 2]
    assert np.array_equal(changed, np.abs(z[:, 0] - z[:, 1]) < 1e-12)


def test_edges_without_a_solution_fall_back_to_planar_and_are_counted() -> None:
    edges = arc(0.5)
    assert edges.W0 is not None
    assert edges.W1 is not None
    bent_away = EdgeData(edges.p0, edges.p1, edges.n0, edges.n1, -edges.W0, -edges.W1)
    curves, notes = Hermite().curves(bent_away)
    assert notes == {"curves without a root": 1}
    assert np.array_equal(curves, Planar().curves(bent_away)[0])


def test_an_inflection_with_parallel_tangents_is_solved_end_by_end() -> None:
    # t0 x t1 = 0: d0 = sqrt(t0 x a / (3/2 k0)), d1 = sqrt(a x t1 / (3/2 k1))
    slope = 0.3
    n = unit(np.array([[-np.sin(slope), np.cos(slope), 0.0]]))
    t = np.array([np.cos(slope), np.sin(slope), 0.0])
    W = np.outer(t, t)[None]
    edges = EdgeData(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]), n, n, W, -2.0 * W)
    curves, notes = Hermite().curves(edges)
    assert notes == {}
    expected = np.sqrt(np.sin(slope) / (1.5 * np.array([1.0, 2.0])))
    assert np.ravel(legs(curves)) == pytest.approx(expected, rel=1e-13)
    # and nearly parallel, where eliminating one leg loses all digits
    turned = EdgeData(edges.p0, edges.p1, n, unit(n + np.array([1e-9, 0.0, 0.0])), W, -2.0 * W)
    assert np.ravel(legs(Hermite().curves(turned)[0])) == pytest.approx(expected, rel=1e-8)


def test_a_vanishing_curvature_at_one_end_leaves_a_solution() -> None:
    edges = arc(0.5)
    assert edges.W1 is not None
    curves, notes = Hermite().curves(dataclasses.replace(edges, W0=np.zeros((1, 3, 3))))
    assert notes == {}
    at_start, at_end = normal_curvatures(curves, edges)
    assert abs(at_start[0]) < 1e-12
    assert at_end[0] == pytest.approx(1.0, rel=1e-12)


def test_the_guard_turns_a_short_leg_into_a_fallback() -> None:
    edges = arc(np.radians(50.0))
    assert Hermite(root="worst", guard=(0.15, 0.75)).curves(edges)[1] == {}
    lopsided = legs(Hermite(root="worst").curves(edges)[0])[1] / lengths(edges)
    assert lopsided[0] < 0.15
    only_lopsided = Hermite(guard=(0.9, 1.2))
    assert only_lopsided.curves(edges)[1] == {"curves without a root": 1}


@pytest.mark.parametrize("guard", [(0.5, 0.1), (0.0, 1.0), (0.2,), (float("nan"), 1.0)])
def test_a_guard_that_is_no_interval_is_an_error(guard: tuple[float, ...]) -> None:
    with pytest.raises(SpecError, match="guard"):
        Hermite(guard=guard)


def test_uniform_speed_has_no_variation() -> None:
    along = np.array([[1.0], [0.0]])
    assert speed_variation(np.full((2, 1, 1), 1.0 / 3.0), along, along, along)[0, 0] < 1e-7
    assert speed_variation(np.array([[[0.2]], [[0.5]]]), along, along, along)[0, 0] > 0.1


def random_space_cubics(count: int = 500) -> tuple[Float, EdgeData, Float]:
    """Cubics with random control points, normals across their end tangents, and their normal curvatures (2, E)."""
    rng = np.random.default_rng(11)
    curves = rng.normal(size=(count, 4, 3))
    n0, n1 = (
        unit(cross(leg, rng.normal(size=(count, 3))))
        for leg in (curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2])
    )
    edges = EdgeData(curves[:, 0], curves[:, 3], n0, n1, None, None)
    # of normal_curvatures the sign is that of II
    return curves, edges, -np.stack(normal_curvatures(curves, edges))


def test_the_end_equations_hold_on_space_cubics_and_the_printed_first_one_does_not() -> None:
    curves, edges, k = random_space_cubics()
    assert edges.n0 is not None
    assert edges.n1 is not None
    t0, t1, chord = unit(curves[:, 1] - curves[:, 0]), unit(curves[:, 3] - curves[:, 2]), edges.p1 - edges.p0
    d = np.stack(legs(curves))
    linear, square, constant = end_equations((t0, t1), (edges.n0, edges.n1), chord, k)
    assert np.abs(linear * d + square * d[::-1] ** 2 - constant).max() < 1e-12
    # Mann 1992, section 2.4.4, as printed: <n1, t0> d0 = <n1, p0 - p1> - 3/2 k1 d1^2, and the second
    first = dot(edges.n1, t0) * d[0] - (dot(edges.n1, -chord) - 1.5 * k[1] * d[1] ** 2)
    second = dot(edges.n0, t1) * d[1] - (dot(edges.n0, chord) - 1.5 * k[0] * d[0] ** 2)
    assert np.median(np.abs(first)) > 0.1
    assert np.abs(second).max() < 1e-12


def test_in_a_plane_the_space_curve_is_the_planar_one() -> None:
    for angle in (0.3, 1.0, np.pi / 2, 2.0):
        for root in ("best", "worst"):
            space, planar = (curve(root=root).curves(arc(angle))[0] for curve in (HermiteSpace, Hermite))
            assert norm(space - planar).max() < 1e-9


def test_space_curves_without_a_solution_are_projected_and_counted() -> None:
    edges = arc(0.5)
    assert edges.W0 is not None
    assert edges.W1 is not None
    bent_away = EdgeData(edges.p0, edges.p1, edges.n0, edges.n1, -edges.W0, -edges.W1)
    curves, notes = HermiteSpace().curves(bent_away)
    assert notes == {"curves without a root": 1}
    assert np.array_equal(curves, Projected().curves(bent_away)[0])
    assert HermiteSpace(guard=(0.9, 1.2)).curves(edges)[1] == {"curves without a root": 1}


def test_piper_legs_are_projections_of_a_third_of_the_chord_and_shorter_than_projected_ones() -> None:
    edges = sampled_edges()
    assert edges.n0 is not None
    assert edges.n1 is not None
    curves, projected = PiperCurve().curves(edges)[0], Projected().curves(edges)[0]
    first, last = curves[:, 1] - curves[:, 0], curves[:, 3] - curves[:, 2]
    third = (edges.p1 - edges.p0) / 3.0
    assert norm(first - tangential(third, edges.n0)).max() < 1e-15
    assert norm(last - tangential(third, edges.n1)).max() < 1e-15
    for short, full in zip(legs(curves), legs(projected), strict=True):
        assert (short < full).all()
    for leg, direction in ((first, projected[:, 1] - edges.p0), (last, edges.p1 - projected[:, 2])):
        assert norm(cross(unit(leg), unit(direction))).max() < 1e-13


def test_walton_meek_on_a_right_angle_and_its_legs_with_equal_normals() -> None:
    # c = 0, <n0, a> = -1, <n1, a> = 1 on the unit circle: rho = -3, sigma = 3, leg (6 a + 6 n0 + 3 n1) / 18
    curve = WaltonMeekCurve().curves(arc(np.pi / 2))[0][0]
    assert curve[1] == pytest.approx([1.0, 0.5, 0.0], abs=1e-15)
    # with n0 = n1 on both ends: leg (a - 2 <n, a> n + <n, a> n) / 3, the projection of a third of the chord
    edges = sampled_edges()
    level = EdgeData(edges.p0, edges.p1, edges.n0, edges.n0, None, None)
    assert norm(WaltonMeekCurve().curves(level)[0] - PiperCurve().curves(level)[0]).max() < 1e-15


@pytest.mark.parametrize("degrees", [1.0, 45.0, 90.0, 170.0])
def test_a_conic_over_an_arc_is_the_circle_and_its_cubic_that_of_an_arc(degrees: float) -> None:
    edges = arc(np.radians(degrees), radius=2.0)
    frame = planar_frame(edges)
    conics = edge_conics(frame)
    middle, w, t = conics.middle(edges, frame), conics.weight[0], np.linspace(0.0, 1.0, 9)[:, None]
    assert w == pytest.approx(np.cos(np.radians(degrees / 2.0)), rel=1e-12)
    weights = np.concatenate([(1.0 - t) ** 2, 2.0 * w * t * (1.0 - t), t**2], axis=1)
    points = weights @ np.concatenate([edges.p0, middle, edges.p1]) / weights.sum(axis=1, keepdims=True)
    assert norm(points) == pytest.approx(2.0, rel=1e-13)
    assert norm(ConicCurve().curves(edges)[0] - Circular().curves(edges)[0]).max() < 1e-12


def test_a_conic_curve_passes_through_the_shoulder_of_the_conic() -> None:
    edges = sampled_edges()
    frame = planar_frame(edges)
    conics = edge_conics(frame)
    assert conics.exists.all()
    middle, w = conics.middle(edges, frame), conics.weight[:, None]
    shoulder = (edges.p0 + 2.0 * w * middle + edges.p1) / (2.0 + 2.0 * w)
    curves, notes = ConicCurve().curves(edges)
    assert notes == {}
    assert norm((curves * np.array([1.0, 3.0, 3.0, 1.0])[:, None]).sum(axis=1) / 8.0 - shoulder).max() < 1e-14
    for leg, normal in ((middle - edges.p0, edges.n0), (middle - edges.p1, edges.n1)):
        assert normal is not None
        assert np.abs(dot(leg, normal)).max() < 1e-14


def test_edges_with_an_inflection_or_bent_at_one_end_have_no_conic_and_are_planar() -> None:
    chord = np.array([[1.0, 0.0, 0.0]])
    slopes = [(0.3, 0.3), (0.3, 0.2), (0.3, 0.0), (0.3, -0.01)]
    normals = [unit(np.array([[-s0, 1.0, 0.0], [-s1, 1.0, 0.0]])) for s0, s1 in slopes]
    n0, n1 = (np.stack([pair[end] for pair in normals]) for end in (0, 1))
    edges = EdgeData(np.zeros((4, 3)), np.repeat(chord, 4, axis=0), n0, n1, None, None)
    curves, notes = ConicCurve().curves(edges)
    assert notes == {"curves without a conic": 4}
    assert np.array_equal(curves, Planar().curves(edges)[0])


def objective(turn: Float, offsets: Float, k: Float, s: Float) -> Float:
    """Mann 1994, equations 8 to 10."""
    kappa = 2.0 * (3.0 * offsets - s[::-1] * turn) / s**2
    total: Float = ((s - 1.0) ** 2 + (kappa - k) ** 2).sum(axis=0)
    return total


def test_optimized_speeds_are_a_minimum_no_higher_than_uniform_speed() -> None:
    rng = np.random.default_rng(5)
    angle = rng.uniform(-0.4, 0.4, (2, 500))
    turn, offsets = np.sin(angle[1] - angle[0]), np.stack([-np.sin(angle[0]), np.sin(angle[1])])
    k = rng.normal(size=(2, 500))
    speeds, converged = best_speeds(turn, offsets, k)
    lowest = objective(turn, offsets, k, speeds)
    assert converged.mean() > 0.99
    assert (lowest <= objective(turn, offsets, k, np.ones((2, 500))) + 1e-12)[converged].all()
    for step in 1e-3 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1]]):
        around = objective(turn, offsets, k, speeds * (1.0 + step[:, None]))
        assert (around >= lowest)[converged].all()


def test_optimized_is_hermite_where_that_has_uniform_speed() -> None:
    edges = arc(0.05)
    assert norm(Optimized().curves(edges)[0] - Hermite().curves(edges)[0]).max() < 1e-4 * 0.05


def test_optimized_keeps_legs_long_where_hermite_has_none() -> None:
    mesh = registry.dataset("torus").mesh(0)
    short = Hermite().network(mesh)
    curves = Optimized().network(mesh)
    assert curves.notes == {}
    chord = lengths(mesh.edge_data)
    least = min((leg / chord).min() for leg in legs(curves.control_points))
    assert least > 0.15
    assert least > min((leg / chord).min() for leg in legs(short.control_points))


def test_a_frame_turns_by_a_right_angle_and_reverses_with_the_edge() -> None:
    edges = sampled_edges(20)
    frame, back = planar_frame(edges), planar_frame(reversed_edges(edges))
    assert np.abs(dot(frame.turned(frame.t0), frame.t0)).max() < 1e-14
    assert norm(frame.t0 + back.t1).max() < 1e-14
    assert norm(frame.across - back.across).max() < 1e-14
