"""Gaussian and mean curvature of Bezier patches as quotients of Bernstein polynomials.

With m = S_u x S_v and the unnormalised second form L' = <S_uu, m>, M' = <S_uv, m>, N' = <S_vv, m>,

    K = (L' N' - M'^2) / (m.m)^2,        H = -(E N' - 2 F M' + G L') / (2 (m.m)^(3/2)),

so both are a polynomial over a power of one polynomial q = m.m. On a rational patch S = A / w with w > 0, put

    T_u = A_u w - A w_u = w^2 S_u,       Q = w A_u x A_v + w_v A x A_u - w_u A x A_v = w^3 m,
    D_uu = <A_uu, Q> - w_uu <A, A_u x A_v> = w^4 L'                                  and so on,

    K = w^4 (D_uu D_vv - D_uv^2) / (Q.Q)^2,
    H = -w (|T_u|^2 D_vv - 2 T_u.T_v D_uv + |T_v|^2 D_uu) / (2 (Q.Q)^(3/2)),

again over a power of one polynomial. D_uu is the determinant of (A, w), its first derivatives and the second one, which
is of degree 4 d - 4. The formulas are the classical ones; signs are those of :mod:`testbed.geometry.curvature`.

Degrees of numerator of K, of H, and of q: 6 d - 8, 5 d - 6, 4 d - 4 on a polynomial triangle of degree d >= 2, twelve,
nine and six times d less 8, 6 and 4 on a rational one.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.bernstein import raised
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.enclosed_nets import TINY, UNIT, Degrees, EnclosedNets, cross, dot, largest, multiply, scale
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Bool, Float

#: Kinds of patches that curvature is known of as such a quotient.
KINDS = (BezierTriangles, RationalBezierTriangles, BezierQuads)


@dataclass(frozen=True, eq=False)
class CurvaturePolynomials:
    """Curvatures of P patches as quotients of polynomials.

    Parameters
    ----------
    gauss, mean
        Numerators of K and of H, scalars.
    square
        q, the square of the area element, of degree no higher than the numerators'.
    exponent
        (P,) the patches were multiplied by 2 to these powers, so that K is the quotient times 2 to the power of
        2 ``exponent``, and H times 2 to the power of ``exponent``.
    regular
        (P,) false where the formulas do not hold: not finite, or weights that are not positive.
    """

    gauss: EnclosedNets
    mean: EnclosedNets
    square: EnclosedNets
    exponent: Float
    regular: Bool


def curvature_polynomials(batch: PatchBatch) -> CurvaturePolynomials:
    """Return the polynomials of Bezier patches.

    Raises
    ------
    TypeError
        The patches are of another kind.
    """
    if isinstance(batch, BezierTriangles):
        return _polynomial(batch.control_points.transpose(2, 1, 0), (batch.degree,))
    if isinstance(batch, BezierQuads):
        return _polynomial(_rows(batch.control_points), batch.degree)
    if isinstance(batch, RationalBezierTriangles):
        return _rational(batch)
    raise _not_polynomial(batch)


def numerator_degrees(batch: PatchBatch) -> Degrees:
    """Degree of the numerator of K on patches of degree 2 or more; lower ones have at most as many coefficients.

    Raises
    ------
    TypeError
        The patches are of another kind.
    """
    if isinstance(batch, BezierTriangles):
        return (max(6 * batch.degree - 8, 0),)
    if isinstance(batch, BezierQuads):
        m, n = batch.degree
        return max(6 * m - 4, 0), max(6 * n - 4, 0)
    if isinstance(batch, RationalBezierTriangles):
        return (max(12 * batch.degree - 8, 6),)
    raise _not_polynomial(batch)


def _not_polynomial(batch: PatchBatch) -> TypeError:
    return TypeError(f"patches of kind {batch.kind} are no polynomials: certify Bezier patches only")


def _rows(control_points: Float) -> Float:
    """Control points (P, m + 1, n + 1, 3) row by row, (3, (m + 1) (n + 1), P)."""
    patches, rows, columns, _ = control_points.shape
    return control_points.reshape(patches, rows * columns, 3).transpose(2, 1, 0)


def _differences(points: Float, degrees: Degrees) -> tuple[Float, Float, Degrees, Degrees]:
    """Derivatives along u and v of coefficients (..., n, P), up to rounding; constants have the derivative 0."""
    if len(degrees) == 1:
        (d,) = degrees
        if d == 0:
            return np.zeros_like(points), np.zeros_like(points), degrees, degrees
        first, second, third = raised(d - 1)
        corner = points[..., first, :]
        return d * (points[..., second, :] - corner), d * (points[..., third, :] - corner), (d - 1,), (d - 1,)
    m, n = degrees
    *before, _, patches = points.shape
    table = points.reshape(*before, m + 1, n + 1, patches)
    along_u = m * np.diff(table, axis=-3) if m else np.zeros_like(table)
    along_v = n * np.diff(table, axis=-2) if n else np.zeros_like(table)
    of_u, of_v = (max(m - 1, 0), n), (m, max(n - 1, 0))
    return (
        along_u.reshape(*before, (of_u[0] + 1) * (n + 1), patches),
        along_v.reshape(*before, (m + 1) * (of_v[1] + 1), patches),
        of_u,
        of_v,
    )


@dataclass(frozen=True, eq=False)
class _Derivatives:
    """First and second derivatives along u and v."""

    u: EnclosedNets
    v: EnclosedNets
    uu: EnclosedNets
    uv: EnclosedNets
    vv: EnclosedNets


def _derivatives(points: Float, degrees: Degrees, error: Float) -> _Derivatives:
    """Derivatives of coefficients that are within ``error`` (P,) of the exact ones.

    A difference of two floats has one rounding, so the first derivatives of exact coefficients are right to two
    roundings of their own length wherever the patch lies.
    """
    u, v, of_u, of_v = _differences(points, degrees)
    highest = max(*degrees, 1)

    def bound(values: Float, before: Float) -> Float:
        # differences double the error there was before, and the degree multiplies it
        enlarged: Float = 2.0 * highest * before + 5.0 * UNIT * largest(values) + TINY
        return enlarged

    error_u, error_v = bound(u, error), bound(v, error)
    uu, uv, of_uu, of_uv = _differences(u, of_u)
    _, vv, _, of_vv = _differences(v, of_v)
    # what is constant has the derivative 0, and exactly
    constant = np.zeros_like(error)
    return _Derivatives(
        EnclosedNets.of_coefficients(u, of_u, error_u),
        EnclosedNets.of_coefficients(v, of_v, error_v),
        EnclosedNets.of_coefficients(uu, of_uu, bound(uu, error_u) if of_u[0] else constant),
        EnclosedNets.of_coefficients(uv, of_uv, bound(uv, error_u) if of_u[-1] else constant),
        EnclosedNets.of_coefficients(vv, of_vv, bound(vv, error_v) if of_v[-1] else constant),
    )


def _to_unit_size(points: Float, degrees: Degrees) -> tuple[Float, Float, Bool]:
    """Scale coefficients (3, n, P) by powers of two that bring the largest first derivative near 1.

    Without rounding, but for underflow of coordinates that do not count. Returns the coefficients, the exponents (P,)
    of the factors, and where all of that is finite; elsewhere the coefficients are 0.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        u, v, *_ = _differences(points, degrees)
        most = np.maximum(np.abs(u).max(axis=(0, 1)), np.abs(v).max(axis=(0, 1)))
    regular = np.isfinite(most) & np.isfinite(points).all(axis=(0, 1))
    exponent = -np.frexp(np.where(regular, most, 1.0))[1].astype(np.float64)
    with np.errstate(under="ignore", over="ignore"):
        points = np.ldexp(np.where(regular, points, 0.0), exponent.astype(np.intc))
    regular &= np.isfinite(points).all(axis=(0, 1))
    return np.where(regular, points, 0.0), exponent, regular


