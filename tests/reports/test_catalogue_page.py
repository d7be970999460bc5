"""The catalogue's page: everything registered is on it, and what plugins say is text, never markup."""

import dataclasses
import json
from html.parser import HTMLParser
from typing import Any

import pytest

from testbed.cli.describing import found_facts
from testbed.conformance.catalogue import Card, Findings, card, findings, parameter_meanings
from testbed.conformance.profile import profile
from testbed.conformance.subject import Status
from testbed.conformance.suite import check
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme
from testbed.registry import catalogue, load
from testbed_reports.catalogue import SchemeEntry, paragraphs, render, to_json

SCHEMES = [SchemeEntry(card(kind()), None, "not checked here") for kind in catalogue(Scheme).values()]  # type: ignore[type-abstract]  # the kind
CURVES = [card(kind()) for kind in catalogue(BoundaryCurve).values()]  # type: ignore[type-abstract]  # as above
HOSTILE = "<img src=x onerror=alert(1)> & </dd> ' \""


class Texts(HTMLParser):
    """Collects tags and text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(f"{tag} with {len(attrs)} attributes" if tag == "img" else tag)

    def handle_data(self, data: str) -> None:
        self.text += data


def test_everything_registered_is_on_the_page() -> None:
    found = Texts(render(SCHEMES, CURVES, load().not_built))
    for name in (*catalogue(Scheme), *catalogue(BoundaryCurve), *(entry.name for entry in load().not_built)):  # type: ignore[type-abstract]  # as above
        assert name in found.text


def test_what_plugins_say_is_text() -> None:
    texts = [field.name for field in dataclasses.fields(Card) if field.name not in ("parameters", "claims")]
    changes: dict[str, Any] = {"parameters": (), **dict.fromkeys(texts, HOSTILE)}
    hostile = dataclasses.replace(CURVES[0], **changes)
    found = Texts(render([SchemeEntry(hostile, None, HOSTILE)], [hostile], []))
    assert not [tag for tag in found.tags if tag.startswith("img")]
    assert found.text.count(HOSTILE) > 10


def test_what_came_of_checking_a_scheme_is_on_the_page_and_in_the_record() -> None:
    found = findings("flat")
    entry = SchemeEntry(card(catalogue(Scheme)["flat"]()), found)  # type: ignore[type-abstract]  # as above
    page = Texts(render([entry], [], []))
    assert "1 Bézier triangle of degree 1" in page.text
    assert entry.verdict.endswith("passed")
    for outcome in found.outcomes:
        assert outcome.property in page.text
    record = json.loads(to_json([entry], [], []))
    assert len(record["schemes"][0]["findings"]["outcomes"]) == len(found.outcomes)
    assert record["schemes"][0]["findings"]["profile"]["numbers"] == 9.0


@dataclasses.dataclass(frozen=True)
class Broken(Scheme):
    """A scheme that raises."""

    name = "broken"
    title = "Broken"
    reference = "nobody"
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = None
    reproduces = ()

    def construct(self, mesh: HermiteMesh) -> Surface:
        raise ValueError(f"no surface over {len(mesh.faces)} faces")


def test_a_scheme_that_raises_has_no_profile_and_its_check_tells() -> None:
    assert profile(Broken()) is None
    found = Findings(None, check(Broken()))
    assert found.count(Status.FAILED) > 0
    page = Texts(render([SchemeEntry(card(Broken()), found)], [], []))
    assert "ValueError: no surface over" in page.text
    assert any("ValueError: no surface over" in text for _, text in found_facts(found))


@pytest.mark.parametrize(
    "entry", [*SCHEMES, *(SchemeEntry(one, None) for one in CURVES)], ids=lambda entry: entry.card.name
)
def test_every_parameter_has_its_meaning_on_the_card(entry: SchemeEntry) -> None:
    assert all(one.meaning for one in entry.card.parameters)


def test_meanings_come_from_the_parameters_section_alone() -> None:
    text = "What.\n\nParameters\n----------\na, b\n    Both\n    of them.\nc\n    One.\n\nRaises\n------\nX\n    Y."
    assert parameter_meanings(text) == {"a": "Both of them.", "b": "Both of them.", "c": "One."}
    assert parameter_meanings("What.") == {}


def test_displays_stand_as_they_are() -> None:
    first, display = paragraphs("A **bold**\nword:\n\n    x = 1\n    y = 2")
    assert (first.text, first.display) == ("A bold word:", False)
    assert display.display
    assert "\n" in display.text
