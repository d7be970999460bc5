"""Elementary functions with their derivatives, for Taylor arithmetic; each derivative is computed when asked for.

A function of one variable yields g, g', g''; a function of two yields (g,), (g_x, g_y), (g_xx, g_xy, g_yy).
"""

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from testbed.geometry.vectors import Float

OneVariable: TypeAlias = Callable[[Float], Iterator[Float]]
TwoVariables: TypeAlias = Callable[[Float, Float], Iterator[tuple[Float, ...]]]


def _sqrt(x: Float) -> Iterator[Float]:
    root = np.sqrt(x)
    yield root
    first = 0.5 / root
    yield first
    yield -0.5 * first / x


def _square(x: Float) -> Iterator[Float]:
    yield x * x
    yield 2.0 * x
    yield np.full(x.shape, 2.0)


def _reciprocal(x: Float) -> Iterator[Float]:
    inverse = 1.0 / x
    yield inverse
    square = inverse * inverse
    yield -square
    yield 2.0 * square * inverse


def _exp(x: Float) -> Iterator[Float]:
    e = np.exp(x)
    yield e
    yield e
    yield e


def _log(x: Float) -> Iterator[Float]:
    yield np.log(x)
    inverse = 1.0 / x
    yield inverse
    yield -inverse * inverse


def _sin(x: Float) -> Iterator[Float]:
    sine = np.sin(x)
    yield sine
    yield np.cos(x)
    yield -sine


def _cos(x: Float) -> Iterator[Float]:
    cosine = np.cos(x)
    yield cosine
    yield -np.sin(x)
    yield -cosine


def _tan(x: Float) -> Iterator[Float]:
    tangent = np.tan(x)
    yield tangent
    first = 1.0 + tangent * tangent
    yield first
    yield 2.0 * tangent * first


def _arcsin(x: Float) -> Iterator[Float]:
    yield np.arcsin(x)
    first = 1.0 / np.sqrt((1.0 - x) * (1.0 + x))
    yield first
    yield x * first * first * first


def _arccos(x: Float) -> Iterator[Float]:
    yield np.arccos(x)
    first = -1.0 / np.sqrt((1.0 - x) * (1.0 + x))
    yield first
    yield x * first * first * first


def _arctan(x: Float) -> Iterator[Float]:
    yield np.arctan(x)
    first = 1.0 / (1.0 + x * x)
    yield first
    yield -2.0 * x * first * first


#: The functions of one variable that Taylor arithmetic knows.
ONE_VARIABLE: Mapping[np.ufunc, OneVariable] = MappingProxyType(
    {
        np.sqrt: _sqrt,
        np.square: _square,
        np.reciprocal: _reciprocal,
        np.exp: _exp,
        np.log: _log,
        np.sin: _sin,
        np.cos: _cos,
        np.tan: _tan,
        np.arcsin: _arcsin,
        np.arccos: _arccos,
        np.arctan: _arctan,
    }
)


def power(exponent: Float) -> OneVariable:
    """Return x to a constant power; the exponents broadcast against x."""

    def derivatives(x: Float) -> Iterator[Float]:
        yield np.power(x, exponent)
        # where the factor in front vanishes, x to the power 0 stands in: no 0 * inf at x = 0
        yield exponent * np.power(x, np.where(exponent == 0.0, 0.0, exponent - 1.0))
        factor = exponent * (exponent - 1.0)
        yield factor * np.power(x, np.where(factor == 0.0, 0.0, exponent - 2.0))

    return derivatives


def arctan2(y: Float, x: Float) -> Iterator[tuple[Float, ...]]:
    """Angle of (x, y); the first argument is y, as in numpy."""
    yield (np.arctan2(y, x),)
    h = np.hypot(x, y)
    c, s = x / h / h, y / h / h
    yield c, -s
    yield -2.0 * c * s, s * s - c * c, 2.0 * c * s
