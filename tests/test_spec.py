"""The text form of plugins: every plugin parses back from its own text, mistakes are answered with what is valid."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.errors import SpecError
from testbed.plugins.base import Plugin
from testbed.plugins.spec import parse
from testbed.registry import scheme


@dataclass(frozen=True)
class Curve(Plugin):
    name = "curve"
    title = "Curve"
    reference = "none"

    root: Literal["best", "worst"] = "best"
    guard: tuple[float, float] | None = None


@dataclass(frozen=True)
class Patch(Plugin):
    name = "patch"
    title = "Patch"
    reference = "none"
    positional = "path"

    boundary: Curve = Curve()
    c: float = 1.0
    alpha: float | tuple[float, ...] = 2.25
    steps: int = 3
    closed: bool = False
    path: str = ""
    label: str = ""


class Known:
    def catalogue(self, kind: type[Any]) -> Mapping[str, type[Any]]:
        return {plugin.name: plugin for plugin in (Curve, Patch) if issubclass(plugin, kind)}

    def kind_name(self, kind: type[Plugin]) -> str:
        return {Curve: "curve", Patch: "patch"}.get(kind, "plugin")


def read(text: str) -> Patch:
    return parse(text, Patch, Known())


finite = st.floats(allow_nan=False, allow_infinity=False)
curves = st.builds(Curve, root=st.sampled_from(["best", "worst"]), guard=st.none() | st.tuples(finite, finite))
patches = st.builds(
    Patch,
    boundary=curves,
    c=finite,
    alpha=finite | st.lists(finite, min_size=1, max_size=4).map(tuple),
    steps=st.integers(-9, 9),
    closed=st.booleans(),
    path=st.text(max_size=12) | st.text(st.sampled_from('x*+,:[]()"\\ '), max_size=12),
    label=st.text(max_size=8),
)


@given(patches)
def test_every_plugin_parses_back_from_its_own_text(patch: Patch) -> None:
    assert read(str(patch)) == patch


def test_only_changed_fields_are_written_in_their_declared_order() -> None:
    text = "patch[closed=true, boundary=curve[root=worst], c=1.055]"
    assert str(read(text)) == "patch[boundary=curve[root=worst],c=1.055,closed=true]"
    assert str(read("patch")) == "patch"
    assert str(read("patch:a/b [1].ply")) == "patch:a/b [1].ply"
    assert str(read("patch[c=2]:x,y:(z)")) == "patch[c=2.0]:x,y:(z)"


def test_quotes_about_text_behind_a_colon_are_taken_away_and_written_only_where_needed() -> None:
    assert read('patch:"x*(y+1)"').path == "x*(y+1)"
    assert str(read('patch:"x*(y+1)"')) == "patch:x*(y+1)"
    assert str(Patch(path=" x ")) == 'patch:" x "'
    assert str(Patch(path='"x"')) == 'patch:"\\"x\\""'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pach", ["pach", "did you mean patch?"]),
        ("patch[boundry=curve]", ["boundry", "did you mean boundary?", "alpha, boundary, c"]),
        ("patch[boundary=curve[root=wurst]]", ["root", "did you mean worst?", "best, worst"]),
        ("patch[boundary=bezier]", ["no curve is called 'bezier'"]),
        ("patch[c=one]", ["parameter c of patch", "a finite number"]),
        ("patch[c=nan]", ["a finite number"]),
        ("patch[steps=1.5]", ["a whole number"]),
        ("patch[closed=yes]", ["true or false"]),
        ("patch[alpha=(1 x)]", ["a finite number"]),
        ("patch[boundary=curve[guard=(1 2 3)]]", ["takes 2 values"]),
        ("patch[c=1,c=2]", ["twice"]),
        ("patch[c]", ["has no value"]),
        ("patch[c=1", ["every bracket closed"]),
        ("patch[c=1]x", ["every bracket closed"]),
        ('patch[label="x]', ["bracket"]),
        ('patch:"x', ["quoted text that does not end"]),
        ("patch[path=x]:y", ["path", "twice"]),
    ],
)
def test_a_mistake_is_answered_in_one_sentence_with_what_is_valid(text: str, words: list[str]) -> None:
    with pytest.raises(SpecError) as caught:
        read(text)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_text_behind_a_colon_needs_a_positional_field() -> None:
    with pytest.raises(SpecError, match="takes no ':x'"):
        parse("curve:x", Curve, Known())


def test_nested_plugins_are_found_depth_first() -> None:
    assert [plugin.name for plugin in Patch().nested()] == ["patch", "curve"]


def test_a_scheme_with_boundary_curves_of_its_own_says_so() -> None:
    with pytest.raises(SpecError, match="builds its own boundary curves and takes no others"):
        scheme("nielson[boundary=planar]")
