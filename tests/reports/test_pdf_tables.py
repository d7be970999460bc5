"""Tables fit into pages: columns are as wide as their texts, and parts as wide as pages."""

import json
import tempfile
from itertools import pairwise
from pathlib import Path

import pytest
import typst
from hypothesis import given
from hypothesis import strategies as st

from testbed_reports.formatting import Entry, shorten
from testbed_reports.pdf import lettering, widths
from testbed_reports.pdf.appendix import digits
from testbed_reports.pdf.blocks import (
    Cell,
    Column,
    Folio,
    Heading,
    Name,
    Paragraph,
    Reference,
    Small,
    Strong,
    Swatch,
    Table,
    Text,
    runs,
)
from testbed_reports.pdf.grids import BAND, bands, numbers
from testbed_reports.pdf.numbering import numbered

columns = st.lists(st.floats(1.0, 300.0), max_size=60)


@given(columns, st.floats(50.0, 800.0))
def test_parts_hold_every_column_once_in_order_and_fit(wide: list[float], room: float) -> None:
    found = widths.parts(wide, room)
    assert [column for part in found for column in part] == list(range(len(wide)))
    assert all(len(part) == 1 or sum(wide[column] for column in part) <= room for part in found)


@given(columns, st.floats(50.0, 800.0))
def test_parts_are_as_few_as_can_be(wide: list[float], room: float) -> None:
    # taking columns as long as they fit is best: every part could not take the next column
    used, count = 0.0, min(len(wide), 1)
    for width in wide:
        used += width
        if used > room and used > width:
            used, count = width, count + 1
    assert len(widths.parts(wide, room)) == count


def test_parts_are_about_equally_wide() -> None:
    assert [len(part) for part in widths.parts([10.0] * 12, 100.0)] == [6, 6]


def made(count: int, **options: object) -> list[Table]:
    headings = [f"quantity_{number}" for number in range(count)]
    rows = [tuple(f"{row + column / 7.0:.5g}" for column in range(count)) for row in range(5)]
    names = [Cell(runs(Swatch(row), Name(f"scheme-{row}"))) for row in range(5)]
    return list(numbers("table", "Numbers.", names, 90.0, headings, rows, 400.0, 7.0, **options))  # type: ignore[arg-type]


def test_a_wide_table_comes_in_parts_that_fit_and_begin_with_the_schemes() -> None:
    found = made(40)
    assert len(found) > 1
    assert len({table.label for table in found}) == len(found)
    for table in found:
        assert sum(column.width for column in table.columns) <= 400.0
        assert all(len(row) == len(table.columns) for row in (*table.head, *table.rows))
        assert [row[0] for row in table.rows] == [row[0] for row in found[0].rows]
    numbers_found = [cell for table in found for cell in table.rows[0][1:]]
    assert numbers_found == [f"{column / 7.0:.5g}" for column in range(40)]


def test_repeated_columns_stand_in_every_part() -> None:
    found = made(40, repeated=1)
    assert all(table.rows[3][1] == "3" for table in found)
    assert sum(len(table.columns) - 2 for table in found) == 39


def test_headings_over_columns_cover_those_of_their_part() -> None:
    for table in made(40, groups=[("a", 13), ("", 2), ("b", 25)]):
        over = [cell for cell in table.head[0] if isinstance(cell, Cell)]
        assert sum(cell.span for cell in over) == len(table.columns) - 1


def test_rows_of_one_line_are_set_together_and_others_alone() -> None:
    tall = Cell((Text("1"), Small("face 2", apart=True)))
    found = [("a", "1")] * 10 + [("b", tall)] + [("c", Cell(runs("refused"), 2))] + [("d", "2"), ("e", "3")]
    assert bands(found, [Column(width=60.0)] * 2, 7.0) == (BAND, 10 - BAND, 1, 1, 2)
    assert bands([("a long name that wraps " * 3, "1"), ("a", "2")], [Column(width=60.0)] * 2, 7.0) == (1, 1)


def test_rows_of_a_scheme_are_set_under_its_name() -> None:
    name = Cell(runs(Name("scheme")))
    (table,) = numbers("t", "", [name, name, "other"], 60.0, ["n"], [("1",), ("2",), ("3",)], 400.0, 7.0, together=True)
    assert table.bands == (2, 1)
    assert [row[0] for row in table.rows] == [name, "", "other"]


@pytest.mark.parametrize(
    "value", [0.0, 1.0, 123.0, -0.00123456, 1e-9, -4.56e-13, 99.9, 1e300, float("inf"), float("nan")]
)
def test_columns_are_as_wide_as_typst_makes_their_numbers(value: float) -> None:
    text = lettering.number(shorten(value))
    needed = measured(f'text(size: 10pt, number-width: "tabular", font: "Libertinus Serif", "{text}")')
    assert needed <= widths.of_column("", [text], 10.0) - widths.GUTTER + 0.5
    strong = f'strong(text(size: 10pt, number-width: "tabular", font: "Libertinus Serif", "{text}"))'
    assert measured(strong) <= widths.of_column("", [Cell((Strong(text),))], 10.0) - widths.GUTTER + 0.5


def test_columns_are_as_wide_as_typst_makes_places_and_names() -> None:
    place = "1234 (0.333 0.333 0.334)"
    assert measured(f'text(size: 10pt, font: "Libertinus Serif", "{place}")') <= widths.of_column("", [place], 10.0)
    text = "triangular-gregory"
    needed = measured(f'text(size: 8.4pt, font: "DejaVu Sans Mono", "{text}")')
    assert needed <= widths.of_names([text], 10.0, swatch=False)


def measured(content: str) -> float:
    """Width of content in points."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "measured.typ"
        path.write_text(f"#context [#metadata(measure({content}).width / 1pt)<width>]", "utf-8")
        return float(json.loads(typst.query(path, "<width>", field="value", one=True)))


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        (Entry("0.123", "0.12345678"), "0.12346"),
        (Entry("0.123", "0.12345678; guaranteed from 0.1 to 0.2"), "0.12346"),
        (Entry("-1.23e-9", "-1.23456789e-09"), "−1.2346e−9"),
        (Entry("–", ""), "–"),
        (Entry("–", "no order can be told"), "–"),
        (Entry("12", ""), "12"),
    ],
)
def test_the_appendix_has_five_digits(entry: Entry, text: str) -> None:
    assert digits(entry) == text


def table(label: str, *parts: str | Reference) -> Table:
    return Table(label, runs(*parts), (Column(),), (), ())


def test_numbers_count_through_the_document_and_references_say_them() -> None:
    first = Folio((Heading(1, runs("One"), "one"), table("a"), Paragraph(runs("see ", Reference("b")))))
    second = Folio((Heading(1, runs("Two"), "two"), Heading(2, runs("Part"), "part"), table("b", Reference("part"))))
    found = numbered([first, second])
    assert [getattr(block, "number", None) for folio in found for block in folio.blocks] == [
        "1",
        "Table 1",
        None,
        "2",
        "2.1",
        "Table 2",
    ]
    assert found[0].blocks[2] == Paragraph(runs("see ", Reference("b", "Table 2")))
    assert found[1].blocks[2].caption == (Reference("part", "section 2.1"),)  # type: ignore[union-attr]


def test_a_reference_to_nothing_is_an_error() -> None:
    with pytest.raises(KeyError, match="nowhere"):
        numbered([Folio((Paragraph(runs(Reference("nowhere"))),))])


def test_labels_of_a_table_in_parts_differ() -> None:
    assert all(one.label != other.label for one, other in pairwise(made(60)))
