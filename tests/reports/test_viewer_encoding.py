"""Packed surfaces hold what was sampled, to the digits that they promise, in the same bytes every time."""

import base64
import gzip
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from testbed import registry
from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float, angle_between, unit
from testbed_reports.viewer.encoding import (
    ABSENT,
    LARGEST,
    Code,
    folded,
    lattice_differences,
    packed,
    rounded,
    row_differences,
    to_bytes,
)
from testbed_reports.viewer.samples import SampledSurface, sampled

UNITS = {"gauss": 0.25, "mean": 0.25, "distance": 1e-3, "jump": 1e-3}
CODES = st.integers(0, 0xFFFF)


def words(data: bytes) -> Code:
    """Undo ``to_bytes``."""
    low, high = np.frombuffer(data, np.uint8).astype(np.int64).reshape(2, -1)
    small = low + 256 * high
    return np.where(small % 2 == 1, -(small + 1) // 2, small // 2)


def summed(differences: Code, sides: int, steps: int) -> Code:
    """Undo ``lattice_differences``, number by number as a browser does."""
    number = {tuple(place): k for k, place in enumerate(np.rint(lattice(sides, steps) * steps).astype(int).tolist())}
    codes = np.zeros_like(differences)
    corner = 0
    for row, own in zip(differences, codes, strict=True):
        for (i, j), k in number.items():
            if i and j:
                guess = own[number[i - 1, j]] + own[number[i, j - 1]] - own[number[i - 1, j - 1]]
            elif i > 1:
                guess = 2 * own[number[i - 1, 0]] - own[number[i - 2, 0]]
            elif j > 1:
                guess = 2 * own[number[0, j - 1]] - own[number[0, j - 2]]
            else:
                guess = own[0] if i or j else corner
            own[k] = (guess + row[k]) % 0x10000
        corner = own[0]
    return codes


@given(arrays(np.float64, 20, elements=st.floats(-1e3, 1e3)), st.floats(0.1, 100.0))
def test_values_come_back_within_half_a_step_and_what_is_unknown_stays_unknown(values: Float, span: float) -> None:
    low, high = float(values.min()), float(values.min()) + span
    codes = rounded(np.append(values, [np.nan, np.inf]), low, high)
    np.testing.assert_array_equal(codes[-2:], ABSENT)
    back = low + codes[:-2] / LARGEST * (high - low)
    assert np.abs(back - values.clip(low, high)).max() <= 0.51 * span / LARGEST


@given(arrays(np.float64, (30, 3), elements=st.floats(-1.0, 1.0)))
def test_folded_normals_unfold_within_a_two_hundredth_of_a_degree(vectors: Float) -> None:
    normals = unit(vectors[np.abs(vectors).max(axis=-1) > 1e-3])
    x, y = np.moveaxis(2.0 * folded(normals) / LARGEST - 1.0, -1, 0)
    z = 1.0 - np.abs(x) - np.abs(y)
    below = z < 0.0
    back = np.stack(
        [
            np.where(below, (1.0 - np.abs(y)) * np.where(x < 0.0, -1.0, 1.0), x),
            np.where(below, (1.0 - np.abs(x)) * np.where(y < 0.0, -1.0, 1.0), y),
            z,
        ],
        axis=-1,
    )
    assert np.degrees(angle_between(back, normals)).max(initial=0.0) < 0.005


@pytest.mark.parametrize("sides", [3, 4])
@given(data=st.data(), steps=st.integers(1, 5), patches=st.integers(1, 4))
@settings(max_examples=20, deadline=None)
def test_differences_on_lattices_lose_nothing(sides: int, data: st.DataObject, steps: int, patches: int) -> None:
    codes = data.draw(arrays(np.int64, (patches, len(lattice(sides, steps))), elements=CODES))
    back = words(to_bytes([lattice_differences(codes, sides, steps)])).reshape(codes.shape)
    np.testing.assert_array_equal(summed(back, sides, steps), codes)


@given(arrays(np.int64, st.integers(0, 40), elements=CODES))
def test_differences_of_rows_lose_nothing(codes: Code) -> None:
    np.testing.assert_array_equal(np.cumsum(words(to_bytes([row_differences(codes)]))) % 0x10000, codes)


@pytest.mark.parametrize("sides", [3, 4])
def test_on_a_parallelogram_only_the_first_corner_and_its_neighbours_differ(sides: int) -> None:
    i, j = np.rint(lattice(sides, 6) * 6).astype(np.int64).T
    differences = lattice_differences((1000 + 7 * i + 11 * j)[None], sides, 6)
    assert np.count_nonzero(differences) == 3


def surface(scheme: str, dataset: str, steps: int) -> SampledSurface:
    data = registry.dataset(dataset)
    return sampled(registry.scheme(scheme).fit(data.mesh(0)), steps, data.surface)


@pytest.mark.parametrize(
    ("scheme", "dataset"), [("nielson", "torus"), ("shirman-sequin", "graph"), ("bicubic-interpolant", "quad-torus")]
)
def test_a_packed_surface_holds_its_samples(scheme: str, dataset: str) -> None:
    mine = surface(scheme, dataset, 5)
    pack = packed(mine, UNITS)
    numbers = words(gzip.decompress(base64.b64decode(pack.text)))
    (part,) = mine.parts
    count, taken = part.points[..., 0].size, 0
    low, high = (np.array(corner) for corner in pack.about["box"])

    def codes() -> Code:
        nonlocal taken
        taken += count
        return summed(numbers[taken - count : taken].reshape(part.gauss.shape), part.sides, mine.steps)

    for axis in range(3):
        back = low[axis] + codes() / LARGEST * (high - low)[axis]
        np.testing.assert_allclose(back, part.points[..., axis], rtol=0, atol=0.51 * (high - low).max() / LARGEST)
    taken += 2 * count
    for name in ("gauss", "mean", "distance"):
        first, last, unit_ = pack.about["ranges"][name]
        back = unit_ * np.sinh(first + codes() / LARGEST * (last - first))
        known = np.isfinite(getattr(part, name))
        assert known.any()
        np.testing.assert_allclose(back[known], getattr(part, name)[known], rtol=2e-3, atol=2e-4 * unit_)
    assert pack.about["parts"][0][:2] == [part.sides, len(part.faces)]
    edges = pack.about["edges"]
    assert edges == len(mine.edge_patch) == len(mine.edge_angle)


def test_the_same_surface_gives_the_same_text_without_a_time_in_it() -> None:
    text = packed(surface("shirman-sequin", "octahedron", 4), UNITS).text
    assert text == packed(surface("shirman-sequin", "octahedron", 4), UNITS).text
    assert base64.b64decode(text)[4:8] == b"\0\0\0\0"


def test_rounding_of_a_plane_is_not_stored() -> None:
    pack = packed(surface("flat", "plane", 6), {**UNITS, "gauss": 1e-9})
    first, last, _ = pack.about["ranges"]["gauss"]
    assert last - first >= 1e-3
    assert len(pack.text) < 4.0 * math.prod((24, 28))
