"""Shirman-Sequin: G1 everywhere for all parameters, the published curvatures, and the printed N_i that fails."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbed.conformance.meshes import cases, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import CORNERS, barycentric, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm, unit
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.mathematics.split_domain import J, K, c1_ring
from testbed_schemes.shirman_sequin import ShirmanSequin

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, 1e-2, *np.linspace(0.05, 0.95, 13), 1 - 1e-2, 1 - 1e-3, 1.0])


def jumps(surface: Surface) -> tuple[float, float, float]:
    """Largest angle between normals in degrees across mesh edges and across inner edges, and largest gap."""
    edges = surface.edges[surface.edges.interior]
    left, right = surface.edge_jets(edges, T, order=1)
    angle = np.degrees(angle_between(left.normal, right.normal)).max(axis=1)
    gap = norm(left.f - right.f).max()
    return float(np.max(angle[~edges.within_face], initial=0.0)), float(angle[edges.within_face].max()), float(gap)


def nets(surface: Surface) -> Float:
    """Control points of the quartics, (F, 3, 15, 3)."""
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    assert batch.degree == 4
    return batch.control_points.reshape(-1, 3, 15, 3)


def mixed(mesh: HermiteMesh, seed: int = 0) -> tuple[float, ...]:
    """An alpha2 for each vertex."""
    return tuple(np.random.default_rng(seed).uniform(1.2, 3.0, len(mesh.points)).tolist())


@pytest.mark.parametrize("boundary", [ShirmanSequin().boundary, Planar(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_mesh_edges_and_inner_edges(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    for scheme in (ShirmanSequin(boundary), ShirmanSequin(boundary, jensen_c=1.3, alpha2=mixed(mesh))):
        outer, inner, gap = jumps(scheme.fit(mesh))
        assert outer < 1e-8
        assert inner < 1e-8
        assert gap < 1e-14 * (1.0 + np.abs(mesh.points).max())


@given(st.floats(0.5, 2.5), st.floats(0.5, 6.0), st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_every_c_and_alpha_leaves_the_surface_tangent_continuous(jensen_c: float, alpha2: float, seed: int) -> None:
    mesh = perturbed_icosahedron()
    alphas = np.random.default_rng(seed).uniform(0.7, 1.3, len(mesh.points)) * alpha2
    outer, inner, gap = jumps(ShirmanSequin(jensen_c=jensen_c, alpha2=tuple(alphas.tolist())).fit(mesh))
    assert max(outer, inner) < 1e-8
    assert gap < 1e-14


@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_corners_have_the_points_and_normals_of_the_data(mesh: HermiteMesh) -> None:
    surface = ShirmanSequin(alpha2=mixed(mesh)).fit(mesh)
    part = surface.parts[0]
    jet = part.batch.jets(CORNERS[3][:2], order=1)
    ids = part.corner_ids[:, :2]
    assert mesh.normals is not None
    assert np.array_equal(jet.f, mesh.points[ids])
    assert angle_between(jet.normal, mesh.normals[ids]).max() < 1e-12


def printed_n(alpha: Float, first: Float, second: Float) -> Float:
    """N_i as Mann 1992 prints it, the alphas of corner i (F, 3, 1) standing for all."""
    a3 = -0.75
    w = (2.0 - alpha + 2.0 * 2.75) / 6.0
    return (
        -a3 / 3.0 * (first - first[:, J] - first[:, K])
        + (alpha / 18.0 - w) * second
        + (alpha / 18.0 + w) * (second[:, J] + second[:, K])
    )


def spoke_cubics(net: Float) -> tuple[Float, Float]:
    """The cubic points I_i1 and I_i2 by corner i, recovered from the quartic spokes of sub-patch j = i + 1."""
    corner, first, second = (net[:, J][:, :, place] for place in (10, 11, 12))
    # sub-patch i + 1 runs from corner i + 2 to corner i: its second corner
    cubic_first = (4.0 * first - corner) / 3.0
    return cubic_first, 2.0 * second - cubic_first


def with_printed_n(surface: Surface, scheme: ShirmanSequin) -> Surface:
    """The same surface with the N_i as printed."""
    net = nets(surface).copy()
    alpha = np.broadcast_to(scheme.corner_alphas(surface.mesh), (len(net), 3))[..., None]
    net[:, :, 8] = printed_n(alpha, *spoke_cubics(net))
    return Surface.over_split_faces(surface.mesh, BezierTriangles(net.reshape(-1, 15, 3)))


def test_the_printed_n_is_ours_for_equal_alphas_and_breaks_the_inner_joins_for_others() -> None:
    mesh = octahedron()
    for alpha2 in (2.25, 1.75, 3.0):
        equal = ShirmanSequin(alpha2=alpha2)
        surface = equal.fit(mesh)
        assert nets(with_printed_n(surface, equal)) == pytest.approx(nets(surface), abs=1e-14)
    face = HermiteMesh(mesh.points[[0, 2, 4]], [[0, 1, 2]], mesh.points[[0, 2, 4]])
    unequal = ShirmanSequin(alpha2=(2.25, 2.0, 1.8))
    surface = unequal.fit(face)
    assert jumps(surface)[1] < 1e-12
    assert jumps(with_printed_n(surface, unequal))[1] == pytest.approx(1.462, abs=1e-3)


def extremes(scheme: ShirmanSequin) -> tuple[float, float]:
    """Gaussian curvature of the octahedron's surface, all patches being alike."""
    curvature = gauss(scheme.fit(octahedron()).batches[0].take(slice(0, 1)).jets(lattice(3, 120)))
    return float(curvature.min()), float(curvature.max())


