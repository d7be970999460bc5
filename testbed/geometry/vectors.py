"""Vector algebra over arrays whose last axis is the space, and the array types used everywhere."""

from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

Float: TypeAlias = NDArray[np.float64]
Int: TypeAlias = NDArray[np.int64]
Bool: TypeAlias = NDArray[np.bool_]

#: Between these, squares of lengths have all their digits.
SQUARES = (1e-280, 1e280)


def dot(a: Float, b: Float) -> Float:
    """Scalar product over the last axis; shapes broadcast, (..., 3) and (..., 3) to (...).

    Component by component, so that neither the bits nor the speed depend on the memory layout.
    """
    product: Float = a[..., 0] * b[..., 0]
    for axis in range(1, a.shape[-1]):
        product = product + a[..., axis] * b[..., axis]
    return product


def cross(a: Float, b: Float) -> Float:
    """Vector product over the last axis; (..., 3) and (..., 3) to (..., 3)."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return stack_components(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def stack_components(*components: Float) -> Float:
    """Components (...) as vectors (..., k), each component contiguous in memory where the components are.

    Operations on vectors run component by component, faster on such memory than on a last axis of stride one.
    """
    return np.moveaxis(np.stack(components), 0, -1)


def norm(a: Float) -> Float:
    """Euclidean length over the last axis, without overflow or underflow; (..., 3) to (...).

    By sums of squares, right to about two units in the last place; by hypot, at ten times the cost, only where squares
    leave the range of floats.
    """
    if not isinstance(cast("object", a), np.ndarray):
        # in Taylor arithmetic one operation, differentiable wherever the vector is not zero
        length: Float = np.hypot.reduce(a, axis=-1)
        return length
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        square = np.asarray(dot(a, a))
        length = np.asarray(np.sqrt(square))
    beyond = ~((square > SQUARES[0]) & (square < SQUARES[1]))
    if beyond.any():
        length[beyond] = np.hypot.reduce(a[beyond], axis=-1)
    return length


def unit(a: Float) -> Float:
    """Vectors scaled to length one, (..., 3); a zero vector gives NaN, which no measure takes for a pass."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return a / norm(a)[..., None]


def tangential(a: Float, normal: Float) -> Float:
    """Part of ``a`` perpendicular to the unit ``normal``: a - <a, n> n, (..., 3)."""
    return a - dot(a, normal)[..., None] * normal


def angle_between(a: Float, b: Float) -> Float:
    """Angle of two vectors in radians, (...); by atan2, so that small angles keep all their digits."""
    return np.arctan2(norm(cross(a, b)), dot(a, b))


def quadratic_form(u: Float, W: Float, v: Float) -> Float:
    """Scalar u . W v for vectors (..., 3) and symmetric matrices (..., 3, 3)."""
    product: Float = np.einsum("...i,...ij,...j->...", u, W, v)
    return product


def as_float(values: Any) -> Float:
    """Whatever array-like is given, as float64 in C order."""
    return np.ascontiguousarray(values, dtype=np.float64)
