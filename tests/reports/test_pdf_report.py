"""The PDF is the same for the same results, holds all of them within its pages, and takes no markup from data."""

import ctypes
import dataclasses
import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pypdfium2
import pytest
from hand_made_results import COLUMNS, HOSTILE, RUN, good, results, without
from pypdfium2 import raw

from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.journal import Journal
from testbed.harness.plan import make_plan
from testbed.harness.results import Results, read_results
from testbed.harness.run import run
from testbed.plugins.measure import Column
from testbed_reports.pdf.lettering import BREAK, number
from testbed_reports.pdf.report import NAME, PdfReport, made

#: What typst would take for code or markup, what HTML would, and what is too long for any line.
MARKUP = '#import "x": * $ $ $x_1$ *bold* _slanted_ `raw` <label> @reference = heading // [unbalanced {( \\ \\u{41}'
LONG = "shirman-sequin" + "[boundary=hermite[root=worst],jensen_c=1.055" * 12 + "x" * 200
#: Points that stay free at every margin, but for the line with the page number.
MARGIN = 45.0
FOOT = 20.0


class Reader:
    """What a reader sees: text without places to break, boxes, pictures, and the contents."""

    def __init__(self, pdf: bytes) -> None:
        self.document = pypdfium2.PdfDocument(pdf)

    def __len__(self) -> int:
        return len(self.document)

    @cached_property
    def pages(self) -> list[str]:
        return [self._words(page.get_textpage().get_text_range()) for page in self.document]

    @cached_property
    def text(self) -> str:
        return " ".join(self.pages)

    @cached_property
    def letters(self) -> str:
        """All text without white space: however lines are broken, it reads the same."""
        return re.sub(r"\s", "", self.text)

    @staticmethod
    def _words(text: str) -> str:
        # U+FFFE stands where a line ends with a soft hyphen
        return re.sub(r"\s+", " ", text.replace(BREAK, "").replace("\ufffe", ""))

    def holds(self, text: str) -> bool:
        return re.sub(r"\s", "", text) in self.letters

    def boxes(self) -> Iterator[tuple[int, tuple[float, float], np.ndarray]]:
        """Page number, size of the page, and left, bottom, right and top of every piece of text."""
        for place, page in enumerate(self.document):
            text = page.get_textpage()
            yield (
                place + 1,
                page.get_size(),
                np.array([text.get_rect(i) for i in range(text.count_rects())]).reshape(-1, 4),
            )

    def count(self, kind: int) -> int:
        """Number of objects of a kind, in the pages of folios too."""
        return sum(1 for page in self.document for _ in page.get_objects(filter=[kind], max_depth=6))

    def contents(self) -> list[tuple[str, int]]:
        found = []
        for entry in self.document.get_toc():
            place = entry.get_dest()
            assert place is not None
            found.append((re.sub(r"\s+", " ", entry.get_title().replace(BREAK, "")), place.get_index()))
        return found


def pdf_of(found: Results) -> Reader:
    return Reader(made(found, jobs=1))


def assert_nothing_is_clipped(reader: Reader) -> None:
    for place, (width, height), boxes in reader.boxes():
        assert (boxes[:, 0] >= MARGIN).all(), place
        assert (boxes[:, 2] <= width - MARGIN).all(), place
        assert (boxes[:, 1] >= FOOT).all(), place
        assert (boxes[:, 3] <= height - FOOT).all(), place
        across = np.minimum(boxes[:, None, 2], boxes[:, 2]) - np.maximum(boxes[:, None, 0], boxes[:, 0])
        along = np.minimum(boxes[:, None, 3], boxes[:, 3]) - np.maximum(boxes[:, None, 1], boxes[:, 1])
        over = (across > 1.0) & (along > 0.5 * np.minimum(*np.broadcast_arrays(*_heights(boxes))))
        assert not np.triu(over, 1).any(), (place, boxes[np.nonzero(np.triu(over, 1))[0]])


