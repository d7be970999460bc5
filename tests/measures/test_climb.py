"""The local search: maxima inside, on the boundary, at corners and along ridges, in few evaluations."""

from collections.abc import Callable

import numpy as np
import pytest

from testbed.geometry.domain import barycentric, corner_distance
from testbed.geometry.vectors import Bool, Float
from testbed.measures.climb import Climb, move

Function = Callable[[Float, Float], Float]


def climbed(function: Function, start: Float, sides: int = 3, margin: float = 0.0) -> tuple[Climb, int]:
    """Climb from points (N, 2) to the end; the search and the number of rounds it took."""

    def values(at: Float) -> Float:
        return function(at[..., 0], at[..., 1])

    climb = Climb.start(start, values(start), np.full(len(start), 0.15))
    rounds = 0
    while climb.active.any() and rounds < 40:
        (rows,) = np.nonzero(climb.active)
        climb.advance(rows, values, sides, margin)
        rounds += 1
    return climb, rounds


STARTS = np.array([[0.25, 0.25], [0.3, 0.1], [0.1, 0.6], [0.0, 0.4], [0.5, 0.5], [0.0, 0.0]])


@pytest.mark.parametrize(
    ("function", "place", "most"),
    [
        (lambda u, v: np.exp(-3.0 * (u - 0.31) ** 2 - 5.0 * (v - 0.22) ** 2 + (u - 0.31) ** 3), (0.31, 0.22), 9),
        (lambda u, v: np.cos(2.0 * (u - 0.47)) - v * (1.0 + u), (0.47, 0.0), 10),
        (lambda u, v: np.cos(2.0 * (u - 0.47)) - (1.0 - u - v), (0.47, 0.53), 15),
        (lambda u, v: -u - 2.0 * v - u * v, (0.0, 0.0), 15),
    ],
    ids=["inside", "on a side", "on the slanted side", "at a corner"],
)
def test_maxima_are_found_in_few_rounds(function: Function, place: tuple[float, float], most: int) -> None:
    climb, rounds = climbed(function, STARTS)
    best = float(function(*np.array(place)))
    np.testing.assert_allclose(climb.value, best, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(climb.at, np.broadcast_to(place, climb.at.shape), atol=1e-6)
    assert rounds <= most


def test_a_curved_ridge_is_followed_to_its_end() -> None:
    # 2 % of the height of the ridge across it, and the maximum at (0.1, 0.4)
    def ridge(u: Float, v: Float) -> Float:
        return -100.0 * (v - 0.4 + 2.0 * (u - 0.1) ** 2) ** 2 - (u - 0.1) ** 2

    climb, _ = climbed(ridge, np.array([[0.5, 0.05], [0.45, 0.2]]))
    np.testing.assert_allclose(climb.value, 0.0, atol=1e-10)


def test_a_candidate_does_as_it_does_alone() -> None:
    def function(u: Float, v: Float) -> Float:
        return np.sin(7.0 * u + 1.0) * np.cos(5.0 * v) + u * v

    together, _ = climbed(function, STARTS)
    alone = [climbed(function, STARTS[k : k + 1])[0] for k in range(len(STARTS))]
    np.testing.assert_array_equal(together.at, np.concatenate([one.at for one in alone]))
    np.testing.assert_array_equal(together.value, np.concatenate([one.value for one in alone]))


@pytest.mark.parametrize("seed", range(4))
def test_the_result_is_never_less_than_a_point_that_was_looked_at(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wave = rng.normal(size=(12, 2)) * 8.0
    most = np.full(len(STARTS), -np.inf)

    def rough(u: Float, v: Float) -> Float:
        total: Float = np.sin(u[..., None] * wave[:, 0] + v[..., None] * wave[:, 1] + np.arange(12.0)).sum(axis=-1)
        return total

    def watched(u: Float, v: Float) -> Float:
        values = rough(u, v)
        if values.ndim == 2 and len(values) == len(most):
            most[:] = np.maximum(most, values.max(axis=1))
        return values

    climb, _ = climbed(watched, STARTS)
    assert (climb.value >= most).all()
    np.testing.assert_allclose(rough(*climb.at.T), climb.value, rtol=1e-12)


def test_functions_of_the_direction_from_a_corner_are_searched_as_finely_as_they_vary() -> None:
    margin = 1e-6

    def directional(u: Float, v: Float) -> Float:
        share = u / (u + v)
        return -((share - 0.37) ** 2) - 0.1 * (u + v)

    climb, _ = climbed(directional, margin * np.array([[0.5, 0.5], [0.9, 0.1], [0.0, 1.0]]), margin=margin)
    np.testing.assert_allclose(climb.value, -0.1 * margin, atol=1e-12)
    assert (corner_distance(3, climb.at) >= margin * (1.0 - 1e-6)).all()


def test_a_nan_becomes_the_maximum_and_ends_the_search() -> None:
    def broken(u: Float, v: Float) -> Float:
        hole: Bool = np.asarray(u > 0.35)
        return np.where(hole, np.nan, u + v)

    climb, _ = climbed(broken, np.array([[0.3, 0.2], [0.1, 0.1]]))
    assert np.isnan(climb.value).all()
    assert not climb.active.any()


@pytest.mark.parametrize("sides", [3, 4])
def test_steps_stay_in_the_domain_and_off_the_corners(sides: int) -> None:
    rng = np.random.default_rng(sides)
    centre = rng.dirichlet((1, 1, 1), 200)[:, None, 1:]
    moved = move(centre, rng.normal(size=(200, 7, 2)), sides, 0.01)
    inside = barycentric(moved) if sides == 3 else np.concatenate([moved, 1.0 - moved], axis=-1)
    assert inside.min() >= -1e-15
    there = np.broadcast_to(corner_distance(sides, centre), moved.shape[:2])
    assert (corner_distance(sides, moved) >= np.minimum(0.01 * (1.0 - 1e-9), there)).all()
