"""``testbed reproduce`` as a user meets it."""

import json
from pathlib import Path

from test_cli import command_line, sentence

from testbed_reports.published_table import derived_of, figures_of, not_remade_of
from testbed_reports.redrawn import pictures_of

PAPER = "si-ping-2015"


def test_it_has_help_with_an_example() -> None:
    result = command_line("reproduce", "--help")
    assert result.returncode == 0
    assert "Example:" in result.stdout


def test_it_tells_all_numbers_draws_all_figures_and_says_what_is_not_remade(tmp_path: Path) -> None:
    result = command_line("reproduce", PAPER, "-o", "out", "--json", cwd=tmp_path)
    assert result.returncode == 0
    found = json.loads(result.stdout)
    assert len(found["figures"]) == len(figures_of(PAPER)) + len(derived_of(PAPER))
    assert {one["agreement"] for one in found["figures"]} == {"agrees"}
    assert all(abs(one["difference"]) <= one["within"] for one in found["figures"])
    assert [one["file"] for one in found["pictures"]] == [one.file for one in pictures_of(PAPER)]
    for one in found["pictures"]:
        assert (tmp_path / one["written"]).read_bytes().startswith(b"\x89PNG")
    assert [one["place"] for one in found["not_remade"]] == [one.place for one in not_remade_of(PAPER)]
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    assert page.count("<img ") == len(found["pictures"])


def test_a_directory_that_is_a_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("")
    result = command_line("reproduce", PAPER, "-o", "out", cwd=tmp_path)
    assert result.returncode == 2
    assert "out is a file: name a directory with -o" in sentence(result)
