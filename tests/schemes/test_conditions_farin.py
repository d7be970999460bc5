"""Farin's conditions: rows that fulfil them join in one tangent plane, for every degree; inner spokes fulfil them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testbed.conformance.meshes import perturbed_icosahedron
from testbed.geometry.bernstein import derivative_curve, elevate_curve, evaluate_curve
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_schemes.continuity_conditions.farin import end_weights, matching_row, residual
from testbed_schemes.jensen import Jensen
from testbed_schemes.mathematics.split_domain import J
from testbed_schemes.shirman_sequin import ShirmanSequin

T = np.linspace(0.0, 1.0, 21)
seeds = st.integers(0, 2**32 - 1)
degrees = st.sampled_from([3, 4, 5])


class EdgeCase:
    """A random boundary of degree n - 1 with a random second row of degree n, and weights at both ends."""

    def __init__(self, seed: int, degree: int) -> None:
        self.rng = np.random.default_rng(seed)
        along = np.linspace(0.0, 1.0, degree)[:, None] * np.array([3.0, 0.0, 0.0])
        self.boundary = along + self.rng.uniform(-0.3, 0.3, (degree, 3))
        self.row = along + np.array([0.5, 1.0, 0.0]) + self.rng.uniform(-0.3, 0.3, (degree, 3))
        alpha = -self.rng.uniform(0.3, 3.0)
        second, third = self.rng.uniform(-1.0, 2.0, 2)
        self.start = np.array([1.0 - second - alpha, second, alpha])
        self.end = np.array([third, 1.0 - third - alpha, alpha])

    def other(self) -> Float:
        return matching_row(self.boundary, self.row, self.start, self.end)


def largest_determinant(boundary: Float, row: Float, other: Float) -> float:
    """Of the boundary's derivative and both cross-boundary derivatives along the edge, over their sizes."""
    raised = elevate_curve(boundary)
    fields = [derivative_curve(boundary), row - raised[:-1], other - raised[:-1]]
    h, f, g = (evaluate_curve(field, T)[0] for field in fields)
    return float(np.abs(dot(h, cross(f, g))).max() / np.prod([norm(field).max() for field in (h, f, g)]))


