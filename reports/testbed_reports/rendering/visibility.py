"""What shows in a picture: a z-buffer over facets, and the places on patches that its pixels look at.

A pixel has 2 x 2 samples. Where all four see one patch the patch is looked at once, in the middle; along silhouettes
and between patches each sample counts by itself, so that edges come out smooth.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from testbed.geometry.vectors import Float, Int
from testbed_reports.rendering.camera import Camera
from testbed_reports.rendering.facets import Facets

#: Samples a pixel along each direction.
GRID = 2
#: Samples handled at once, and rows of pixels.
CHUNK = 1 << 19
STRIP = 64
#: Samples along a side of the squares that tell which facets are hidden.
TILE = 32
#: How far beside a facet, in samples, a sample belongs to it still.
SLACK = 1e-9
#: Depths are whole numbers up to this.
DEPTHS = (1 << 31) - 1
_NOTHING = np.iinfo(np.int64).max


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

    def some(self, chosen: slice) -> "Sights":
        """Return some of the places."""
        pixel, share, at = self.pixel[chosen], self.share[chosen], self.at[chosen]
        return Sights(self.size, pixel, share, self.part[chosen], self.patch[chosen], at)


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


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of the corners of what samples see; ``weights[row, column]`` are (..., 3), NaN for nothing.

    Parameters
    ----------
    facet
        (GRID size, GRID size) the facet that each sample sees; -1 for none.
    corners
        (T, 3, 2) corners of all facets, in samples.
    """

    facet: Int
    corners: Float

    def __getitem__(self, at: tuple[Int, Int]) -> Float:
        row, column = at
        facet = self.facet[row, column]
        found = self.of(facet, column + 0.5, row + 0.5)
        return np.where((facet >= 0)[..., None], found, np.nan)

    def of(self, facet: Int, x: npt.NDArray[np.floating], y: npt.NDArray[np.floating]) -> Float:
        """Return the weights (..., 3) of corners at places in samples, or within facets, where they are beside them."""
        p, q, r = (self.corners[facet, i] for i in range(3))
        e1, e2 = q - p, r - p
        area = e1[..., 0] * e2[..., 1] - e1[..., 1] * e2[..., 0]
        x, y = x - p[..., 0], y - p[..., 1]
        found = np.empty((*facet.shape, 3))
        # facets without an area are not seen
        with np.errstate(invalid="ignore", divide="ignore"):
            found[..., 1] = (x * e2[..., 1] - y * e2[..., 0]) / area
            found[..., 2] = (e1[..., 0] * y - e1[..., 1] * x) / area
            found[..., 0] = 1.0 - found[..., 1] - found[..., 2]
            np.maximum(found, 0.0, out=found)
            found /= (found[..., 0] + found[..., 1] + found[..., 2])[..., None]
        return found


def rasterise(facets: Facets, camera: Camera, size: int) -> tuple[Buffer, Weights]:
    """Return the z-buffer, and the weights of the corners of what its samples see."""
    samples = GRID * size
    corners = camera.screen(facets.points, samples)[facets.corners]
    spans = _Spans.of(corners, samples)
    keys = np.full(samples * samples, _NOTHING)
    depths = corners[..., 2][np.isfinite(corners).all(axis=(1, 2))]
    nearest, range_ = (float(depths.max()), max(float(np.ptp(depths)), 1e-300)) if len(depths) else (0.0, 1.0)

    def level(depth: Float) -> Int:
        return np.clip((nearest - depth) * (DEPTHS / range_), 0, DEPTHS).astype(np.int64)

    # facets that face the viewer first: most of the others are behind them, and need not be looked at sample by sample
    (front,) = np.nonzero(spans.area < 0.0)
    _fill(keys, front, spans, level, samples)
    (back,) = np.nonzero(spans.area > 0.0)
    behind = level(corners[back, :, 2].max(axis=1)) > _farthest(keys, spans, back, samples)
    _fill(keys, back[~behind], spans, level, samples)
    seen = (keys != _NOTHING).reshape(samples, samples)
    facet = np.where(seen, (keys & 0xFFFFFFFF).reshape(samples, samples), -1)
    depth = nearest - (keys >> 32).astype(np.float64).reshape(samples, samples) * (range_ / DEPTHS)
    return Buffer(facet, np.where(seen, depth / GRID, -np.inf)), Weights(facet, corners[..., :2])


