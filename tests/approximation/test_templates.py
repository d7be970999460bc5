"""Splitting by templates: all patterns, conforming divisions, the shorter diagonal, the counts of a demonstration."""

import math

import numpy as np
import pytest
from random_meshes import check_division, divided, plane_mesh

from testbed import registry
from testbed.approximation.division import LOCAL_POINTS
from testbed.approximation.sampled import Projected, SampledMesh
from testbed.approximation.templates import PATTERNS, Template
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import angle_between

TRIANGLE = HermiteMesh([[0, 0, 0], [1, 0, 0], [0.2, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize("mask", range(8))
def test_every_pattern_of_marked_sides_divides_a_triangle_into_one_more_than_its_sides(mask: int) -> None:
    marked = np.zeros(3, dtype=np.bool_)
    marked[TRIANGLE.face_edges[0, [side for side in range(3) if mask >> side & 1]]] = True
    division, finer = divided(Template(), TRIANGLE, marked)
    assert len(finer.faces) == 1 + int(marked.sum())
    check_division(TRIANGLE, division, finer, marked)
    assert np.array_equal(np.flatnonzero(marked), division.split)


def test_the_patterns_use_every_local_point_of_split_sides_and_no_other() -> None:
    for code, pattern in PATTERNS.items():
        sides = {3 + side for side in range(3) if code >> side & 1}
        assert set(np.ravel(pattern)) == {0, 1, 2} | sides
        corners = LOCAL_POINTS[np.array(pattern)]
        assert np.abs(np.linalg.det(corners)).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(20))
def test_divisions_of_random_meshes_conform_and_keep_area_orientation_and_euler_characteristic(seed: int) -> None:
    mesh, rng = plane_mesh(seed), np.random.default_rng(seed)
    for share in (0.1, 0.5, 0.0, 1.0):
        marked = rng.random(len(mesh.edges)) < share
        division, finer = divided(Template(), mesh, marked)
        check_division(mesh, division, finer, marked)
        assert np.array_equal(division.split, np.flatnonzero(marked))
        mesh = finer


@pytest.mark.parametrize(("apex", "shorter"), [((0.2, 1.0), (1, 5)), ((0.5, 0.3), (2, 3))])
def test_the_quadrilateral_beside_a_corner_is_halved_by_its_shorter_diagonal(
    apex: tuple[float, float], shorter: tuple[int, int]
) -> None:
    # sides 0 and 2 are split; local points 3 and 5 are their middles, vertices 3 and 4 in the order of the edges
    mesh = HermiteMesh([[0, 0, 0], [1, 0, 0], [*apex, 0]], [[0, 1, 2]])
    marked = np.ones(3, dtype=np.bool_)
    marked[mesh.face_edges[0, 1]] = False
    _, finer = divided(Template(), mesh, marked)
    vertex = {0: 0, 1: 1, 2: 2, 3: 3, 5: 4}
    assert tuple(sorted(vertex[point] for point in shorter)) in set(map(tuple, finer.edges.tolist()))


def test_of_equal_diagonals_the_one_at_the_smaller_vertex_id_is_taken() -> None:
    points = np.array([[0.5, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    for order in ([0, 1, 2], [0, 2, 1], [2, 0, 1], [1, 2, 0]):
        inverse = np.argsort(order)
        mesh = HermiteMesh(points[order], inverse[np.array([[0, 1, 2]])])
        top = int(inverse[0])
        marked = (mesh.edges == top).any(axis=1)
        _, finer = divided(Template(), mesh, marked)
        base = [vertex for vertex in range(3) if vertex != top]
        valence = finer.valence
        # the diagonal adds an edge at the smaller of the two vertices at the base
        assert valence[min(base)] == 3
        assert valence[max(base)] == 2


@pytest.mark.parametrize(("name", "last"), [("algebraic", 424), ("ellipsoid", 440)])
def test_the_counts_of_a_demonstration_on_the_ellipsoid(name: str, last: int) -> None:
    # split where the normals at the ends differ by more than 25 degrees; middles are projected along the gradient of
    # the polynomial, which gives the known counts, or to the nearest points
    exact, start = registry.dataset(name).surface, registry.dataset("ellipsoid").mesh(0)
    assert exact is not None
    sampled: SampledMesh = Projected(exact, start.points, start.faces)
    counts = []
    while True:
        mesh = sampled.mesh
        counts.append(len(mesh.faces))
        data = mesh.edge_data
        assert data.n0 is not None
        assert data.n1 is not None
        marked = angle_between(data.n0, data.n1) > math.radians(25.0)
        if not marked.any():
            break
        middles = sampled.middles(np.flatnonzero(marked))
        sampled = sampled.divided(Template().divide(mesh, marked, middles), middles)
    assert counts == [8, 32, 120, 288, last]
