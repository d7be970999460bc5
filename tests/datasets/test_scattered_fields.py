"""Fields of scattered heights: derivatives, nearest points against brute force, expansions, and random heights."""

import numpy as np
import pytest

from testbed.geometry.level_bounds import powers
from testbed.geometry.vectors import Float, norm, tangential
from testbed_datasets.bumped_plane import BumpedPlane
from testbed_datasets.scattered_fields import RAIN, ROUGHNESS, BumpField, peak, rainfall, random_heights, rough_middles

#: Two showers whose supports touch, one beside, a tall and a flat one.
TOUCHING = BumpField(
    (BumpedPlane(0.5, 0.25, (0.25, 0.5)), BumpedPlane(0.1, 0.25, (0.75, 0.5)), BumpedPlane(2.0, 0.125, (0.5, 0.875))),
    0.25,
)
FIELDS = {"peak": peak(1, 0.5, 0.01), "rainfall": rainfall(2, 0.5, 0.0), "touching": TOUCHING}
every_field = pytest.mark.parametrize("name", FIELDS)


def around(field: BumpField, count: int, seed: int = 0) -> Float:
    """Points over and beside the unit square, above and below the surface."""
    random = np.random.default_rng(seed)
    points: Float = random.uniform((-0.3, -0.3, -0.5), (1.3, 1.3, 1.0), (count, 3))
    # half of them near the surface, where it matters most
    near = field.over(points[::2, :2])
    points[::2] = near + 0.02 * random.normal(size=near.shape)
    return points


@every_field
def test_slopes_and_bending_are_the_derivatives(name: str) -> None:
    field, at = FIELDS[name], around(FIELDS[name], 500)[:, :2]
    step = 1e-5
    for axis in (0, 1):
        move = step * np.eye(2)[axis]
        first = (field.height(at + move) - field.height(at - move)) / (2.0 * step)
        assert np.abs(first - field.slopes(at)[:, axis]).max() < 1e-6
        second = (field.slopes(at + move) - field.slopes(at - move)) / (2.0 * step)
        assert np.abs(second - field.bending(at)[:, axis]).max() < 2e-4
    assert np.abs(field.slopes(at)).max() > 0.5


@every_field
def test_feet_are_nearest(name: str) -> None:
    from scipy.spatial import cKDTree

    field = FIELDS[name]
    points = around(field, 1000)
    feet = field.closest(points)
    distance = norm(points - feet)
    assert norm(feet - field.over(feet[:, :2])).max() < 4e-15
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 2.0, 901)] * 2), axis=-1).reshape(-1, 2)
    brute = cKDTree(field.over(grid)).query(points)[0]
    assert (distance <= brute + 1e-14).all()
    # half a diagonal of the grid's cells, on slopes of up to 31
    assert (brute**2 - distance**2 <= 0.14**2 + 0.28 * distance).all()
    assert norm(tangential(points - feet, field.normal(feet))).max() < 1e-9


def test_a_foot_is_on_another_bump_where_that_is_nearer() -> None:
    # over the low bump, level with the tall one's flank; and inside the tall bump, which nothing is seen through
    over = np.array([[0.55, 0.7, 1.0], [0.5, 0.875, 1.0]])
    feet = TOUCHING.closest(over)
    assert norm(feet[:, :2] - np.array([0.5, 0.875]))[0] < 0.125
    assert feet[0, 2] > 0.5
    assert (norm(feet[:, :2] - np.array([0.5, 0.875])) < 0.125).all()


