"""Lower bounds of distances from planes: never above what is reached, close to it, exact on the plane itself."""

import math
from fractions import Fraction

import numpy as np
import pytest

from testbed.geometry.bernstein import multi_indices, triangle_tables
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.plane_bounds import Plane, lowest_distance, signed_distances
from testbed.geometry.vectors import Float

GROUND: Plane = (0.0, 0.0, 1.0, 0.0)
#: r(A, B, C): with the three corner ordinates A, B, C and all others -r, the minimum of the quartic is exactly 0.
SHARP = [
    ((1.0, 1.0, 1.0), 1.0 / 26.0),
    ((1.0, 2.0, 3.0), 0.06787608915365591),
    ((0.01, 1.0, 1.0), 0.004386889373784991),
    ((0.3, 0.7, 0.05), 0.0071059912752193515),
]


def over_grid(degree: int, heights: Float) -> BezierTriangles:
    """Triangles whose control points have these heights (P, n) over the parameters."""
    places = np.broadcast_to(np.array(multi_indices(degree))[:, 1:] / degree, (*heights.shape, 2))
    return BezierTriangles(np.concatenate([places, heights[..., None]], axis=-1))


def random_patches(kind: str, seed: int, count: int = 12) -> PatchBatch:
    random = np.random.default_rng(seed)
    if kind == "quads":
        return BezierQuads(random.normal(size=(count, 4, 3, 3)))
    return BezierTriangles(random.normal(size=(count, {"quartics": 15, "lines": 3, "quintics": 21}[kind], 3)))


@pytest.mark.parametrize(("corners", "r"), SHARP)
def test_the_sharp_quartics_touch_the_plane(corners: tuple[float, ...], r: float) -> None:
    heights = np.full((1, 15), -r)
    heights[0, [0, 10, 14]] = corners
    fine = lowest_distance([over_grid(4, heights)], GROUND, tolerance=1e-9)
    assert -2e-9 * max(corners) < fine < 1e-15
    assert -1e-4 * max(corners) < lowest_distance([over_grid(4, heights)], GROUND) <= 0.0
    # more room, and the minimum is above the plane by as much
    raised = lowest_distance([over_grid(4, heights + 0.25)], GROUND, tolerance=1e-9)
    assert raised == pytest.approx(0.25, abs=1e-8)


