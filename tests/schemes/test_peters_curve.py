"""Peters' boundary curves: which degree for which data, the parabola's middle point, the printed rule that fails."""

import numpy as np
import pytest

from testbed.errors import SpecError
from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float, cross, dot, norm, unit
from testbed_schemes.boundary_curves.peters import PetersCurve, tangent_planes_meet
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.peters import quadratic_boundary_point
from testbed_schemes.peters import is_quadratic


def edge(slope0: float, slope1: float, twist: float = 0.0) -> EdgeData:
    """The unit edge along x with end normals turned about y, by which its curve rises and falls; and about x."""
    n0 = unit(np.array([[-slope0, -twist, 1.0]]))
    n1 = unit(np.array([[-slope1, twist, 1.0]]))
    return EdgeData(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]), n0, n1, None, None)


def random_edges(count: int = 500) -> EdgeData:
    rng = np.random.default_rng(6)
    normals = unit(rng.normal(scale=0.4, size=(2, count, 3)) + np.array([0.0, 0.0, 1.0]))
    chord = rng.normal(size=(count, 3)) * [1.0, 1.0, 0.3]
    start = rng.normal(size=(count, 3))
    return EdgeData(start, start + chord, normals[0], normals[1], None, None)


def heights(edges: EdgeData) -> Float:
    """sigma_0 and sigma_1 of equation 2.11."""
    assert edges.n0 is not None
    assert edges.n1 is not None
    return np.stack([dot(edges.n0, edges.p1 - edges.p0), dot(edges.n1, edges.p0 - edges.p1)])


def third_difference(curves: Float) -> Float:
    return norm(np.diff(curves, n=3, axis=1)[:, 0])


def test_the_degree_follows_the_heights() -> None:
    edges = random_edges()
    curves, notes = PetersCurve().curves(edges)
    sigma = heights(edges)
    ratio = np.abs(sigma).min(axis=0) / np.abs(sigma).max(axis=0)
    one_sign = sigma[0] * sigma[1] > 0.0
    assert np.array_equal(is_quadratic(curves), one_sign & (ratio >= 0.2))
    assert notes == {"lopsided parabolas made cubic": int((one_sign & (ratio < 0.2)).sum())}
    others = ~is_quadratic(curves)
    assert np.array_equal(curves[others], Projected().curves(edges)[0][others])
    assert (third_difference(curves[others]) > 1e-6).all()


@pytest.mark.parametrize("twist", [0.0, 0.3])
def test_a_chord_in_both_tangent_planes_is_the_curve(twist: float) -> None:
    curves, notes = PetersCurve().curves(edge(0.0, 0.0, twist))
    assert curves[0, :, 0] == pytest.approx(np.arange(4) / 3.0)
    assert np.array_equal(curves[0, :, 1:], np.zeros((4, 2)))
    assert notes == {}


@pytest.mark.parametrize("noise", [1e-12, 1e-15])
def test_rounding_of_flat_normals_does_not_move_the_middle_of_a_straight_edge(noise: float) -> None:
    curves, notes = PetersCurve().curves(edge(noise, -0.3 * noise))
    assert curves[0, :, 0] == pytest.approx(np.arange(4) / 3.0, abs=1e-15)
    assert notes == {}


def test_the_middle_point_is_the_nearest_of_both_tangent_planes() -> None:
    edges = random_edges()
    assert edges.n0 is not None
    assert edges.n1 is not None
    middle, midpoint = tangent_planes_meet(edges), (edges.p0 + edges.p1) / 2.0
    assert np.abs(dot(middle - edges.p0, edges.n0)).max() < 1e-13
    assert np.abs(dot(middle - edges.p1, edges.n1)).max() < 1e-13
    # least norm by a general solver
    planes = np.stack([edges.n0, edges.n1], axis=1)
    off = np.stack([dot(edges.p0 - midpoint, edges.n0), dot(edges.p1 - midpoint, edges.n1)], axis=-1)
    assert middle - midpoint == pytest.approx(np.einsum("eij,ej->ei", np.linalg.pinv(planes), off), abs=1e-12)


