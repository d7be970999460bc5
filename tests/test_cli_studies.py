"""``testbed sweep`` and ``testbed tune`` as a user meets them."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest
from test_cli import command_line, sentence

SWEEP = ("sweep", "triangular-gregory", "--over", "jensen_c=1:1.2:3", "--over", "boundary=projected,hermite")


@pytest.mark.parametrize("command", ["sweep", "tune"])
def test_studies_have_help_with_an_example(command: str) -> None:
    result = command_line(command, "--help")
    assert result.returncode == 0
    assert re.search(rf"Example:\s+testbed {command}", result.stdout)


def test_a_sweep_prints_the_best_writes_its_files_and_is_resumed(tmp_path: Path) -> None:
    first = command_line(*SWEEP, "-d", "octahedron", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "triangular-gregory[boundary=hermite,jensen_c=1.2]" in first.stdout
    assert "jensen_c of triangular-gregory[boundary=hermite,jensen_c=1.2] is at the end of its range" in first.stdout
    assert "6 cells: 6 ok; 6 computed, 0 reused" in first.stdout
    table = pd.read_csv(tmp_path / "sweep" / "sweep.csv")
    assert {"jensen_c", "boundary", "dataset", "level", "status", "reason", "gauss_spread", "epsilon_deg"} <= set(table)
    assert len(table) == 7
    files = [tmp_path / "sweep" / name for name in ("sweep.csv", "sweep.svg", "sweep.png")]
    before = [path.read_bytes() for path in files]
    second = command_line(*SWEEP, "-d", "octahedron", "--json", cwd=tmp_path)
    found = json.loads(second.stdout)
    assert "0 computed" not in second.stdout
    assert found["counts"] == {"ok": 6}
    (best,) = found["best"]
    assert best["setting"] == "triangular-gregory[boundary=hermite,jensen_c=1.2]"
    assert best["values"] == [table["gauss_spread"].min()]
    assert [path.read_bytes() for path in files] == before


def test_a_search_prints_a_setting_that_can_be_pasted(tmp_path: Path) -> None:
    arguments = ("tune", "triangular-gregory[boundary=hermite]", "-d", "icosahedron", "--over", "jensen_c=1:1.1")
    shown = command_line(*arguments, cwd=tmp_path)
    assert shown.returncode == 0, shown.stderr
    setting = re.search(r"best setting  (.*)", shown.stdout)
    assert setting is not None
    assert "gain " in shown.stdout
    found = json.loads(command_line(*arguments, "--json", cwd=tmp_path).stdout)
    assert found["best"]["setting"] == setting[1]
    assert found["best"]["parameters"]["jensen_c"] == pytest.approx(1.0625, abs=1e-3)
    assert found["best"]["on_bound"] == []
    assert found["given"]["outcomes"][0]["value"] > 20.0 * found["best"]["outcomes"][0]["value"]
    record = json.loads((tmp_path / "tune" / "tune.json").read_text())
    assert record["best"] == found["best"]
    trace = pd.read_csv(tmp_path / "tune" / "tune.csv")
    assert len(trace) == found["settings"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("sweep", "flat", "--over", "jensen_c=1:2:3", "-d", "octahedron"), "flat has no parameter"),
        (("sweep", "jensen", "--over", "jensen_c=2:1:3", "-d", "octahedron"), "low is below high"),
        (("sweep", "jensen", "--over", "jensen_c=1,2", "-d", "octahedron", "--measure", "gaus"), "gauss_"),
        (("tune", "flat", "-d", "octahedron"), "flat declares no bounds"),
        (("tune", "jensen", "-d", "octahedron", "--over", "boundary"), "no real number"),
        (("tune", "jensen", "-d", "octahedron", "--level", "0:1"), "one level"),
        (("tune", "jensen", "-d", "octahedron", "-o", "file"), "is a file"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert words in sentence(command_line(*arguments, cwd=tmp_path))
