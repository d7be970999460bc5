"""Nagata's patch: the published vector, corners matched where it exists, straight edges counted where it does not."""

import numpy as np
import pytest

import testbed
from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import EdgeData, HermiteMesh
from testbed.geometry.vectors import Float, angle_between, dot, norm, unit
from testbed_schemes.boundary_curves.peters import PetersCurve
from testbed_schemes.mathematics.planar_frame import edge_normals
from testbed_schemes.nagata import Nagata, curvature_vectors

MESHES = ["octahedron", "icosahedron", "torus", "graph", "monkey-saddle", "hyperboloid"]


def one_edge(n0: Float, n1: Float) -> EdgeData:
    points = np.array([[[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]]])
    return EdgeData(points[0], points[1], unit(n0)[None], unit(n1)[None], None, None)


def step(slope: float, tilt: float = 0.0) -> HermiteMesh:
    """One face with two vertices whose normals lean back against the edge between them, the second also sideways."""
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]])
    normals = unit(np.array([[-slope, 0.0, 1.0], [-slope, tilt, 1.0], [0.0, 0.0, 1.0]]))
    return HermiteMesh(points, [[0, 1, 2]], normals)


@pytest.mark.parametrize("name", MESHES)
def test_position_and_normal_are_matched_at_the_corners(name: str) -> None:
    mesh = registry.dataset(name).mesh(1)
    surface = Nagata().fit(mesh)
    jet = surface.batches[0].jets(CORNERS[3], 1)
    assert not surface.notes
    assert norm(jet.f - mesh.corner_points()).max() < 1e-14
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13


@pytest.mark.parametrize("name", MESHES)
def test_the_vector_is_the_published_combination_of_the_normals(name: str) -> None:
    edges = registry.dataset(name).mesh(0).edge_data
    n0, n1 = edge_normals(edges)
    d, a = edges.p1 - edges.p0, dot(n0, n1)
    alpha, beta = np.stack([dot(n0, d) + a * dot(n1, d), -dot(n1, d) - a * dot(n0, d)]) / (1.0 - a**2)
    c, straight = curvature_vectors(edges, 1e-6)
    assert not straight.any()
    assert norm(c - alpha[:, None] * n0 - beta[:, None] * n1).max() < 1e-12


@pytest.mark.parametrize("name", MESHES)
def test_the_middle_point_is_the_nearest_to_the_midpoint_in_both_tangent_planes(name: str) -> None:
    edges = registry.dataset(name).mesh(0).edge_data
    n0, n1 = edge_normals(edges)
    midpoint = (edges.p0 + edges.p1) / 2.0
    planes = np.stack([n0, n1], axis=1)
    heights = np.stack([dot(edges.p0 - midpoint, n0), dot(edges.p1 - midpoint, n1)], axis=1)
    nearest = midpoint + np.einsum("eij,ej->ei", np.linalg.pinv(planes), heights)
    c, _ = curvature_vectors(edges, 1e-6)
    assert norm(midpoint - c / 2.0 - nearest).max() < 1e-12


@pytest.mark.parametrize("name", ["octahedron", "icosahedron"])
def test_the_curves_are_peters_parabolas(name: str) -> None:
    mesh = registry.dataset(name).mesh(0)
    cubics = PetersCurve().network(mesh).along_sides()
    middle = Nagata().fit(mesh).batches[0].control_points[:, [1, 4, 2]]  # type: ignore[attr-defined]
    assert norm(0.5 * (3.0 * cubics[:, :, 1] - cubics[:, :, 0]) - middle).max() < 1e-12


def test_nearly_parallel_normals_lose_no_digits() -> None:
    # a circle of radius 1e6: 2 c = x'' = -L^2 / R; the difference 1 - a has four digits here
    n0, n1 = np.array([-0.5e-6, 0.0, 1.0]), np.array([0.5e-6, 0.0, 1.0])
    c, straight = curvature_vectors(one_edge(n0, n1), 1e-7)
    assert not straight.any()
    assert abs(c[0, 2] / -0.5e-6 - 1.0) < 1e-9


def test_parallel_normals_across_a_step_leave_the_edge_straight_and_are_counted() -> None:
    surface = Nagata().fit(step(0.5))
    assert dict(surface.notes) == {"edges left straight": 1}
    jet = surface.batches[0].jets(np.array([[0.5, 0.0]]))
    assert norm(jet.fuu).max() < 1e-15
    assert surface.mesh.normals is not None
    off = np.degrees(angle_between(surface.batches[0].jets(CORNERS[3], 1).normal[0], surface.mesh.normals))
    assert off.max() > 20.0  # what the claim to match normals does not cover


def test_opposite_normals_leave_the_edge_straight_too() -> None:
    _, straight = curvature_vectors(one_edge(np.array([0.1, 0.0, 1.0]), np.array([-0.1, 0.0, -1.0])), 1e-6)
    assert straight.all()


def test_parallel_normals_on_a_plane_are_no_fallback() -> None:
    surface = Nagata().fit(step(0.0))
    assert not surface.notes


def test_nearly_parallel_normals_fold_and_are_refused_and_a_larger_threshold_takes_them() -> None:
    mesh = step(0.5, 0.02)
    with pytest.raises(Refused, match=r"vertex [01] of face 0"):
        Nagata().fit(mesh)
    assert dict(Nagata(parallel=0.1).fit(mesh).notes) == {"edges left straight": 1}


def test_the_normals_jump_by_39_degrees_on_the_octahedron() -> None:
    surface = Nagata().fit(registry.dataset("octahedron").mesh(0))
    one, other = surface.edge_jets(surface.edges, np.linspace(0.0, 1.0, 101), 1)
    assert np.degrees(angle_between(one.normal, other.normal).max()) == pytest.approx(38.9, abs=0.1)


@pytest.mark.parametrize("parallel", [-1e-9, 1.0])
def test_the_threshold_is_a_sine(parallel: float) -> None:
    with pytest.raises(SpecError, match="parallel is a sine"):
        testbed.scheme(f"nagata[parallel={parallel}]")
