"""Two runs compared: what is better and what is worse, what is gone, and results that are none."""

import contextlib
import math
import sqlite3
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.comparable import Comparable, Row, Value, read_comparable
from testbed.harness.differences import TOLERANCE, Comparison, compare
from testbed.harness.journal import Claim, Journal
from testbed.harness.plan import Cell, Plan, PlannedDataset, PlannedMeasure, PlannedScheme
from testbed.harness.results import export
from testbed.plugins.measure import Column

CELL: Row = {"scheme": "s", "dataset": "d", "level": 0.0, "status": "ok", "faces": 8.0, "h": 1.0, "diameter": 2.0}


def cells(
    *levels: Mapping[str, Value],
    shape: str | None = None,
    orders: Mapping[tuple[str, ...], Row] | None = None,
    claims: Mapping[tuple[str, ...], Row] | None = None,
    converging: frozenset[str] = frozenset(),
) -> Comparable:
    """Return results of one scheme on one dataset, a cell a level with some values."""
    rows = {("s", "d", level): {**CELL, "level": float(level), **values} for level, values in enumerate(levels)}
    columns = tuple(dict.fromkeys(name for row in rows.values() for name in row))
    return Comparable(
        "some results",
        columns,
        rows,
        orders or {},
        claims or {},
        is_judged=True,
        shapes={"d": shape},
        converging=converging,
    )


def kinds(comparison: Comparison) -> dict[str, str]:
    """Return the kinds of differences by quantity."""
    return {one.quantity: one.kind for one in comparison.differences}


def judged(name: str, old: Value, new: Value, *, tolerance: float = TOLERANCE, seconds: float | None = None) -> str:
    """Return what becomes of one value."""
    found = kinds(compare(cells({name: old}), cells({name: new}), tolerance, seconds))
    return found.get(name, "unchanged")


@pytest.mark.parametrize(
    ("name", "old", "new", "kind"),
    [
        ("distance_max", 1e-3, 1.1e-3, "regressed"),
        ("distance_max", 1e-3, 0.9e-3, "improved"),
        ("distance_rms", 1e-3, 1e-3 * (1 + 1e-7), "unchanged"),
        ("distance_max", 1e-16, 1e-14, "unchanged"),  # rounding of coordinates
        ("distance_max", 1e-14, 1e-9, "regressed"),
        ("normal_max_deg", 2.0, 1.0, "improved"),
        ("epsilon_deg", 1e-13, 1e-10, "unchanged"),  # no angle at all
        ("epsilon_deg", 1e-13, 1e-3, "regressed"),
        ("epsilon_exact_deg", 3.0, 0.0, "improved"),
        ("gap_max", 0.0, 1e-15, "unchanged"),
        ("gap_max", 0.0, 1e-6, "regressed"),
        ("gauss_error_rms", 0.1, 0.2, "regressed"),
        ("gauss_error_max", 1e-12, 1e-14, "unchanged"),
        ("curvature_jump_max", 1e-9, 1e-7, "unchanged"),
        ("vertex_form_max", 1e-3, 1e-4, "improved"),
        ("edges_above_0p057_deg", 0.0, 0.5, "regressed"),
        ("fallbacks", 0.0, 3.0, "regressed"),
        ("fallbacks", 3.0, 0.0, "improved"),
        ("gauss_max", 2.0, 3.0, "changed"),  # nobody can say which is better
        ("gauss_min", -1.0, 1.0, "changed"),
        ("mean_min", 1e-12, -1e-12, "unchanged"),
        ("patches", 24.0, 32.0, "changed"),
        ("anything", 1.0, 2.0, "changed"),
        ("anything", 1.0, 1.0 + 1e-9, "unchanged"),
        ("notes", "3 curves", "4 curves", "changed"),
        ("distance_max", 1e-3, None, "vanished"),
        ("distance_max", None, 1e-3, "appeared"),
        ("distance_max", math.inf, math.inf, "unchanged"),
        ("distance_max", 1.0, math.inf, "regressed"),
        ("gauss_max_face", 3.0, 5.0, "unchanged"),  # places of extremes jump
        ("fit_seconds", 1.0, 9.0, "unchanged"),  # times are passed over
    ],
)
def test_what_is_better_follows_from_the_quantity(name: str, old: Value, new: Value, kind: str) -> None:
    assert judged(name, old, new) == kind


def test_columns_declared_to_converge_are_better_the_smaller() -> None:
    old, new = (cells({"own_error": value}, converging=frozenset({"own_error"})) for value in (1.0, 2.0))
    assert kinds(compare(old, new)) == {"own_error": "regressed"}


