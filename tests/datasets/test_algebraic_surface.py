"""Algebraic surfaces as exact surfaces: closed forms, the blossom's second form, feet, bounds of the curvature."""

import itertools
import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.geometry.vectors import Float, norm, tangential, unit
from testbed_datasets.algebraic_surface import AlgebraicSurface
from testbed_datasets.polynomial import Evaluated, Polynomial
from testbed_datasets.polynomial_text import parse_polynomial
from testbed_datasets.quadric import Quadric
from testbed_datasets.sphere import RoundSphere
from testbed_datasets.torus import RoundTorus

ELLIPSOID = "4*x**2+2*y**2+z**2-4"
TORUS = "(x^2+y^2+z^2+3/4)^2-4*(x^2+y^2)"  # radii 1 and 1/2
#: A closed quartic of genus 5 with all signs of curvature.
QUARTIC = "x^4+y^4+z^4-4*(x^2+y^2+z^2)+5.5"
CUBIC = "y^2-x^2*(x+1)+z"


@cache
def surface_of(text: str, box: float = 3.0) -> AlgebraicSurface:
    low, high = (-box, -box, -box), (box, box, box)
    return AlgebraicSurface(Evaluated.over(parse_polynomial(text), low, high), low, high)


def random_points(text: str, count: int = 2000) -> Float:
    samples = surface_of(text).samples
    return samples[np.random.default_rng(5).integers(len(samples), size=count)]


def blossom(polynomial: Polynomial, arguments: list[tuple[Fraction, ...]]) -> Fraction:
    """Polar form of a polynomial of degree n at n points (weight 1) and vectors (weight 0), by polarisation."""
    n = len(arguments)

    def homogeneous(x: Fraction, y: Fraction, z: Fraction, w: Fraction) -> Fraction:
        return sum((c * x**i * y**j * z**k * w ** (n - i - j - k) for (i, j, k), c in polynomial.terms), Fraction(0))

    total = Fraction(0)
    for size in range(n + 1):
        for chosen in itertools.combinations(arguments, size):
            x, y, z, w = (sum((one[row] for one in chosen), Fraction(0)) for row in range(4))
            total += (-1) ** (n - size) * homogeneous(x, y, z, w)
    return total / math.factorial(n)


@pytest.mark.parametrize("text", [ELLIPSOID, CUBIC, TORUS, QUARTIC])
def test_forms_are_those_of_the_blossom(text: str) -> None:
    # Schweitzer and DeRose, as printed in 5.4.1, in exact arithmetic
    polynomial, surface = parse_polynomial(text), surface_of(text)
    n = polynomial.degree
    axes = [tuple(Fraction(int(row == axis)) for row in range(4)) for axis in range(3)]
    points = random_points(text, 5)
    for point, normal, W in zip(points.tolist(), surface.normal(points), surface.second_form(points), strict=True):
        p = (*(Fraction(value) for value in point), Fraction(1))
        g = np.array([float(blossom(polynomial, [axis] + [p] * (n - 1))) for axis in axes])
        assert np.abs(normal - g / np.linalg.norm(g)).max() < 1e-13
        second = np.array([[float(blossom(polynomial, [a, b] + [p] * (n - 2))) for a in axes] for b in axes])
        tangent = np.eye(3) - np.outer(normal, normal)
        expected = tangent @ ((n - 1) * second / np.linalg.norm(g)) @ tangent
        assert np.abs(W - expected).max() < 1e-11 * (1.0 + np.abs(expected).max())


def test_ellipsoid_curvature_in_closed_form() -> None:
    squares = np.array([1.0, 2.0, 4.0])
    points = random_points(ELLIPSOID)
    expected = np.prod(1.0 / squares) / np.sum(points**2 / squares**2, axis=1) ** 2
    k1, k2 = principal_curvatures_of(surface_of(ELLIPSOID), points)
    assert np.abs(k1 * k2 - expected).max() < 1e-13


def principal_curvatures_of(surface: AlgebraicSurface, points: Float) -> tuple[Float, Float]:
    W = surface.second_form(points)
    mean = 0.5 * np.trace(W, axis1=-2, axis2=-1)
    gauss = 2.0 * mean**2 - 0.5 * np.einsum("nij,nji->n", W, W)
    root = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
    return mean - root, mean + root


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        (ELLIPSOID, Quadric((1.0, 2.0**0.5, 2.0))),
        (TORUS, RoundTorus(1.0, 0.5)),
        ("x^2+y^2+z^2-4", RoundSphere(2.0)),
        ("x^2/4+y^2-z^2/9-1", Quadric((2.0, 1.0, 3.0), (1, 1, -1))),
    ],
)
def test_forms_and_feet_are_those_of_the_closed_forms(text: str, exact: Quadric | RoundTorus | RoundSphere) -> None:
    surface, points = surface_of(text), random_points(text)
    assert np.abs(surface.normal(points) - exact.normal(points)).max() < 1e-14
    assert np.abs(surface.second_form(points) - exact.second_form(points)).max() < 1e-13
    random = np.random.default_rng(1)
    for distance in (0.0, 1e-9, 1e-3, 0.05, 0.3, 2.0):
        near = points + distance * random.uniform(-1.0, 1.0, points.shape)
        feet = surface.closest(near)
        assert np.isfinite(feet).all()
        assert (norm(feet - near) - norm(exact.closest(near) - near)).max() < 1e-12
        if distance < 0.1:
            assert norm(feet - exact.closest(near)).max() < 1e-14


