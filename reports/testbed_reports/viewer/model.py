"""What the viewers of a page show: for each dataset its surfaces, packed, with scales that all of them share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed.harness.results import Results
from testbed_reports.formatting import shorten
from testbed_reports.grid import Grid, Row, is_ok
from testbed_reports.rendering.camera import Camera, turned
from testbed_reports.rendering.colouring import Scale, Style, rounded_up
from testbed_reports.rendering.figure import SMOOTH_DEG
from testbed_reports.shown_surfaces import ShownSurface, shown_level, shown_surfaces
from testbed_reports.viewer.encoding import packed
from testbed_reports.viewer.samples import SampledSurface, sampled, steps_for
from testbed_reports.viewer.stills import still

#: Characters that the packed surfaces of a page are to take together, about.
BUDGET: Final = 12_000_000
#: Characters that a triangle takes: of surfaces without symmetry about 15 a sample point, 1.5 triangles a point.
EACH: Final = 10.0
#: Most triangles of a surface, and most patches, beyond which a surface is left to ``testbed render``.
TRIANGLES: Final = 20_000
PATCHES: Final = 20_000
#: Points farther from the mesh's centre than this times its radius are not made room for.
ROOM: Final = 1.6
#: Which results mark a place: field, name of what is extreme, column, stem of the columns of the place.
EXTREMES: Final = (
    ("gauss", "largest K", "gauss_max", "gauss_max"),
    ("gauss", "smallest K", "gauss_min", "gauss_min"),
    ("mean", "largest H", "mean_max", "mean_max"),
    ("mean", "smallest H", "mean_min", "mean_min"),
    ("distance", "largest distance", "distance_max", "distance_max"),
    ("jump", "largest normal jump", "epsilon_deg", "epsilon"),
)
#: Fields with a scale of their own.
MAPS: Final[tuple[Style, ...]] = ("gauss", "mean", "distance")
#: The map that still pictures show.
STILL: Final[Style] = "gauss"


@dataclass(frozen=True)
class Card:
    """A scheme's surface.

    Parameters
    ----------
    position, scheme
        Position of the scheme in the plan, and its text.
    reason
        Why there is no surface; empty where there is one.
    data
        The packed surface.
    about
        How it is packed, and its ``marks``: field, name, value, point, face, place.
    still
        Address of its picture.
    extremes
        Least and largest Gaussian curvature of the results, in words; may be empty.
    triangles
        How many it is drawn with.
    """

    position: int
    scheme: str
    reason: str = ""
    data: str = ""
    about: Mapping[str, Any] | None = None
    still: str = ""
    extremes: str = ""
    triangles: int = 0


@dataclass(frozen=True)
class Scene:
    """The surfaces over a dataset at a level.

    Parameters
    ----------
    dataset, level
        Which.
    cards
        The schemes that are compared there, in the order of the plan.
    scales
        Limits by field: ``gauss``, ``mean``, ``distance`` and ``jump``; without those that no surface has values of.
    view
        Camera: ``azimuth`` and ``elevation`` in degrees, ``centre``, ``width``, ``radius``.
    """

    dataset: str
    level: int
    cards: tuple[Card, ...]
    scales: Mapping[str, tuple[float, float]]
    view: Mapping[str, Any]

    @property
    def shown(self) -> tuple[Card, ...]:
        """The cards that have a surface."""
        return tuple(card for card in self.cards if not card.reason)

    @property
    def without(self) -> tuple[Card, ...]:
        """The cards that have none."""
        return tuple(card for card in self.cards if card.reason)

    @property
    def triangles(self) -> str:
        """How many triangles a surface is drawn with, in words."""
        counts = sorted(card.triangles for card in self.shown)
        return str(counts[0]) if counts[0] == counts[-1] else f"{counts[0]} to {counts[-1]}"

    @property
    def size(self) -> int:
        """Characters of the packed surfaces."""
        return sum(len(card.data) for card in self.cards)


def triangles_for(surfaces: int, budget: int = BUDGET) -> int:
    """Return how many triangles each of some surfaces may have for all of them to stay within a budget, about."""
    return int(min(TRIANGLES, budget / EACH / max(surfaces, 1)))


def surface_count(grid: Grid) -> int:
    """Return how many surfaces a page shows, as far as the results tell."""
    return sum(is_ok(row) for dataset in grid.datasets for row in grid.at(dataset, shown_level(grid, dataset)))


def scene(results: Results, dataset: str, triangles: int) -> Scene:
    """Return the surfaces of a dataset, each of about so many triangles."""
    grid = Grid.of(results)
    level = shown_level(grid, dataset)
    found = list(shown_surfaces(results, dataset, level))
    surfaces: dict[str, SampledSurface] = {}
    reasons = {one.scheme: one.reason for one in found}
    for one in found:
        if one.surface is None:
            continue
        if one.surface.patch_count > PATCHES:
            reasons[one.scheme] = (
                f"{one.surface.patch_count} patches are too many for a page: `testbed render` draws it"
            )
        else:
            surfaces[one.scheme] = sampled(one.surface, steps_for(one.surface, triangles), one.exact)
    samples = list(surfaces.values())
    scales = _scales(samples)
    camera, view = _view(found, samples)
    cards = []
    for one in found:
        position = grid.schemes.index(one.scheme)
        if one.scheme not in surfaces or one.surface is None:
            cards.append(Card(position, one.scheme, reasons[one.scheme]))
            continue
        mine, row = surfaces[one.scheme], grid.cells[one.scheme, dataset, level]
        about = {"sides": one.surface.mesh.sides, "marks": _marks(one.surface, row)}
        pack = packed(mine, {name: _unit(name, high) for name, (_, high) in scales.items()})
        cards.append(
            Card(
                position,
                one.scheme,
                "",
                pack.text,
                {**pack.about, **about},
                still(mine, camera, STILL, Scale(*scales.get(STILL, (-1.0, 1.0)))),
                _extremes(row),
                mine.triangles,
            )
        )
    return Scene(dataset, level, tuple(cards), scales, view)


def _scales(samples: Sequence[SampledSurface]) -> dict[str, tuple[float, float]]:
    """Limits that suit all surfaces together."""
    result: dict[str, tuple[float, float]] = {}
    for name in (*MAPS, "jump"):
        values = np.concatenate([np.empty(0), *(one.values(name) for one in samples)])
        if not np.isfinite(values).any():
            continue
        if name == "jump":
            result[name] = (0.0, max(rounded_up(float(np.nanmax(values))), 10.0 * SMOOTH_DEG))
        else:
            scale = Scale.of(name, values)
            result[name] = (scale.low, scale.high)
    return result


def _unit(field: str, limit: float) -> float:
    """Return the value near which digits of a field matter."""
    return {"gauss": limit / 4.0, "mean": limit / 4.0, "distance": limit / 1000.0, "jump": SMOOTH_DEG}[field]


def _view(found: Sequence[ShownSurface], samples: Sequence[SampledSurface]) -> tuple[Camera, dict[str, Any]]:
    """Return a camera that has all surfaces in the picture, where they do not go far from their mesh, and the view."""
    mesh: Float = next((one.surface.mesh.points for one in found if one.surface is not None), np.zeros((1, 3)))
    middle = 0.5 * (mesh.min(axis=0) + mesh.max(axis=0))
    radius = float(norm(mesh - middle).max())
    points = np.concatenate([mesh, *(one.points for one in samples)])
    points = points[norm(points - middle) <= ROOM * radius]
    angles = turned(mesh)
    camera = Camera.around(points, *angles)
    view = {"azimuth": angles[0], "elevation": angles[1], "centre": list(camera.centre), "width": camera.width}
    return camera, {**view, "radius": radius or 1.0}


def _marks(surface: Surface, row: Row) -> list[dict[str, Any]]:
    """Return the places of the extremes in the results, as points."""
    marks = []
    for field, name, column, stem in EXTREMES:
        value, face, place = (row.get(key) for key in (column, f"{stem}_face", f"{stem}_bary"))
        if value is None or face is None or int(face) < 0 or not place:
            continue
        bary = [float(text) for text in str(place).split(";")]
        (point,) = surface.evaluate(np.array([int(face)]), np.array([bary]), 0).f
        marks.append(
            {
                "field": field,
                "name": name,
                "value": float(value),
                "point": point.tolist(),
                "face": int(face),
                "place": bary,
            }
        )
    return marks


def _extremes(row: Row) -> str:
    low, high = row.get("gauss_min"), row.get("gauss_max")
    return "" if low is None or high is None else f"K from {shorten(float(low))} to {shorten(float(high))}"
