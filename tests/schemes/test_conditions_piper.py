"""Piper's conditions: quartic joins share their tangent planes, and are the nearest to their candidates that do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.geometry.bernstein import derivative_curve, elevate_curve, elevate_triangle, evaluate_curve
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_schemes.continuity_conditions.piper import end_values, nearest_join, residual

T = np.linspace(0.0, 1.0, 21)
seeds = st.integers(0, 2**32 - 1)

#: Boundary, row and other row.
Edge = tuple[Float, Float, Float]


def random_edge(seed: int, change: float | None = None) -> Edge:
    """A generic candidate with coplanar ends; e and g differ from end to end by about ``change``."""
    rng = np.random.default_rng(seed)
    along = np.array([4.0, 0.0, 0.0])
    boundary = np.linspace(0.0, 1.0, 5)[:, None] * along + rng.uniform(-0.3, 0.3, (5, 3))
    rows = np.linspace(0.0, 0.75, 4)[:, None] * along + rng.uniform(-0.3, 0.3, (2, 4, 3))
    row, other = rows + np.array([[[0.5, 1.0, 0.0]], [[0.5, -1.0, 0.0]]])
    e0, g0 = rng.uniform(-1.0, 0.0), rng.uniform(0.3, 0.7)
    if change is None:
        e1, g1 = rng.uniform(-1.0, 0.0), rng.uniform(0.3, 0.7)
    else:
        e1, g1 = e0 + change * rng.uniform(0.5, 1.0), g0 + change * rng.uniform(0.5, 1.0)
    for here, beside, place, x, g in ((0, 1, 0, e0, g0), (4, 3, 3, -1.0 - e1, g1)):
        v, a = boundary[beside] - boundary[here], row[place] - boundary[here]
        other[place] = boundary[here] - (x * v + g * a) / (1.0 - g)
    return boundary, row, other


def apart(one: Edge, other: Edge) -> float:
    return max(float(np.abs(a - b).max()) for a, b in zip(one, other, strict=True))


def reversed_edge(edge: Edge) -> Edge:
    boundary, row, other = edge
    return boundary[..., ::-1, :], row[..., ::-1, :], other[..., ::-1, :]


def joined(edge: Edge) -> Edge:
    boundary, row, other, _ = nearest_join(*edge)
    return boundary, row, other


def printed_equations(edge: Edge) -> tuple[Float, Float]:
    """The 3 x 5 system as the thesis has it, for H2, F1, F2, G1, G2: matrix (3, 5) and right side (3, 3)."""
    H, F, G = edge
    (e0, e1), (f0, f1), (g0, g1), (h0, h1) = end_values(*edge)
    matrix = np.array(
        [
            [3 * e0, 3 * g0, 0.0, 3 * h0, 0.0],
            [2 * f0 + 2 * e1, 2 * g1, 2 * g0, 2 * h1, 2 * h0],
            [3 * f1, 0.0, 3 * g1, 0.0, 3 * h1],
        ]
    )
    known = np.stack(
        [
            3 * f0 * H[1] + e1 * H[1] + f1 * H[0] + g1 * F[0] + h1 * G[0],
            2 * e0 * H[3] + 2 * f1 * H[1],
            e0 * H[4] + f0 * H[3] + g0 * F[3] + h0 * G[3] + 3 * e1 * H[3],
        ]
    )
    return matrix, -known


def joined_as_printed(edge: Edge) -> Edge:
    """The nearest solution of the printed equations, by pseudo-inverse."""
    boundary, row, other = (points.copy() for points in edge)
    matrix, right = printed_equations(edge)
    unknowns = np.stack([boundary[2], row[1], row[2], other[1], other[2]])
    boundary[2], row[1], row[2], other[1], other[2] = unknowns + np.linalg.pinv(matrix, rcond=1e-10) @ (
        right - matrix @ unknowns
    )
    return boundary, row, other


def largest_determinant(edge: Edge) -> float:
    """Of the boundary's derivative and both cross-boundary derivatives along the edge, over their sizes."""
    boundary, row, other = edge
    fields = (derivative_curve(boundary), row - boundary[:-1], other - boundary[:-1])
    h, f, g = (evaluate_curve(field, T)[0] for field in fields)
    return float(np.abs(dot(h, cross(f, g))).max() / np.prod([norm(field).max() for field in (h, f, g)]))


@given(seeds)
def test_the_fields_share_a_plane_along_the_whole_edge(seed: int) -> None:
    edge = random_edge(seed)
    assert largest_determinant(joined(edge)) < 1e-13
    assert np.abs(residual(*joined(edge))).max() < 1e-13
    assert largest_determinant(edge) > 1e-6


