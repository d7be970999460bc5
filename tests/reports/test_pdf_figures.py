"""Pictures and plots of a PDF: the same whoever draws them, all of a dataset on one scale, and whole."""

import dataclasses
import io
import os
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hand_made_results import good, results
from PIL import Image

from testbed import registry
from testbed.errors import TestbedError
from testbed.harness.cell import Outcome
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.pdf import strips
from testbed_reports.pdf.document import document
from testbed_reports.pdf.figures import figures, files, swatch
from testbed_reports.pdf.pool import Lost, Pool
from testbed_reports.pdf.report import made
from testbed_reports.pdf.scheme_pages import descriptions
from testbed_reports.pdf.strips import Strip, strip
from testbed_reports.styles import style
from testbed_reports.view import view

SCHEMES = ("flat", "nielson", "bicubic-interpolant")


def of_today(schemes: Sequence[str] = SCHEMES, dataset: str = "octahedron") -> Results:
    """Return results by hand whose sources are those of today; the last scheme is refused."""

    def cell(scheme: str, _: str, level: int) -> Outcome:
        return Outcome("refused", "no quadrilaterals") if scheme == SCHEMES[-1] else good(scheme, dataset, level)

    found, sources = results(schemes, (dataset,), 1, cell), Sources()
    planned = tuple(
        dataclasses.replace(one, source=sources.content(registry.scheme(one.spec))) for one in found.plan.schemes
    )
    data = dataclasses.replace(found.plan.datasets[0], source=sources.content(registry.dataset(dataset)))
    return dataclasses.replace(found, plan=dataclasses.replace(found.plan, schemes=planned, datasets=(data,)))


@pytest.fixture(scope="module")
def drawn() -> Strip:
    found = strip(of_today(), "octahedron", size=90)
    assert found is not None
    return found


def pixels(image: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(image)).convert("RGB")).astype(np.int64)


def test_every_scheme_has_two_pictures_or_a_reason(drawn: Strip) -> None:
    assert [shot.scheme for shot in drawn.shots] == list(SCHEMES)
    assert [len(shot.images) for shot in drawn.shots] == [2, 2, 0]
    assert [shot.reason for shot in drawn.shots] == ["", "", "no quadrilaterals"]


def test_pictures_hold_the_whole_of_all_surfaces_and_are_of_one_size(drawn: Strip) -> None:
    images = [pixels(image) for shot in drawn.shots for image in shot.images]
    assert {image.shape for image in images} == {(round(90 * drawn.aspect), 90, 3)}
    for image in images:
        dark = (image < 200).any(axis=-1)
        assert dark[10:-10].any()
        # the border is background, but for what JPEG blurs
        assert not dark[[0, -1]].any()
        assert not dark[:, [0, -1]].any()


def test_curvatures_seen_are_told_and_lie_around_the_scale(drawn: Strip) -> None:
    flat, nielson = drawn.shots[:2]
    assert (flat.least, flat.most) == (0.0, 0.0)
    assert nielson.least is not None
    assert nielson.most is not None
    assert 0.3 < nielson.least < 1.0 < nielson.most
    assert 1.0 <= drawn.limit <= 3.0
    # zero is grey on a scale that is symmetric about it
    middle = pixels(flat.images[1])[40, 40]
    assert np.ptp(middle) < 8


def test_surfaces_that_are_fitted_again_look_the_same(drawn: Strip, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(strips, "KEPT", 0)
    assert strip(of_today(), "octahedron", size=90) == drawn


def test_without_surfaces_there_are_reasons_only() -> None:
    found = strip(results(("flat",), ("octahedron",), 1), "octahedron")
    assert found is not None
    assert [shot.images for shot in found.shots] == [()]
    assert "source has changed" in found.shots[0].reason


def test_plots_and_swatches_are_files_of_their_own() -> None:
    found = results(levels=2)
    page = view(found)
    with Pool(1) as pool:
        made_files = files(page, figures(found, page, pool))
    plots = [content for name, content in made_files.items() if name.startswith("plot")]
    assert len(plots) == sum(len(drawing.panels) for section in page.sections for drawing in section.drawings)
    for content in (*plots, swatch(style(3)).encode()):
        root = ElementTree.fromstring(content)  # noqa: S314 - ours
        assert root.tag == "{http://www.w3.org/2000/svg}svg"


def test_a_task_that_ends_its_process_costs_itself_only() -> None:
    with Pool(2) as pool:
        found = pool.map(os._exit, [(3,)])
        assert isinstance(found[0], Lost)
        assert "exit code 3" in found[0].reason
        assert pool.map(abs, [(-1,), (2,), (-3,)]) == [1, 2, 3]


class LosingPool(Pool):
    """A pool that loses what it is to draw."""

    def map(self, function: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> list[Any]:
        del function
        return [Lost("the worker process ended")] * len(tasks)


def test_plots_stand_and_the_reason_is_told_where_drawing_surfaces_ends_a_process() -> None:
    found = of_today()
    page = view(found)
    with LosingPool(1) as pool:
        lost = figures(found, page, pool)
    assert [bool(one.plots) for one in lost] == [True]
    made_document = document(found, page, lost, descriptions(found, Sources()))
    told = [
        getattr(run, "text", "")
        for folio in made_document.folios
        for block in folio.blocks
        for run in getattr(block, "runs", ())
    ]
    assert "There are no pictures of the surfaces: the worker process ended." in told


def test_without_typst_the_report_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    with pytest.raises(TestbedError, match="pip install typst"):
        made(results(levels=1), jobs=1)
