"""The quadratic interpolant: corners matched, boundaries shared, edges that bend both ways refused."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import angle_between, dot, norm, unit
from testbed_schemes.mathematics.planar_frame import planar_frame
from testbed_schemes.quadratic_interpolant import QuadraticInterpolant, tangents_meet

CONVEX = ["octahedron", "icosahedron", "sphere", "ellipsoid"]


@pytest.mark.parametrize("name", CONVEX)
@pytest.mark.parametrize("level", [0, 1])
def test_position_and_normal_are_matched_at_the_corners(name: str, level: int) -> None:
    mesh = registry.dataset(name).mesh(level)
    jet = QuadraticInterpolant().fit(mesh).batches[0].jets(CORNERS[3], 1)
    assert norm(jet.f - mesh.corner_points()).max() < 1e-14
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13


@pytest.mark.parametrize("name", CONVEX)
def test_the_middle_point_lies_in_both_tangent_planes_and_in_the_frame(name: str) -> None:
    mesh = registry.dataset(name).mesh(0)
    edges = mesh.edge_data
    middle = tangents_meet(mesh)
    assert edges.n0 is not None
    assert edges.n1 is not None
    assert np.abs(dot(middle - edges.p0, edges.n0)).max() < 1e-14
    assert np.abs(dot(middle - edges.p1, edges.n1)).max() < 1e-14
    frame = planar_frame(edges)
    across = np.cross(frame.along, frame.across)
    assert np.abs(dot(middle - edges.p0, across)).max() < 1e-14


def test_the_octahedron_has_the_cubes_corners_as_middle_points() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    assert np.allclose(np.abs(tangents_meet(mesh)), (mesh.edge_data.p0 != 0) | (mesh.edge_data.p1 != 0), atol=1e-15)


def test_an_edge_that_bends_both_ways_is_refused_by_its_vertices() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    tilted = unit(np.array([-0.3, 0.0, 1.0]))
    normals = np.array([tilted, tilted, [0.0, 0.0, 1.0]])
    with pytest.raises(Refused, match=r"no middle point .* from vertex 0 to vertex 1 of face 0"):
        QuadraticInterpolant().fit(HermiteMesh(points, [[0, 1, 2]], normals))


def test_tangents_that_meet_behind_an_end_are_refused() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0]])
    normals = unit(np.array([[-0.3, 0.0, 1.0], [-0.1, 0.0, 1.0], [0.0, 0.0, 1.0]]))
    with pytest.raises(Refused, match="vertex 0 to vertex 1"):
        QuadraticInterpolant().fit(HermiteMesh(points, [[0, 1, 2]], normals))


def test_the_message_counts_the_edges_on_the_monkey_saddle() -> None:
    with pytest.raises(Refused, match=r"for 3 of 42 edges"):
        QuadraticInterpolant().fit(registry.dataset("monkey-saddle").mesh(0))


def test_flat_data_give_straight_edges() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.0, 0.0]])
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    mesh = HermiteMesh(points @ rotation.T + 3.0, [[0, 1, 2]], np.broadcast_to(rotation[:, 2], (3, 3)))
    jet = QuadraticInterpolant().fit(mesh).batches[0].jets(lattice(3, 4))
    assert norm(jet.fuu).max() < 1e-13
    assert np.abs(dot(jet.f - mesh.points[0], rotation[:, 2])).max() < 1e-14


def test_the_distance_to_a_sphere_falls_with_the_claimed_order_at_least() -> None:
    dataset = registry.dataset("octahedron")
    off = [
        np.abs(norm(QuadraticInterpolant().fit(dataset.mesh(level)).batches[0].jets(lattice(3, 6), 0).f) - 1.0).max()
        for level in (1, 2, 3)
    ]
    assert np.log2(np.divide(off[:-1], off[1:])).min() > 2.9
