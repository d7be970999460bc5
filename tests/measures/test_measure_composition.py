from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from built_surfaces import OCTAHEDRON, OCTANTS, UnitSphere, bumpy_octahedron, octahedron

from testbed import registry
from testbed.errors import PluginError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float
from testbed.measures import sampling
from testbed.plugins.measure import Column, Measure, Survey, Value, measure_all

CONTRACT = (
    "vertices",
    "faces",
    "patches",
    "h",
    "distance_max",
    "distance_rms",
    "normal_max_deg",
    "gauss_min",
    "gauss_max",
    "mean_min",
    "mean_max",
    "epsilon_deg",
    "gap_max",
    "curvature_jump_max",
    "curvature_jump_face",
    "curvature_jump_bary",
    "gauss_min_face",
    "gauss_min_bary",
    "gauss_max_face",
    "gauss_max_bary",
    "mean_min_face",
    "mean_min_bary",
    "mean_max_face",
    "mean_max_bary",
    "distance_max_face",
    "distance_max_bary",
    "normal_max_face",
    "normal_max_bary",
    "epsilon_face",
    "epsilon_bary",
    "gap_face",
    "gap_bary",
    "edges_above_0p057_deg",
    "edges_above_0p1_deg",
    "edges_above_0p5_deg",
    "edges_above_1_deg",
    "fallbacks",
    "notes",
    "curvature_corner_margin",
    "samples_per_patch",
    "interior_edges",
)


def test_all_columns_of_the_contract_are_measured() -> None:
    found = registry.measure(octahedron(), UnitSphere())
    assert set(CONTRACT) <= set(found)
    assert (found["vertices"], found["faces"], found["patches"]) == (6, 8, 8)
    assert found["h"] == pytest.approx(np.sqrt(2.0))


def test_without_an_exact_surface_its_columns_are_missing_and_the_rest_is_the_same() -> None:
    surface = bumpy_octahedron()
    without, found = registry.measure(surface), registry.measure(surface, UnitSphere())
    assert not any(name.startswith(("distance", "normal")) for name in without)
    assert {name: found[name] for name in without} == without


def test_what_converges_is_an_error() -> None:
    converging = {column.name for one in registry.measures() for column in one.columns if column.converges}
    errors = {f"{name}_error_{kind}" for name in ("gauss", "mean") for kind in ("max", "rms")}
    assert converging == {"distance_max", "distance_rms", "normal_max_deg", "epsilon_deg"} | errors


def test_fallbacks_are_counted_and_named() -> None:
    surface = octahedron()
    noted = Surface(surface.mesh, surface.parts, {"singular centres": 1, "curves without a root": 3, "none": 0})
    found = registry.measure(noted)
    assert found["fallbacks"] == 4
    assert found["notes"] == "3 curves without a root; 1 singular centres"


def test_the_order_of_patches_does_not_matter() -> None:
    whole = bumpy_octahedron()
    order = np.array([5, 2, 7, 0, 1, 6, 3, 4])
    part = whole.parts[0]
    shuffled = Part(part.batch.take(order), part.corner_ids[order], part.faces[order], part.corners_in_face[order])
    assert registry.measure(Surface(whole.mesh, (shuffled,)), UnitSphere()) == registry.measure(whole, UnitSphere())


def test_the_order_of_patches_does_not_matter_where_all_are_alike() -> None:
    whole = octahedron()
    order = np.arange(8)[::-1]
    part = whole.parts[0]
    shuffled = Part(part.batch.take(order), part.corner_ids[order], part.faces[order], part.corners_in_face[order])
    assert registry.measure(Surface(whole.mesh, (shuffled,)), UnitSphere()) == registry.measure(whole, UnitSphere())


def test_the_division_into_parts_and_chunks_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = bumpy_octahedron()
    batch, mesh = whole.batches[0], whole.mesh
    parts = tuple(
        Part(batch.take(some), mesh.faces[some], some, np.broadcast_to(CORNERS[3], (len(some), 3, 2)))
        for some in (np.array([6, 1]), np.array([0, 2, 3, 4, 5]), np.array([7]))
    )
    found = registry.measure(whole, UnitSphere())
    monkeypatch.setattr(sampling, "CHUNK", 200)
    divided = registry.measure(Surface(mesh, parts), UnitSphere())
    rms = divided.pop("distance_rms")
    assert rms == pytest.approx(found.pop("distance_rms"), rel=1e-14)  # a sum over patches, rounded in another order
    assert divided == found


class MovedSphere(ExactSurface):
    """The unit sphere turned, scaled and moved."""

    def __init__(self, scale: float, shift: Float) -> None:
        self.scale, self.shift = scale, shift

    def closest(self, points: Float) -> Float:
        return self.shift + self.scale * UnitSphere().closest(points - self.shift)

    def normal(self, points: Float) -> Float:
        return (points - self.shift) / self.scale

    def second_form(self, points: Float) -> Float:
        return UnitSphere().second_form(self.normal(points)) / self.scale


@pytest.mark.parametrize("scale", [1e-3, 1.0, 700.0])
def test_measures_move_and_scale_with_the_surface(scale: float) -> None:
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    shift = scale * np.array([0.3, -0.2, 0.5])
    surface = bumpy_octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    moved = Surface.over_faces(
        HermiteMesh(scale * OCTAHEDRON @ turn.T + shift, OCTANTS),
        BezierTriangles(scale * batch.control_points @ turn.T + shift),
    )
    before = registry.measure(surface, UnitSphere())
    after = registry.measure(moved, MovedSphere(scale, shift))
    power = {"h": 1, "distance_max": 1, "distance_rms": 1, "gap_max": 1, "gauss_min": -2, "gauss_max": -2} | {
        "mean_min": -1,
        "mean_max": -1,
        "normal_max_deg": 0,
        "epsilon_deg": 0,
        "curvature_jump_max": 0,
    }
    for name, exponent in power.items():
        value = before[name]
        assert isinstance(value, float)
        assert after[name] == pytest.approx(value * scale**exponent, rel=1e-9), name
    for name in ("gauss_max_face", "epsilon_face", "distance_max_face", "gap_face", "curvature_jump_face"):
        assert after[name] == before[name]


@dataclass(frozen=True)
class Careless(Measure):
    """Declares one column and returns another."""

    name: ClassVar[str] = "careless"
    title: ClassVar[str] = "Careless"
    reference: ClassVar[str] = "none"
    columns: ClassVar[tuple[Column, ...]] = (Column("declared", "a number"),)

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        return {"returned": survey.surface.patch_count}


@dataclass(frozen=True)
class Again(Careless):
    """Declares the faces once more."""

    columns: ClassVar[tuple[Column, ...]] = (Column("faces", "a number"),)

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        return {"faces": survey.surface.patch_count}


def test_columns_are_those_declared() -> None:
    with pytest.raises(PluginError, match="careless declares other columns than it returns, declared, returned"):
        measure_all([Careless()], octahedron(), None)


def test_no_two_measures_share_a_column() -> None:
    with pytest.raises(PluginError, match="column faces"):
        measure_all([*registry.measures(), Again()], octahedron(), None)


def test_measures_share_what_they_compute_and_surveys_do_not() -> None:
    calls = []

    def compute(survey: Survey, budget: int) -> int:
        calls.append(budget)
        return survey.surface.patch_count * budget

    survey = Survey(octahedron())
    assert [survey.shared(compute, 2), survey.shared(compute, 2), survey.shared(compute, 3)] == [16, 16, 24]
    assert Survey(octahedron()).shared(compute, 2) == 16
    assert calls == [2, 3, 2]