def _heights(boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    heights = boxes[:, 3] - boxes[:, 1]
    return heights[:, None], heights


def sad(scheme: str, dataset: str, level: int) -> Outcome | None:
    """Return a cell whose number is like no other's; ``sad`` is refused or fails, or has no result yet."""
    where = f"{scheme} on {dataset}, level {level}"
    if scheme == "sad":
        if level == 2:
            return None
        return Outcome("failed" if level else "refused", f"because of {where}", f"Traceback of {where}", faces=8)
    return good(scheme, dataset, level, normal_max_deg=1.0 + level / 7 + len(dataset) / 11 + len(where) / 13)


@pytest.fixture(scope="module")
def usual() -> Reader:
    return pdf_of(results(("p2", "p4", "sad"), ("ball", "egg"), 3, sad))


def test_every_number_reason_and_traceback_is_in_it(usual: Reader) -> None:
    found = results(("p2", "p4", "sad"), ("ball", "egg"), 3, sad)
    for _, cell in found.cells.iterrows():
        if cell["status"] == "ok":
            assert number(f"{cell['normal_max_deg']:.5g}") in usual.text
        else:
            assert usual.holds(str(cell["reason"]))
    assert usual.holds("Traceback of sad on egg, level 1")
    assert usual.holds("2 cells without a result yet: sad on ball, level 2; sad on egg, level 2.")


def test_it_tells_where_the_results_come_from(usual: Reader) -> None:
    title = usual.pages[0]
    for text in (
        "testbed run -o 'a directory'",
        "2024-05-06T07:08:09+0000",
        "numpy 1.2.3",
        "3 processors",
        "3 schemes",
    ):
        assert re.sub(r"\s", "", text) in re.sub(r"\s", "", title)
    assert re.search(r"schemes [0-9a-f]{12}, datasets [0-9a-f]{12}", title)


def test_contents_lead_to_the_pages_where_the_sections_begin(usual: Reader) -> None:
    contents = usual.contents()
    assert contents[0][0] == "1 Summary"
    assert {"Datasets", "Schemes", "Appendix"} <= {title.partition(" ")[2] for title, _ in contents}
    for title, place in contents:
        assert re.sub(r"\s", "", title) in re.sub(r"\s", "", usual.pages[place]), title
    printed = re.findall(r"(\d[\d.]*) ([^.]+?)(?: \.){3,} (\d+)", usual.pages[1])
    assert {(f"{one} {title}", int(place) - 1) for one, title, place in printed} <= set(contents)
    assert len(printed) > 5


@pytest.mark.parametrize(
    ("title", "name", "leads_to"),
    [
        ("1 Summary", "egg", "4.2 a text egg"),
        ("4.2 a text egg", "section 6.3", "6.3 All numbers on egg"),
        ("5.1 a text p2", "ball", "4.1 a text ball"),
    ],
)
def test_names_and_numbers_lead_to_what_they_name(usual: Reader, title: str, name: str, leads_to: str) -> None:
    places = dict(usual.contents())
    page = usual.document[places[title]]
    text = page.get_textpage()
    found = set()
    search = text.search(name, match_case=True, match_whole_word=True)
    while (hit := search.get_next()) is not None:
        left, bottom, right, top = text.get_charbox(hit[0])
        link = raw.FPDFLink_GetLinkAtPoint(page.raw, (left + right) / 2, (bottom + top) / 2)
        if link:
            found.add(raw.FPDFDest_GetDestPageIndex(usual.document.raw, raw.FPDFLink_GetDest(usual.document.raw, link)))
    assert places[leads_to] in found


@pytest.mark.parametrize("kind", ["Table", "Figure"])
def test_figures_and_tables_are_numbered_in_order(usual: Reader, kind: str) -> None:
    captions = [int(found) for found in re.findall(rf"{kind} (\d+)\. ", usual.text)]
    assert len(captions) > 1
    # tables that go on tell their caption once; a caption is a number with a full stop
    assert list(dict.fromkeys(captions)) == list(range(1, max(captions) + 1))


def test_pages_have_numbers(usual: Reader) -> None:
    assert all(
        page.rstrip().endswith(f"{place} / {len(usual)}") or f"{place} / {len(usual)}" in page
        for place, page in enumerate(usual.pages, 1)
    )


def test_it_has_a_title_and_no_time(usual: Reader) -> None:
    told = usual.document.get_metadata_dict()
    assert told["Title"] == "Surface schemes compared"
    assert "D:20" not in told["CreationDate"] + told["ModDate"]


def test_all_fonts_are_embedded(usual: Reader) -> None:
    fonts = set()
    for page in usual.document:
        for text in page.get_objects(filter=[raw.FPDF_PAGEOBJ_TEXT], max_depth=6):
            font = raw.FPDFTextObj_GetFont(text.raw)
            length = raw.FPDFFont_GetBaseFontName(font, None, 0)
            buffer = ctypes.create_string_buffer(length)
            raw.FPDFFont_GetBaseFontName(font, buffer, length)
            fonts.add((buffer.value, raw.FPDFFont_GetIsEmbedded(font)))
    assert fonts
    assert {embedded for _, embedded in fonts} == {1}


def test_plots_are_lines_not_pixels(usual: Reader) -> None:
    assert usual.count(raw.FPDF_PAGEOBJ_IMAGE) == 0
    assert usual.count(raw.FPDF_PAGEOBJ_PATH) > 100


def test_the_same_results_give_the_same_bytes_whatever_the_settings_of_matplotlib_and_the_workers() -> None:
    found = results(levels=2)
    first = made(found, jobs=1)
    with mpl.rc_context({"svg.fonttype": "path", "lines.linewidth": 7.0, "svg.hashsalt": None}):
        assert made(found, jobs=1) == first
    assert made(found, jobs=2) == first


def hostile(text: str) -> Results:
    """Every text that does not come from here is hostile."""

    def cell(scheme: str, dataset: str, level: int) -> Outcome:
        if scheme == text:
            return Outcome("refused" if level else "failed", text, text, faces=8)
        return good(scheme, dataset, level, notes=text, epsilon_bary=text, fallbacks=level)

    return results(
        ("p4", text, f"x{text}"),
        (text, "ball"),
        2,
        cell,
        text=text,
        run={**RUN, "command": ["testbed", text], "versions": {text: text}, "started": text},
        columns=tuple(dataclasses.replace(column, meaning=text) for column in COLUMNS),
    )


@pytest.mark.parametrize(
    "text", [MARKUP, HOSTILE, LONG, "漢字\u202egnp\x00\ud800"], ids=["typst", "html", "long", "signs"]
)
def test_names_reasons_and_references_are_text_and_nothing_else(text: str) -> None:
    reader = pdf_of(hostile(text))
    shown = text.replace("漢字\u202e", "\\u6f22\\u5b57\\u202e").replace("\x00\ud800", "\\x00\\ud800")
    assert reader.letters.count(re.sub(r"\s", "", shown)) > 10
    assert_nothing_is_clipped(reader)
    # the outline has headings of the document only
    assert {title[0] for title, _ in reader.contents()} <= set("123456")


@pytest.mark.parametrize(
    "found",
    [
        results(levels=1),
        results(("p4",), levels=2),
        results(make=lambda *_: None, run={}),
        results(make=lambda *_: Outcome("refused", "no", faces=8)),
        results(make=lambda *at: good(*at) if at[2] < 2 or at[0] == "p2" else None),
        results(make=lambda *at: without(good(*at), "distance_max", "normal_max_deg"), shape=None),
        results(columns=(), make=lambda *at: dataclasses.replace(good(*at), values={})),
        results(make=lambda *at: good(*at, gauss_min=-123.0, normal_max_deg=1e300, distance_max=1e-300)),
        results(tuple(f"scheme-number-{number}[boundary=hermite]" for number in range(40)), levels=3),
        results(("p2", "p4"), tuple(f"dataset-number-{number}" for number in range(14)), levels=2),
        results(
            columns=(*COLUMNS, *(Column(f"quantity_of_place_{number}", "a meaning") for number in range(50))),
            make=lambda *at: good(*at, **{f"quantity_of_place_{number}": -1.2345e-13 * number for number in range(50)}),
        ),
    ],
    ids=[
        "one level",
        "one scheme",
        "nothing",
        "all refused",
        "partial",
        "no exact surface",
        "no columns",
        "wild",
        "many schemes",
        "many datasets",
        "many columns",
    ],
)
def test_results_of_every_sort_stay_within_their_pages(found: Results) -> None:
    reader = pdf_of(found)
    assert_nothing_is_clipped(reader)
    assert "NaN" not in reader.text
    assert all(reader.holds(cell.scheme) for cell in found.plan.cells)


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a directory with results of schemes of triangles and of quadrilaterals."""
    directory = tmp_path_factory.mktemp("computed")
    plan = make_plan(["flat", "nielson", "bicubic-interpolant", "peters-cubic"], ["ring", "quad-sphere"], "0:1")
    run(plan, directory, jobs=1, command=["testbed", "run"])
    return directory


def test_surfaces_are_shown_and_what_is_not_has_its_reason(computed: Path) -> None:
    (path,) = PdfReport().write(computed)
    assert path == computed / NAME
    reader = Reader(path.read_bytes())
    assert_nothing_is_clipped(reader)
    found = read_results(computed)
    coarsest = found.cells[found.cells["level"] == 0]
    shown = int((coarsest["status"] == "ok").sum())
    # shaded and by curvature with the dataset, shaded with the scheme
    assert reader.count(raw.FPDF_PAGEOBJ_IMAGE) == 3 * shown
    assert "Figure 1. Surfaces on ring, level 0, shaded" in reader.text
    assert "the same scale for all" in reader.text
    refused = found.cells[found.cells["status"] == "refused"].drop_duplicates(["scheme", "dataset"])
    assert len(refused)
    assert all(reader.holds(reason) for reason in refused["reason"])
    nielson = next(one for one in found.plan.schemes if one.spec == "nielson")
    assert reader.holds(nielson.reference)
    assert reader.holds("sum beta_i G_i")


def test_a_scheme_whose_source_has_changed_is_not_shown(computed: Path) -> None:
    found = read_results(computed)
    schemes = tuple(
        dataclasses.replace(one, source="0" * 64) if one.spec == "flat" else one for one in found.plan.schemes
    )
    reader = pdf_of(dataclasses.replace(found, plan=dataclasses.replace(found.plan, schemes=schemes)))
    assert reader.holds("its source has changed since the results were computed")
    assert reader.holds("Its source has changed since the results were computed; the words are today's.")


def test_the_report_writes_one_file_beside_the_results(tmp_path: Path) -> None:
    found = results()
    (tmp_path / "plan.json").write_text(found.plan.to_json())
    with Journal(tmp_path):
        pass
    (path,) = PdfReport().write(tmp_path)
    assert path == tmp_path / "report.pdf"
    assert sorted(one.name for one in tmp_path.iterdir() if one.suffix in (".pdf", ".part")) == ["report.pdf"]
    assert Reader(path.read_bytes()).holds("8 cells without a result yet")


def test_without_results_there_is_no_report(tmp_path: Path) -> None:
    with pytest.raises(TestbedError, match="holds no results"):
        PdfReport().write(tmp_path)