@every_field
def test_what_is_left_out_of_an_expansion_is_within_its_bound(name: str) -> None:
    field, random = FIELDS[name], np.random.default_rng(3)
    points = around(field, 400, 1)
    about = field.expansion(points, 2)
    radii = 10.0 ** random.uniform(-4.0, -0.5, (400, 1)) * random.uniform(0.1, 1.0, (400, 3))
    offsets = random.uniform(-1.0, 1.0, (400, 3)) * radii
    of = powers(offsets, 2)
    taylor = sum(
        coefficient * of[i, 0] * of[j, 1] * of[k, 2]
        for (i, j, k), coefficient in zip(about.exponents.tolist(), about.coefficients, strict=True)
    )
    moved = points + offsets
    value, gradient = about.magnitudes(radii)
    rounding = about.operations * 2.0**-52
    error = np.abs(moved[:, 2] - field.height(moved[:, :2]) - taylor)
    assert (error <= about.remainder(radii) + rounding * value).all()
    linear = about.gradient + np.einsum("nij,nj->ni", about.hessian, offsets)
    assert (norm(field.gradient(moved) - linear) <= about.gradient_remainder(radii) + rounding * gradient).all()
    # and not by a wide margin everywhere
    assert (error > 0.01 * about.remainder(radii)).any()


@every_field
def test_no_curvature_in_a_box_is_above_its_bound(name: str) -> None:
    field, random = FIELDS[name], np.random.default_rng(4)
    inside = field.over(random.uniform(-0.2, 1.2, (2000, 2)))
    found = np.abs(np.linalg.eigvalsh(field.second_form(inside))).max(axis=1)
    half = random.uniform(0.0, 0.1, inside.shape)
    centre = inside + half * random.uniform(-1.0, 1.0, inside.shape)
    bound = field.curvature_bound(centre - half, centre + half)
    assert (found <= bound * (1.0 + 1e-12)).all()
    assert (found > 0.5 * bound)[found > 0.0].any()


@pytest.mark.parametrize("seed", range(20))
def test_showers_do_not_meet_and_leave_dry_ground(seed: int) -> None:
    field = rainfall(seed, 0.7, 0.0)  # refuses bumps that overlap
    assert 2 <= len(field.bumps) <= 6
    for bump in field.bumps:
        assert 0.7 * RAIN[0] <= bump.height / bump.width <= 0.7 * RAIN[1]
    plane = np.random.default_rng(seed).uniform(size=(4000, 2))
    dry = np.all([norm(plane - np.array(bump.place)) >= bump.width for bump in field.bumps], axis=0)
    assert dry.mean() > 0.1
    assert not field.height(plane)[dry].any()
    assert np.array_equal(field.normal(field.over(plane[dry])), np.tile([0.0, 0.0, 1.0], (dry.sum(), 1)))
    assert (field.height(plane)[~dry] > 0.0).all()


def test_bumps_that_overlap_or_are_dents_are_refused() -> None:
    with pytest.raises(ValueError, match="overlaps"):
        BumpField((BumpedPlane(0.5, 0.25, (0.25, 0.5)), BumpedPlane(0.1, 0.26, (0.75, 0.5))), 0.0)
    with pytest.raises(ValueError, match="positive"):
        BumpField((BumpedPlane(-0.5, 0.25, (0.25, 0.5)),), 0.0)


def test_random_heights_are_above_the_ground_and_most_are_low() -> None:
    heights = random_heights(5, 4000, 2.0, 0.25)
    assert 0.25 <= heights.min() < 0.2501
    assert 2.1 < heights.max() <= 2.25
    # the median of the fourth power
    assert np.median(heights) == pytest.approx(0.25 + 2.0 / 16.0, abs=0.03)
    assert not np.array_equal(heights, random_heights(6, 4000, 2.0, 0.25))


@pytest.mark.parametrize("step", [0, 1, 4])
def test_rough_middles_are_between_the_ground_and_a_little_more_than_the_mean(step: int) -> None:
    random = np.random.default_rng(1)
    start, end = random.uniform(0.25, 1.0, (2, 500, 3))
    middle = rough_middles(3, step, start, end, 0.25)
    mean = 0.5 * (start + end)
    assert np.array_equal(middle[:, :2], mean[:, :2])
    factor = (middle[:, 2] - 0.25) / (mean[:, 2] - 0.25)
    assert np.abs(factor - 1.0).max() <= ROUGHNESS * 0.5**step * (1.0 + 1e-9)
    assert factor.std() > 0.4 * ROUGHNESS * 0.5**step
