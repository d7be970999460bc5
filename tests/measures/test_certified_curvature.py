from typing import Any

import numpy as np
import pytest
from built_surfaces import bumpy_octahedron, exact_cap, flat, graph, octahedron, one_graph

import testbed
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import analyse
from testbed.geometry.domain import lattice
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.certified_curvature import EXTREMES, CertifiedCurvature
from testbed.measures.curvature import CurvatureExtremes
from testbed.plugins.measure import Survey, measure_all

COLUMNS = [f"{name}_{end}" for name in EXTREMES for end in ("low", "high")]


def measured(surface: Surface, **settings: Any) -> dict[str, Any]:
    """Return the columns of the searched and of the certified extremes."""
    return measure_all([CurvatureExtremes(), CertifiedCurvature(**settings)], surface, None)


def scale_of(found: dict[str, Any], name: str) -> float:
    kind = name.split("_")[0]
    return float(max(abs(found[f"{kind}_min_low"]), abs(found[f"{kind}_max_high"])))


def test_columns_are_pairs_of_bounds() -> None:
    assert [column.name for column in CertifiedCurvature.columns] == COLUMNS
    assert all(column.optional for column in CertifiedCurvature.columns)


@pytest.mark.parametrize("seed", range(5))
def test_searched_extremes_are_inside_and_the_gap_is_small(seed: int) -> None:
    found = measured(bumpy_octahedron(seed))
    for name in EXTREMES:
        low, high = found[f"{name}_low"], found[f"{name}_high"]
        assert low <= found[name] <= high
        assert high - low <= 1e-6 * scale_of(found, name)


@pytest.mark.parametrize("scheme", ["flat", "cubic-interpolant", "shirman-sequin", "pn-triangle", "nagata", "hansford"])
def test_dense_samples_of_schemes_are_within(scheme: str) -> None:
    surface = testbed.scheme(scheme).fit(testbed.dataset("octahedron").mesh(0))
    found = measured(surface)
    dense = [analyse(batch.jets(lattice(batch.sides, 40))) for batch in surface.batches]
    for kind in ("gauss", "mean"):
        values = np.concatenate([getattr(one, kind).ravel() for one in dense])
        rounding = 1e-10 * scale_of(found, f"{kind}_max")
        assert found[f"{kind}_min_low"] <= values.min() + rounding
        assert found[f"{kind}_max_high"] >= values.max() - rounding


def test_known_extremes_are_enclosed() -> None:
    # the paraboloid's vertex: K = 9, H = 3
    found = measured(one_graph(lambda x, y: -1.5 * ((x - 0.2371) ** 2 + (y - 0.3313) ** 2), 2))
    assert found["gauss_max_low"] <= 9.0 + 1e-12
    assert found["gauss_max_high"] >= 9.0 - 1e-12
    assert found["mean_max_low"] <= 3.0 + 1e-12
    assert found["mean_max_high"] >= 3.0 - 1e-12
    assert found["gauss_max_high"] - found["gauss_max_low"] < 1e-5


def test_a_patch_of_high_degree_is_enclosed() -> None:
    def height(x: Float, y: Float) -> Float:
        return 0.01 * x * y - 30.0 * x**2 * (1.0 - x) ** 2 * y**3

    surface = one_graph(height, 7)
    found = measured(surface)
    dense = analyse(surface.batches[0].jets(lattice(3, 300)))
    assert found["gauss_max_high"] >= dense.gauss.max()
    assert found["gauss_min_low"] <= dense.gauss.min()


def test_a_plane_has_no_curvature() -> None:
    found = measured(octahedron())
    for name in EXTREMES:
        assert found[f"{name}_low"] <= 0.0 <= found[f"{name}_high"]
        assert found[f"{name}_high"] - found[f"{name}_low"] < 1e-100


def test_a_sphere_of_rational_patches_has_curvature_one() -> None:
    found = measured(exact_cap())
    for name in EXTREMES:
        assert found[f"{name}_low"] <= 1.0 + 1e-12
        assert found[f"{name}_high"] >= 1.0 - 1e-12
        assert found[f"{name}_high"] - found[f"{name}_low"] < 1e-2


def test_blended_patches_have_no_columns() -> None:
    surface = testbed.scheme("nielson").fit(testbed.dataset("octahedron").mesh(0))
    assert not CertifiedCurvature().measure(Survey(surface))


def test_large_surfaces_have_no_columns() -> None:
    surface = bumpy_octahedron()
    size = 8 * 153
    assert not CertifiedCurvature(coefficients=size - 1).measure(Survey(surface))
    assert list(CertifiedCurvature(coefficients=size).measure(Survey(surface))) == COLUMNS


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_no_number(bad: float) -> None:
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[5, 7, 1] = bad
    values = CertifiedCurvature().measure(Survey(Surface.over_faces(surface.mesh, BezierTriangles(points))))
    assert list(values) == COLUMNS
    assert np.isnan(list(values.values())).all()


def test_a_degenerate_patch_has_infinite_bounds() -> None:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    surface = graph(lambda x, y: x * y, 3, corners, np.array([[0, 1, 2]]))
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[0, 1] = points[0, 2] = points[0, 0]
    values = CertifiedCurvature().measure(Survey(Surface.over_faces(surface.mesh, BezierTriangles(points))))
    assert values["gauss_max_high"] == np.inf
    assert values["gauss_min_low"] == -np.inf
    assert np.isfinite([values["gauss_max_low"], values["mean_min_high"]]).all()


def test_the_search_is_shared() -> None:
    survey = Survey(bumpy_octahedron())
    CurvatureExtremes().measure(survey)
    before = dict(survey._computed)
    CertifiedCurvature().measure(survey)
    assert survey._computed == before


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_the_gap_is_what_was_asked_for(tolerance: float) -> None:
    found = measured(bumpy_octahedron(), tolerance=tolerance)
    for name in EXTREMES:
        assert found[f"{name}_high"] - found[f"{name}_low"] <= tolerance * scale_of(found, name)


def test_a_few_triangles_are_certified_too() -> None:
    found = measured(flat(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0.5]]), np.array([[0, 1, 2]])))
    assert found["gauss_max_high"] < 1e-100