def _polynomial(points: Float, degrees: Degrees) -> CurvaturePolynomials:
    points, exponent, regular = _to_unit_size(np.ascontiguousarray(points), degrees)
    S = _derivatives(points, degrees, np.zeros(points.shape[-1]))
    m = cross(S.u, S.v)
    L, M, N = dot(S.uu, m), dot(S.uv, m), dot(S.vv, m)
    E, F, G = dot(S.u, S.u), dot(S.u, S.v), dot(S.v, S.v)
    gauss = multiply(L, N) - multiply(M, M)
    mean = multiply(F, M) - (multiply(E, N) + multiply(G, L)).halved()
    return CurvaturePolynomials(gauss, mean, dot(m, m), exponent, regular)


def _rational(batch: RationalBezierTriangles) -> CurvaturePolynomials:
    degrees = (batch.degree,)
    points, weight = (
        np.ascontiguousarray(batch.control_points.transpose(2, 1, 0)),
        np.ascontiguousarray(batch.weights.T),
    )
    with np.errstate(over="ignore", invalid="ignore"):
        # the place of a patch does not count, and near the origin its products are rounded least
        points = points - points[:, :1]
    points, exponent, regular = _to_unit_size(points, degrees)
    regular &= ((weight > 0.0) & np.isfinite(weight)).all(axis=0)
    weight = np.where(regular, weight, 1.0)
    weight = np.ldexp(weight, -np.frexp(weight.max(axis=0))[1])
    product = weight * points
    # two roundings: of the translated point and of the product
    error, exact = 3.0 * UNIT * largest(product) + TINY, np.zeros(len(batch))
    of_A, of_w = _derivatives(product, degrees, error), _derivatives(weight, degrees, exact)
    A = EnclosedNets.of_coefficients(product, degrees, error)
    w = EnclosedNets.of_coefficients(weight, degrees, exact)
    u_cross_v = cross(of_A.u, of_A.v)
    Q = scale(w, u_cross_v) + scale(of_w.v, cross(A, of_A.u)) - scale(of_w.u, cross(A, of_A.v))
    volume = dot(A, u_cross_v)
    L, M, N = (
        dot(second, Q) - multiply(of_weight, volume)
        for second, of_weight in ((of_A.uu, of_w.uu), (of_A.uv, of_w.uv), (of_A.vv, of_w.vv))
    )
    T_u, T_v = (scale(w, a) - scale(b, A) for a, b in ((of_A.u, of_w.u), (of_A.v, of_w.v)))
    second_power = multiply(w, w)
    gauss = multiply(multiply(second_power, second_power), multiply(L, N) - multiply(M, M))
    E, F, G = dot(T_u, T_u), dot(T_u, T_v), dot(T_v, T_v)
    mean = multiply(w, multiply(F, M) - (multiply(E, N) + multiply(G, L)).halved())
    return CurvaturePolynomials(gauss, mean, dot(Q, Q), exponent, regular)
