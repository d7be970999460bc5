from typing import Any

import numpy as np
import pytest
from built_surfaces import bumpy_octahedron, exact_cap, flat, octahedron, place

from testbed.conformance.meshes import perturbed_icosahedron
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.surface import Part, Surface
from testbed.measures.continuity import Continuity
from testbed.measures.edge_angles import edge_angles
from testbed.measures.exact_continuity import FIRST, ExactContinuity
from testbed.plugins.measure import Survey, measure_all
from testbed.registry import dataset, scheme

SCHEMES = ("cubic-interpolant", "pn-triangle", "quadratic-interpolant", "flat", "shirman-sequin")


def exact(surface: Surface) -> dict[str, Any]:
    return dict(ExactContinuity().measure(Survey(surface)))


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("mesh", ["icosahedron", "torus"])
def test_it_is_the_largest_of_all_edges_and_not_below_the_sampled_one(name: str, mesh: str) -> None:
    surface = scheme(name).fit(perturbed_icosahedron() if mesh == "icosahedron" else dataset("torus").mesh(1))
    found, angles = exact(surface), edge_angles(surface)
    assert len(angles) > FIRST or mesh == "icosahedron"
    # where all is rounding, samples differ
    largest = np.degrees(angles.angle.max())
    assert found["epsilon_exact_deg"] == pytest.approx(largest, rel=1e-13, abs=1e-13)
    sampled = Continuity().measure(Survey(surface))["epsilon_deg"]
    assert isinstance(sampled, float)
    assert found["epsilon_exact_deg"] >= sampled - 1e-11
    assert found["epsilon_low_deg"] <= found["epsilon_exact_deg"] <= found["epsilon_high_deg"]
    assert found["epsilon_high_deg"] - found["epsilon_low_deg"] <= 1e-8 * found["epsilon_exact_deg"] + 1e-9
    assert found["epsilon_low_deg"] <= np.degrees(angles.high.max())
    assert found["epsilon_high_deg"] >= np.degrees(angles.low.max())


def test_the_angle_is_where_it_is_said_to_be() -> None:
    surface = bumpy_octahedron(3)
    found, sampled = exact(surface), Continuity().measure(Survey(surface))
    assert found["epsilon_exact_face"] == sampled["epsilon_face"]
    np.testing.assert_allclose(place(found["epsilon_exact_bary"]), place(sampled["epsilon_bary"]), atol=1e-5)


def test_the_flat_octahedron_has_its_dihedral_angle() -> None:
    assert exact(octahedron())["epsilon_exact_deg"] == pytest.approx(np.degrees(np.arccos(1.0 / 3.0)), abs=1e-13)


def test_patches_of_one_sphere_are_smooth_with_a_guarantee() -> None:
    assert exact(exact_cap())["epsilon_high_deg"] < 1e-8


def test_of_blended_patches_there_are_no_such_columns() -> None:
    surface = scheme("nielson").fit(perturbed_icosahedron())
    assert exact(surface) == {}
    assert not any(name.startswith("epsilon_exact") for name in measure_all([ExactContinuity()], surface, None))


def test_without_edges_between_patches_there_is_no_angle() -> None:
    found = exact(flat(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=np.float64), np.array([[0, 1, 2]])))
    assert found["epsilon_exact_deg"] == found["epsilon_high_deg"] == 0.0
    assert found["epsilon_exact_face"] == -1
    assert found["epsilon_exact_bary"] == ""


def test_a_control_point_that_is_not_finite_is_never_a_pass() -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[3, 1] = np.nan
    found = exact(Surface.over_faces(surface.mesh, BezierTriangles(points)))
    for name in ("epsilon_exact_deg", "epsilon_low_deg", "epsilon_high_deg"):
        assert np.isnan(found[name])


def test_the_order_of_patches_does_not_matter() -> None:
    for whole in (bumpy_octahedron(), octahedron(), scheme("pn-triangle").fit(dataset("torus").mesh(1))):
        part = whole.parts[0]
        order = np.random.default_rng(2).permutation(len(part.batch))
        shuffled = Part(part.batch.take(order), part.corner_ids[order], part.faces[order], part.corners_in_face[order])
        assert exact(Surface(whole.mesh, (shuffled,))) == exact(whole)
