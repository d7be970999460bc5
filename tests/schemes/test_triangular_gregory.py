"""The triangular Gregory patch: G1 across edges, exact derivatives of the blends, and the printed blend that fails."""

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.bernstein import triangle_tables
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import CORNERS, barycentric, corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.triangular_gregory import CORNER_MARGIN, TriangularGregory, corner_table, gregory_basis

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])


def jumps(surface: Surface) -> tuple[float, float]:
    """Largest angle between normals across edges in degrees, and largest gap."""
    edges = surface.edges[surface.edges.interior]
    left, right = surface.edge_jets(edges, T, order=1)
    angle = np.degrees(angle_between(left.normal, right.normal))
    return float(np.max(angle, initial=0.0)), float(np.max(norm(left.f - right.f), initial=0.0))


def patches(surface: Surface) -> TabulatedTriangles:
    """Return the batch of a surface, a patch a face."""
    batch = surface.batches[0]
    assert isinstance(batch, TabulatedTriangles)
    return batch


def points(surface: Surface) -> Float:
    """Control points, (F, 18, 3)."""
    return patches(surface).control_points


@pytest.mark.parametrize("boundary", [TriangularGregory().boundary, Planar(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_edges(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for jensen_c in (1.0, 1.234):
        angle, gap = jumps(TriangularGregory(boundary, jensen_c).fit(mesh))
        assert angle < 1e-8
        assert gap < 1e-14 * (1.0 + np.abs(mesh.points).max())


@given(st.floats(0.5, 3.0))
@settings(max_examples=15, deadline=None)
def test_every_c_leaves_the_surface_tangent_continuous(jensen_c: float) -> None:
    assert jumps(TriangularGregory(jensen_c=jensen_c).fit(perturbed_icosahedron()))[0] < 1e-8


@pytest.mark.parametrize(("mesh", "printed_jump"), [(octahedron(), 16.099), (perturbed_icosahedron(), 10.704)])
def test_the_printed_blend_has_its_points_exchanged(mesh: HermiteMesh, printed_jump: float) -> None:
    """I_ij from the edge b_j = 0 must stand alone on that edge; Mann 1992, section 2.3.2 gives I_ik all of it there."""
    surface = TriangularGregory().fit(mesh)
    exchanged = points(surface)[:, [*range(12), 13, 12, 15, 14, 17, 16]]
    printed = TabulatedTriangles(gregory_basis, exchanged, corner_table(), CORNER_MARGIN)
    assert jumps(surface)[0] < 1e-12
    assert jumps(Surface.over_faces(mesh, printed))[0] == pytest.approx(printed_jump, abs=1e-3)


@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_corners_have_the_points_and_normals_of_the_data(mesh: HermiteMesh) -> None:
    jet = TriangularGregory().fit(mesh).batches[0].jets(CORNERS[3])
    assert np.array_equal(jet.f, mesh.corner_points())
    assert angle_between(jet.normal, mesh.corner_normals()).max() < 1e-12
    assert np.isnan(jet.coefficients[3:]).all()


def test_first_derivatives_at_corners_are_those_of_the_boundary_and_the_limit() -> None:
    mesh = perturbed_icosahedron()
    surface = TriangularGregory().fit(mesh)
    curves = TriangularGregory().boundary.network(mesh).along_sides()
    start = surface.batches[0].jets(CORNERS[3], order=1)
    assert start.fu[:, 0] == pytest.approx(3.0 * (curves[:, 0, 1] - curves[:, 0, 0]), abs=1e-14)
    assert start.fv[:, 0] == pytest.approx(3.0 * (curves[:, 2, 2] - curves[:, 2, 3]), abs=1e-14)
    towards = 1e-9 * (np.full(2, 1.0 / 3.0) - CORNERS[3])
    near = surface.batches[0].jets(CORNERS[3] + towards, order=1)
    assert near.coefficients == pytest.approx(start.coefficients, abs=2e-7)


def exact_jets(at: Float) -> Float:
    """Jets (6, 18) of the basis in rational arithmetic, by differences whose error is beyond double precision."""
    u, v = (Fraction(x) for x in at.tolist())
    step = min(u, v, 1 - u - v) / 10**18

    def basis(i: int, j: int) -> Any:
        return np.array(gregory_basis(1 - u - v - (i + j) * step, u + i * step, v + j * step), dtype=object)

    first = [(basis(*d) - basis(-d[0], -d[1])) / (2 * step) for d in ((1, 0), (0, 1))]
    second = [(basis(*d) - 2 * basis(0, 0) + basis(-d[0], -d[1])) / step**2 for d in ((1, 0), (0, 1))]
    mixed = (basis(1, 1) - basis(1, -1) - basis(-1, 1) + basis(-1, -1)) / (4 * step**2)
    return np.stack([basis(0, 0), *first, second[0], mixed, second[1]]).astype(np.float64)


@pytest.mark.parametrize("corner", [0, 1, 2])
@pytest.mark.parametrize("distance", [0.3, 1e-3, CORNER_MARGIN])
def test_derivatives_are_exact_down_to_the_stated_margin(corner: int, distance: float) -> None:
    batch = patches(TriangularGregory().fit(octahedron()))
    for direction in (0.1, 0.37, 0.9):
        b = np.roll([1.0 - distance, distance * direction, distance * (1.0 - direction)], corner)
        found = np.moveaxis(batch.functions(b[None, 1:], 2), 0, -1)[:, 0]
        expected = exact_jets(b[1:])
        assert found[:3] == pytest.approx(expected[:3], abs=1e-14)
        assert found[3:] == pytest.approx(expected[3:], abs=1e-14 + 1e-14 / distance)


def test_the_basis_is_a_partition_of_unity_and_the_quartic_one_for_equal_points() -> None:
    at = lattice(3, 9)
    at = at[corner_distance(3, at) > 0.0]
    functions = np.stack(gregory_basis(*barycentric(at).T), axis=-1)
    assert functions.sum(axis=-1) == pytest.approx(np.ones(len(at)), abs=1e-15)
    inner = functions[:, 12:].reshape(-1, 3, 2).sum(axis=-1)
    assert inner == pytest.approx(triangle_tables(4, at, 0)[0][:, [4, 7, 8]], abs=1e-15)
    assert functions.min() >= 0.0


def test_near_a_corner_the_second_derivatives_depend_on_the_direction_as_predicted() -> None:
    """Near corner 0 I_01 has the share y / (x + y) of x y, with x = b1 and y = b2; differentiated at x + y = 1."""
    batch = patches(TriangularGregory().fit(perturbed_icosahedron()))
    corner, along_u, along_v, *_ = batch.control_points.transpose(1, 0, 2)
    one, other = batch.control_points[:, 12], batch.control_points[:, 13]
    for x in (0.2, 0.5, 0.75):
        y = 1.0 - x
        inner = (y**3 + 3 * x * y**2) * one + (x**3 + 3 * x**2 * y) * other
        found = batch.jets(CORNER_MARGIN * np.array([[x, y]])).fuv[:, 0]
        assert found == pytest.approx(12.0 * (inner - along_u - along_v + corner), abs=1e-4)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_points_of_their_own_give_what_shared_points_give(order: int) -> None:
    batch = patches(TriangularGregory().fit(perturbed_icosahedron()))
    at = lattice(3, 5)
    shared, own = batch.jets(at, order), batch.jets(np.broadcast_to(at, (len(batch), *at.shape)), order)
    assert own.coefficients == pytest.approx(shared.coefficients, abs=1e-12, nan_ok=True)
    assert own.coefficients.shape == shared.coefficients.shape == ((1, 3, 6)[order], len(batch), len(at), 3)


def test_jets_do_not_depend_on_the_batch() -> None:
    batch = patches(TriangularGregory().fit(perturbed_icosahedron()))
    at = lattice(3, 6)
    own = np.random.default_rng(4).dirichlet((1, 1, 1), (len(batch), 7))[..., :2]
    chosen = np.array([13, 2, 2])
    for where, there in ((at, at), (own, own[chosen])):
        all_patches, few = batch.jets(where), batch.take(chosen).jets(there)
        assert np.array_equal(all_patches.coefficients[:, chosen], few.coefficients, equal_nan=True)
    one = batch.jets(at[5:6])
    assert np.array_equal(batch.jets(at).coefficients[:, :, 5:6], one.coefficients)


@pytest.mark.parametrize(
    ("scheme", "extremes"),
    [(TriangularGregory(), (0.3826, 2.706)), (TriangularGregory(Hermite(), jensen_c=1.234), (0.978, 1.028))],
    ids=str,
)
def test_the_curvatures_of_the_octahedron(scheme: TriangularGregory, extremes: tuple[float, float]) -> None:
    at = lattice(3, 60)
    curvature = gauss(scheme.fit(octahedron()).batches[0].take(slice(0, 1)).jets(at[corner_distance(3, at) > 0.0]))
    assert (float(curvature.min()), float(curvature.max())) == pytest.approx(extremes, abs=1e-3)


def test_flat_data_give_the_plane_and_its_own_parameters() -> None:
    mesh = ZOO["flat mesh"]
    at = lattice(3, 8)
    jet = TriangularGregory().fit(mesh).batches[0].jets(at)
    expected = np.einsum("bi,fix->fbx", barycentric(at), mesh.corner_points())
    assert jet.f == pytest.approx(expected, abs=2e-15)
    away = corner_distance(3, at) > 0.0
    assert np.abs(jet.coefficients[3:, :, away]).max() < 1e-13


@given(st.floats(-1.0, 3.0))
@settings(max_examples=15, deadline=None)
def test_flat_data_give_the_plane_for_all_c(jensen_c: float) -> None:
    mesh = ZOO["flat mesh"]
    assert mesh.normals is not None
    offset = points(TriangularGregory(jensen_c=jensen_c).fit(mesh)) - mesh.points[0]
    assert np.abs(offset @ mesh.normals[0]).max() < 1e-14


def test_moving_a_vertex_changes_its_own_faces_only() -> None:
    mesh = torus(8, 5, 3)
    assert mesh.normals is not None
    moved = np.array(mesh.points)
    moved[7] += [0.01, -0.02, 0.015]
    before = points(TriangularGregory().fit(mesh))
    after = points(TriangularGregory().fit(HermiteMesh(moved, mesh.faces, mesh.normals)))
    assert np.array_equal((before != after).any(axis=(1, 2)), (mesh.faces == 7).any(axis=1))


def test_faces_may_stand_in_any_order_and_start_at_any_corner() -> None:
    mesh = perturbed_icosahedron()
    order = np.random.default_rng(2).permutation(len(mesh.faces))
    turned = HermiteMesh(mesh.points, np.roll(mesh.faces[order], 1, axis=1), mesh.normals)
    one, other = TriangularGregory().fit(mesh), TriangularGregory().fit(turned)
    assert np.array_equal(
        points(other)[:, 12:].reshape(-1, 3, 2, 3)[:, [1, 2, 0]], points(one)[order][:, 12:].reshape(-1, 3, 2, 3)
    )
    bary = np.tile([0.2, 0.5, 0.3], (len(mesh.faces), 1))
    there = other.evaluate(np.arange(len(order)), np.roll(bary, 1, axis=1), 0)
    assert there.f == pytest.approx(one.evaluate(order, bary, 0).f, abs=1e-14)


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100.0))
@settings(max_examples=20, deadline=None)
def test_the_surface_moves_turns_and_grows_with_its_data(seed: int, scale: float) -> None:
    mesh, rng = perturbed_icosahedron(), np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    shift = rng.normal(size=3)
    assert mesh.normals is not None
    moved = HermiteMesh(scale * mesh.points @ rotation.T + shift, mesh.faces, mesh.normals @ rotation.T)
    expected = scale * points(TriangularGregory().fit(mesh)) @ rotation.T + shift
    assert points(TriangularGregory().fit(moved)) == pytest.approx(expected, abs=1e-13 * (scale + 3.0))


def test_turning_the_mesh_inside_out_keeps_the_surface() -> None:
    mesh = perturbed_icosahedron()
    assert mesh.normals is not None
    inside_out = HermiteMesh(mesh.points, mesh.faces[:, [0, 2, 1]], -mesh.normals)
    one, other = TriangularGregory().fit(mesh), TriangularGregory().fit(inside_out)
    bary = np.tile([0.2, 0.5, 0.3], (len(mesh.faces), 1))
    faces = np.arange(len(mesh.faces))
    assert other.evaluate(faces, bary[:, [0, 2, 1]], 0).f == pytest.approx(one.evaluate(faces, bary, 0).f, abs=1e-14)


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="needs vertex normals"):
        TriangularGregory().fit(HermiteMesh(mesh.points, mesh.faces))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        TriangularGregory().fit(torus(8, 5, 4))
    normals = np.array(mesh.normals)
    normals[0] = np.array([-1.0, 1.0, 0.0]) / math.sqrt(2.0)
    with pytest.raises(Refused, match="vertex 0 to vertex 2"):
        TriangularGregory().fit(HermiteMesh(mesh.points, mesh.faces, normals))


@pytest.mark.parametrize("jensen_c", [float("nan"), float("inf")])
def test_a_jensen_c_that_is_not_finite_is_no_parameter(jensen_c: float) -> None:
    with pytest.raises(SpecError, match="jensen_c must be finite"):
        TriangularGregory(jensen_c=jensen_c)


def test_tables_that_do_not_fit_their_points_are_an_error() -> None:
    with pytest.raises(ValueError, match="corner table"):
        TabulatedTriangles(gregory_basis, np.zeros((2, 17, 3)), corner_table(), 0.0)