def test_the_parabola_ends_in_its_middle_point() -> None:
    edges = random_edges()
    curves, _ = PetersCurve().curves(edges)
    parabolas = is_quadratic(curves)
    middle = tangent_planes_meet(edges)
    expected = elevate_curve(np.stack([edges.p0, middle, edges.p1], axis=1))
    assert curves[parabolas] == pytest.approx(expected[parabolas], abs=1e-14)


def test_a_least_ratio_keeps_the_middle_point_away_from_the_ends() -> None:
    """Along n0 - n1 it is within (1 - ratio) / (1 + ratio) of half the chord, for any heights and twist."""
    edges = random_edges(4000)
    assert edges.n0 is not None
    assert edges.n1 is not None
    length = norm(edges.p1 - edges.p0)
    middle = tangent_planes_meet(edges) - (edges.p0 + edges.p1) / 2.0
    along = np.abs(dot(middle, unit(edges.n0 - edges.n1))) / length
    parabolas = is_quadratic(PetersCurve().curves(edges)[0])
    assert 0.3 < along[parabolas].max() <= 0.5 * 0.8 / 1.2 + 1e-12
    assert along[~parabolas].max() > 1.0


def test_the_printed_rule_takes_parabolas_without_an_end_tangent() -> None:
    """sigma_0 sigma_1 >= 0 as printed: planar data with one height zero put the middle point into a vertex."""
    edges = edge(0.4, 0.0)
    sigma = heights(edges)
    assert sigma[0] != 0.0
    assert sigma[1] == 0.0
    assert (sigma[0] * sigma[1] >= 0.0).all()
    middle = tangent_planes_meet(edges)
    assert norm(middle - edges.p0) == pytest.approx(0.0, abs=1e-15)
    printed = elevate_curve(np.stack([edges.p0, edges.p0, edges.p1], axis=1))
    assert edges.n0 is not None
    assert edges.n1 is not None
    leg = np.array([[0.1, 0.3, 0.04]])
    assert np.isnan(quadratic_boundary_point(printed, leg, leg, edges.n0, edges.n1)).all()
    ours, notes = PetersCurve().curves(edges)
    assert np.array_equal(ours, Projected().curves(edges)[0])
    assert norm(np.diff(ours, axis=1)).min() > 0.3
    assert notes == {}
    assert np.isfinite(quadratic_boundary_point(ours, leg, leg, edges.n0, edges.n1)).all()


def test_opposite_normals_have_no_common_point_and_take_the_cubic() -> None:
    n = unit(np.array([[0.3, 0.2, 1.0]]))
    edges = EdgeData(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0]]), n, -n, None, None)
    assert norm(cross(n, -n)).max() < 1e-15
    curves, notes = PetersCurve().curves(edges)
    assert np.array_equal(curves, Projected().curves(edges)[0])
    assert notes == {"lopsided parabolas made cubic": 1}


def test_an_arc_is_flat_at_its_ends_and_sharp_in_its_middle() -> None:
    """Mann 1992, section 2.4.3; curvature 1 / 2 and sqrt 2 over a quarter of the unit circle."""
    edges = edge(1.0, -1.0)
    scaled = EdgeData(edges.p0, edges.p1 * 2**0.5, edges.n0, edges.n1, None, None)
    h = PetersCurve().curves(scaled)[0][0]
    v = np.diff(h, axis=0)
    at_start = 2.0 / 3.0 * norm(cross(v[0], v[1] - v[0])) / norm(v[0]) ** 3
    middle = 3.0 * (v[0] + 2.0 * v[1] + v[2]) / 4.0
    second = 6.0 * ((v[1] - v[0]) + (v[2] - v[1])) / 2.0
    assert float(at_start) == pytest.approx(0.5)
    assert float(norm(cross(middle, second)) / norm(middle) ** 3) == pytest.approx(2**0.5)


@pytest.mark.parametrize("ratio", [-0.1, 1.1, float("nan")])
def test_a_ratio_out_of_range_is_no_parameter(ratio: float) -> None:
    with pytest.raises(SpecError, match="ratio must be between 0 and 1"):
        PetersCurve(ratio)
