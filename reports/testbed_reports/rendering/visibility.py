"""What shows in a picture: a z-buffer over facets, and the places on patches that its pixels look at.

A pixel has 2 x 2 samples. Where all four see one patch the patch is looked at once, in the middle; along silhouettes
and between patches each sample counts by itself, so that edges come out smooth.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Bool, Float, Int
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.facets import Facets

#: Samples a pixel along each direction.
GRID = 2
#: Candidate samples handled at once.
CHUNK = 1 << 20
#: Depths are whole numbers up to this.
DEPTHS = (1 << 31) - 1
_NOTHING = np.iinfo(np.uint64).max


@dataclass(frozen=True, eq=False)
class Sights:
    """Places on patches that pixels look at.

    Parameters
    ----------
    size
        Pixels along a side of the picture.
    pixel
        (N,) number of the pixel, row by row from the top.
    share
        (N,) share of the pixel that each stands for.
    part, patch
        (N,) which patch.
    at
        (N, 2) parameters.
    """

    size: int
    pixel: Int
    share: Float
    part: Int
    patch: Int
    at: Float

    def __len__(self) -> int:
        return len(self.pixel)


@dataclass(frozen=True, eq=False)
class Buffer:
    """The z-buffer of a picture.

    Parameters
    ----------
    facet
        (GRID size, GRID size) the facet that each sample sees; -1 for none.
    depth
        Depth towards the viewer, in pixels, of those samples; -inf for none.
    """

    facet: Int
    depth: Float


def rasterise(facets: Facets, camera: Camera, size: int) -> tuple[Buffer, Float]:
    """Return the z-buffer, and the weights (S, S, 3) of the corners of what its samples see, NaN for nothing."""
    samples = GRID * size
    screen = camera.screen(facets.points, samples)
    corners = screen[facets.corners]
    # weights of corners 1 and 2 are affine in the sample's place
    p, e1, e2 = corners[:, 0, :2], corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]
    area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    low = np.ceil(corners[..., :2].min(axis=1) - 0.5).clip(0, samples)
    high = np.floor(corners[..., :2].max(axis=1) - 0.5).clip(-1, samples - 1)
    extent = np.where(np.isfinite(low) & np.isfinite(high), high - low + 1, 0).clip(0).astype(np.int64)
    count = np.where(np.abs(area) > 0.0, extent[:, 0] * extent[:, 1], 0)
    finite = screen[np.isfinite(screen[:, 2]), 2]
    nearest, range_ = (finite.max(), max(float(np.ptp(finite)), 1e-300)) if len(finite) else (0.0, 1.0)
    keys = np.full(samples * samples, _NOTHING)
    (some,) = np.nonzero(count)
    ends = np.cumsum(count[some])
    for chunk in np.split(some, np.searchsorted(ends, np.arange(CHUNK, ends[-1] if len(ends) else 0, CHUNK))):
        facet = np.repeat(chunk, count[chunk])
        run = np.arange(len(facet)) - np.repeat(np.cumsum(count[chunk]) - count[chunk], count[chunk])
        column = low[facet, 0].astype(np.int64) + run % extent[facet, 0]
        row = low[facet, 1].astype(np.int64) + run // extent[facet, 0]
        weights = _weights(p[facet], e1[facet], e2[facet], area[facet], column, row)
        hit = (weights >= 0.0).all(axis=-1)
        facet, weights = facet[hit], weights[hit]
        depth = (corners[facet, :, 2] * weights).sum(axis=-1)
        whole = np.clip((nearest - depth) / range_ * DEPTHS, 0, DEPTHS).astype(np.uint64)
        np.minimum.at(keys, (row * samples + column)[hit], (whole << np.uint64(32)) | facet.astype(np.uint64))
    seen = keys != _NOTHING
    facet = np.where(seen, keys & np.uint64(0xFFFFFFFF), 0).astype(np.int64)
    row, column = np.divmod(np.arange(samples * samples), samples)
    weights = np.full((samples * samples, 3), np.nan)
    depth = np.full(samples * samples, -np.inf)
    which = facet[seen]
    weights[seen] = _weights(p[which], e1[which], e2[which], area[which], column[seen], row[seen])
    depth[seen] = (corners[which, :, 2] * weights[seen]).sum(axis=-1) / GRID
    shape = (samples, samples)
    return Buffer(np.where(seen, facet, -1).reshape(shape), depth.reshape(shape)), weights.reshape(*shape, 3)


def _weights(p: Float, e1: Float, e2: Float, area: Float, column: Int, row: Int) -> Float:
    """Weights (N, 3) of the corners of triangles at the middles of samples."""
    x, y = column + 0.5 - p[:, 0], row + 0.5 - p[:, 1]
    second = (x * e2[:, 1] - y * e2[:, 0]) / area
    third = (e1[:, 0] * y - e1[:, 1] * x) / area
    return np.stack([1.0 - second - third, second, third], axis=-1)


def sights(facets: Facets, buffer: Buffer, weights: Float, *, every_sample: bool = False) -> Sights:
    """Return what the pixels look at.

    Parameters
    ----------
    every_sample
        Look at every sample by itself, for colourings that vary within a pixel.
    """
    size = len(buffer.facet) // GRID
    facet = _by_pixel(buffer.facet)
    places = _by_pixel(weights)
    seen = facet >= 0
    at = (facets.at[facet] * places[..., None]).sum(axis=-2)
    part, patch = facets.part[facet], facets.patch[facet]
    same = (part == part[:, :1]) & (patch == patch[:, :1])
    whole: Bool = (seen & same).all(axis=1) & (not every_sample)
    pixel, sample = np.nonzero(seen & ~whole[:, None])
    (middle,) = np.nonzero(whole)
    samples = facet.shape[1]
    return Sights(
        size,
        np.concatenate([middle, pixel]),
        np.concatenate([np.ones(len(middle)), np.full(len(pixel), 1.0 / samples)]),
        np.concatenate([part[middle, 0], part[pixel, sample]]),
        np.concatenate([patch[middle, 0], patch[pixel, sample]]),
        np.concatenate([at[middle].mean(axis=1), at[pixel, sample]]),
    )


def _by_pixel(samples: Float | Int) -> Float | Int:
    """Values (GRID S, GRID S, ...) of samples as (S S, GRID GRID, ...) of pixels."""
    size = len(samples) // GRID
    split = samples.reshape(size, GRID, size, GRID, *samples.shape[2:])
    return np.moveaxis(split, 2, 1).reshape(size * size, GRID * GRID, *samples.shape[2:])
