"""Boundary curves whose legs are formulas of chord and normals: lengths and directions."""

import numpy as np
import pytest
from edge_samples import (
    arc,
    legs,
    lengths,
    reversed_edges,
    sampled_edges,
)

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import cross, dot, norm, tangential, unit
from testbed_schemes.boundary_curves.circular import Circular
from testbed_schemes.boundary_curves.piper import PiperCurve
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve
from testbed_schemes.mathematics.planar_frame import planar_frame


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


def test_a_frame_turns_by_a_right_angle_and_reverses_with_the_edge() -> None:
    edges = sampled_edges(20)
    frame, back = planar_frame(edges), planar_frame(reversed_edges(edges))
    assert np.abs(dot(frame.turned(frame.t0), frame.t0)).max() < 1e-14
    assert norm(frame.t0 + back.t1).max() < 1e-14
    assert norm(frame.across - back.across).max() < 1e-14
