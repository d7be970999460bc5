"""Constructions whose numbers papers print: what the table names there is, and orders and counts are what they say."""

import numpy as np
import pytest

from testbed_reports.constructions import (
    CONSTRUCTIONS,
    curves_of_sphere_data,
    inner_boundaries,
    linear_patches,
    patch_ratio,
    second_rows,
)
from testbed_reports.derived import compare_derived, measure_derived
from testbed_reports.published_table import DerivedFigure, published_table


def test_the_table_names_every_construction_and_no_others() -> None:
    named = {one.column for one in published_table().derived if one.source == "construction"}
    assert named == set(CONSTRUCTIONS)


def test_the_three_linear_patches_share_their_spokes_and_are_flat() -> None:
    first, second, third = np.array(linear_patches())
    assert np.abs(np.array(linear_patches())[..., 2]).max() < 1e-15
    # rows of a quartic: 5, 4, 3, 2, 1 points; the first row of each runs between its first two corners
    np.testing.assert_array_equal(first[0], second[0])
    np.testing.assert_array_equal(first[-1], third[0])
    np.testing.assert_array_equal(second[-1], third[-1])
    np.testing.assert_allclose(second[[0, 1, 2, 3, 4]], first[[0, 5, 9, 12, 14]], atol=1e-15)


def test_the_quadratics_points_cannot_be_reached_along_the_directions_of_c() -> None:
    own, made, directions = second_rows()
    missing = own - made
    along = (missing * directions).sum(axis=-1, keepdims=True) * directions
    assert np.linalg.norm(missing - along, axis=-1).min() > 0.7
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0, rtol=1e-14)


def test_what_must_not_change_does_not_and_the_rest_is_counted() -> None:
    assert max(inner_boundaries()) < 1e-12
    assert curves_of_sphere_data() == 3
    assert patch_ratio() == pytest.approx(8.0 / 5.0)


def test_a_row_that_names_nothing_or_the_wrong_count_has_a_reason() -> None:
    def figure(**changes: str) -> DerivedFigure:
        given = {"source": "construction", "dataset": "d", "column": "ratio of patches", "printed": "1.6", **changes}
        return DerivedFigure(paper="mann-1994", place="p", quantity="q", data="given", **given)  # type: ignore[arg-type]

    figures = (
        figure(),
        figure(column="nothing"),
        figure(printed="1 2"),
        figure(source="surface", scheme="a-patch", dataset="joined-faces", column="positive faces", printed="2"),
        figure(source="surface", scheme="a-patch", dataset="joined-faces", column="nothing", printed="2"),
        figure(source="surface", scheme="bicubic-interpolant", dataset="joined-faces", column="nothing", printed="2"),
    )
    rows = compare_derived(figures, measure_derived(figures, 1))
    assert [row.agreement for row in rows] == ["agrees", "no value", "no value", "agrees", "no value", "no value"]
    assert rows[1].reason == "there is no construction nothing"
    assert rows[2].reason == "ratio of patches are 1 numbers"
    assert rows[4].reason == "a-patch does not count nothing"
    assert "quadrilaterals" in rows[5].reason
