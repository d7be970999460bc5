"""The table of published figures: its rows, how numbers compare, that every row comes out or is explained."""

import dataclasses
import json
import math
import subprocess
import sys
from html import escape
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed import registry
from testbed.cli import reproducing
from testbed.cli.reproducing import reproduce_command
from testbed.errors import SpecError, TestbedError
from testbed.harness.results import read_results
from testbed.plugins.measure import Column
from testbed_reports import published
from testbed_reports.derived import Measured, compare_derived, measure_derived
from testbed_reports.published import (
    Agreement,
    PublishedRow,
    comes_out,
    compare,
    decimals,
    farthest,
    published_rows,
    rounds_to,
    write_published,
)
from testbed_reports.published_table import (
    DerivedFigure,
    Figure,
    derived_of,
    figures_of,
    parse_table,
    published_table,
)
from testbed_reports.redrawn import pictures_of

#: A row of a file in the format of published.toml.
ROW = """
[papers.somebody-2001]
citation = "Somebody, 2001"
[[figures]]
paper = "somebody-2001"
place = "page 1"
quantity = "faces"
scheme = "flat"
dataset = "octahedron"
level = 0
column = "faces"
printed = "8"
data = "given"
"""
FLAT = Figure("mann-1992", "page 1", "faces", "flat", "octahedron", "faces", "8", "given", level=0)


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_a_value_rounds_to_what_it_is_printed_as(value: float, digits: int) -> None:
    printed = f"{value:.{digits}f}"
    assert rounds_to(value, printed)
    assert decimals(printed) == digits
    assert not rounds_to(value + 1.01 * 10.0**-digits, printed)
    assert not rounds_to(value - 1.01 * 10.0**-digits, printed)


@pytest.mark.parametrize(
    ("value", "printed", "agrees"),
    [
        (1.4459, "1.4", True),
        (2.4593, "2.5", True),
        (2.5147, "2.5", True),
        (0.5148, "0.51", True),
        (0.5151, "0.51", False),
        (0.7448, "0.75", False),
        (234.88, "235", True),
        (261.5, "235", False),
        (-298.37, "-298", True),
        (298.37, "-298", False),
        (2.45, "2.4", True),
        (2.45, "2.5", True),
        (1.4459, "1.40", False),
        (math.nan, "1.4", False),
        (math.inf, "5", False),
    ],
)
def test_numbers_compare_at_the_printed_digits(value: float, printed: str, agrees: bool) -> None:
    assert rounds_to(value, printed) is agrees


def test_every_row_names_what_there_is() -> None:
    columns: dict[str, Column] = {column.name: column for one in registry.measures() for column in one.columns}
    table = published_table()
    assert table.figures
    for figure in table.figures:
        assert figure.place
        assert figure.quantity
        registry.scheme(figure.scheme)
        dataset = registry.dataset(figure.dataset)
        assert figure.column in columns
        if figure.level is None:
            assert columns[figure.column].converges
        else:
            assert 0 <= figure.level <= dataset.finest
    places = [(one.place, one.scheme, one.dataset, one.level, one.column) for one in table.figures]
    assert len(set(places)) == len(places)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('printed = "8"', "printed = 8", "printed is 8, and should be a str"),
        ('printed = "8"', 'printed = "eight"', "decimal number"),
        ('printed = "8"', 'printed = "nan"', "decimal number"),
        ("level = 0", 'level = "0"', "level is '0', and should be a int"),
        ('data = "given"', 'data = "guessed"', "one of given, reconstructed, lost, general"),
        ('paper = "somebody-2001"', 'paper = "nobody"', "no paper 'nobody'"),
        ('printed = "8"', 'printed = "8 9"', "decimal number"),
        ('printed = "8"', 'printed = "8"\nwithin = -1.0', "within is -1.0"),
        ('printed = "8"', 'printed = "8"\nwithin = "0"', "within is '0'"),
        ('column = "faces"', 'colum = "faces"', "colum"),
        ('column = "faces"', "", "column"),
    ],
)
def test_a_row_that_is_no_figure_is_named(old: str, new: str, says: str) -> None:
    assert parse_table(ROW).figures[0].printed == "8"
    with pytest.raises(TestbedError, match="published figure 1") as caught:
        parse_table(ROW.replace(old, new))
    assert says in str(caught.value)


