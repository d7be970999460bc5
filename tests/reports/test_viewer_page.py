"""Surfaces in the page are data that its script reads: no text of others is markup, and pictures stand without it."""

import json
import re
from dataclasses import replace

import pytest
from hand_made_results import HOSTILE
from test_page import Reader
from viewer_examples import DATASET, SCHEMES, shown_results

from testbed_reports.page import render
from testbed_reports.view import view
from testbed_reports.viewer.markup import embedded, script
from testbed_reports.viewer.model import Scene, scene


@pytest.fixture(scope="module")
def shown() -> tuple[Reader, Scene]:
    """A page of three surfaces, one of a hostile name, and one refused for a hostile reason."""
    results = shown_results()
    found = scene(results, DATASET, 10_000)
    first, second, third = found.cards
    hostile = replace(
        found, cards=(replace(first, scheme=HOSTILE), second, replace(third, reason=HOSTILE, data="", about=None))
    )
    return Reader(render(view(results), (hostile,))), hostile


def data(reader: Reader) -> dict[str, str]:
    """Data elements by id."""
    scripts = [attributes for tag, attributes in reader.elements if tag == "script"]
    return {one["id"]: text for one, text in zip(scripts, reader.scripts, strict=True) if "type" in one}


def test_hostile_names_and_reasons_are_text(shown: tuple[Reader, Scene]) -> None:
    reader, _ = shown
    assert reader.open == []
    assert reader.text.count(HOSTILE) == 2
    assert HOSTILE in " ".join(reader.values("alt"))
    assert not [name for _, attributes in reader.elements for name in attributes if name.startswith("on")]
    assert not re.search("[<>&]", "".join(data(reader).values()))


def test_pictures_stand_for_all_surfaces_and_nothing_is_loaded(shown: tuple[Reader, Scene]) -> None:
    reader, found = shown
    images = [attributes["src"] for tag, attributes in reader.elements if tag == "img"]
    assert images == [card.still for card in found.shown]
    assert all(source.startswith("data:image/png;base64,") for source in reader.values("src"))
    (policy,) = (value["content"] for tag, value in reader.elements if "http-equiv" in value)
    assert "img-src data:;" in policy
    assert "connect-src" not in policy


def test_every_surface_is_where_its_viewer_looks(shown: tuple[Reader, Scene]) -> None:
    reader, found = shown
    texts = data(reader)
    about = json.loads(texts["scene-0"])
    assert [texts[one["data"]] for one in about["surfaces"]] == [card.data for card in found.shown]
    assert [one["scheme"] for one in about["surfaces"]] == [HOSTILE, SCHEMES[1]]
    assert about["scales"] == {name: list(limits) for name, limits in found.scales.items()}
    assert len(json.loads(texts["viewer-settings"])["styles"]) == 8


def test_limits_of_the_pictures_are_stated(shown: tuple[Reader, Scene]) -> None:
    reader, found = shown
    limit = f"{found.scales['gauss'][1]:.3g}"
    assert f"Gaussian curvature K: −{limit}{limit}" in reader.text


def test_where_no_surface_can_be_shown_the_page_says_why() -> None:
    results = shown_results()
    nothing = Scene(
        DATASET, 0, tuple(replace(card, reason="it is gone") for card in scene(results, DATASET, 5e3).cards), {}, {}
    )
    reader = Reader(render(view(results), (nothing,)))
    assert "None can be shown. It is gone." in reader.text
    assert "img" not in {tag for tag, _ in reader.elements}


def test_embedded_json_is_the_value_and_no_markup() -> None:
    value = {"a": [HOSTILE, "\ud800", " & </script>"], "b": 1.5}
    assert not re.search("[<>&\ud800]", embedded(value))
    assert json.loads(embedded(value)) == value
    with pytest.raises(ValueError, match="not JSON compliant"):
        embedded(float("nan"))


def test_the_script_does_not_end_its_element_nor_make_markup_of_texts() -> None:
    text = script()
    assert "</script" not in text
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function", text)
    assert not re.search(r"fetch\(|XMLHttpRequest|WebSocket|importScripts|https?:", text)
