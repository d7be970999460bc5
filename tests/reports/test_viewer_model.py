"""Scenes of a page: limits that surfaces share, places of extremes, reasons, bounded size, any number of processes."""

import base64
import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from viewer_examples import DATASET, PLACE, SCHEMES, shown_results

from testbed import registry
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed_reports.viewer import model
from testbed_reports.viewer.model import BUDGET, EACH_POINT, TRIANGLES, Scene, scene, steps_for
from testbed_reports.viewer.samples import SampledSurface, sampled
from testbed_reports.viewer.scenes import scenes
from testbed_reports.viewer.stills import COLOURS, SIZE


@pytest.fixture(scope="module")
def octahedron() -> Scene:
    return scene(shown_results(refused="flat"), DATASET, 30_000)


def test_every_scheme_has_a_surface_or_a_reason(octahedron: Scene) -> None:
    assert [card.scheme for card in octahedron.cards] == list(SCHEMES)
    assert [card.scheme for card in octahedron.shown] == ["shirman-sequin", "nielson"]
    (flat,) = octahedron.without
    assert flat.reason == "it does not like this mesh"
    assert octahedron.size == sum(len(card.data) for card in octahedron.shown) > 0


def test_limits_of_curvature_are_symmetric_and_hold_nearly_all_values_of_all_surfaces(octahedron: Scene) -> None:
    for name in ("gauss", "mean"):
        low, high = octahedron.scales[name]
        assert low == -high
        assert high > 1.0  # the sphere's
    assert octahedron.scales["distance"][0] == 0.0


def test_limits_are_not_rounding(octahedron: Scene) -> None:
    plane = scene(shown_results(("flat", "nagata"), ("plane",)), "plane", 20_000)
    for name in ("gauss", "mean", "distance"):
        assert 1e-12 < plane.scales[name][1] < 1e-6 < octahedron.scales[name][1]


def test_marks_are_on_the_surface_where_the_results_say(octahedron: Scene) -> None:
    card = octahedron.shown[0]
    marks = {mark["name"]: mark for mark in (card.about or {})["marks"]}
    assert set(marks) == {"largest K", "largest normal jump"}  # the place of the smallest is not known
    surface = registry.scheme(card.scheme).fit(registry.dataset(DATASET).mesh(0))
    face, place = PLACE
    (point,) = surface.evaluate(np.array([face]), np.array([place]), 0).f
    np.testing.assert_allclose(marks["largest K"]["point"], point, rtol=1e-12)


def test_source_that_has_changed_shows_no_surface_and_says_so() -> None:
    found = shown_results()
    changed = replace(found.plan.schemes[0], source="another")
    results = replace(found, plan=replace(found.plan, schemes=(changed, *found.plan.schemes[1:])))
    cards = scene(results, DATASET, 10_000).cards
    assert "source has changed" in cards[0].reason
    assert not cards[1].reason


def test_a_surface_of_very_many_patches_is_left_to_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model, "PATCHES", 20)
    cards = {card.scheme: card for card in scene(shown_results(), DATASET, 10_000).cards}
    assert "24 patches are too many" in cards["shirman-sequin"].reason
    assert not cards["flat"].reason


@pytest.mark.parametrize("characters", [1e3, 1e4, 1e5, 1e9])
def test_lattices_are_as_fine_as_fits(characters: float) -> None:
    surface = registry.scheme("shirman-sequin").fit(registry.dataset("torus").mesh(0))
    steps = steps_for(surface, characters)
    points = 300 * (steps + 1) * (steps + 2) / 2
    assert steps == 2 or points * EACH_POINT <= characters
    assert 300 * steps**2 <= TRIANGLES
    assert steps == 8 or 300 * (steps + 1) * (steps + 2) * EACH_POINT > 0.5 * characters


def test_thirty_surfaces_of_twenty_thousand_triangles_fit() -> None:
    found = scene(shown_results(("nielson", "shirman-sequin"), ("torus",)), "torus", BUDGET / 30)
    assert all(card.triangles > 0.9 * TRIANGLES for card in found.shown)
    assert 15 * found.size < 8e6


def test_stills_are_small_pictures(octahedron: Scene) -> None:
    for card in octahedron.shown:
        kind, _, text = card.still.partition(",")
        assert kind == "data:image/png;base64"
        assert len(text) < 20_000
        image = Image.open(io.BytesIO(base64.b64decode(text)))
        assert image.size == (SIZE, SIZE)
        colours = image.convert("RGB").getcolors(COLOURS)
        assert colours is not None
        assert len(colours) > 8


def test_scenes_are_the_same_however_many_processes_make_them() -> None:
    found = shown_results(("shirman-sequin", "flat"), (DATASET, "graph"))
    assert scenes(found, jobs=2) == scenes(found, jobs=1)


def test_a_plugin_that_fails_now_costs_its_dataset_its_surfaces_only(monkeypatch: pytest.MonkeyPatch) -> None:
    found = shown_results(("shirman-sequin", "flat"), (DATASET, "graph"))

    def failing(surface: Surface, steps: int, exact: ExactSurface | None) -> SampledSurface:
        if len(surface.mesh.faces) == 8:
            raise ArithmeticError("no jets today")
        return sampled(surface, steps, exact)

    monkeypatch.setattr(model, "sampled", failing)
    first, second = scenes(found, jobs=1)
    assert [card.reason for card in first.cards] == ["ArithmeticError: no jets today"] * 2
    assert len(second.shown) == 2
