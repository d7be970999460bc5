"""The page in a browser: surfaces are drawn, coloured, turned together and asked for values; tables sort and filter."""

import base64
import io
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browser import DRAWING, Visit, playing, start, visit
from hand_made_results import HOSTILE
from PIL import Image
from viewer_examples import DATASET, SCHEMES, shown_results

from testbed import registry
from testbed.geometry.curvature import analyse
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.harness.results import Results
from testbed_reports.page import render
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.colouring import Scale, Style
from testbed_reports.rendering.picture import look, pixels
from testbed_reports.view import view
from testbed_reports.viewer.markup import STYLES
from testbed_reports.viewer.model import Scene, scene

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Playwright

#: Page functions: the pixels of a canvas as text, and whether something is drawn on it.
PIXELS = "canvas => canvas.toDataURL()"


@pytest.fixture(scope="module")
def found() -> Results:
    return shown_results(datasets=(DATASET, "torus"))


@pytest.fixture(scope="module")
def octahedron(found: Results) -> Scene:
    return scene(found, DATASET, 40_000)


@pytest.fixture(scope="module")
def path(found: Results, octahedron: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of two datasets with three surfaces each; on the second, one has a hostile name."""
    second = scene(found, "torus", 40_000)
    hostile = replace(second, cards=(replace(second.cards[0], scheme=HOSTILE), *second.cards[1:]))
    file = tmp_path_factory.mktemp("page") / "index.html"
    file.write_text(render(view(found), (octahedron, hostile)), "utf-8")
    return file


def the_surface() -> Surface:
    """The first surface of the page."""
    return registry.scheme(SCHEMES[0]).fit(registry.dataset(DATASET).mesh(0))


def camera_of(scene: Scene) -> Camera:
    """The camera that a viewer begins with."""
    azimuth, elevation = scene.view["azimuth"], scene.view["elevation"]
    turned = Camera.around(np.zeros((1, 3)), azimuth, elevation)
    return replace(turned, centre=tuple(scene.view["centre"]), width=scene.view["width"])


@pytest.fixture(scope="module")
def playwright() -> Iterator["Playwright"]:
    with playing() as found:
        yield found


@pytest.fixture(scope="module")
def drawing(playwright: "Playwright") -> Iterator["Browser"]:
    found = start(playwright, *DRAWING)
    yield found
    found.close()


@pytest.fixture
def open_page(drawing: "Browser", path: Path) -> Iterator[Visit]:
    """The page at its first viewer, which is drawn; nothing is loaded and nothing goes wrong until the end."""
    with visit(drawing, path) as made:
        made.page.locator(".viewer").first.scroll_into_view_if_needed()
        made.page.wait_for_selector(".viewer[data-ready]", timeout=3000)
        yield made
        assert made.complaints == []
        assert [url for url in made.requests if not url.startswith(("file:", "data:"))] == []


def viewer(made: Visit, number: int = 0) -> "Locator":
    found = made.page.locator(".viewer").nth(number)
    found.scroll_into_view_if_needed()
    made.page.wait_for_function("k => document.querySelectorAll('.viewer')[k].dataset.ready !== undefined", arg=number)
    return found


def pictures(made: Visit, within: "Locator") -> list[str]:
    """What is drawn on all canvases, when the browser has drawn."""
    made.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return [str(one.evaluate(PIXELS)) for one in within.locator(".card canvas").all()]


def point_at(canvas: "Locator", right: float, down: float) -> None:
    """Move the mouse to a place of a canvas, in shares of its size."""
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    canvas.hover(position={"x": right * box["width"], "y": down * box["height"]})


def drag(made: Visit, canvas: "Locator", right: int, down: int) -> None:
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    made.page.mouse.move(x, y)
    made.page.mouse.down()
    made.page.mouse.move(x + right, y + down, steps=3)
    made.page.mouse.up()
    made.page.mouse.move(2, 2)


def test_every_colouring_draws_every_surface_differently(open_page: Visit) -> None:
    shown = viewer(open_page)
    drawn = {}
    for style, _ in STYLES:
        shown.locator("select").select_option(style)
        drawn[style] = pictures(open_page, shown)
    for number in range(len(SCHEMES)):
        assert len({pictures_[number] for pictures_ in drawn.values()}) == len(STYLES)
    assert all(len(set(pictures_)) == len(SCHEMES) for pictures_ in drawn.values())


def test_surfaces_look_as_in_pictures(open_page: Visit, octahedron: Scene) -> None:
    """The same colours at nearly all pixels as the renderer's, which asks the patches themselves."""
    shown = viewer(open_page)
    shown.locator("[name=marks]").uncheck()
    drawn = {}
    for style, _ in STYLES:
        shown.locator("select").select_option(style)
        drawn[style] = decoded(pictures(open_page, shown)[0])
    size = min(drawn["gauss"].shape[:2])
    groups: tuple[tuple[Style, ...], ...] = (
        ("gauss", "mean", "thesis"),
        ("isophotes", "zebra", "shaded"),
        ("distance",),
    )
    for styles in groups:
        seen = look(the_surface(), styles[0], size, camera_of(octahedron), registry.dataset(DATASET).surface)
        for style in styles:
            limits = (-4.0, 4.0) if style == "thesis" else octahedron.scales.get(style, (0.0, 1.0))
            expected = pixels(seen, style, Scale(*limits))
            difference = np.abs(drawn[style][:size, :size] - expected).max(axis=-1)
            assert (expected.min(axis=-1) < 0.99).mean() > 0.3  # there is something in the picture
            assert (difference > 0.1).mean() < 0.04, style


def decoded(picture: str) -> Float:
    """Colours from 0 to 1 of a picture, (H, W, 3)."""
    with Image.open(io.BytesIO(base64.b64decode(picture.partition(",")[2]))) as image:
        return np.asarray(image.convert("RGB"), dtype=np.float64) / 255.0


def test_turning_one_turns_all_until_they_are_no_longer_linked(open_page: Visit) -> None:
    shown = viewer(open_page)
    canvas = shown.locator(".card canvas").first
    before = pictures(open_page, shown)
    drag(open_page, canvas, 60, 10)
    turned = pictures(open_page, shown)
    assert all(a != b for a, b in zip(before, turned, strict=True))
    shown.locator("[name=linked]").uncheck()
    drag(open_page, canvas, 50, -20)
    alone = pictures(open_page, shown)
    assert [a != b for a, b in zip(turned, alone, strict=True)] == [True, False, False]
    shown.locator("[name=linked]").check()
    assert pictures(open_page, shown) == turned
    shown.get_by_role("button", name="Reset view").click()
    assert pictures(open_page, shown) == before


def test_wheel_and_keys_enlarge_and_turn(open_page: Visit) -> None:
    shown = viewer(open_page)
    before = pictures(open_page, shown)
    shown.locator(".card canvas").nth(1).hover()
    open_page.page.wait_for_timeout(450)  # the page has come to rest
    open_page.page.mouse.move(640, 450)
    shown.locator(".card canvas").nth(1).hover()
    open_page.page.mouse.wheel(0, -300)
    open_page.page.wait_for_timeout(50)
    larger = pictures(open_page, shown)
    assert all(a != b for a, b in zip(before, larger, strict=True))
    shown.locator(".cards").focus()
    open_page.page.keyboard.press("ArrowLeft")
    assert all(a != b for a, b in zip(larger, pictures(open_page, shown), strict=True))
    open_page.page.keyboard.press("0")
    assert pictures(open_page, shown) == before


def test_edges_marks_and_limits_change_the_picture_and_the_bar(open_page: Visit) -> None:
    shown = viewer(open_page)
    seen = {tuple(pictures(open_page, shown))}
    shown.locator("[name=edges]").check()
    seen.add(tuple(pictures(open_page, shown)))
    shown.locator("[name=marks]").uncheck()
    seen.add(tuple(pictures(open_page, shown)))
    ticks = shown.locator(".ticks").inner_text()
    shown.get_by_role("button", name="limits ÷ 2").click()
    seen.add(tuple(pictures(open_page, shown)))
    assert len(seen) == 4
    low, middle, high = (float(text.replace("\N{MINUS SIGN}", "-")) for text in ticks.split())
    assert (low, middle) == (-high, 0.0)
    assert float(shown.locator(".ticks span").last.inner_text()) == pytest.approx(high / 2)


def test_values_at_a_place_are_those_of_the_surface(open_page: Visit, octahedron: Scene) -> None:
    shown = viewer(open_page)
    canvas = shown.locator(".card canvas").first
    point_at(canvas, 0.52, 0.58)
    tip = shown.locator(".tip")
    assert tip.locator("b").inner_text() == SCHEMES[0]
    names = tip.locator("dt").all_inner_texts()
    texts = dict(zip(names, tip.locator("dd").all_inner_texts(), strict=True))

    def numbers(text: str) -> list[float]:
        return [float(one) for one in text.replace("\N{MINUS SIGN}", "-").strip("()").split(",")]

    (face,) = (name for name in names if name.startswith("face"))
    place = np.array(numbers(texts[face]))
    jet = the_surface().evaluate(np.array([int(face.split()[1])]), (place / place.sum())[None])
    analysis = analyse(jet)
    np.testing.assert_allclose(numbers(texts["point"]), jet.f[0], atol=3e-3)
    np.testing.assert_allclose(numbers(texts["normal"]), analysis.normal[0], atol=5e-3)
    np.testing.assert_allclose(numbers(texts["K"]), analysis.gauss, rtol=0.05, atol=0.02)
    np.testing.assert_allclose(numbers(texts["H"]), analysis.mean, rtol=0.05, atol=0.02)
    exact = registry.dataset(DATASET).surface
    assert exact is not None
    distance = np.linalg.norm(jet.f - exact.closest(jet.f))
    np.testing.assert_allclose(numbers(texts["distance"]), distance, rtol=0.1, atol=1e-3)
    # it is the place under the mouse, on the near side
    camera = camera_of(octahedron)
    np.testing.assert_allclose(camera.screen(jet.f, 100)[0, :2], [52.0, 58.0], atol=0.6)
    assert analysis.normal[0] @ camera.towards > 0.0


def test_hostile_names_are_text_everywhere(open_page: Visit) -> None:
    shown = viewer(open_page, 1)
    assert shown.locator(".card .name").first.inner_text() == HOSTILE
    point_at(shown.locator(".card canvas").first, 0.5, 0.62)
    assert shown.locator(".tip b").inner_text() == HOSTILE
    assert open_page.page.locator("img:not(.picture img)").count() == 0


def test_tables_sort_by_mouse_and_keyboard(open_page: Visit) -> None:
    table = open_page.page.locator("#dataset-0 table.compare")
    heading = table.locator("thead tr").last.locator("th", has_text=re.compile("rms|max")).first

    def column() -> list[float]:
        cells = table.locator(f"tbody tr > :nth-child({int(heading.evaluate('th => th.cellIndex')) + 1})")
        return [float(cell.locator("span").get_attribute("title") or "nan") for cell in cells.all()]

    before = column()
    heading.click()
    assert heading.get_attribute("aria-sort") == "ascending"
    assert column() == sorted(before)
    heading.get_by_role("button").focus()
    open_page.page.keyboard.press("Enter")
    assert heading.get_attribute("aria-sort") == "descending"
    assert column() == sorted(before, reverse=True)
    open_page.page.keyboard.press("Enter")
    assert heading.get_attribute("aria-sort") is None
    assert column() == before


def test_schemes_are_filtered_in_the_viewer(open_page: Visit) -> None:
    shown = viewer(open_page)
    for text, visible in (("niel", [False, True, False]), ("Man shir", [True, False, False]), ("", [True] * 3)):
        shown.locator("[name=schemes]").fill(text)
        assert [one.is_visible() for one in shown.locator(".card").all()] == visible


def test_numbers_show_the_command_that_reproduces_them(open_page: Visit) -> None:
    cell = open_page.page.locator("#dataset-0 table.compare tbody tr").nth(1).locator("td").nth(1)
    cell.click()
    bar = open_page.page.locator(".command")
    assert bar.locator("code").inner_text() == f"testbed run -s {SCHEMES[1]} -d {DATASET} --levels 0:0"
    assert str(cell.locator("span").get_attribute("title")) in bar.locator(".what").inner_text()
    cell.focus()
    open_page.page.keyboard.press("Escape")
    assert bar.is_hidden()
    open_page.page.locator("#orders td").first.focus()
    open_page.page.keyboard.press("ArrowRight")
    open_page.page.keyboard.press("Enter")
    assert bar.locator("code").inner_text() == f"testbed run -s {SCHEMES[0]} -d torus --levels 0:0"


def test_a_narrow_page_is_no_wider_than_its_window_and_its_viewers_draw(drawing: "Browser", path: Path) -> None:
    with visit(drawing, path, width=390) as made:
        shown = viewer(made)
        assert len(set(pictures(made, shown))) == len(SCHEMES)
        assert made.page.evaluate("document.documentElement.scrollWidth") <= 390


def test_on_paper_the_pictures_stand_and_the_controls_are_gone(open_page: Visit) -> None:
    shown = viewer(open_page)
    open_page.page.emulate_media(media="print")
    assert shown.locator(".controls").is_hidden()
    assert all(one.is_visible() for one in shown.locator("img").all())
    assert not any(one.is_visible() for one in shown.locator("canvas").all())
    assert shown.locator(".legend-still").is_visible()


def test_without_webgl_and_without_scripts_the_pictures_stand(playwright: "Playwright", path: Path) -> None:
    found = start(playwright, "--disable-3d-apis")
    try:
        for scripts in (True, False):
            with visit(found, path, scripts=scripts) as made:
                images = made.page.locator("#dataset-0 .viewer img")
                assert images.count() == len(SCHEMES)
                assert all(one.is_visible() and one.evaluate("img => img.naturalWidth") > 0 for one in images.all())
                assert made.page.locator("#dataset-0 .legend-still").is_visible()
                assert made.page.locator(".card canvas").count() == 0
                assert made.page.get_by_text("Scripts do not run here").is_visible() == (not scripts)
                if scripts:
                    assert made.page.locator("html").get_attribute("data-viewer") == "pictures"
                    assert made.page.locator("thead .sort").count() > 0
                assert made.complaints == []
    finally:
        found.close()
