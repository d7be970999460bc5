"""Curvature from jets: Gaussian, mean and principal curvatures and the second fundamental form in space.

Signs: curvature is positive where the surface bends away from its normal f_u x f_v (unit sphere with outward normals:
both principal curvatures +1). Turning the normal over changes the sign of all but the Gaussian curvature. Where the
first fundamental form is degenerate (f_u x f_v = 0) everything is NaN.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.jets import Jet
from testbed.geometry.vectors import Float, cross, dot


@dataclass(frozen=True, slots=True)
class Analysis:
    """Normal and curvatures of one jet.

    Attributes
    ----------
    normal
        Unit normals, (..., 3).
    gauss, mean
        Gaussian curvature and mean of the principal curvatures, (...).
    area
        Area element |f_u x f_v|, (...).
    """

    normal: Float
    gauss: Float
    mean: Float
    area: Float


# a singular point is 0/0 and comes out as NaN, as promised; far out of scale, infinities turn to NaN as well
_expected = np.errstate(invalid="ignore", divide="ignore", over="ignore")


def _forms(jet: Jet) -> tuple[Float, Float, tuple[Float, Float, Float]]:
    """Return the unit normal n, the area A = |f_u x f_v|, and L, M, N divided by A.

    Divided before they meet: products of areas leave the range of floats on very small patches.
    """
    n = cross(jet.fu, jet.fv)
    area = np.sqrt(dot(n, n))
    n /= area[..., None]
    scale = -1.0 / area
    return n, area, (dot(jet.fuu, n) * scale, dot(jet.fuv, n) * scale, dot(jet.fvv, n) * scale)


@_expected
def analyse(jet: Jet) -> Analysis:
    """Return unit normal, Gaussian and mean curvature of a jet of order 2, with nothing computed twice.

    K = (L N - M^2) / A^2 and H = (E N - 2 F M + G L) / (2 A^2), A = |f_u x f_v|.
    """
    n, area, (L, M, N) = _forms(jet)
    E, F, G = jet.first_form
    return Analysis(n, L * N - M * M, (E * N - 2.0 * F * M + G * L) / (2.0 * area), area)


@_expected
def gauss(jet: Jet) -> Float:
    """Gaussian curvature, (...)."""
    _, _, (L, M, N) = _forms(jet)
    K: Float = L * N - M * M
    return K


def mean(jet: Jet) -> Float:
    """Mean of the principal curvatures, (...)."""
    return analyse(jet).mean


@_expected
def principal(jet: Jet) -> tuple[Float, Float]:
    """Principal curvatures (k_max, k_min), (...) each.

    From the second form in an orthonormal frame, where the discriminant is a sum of squares: accurate at umbilics,
    where the square root of H^2 - K loses half the digits.
    """
    _, area, (L, M, N) = _forms(jet)
    E, F, _ = jet.first_form
    # frame e1 = f_u / |f_u|, e2 = n x e1: f_v = (F e1 + A e2) / |f_u|
    slope = F / E
    first = L * (area / E)
    mixed = M - slope * L
    second = (N - slope * (2.0 * M - slope * L)) * (E / area)
    middle, radius = 0.5 * (first + second), np.hypot(0.5 * (first - second), mixed)
    return middle + radius, middle - radius


@_expected
def second_form_matrix(jet: Jet) -> Float:
    """Second fundamental form in space: the symmetric W (..., 3, 3) with W n = 0 and II(u, v) = u . W v."""
    n, area, (L, M, N) = _forms(jet)
    # dual basis of the tangent plane: <a, f_u> = 1, <a, f_v> = 0 and the other way round
    a, b = cross(jet.fv, n) / area[..., None], cross(n, jet.fu) / area[..., None]
    L, M, N = ((area * form)[..., None] for form in (L, M, N))
    along_a, along_b = L * a + M * b, M * a + N * b
    W: Float = a[..., :, None] * along_a[..., None, :] + b[..., :, None] * along_b[..., None, :]
    return 0.5 * (W + W.swapaxes(-1, -2))


def invariants(W: Float) -> tuple[Float, Float]:
    """Gaussian curvature and mean of the principal curvatures, (...) each, of second fundamental forms (..., 3, 3).

    W has the principal curvatures and 0 as eigenvalues: H is half its trace, and K the sum of its principal minors.
    """
    trace = np.trace(W, axis1=-2, axis2=-1)
    minors = (W[..., i, i] * W[..., j, j] - W[..., i, j] * W[..., j, i] for i, j in ((0, 1), (1, 2), (2, 0)))
    gauss: Float = sum(minors, start=np.zeros(W.shape[:-2]))
    return gauss, 0.5 * trace