@pytest.mark.parametrize(
    ("scheme", "published", "exact"),
    [
        (ShirmanSequin(), ("0.28", "2.5"), (0.27757, 2.51472)),
        (ShirmanSequin(Hermite()), ("0.44", "1.4"), (0.44260, 1.44614)),
        (ShirmanSequin(Hermite(), jensen_c=1.055, alpha2=1.75), ("0.98", "1.03"), (0.97840, 1.02775)),
    ],
    ids=str,
)
def test_the_published_curvatures_of_the_octahedron(
    scheme: ShirmanSequin, published: tuple[str, str], exact: tuple[float, float]
) -> None:
    """Mann 1992, figure 2.20. The extremes with more digits are ours, corners included."""
    found = extremes(scheme)
    assert found == pytest.approx(exact, abs=2e-5)
    assert tuple(f"{value:.{len(text) - 2}f}" for value, text in zip(found, published, strict=True)) == published


def test_flat_data_give_the_plane_and_its_own_parameters() -> None:
    mesh = ZOO["flat mesh"]
    surface = ShirmanSequin(jensen_c=1.0).fit(mesh)
    bary = barycentric(lattice(3, 7))
    face = np.repeat(np.arange(len(mesh.faces)), len(bary))
    jet = surface.evaluate(face, np.tile(bary, (len(mesh.faces), 1)), order=2)
    expected = np.einsum("bi,fix->fbx", bary, mesh.corner_points()).reshape(-1, 3)
    assert jet.f == pytest.approx(expected, abs=2e-15)
    assert np.abs(jet.coefficients[3:]).max() < 1e-13


@given(st.floats(-1.0, 3.0), st.floats(0.5, 5.0))
@settings(max_examples=20, deadline=None)
def test_flat_data_give_the_plane_for_all_parameters(jensen_c: float, alpha2: float) -> None:
    mesh = ZOO["flat mesh"]
    assert mesh.normals is not None
    points = nets(ShirmanSequin(jensen_c=jensen_c, alpha2=alpha2).fit(mesh)).reshape(-1, 3)
    assert np.abs((points - mesh.points[0]) @ mesh.normals[0]).max() < 1e-14


def test_the_inner_joins_are_c1_for_the_original_alpha_and_only_then() -> None:
    mesh = perturbed_icosahedron()
    ratio = []
    for alpha2 in (2.25, 2.0):
        net = nets(ShirmanSequin(alpha2=alpha2).fit(mesh))
        ring = c1_ring(net[:, :, [0, 1, 3, 6, 10]], (net[:, :, 4], net[:, :, 7]), net[:, :, 8])
        ratio.append(float(np.abs(ring.nets() - net).max()))
    assert ratio[0] < 1e-14
    assert ratio[1] > 1e-3


def test_the_ring_joins_with_c1_whatever_the_free_points() -> None:
    rng = np.random.default_rng(5)
    boundary = rng.normal(size=(6, 3, 5, 3))
    boundary[:, :, 4] = boundary[:, J, 0]
    cross_points = (rng.normal(size=(6, 3, 3)), rng.normal(size=(6, 3, 3)))
    net = c1_ring(boundary, cross_points, rng.normal(size=(6, 3, 3))).nets()
    # along spoke V_k S of sub-patches i and j: 3 (spoke point) = spoke point before + its neighbours on either side
    spoke, before, left, right = [11, 12, 13], [10, 11, 12], [6, 7, 8], [1, 4, 8]
    mean = (net[:, :, before] + net[:, :, left] + net[:, J][:, :, right]) / 3.0
    assert net[:, :, spoke] == pytest.approx(mean, abs=1e-13)
    assert net[:, :, 14] == pytest.approx(np.repeat(net[:, :, 13].mean(axis=1)[:, None], 3, axis=1), abs=1e-13)


def test_neighbouring_sub_patches_share_their_spokes() -> None:
    net = nets(ShirmanSequin(alpha2=mixed(octahedron())).fit(octahedron()))
    assert np.array_equal(net[:, :, [10, 11, 12, 13, 14]], net[:, J][:, :, [0, 2, 5, 9, 14]])


def test_one_alpha_for_all_is_a_list_of_equal_ones_bit_for_bit() -> None:
    mesh = perturbed_icosahedron()
    one, each = ShirmanSequin(alpha2=1.9, jensen_c=1.1), ShirmanSequin(alpha2=(1.9,) * len(mesh.points), jensen_c=1.1)
    assert np.array_equal(nets(one.fit(mesh)), nets(each.fit(mesh)))


