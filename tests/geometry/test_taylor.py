"""Taylor arithmetic against difference quotients in extended precision, and against its own algebra."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float, angle_between, cross, dot, norm, quadratic_form, tangential, unit

seeds = st.integers(0, 2**32 - 1)
orders = pytest.mark.parametrize("order", [0, 1, 2])
AT = np.random.default_rng(7).uniform(0.1, 0.9, size=(40, 2))
ROWS = (1, 3, 6)

#: Every operation of the arithmetic, in functions of u, v in (0.1, 0.9) that exercise all terms of the chain rule.
FUNCTIONS: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda u, v: u + v + 2.0 + (1.0 + u),
    "subtract": lambda u, v: (u - v) - 2.0 - (1.0 - v * v),
    "multiply": lambda u, v: (u * u * v) * (3.0 * v) * (u * v * 0.5),
    "divide": lambda u, v: (u * v) / (1.0 + u + v * v),
    "divide by a constant": lambda u, v: (u * v) / 3.0,
    "divide a constant": lambda u, v: 2.0 / (u * u + v),
    "reciprocal": lambda u, v: np.reciprocal(u * v + v),
    "negative": lambda u, v: -(u * u * v),
    "positive": lambda u, v: +(u * u * v),
    "absolute": lambda u, v: abs(u * v - 2.0) * abs(u + v),
    "square": lambda u, v: np.square(u * v + u),
    "power 2": lambda u, v: (u * v + u) ** 2,
    "power 3": lambda u, v: (u * v - 2.0 * u) ** 3,
    "power -1.5": lambda u, v: (u * v + u) ** -1.5,
    "power 1": lambda u, v: (u * v * v) ** 1,
    "power 0": lambda u, v: (u * v * v) ** 0 + u,
    "power of two": lambda u, v: (u + v) ** (u * v),
    "power of a constant": lambda u, v: 2.0 ** (u * v),
    "sqrt": lambda u, v: np.sqrt(u * u + v),
    "exp": lambda u, v: np.exp(u * v - u),
    "log": lambda u, v: np.log(u * u + v),
    "sin": lambda u, v: np.sin(u * v + 3.0 * u),
    "cos": lambda u, v: np.cos(u * v + 3.0 * u),
    "tan": lambda u, v: np.tan(u * v - v),
    "arcsin": lambda u, v: np.arcsin(u * v - 0.3 * u),
    "arccos": lambda u, v: np.arccos(u * v - 0.3 * u),
    "arctan": lambda u, v: np.arctan(u * v - 3.0 * u),
    "arctan2": lambda u, v: np.arctan2(u * v - 0.3, u * u - v),
    "arctan2 of a constant": lambda u, v: np.arctan2(0.4, u * u - v) + np.arctan2(u * v, -1.0),
    "hypot": lambda u, v: np.hypot(u * v - 2.0, u * u - v),
    "hypot with a constant": lambda u, v: np.hypot(0.4, u * u - v) + np.hypot(u * v, 1.0),
    "maximum": lambda u, v: np.maximum(u * u, v * v) + np.maximum(u * v, 0.2),
    "minimum": lambda u, v: np.minimum(u * u, v * v) + np.minimum(0.2, u * v),
    "where": lambda u, v: np.where(u > v, u * v, np.where(u < 0.3, 1.0, v * v)),
}


def differences(function: Callable[[Any, Any], Any], at: Float) -> Float:
    """Value, first and second derivatives (6, ...) by fourth-order difference quotients in extended precision."""
    step = np.longdouble(1.0) / 2048
    first = np.array([1, -8, 0, 8, -1], dtype=np.longdouble) / (12 * step)
    second = np.array([-1, 16, -30, 16, -1], dtype=np.longdouble) / (12 * step**2)
    value = np.array([0, 0, 1, 0, 0], dtype=np.longdouble)
    u, v = np.moveaxis(at.astype(np.longdouble), -1, 0)
    grid = np.stack([np.stack([function(u + i * step, v + j * step) for j in range(-2, 3)]) for i in range(-2, 3)])
    rows = [(value, value), (first, value), (value, first), (second, value), (first, first), (value, second)]
    return np.stack([np.einsum("i,j,ij...->...", a, b, grid) for a, b in rows]).astype(np.float64)


def random_taylor(seed: int, shape: tuple[int, ...], order: int = 2) -> Taylor:
    return Taylor(np.random.default_rng(seed).normal(size=(ROWS[order], *shape)))


def vector(u: Any, v: Any) -> Any:
    return np.stack([u * v + 0.2, u * u - v, np.sin(u) + v], axis=-1)


def other_vector(u: Any, v: Any) -> Any:
    return np.stack([v * v + 1.0, u * v, u - np.cos(v)], axis=-1)


def test_variables_are_the_coordinates() -> None:
    u, v = Taylor.variables(AT)
    zero, one = np.zeros(len(AT)), np.ones(len(AT))
    np.testing.assert_array_equal(u.coefficients, [AT[:, 0], one, zero, zero, zero, zero])
    np.testing.assert_array_equal(v.coefficients, [AT[:, 1], zero, one, zero, zero, zero])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_operation_agrees_with_difference_quotients(name: str) -> None:
    # maximum, minimum, where and abs have kinks, away from which the points lie
    away = AT[(np.abs(AT[:, 0] - AT[:, 1]) > 0.01) & (np.abs(AT.prod(axis=1) - 0.2) > 0.01)]
    away = away[np.abs(away[:, 0] - 0.3) > 0.01]
    result = FUNCTIONS[name](*Taylor.variables(away))
    expected = differences(FUNCTIONS[name], away)
    np.testing.assert_allclose(result.coefficients, expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_value_is_that_of_the_same_formula_on_arrays(name: str) -> None:
    u, v = Taylor.variables(AT)
    np.testing.assert_allclose(FUNCTIONS[name](u, v).value, FUNCTIONS[name](*AT.T), rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_lower_orders_are_the_first_rows_to_the_last_bit(name: str) -> None:
    full = FUNCTIONS[name](*Taylor.variables(AT)).coefficients
    for order in (0, 1):
        result = FUNCTIONS[name](*Taylor.variables(AT, order))
        assert result.order == order
        np.testing.assert_array_equal(result.coefficients, full[: ROWS[order]])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_point_has_the_same_bits_in_any_company(name: str) -> None:
    together = FUNCTIONS[name](*Taylor.variables(AT)).coefficients
    alone = [FUNCTIONS[name](*Taylor.variables(AT[k : k + 1])).coefficients for k in range(len(AT))]
    np.testing.assert_array_equal(together, np.concatenate(alone, axis=1))


@pytest.mark.parametrize(
    "function",
    [
        lambda u, v: dot(vector(u, v), other_vector(u, v)),
        lambda u, v: np.vecdot(vector(u, v), other_vector(u, v)),
        lambda u, v: cross(vector(u, v), other_vector(u, v)),
        lambda u, v: np.cross(vector(u, v), other_vector(u, v)),
        lambda u, v: norm(vector(u, v)),
        lambda u, v: np.linalg.norm(vector(u, v), axis=-1),
        lambda u, v: unit(vector(u, v)),
        lambda u, v: tangential(vector(u, v), unit(other_vector(u, v))),
        lambda u, v: angle_between(vector(u, v), other_vector(u, v)),
        lambda u, v: quadratic_form(vector(u, v), np.arange(9.0).reshape(3, 3), other_vector(u, v)),
        lambda u, v: np.einsum("...i,...j->...ji", vector(u, v), other_vector(u, v)),
        lambda u, v: np.sum(vector(u, v) * other_vector(u, v), axis=-1),
    ],
    ids=[
        "dot",
        "vecdot",
        "cross",
        "np.cross",
        "norm",
        "np.norm",
        "unit",
        "tangential",
        "angle",
        "form",
        "outer",
        "sum",
    ],
)
def test_vector_algebra_agrees_with_difference_quotients(function: Callable[[Any, Any], Any]) -> None:
    result = function(*Taylor.variables(AT))
    np.testing.assert_allclose(result.coefficients, differences(function, AT), rtol=1e-7, atol=1e-7)


@given(seeds)
def test_length_is_differentiable_on_the_axes(seed: int) -> None:
    direction = np.random.default_rng(seed).normal(size=(6, 3))
    direction[0] = (0.0, 0.0, 2.0)
    a: Any = Taylor(direction)
    length: Any = norm(a)
    a = direction
    # by hand: h' = <a, a'> / h, h'' = (<a', a'> + <a, a''> - h' h') / h
    hu, hv = a[1, 2], a[2, 2]
    second = [a[1] @ a[1] - hu * hu, a[1] @ a[2] - hu * hv, a[2] @ a[2] - hv * hv]
    expected = [2.0, hu, hv, *(s / 2.0 + a[3 + r, 2] for r, s in enumerate(second))]
    np.testing.assert_allclose(length.coefficients, expected, rtol=1e-12, atol=1e-13)


@given(seeds)
def test_identities(seed: int) -> None:
    a, b = random_taylor(seed, (4, 3)), random_taylor(seed + 1, (4, 3))
    positive = np.exp(a)

    def same(x: Any, y: Any) -> None:
        expected = y.coefficients if isinstance(y, Taylor) else np.concatenate([[y], np.zeros((5, *np.shape(y)))])
        np.testing.assert_allclose(x.coefficients, expected, rtol=1e-9, atol=1e-9)

    b = b + np.copysign(1.0, b.value)  # away from zero
    same(a * b, b * a)
    same((a * b) / b, a)
    same(a * (b + a), a * b + a * a)
    same(np.sin(a) ** 2 + np.cos(a) ** 2, np.ones((4, 3)))
    same(np.sqrt(positive) * np.sqrt(positive), positive)
    same(np.log(positive), a)
    same(np.tan(0.1 * a) * np.cos(0.1 * a), np.sin(0.1 * a))
    same(np.arctan(np.tan(0.1 * a)), 0.1 * a)
    same(np.arctan2(positive * np.sin(b / 9), positive * np.cos(b / 9)), b / 9)
    same(np.hypot(a, b) ** 2, a * a + b * b)
    same(1.0 / b, np.reciprocal(b))
    same(a - a, np.zeros((4, 3)))


@given(seeds)
def test_product_commutes_to_the_last_bit(seed: int) -> None:
    a, b = random_taylor(seed, (5,)), random_taylor(seed + 1, (5,))
    np.testing.assert_array_equal((a * b).coefficients, (b * a).coefficients)


@orders
@given(seed=seeds)
def test_broadcasting_is_that_of_the_materialised_arrays(order: int, seed: int) -> None:
    a: Any = random_taylor(seed, (1, 5, 1), order)
    b: Any = random_taylor(seed + 1, (4, 1, 3), order)
    constant = np.random.default_rng(seed + 2).normal(size=(4, 5, 3)) + 5.0
    whole_a, whole_b = (np.broadcast_to(x, (4, 5, 3)) for x in (a, b))
    for operation in (np.add, np.subtract, np.multiply, np.divide, np.hypot, np.arctan2):
        for few, many in (((a, b), (whole_a, whole_b)), ((a, constant), (whole_a, constant))):
            for x, y in ((few, many), (few[::-1], many[::-1])):
                np.testing.assert_array_equal(operation(*x).coefficients, operation(*y).coefficients)


@pytest.mark.parametrize(
    "function",
    [
        lambda x: x[1],
        lambda x: x[..., 0],
        lambda x: x[:, None, 1:, ..., ::-1],
        lambda x: x[..., [2, 0, 1]],
        lambda x: x[np.array([2, 2, 0]), :, np.array([0, 1, 2])],
        lambda x: x[np.arange(12).reshape(3, 4) % 2 == 0],
        lambda x: x.reshape(4, 9),
        lambda x: x.reshape((6, -1)),
        lambda x: np.reshape(x, (-1,)),
        lambda x: x.transpose(2, 0, 1),
        lambda x: x.transpose(),
        lambda x: np.transpose(x, (1, 0, 2)),
        lambda x: np.moveaxis(x, 0, -1),
        lambda x: np.moveaxis(x, (0, 2), (1, 0)),
        lambda x: np.broadcast_to(x, (2, 3, 4, 3)),
        lambda x: np.stack([x, 2.0 * x], axis=-2),
        lambda x: np.stack([x, x, x]),
        lambda x: np.concatenate([x, x[:, :2]], axis=1),
        lambda x: np.concatenate([x, x], axis=-1),
        lambda x: x.sum(),
        lambda x: np.sum(x, axis=1),
        lambda x: np.sum(x, axis=(0, -1)),
        lambda x: np.sum(x, axis=(0, 1), keepdims=True),
        lambda x: np.einsum("...ij->...ji", x),
        lambda x: np.einsum("abc->ca", x),
        lambda x: np.einsum("...i,ki->...k", x, np.arange(6.0).reshape(2, 3)),
        lambda x: np.einsum("ij,aib->bja", np.arange(8.0).reshape(4, 2), x),
        lambda x: np.einsum("...ij,...j,i->...", x, np.arange(3.0), np.arange(4.0)),
    ],
)
def test_linear_array_functions_act_on_every_coefficient(function: Callable[[Any], Any]) -> None:
    x = random_taylor(3, (3, 4, 3))
    result = function(x)
    expected = np.stack([function(row) for row in x.coefficients])
    assert result.shape == expected.shape[1:]
    assert result.ndim == len(result.shape)
    np.testing.assert_allclose(result.coefficients, expected, rtol=1e-14, atol=1e-14)


@given(seeds)
def test_einsum_of_two_is_the_sum_of_products(seed: int) -> None:
    m, x = random_taylor(seed, (2, 1, 3, 3)), random_taylor(seed + 1, (4, 3))
    product: Any = np.einsum("...ij,...j->...i", m, x)
    by_component: Any = np.stack(
        [m[..., i, 0] * x[..., 0] + m[..., i, 1] * x[..., 1] + m[..., i, 2] * x[..., 2] for i in range(3)], axis=-1
    )
    np.testing.assert_array_equal(product.coefficients, by_component.coefficients)


def test_constants_join_with_zero_derivatives() -> None:
    u, v = Taylor.variables(AT)
    joined: Any = np.stack([u, np.ones(len(AT)), v], axis=-1)
    np.testing.assert_array_equal(joined[..., 1].coefficients[1:], 0.0)
    np.testing.assert_array_equal(joined[..., 1].value, 1.0)
    assert np.concatenate([u, np.zeros(3)]).shape == (len(AT) + 3,)


def test_orders_mix_to_the_lower_one() -> None:
    (u2, _), (u1, v1) = Taylor.variables(AT, 2), Taylor.variables(AT, 1)
    results: list[Any] = [u2 * v1, v1 / u2, np.stack([u2, v1]), np.where(u2 > v1, u2, v1), np.hypot(u2, v1)]
    for mixed in results:
        assert mixed.order == 1
    np.testing.assert_array_equal((u2 * v1).coefficients, (u1 * v1).coefficients)


def test_comparisons_are_those_of_the_values() -> None:
    u, v = Taylor.variables(AT)
    np.testing.assert_array_equal(u < v, AT[:, 0] < AT[:, 1])
    np.testing.assert_array_equal(v >= 0.5, AT[:, 1] >= 0.5)
    np.testing.assert_array_equal(u != 0.5, AT[:, 0] != 0.5)
    assert np.isfinite(u).all()


def test_maximum_and_minimum_propagate_nan_from_either_side() -> None:
    u, _ = Taylor.variables(AT[:1])
    for pick in (np.maximum, np.minimum):
        results: list[Any] = [pick(u, u * np.nan), pick(u * np.nan, u), pick(u, np.nan), pick(np.nan, u)]
        for result in results:
            assert np.isnan(result.value).all()


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (np.floor, "numpy.floor"),
        (np.add.accumulate, "numpy.add.accumulate"),
        (np.multiply.reduce, "numpy.multiply.reduce"),
        (np.sort, "numpy.sort"),
        (lambda u: np.linalg.det(np.stack([np.stack([u, u]), np.stack([u, u])])), "numpy.linalg.det"),
        (lambda u: np.add(u, u, out=np.zeros(len(u))), "numpy.add"),
        (lambda u: np.einsum("ii->i", np.stack([u[:1]])), "numpy.einsum"),
        (lambda u: np.einsum("i...,i...", u, u), "numpy.einsum"),
        (np.asarray, "take .value"),
    ],
)
def test_what_is_not_defined_is_a_type_error_that_names_it(call: Callable[[Any], Any], name: str) -> None:
    u, _ = Taylor.variables(AT)
    with pytest.raises(TypeError, match=name.replace(".", r"\.")):
        call(u)


@pytest.mark.parametrize("shape", [(), (2, 5), (4,), (7, 1)])
def test_coefficients_have_one_three_or_six_rows(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="1, 3 or 6 rows"):
        Taylor(np.zeros(shape))


def test_division_by_zero_warns_as_for_arrays() -> None:
    u, v = Taylor.variables(np.zeros((1, 2)))
    with pytest.warns(RuntimeWarning, match="invalid value"):
        quotient = u / v
    assert np.isnan(quotient.coefficients).all()
