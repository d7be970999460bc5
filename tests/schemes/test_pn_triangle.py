"""PN triangles: control points as published, corners matched, boundaries shared."""

import numpy as np
import pytest

from testbed import registry
from testbed.geometry import curvature
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE
from testbed.geometry.vectors import angle_between, cross, norm
from testbed_schemes.pn_triangle import PnTriangle


def test_the_control_points_are_the_published_ones() -> None:
    mesh = registry.dataset("torus").mesh(0)
    net = PnTriangle().fit(mesh).batches[0].control_points  # type: ignore[attr-defined]
    p, n = mesh.corner_points(), mesh.corner_normals()
    edge_points = []
    # 210, 120; 021, 012; 102, 201: the ends of the sides 01, 12, 20
    for (i, j), places in (((0, 1), (1, 3)), ((1, 2), (7, 8)), ((2, 0), (5, 2))):
        for (a, b), place in zip(((i, j), (j, i)), places, strict=True):
            w = ((p[:, b] - p[:, a]) * n[:, a]).sum(axis=-1, keepdims=True)
            expected = (2.0 * p[:, a] + p[:, b] - w * n[:, a]) / 3.0
            edge_points.append(expected)
            assert norm(net[:, place] - expected).max() < 1e-14
    mean, corner_mean = np.mean(edge_points, axis=0), p.mean(axis=1)
    assert norm(net[:, CENTRE] - (mean + (mean - corner_mean) / 2.0)).max() < 1e-14


def test_the_normals_at_the_corners_are_the_data() -> None:
    mesh = registry.dataset("graph").mesh(0)
    jet = PnTriangle().fit(mesh).batches[0].jets(CORNERS[3], 1)
    assert norm(jet.f - mesh.corner_points()).max() < 1e-15
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-13


def test_neighbours_share_their_boundary_bit_for_bit() -> None:
    surface = PnTriangle().fit(registry.dataset("torus").mesh(0))
    edges = surface.edges
    one, other = surface.edge_jets(edges, np.linspace(0.0, 1.0, 9), 1)
    assert norm(one.f - other.f).max() < 1e-15


def test_the_normals_jump_by_46_degrees_on_the_octahedron() -> None:
    surface = PnTriangle().fit(registry.dataset("octahedron").mesh(0))
    one, other = surface.edge_jets(surface.edges, np.linspace(0.0, 1.0, 101), 1)
    assert np.degrees(angle_between(one.normal, other.normal).max()) == pytest.approx(46.0, abs=0.5)


def test_the_gaussian_curvature_on_the_octahedron() -> None:
    # by hand, in rational numbers, at a corner: legs (0, 1/3, 0), (0, 0, 1/3), so K = 7
    jet = PnTriangle().fit(registry.dataset("octahedron").mesh(0)).batches[0].jets(CORNERS[3])
    assert curvature.gauss(jet) == pytest.approx(7.0, rel=1e-12)


def test_flat_data_give_the_face_with_its_own_parameters() -> None:
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.0, 0.0]])
    mesh = HermiteMesh(points, [[0, 1, 2]], np.broadcast_to([0.0, 0.0, 1.0], (3, 3)))
    jet = PnTriangle().fit(mesh).batches[0].jets(lattice(3, 5))
    assert norm(cross(jet.fu - (points[1] - points[0]), jet.fv)).max() < 1e-14
    assert norm(jet.fuu).max() < 1e-13
