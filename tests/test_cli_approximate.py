"""``testbed approximate`` as a user meets it."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from test_cli import command_line, sentence


def test_approximate_has_help_with_an_example() -> None:
    result = command_line("approximate", "--help")
    assert result.returncode == 0
    assert re.search(r"Example:\s+testbed approximate", result.stdout)


def test_an_approximation_prints_its_history_and_writes_its_files(tmp_path: Path) -> None:
    arguments = ("approximate", "ellipsoid", "--epsilon", "0.4", "--distance", "1e-3", "-o", "out")
    result = command_line(*arguments, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "reached: all bounds are reached after 3 refinements" in result.stdout
    out = tmp_path / "out"
    for name in ("refinement.png", "history.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    with (out / "history.csv").open() as file:
        rows = list(csv.DictReader(file))
    record = json.loads((out / "approximation.json").read_text())
    mesh = np.load(out / "mesh.npz")
    assert [int(row["faces"]) for row in rows] == [step["faces"] for step in record["history"]]
    assert float(rows[-1]["epsilon_deg"]) <= 0.4
    assert float(rows[-1]["distance"]) <= 1e-3
    assert rows[-1]["distance_certified"] == "True"
    assert (record["dataset"], record["epsilon_deg"], record["distance"]) == ("ellipsoid", 0.4, 1e-3)
    assert record["reached"] is True
    assert record["command"] == ["testbed", *arguments]
    assert mesh["faces"].shape == (int(rows[-1]["faces"]), 3)
    assert mesh["control_points_0"].shape == (len(mesh["faces"]), 10, 3)
    assert np.bincount(mesh["face_levels"]).tolist() == record["faces_by_level"]
    assert mesh["edge_jumps_deg"].max() <= 0.4
    assert {"points", "normals", "second_forms", "edges", "edge_levels", "face_distances"} <= set(mesh)
    # the same again, but for the times
    again = json.loads(command_line(*arguments, "--json", cwd=tmp_path).stdout)
    for step in (*again["history"], *record["history"]):
        del step["seconds"]
    assert again["history"] == record["history"]
    assert len(again["written"]) == 5


def test_bounds_that_are_not_reached_are_exit_code_1_with_what_prevents_it(tmp_path: Path) -> None:
    result = command_line("approximate", "torus", "--epsilon", "0.01", "--steps", "1", "-o", "out", cwd=tmp_path)
    assert result.returncode == 1
    assert "not reached (most steps): 1 refinements are done: epsilon is" in result.stdout
    assert "~ distances are sampled only: --distance asks for a bound of them" in result.stdout
    assert (tmp_path / "out" / "refinement.png").exists()
    refused = command_line("approximate", "torus", "--epsilon", "1", "-s", "peters-cubic", "-o", "out", cwd=tmp_path)
    assert refused.returncode == 1
    assert "not reached (refused): the start mesh is refused" in refused.stdout


def test_distances_without_a_guarantee_say_so(tmp_path: Path) -> None:
    arguments = ("--epsilon", "1", "--distance", "0.1", "-s", "nielson")
    result = command_line("approximate", "sphere", *arguments, cwd=tmp_path)
    assert result.returncode == 0
    assert "~ distances are not guaranteed" in result.stdout
    assert "~ epsilon is sampled and searched only" in result.stdout
    assert (tmp_path / "approximation" / "history.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("elipsoid", "--epsilon", "1"), "did you mean ellipsoid?"),
        (("ellipsoid", "--epsilon", "1", "-s", "cubik-interpolant"), "did you mean cubic-interpolant?"),
        (("ellipsoid", "--epsilon", "0"), "epsilon cannot be 0"),
        (("ellipsoid", "--epsilon", "nan"), "epsilon cannot be nan"),
        (("ellipsoid", "--epsilon", "1", "--distance", "-1"), "distance cannot be -1"),
        (("ellipsoid", "--epsilon", "1", "--split", "thirds"), "template or longest-edge"),
        (("ellipsoid", "--epsilon", "1", "--criterion", "felt"), "exact or sampled"),
        (("mesh", "--epsilon", "1"), "no exact surface"),
        (("quad-torus", "--epsilon", "1"), "4 sides"),
        (("ellipsoid", "--epsilon", "1", "-o", "file"), "is a file"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert words in sentence(command_line("approximate", *arguments, cwd=tmp_path))
    assert not (tmp_path / "approximation").exists()
