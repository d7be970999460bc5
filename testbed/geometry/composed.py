"""Taylor arithmetic with functions of one parameter, the parameter being a function of (u, v).

A curve's point at s, its tangent, their lengths and angles depend on one number s(u, v) alone. In two variables each of
them has six coefficients, in s only three, and a product takes less than half of the work. A :class:`Composed` is a
Taylor that keeps the three: arithmetic among functions of one parameter, and with constants, stays in that parameter,
and whatever else is done with them takes their derivatives along (u, v), by the chain rule.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import EllipsisType, MappingProxyType
from typing import Any

import numpy as np

from testbed.geometry import elementary, truncated, univariate
from testbed.geometry.taylor import YZX, ZXY, Taylor
from testbed.geometry.vectors import Float


def in_one_parameter(t: Any, rest: Any) -> tuple[Any, Any]:
    """Return a parameter and its complement: what is computed from them alone is a function of one variable.

    Taylors become :class:`Composed`, arrays stay what they are; the values are the same either way.

    Parameters
    ----------
    t
        The parameter, an array or a Taylor.
    rest
        1 - ``t`` without loss, of the same shape.
    """
    if not isinstance(t, Taylor):
        return t, rest
    held = np.zeros((2, t.order + 1, *t.shape[::-1]))
    held[0, 0], held[1, 0] = t.value.T, rest.value.T
    held[0, 1:2], held[1, 1:2] = 1.0, -1.0  # empty slices at order 0
    inner = t._planes
    return Composed._in(held[0], inner, inner), Composed._in(held[1], inner, inner)


def weighted_sum(weights: Sequence[Any], vectors: Sequence[Any]) -> Any:
    """Return the sum of scalars (...) times vectors (..., k), in their order, (..., k).

    Arrays, or Taylors of any kind; functions of one parameter times constants, and other Taylors times functions of one
    parameter, are summed in place.
    """
    scalars = [weight[..., None] for weight in weights]
    if all(isinstance(weight, Composed) for weight in scalars):
        common = _in_common(*scalars, *vectors)
        if common is not None and not any(isinstance(vector, Taylor) for vector in vectors):
            series, inner, root = common
            return Composed._in(_summed(series[: len(scalars)], series[len(scalars) :]), inner, root)
    elif all(type(weight) is Taylor for weight in scalars) and all(isinstance(vector, Composed) for vector in vectors):
        common = _in_common(*vectors)
        if common is not None:
            series, inner, _ = common
            planes = [weight._planes for weight in scalars]
            ndim = max(part.ndim for part in (*planes, *series))
            planes, series = ([_with_axes(part, ndim) for part in parts] for parts in (planes, series))
            shape = np.broadcast_shapes(*(part.shape[1:] for part in (*planes, *series)))
            total = np.zeros((min(map(len, planes)), *shape))
            for factor, vector in zip(planes, series, strict=True):
                univariate.add_expanded_product(total, factor, vector, _with_axes(inner, ndim))
            return Taylor._of(total)
    total = scalars[0] * vectors[0]
    for scalar, vector in zip(scalars[1:], vectors[1:], strict=True):
        total = total + scalar * vector
    return total


def _summed(weights: Sequence[Float], constants: Sequence[Float]) -> Float:
    """Sum of products of series and constants, one after the other."""
    total: Float = weights[0] * constants[0]
    product = np.empty_like(total)
    for weight, constant in zip(weights[1:], constants[1:], strict=True):
        total += np.multiply(weight, constant, out=product)
    return total


class Composed(Taylor):
    """An array of functions of one parameter t(u, v), each known by its derivatives with respect to t; immutable.

    Each element has the parameter that stands at its own place, t being broadcast to the value's shape. It is made by
    :func:`in_one_parameter` and behaves as a Taylor does.
    """

    __slots__ = ("_inner", "_root", "_series")

    _series: Float  # (rows in t, *reversed value axes)
    _inner: Float  # rows of t; as many axes, and lengths those of the series or one
    _root: Float  # t as it was at first: the same elements in the same order, but for axes of length one

    @classmethod
    def _in(cls, series: Float, inner: Float, root: Float) -> "Composed":
        composed = cls.__new__(cls)
        composed._series, composed._inner, composed._root = series, inner, root
        return composed

    @property
    def _planes(self) -> Float:
        return univariate.expand(self._series, self._inner)

    @property
    def value(self) -> Float:
        """Values f, (...)."""
        value: Float = self._series[0].T
        return value

    @property
    def order(self) -> int:
        """0, 1 or 2."""
        return len(self._series) - 1

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the value."""
        return self._series.shape[:0:-1]

    @property
    def ndim(self) -> int:
        """Axes of the value."""
        return self._series.ndim - 1

    def _is_alike_along(self, axis: int) -> bool:
        """Whether the parameter is the same along an axis of the value."""
        length: int = self._inner.shape[self.ndim - axis % self.ndim]
        return length == 1

    def __getitem__(self, key: Any) -> Taylor:
        keys = list(key) if isinstance(key, tuple) else [key]
        if not all(item is None or isinstance(item, int | slice | EllipsisType) for item in keys):
            return super().__getitem__(key)
        taken = sum(item is not None and item is not Ellipsis for item in keys)
        place = keys.index(Ellipsis) if Ellipsis in keys else len(keys)
        keys[place : place + 1] = [_ALL] * (self.ndim - taken)
        of_inner, axis = [], 0
        for item in keys:
            of_inner.append(0 if isinstance(item, int) else None if item is None else _ALL)
            if item is not None:
                if item is not _ALL and not self._is_alike_along(axis):
                    return super().__getitem__(key)
                axis += 1
        return Composed._in(self._series.T[*keys, :].T, self._inner.T[*of_inner, :].T, self._root)

    def transpose(self, *axes: int) -> Taylor:
        """Return the value axes permuted; reversed without arguments."""
        order = [axis % self.ndim for axis in axes] or list(range(self.ndim))[::-1]
        places = [axis for axis in order if not self._is_alike_along(axis)]
        if places != sorted(places):
            return super().transpose(*axes)
        held = [0, *(self.ndim - axis for axis in reversed(order))]
        return Composed._in(self._series.transpose(held), self._inner.transpose(held), self._root)

    def sum(self, axis: int | tuple[int, ...] | None = None, keepdims: bool = False) -> Taylor:
        """Sum over value axes."""
        if not isinstance(axis, int) or keepdims or not self._is_alike_along(axis):
            return super().sum(axis, keepdims)
        held = self.ndim - axis % self.ndim
        first, *others = np.moveaxis(self._series, held, 0)
        total = first
        for term in others:
            total = total + term
        return Composed._in(total, self._inner.squeeze(held), self._root)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method == "__call__" and not kwargs:
            if ufunc is np.power and np.ndim(inputs[1]) == 0 and inputs[1] == 2:
                ufunc, inputs = np.multiply, (inputs[0], inputs[0])
            if ufunc in _RULES and (common := _in_common(*inputs)) is not None:
                series, inner, root = common
                return Composed._in(_RULES[ufunc](*series), inner, root)
        return super().__array_ufunc__(ufunc, method, *inputs, **kwargs)

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func is np.cross and not kwargs and (common := _in_common(*args)) is not None:
            (p, q), inner, root = common
            (p_yzx, p_zxy), (q_yzx, q_zxy) = ((x[:, YZX], x[:, ZXY]) for x in (p, q))
            return Composed._in(univariate.multiply(p_yzx, q_zxy) - univariate.multiply(p_zxy, q_yzx), inner, root)
        return super().__array_function__(func, types, args, kwargs)


