"""Cost tables: every printed number is ours, or is explained; the command prints them."""

import json

import pytest

from testbed import registry
from testbed.cli.costing import costs_command
from testbed.errors import TestbedError
from testbed_reports.cost_tables import CostRow, cost_rows
from testbed_reports.published_table import published_table

every_table = pytest.mark.parametrize("name", ["branch", "ring"])


def rows_of(name: str, triangles: int | None = None) -> dict[tuple[str, str], CostRow]:
    return {(row.patches, row.quantity): row for row in cost_rows(registry.dataset(name), triangles)}


@every_table
def test_every_printed_number_is_compared_and_agrees_or_is_explained(name: str) -> None:
    printed = [one for one in published_table().derived if (one.dataset, one.source) == (name, "cost")]
    rows = rows_of(name)
    assert len(printed) >= 15
    assert {key: row.printed for key, row in rows.items() if row.printed} == {
        (one.patches, one.column): one.printed for one in printed
    }
    for row in rows.values():
        assert row.agrees == (not row.explanation)


def test_the_branch_is_as_printed() -> None:
    rows = rows_of("branch")
    assert rows["S-patches", "control points"].measured == 1240
    assert rows["S-patches", "control points, shared"].measured == 1015
    assert rows["S-patches", "cost of the surface"].measured == 1000.0
    assert rows["cubic triangles", "control points, shared"].measured == 1088
    assert rows["S-patches / cubic triangles", "cost"].measured == pytest.approx(4.2, abs=0.005)


def test_the_ring_has_three_misprints() -> None:
    rows = rows_of("ring")
    expected = {
        ("3 sides, depth 6", "control points of one"): (28, "56", "56 is the number of combinations"),
        ("S-patches", "control points"): (1656, "1768", "28"),
        ("S-patches / cubic triangles", "cost"): (2.985, "4.2", "the branch"),
    }
    for key, (ours, printed, explanation) in expected.items():
        assert rows[key].measured == pytest.approx(ours, abs=5e-4)
        assert rows[key].printed == printed
        assert explanation in rows[key].explanation
    # the printed total is the sum of the printed columns, so it is the 56 that is wrong
    assert 4 * 56 + 31 * 20 + 2 * 462 == 1768
    assert rows["S-patches", "cost of the surface"].measured == pytest.approx(1379.2)
    assert rows["cubic triangles", "control points, shared"].measured == 2079


def test_another_approximation_is_compared_with_nothing_printed() -> None:
    rows = rows_of("branch", 400)
    assert not any(row.printed for row in rows.values())
    assert rows["S-patches / cubic triangles", "cost"].measured == 2.5


def test_only_networks_have_cost_tables() -> None:
    with pytest.raises(TestbedError, match="torus is no network of S-patches"):
        cost_rows(registry.dataset("torus"))


def test_the_command_prints_the_table_and_its_notes(capsys: pytest.CaptureFixture[str]) -> None:
    costs_command("ring", None, as_json=False)
    text = capsys.readouterr().out
    for part in ("6 sides, depth 6", "1656", "1768", "differs (2)", "(3) 4.2 is the value of the branch"):
        assert part in text
    costs_command("branch", None, as_json=True)
    rows = json.loads(capsys.readouterr().out)
    assert {"patches", "quantity", "measured", "printed", "explanation"} == set(rows[0])
    costs_command("network", None, as_json=False)
    assert "printed" not in capsys.readouterr().out
