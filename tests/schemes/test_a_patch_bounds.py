"""Bounds of A-patches' free coefficients: the paper's figures, sharpness, dense samples, invariances, hostile faces."""

from collections.abc import Callable

import numpy as np
import pytest
from a_patch_functions import edge_rays, face_rays
from single_faces import FIGURE6, FIGURE7, FIGURE9, common_edge, figure, nets_of, random_faces

from testbed.geometry.cubic_roots import bracketed_roots
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.a_patch_bounds import above, edge_bounds, edge_factor, face_bounds, raised_bounds
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets, FacePieces, face_nets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets
from testbed_schemes.mathematics.a_patch_shooting import shooting_bound

FIGURES = [(FIGURE6, (False, False)), (FIGURE7, (False, True)), (FIGURE9, (True, True))]


def of_pieces(pieces: FacePieces) -> Float:
    return face_bounds(pieces.layer0, pieces.rational, pieces.layer1, pieces.q)


def of_faces(nets: FaceNets) -> Float:
    pieces = nets.pieces()
    result = np.full(len(nets), -np.inf)
    np.maximum.at(result, pieces.owner, of_pieces(pieces))
    return result


def of_edges(edges: EdgeNets) -> Float:
    return edge_bounds(edges.nets, edges.rational, edges.mu, edges.nu)


def magnitude(pieces: FacePieces) -> Float:
    layers = (pieces.layer0, pieces.rational, pieces.layer1, pieces.q)
    return np.asarray(np.stack([np.abs(layer).max(axis=1) for layer in layers]).max(axis=0))


def first_roots_on(rays: Float) -> tuple[Float, Float]:
    """First roots of rays (N, S, 4) that start below zero, and slopes there; infinite for others, NaN if none."""
    below = rays[..., 0] < -1e-13 * np.abs(rays).max(axis=-1)
    t = np.where(below, bracketed_roots(np.where(below[..., None], rays, -1.0)), np.inf)
    s, r = np.where(below, t, 0.5), np.where(below, 1.0 - t, 0.5)
    d0, d1, d2 = np.moveaxis(np.diff(rays, axis=-1), -1, 0)
    return t, np.where(below, 3.0 * (d0 * r * r + 2.0 * d1 * r * s + d2 * s * s), np.inf)


def sampled(pieces: FacePieces, steps: int) -> Float:
    """The largest threshold on a lattice, from F itself."""
    rays = face_rays(pieces, np.zeros(len(pieces.owner)), barycentric(lattice(3, steps)))
    below = rays[..., 0] < -1e-13 * np.abs(rays).max(axis=-1)
    rays = np.where(below[..., None], rays, -1.0)
    bound = shooting_bound(*np.moveaxis(rays, -1, 0))
    return np.asarray(np.where(below, bound, -np.inf).max(axis=1))


def test_figure_6() -> None:
    """The bound of both faces is taken at the middle of an edge, where the number 3 coefficient is zero."""
    nets = figure(FIGURE6, (False, False))
    bounds = of_faces(nets)
    assert np.abs(nets.apex[:, 2] - nets.base.mean(axis=1)[:, 2]).min() > 4.0
    assert np.abs(bounds + 1.0).max() < 1e-10
    assert np.abs(of_edges(common_edge(nets, bounds, FIGURE6)) - 0.12586806).max() < 1e-8


def test_figure_7() -> None:
    nets = figure(FIGURE7, (False, True))
    bounds = of_faces(nets)
    raised = raised_bounds(bounds, of_edges(common_edge(nets, bounds, FIGURE7)), np.array([[1, 0]]))
    assert abs(raised[0] - 0.57101838) < 1e-8


@pytest.mark.parametrize("excess", [1e-4, 1e-2, 1.0])
def test_above_the_bound_all_first_roots_on_faces_are_simple(excess: float) -> None:
    pieces = random_faces(60, 1).pieces()
    bounds = of_pieces(pieces)
    asked = np.flatnonzero(np.isfinite(bounds) & (bounds > -50.0))
    pieces = take(pieces, asked)
    top = bounds[asked] + excess * magnitude(pieces)
    roots, slopes = first_roots_on(face_rays(pieces, top, barycentric(lattice(3, 40))))
    assert not np.isnan(roots).any()
    assert (slopes > 0.0).all()


def test_below_the_bound_first_roots_on_faces_are_missing_or_jump() -> None:
    pieces = random_faces(60, 2).pieces()
    bounds = of_pieces(pieces)
    asked = np.flatnonzero(np.isfinite(bounds) & (bounds > -5.0))
    pieces = take(pieces, asked)
    q = barycentric(lattice(3, 80))
    change = 1e-2 * np.maximum(magnitude(pieces), np.abs(bounds[asked]))
    good, _ = first_roots_on(face_rays(pieces, bounds[asked] + 1e-3 * change, q))
    bad, _ = first_roots_on(face_rays(pieces, bounds[asked] - change, q))
    with np.errstate(invalid="ignore"):  # infinite where nothing is asked
        jumps = np.isnan(bad) | (bad - good > 0.05)
    assert not np.isnan(good).any()
    assert jumps.any(axis=1).all()
    assert np.isnan(bad).any(axis=1).mean() > 0.5


