"""Cubics with rational terms on tetrahedra: the functions whose zero sets are A-patches, with two derivatives.

On a tetrahedron with barycentric coordinates alpha, F is a cubic in Bernstein form plus a quotient of two homogeneous
polynomials of a degree that differs by three (Xu, Huang and Bajaj 2001, equations 4.1 to 4.4):

    on a face, base corners 0, 1, 2:  6 a0 a1 a2 (c0 a1 a2 + c1 a2 a0 + c2 a0 a1) / (a1 a2 + a2 a0 + a0 a1)
    on an edge, from corner 1 to 2:   6 a0 a3 (a1 (c0 a0 + c1 a3) + a2 (c2 a0 + c3 a3)) / (a0 + a3)

Where a denominator vanishes, on lines, the quotient and its gradient tend to zero, and its second derivatives have no
limit. Everything here is written in monomials and the rules for quotients, and shares nothing with the shooting of
rays: either can check the other.
"""

import math
from dataclasses import dataclass

import numpy as np

from testbed.geometry.simplex_bernstein import simplex_multi_indices
from testbed.geometry.vectors import Bool, Float, Int, cross, dot, norm, stack_components

#: Two base coordinates of a face below this make its denominator zero: rounding may give it either sign.
SINGULAR = 1e-12
UNIT = np.eye(4, dtype=np.int64)


@dataclass(frozen=True)
class QuotientTerm:
    """The quotient of two homogeneous polynomials in barycentric coordinates; exponents (terms, 4) of either."""

    numerator: tuple[tuple[int, int, int, int], ...]
    denominator: tuple[tuple[int, int, int, int], ...]


#: Of a face; three coefficients, the first belongs to the edge between corners 1 and 2.
FACE_TERM = QuotientTerm(
    numerator=((1, 2, 2, 0), (2, 1, 2, 0), (2, 2, 1, 0)), denominator=((0, 1, 1, 0), (1, 0, 1, 0), (1, 1, 0, 0))
)
#: Of an edge; the coefficients are a_1101, b_1101, a_1011, b_1011 of equation 4.3.
EDGE_TERM = QuotientTerm(
    numerator=((2, 1, 0, 1), (1, 1, 0, 2), (2, 0, 1, 1), (1, 0, 1, 2)), denominator=((1, 0, 0, 0), (0, 0, 0, 1))
)


@dataclass(frozen=True)
class Expansion:
    """Values (N,), gradients (4, N) and Hessians (4, 4, N) in barycentric coordinates, taken as independent."""

    value: Float
    gradient: Float
    hessian: Float


def polynomial(exponents: Int, coefficients: Float, alpha: Float) -> Expansion:
    """Expand sums of monomials: exponents (T, 4), coefficients (T, N) or (T, 1), at coordinates (4, N)."""
    powers = np.ones((int(exponents.max(initial=0)) + 1, *alpha.shape))
    for e in range(1, len(powers)):
        powers[e] = powers[e - 1] * alpha
    count = alpha.shape[1]
    value, gradient, hessian = np.zeros(count), np.zeros((4, count)), np.zeros((4, 4, count))
    for row, coefficient in zip(exponents, coefficients, strict=True):
        value += coefficient * monomial(row, powers)
        for i in np.flatnonzero(row):
            once = row - UNIT[i]
            gradient[i] += row[i] * coefficient * monomial(once, powers)
            for j in np.flatnonzero(once):
                hessian[i, j] += row[i] * once[j] * coefficient * monomial(once - UNIT[j], powers)
    return Expansion(value, gradient, hessian)


def monomial(exponents: Int, powers: Float) -> Float:
    """Products (N,) of coordinates with exponents (4,), from their powers (degrees, 4, N)."""
    result: Float = powers[exponents[0], 0]
    for axis in range(1, 4):
        result = result * powers[exponents[axis], axis]
    return result


def cubic(nets: Float, alpha: Float) -> Expansion:
    """Expand cubics with Bernstein coefficients (20, N) at barycentric coordinates (4, N)."""
    exponents = simplex_multi_indices(4, 3)
    factors = np.array([6 / math.prod(math.factorial(e) for e in row) for row in exponents.tolist()])
    return polynomial(exponents, factors[:, None] * nets, alpha)


