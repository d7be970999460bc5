"""Bounds of the curvature of S-patches: the same patches in Bernstein form, true bounds, not much too large."""

from functools import cache

import numpy as np
import pytest
from control_meshes import antiprism, cuboctahedron, grid

from testbed.geometry.bezier import BezierQuads, RationalBezierTriangles
from testbed.geometry.charted import triangle_fan
from testbed.geometry.charted_surface import ChartedSurface, CurvedBoxes
from testbed.geometry.curvature import principal
from testbed.geometry.jets import Jet
from testbed.geometry.network_bounds import curvature_bounds, curved_boxes, halved, rational_triangles
from testbed.geometry.network_charts import NetworkCharts
from testbed.geometry.s_patches import SPatches
from testbed.geometry.spline_network import spline_network
from testbed.geometry.vectors import Bool, Float, norm

#: Polygons and their rational triangles' degrees.
DEGREES = {3: 6, 4: 6, 5: 18}


@cache
def patches(sides: int) -> SPatches:
    mesh = {3: cuboctahedron(), 4: grid(5, 4), 5: antiprism(5)}[sides]
    part = next(part for part in spline_network(mesh).parts if part.sides == sides)
    return part.take(slice(0, 2))


@cache
def boxes(sides: int) -> CurvedBoxes:
    return curved_boxes(patches(sides))


def some_points(count: int) -> Float:
    weights: Float = np.random.default_rng(count).dirichlet(np.full(3, 0.6), count)
    return weights


def jets(nets: Float, weights: Float) -> Jet:
    rational = RationalBezierTriangles(nets[..., :3] / nets[..., 3:], nets[..., 3])
    return rational.jets(weights[:, 1:])


def largest(jet: Jet) -> Float:
    curvatures: Float = np.abs(np.stack(principal(jet))).max(axis=0)
    return curvatures


every_polygon = pytest.mark.parametrize("sides", list(DEGREES))


