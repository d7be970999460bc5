"""Splitting at longest edges: conforming divisions whose angles stay good whatever is marked."""

import numpy as np
import pytest
from random_meshes import check_division, divided, plane_mesh

from testbed.approximation.division import longest_sides
from testbed.approximation.history import smallest_angle
from testbed.approximation.longest_edge import LongestEdge
from testbed.approximation.templates import Template
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import norm


@pytest.mark.parametrize("seed", range(12))
def test_divisions_of_random_meshes_conform_and_halve_the_longest_side_of_what_they_divide(seed: int) -> None:
    mesh, rng = plane_mesh(seed), np.random.default_rng(seed)
    for share in (0.1, 0.5, 0.0, 1.0):
        marked = rng.random(len(mesh.edges)) < share
        division, finer = divided(LongestEdge(), mesh, marked)
        check_division(mesh, division, finer, marked)
        touched = np.isin(mesh.face_edges, division.split)
        longest = np.take_along_axis(touched, longest_sides(mesh)[:, None], axis=1)[:, 0]
        assert np.array_equal(longest, touched.any(axis=1))
        # nothing is split that need not be: without marks nothing
        assert marked.any() or not len(division.split)
        mesh = finer


@pytest.mark.parametrize("flat", [1.0, 0.1, 0.01])
def test_no_angle_gets_below_half_of_the_smallest_at_the_start(flat: float) -> None:
    worst = 1.0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        mesh = plane_mesh(seed, 5, flat)
        start = smallest_angle(mesh)
        for _ in range(9):
            share = rng.choice([1.0 / len(mesh.edges), 0.05, 0.3 if len(mesh.faces) < 500 else 0.02])
            marked = rng.random(len(mesh.edges)) < share
            _, mesh = divided(LongestEdge(), mesh, marked)
        worst = min(worst, smallest_angle(mesh) / start)
    assert worst >= 0.5 - 1e-9


def test_templates_do_not_keep_angles() -> None:
    ratio = {}
    for splitting in (Template(), LongestEdge()):
        mesh = plane_mesh(0, 3)
        start = smallest_angle(mesh)
        for _ in range(8):
            # edges at one corner of the square again and again
            marked = (mesh.edges == 0).any(axis=1) & ~mesh.boundary_edges
            _, mesh = divided(splitting, mesh, marked)
        ratio[splitting.name] = smallest_angle(mesh) / start
    assert ratio["longest-edge"] >= 0.5
    assert ratio["template"] < 0.1


def test_equally_long_sides_are_told_apart_by_their_ids_and_not_by_rounding() -> None:
    angle = np.array([0.1, 0.1 + 2.0 * np.pi / 3.0, 0.1 + 4.0 * np.pi / 3.0])
    triangle = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    for _ in range(3):
        mesh = HermiteMesh(triangle, [[0, 1, 2]])
        ends = mesh.points[mesh.edges]
        assert np.ptp(norm(ends[:, 1] - ends[:, 0])) < 1e-15
        assert mesh.face_edges[0, longest_sides(mesh)[0]] == 0
        triangle = triangle[[1, 2, 0]]