@pytest.mark.parametrize(("tolerance", "kind"), [(0.05, "regressed"), (0.2, "unchanged")])
def test_differences_up_to_the_tolerance_are_none(tolerance: float, kind: str) -> None:
    assert judged("distance_max", 1.0, 1.1, tolerance=tolerance) == kind


@pytest.mark.parametrize(
    ("old", "new", "kind"), [(1.0, 1.4, "unchanged"), (1.0, 1.6, "regressed"), (1e-4, 9e-3, "unchanged")]
)
def test_times_have_a_tolerance_of_their_own(old: float, new: float, kind: str) -> None:
    assert judged("fit_seconds", old, new, seconds=0.5) == kind
    assert judged("own_seconds", old, new, seconds=0.5) == kind
    assert judged("distance_max", 1.0, 1.4, seconds=0.5) == "regressed"


def test_bounds_go_with_what_they_bound() -> None:
    names = ("gauss_max", "gauss_max_low", "gauss_max_high")
    old, new = (cells(dict.fromkeys(names, value)) for value in (1.0, 2.0))
    assert kinds(compare(old, new)) == {"gauss_max": "changed"}


def test_curvature_that_is_constant_is_better_the_less_it_spreads() -> None:
    narrow, wide = {"gauss_min": 0.9, "gauss_max": 1.1}, {"gauss_min": 0.8, "gauss_max": 1.3}
    on_sphere = compare(cells(narrow, shape="spheres"), cells(wide, shape="spheres"))
    assert kinds(on_sphere) == {"gauss_spread": "regressed", "gauss_min": "changed", "gauss_max": "changed"}
    assert on_sphere.cells == {"regressed": 1}
    elsewhere = compare(cells(narrow, shape="quadrics"), cells(wide, shape="quadrics"))
    assert set(kinds(elsewhere).values()) == {"changed"}


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ("ok", "refused", "regressed"),
        ("ok", "failed", "regressed"),
        ("refused", "failed", "regressed"),
        ("failed", "ok", "improved"),
        ("timeout", "refused", "improved"),
        ("ok", "well", "changed"),
    ],
)
def test_a_status_is_better_or_worse_than_another_and_values_wait(old: str, new: str, kind: str) -> None:
    reasons = {"ok": "", "well": ""}
    before, after = (
        cells({"status": one, "reason": reasons.get(one, "because"), "distance_max": 1.0}) for one in (old, new)
    )
    found = compare(before, after)
    assert kinds(found) == {"status": kind}
    assert found.cells == {kind: 1}
    assert found.differences[0].reason == ("because" if {old, new} - {"ok", "well"} else "")


def test_what_is_gone_is_no_pass() -> None:
    two, one = cells({}, {}), cells({})
    gone, fresh = compare(two, one), compare(one, two)
    assert gone.cells == {"unchanged": 1, "vanished": 1}
    assert (gone.fails("regressed"), gone.fails("changed")) == (True, True)
    assert (fresh.fails("regressed"), fresh.fails("changed")) == (False, True)
    no_column = compare(cells({"distance_max": 1.0}), cells({}))
    assert [(one.what, one.kind) for one in no_column.differences] == [("column", "vanished")]
    assert no_column.fails("regressed")
    assert not compare(cells({}), cells({"distance_max": 1.0})).fails("regressed")


def test_equal_results_have_no_differences_and_fail_on_nothing() -> None:
    one = cells({"distance_max": 1.0, "notes": None}, {"status": "refused", "reason": "no"})
    same = compare(one, one)
    assert same.differences == ()
    assert same.sentence() == "2 cells in both: 2 unchanged"
    assert not same.fails("changed")


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ((4.0, 3.9, 4.1), (3.0, 2.9, 3.1), "regressed"),
        ((3.0, 2.9, 3.1), (4.0, 3.9, 4.1), "improved"),
        ((4.0, 3.0, 4.1), (3.5, 3.4, 3.6), "changed"),  # the intervals meet
        ((4.0, 3.9, 4.1), (4.0 + 1e-9, 3.9, 4.1), "unchanged"),
        ((math.inf, None, None), (4.0, 3.9, 4.1), "regressed"),
        ((math.inf, None, None), (math.inf, None, None), "unchanged"),
        ((4.0, 3.9, 4.1), (None, None, None), "vanished"),
        ((None, None, None), (4.0, 3.9, 4.1), "appeared"),
    ],
)
def test_orders_differ_where_their_intervals_are_apart(
    old: tuple[Value, ...], new: tuple[Value, ...], kind: str
) -> None:
    key = ("s", "d", "distance_max")
    before, after = (
        cells({}, orders={key: dict(zip(("order", "low", "high"), one, strict=True))}) for one in (old, new)
    )
    found = compare(before, after)
    assert found.orders == {kind: 1}
    assert kinds(found) == ({} if kind == "unchanged" else {"distance_max": kind})


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ("met", "missed", "regressed"),
        ("met", "not testable", "regressed"),
        ("exceeded", "met", "regressed"),
        ("missed", "met", "improved"),
        ("met", None, "vanished"),
        (None, "missed", "appeared"),
        ("met", "met", "unchanged"),
    ],
)
def test_verdicts_are_compared(old: Value, new: Value, kind: str) -> None:
    key = ("s", "continuity G1", "d")
    before, after = (cells({}, claims={key: {"verdict": one, "reason": "r"}} if one else {}) for one in (old, new))
    found = compare(before, after)
    assert found.claims == {kind: 1}
    assert found.fails("regressed") == (kind in ("regressed", "vanished"))


