"""Linear coefficients in the G1 condition of two quartics: the condition holds, and what is free and what is not."""

import numpy as np
import pytest

from testbed.geometry.bernstein import elevate_curve, elevate_triangle, reparametrise_triangle
from testbed.geometry.nets import inner_indices, side_indices
from testbed.geometry.vectors import Float, cross, norm, tangential, unit
from testbed_schemes.mathematics.linear_g1 import (
    LinearG1,
    SharedEdge,
    boundary,
    first_rows,
    free_vector,
    linear_g1,
    parallel_row,
)

EDGES = 300


def random_edges(seed: int, kappa: float | None = None) -> SharedEdge:
    """Edges with random ends, whose patches lie on different sides; kappa between 1/8 and 8."""
    random = np.random.default_rng(seed)
    n0, n1 = unit(random.normal(size=(2, EDGES, 3)))
    corners = random.normal(size=(2, EDGES, 3))
    legs = [tangential(random.normal(size=(EDGES, 3)), n) for n in (n0, n1)]
    ratio = 8.0 ** random.uniform(-1.0, 1.0, EDGES) if kappa is None else np.full(EDGES, kappa)
    first, last = corners[0] + legs[0], corners[1] + legs[1]
    c = np.stack([corners[0], first, boundary(corners[0], first, last, corners[1], ratio), last, corners[1]], axis=1)
    beside = []
    for sign in (1.0, -1.0):
        for corner, along, normal in ((corners[0], legs[0], n0), (corners[1], -legs[1], n1)):
            sideways = sign * random.uniform(0.3, 2.0, (EDGES, 1)) * cross(normal, along)
            beside.append(corner + sideways + random.normal(size=(EDGES, 1)) * along)
    p0, p3, q0, q3 = beside
    return SharedEdge(c, p0, p3, q0, q3, ratio, n0, n1)


def rows(edge: SharedEdge, g1: LinearG1) -> tuple[Float, Float]:
    """Second rows (E, 4, 3) on the left and on the right."""
    p1, p2, q1, q2 = first_rows(edge, g1, free_vector(edge, g1))
    return np.stack([edge.p0, p1, p2, edge.p3], axis=1), np.stack([edge.q0, q1, q2, edge.q3], axis=1)


def residuals(edge: SharedEdge, left: Float, right: Float, alpha: Float, beta: Float, gamma: Float) -> Float:
    """Bernstein coefficients (E, 5, 3) of alpha D1 + beta D2 + gamma D3, coefficients (E, 2) with their kappa."""
    legs = (left - edge.c[:, :4], right - edge.c[:, :4], np.diff(edge.c, axis=1))
    total = np.zeros((len(edge.c), 5, 3))
    for coefficient, vectors in zip((alpha, beta, gamma), legs, strict=True):
        for j in range(4):
            total[:, j] += (4 - j) * coefficient[:, :1] * vectors[:, j]
            total[:, j + 1] += (j + 1) * coefficient[:, 1:] * vectors[:, j]
    return total


def coefficients(edge: SharedEdge, g1: LinearG1) -> tuple[Float, Float, Float]:
    """Those of the condition, at t = 1 multiplied by kappa."""
    factor = np.stack([np.ones(EDGES), edge.kappa], axis=-1)
    return g1.alpha * factor, g1.beta * factor, g1.gamma * factor


def reversed_edge(edge: SharedEdge) -> SharedEdge:
    """Return the edges run the other way: left and right change places."""
    return SharedEdge(edge.c[:, ::-1], edge.q3, edge.q0, edge.p3, edge.p0, 1.0 / edge.kappa, edge.n1, edge.n0)


@pytest.mark.parametrize("kappa", [None, 1.0])
def test_the_condition_holds_with_any_kappa(kappa: float | None) -> None:
    edge = random_edges(1, kappa)
    g1 = linear_g1(edge)
    found = norm(residuals(edge, *rows(edge, g1), *coefficients(edge, g1)))
    size = np.abs(edge.c).max(axis=(1, 2)) * (1.0 + edge.kappa) * (1.0 + np.abs(g1.gamma).max(axis=1)) * 16.0
    assert (found.max(axis=1) / size).max() < 1e-14
    assert not g1.opposed.any()


