"""Truncated Taylor arithmetic of second order in two variables, over arrays.

A :class:`Taylor` is an array whose every element carries its derivatives along (u, v). It answers to numpy's protocols,
so a formula written for arrays yields, given Taylor arguments, its exact first and second derivatives: the rules of
differentiation are applied operation by operation, nothing is approximated.

All sums run one term after the other and all functions run on contiguous data, so that no bit of a result depends on
how the points are divided over calls.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import EllipsisType, MappingProxyType
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from testbed.geometry import elementary, truncated
from testbed.geometry.jets import ROWS
from testbed.geometry.vectors import Bool, Float


class Taylor(NDArrayOperatorsMixin):
    """An array of functions of (u, v), each known by its derivatives up to an order; immutable.

    Parameters
    ----------
    coefficients
        (1 | 3 | 6, ...): f | f_u, f_v | f_uu, f_uv, f_vv, derivatives as in a jet; the value axes follow.

    Notes
    -----
    Shape, axes and indices are those of the value. Operations between orders truncate to the lower one. Plain arrays
    and numbers are constants. Memory is held with the value axes reversed: points run contiguously, and an operation on
    vectors (patches, samples, 3) is three operations on long runs instead of many on three numbers.
    """

    __slots__ = ("_held",)

    _held: Float

    def __init__(self, coefficients: Float) -> None:
        coefficients = np.asarray(coefficients, dtype=np.float64)
        if coefficients.ndim == 0 or len(coefficients) not in ROWS:
            raise ValueError(f"Taylor coefficients have 1, 3 or 6 rows, not the shape {coefficients.shape}")
        self._held = np.ascontiguousarray(np.moveaxis(coefficients, 0, -1).T)

    @classmethod
    def _of(cls, planes: Float) -> "Taylor":
        taylor = cls.__new__(cls)
        taylor._held = planes
        return taylor

    @classmethod
    def variables(cls, at: Float, order: int = 2) -> tuple["Taylor", "Taylor"]:
        """Return u and v themselves at the domain points ``at`` (..., 2), two Taylors of shape (...)."""
        both = []
        for axis in range(2):
            coefficients = np.zeros((ROWS[order], *at.shape[:-1]))
            coefficients[0] = at[..., axis]
            coefficients[1 + axis : 2 + axis] = 1.0  # an empty slice at order 0
            both.append(cls(coefficients))
        return both[0], both[1]

    @property
    def _planes(self) -> Float:
        """Coefficients as they are held: (rows, *reversed value axes), the last ones contiguous."""
        return self._held

    @property
    def coefficients(self) -> Float:
        """(1 | 3 | 6, ...) derivatives f | f_u, f_v | f_uu, f_uv, f_vv."""
        return np.moveaxis(self._planes.T, -1, 0)

    @property
    def value(self) -> Float:
        """Values f, (...)."""
        value: Float = self._planes[0].T
        return value

    @property
    def order(self) -> int:
        """0, 1 or 2."""
        return ROWS.index(len(self._planes))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the value."""
        return self._planes.shape[:0:-1]

    @property
    def ndim(self) -> int:
        """Axes of the value."""
        return self._planes.ndim - 1

    @property
    def size(self) -> int:
        """Elements of the value."""
        return math.prod(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return f"Taylor(order={self.order}, shape={self.shape})"

    def __getitem__(self, key: Any) -> "Taylor":
        keys = key if isinstance(key, tuple) else (key,)
        if not any(isinstance(item, EllipsisType) for item in keys):
            keys = (*keys, ...)
        return Taylor._of(self._planes.T[*keys, :].T)

    def reshape(self, *shape: Any) -> "Taylor":
        """Return the same elements, in C order of the value, in another shape."""
        return Taylor(self.coefficients.reshape(len(self._planes), *np.atleast_1d(np.squeeze(shape)).tolist()))

    def transpose(self, *axes: int) -> "Taylor":
        """Return the value axes permuted; reversed without arguments."""
        order = [axis % self.ndim for axis in axes] or list(range(self.ndim))[::-1]
        return Taylor(self.coefficients.transpose(0, *(1 + axis for axis in order)))

    def sum(self, axis: int | tuple[int, ...] | None = None, keepdims: bool = False) -> "Taylor":
        """Sum over value axes."""
        return _sum(self, axis, keepdims)

    def __array__(self, *_: Any, **__: Any) -> Float:
        raise TypeError("a Taylor is not converted to an array: take .value or .coefficients")

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method == "__call__" and not kwargs and ufunc in _RULES:
            return Taylor._of(_RULES[ufunc](*_operands(*inputs)))
        if method == "reduce" and ufunc in _REDUCTIONS:
            return _REDUCTIONS[ufunc](*inputs, **{"axis": 0, **kwargs})
        if method != "__call__" or kwargs:
            options = f" with {', '.join(kwargs)}" if kwargs else ""
            raise TypeError(f"numpy.{ufunc.__name__}.{method}{options} is not defined on Taylor arguments")
        if ufunc in _ON_VALUES:
            return ufunc(*(x.value if isinstance(x, Taylor) else x for x in inputs))
        if ufunc in _CHOICES:
            return _CHOICES[ufunc](*inputs)
        raise TypeError(f"numpy.{ufunc.__name__} is not defined on Taylor arguments")

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func not in _FUNCTIONS:
            raise TypeError(f"{func.__module__}.{func.__name__} is not defined on Taylor arguments")
        return _FUNCTIONS[func](*args, **kwargs)


# Arithmetic. Inside, arrays are planes: rows first, value axes reversed, so that shapes are aligned at the left.


def _operands(*inputs: Any) -> list[Float]:
    """Planes of each input, of one order and with as many axes as the largest has; constants have one row."""
    rows, planes = 6, []
    for x in inputs:
        if isinstance(x, Taylor):
            planes.append(x._planes)
            rows = min(rows, len(x._planes))
        else:
            value = np.asarray(x, dtype=np.float64)
            planes.append((np.ascontiguousarray(value.T) if value.ndim else value)[None])
    ndim = max([p.ndim for p in planes])
    # most operations join arrays of equal order and equally many axes, and there is nothing to do
    return [p[:rows].reshape(p[:rows].shape + (1,) * (ndim - p.ndim)) if p.ndim < ndim else p[:rows] for p in planes]


def _power(a: Any, exponent: Any) -> Taylor:
    if isinstance(exponent, Taylor):
        result: Taylor = np.exp(exponent * np.log(a))
        return result
    if np.ndim(exponent) == 0 and exponent == 2:
        return Taylor._of(truncated.multiply(a._planes, a._planes))
    shape = np.broadcast_shapes(a.shape, np.shape(exponent))
    constant = np.broadcast_to(np.asarray(exponent, dtype=np.float64), shape)
    function = elementary.power(np.ascontiguousarray(constant.T))
    return Taylor._of(truncated.compose(function, _broadcast_to(a, shape)._planes))


def _vecdot(a: Any, b: Any) -> Taylor:
    """Scalar product over the last value axis, in one multiplication."""
    product: Taylor = a * b
    return product.sum(-1)


_RULES: Mapping[np.ufunc, Callable[..., Float]] = MappingProxyType(
    {
        np.add: partial(truncated.linear, np.add),
        np.subtract: partial(truncated.linear, np.subtract),
        np.multiply: truncated.multiply,
        np.divide: truncated.divide,
        np.negative: np.negative,
        np.positive: np.positive,
        np.hypot: truncated.hypot,
        np.arctan2: partial(truncated.compose_two, elementary.arctan2),
        **{ufunc: partial(truncated.compose, function) for ufunc, function in elementary.ONE_VARIABLE.items()},
    }
)

#: Components of vectors, turned; for vector products.
YZX, ZXY = [1, 2, 0], [2, 0, 1]

_CHOICES: Mapping[np.ufunc, Callable[..., Taylor]] = MappingProxyType(
    {
        np.power: _power,
        np.vecdot: _vecdot,
        np.absolute: lambda a: a * np.copysign(1.0, a.value),
        # a NaN is chosen, from either side
        np.maximum: lambda a, b: _where((a >= b) | np.isnan(a), a, b),
        np.minimum: lambda a, b: _where((a <= b) | np.isnan(a), a, b),
    }
)

_ON_VALUES = frozenset(
    {np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal, np.sign}
    | {np.isfinite, np.isnan, np.isinf, np.signbit}
)


# Array functions.


def _full(x: Any, rows: int) -> Taylor:
    """Return a Taylor of so many rows, a constant with zero derivatives."""
    if isinstance(x, Taylor):
        return Taylor._of(x._planes[:rows])
    value = np.asarray(x, dtype=np.float64)
    return Taylor(np.concatenate([value[None], np.zeros((rows - 1, *value.shape))]))


def _same_order(parts: Sequence[Any]) -> list[Taylor]:
    rows = min(len(part._planes) for part in parts if isinstance(part, Taylor))
    return [_full(part, rows) for part in parts]


def _stack(parts: Sequence[Any], axis: int = 0) -> Taylor:
    same = _same_order(parts)
    # outermost in memory wherever it stands: a stacked axis is one of components
    planes = np.stack([part._planes for part in same], axis=1)
    return Taylor._of(np.moveaxis(planes, 1, planes.ndim - 1 - axis % (planes.ndim - 1)))


def _concatenate(parts: Sequence[Any], axis: int = 0) -> Taylor:
    same = _same_order(parts)
    # value axis k is axis ndim - k of the planes
    return Taylor._of(np.concatenate([part._planes for part in same], axis=same[0].ndim - axis % same[0].ndim))


def _where(condition: Bool, a: Any, b: Any) -> Taylor:
    shape = np.broadcast_shapes(np.shape(condition), np.shape(a), np.shape(b))
    rows = min(len(x._planes) for x in (a, b) if isinstance(x, Taylor))
    p, q = (_broadcast_to(_full(x, rows), shape)._planes for x in (a, b))
    return Taylor._of(np.where(np.broadcast_to(condition, shape).T, p, q))


def _broadcast_to(a: Taylor, shape: tuple[int, ...]) -> Taylor:
    planes = a._planes
    padded = planes.reshape(planes.shape + (1,) * (len(shape) - a.ndim))
    return Taylor._of(np.broadcast_to(padded, (len(planes), *shape[::-1])))


def _moveaxis(a: Taylor, source: Any, destination: Any) -> Taylor:
    planes = a._planes.T  # value axes first, rows last
    last = planes.ndim - 1
    source, destination = (np.atleast_1d(axes) % last for axes in (source, destination))
    return Taylor._of(np.moveaxis(planes, source.tolist(), destination.tolist()).T)


def _sum(a: Taylor, axis: int | tuple[int, ...] | None = None, keepdims: bool = False) -> Taylor:
    axes = range(a.ndim) if axis is None else axis if isinstance(axis, tuple) else (axis,)
    planes = a._planes
    # value axis k is axis ndim - k of the planes; lowest k first, so that the axes still to come keep their places
    for k in sorted(x % a.ndim for x in axes):
        first, *others = np.moveaxis(planes, a.ndim - k, 0)
        total = first
        for term in others:
            total = total + term
        planes = np.expand_dims(total, a.ndim - k) if keepdims else total
    return Taylor._of(planes)


def _einsum(subscripts: str, *operands: Any) -> Taylor:
    """Sum of products, one product after the other: explicit output, an ellipsis only in front, no repeated label."""
    inputs, arrow, output = subscripts.replace(" ", "").partition("->")
    labels = [term.removeprefix("...") for term in inputs.split(",")]
    out = output.removeprefix("...")
    if not arrow or "." in "".join((*labels, out)) or any(len(set(term)) < len(term) for term in (*labels, out)):
        raise TypeError(
            f"numpy.einsum of Taylor arguments takes subscripts such as '...ij,...j->...i', not {subscripts!r}"
        )
    size = {
        label: length
        for term, x in zip(labels, operands, strict=True)
        for label, length in zip(term, np.shape(x)[np.ndim(x) - len(term) :], strict=True)
    }
    summed = sorted(set(size) - set(out))
    # each operand's axes in the order of the output, then the summed ones; a label it lacks has length one
    ordered: list[Any] = []
    for term, x in zip(labels, operands, strict=True):
        front = np.ndim(x) - len(term)
        kept = [label for label in (*out, *summed) if label in term]
        turned: Any = np.transpose(x, (*range(front), *(front + term.index(label) for label in kept)))
        ordered.append(turned[(..., *(slice(None) if label in term else None for label in (*out, *summed)))])
    total: Any = None
    for index in itertools.product(*(range(size[label]) for label in summed)):
        product: Any = None
        for x in ordered:
            here = tuple(
                i if length > 1 else 0 for i, length in zip(index, x.shape[x.ndim - len(index) :], strict=True)
            )
            factor = x[(..., *here)]
            product = factor if product is None else product * factor
        total = product if total is None else total + product
    result: Taylor = total
    return result


def _cross(a: Any, b: Any) -> Taylor:
    """Vector product over the last value axis, in two multiplications of vectors whose components are turned."""
    a, b = _same_order((a, b))
    p, q = _operands(a, b)
    (p_yzx, p_zxy), (q_yzx, q_zxy) = ((x[:, YZX], x[:, ZXY]) for x in (p, q))
    return Taylor._of(truncated.multiply(p_yzx, q_zxy) - truncated.multiply(p_zxy, q_yzx))


def _norm(a: Taylor, axis: int | tuple[int, ...] | None = None, keepdims: bool = False) -> Taylor:
    root: Taylor = np.sqrt(_sum(a**2, axis, keepdims))  # type: ignore[assignment]  # numpy dispatches to Taylor
    return root


_REDUCTIONS: Mapping[np.ufunc, Callable[..., Taylor]] = MappingProxyType({np.add: _sum, np.hypot: _norm})

_FUNCTIONS: Mapping[Any, Callable[..., Any]] = MappingProxyType(
    {
        np.shape: lambda a: a.shape,
        np.ndim: lambda a: a.ndim,
        np.size: lambda a: a.size,
        np.sum: _sum,
        np.stack: _stack,
        np.concatenate: _concatenate,
        np.einsum: _einsum,
        np.cross: _cross,
        np.linalg.norm: _norm,
        np.where: _where,
        np.broadcast_to: _broadcast_to,
        np.moveaxis: _moveaxis,
        np.transpose: lambda a, axes=None: a.transpose(*(axes or ())),
        np.reshape: lambda a, shape: a.reshape(shape),
    }
)
