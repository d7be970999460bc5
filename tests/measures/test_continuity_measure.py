from typing import Any

import numpy as np
import pytest
from built_surfaces import bumpy_octahedron, exact_cap, flat, graph, octahedron, place

from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float
from testbed.measures.continuity import Continuity, edge_jumps, edge_parameters
from testbed.plugins.measure import Survey

TWO = np.array([[0, 1, 2], [1, 0, 3]])


def continuity(surface: Surface, **settings: Any) -> dict[str, Any]:
    return dict(Continuity(**settings).measure(Survey(surface)))


def hinge(degrees: float) -> Surface:
    """Two triangles that share the edge from (0, 0, 0) to (1, 0, 0), bent by an angle."""
    angle = np.radians(degrees)
    points = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.6, -np.cos(angle), np.sin(angle)]], dtype=np.float64)
    return flat(points, TWO)


def moved_patch(surface: Surface, patch: int, by: Float) -> Surface:
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[patch] += by
    return Surface.over_faces(surface.mesh, BezierTriangles(points))


@pytest.mark.parametrize("degrees", [0.0, 1e-12, 1e-6, 0.05, 0.3, 30.0, 90.0, 179.0])
def test_a_crease_reads_its_angle(degrees: float) -> None:
    found = continuity(hinge(degrees))
    assert found["epsilon_deg"] == pytest.approx(degrees, rel=1e-12, abs=1e-14)
    assert found["gap_max"] == 0.0
    assert found["interior_edges"] == 1
    assert found["edges_above_0p057_deg"] == float(degrees > 0.057)
    assert found["edges_above_0p1_deg"] == float(degrees > 0.1)
    assert found["edges_above_0p5_deg"] == float(degrees > 0.5)
    assert found["edges_above_1_deg"] == float(degrees > 1.0)


def test_a_fold_reads_180_degrees() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.6, 1, 0]], dtype=np.float64)
    assert continuity(flat(points, TWO))["epsilon_deg"] == pytest.approx(180.0, abs=1e-12)


def test_the_flat_octahedron_has_its_dihedral_angle() -> None:
    found = continuity(octahedron())
    assert found["epsilon_deg"] == pytest.approx(np.degrees(np.arccos(1.0 / 3.0)), abs=1e-12)
    assert found["interior_edges"] == 12


def test_patches_of_one_sphere_join_smoothly() -> None:
    found = continuity(exact_cap(3))
    assert found["epsilon_deg"] < 1e-12
    assert found["gap_max"] < 1e-15
    assert found["interior_edges"] == 21


def test_an_offset_seam_reads_its_gap_and_no_angle() -> None:
    found = continuity(moved_patch(hinge(0.0), 1, np.array([0.0, 0.0, 1e-3])))
    assert found["gap_max"] == pytest.approx(1e-3, rel=1e-12)
    assert found["epsilon_deg"] == 0.0


def bent_seam() -> Surface:
    """Flat for y >= 0; for y < 0 the slope across the edge is x^2 (1 - x): largest at x = 2/3, where it is 4/27."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 1.0], [0.7, -1.0]])
    return graph(lambda x, y: np.where(y < 0.0, y * x**2 * (1.0 - x), 0.0), 4, corners, TWO)


@pytest.mark.parametrize("budget", [0, 60_000])
def test_the_largest_angle_is_found_between_the_samples(budget: int) -> None:
    found = continuity(bent_seam(), budget=budget)
    assert found["epsilon_deg"] == pytest.approx(np.degrees(np.arctan(4.0 / 27.0)), rel=1e-11)
    np.testing.assert_allclose(place(found["epsilon_bary"]), [1 / 3, 2 / 3, 0.0], atol=1e-5)
    assert found["epsilon_face"] == 0


@pytest.mark.parametrize("seed", range(3))
def test_maxima_reach_those_of_a_fifty_times_denser_sampling(seed: int) -> None:
    surface = bumpy_octahedron(seed)
    found = continuity(surface)
    angle, gap = edge_jumps(surface, surface.edges, np.arange(2001) / 2000.0)
    assert found["epsilon_deg"] >= np.degrees(angle.max())
    assert found["gap_max"] >= gap.max()


def test_inner_edges_of_split_faces_count() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64)
    peak = np.array([1 / 3, 1 / 3, 0.5])
    nets = np.stack([np.stack([points[(i + 1) % 3], points[(i + 2) % 3], peak]) for i in range(3)])
    found = continuity(Surface.over_split_faces(HermiteMesh(points, np.array([[0, 1, 2]])), BezierTriangles(nets)))
    assert found["interior_edges"] == 3
    assert found["epsilon_deg"] > 30.0


def test_a_surface_without_edges_between_patches_has_nothing_that_jumps() -> None:
    found = continuity(flat(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64), np.array([[0, 1, 2]])))
    assert found["interior_edges"] == 0
    assert found["epsilon_deg"] == found["gap_max"] == found["edges_above_1_deg"] == 0.0
    assert found["epsilon_face"] == -1
    assert found["epsilon_bary"] == ""


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_control_point_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    found = continuity(moved_patch(octahedron(), 2, np.array([bad, 0.0, 0.0])))
    for name in ("epsilon_deg", "gap_max", "edges_above_0p057_deg", "edges_above_1_deg"):
        assert not np.isfinite(found[name])


def test_a_collapsed_corner_has_no_normal_and_so_no_angle() -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[0, 1] = points[0, 0]
    found = continuity(Surface.over_faces(surface.mesh, BezierTriangles(points)))
    assert np.isnan(found["epsilon_deg"])
    assert np.isfinite(found["gap_max"])


@pytest.mark.parametrize("edges", [0, 1, 100, 5_000, 100_000])
def test_edge_samples_are_symmetric_to_the_last_bit_and_no_coarser_than_ten_points(edges: int) -> None:
    t = edge_parameters(edges, 120_000)
    np.testing.assert_array_equal(1.0 - t[::-1], t)
    assert t[0] == 0.0
    assert np.diff(t).max() < 1.0 / 9.0 + 1e-12
    assert len(t) >= 14
    np.testing.assert_allclose(t[1:3], [1e-3, 1e-2], rtol=1e-9)


def test_patches_may_stand_in_several_parts() -> None:
    whole = bumpy_octahedron()
    batch, mesh = whole.batches[0], whole.mesh
    corners = np.broadcast_to(CORNERS[3], (4, 3, 2))
    parts = tuple(
        Part(batch.take(np.array(some)), mesh.faces[some], np.array(some), corners)
        for some in ([7, 1, 4, 2], [0, 3, 5, 6])
    )
    assert continuity(Surface(mesh, parts)) == continuity(whole)
