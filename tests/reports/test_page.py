"""The page is the same for the same results, holds all of them, loads nothing, and takes no markup from data."""

import base64
import dataclasses
import hashlib
import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import matplotlib as mpl
import pytest
from hand_made_results import COLUMNS, HOSTILE, RUN, good, results, without
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.harness.cell import Outcome
from testbed.harness.journal import Journal
from testbed.harness.results import Results
from testbed_reports.page import HtmlPage, render
from testbed_reports.view import view


class Reader(HTMLParser):
    """What a browser sees: elements with their attributes, scripts, and the text outside of scripts and styles."""

    VOID = frozenset({"meta", "img", "br", "link", "input"})

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.text = ""
        self.scripts: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            self.scripts.append(data)
        elif not self.open or self.open[-1] != "style":
            self.text += data

    def values(self, attribute: str) -> list[str]:
        return [attributes[attribute] for _, attributes in self.elements if attribute in attributes]


def page_of(found: Results) -> str:
    return render(view(found))


def refused(scheme: str, dataset: str, level: int) -> Outcome:
    if scheme == "p4":
        return good(scheme, dataset, level)
    return Outcome("refused" if level else "failed", HOSTILE, HOSTILE, faces=8)


def hostile() -> Results:
    """Every text that does not come from here is hostile."""
    return results(
        ("p4", HOSTILE, f"x{HOSTILE}"),
        (HOSTILE, "ball"),
        2,
        lambda *at: refused(*at) if at[0] != f"x{HOSTILE}" else good(*at, notes=HOSTILE, epsilon_bary=HOSTILE),
        text=HOSTILE,
        run={**RUN, "command": ["testbed", HOSTILE], "versions": {HOSTILE: HOSTILE}, "started": HOSTILE},
        columns=tuple(dataclasses.replace(column, meaning=HOSTILE) for column in COLUMNS),
    )


def test_the_same_results_give_the_same_bytes_whatever_the_settings_of_matplotlib() -> None:
    first = page_of(results())
    with mpl.rc_context({"svg.fonttype": "path", "lines.linewidth": 7.0, "svg.hashsalt": None}):
        assert page_of(results()) == first


def test_drawing_leaves_the_settings_of_matplotlib_alone() -> None:
    with mpl.rc_context({"lines.linewidth": 7.0}):
        page_of(results())
        assert mpl.rcParams["lines.linewidth"] == 7.0


def test_names_reasons_and_references_are_text_and_nothing_else() -> None:
    benign = Reader(page_of(results(("p4", "b", "c"), ("d", "ball"), 2, refused_or_noted)))
    reader = Reader(page_of(hostile()))
    assert HOSTILE in reader.text
    assert {tag for tag, _ in reader.elements} <= {tag for tag, _ in benign.elements}
    assert {name for _, attributes in reader.elements for name in attributes} <= {
        name for _, attributes in benign.elements for name in attributes
    }
    assert not {"img", "iframe", "object", "link", "base"} & {tag for tag, _ in reader.elements}
    assert not [name for _, attributes in reader.elements for name in attributes if name.startswith("on")]
    assert str(7777 * 7) not in reader.text


def test_one_script_runs_whatever_is_in_the_data_and_the_policy_of_the_page_names_it() -> None:
    page = page_of(hostile())
    reader = Reader(page)
    scripts = [attributes for tag, attributes in reader.elements if tag == "script"]
    assert len(scripts) == len(reader.scripts)
    running = [text for attributes, text in zip(scripts, reader.scripts, strict=True) if "type" not in attributes]
    assert running == [text for text in Reader(page_of(results())).scripts if text.startswith('"use strict"')]
    (policy,) = (value["content"] for tag, value in reader.elements if "http-equiv" in value)
    digest = base64.b64encode(hashlib.sha256(running[0].encode()).digest()).decode()
    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{digest}'" in policy


