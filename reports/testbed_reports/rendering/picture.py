"""From a surface to the pixels of a picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int
from testbed_reports.rendering.camera import VIEW, Camera
from testbed_reports.rendering.colouring import (
    BACKGROUND,
    CURVED,
    EXACT,
    LABELS,
    STRIPED,
    Scale,
    Style,
    coloured,
    mapped,
)
from testbed_reports.rendering.facets import facets_of
from testbed_reports.rendering.fields import Fields, fields
from testbed_reports.rendering.lines import Lines, edge_lines
from testbed_reports.rendering.visibility import Buffer, Sights, rasterise, sights

#: Places coloured at once.
CHUNK = 1 << 18


@dataclass(frozen=True, eq=False)
class Look:
    """A surface as a camera sees it, before it is coloured.

    Parameters
    ----------
    camera
        The camera.
    sights
        The places that pixels look at.
    fields
        Their values.
    group
        (N,) which of the colours of ``patches`` each has: 0 on faces, 1 beside them, 2 and 3 for further kinds.
    lines
        The visible edges of patches.
    buffer
        The z-buffer, or None where the picture is not to be drawn on.
    """

    camera: Camera
    sights: Sights
    fields: Fields
    group: Int
    lines: Lines
    buffer: Buffer | None = None


def look(
    surface: Surface,
    style: Style,
    size: int,
    camera: Camera | None = None,
    exact: ExactSurface | None = None,
) -> Look:
    """See a surface in a style.

    Parameters
    ----------
    size
        Pixels along a side of the picture.
    camera
        Where from; None for the usual view.
    exact
        The exact surface, for distances.
    """
    facets = facets_of(surface)
    camera = camera or Camera.around(facets.points[np.isfinite(facets.points).all(axis=-1)], *VIEW)
    buffer, weights = rasterise(facets, camera, size)
    seen = sights(facets, buffer, weights, every_sample=style in STRIPED)
    values = fields(surface, seen, curved=style in CURVED, exact=exact if style in EXACT else None)
    kinds = np.array([0 if part.batch.sides == surface.mesh.sides else 1 for part in surface.parts])
    return Look(camera, seen, values, kinds[seen.part], edge_lines(surface, camera, facets, buffer), buffer)


def pixels(one: Look, style: Style, scale: Scale, base: Float | None = None) -> Float:
    """Return the picture, (size, size, 3) from 0 to 1.

    Parameters
    ----------
    base
        Colours (N, 3) of the places that are seen, to be shaded in place of the usual ones.
    """
    size = one.sights.size
    share = np.bincount(one.sights.pixel, weights=one.sights.share, minlength=size * size)
    image = (1.0 - share)[:, None] * BACKGROUND
    for some in (slice(first, first + CHUNK) for first in range(0, len(one.sights), CHUNK)):
        seen = one.sights.some(some)
        own = None if base is None else base[some]
        colours = coloured(style, one.fields.some(some), seen, one.camera, scale, one.group[some], own)
        for channel in range(3):
            image[:, channel] += np.bincount(
                seen.pixel, weights=seen.share * colours[:, channel], minlength=size * size
            )
    whole: Float = image.reshape(size, size, 3).clip(0.0, 1.0)
    return whole


def tinted(seen: Sights, colours: Sequence[Float]) -> Float:
    """Colours (N, 3) of the places that are seen, from those of the patches of each part, (P, 3)."""
    result = np.empty((len(seen), 3))
    for index, own in enumerate(colours):
        mine = seen.part == index
        result[mine] = own[seen.patch[mine]]
    return result


def common_scale(looks: Sequence[Look], style: Style) -> Scale:
    """Return one scale for all pictures that are compared."""
    if style not in LABELS:
        return Scale(0.0, 1.0)
    return Scale.of(style, np.concatenate([mapped(style, one.fields) for one in looks]))
