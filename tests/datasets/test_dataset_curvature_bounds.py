"""Bounds of curvature over boxes: never below what is inside, and close for small boxes."""

import numpy as np
import pytest

from testbed.geometry.exact import ExactSurface
from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.vectors import Float
from testbed_datasets.bump import Bump
from testbed_datasets.ellipsoid import Ellipsoid
from testbed_datasets.graph import Graph
from testbed_datasets.hyperboloid import Hyperboloid
from testbed_datasets.monkey_saddle import MonkeySaddle
from testbed_datasets.plane import Plane
from testbed_datasets.quadric import Quadric
from testbed_datasets.sphere import RoundSphere
from testbed_datasets.torus import RoundTorus, Torus

SURFACES: dict[str, ExactSurface] = {
    "sphere": RoundSphere(0.7),
    "ellipsoid": Ellipsoid().surface,
    "two sheets": Quadric((2.0, 0.7, 1.1), (1, -1, -1)),
    "hyperboloid": Hyperboloid().surface,
    "torus": Torus().surface,
    "thick torus": RoundTorus(1.0, 0.9),
    "graph": Graph().surface,
    "saddle graph": Graph(height=3.0, bowl=0.0).surface,
    "monkey saddle": MonkeySaddle().surface,
    "plane": Plane().surface,
    "bump": Bump(height=0.3, width=0.4, x=0.1, y=-0.2).surface,
    "dent": Bump(height=-0.1, width=0.2, x=0.1, y=-0.2).surface,
}


def largest_curvatures(exact: ExactSurface, points: Float) -> Float:
    curvatures: Float = np.abs(np.linalg.eigvalsh(exact.second_form(points))).max(axis=-1)
    return curvatures


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("size", [1e-6, 0.03, 0.3, 1.0])
def test_no_curvature_in_a_box_is_above_its_bound(name: str, size: float) -> None:
    exact, random = SURFACES[name], np.random.default_rng(3)
    middle = exact.closest(random.uniform(-1.0, 1.0, (60, 3)))
    half = size * random.uniform(0.2, 1.0, (60, 3))
    middle = middle + half * random.uniform(-0.8, 0.8, (60, 3))
    bounds = exact.curvature_bound(middle - half, middle + half)
    assert (bounds >= 0.0).all()
    inside = exact.closest((middle[:, None] + half[:, None] * random.uniform(-1.0, 1.0, (60, 60, 3))).reshape(-1, 3))
    box = np.repeat(np.arange(60), 60)
    contained = (np.abs(inside - middle[box]) <= half[box]).all(axis=1)
    assert contained.sum() > 200
    found = largest_curvatures(exact, inside[contained])
    # the eigenvalues round too
    assert (found <= bounds[box[contained]] * (1.0 + 1e-13) + 1e-13).all()


@pytest.mark.parametrize("name", SURFACES)
def test_bounds_of_small_boxes_are_close(name: str) -> None:
    exact = SURFACES[name]
    points = exact.closest(np.random.default_rng(4).uniform(-1.0, 1.0, (200, 3)))
    found = largest_curvatures(exact, points)
    bounds = exact.curvature_bound(points - 1e-5, points + 1e-5)
    # those of spheres and tori are of the whole surface; those of quadrics and graphs leave out a projection
    scale = largest_curvatures(exact, exact.closest(np.random.default_rng(5).uniform(-1.0, 1.0, (5000, 3)))).max()
    assert (bounds <= 12.0 * found + 1.5 * scale + 1e-9).all()


def test_a_box_too_large_for_an_expansion_has_no_bound_unless_the_gradient_has_one() -> None:
    low, high = np.full((1, 3), -5.0), np.full((1, 3), 5.0)
    assert np.isinf(PolynomialLevelSet.curvature_bound(Ellipsoid().surface, low, high)).all()
    assert np.isfinite(MonkeySaddle().surface.curvature_bound(low, high)).all()