def test_at_the_bound_the_least_slope_goes_to_zero() -> None:
    nets = figure(FIGURE6, (False, False))
    pieces, bounds = nets.pieces(), of_faces(nets)
    q = barycentric(lattice(3, 60))
    least = [first_roots_on(face_rays(pieces, bounds + excess, q))[1].min() for excess in (1.0, 1e-2, 1e-4, 1e-6)]
    # a double root opens like the square root
    assert np.allclose(np.diff(np.log10(least)), -1.0, atol=0.15)


@pytest.mark.parametrize("seed", [3, 4])
def test_no_dense_sample_of_faces_is_above_the_bound(seed: int) -> None:
    pieces = random_faces(100, seed).pieces()
    bounds, dense = of_pieces(pieces), sampled(pieces, 64)
    assert (dense <= bounds + 1e-10 * magnitude(pieces)).all()
    # and the bound is near, where anything is asked
    near = np.isfinite(dense) & (dense > -10.0)
    assert near.sum() > 100
    assert np.abs(bounds[near] - dense[near]).max() < 0.5
    assert np.median(bounds[near] - dense[near]) < 1e-4


def test_the_bound_of_edges_is_what_both_coefficients_lack() -> None:
    """Raising both by b lowers it by b: the factor is right."""
    for vectors, split in FIGURES:
        nets = figure(vectors, split)
        start = np.array([-1.0, -0.7])
        bound = of_edges(common_edge(nets, start, vectors))[0]
        for further in (0.3, 1.7):
            assert abs(of_edges(common_edge(nets, start + further, vectors))[0] - (bound - further)) < 1e-9


@pytest.mark.parametrize(("vectors", "split"), FIGURES)
def test_the_bound_of_edges_is_sharp(vectors: Float, split: tuple[bool, bool]) -> None:
    nets = figure(vectors, split)
    start = np.array([-1.5, -1.0])
    bound = of_edges(common_edge(nets, start, vectors))
    at = lattice(4, 60)
    roots, slopes = first_roots_on(edge_rays(common_edge(nets, start + bound + 1e-4, vectors), at))
    assert not np.isnan(roots).any()
    assert 0.0 < slopes.min() < 0.5
    assert np.isnan(first_roots_on(edge_rays(common_edge(nets, start + bound - 1e-2, vectors), at))[0]).any()


@pytest.mark.parametrize(("vectors", "split"), FIGURES)
def test_no_dense_sample_of_edges_is_above_the_bound(vectors: Float, split: tuple[bool, bool]) -> None:
    nets = figure(vectors, split)
    edges = common_edge(nets, np.array([-1.0, 0.2]), vectors)
    at = lattice(4, 150)
    rays = edge_rays(edges, at)
    below = rays[..., 0] < -1e-13
    factor = edge_factor(at[:, 1], edges.mu[:, 3], edges.nu[:, 0])
    b0, b1, b2, b3 = np.moveaxis(np.where(below[..., None], rays, -1.0), -1, 0)
    bound = shooting_bound(b0, b1, b2, b3, factor)
    dense = np.where(below, bound, -np.inf).max()
    assert 0.0 <= of_edges(edges)[0] - dense + 1e-12 < 1e-3


def test_the_printed_factor_is_the_short_one() -> None:
    y = np.linspace(0.0, 1.0, 11)
    for mu4, nu1 in ((0.3, 0.7), (-1.2, 2.0)):
        printed = (1 - y) ** 3 + 2 * nu1 * y * (1 - y) ** 2 + 2 * mu4 * y**2 * (1 - y) + y**3 + y * (1 - y)
        assert np.abs(edge_factor(y, np.full(11, mu4), np.full(11, nu1)) - printed).max() < 1e-14


def test_a_factor_that_is_not_positive_helps_only_edges_that_lack_nothing() -> None:
    edges = common_edge(figure(FIGURE6, (False, False)), np.array([-1.0, -1.0]), FIGURE6)
    wide = np.array([[0.0, 0.0, 0.0, -3.0]])
    assert of_edges(edges)[0] > 0.0
    assert np.isnan(edge_bounds(edges.nets, edges.rational, wide, wide[:, ::-1])).all()
    good = common_edge(figure(FIGURE6, (False, False)), np.array([5.0, 5.0]), FIGURE6)
    assert edge_bounds(good.nets, good.rational, wide, wide[:, ::-1])[0] < 0.0


def test_faces_and_edges_are_raised_by_the_largest_positive_bound() -> None:
    bounds = np.array([1.0, 2.0, 3.0, 4.0])
    rows = np.array([[0, 1], [1, 2], [2, 0]])
    assert raised_bounds(bounds, np.array([0.5, -1.0, 0.25]), rows).tolist() == [1.5, 2.5, 3.25, 4.0]
    assert np.isnan(raised_bounds(bounds, np.array([np.nan, -1.0, 0.25]), rows)).tolist() == [True, True, False, False]


