"""Bezier simplices: the order of the control points, blossoms, elevation; triangles are those of bernstein.py."""

from math import comb, factorial, prod

import numpy as np
import pytest

from testbed.geometry.bernstein import blossom_triangle, elevate_triangle, multi_indices
from testbed.geometry.simplex_bernstein import (
    blossom_table,
    composed_tables,
    elevate_simplex,
    simplex_multi_indices,
    simplex_places,
    simplex_point_count,
    simplex_raised,
)

SIZES = [(3, 0), (3, 1), (3, 6), (4, 3), (5, 6), (6, 4), (8, 2)]


@pytest.mark.parametrize(("sides", "degree"), SIZES)
def test_multi_indices_are_all_of_them_and_know_their_places(sides: int, degree: int) -> None:
    s = simplex_multi_indices(sides, degree)
    assert len(s) == simplex_point_count(sides, degree) == comb(sides - 1 + degree, degree)
    assert (s.sum(axis=1) == degree).all()
    assert len(np.unique(s, axis=0)) == len(s)
    assert s.tolist() == sorted(s.tolist(), reverse=True)
    assert np.array_equal(simplex_places(s), np.arange(len(s)))


def test_the_order_of_triangles_is_that_of_bezier_triangles() -> None:
    for degree in range(7):
        assert np.array_equal(simplex_multi_indices(3, degree), multi_indices(degree))


@pytest.mark.parametrize(("sides", "degree"), SIZES)
def test_raised_places_hold_the_raised_indices(sides: int, degree: int) -> None:
    higher = simplex_multi_indices(sides, degree + 1)
    for i, places in enumerate(simplex_raised(sides, degree)):
        assert np.array_equal(higher[places] - simplex_multi_indices(sides, degree), np.eye(sides)[[i] * len(places)])


def test_the_blossom_of_a_triangle_is_the_one_there_was() -> None:
    random = np.random.default_rng(1)
    net, arguments = random.normal(size=(15, 3)), random.normal(size=(4, 3))
    table = blossom_table(list(arguments[..., None]))
    assert np.einsum("np,ni->pi", table, net)[0] == pytest.approx(blossom_triangle(net, arguments), abs=1e-13)


def test_the_blossom_is_symmetric_and_its_diagonal_the_bernstein_polynomials() -> None:
    random = np.random.default_rng(2)
    u = random.normal(size=(3, 5))
    assert blossom_table([u[0], u[1], u[2]]) == pytest.approx(blossom_table([u[2], u[0], u[1]]), abs=1e-13)
    powers = [factorial(3) / prod(map(factorial, s)) * prod(u[0] ** s) for s in simplex_multi_indices(5, 3).tolist()]
    assert blossom_table([u[0]] * 3) == pytest.approx(np.array(powers), abs=1e-14)


@pytest.mark.parametrize(("sides", "degree"), [(3, 1), (4, 3), (5, 2), (6, 3)])
def test_elevation_keeps_the_simplex(sides: int, degree: int) -> None:
    random = np.random.default_rng(3)
    net = random.normal(size=(2, simplex_point_count(sides, degree), 3))
    raised = elevate_simplex(net, sides, degree, 3)
    at = random.dirichlet(np.ones(sides))[:, None]
    values = [
        np.einsum("nq,pni->pqi", composed_tables(d, at[None])[0], points)
        for d, points in ((degree, net), (degree + 3, raised))
    ]
    assert values[1] == pytest.approx(values[0], abs=1e-14)


def test_elevation_of_triangles_is_the_one_there_was() -> None:
    net = np.random.default_rng(4).normal(size=(2, 10, 3))
    assert elevate_simplex(net, 3, 3, 2) == pytest.approx(elevate_triangle(net, 2), abs=1e-15)
