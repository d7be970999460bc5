"""Optimized boundary curves: a minimum, between geometric Hermite curves and uniform speed."""

import numpy as np
from edge_samples import (
    arc,
    legs,
    lengths,
)

from testbed import registry
from testbed.geometry.vectors import Float, norm
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.optimized import Optimized, best_speeds


def objective(turn: Float, offsets: Float, k: Float, s: Float) -> Float:
    """Mann 1994, equations 8 to 10."""
    kappa = 2.0 * (3.0 * offsets - s[::-1] * turn) / s**2
    total: Float = ((s - 1.0) ** 2 + (kappa - k) ** 2).sum(axis=0)
    return total


def test_optimized_speeds_are_a_minimum_no_higher_than_uniform_speed() -> None:
    rng = np.random.default_rng(5)
    angle = rng.uniform(-0.4, 0.4, (2, 500))
    turn, offsets = np.sin(angle[1] - angle[0]), np.stack([-np.sin(angle[0]), np.sin(angle[1])])
    k = rng.normal(size=(2, 500))
    speeds, converged = best_speeds(turn, offsets, k)
    lowest = objective(turn, offsets, k, speeds)
    assert converged.mean() > 0.99
    assert (lowest <= objective(turn, offsets, k, np.ones((2, 500))) + 1e-12)[converged].all()
    for step in 1e-3 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1]]):
        around = objective(turn, offsets, k, speeds * (1.0 + step[:, None]))
        assert (around >= lowest)[converged].all()


def test_optimized_is_hermite_where_that_has_uniform_speed() -> None:
    edges = arc(0.05)
    assert norm(Optimized().curves(edges)[0] - Hermite().curves(edges)[0]).max() < 1e-4 * 0.05


def test_optimized_keeps_legs_long_where_hermite_has_none() -> None:
    mesh = registry.dataset("torus").mesh(0)
    short = Hermite().network(mesh)
    curves = Optimized().network(mesh)
    assert curves.notes == {}
    chord = lengths(mesh.edge_data)
    least = min((leg / chord).min() for leg in legs(curves.control_points))
    assert least > 0.15
    assert least > min((leg / chord).min() for leg in legs(short.control_points))
