"""Rankings, the effects of curves and schemes, and groups of plots: from results made by hand with known factors."""

import math
import sys
from dataclasses import replace
from typing import Any

import pytest
from hand_made_results import COLUMNS, good, results

from testbed.harness.cell import Outcome
from testbed.harness.results import Results, tabulate
from testbed.plugins.measure import Column
from testbed_reports.findings import findings
from testbed_reports.grid import Grid
from testbed_reports.page import render
from testbed_reports.panels import TOGETHER, groups, panels
from testbed_reports.ranking import Ranking, rankings
from testbed_reports.view import view

WITH_ERRORS = (*COLUMNS, Column("gauss_error_rms", "error of the Gaussian curvature", converges=True, exact=True))
#: Error of a scheme, and its factor on another curve, by dataset.
FACTORS = {"a": 1.0, "b": 2.0, "c": 8.0}
CURVE = {"ball": 0.25, "ring": 1.0}


def made(scheme: str, dataset: str, level: int) -> Outcome:
    name = scheme[0]
    error = FACTORS.get(name, 3.0) * (CURVE[dataset] if "better" in scheme else 1.0) * 0.5**level
    done = good(scheme, dataset, level)
    return replace(done, values={**(done.values or {}), "gauss_error_rms": error, "distance_max": error**2})


def variants(**changed: Any) -> Results:
    names = [f"{name}{tail}" for name in FACTORS for tail in ("", "[boundary=better]")]
    found = results(names, ("ball", "ring"), 2, made, shape=None, columns=WITH_ERRORS)
    schemes = tuple(
        replace(one, continuity="G1", family=one.spec[0], boundary="better" if "better" in one.spec else "usual")
        for one in found.plan.schemes
    )
    return replace(found, plan=replace(found.plan, schemes=schemes, **changed))


def ranking_of(grid: Grid) -> Ranking | None:
    """The one ranking of schemes that share their datasets."""
    found = rankings(grid)
    assert len(found) <= 1
    return found[0] if found else None


def of_two_kinds() -> Results:
    """Schemes a and b on ``ball``, c and d on ``ring``, which has faces of another kind."""
    found = results(("a", "b", "c", "d"), ("ball", "ring"), 2, made, shape=None, columns=WITH_ERRORS)
    cells = tuple(cell for cell in found.plan.cells if (cell.scheme in "ab") == (cell.dataset == "ball"))
    plan = replace(found.plan, cells=cells)
    return tabulate(plan, {cell.key: made(cell.scheme, cell.dataset, cell.level) for cell in cells}, {})


def test_schemes_that_take_other_faces_are_compared_apart() -> None:
    found = of_two_kinds()
    grid = Grid.of(found)
    assert grid.circles() == (((0, 1), ("ball",)), ((2, 3), ("ring",)))
    assert [[row.scheme for row in one.rows] for one in rankings(grid)] == [["a", "b"], ["d", "c"]]
    assert not any(one.unranked for one in rankings(grid))
    assert {(row["scheme"], row["dataset"]) for row in grid.claims if row["dataset"]} == found.plan.pairs
    page = view(found)
    assert [[row.scheme for row in section.table.rows] for section in page.sections if section.table] == [
        ["a", "b"],
        ["c", "d"],
    ]
    assert [[cell.order.text == "" for cell in row] for row in page.overview] == [[False, True]] * 2 + [
        [True, False]
    ] * 2
    assert render(page).count("Errors against the exact surfaces") == 2


def test_factors_are_geometric_means_over_the_datasets() -> None:
    found = ranking_of(Grid.of(results(("a", "b", "c"), ("ball", "ring"), 2, made, shape=None, columns=WITH_ERRORS)))
    assert found is not None
    assert [row.scheme for row in found.rows] == ["a", "b", "c"]
    index = [one.column for one in found.criteria].index("gauss_error_rms")
    assert [float(row.factors[index].exact) for row in found.rows] == pytest.approx([1.0, 2.0, 8.0])
    index = [one.column for one in found.criteria].index("distance_max")
    assert [float(row.factors[index].exact) for row in found.rows] == pytest.approx([1.0, 4.0, 64.0])
    assert found.rows[0].factors[index].best
    assert any("a (1.00), b (2.00) and c (8.00)" in sentence for sentence in found.sentences)


def test_spheres_and_other_surfaces_are_ranked_apart() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        done = made(scheme, dataset, level)
        best = {"ball": "c", "ring": "a"}[dataset]
        values = {**(done.values or {}), "gauss_error_rms": 1.0 if scheme == best else 5.0}
        return replace(done, values=values)

    found = results(("a", "b", "c"), ("ball", "ring"), 2, make, shape=None, columns=WITH_ERRORS)
    ball, ring = found.plan.datasets
    plan = replace(found.plan, datasets=(replace(ball, shape="spheres"), ring))
    ranked = ranking_of(Grid.of(replace(found, plan=plan)))
    assert ranked is not None
    assert any("on spheres: c (1.00)" in sentence for sentence in ranked.sentences)
    assert any("on other surfaces: a (1.00)" in sentence for sentence in ranked.sentences)
    (whole,) = [i for i, one in enumerate(ranked.criteria) if (one.column, one.where) == ("gauss_error_rms", "all")]
    factors = {row.scheme: float(row.factors[whole].exact) for row in ranked.rows}
    assert factors == pytest.approx({"a": 5.0**0.5, "b": 5.0, "c": 5.0**0.5})


def test_a_scheme_without_a_surface_on_some_dataset_is_not_ranked_and_named() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        return Outcome("refused", "no") if (scheme, dataset) == ("b", "ring") else made(scheme, dataset, level)

    found = ranking_of(Grid.of(results(("a", "b", "c"), ("ball", "ring"), 2, make, shape=None, columns=WITH_ERRORS)))
    assert found is not None
    assert [row.scheme for row in found.rows] == ["a", "c"]
    assert found.unranked == ("b (refused on ring)",)


