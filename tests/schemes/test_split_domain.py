"""Split domains: C1 inside for any free points, in any dimension, and cubics stay cubics."""

import numpy as np
import pytest

from testbed.geometry.bernstein import elevate_curve, elevate_triangle, subdivide_triangle
from testbed.geometry.nets import CENTRE, side_indices
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.split_domain import J, c1_cubics, c1_ring, cubic_reproducing_inner, subdivided_cubics

#: Places in a quartic sub-patch: the edge, C_ij and C_ik, N_i.
EDGE, CROSS, INNER = [0, 1, 3, 6, 10], [4, 7], 8

dimensions = pytest.mark.parametrize("dimension", [3, 4])


def random_curves(dimension: int, degree: int = 3) -> Float:
    """Curves (5, 3, degree + 1, dimension) around random faces that meet at the corners."""
    curves = np.random.default_rng(dimension).normal(size=(5, 3, degree + 1, dimension))
    curves[:, :, -1] = curves[:, J, 0]
    return curves


def spoke_defect(net: Float, spoke: list[int], before: list[int], left: list[int], right: list[int]) -> float:
    """Largest distance of the points of spoke V_k S from the mean of their neighbours, in sub-patches i and j."""
    mean = (net[:, :, before] + net[:, :, left] + net[:, J][:, :, right]) / 3.0
    apart = net[:, J][:, :, [net.shape[2] - 1]] - net[:, :, [-1]]
    return float(max(np.abs(net[:, :, spoke] - mean).max(), np.abs(apart).max()))


@dimensions
def test_the_quartic_ring_joins_with_c1_whatever_the_free_points(dimension: int) -> None:
    rng = np.random.default_rng(1)
    near_start, near_end, inner = rng.normal(size=(3, 5, 3, dimension))
    net = c1_ring(random_curves(dimension, 4), (near_start, near_end), inner).nets()
    assert net.shape == (5, 3, 15, dimension)
    assert spoke_defect(net, [11, 12, 13], [10, 11, 12], [6, 7, 8], [1, 4, 8]) < 1e-14
    assert net[:, 0, 14] == pytest.approx(net[:, :, 13].mean(axis=1), abs=1e-15)


@dimensions
def test_the_cubic_ring_joins_with_c1_whatever_the_free_points(dimension: int) -> None:
    net = c1_cubics(random_curves(dimension), np.random.default_rng(1).normal(size=(5, 3, dimension)))
    assert net.shape == (5, 3, 10, dimension)
    assert spoke_defect(net, [7, 8], [6, 7], [3, 4], [1, 4]) < 1e-14
    assert net[:, 0, 9] == pytest.approx(net[:, :, 8].mean(axis=1), abs=1e-15)


@dimensions
def test_a_cubic_cut_at_its_centroid_is_the_same_polynomials(dimension: int) -> None:
    whole = np.random.default_rng(2).normal(size=(5, 10, dimension))
    curves = np.roll(whole[:, side_indices(3)], -1, axis=1)
    assert subdivided_cubics(curves, whole[:, CENTRE]) == pytest.approx(subdivide_triangle(whole), abs=1e-14)


@dimensions
def test_split_cubics_raised_to_quartics_are_reproduced(dimension: int) -> None:
    curves = random_curves(dimension)
    expected = elevate_triangle(c1_cubics(curves, np.random.default_rng(3).normal(size=(5, 3, dimension))))
    boundary = elevate_curve(curves)
    assert expected[:, :, EDGE] == pytest.approx(boundary, abs=1e-15)
    cross_points = (expected[:, :, CROSS[0]], expected[:, :, CROSS[1]])
    inner = cubic_reproducing_inner(boundary, curves, cross_points)
    assert inner == pytest.approx(expected[:, :, INNER], abs=1e-14)
    assert c1_ring(boundary, cross_points, inner).nets() == pytest.approx(expected, abs=1e-14)


def test_the_inner_points_follow_the_data() -> None:
    """They move with the points, and do not depend on the corner a face starts at, or on its orientation."""
    rng = np.random.default_rng(4)
    curves = random_curves(3)
    start, end = rng.normal(size=(2, 5, 3, 3))
    inner = cubic_reproducing_inner(elevate_curve(curves), curves, (start, end))
    shift = np.array([3.0, -2.0, 1.0])
    moved = cubic_reproducing_inner(elevate_curve(curves + shift), curves + shift, (start + shift, end + shift))
    assert moved == pytest.approx(inner + shift, abs=1e-14)
    turned = np.roll(curves, 1, axis=1)
    rolled = cubic_reproducing_inner(
        elevate_curve(turned), turned, (np.roll(start, 1, axis=1), np.roll(end, 1, axis=1))
    )
    assert rolled == pytest.approx(np.roll(inner, 1, axis=1), abs=1e-15)
    flipped = curves[:, ::-1, ::-1]
    mirrored = cubic_reproducing_inner(elevate_curve(flipped), flipped, (end[:, ::-1], start[:, ::-1]))
    assert mirrored == pytest.approx(inner[:, ::-1], abs=1e-15)
