"""``testbed diff`` as a user meets it."""

import json
from pathlib import Path

import pytest
from test_cli import command_line, sentence

HEAD = "scheme,dataset,level,status,reason,distance_max,gauss_max,fit_seconds\n"
OLD = HEAD + "s,d,0,ok,,0.5,1.0,1.0\ns,d,1,ok,,0.1,inf,1.0\ns,[red]d,0,ok,,0.5,1.0,1.0\n"
NEW = HEAD + "s,d,0,ok,,0.75,1.25,9.0\ns,d,1,ok,,0.1,2.0,1.0\ns,[red]d,0,failed,[bold]no[/bold],,,\n"


@pytest.fixture
def tables(tmp_path: Path) -> Path:
    for name, text in (("old.csv", OLD), ("new.csv", NEW)):
        (tmp_path / name).write_text(text)
    return tmp_path


def test_it_tells_what_is_worse_and_fails_where_asked_to(tables: Path) -> None:
    told = command_line("diff", "old.csv", "new.csv", cwd=tables)
    assert told.returncode == 0, told.stderr
    first, *rest = told.stdout.splitlines()
    assert first == "old.csv -> new.csv: 3 cells in both: 2 regressed, 1 changed"
    assert "old.csv holds cells alone: orders and verdicts are not compared" in rest
    rows = [" ".join(line.split()) for line in rest if line.startswith(("regressed", "changed"))]
    assert rows == [
        "regressed cell s [red]d 0 status ok failed [bold]no[/bold]",
        "regressed cell s d 0 distance_max 0.5 0.75 1.5 and 1 more of the cell",
        "changed cell s d 1 gauss_max inf 2 0",
    ]
    failing = command_line("diff", "old.csv", "new.csv", "--fail-on", "regressed", cwd=tables)
    assert (failing.returncode, failing.stdout) == (1, told.stdout)
    better = command_line("diff", "old.csv", "old.csv", "--fail-on", "changed", cwd=tables)
    assert better.returncode == 0
    assert "3 cells in both: 3 unchanged" in better.stdout


def test_json_has_everything_and_is_json(tables: Path) -> None:
    arguments = ("diff", "old.csv", "new.csv", "--seconds", "0.5", "--fail-on", "changed", "--json")
    result = command_line(*arguments, cwd=tables)
    assert result.returncode == 1
    found = json.loads(result.stdout, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert found["failed"]
    assert found["cells"] == {"changed": 1, "regressed": 2}
    by_quantity = {(one["level"], one["quantity"]): one for one in found["differences"]}
    assert by_quantity[0, "fit_seconds"]["kind"] == "regressed"
    assert by_quantity[1, "gauss_max"]["old"] == "inf"
    assert by_quantity[0, "status"]["factor"] is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("old.csv", "nowhere"), "nowhere does not exist"),
        (("old.csv", "new.csv", "--fail-on", "worse"), "take regressed or changed"),
        (("old.csv", "new.csv", "--tolerance", "nan"), "--tolerance cannot be nan"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tables: Path) -> None:
    assert words in sentence(command_line("diff", *arguments, cwd=tables))


def test_it_has_help_with_an_example() -> None:
    result = command_line("diff", "--help")
    assert result.returncode == 0
    assert "Example:" in result.stdout