def test_data_for_the_script_is_json_without_any_character_of_markup() -> None:
    reader = Reader(page_of(hostile()))
    scripts = [attributes for tag, attributes in reader.elements if tag == "script"]
    data = {
        attributes["id"]: text for attributes, text in zip(scripts, reader.scripts, strict=True) if "type" in attributes
    }
    assert not [text for text in data.values() if re.search("[<>&]", text)]
    assert json.loads(data["run-data"])["schemes"] == ["p4", HOSTILE, f"x{HOSTILE}"]


def refused_or_noted(scheme: str, dataset: str, level: int) -> Outcome:
    if scheme == "b":
        return Outcome("refused" if level else "failed", "reason", "trace", faces=8)
    return good(scheme, dataset, level, notes="a note")


@given(st.text(st.characters(codec=None), max_size=60))
@settings(max_examples=15, deadline=None)
def test_any_text_makes_a_page_whose_elements_close(text: str) -> None:
    reader = Reader(page_of(results(("p4", text + "!"), levels=1, make=refused, text=text)))
    assert reader.open == []


def test_nothing_is_loaded_and_every_link_leads_to_a_place_of_the_page() -> None:
    page = page_of(hostile())
    reader = Reader(page)
    targets = [*reader.values("href"), *reader.values("xlink:href")]
    assert targets
    assert all(target.startswith("#") and target[1:] in reader.values("id") for target in targets)
    assert reader.values("src") == []
    assert all(target in reader.values("id") for target in re.findall(r"url\(#([^)]+)\)", page))
    assert not re.search(r"url\((?!#)|@import", page)
    assert max(Counter(reader.values("id")).values()) == 1


def test_every_cell_and_every_reason_appears() -> None:
    found = results(("p2", "p4", "sad"), ("ball", "egg"), 3, unlike)
    page = page_of(found)
    text = Reader(page).text
    for _, cell in found.cells.iterrows():
        if cell["status"] == "ok":
            assert f'title="{cell["normal_max_deg"]!r}"' in page
        else:
            assert f"{cell['status']}: {cell['reason']}" in text
    assert "Traceback of sad on egg, level 1" in text


def unlike(scheme: str, dataset: str, level: int) -> Outcome:
    """Return a cell whose number is like no other's; ``sad`` is refused or fails."""
    where = f"{scheme} on {dataset}, level {level}"
    if scheme == "sad":
        return Outcome("failed" if level == 1 else "refused", f"because of {where}", f"Traceback of {where}", faces=8)
    return good(scheme, dataset, level, normal_max_deg=1.0 + level / 7 + len(dataset) / 11 + len(where) * ord(where[1]))


@pytest.mark.parametrize(
    "found",
    [
        results(levels=1),
        results(make=lambda *_: None, run={}),
        results(make=lambda *at: good(*at) if at[2] < 2 or at[0] == "p2" else None),
        results(make=lambda *at: without(good(*at), "distance_max", "normal_max_deg"), shape=None),
        results(columns=(), make=lambda *at: dataclasses.replace(good(*at), values={})),
        results(make=lambda *at: good(*at, gauss_min=-1e9, gauss_max=3.0)),
        results(make=lambda *at: good(*at, epsilon_deg=0.0, gauss_min=0.0, gauss_max=0.0, distance_max=1e-300)),
        results(tuple(f"scheme-{number}" for number in range(20)), levels=3),
    ],
    ids=["one level", "nothing", "partial", "no exact surface", "no columns", "wild", "zeros", "many schemes"],
)
def test_results_of_every_sort_make_a_whole_page(found: Results) -> None:
    reader = Reader(page_of(found))
    assert reader.open == []
    assert "NaN" not in reader.text
    assert all(cell.scheme in reader.text for cell in found.plan.cells)


def test_the_report_writes_one_file_beside_the_results(tmp_path: Path) -> None:
    found = results()
    (tmp_path / "plan.json").write_text(found.plan.to_json())
    with Journal(tmp_path):
        pass
    (path,) = HtmlPage().write(tmp_path)
    assert path == tmp_path / "index.html"
    assert "8 cells have no result yet" in path.read_text("utf-8")
