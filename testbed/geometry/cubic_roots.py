"""First roots of cubics in Bernstein form: in closed form by cases, and by bisection.

A-patches are zero sets met by rays: F along a ray is B(t) = sum over s of b_s B_s^3(t), and the surface is at its first
root. With s = t / (1 - t) that is d + 3 c s + 3 b s^2 + a s^3, (d, c, b, a) = (b_0, b_1, b_2, b_3), and Cardano's
formulas give the roots (Xu, Huang and Bajaj 2001, section 4.4). Which of the three it is follows from signs alone, by
Descartes's rule, given d < 0; the paper's own criterion asks for whole regions of parameters instead.

Every number is found element by element: no bit of a root depends on what it is computed with.
"""

import numpy as np

from testbed.geometry.vectors import Bool, Float

#: Below this, relative to the largest coefficient, b_3 is left out of the first guess: cancellation would spoil it.
TINY = 1e-6
#: Below this, relative to its terms, the sign of a discriminant is not known: such cubics are bisected.
DOUBLE = 1e-12
#: Below this b_0 is small enough for the first root to be near the start, where b_3 hardly counts.
NEAR = 1e-3
#: Newton steps that polish a root.
STEPS = 2
#: A root is accepted where the cubic is below this, relative to the sum of the moduli of its terms.
RESIDUAL = 1e-14
#: Bisections of an interval of length one at most: beyond the last digit of everything but roots near 0.
BISECTIONS = 60

# where there is no root, formulas divide by zero or take roots of negative numbers: NaN is the answer
_expected = np.errstate(invalid="ignore", divide="ignore", over="ignore")


@_expected
def first_roots(b: Float) -> Float:
    """Return the first roots of cubics that start at zero or below.

    Parameters
    ----------
    b
        (..., 4) Bernstein coefficients b_0 <= 0, b_1, b_2, b_3; of any scale.

    Returns
    -------
    Float
        (...) the smallest t in [0, 1) where the cubic rises through zero, 0 where b_0 = 0; NaN where there is none,
        where b_0 > 0, and where a coefficient is not finite.

    Notes
    -----
    In closed form, then polished by Newton steps as long as they make the cubic smaller. Where rounding leaves the case
    open (a discriminant that cancels, a b_3 that hardly counts) or the result is no root to rounding, by bisection. A
    cubic that only touches zero from below has, for the shooting, no root there; rounding may decide otherwise.
    """
    cubics, shape = scaled_rows(b)
    t, settled = closed_form(cubics)
    t = polished(cubics, t)
    settled &= np.isnan(t) | (np.abs(bernstein(cubics, t)) <= RESIDUAL * bernstein(np.abs(cubics), t))
    open_cases = ~settled & (cubics[0] < 0.0)
    if open_cases.any():
        t[open_cases] = bracketed(cubics[:, open_cases])
    return started(cubics, t).reshape(shape)


@_expected
def bracketed_roots(b: Float) -> Float:
    """First roots as in :func:`first_roots`, found without a formula: the robust reference.

    The critical points divide [0, 1] into intervals where the cubic is monotone; the first one with a change of sign is
    halved to the last digit, and a Newton step restores the relative accuracy of roots near 0.
    """
    cubics, shape = scaled_rows(b)
    return started(cubics, bracketed(cubics)).reshape(shape)


@_expected
def extended_roots(b: Float) -> Float:
    """Return the roots behind the start of a ray (equation 4.5), for cubics that start at zero or above.

    Parameters
    ----------
    b
        (..., 4) Bernstein coefficients, b_0 >= 0.

    Returns
    -------
    Float
        (...) the largest t <= 0 where the cubic is zero; NaN where there is none or b_0 < 0.

    Notes
    -----
    With s = -r the polynomial in s is, up to its sign, -d + 3 c r - 3 b r^2 + a r^3; t = -r / (1 - r) for r in (0, 1).
    """
    first = first_roots(np.asarray(b) * np.array([-1.0, 1.0, -1.0, 1.0]))
    behind = np.where(first < 0.5, -first, np.nan)
    root: Float = behind / (1.0 + 2.0 * behind)
    return root


def scaled_rows(b: Float) -> tuple[Float, tuple[int, ...]]:
    """Coefficients as contiguous rows (4, N), scaled by powers of two to a largest modulus near 1; and their shape."""
    b = np.asarray(b, dtype=np.float64)
    rows = np.ascontiguousarray(b.reshape(-1, 4).T)
    _, exponent = np.frexp(np.abs(rows).max(axis=0, initial=0.0))
    return np.ldexp(rows, -exponent), b.shape[:-1]


def started(cubics: Float, t: Float) -> Float:
    """Roots t (N,), with those that are at the start, and NaN where the cubic starts above zero or is not finite."""
    t = np.where(cubics[0] == 0.0, 0.0, t)
    return np.where((cubics[0] <= 0.0) & np.isfinite(cubics).all(axis=0), t, np.nan)


def bernstein(cubics: Float, t: Float) -> Float:
    """Values (N,) of cubics (4, N) at t (N,); near 0 as accurate, relatively, as the coefficients are."""
    r = 1.0 - t
    value: Float = ((cubics[0] * r + 3.0 * t * cubics[1]) * r + 3.0 * t * t * cubics[2]) * r + t * t * t * cubics[3]
    return value


def bernstein_slope(cubics: Float, t: Float) -> Float:
    """Derivatives (N,) of cubics (4, N) along t (N,)."""
    first, second, third = cubics[1:] - cubics[:-1]
    r = 1.0 - t
    slope: Float = 3.0 * (r * (r * first + 2.0 * t * second) + t * t * third)
    return slope


