"""Surfaces in charts against spheres, a torus and flat polygons in closed form, over polygons with 3 to 6 sides."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from polyhedral_charts import POLYHEDRA, FlatPolygon, SphereOverPolyhedron, TiledTorus

from testbed.geometry.charted_surface import BoundedCharts, ChartedSurface, CurvedBoxes
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.jets import Jet
from testbed.geometry.polygon_descent import lowest_in_polygon
from testbed.geometry.vectors import Float, Int, norm, tangential, unit

every_polyhedron = pytest.mark.parametrize("polyhedron", sorted(POLYHEDRA))


def random_points(count: int, seed: int = 3) -> Float:
    return np.random.default_rng(seed).uniform(-1.7, 1.7, (count, 3))


def on_torus(points: Float, major: float, minor: float) -> Float:
    """Nearest points of the whole torus."""
    rho = np.hypot(points[:, 0], points[:, 1])
    core = np.stack([points[:, 0] / rho, points[:, 1] / rho, 0.0 * rho], axis=-1) * major
    return core + minor * unit(points - core)


@every_polyhedron
def test_feet_on_a_sphere_wherever_its_charts_join(polyhedron: str) -> None:
    surface = ChartedSurface(SphereOverPolyhedron(polyhedron), 5)
    vertices = np.array(POLYHEDRA[polyhedron][0], dtype=np.float64)
    # far and near, just off the vertices where charts meet, and along the edges between neighbouring vertices
    apart = norm(vertices[:, None] - vertices)
    i, j = np.nonzero((apart > 0.0) & (apart < 1.01 * apart[apart > 0.0].min()))
    t = np.linspace(0.0, 1.0, 7)[:, None, None]
    edges = ((1.0 - t) * vertices[i] + t * vertices[j]).reshape(-1, 3)
    points = np.concatenate(
        [random_points(2000), 1e-9 * random_points(500) + unit(vertices)[np.arange(500) % 12], edges]
    )
    feet = surface.closest(points)
    assert norm(feet - unit(points)).max() < 4e-15
    assert norm(surface.closest(feet) - feet).max() < 4e-15
    normal = surface.normal(feet)
    assert norm(normal - feet).max() < 2e-14
    W = np.eye(3) - feet[:, :, None] * feet[:, None, :]
    assert np.abs(surface.second_form(feet) - W).max() < 1e-13


def test_feet_on_a_torus_are_the_nearest_of_all() -> None:
    # far from the surface too: two feet on either side of the tube or of the axis, and the starts decide
    surface, points = ChartedSurface(TiledTorus()), random_points(5000)
    feet = surface.closest(points)
    assert norm(feet - on_torus(points, 1.0, 0.4)).max() < 1e-13


@pytest.mark.parametrize("sides", [3, 4, 5, 6])
def test_beyond_the_rim_the_nearest_point_is_on_it(sides: int) -> None:
    charts = FlatPolygon(sides)
    surface, points = ChartedSurface(charts), 20.0 * random_points(400)
    found = surface.locate(points)
    corners = charts.jets(np.zeros(sides, dtype=np.int64), charts.polygon(0), 0).f
    start, side = corners, np.roll(corners, -1, axis=0) - corners
    from_start = points[:, None] - start
    t = np.clip((from_start * side).sum(axis=-1) / (side * side).sum(axis=-1), 0.0, 1.0)
    on_rim = start + t[..., None] * side
    flat = points * [1.0, 1.0, 0.0]
    across = flat[:, None] - start
    heights = side[:, 0] * across[..., 1] - side[:, 1] * across[..., 0]
    inside = heights.min(axis=1, keepdims=True) > 0.0
    nearest = on_rim[np.arange(len(points)), norm(on_rim - points[:, None]).argmin(axis=1)]
    assert norm(found.points - np.where(inside, flat, nearest)).max() < 1e-12
    assert np.array_equal(found.on_side, ~inside.ravel())


def test_a_foot_depends_on_its_point_alone() -> None:
    surface, points = ChartedSurface(SphereOverPolyhedron("dodecahedron (5 sides)")), random_points(5000)
    feet = surface.locate(points)
    some = np.random.default_rng(0).permutation(len(points))[:41]
    few = surface.locate(points[some])
    for all_values, values in zip(vars(feet).values(), vars(few).values(), strict=True):
        assert np.array_equal(all_values[some], values)
    assert surface.closest(points[:0]).shape == (0, 3)


def test_what_is_not_a_number_has_no_foot() -> None:
    surface = ChartedSurface(TiledTorus())
    points = random_points(5)
    points[1, 0], points[3, 2] = np.nan, np.inf
    found = surface.locate(points)
    assert np.array_equal(np.isnan(found.points).any(axis=1), [False, True, False, True, False])
    assert np.array_equal(found.chart < 0, [False, True, False, True, False])
    assert np.isnan(surface.normal(points)[[1, 3]]).all()


def test_charts_place_the_foot() -> None:
    charts = TiledTorus()
    surface, points = ChartedSurface(charts), on_torus(random_points(500), 1.0, 0.4)
    found = surface.locate(points)
    jet = charts.jets(found.chart, found.at, 2)
    assert norm(jet.f - points).max() < 1e-14
    assert np.array_equal(surface.normal(points), charts.jets(found.chart, found.at, 1).normal)
    assert np.array_equal(surface.second_form(points), second_form_matrix(jet))
    off = tangential(random_points(500, 4) - points, jet.normal)
    assert norm(off).max() > 0.1  # the frame of the tangent plane is no accident


coordinates = st.floats(-3.0, 3.0)


@settings(max_examples=200, derandomize=True)
@given(
    sides=st.integers(3, 6),
    slope=st.tuples(coordinates, coordinates),
    bending=st.tuples(st.floats(0.1, 5.0), st.floats(-0.9, 0.9), st.floats(0.1, 5.0)),
    place=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_a_quadratic_model_is_lowest_where_it_is_said_to_be(
    sides: int, slope: tuple[float, float], bending: tuple[float, float, float], place: tuple[float, float]
) -> None:
    angle = 2.0 * np.pi * np.arange(sides) / sides
    polygon = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    # a corner repeated, as polygons with fewer corners than others have it
    padded = np.concatenate([polygon, polygon[-1:]])
    xx, mixed, yy = bending
    hessian = np.array([[xx, mixed * np.sqrt(xx * yy), yy]])
    weights = np.array([place[0], place[1], 1.0])
    at = (weights[:, None] * polygon[:3]).sum(axis=0) / weights.sum()
    lowest, on_side = lowest_in_polygon(at[None], np.array([slope]), hessian, padded[None])

    def model(x: Float) -> Float:
        d = x - at
        quadratic = 0.5 * (xx * d[..., 0] ** 2 + 2.0 * hessian[0, 1] * d[..., 0] * d[..., 1] + yy * d[..., 1] ** 2)
        value: Float = d @ np.array(slope) + quadratic
        return value

    weights = np.random.default_rng(0).dirichlet(np.full(sides, 0.5), 400)
    assert model(lowest)[0] <= model(weights @ polygon).min() + 1e-12
    step = np.roll(polygon, -1, axis=0) - polygon
    across = lowest[0] - polygon
    heights = step[:, 0] * across[:, 1] - step[:, 1] * across[:, 0]
    assert heights.min() > -1e-12
    # on a side or inside it; where it is on a side to rounding it may be either
    assert not on_side[0] if heights.min() > 1e-9 else heights.min() < 1e-9


@dataclass(frozen=True)
class BoundedTorus(TiledTorus, BoundedCharts):
    """The torus, of which two boxes are known, and that it ends in one."""

    last: float = 2.5

    def boxes(self) -> CurvedBoxes:
        low = np.array([[0.0, -1.5, -0.5], [-1.5, -1.5, -0.5]])
        return CurvedBoxes(low, low + np.array([1.5, 3.0, 1.0]), np.array([self.last, 3.0]))

    def rim(self) -> tuple[Float, Float]:
        return np.full((1, 3), -1.5), np.full((1, 3), 0.1)


def test_curvature_is_bounded_by_the_boxes_that_meet() -> None:
    low = np.array([[-1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [-0.1, 0.0, 0.0], [2.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])
    surface = ChartedSurface(BoundedTorus())
    assert np.array_equal(surface.curvature_bound(low, low + 0.2), [3.0, 2.5, 3.0, 0.0, 3.0])
    assert np.array_equal(ChartedSurface(TiledTorus()).curvature_bound(low, low + 0.2), np.full(5, np.inf))
    # the order of the boxes does not matter, nor how many are asked for, and what is not a number bounds nothing
    many = np.random.default_rng(0).uniform(-2.0, 2.0, (2000, 3))
    bounds = surface.curvature_bound(many, many + 0.3)
    meets = [
        ((many + 0.3 >= one) & (many <= one + np.array([1.5, 3.0, 1.0]))).all(axis=1)
        for one in ([0.0, -1.5, -0.5], [-1.5, -1.5, -0.5])
    ]
    assert np.array_equal(bounds, np.maximum(2.5 * meets[0], 3.0 * meets[1]))
    assert ChartedSurface(BoundedTorus(last=np.nan)).curvature_bound(low[1:2], low[1:2])[0] == np.inf


def test_a_surface_may_end_where_boxes_of_its_rim_are_met() -> None:
    low = np.array([[-1.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.09], [0.0, 0.0, 0.2], [0.0, np.nan, 0.0]])
    assert np.array_equal(ChartedSurface(BoundedTorus()).may_end(low, low + 0.1), [True, False, True, False, True])
    assert ChartedSurface(TiledTorus()).may_end(low, low + 0.1).all()


def test_a_foot_where_a_chart_has_no_tangent_plane() -> None:
    # a cone's tip, on the rim: the parametrisation is singular, and the tip is nearest to points behind it
    @dataclass(frozen=True)
    class Cone(FlatPolygon):
        def polygon(self, chart: int) -> Float:
            return np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) + chart

        def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
            u, v = at[:, 0], at[:, 1]
            zero, cosine, sine = np.zeros_like(u), np.cos(v), np.sin(v) + 0.0 * chart
            rows = [
                [u * cosine, u * sine, u],
                [cosine, sine, zero + 1.0],
                [-u * sine, u * cosine, zero],
                [zero, zero, zero],
                [-sine, cosine, zero],
                [-u * cosine, -u * sine, zero],
            ]
            return Jet(np.moveaxis(np.array(rows), 1, -1)[: (1, 3, 6)[order]])

    behind = np.array([[-0.1, -0.05, -0.5]])
    assert norm(ChartedSurface(Cone(4)).closest(behind)) < 1e-12
