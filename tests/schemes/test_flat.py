"""Flat triangles: the mesh itself, and second order."""

import numpy as np

from testbed import registry
from testbed.geometry.domain import barycentric, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import norm
from testbed_schemes.flat import Flat


def test_a_patch_is_its_face() -> None:
    mesh = registry.dataset("torus").mesh(0)
    at = lattice(3, 4)
    points = Flat().fit(mesh).batches[0].jets(at, 0).f
    assert norm(points - np.einsum("sc,fcx->fsx", barycentric(at), mesh.corner_points())).max() < 1e-15


def test_it_needs_points_only() -> None:
    mesh = HermiteMesh(np.eye(3), [[0, 1, 2]])
    assert len(Flat().fit(mesh).batches[0]) == 1


def test_the_distance_to_a_sphere_falls_with_the_square_of_the_edge() -> None:
    dataset = registry.dataset("octahedron")
    depths = [
        1.0 - norm(Flat().fit(dataset.mesh(level)).batches[0].jets(lattice(3, 6), 0).f).min() for level in (2, 3, 4)
    ]
    assert np.log2(np.divide(depths[:-1], depths[1:])).min() > 1.8
