"""Thresholds of shooting polynomials of A-patches (Xu, Huang and Bajaj 2001, Lemma 2.3), many at once.

Along the ray from a point q of a face or edge towards the apex, F is a cubic in t, the *shooting polynomial* with
Bernstein coefficients b_0 < 0, b_1, b_2, b_3; the free coefficient b adds beta t^2 b to it. The surface is smooth and
single sheeted where the smallest root in [0, 1) of every shooting polynomial is simple. With sigma = (1 - t) / t, roots
are solutions of

    beta b = h(sigma) = -(b_0 sigma^3 + 3 b_1 sigma^2 + 3 b_2 sigma + b_3) / (1 + sigma),

and t = 0 is sigma = inf, where h = +inf. So the smallest root exists and is simple for all b above the first local
minimum of h met from there, and is double at it: **fill**, the exact threshold in place of the lemma's, which is the
same in most cases and never below.
"""

import numpy as np

from testbed.geometry.vectors import Float

# Below this part of the others, b_0 counts as zero: h has no minimum of any height there if b_1 > 0.
_VANISHING = 1e-40


def shooting_bound(b0: Float, b1: Float, b2: Float, b3: Float, beta: float | Float = 1.0) -> Float:
    """Return the exact threshold b* above which the smallest root of sum b_s B_s^3(t) + beta t^2 b is simple.

    Parameters
    ----------
    b0, b1, b2, b3
        (...) Bernstein coefficients without the free coefficient's part; b0 <= 0. They broadcast.
    beta
        (...) positive factor; NaN results where it is not.

    Returns
    -------
    Float
        (...): h(sigma*) / beta with sigma* the largest positive root of h', that is of
        2 b0 sigma^3 + 3 (b0 + b1) sigma^2 + 6 b1 sigma + 3 b2 - b3; -b3 / beta if there is none.
        For b0 -> 0 and b1 > 0 it tends to -inf, which is returned where b0 vanishes (nothing is asked there: the root
        is t = 0). NaN for b0 > 0, and for b0 = 0 with b1 <= 0, where t = 0 is no simple root or no limit of one.
    """
    b0, b1, b2, b3, beta = np.broadcast_arrays(b0, b1, b2, b3, beta)
    shape = b0.shape
    b0, b1, b2, b3, beta = (np.asarray(b, dtype=np.float64).ravel() for b in (b0, b1, b2, b3, beta))
    scale = np.maximum(np.maximum(np.abs(b0), np.abs(b1)), np.maximum(np.abs(b2), np.abs(b3)))
    with np.errstate(invalid="ignore", divide="ignore"):  # all zero: NaN
        b0, b1, b2, b3 = b0 / scale, b1 / scale, b2 / scale, b3 / scale
    valid = (b0 < -_VANISHING) & (beta > 0.0)
    result = np.full(len(b0), np.nan)
    result[(np.abs(b0) <= _VANISHING) & (b1 > 0.0) & (beta > 0.0)] = -np.inf
    b0, b1, b2, b3 = b0[valid], b1[valid], b2[valid], b3[valid]
    t = _first_stationary(b0, b1, b2, b3)
    s = 1.0 - t
    height = -(s * (s * (s * b0 + 3.0 * t * b1) + 3.0 * t * t * b2) + t * t * t * b3) / (t * t)
    result[valid] = height * scale[valid] / beta[valid]
    return result.reshape(shape)


def _first_stationary(b0: Float, b1: Float, b2: Float, b3: Float) -> Float:
    """Return the parameter t in (0, 1] of the first stationary point of h seen from t = 0, 1 if there is none.

    Of a x^3 + 3 b x^2 + 3 c x + d, a < 0, the largest root; x + b / a is the root of a depressed cubic, scaled by a so
    that the smallest root is looked for and nothing is divided by a until the end.
    """
    a, b, c, d = 2.0 * b0, b0 + b1, 2.0 * b1, 3.0 * b2 - b3
    H = a * c - b * b
    G = a * (a * d - 3.0 * b * c) + 2.0 * b * b * b
    square = G * G + 4.0 * H * H * H
    root = np.empty(len(a))
    three = (square <= 0.0) & (H < 0.0)
    radius = np.sqrt(-H[three])
    angle = np.arccos(np.clip(-G[three] / (2.0 * radius * radius * radius), -1.0, 1.0))
    root[three] = 2.0 * radius * np.cos((angle + 2.0 * np.pi) / 3.0)
    one = ~three
    larger = np.cbrt(-0.5 * (G[one] + np.copysign(np.sqrt(np.maximum(square[one], 0.0)), G[one])))
    with np.errstate(invalid="ignore", divide="ignore"):  # 0 / 0: the triple root, at 0
        smaller = np.where(larger == 0.0, 0.0, -H[one] / larger)
    root[one] = larger + smaller
    sigma = (root - b) / a
    t = 1.0 / (1.0 + np.maximum(sigma, 0.0))
    # one Newton step on the cubic in t, whose Bernstein coefficients are (a, b, c, d); where it is a step
    s = 1.0 - t
    value = s * (s * (s * a + 3.0 * t * b) + 3.0 * t * t * c) + t * t * t * d
    slope = 3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c))
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        step = value / slope
    near = (np.abs(step) < 1e-3 * t) & (sigma > 0.0)
    return np.where(near, np.minimum(t - np.where(near, step, 0.0), 1.0), t)


def lemma_bound(b0: Float, b1: Float, b2: Float, b3: Float, beta: float | Float = 1.0) -> Float:
    """Return b_min of Lemma 2.3, never below the threshold of :func:`shooting_bound`.

    As printed: the smaller of min max(-3 F_2, -F_3) / (beta t^2) over [0, 1], and of min -F_3 / (beta t^2) where
    F_1 <= 0. Both are attained at t = 1, at the end of the set, or at roots of the cubic of :func:`shooting_bound`.
    """
    b0, b1, b2, b3, beta = np.broadcast_arrays(b0, b1, b2, b3, beta)
    shape = b0.shape
    b0, b1, b2, b3, beta = (np.asarray(b, dtype=np.float64).ravel() for b in (b0, b1, b2, b3, beta))
    # companion matrices of the cubic, one for each
    a, b, c, d = 2.0 * b0, 3.0 * (b0 + b1), 6.0 * b1, 3.0 * b2 - b3
    matrices = np.zeros((len(a), 3, 3))
    matrices[:, 1, 0] = matrices[:, 2, 1] = 1.0
    matrices[:, :, 2] = -np.stack([d / a, c / a, b / a], axis=-1)
    roots = np.linalg.eigvals(matrices)
    real = np.abs(roots.imag) <= 1e-7 * (1.0 + np.abs(roots))
    end = np.maximum(0.0, -b1 / b0)
    sigma = np.column_stack([np.zeros(len(a)), end, np.where(real & (roots.real >= 0.0), roots.real, np.nan)])
    b0, b1, b2, b3 = (b[:, None] for b in (b0, b1, b2, b3))
    quadratic = -3.0 * (b0 * sigma**2 + 2.0 * b1 * sigma + b2)
    cubic = -(b0 * sigma**3 + 3.0 * b1 * sigma**2 + 3.0 * b2 * sigma + b3) / (1.0 + sigma)
    first = np.nanmin(np.maximum(quadratic, cubic), axis=1)
    second = np.nanmin(np.where(sigma >= end[:, None], cubic, np.nan), axis=1)
    lowest: Float = np.minimum(first, second) / beta
    return lowest.reshape(shape)