def test_orders_and_claims_of_what_one_side_did_not_compute_are_told_by_the_cells() -> None:
    row: Row = {"order": 4.0, "verdict": "met"}
    old = cells({}, orders={("other", "d", "gap_max"): row}, claims={("other", "order 4", "d"): row})
    found = compare(old, cells({}))
    assert found.differences == ()


def test_the_worst_come_first_whatever_the_order_of_the_rows() -> None:
    same: Row = {"distance_max": 1.0, "gap_max": 1.0, "patches": 2.0}
    changed: list[Row] = [
        {"distance_max": 2.0, "gap_max": 0.1, "patches": 3.0},
        {"distance_max": 5.0},
        {"status": "failed"},
    ]
    old, new = cells(same, same, same), cells(*({**same, **one} for one in changed))
    before, after = (
        Comparable(one.name, one.columns[::-1], dict(list(one.cells.items())[::-1]), is_judged=True)
        for one in (old, new)
    )
    found, again = compare(old, new), compare(before, after)
    assert found.differences == again.differences
    assert [(one.kind, one.level, one.quantity) for one in found.differences] == [
        ("regressed", 2, "status"),
        ("regressed", 1, "distance_max"),
        ("regressed", 0, "distance_max"),
        ("changed", 0, "patches"),
        ("improved", 0, "gap_max"),
    ]
    assert found.differences[1].factor == 5.0


numbers = st.one_of(st.none(), st.floats(0.0, 1e6), st.just(math.inf))


@given(old=numbers, new=numbers, name=st.sampled_from(["distance_max", "epsilon_deg", "gap_max", "gauss_max"]))
def test_what_is_better_one_way_is_worse_the_other(old: Value, new: Value, name: str) -> None:
    turned = {"improved": "regressed", "regressed": "improved", "appeared": "vanished", "vanished": "appeared"}
    there, back = judged(name, old, new), judged(name, new, old)
    assert back == turned.get(there, there)
    assert judged(name, old, old) == "unchanged"


def test_other_meshes_and_tables_alone_are_noted() -> None:
    found = compare(cells({}), cells({"h": 0.5}))
    assert any("1 cells have other meshes" in note for note in found.notes)
    alone = Comparable("a.csv", ("scheme",), {})
    found = compare(alone, cells({}))
    assert "a.csv holds cells alone: orders and verdicts are not compared" in found.notes
    assert any("no cell is in both" in note for note in found.notes)


def computed(directory: Path, levels: int = 3) -> Path:
    """Write the results of a run with so many levels of three, the second of which failed."""
    columns = (Column("distance_max", "", converges=True), Column("notes", ""))
    plan = Plan(
        tuple(Cell("s", "d", level, 8, "", f"key{level}") for level in range(3)),
        (PlannedScheme("s", "S", "", "G1", 4.0, (), (), ""),),
        (PlannedDataset("d", "D", "", None, "spheres", ""),),
        (PlannedMeasure("m", "M", columns, ""),),
    )
    directory.mkdir(exist_ok=True)
    (directory / "plan.json").write_text(plan.to_json())
    with Journal(directory) as journal:
        for level in range(levels):
            values: dict[str, float | int | str] = {"distance_max": 0.1**level / 3.0, "notes": ""}
            outcome = Outcome("ok", "", "", 8, 8, 0.5**level, 2.0, values, 0.1, 0.2)
            assert journal.claim(f"key{level}") is Claim.GRANTED
            failed = Outcome("failed", "a reason, with a comma")
            journal.record(f"key{level}", ("s", "d", level), failed if level == 1 else outcome, 0.0)
    export(directory, {})
    return directory


