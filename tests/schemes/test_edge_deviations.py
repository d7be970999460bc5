"""Deviations from flat triangles: functions exact down to the margin, limits at corners, no harm from far away."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from testbed.conformance.meshes import octahedron, perturbed_icosahedron
from testbed.geometry.domain import CORNERS
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float, angle_between
from testbed.plugins.scheme import Scheme
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.gregory_charrot import GregoryCharrot, boolean_sum_basis
from testbed_schemes.mathematics.edge_deviations import CORNER_MARGIN
from testbed_schemes.nielson_network import NielsonNetwork, side_vertex_basis

both_bases = pytest.mark.parametrize("basis", [side_vertex_basis, boolean_sum_basis])
both_schemes = pytest.mark.parametrize("scheme", [NielsonNetwork(), GregoryCharrot()], ids=str)


def patches(scheme: Scheme, mesh: HermiteMesh) -> TabulatedTriangles:
    batch = scheme.fit(mesh).batches[0]
    assert isinstance(batch, TabulatedTriangles)
    return batch


def exact_jets(basis: Callable[..., Any], at: Float) -> Float:
    """Jets (6, 15) in rational arithmetic, by differences whose error is beyond double precision."""
    u, v = (Fraction(x) for x in at.tolist())
    step = min(u, v, 1 - u - v) / 10**18

    def functions(i: int, j: int) -> Any:
        return np.array(basis(1 - u - v - (i + j) * step, u + i * step, v + j * step), dtype=object)

    first = [(functions(*d) - functions(-d[0], -d[1])) / (2 * step) for d in ((1, 0), (0, 1))]
    second = [(functions(*d) - 2 * functions(0, 0) + functions(-d[0], -d[1])) / step**2 for d in ((1, 0), (0, 1))]
    mixed = (functions(1, 1) - functions(1, -1) - functions(-1, 1) + functions(-1, -1)) / (4 * step**2)
    return np.stack([functions(0, 0), *first, second[0], mixed, second[1]]).astype(np.float64)


@both_bases
@pytest.mark.parametrize("corner", [0, 1, 2])
@pytest.mark.parametrize("distance", [0.3, 1e-3, CORNER_MARGIN])
def test_functions_are_exact_down_to_the_stated_margin(basis: Any, corner: int, distance: float) -> None:
    batch = TabulatedTriangles(basis, np.zeros((0, 15, 3)), np.zeros((3, 3, 15)), CORNER_MARGIN)
    for direction in (0.1, 0.37, 0.9):
        b = np.roll([1.0 - distance, distance * direction, distance * (1.0 - direction)], corner)
        found = np.moveaxis(batch.functions(b[None, 1:], 2), 0, -1)[:, 0]
        expected = exact_jets(basis, b[1:])
        assert found[:3] == pytest.approx(expected[:3], abs=1e-14)
        assert found[3:] == pytest.approx(expected[3:], abs=3e-14 + 1e-14 / distance)


@both_schemes
def test_at_corners_the_functions_have_their_limits(scheme: Scheme) -> None:
    batch = patches(scheme, octahedron())
    at_corner = batch.functions(CORNERS[3], 1)
    for towards in ([1 / 3, 1 / 3], [0.1, 0.5], [0.4, 0.5]):
        near = batch.functions(CORNERS[3] + 1e-9 * (np.array(towards) - CORNERS[3]), 1)
        np.testing.assert_allclose(near, at_corner, atol=1e-8)


@both_schemes
def test_corners_have_the_points_the_normals_and_the_derivatives_of_the_curves(scheme: Scheme) -> None:
    mesh = perturbed_icosahedron()
    jet = patches(scheme, mesh).jets(CORNERS[3], order=2)
    curves = Projected().network(mesh).along_sides()
    assert np.array_equal(jet.f, mesh.corner_points())
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-12
    assert jet.fu[:, 0] == pytest.approx(3.0 * (curves[:, 0, 1] - curves[:, 0, 0]), abs=1e-14)
    assert jet.fv[:, 0] == pytest.approx(3.0 * (curves[:, 2, 2] - curves[:, 2, 3]), abs=1e-14)
    assert np.isnan(jet.coefficients[3:]).all()


@both_schemes
def test_second_derivatives_near_a_corner_survive_a_move_far_away(scheme: Scheme) -> None:
    mesh, at = perturbed_icosahedron(), np.array([[1e-6, 2e-6], [2e-6, 1e-6]])
    moved = HermiteMesh(mesh.points + 2.0**10, mesh.faces, mesh.normals)
    here, there = (patches(scheme, m).jets(at).coefficients[3:] for m in (mesh, moved))
    # coordinates are rounded by 1e-13 and second derivatives are multiplied by no more than that
    np.testing.assert_allclose(there, here, atol=1e-11)
