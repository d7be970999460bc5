"""Barycentric coordinates of polygons: sum, linear precision, sides, derivatives by Taylor arithmetic."""

from typing import Any

import numpy as np
import pytest

from testbed.geometry.domain import CORNERS, barycentric
from testbed.geometry.polygon_coordinates import corner_areas, polygon_coordinates, regular_polygon
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Float

#: Convex, no two sides or angles alike.
IRREGULAR = np.array([[1.0, 0.0], [1.1, 0.9], [-0.2, 1.3], [-1.0, 0.3], [-0.6, -0.8]])
POLYGONS = {**{f"regular {n}": regular_polygon(n) for n in range(3, 9)}, "irregular": IRREGULAR}
every_polygon = pytest.mark.parametrize("corners", list(POLYGONS.values()), ids=list(POLYGONS))


def inside(corners: Float, count: int = 60) -> Float:
    """Points of a polygon: inside, and its corners."""
    weights = np.random.default_rng(len(corners)).dirichlet(np.ones(len(corners)), count)
    return np.concatenate([weights @ corners, corners])


@every_polygon
def test_they_sum_to_one_and_reproduce_linear_functions(corners: Float) -> None:
    at = inside(corners)
    coordinates = polygon_coordinates(corners, at)
    scale = np.abs(coordinates).max(axis=(1, 2)).clip(1.0)
    total = coordinates.sum(axis=1)
    assert np.abs(total[0] - 1.0).max() < 4e-16 * len(corners)
    assert (np.abs(total[1:]).max(axis=1) < 1e-14 * scale[1:]).all()
    moments = np.einsum("rns,nx->rsx", coordinates, corners)
    assert np.abs(moments[0] - at).max() < 2e-15
    slopes = np.stack([np.broadcast_to(row, at.shape) for row in np.eye(2)])
    assert np.abs(moments[1:3] - slopes).max() < 1e-14 * scale[1]
    assert (np.abs(moments[3:]).max(axis=(1, 2)) < 2e-14 * scale[3:]).all()


@every_polygon
def test_they_are_not_negative_and_linear_on_sides(corners: Float) -> None:
    n, t = len(corners), np.linspace(0.0, 1.0, 9)
    assert polygon_coordinates(corners, inside(corners), 0).min() > -1e-16
    for i in range(n):
        at = (1.0 - t)[:, None] * corners[i] + t[:, None] * corners[(i + 1) % n]
        expected = np.zeros((n, len(t)))
        expected[i], expected[(i + 1) % n] = 1.0 - t, t
        assert np.abs(polygon_coordinates(corners, at, 0)[0] - expected).max() < 4e-16


def in_taylor_arithmetic(corners: Float, at: Float) -> Float:
    """The definition, differentiated operation by operation."""
    n = len(corners)
    x, y = Taylor.variables(at)
    p, q = corners, np.roll(corners, -1, axis=0)
    alpha: list[Any] = [
        x * (p[i, 1] - q[i, 1]) + y * (q[i, 0] - p[i, 0]) + (p[i, 0] * q[i, 1] - q[i, 0] * p[i, 1]) for i in range(n)
    ]
    products: list[Any] = []
    for i, weight in enumerate(corner_areas(corners)):
        product: Any = weight
        for j in range(n):
            if j not in (i, (i - 1) % n):
                product = product * alpha[j]
        products.append(product)
    total = sum(products[1:], start=products[0])
    return np.stack([(product / total).coefficients for product in products], axis=1)


@every_polygon
def test_derivatives_are_those_of_taylor_arithmetic(corners: Float) -> None:
    at = inside(corners)
    ours, reference = polygon_coordinates(corners, at), in_taylor_arithmetic(corners, at)
    error = np.abs(ours - reference).max(axis=(1, 2))
    assert (error < 1e-14 * len(corners) * np.abs(reference).max(axis=(1, 2)).clip(1.0)).all()
    for order, rows in ((0, 1), (1, 3)):
        assert np.array_equal(polygon_coordinates(corners, at, order), ours[:rows])


def test_triangles_and_squares_are_the_usual_ones() -> None:
    at = np.random.default_rng(0).dirichlet(np.ones(3), 20)[:, 1:]
    assert polygon_coordinates(CORNERS[3], at, 0)[0] == pytest.approx(barycentric(at).T, abs=1e-15)
    u, v = at.T
    bilinear = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v])
    assert polygon_coordinates(CORNERS[4], at, 0)[0] == pytest.approx(bilinear, abs=1e-15)


def test_the_areas_in_the_text_do_for_regular_polygons_only() -> None:
    # it divides alpha_i by the area of p_i, p_{i+1}, p_{i+2} and gives the products no weights
    def linear_precision(corners: Float) -> float:
        at = inside(corners)[:20]
        p, q = corners[:, None], np.roll(corners, -1, axis=0)[:, None]
        edge, away = q - p, at - p
        alpha = edge[..., 0] * away[..., 1] - edge[..., 1] * away[..., 0]
        alpha = alpha / np.roll(corner_areas(corners), -1)[:, None]
        n = len(corners)
        products = np.stack([np.prod(np.delete(alpha, [i, (i - 1) % n], axis=0), axis=0) for i in range(n)])
        return float(np.abs(np.einsum("ns,nx->sx", products / products.sum(axis=0), corners) - at).max())

    assert linear_precision(regular_polygon(5)) < 1e-15
    assert linear_precision(IRREGULAR) > 0.01
