"""Two quartic Bezier triangles that meet G1, with linear coefficients in the condition (Si 2015, section 3.2).

Along the common boundary, with control points c_0 ... c_4, stand the second rows p_0 ... p_3 of the patch on the left
and q_0 ... q_3 of the patch on the right. The cross-boundary derivatives D1, D2 along (1, -1, 0) and the derivative D3
along the boundary are

    D1 = 4 sum (p_k - c_k) B_k^3,   D2 = 4 sum (q_k - c_k) B_k^3,   D3 = 4 sum (c_{k+1} - c_k) B_k^3,

and the patches share their tangent planes where

    alpha(t) D1(t) + beta(t) D2(t) + gamma(t) D3(t) = 0.   (3.1)

All three coefficients are linear in t (3.2). At both ends the control points lie in a plane and decide the coefficients
up to a factor. Here alpha + beta = 1 at either end, and the coefficients at t = 1 are multiplied by kappa > 0, which is
free: it is 1 / kappa for the reversed edge. What (3.1) asks for in between, with eps and g the changes of alpha and
gamma, D_k = c_{k+1} - c_k, W0 = p_0 - q_0 and W3 = p_3 - q_3, is

    alpha0 p_1 + beta0 q_1 = R1 = c_1 - gamma0 D_1 - (kappa / 3) (eps W0 + g D_0)
    alpha1 p_2 + beta1 q_2 = R3 = c_2 - gamma1 D_2 + (eps W3 + g D_3) / (3 kappa)
    eps [W3 - 3 kappa w2 + 3 kappa^2 w1 - kappa^3 W0] + g [D_3 - 3 kappa D_2 + 3 kappa^2 D_1 - kappa^3 D_0] = 0

with w1 = p_1 - q_1 and w2 = p_2 - q_2. Where alpha is constant and gamma is not, the boundary has to make the second
bracket zero: for kappa = 1 it is a raised cubic, for another kappa a quartic with another c_2. Here both brackets are
zero, which is never ill-conditioned; one vector w1 an edge stays free.

Formulas: corrected. The printed (3.2) has alpha_0 in place of gamma_0. That linear coefficients decide the boundary is
not said in the available text; kappa, the family with both brackets zero and the choice of w1 are fills.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.geometry.vectors import Bool, Float, cross, dot


@dataclass(frozen=True, eq=False)
class SharedEdge:
    """What is given along E edges: the common boundary and the second rows' first and last points.

    Parameters
    ----------
    c
        (E, 5, 3) quartic control points of the common boundary; c_2 as :func:`boundary` makes it.
    p0, p3
        (E, 3) second row of the patch on the left at both ends, in the tangent planes there.
    q0, q3
        (E, 3) that of the patch on the right.
    kappa
        (E,) the relative factor of the coefficients at t = 1; positive.
    n0, n1
        (E, 3) unit normals at both ends.
    """

    c: Float
    p0: Float
    p3: Float
    q0: Float
    q3: Float
    kappa: Float
    n0: Float
    n1: Float


@dataclass(frozen=True, eq=False)
class LinearG1:
    """Coefficients of the condition and what it makes of the boundary.

    Parameters
    ----------
    alpha, beta, gamma
        (E, 2) at both ends, alpha + beta = 1, those at t = 1 without the factor kappa.
    R1, R3
        (E, 3) the means of the second rows that the condition asks for.
    R4
        (E, 3) w2 - kappa w1 = W3 / (3 kappa) - kappa^2 W0 / 3.
    """

    alpha: Float
    beta: Float
    gamma: Float
    R1: Float
    R3: Float
    R4: Float

    @cached_property
    def opposed(self) -> Bool:
        """(E, 2) true at ends where the patches lie on the same side of the edge: they would make a ridge."""
        with np.errstate(invalid="ignore"):  # NaN and infinite coefficients are opposed
            overlapping: Bool = ~(self.alpha * self.beta > 0.0)
        return overlapping


def end_coefficients(left: Float, right: Float, along: Float, normal: Float) -> tuple[Float, Float, Float]:
    """Return alpha, beta, gamma (...) with alpha left + beta right + gamma along = 0 and alpha + beta = 1.

    Parameters
    ----------
    left, right, along
        (..., 3) vectors in the plane perpendicular to ``normal``, ``left`` and ``right`` on different sides of
        ``along``; otherwise alpha and beta have different signs, and they are NaN or infinite where both are as far
        from the line.
    normal
        (..., 3) unit vectors.
    """
    on_left, on_right = dot(cross(left, along), normal), dot(cross(right, along), normal)
    with np.errstate(divide="ignore", invalid="ignore"):  # the doc says so
        alpha, beta = on_right / (on_right - on_left), on_left / (on_left - on_right)
        mean = alpha[..., None] * left + beta[..., None] * right
        return alpha, beta, -dot(mean, along) / dot(along, along)


def boundary(c0: Float, c1: Float, c3: Float, c4: Float, kappa: Float) -> Float:
    """Return c_2 (E, 3) of boundaries that admit linear coefficients, from the others (E, 3) and kappa (E,).

    For kappa = 1 that of the raised cubic.
    """
    k = kappa[..., None]
    # in legs from both ends: bit by bit the same for the reversed edge if kappa = 1
    first, last = c1 + k * (c1 - c0) / 3.0, c3 + (c3 - c4) / (3.0 * k)
    weight = 1.0 + k
    return (k * first + last) / weight


def linear_g1(edge: SharedEdge) -> LinearG1:
    """Return the coefficients at both ends and the right sides of the condition."""
    c, kappa = edge.c, edge.kappa[:, None]
    legs = np.diff(c, axis=1)
    ends = [
        end_coefficients(left - corner, right - corner, along, normal)
        for left, right, corner, along, normal in (
            (edge.p0, edge.q0, c[:, 0], legs[:, 0], edge.n0),
            (edge.p3, edge.q3, c[:, 3], legs[:, 3], edge.n1),
        )
    ]
    alpha, beta, gamma = (np.stack(pair, axis=-1) for pair in zip(*ends, strict=True))
    turn, change = (alpha[:, 1] - alpha[:, 0])[:, None], (gamma[:, 1] - gamma[:, 0])[:, None]
    W0, W3 = edge.p0 - edge.q0, edge.p3 - edge.q3
    R1 = c[:, 1] - gamma[:, :1] * legs[:, 1] - kappa / 3.0 * (turn * W0 + change * legs[:, 0])
    R3 = c[:, 2] - gamma[:, 1:] * legs[:, 2] + (turn * W3 + change * legs[:, 3]) / (3.0 * kappa)
    return LinearG1(alpha, beta, gamma, R1, R3, W3 / (3.0 * kappa) - kappa**2 * W0 / 3.0)


def parallel_row(c: Float, first: Float, last: Float) -> tuple[Float, Float]:
    """Return the two inner points (E, 3) of a second row whose cross-boundary derivative is linear.

    The derivative is that along (1, -1/2, -1/2), the same from both ends: the reversed edge has the reversed row. In
    general this meets no condition.

    Parameters
    ----------
    c
        (E, 5, 3) the boundary.
    first, last
        (E, 3) the row's first and last point.
    """
    middles = 0.5 * (c[:, :-1] + c[:, 1:])
    start, end = first - middles[:, 0], last - middles[:, 3]
    return middles[:, 1] + (2.0 * start + end) / 3.0, middles[:, 2] + (start + 2.0 * end) / 3.0


def free_vector(edge: SharedEdge, g1: LinearG1) -> Float:
    """Return w1 (E, 3) that brings the second rows nearest to :func:`parallel_row`, in the sum of squares."""
    (p1, p2), (q1, q2) = parallel_row(edge.c, edge.p0, edge.p3), parallel_row(edge.c, edge.q0, edge.q3)
    kappa, alpha, beta = edge.kappa, g1.alpha, g1.beta
    slopes = (beta[:, 0], -alpha[:, 0], kappa * beta[:, 1], -kappa * alpha[:, 1])
    left, right = g1.R3 + beta[:, 1:] * g1.R4, g1.R3 - alpha[:, 1:] * g1.R4
    off = (p1 - g1.R1, q1 - g1.R1, p2 - left, q2 - right)
    weighted = [slope[:, None] * vector for slope, vector in zip(slopes, off, strict=True)]
    squares = sum(slope * slope for slope in slopes)
    total = weighted[0] + weighted[1] + weighted[2] + weighted[3]
    nearest: Float = total / np.asarray(squares)[:, None]
    return nearest


def first_rows(edge: SharedEdge, g1: LinearG1, w1: Float) -> tuple[Float, Float, Float, Float]:
    """Return p1, p2, q1, q2 (E, 3) that meet the condition, from w1 (E, 3)."""
    w2 = edge.kappa[:, None] * w1 + g1.R4
    (alpha0, alpha1), (beta0, beta1) = ((pair[:, :1], pair[:, 1:]) for pair in (g1.alpha, g1.beta))
    return g1.R1 + beta0 * w1, g1.R3 + beta1 * w2, g1.R1 - alpha0 * w1, g1.R3 - alpha1 * w2
