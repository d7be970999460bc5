"""The pictures that papers print: rows that can be drawn, and are."""

from pathlib import Path

import pytest

from testbed import registry
from testbed.errors import SpecError, TestbedError
from testbed_reports.redrawn import draw_again, parse_redrawn, pictures_of, redrawn_table

ROW = """
[[pictures]]
paper = "xu-huang-bajaj-2001"
place = "figure 1"
file = "one"
title = "One"
style = "shaded"
view = [0, 90]
data = "given"
shows = [{ title = "flat", scheme = "flat", dataset = "octahedron", level = 0 }]
"""


@pytest.mark.parametrize("picture", redrawn_table(), ids=lambda picture: f"{picture.paper}-{picture.file}")
def test_every_picture_shows_what_is_registered(picture: object) -> None:
    (one,) = [candidate for candidate in redrawn_table() if candidate is picture]
    for shown in one.shows:
        assert registry.scheme(shown.scheme).fit(registry.dataset(shown.dataset).mesh(shown.level)).patch_count


def test_pictures_are_drawn_into_a_folder_of_their_paper_the_same_each_time(tmp_path: Path) -> None:
    (picture,) = parse_redrawn(ROW)
    (path,) = draw_again(tmp_path, [picture], 64)
    assert path == tmp_path / "figures" / "xu-huang-bajaj-2001" / "one.png"
    (again,) = draw_again(tmp_path / "again", [picture], 64)
    assert path.read_bytes() == again.read_bytes()


def test_papers_have_their_pictures() -> None:
    assert {one.paper for one in pictures_of("xu-huang-bajaj-2001")} == {"xu-huang-bajaj-2001"}
    assert pictures_of("all") == redrawn_table()
    with pytest.raises(SpecError, match="did you mean xu-huang-bajaj-2001"):
        pictures_of("xu-huang-bajaj-2002")


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        (ROW.replace('style = "shaded"', 'style = "stripes"'), "style is 'stripes'"),
        (ROW.replace("2001", "1999"), "paper is 'xu-huang-bajaj-1999'"),
        (ROW.replace('data = "given"', 'data = "found"'), "data is 'found'"),
        (ROW.replace("view = [0, 90]", "view = [0]"), "picture 1 has other fields"),
        (ROW.replace("file =", "name ="), "picture 1 has other fields"),
        (ROW.replace("level = 0", "levels = 0"), "picture 1 has other fields"),
        (ROW + ROW, "are called one"),
    ],
)
def test_rows_that_are_no_pictures_are_named(row: str, sentence: str) -> None:
    with pytest.raises(TestbedError, match=sentence):
        parse_redrawn(row)
