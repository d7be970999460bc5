"""Storage and evaluation cost of patches: counted against an evaluation that counts, and against surfaces."""

from itertools import combinations_with_replacement

import numpy as np
import pytest
from control_meshes import antiprism, cuboctahedron, grid

from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.costs import (
    PatchCost,
    casteljau_multiplications,
    distinct,
    network_cost,
    relative_cost,
    shared_cubic_points,
    surface_cost,
)
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.network_charts import charted_network
from testbed.geometry.polygon_mesh import PolygonMesh
from testbed.geometry.s_patches import SPatches
from testbed.geometry.spline_network import spline_network
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float


@pytest.mark.parametrize(("sides", "depth"), [(3, 1), (3, 3), (4, 3), (3, 6), (5, 6), (6, 2)])
def test_multiplications_are_those_of_a_de_casteljau_evaluation(sides: int, depth: int) -> None:
    # a new point for each multiset of corners, of every size below the depth, out of one point a corner
    made = sum(len(list(combinations_with_replacement(range(sides), size))) for size in range(depth))
    assert casteljau_multiplications(sides, depth) == sides * made


def test_relative_costs_are_the_printed_ones() -> None:
    kinds = [(3, 3), (4, 3), (3, 6), (5, 6), (6, 6)]
    assert [relative_cost(*kind) for kind in kinds] == pytest.approx([1.0, 2.0, 5.6, 42.0, 92.4])
    # 56 is printed for the second: those are the points that an evaluation makes
    assert [PatchCost(*kind, 1).points_per_patch for kind in kinds] == [10, 20, 28, 210, 462]
    assert casteljau_multiplications(3, 6) == 3 * 56


@pytest.mark.parametrize("mesh", [antiprism(3), antiprism(5), cuboctahedron(), grid()])
@pytest.mark.parametrize("level", [0, 1, 2])
def test_shared_points_of_cubics_are_those_at_different_places(mesh: PolygonMesh, level: int) -> None:
    network = spline_network(mesh)
    charted = charted_network(network).halved(level)
    triangles = charted.sampled()
    counted = len(triangles.points) + 2 * len(triangles.edges) + len(triangles.faces)
    # each boundary edge that was split adds one and a half
    boundary = int(triangles.boundary_edges.sum())
    grown = boundary - boundary // 2**level
    assert counted == shared_cubic_points(network, len(triangles.faces)) + 3 * grown // 2
    inner = np.array([[i / 3, j / 3] for i in range(4) for j in range(4 - i)])
    parameters = charted.at[:, None, 0] + np.einsum("sk,fkx->fsx", inner, charted.at[:, 1:] - charted.at[:, :1])
    nets = charted.charts.jets(np.repeat(charted.chart, 10), parameters.reshape(-1, 2), 0).f
    assert distinct([nets.reshape(-1, 10, 3)]) == counted


def test_a_surface_costs_what_its_triangles_cost() -> None:
    mesh = HermiteMesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))

    def over(degree: int) -> Surface:
        steps = np.array([[i, j] for i in range(degree + 1) for j in range(degree + 1 - i)])
        weights = np.column_stack([degree - steps.sum(axis=1), steps]) / degree
        nets: Float = np.einsum("nk,fkx->fnx", weights, mesh.corner_points())
        return Surface.over_faces(mesh, BezierTriangles(nets))

    cost = surface_cost(over(3))
    assert cost.kinds == (PatchCost(3, 3, 2),)
    assert (cost.patches, cost.control_points, cost.distinct_points) == (2, 20, 4 + 2 * 5 + 2)
    assert (cost.triangles, cost.evaluation) == (2, 2.0)
    assert surface_cost(over(6)).evaluation == pytest.approx(2 * 5.6)


def test_a_surface_of_other_patches_has_no_such_cost() -> None:
    mesh = HermiteMesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
    surface = Surface.over_faces(mesh, BezierQuads(np.zeros((1, 4, 4, 3))))
    with pytest.raises(TypeError, match="tensor-product Bézier patch is not defined here"):
        surface_cost(surface)


def test_tensor_product_patches_share_points_within() -> None:
    quads = BezierQuads(np.random.default_rng(1).normal(size=(3, 4, 4, 3)))
    assert distinct([SPatches.from_quads(quads).control_points]) == 3 * 16


def test_a_network_counts_its_patches() -> None:
    cost = network_cost(spline_network(cuboctahedron()))
    assert [(kind.sides, kind.depth, kind.patches) for kind in cost.kinds] == [(3, 6, 8), (4, 3, 6)]
    assert cost.control_points == 8 * 28 + 6 * 20
    # only corners are shared: curves of degree 3 and of degree 6 have other control points, though the same places
    assert cost.distinct_points == 12 + 6 * 12 + 8 * 25
    assert cost.triangles == 8 + 24
    assert cost.evaluation == pytest.approx(8 * 5.6 + 24 * 2.0)