def test_a_directory_and_its_tables_are_the_same_results(tmp_path: Path) -> None:
    directory = computed(tmp_path / "whole")
    (tmp_path / "copied").mkdir()
    for file in ("results.csv", "orders.csv", "claims.csv", "plan.json"):
        (tmp_path / "copied" / file).write_bytes((directory / file).read_bytes())
    whole, copied = (read_comparable(tmp_path / name) for name in ("whole", "copied"))
    alone = read_comparable(directory / "results.csv")
    assert whole.cells == copied.cells == alone.cells
    assert (whole.orders, whole.claims) == (copied.orders, copied.claims)
    assert (whole.shapes, whole.converging) == (copied.shapes, copied.converging)
    assert whole.shapes == {"d": "spheres"}
    assert whole.converging == {"distance_max"}
    assert [row["status"] for row in whole.cells.values()] == ["ok", "failed", "ok"]
    assert whole.cells["s", "d", 2]["distance_max"] == 0.1**2 / 3.0
    assert compare(whole, copied).differences == ()
    assert len(compare(whole, alone).notes) == 1


def test_a_run_that_is_not_finished_is_compared_as_far_as_it_is(tmp_path: Path) -> None:
    found = compare(read_comparable(computed(tmp_path / "whole")), read_comparable(computed(tmp_path / "part", 2)))
    assert found.cells == {"unchanged": 2, "vanished": 1}
    assert any("is not finished: 1 of its cells" in note for note in found.notes)


HEAD = "scheme,dataset,level,status,distance_max\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "has no column scheme"),
        (b"a,b\n1,2\n", "has no column scheme"),
        (b"\xff\xfe\x00", "no table of results"),
        (b"scheme,dataset,level,status,status\n", "two of its columns have one name"),
        (f"{HEAD}s,d,0,ok\n".encode(), "record 2 has 4 entries for 5 columns"),
        (f"{HEAD}s,d,zero,ok,1\n".encode(), "level 'zero' is no whole number"),
        (f"{HEAD}s,d,0.5,ok,1\n".encode(), "level 0.5 is no whole number"),
        (f"{HEAD}s,d,,ok,1\n".encode(), "level None is no whole number"),
        (f"{HEAD}s,d,0,ok,1\ns,d,0,ok,1\n".encode(), "two rows for s on d, level 0"),
        (f'{HEAD}s,d,0,"ok,1\n'.encode(), "no table of results"),
    ],
)
def test_a_foreign_table_is_told_in_one_sentence(text: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "results.csv").write_bytes(text)
    for path in (tmp_path, tmp_path / "results.csv"):
        with pytest.raises(TestbedError, match=words) as caught:
            read_comparable(path)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["journal.sqlite", "plan.json"])
@pytest.mark.parametrize("text", ["[]", "{}", '{"cells": 3}'])
def test_a_foreign_directory_is_told_in_one_sentence(name: str, text: str, tmp_path: Path) -> None:
    (computed(tmp_path) / name).write_text(text)
    with pytest.raises(TestbedError) as caught:
        read_comparable(tmp_path)
    assert "\n" not in str(caught.value)


def test_a_journal_of_something_else_is_told_in_one_sentence(tmp_path: Path) -> None:
    with closing(sqlite3.connect(computed(tmp_path) / "journal.sqlite")) as journal:
        journal.execute("""UPDATE cells SET outcome = '{"colour": "red"}'""")
        journal.commit()
    with pytest.raises(TestbedError, match="cannot be read"):
        read_comparable(tmp_path)


def test_a_place_without_results_is_told_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(TestbedError, match="holds no results: run `testbed run"):
        read_comparable(tmp_path)
    with pytest.raises(TestbedError, match="does not exist"):
        read_comparable(tmp_path / "nowhere")


@settings(deadline=None, max_examples=150)
@given(data=st.data())
def test_damaged_tables_are_compared_or_refused_and_never_raise_anything_else(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    rows = ["s,d,0,ok,0.5,8", 's,d,1,refused,,"8"', "s,e,0,ok,nan,8", "t,d,0,failed,inf,8"]
    text = "scheme,dataset,level,status,distance_max,faces\n" + "\n".join(rows) + "\n"
    begin = data.draw(st.integers(0, len(text)))
    length = data.draw(st.integers(0, 12))
    damaged = text[:begin].encode() + data.draw(st.binary(max_size=6)) + text[begin + length :].encode()
    directory = tmp_path_factory.mktemp("damaged")
    (directory / "a.csv").write_text(text)
    (directory / "b.csv").write_bytes(damaged)
    whole = read_comparable(directory / "a.csv")
    with contextlib.suppress(TestbedError):  # it says what is wrong; any other error fails
        assert compare(whole, read_comparable(directory / "b.csv")).sentence()
