"""Values and bounds of parameters as a study reads them, and the texts it makes of them."""

import pytest

from testbed.errors import SpecError
from testbed.harness.parameters import free_parameters, parse_axis, parse_interval, value_of, with_values
from testbed.registry import scheme

SPLIT = scheme("shirman-sequin[boundary=hermite[root=worst],jensen_c=1.1]")


def test_a_range_has_both_ends_and_short_numbers_between() -> None:
    axis = parse_axis("jensen_c=0.9:1.4:26", SPLIT)
    assert (axis.texts[0], axis.texts[9], axis.texts[-1]) == ("0.9", "1.08", "1.4")
    assert axis.numbers == tuple(map(float, axis.texts))
    assert len(set(axis.texts)) == 26
    assert parse_axis("alpha2=1:2:3", SPLIT).texts == ("1.0", "1.5", "2.0")  # a number or a tuple of them


def test_lists_are_numbers_in_order_or_words_as_given() -> None:
    assert parse_axis("jensen_c=3,1,2", SPLIT).numbers == (1.0, 2.0, 3.0)
    axis = parse_axis("boundary=projected,hermite[root=worst,guard=(0.1 0.8)],circular", SPLIT)
    assert axis.numbers is None
    assert axis.texts == ("projected", "hermite[root=worst,guard=(0.1 0.8)]", "circular")
    assert parse_axis("boundary.root=best,worst", SPLIT).texts == ("best", "worst")


def test_a_whole_parameter_takes_whole_numbers() -> None:
    assert parse_axis("tag=1:5:3", scheme("toy")).texts == ("1", "3", "5")
    with pytest.raises(SpecError, match="whole number"):
        parse_axis("tag=1:2:3", scheme("toy"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("jensen_d=1:2:3", "did you mean jensen_c"),
        ("jensen_c", "name=low:high:count"),
        ("jensen_c=", "name=low:high:count"),
        ("jensen_c=,", "no values"),
        ("jensen_c=1:2:x", "count is a whole one"),
        ("jensen_c=1:2:2.5", "count is a whole one"),
        ("jensen_c=nan:2:3", "numbers"),
        ("jensen_c=2:1:3", "low is below high"),
        ("jensen_c=1:2:1", "count from 2"),
        ("jensen_c=1:2:100000", "count from 2 to 1000"),
        ("jensen_c=1,1.0", "1.0 twice"),
        ("jensen_c=1,x", "finite number"),
        ("alpha2=-1:1:3", "alpha2 must be positive"),
        ("boundary=1:2:3", "list its values"),
        ("boundary=sheep", "no boundary curve is called 'sheep'"),
        ("boundary.rot=best", "did you mean root"),
        ("jensen_c.root=best", "no parameters of its own"),
    ],
)
def test_a_bad_axis_is_one_sentence(text: str, words: str) -> None:
    with pytest.raises(SpecError) as caught:
        parse_axis(text, SPLIT)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("jensen_d", "did you mean jensen_c"),
        ("boundary", "no real number"),
        ("jensen_c=1", "jensen_c=low:high"),
        ("jensen_c=2:1", "low below high"),
        ("jensen_c=1:inf", "low below high"),
        ("jensen_c=1:2:3", "low below high"),
        ("alpha2=-1:1", "alpha2 must be positive"),
    ],
)
def test_bad_bounds_are_one_sentence(text: str, words: str) -> None:
    with pytest.raises(SpecError) as caught:
        parse_interval(text, SPLIT)
    assert words in str(caught.value)


def test_bounds_are_those_given_or_those_declared() -> None:
    found = parse_interval("jensen_c=1:1.5", SPLIT)
    assert (found.name, found.low, found.high) == ("jensen_c", 1.0, 1.5)
    declared = parse_interval("alpha2", SPLIT)
    assert (declared.low, declared.high) == SPLIT.bounds["alpha2"]
    assert free_parameters(SPLIT) == (parse_interval("jensen_c", SPLIT), declared)
    with pytest.raises(SpecError, match="declares no bounds"):
        free_parameters(scheme("flat"))


def test_other_parameters_stay() -> None:
    found = scheme(with_values(SPLIT, {"boundary.guard": "(0.1 0.8)", "alpha2": "1.5"}))
    assert str(found) == "shirman-sequin[boundary=hermite[root=worst,guard=(0.1 0.8)],jensen_c=1.1,alpha2=1.5]"
    assert value_of(found, "boundary.guard") == (0.1, 0.8)
    with pytest.raises(SpecError, match="cannot be varied at once"):
        with_values(SPLIT, {"boundary": "projected", "boundary.root": "best"})


def test_bounds_of_every_scheme_are_of_real_parameters_and_hold_the_default() -> None:
    from testbed.plugins.scheme import Scheme
    from testbed.registry import catalogue

    declared = [(one(), name) for one in catalogue(Scheme).values() for name in one.bounds]  # type: ignore[type-abstract]  # what comes is concrete
    assert len(declared) > 3
    for one, name in declared:
        interval = parse_interval(name, one)
        assert interval.low < value_of(one, name) < interval.high
        for end in (interval.low, interval.high):
            scheme(with_values(one, {name: repr(end)}))
