"""``testbed render`` as a user meets it."""

from pathlib import Path

import pytest
from test_cli import command_line, sentence


def test_it_has_help_with_an_example() -> None:
    result = command_line("render", "--help")
    assert result.returncode == 0
    assert "Example:" in result.stdout


def test_it_draws_schemes_side_by_side_and_says_what_it_could_not_draw(tmp_path: Path) -> None:
    arguments = (
        "render",
        "nielson",
        "bicubic-interpolant",
        "flat",
        "-d",
        "octahedron",
        "--style",
        "gauss",
        "--size",
        "80",
    )
    result = command_line(*arguments, "-o", "new/k.png", cwd=tmp_path)
    assert result.returncode == 1
    assert "not drawn:" in result.stdout
    assert "quadrilaterals" in result.stdout
    assert (tmp_path / "new" / "k.png").read_bytes().startswith(b"\x89PNG")
    again = command_line(*arguments, "-o", "again.png", cwd=tmp_path)
    assert again.returncode == 1
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "new" / "k.png").read_bytes()


def test_it_draws_nets_and_extremes(tmp_path: Path) -> None:
    plain = ("render", "cubic-interpolant", "-d", "octahedron", "--style", "gauss", "--size", "80")
    for name, options in (("plain", ()), ("net", ("--net",)), ("extremes", ("--extremes",))):
        assert command_line(*plain, *options, "-o", f"{name}.png", cwd=tmp_path).returncode == 0
    assert len({path.read_bytes() for path in tmp_path.glob("*.png")}) == 3


def test_it_draws_boundary_curves_and_says_which_it_could_not(tmp_path: Path) -> None:
    # plain normals only: geometric Hermite curves need second fundamental forms
    arguments = ("render", "--curves", "hermite", "projected", "-d", "jug", "--size", "80", "-o", "curves.png")
    result = command_line(*arguments, cwd=tmp_path)
    assert result.returncode == 1
    assert "not drawn:" in result.stdout
    assert "hermite" in result.stdout
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nielson", "-d", "sphere", "--style", "stripes"), "there is no style 'stripes': take shaded"),
        (("nielson", "-d", "sphere", "--view", "30"), "no view: give azimuth and elevation"),
        (("nielson", "-d", "sphere", "--view", "30,nan"), "does not exist"),
        (("nielson", "-d", "sphere", "-o", "surface.jpg"), "does not end in .png"),
        (("flat", "-d", "mesh", "--style", "distance"), "no exact surface"),
        (("bicubic-interpolant", "-d", "sphere"), "takes meshes of quadrilaterals"),
        (("nielsen", "-d", "sphere"), "nielson"),
        (("nielson", "-d", "sphere", "--limit", "-1"), "limit"),
        (("nielson", "-d", "sphere", "--extremes"), "--extremes marks curvatures, and shaded shows none"),
        (("--curves", "nielson", "-d", "sphere"), "nielson"),
        (("--curves", "hermite", "-d", "sphere", "--style", "gauss"), "--style is about surfaces"),
        (("--curves", "hermite", "-d", "sphere", "--no-edges"), "--edges is about surfaces"),
        (("--curves", "hermite", "-d", "jug"), "second fundamental forms"),
    ],
)
def test_bad_usage_is_one_sentence_and_exit_code_2(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    result = command_line("render", *arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert words in sentence(result)