def test_the_alphas_follow_their_vertices() -> None:
    mesh = perturbed_icosahedron()
    alphas = np.array(mixed(mesh))
    order = np.random.default_rng(1).permutation(len(mesh.points))
    place = np.argsort(order)
    assert mesh.normals is not None
    renamed = HermiteMesh(mesh.points[order], place[mesh.faces], mesh.normals[order])
    one = ShirmanSequin(alpha2=tuple(alphas.tolist())).fit(mesh)
    other = ShirmanSequin(alpha2=tuple(alphas[order].tolist())).fit(renamed)
    assert nets(other) == pytest.approx(nets(one), abs=1e-14)


def test_moving_a_vertex_changes_its_own_faces_only() -> None:
    mesh = torus(8, 5, 3)
    assert mesh.normals is not None
    points = np.array(mesh.points)
    points[7] += [0.01, -0.02, 0.015]
    before, after = (
        nets(ShirmanSequin().fit(mesh)),
        nets(ShirmanSequin().fit(HermiteMesh(points, mesh.faces, mesh.normals))),
    )
    changed = (before != after).any(axis=(1, 2, 3))
    assert np.array_equal(changed, (mesh.faces == 7).any(axis=1))


def test_faces_may_stand_in_any_order_and_start_at_any_corner() -> None:
    mesh = perturbed_icosahedron()
    order = np.random.default_rng(2).permutation(len(mesh.faces))
    turned = HermiteMesh(mesh.points, np.roll(mesh.faces[order], 1, axis=1), mesh.normals)
    one, other = nets(ShirmanSequin().fit(mesh))[order], nets(ShirmanSequin().fit(turned))
    assert other == pytest.approx(np.roll(one, 1, axis=1), abs=1e-14)
    # the boundaries and their second rows do not even round differently
    outer = [0, 1, 2, 3, 4, 6, 7, 10, 11]
    assert np.array_equal(other[:, :, outer], np.roll(one, 1, axis=1)[:, :, outer])


@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100.0))
@settings(max_examples=20, deadline=None)
def test_the_surface_moves_turns_and_grows_with_its_data(seed: int, scale: float) -> None:
    mesh, rng = perturbed_icosahedron(), np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    shift = rng.normal(size=3)
    assert mesh.normals is not None
    moved = HermiteMesh(scale * mesh.points @ rotation.T + shift, mesh.faces, mesh.normals @ rotation.T)
    expected = scale * nets(ShirmanSequin().fit(mesh)) @ rotation.T + shift
    assert nets(ShirmanSequin().fit(moved)) == pytest.approx(expected, abs=1e-13 * (scale + 3.0))


def test_turning_the_mesh_inside_out_keeps_the_surface() -> None:
    mesh = perturbed_icosahedron()
    assert mesh.normals is not None
    inside_out = HermiteMesh(mesh.points, mesh.faces[:, [0, 2, 1]], -mesh.normals)
    one, other = ShirmanSequin().fit(mesh), ShirmanSequin().fit(inside_out)
    bary = np.tile([0.2, 0.5, 0.3], (len(mesh.faces), 1))
    faces = np.arange(len(mesh.faces))
    assert other.evaluate(faces, bary[:, [0, 2, 1]], 0).f == pytest.approx(one.evaluate(faces, bary, 0).f, abs=1e-14)


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="3 values of alpha2 and the mesh has 6 vertices"):
        ShirmanSequin(alpha2=(2.0, 2.0, 2.0)).fit(mesh)
    with pytest.raises(Refused, match="needs vertex normals"):
        ShirmanSequin().fit(HermiteMesh(mesh.points, mesh.faces))
    edge = unit(mesh.points[2] - mesh.points[0])
    normals = np.where(np.arange(6)[:, None] == 0, edge, mesh.points)
    with pytest.raises(Refused, match="vertex 0 to vertex 2"):
        ShirmanSequin().fit(HermiteMesh(mesh.points, mesh.faces, normals))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        ShirmanSequin().fit(torus(8, 5, 4))


@pytest.mark.parametrize("alpha2", [0.0, -1.0, float("nan"), float("inf"), (2.0, 0.0), (2.0, float("nan"))])
def test_an_alpha_that_is_not_positive_is_no_parameter(alpha2: Any) -> None:
    with pytest.raises(SpecError, match="alpha2 must be positive and finite"):
        ShirmanSequin(alpha2=alpha2)


@pytest.mark.parametrize("jensen_c", [float("nan"), float("inf")])
def test_a_jensen_c_that_is_not_finite_is_no_parameter(jensen_c: float) -> None:
    with pytest.raises(SpecError, match="jensen_c must be finite"):
        ShirmanSequin(jensen_c=jensen_c)


def test_the_notes_of_the_curves_are_passed_on() -> None:
    mesh = torus(10, 5, 3)
    network = Hermite().network(mesh)
    assert ShirmanSequin(Hermite()).fit(mesh).notes == network.notes