_RULES: Mapping[np.ufunc, Callable[..., Float]] = MappingProxyType(
    {
        np.add: partial(truncated.linear, np.add),
        np.subtract: partial(truncated.linear, np.subtract),
        np.multiply: univariate.multiply,
        np.divide: univariate.divide,
        np.negative: np.negative,
        **{ufunc: partial(univariate.compose, function) for ufunc, function in elementary.ONE_VARIABLE.items()},
    }
)

_ALL = slice(None)


def _with_axes(planes: Float, ndim: int) -> Float:
    """Planes with so many axes, the new ones in front in the value."""
    return planes if planes.ndim == ndim else planes.reshape(planes.shape + (1,) * (ndim - planes.ndim))


def _in_common(*inputs: Any) -> tuple[list[Float], Float, Float] | None:
    """Series with equally many axes, their parameter and its root; None where there is not one parameter for all."""
    series, composed = [], []
    for x in inputs:
        if isinstance(x, Composed):
            series.append(x._series)
            composed.append(x)
        elif isinstance(x, Taylor):
            return None
        else:
            value = np.asarray(x, dtype=np.float64)
            series.append((np.ascontiguousarray(value.T) if value.ndim else value)[None])
    ndim = max([part.ndim for part in series])
    root, inner = composed[0]._root, _with_axes(composed[0]._inner, ndim)
    for other in composed[1:]:
        # equal elements in equal order and equal shape: at equal places
        if other._root is not root or _with_axes(other._inner, ndim).shape != inner.shape:
            return None
    return [_with_axes(part, ndim) for part in series], inner, root
