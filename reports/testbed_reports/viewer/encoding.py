"""Sampled surfaces as text in a page: whole numbers of 16 bits, predicted from their neighbours, deflated, base 64.

Every quantity is rounded to whole numbers from 0 to ``LARGEST`` between its least and its largest value; ``ABSENT``
stands for no value. Curvatures, distances and angles vary over powers of ten: their inverse hyperbolic sine is rounded,
which keeps about as many digits of large values as of those near a given unit. Normals are folded onto an octahedron.

A number of the lattice is stored as the difference from what its neighbours before it predict, the parallelogram's
fourth corner, modulo 2^16: with signs folded into the lowest bit (0, -1, 1, -2, ...), low bytes first, then high bytes.
``decode.js`` undoes all of this.
"""

import base64
import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from testbed.geometry.vectors import Float, Int
from testbed_reports.viewer.samples import SampledSurface

LARGEST: Final = 65_534
ABSENT: Final = 65_535
#: Whole numbers are not closer together than this, in units and in shares of a surface's size: rounding is not stored.
FINEST: Final = 1e-7

Code: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True)
class Packed:
    """A surface as text.

    Parameters
    ----------
    text
        The numbers, base 64.
    about
        What is needed to read them, as JSON: ``steps``; ``parts`` with sides, patches and different places in faces;
        ``edges``, their number; ``box``, least and largest coordinates; ``ranges``, for each field that has values the
        least and largest of asinh(value / unit) and the unit.
    """

    text: str
    about: Mapping[str, Any]


def rounded(values: Float, low: float, high: float) -> Code:
    """Whole numbers from 0 at ``low`` to ``LARGEST`` at ``high``; ``ABSENT`` for NaN and infinities."""
    known = np.isfinite(values)
    share = np.where(known, values - low, 0.0) / (high - low if high > low else 1.0)
    return np.where(known, np.rint(share.clip(0.0, 1.0) * LARGEST), ABSENT).astype(np.int64)


def folded(normals: Float) -> Code:
    """Unit vectors (..., 3) as places (..., 2) on an unfolded octahedron, from 0 to ``LARGEST`` in both directions."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y, z = np.moveaxis(normals / np.abs(normals).sum(axis=-1, keepdims=True), -1, 0)
    sign_x, sign_y = np.where(x < 0.0, -1.0, 1.0), np.where(y < 0.0, -1.0, 1.0)
    lower = z < 0.0
    across = np.where(lower, (1.0 - np.abs(y)) * sign_x, x)
    along = np.where(lower, (1.0 - np.abs(x)) * sign_y, y)
    return rounded(np.stack([across, along], axis=-1), -1.0, 1.0)


def lattice_differences(codes: Code, sides: int, steps: int) -> Code:
    """Differences (P, S) of codes (P, S) on lattices from what the points before them predict."""
    number = {place: index for index, place in enumerate(_places(sides, steps))}
    differences = np.empty_like(codes)

    def at(i: int, j: int) -> Code:
        column: Code = codes[:, number[i, j]]
        return column

    for (i, j), index in number.items():
        if i and j:
            predicted = at(i - 1, j) + at(i, j - 1) - at(i - 1, j - 1)
        elif max(i, j) > 1:
            predicted = 2 * at(max(i - 1, 0), max(j - 1, 0)) - at(max(i - 2, 0), max(j - 2, 0))
        elif max(i, j) == 1:
            predicted = at(0, 0)
        else:  # the first corner: that of the patch before
            predicted = np.concatenate([[0], codes[:-1, 0]])
        differences[:, index] = codes[:, index] - predicted
    return differences


def _places(sides: int, steps: int) -> list[tuple[int, int]]:
    """Whole coordinates of the points of ``domain.lattice(sides, steps)``."""
    return [(i, j) for i in range(steps + 1) for j in range(steps + 1 - (i if sides == 3 else 0))]


def row_differences(codes: Code) -> Code:
    """Differences of codes from those before them."""
    flat = codes.ravel()
    return np.diff(flat, prepend=np.zeros(1, dtype=np.int64))


def to_bytes(differences: Sequence[Code]) -> bytes:
    """Differences modulo 2^16, small ones as small numbers: all low bytes, then all high bytes."""
    words = np.concatenate([np.empty(0, dtype=np.int64), *(some.ravel() for some in differences)])
    signed = (words + 0x8000) % 0x10000 - 0x8000
    small = np.where(signed < 0, -2 * signed - 1, 2 * signed)
    return (small & 0xFF).astype(np.uint8).tobytes() + (small >> 8).astype(np.uint8).tobytes()


def packed(surface: SampledSurface, units: Mapping[str, float]) -> Packed:
    """Pack a sampled surface.

    Parameters
    ----------
    surface
        The samples.
    units
        For ``gauss``, ``mean``, ``distance`` and ``jump`` the value near which digits matter, above zero.
    """
    points = surface.points
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.zeros(3))
    high = np.maximum(high, low + FINEST * float((high - low).max()) * LARGEST)
    ranges = {name: found for name, unit in units.items() if (found := _range(surface.values(name), unit)) is not None}
    pieces: list[Code] = []
    parts = []
    for part in surface.parts:
        codes = [rounded(part.points[..., axis], low[axis], high[axis]) for axis in range(3)]
        normals = folded(part.normals)
        codes += [normals[..., 0], normals[..., 1]]
        codes += [_coded(getattr(part, name), ranges[name]) for name in ("gauss", "mean", "distance") if name in ranges]
        pieces += [lattice_differences(code, part.sides, surface.steps) for code in codes]
        rows, which = np.unique(part.corners.reshape(len(part.corners), -1), axis=0, return_inverse=True)
        pieces += [*map(row_differences, _split(part.faces)), *map(row_differences, _split(which.ravel()))]
        pieces.append(row_differences(rounded(rows.T, 0.0, 1.0)))
        parts.append([part.sides, len(part.faces), len(rows)])
    pieces += [*map(row_differences, _split(surface.edge_patch)), row_differences(surface.edge_side)]
    if "jump" in ranges:
        pieces.append(row_differences(_coded(surface.edge_angle, ranges["jump"])))
    squeezed = gzip.compress(to_bytes(pieces), compresslevel=9, mtime=0)
    about = {
        "steps": surface.steps,
        "parts": parts,
        "edges": len(surface.edge_patch),
        "box": [low.tolist(), high.tolist()],
        "ranges": ranges,
    }
    return Packed(base64.b64encode(squeezed).decode("ascii"), about)


def _split(numbers: Int) -> tuple[Int, Int]:
    """Low and high 16 bits of whole numbers."""
    return numbers & 0xFFFF, numbers >> 16


def _range(values: Float, unit: float) -> list[float] | None:
    """Least and largest asinh(value / unit), and the unit; None without a value."""
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    low, high = float(np.arcsinh(known.min() / unit)), float(np.arcsinh(known.max() / unit))
    return [low, max(high, low + FINEST * LARGEST), unit]


def _coded(values: Float, span: Sequence[float]) -> Code:
    low, high, unit = span
    return rounded(np.arcsinh(values / unit), low, high)