@dataclass(frozen=True, eq=False)
class _Spans:
    """Facets (T,) on a raster: a half plane for each side, the rows and columns they reach, and their depth.

    Parameters
    ----------
    area
        Twice the signed area; 0 for facets that are not to be drawn.
    slope, offset
        (T, 3, 2), (T, 3): the weights of corners at a sample (x, y) are slope . (x, y) + offset.
    rise, base
        (T, 2), (T,): the depth there is rise . (x, y) + base.
    low, high
        (T, 2) first and last column and row of samples.
    """

    area: Float
    slope: Float
    offset: Float
    rise: Float
    base: Float
    low: Int
    high: Int

    @classmethod
    def of(cls, corners: Float, samples: int) -> Self:
        """Prepare facets with corners (T, 3, 3)."""
        place = corners[..., :2]
        e1, e2 = place[:, 1] - place[:, 0], place[:, 2] - place[:, 0]
        area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
        low = np.ceil(place.min(axis=1) - 0.5).clip(0, samples)
        high = np.floor(place.max(axis=1) - 0.5).clip(-1, samples - 1)
        drawn = np.isfinite(corners).all(axis=(1, 2)) & (low <= high).all(axis=1)
        area = np.where(drawn, area, 0.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            second = np.stack([e2[:, 1], -e2[:, 0]], axis=-1) / area[:, None]
            third = np.stack([-e1[:, 1], e1[:, 0]], axis=-1) / area[:, None]
            slope = np.stack([-second - third, second, third], axis=1)
            offset = -(slope * place[:, :1]).sum(axis=-1) + np.array([1.0, 0.0, 0.0])
            rise = (slope * corners[..., 2:]).sum(axis=1)
            base = (offset * corners[..., 2]).sum(axis=1)
        whole = np.where(drawn[:, None], low, 1).astype(np.int64), np.where(drawn[:, None], high, 0).astype(np.int64)
        return cls(area, slope, offset, rise, base, *whole)


def _fill(keys: Int, chosen: Int, spans: _Spans, level: Callable[[Float], Int], samples: int) -> None:
    """Enter facets into the z-buffer ``keys``: depth in the upper half of a key, the facet in the lower."""
    if not len(chosen):
        return
    tall = spans.high[chosen, 1] - spans.low[chosen, 1] + 1
    box = np.cumsum(tall * (spans.high[chosen, 0] - spans.low[chosen, 0] + 1))
    for some in np.split(np.arange(len(chosen)), np.searchsorted(box, np.arange(CHUNK, box[-1], CHUNK))):
        # a row of samples of a facet at a time: where it begins and ends follows from the half planes
        facet = np.repeat(chosen[some], tall[some])
        row = spans.low[facet, 1] + _counting(tall[some])
        slope, y = spans.slope[facet], row + 0.5
        begins, ends = np.full(len(facet), -1.0), np.full(len(facet), samples + 1.0)
        for corner in range(3):
            along, rest = slope[:, corner, 0], slope[:, corner, 1] * y + spans.offset[facet, corner]
            with np.errstate(invalid="ignore", divide="ignore"):
                cut = -rest / along
            begins = np.where(along > 0.0, np.maximum(begins, cut), begins)
            ends = np.where(along < 0.0, np.minimum(ends, cut), ends)
            ends = np.where((along == 0.0) & (rest < 0.0), -2.0, ends)
        # samples on a side that two facets share belong to both, whatever rounding does
        first = np.maximum(np.ceil(np.minimum(begins, samples) - 0.5 - SLACK).astype(np.int64), spans.low[facet, 0])
        last = np.minimum(np.floor(np.maximum(ends, -2.0) - 0.5 + SLACK).astype(np.int64), spans.high[facet, 0])
        count = (last - first + 1).clip(0)
        column = np.repeat(first, count) + _counting(count)
        depth = np.repeat(spans.rise[facet, 1] * y + spans.base[facet], count)
        depth += np.repeat(spans.rise[facet, 0], count) * (column + 0.5)
        key = (level(depth) << 32) | np.repeat(facet, count)
        np.minimum.at(keys, np.repeat(row * samples, count) + column, key)


def _counting(count: Int) -> Int:
    """0, 1, ... up to each count, one after the other."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)


def _farthest(keys: Int, spans: _Spans, chosen: Int, samples: int) -> Int:
    """The farthest depth (N,) that is seen about each of some facets; the greatest possible where nothing is seen."""
    tiles = -(-samples // TILE)
    padded = np.full((tiles * TILE, tiles * TILE), _NOTHING)
    padded[:samples, :samples] = keys.reshape(samples, samples)
    most = padded.reshape(tiles, TILE, tiles, TILE).max(axis=(1, 3)) >> 32
    low, high = spans.low[chosen] // TILE, spans.high[chosen] // TILE
    found = np.full(len(chosen), _NOTHING)
    small = (high - low <= 1).all(axis=1)
    ends = [
        most[rows[small], columns[small]] for columns in (low[:, 0], high[:, 0]) for rows in (low[:, 1], high[:, 1])
    ]
    found[small] = np.maximum.reduce(ends)
    return found


def sights(facets: Facets, buffer: Buffer, weights: Weights, *, every_sample: bool = False) -> Sights:
    """Return what the pixels look at.

    Parameters
    ----------
    every_sample
        Look at every sample by itself, for colourings that vary within a pixel.
    """
    size = len(buffer.facet) // GRID
    # some rows of pixels at a time: what is looked up for each sample takes room
    strips = [
        _strip(facets, buffer.facet, weights, first, every_sample=every_sample) for first in range(0, size, STRIP)
    ]
    pixel, share, part, patch, at = (np.concatenate([found[i] for found in strips]) for i in range(5))
    return Sights(size, pixel, share, part, patch, at)


def _strip(
    facets: Facets, buffer: Int, weights: Weights, first: int, *, every_sample: bool
) -> tuple[Int, Float, Int, Int, Float]:
    """Pixel, share, part, patch and parameters of what pixels look at in rows from the first on."""
    size = len(buffer) // GRID
    facet = _by_pixel(buffer[GRID * first : GRID * (first + STRIP)])
    seen = facet >= 0
    whole = np.logical_and(np.all(seen, axis=1), not every_sample)
    same = np.all(facet == facet[:, :1], axis=1)
    # most pixels see one facet: what is left is looked at more closely
    (several,) = np.nonzero(whole & ~same)
    part, patch = facets.part[facet[several]], facets.patch[facet[several]]
    whole[several] = ((part == part[:, :1]) & (patch == patch[:, :1])).all(axis=1)
    (middle,), (mixed,) = np.nonzero(whole & same), np.nonzero(whole & ~same)
    single, sample = np.nonzero(seen & ~whole[:, None])
    row, column = np.divmod(np.arange(len(facet)) + first * size, size)
    inner = facet[middle, 0]
    centre = weights.of(inner, GRID * column[middle] + 0.5 * GRID, GRID * row[middle] + 0.5 * GRID)
    at = [_placed(facets, inner, centre)]
    # the mean of what the samples look at, on one patch
    number = np.arange(GRID * GRID)
    for pixels, which in ((mixed[:, None], number), (single, sample)):
        x, y = GRID * column[pixels] + which % GRID + 0.5, GRID * row[pixels] + which // GRID + 0.5
        places = _placed(facets, facet[pixels, which], weights.of(facet[pixels, which], x, y))
        at.append(places.mean(axis=1) if places.ndim == 3 else places)
    pixel = np.concatenate([middle, mixed, single])
    shown = np.concatenate([inner, facet[mixed, 0], facet[single, sample]])
    share = np.ones(len(pixel))
    share[len(middle) + len(mixed) :] = 1.0 / (GRID * GRID)
    return pixel + first * size, share, facets.part[shown], facets.patch[shown], np.concatenate(at)


def _placed(facets: Facets, facet: Int, weights: Float) -> Float:
    """Parameters (..., 2) at weights (..., 3) of the corners of facets (...)."""
    corners = facets.at[facet]
    placed: Float = corners[..., 0, :] * weights[..., :1]
    for corner in (1, 2):
        placed += corners[..., corner, :] * weights[..., corner, None]
    return placed


def _by_pixel(samples: Int) -> Int:
    """Values (GRID H, GRID W) of samples as (H W, GRID GRID) of pixels."""
    tall, wide = samples.shape[0] // GRID, samples.shape[1] // GRID
    return np.moveaxis(samples.reshape(tall, GRID, wide, GRID), 2, 1).reshape(tall * wide, GRID * GRID)
