"""``testbed export`` as a user meets it."""

from pathlib import Path

import pytest
from test_cli import command_line, sentence


def test_it_has_help_with_an_example() -> None:
    result = command_line("export", "--help")
    assert result.returncode == 0
    assert "Example:" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("new/a.glb", "--field", "gauss", "--triangles", "300"), "288 triangles"),
        (("new/a.vtu",), "8 Bézier cells"),
    ],
)
def test_it_tells_what_it_writes_and_writes_the_same_bytes_in_another_process(
    arguments: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    result = command_line("export", "cubic-interpolant", "-d", "octahedron", "-o", *arguments, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert f"{arguments[0]}: {told}" in result.stdout
    before = (tmp_path / arguments[0]).read_bytes()
    command_line("export", "cubic-interpolant", "-d", "octahedron", "-o", *arguments, cwd=tmp_path)
    assert (tmp_path / arguments[0]).read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nielson", "-d", "sphere", "-o", "a.stl"), "does not end in the name of a format: take .glb"),
        (("nielson", "-d", "sphere", "-o", "a.vtu"), "write triangles with --tessellated"),
        (("flat", "-d", "sphere", "-o", "a.glb", "--field", "torsion"), "there is no field 'torsion': take gauss"),
        (("flat", "-d", "mesh", "-o", "a.glb", "--field", "distance"), "no exact surface"),
        (("bicubic-interpolant", "-d", "sphere", "-o", "a.ply"), "takes meshes of quadrilaterals"),
        (("flat", "-d", "sphere", "-o", "there/a.ply"), "cannot be written"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    (tmp_path / "there").write_text("a file")
    assert words in sentence(command_line("export", *arguments, cwd=tmp_path))
    assert sorted(file.name for file in tmp_path.iterdir()) == ["there"]
