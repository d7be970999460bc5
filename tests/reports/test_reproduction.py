"""The page of a reproduction: numbers beside the figures that show them, nothing lost, nothing but text from names."""

import dataclasses
import math
import re
from pathlib import Path

import pytest

from testbed_reports.published import Agreement, PublishedRow
from testbed_reports.published_table import NotRemade, published_table
from testbed_reports.redrawn import Redrawn, Shown
from testbed_reports.reproduction import MARKS, figure_numbers, sections, write_reproduction

NASTY = "<img src=x onerror=alert(1)>&\"'"


def row(place: str, agreement: Agreement = "agrees", **changes: object) -> PublishedRow:
    names = ("mann-1992", place, "a quantity", "flat", "octahedron", "0", "faces", "8")
    plain = PublishedRow(*names, 8.0, math.nan, math.nan, agreement, "given", "", "")
    return dataclasses.replace(plain, **changes)  # type: ignore[arg-type]  # fields of a row


def picture(place: str, file: str) -> Redrawn:
    return Redrawn("mann-1992", place, file, NASTY, "lost", (Shown("", "flat", "octahedron"),), remark=NASTY)


@pytest.fixture
def image(tmp_path: Path) -> Path:
    path = tmp_path / "one.png"
    path.write_bytes(b"\x89PNG and so on")
    return path


@pytest.mark.parametrize(
    ("place", "numbers"),
    [
        ("figure 2.18 left, page 42", {"2.18"}),
        ("figures 2.20 center, page 46, and 3.6 left, page 62", {"2.20", "3.6"}),
        ("figures 6, 7, 9 and 10", {"6", "7", "9", "10"}),
        ("figures 14 to 17", {"14", "15", "16", "17"}),
        ("pictures 1 to 3", {"1", "2", "3"}),
        ("theorem 4.1, figure 13", {"13"}),
        ("section 4.2, step 8, and figure 13", {"13"}),
        ("figures 4.2 and 4.4, pages 69 and 74", {"4.2", "4.4"}),
        ("section 3.3, page 53 or 54", set()),
        ("table 5.2, page 87", set()),
        ("appendix B", set()),
    ],
)
def test_places_name_their_figures(place: str, numbers: set[str]) -> None:
    assert figure_numbers(place) == numbers


def test_numbers_stand_once_beside_the_first_figure_that_shows_them(image: Path) -> None:
    rows = [row("figure 2.18 left, page 42"), row("section 2.18, page 1"), row("figures 3.5 and 2.18")]
    pictures = [picture("figure 2.18, page 42", "a"), picture("figure 3.5", "b")]
    absent = [NotRemade("mann-1994", "p", "w", "r")]
    thesis, report = sections(rows, pictures, [image, image], absent)
    assert [[line.row for line in pair.lines] for pair in thesis.pairs] == [[rows[0], rows[2]], []]
    assert [line.row for line in thesis.others] == [rows[1]]
    assert (report.name, report.pairs, report.absent) == ("mann-1994", (), tuple(absent))


def test_every_number_of_the_table_stands_on_its_place() -> None:
    # figures of one paper are told apart by their numbers
    for figure in published_table().figures:
        assert len(figure_numbers(figure.place)) <= 2, figure.place


def test_the_page_is_text_whatever_names_are_and_the_same_again(tmp_path: Path, image: Path) -> None:
    rows = [
        row("figure 1", quantity=NASTY, scheme=NASTY),
        row("figure 1", "differs", explanation=NASTY, measured=9.0),
        row("figure 1", "differs", explanation="gone", data="lost"),
        row("page 1", "no value", reason=NASTY, measured=math.nan),
        row("page 1", printed="1 2 3", ours="1.0 2.0 3.0", measured=1.0),
    ]
    absent = [NotRemade("mann-1992", NASTY, NASTY, NASTY)]
    arguments = (rows, [picture("figure 1", "one")], [image], absent)
    path = write_reproduction(tmp_path, *arguments)
    assert path == tmp_path / "index.html"
    text = path.read_text("utf-8")
    assert "<img src=x" not in text
    assert text.count("<img ") == 1
    assert "onerror=alert(1)&gt;" in text
    assert "<script" not in text
    assert "default-src 'none'" in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)
    for verdict in ("agrees", "differs", "data lost", "no value"):
        assert f'<span class="mark {MARKS[verdict]}">{verdict}</span>' in text
    assert "3 numbers" in text
    assert "the same" in text
    write_reproduction(tmp_path, *arguments)
    assert path.read_text("utf-8") == text
