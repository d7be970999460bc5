"""What studies look for: columns, numbers derived from them, and the curvatures of exact surfaces."""

import math

import pytest

from testbed.errors import SpecError
from testbed.harness.objectives import curvature_extremes, exact_extremes, measures_for, objective
from testbed.registry import dataset

ROW = {"gauss_min": 0.5, "gauss_max": 1.5, "mean_min": 0.75, "mean_max": 1.125, "where": "here"}
SPHERE = {"gauss_min": 1.0, "gauss_max": 1.0, "mean_min": 1.0, "mean_max": 1.0}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("gauss_spread", 1.0),
        ("mean_spread", 0.375),
        ("gauss_ratio", 3.0),
        ("gauss_error", 0.5),
        ("mean_error", 0.25),
        ("gauss_max", 1.5),
    ],
)
def test_derived_quantities_and_columns(name: str, value: float) -> None:
    assert objective(name).value(ROW, SPHERE) == value


def test_what_is_not_defined_has_no_value() -> None:
    assert math.isnan(objective("gauss_ratio").value(ROW | {"gauss_min": -0.5}, {}))
    assert math.isnan(objective("gauss_spread").value({"gauss_min": 1.0}, {}))
    assert math.isnan(objective("gauss_error").value(ROW | {"gauss_max": math.nan}, SPHERE))
    assert math.isnan(objective("gauss_error").value(ROW | {"gauss_min": math.nan}, SPHERE))


def test_texts_and_unknown_names_are_refused() -> None:
    with pytest.raises(SpecError, match="where is a text"):
        objective("where").value(ROW, {})
    with pytest.raises(SpecError, match="did you mean gauss_spread"):
        objective("gauss_spred")


def test_only_the_measures_needed_are_asked() -> None:
    assert measures_for([objective("gauss_spread")]) == ["curvature"]
    assert set(measures_for([objective("total"), objective("mean_max")])) == {"curvature", "sums"}


def test_the_exact_curvatures_of_a_sphere_and_of_a_torus() -> None:
    ball = dataset("octahedron[radius=2]")
    assert ball.surface is not None
    found = curvature_extremes(ball.surface, ball.mesh(0))
    assert found == pytest.approx({"gauss_min": 0.25, "gauss_max": 0.25, "mean_min": 0.5, "mean_max": 0.5}, rel=1e-14)
    ring = dataset("torus[major=2,minor=0.5]")
    assert ring.surface is not None
    # K = cos t / (r (R + r cos t)), H = (1/r + cos t / (R + r cos t)) / 2
    expected = {
        "gauss_min": -1 / 0.75,
        "gauss_max": 1 / 1.25,
        "mean_min": (2 - 1 / 1.5) / 2,
        "mean_max": (2 + 1 / 2.5) / 2,
    }
    for level in (0, 1):
        assert curvature_extremes(ring.surface, ring.mesh(level)) == pytest.approx(expected, rel=1e-3)


def test_the_exact_surface_is_asked_for_where_it_is_needed_only() -> None:
    spread, error, distance = (objective(name) for name in ("gauss_spread", "gauss_error", "distance_max"))
    assert exact_extremes("grid[forms=false]", 0, [spread]) == {}
    assert exact_extremes("grid", 0, [distance]) == {}
    assert exact_extremes("grid", 0, [spread, error]) == dict.fromkeys(SPHERE, 0.0)
    for one in (error, distance):
        with pytest.raises(SpecError, match="has none"):
            exact_extremes("grid[forms=false]", 0, [one])
    with pytest.raises(SpecError, match="level 9"):
        exact_extremes("grid", 9, [error])