@given(seeds, degrees)
def test_rows_that_fulfil_the_conditions_share_a_tangent_plane_along_the_edge(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    assert largest_determinant(edge.boundary, edge.row, edge.other()) < 1e-13


@given(seeds, degrees)
def test_weights_are_found_from_the_ends_and_nothing_is_left(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    start, end = end_weights(edge.boundary, edge.row, edge.other())
    assert start == pytest.approx(edge.start, abs=1e-11)
    assert end == pytest.approx(edge.end, abs=1e-11)
    assert np.abs(residual(edge.boundary, edge.row, edge.other())).max() < 1e-11


@given(seeds, degrees)
def test_the_conditions_are_the_printed_ones(seed: int, degree: int) -> None:
    """Point by point as in the thesis, and at the ends (2.1); H_n and H_{-1} would come with the factor zero."""
    edge = EdgeCase(seed, degree)
    n, H, F = degree, edge.boundary, edge.row
    (a1, a2, alpha), (a3, a4, _) = edge.start, edge.end
    expected = [a1 * H[0] + a2 * H[1] + alpha * F[0]]
    expected += [
        (n - 1 - i) / (n - 1) * (a1 * H[i] + a2 * H[i + 1] + alpha * F[i])
        + i / (n - 1) * (a3 * H[i - 1] + a4 * H[i] + alpha * F[i])
        for i in range(1, n - 1)
    ]
    expected += [a3 * H[n - 2] + a4 * H[n - 1] + alpha * F[n - 1]]
    assert edge.other() == pytest.approx(np.stack(expected), abs=1e-13)


@given(seeds, degrees)
def test_indices_shifted_by_one_break_the_join(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    wrong = edge.other()
    start, end = (weights[[1, 0, 2]] for weights in (edge.start, edge.end))
    wrong[1:-1] = matching_row(edge.boundary, edge.row, start, end)[1:-1]
    assert largest_determinant(edge.boundary, edge.row, wrong) > 1e-6


@given(seeds, degrees)
def test_a_point_out_of_its_place_is_seen(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    moved = edge.other()
    moved[1] += [0.0, 0.0, 1e-3]
    assert residual(edge.boundary, edge.row, moved)[1] == pytest.approx([0.0, 0.0, 1e-3], abs=1e-11)


@given(seeds, degrees)
def test_ends_with_different_ratios_are_seen(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    moved = edge.other()
    moved[-1] += 0.1 * (edge.row[-1] - edge.boundary[-1])
    assert np.abs(residual(edge.boundary, edge.row, moved)[[0, -1]]).max() > 1e-5


@given(seeds, degrees)
def test_patches_and_directions_are_alike(seed: int, degree: int) -> None:
    edge = EdgeCase(seed, degree)
    other = edge.other()
    assert np.abs(residual(edge.boundary, other, edge.row)).max() < 1e-11
    assert np.abs(residual(edge.boundary[::-1], edge.row[::-1], other[::-1])).max() < 1e-11


def test_a_batch_gives_what_its_edges_give_alone() -> None:
    boundary, row, other = np.random.default_rng(2).normal(size=(3, 6, 2, 4, 3))
    alone = residual(boundary[4, 1], row[4, 1], other[4, 1])
    assert np.array_equal(residual(boundary, row, other)[4, 1], alone)


def test_one_alpha_must_serve_both_ends() -> None:
    edge = EdgeCase(1, 4)
    with pytest.raises(ValueError, match="differs from alpha at its end"):
        matching_row(edge.boundary, edge.row, edge.start, edge.end + np.array([0.5, 0.0, -0.5]))


def spokes(surface: Surface) -> tuple[Float, Float, Float]:
    """Cubic spokes from V_k to S with the second rows of sub-patches i and j, (F, 3, 4, 3) each."""
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    net = batch.control_points.reshape(-1, 3, 15, 3)
    spoke = net[:, :, [10, 11, 12, 13, 14]]
    first, last = (4 * spoke[:, :, 1] - spoke[:, :, 0]) / 3, (4 * spoke[:, :, 3] - spoke[:, :, 4]) / 3
    cubic = np.stack([spoke[:, :, 0], first, last, spoke[:, :, 4]], axis=2)
    assert elevate_curve(cubic) == pytest.approx(spoke, abs=1e-14)
    return cubic, net[:, :, [6, 7, 8, 9]], net[:, J][:, :, [1, 4, 8, 13]]


@pytest.mark.parametrize("alpha2", [2.25, 1.75, 3.0])
def test_the_spokes_of_shirman_and_sequin_fulfil_them_with_one_ratio(alpha2: float) -> None:
    edge = spokes(ShirmanSequin(alpha2=alpha2).fit(perturbed_icosahedron()))
    assert np.abs(residual(*edge)).max() < 1e-13
    start, end = end_weights(*edge)
    assert start == pytest.approx(np.broadcast_to([2.0 - alpha2, alpha2, -1.0], start.shape), abs=1e-10)
    # Mann 1992, section 2.3.1: S the centroid of the I_i2
    assert end == pytest.approx(np.broadcast_to([-0.75, 2.75, -1.0], end.shape), abs=1e-10)


def test_spokes_with_different_alphas_fulfil_them_too() -> None:
    mesh = perturbed_icosahedron()
    alphas = tuple(np.random.default_rng(3).uniform(1.2, 3.0, len(mesh.points)).tolist())
    assert np.abs(residual(*spokes(ShirmanSequin(alpha2=alphas).fit(mesh)))).max() < 1e-13


def test_the_conditions_are_sufficient_only() -> None:
    """The rows of a Chiyokura-Kimura join share their tangent planes; one ratio along the edge they have not."""
    mesh = perturbed_icosahedron()
    surface = Jensen().fit(mesh)
    edges = surface.edges[surface.edges.interior & ~surface.edges.within_face]
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    left, right = batch.control_points[edges.left.patch[0]], batch.control_points[edges.right.patch[0]]
    raised, row, other = left[[0, 1, 3, 6, 10]], left[[2, 4, 7, 11]], right[[11, 7, 4, 2]]
    cubic = np.stack([raised[0], (4 * raised[1] - raised[0]) / 3, (4 * raised[3] - raised[4]) / 3, raised[4]])
    assert largest_determinant(cubic, row, other) < 1e-14
    assert np.abs(residual(cubic, row, other)).max() > 1e-3
