"""Sweeps: the settings, their table, and the best of them; refusals are rows without a value."""

import math
from pathlib import Path

import pandas as pd
import pytest

from testbed.errors import SpecError
from testbed.harness.objectives import measures_for, objective
from testbed.harness.run import run
from testbed.harness.sweep import Sweep, best, best_number, make_sweep, read_sweep, values, write_sweep

#: The toy refuses and fails where it is told to.
ACTS = "act=work,refuse,raise"


def swept(
    directory: Path, *over: str, scheme: str = "toy", measures: tuple[str, ...] = ("total",)
) -> tuple[Sweep, pd.DataFrame]:
    objectives = [objective(name) for name in measures]
    sweep = make_sweep(scheme, over, ["grid"], "0", objectives, measures=measures_for(objectives))
    run(sweep.plan, directory, jobs=1, tables=False)
    return sweep, read_sweep(sweep, directory)


def test_a_row_a_setting_with_its_parameters_and_one_for_the_scheme_as_given(tmp_path: Path) -> None:
    sweep, table = swept(tmp_path, "tag=1:3:3", ACTS)
    assert sweep.settings[:4] == ("toy[tag=1]", "toy[act=refuse,tag=1]", "toy[act=raise,tag=1]", "toy[tag=2]")
    assert table["setting"].tolist() == [*range(9), -1]
    assert table["tag"].tolist() == ["1", "1", "1", "2", "2", "2", "3", "3", "3", "0"]
    assert table["status"].tolist() == ["ok", "refused", "failed"] * 3 + ["ok"]
    assert table["scheme"].tolist() == [*sweep.settings, "toy"]
    assert "vertex 0" in table["reason"][1]
    found, given = values(sweep, table, sweep.objectives[0], "grid")
    assert [math.isfinite(value) for value in found] == [True, False, False] * 3
    assert given == found[0]  # tags change nothing
    # the file reads back to the same numbers, and says the same again
    first = write_sweep(tmp_path, table).read_bytes()
    read = pd.read_csv(tmp_path / "sweep.csv")
    assert read["total"].tolist()[0] == table["total"][0]
    assert write_sweep(tmp_path, read_sweep(sweep, tmp_path)).read_bytes() == first
    assert not (tmp_path / "results.csv").exists()


def test_derived_quantities_are_columns(tmp_path: Path) -> None:
    _, table = swept(tmp_path, "jensen_c=1,1.2", scheme="jensen", measures=("gauss_spread", "gauss_max"))
    assert table["gauss_spread"].tolist() == (table["gauss_max"] - table["gauss_min"]).tolist()


def test_the_best_is_the_least_or_the_largest_and_never_a_refusal() -> None:
    numbers = [math.nan, 2.0, 1.0, math.inf, 1.0, 3.0]
    assert best_number(numbers) == 2
    assert best_number(numbers, maximise=True) == 5
    assert best_number([math.nan, math.inf]) is None


def hand_made(*rows: tuple[str, list[float]], maximise: bool = False) -> tuple[Sweep, pd.DataFrame]:
    """Tell the values of three settings on datasets, and that of the scheme as given, without computing them."""
    sweep = make_sweep(
        "toy",
        ["tag=1,2,3"],
        [name for name, _ in rows],
        "0",
        [objective("total")],
        maximise=maximise,
        measures=["sums"],
    )
    cells = [
        {"setting": number, "dataset": name, "status": "refused" if math.isnan(value) else "ok", "total": value}
        for name, numbers in rows
        for number, value in zip([0, 1, 2, -1], numbers, strict=True)
    ]
    return sweep, pd.DataFrame(cells)


def test_the_best_on_each_dataset_and_the_one_for_all() -> None:
    own, other, joint = best(*hand_made(("grid", [1.0, 1.5, 9.0, 4.0]), ("grid[act=print]", [80.0, 30.0, 20.0, 40.0])))
    assert (own.setting, own.values, own.given, own.on_end) == ("toy[tag=1]", (1.0,), (4.0,), ("tag",))
    assert other.setting == "toy[tag=3]"
    # 1.5 times the best on either, where the others are 4 and 9 times the best on one
    assert (joint.setting, joint.values, joint.worst_ratio, joint.on_end) == ("toy[tag=2]", (1.5, 30.0), 1.5, ())


def test_a_setting_that_one_dataset_refuses_is_not_for_all() -> None:
    found = best(*hand_made(("grid", [1.0, 2.0, math.nan, 4.0]), ("grid[act=print]", [math.nan, 3.0, 1.0, math.nan])))
    assert [one.setting for one in found] == ["toy[tag=1]", "toy[tag=3]", "toy[tag=2]"]
    assert math.isnan(found[1].given[0])
    assert best(*hand_made(("grid", [math.nan] * 4))) == []


def test_large_values_can_be_sought() -> None:
    found = best(*hand_made(("grid", [1.0, 8.0, 9.0, 4.0]), ("grid[act=print]", [9.0, 8.0, 1.0, 1.0]), maximise=True))
    assert [one.setting for one in found] == ["toy[tag=3]", "toy[tag=1]", "toy[tag=2]"]
    assert found[-1].worst_ratio == 9.0 / 8.0


@pytest.mark.parametrize(
    ("over", "level", "words"),
    [
        ([], "0", "one or two parameters"),
        (["tag=1,2", "level=1,2", "seconds=1,2"], "0", "one or two parameters"),
        (["tag=1,2", "tag=3,4"], "0", "tag twice"),
        (["seconds=0:1:1000", "level=1:1000:1000"], "0", "1000000 settings"),
        (["tag=1,2"], "0:1", "one level"),
    ],
)
def test_bad_sweeps_are_one_sentence(over: list[str], level: str, words: str) -> None:
    with pytest.raises(SpecError, match=words):
        make_sweep("toy", over, ["grid"], level, [objective("total")])
