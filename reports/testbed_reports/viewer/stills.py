"""Small pictures of sampled surfaces, for paper and for browsers that cannot draw the surfaces themselves."""

import base64
import io
from typing import Final

import numpy as np

from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float, Int, unit
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.colouring import Scale, Style
from testbed_reports.rendering.facets import Facets, lattice_facets
from testbed_reports.rendering.fields import Fields
from testbed_reports.rendering.lines import Lines
from testbed_reports.rendering.picture import Look, pixels
from testbed_reports.rendering.visibility import GRID, Sights, rasterise
from testbed_reports.viewer.samples import SampledSurface

#: Pixels along a side, and colours of a picture.
SIZE: Final = 160
COLOURS: Final = 64


def still(surface: SampledSurface, camera: Camera, style: Style, scale: Scale, size: int = SIZE) -> str:
    """Return a picture as the address of an image that holds it, ``data:image/png;base64,...``.

    Between the samples, values and normals are interpolated.
    """
    look = _look(surface, camera, size)
    return _address(pixels(look, style, scale))


def _look(surface: SampledSurface, camera: Camera, size: int) -> Look:
    """See a sampled surface: every sample of the picture looks at a place of its own."""
    facets, values = _facets(surface)
    buffer, weights = rasterise(facets, camera, size)
    row, column = np.nonzero(buffer.facet >= 0)
    facet, weight = buffer.facet[row, column], weights[row, column]
    seen = (values[facets.corners[facet]] * weight[..., None]).sum(axis=1)
    sights = Sights(
        size,
        row // GRID * size + column // GRID,
        np.full(len(facet), 1.0 / GRID**2),
        facets.part[facet],
        facets.patch[facet],
        (facets.at[facet] * weight[..., None]).sum(axis=1),
    )
    fields = Fields(unit(seen[:, :3]), seen[:, 3], seen[:, 4], seen[:, 5])
    nothing = Lines(np.empty((0, 2, 2)), np.empty(0), np.empty(0, dtype=np.bool_))
    return Look(camera, sights, fields, np.zeros(len(facet), dtype=np.int64), nothing)


def _facets(surface: SampledSurface) -> tuple[Facets, Float]:
    """Triangles between the samples, and the normal, curvatures and distance of each sample, (N, 6)."""
    points: list[Float] = [np.empty((0, 3))]
    values: list[Float] = [np.empty((0, 6))]
    corners: list[Int] = [np.empty((0, 3), dtype=np.int64)]
    places: list[Float] = [np.empty((0, 3, 2))]
    parts, patches = [np.empty(0, dtype=np.int64)], [np.empty(0, dtype=np.int64)]
    first = 0
    for index, part in enumerate(surface.parts):
        at, triangles = lattice(part.sides, surface.steps), lattice_facets(part.sides, surface.steps)
        count = len(part.faces)
        points.append(part.points.reshape(-1, 3))
        every = (part.normals, part.gauss[..., None], part.mean[..., None], part.distance[..., None])
        values.append(np.concatenate(every, axis=-1).reshape(-1, 6))
        corners.append((first + len(at) * np.arange(count)[:, None, None] + triangles).reshape(-1, 3))
        places.append(np.tile(at[triangles], (count, 1, 1)))
        parts.append(np.full(count * len(triangles), index))
        patches.append(np.repeat(np.arange(count), len(triangles)))
        first += count * len(at)
    facets = Facets(
        np.concatenate(points),
        np.concatenate(corners),
        np.concatenate(parts),
        np.concatenate(patches),
        np.concatenate(places),
    )
    return facets, np.concatenate(values)


def _address(image: Float) -> str:
    """Image (H, W, 3) from 0 to 1 as a PNG file of few colours in an address."""
    from PIL import Image

    whole = Image.fromarray(np.rint(image * 255.0).astype(np.uint8))
    stream = io.BytesIO()
    whole.quantize(COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(stream, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode("ascii")