def test_a_choice_below_its_bound_is_raised_by_a_margin() -> None:
    chosen, bounds = np.array([1.0, 1.0, -2.0, 0.0]), np.array([0.5, 1.0, -np.inf, 2.0])
    assert above(chosen, bounds, 0.01).tolist() == [1.0, 1.01, -2.0, 2.02]


def rotated(nets: FaceNets, shift: int) -> FaceNets:
    base, vectors = np.roll(nets.base, shift, axis=1), np.roll(nets.vectors, shift, axis=1)
    return face_nets(nets.faces, base, vectors, nets.apex, nets.split)


def reflected(nets: FaceNets) -> FaceNets:
    return face_nets(nets.faces, nets.base[:, ::-1], nets.vectors[:, ::-1], nets.apex, nets.split)


def longer(nets: FaceNets) -> FaceNets:
    return face_nets(nets.faces, nets.base, 3.0 * nets.vectors, nets.apex, nets.split)


def smaller(nets: FaceNets) -> FaceNets:
    return face_nets(nets.faces, 1e-3 * nets.base, nets.vectors, 1e-3 * nets.apex, nets.split)


@pytest.mark.parametrize(
    ("change", "factor"),
    [(lambda nets: rotated(nets, 1), 1.0), (reflected, 1.0), (longer, 3.0), (smaller, 1e-3)],
)
def test_corners_orientation_and_scale_do_not_matter(change: Callable[[FaceNets], FaceNets], factor: float) -> None:
    nets = random_faces(80, 5)
    bounds, changed = of_faces(nets), of_faces(change(nets)) / factor
    assert np.array_equal(np.isfinite(bounds), np.isfinite(changed))
    near = bounds > -10.0
    assert near.sum() > 40
    assert np.abs(changed[near] - bounds[near]).max() < 1e-8


def test_no_bit_depends_on_the_other_faces() -> None:
    pieces = random_faces(200, 6).pieces()
    bounds = of_pieces(pieces)
    assert len(bounds) > 290  # more than one block
    for chosen in ([17], [280, 3, 3, 150], list(range(len(bounds) - 1, -1, -1))):
        assert np.array_equal(of_pieces(take(pieces, np.array(chosen))), bounds[chosen])


def test_needles_and_nearly_flat_faces_have_bounds() -> None:
    random = np.random.default_rng(7)
    base = np.tile([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1e-4, 0.0]], (40, 1, 1))
    base[:, 2, 0] = random.uniform(0.0, 1.0, 40)
    upright = np.tile([0.0, 0.0, 1.0], (40, 3, 1))
    for tilt in (0.1, 1e-6, 1e-12):
        nets = nets_of(base, upright + tilt * random.normal(size=base.shape) * [1.0, 0.0, 0.0], np.arange(40) % 2 == 0)
        pieces = nets.pieces()
        bounds = of_pieces(pieces)
        assert not np.isnan(bounds).any()
        dense, asked = sampled(pieces, 24), np.isfinite(bounds)
        size = np.maximum(magnitude(pieces), np.abs(np.where(asked, bounds, 0.0)))
        assert (dense <= bounds + 1e-9 * size).all()


def test_where_nothing_is_below_the_surface_nothing_is_asked() -> None:
    nets = figure(FIGURE6, (False, False))
    pieces = nets.pieces()
    assert (face_bounds(-pieces.layer0, -pieces.rational, pieces.layer1, pieces.q) == -np.inf).all()
    assert (face_bounds(0.0 * pieces.layer0, 0.0 * pieces.rational, pieces.layer1, pieces.q) == -np.inf).all()
    edges = common_edge(nets, nets.default, FIGURE6)
    assert (edge_bounds(np.where(np.arange(20) < 20, 1.0, 0.0)[None], edges.rational, edges.mu, edges.nu) < 0.0).all()


def test_coefficients_that_are_not_numbers_give_none() -> None:
    pieces = take(figure(FIGURE6, (False, False)).pieces(), np.array([0]))
    layers = [pieces.layer0, pieces.rational, pieces.layer1, pieces.q]
    for k in range(4):
        broken = [layer.copy() for layer in layers]
        broken[k][0, 1] = np.nan
        assert np.isnan(face_bounds(*broken)).all()


def test_no_faces_have_no_bounds() -> None:
    assert face_bounds(np.empty((0, 10)), np.empty((0, 3)), np.empty((0, 6)), np.empty((0, 3))).shape == (0,)
    assert edge_bounds(np.empty((0, 20)), np.empty((0, 4)), np.empty((0, 4)), np.empty((0, 4))).shape == (0,)


def take(pieces: FacePieces, rows: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> FacePieces:
    return FacePieces(
        pieces.owner[rows],
        pieces.corner[rows],
        pieces.base[rows],
        pieces.layer0[rows],
        pieces.rational[rows],
        pieces.layer1[rows],
        pieces.q[rows],
    )