@given(seeds)
def test_the_end_values_are_the_printed_ones_in_our_scale(seed: int) -> None:
    H, F, G = edge = random_edge(seed)
    e, f, g, h = end_values(*edge)
    assert g + h == pytest.approx(np.ones(2), abs=1e-14)
    assert e + f == pytest.approx(-np.ones(2), abs=1e-14)
    assert e[0] * H[1] + f[0] * H[0] + g[0] * F[0] + h[0] * G[0] == pytest.approx(np.zeros(3), abs=1e-13)
    assert e[1] * H[4] + f[1] * H[3] + g[1] * F[3] + h[1] * G[3] == pytest.approx(np.zeros(3), abs=1e-13)


@given(seeds)
def test_only_the_five_points_move(seed: int) -> None:
    edge = random_edge(seed)
    moved = [(a != b).any(axis=-1).tolist() for a, b in zip(edge, joined(edge), strict=True)]
    assert moved == [[False, False, True, False, False], [False, True, True, False], [False, True, True, False]]


@given(seeds)
def test_the_join_is_the_nearest_solution_of_the_printed_equations(seed: int) -> None:
    edge = random_edge(seed, change=0.2)
    assert apart(joined(edge), joined_as_printed(edge)) < 1e-11


@given(seeds)
def test_a_join_stays(seed: int) -> None:
    edge = joined(random_edge(seed))
    assert apart(joined(edge), edge) < 1e-13


@given(seeds)
def test_patches_and_directions_are_alike(seed: int) -> None:
    boundary, row, other = edge = random_edge(seed)
    result = joined(edge)
    exchanged = joined((boundary, other, row))
    assert apart((exchanged[0], exchanged[2], exchanged[1]), result) < 1e-13
    assert apart(reversed_edge(joined(reversed_edge(edge))), result) < 1e-13


def test_a_batch_gives_what_its_edges_give_alone() -> None:
    edges = [random_edge(seed) for seed in range(6)]
    boundary, row, other = (np.stack(points).reshape(3, 2, -1, 3) for points in zip(*edges, strict=True))
    together = joined((boundary, row, other))
    alone = joined(edges[3])
    assert all(np.array_equal(batch[1, 1], one) for batch, one in zip(together, alone, strict=True))


@pytest.mark.parametrize("change", [1e-3, 1e-6, 3e-9, 3e-10])
def test_nearly_constant_factors_do_not_cost_the_join_any_digits(change: float) -> None:
    """The numerical trouble of the scheme: the printed equations divide their rounding by the change of e and g."""
    edges = [random_edge(seed, change) for seed in range(20)]
    assert max(largest_determinant(joined(edge)) for edge in edges) < 1e-14
    assert max(apart(joined(edge), edge) for edge in edges) < 1.0
    assert max(largest_determinant(joined_as_printed(edge)) for edge in edges) > 1e-18 / change


@given(seeds)
def test_raised_cubics_fulfil_the_equation_of_the_fourth_power_from_the_start(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one, two = rng.normal(size=(2, 10, 3))
    two[[0, 2, 5, 9]] = one[[0, 1, 3, 6]]  # side 0 of one is side 2 of the other, run back
    boundary = elevate_triangle(one)[[0, 1, 3, 6, 10]]
    row, other = elevate_triangle(one)[[2, 4, 7, 11]], elevate_triangle(two)[[1, 4, 8, 13]]
    assert boundary == pytest.approx(elevate_curve(one[[0, 1, 3, 6]]), abs=1e-15)
    assert np.abs(np.diff(boundary, 4, axis=0)).max() < 1e-13
    assert np.abs(np.diff(row - other, 3, axis=0)).max() < 1e-13


def test_ends_without_a_plane_give_nan_and_no_points() -> None:
    boundary, row, other = random_edge(1)
    boundary[1] = boundary[0]
    assert np.isnan(joined((boundary, row, other))[0][2]).all()
    boundary, row, other = random_edge(1)
    other[3] = row[3]
    assert np.isnan(joined((boundary, row, other))[1][1]).all()


def test_constant_factors_leave_two_equations() -> None:
    for seed in range(5):
        edge = random_edge(seed, change=0.0)
        assert np.linalg.matrix_rank(printed_equations(edge)[0], tol=1e-10) == 2
        assert nearest_join(*edge)[3]
        assert apart(joined(edge), joined_as_printed(edge)) < 1e-13
        assert largest_determinant(joined(edge)) < 1e-13
        assert not nearest_join(*random_edge(seed))[3]
