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

from testbed.geometry.cubic_roots import first_roots
from testbed.geometry.vectors import Float

_NEAREST = 1e-140


def shooting_bound(b0: Float, b1: Float, b2: Float, b3: Float, beta: float | Float = 1.0) -> Float:
    """Return the exact threshold b* above which the smallest root of sum b_s B_s^3(t) + beta t^2 b is simple.

    Parameters
    ----------
    b0, b1, b2, b3
        (...) Bernstein coefficients without the free coefficient's part, b0 < 0. All broadcast.
    beta
        (...) positive factor.

    Returns
    -------
    Float
        (...): h(sigma*) / beta with sigma* the largest positive root of h', or -b3 / beta if there is none. For
        b0 -> 0 it tends to -inf if b1 > 0. NaN where b0 < 0 or beta > 0 does not hold.

    Notes
    -----
    The numerator of h' is 2 b0 sigma^3 + 3 (b0 + b1) sigma^2 + 6 b1 sigma + 3 b2 - b3: in t, a cubic with the
    Bernstein coefficients 2 b0, b0 + b1, 2 b1, 3 b2 - b3, which starts below zero.
    """
    with np.errstate(
        invalid="ignore", over="ignore", divide="ignore"
    ):  # coefficients that are not finite, for the caller to find
        t = first_roots(np.stack(np.broadcast_arrays(2.0 * b0, b0 + b1, 2.0 * b1, 3.0 * b2 - b3), axis=-1))
        t = np.where(np.isnan(t), 1.0, t)
        s = 1.0 - t
        beta = np.asarray(beta, dtype=np.float64)
        valid = (b0 < 0.0) & (beta > 0.0)
        height = -(s * (s * (s * b0 + 3.0 * t * b1) + 3.0 * t * t * b2) + t * t * t * b3)
        # nearer to the start than squares can tell, h is below everything
        bound = np.where(t > _NEAREST, height / np.where(t > _NEAREST, beta * (t * t), 1.0), -np.inf)
    return np.where(valid, bound, np.nan)