def test_rounding_is_no_victory() -> None:
    def make(scheme: str, dataset: str, level: int) -> Outcome:
        done = made(scheme, dataset, level)
        tiny = {"a": 1e-17, "b": 0.0, "c": 1e-16}[scheme]
        return replace(done, values={**(done.values or {}), "distance_max": tiny})

    found = ranking_of(Grid.of(results(("a", "b", "c"), ("ball",), 2, make, shape=None, columns=WITH_ERRORS)))
    assert found is not None
    index = [one.column for one in found.criteria].index("distance_max")
    assert {row.factors[index].text for row in found.rows} == {"1.00"}


def test_one_scheme_or_planes_alone_have_no_ranking() -> None:
    assert ranking_of(Grid.of(results(("a",), ("ball",), 2, made, shape=None, columns=WITH_ERRORS))) is None
    assert ranking_of(Grid.of(results(("a", "b"), ("ball",), 2, made, shape="planes", columns=WITH_ERRORS))) is None


def test_the_effect_of_a_curve_is_its_error_over_the_usual_curve_s() -> None:
    found = findings(Grid.of(variants()))
    assert found is not None
    assert found.base == "usual"
    (row,) = found.comparisons[0].curves
    at = dict(zip(found.places, row.entries, strict=True))
    assert {dataset: entry.text for (dataset, _), entry in at.items()} == {"ball": "0.250", "ring": "1.00"}
    assert at["ball", 0].best
    assert not at["ring", 0].best
    by_scheme = {row.name: row.entries[0].text for row in found.comparisons[0].schemes}
    assert by_scheme == {"a": "0.500", "b": "1.00", "c": "4.00"}
    conclusion, distance, ball, *_ = found.sentences
    assert distance.startswith("Largest distance: on usual curves the schemes differ by factors of 64.0 to 64.0.")
    assert "by factors of 8.00 to 8.00" in conclusion
    assert "Other curves help on ball, the best of them by factors of 4.00 to 4.00, and do not on ring." in conclusion
    assert "within a factor of 8.00 (a to c)" in ball
    assert "falls with better by 4.00, 1 curve of 1 lower it" in ball
    assert any("ring" in sentence and "none of 1 other curve lowers it" in sentence for sentence in found.sentences)


@pytest.mark.parametrize(
    ("gains", "holds"), [({"ball": 0.25, "ring": 1.0}, True), ({"ball": 0.25, "ring": 0.5}, False)]
)
def test_the_survey_s_finding_is_judged(gains: dict[str, float], holds: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[__name__], "CURVE", gains)
    found = variants()
    ball, ring = found.plan.datasets
    grid = Grid.of(replace(found, plan=replace(found.plan, datasets=(replace(ball, shape="spheres"), ring))))
    told = findings(grid)
    assert told is not None
    assert f"{'holds' if holds else 'does not hold'} here" in told.sentences[0]


def test_schemes_on_one_curve_each_tell_nothing_of_curves() -> None:
    assert findings(Grid.of(results(("a", "b"), ("ball",), 2, made, shape=None, columns=WITH_ERRORS))) is None


def test_few_schemes_are_drawn_together_and_many_in_groups_that_lose_none() -> None:
    assert [group.title for group in groups(Grid.of(variants()))] == [""]
    names = [f"{letter}{number}" for letter in "abc" for number in range(TOGETHER)]
    found = results(names, ("ball",), 2, made, shape=None, columns=WITH_ERRORS)
    schemes = tuple(
        replace(one, family=one.spec, continuity="C0" if one.spec[0] == "a" else "G1") for one in found.plan.schemes
    )
    grid = Grid.of(replace(found, plan=replace(found.plan, schemes=schemes)))
    drawn = [position for group in groups(grid) for position in group.positions]
    assert sorted(drawn) == list(range(len(names)))
    assert all(0 < len(group.positions) <= TOGETHER for group in groups(grid))
    whole = panels(grid, "ball")
    for group in groups(grid):
        for panel, all_of_it in zip(panels(grid, "ball", group), whole, strict=True):
            assert panel.values[0] == all_of_it.values[0]
            assert panel.values[-1] == all_of_it.values[-1]
            assert panel.lengths == all_of_it.lengths
            assert {line.position for line in panel.lines} <= set(group.positions)


def test_of_many_schemes_on_several_curves_those_on_their_own_are_drawn() -> None:
    names = [f"{letter}{number}{tail}" for letter in "abc" for number in range(9) for tail in ("", "[boundary=better]")]
    found = results(names, ("ball", "ring"), 2, made, shape=None, columns=WITH_ERRORS)
    schemes = tuple(
        replace(one, family=one.spec.partition("[")[0], boundary="x", continuity="G1") for one in found.plan.schemes
    )
    grid = Grid.of(replace(found, plan=replace(found.plan, schemes=schemes)))
    drawn = {grid.schemes[position] for group in groups(grid) for position in group.positions}
    assert drawn == {name for name in names if "better" not in name}


def test_the_page_shows_ranking_findings_and_what_was_left_out() -> None:
    found = variants()
    page = view(replace(found, run={**found.run, "left_out": {"ring": [3, 4]}}))
    assert ("Left out", "ring, levels 3 4: testbed run --all computes them") in page.facts
    text = render(page)
    assert 'id="ranking"' in text
    assert 'id="findings"' in text
    assert math.isfinite(float(page.rankings[0].rows[0].factors[0].exact) if page.rankings else math.nan)