def polished(cubics: Float, t: Float) -> Float:
    """Roots (N,) after Newton steps, each taken only where it stays in [0, 1) and the cubic does not grow."""
    value = bernstein(cubics, t)
    for _ in range(STEPS):
        stepped = t - value / bernstein_slope(cubics, t)
        there = bernstein(cubics, stepped)
        better = (stepped >= 0.0) & (stepped < 1.0) & (np.abs(there) <= np.abs(value))
        t, value = np.where(better, stepped, t), np.where(better, there, value)
    return t


@_expected
def closed_form(cubics: Float) -> tuple[Float, Bool]:
    """First roots (N,) of cubics (4, N) with b_0 < 0 in closed form, NaN where there are none; and where that is sure.

    By Cardano's formulas, except where b_3 hardly counts: where it is tiny, and near the start, where the root is small
    and would be lost in a difference. There the quadratic formula gives a first guess.
    """
    d, c, b, a = cubics
    near = (-d <= NEAR * c) & (-d * np.maximum(np.abs(b), np.abs(a)) <= NEAR * c * c)
    plain = ~near & (np.abs(a) > TINY * np.abs(cubics).max(axis=0))
    s = np.full(d.shape, np.nan)
    certain = np.zeros(d.shape, dtype=np.bool_)
    s[plain], certain[plain] = cardano(*cubics[:, plain])
    s[~plain] = quadratic(d[~plain], c[~plain], b[~plain])
    certain |= ~plain & ~np.isnan(s)
    s = np.where(s >= 0.0, s, np.nan)
    return s / (1.0 + s), certain


def cardano(d: Float, c: Float, b: Float, a: Float) -> tuple[Float, Bool]:
    """First positive roots s (N,) of d + 3 c s + 3 b s^2 + a s^3, d < 0; negative or NaN: none; and where that is sure.

    s = x - b / a gives x^3 + p x + q = 0 with p = 3 (a c - b^2) / a^2, q = (2 b^3 - 3 a b c + a^2 d) / a^3 and the
    discriminant D = (q / 2)^2 + (p / 3)^3.

    Which root it is follows from Descartes's rule. d < 0 leaves an odd number of positive roots where a > 0, an even
    one where a < 0. Let x_1 be the largest, x_2 the smallest and x_3 the middle one of three, or x_1 the only one.
    a > 0: x_1, the only positive one, unless b < 0 < c: then no root is negative, and it is x_2 if there are three.
    a < 0: x_3 if it is positive, for then so is x_1; else none.
    """
    shift = b / a
    third = c / a - shift * shift  # p / 3
    half = shift * shift * shift - 1.5 * shift * (c / a) + 0.5 * (d / a)  # q / 2
    square, cube = half * half, third * third * third
    discriminant = square + cube
    certain = np.abs(discriminant) > DOUBLE * (square + np.abs(cube))
    s = np.empty(d.shape)
    single = discriminant >= 0.0
    # one real root (4.18): the cube root of the larger modulus, so that nothing cancels; the other is -p / 3 over it
    h, p3 = half[single], third[single]
    larger = np.cbrt(-(h + np.copysign(np.sqrt(discriminant[single]), h)))
    s[single] = np.where(larger == 0.0, 0.0, larger - p3 / larger) - shift[single]
    s[single & (a < 0.0)] = np.nan
    # three real roots, in trigonometric form
    three = ~single
    radius = 2.0 * np.sqrt(-third[three])
    angle = np.arctan2(np.sqrt(-discriminant[three]), -half[three]) / 3.0
    turn = 2.0 * np.pi / 3.0
    all_positive = (b[three] < 0.0) & (c[three] > 0.0)
    by = np.where(a[three] < 0.0, -turn, np.where(all_positive, turn, 0.0))
    s[three] = radius * np.cos(angle + by) - shift[three]
    return s, certain


def quadratic(d: Float, c: Float, b: Float) -> Float:
    """First positive roots s (N,) of d + 3 c s + 3 b s^2, d < 0, and of d + 3 c s where b = 0; NaN: none."""
    root = np.sqrt(9.0 * c * c - 12.0 * b * d)  # NaN where there is no real root
    forward = -2.0 * d / (3.0 * c + root)
    backward = (root - 3.0 * c) / (6.0 * b)
    return np.where(c > 0.0, forward, np.where(b > 0.0, backward, np.nan))


def bracketed(cubics: Float) -> Float:
    """First roots (N,) of cubics (4, N) with b_0 < 0 by bisection between critical points; NaN: none."""
    first, second, third = cubics[1:] - cubics[:-1]
    # B' / 3 = first (1 - t)^2 + 2 second t (1 - t) + third t^2, as A t^2 + 2 B t + C
    quadratic_part, linear_part = (third - second) - (second - first), second - first
    root = np.sqrt(linear_part * linear_part - quadratic_part * first)
    larger = -(linear_part + np.copysign(root, linear_part))
    ends = np.stack([larger / quadratic_part, first / larger])
    # where there is no critical point inside, its place is taken by the end
    ends = np.sort(np.where((ends > 0.0) & (ends < 1.0), ends, 1.0), axis=0)
    low, high = np.zeros(first.shape), np.ones(first.shape)
    found = np.zeros(first.shape, dtype=np.bool_)
    for end in (*ends, np.ones(first.shape)):
        reached = bernstein(cubics, end) > 0.0
        high = np.where(found, high, end)
        found |= reached
        low = np.where(found, low, end)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        above = bernstein(cubics, middle) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    # a root far below the last interval's length keeps its digits if Newton's method starts below it
    t = polished(cubics, np.where(low == 0.0, low, high))
    return np.where(found & (t < 1.0), t, np.nan)
