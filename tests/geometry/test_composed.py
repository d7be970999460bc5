"""Functions of one parameter: the same jets as in two variables, whatever they meet, and shorter where they do not."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.composed import Composed, in_one_parameter, weighted_sum
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float

PATCHES, SAMPLES = 4, 5
orders = pytest.mark.parametrize("order", [0, 1, 2])


@dataclass(frozen=True)
class Operands:
    """Parameters s and rest = 1 - s by corner, (1, S, 3), another function r of (u, v), and data (P, 1, 3, 3)."""

    s: Any
    rest: Any
    r: Any
    a: Float
    b: Float


def operands(order: int) -> tuple[Operands, Operands]:
    """The same operands with parameters in one variable, and as functions of two."""
    rng = np.random.default_rng(1)
    u, v = Taylor.variables(rng.uniform(0.1, 0.4, (1, SAMPLES, 2)), order)
    bj, bk = np.stack([u, v, 1.0 - (u + v)], axis=-1), np.stack([v, 1.0 - (u + v), u], axis=-1)
    r: Any = bj + bk
    pair: tuple[Any, Any] = bk / r, bj / r
    a, b = rng.normal(size=(2, PATCHES, 1, 3, 3))
    return Operands(*in_one_parameter(*pair), r, a, b), Operands(*pair, r, a, b)


def expect_same(found: Any, expected: Any, *, stays: bool) -> None:
    assert isinstance(found, Composed) == stays
    assert found.shape == expected.shape
    assert found.ndim == expected.ndim
    assert found.size == expected.size
    assert found.order == expected.order
    np.testing.assert_allclose(found.value, expected.value, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(found.coefficients, expected.coefficients, rtol=1e-12, atol=1e-12)


STAY: dict[str, Callable[..., Any]] = {
    "sum": lambda x: x.s + x.rest * 2.0 + x.a[..., 0] + 1.0,
    "difference": lambda x: (x.s - x.a[..., 0]) - (2.0 - x.rest),
    "negative": lambda x: -x.s,
    "product": lambda x: x.s * x.s * x.rest * x.a[..., 1],
    "quotient": lambda x: x.s / (1.0 + x.rest) + 1.0 / x.s + x.rest / 2.0,
    "square": lambda x: x.s**2 + np.square(x.rest),
    "functions": lambda x: np.sqrt(x.s) + np.exp(x.rest) + np.log(x.s) + np.arccos(0.5 * x.s) + np.sin(x.s),
    "vectors": lambda x: x.s[..., None] * x.a + x.rest[..., None] * x.b,
    "scalar product": lambda x: np.vecdot(x.s[..., None] * x.a, x.rest[..., None] * x.b + x.a),
    "scalar product with a constant": lambda x: np.vecdot(x.s[..., None] * x.a, x.b),
    "vector product": lambda x: np.cross(x.s[..., None] * x.a, x.rest[..., None] * x.b + x.a),
    "vector product with a constant": lambda x: np.cross(x.b, x.s[..., None] * x.a),
    "components": lambda x: (x.s[..., None] * x.a)[..., 1] * (x.rest[..., None] * x.b)[..., -1],
    "some components": lambda x: (x.s[..., None] * x.a)[..., :2],
    "sum of components": lambda x: (x.s[..., None] * x.a).sum(axis=-1) + (x.rest[..., None] * x.b).sum(-1),
    "matrix": lambda x: np.einsum("...ij,...j->...i", x.a[..., None] * x.b[..., None, :], x.s[..., None] * x.a),
    "axes in front": lambda x: x.s[None] * x.rest,
    "weighted sum": lambda x: weighted_sum((x.s, x.rest, x.s * x.s), (x.a, x.b, x.a)),
    "sum with nothing else": lambda x: weighted_sum((x.s,), (x.s[..., None] * x.a,)),
}


@orders
@pytest.mark.parametrize("function", STAY.values(), ids=STAY.keys())
def test_functions_of_the_parameter_alone_stay_in_it(function: Callable[..., Any], order: int) -> None:
    in_one, in_two = operands(order)
    expect_same(function(in_one), function(in_two), stays=True)


LEAVE: dict[str, Callable[..., Any]] = {
    "another Taylor": lambda x: x.s + x.r,
    "product with another Taylor": lambda x: x.r * x.s + x.s * x.r,
    "vectors of either kind": lambda x: x.r[..., None] * (x.s[..., None] * x.a) - x.rest[..., None] * x.a,
    "quotients": lambda x: x.s / x.r + x.r / x.rest,
    "vector product": lambda x: np.cross(x.s[..., None] * x.a, x.r[..., None] * x.a[:, :, [1, 2, 0]]),
    "weighted sum": lambda x: weighted_sum((x.r, x.r * x.r), (x.s[..., None] * x.a, x.rest[..., None] * x.a)),
    "weighted sum of a constant": lambda x: weighted_sum((x.r, x.r), (x.s[..., None] * x.a, x.a)),
    "mixed weights": lambda x: weighted_sum((x.r, x.s), (x.s[..., None] * x.a, x.rest[..., None] * x.a)),
    "sum over places": lambda x: x.s.sum(axis=-1) + x.s.sum(axis=1)[..., 0],
    "sum over everything": lambda x: (x.s[..., None] * x.a).sum(),
    "places exchanged": lambda x: x.s[..., [1, 2, 0]] * x.rest,
    "some places": lambda x: x.s[..., 1:] * x.rest[..., :2],
    "one place": lambda x: x.s[..., 1],
    "places transposed": lambda x: np.transpose(x.s) + np.transpose(x.rest),
    "stacked": lambda x: np.stack([x.s, x.rest], axis=-1),
    "chosen": lambda x: np.where(x.s.value > 0.5, x.s, x.rest) + np.maximum(x.s, x.rest),
    "powers": lambda x: x.s**3 + x.s**x.rest,
}


@orders
@pytest.mark.parametrize("function", LEAVE.values(), ids=LEAVE.keys())
def test_whatever_else_is_done_is_done_in_two_variables(function: Callable[..., Any], order: int) -> None:
    in_one, in_two = operands(order)
    expect_same(function(in_one), function(in_two), stays=False)


def test_values_at_different_places_are_not_taken_for_functions_of_one_parameter() -> None:
    """With as many samples as corners nothing but the order of axes tells s at one corner from s at another."""
    at = np.random.default_rng(2).uniform(0.1, 0.4, (1, 3, 2))
    u, v = Taylor.variables(at)
    in_two: Any = np.stack([u / (u + v), v * u, u], axis=-1)
    in_one, _ = in_one_parameter(in_two, 1.0 - in_two)
    other, _ = in_one_parameter(1.0 * in_two, 1.0 - in_two)
    for x in (in_one, in_two):
        assert not isinstance(x[..., None] * x[..., None, :], Composed)
        assert not isinstance(x[:, None] * x[:, :, None], Composed)
    np.testing.assert_allclose(
        (in_one[..., None] * in_one[..., None, :]).coefficients,
        (in_two[..., None] * in_two[..., None, :]).coefficients,
        atol=1e-14,
    )
    assert not isinstance(in_one * other, Composed)  # equal, but not known to be
    np.testing.assert_allclose((in_one * other).coefficients, (in_two * in_two).coefficients, atol=1e-14)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_points_of_their_own_have_parameters_of_their_own(seed: int) -> None:
    rng = np.random.default_rng(seed)
    u, v = Taylor.variables(rng.uniform(0.1, 0.4, (PATCHES, SAMPLES, 2)))
    in_two: Any = (u / (u + v), v / (u + v))
    a = rng.normal(size=(PATCHES, 1, 3))

    def curve(s: Any, rest: Any) -> Any:
        vector = weighted_sum((s * rest, s * s), (a, 1.0 + a))
        return u[..., None] * (np.sqrt(1.0 + np.vecdot(vector, vector))[..., None] * vector)

    expect_same(curve(*in_one_parameter(*in_two)), curve(*in_two), stays=False)


def test_the_complement_is_taken_as_given() -> None:
    u, v = Taylor.variables(np.array([1e-20, 0.3]))
    _, rest = in_one_parameter(v / (u + v), u / (u + v))
    assert rest.value == u.value / (u + v).value > 0.0
    _, rest = in_one_parameter(np.array(1.0), np.array(1e-20))
    assert rest == 1e-20


def test_weighted_sums_of_arrays_are_sums() -> None:
    rng = np.random.default_rng(3)
    weights, vectors = rng.normal(size=(3, 4, 5)), rng.normal(size=(3, 4, 5, 3))
    np.testing.assert_allclose(
        weighted_sum(list(weights), list(vectors)), np.einsum("rps,rpsi->psi", weights, vectors), atol=1e-14
    )


@pytest.mark.parametrize("name", ["vector product", "weighted sum", "functions"])
def test_no_bit_depends_on_how_many_are_computed_together(name: str) -> None:
    rng = np.random.default_rng(4)
    at, a, b = rng.uniform(0.1, 0.4, (7, 9, 2)), rng.normal(size=(7, 1, 3)), rng.normal(size=(7, 1, 3))

    def evaluate(patches: slice, samples: slice) -> Float:
        u, v = Taylor.variables(at[patches, samples])
        pair = in_one_parameter(u / (u + v), v / (u + v))
        values = STAY[name](Operands(*pair, u, a[patches], b[patches]))
        jets: Float = ((u if values.ndim == 2 else u[..., None]) * values).coefficients
        return jets

    together = evaluate(slice(None), slice(None))
    np.testing.assert_array_equal(evaluate(slice(2, 3), slice(4, 5)), together[:, 2:3, 4:5])
