"""The grid is planned without computing it: levels, sizes, refusals that can be foreseen."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_plugins import Toy

from testbed.errors import SpecError
from testbed.harness.plan import Plan, make_plan, parse_levels
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.registry import catalogue

Planning = Callable[..., Plan]


@given(st.integers(0, 99), st.integers(0, 20))
def test_levels_include_both_ends(first: int, more: int) -> None:
    assert parse_levels(f"{first}:{first + more}") == tuple(range(first, first + more + 1))
    assert parse_levels(str(first)) == (first,)


@pytest.mark.parametrize("text", ["", ":", "1:", ":2", "a", "-1", "1.5", "0:1:2", "3:1", "1,2", "1e1"])
def test_other_levels_are_an_error_of_one_sentence(text: str) -> None:
    with pytest.raises(SpecError, match="levels") as caught:
        parse_levels(text)
    assert "\n" not in str(caught.value)
    assert "write" in str(caught.value)


def test_the_grid_is_the_product_in_the_order_asked_for(toy_plan: Planning) -> None:
    plan = toy_plan(["toy[tag=2]", "toy"], ["grid[forms=false]", "grid"])
    assert [(cell.scheme, cell.dataset, cell.level) for cell in plan.cells] == [
        (scheme, dataset, level)
        for scheme in ("toy[tag=2]", "toy")
        for dataset in ("grid[forms=false]", "grid")
        for level in (0, 1, 2)
    ]
    assert [cell.faces for cell in plan.cells[:3]] == [2, 8, 32]
    assert len({cell.key for cell in plan.cells}) == len(plan.cells)


def test_equal_plugins_written_differently_are_one(toy_plan: Planning) -> None:
    plan = toy_plan(["toy[tag=0, seconds=0]", "toy"], ["grid"], "1")
    assert [cell.scheme for cell in plan.cells] == ["toy"]
    assert plan.cells == toy_plan(["toy"], ["grid"], "0:2").cells[1:2]


def test_refusals_are_foreseen(toy_plan: Planning) -> None:
    datasets = ["grid", "grid[forms=false]", "grid[sides=4]", "grid[act=refuse]"]
    foreseen = {cell.dataset: cell.foreseen for cell in toy_plan(["needy"], datasets, "0").cells}
    assert foreseen["grid"] == ""
    assert "second forms" in foreseen["grid[forms=false]"]
    assert "4 sides" in foreseen["grid[sides=4]"]
    assert "vertex 0" in foreseen["grid[act=refuse]"]


def test_the_needs_of_boundary_curves_count() -> None:
    plan = make_plan(["shirman-sequin[boundary=hermite]"], ["grid[forms=false]"], "0", ["sums"])
    assert "second forms" in plan.cells[0].foreseen


def test_levels_beyond_the_range_are_foreseen(toy_plan: Planning) -> None:
    foreseen = {cell.level: cell.foreseen for cell in toy_plan(["toy"], ["grid"], "4:6").cells}
    assert foreseen[4] == foreseen[5] == ""
    assert "ends at level 5" in foreseen[6]


def test_a_dataset_that_breaks_does_not_break_the_plan(toy_plan: Planning) -> None:
    plan = toy_plan(["toy"], [f"grid[act={act}]" for act in ("exit", "raise", "kill")] + ["grid"], "0:1")
    assert [cell.faces for cell in plan.cells] == [None] * 6 + [2, 8]


def test_the_default_grid_has_every_registered_dataset_of_the_faces_that_schemes_take() -> None:
    plan = make_plan(["toy"], None, "0", ["sums"])
    assert set(Toy.domain) == {3}
    taken = [name for name, one in catalogue(Dataset).items() if one.compared and one().mesh(0).sides == 3]  # type: ignore[type-abstract]
    assert "bump" not in taken
    assert [dataset.spec for dataset in plan.datasets] == taken
    assert "quad-torus" not in taken


def test_faces_that_a_scheme_does_not_take_are_refused_where_both_are_named() -> None:
    (cell,) = make_plan(["toy"], ["quad-torus"], "0", ["sums"]).cells
    assert cell.foreseen == "faces have 4 sides, and the scheme takes 3"
    assert {cell.scheme for cell in make_plan(None, ["quad-torus"], "0", ["sums"]).cells}.isdisjoint({"toy", "flat"})


def test_a_file_that_cannot_be_read_is_an_error_that_names_it(toy_plan: Planning, tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"missing\.ply"):
        toy_plan(["toy"], [f"file:{tmp_path / 'missing.ply'}"])


def test_an_empty_grid_is_an_error() -> None:
    with pytest.raises(SpecError, match="no scheme"):
        make_plan([], ["grid"], "0", ["sums"])


def test_a_plan_survives_being_stored(toy_plan: Planning) -> None:
    plan = toy_plan(["toy", "needy[tag=1]"], ["grid", "grid[forms=false]"])
    assert Plan.from_json(plan.to_json()) == plan


def test_a_bounded_plan_has_the_same_levels_for_all_schemes_and_says_what_it_left_out() -> None:
    whole = make_plan(["toy", "needy"], ["grid", "grid[forms=false]"], "0:4", ["sums"])
    bounded = make_plan(["toy", "needy"], ["grid", "grid[forms=false]"], "0:4", ["sums"], budget=3000.0)
    levels: dict[tuple[str, str], list[int]] = {(cell.scheme, cell.dataset): [] for cell in whole.cells}
    for cell in bounded.cells:
        levels[cell.scheme, cell.dataset].append(cell.level)
    assert levels["toy", "grid"] == levels["needy", "grid"]
    for one in bounded.left_out:
        assert [*levels["toy", one.dataset], *one.levels] == [0, 1, 2, 3, 4]
    assert bounded.left_out
    assert {cell.key for cell in bounded.cells} < {cell.key for cell in whole.cells}
    assert Plan.from_json(bounded.to_json()) == bounded


def test_a_plan_without_a_bound_leaves_nothing_out(toy_plan: Planning) -> None:
    assert toy_plan(["toy"]).left_out == ()


def test_work_too_small_for_any_cell_is_an_error() -> None:
    with pytest.raises(SpecError, match="no cell fits"):
        make_plan(["toy"], ["grid"], None, ["sums"], budget=1.0)


def test_schemes_on_a_network_are_planned_on_further_boundary_curves() -> None:
    plan = make_plan(["toy", "shirman-sequin"], ["grid"], "0", ["sums"], boundaries=["hermite", "planar", "projected"])
    curves = {scheme.spec: scheme.boundary for scheme in plan.schemes}
    assert curves == {
        "toy": "",
        "shirman-sequin": "projected",
        "shirman-sequin[boundary=hermite]": "hermite",
        "shirman-sequin[boundary=planar]": "planar",
    }


def test_all_stands_for_every_registered_boundary_curve() -> None:
    plan = make_plan(["shirman-sequin"], ["grid"], "0", ["sums"], boundaries=["all"])
    assert {scheme.boundary for scheme in plan.schemes} == set(catalogue(BoundaryCurve))  # type: ignore[type-abstract]