def test_it_holds_with_any_free_vector() -> None:
    edge = random_edges(2)
    g1 = linear_g1(edge)
    p1, p2, q1, q2 = first_rows(edge, g1, np.random.default_rng(0).normal(size=(EDGES, 3)))
    left = np.stack([edge.p0, p1, p2, edge.p3], axis=1)
    right = np.stack([edge.q0, q1, q2, edge.q3], axis=1)
    size = 100.0 * (1.0 + edge.kappa**3 + edge.kappa**-3) * (1.0 + np.abs(g1.gamma).max(axis=1))
    assert (norm(residuals(edge, left, right, *coefficients(edge, g1))).max(axis=1) / size).max() < 1e-14


def test_gamma_as_printed_in_3_2_fails() -> None:
    """There gamma starts with alpha_0."""
    edge = random_edges(3, 1.0)
    g1 = linear_g1(edge)
    alpha, beta, gamma = coefficients(edge, g1)
    printed = np.stack([alpha[:, 0], gamma[:, 1]], axis=-1)
    assert norm(residuals(edge, *rows(edge, g1), alpha, beta, gamma)).max() < 1e-11
    assert np.median(norm(residuals(edge, *rows(edge, g1), alpha, beta, printed)).max(axis=1)) > 1.0


def test_the_boundary_is_a_raised_cubic_for_kappa_1_and_a_quartic_for_another() -> None:
    fourth = [1.0, -4.0, 6.0, -4.0, 1.0]
    for kappa, least, most in ((1.0, 0.0, 1e-13), (2.0, 1e-3, np.inf)):
        size = norm(np.einsum("k,ekc->ec", fourth, random_edges(4, kappa).c))
        assert least <= size.min()
        assert size.max() < most
    cubic = np.random.default_rng(4).normal(size=(7, 4, 3))
    raised = elevate_curve(cubic)
    middle = boundary(raised[:, 0], raised[:, 1], raised[:, 3], raised[:, 4], np.ones(7))
    assert middle == pytest.approx(raised[:, 2], abs=1e-14)


def test_no_rows_meet_the_condition_over_another_boundary_where_alpha_is_constant() -> None:
    """The coefficient j = 2 then does not contain w1 and w2."""
    edge = random_edges(5, 1.0)
    # the legs at the end are those at the start, the rows slid along them, which changes gamma; c2 is not the cubic's
    c0, c4, along = edge.c[:, 0], edge.c[:, 4], edge.c[:, 1] - edge.c[:, 0]
    left, right = edge.p0 - c0, edge.q0 - c0
    c = np.stack([c0, c0 + along, 0.5 * (c0 + c4) + 0.2 * edge.n1, c4 - along, c4], axis=1)
    other = SharedEdge(
        c, c0 + left, c4 + left - 2.0 * along, c0 + right, c4 + right - 1.5 * along, edge.kappa, edge.n0, edge.n0
    )
    g1 = linear_g1(other)
    assert g1.alpha[:, 0] == pytest.approx(g1.alpha[:, 1], abs=1e-12)
    assert np.abs(g1.gamma[:, 0] - g1.gamma[:, 1]).min() > 1e-3
    found = norm(residuals(other, *rows(other, g1), *coefficients(other, g1))[:, 2])
    bracket = norm(np.einsum("k,ekc->ec", [-1.0, 3.0, -3.0, 1.0], np.diff(c, axis=1)))
    assert found == pytest.approx(2.0 / 3.0 * np.abs(g1.gamma[:, 1] - g1.gamma[:, 0]) * bracket, rel=1e-6)
    assert found.min() > 1e-4


def test_the_result_does_not_depend_on_the_direction_of_the_edge() -> None:
    edge = random_edges(6)
    back = reversed_edge(edge)
    c0, c1, _, c3, c4 = np.moveaxis(back.c, 1, 0)
    assert boundary(c0, c1, c3, c4, back.kappa) == pytest.approx(edge.c[:, 2], abs=1e-12)
    left, right = rows(edge, linear_g1(edge))
    other_left, other_right = rows(back, linear_g1(back))
    size = 1.0 + np.abs(left).max() + np.abs(right).max()
    assert np.abs(other_left[:, ::-1] - right).max() < 1e-12 * size
    assert np.abs(other_right[:, ::-1] - left).max() < 1e-12 * size


