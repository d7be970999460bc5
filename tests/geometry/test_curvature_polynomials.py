"""Numerators and denominators against curvature in decimal arithmetic of 60 digits."""

from decimal import Decimal, localcontext

import numpy as np
import pytest
from precise_curvature import DIGITS, Decimals, curvatures, decimal
from random_patches import KINDS, quads, rational, triangles
from test_curvature_bounds import EXTREMES
from test_enclosed_nets import fractions
from test_quotient_bounds import exact_values

from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.curvature_bounds import POWERS, SCALING, patch_bounds
from testbed.geometry.curvature_polynomials import CurvaturePolynomials, curvature_polynomials, numerator_degrees
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Float


def values(forms: CurvaturePolynomials, point: Float) -> list[Decimals]:
    """Numerators of K and H and the square at a point, (P,) each, of the coefficients taken as exact."""
    at = np.broadcast_to(fractions(point), (len(forms.regular), 2))
    with localcontext() as context:
        context.prec = DIGITS
        return [
            np.array([Decimal(value.numerator) / Decimal(value.denominator) for value in exact_values(net, at)])
            for net in (forms.gauss, forms.mean, forms.square)
        ]


def deviations(batch: PatchBatch, point: Float) -> list[tuple[Decimals, Decimals]]:
    """For K and for H: how far a is from f q^p (P,), and how far errors of the coefficients can take it."""
    forms = curvature_polynomials(batch)
    *numerators, square = values(forms, point)
    exact = curvatures(batch, np.broadcast_to(decimal(point), (len(batch), 1, 2)))[..., 0]
    result = []
    with localcontext() as context:
        context.prec = DIGITS
        most = square + decimal(forms.square.error)
        for f, a, net, power, scaling in zip(
            exact, numerators, (forms.gauss, forms.mean), POWERS, SCALING, strict=True
        ):
            # curvature of the patches as they were scaled
            f_scaled = f * np.array([Decimal(2) ** int(-scaling * e) for e in forms.exponent])
            roots = [np.sqrt(q) ** int(2 * power) for q in (square, most)]
            result.append((abs(a - f_scaled * roots[0]), decimal(net.error) + abs(f_scaled) * (roots[1] - roots[0])))
    return result


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("point", lattice(3, 3).tolist())
def test_curvature_is_the_quotient_within_the_errors(kind: str, point: list[float]) -> None:
    batch = KINDS[kind].take(slice(0, 6))
    for deviation, room in deviations(batch, np.array(point)):
        # a power is convex: an error downwards takes it as far to first order, and higher ones are far below
        assert (deviation <= Decimal("1.001") * room).all()


@pytest.mark.parametrize("kind", KINDS)
def test_errors_are_small_beside_the_sizes(kind: str) -> None:
    forms = curvature_polynomials(KINDS[kind])
    for net in (forms.gauss, forms.mean, forms.square):
        assert (net.error <= 1e-12 * net.size).all()
        assert (net.size <= 1e6).all()


@pytest.mark.parametrize(
    "batch", [triangles(3, 5), triangles(2, 5), quads((3, 3), 5), quads((2, 3), 5), rational(2, 3)]
)
def test_degrees_are_those_that_are_stated(batch: PatchBatch) -> None:
    forms = curvature_polynomials(batch)
    if isinstance(batch, BezierTriangles):
        d = batch.degree
        assert forms.gauss.degrees == numerator_degrees(batch) == (6 * d - 8,)
        assert forms.mean.degrees == (5 * d - 6,)
        assert forms.square.degrees == (4 * d - 4,)
    elif isinstance(batch, RationalBezierTriangles):
        d = batch.degree
        assert forms.gauss.degrees == numerator_degrees(batch) == (12 * d - 8,)
        assert forms.mean.degrees == (9 * d - 6,)
        assert forms.square.degrees == (6 * d - 4,)
    else:
        assert isinstance(batch, BezierQuads)
        assert forms.square.degrees == tuple(4 * d - 2 for d in batch.degree)
        assert numerator_degrees(batch) == tuple(6 * d - 4 for d in batch.degree)
        assert all(low <= high for low, high in zip(forms.square.degrees, forms.gauss.degrees, strict=True))
        assert all(low <= high for low, high in zip(forms.square.degrees, forms.mean.degrees, strict=True))


@pytest.mark.parametrize("shift", [1.0, 2.0**20, -(2.0**30)])
def test_a_translation_that_rounds_nothing_changes_no_bit(shift: float) -> None:
    net = np.round(triangles(3, 10).control_points * 2.0**16) / 2.0**16
    here, there = patch_bounds(BezierTriangles(net)), patch_bounds(BezierTriangles(net + shift))
    for name in EXTREMES:
        np.testing.assert_array_equal(getattr(here, name).low, getattr(there, name).low)
        np.testing.assert_array_equal(getattr(here, name).high, getattr(there, name).high)
