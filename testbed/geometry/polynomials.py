"""Polynomials of one variable in Bernstein form, many at once: products, Wronskians, division, roots on [0, 1].

Coefficients come first and rows last, (n + 1, ..., R): what is done to a coefficient runs along contiguous memory, and
no result depends on the other rows. The Bernstein form on [0, 1] is the well-conditioned one there (Farouki and Rajan
1987): no power of t is ever formed.
"""

import math
from functools import cache

import numpy as np

from testbed.geometry.vectors import Float, Int

#: Halvings after which roots that are not alone in their interval are given by its midpoint: a function whose
#: derivative has two roots nearer than this varies between them by the cube of it, which is rounding.
DEPTH = 17
#: Newton steps for a root that is alone; a bracket is kept, so that even bisection alone ends within 1e-9.
STEPS = 30
#: A Newton step below this was the last: the next would be below its square.
LAST_STEP = 1e-6


@cache
def _binomials(degree: int) -> Float:
    """Binomial coefficients C(degree, i), (degree + 1,), read-only."""
    row = np.array([math.comb(degree, i) for i in range(degree + 1)], dtype=np.float64)
    row.flags.writeable = False
    return row


def scaled(p: Float) -> Float:
    """Coefficients times binomials, (n + 1, ...): those of the powers of t / (1 - t) in p(t) / (1 - t)^n."""
    return p * _binomials(len(p) - 1).reshape(-1, *(1,) * (p.ndim - 1))


def _unscaled(p: Float) -> Float:
    """Divide scaled coefficients, in place, by the binomials."""
    p /= _binomials(len(p) - 1).reshape(-1, *(1,) * (p.ndim - 1))
    return p


def _add_product(total: Float, p: Float, q: Float) -> None:
    """Add to scaled coefficients (m + n + 1, ...) the product of polynomials with scaled coefficients: no weights."""
    for i, coefficient in enumerate(p):
        total[i : i + len(q)] += coefficient * q


def multiply(p: Float, q: Float) -> Float:
    """Product of polynomials (m + 1, ...) and (n + 1, ...), of degree m + n; the other axes broadcast."""
    product = np.zeros((len(p) + len(q) - 1, *np.broadcast_shapes(p.shape[1:], q.shape[1:])))
    _add_product(product, scaled(p), scaled(q))
    return _unscaled(product)


def multiply_dot(p: Float, q: Float) -> Float:
    """Scalar product of vector polynomials (m + 1, 3, R) and (n + 1, 3, R), (m + n + 1, R)."""
    p, q = scaled(p), scaled(q)
    product = np.zeros((len(p) + len(q) - 1, p.shape[-1]))
    for x in range(3):
        _add_product(product, p[:, x], q[:, x])
    return _unscaled(product)


def multiply_cross(p: Float, q: Float) -> Float:
    """Vector product of vector polynomials (m + 1, 3, R) and (n + 1, 3, R), (m + n + 1, 3, R)."""
    p, q = scaled(p), scaled(q)
    opposite = -p
    product = np.zeros((len(p) + len(q) - 1, 3, p.shape[-1]))
    for x in range(3):
        _add_product(product[:, x], p[:, x - 2], q[:, x - 1])
        _add_product(product[:, x], opposite[:, x - 1], q[:, x - 2])
    return _unscaled(product)


def wronskian(p: Float, q: Float) -> Float:
    """Polynomial p' q - p q' of two polynomials (n + 1, ...) of the same degree n, written with degree 2 n - 2.

    As forms in a = 1 - t and b = t, where n p = a p_a + b p_b and p' = p_b - p_a, it is (p_b q_a - p_a q_b) / n: the
    leading terms of p' q and p q', which cancel, never appear.
    """
    n = len(p) - 1
    if n == 0:
        return np.zeros((1, *np.broadcast_shapes(p.shape[1:], q.shape[1:])))
    return n * (multiply(p[1:], q[:-1]) - multiply(p[:-1], q[1:]))


def basis(degree: int, t: Float) -> Float:
    """Bernstein polynomials of a degree at parameters (R,), (degree + 1, R)."""
    powers = np.ones((2, degree + 1, *t.shape))
    for i in range(1, degree + 1):
        np.multiply(powers[0, i - 1], t, out=powers[0, i])
        np.multiply(powers[1, i - 1], 1.0 - t, out=powers[1, i])
    return scaled(powers[0] * powers[1, ::-1])