@pytest.mark.parametrize("text", [ELLIPSOID, TORUS, QUARTIC, CUBIC, "z-x*y", "x^2+y^2-z^2-1", "x^5+y^5+z^5-x*y*z-1"])
def test_feet_are_on_the_surface_and_the_way_is_along_the_normal(text: str) -> None:
    surface, points = surface_of(text), random_points(text)
    near = points + 0.1 * np.random.default_rng(2).uniform(-1.0, 1.0, points.shape)
    feet = surface.closest(near)
    assert np.isfinite(feet).all()
    residual = np.abs(surface.evaluated.values(feet)) / norm(surface.gradient(feet))
    assert residual.max() < 1e-14
    assert norm(tangential(near - feet, surface.normal(feet))).max() < 1e-12
    assert norm(surface.closest(feet) - feet).max() < 1e-14
    # no sample is nearer
    nearest = np.array([norm(surface.samples - point).min() for point in near[:200]])
    assert (norm(feet - near)[:200] <= nearest + 1e-14).all()


def test_a_foot_on_the_nearer_of_two_sheets() -> None:
    # the spheres of radii 1 and 2 as one quartic
    surface = surface_of("(x^2+y^2+z^2-1)*(x^2+y^2+z^2-4)")
    direction = unit(np.random.default_rng(0).normal(size=(500, 3)))
    radius = np.linspace(0.05, 2.9, 500)
    feet = surface.closest(radius[:, None] * direction)
    expected = np.where(radius < 1.5, 1.0, 2.0)[:, None] * direction
    assert norm(feet - expected).max() < 1e-14


def test_feet_depend_on_their_point_alone() -> None:
    surface = surface_of(QUARTIC)
    points = random_points(QUARTIC, 5000) + 0.3 * np.random.default_rng(2).uniform(-1.0, 1.0, (5000, 3))
    feet = surface.closest(points)
    some = np.random.default_rng(5).permutation(len(points))[:57]
    assert np.array_equal(surface.closest(points[some]), feet[some], equal_nan=True)
    assert surface.closest(points[:0]).shape == (0, 3)


def test_no_foot_of_what_is_not_a_number_or_very_far() -> None:
    points = np.array([[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], [1e200, 0.0, 0.0], [1.0, 0.0, 0.0]])
    feet = surface_of(ELLIPSOID).closest(points)
    assert np.isnan(feet[:3]).all()
    assert np.array_equal(feet[3], [1.0, 0.0, 0.0])


def test_a_centre_of_symmetry_has_one_of_its_feet() -> None:
    feet = surface_of("x^2+y^2+z^2-1").closest(np.zeros((1, 3)))
    assert norm(feet)[0] == pytest.approx(1.0, abs=1e-14)
    feet = surface_of(ELLIPSOID).closest(np.zeros((1, 3)))
    assert np.abs(np.abs(feet) - [[1.0, 0.0, 0.0]]).max() < 1e-12


@settings(max_examples=25, deadline=None)
@given(st.sampled_from([ELLIPSOID, TORUS, QUARTIC, CUBIC, "z-x*y"]), st.integers(0, 2**32), st.floats(-4.0, 0.0))
def test_curvature_bounds_hold_in_boxes(text: str, seed: int, exponent: float) -> None:
    surface, random = surface_of(text), np.random.default_rng(seed)
    half = 10.0**exponent
    centre = surface.samples[random.integers(len(surface.samples), size=40)] + half * random.uniform(-1.0, 1.0, (40, 3))
    bound = surface.curvature_bound(centre - half, centre + half)
    inside = centre[:, None] + half * random.uniform(-1.0, 1.0, (40, 20, 3))
    feet = surface.projected(inside.reshape(-1, 3))
    row = np.repeat(np.arange(40), 20)
    there = (np.abs(feet - centre[row]) <= half).all(axis=1)
    k1, k2 = principal_curvatures_of(surface, feet[there])
    assert (np.maximum(np.abs(k1), np.abs(k2)) <= bound[row[there]]).all()


def test_curvature_bounds_are_sharp_in_small_boxes_and_zero_without_surface() -> None:
    for text in (ELLIPSOID, TORUS, QUARTIC):
        surface, points = surface_of(text), random_points(text, 200)
        k1, k2 = principal_curvatures_of(surface, points)
        frobenius = np.hypot(k1, k2)  # what the bound tends to
        bound = surface.curvature_bound(points - 1e-5, points + 1e-5)
        assert (bound >= np.maximum(np.abs(k1), np.abs(k2))).all()
        assert (bound <= 1.01 * frobenius + 1e-3).all()
    centre = np.zeros((1, 3))
    assert surface_of(ELLIPSOID).curvature_bound(centre - 0.1, centre + 0.1)[0] == 0.0
    assert surface_of("x^2+y^2-z^2-1e-9").curvature_bound(centre - 0.1, centre + 0.1)[0] == np.inf


def test_middles_of_boundary_edges_stay_on_the_side_of_the_box() -> None:
    surface = surface_of("x^2+y^2-z^2-1")
    angle = np.linspace(0.0, 0.7, 8)
    ring = np.stack([np.sqrt(10.0) * np.cos(angle), np.sqrt(10.0) * np.sin(angle), np.full(8, 3.0)], axis=-1)
    start, end = ring[:-1], ring[1:]
    along = surface.middles(start, end, np.ones(7, dtype=np.bool_))
    assert np.array_equal(along[:, 2], np.full(7, 3.0))
    assert np.abs(norm(along[:, :2]) - np.sqrt(10.0)).max() < 1e-14
    across = surface.middles(start, end, np.zeros(7, dtype=np.bool_))
    assert np.abs(across[:, 2] - 3.0).min() > 1e-4
    assert np.abs(across[:, 0] ** 2 + across[:, 1] ** 2 - across[:, 2] ** 2 - 1.0).max() < 1e-13
