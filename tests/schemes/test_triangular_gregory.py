"""The triangular Gregory patch: its two blends, the printed one that fails, and invariance (more: blended quartics)."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import testbed
from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import corner_distance, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.tabulated import TabulatedTriangles
from testbed.geometry.vectors import Float, angle_between, norm
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.mathematics.blended_quartics import CORNER_MARGIN, corner_table
from testbed_schemes.triangular_gregory import TriangularGregory, longhi_basis

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


@given(st.floats(0.5, 3.0))
@settings(max_examples=15, deadline=None)
def test_every_c_leaves_the_surface_tangent_continuous(jensen_c: float) -> None:
    assert jumps(TriangularGregory(jensen_c=jensen_c).fit(perturbed_icosahedron()))[0] < 1e-8


@pytest.mark.parametrize(("mesh", "printed_jump"), [(octahedron(), 16.099), (perturbed_icosahedron(), 10.704)])
def test_the_printed_blend_has_its_points_exchanged(mesh: HermiteMesh, printed_jump: float) -> None:
    """I_ij from the edge b_j = 0 must stand alone on that edge; Mann 1992, section 2.3.2 gives I_ik all of it there."""
    surface = TriangularGregory().fit(mesh)
    exchanged = points(surface)[:, [*range(12), 13, 12, 15, 14, 17, 16]]
    printed = TabulatedTriangles(longhi_basis, exchanged, corner_table(), CORNER_MARGIN)
    assert jumps(surface)[0] < 1e-12
    assert jumps(Surface.over_faces(mesh, printed))[0] == pytest.approx(printed_jump, abs=1e-3)


def test_the_simple_blend_is_another_surface_through_the_same_control_points() -> None:
    mesh, at = octahedron(), np.full((1, 2), 1.0 / 3.0)
    longhi, simple = TriangularGregory().fit(mesh), TriangularGregory(blend="simple").fit(mesh)
    assert np.array_equal(points(longhi), points(simple))
    # at the centre the shares are equal, so are the points; elsewhere the surfaces part
    assert longhi.batches[0].jets(at, 0).f == pytest.approx(simple.batches[0].jets(at, 0).f, abs=1e-15)
    at = lattice(3, 30)
    apart = norm(longhi.batches[0].jets(at, 0).f - simple.batches[0].jets(at, 0).f).max()
    assert apart == pytest.approx(2.8e-3, abs=1e-4)
    assert TriangularGregory(blend="simple") == testbed.scheme("triangular-gregory[blend=simple]")


@pytest.mark.parametrize(
    ("scheme", "extremes"),
    [
        (TriangularGregory(), (0.38231, 2.70555)),
        (TriangularGregory(Hermite(), jensen_c=1.234), (0.97736, 1.02847)),
        (TriangularGregory(Hermite(), jensen_c=1.234, blend="simple"), (0.98152, 1.03127)),
    ],
    ids=str,
)
def test_the_curvatures_of_the_octahedron(scheme: TriangularGregory, extremes: tuple[float, float]) -> None:
    at = lattice(3, 60)
    curvature = gauss(scheme.fit(octahedron()).batches[0].take(slice(0, 1)).jets(at[corner_distance(3, at) > 0.0]))
    assert (float(curvature.min()), float(curvature.max())) == pytest.approx(extremes, abs=1e-5)


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
        TabulatedTriangles(longhi_basis, np.zeros((2, 17, 3)), corner_table(), 0.0)
