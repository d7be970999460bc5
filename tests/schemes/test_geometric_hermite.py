"""Geometric Hermite curves, planar and in space: their equations, all roots, the choice of one, what is counted."""

import dataclasses

import numpy as np
import pytest
from edge_samples import (
    arc,
    legs,
    lengths,
    normal_curvatures,
)

from testbed import registry
from testbed.errors import SpecError
from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.hermite_space import HermiteSpace
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.mathematics.geometric_hermite import speed_variation
from testbed_schemes.mathematics.space_hermite import end_equations


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
    for curve in (Hermite, HermiteSpace):
        with pytest.raises(SpecError, match=f"{curve.name}: guard"):
            curve(guard=guard)


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
