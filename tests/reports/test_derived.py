"""Published figures of approximations and costs: measured or not with the reason, and their rows in the file."""

import dataclasses

import pytest

from testbed import registry
from testbed.approximation.history import Step
from testbed.errors import TestbedError
from testbed_reports.constructions import CONSTRUCTIONS
from testbed_reports.derived import compare_derived, measure_derived
from testbed_reports.published_table import DerivedFigure, parse_table, published_table

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

DERIVED = DerivedFigure(
    "mann-1992", "page 1", "a number", "approximation", "octahedron", "faces", "8", "given", "flat", 175.0
)


def test_an_approximation_without_a_number_says_why() -> None:
    figures = (
        DERIVED,
        dataclasses.replace(DERIVED, printed="9"),
        dataclasses.replace(DERIVED, printed="9", explanation="A slip."),
        dataclasses.replace(DERIVED, column="nothing"),
        dataclasses.replace(DERIVED, dataset="mesh"),
        dataclasses.replace(DERIVED, dataset="branch", source="cost", patches="4 sides, depth 3", column="patches"),
        dataclasses.replace(DERIVED, dataset="branch", source="cost", patches="nine sides", column="patches"),
    )
    rows = compare_derived(figures, measure_derived(figures, 1))
    assert [row.agreement for row in rows[:4]] == ["agrees", "unexplained", "differs", "no value"]
    assert rows[3].reason == "the history has no nothing"
    assert (rows[4].agreement, bool(rows[4].reason)) == ("no value", True)
    assert rows[5].measured == 20.0
    assert "no patches of nine sides" in rows[6].reason


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('source = "approximation"', 'source = "hearsay"', "one of approximation, cost, surface, construction"),
        ('source = "approximation"', 'source = "cost"', "patches"),
        ("epsilon = 1.0", "epsilon = 0.0", "positive epsilon"),
        ('scheme = "flat"', "", "needs a scheme"),
        ('printed = "8"', 'printed = "eight"', "decimal number"),
        ('column = "faces"', "", "column"),
    ],
)
def test_a_derived_row_that_is_no_figure_is_named(old: str, new: str, says: str) -> None:
    row = ROW.replace("[[figures]]", "[[derived]]").replace("level = 0", 'source = "approximation"\nepsilon = 1.0')
    assert parse_table("figures = []\n" + row).derived[0].level == "epsilon 1°"
    with pytest.raises(TestbedError, match="derived figure 1") as caught:
        parse_table("figures = []\n" + row.replace(old, new))
    assert says in str(caught.value)


def test_every_derived_row_names_what_there_is() -> None:
    steps = {field.name for field in dataclasses.fields(Step)}
    for figure in published_table().derived:
        if figure.source == "construction":
            assert figure.column in CONSTRUCTIONS
            continue
        dataset = registry.dataset(figure.dataset)
        if figure.source == "approximation":
            registry.scheme(figure.scheme)
            assert figure.column in steps
            assert dataset.surface is not None
    rows = [dataclasses.replace(one, printed="", explanation="") for one in published_table().derived]
    assert len(set(rows)) == len(rows)