def combine(weights: Float, p: Float) -> Float:
    """Values (..., R) of polynomials (n + 1, ..., R) where the Bernstein polynomials are (n + 1, R or 1)."""
    value: Float = weights[0] * p[0]
    for weight, coefficient in zip(weights[1:], p[1:], strict=True):
        value += weight * coefficient
    return value


def divide(p: Float, t: Float | float = 0.5) -> tuple[Float, Float]:
    """Coefficients on [0, t] and on [t, 1] of polynomials (n + 1, ..., R); ``t`` is a number or (R,)."""
    before, after = np.empty_like(p), np.empty_like(p)
    s, degree = 1.0 - t, len(p) - 1
    for step in range(degree + 1):
        before[step], after[degree - step] = p[0], p[-1]
        p = s * p[:-1] + t * p[1:]
    return before, after


def sign_changes(p: Float) -> Int:
    """Sign changes (R,) in the coefficients (n + 1, R), zero counting as positive.

    At least as many as there are roots inside (0, 1), and of the same parity (Descartes' rule in Bernstein form); no
    fewer than without the zeros.
    """
    negative = p < 0.0
    changes: Int = np.count_nonzero(negative[1:] != negative[:-1], axis=0)
    return changes


def real_roots(p: Float) -> tuple[Int, Float]:
    """Return rows (K,) and parameters (K,) that hold all real roots in (0, 1) of polynomials (n + 1, R).

    Intervals are halved until the coefficients on them change sign once or never. Points of division are returned too,
    because a root there may escape by rounding, and so are the midpoints of intervals that are still undecided at
    :data:`DEPTH`, where roots are multiple or as good as multiple: the list may hold more than roots.
    """
    row, left, width = np.arange(p.shape[1]), np.zeros(p.shape[1]), 1.0
    rows, roots, alone = [], [], []
    for level in range(DEPTH + 1):
        changes = sign_changes(p)
        (one,) = np.nonzero(changes == 1)
        alone.append((row[one], left[one], np.full(len(one), width), p[:, one]))
        (several,) = np.nonzero(changes > 1)
        if not len(several):
            break
        row, left, width = row[several], left[several], 0.5 * width
        rows.append(row)
        roots.append(left + width)
        if level < DEPTH:
            p = np.concatenate(divide(p[:, several]), axis=1)
            row, left = np.concatenate([row, row]), np.concatenate([left, left + width])
    row, left, widths, p = (np.concatenate(parts, axis=-1) for parts in zip(*alone, strict=True))
    return np.concatenate([*rows, row]), np.concatenate([*roots, left + widths * _only_root(p)])


def _only_root(p: Float) -> Float:
    """Roots (R,) in [0, 1] of polynomials (n + 1, R) that change sign once: Newton's method in brackets.

    In r = t / (1 - t) or its inverse, whichever is at most 1, p is (1 - t)^n or t^n times a polynomial with the scaled
    coefficients, which takes one multiplication a coefficient and has the same root.
    """
    middle = combine(basis(len(p) - 1, np.full(1, 0.5)), p)
    late = (middle < 0.0) == (p[0] < 0.0)
    c = scaled(np.where(late, p[::-1], p))
    c *= np.where(c[0] < 0.0, -1.0, 1.0)
    # positive at low, or zero as at a root at the end that is not the one sought; negative at high
    low, high, row = np.zeros(p.shape[1]), np.ones(p.shape[1]), np.arange(p.shape[1])
    end = c.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):  # where p is tiny the quotients may be 0/0: bisection then
        r = c[0] / (c[0] - end)
    root = np.empty(p.shape[1])
    r = np.where((r > 0.0) & (r <= 1.0), r, 0.5)
    for _ in range(STEPS):
        value, slope = c[-1].copy(), np.zeros_like(r)
        for coefficient in c[-2::-1]:
            slope *= r
            slope += value
            value *= r
            value += coefficient
        low, high = np.where(value >= 0.0, r, low), np.where(value >= 0.0, high, r)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            following = r - value / slope
        following = np.where((following >= low) & (following <= high), following, 0.5 * (low + high))
        root[row] = following
        (moving,) = np.nonzero(np.abs(following - r) > LAST_STEP)
        if not len(moving):
            break
        row, r, c, low, high = row[moving], following[moving], c[:, moving], low[moving], high[moving]
    t: Float = np.where(late, 1.0 / (1.0 + root), root / (1.0 + root))
    return t
