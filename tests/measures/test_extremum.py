"""Maxima over a surface where the samples mislead: of several peaks in a patch, the highest is found."""

import numpy as np
import pytest
from built_surfaces import octahedron

from testbed.geometry.domain import lattice
from testbed.geometry.vectors import Float, Int
from testbed.measures.extremum import Extremum, maxima

SURFACE = octahedron()
SAMPLES = lattice(3, 12)
LOW, HIGH = np.array([0.25, 0.25]), np.array([0.5417, 0.2083])  # a sample, and the middle between samples


def peaks(at: Float) -> Float:
    """A peak of height 1 at a sample and one of height 1.01 between samples, which all lie below 1."""
    low = np.exp(-40.0 * ((at - LOW) ** 2).sum(axis=-1))
    high = 1.01 * np.exp(-40.0 * ((at - HIGH) ** 2).sum(axis=-1))
    higher: Float = np.maximum(low, high)
    return higher


def found(candidates: int, faces: slice = slice(None)) -> Extremum:
    """The maximum where only some faces have the higher peak."""
    higher = np.zeros(8, dtype=np.bool_)
    higher[faces] = True

    def values(part: int, patches: Int, at: Float) -> Float:
        del part
        low = np.exp(-40.0 * ((at - LOW) ** 2).sum(axis=-1))
        return np.where(higher[patches][:, None], peaks(at), low)[None]

    at = np.broadcast_to(SAMPLES, (8, *SAMPLES.shape))
    (extremum,) = maxima(SURFACE, [values(0, np.arange(8), at)], [SAMPLES], values, [0.0], candidates)
    return extremum


def test_the_highest_sample_is_at_the_lower_peak() -> None:
    best = SAMPLES[peaks(SAMPLES).argmax()]
    np.testing.assert_array_equal(best, LOW)


@pytest.mark.parametrize("face", [0, 5, 7])
def test_the_higher_peak_is_found_in_the_patch_that_has_it(face: int) -> None:
    extremum = found(256, slice(face, face + 1))
    assert extremum.value == pytest.approx(1.01, rel=1e-12)
    assert extremum.face == face
    np.testing.assert_allclose(extremum.place, HIGH, atol=1e-6)


def test_of_equal_peaks_the_first_faces_counts() -> None:
    assert found(256).face == 0


def test_with_more_patches_than_candidates_each_patch_has_one_start() -> None:
    assert found(7, slice(0, 0)).value == pytest.approx(1.0, rel=1e-12)


def test_the_first_nan_is_the_maximum() -> None:
    values = np.broadcast_to(peaks(SAMPLES), (1, 8, len(SAMPLES))).copy()
    values[0, 5, 7] = values[0, 3, 11] = values[0, 3, 9] = np.nan
    (extremum,) = maxima(SURFACE, [values], [SAMPLES], lambda *_: np.zeros((1, 1, 1)), [0.0], 256)
    assert np.isnan(extremum.value)
    assert extremum.face == 3
    np.testing.assert_array_equal(extremum.place, SAMPLES[9])
