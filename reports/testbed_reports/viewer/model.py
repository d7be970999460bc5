"""What the viewers of a page show: for each dataset its surfaces, packed, with scales that all of them share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.formatting import shorten
from testbed_reports.grid import Grid, Row, is_ok
from testbed_reports.rendering.camera import Camera, turned
from testbed_reports.rendering.colouring import Scale, Style, rounded_up
from testbed_reports.rendering.figure import SMOOTH_DEG
from testbed_reports.shown_surfaces import ShownSurface, shown_level, shown_surfaces
from testbed_reports.viewer.encoding import packed
from testbed_reports.viewer.samples import SampledSurface, sampled
from testbed_reports.viewer.stills import still

#: Characters that the packed surfaces of a page are to take together, about.
BUDGET: Final = 12_000_000
#: Characters that a sample point and an angle on an edge take, of surfaces without symmetry; others take a tenth.
EACH_POINT: Final = 13.0
EACH_ANGLE: Final = 2.0
#: Least and most steps that the sides of a patch are divided into.
STEPS: Final = (2, 60)
#: Most triangles of a surface, and most patches, beyond which a surface is left to ``testbed render``.
TRIANGLES: Final = 20_000
PATCHES: Final = 20_000
#: Points farther from the mesh's centre than this times its radius are not made room for.
ROOM: Final = 1.6
#: Lengths up to this share of the mesh's size are rounding, in distances and in the bending that curvature tells of.
ROUNDING: Final = 1e-9
#: Which results mark a place: field, name of what is extreme, column, stem of the columns of the place.
EXTREMES: Final = (
    ("gauss", "largest K", "gauss_max", "gauss_max"),
    ("gauss", "smallest K", "gauss_min", "gauss_min"),
    ("mean", "largest H", "mean_max", "mean_max"),
    ("mean", "smallest H", "mean_min", "mean_min"),
    ("distance", "largest distance", "distance_max", "distance_max"),
    ("jump", "largest normal jump", "epsilon_deg", "epsilon"),
)
#: Fields that have a least and a largest value, and their letters.
RANGES: Final = {"gauss": "K", "mean": "H"}
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
        By field, how far the results say that it goes, in words.
    triangles
        How many it is drawn with.
    """

    position: int
    scheme: str
    reason: str = ""
    data: str = ""
    about: Mapping[str, Any] | None = None
    still: str = ""
    extremes: Mapping[str, str] = field(default_factory=dict)
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


def steps_for(surface: Surface, characters: float) -> int:
    """Return the steps of the lattices that fill so many characters, as far as ``STEPS`` and ``TRIANGLES`` allow."""
    sides = [part.batch.sides for part in surface.parts]
    counts = [len(part.batch) for part in surface.parts]
    best = STEPS[0]
    for steps in range(STEPS[0] + 1, STEPS[1] + 1):
        triangles = sum(count * (side - 2) for count, side in zip(counts, sides, strict=True)) * steps**2
        points = sum(count * len(lattice(side, steps)) for count, side in zip(counts, sides, strict=True))
        taken = EACH_POINT * points + EACH_ANGLE * len(surface.edges) * (steps + 1)
        if triangles > TRIANGLES or taken > characters:
            break
        best = steps
    return best


def surface_count(grid: Grid) -> int:
    """Return how many surfaces a page shows, as far as the results tell."""
    return sum(is_ok(row) for dataset in grid.datasets for row in grid.at(dataset, shown_level(grid, dataset)))


def scene(results: Results, dataset: str, characters: float, sources: Sources | None = None) -> Scene:
    """Return the surfaces of a dataset.

    Parameters
    ----------
    results
        The results; those of the dataset are enough.
    dataset
        Its text.
    characters
        What each packed surface may take, about.
    sources
        Source hashes, if they are known.
    """
    grid = Grid.of(results)
    level = shown_level(grid, dataset)
    found = list(shown_surfaces(results, dataset, level, sources))
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
            surfaces[one.scheme] = sampled(one.surface, steps_for(one.surface, characters), one.exact)
    samples = list(surfaces.values())
    camera, view = _view(found, samples)
    scales = _scales(samples, view["radius"])
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
                extremes(row),
                mine.triangles,
            )
        )
    return Scene(dataset, level, tuple(cards), scales, view)


def _scales(samples: Sequence[SampledSurface], size: float) -> dict[str, tuple[float, float]]:
    """Limits that suit all surfaces together, of meshes of some size; never so narrow that rounding shows."""
    least = {"gauss": ROUNDING / size**2, "mean": ROUNDING / size, "distance": ROUNDING * size, "jump": SMOOTH_DEG}
    result: dict[str, tuple[float, float]] = {}
    for name in (*MAPS, "jump"):
        values = np.concatenate([np.empty(0), *(one.values(name) for one in samples)])
        if not np.isfinite(values).any():
            continue
        scale = Scale(0.0, rounded_up(float(np.nanmax(values)))) if name == "jump" else Scale.of(name, values)
        limit = max(scale.high, rounded_up(least[name]))
        result[name] = (-limit if scale.low < 0.0 else 0.0, limit)
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
    """Return the places of the extremes in the results, as points; of what is the same everywhere there are none."""
    marks = []
    for name, words, column, stem in EXTREMES:
        value, face, place = (row.get(key) for key in (column, f"{stem}_face", f"{stem}_bary"))
        if value is None or face is None or int(face) < 0 or not place:
            continue
        if name in RANGES and row.get(f"{name}_min") == row.get(f"{name}_max"):
            continue
        at = [float(text) for text in str(place).split(";")]
        (point,) = surface.evaluate(np.array([int(face)]), np.array([at]), 0).f
        found = {"field": name, "name": words, "value": float(value), "face": int(face), "point": point.tolist()}
        marks.append(found)
    return marks


def extremes(row: Row) -> dict[str, str]:
    """Return by field how far it goes in the results, in words."""
    result = {}
    for name, letter in RANGES.items():
        low, high = row.get(f"{name}_min"), row.get(f"{name}_max")
        if low is not None and high is not None:
            result[name] = f"{letter} from {_text(low)} to {_text(high)}"
    if row.get("distance_max") is not None:
        result["distance"] = f"distance up to {_text(row['distance_max'])}"
    if row.get("epsilon_deg") is not None:
        result["jump"] = f"normal jump up to {_text(row['epsilon_deg'])}°"
    return result


def _text(value: Any) -> str:
    return shorten(float(value)).replace("-", "\N{MINUS SIGN}")
