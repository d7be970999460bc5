"""``testbed ranges`` as a user meets it."""

import csv
import json
import re
from pathlib import Path

import pytest
from test_cli import command_line

from testbed.cli import ranging
from testbed_reports.range_comparison import Comparison, RangeSet, comparison


def test_ranges_has_help_with_an_example() -> None:
    result = command_line("ranges", "--help")
    assert result.returncode == 0
    assert re.search(r"Example:\s+testbed ranges", result.stdout)


def test_ranges_prints_tables_and_writes_them(tmp_path: Path) -> None:
    result = command_line("ranges", "--sets", "1", "-j", "1", "--no-pictures", "-o", "out", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    for part in ("lowest signed distance", "schemes over all sets", "Who stays above the plane", "Who stays smooth"):
        assert part in result.stdout
    with (tmp_path / "out" / "ranges.csv").open() as file:
        rows = {row["label"]: row for row in csv.DictReader(file)}
    assert float(rows["unconstrained"]["lowest"]) < 0.0 < float(rows["constrained"]["lowest_bound"])
    assert float(rows["Clough-Tocher"]["lowest"]) < 0.0 <= float(rows["positive Clough-Tocher"]["lowest_bound"])
    assert float(rows["clipped Clough-Tocher"]["crease_deg"]) > 1.0
    for label in ("unconstrained", "constrained"):
        assert float(rows[label]["epsilon_deg"]) < 1e-8
        assert float(rows[label]["data_max"]) == 0.0
    page = (tmp_path / "out" / "ranges.html").read_text()
    assert "<figure>" not in page
    assert "who is nearer the truth" in page


def test_ranges_as_json_with_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    few = comparison()
    schemes = tuple(one for one in few.schemes if one.label in ("Clough-Tocher", "flat"))
    small = RangeSet("scattered[points=12,field=noise,normals=none,ground=0.001]")
    monkeypatch.setattr(ranging, "comparison", lambda: Comparison(schemes, (small,)))
    assert ranging.ranges_command(tmp_path, None, 1, pictures=True, as_json=True) == 0
    record = json.loads(capsys.readouterr().out)
    assert [row["status"] for row in record["rows"]] == ["ok", "ok"]
    assert record["rows"][0]["moved"] is None
    assert record["rows"][0]["lowest"] < 0.0 < record["rows"][1]["lowest"]
    assert record["written"] == [str(tmp_path / name) for name in ("ranges.csv", "ranges.html")]
    assert "data:image/png;base64," in (tmp_path / "ranges.html").read_text()


def test_a_file_in_place_of_the_directory_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("")
    result = command_line("ranges", "-o", "out", cwd=tmp_path)
    assert result.returncode == 2
    assert "out is a file: name a directory with -o" in result.stderr
