"""Bounds of distances against dense samples in extended precision: never on the wrong side, and close."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from testbed.geometry.bernstein import multi_indices
from testbed.geometry.composition import BernsteinBasis, binomials
from testbed.geometry.distance_bounds import PatchNets, distance_bounds
from testbed.geometry.domain import lattice
from testbed.geometry.exact import ExactSurface
from testbed.geometry.level_bounds import PolynomialLevelSet
from testbed.geometry.vectors import Bool, Float, Int, norm
from testbed_datasets.bump import Bump
from testbed_datasets.ellipsoid import Ellipsoid
from testbed_datasets.graph import Graph
from testbed_datasets.hyperboloid import Hyperboloid
from testbed_datasets.monkey_saddle import MonkeySaddle
from testbed_datasets.plane import Plane
from testbed_datasets.sphere import RoundSphere
from testbed_datasets.torus import Torus

Extended = NDArray[np.longdouble]
SURFACES: dict[str, ExactSurface] = {
    "sphere": RoundSphere(1.5),
    "ellipsoid": Ellipsoid().surface,
    "hyperboloid": Hyperboloid().surface,
    "torus": Torus().surface,
    "graph": Graph().surface,
    "saddle graph": Graph(height=3.0, bowl=0.0).surface,
    "monkey saddle": MonkeySaddle().surface,
    "plane": Plane().surface,
}
BASES = [BernsteinBasis((3,)), BernsteinBasis((4,)), BernsteinBasis((3, 3)), BernsteinBasis((1, 2))]
every_surface = pytest.mark.parametrize("name", SURFACES)
every_basis = pytest.mark.parametrize("basis", BASES, ids=str)


def sides(basis: BernsteinBasis) -> int:
    return 3 if len(basis.degrees) == 1 else 4


def parameters(basis: BernsteinBasis) -> Float:
    """Greville points of the control points, (n, 2)."""
    places: Float = basis.exponents / np.array([max(degree, 1) for degree in basis.degrees])
    return places


def patches_near(
    exact: ExactSurface, basis: BernsteinBasis, size: float, away: float, count: int = 10, seed: int = 0
) -> Float:
    """Control points (P, n, 3) at up to ``away`` from the surface, over triangles and squares of a size beside it."""
    random = np.random.default_rng(seed)
    anchor = exact.closest(random.uniform(-1.0, 1.0, (3 * count, 3)))
    anchor = anchor[np.isfinite(anchor).all(axis=1)][:count]
    frame = np.linalg.qr(np.concatenate([exact.normal(anchor)[..., None], random.normal(size=(count, 3, 2))], axis=2))[
        0
    ]
    at = parameters(basis) - parameters(basis).mean(axis=0)
    flat = anchor[:, None] + size * np.einsum("nk,pik->pni", at, frame[:, :, 1:])
    on_surface = exact.closest(flat.reshape(-1, 3)).reshape(flat.shape)
    points: Float = on_surface + away * random.normal(size=flat.shape)
    return points


def extended_points(basis: BernsteinBasis, nets: Float, at: Float) -> Extended:
    """Points (P, S, dim) of patches in extended precision."""
    u, v = (at[:, axis].astype(np.longdouble) for axis in range(2))
    weights = np.empty((len(at), len(basis)), dtype=np.longdouble)
    for column, (i, j) in enumerate(basis.exponents.tolist()):
        if len(basis.degrees) == 1:
            weights[:, column] = u**i * v**j * (1 - u - v) ** (basis.degrees[0] - i - j)
        else:
            weights[:, column] = u**i * (1 - u) ** (basis.degrees[0] - i) * v**j * (1 - v) ** (basis.degrees[1] - j)
    weights *= binomials(basis)
    result: Extended = np.einsum("sn,pnd->psd", weights, nets.astype(np.longdouble))
    return result


def extended_distances(exact: PolynomialLevelSet, points: Extended) -> Extended:
    """Distances (P, S): feet found in double precision, put onto the surface in extended precision.

    What is left of the foot's error is along the surface and changes the distance to second order only.
    """
    flat = points.reshape(-1, 3)
    foot = exact.closest(flat.astype(np.float64)).astype(np.longdouble)
    for _ in range(3):
        value, gradient = extended_polynomial(exact, foot)
        foot = foot - gradient * (value / (gradient**2).sum(axis=1))[:, None]
    result: Extended = np.sqrt(((flat - foot) ** 2).sum(axis=1)).reshape(points.shape[:-1])
    return result


def extended_polynomial(exact: PolynomialLevelSet, points: Extended) -> tuple[Extended, Extended]:
    value = np.zeros(len(points), dtype=np.longdouble)
    gradient = np.zeros((len(points), 3), dtype=np.longdouble)
    for powers, coefficient in exact.polynomial.terms:
        value += coefficient * np.prod([points[:, k] ** e for k, e in enumerate(powers)], axis=0)
        for axis in range(3):
            if powers[axis]:
                lower = [e - (k == axis) for k, e in enumerate(powers)]
                factors: Any = [points[:, k] ** e for k, e in enumerate(lower)]
                gradient[:, axis] += coefficient * powers[axis] * np.prod(factors, axis=0)
    return value, gradient


def polynomial_surface(name: str) -> PolynomialLevelSet:
    surface = SURFACES[name]
    assert isinstance(surface, PolynomialLevelSet)
    return surface


def centre(basis: BernsteinBasis) -> Float:
    return np.full((1, 2), 1.0 / 3.0) if sides(basis) == 3 else np.full((1, 2), 0.5)


@every_surface
@every_basis
@pytest.mark.parametrize(("size", "away"), [(0.4, 0.05), (0.1, 1e-3), (0.02, 1e-9), (0.01, 1e-15)])
def test_bounds_are_never_on_the_wrong_side(name: str, basis: BernsteinBasis, size: float, away: float) -> None:
    exact = polynomial_surface(name)
    nets = patches_near(exact, basis, size, away)
    bounds = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
    sampled = extended_distances(exact, extended_points(basis, nets, lattice(sides(basis), 8))).max(axis=1)
    assert (bounds.high >= sampled).all()
    there = extended_distances(exact, extended_points(basis, nets, centre(basis)))[:, 0]
    assert (bounds.low <= there).all()
    assert (bounds.seen <= there).all()


@every_surface
def test_rounding_is_part_of_the_bounds(name: str) -> None:
    # patches so small and near that everything is rounding
    exact, basis = polynomial_surface(name), BernsteinBasis((1,))
    nets = patches_near(exact, basis, 1e-15, 0.0, count=300)
    bounds = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
    sampled = extended_distances(exact, extended_points(basis, nets, lattice(3, 3))).max(axis=1)
    assert sampled.max() > 0.0
    assert (bounds.high >= sampled).all()
    assert (bounds.high <= sampled + 2e-12).all()
    assert (bounds.low <= sampled).all()


@every_surface
def test_lower_bounds_of_far_points(name: str) -> None:
    # points are patches of degree 0; feet are not asked where the level set's own bound is good
    exact, basis = polynomial_surface(name), BernsteinBasis((0,))
    for away in (0.02, 0.2, 0.6):
        nets = patches_near(exact, basis, 0.0, away, count=150)
        bounds = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
        there = extended_distances(exact, nets[:, 0].astype(np.longdouble))
        assert (bounds.low <= there).all()
        assert (bounds.high >= there * (1.0 - 1e-12)).all()
        assert np.median(bounds.low / there) > (0.5 if away < 0.5 else 0.2)


@every_surface
@every_basis
def test_bounds_of_small_patches_are_close(name: str, basis: BernsteinBasis) -> None:
    # a constant distance: nothing but the bounds' own slack is between them
    exact = polynomial_surface(name)
    nets = patches_near(exact, basis, 0.02, 0.0, count=12)
    flat = nets.reshape(-1, 3)
    nets = (flat + 1e-4 * exact.normal(flat)).reshape(nets.shape)
    bounds = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
    sampled = extended_distances(exact, extended_points(basis, nets, lattice(sides(basis), 8))).max(axis=1)
    there = extended_distances(exact, extended_points(basis, nets, centre(basis)))[:, 0]
    # Bernstein coefficients are off by the square of the patch's size
    assert (bounds.high <= 1.02 * sampled + 2e-4).all()
    assert (bounds.low >= 0.999 * there).all()


def test_bounds_of_rational_patches() -> None:
    basis = BernsteinBasis((3,))
    for name in ("sphere", "torus", "graph", "plane"):
        exact = polynomial_surface(name)
        nets = patches_near(exact, basis, 0.3, 0.01)
        w = np.random.default_rng(5).uniform(0.5, 2.0, nets.shape[:2])[..., None]
        homogeneous = np.concatenate([nets * w, w], axis=-1)
        bounds = distance_bounds(exact, PatchNets(basis, homogeneous, np.full(len(nets), 1e-15)))
        points = extended_points(basis, homogeneous, lattice(3, 12))
        sampled = extended_distances(exact, points[..., :3] / points[..., 3:]).max(axis=1)
        assert (bounds.high >= sampled).all()
        assert (bounds.high <= sampled + 2.0 * 0.3**2).all()
        # equal weights do not matter
        double = np.concatenate([2.0 * nets, np.full((*nets.shape[:2], 1), 2.0)], axis=-1)
        polynomial = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
        rational = distance_bounds(exact, PatchNets(basis, double, np.zeros(len(nets))))
        assert np.abs(rational.high - polynomial.high).max() < 1e-12
        assert np.abs(rational.low - polynomial.low).max() < 1e-12


def test_weights_that_are_not_positive_have_no_bound() -> None:
    basis = BernsteinBasis((2,))
    homogeneous = np.concatenate(
        [multi_indices(2) / 2.0, np.array([[1.0], [-0.2], [1.0], [1.0], [1.0], [1.0]])], axis=1
    )
    bounds = distance_bounds(RoundSphere(1.0), PatchNets(basis, homogeneous[None], np.zeros(1)))
    assert np.isinf(bounds.high[0])


def test_patches_on_the_bump_have_bounds() -> None:
    exact, basis = Bump(height=0.3, width=0.4, x=0.0, y=0.0).surface, BernsteinBasis((3,))
    for size, away in ((0.5, 0.1), (0.1, 1e-2), (0.02, 1e-6), (0.01, 0.0)):
        nets = patches_near(exact, basis, size, away, count=40)
        bounds = distance_bounds(exact, PatchNets(basis, nets, np.zeros(len(nets))))
        points = extended_points(basis, nets, lattice(3, 12)).astype(np.float64)
        sampled = norm(points - exact.closest(points.reshape(-1, 3)).reshape(points.shape)).max(axis=1)
        assert (bounds.high >= sampled - 1e-15).all()
        at_centre = extended_points(basis, nets, centre(basis)).astype(np.float64)[:, 0]
        assert (bounds.low <= norm(at_centre - exact.closest(at_centre)) + 1e-15).all()


class Ball(ExactSurface):
    """The unit sphere of which nothing is known but its curvature, and perhaps that it is whole."""

    def __init__(self, curvature: float, *, ends: bool = False) -> None:
        self.curvature, self.ends = curvature, ends

    def closest(self, points: Float) -> Float:
        return RoundSphere(1.0).closest(points)

    def normal(self, points: Float) -> Float:
        return RoundSphere(1.0).normal(points)

    def second_form(self, points: Float) -> Float:
        return RoundSphere(1.0).second_form(points)

    def curvature_bound(self, low: Float, high: Float) -> Float:
        assert (high >= low).all()
        return np.full(len(low), self.curvature)

    def may_end(self, low: Float, high: Float) -> Bool:
        assert (high >= low).all()
        return np.full(len(low), self.ends)


@pytest.mark.parametrize(("curvature", "ends"), [(1.0 + 1e-12, False), (3.0, False), (np.inf, False), (1.0, True)])
def test_bounds_by_curvature(curvature: float, ends: bool) -> None:
    basis = BernsteinBasis((3,))
    for size, away in ((0.5, 0.1), (0.1, 1e-3), (0.05, 0.0)):
        nets = patches_near(Ball(1.0), basis, size, away)
        bounds = distance_bounds(Ball(curvature, ends=ends), PatchNets(basis, nets, np.zeros(len(nets))))
        points = extended_points(basis, nets, lattice(3, 12))
        sampled = np.abs(np.sqrt((points**2).sum(axis=-1)) - 1).max(axis=1)
        assert (bounds.high >= sampled).all()
        # without a bound of curvature the patch's size, with one its square
        unknown = np.isinf(curvature) or ends
        reach = 2.0 * size if unknown else 2.0 * (1.0 + curvature) * size**2
        assert (bounds.high <= sampled + reach).all()
        assert not unknown or bounds.crude.all()
        assert unknown or size > 0.1 or not bounds.crude.any()


def test_a_point_without_a_foot_has_no_bound_by_curvature() -> None:
    bounds = distance_bounds(Ball(1.0), PatchNets(BernsteinBasis((0,)), np.zeros((1, 1, 3)), np.zeros(1)))
    assert np.isinf(bounds.high[0])
    assert bounds.low[0] == 0.0


def test_what_is_not_finite_has_no_bound() -> None:
    for bad in (np.nan, np.inf, 1e300):
        nets = np.array(multi_indices(3), dtype=np.float64)[None] / 3.0
        nets[0, 4, 1] = bad
        for exact in (RoundSphere(1.0), Ball(1.0)):
            bounds = distance_bounds(exact, PatchNets(BernsteinBasis((3,)), nets, np.zeros(1)))
            assert not bounds.high[0] < 1e290


def test_bounds_do_not_depend_on_other_patches() -> None:
    exact, basis = polynomial_surface("torus"), BernsteinBasis((3,))
    nets = patches_near(exact, basis, 0.2, 0.01, count=40)
    order: Int = np.random.default_rng(0).permutation(40)
    whole = distance_bounds(exact, PatchNets(basis, nets, np.zeros(40)))
    some = distance_bounds(exact, PatchNets(basis, nets[order[:7]], np.zeros(7)))
    assert np.array_equal(some.high, whole.high[order[:7]])
    assert np.array_equal(some.low, whole.low[order[:7]])
