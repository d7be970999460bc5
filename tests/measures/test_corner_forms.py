"""Second fundamental forms at corners: values on polynomial patches, limits by direction on blended ones."""

import numpy as np
import pytest

from testbed.conformance.meshes import octahedron, perturbed_icosahedron
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS, corner_distance
from testbed.measures.corner_forms import DIRECTIONS, approaches, corner_forms, extrapolated
from testbed.registry import scheme


def test_polynomial_patches_are_evaluated_at_their_corners() -> None:
    batch = scheme("cubic-interpolant").fit(octahedron()).batches[0]
    found = corner_forms(batch)
    assert found.shape == (8, 3, 1, 3, 3)
    np.testing.assert_array_equal(found[:, :, 0], second_form_matrix(batch.jets(CORNERS[3])))


@pytest.mark.parametrize("spec", ["nielson", "triangular-gregory"])
def test_limits_are_those_much_nearer_to_the_corner(spec: str) -> None:
    """Values at a distance d differ from the limit in proportion to d, the limits from direction to direction."""
    batch = scheme(spec).fit(perturbed_icosahedron()).batches[0]
    limits = corner_forms(batch)
    distance = 1e-5
    at = distance * np.stack([1.0 - DIRECTIONS, DIRECTIONS], axis=1)
    near = second_form_matrix(batch.jets(at))
    assert np.abs(near - limits[:, 0]).max() < 100.0 * distance * np.abs(limits).max()
    assert np.ptp(limits, axis=2).max() > 0.1


def test_limits_of_a_curvature_continuous_scheme_are_one() -> None:
    limits = corner_forms(scheme("hagen-pottmann").fit(perturbed_icosahedron()).batches[0])
    assert np.ptp(limits, axis=2).max() < 1e-8


@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("margin", [1e-6, 1e-2])
def test_points_approach_the_corners_from_inside_and_keep_to_the_margin(sides: int, margin: float) -> None:
    at = approaches(sides, margin)
    distance = corner_distance(sides, at)
    assert (distance >= margin).all()
    np.testing.assert_allclose(distance[1:], 0.5 * distance[:-1], rtol=1e-12)
    assert (at > 0.0).all()
    assert (at < 1.0).all()
    if sides == 3:
        assert (at.sum(axis=-1) < 1.0).all()


def test_extrapolation_is_exact_for_polynomials_of_the_distance() -> None:
    h = 0.01 * 0.5 ** np.arange(5)
    values = np.stack([2.0 - h + 3.0 * h**2 + h**3, 5.0 + h**4], axis=-1)
    np.testing.assert_allclose(extrapolated(values), [2.0, 5.0], rtol=1e-15)


def test_nan_stays() -> None:
    values = np.ones((5, 2))
    values[1, 0] = np.nan
    np.testing.assert_array_equal(np.isnan(extrapolated(values)), [True, False])
