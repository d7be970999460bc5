"""Text of others reaches paper as it is, or spelled out; it can always be broken into lines."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed_reports.pdf.lettering import BREAK, LONGEST, name, number, numberless, printable, prose, shortened

texts = st.text(st.characters(codec=None), max_size=80)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Shirman-Séquin", "Shirman-Séquin"),
        ('#import "x" $x$ *b* <img> [}', '#import "x" $x$ *b* <img> [}'),
        ("a\n\tb\r\n c", "a b c"),
        ("\x00\x1b[31m", "\\x00\\x1b[31m"),
        ("mesh\u202egnp.ply", "mesh\\u202egnp.ply"),
        ("half \ud800", "half \\ud800"),
        ("e\u0301", "é"),
        ("x\u0336\u0336", "x\\u0336\\u0336"),
        ("漢字 🔔", "\\u6f22\\u5b57 \\U0001f514"),
        ("K ≤ 1/length² ✓", "K ≤ 1/length² ✓"),
    ],
)
def test_what_fonts_lack_or_what_moves_its_neighbours_is_spelled_out(text: str, shown: str) -> None:
    assert printable(text) == shown


@given(texts)
def test_only_known_signs_are_printed_and_spelling_out_is_done_once(text: str) -> None:
    shown = printable(text)
    assert printable(shown) == shown
    assert shown.encode("utf-8").decode("utf-8") == shown
    assert "\n" not in shown


@given(texts)
def test_names_and_prose_say_the_same_as_before_and_break_everywhere(text: str) -> None:
    for broken in (name(text), prose(text)):
        assert broken.replace(BREAK, "") == printable(text).replace(BREAK, "")
        assert max(map(len, re.split(rf"[\s{BREAK}\N{{SOFT HYPHEN}}-]", broken))) <= LONGEST


def test_names_break_after_what_separates_their_parts() -> None:
    assert name("a[b=c,d=e]").split(BREAK) == ["a[", "b=", "c,", "d=", "e]"]


def test_long_texts_lose_their_middle() -> None:
    assert shortened("short", 10) == "short"
    cut = shortened("shirman-sequin[boundary=hermite,jensen_c=1.055]", 20)
    assert len(cut) == 20
    assert cut.startswith("shirman-sequi")
    assert cut.endswith("1.055]"[-6:])


def test_numbers_have_true_minus_signs_and_reasons_are_alike_up_to_them() -> None:
    assert number("-1.2e-3") == "−1.2e−3"
    assert numberless("face 12 is 3.5e-7 off") == numberless("face 7 is 0.1 off")