def test_an_unknown_paper_is_told_the_nearest() -> None:
    with pytest.raises(SpecError, match="did you mean mann-1992"):
        figures_of("man-1992")
    assert figures_of("all") == published_table().figures
    command = [sys.executable, "-c", "from testbed.cli import main; main()", "reproduce", "man-1992"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    assert (result.returncode, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert "did you mean mann-1992" in result.stderr


def quick(figures: tuple[DerivedFigure, ...]) -> tuple[DerivedFigure, ...]:
    """Leave out the approximations that take more than a second."""
    return tuple(one for one in figures if one.source != "approximation" or one.dataset == "ellipsoid")


def test_every_published_figure_comes_out_or_is_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reproducing, "derived_of", lambda paper: quick(derived_of(paper)))
    monkeypatch.setattr(
        reproducing, "pictures_of", lambda paper: tuple(p for p in pictures_of(paper) if p.file == "2-15")
    )
    assert reproduce_command("all", tmp_path, 2, as_json=False) == 0
    printed = capsys.readouterr().out
    rows = published_rows(tmp_path)
    derived = quick(published_table().derived)
    assert {one.source for one in derived} == {"approximation", "cost", "surface", "construction"}
    assert {row.paper for row in rows} == set(published_table().citations)
    assert len(rows) == len(published_table().figures) + len(derived)
    for row in rows:
        assert row.agreement in ("agrees", "differs"), row
        assert bool(row.explanation) == (row.agreement == "differs"), row
        assert row.shown in printed
        if row.agreement == "agrees":
            values = [float(value) for value in row.ours.split()] or [row.measured]
            assert comes_out(values, row.printed, None if math.isnan(row.within) else row.within)
    for absent in published_table().not_remade:
        assert absent.place in printed
        assert absent.what.split()[0] in printed
    page = (tmp_path / "index.html").read_text("utf-8")
    assert all(escape(row.quantity, quote=False) in page.replace("&#39;", "'") for row in rows)
    # the file says what the results say, to the last bit
    results = read_results(tmp_path)
    assert repr(rows[: -len(derived)]) == repr(compare(published_table().figures, results))
    assert repr(rows[-len(derived) :]) == repr(compare_derived(derived, measure_derived(derived, 1)))
    assert not results.missing
    # and a second time nothing is computed
    assert reproduce_command("mann-1992", tmp_path, 1, as_json=True) == 0
    found = json.loads(capsys.readouterr().out)["figures"]
    assert [one["measured"] for one in found] == [row.measured for row in rows if row.paper == "mann-1992"]
    assert read_results(tmp_path).run["cells"]["computed"] == 0


def test_what_is_not_explained_or_not_there_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = dataclasses.replace(FLAT, printed="9")
    explained = dataclasses.replace(wrong, explanation="A slip.")
    absent = dataclasses.replace(FLAT, column="nothing")
    slow = dataclasses.replace(FLAT, column="gauss_max", level=None)
    refused = dataclasses.replace(FLAT, scheme="quadratic-interpolant", dataset="monkey-saddle")

    def outcome(*figures: Figure) -> tuple[int, list[Agreement]]:
        monkeypatch.setattr(reproducing, "figures_of", lambda _: figures)
        monkeypatch.setattr(reproducing, "derived_of", lambda _: ())
        monkeypatch.setattr(reproducing, "pictures_of", lambda _: ())
        code = reproduce_command("mann-1992", tmp_path, 1, as_json=True)
        return code, [row.agreement for row in published_rows(tmp_path)]

    assert outcome(FLAT, explained) == (0, ["agrees", "differs"])
    assert outcome(FLAT, wrong, absent, slow, refused) == (1, ["agrees", "unexplained", *["no value"] * 3])
    reasons = [row.reason for row in published_rows(tmp_path)]
    assert reasons[:2] == ["", ""]
    assert "no nothing" in reasons[2]
    assert "no order of gauss_max" in reasons[3]
    assert reasons[4].startswith("refused: ")
    with pytest.raises(SpecError, match="level 9 of octahedron"):
        outcome(dataclasses.replace(FLAT, level=9))


def test_an_order_agrees_only_if_its_interval_tells_it_from_its_neighbours() -> None:
    figure = dataclasses.replace(FLAT, printed="5", level=None, column="distance_max")
    assert published._agreement(figure, 5.05, 4.9, 5.2) == "agrees"
    assert published._agreement(figure, 5.05, 3.9, 6.2) == "unexplained"
    assert published._agreement(figure, 4.4, 4.3, 5.1) == "unexplained"
    assert published._agreement(figure, math.inf, math.inf, math.inf) == "unexplained"


def test_rows_are_read_as_they_were_written(tmp_path: Path) -> None:
    assert published_rows(tmp_path) == ()
    names = ("p", 'a "place", here', "ΔK\nmax", "flat", "sphere", "0 1 2", "gauss_max", "2.5")
    row = PublishedRow(*names, 0.1 + 0.2, math.nan, -1e-300, "no value", "lost", "", "why, exactly")
    path = write_published(tmp_path, [row, row])
    assert repr(published_rows(tmp_path)) == repr((row, row))
    path.write_text("paper,place\nx,y\n")
    with pytest.raises(TestbedError, match=r"published\.csv cannot be read"):
        published_rows(tmp_path)


def several(printed: str, ours: str, **changes: object) -> PublishedRow:
    """A row of several numbers, ours as text."""
    figure = DerivedFigure("mann-1994", "p", "q", "construction", "d", "c", printed, "given")
    values = tuple(float(value) for value in ours.split())
    (row,) = compare_derived([figure], [Measured(farthest(values, printed), "", values)])
    return dataclasses.replace(row, **changes)  # type: ignore[arg-type]  # fields of a row


def test_several_numbers_agree_together_and_show_the_one_farthest_off() -> None:
    row = several("1.5 -2 0.25", "1.46 -2.3 0.25")
    assert (row.agreement, row.measured, row.shown, row.shown_printed) == ("agrees", -2.3, "the same", "3 numbers")
    assert row.difference == pytest.approx(-0.3)
    off = several("1.5 -2 0.25", "1.46 -2.3 0.26")
    assert off.agreement == "unexplained"
    assert (off.measured, off.shown) == (-2.3, "-2.30")
    assert several("1.5 -2", "nan -2").agreement == "no value"
    assert comes_out((1.0, 2.0), "1 2")
    assert not comes_out((1.0,), "1 2")
    assert math.isnan(farthest((1.0,), "1 2"))


def test_statements_in_words_hold_within_what_they_say() -> None:
    exact = dataclasses.replace(FLAT, printed="0", within=1e-12, column="distance_max")
    assert published._agreement(exact, 1e-13, math.nan, math.nan) == "agrees"
    assert published._agreement(exact, 1e-11, math.nan, math.nan) == "unexplained"
    assert comes_out((0.0,), "0", 0.0)
    assert not comes_out((1e-300,), "0", 0.0)
    assert not comes_out((math.nan,), "0", 1.0)


def test_differences_from_lost_data_are_called_so() -> None:
    lost = several("2", "3", data="lost", agreement="differs")
    assert (lost.verdict, several("2", "3", agreement="differs").verdict) == ("data lost", "differs")
    assert several("2", "2", data="lost").verdict == "agrees"
    assert (lost.difference, lost.shown_difference) == (1.0, "+1")
    assert several("2", "2").shown_difference == "0"


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ('paper = "nobody"\nplace = "p"\nwhat = "w"\nreason = "r"', "no paper 'nobody'"),
        ('paper = "somebody-2001"\nplace = "p"\nwhat = "w"\nreason = ""', "has no reason"),
        ('paper = "somebody-2001"\nplace = "p"\nwhat = "w"', "other fields"),
    ],
)
def test_what_is_not_remade_has_a_paper_and_a_reason(row: str, says: str) -> None:
    with pytest.raises(TestbedError, match=says):
        parse_table(f"{ROW}[[not_remade]]\n{row}\n")


def test_every_paper_has_numbers_and_says_what_is_not_remade() -> None:
    table = published_table()
    for paper in table.citations:
        assert paper in {one.paper for one in table.figures} | {one.paper for one in table.derived}
        assert [one for one in table.not_remade if one.paper == paper]


@pytest.mark.parametrize(
    ("measured", "low", "shown"),
    [
        (2.377404, math.nan, "2.377"),
        (300.0, math.nan, "300"),
        (0.000164, math.nan, "0.000164"),
        (-311.4, math.nan, "-311.400"),
        (5.0487, 4.9, "5.049 [4.900, 5.200]"),
        (math.nan, math.nan, "–"),
    ],
)
def test_measured_numbers_show_two_digits_more(measured: float, low: float, shown: str) -> None:
    row = PublishedRow("", "", "", "", "", "", "", "2.4", measured, low, 5.2, "agrees", "given", "", "")
    assert row.shown == shown
