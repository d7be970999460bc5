"""Bounds of faces' distances: between dense samples and what was asked for, and covariant."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pytest
from built_surfaces import OCTAHEDRON, OCTANTS, UnitSphere, bumpy_octahedron, exact_cap, graph, octahedron

from testbed import registry
from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.trivariate import Trivariate
from testbed.geometry.vectors import Float, norm, unit
from testbed.measures.face_distances import face_distances
from testbed_datasets.sphere import RoundSphere


@dataclass(frozen=True)
class Ball(PolynomialLevelSet):
    """A sphere anywhere, of which ``closest`` is not said to be nearest."""

    centre: tuple[float, float, float]
    radius: float = 1.0

    @cached_property
    def polynomial(self) -> Trivariate:
        x, y, z = self.centre
        squares = [((2, 0, 0), 1.0), ((0, 2, 0), 1.0), ((0, 0, 2), 1.0)]
        linear = [((1, 0, 0), -2.0 * x), ((0, 1, 0), -2.0 * y), ((0, 0, 1), -2.0 * z)]
        return Trivariate((*squares, *linear, ((0, 0, 0), x * x + y * y + z * z - self.radius**2)))

    def closest(self, points: Float) -> Float:
        foot: Float = np.array(self.centre) + self.radius * unit(points - np.array(self.centre))
        return foot


def sampled(surface: Surface, exact: ExactSurface, steps: int = 24) -> Float:
    """Largest distances (F,) of dense samples."""
    result = np.zeros(len(surface.mesh.faces))
    for part in surface.parts:
        points = part.batch.jets(lattice(part.batch.sides, steps), 0).f
        away = norm(points - exact.closest(points.reshape(-1, 3)).reshape(points.shape))
        np.maximum.at(result, part.faces, away.max(axis=1))
    return result


@pytest.mark.parametrize("scheme", ["flat", "cubic-interpolant", "shirman-sequin"])
@pytest.mark.parametrize("name", ["octahedron", "torus", "ellipsoid", "hyperboloid", "graph", "monkey-saddle"])
def test_bounds_are_on_both_sides_and_as_close_as_asked_for(name: str, scheme: str) -> None:
    dataset = registry.dataset(name)
    exact = dataset.surface
    assert exact is not None
    surface = registry.scheme(scheme).fit(dataset.mesh(1))
    known = sampled(surface, exact)
    tolerance = 0.2 * float(known.max())
    bounds = face_distances(surface, exact, tolerance)
    assert bounds.certified
    assert (bounds.high >= known - 1e-15).all()
    assert (bounds.high <= known + 1.1 * tolerance).all()
    # the samples are up to a 24th of a face away from the maximum
    assert (bounds.low <= 1.02 * known + 1e-15).all()
    assert (bounds.high - bounds.low <= 2.0 * tolerance).all()


def test_planes_are_at_no_distance_from_themselves() -> None:
    dataset = registry.dataset("plane")
    exact = dataset.surface
    assert exact is not None
    for scheme in ("flat", "cubic-interpolant", "shirman-sequin"):
        bounds = face_distances(registry.scheme(scheme).fit(dataset.mesh(1)), exact, 0.0)
        assert bounds.high.max() < 1e-13
        assert bounds.low.max() == 0.0


def test_exact_rational_patches_are_at_no_distance() -> None:
    bounds = face_distances(exact_cap(), RoundSphere(1.0), 0.0)
    assert bounds.high.max() < 1e-13


def test_bounds_follow_motions() -> None:
    surface, tolerance = bumpy_octahedron(1), 0.004
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    shift = np.array([3.0, -2.0, 0.5])
    before = face_distances(surface, Ball((0.0, 0.0, 0.0)), tolerance)
    moved = HermiteMesh(surface.mesh.points @ turn.T + shift, surface.mesh.faces)
    net = np.einsum("ij,pnj->pni", turn, batch.control_points) + shift
    after = face_distances(Surface.over_faces(moved, BezierTriangles(net)), Ball((3.0, -2.0, 0.5)), tolerance)
    assert np.abs(after.high - before.high).max() <= 1.001 * tolerance
    assert (after.high >= before.low - 1e-13).all()
    assert (before.high >= after.low - 1e-13).all()


def test_bounds_scale() -> None:
    surface = bumpy_octahedron(2)
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    once = face_distances(surface, RoundSphere(1.0), 0.004)
    for factor in (2.0**-30, 4.0):
        mesh = HermiteMesh(factor * surface.mesh.points, surface.mesh.faces)
        larger = Surface.over_faces(mesh, BezierTriangles(factor * batch.control_points))
        scaled = face_distances(larger, RoundSphere(factor), 0.004 * factor)
        assert np.allclose(scaled.high, factor * once.high, rtol=1e-12, atol=0.0)
        assert np.allclose(scaled.low, factor * once.low, rtol=1e-12, atol=0.0)


def test_bounds_do_not_depend_on_the_order_of_faces() -> None:
    surface = bumpy_octahedron(3)
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    order = np.random.default_rng(0).permutation(8)
    once = face_distances(surface, RoundSphere(1.0), 0.004)
    mesh = HermiteMesh(OCTAHEDRON, OCTANTS[order])
    other = face_distances(
        Surface.over_faces(mesh, BezierTriangles(batch.control_points[order])), RoundSphere(1.0), 0.004
    )
    assert np.array_equal(other.high, once.high[order])
    assert np.array_equal(other.low, once.low[order])


def test_a_threshold_saves_work_and_decides() -> None:
    surface, exact = bumpy_octahedron(4), RoundSphere(1.0)
    close = face_distances(surface, exact, 1e-4)
    middle = float(np.median(0.5 * (close.low + close.high)))
    decided = face_distances(surface, exact, 1e-4, threshold=middle)
    clear = np.abs(0.5 * (close.low + close.high) - middle) > 2e-4
    assert clear.sum() >= 6
    assert np.array_equal((decided.high <= middle)[clear], (close.high <= middle)[clear])
    assert np.array_equal((decided.low > middle)[clear], (close.low > middle)[clear])
    assert (decided.high >= close.low).all()


def test_tensor_product_patches() -> None:
    # z = x (1 - x) y (1 - y): 1/16 in the middle
    points = np.zeros((1, 3, 3, 3))
    points[0, ..., 0], points[0, ..., 1] = np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij")
    points[0, 1, 1, 2] = 0.25
    mesh = HermiteMesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
    plane = registry.dataset("plane[slope_x=0,slope_y=0]").surface
    assert plane is not None
    bounds = face_distances(Surface.over_faces(mesh, BezierQuads(points)), plane, 1e-6)
    assert bounds.low[0] <= 1.0 / 16.0 <= bounds.high[0] <= bounds.low[0] + 1.01e-6


def test_patches_without_control_points_have_no_bound() -> None:
    dataset = registry.dataset("octahedron")
    exact = dataset.surface
    assert exact is not None
    bounds = face_distances(registry.scheme("nielson").fit(dataset.mesh(0)), exact, 1e-3)
    assert np.isinf(bounds.high).all()
    assert not bounds.certified


def test_a_control_point_that_is_not_finite_costs_its_own_face() -> None:
    surface = octahedron()
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    points = batch.control_points.copy()
    points[5, 1, 2] = np.nan
    bounds = face_distances(Surface.over_faces(surface.mesh, BezierTriangles(points)), RoundSphere(1.0), 1e-2)
    assert np.flatnonzero(np.isinf(bounds.high)).tolist() == [5]
    others = np.delete(bounds.high, 5)
    assert np.abs(others - (1.0 - 1.0 / np.sqrt(3.0))).max() < 1.1e-2


def test_a_patch_through_the_centre_of_a_sphere_has_bounds() -> None:
    # the gradient vanishes there, and no foot is the nearest
    corners = np.array([[1.0, 0.0, 0.0], [-0.5, 0.8, 0.0], [-0.5, -0.8, 0.0]])
    surface = graph(lambda x, _: 0.0 * x, 1, corners[:, :2], np.array([[0, 1, 2]]))
    bounds = face_distances(surface, RoundSphere(1.0), 0.01)
    assert 0.99 <= bounds.low[0] <= 1.0 + 1e-12
    assert 1.0 <= bounds.high[0] <= 1.02


def test_where_a_surface_may_end_feet_bound_what_is_far_away_and_not_what_is_near() -> None:
    # nothing but feet are known of this sphere
    surface = bumpy_octahedron(5)
    known = sampled(surface, UnitSphere())
    bounds = face_distances(surface, UnitSphere(), 1e-3)
    assert (bounds.high >= known).all()
    assert (bounds.high <= known + 5e-3).all()
    assert (bounds.low <= 1.02 * known).all()
    # pieces would have to be as small as the tolerance
    on_sphere = face_distances(exact_cap(), UnitSphere(), 1e-6)
    assert np.isinf(on_sphere.high).all()
    assert on_sphere.low.max() < 1e-15
