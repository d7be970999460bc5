from itertools import pairwise

import numpy as np
import pytest
from precise_curvature import curvatures, decimal, refined_extreme
from random_patches import KINDS, quads, rational, rotation, triangles

from testbed.geometry.bernstein import elevate_tensor, elevate_triangle, multi_indices
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.curvature import analyse
from testbed.geometry.curvature_bounds import (
    CurvatureBounds,
    Enclosure,
    Places,
    certifiable,
    numerator_size,
    patch_bounds,
    surface_bounds,
)
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float

EXTREMES = ("gauss_min", "gauss_max", "mean_min", "mean_max")
#: Largest relative gap that is asserted: the tolerance the bounds aim at.
GAP = 1e-6


every_kind = pytest.mark.parametrize("kind", KINDS)


def enclosures(bounds: CurvatureBounds) -> list[tuple[str, int, int, Enclosure]]:
    """Name, quantity (0 for K, 1 for H) and sign (-1 for a minimum) of each, with it."""
    return [
        (name, 0 if name.startswith("gauss") else 1, 1 if name.endswith("max") else -1, getattr(bounds, name))
        for name in EXTREMES
    ]


def scale_of(bounds: CurvatureBounds, quantity: int) -> Float:
    """Largest absolute curvature of each patch."""
    lowest, highest = (
        (bounds.gauss_min.high, bounds.gauss_max.low) if quantity == 0 else (bounds.mean_min.high, bounds.mean_max.low)
    )
    return np.maximum(np.abs(lowest), np.abs(highest))


@every_kind
def test_extremes_in_50_digits_are_inside_and_the_enclosures_are_tight(kind: str) -> None:
    batch = KINDS[kind]
    bounds = patch_bounds(batch)
    for name, quantity, sign, enclosure in enclosures(bounds):
        _, value = refined_extreme(batch, quantity, sign)
        extreme = sign * value
        # comparisons of Decimals with each other are exact: no slack on either side
        assert (decimal(enclosure.low) <= extreme).all(), name
        assert (extreme <= decimal(enclosure.high)).all(), name
        assert (enclosure.high - enclosure.low <= GAP * scale_of(bounds, quantity)).all(), name


@every_kind
def test_no_sample_in_50_digits_is_beyond_the_outer_bounds(kind: str) -> None:
    batch = KINDS[kind]
    bounds = patch_bounds(batch)
    at = np.broadcast_to(decimal(lattice(batch.sides, 8)), (len(batch), len(lattice(batch.sides, 8)), 2))
    gauss, mean = curvatures(batch, at)
    for found, smallest, largest in (
        (gauss, bounds.gauss_min, bounds.gauss_max),
        (mean, bounds.mean_min, bounds.mean_max),
    ):
        assert (decimal(smallest.low)[:, None] <= found).all()
        assert (found <= decimal(largest.high)[:, None]).all()


@every_kind
@pytest.mark.parametrize(("rounds", "cuts"), [(0, None), (48, 0), (3, None), (48, 30)])
def test_less_work_gives_wider_bounds_that_hold_as_well(kind: str, rounds: int, cuts: int | None) -> None:
    batch = KINDS[kind]
    full, less = patch_bounds(batch), patch_bounds(batch, rounds=rounds, cuts=cuts)
    dense = analyse(batch.jets(lattice(batch.sides, 40)))
    for name, quantity, sign, wide in enclosures(less):
        narrow = getattr(full, name)
        samples = (dense.gauss, dense.mean)[quantity]
        extreme = samples.max(axis=1) if sign > 0 else samples.min(axis=1)
        outer, wide_outer = (narrow.high, wide.high) if sign > 0 else (narrow.low, wide.low)
        assert (sign * wide_outer >= sign * extreme).all()
        # wider by nothing less than what the tighter one leaves open
        assert (wide.low <= narrow.high).all()
        assert (wide.high >= narrow.low).all()
        assert (sign * wide_outer >= sign * outer - GAP * scale_of(full, quantity)).all()
    assert (less.gauss_max.high - less.gauss_max.low).sum() > 10.0 * (full.gauss_max.high - full.gauss_max.low).sum()


