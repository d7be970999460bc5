"""The command line as a user meets it: in a process of its own, with its output and its exit code."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

FLAT = ("-s", "flat", "-d", "octahedron", "--levels", "0:2")


def command_line(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", "from testbed.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=300, check=False)  # noqa: S603


def sentence(result: subprocess.CompletedProcess[str]) -> str:
    """What a refused command says: one line on standard error, nothing else."""
    assert result.returncode == 2, result
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1, result.stderr
    return result.stderr


def test_help_comes_without_the_heavy_libraries() -> None:
    code = (
        "import sys; sys.argv = ['testbed', '--help']\n"
        "from testbed.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(sorted(sys.modules.keys() & {'numpy', 'scipy', 'pandas', 'matplotlib', 'trimesh'}))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: S603
    assert found.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("command", ["run", "plan", "list", "info", "check", "report"])
def test_every_command_has_help_with_an_example(command: str) -> None:
    result = command_line(command, "--help")
    assert result.returncode == 0
    assert re.search(rf"Example:\s+testbed {command}", result.stdout)


def test_a_run_writes_its_files_and_a_second_computes_nothing(tmp_path: Path) -> None:
    first = command_line("run", *FLAT, "-o", "out", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    for name in ("results.csv", "orders.csv", "run.json", "index.html"):
        assert (tmp_path / "out" / name).stat().st_size > 0
    assert "octahedron, level 2" in first.stdout
    assert "index.html" in first.stdout
    assert "3 cells: 3 ok; 3 computed, 0 reused" in first.stdout
    before = (tmp_path / "out" / "results.csv").read_bytes()
    second = command_line("run", *FLAT, "-o", "out", cwd=tmp_path)
    assert "0 computed, 3 reused" in second.stdout
    assert (tmp_path / "out" / "results.csv").read_bytes() == before
    again = command_line("report", "out", cwd=tmp_path)
    assert again.returncode == 0
    assert "octahedron, level 2" in again.stdout
    plan = command_line("plan", *FLAT, "-o", "out", cwd=tmp_path)
    assert "3 cells, 0 to compute, 3 known" in plan.stdout


def test_json_is_all_there_is_on_standard_output(tmp_path: Path) -> None:
    result = json.loads(command_line("run", *FLAT, "-o", "out", "--json", cwd=tmp_path).stdout)
    assert [cell["level"] for cell in result["cells"]] == [0, 1, 2]
    assert result["counts"] == {"ok": 3}
    assert json.loads(command_line("report", "out", "--json", cwd=tmp_path).stdout)["cells"] == result["cells"]
    assert len(json.loads(command_line("plan", *FLAT, "--json", cwd=tmp_path).stdout)["cells"]) == 3
    assert {"schemes", "curves", "datasets", "measures", "reports", "not_built", "problems"} == set(
        json.loads(command_line("list", "--json").stdout)
    )


def test_a_refused_cell_is_a_result_and_a_mesh_file_a_dataset(tmp_path: Path) -> None:
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 1 1 0.2", "f 1 2 3", "f 2 4 3"]
    (tmp_path / "two.obj").write_text("\n".join(lines) + "\n")
    result = command_line(
        "run", "-s", "cubic-interpolant", "-s", "flat", "-d", "mesh:two.obj", "-o", "out", cwd=tmp_path
    )
    assert result.returncode == 0, result.stderr
    assert "1 ok, 1 refused" in result.stdout
    assert "second" in result.stdout
    assert "mesh:two.obj" in result.stdout


def test_unknown_names_suggest_the_nearest() -> None:
    assert "did you mean shirman-sequin?" in sentence(command_line("run", "-s", "shirman-sekin"))
    assert "did you mean torus?" in sentence(command_line("plan", "-d", "torsu"))
    assert "did you mean minor?" in sentence(command_line("plan", "-d", "torus[miner=0.4]"))
    assert "did you mean nielson?" in sentence(command_line("info", "nielsen"))
    assert "did you mean nielson?" in sentence(command_line("check", "nielsen"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "--levels", "4:0", "-d", "octahedron"), "4:0"),
        (("run", "--levels", "x"), "'x'"),
        (("report", "nowhere"), "nowhere"),
        (("run", "-d", "mesh:absent.ply"), "absent.ply"),
        (("list", "sheep"), "sheep"),
        (("run", "-d", "torus[minor=2]"), "minor"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    assert words in sentence(command_line(*arguments, cwd=tmp_path))


def test_a_traceback_is_shown_when_asked_for() -> None:
    assert "Traceback" not in command_line("info", "sheep").stderr
    assert "Traceback" in command_line("info", "sheep", "--traceback").stderr


def test_check_prints_each_property_and_its_exit_code_tells_of_failures(tmp_path: Path) -> None:
    assert command_line("check", "flat").returncode == 0
    (tmp_path / "liar.py").write_text(
        "from dataclasses import dataclass\n"
        "from testbed.registry import hookimpl, scheme\n"
        "from testbed_schemes.flat import Flat\n"
        "@dataclass(frozen=True)\n"
        "class Liar(Flat):\n    name = 'liar'\n    title = 'Liar'\n    reproduces = tuple(type(Flat.reproduces[0]))\n"
        "@hookimpl\ndef testbed_schemes(): return ['liar']\n"
    )
    code = f"import os, sys; sys.path.insert(0, {str(tmp_path)!r}); os.environ['TESTBED_PLUGINS'] = 'liar'\n"
    code += "sys.argv = ['testbed', 'check', 'liar', '--json']\nfrom testbed.cli import main; main()"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)  # noqa: S603
    assert result.returncode == 1
    found = {one["property"]: one for one in json.loads(result.stdout)["liar"]}
    assert found["reproduces spheres"]["status"] == "failed"
    assert (
        "octahedron" in found["reproduces spheres"]["detail"] or "tetrahedron" in found["reproduces spheres"]["detail"]
    )
    assert found["interpolates points"]["status"] == "passed"


def test_info_shows_citation_claims_and_parameters() -> None:
    text = command_line("info", "shirman-sequin").stdout
    for words in ("1987", "G1", "jensen_c", "alpha2", "boundary"):
        assert words in text


def test_info_tells_claims_verdicts_and_cost_of_a_scheme_with_its_parameters() -> None:
    told = command_line("info", "shirman-sequin[boundary=hermite]").stdout
    for text in (
        "shirman-sequin[boundary=hermite]",
        "second forms",
        "3 Bézier triangles of degree 4",
        "45 control points",
    ):
        assert text in told
    assert re.search(r"checks +(\d+) of \1 passed", told)
    assert re.search(r"cost of a jet +[0-9.]+ cubic triangles", told)


def test_info_tells_why_a_published_scheme_is_not_built() -> None:
    told = command_line("info", "farin-1983")
    assert told.returncode == 0
    assert "not built" in told.stdout
    assert "farin-1983" in command_line("list", "schemes").stdout


@pytest.mark.parametrize("command", ["run", "check", "sweep", "tune"])
def test_help_shows_how_parameters_are_written(command: str) -> None:
    told = " ".join(command_line(command, "--help").stdout.split())
    assert "name[field=value,...]" in told.replace(" │ │ ", " ").replace("│ │ ", "")
    assert "[boundary=hermite]" in told