def test_quadratics_have_their_minima() -> None:
    # (u - 1/4)^2 + 2 (v - 1/3)^2 - 0.1 over the triangle, and over the square as (u - 0.3)^2 + (v - 0.6)^2 + 0.5
    nodes = np.array(multi_indices(2)) / 2.0
    u, v = nodes[:, 1], nodes[:, 2]
    values = (u - 0.25) ** 2 + 2.0 * (v - 1.0 / 3.0) ** 2 - 0.1
    triangle = over_grid(2, np.linalg.solve(triangle_tables(2, nodes[:, 1:], 0)[0], values)[None])
    bound = lowest_distance([triangle], GROUND, tolerance=1e-10)
    assert -0.1 - 1e-8 < bound <= -0.1 + 1e-15
    # ordinates of (t - s)^2 are s^2, s^2 - s, (1 - s)^2
    along_u, along_v = ([s * s, s * s - s, (1.0 - s) ** 2] for s in (0.3, 0.6))
    heights = np.add.outer(along_u, along_v) + 0.5
    places = np.stack(np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij"), axis=-1)
    square = BezierQuads(np.concatenate([places, heights[..., None]], axis=-1)[None])
    assert 0.5 - 1e-8 < lowest_distance([square], GROUND, tolerance=1e-10) <= 0.5 + 1e-15
    # of several batches the lowest, in any order
    for batches in ([triangle, square], [square, triangle]):
        assert lowest_distance(batches, GROUND, tolerance=1e-10) == pytest.approx(-0.1, abs=1e-8)


@pytest.mark.parametrize("kind", ["quartics", "quads", "lines", "quintics"])
@pytest.mark.parametrize("seed", range(6))
def test_no_point_is_below_the_bound(kind: str, seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    batch = random_patches(kind, seed)
    a, b, c, d = random.normal(size=4).tolist()
    plane = (a, b, c, d)
    points = batch.jets(lattice(batch.sides, 60), 0).f
    distances = signed_distances(plane, points)
    bound = lowest_distance([batch], plane)
    size = float(np.abs(distances).max())
    assert bound <= distances.min() + 1e-14 * size
    # the lattice misses the minimum by less than this, and the bound by its tolerance
    assert bound >= distances.min() - 0.01 * size
    fine = lowest_distance([batch], plane, tolerance=1e-9)
    assert bound <= fine + 1e-15 * size
    assert fine - bound <= 2e-5 * float(np.abs(signed_distances(plane, points)).max() + 10.0)
    # the patches one by one
    alone = [lowest_distance([batch.take(slice(i, i + 1))], plane, tolerance=1e-9) for i in range(len(batch))]
    assert min(alone) == pytest.approx(fine, abs=1e-8 * size)
    assert (np.array(alone) <= distances.min(axis=1) + 1e-14 * size).all()
    assert (np.array(alone) >= distances.min(axis=1) - 0.01 * size).all()


def test_what_is_known_saves_work_and_changes_no_guarantee() -> None:
    batch = random_patches("quartics", 3)
    fine = lowest_distance([batch], GROUND, tolerance=1e-9)
    for known in (fine, fine + 1e-3, 7.0, fine - 0.5, -1e9, math.nan):
        assert lowest_distance([batch], GROUND, known) <= fine + 1e-12
    assert lowest_distance([batch], GROUND, fine) == pytest.approx(fine, abs=1e-4)


def test_little_work_gives_a_wide_bound_and_none_that_is_wrong() -> None:
    batch = over_grid(4, np.random.default_rng(7).normal(size=(12, 15)))
    fine = lowest_distance([batch], GROUND, tolerance=1e-9)
    bounds = [lowest_distance([batch], GROUND, rounds=rounds, tolerance=1e-9) for rounds in (0, 2, 4, 8, 40)]
    assert bounds == sorted(bounds)
    assert bounds[0] == pytest.approx(batch.control_points[..., 2].min())
    assert bounds[0] < bounds[2] < bounds[-1] == pytest.approx(fine)
    assert lowest_distance([batch], GROUND, cuts=3) <= fine


@pytest.mark.parametrize("plane", [GROUND, (0.0, 0.0, 4.0, 0.0), (0.0, 0.5, 0.0, 0.0)])
def test_what_is_on_the_plane_is_not_below_it(plane: Plane) -> None:
    control_points = np.abs(np.random.default_rng(0).normal(size=(20, 15, 3)))
    control_points[3] *= [1.0, 0.0, 0.0]
    assert lowest_distance([BezierTriangles(control_points)], plane) == 0.0
    control_points[3, 4, 1:] = -1e-300
    assert lowest_distance([BezierTriangles(control_points)], plane) < 0.0


@pytest.mark.parametrize("scale", [1e-20, 1.0, 1e20])
def test_rounding_is_part_of_the_bound(scale: float) -> None:
    # the normal has length 7, and the points lie near the plane far from the origin: differences of large numbers
    random = np.random.default_rng(1)
    tight = 0
    for _ in range(200):
        corner = scale * random.uniform(-1.0, 1.0, 3)
        plane = (2.0, 3.0, 6.0, -float(corner @ np.array([2.0, 3.0, 6.0])))
        control_points = corner * (1.0 + 1e-15 * random.integers(0, 3, (1, 10, 3)))
        exact = [
            sum((Fraction(a) * Fraction(x) for a, x in zip(plane, [*point, 1.0], strict=True)), Fraction(0)) / 7
            for point in control_points[0, [0, 6, 9]].tolist()
        ]
        bound = lowest_distance([BezierTriangles(control_points)], plane)
        assert Fraction(bound) <= min(exact)
        assert bound >= float(min(exact)) - 1e-14 * scale
        tight += bound > float(min(exact)) - 4e-15 * scale
    assert tight > 100


def test_planes_are_the_same_whatever_the_length_of_their_normals() -> None:
    batch = random_patches("quartics", 8)
    for factor in (1e-60, 3.0, 1e60):
        plane = (0.3 * factor, -1.1 * factor, 0.7 * factor, 0.2 * factor)
        assert lowest_distance([batch], plane) == pytest.approx(lowest_distance([batch], (0.3, -1.1, 0.7, 0.2)))


def test_what_is_not_finite_has_no_bound() -> None:
    for wrong in (np.nan, np.inf):
        control_points = np.ones((3, 10, 3))
        control_points[1, 4, 2] = wrong
        for plane in (GROUND, (0.3, 0.4, 0.5, 0.0)):
            assert math.isnan(lowest_distance([BezierTriangles(control_points)], plane))
    assert lowest_distance([BezierTriangles(np.ones((0, 10, 3)))], GROUND) == math.inf
    assert lowest_distance([], GROUND) == math.inf


def test_other_patches_have_no_bound() -> None:
    with pytest.raises(TypeError, match="RationalBezierTriangles"):
        lowest_distance([RationalBezierTriangles(np.ones((1, 3, 3)), np.ones((1, 3)))], GROUND)
