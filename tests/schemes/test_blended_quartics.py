"""Rationally blended quartics: G1 across edges, exact derivatives of the blends, limits of curvature at corners."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron
from testbed.geometry.bernstein import triangle_tables
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import CORNERS, barycentric, corner_distance, lattice
from testbed.geometry.jets import Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import Basis, TabulatedTriangles
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.boundary_curves.walton_meek import WaltonMeekCurve
from testbed_schemes.herron import Herron, herron_basis
from testbed_schemes.mathematics.blended_quartics import CORNER_MARGIN, corner_table, gregory_basis
from testbed_schemes.triangular_gregory import TriangularGregory, longhi_basis
from testbed_schemes.walton_meek import WaltonMeek

Blended = TriangularGregory | Herron | WaltonMeek

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])
SCHEMES = (TriangularGregory(), TriangularGregory(blend="simple"), Herron(), WaltonMeek())
every_scheme = pytest.mark.parametrize("scheme", SCHEMES, ids=str)
every_basis = pytest.mark.parametrize("basis", [longhi_basis, gregory_basis, herron_basis])


def patches(surface: Surface) -> TabulatedTriangles:
    """Return the batch of a surface, a patch a face."""
    batch = surface.batches[0]
    assert isinstance(batch, TabulatedTriangles)
    return batch


def on(scheme: Blended, boundary: BoundaryCurve, jensen_c: float) -> Blended:
    """Return the scheme on other curves, and with Jensen's C where it has one."""
    if isinstance(scheme, WaltonMeek):
        return WaltonMeek(boundary)
    if isinstance(scheme, Herron):
        return Herron(boundary, jensen_c)
    return TriangularGregory(boundary, jensen_c, scheme.blend)