def test_more_rounds_do_not_widen_bounds() -> None:
    batch = triangles(3, 20, 7)
    gaps = [
        patch_bounds(batch, rounds=rounds).gauss_max.high - patch_bounds(batch, rounds=rounds).gauss_max.low
        for rounds in (2, 6, 12, 24)
    ]
    for before, after in pairwise(gaps):
        assert (after <= before).all()


@every_kind
def test_patches_do_not_depend_on_their_company(kind: str) -> None:
    batch = KINDS[kind]
    order = np.random.default_rng(0).permutation(len(batch))
    together, shuffled = patch_bounds(batch), patch_bounds(batch.take(order))
    alone = patch_bounds(batch.take(np.array([3])))
    for name in EXTREMES:
        for end in ("low", "high"):
            values = getattr(getattr(together, name), end)
            assert np.array_equal(values[order], getattr(getattr(shuffled, name), end))
            assert values[3] == getattr(getattr(alone, name), end)[0]


def overlap(one: Enclosure, other: Enclosure, slack: Float) -> bool:
    return bool(((one.low <= other.high + slack) & (other.low <= one.high + slack)).all())


@pytest.mark.parametrize("degree", [2, 3])
def test_degree_elevation_keeps_the_extremes(degree: int) -> None:
    batch = triangles(degree, 10, 8)
    elevated = BezierTriangles(elevate_triangle(batch.control_points, 2))
    check_same(patch_bounds(batch), patch_bounds(elevated))
    square = quads((degree, 2), 5, 8)
    check_same(patch_bounds(square), patch_bounds(BezierQuads(elevate_tensor(square.control_points))))


def check_same(before: CurvatureBounds, after: CurvatureBounds, factor: float = 1.0) -> None:
    """Compare the same extremes of patches that differ by rounding of their control points."""
    for name, quantity, _, enclosure in enclosures(before):
        power = factor ** (2 - quantity)
        other = getattr(after, name)
        scale = scale_of(before, quantity)
        assert overlap(enclosure, Enclosure(other.low * power, other.high * power), 1e-10 * scale)
        assert ((other.high - other.low) * power <= GAP * scale * (1.0 + GAP)).all()


@every_kind
def test_turning_corners_keeps_the_extremes(kind: str) -> None:
    batch = KINDS[kind].take(slice(0, 10))
    if isinstance(batch, BezierQuads):
        turned: PatchBatch = BezierQuads(batch.control_points.swapaxes(1, 2)[:, ::-1])
    else:
        assert isinstance(batch, BezierTriangles | RationalBezierTriangles)
        exponents = multi_indices(batch.degree).tolist()
        order = np.array([exponents.index([j, k, i]) for i, j, k in exponents])
        if isinstance(batch, BezierTriangles):
            turned = BezierTriangles(batch.control_points[:, order])
        else:
            turned = RationalBezierTriangles(batch.control_points[:, order], batch.weights[:, order])
    check_same(patch_bounds(batch), patch_bounds(turned))


def test_rigid_motions_keep_the_extremes_and_mirrors_negate_the_mean() -> None:
    batch = triangles(3, 20, 9)
    moved = BezierTriangles(batch.control_points @ rotation(np.random.default_rng(1)) + np.array([3.0, -7.0, 2.0]))
    check_same(patch_bounds(batch), patch_bounds(moved))
    mirrored = patch_bounds(BezierTriangles(batch.control_points * np.array([1.0, 1.0, -1.0])))
    bounds = patch_bounds(batch)
    # changing signs rounds nothing, but what one bounds from above the other bounds from below
    np.testing.assert_array_equal(mirrored.mean_max.high, -bounds.mean_min.low)
    np.testing.assert_array_equal(mirrored.mean_min.high, -bounds.mean_max.low)
    np.testing.assert_array_equal(mirrored.gauss_max.high, bounds.gauss_max.high)


@pytest.mark.parametrize("exponent", [-60, -3, 5, 200])
def test_scaling_by_powers_of_two_scales_the_bounds_to_the_last_bit(exponent: int) -> None:
    batch = triangles(3, 20, 10)
    bounds, scaled = patch_bounds(batch), patch_bounds(BezierTriangles(np.ldexp(batch.control_points, exponent)))
    for name, quantity, _, enclosure in enclosures(bounds):
        for end in ("low", "high"):
            expected = np.ldexp(getattr(enclosure, end), -exponent * (2 - quantity))
            np.testing.assert_array_equal(getattr(getattr(scaled, name), end), expected)


