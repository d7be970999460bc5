from math import factorial

import numpy as np
import pytest

from testbed.geometry.domain import barycentric, corner_distance, lattice
from testbed.measures.sampling import CHUNK, chunks, lattice_steps, quadrature, sample_points


@pytest.mark.parametrize("p", range(7))
@pytest.mark.parametrize("q", range(7))
def test_the_triangle_rule_is_exact_to_degree_six_and_no_further(p: int, q: int) -> None:
    at, weights = quadrature(3)
    # mean of u^p v^q over the triangle
    exact = 2.0 * factorial(p) * factorial(q) / factorial(p + q + 2)
    assert (weights @ (at[:, 0] ** p * at[:, 1] ** q) == pytest.approx(exact, rel=1e-13)) == (p + q <= 6)


@pytest.mark.parametrize("p", range(8))
def test_the_square_rule_is_exact_to_degree_seven(p: int) -> None:
    at, weights = quadrature(4)
    assert weights @ (at[:, 0] ** p * at[:, 1] ** (7 - p)) == pytest.approx(1.0 / ((p + 1) * (8 - p)), rel=1e-13)


def test_the_triangle_rule_has_all_symmetries_of_the_triangle() -> None:
    at, weights = quadrature(3)
    b = barycentric(at)
    rows = {(round(w, 12), *np.round(row, 12)) for w, row in zip(weights, b, strict=True)}
    for permutation in ([1, 2, 0], [1, 0, 2]):
        assert {(round(w, 12), *np.round(row, 12)) for w, row in zip(weights, b[:, permutation], strict=True)} == rows


@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("margin", [0.0, 0.01])
def test_samples_hold_the_lattice_and_keep_curvature_off_the_corners(sides: int, margin: float) -> None:
    points = sample_points(sides, margin, 4)
    assert {tuple(row) for row in lattice(sides, 4)} <= {tuple(row) for row in points.at}
    assert points.weights.sum() == pytest.approx(1.0, abs=1e-14)
    distance = corner_distance(sides, points.at[points.curved])
    assert distance.min() >= margin * (1.0 - 1e-9)
    assert (np.abs(distance - margin) < 1e-12).sum() == (3 * sides if margin else sides)
    assert (~points.curved).sum() == (sides if margin else 0)
    inside = points.at.sum(axis=1) <= 1.0 + 1e-15 if sides == 3 else points.at.max(axis=1) <= 1.0
    assert (points.at >= 0.0).all()
    assert inside.all()


def test_the_lattice_gets_coarser_with_the_number_of_patches_and_keeps_the_budget() -> None:
    steps = [lattice_steps(patches, 3, 60_000) for patches in (1, 8, 500, 1000, 2000, 20_000)]
    assert steps == sorted(steps, reverse=True)
    assert steps[0] > steps[-1]
    for patches in (500, 1000):
        n = lattice_steps(patches, 3, 60_000)
        assert patches * (len(lattice(3, n)) + 12) <= 60_000


@pytest.mark.parametrize(("patches", "samples"), [(1, 22), (0, 22), (5000, 22), (3, 10 * CHUNK)])
def test_chunks_cover_every_patch_once(patches: int, samples: int) -> None:
    covered = np.concatenate([np.arange(patches)[some] for some in chunks(patches, samples)] + [np.arange(0)])
    np.testing.assert_array_equal(covered, np.arange(patches))
