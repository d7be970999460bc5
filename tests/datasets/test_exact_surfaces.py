"""Exact surfaces against closed forms, brute force, and where there is no foot or more than one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import polynomial

from testbed.geometry.vectors import Float, norm, tangential, unit
from testbed_datasets.graph import Graph
from testbed_datasets.height_field import HeightField
from testbed_datasets.hyperboloid import Hyperboloid
from testbed_datasets.monkey_saddle import MonkeySaddle
from testbed_datasets.quadric import Quadric
from testbed_datasets.sphere import RoundSphere
from testbed_datasets.torus import RoundTorus

semi_axis = st.floats(0.2, 5.0)
coordinates = st.lists(st.tuples(*(3 * [st.floats(-6.0, 6.0)])), min_size=1, max_size=20)


def curvatures(W: Float) -> tuple[Float, Float]:
    """Gaussian and mean curvature of second fundamental forms."""
    mean: Float = 0.5 * np.trace(W, axis1=-2, axis2=-1)
    return 2.0 * mean**2 - 0.5 * np.einsum("nij,nji->n", W, W), mean


def directions(count: int = 3000) -> Float:
    return unit(np.random.default_rng(11).normal(size=(count, 3)))


def test_sphere_curvatures_are_those_of_its_radius() -> None:
    gauss, mean = curvatures(RoundSphere(2.0).second_form(2.0 * directions()))
    assert np.abs(gauss - 0.25).max() < 1e-15
    assert np.abs(mean - 0.5).max() < 1e-15


def test_torus_curvatures_in_closed_form() -> None:
    major, minor = 1.3, 0.4
    u, v = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, 2000))
    rho = major + minor * np.cos(v)
    points = np.stack([rho * np.cos(u), rho * np.sin(u), minor * np.sin(v)], axis=-1)
    surface = RoundTorus(major, minor)
    outward = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1)
    gauss, mean = curvatures(surface.second_form(points))
    assert np.abs(surface.normal(points) - outward).max() < 1e-14
    assert np.abs(gauss - np.cos(v) / (minor * rho)).max() < 1e-13
    assert np.abs(mean - (1.0 / minor + np.cos(v) / rho) / 2.0).max() < 1e-13
    for height in (-0.3, 0.0, 0.7):
        feet = surface.closest(points + height * outward)
        assert norm(feet - points).max() < 1e-14


def test_torus_has_no_foot_on_its_axis_and_core_circle() -> None:
    points = np.array([[0.0, 0.0, 0.3], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 3.0, 0.0]])
    feet = RoundTorus(1.0, 0.5).closest(points)
    assert np.isnan(feet[:4]).all()
    assert np.array_equal(feet[4], [0.0, 1.5, 0.0])


def test_sphere_has_no_foot_at_its_centre() -> None:
    assert np.isnan(RoundSphere(1.0).closest(np.zeros((1, 3)))).all()


@pytest.mark.parametrize(
    ("axes", "signs"),
    [((1.0, 2.0**0.5, 2.0), (1, 1, 1)), ((1.0, 1.3, 0.9), (1, 1, -1)), ((2.0, 0.7, 1.1), (1, -1, -1))],
)
def test_quadric_curvature_in_closed_form(axes: tuple[float, float, float], signs: tuple[int, int, int]) -> None:
    surface = Quadric(axes, signs)
    q = np.array(signs) / np.square(np.array(axes))
    points = surface.closest(1.5 * directions() * axes)
    expected = q.prod() / np.sum((q * points) ** 2, axis=1) ** 2
    gauss, _ = curvatures(surface.second_form(points))
    assert np.abs(gauss - expected).max() < 1e-14 * (1.0 + np.abs(expected).max())


@settings(max_examples=40, deadline=None, derandomize=True)
@given(axes=st.tuples(semi_axis, semi_axis, semi_axis), hyperbolic=st.booleans(), places=coordinates)
def test_quadric_feet_are_feet_and_nearest(
    axes: tuple[float, float, float], hyperbolic: bool, places: list[tuple[float, float, float]]
) -> None:
    surface, points = Quadric(axes, (1, 1, -1) if hyperbolic else (1, 1, 1)), np.array(places)
    feet = surface.closest(points)
    terms = np.square(feet / axes)
    assert (np.abs(terms @ surface.signs - 1.0) <= 1e-15 * (1.0 + terms.sum(axis=1))).all()
    assert norm(tangential(points - feet, surface.normal(feet))).max() < 1e-10
    t, u = np.meshgrid(np.linspace(-3.0, 3.0, 61), np.linspace(0.0, 2.0 * np.pi, 60))
    if hyperbolic:
        others = np.stack([np.cosh(t) * np.cos(u), np.cosh(t) * np.sin(u), np.sinh(t)], axis=-1) * axes
    else:
        others = unit(np.stack([np.cos(u), np.sin(u), np.sinh(t)], axis=-1)) * axes
    distance = norm(others.reshape(1, -1, 3) - points[:, None]).min(axis=1)
    assert (norm(feet - points) <= distance + 1e-12).all()


def test_ellipsoid_feet_near_the_plane_where_they_jump() -> None:
    # inside the evolute the foot jumps across x = 0: two feet there, mirror images just beside
    surface = Quadric((1.0, 2.0**0.5, 2.0))
    beside = np.array([[1e-200, 0.1, 0.2], [1e-12, 0.1, 0.2], [-1e-12, 0.1, 0.2]])
    feet = surface.closest(beside)
    assert norm(feet[0] - feet[1]) < 1e-11
    assert np.array_equal(feet[1], feet[2] * [-1.0, 1.0, 1.0])
    assert norm(tangential(beside - feet, surface.normal(feet))).max() < 1e-15
    assert norm(surface.closest(np.array([[0.0, 0.1, 0.2]])) - feet[0]).max() < 1e-15
    assert np.array_equal(surface.closest(np.zeros((1, 3))), [[1.0, 0.0, 0.0]])
    # outside the evolute there is one foot, in the plane
    assert np.array_equal(surface.closest(np.array([[0.0, 0.0, 5.0]])), [[0.0, 0.0, 2.0]])


def test_hyperboloid_bends_both_ways_everywhere() -> None:
    mesh = Hyperboloid().mesh(2)
    assert mesh.second_forms is not None
    gauss, _ = curvatures(mesh.second_forms)
    assert gauss.max() < -0.1


def test_no_edge_of_the_hyperboloid_comes_near_to_a_line_on_it() -> None:
    for level in range(4):
        data = Hyperboloid().mesh(level).edge_data
        assert data.n0 is not None
        assert data.W0 is not None
        u = unit(tangential(data.p1 - data.p0, data.n0))
        along = np.einsum("ni,nij,nj->n", u, data.W0, u)
        assert np.abs(along / np.linalg.norm(data.W0, axis=(1, 2))).min() > 0.1


@pytest.mark.parametrize("surface", [Graph().surface, Graph(height=3.0, bowl=0.0).surface, MonkeySaddle().surface])
def test_height_field_against_another_polynomial_evaluation(surface: HeightField) -> None:
    width = max(map(len, surface.coefficients))
    table = np.array([[*row, *[0.0] * (width - len(row))] for row in surface.coefficients])
    x, y = np.random.default_rng(0).uniform(-1.2, 1.2, (2, 500))

    def derivative(along_x: int, along_y: int) -> Float:
        by_x = polynomial.polyder(table, along_x, axis=0)
        result: Float = polynomial.polyval2d(x, y, polynomial.polyder(by_x, along_y, axis=1))
        return result

    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    f, fx, fy, fxx, fxy, fyy = expected = [derivative(*order) for order in orders]
    assert np.abs(np.array(surface.jet(x, y)) - np.array(expected)).max() < 1e-13
    gauss, mean = curvatures(surface.second_form(np.stack([x, y, f], axis=-1)))
    w = np.sqrt(1.0 + fx**2 + fy**2)
    assert np.abs(gauss - (fxx * fyy - fxy**2) / w**4).max() < 1e-12
    # upward normal: a bowl bends towards it, so its mean curvature is negative
    bending = (1.0 + fy**2) * fxx - 2.0 * fx * fy * fxy + (1.0 + fx**2) * fyy
    assert np.abs(mean + bending / (2.0 * w**3)).max() < 1e-12


def test_height_field_feet_where_they_are_known() -> None:
    # the paraboloid z = (x^2 + y^2)/2: the point (0, 0, 1 + s) beyond the focus at 1 has a circle of feet, below it one
    surface = HeightField(((0.0, 0.0, 0.5), (0.0,), (0.5,)))
    feet = surface.closest(np.array([[0.0, 0.0, 0.9], [0.0, 0.0, -3.0], [0.0, 0.0, 1.5], [1e-9, 0.0, 1.5]]))
    assert np.array_equal(feet[:2], np.zeros((2, 3)))
    assert np.isnan(feet[2]).all()
    assert np.abs(feet[3] - [1.0, 0.0, 0.5]).max() < 1e-8


def test_monkey_saddle_is_flat_at_vertex_zero_and_nowhere_else() -> None:
    mesh = MonkeySaddle().mesh(2)
    assert mesh.second_forms is not None
    x, y, _ = mesh.points.T
    gauss, _ = curvatures(mesh.second_forms)
    assert not mesh.points[0].any()
    assert not mesh.second_forms[0].any()
    assert np.abs(gauss + 36.0 * (x**2 + y**2) / (1.0 + 9.0 * (x**2 + y**2) ** 2) ** 2).max() < 1e-13
    assert gauss[1:].max() < 0.0


def test_graph_is_convex_by_default_and_not_without_its_bowl() -> None:
    for dataset, lowest, highest in ((Graph(), 0.02, 1.1), (Graph(height=3.0, bowl=0.0), -1.4, 0.4)):
        forms = dataset.mesh(4).second_forms
        assert forms is not None
        gauss, _ = curvatures(forms)
        assert lowest < gauss.min() < lowest + 0.2
        assert highest - 0.2 < gauss.max() < highest


def test_quadrics_of_revolution_have_a_foot_on_their_axis() -> None:
    # a circle of feet equally near: one of them
    barrel, waist = Quadric((1.0, 1.0, 2.0)), Quadric((1.0, 1.0, 1.0), (1, 1, -1))
    for surface, point, distance in ((barrel, [0.0, 0.0, 0.5], 0.9574271077563381), (waist, [0.0, 0.0, 0.0], 1.0)):
        feet = surface.closest(np.array([point]))
        assert norm(feet - point)[0] == pytest.approx(distance, rel=1e-14)
        assert np.abs(tangential(point - feet, surface.normal(feet))).max() < 1e-15


def test_hyperboloid_feet_outside_its_focal_circle_are_a_pair() -> None:
    # in the plane of the waist, beyond its centres of curvature, the feet go up and down
    surface = Quadric((1.0, 1.0, 1.0), (1, 1, -1))
    inner, outer = surface.closest(np.array([[1.9, 0.0, 0.0], [3.0, 0.0, 0.0]]))
    assert np.abs(inner - [1.0, 0.0, 0.0]).max() < 1e-15
    assert np.abs(outer - [1.5, 0.0, np.sqrt(1.25)]).max() < 1e-15