def test_scaling_by_any_factor_scales_the_extremes() -> None:
    batch = rational(2, 10, 11)
    larger = RationalBezierTriangles(1234.5 * batch.control_points, 3.0 * batch.weights)
    check_same(patch_bounds(batch), patch_bounds(larger), 1234.5)


def test_curvature_beyond_the_range_of_floats_is_still_enclosed() -> None:
    net = triangles(2, 1, 12).control_points - triangles(2, 1, 12).control_points[:, :1]
    large = patch_bounds(BezierTriangles(np.ldexp(net, -560)))
    for name, sign in (("gauss_min", -1), ("gauss_max", 1)):
        enclosure = getattr(large, name)
        assert not np.isnan([enclosure.low, enclosure.high]).any()
        if sign * np.sign(getattr(patch_bounds(BezierTriangles(net)), name).low)[0] > 0:
            assert sign * (enclosure.high if sign > 0 else enclosure.low)[0] == np.inf
    small = patch_bounds(BezierTriangles(np.ldexp(net, 700)))
    assert 0.0 < small.gauss_max.high[0] < 1e-300
    assert small.gauss_max.low[0] <= 0.0 <= small.gauss_max.high[0]


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_flat_patches_enclose_zero_within_rounding(degree: int) -> None:
    batch = triangles(degree, 10, 13, 0.01)
    level = batch.control_points.copy()
    level[..., 2] = 0.0
    tilted = BezierTriangles(level @ rotation(np.random.default_rng(2)))
    for flat in (BezierTriangles(level), tilted):
        bounds = patch_bounds(flat)
        for name in EXTREMES:
            enclosure = getattr(bounds, name)
            assert (enclosure.low <= 1e-13).all()
            assert (enclosure.high >= -1e-13).all()
        for smallest, largest in ((bounds.gauss_min, bounds.gauss_max), (bounds.mean_min, bounds.mean_max)):
            assert (smallest.low <= 0.0).all()
            assert (largest.high >= 0.0).all()
            assert (largest.high - smallest.low <= 1e-9).all()


def test_a_triangle_has_no_curvature_at_all() -> None:
    bounds = patch_bounds(triangles(1, 10, 14))
    for name in EXTREMES:
        enclosure = getattr(bounds, name)
        assert (enclosure.low <= 0.0).all()
        assert (enclosure.high >= 0.0).all()
        assert (enclosure.high - enclosure.low <= 1e-150).all()


def test_a_sphere_has_curvature_one() -> None:
    # the rational octant of the unit sphere has a pole; over a part of the stereographic plane it has none
    corners = np.array([[0.1, -0.3], [0.6, 0.2], [-0.2, 0.5]])
    pairs = np.array([[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]])
    p, q = corners[pairs[:, 0]], corners[pairs[:, 1]]
    product = (p * q).sum(axis=-1)
    points = np.concatenate([p + q, (1.0 - product)[:, None]], axis=-1) / (1.0 + product)[:, None]
    bounds = patch_bounds(RationalBezierTriangles(points[None], (1.0 + product)[None]))
    for name in EXTREMES:
        enclosure = getattr(bounds, name)
        # constant curvature is the hardest case: no piece is ever out of the running
        assert enclosure.low[0] <= 1.0 + 1e-12
        assert enclosure.high[0] >= 1.0 - 1e-12
        assert enclosure.high[0] - enclosure.low[0] < 1e-3


def collapsed_corner() -> Float:
    net = triangles(3, 1, 15).control_points.copy()
    net[0, 1] = net[0, 0]
    return net