def test_rows_with_a_linear_derivative_along_1_m1_0_would_depend_on_it() -> None:
    edge = random_edges(7)

    def skewed(c: Float, first: Float, last: Float) -> tuple[Float, Float]:
        start, end = first - c[:, 0], last - c[:, 3]
        return c[:, 1] + (2.0 * start + end) / 3.0, c[:, 2] + (start + 2.0 * end) / 3.0

    for row, most, least in ((parallel_row, 1e-13, 0.0), (skewed, np.inf, 0.1)):
        one, other = row(edge.c, edge.p0, edge.p3)
        back_one, back_other = row(edge.c[:, ::-1], edge.p3, edge.p0)
        apart = np.maximum(norm(one - back_other), norm(other - back_one))
        assert least <= apart.max() < most


def test_the_free_vector_brings_the_rows_nearest_to_the_parallel_ones() -> None:
    edge = random_edges(8)
    g1 = linear_g1(edge)
    wanted = np.stack([*parallel_row(edge.c, edge.p0, edge.p3), *parallel_row(edge.c, edge.q0, edge.q3)])
    best = free_vector(edge, g1)

    def distance(w1: Float) -> Float:
        return np.asarray((norm(np.stack(first_rows(edge, g1, w1)) - wanted) ** 2).sum(axis=0))

    random = np.random.default_rng(0)
    for _ in range(5):
        assert (distance(best + random.normal(size=(EDGES, 3))) > distance(best)).all()
    # the derivative vanishes
    step = 1e-3 * random.normal(size=(EDGES, 3))
    slope = distance(best + step) - distance(best - step)
    assert np.abs(slope).max() < 1e-10 * (1.0 + distance(best).max())


def test_rows_of_adjacent_pieces_of_a_quadratic_patch_come_out() -> None:
    net = elevate_triangle(np.random.default_rng(9).normal(size=(EDGES, 6, 3)), 2)
    corners = np.array([[0.1, 0.2, 0.7], [0.3, 0.5, 0.2], [0.0, 0.9, 0.1], [0.7, 0.1, 0.2]])
    left, right = (reparametrise_triangle(net, corners[pick]) for pick in ([0, 1, 2], [1, 0, 3]))
    outer, inner = side_indices(4), inner_indices(4)
    c = left[:, outer[0]]
    first, last = left[:, outer[2, 3]], left[:, outer[1, 1]]  # next to corner 0 and to corner 1, towards corner 2
    other_first, other_last = right[:, outer[1, 1]], right[:, outer[2, 3]]
    n0, n1 = (unit(cross(a, b)) for a, b in ((c[:, 1] - c[:, 0], first - c[:, 0]), (c[:, 3] - c[:, 4], c[:, 4] - last)))
    edge = SharedEdge(c, first, last, other_first, other_last, np.ones(EDGES), n0, n1)
    p1, p2, q1, q2 = first_rows(edge, linear_g1(edge), free_vector(edge, linear_g1(edge)))
    for row, place in (
        (p1, left[:, inner[0]]),
        (p2, left[:, inner[1]]),
        (q1, right[:, inner[1]]),
        (q2, right[:, inner[0]]),
    ):
        assert row == pytest.approx(place, abs=1e-10)


def test_patches_on_the_same_side_of_the_edge_are_told() -> None:
    edge = random_edges(10)
    folded = SharedEdge(
        edge.c, edge.p0, edge.p3, 3.0 * edge.p0 - 2.0 * edge.c[:, 0], edge.q3, edge.kappa, edge.n0, edge.n1
    )
    assert linear_g1(folded).opposed[:, 0].all()
    assert not linear_g1(folded).opposed[:, 1].any()


def test_edges_do_not_depend_on_others() -> None:
    edge = random_edges(11)
    p1, _, _, q2 = first_rows(edge, linear_g1(edge), free_vector(edge, linear_g1(edge)))
    one = SharedEdge(*(value[17:18] for value in vars(edge).values()))
    alone = first_rows(one, linear_g1(one), free_vector(one, linear_g1(one)))
    assert np.array_equal(alone[0][0], p1[17])
    assert np.array_equal(alone[3][0], q2[17])
