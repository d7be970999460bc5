"""Free coefficients of whole meshes: raised where a sheet would tear, on faces and on edges, and nowhere else."""

import numpy as np
import pytest
from a_patch_functions import edge_rays, face_rays

from testbed.geometry.cubic_roots import bracketed_roots
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float, unit
from testbed_schemes.mathematics.a_patch_bounds import above, edge_bounds
from testbed_schemes.mathematics.a_patch_classes import Convexity
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.a_patch_parameters import Free, bounds_of_faces, free_coefficients
from testbed_schemes.mathematics.a_patch_sides import Hull, hull, nets_of_edges, nets_of_faces


def noisy_torus(seed: int, noise: float) -> Hull:
    """A torus of 16 times 10 quadrilaterals, halved, with tilted normals."""
    u, v = np.meshgrid(np.arange(16) * np.pi / 8.0, np.arange(10) * np.pi / 5.0, indexing="ij")
    outward = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=-1).reshape(-1, 3)
    points = np.stack([np.cos(u), np.sin(u), 0.0 * u], axis=-1).reshape(-1, 3) + 0.4 * outward
    place = np.arange(160).reshape(16, 10)
    a, b, d = place, np.roll(place, -1, axis=0), np.roll(place, -1, axis=1)
    c = np.roll(b, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    vectors = unit(outward + noise * np.random.default_rng(seed).normal(size=points.shape))
    return hull(HermiteMesh(points, faces, gradients=vectors), 0.05, 1e-12)


def sides(found: Hull) -> list[tuple[int, FaceNets]]:
    split = found.faces == Convexity.NONCONVEX
    return [(side, nets_of_faces(found, side, split)) for side in range(2)]


def all_simple(rays: Float) -> bool:
    """Whether the first root of every ray (N, S, 4) that starts below zero exists and is simple."""
    below: Bool = rays[..., 0] < -1e-13 * np.abs(rays).max(axis=-1)
    cubics = rays[below]
    t = bracketed_roots(cubics)
    d0, d1, d2 = np.diff(cubics, axis=-1).T
    return bool((d0 * (1.0 - t) ** 2 + 2.0 * d1 * t * (1.0 - t) + d2 * t * t > 0.0).all())


@pytest.mark.parametrize(("free", "noise"), [("default", 0.1), ("quadric", 0.1), (-1.0, 0.1), (0.0, 0.2), (0.05, 0.0)])
def test_every_ray_meets_one_simple_root_first(free: Free, noise: float) -> None:
    found = noisy_torus(1, noise)
    for side, nets in sides(found):
        chosen = free_coefficients(found, side, nets, free, str)
        pieces = nets.pieces()
        assert all_simple(face_rays(pieces, chosen.top[pieces.owner], barycentric(lattice(3, 12))))
        assert all_simple(edge_rays(nets_of_edges(found, side, nets, chosen.top), lattice(4, 12)))


@pytest.mark.parametrize("free", [-1.0, 0.0, 0.05])
def test_a_low_choice_is_raised_above_the_bounds_of_faces_and_edges_alone(free: float) -> None:
    found = noisy_torus(2, 0.1)
    for side, nets in sides(found):
        result = free_coefficients(found, side, nets, free, str)
        bounds = bounds_of_faces(nets, np.arange(len(nets)))
        assert (result.top > bounds).all()
        edges = nets_of_edges(found, side, nets, result.top)
        assert (edge_bounds(edges.nets, edges.rational, edges.mu, edges.nu) < 0.0).all()
        assert np.array_equal(result.raised, result.top > free)
        assert (result.top[~result.raised] == free).all()
        # where nothing is raised for an edge, the coefficient is the choice, or a margin above the face's bound
        start = above(np.full(len(nets), free), bounds)
        edges = nets_of_edges(found, side, nets, start)
        lacking = edge_bounds(edges.nets, edges.rational, edges.mu, edges.nu) > 0.0
        by_edges = np.zeros(len(nets), dtype=np.bool_)
        by_edges[edges.rows[lacking]] = True
        assert (result.top > np.maximum(free, bounds))[by_edges].all()
        alone = np.ones(len(nets), dtype=np.bool_)
        alone[edges.rows[by_edges[edges.rows].any(axis=1)]] = False
        kept, margin = alone & (bounds < free), 1e-3 * np.maximum(abs(free), np.maximum(np.abs(bounds), nets.default))
        assert (result.top == free)[kept].all()
        assert (result.top <= bounds + margin + 1e-12)[alone & ~kept].all()


def test_good_choices_are_kept_to_the_last_bit() -> None:
    found = noisy_torus(3, 0.0)
    for side, nets in sides(found):
        result = free_coefficients(found, side, nets, "default", str)
        assert np.array_equal(result.top, nets.default)
        assert not result.raised.any()