def is_singular(term: QuotientTerm, alpha: Float) -> Bool:
    """(N,) true where the denominator of a term is zero to rounding, at barycentric coordinates (4, N)."""
    if term is FACE_TERM:
        below: Bool = (np.abs(alpha[:3]) < SINGULAR).sum(axis=0) >= 2
        return below
    zero: Bool = np.abs(alpha[0]) + np.abs(alpha[3]) == 0.0
    return zero


def quotient(term: QuotientTerm, coefficients: Float, alpha: Float) -> Expansion:
    """Expand 6 times a term with coefficients (3 | 4, N) at barycentric coordinates (4, N).

    From P = R D follow R' = (P' - R D') / D and R'' = (P'' - R' D' - D' R' - R D'') / D. Where D is zero to rounding,
    value and gradient are zero and second derivatives NaN, unless all coefficients are zero.
    """
    singular = is_singular(term, alpha)
    # somewhere else instead, so that nothing divides by zero
    safe = np.where(singular, 0.25, alpha)
    above = polynomial(np.array(term.numerator), 6.0 * coefficients, safe)
    below = polynomial(np.array(term.denominator), np.ones((len(term.denominator), 1)), safe)
    value = above.value / below.value
    gradient = (above.gradient - value * below.gradient) / below.value
    mixed = gradient[:, None] * below.gradient
    hessian = (above.hessian - mixed - mixed.swapaxes(0, 1) - value * below.hessian) / below.value
    undefined = np.where((coefficients == 0.0).all(axis=0), 0.0, np.nan)
    return Expansion(
        np.where(singular, 0.0, value),
        np.where(singular, 0.0, gradient),
        np.where(singular, undefined, hessian),
    )


def rational_cubic(nets: Float, term: QuotientTerm, coefficients: Float, alpha: Float) -> Expansion:
    """Expand a cubic (20, N) and its rational term together, at barycentric coordinates (4, N)."""
    first, second = cubic(nets, alpha), quotient(term, coefficients, alpha)
    return Expansion(first.value + second.value, first.gradient + second.gradient, first.hessian + second.hessian)


def coordinate_gradients(corners: Float) -> Float:
    """Gradients (4, N, 3) in space of the barycentric coordinates of tetrahedra with corners (N, 4, 3)."""
    apex = corners[:, 3]
    legs = [corners[:, i] - apex for i in range(3)]
    normals = [cross(legs[1], legs[2]), cross(legs[2], legs[0]), cross(legs[0], legs[1])]
    volume = dot(legs[0], normals[0])[:, None]
    first, second, third = (normal / volume for normal in normals)
    return np.stack([first, second, third, -(first + second + third)])


def in_space(expansion: Expansion, corners: Float) -> tuple[Float, Float]:
    """Gradients (N, 3) and Hessians (N, 3, 3) in space from those in barycentric coordinates."""
    directions = coordinate_gradients(corners)
    gradient = sum((expansion.gradient[i, :, None] * directions[i] for i in range(4)), start=np.zeros(1))
    hessian = np.zeros((corners.shape[0], 3, 3))
    for i in range(4):
        for j in range(4):
            outer = directions[i][:, :, None] * directions[j][:, None, :]
            hessian += expansion.hessian[i, j][:, None, None] * outer
    return gradient, hessian


def implicit_curvatures(gradient: Float, hessian: Float) -> tuple[Float, Float]:
    """Gaussian curvature and mean of the principal curvatures of level sets, (N,) each.

    With g the gradient (N, 3), along the outward normal, and A the Hessian (N, 3, 3): K = g . adj(A) g / |g|^4 and
    H = (|g|^2 tr A - g . A g) / (2 |g|^3), positive on a sphere.
    """
    length = norm(gradient)
    n = gradient / length[:, None]
    rows = [hessian[:, i] for i in range(3)]
    adjugate = (cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]))
    gauss = sum((n[:, i] * dot(adjugate[i], n) for i in range(3)), start=np.zeros(1)) / (length * length)
    trace = hessian[:, 0, 0] + hessian[:, 1, 1] + hessian[:, 2, 2]
    along = dot(n, stack_components(*(dot(row, n) for row in rows)))
    return gauss, 0.5 * (trace - along) / length
