"""From outcomes to tables: types, round trips, orders, and verdicts on claims."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf, nan
from pathlib import Path

import pandas as pd
import pytest

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.claims import CLOSED
from testbed.harness.plan import Cell, Plan, PlannedDataset, PlannedMeasure, PlannedScheme
from testbed.harness.results import BEGINNING, END, Results, export, read_results, tabulate
from testbed.harness.run import run
from testbed.plugins.measure import Column, Value

COLUMNS = (
    Column("distance_max", "", converges=True, exact=True),
    Column("normal_max_deg", "", converges=True, exact=True),
    Column("epsilon_deg", "", converges=True),
    Column("gap_max", ""),
    Column("count", ""),
    Column("where", ""),
)
LEVELS = 4


def grid(
    continuity: str = "G1", order: float | None = 4, reproduces: tuple[str, ...] = (), shape: str | None = None
) -> Plan:
    """Return the plan of one scheme on one dataset."""
    scheme = PlannedScheme("s", "S", "", continuity, order, reproduces, (), "")
    dataset = PlannedDataset("d", "D", "", None, shape, "")
    cells = tuple(Cell("s", "d", level, 2 * 4**level, "", f"key{level}") for level in range(LEVELS))
    return Plan(cells, (scheme,), (dataset,), (PlannedMeasure("m", "M", COLUMNS, ""),))


def ok(level: int, **values: Value) -> Outcome:
    """Return an outcome with errors of order 4, and others as given."""
    h = 0.5**level
    found: dict[str, Value] = {"distance_max": 0.1 * h**4, "normal_max_deg": 3.0 * h**3, "epsilon_deg": 1e-13}
    found |= {"gap_max": 1e-16, "count": level, "where": f"face {level}", **values}
    return Outcome("ok", "", "", 2 * 4**level, 2 * 4**level, h, 2.0, found, 0.1, 0.2)


def table(plan: Plan, changed: Mapping[int, Outcome] | None = None, **values: Value) -> Results:
    """Return the results of outcomes with values as given on all levels."""
    outcomes = {f"key{level}": ok(level, **values) for level in range(LEVELS)}
    outcomes |= {f"key{level}": outcome for level, outcome in (changed or {}).items()}
    return tabulate(plan, outcomes, {})


def judged(results: Results, claim: str) -> list[str]:
    """Return the verdicts on a claim."""
    return results.claims.loc[results.claims["claim"] == claim, "verdict"].tolist()


def test_types_are_the_same_whether_all_cells_are_there_or_none() -> None:
    plan = grid()
    whole = table(plan).cells
    holes = table(plan, {1: Outcome("refused", "no"), 2: Outcome("failed", "bad", "trace")}).cells
    assert list(whole.columns) == [*BEGINNING, *(column.name for column in COLUMNS), *END]
    pd.testing.assert_series_equal(whole.dtypes, holes.dtypes)
    assert holes.loc[1, "reason"] == "no"
    assert holes["count"].isna().tolist() == [False, True, True, False]
    assert holes.loc[1, "where"] == ""
    empty = tabulate(plan, {}, {})
    assert empty.cells.empty
    assert len(empty.missing) == LEVELS
    assert judged(empty, "continuity G1") == ["not testable"]


def test_an_extreme_that_a_bound_proves_missed_stands_at_the_bound_without_a_place() -> None:
    names = ("distance_max", "distance_max_low", "distance_max_high", "distance_max_face", "distance_max_bary")
    least = ("gauss_min", "gauss_min_low", "gauss_min_high")
    measure = PlannedMeasure("m", "M", tuple(Column(name, "") for name in (*names, *least)), "")
    bounds: dict[str, Value] = {"distance_max_low": 0.5, "distance_max_high": 0.6, "distance_max_face": 3}
    bounds |= {"distance_max_bary": "1;0;0", "gauss_min_low": -3.0, "gauss_min_high": -2.0}
    without = {"distance_max": 0.0, "gauss_min": 0.0, "distance_max_face": 3, "distance_max_bary": "1;0;0"}
    found = [
        ok(0, **{**bounds, "distance_max": 0.1, "gauss_min": -1.0}),
        ok(1, **{**bounds, "distance_max": 0.55, "gauss_min": -2.5}),
        ok(2, **{**bounds, "distance_max": 0.7, "gauss_min": -3.5}),
        ok(3, **without),
    ]
    plan = replace(grid(), measures=(measure,))
    cells = tabulate(plan, {f"key{level}": outcome for level, outcome in enumerate(found)}, {}).cells
    assert cells["distance_max"].tolist() == [0.5, 0.55, 0.7, 0.0]
    assert cells["gauss_min"].tolist() == [-2.0, -2.5, -3.5, 0.0]
    assert cells["distance_max_face"].tolist() == [-1, 3, 3, 3]
    assert cells["distance_max_bary"].tolist() == ["", "1;0;0", "1;0;0", "1;0;0"]


def test_orders_are_estimated_and_judged() -> None:
    orders = table(grid(order=4)).orders.set_index("quantity")
    assert orders.loc["distance_max", "order"] == pytest.approx(4.0)
    assert orders.loc["distance_max", "verdict"] == "met"
    assert orders.loc["distance_max", "levels_used"] == "0 1 2 3"
    assert orders.loc["normal_max_deg", "order"] == pytest.approx(3.0)
    assert orders.loc["normal_max_deg", "verdict"] == "not claimed"
    assert orders.loc["epsilon_deg", "order"] == inf
    assert "count" not in orders.index


@pytest.mark.parametrize(("claim", "verdict"), [(3, "exceeded"), (4, "met"), (5, "missed")])
def test_an_order_claim(claim: float, verdict: str) -> None:
    assert judged(table(grid(order=claim)), f"order {claim}") == [verdict]


def test_failed_levels_are_left_out_of_an_order_and_too_few_give_none() -> None:
    failed = Outcome("failed", "bad")
    three = table(grid(), {1: failed}).orders.set_index("quantity").loc["distance_max"]
    assert (three["levels_used"], three["verdict"]) == ("0 2 3", "met")
    two = table(grid(), {1: failed, 2: failed}).orders.set_index("quantity").loc["distance_max"]
    assert two["verdict"] == "not testable"
    assert two["reason"]


def test_meshes_that_do_not_get_finer_have_no_order() -> None:
    same = {level: replace(ok(level), h=1.0) for level in range(LEVELS)}
    row = table(grid(), same).orders.iloc[0]
    assert row["verdict"] == "not testable"
    assert "decrease" in row["reason"]


@pytest.mark.parametrize(
    ("continuity", "gap", "epsilon", "verdict"),
    [
        ("G1", 1e-16, 1e-9, "met"),
        ("G1", 1e-16, 1e-7, "missed"),
        ("G1", 3 * CLOSED, 1e-9, "missed"),
        ("G1", nan, 1e-9, "not testable"),
        ("C0", 1e-16, 5.0, "met"),
        ("C0", 3 * CLOSED, 5.0, "missed"),
        ("C0", 1e-16, 1e-9, "exceeded"),
        ("G2", 1e-16, 1e-9, "not testable"),
        ("G2", 1e-16, 1.0, "missed"),
    ],
)
def test_continuity(continuity: str, gap: float, epsilon: float, verdict: str) -> None:
    one = {2: ok(2, gap_max=gap, epsilon_deg=epsilon)}
    assert judged(table(grid(continuity), one, epsilon_deg=1e-12), f"continuity {continuity}") == [verdict]


@pytest.mark.parametrize(
    ("continuity", "epsilon", "jump", "verdict"),
    [
        ("G2", 1e-9, 1e-7, "met"),
        ("G2", 1e-9, 1e-5, "missed"),
        ("G2", 1e-9, nan, "missed"),
        ("G2", 1e-7, 1e-7, "missed"),
        ("G1", 1e-9, 1e-7, "met"),  # meshes with mirrors join schemes of all kinds with no curvature jump
        ("C1", 1e-9, 1e-7, "not testable"),
    ],
)
def test_curvature_continuity(continuity: str, epsilon: float, jump: float, verdict: str) -> None:
    plan = grid(continuity)
    plan = replace(plan, measures=(PlannedMeasure("m", "M", (*COLUMNS, Column("curvature_jump_max", "")), ""),))
    one = {2: ok(2, epsilon_deg=epsilon, curvature_jump_max=jump)}
    assert judged(table(plan, one, curvature_jump_max=1e-12), f"continuity {continuity}") == [verdict]


def test_a_claim_is_judged_on_the_cells_that_are_ok_and_says_which_are_not() -> None:
    claims = table(grid(), {0: Outcome("failed", "bad")}).claims.set_index("claim")
    assert claims.loc["continuity G1", "verdict"] == "met"
    assert "level 0 failed" in str(claims.loc["continuity G1", "reason"])
    none = table(grid(), {level: Outcome("refused", "because") for level in range(LEVELS)}).claims
    assert set(none["verdict"]) == {"not testable"}
    assert "because" in none.iloc[0]["reason"]


@pytest.mark.parametrize(
    ("reproduces", "shape", "error", "verdicts"),
    [
        (("spheres",), "spheres", 1e-15, ["met"]),
        (("spheres",), "spheres", 1e-3, ["missed"]),
        (("spheres",), "quadrics", 1e-3, ["not testable"]),
        (("spheres",), None, 1e-3, ["not testable"]),
        ((), "spheres", 1e-15, ["exceeded"]),
        ((), "spheres", 1e-3, []),
    ],
)
def test_reproduction(reproduces: tuple[str, ...], shape: str | None, error: float, verdicts: list[str]) -> None:
    results = table(grid(reproduces=reproduces, shape=shape), distance_max=error, normal_max_deg=error)
    assert judged(results, "reproduces spheres") == verdicts


def test_a_sphere_is_a_quadric_too() -> None:
    results = table(grid(reproduces=("quadrics",), shape="spheres"), distance_max=0.0, normal_max_deg=0.0)
    assert judged(results, "reproduces quadrics") == ["met"]


def test_exports_read_back_to_the_last_bit(toy_plan: Callable[..., Plan], tmp_path: Path) -> None:
    plan = toy_plan(["toy", "toy[act=nan]"], ["grid", "grid[forms=false]"])
    run(plan, tmp_path, jobs=1)
    results = read_results(tmp_path)
    assert results.plan == plan
    assert results.run["cells"]["total"] == len(plan.cells)
    types = {str(name): kind for name, kind in results.cells.dtypes.items() if kind != "str"}
    read = pd.read_csv(
        tmp_path / "results.csv", dtype={**types}, keep_default_na=False, na_values={name: [""] for name in types}
    )
    pd.testing.assert_frame_equal(read.astype(results.cells.dtypes), results.cells, check_exact=True)
    before = {file.name: file.read_bytes() for file in tmp_path.glob("*.csv")}
    export(tmp_path, results.run)
    assert before == {file.name: file.read_bytes() for file in tmp_path.glob("*.csv")}
    assert not list(tmp_path.glob(".*"))


def test_a_directory_without_results_is_an_error_that_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(TestbedError, match="holds no results: run `testbed run"):
        read_results(tmp_path)
    (tmp_path / "plan.json").write_text("{")
    with pytest.raises(TestbedError, match=r"plan\.json is not a plan"):
        read_results(tmp_path)
