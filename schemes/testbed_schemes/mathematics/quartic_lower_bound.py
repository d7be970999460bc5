"""How far the ordinates of a quartic triangle may lie below zero while the quartic does not.

A quartic Bezier triangle with ordinates A, B, C >= 0 at its corners and -r or more everywhere else is at least

    (A + r) u^4 + (B + r) v^4 + (C + r) w^4 - r,

whose least value on the triangle is [sum (A + r)^(-1/3)]^(-3) - r. With s = 1 / r it is not negative where

    G(s) = (1 + A s)^(-1/3) + (1 + B s)^(-1/3) + (1 + C s)^(-1/3) <= 1.

G falls from 3 and is convex; it takes the value 1 once if A, B, C > 0, and not at all if one of them is zero. The bound
is sharp: where all other ordinates are -r, the least value is zero.

Source: the condition of Piah, Saaban and Abd. Majid 2006 for functions, which Si 2015, chapter 4, applies to signed
distances of control points from a plane. Derived anew from that outline. Fill: rounding towards the safe side.
"""

import numpy as np

from testbed.geometry.vectors import Bool, Float

#: The root's rounding errors, some 20 units in the last place at most, are given away so that r never is too large.
SAFE = 1.0 - 64 * np.finfo(np.float64).eps
#: Newton's steps for s: each but the last few multiplies it by 4 at most, and the root is below 1e226 for floats.
STEPS = 500


def lower_ordinate(A: Float, B: Float, C: Float) -> Float:
    """Return the greatest r such that ordinates A, B, C at the corners and -r or more elsewhere make no negative value.

    Symmetric and homogeneous of degree one, between min(A, B, C) / 26 and max(A, B, C) / 26 unless a corner is zero.
    Rounded downwards: the bound holds for the r returned.

    Parameters
    ----------
    A, B, C
        Ordinates at the corners, arrays of one shape.

    Returns
    -------
    Float
        r of that shape; 0 where a corner is zero, NaN where one is negative or not finite.
    """
    low, high = np.minimum(np.minimum(A, B), C), np.maximum(np.maximum(A, B), C)
    middle = np.maximum(np.minimum(A, B), np.minimum(np.maximum(A, B), C))
    bounded: Bool = np.asarray((low >= 0.0) & np.isfinite(high))
    scale = np.where(bounded & (high > 0.0), high, 1.0)
    a, b = (np.where(bounded, value, 0.0) / scale for value in (low, middle))
    r = np.zeros(np.shape(low))
    positive: Bool = np.asarray(a > 0.0)
    r[positive] = SAFE * scale[positive] / root(a[positive], b[positive])
    return np.where(bounded, r, np.nan)


def root(a: Float, b: Float) -> Float:
    """Return s of G(s) = 1 for the corners 0 < a <= b <= 1 and 1, arrays (n,).

    Newton's steps from 26, where G >= 1: on a falling convex function they stay on this side of the root. Each entry
    stops by itself, when rounding keeps it from growing.
    """
    s = np.full(np.shape(a), 26.0)
    open_ = np.arange(len(s))
    for _ in range(STEPS):
        at, corners = s[open_], (a[open_], b[open_], np.ones(len(open_)))
        logarithms = [np.log1p(corner * at) for corner in corners]
        # 1 is taken from the greatest of the three terms, which tends to it as its corner tends to zero
        excess = np.expm1(-logarithms[0] / 3.0) + np.exp(-logarithms[1] / 3.0) + np.exp(-logarithms[2] / 3.0)
        slope = sum(corner * np.exp(-4.0 * log / 3.0) for corner, log in zip(corners, logarithms, strict=True)) / 3.0
        next_ = at + excess / slope
        grows = next_ > at
        open_ = open_[grows]
        if not len(open_):
            break
        s[open_] = next_[grows]
    return s