def test_a_singular_point_makes_outer_bounds_infinite_and_leaves_inner_ones_attained() -> None:
    net = collapsed_corner()
    net[0, 1] = net[0, 2] = net[0, 0]
    batch = BezierTriangles(net)
    bounds = patch_bounds(batch)
    assert bounds.gauss_max.high[0] == np.inf
    assert bounds.gauss_min.low[0] == -np.inf
    assert bounds.mean_max.high[0] == np.inf
    assert bounds.mean_min.low[0] == -np.inf
    assert np.isfinite([bounds.gauss_max.low[0], bounds.gauss_min.high[0]]).all()
    # the company of a singular patch keeps its bounds
    fine = triangles(3, 5, 16)
    mixed = patch_bounds(BezierTriangles(np.concatenate([fine.control_points, net])))
    np.testing.assert_array_equal(mixed.mean_max.high[:5], patch_bounds(fine).mean_max.high)
    everything = surface_bounds([BezierTriangles(np.concatenate([fine.control_points, net]))])
    assert everything.gauss_max.high[0] == np.inf


def test_a_patch_without_area_has_no_bounds() -> None:
    line = triangles(3, 1, 17).control_points.copy()
    line[..., 1:] = 0.0
    for net in (line, np.zeros_like(line), np.zeros((1, 1, 3))):
        bounds = patch_bounds(BezierTriangles(net))
        assert bounds.gauss_min.low[0] == -np.inf
        assert bounds.gauss_max.high[0] == np.inf


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e308])
def test_what_is_not_finite_has_no_bounds(bad: float) -> None:
    net = triangles(3, 3, 18).control_points.copy()
    net[1, 4, 0], net[1, 5, 0] = bad, -bad
    bounds = patch_bounds(BezierTriangles(net))
    assert np.isinf(bounds.gauss_max.high).tolist() == [False, True, False]
    assert np.isinf(bounds.mean_min.low).tolist() == [False, True, False]


def test_weights_that_are_not_positive_have_no_bounds() -> None:
    batch = rational(2, 3, 19)
    weights = batch.weights.copy()
    weights[2, 1] = -0.1
    bounds = patch_bounds(RationalBezierTriangles(batch.control_points, weights))
    assert np.isinf(bounds.gauss_max.high).tolist() == [False, False, True]


def test_a_surface_has_the_extremes_of_its_patches() -> None:
    batches = [triangles(3, 30, 20), triangles(2, 600, 21), quads((2, 3), 7, 22)]
    each = [patch_bounds(batch) for batch in batches]
    whole = surface_bounds(batches)
    for name, quantity, sign, enclosure in enclosures(whole):
        low, high = (np.concatenate([getattr(getattr(one, name), end) for one in each]) for end in ("low", "high"))
        pick = np.max if sign > 0 else np.min
        slack = GAP * scale_of(whole, quantity)
        # both enclose the same number
        assert overlap(enclosure, Enclosure(pick(low), pick(high)), np.zeros(1))
        assert enclosure.high - enclosure.low <= slack


def test_places_save_work_and_change_nothing_else() -> None:
    batch = triangles(3, 40, 23)
    plain = surface_bounds([batch])
    rng = np.random.default_rng(24)
    places = Places(rng.integers(0, 40, 25), rng.dirichlet(np.ones(3), 25)[:, 1:])
    seeded = surface_bounds([batch], [places])
    for name in EXTREMES:
        assert overlap(getattr(plain, name), getattr(seeded, name), np.zeros(1))
    # at the places themselves, the bounds are attained: an extreme is at least as large as curvature there
    values = curvatures(batch.take(places.patch), decimal(places.at)[:, None])[0][:, 0]
    none = surface_bounds([batch], [places], rounds=0)
    assert float(none.gauss_max.low[0]) >= float(max(values)) - 1e-9 * abs(float(max(values)))
    # the best of many corners and places, but no more than the largest there is
    assert none.gauss_max.low[0] <= plain.gauss_max.high[0]


def test_other_patches_are_refused_by_name() -> None:
    blended = TabulatedTriangles(lambda a, b, c: [a, b, c], np.zeros((2, 3, 3)), np.zeros((3, 3, 3)), 0.0)
    assert not certifiable(blended)
    with pytest.raises(TypeError, match="certify"):
        patch_bounds(blended)


@pytest.mark.parametrize(("batch", "size"), [(triangles(3, 1), 66), (triangles(4, 1), 153), (quads((3, 3), 1), 225)])
def test_the_size_of_the_numerator_is_known(batch: PatchBatch, size: int) -> None:
    assert numerator_size(batch) == size
