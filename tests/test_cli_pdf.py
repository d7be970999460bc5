"""The PDF as a user asks for it."""

import json
from pathlib import Path

from test_cli import command_line


def test_a_run_writes_the_pdf_where_it_is_asked_for_and_report_writes_the_same_again(tmp_path: Path) -> None:
    result = command_line("run", "-s", "flat", "-d", "ring", "--levels", "0:0", "-o", "out", "--pdf", cwd=tmp_path)
    assert result.returncode == 0
    path = tmp_path / "out" / "report.pdf"
    assert f"written: {Path('out') / 'report.pdf'}" in result.stdout
    first = path.read_bytes()
    assert first.startswith(b"%PDF")
    path.unlink()
    assert command_line("report", "out", cwd=tmp_path).returncode == 0
    assert not path.exists()
    told = json.loads(command_line("report", "out", "--pdf", "--json", cwd=tmp_path).stdout)
    assert str(Path("out") / "report.pdf") in told["written"]
    assert path.read_bytes() == first


def test_it_is_listed_and_described() -> None:
    assert "pdf" in command_line("list", "reports").stdout
    assert "report.pdf" in command_line("info", "pdf").stdout