@every_scheme
@pytest.mark.parametrize("boundary", [Projected(), Planar(), Hermite(), WaltonMeekCurve()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_edges(scheme: Blended, mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for jensen_c in (1.0, 1.234):
        surface = on(scheme, boundary, jensen_c).fit(mesh)
        left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
        assert np.degrees(np.max(angle_between(left.normal, right.normal), initial=0.0)) < 1e-8
        assert np.max(norm(left.f - right.f), initial=0.0) < 1e-14 * (1.0 + np.abs(mesh.points).max())


@every_scheme
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_corners_have_the_points_and_normals_of_the_data(scheme: Blended, mesh: HermiteMesh) -> None:
    jet = scheme.fit(mesh).batches[0].jets(CORNERS[3])
    assert np.array_equal(jet.f, mesh.corner_points())
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-12
    assert np.isnan(jet.coefficients[3:]).all()


@every_scheme
def test_first_derivatives_at_corners_are_those_of_the_boundary_and_the_limit(scheme: Blended) -> None:
    mesh = perturbed_icosahedron()
    surface = scheme.fit(mesh)
    curves = scheme.boundary.network(mesh).along_sides()
    start = surface.batches[0].jets(CORNERS[3], order=1)
    assert start.fu[:, 0] == pytest.approx(3.0 * (curves[:, 0, 1] - curves[:, 0, 0]), abs=1e-14)
    assert start.fv[:, 0] == pytest.approx(3.0 * (curves[:, 2, 2] - curves[:, 2, 3]), abs=1e-14)
    towards = 1e-9 * (np.full(2, 1.0 / 3.0) - CORNERS[3])
    near = surface.batches[0].jets(CORNERS[3] + towards, order=1)
    assert near.coefficients == pytest.approx(start.coefficients, abs=2e-7)


@every_basis
def test_the_basis_is_a_partition_of_unity_and_the_quartic_one_for_equal_points(basis: Basis) -> None:
    at = lattice(3, 9)
    at = at[corner_distance(3, at) > 0.0]
    functions = np.stack(basis(*barycentric(at).T), axis=-1)
    assert functions.sum(axis=-1) == pytest.approx(np.ones(len(at)), abs=1e-15)
    quartic = triangle_tables(4, at, 0)[0]
    assert functions[:, :12] == pytest.approx(quartic[:, [0, 1, 3, 6, 10, 11, 12, 13, 14, 9, 5, 2]], abs=1e-15)
    assert functions[:, 12::2] + functions[:, 13::2] == pytest.approx(quartic[:, [4, 7, 8]], abs=1e-15)
    assert functions.min() >= 0.0


@every_basis
def test_the_basis_is_the_same_seen_from_any_corner_and_from_the_other_side(basis: Basis) -> None:
    b0, b1, b2 = np.random.default_rng(1).dirichlet((1, 1, 1), 20).T
    functions = np.stack(basis(b0, b1, b2))
    sides, inner = np.arange(12), np.arange(12, 18)
    turned = np.stack(basis(b1, b2, b0))
    assert np.array_equal(turned[np.concatenate([np.roll(sides, 4), np.roll(inner, 2)])], functions)
    reflected = np.stack(basis(b0, b2, b1))
    back = np.concatenate([[0], sides[:0:-1], [13, 12, 17, 16, 15, 14]])
    assert reflected[back] == pytest.approx(functions, abs=1e-15)


def exact_jets(basis: Basis, at: Float) -> Float:
    """Jets (6, 18) of a basis in rational arithmetic, by differences whose error is beyond double precision."""
    u, v = (Fraction(x) for x in at.tolist())
    step = min(u, v, 1 - u - v) / 10**18

    def at_step(i: int, j: int) -> Any:
        return np.array(basis(1 - u - v - (i + j) * step, u + i * step, v + j * step), dtype=object)

    first = [(at_step(*d) - at_step(-d[0], -d[1])) / (2 * step) for d in ((1, 0), (0, 1))]
    second = [(at_step(*d) - 2 * at_step(0, 0) + at_step(-d[0], -d[1])) / step**2 for d in ((1, 0), (0, 1))]
    mixed = (at_step(1, 1) - at_step(1, -1) - at_step(-1, 1) + at_step(-1, -1)) / (4 * step**2)
    return np.stack([at_step(0, 0), *first, second[0], mixed, second[1]]).astype(np.float64)


@every_basis
@pytest.mark.parametrize("corner", [0, 1, 2])
@pytest.mark.parametrize("distance", [0.3, 1e-3, CORNER_MARGIN])
def test_derivatives_are_exact_down_to_the_stated_margin(basis: Basis, corner: int, distance: float) -> None:
    batch = TabulatedTriangles(basis, np.zeros((1, 18, 3)), corner_table(), CORNER_MARGIN)
    for direction in (0.1, 0.37, 0.9):
        b = np.roll([1.0 - distance, distance * direction, distance * (1.0 - direction)], corner)
        found = np.moveaxis(batch.functions(b[None, 1:], 2), 0, -1)[:, 0]
        expected = exact_jets(basis, b[1:])
        assert found[:3] == pytest.approx(expected[:3], abs=1e-14)
        assert found[3:] == pytest.approx(expected[3:], abs=1e-14 + 1e-14 / distance)


def limit_at_corner_0(points: Float, x: float) -> Jet:
    """Limit of the jets (6, F, 1, 3) as corner 0 is approached along (x, 1 - x).

    There the inner point has the share y : x of I_01 : I_02, and its polynomial is 12 x y to second order.
    """
    y = 1.0 - x
    corner, along_u, along_uu, along_vv, along_v = points[:, [0, 1, 2, 10, 11]].transpose(1, 0, 2)
    one, turn = points[:, 12], points[:, 13] - points[:, 12]
    fu, fv = 4.0 * (along_u - corner), 4.0 * (along_v - corner)
    fuu = 12.0 * (along_uu - 2.0 * along_u + corner + 2.0 * y**3 * turn)
    fvv = 12.0 * (along_vv - 2.0 * along_v + corner - 2.0 * x**3 * turn)
    fuv = 12.0 * (one + (x**3 + 3.0 * x**2 * y) * turn - along_u - along_v + corner)
    return Jet(np.stack([corner, fu, fv, fuu, fuv, fvv])[:, :, None])


@every_scheme
def test_near_a_corner_the_curvature_depends_on_the_direction_as_predicted(scheme: Blended) -> None:
    batch = patches(scheme.fit(perturbed_icosahedron()))
    limits = []
    for x in (0.0, 0.2, 0.5, 0.75, 1.0):
        limit = limit_at_corner_0(batch.control_points, x)
        found = batch.jets(CORNER_MARGIN * np.array([[x, 1.0 - x]]))
        assert found.coefficients == pytest.approx(limit.coefficients, abs=2e-4)
        assert gauss(found) == pytest.approx(gauss(limit), abs=2e-4)
        limits.append(gauss(limit))
    assert np.ptp(limits, axis=0).max() > 0.1


def test_blends_of_the_same_points_agree_on_edges_to_first_order_only() -> None:
    mesh = perturbed_icosahedron()
    one, other = (patches(TriangularGregory(blend=blend).fit(mesh)) for blend in ("longhi", "simple"))
    assert np.array_equal(one.control_points, other.control_points)
    edge = np.array([[0.3, 0.0]])
    assert one.jets(edge, 1).coefficients == pytest.approx(other.jets(edge, 1).coefficients, abs=1e-14)
    assert norm(one.jets(edge).fvv - other.jets(edge).fvv).max() > 1e-2


@every_scheme
@pytest.mark.parametrize("order", [0, 1, 2])
def test_points_of_their_own_give_what_shared_points_give(scheme: Blended, order: int) -> None:
    batch = patches(scheme.fit(perturbed_icosahedron()))
    at = lattice(3, 5)
    shared, own = batch.jets(at, order), batch.jets(np.broadcast_to(at, (len(batch), *at.shape)), order)
    assert own.coefficients == pytest.approx(shared.coefficients, abs=1e-12, nan_ok=True)
    assert own.coefficients.shape == shared.coefficients.shape == ((1, 3, 6)[order], len(batch), len(at), 3)


@every_scheme
def test_jets_do_not_depend_on_the_batch(scheme: Blended) -> None:
    batch = patches(scheme.fit(perturbed_icosahedron()))
    at = lattice(3, 6)
    own = np.random.default_rng(4).dirichlet((1, 1, 1), (len(batch), 7))[..., :2]
    chosen = np.array([13, 2, 2])
    for where, there in ((at, at), (own, own[chosen])):
        all_patches, few = batch.jets(where), batch.take(chosen).jets(there)
        assert np.array_equal(all_patches.coefficients[:, chosen], few.coefficients, equal_nan=True)
    one = batch.jets(at[5:6])
    assert np.array_equal(batch.jets(at).coefficients[:, :, 5:6], one.coefficients)


@every_scheme
def test_flat_data_give_the_plane_and_its_own_parameters(scheme: Blended) -> None:
    mesh = ZOO["flat mesh"]
    at = lattice(3, 8)
    jet = scheme.fit(mesh).batches[0].jets(at)
    expected = np.einsum("bi,fix->fbx", barycentric(at), mesh.corner_points())
    assert jet.f == pytest.approx(expected, abs=2e-15)
    away = corner_distance(3, at) > 0.0
    assert np.abs(jet.coefficients[3:, :, away]).max() < 1e-13


@every_scheme
def test_more_faces_than_a_block_have_the_points_they_have_alone(scheme: Blended) -> None:
    mesh = octahedron()
    many = np.tile(np.arange(8), 300)
    assert mesh.normals is not None
    shift = np.repeat(10.0 * np.arange(300), 6)[:, None] * np.array([1.0, 0.0, 0.0])
    copies = HermiteMesh(
        np.tile(mesh.points, (300, 1)) + shift,
        np.tile(mesh.faces, (300, 1)) + np.repeat(6 * np.arange(300), 8)[:, None],
        np.tile(mesh.normals, (300, 1)),
    )
    alone, found = patches(scheme.fit(mesh)).control_points, patches(scheme.fit(copies)).control_points
    assert found - np.repeat(shift[::6], 8, axis=0)[:, None] == pytest.approx(alone[many], abs=1e-11)
