"""Pictures of the surfaces of a dataset, side by side: shaded, and by Gaussian curvature with one scale for all."""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed import registry
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.colouring import Scale, Style
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.fields import fields
from testbed_reports.rendering.lines import Lines
from testbed_reports.rendering.picture import Look, common_scale, pixels
from testbed_reports.rendering.visibility import rasterise, sights
from testbed_reports.shown_surfaces import ShownSurface, shown_surfaces

#: Pixels along a side of a picture: 190 an inch at the width of a strip's column.
SIZE: Final = 220
#: Of JPEG, of 95.
QUALITY: Final = 92
#: Facets of a picture; its pixels are evaluated on the patches, facets tell which.
BUDGET: Final = 12_000
#: Surfaces of so many patches together are kept between finding the view and drawing; more are fitted again.
KEPT: Final = 200_000
#: The colourings of a strip.
STYLES: Final[tuple[Style, ...]] = ("shaded", "gauss")
NO_LINES: Final = Lines(np.empty((0, 2, 2)), np.empty(0), np.empty(0, dtype=bool))


@dataclass(frozen=True)
class Shot:
    """The pictures of a scheme's surface.

    Parameters
    ----------
    scheme
        Its text.
    images
        A JPEG file in each of :data:`STYLES`; empty where there is no surface.
    least, most
        Gaussian curvatures seen; None where there are none.
    reason
        Why there is no surface; empty where there is one.
    """

    scheme: str
    images: tuple[bytes, ...]
    least: float | None = None
    most: float | None = None
    reason: str = ""


@dataclass(frozen=True)
class Strip:
    """The pictures of a dataset.

    Parameters
    ----------
    level
        The level whose surfaces are shown.
    shots
        A shot a scheme, in the order of the plan.
    limit
        Gaussian curvature at the end of the colours.
    length
        What the width of a picture shows.
    aspect
        Height over width of the pictures.
    """

    level: int
    shots: tuple[Shot, ...]
    limit: float
    length: float
    aspect: float


def strip(results: Results, dataset: str, sources: Sources | None = None, size: int = SIZE) -> Strip | None:
    """Draw the surfaces of a dataset at the level that reports show; None if no scheme is planned there.

    Parameters
    ----------
    results, dataset
        The results, and the text of the dataset.
    sources
        Hashes of sources, if some are known already.
    size
        Pixels along a side of a picture.
    """
    found, corners, kept = [], [np.empty((0, 3))], 0
    for one in shown_surfaces(results, dataset, sources=sources):
        if one.surface is not None:
            corners.append(_extremes(one.surface))
            kept += one.surface.patch_count
        found.append((one, one.surface if kept <= KEPT else None))
    if not found:
        return None
    points = np.concatenate(corners)
    if not len(points):
        return Strip(found[0][0].level, tuple(_none(one) for one, _ in found), 1.0, 1.0, 1.0)
    camera = Camera.around(points)
    looks = [
        _look(_again(one) if surface is None else surface, camera, size) for one, surface in found if not one.reason
    ]
    scale = common_scale(looks, "gauss")
    rows = _rows(looks, size)
    remaining = iter(looks)
    shots = [_none(one) if one.reason else _shot(one, next(remaining), scale, rows) for one, _ in found]
    return Strip(found[0][0].level, tuple(shots), scale.high, camera.width, (rows[1] - rows[0]) / size)


def _none(one: ShownSurface) -> Shot:
    return Shot(one.scheme, (), reason=one.reason)


def _again(one: ShownSurface) -> Surface:
    """Fit a surface that was not kept."""
    return registry.scheme(one.scheme).fit(registry.dataset(one.dataset).mesh(one.level))


def _extremes(surface: Surface) -> Float:
    """Points of a surface that are outermost as the usual camera sees them, (6, 3) or fewer."""
    points = facets_of(surface, BUDGET // 4).points
    points = points[np.isfinite(points).all(axis=-1)]
    if not len(points):
        return points
    axes = np.array(Camera.around(points[:1]).axes)
    seen = points @ axes.T
    outermost: Float = points[np.concatenate([seen.argmin(axis=0), seen.argmax(axis=0)])]
    return outermost


def _look(surface: Surface, camera: Camera, size: int) -> Look:
    """See a surface once, for both colourings."""
    facets = facets_of(surface, BUDGET)
    seen = sights(facets, *rasterise(facets, camera, size))
    return Look(camera, seen, fields(surface, seen), np.zeros(len(seen), dtype=np.int64), NO_LINES)


def _rows(looks: Sequence[Look], size: int) -> tuple[int, int]:
    """The rows of pixels that hold all surfaces: the first, and the one after the last."""
    rows = np.concatenate([one.sights.pixel // size for one in looks])
    if not len(rows):
        return 0, size
    return max(0, int(rows.min()) - 3), min(size, int(rows.max()) + 4)


def _shot(one: ShownSurface, seen: Look, scale: Scale, rows: tuple[int, int]) -> Shot:
    images = tuple(_jpeg(pixels(seen, style, scale)[rows[0] : rows[1]]) for style in STYLES)
    known = seen.fields.gauss[np.isfinite(seen.fields.gauss)]
    least, most = (float(known.min()), float(known.max())) if len(known) else (None, None)
    return Shot(one.scheme, images, least, most)


def _jpeg(colours: Float) -> bytes:
    """A file that PDF holds as it is: a third of what lossless ones take there, and the same to the eye."""
    from PIL import Image

    stream = io.BytesIO()
    image = Image.fromarray((colours * 255.0 + 0.5).astype(np.uint8))
    image.save(stream, "JPEG", quality=QUALITY, subsampling=0)
    return stream.getvalue()
