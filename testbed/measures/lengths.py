"""Lengths and angles of many vectors, quickly: by sums of squares, where :mod:`testbed.geometry.vectors` takes hypot.

hypot keeps the last digit and the whole range of floats, at ten times the cost. Measures look at millions of vectors;
they take square roots of sums of squares, right to about two units in the last place, and hypot only where the squares
leave the range.
"""

import numpy as np

from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, cross, dot, norm

#: Between these, squares of lengths have all their digits.
SQUARES = (1e-280, 1e280)


def length(a: Float) -> Float:
    """Euclidean length over the last axis, without overflow or underflow; (..., 3) to (...)."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        square = dot(a, a)
        result: Float = np.sqrt(square)
    beyond = ~((square > SQUARES[0]) & (square < SQUARES[1]))
    if beyond.any():
        result[beyond] = norm(a[beyond])
    return result


def angle(a: Float, b: Float) -> Float:
    """Angle of two vectors in radians, (...); by atan2, so that small angles keep all their digits."""
    return np.arctan2(length(cross(a, b)), dot(a, b))


def unit_normal(jet: Jet) -> Float:
    """Unit normals f_u x f_v / |f_u x f_v|, (..., 3); NaN where the parametrisation is singular."""
    normal = cross(jet.fu, jet.fv)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal /= length(normal)[..., None]
    return normal