@every_polygon
def test_rational_triangles_are_the_patches(sides: int) -> None:
    part, weights = patches(sides), some_points(20)
    nets = rational_triangles(part)
    assert nets.shape == (2 * sides, (DEGREES[sides] + 1) * (DEGREES[sides] + 2) // 2, 4)
    assert 0.0 < nets[..., 3].min() <= nets[..., 3].max() < 1.0 + 1e-14
    at = np.einsum("sk,fkx->fsx", weights, triangle_fan(part.corners)[0])
    exact = np.stack([part.jets(points, 0).f for points in at], axis=1).reshape(2 * sides, len(weights), 3)
    assert np.abs(jets(nets, weights).f - exact).max() < 1e-13


@every_polygon
def test_halves_are_the_triangle(sides: int) -> None:
    nets, weights = rational_triangles(patches(sides)), some_points(15)
    halves = halved(nets)
    corner = np.eye(3)
    middle = 0.5 * (corner[0] + corner[1])
    pieces = ([corner[2], corner[0], middle], [corner[1], corner[2], middle])
    for half, corners in zip(np.split(halves, 2), pieces, strict=True):
        inside = weights @ np.array(corners)
        assert np.abs(jets(half, weights).f - jets(nets, inside).f).max() < 1e-13
    # after four halvings every side was cut twice
    sizes = [float(np.ptp(one[..., :3] / one[..., 3:], axis=1).max()) for one in (nets, halved(halved(halved(halves))))]
    assert sizes[1] < 0.6 * sizes[0]


@every_polygon
def test_no_curvature_is_beyond_the_bound_of_its_piece(sides: int) -> None:
    nets = rational_triangles(patches(sides))
    for _ in range(3):
        nets = halved(nets)
    bound, attained = curvature_bounds(nets).T
    found = largest(jets(nets, some_points(60))).max(axis=1)
    assert (found <= bound).all()
    assert (attained <= bound).all()
    # and the bounds come down to the curvatures as pieces get small
    few = nets[:: len(nets) // 4]
    excess = []
    for _ in range(3):
        bound, attained = curvature_bounds(few).T
        excess.append(float((bound.max() - attained.max()) / attained.max()))
        for _ in range(4):
            few = halved(few)
    assert excess[2] < 0.6 * excess[1] < 0.36 * excess[0]
    assert excess[2] < 0.5


@every_polygon
def test_boxes_contain_the_patches_and_bound_them(sides: int) -> None:
    part, found = patches(sides), boxes(sides)
    fan, _ = triangle_fan(part.corners)
    jet = part.jets(np.einsum("sk,fkx->fsx", some_points(40), fan).reshape(-1, 2))
    points, curvature = jet.f.reshape(-1, 3), largest(jet).ravel()
    inside: Bool = np.all((points[:, None] >= found.low) & (points[:, None] <= found.high), axis=2)
    assert inside.any(axis=1).all()
    assert (curvature <= np.where(inside, found.bound, 0.0).max(axis=1)).all()
    assert found.bound.max() < 2.0 * curvature.max()


def test_bounds_of_boxes_are_scaled_with_the_patches() -> None:
    part = patches(4)
    small = curved_boxes(SPatches(1e-3 * part.control_points, 4, 3))
    assert small.bound == pytest.approx(1e3 * boxes(4).bound, rel=1e-6)


def test_a_plane_is_not_curved_and_a_singular_patch_not_bounded() -> None:
    u, v = (index / 3.0 for index in np.meshgrid(np.arange(4), np.arange(4), indexing="ij"))
    plane = np.stack([u + 0.2 * u * v, v, 2.0 * u + v + 0.4 * u * v], axis=-1)[None]
    assert curvature_bounds(rational_triangles(SPatches.from_quads(BezierQuads(plane)))).max() < 1e-6
    point = plane.copy()
    point[:, 0] = point[:, 0, :1]  # a side that is one point
    bounds = curvature_bounds(rational_triangles(SPatches.from_quads(BezierQuads(point + 0.1 * np.sin(7.0 * point)))))
    assert np.isinf(bounds[:, 0]).any()
    assert not np.isnan(bounds).any()


def test_a_network_bounds_its_surface_everywhere() -> None:
    network = spline_network(cuboctahedron())
    surface = ChartedSurface(NetworkCharts(network))
    everywhere = surface.curvature_bound(np.full((1, 3), -9.0), np.full((1, 3), 9.0))
    most = max(float(boxes.max()) for boxes in (curved_boxes(part).bound for part in network.parts))
    assert everywhere[0] == most
    assert surface.curvature_bound(np.full((1, 3), 8.0), np.full((1, 3), 9.0))[0] == 0.0


def test_only_boxes_at_the_rim_may_hold_an_end_of_the_surface() -> None:
    closed = ChartedSurface(NetworkCharts(spline_network(cuboctahedron())))
    everywhere = np.full((1, 3), -9.0), np.full((1, 3), 9.0)
    assert not closed.may_end(*everywhere).any()
    # nine patches over [1, 4]^2, whose sides outside are the rim
    charts = NetworkCharts(spline_network(grid(5, 5)))
    surface = ChartedSurface(charts)
    assert surface.may_end(*everywhere).all()
    jet = charts.jets(np.arange(len(charts)), np.zeros((len(charts), 2)), 0)
    about = surface.may_end(jet.f - 0.2, jet.f + 0.2)
    assert not about.any()
    wide = surface.may_end(jet.f - 0.7, jet.f + 0.7)
    middle = norm(jet.f[:, :2] - 2.5) < 0.5
    assert np.array_equal(wide, ~middle)
    # points of the rim are in its boxes
    polygon = charts.polygon(0)
    corners = charts.jets(np.zeros(4, dtype=np.int64), polygon, 0).f
    assert surface.may_end(corners, corners).sum() == 3
