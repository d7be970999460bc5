"""The side-vertex blend: which piece counts where, in either form, for arrays and for Taylors."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.conformance.meshes import torus
from testbed.geometry.bernstein import curve_tables
from testbed.geometry.domain import lattice
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float
from testbed.plugins.scheme import Scheme
from testbed_schemes.hagen_pottmann import HagenPottmann
from testbed_schemes.mathematics.side_vertex import hermite_weights, separable_blend, side_vertex_blend
from testbed_schemes.nielson import Nielson
from testbed_schemes.nielson_conic import NielsonConic

seeds = st.integers(0, 2**32 - 1)


def barycentrics(rng: np.random.Generator) -> Float:
    b: Float = rng.dirichlet(np.ones(3), 8).T
    return b


def variables(at: Float) -> tuple[Any, Any]:
    return Taylor.variables(at, 2)


@given(seeds)
def test_equal_pieces_are_kept(seed: int) -> None:
    rng = np.random.default_rng(seed)
    b, points, offset = barycentrics(rng), rng.normal(size=(3, 3)), rng.normal(size=3)
    result = side_vertex_blend(lambda r, *_: r[..., None] * 0.0 + offset, points, *b)
    np.testing.assert_allclose(result, b.T @ points + offset, atol=1e-14)


@given(seeds, st.integers(0, 2))
def test_on_a_side_its_own_piece_counts_and_parameters_are_those_of_the_side(seed: int, i: int) -> None:
    rng = np.random.default_rng(seed)
    b, points = barycentrics(rng), rng.normal(size=(3, 3))
    b[i] = 0.0
    b /= b.sum(axis=0)
    j, k = (i + 1) % 3, (i + 2) % 3
    offsets = rng.normal(size=(3, 3))

    def deviation(r: Any, rest: Any, s: Any, rest_s: Any) -> Any:
        assert (r + rest)[..., i] == pytest.approx(np.ones(8), abs=1e-15)
        assert s[..., i] == pytest.approx(b[k] / (b[j] + b[k]), abs=1e-15)
        assert rest_s[..., i] == pytest.approx(b[j] / (b[j] + b[k]), abs=1e-15)
        return np.ones(r.shape)[..., None] * offsets

    result = side_vertex_blend(deviation, points, *b)
    np.testing.assert_allclose(result, b.T @ points + offsets[i], atol=1e-14)


@pytest.mark.parametrize("exponent", [1, 2])
def test_derivatives_on_a_side_are_those_of_its_own_piece_up_to_the_exponent(exponent: int) -> None:
    shapes = np.random.default_rng(6).normal(size=(3, 3))
    u, v = variables(np.array([[0.0, 0.3], [0.0, 0.8]]))
    # pieces that meet on side 1, where u = b_1 vanishes, with different derivatives across
    height: Any = np.stack([u, u, u], axis=-1)
    result: Any = separable_blend(
        lambda *_: ([height], [np.ones((2, 3))[..., None] * shapes]), np.zeros((3, 3)), 1.0 - (u + v), u, v, exponent
    )
    f, fu, fv, *second = result.coefficients
    np.testing.assert_allclose(fu, np.broadcast_to(shapes[1], (2, 3)), atol=1e-14)
    assert np.abs([f, fv]).max() < 1e-14
    assert (np.abs(second).max() < 1e-13) == (exponent == 2)


@given(seeds, st.sampled_from([1, 2]))
def test_both_forms_and_both_kinds_of_numbers_give_the_same(seed: int, exponent: int) -> None:
    rng = np.random.default_rng(seed)
    b, points, chord, tangent = barycentrics(rng), rng.normal(size=(3, 3)), *rng.normal(size=(2, 3, 3))

    def curves(s: Any, rest_s: Any) -> list[Any]:
        return [s[..., None] * chord, (s * rest_s)[..., None] * tangent]

    def terms(r: Any, rest: Any, s: Any, rest_s: Any) -> Any:
        return [r, r * rest], curves(s, rest_s)

    def deviation(r: Any, rest: Any, s: Any, rest_s: Any) -> Any:
        one, other = curves(s, rest_s)
        return r[..., None] * one + (r * rest)[..., None] * other

    u, v = variables(b[1:].T)
    of_taylors: Any = separable_blend(terms, points, 1.0 - (u + v), u, v, exponent)
    np.testing.assert_allclose(of_taylors.value, separable_blend(terms, points, b[0], b[1], b[2], exponent), atol=1e-13)
    if exponent == 1:
        whole: Any = side_vertex_blend(deviation, points, 1.0 - (u + v), u, v)
        scale = 1.0 + np.abs(whole.coefficients).max()
        np.testing.assert_allclose(of_taylors.coefficients, whole.coefficients, atol=1e-12 * scale)


def test_hermite_weights_are_those_of_the_cubic_less_its_chord() -> None:
    t = np.linspace(0.0, 1.0, 11)
    chord, first, last = np.random.default_rng(5).normal(size=(3, 3))
    control = np.stack([0.0 * chord, first / 3.0, chord - last / 3.0, chord])
    expected = curve_tables(3, t, 0)[0] @ control - t[:, None] * chord
    found = np.stack(hermite_weights(t, 1.0 - t), axis=-1) @ np.stack([chord, first, last])
    np.testing.assert_allclose(found, expected, atol=1e-15)


@pytest.mark.parametrize("scheme", [Nielson(), NielsonConic(), HagenPottmann()], ids=str)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_no_bit_of_a_jet_depends_on_the_other_patches_and_points(scheme: Scheme, order: int) -> None:
    batch, at = scheme.fit(torus(8, 5, 3)).batches[0], lattice(3, 9)
    together = batch.jets(at, order).coefficients
    np.testing.assert_array_equal(batch.take(slice(7, 8)).jets(at, order).coefficients, together[:, 7:8])
    np.testing.assert_array_equal(batch.jets(at[11:12], order).coefficients, together[:, :, 11:12])
    own = np.broadcast_to(at, (len(batch), *at.shape))
    np.testing.assert_array_equal(
        batch.take(slice(7, 8)).jets(own[7:8, 11:12], order).coefficients,
        batch.jets(own, order).coefficients[:, 7:8, 11:12],
    )
