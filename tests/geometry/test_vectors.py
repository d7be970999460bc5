"""Lengths and angles by sums of squares against those by hypot, over the whole range of floats."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, angle_between, norm


def hypot(vectors: Float) -> Float:
    """The length that keeps the whole range of floats, at ten times the cost."""
    return np.hypot.reduce(vectors, axis=-1)


@given(seed=st.integers(0, 2**32 - 1), exponent=st.integers(-300, 300))
def test_lengths_are_those_of_hypot_at_every_scale(seed: int, exponent: int) -> None:
    vectors = np.random.default_rng(seed).normal(size=(5, 4, 3)) * 10.0**exponent
    vectors[0, 0] = 0.0
    vectors[1, :, 2] *= 1e-200
    np.testing.assert_allclose(norm(vectors), hypot(vectors), rtol=1e-15)


def test_lengths_have_the_same_bits_in_any_company() -> None:
    vectors = np.random.default_rng(0).normal(size=(50, 3)) * 10.0 ** np.arange(-250, 250, 10)[:, None]
    alone = np.concatenate([norm(vectors[k : k + 1]) for k in range(50)])
    np.testing.assert_array_equal(norm(vectors), alone)
    np.testing.assert_array_equal(norm(np.ascontiguousarray(vectors.T).T), alone)


def test_what_is_not_finite_has_no_finite_norm() -> None:
    vectors = np.array([[np.nan, 1.0, 2.0], [np.inf, 1.0, 2.0], [3.0, 4.0, 0.0]])
    np.testing.assert_array_equal(norm(vectors), [np.nan, np.inf, 5.0])
    assert norm(np.empty((0, 3))).shape == (0,)


@pytest.mark.parametrize("size", [0.0, 1e-160, 1e-12, 1e-3, 1.0, 3.0])
def test_angles_keep_all_digits(size: float) -> None:
    a = np.array([[1.0, 0.0, 0.0]])
    b = np.array([[np.cos(size), np.sin(size), 0.0]])
    np.testing.assert_allclose(angle_between(a, b), size, rtol=1e-15)


def test_a_single_vector_has_a_length() -> None:
    assert float(norm(np.array([3.0, 4.0, 12.0]))) == 13.0
    assert float(norm(np.array([3e-200, 4e-200, 0.0]))) == pytest.approx(5e-200, rel=1e-15)


def test_normals_are_undefined_at_singular_points() -> None:
    assert np.isnan(Jet(np.ones((3, 1, 1, 3))).normal).all()
