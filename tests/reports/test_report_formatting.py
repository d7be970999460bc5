"""Numbers read back to what they were, to three digits and to the last."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed_reports.formatting import NOTHING, counted, entry, listed, shorten

numbers = st.floats(-1e300, 1e300)


@given(numbers)
def test_a_short_number_is_within_half_a_unit_of_its_third_digit(value: float) -> None:
    assert float(shorten(value)) == pytest.approx(value, rel=5.001e-3, abs=5e-324)


@given(st.floats(1e-3, 999.0))
def test_a_short_number_shows_three_significant_digits(value: float) -> None:
    assert len(shorten(value).split("e")[0].lstrip("0.").replace(".", "")) == 3


@given(numbers)
def test_an_entry_keeps_every_digit(value: float) -> None:
    assert float(entry(value).exact) == value


def test_counts_and_texts_stay_as_they_are() -> None:
    assert [entry(value).text for value in (2048, np.int64(12345), "as told", None, "")] == [
        "2048",
        "12345",
        "as told",
        NOTHING,
        NOTHING,
    ]


def test_what_is_not_finite_says_so() -> None:
    assert [shorten(value) for value in (math.inf, -math.inf, math.nan)] == ["∞", "-∞", "NaN"]


def test_a_share_is_shown_in_percent_and_kept_as_a_share() -> None:
    share = entry(0.125, percent=True)
    assert (share.text, share.exact) == ("12.5", "0.125")


def test_words_are_joined_as_in_a_sentence() -> None:
    assert [listed(words) for words in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["", "a", "a and b", "a, b and c"]
    assert (counted(1, "cell"), counted(0, "cell")) == ("1 cell", "0 cells")
