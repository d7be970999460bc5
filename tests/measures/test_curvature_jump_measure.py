"""The curvature jump reads off what second derivatives jump by, wherever it is, and nothing where there is none."""

from typing import Any

import numpy as np
import pytest
from built_surfaces import UnitSphere, bumpy_octahedron, exact_cap, flat, graph, octahedron, place

from testbed.conformance.meshes import cases, perturbed_icosahedron
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.continuity import interior_edges
from testbed.measures.curvature_jump import CurvatureJump, curvature_jumps, diameter, jump_parameters
from testbed.plugins.measure import Survey
from testbed.registry import scheme

TWO = np.array([[0, 1, 2], [1, 0, 3]])
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.2, 1.0], [0.7, -1.0]])


def jump(surface: Surface, **settings: Any) -> dict[str, Any]:
    return dict(CurvatureJump(**settings).measure(Survey(surface)))


def roof(height: float) -> Surface:
    """Flat for y >= 0, and h y^2 for y < 0: the curvature across the edge jumps from 0 to -2 h."""
    return graph(lambda _, y: np.where(y < 0.0, height * y * y, 0.0), 2, CORNERS, TWO)


@pytest.mark.parametrize("height", [1e-6, 0.3, 5.0])
def test_a_jump_of_curvature_reads_its_size(height: float) -> None:
    surface = roof(height)
    # the form has the only entry 2 h, and is relative to that and one over the diameter
    expected = 2.0 * height / (2.0 * height + 1.0 / diameter(surface.mesh))
    assert jump(surface)["curvature_jump_max"] == pytest.approx(expected, rel=1e-9)


def test_the_normals_of_such_an_edge_agree_all_the_same() -> None:
    surface = roof(0.3)
    left, right = surface.edge_jets(interior_edges(surface), np.linspace(0, 1, 9), 1)
    np.testing.assert_allclose(left.normal, right.normal, atol=1e-15)


def test_the_largest_jump_is_found_between_the_samples() -> None:
    """The curvature across is 2 x^2 (1 - x) for y < 0: largest at x = 2/3, where it is 8/27."""
    surface = graph(lambda x, y: np.where(y < 0.0, y * y * x**2 * (1.0 - x), 0.0), 5, CORNERS, TWO)
    found = jump(surface, budget=0)
    worst = 8.0 / 27.0
    assert found["curvature_jump_max"] == pytest.approx(worst / (worst + 1.0 / diameter(surface.mesh)), rel=1e-10)
    np.testing.assert_allclose(place(found["curvature_jump_bary"]), [1 / 3, 2 / 3, 0.0], atol=1e-5)
    assert found["curvature_jump_face"] == 0


def test_patches_of_one_sphere_have_none() -> None:
    assert jump(exact_cap(3))["curvature_jump_max"] < 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_maxima_reach_those_of_a_fifty_times_denser_sampling(seed: int) -> None:
    surface = bumpy_octahedron(seed)
    dense = curvature_jumps(surface, interior_edges(surface), np.arange(1001) / 1000.0)
    assert jump(surface)["curvature_jump_max"] >= dense.max() * (1.0 - 1e-12)


@pytest.mark.parametrize("case", [case for case in cases(3) if len(case.mesh.faces) > 1], ids=lambda case: case.name)
@pytest.mark.parametrize("spec", ["hagen-pottmann", "hagen-pottmann[tangents=arc,mu=0.3]"])
def test_a_curvature_continuous_scheme_has_none_on_any_mesh_of_the_suite(spec: str, case: Any) -> None:
    assert jump(scheme(spec).fit(case.mesh))["curvature_jump_max"] < 1e-7


@pytest.mark.parametrize("spec", ["nielson", "triangular-gregory", "shirman-sequin", "cubic-interpolant"])
def test_schemes_of_lower_continuity_have_one(spec: str) -> None:
    assert jump(scheme(spec).fit(perturbed_icosahedron()))["curvature_jump_max"] > 0.1


def test_a_surface_without_edges_between_patches_has_nothing_that_jumps() -> None:
    found = jump(flat(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64), np.array([[0, 1, 2]])))
    assert found == {"curvature_jump_max": 0.0, "curvature_jump_face": -1, "curvature_jump_bary": ""}


def broken(surface: Surface, bad: float) -> Surface:
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[2, 0, 0] = bad
    return Surface.over_faces(surface.mesh, BezierTriangles(points))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_control_point_that_is_not_finite_is_never_a_pass(bad: float) -> None:
    found = jump(broken(octahedron(), bad))
    assert np.isnan(found["curvature_jump_max"])
    assert found["curvature_jump_face"] >= 0


@pytest.mark.parametrize("scale", [1e-3, 1.0, 700.0])
def test_it_has_no_unit(scale: float) -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    scaled = Surface.over_faces(
        HermiteMesh(scale * surface.mesh.points, surface.mesh.faces), BezierTriangles(scale * batch.control_points)
    )
    assert jump(scaled)["curvature_jump_max"] == pytest.approx(jump(surface)["curvature_jump_max"], rel=1e-10)


def test_a_budget_bounds_the_edges_that_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    surface = scheme("nielson").fit(perturbed_icosahedron())
    looked_at: list[tuple[int, int]] = []

    def counting(surface: Surface, edges: Any, t: Float) -> Float:
        looked_at.append((len(edges), t.shape[-1]))
        return curvature_jumps(surface, edges, t)

    monkeypatch.setattr("testbed.measures.curvature_jump.curvature_jumps", counting)
    few = jump(surface, budget=50, candidates=1)
    assert looked_at[0] == (10, 5)
    assert len(looked_at) > 1
    looked_at.clear()
    all_ = jump(surface, budget=600, candidates=1)
    assert looked_at[0] == (30, 20)
    assert 0.0 < few["curvature_jump_max"] <= all_["curvature_jump_max"]


@pytest.mark.parametrize("margin", [0.0, 1e-3])
@pytest.mark.parametrize("intervals", [4, 5, 17, 32])
def test_parameters_are_symmetric_to_the_last_bit_and_keep_to_the_margin(intervals: int, margin: float) -> None:
    t = jump_parameters(intervals, margin)
    np.testing.assert_array_equal(1.0 - t[::-1], t)
    assert len(t) == intervals + 1
    assert t[0] == pytest.approx(margin, rel=1e-9)
    np.testing.assert_allclose(np.diff(t), (1.0 - 2.0 * margin) / intervals, rtol=1e-9)


def test_the_exact_surface_is_not_needed() -> None:
    surface = octahedron()
    assert CurvatureJump().measure(Survey(surface, UnitSphere())) == jump(surface)
