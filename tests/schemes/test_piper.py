"""Piper: G1 with quartic edges that know both faces, moved no further than needed from split cubics."""

import numpy as np
import pytest

from testbed.conformance.meshes import GENERIC, cases, fan, graph, octahedron, perturbed_icosahedron, torus
from testbed.errors import Refused
from testbed.geometry.bernstein import elevate_curve, elevate_triangle, subdivide_triangle
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.curvature import gauss
from testbed.geometry.domain import CORNERS, lattice
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.nets import CENTRE, boundary_net
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, angle_between, norm
from testbed.plugins.boundary import BoundaryCurve
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.boundary_curves.planar import Planar
from testbed_schemes.boundary_curves.projected import Projected
from testbed_schemes.continuity_conditions.piper import end_values, nearest_join
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre
from testbed_schemes.mathematics.split_domain import c1_ring
from testbed_schemes.piper import Piper

ZOO = {case.name: case.mesh for case in cases(3)}
T = np.array([0.0, 1e-3, *np.linspace(0.05, 0.95, 13), 1 - 1e-3, 1.0])
#: Places in a quartic sub-patch: the edge, C_ij and C_ik, N_i, the second row as a whole.
EDGE, CROSS, INNER, ROW = [0, 1, 3, 6, 10], [4, 7], 8, [2, 4, 7, 11]


def nets(surface: Surface) -> Float:
    """Control points of the quartics, (F, 3, 15, 3)."""
    batch = surface.batches[0]
    assert isinstance(batch, BezierTriangles)
    assert batch.degree == 4
    return batch.control_points.reshape(-1, 3, 15, 3)


def largest_jump(surface: Surface) -> float:
    """Largest angle between normals across edges, inner ones included, in degrees."""
    left, right = surface.edge_jets(surface.edges[surface.edges.interior], T, order=1)
    return float(np.degrees(angle_between(left.normal, right.normal)).max())


def candidate(mesh: HermiteMesh, boundary: BoundaryCurve) -> Float:
    """The cubics of quadratic precision, cut and raised by the general algorithms, (F, 3, 15, 3)."""
    net = boundary_net(boundary.network(mesh))
    net[:, CENTRE] = quadratic_precision_centre(net)
    return elevate_triangle(subdivide_triangle(net))


def edges_of(mesh: HermiteMesh, net: Float) -> tuple[Float, Float, Float]:
    """Boundary and both second rows on all inner edges of the mesh, from the patches on their two sides."""
    edges = Surface.over_split_faces(mesh, BezierTriangles(net.reshape(-1, 15, 3))).edges
    edges = edges[edges.interior & ~edges.within_face]
    left, right = (net.reshape(-1, 15, 3)[side.patch] for side in (edges.left, edges.right))
    assert left[:, EDGE] == pytest.approx(right[:, EDGE[::-1]], abs=1e-15 * (1.0 + np.abs(mesh.points).max()))
    return left[:, EDGE], left[:, ROW], right[:, ROW[::-1]]


@pytest.mark.parametrize("boundary", [Piper().boundary, Planar(), Hermite()], ids=str)
@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_normals_agree_across_mesh_edges_and_inner_edges(mesh: HermiteMesh, boundary: BoundaryCurve) -> None:
    assert largest_jump(Piper(boundary).fit(mesh)) < 1e-8


@pytest.mark.parametrize("mesh", ZOO.values(), ids=ZOO.keys())
def test_corners_have_the_points_and_normals_of_the_data(mesh: HermiteMesh) -> None:
    part = Piper().fit(mesh).parts[0]
    jet = part.batch.jets(CORNERS[3][:2], order=1)
    ids = part.corner_ids[:, :2]
    assert mesh.normals is not None
    assert np.array_equal(jet.f, mesh.points[ids])
    assert angle_between(jet.normal, mesh.normals[ids]).max() < 1e-12


@pytest.mark.parametrize("boundary", [Projected(), Hermite()], ids=str)
@pytest.mark.parametrize("name", ["octahedron", "coarse torus", "needle faces"])
def test_each_edge_is_the_join_nearest_to_the_split_cubics(name: str, boundary: BoundaryCurve) -> None:
    mesh = ZOO[name]
    expected = nearest_join(*edges_of(mesh, candidate(mesh, boundary)))[:3]
    found = edges_of(mesh, nets(Piper(boundary).fit(mesh)))
    for ours, nearest in zip(found, expected, strict=True):
        assert ours == pytest.approx(nearest, abs=1e-12)


def test_the_inner_points_are_those_of_the_candidate_and_the_spokes_are_c1() -> None:
    mesh = perturbed_icosahedron()
    net = nets(Piper().fit(mesh))
    assert net[:, :, INNER] == pytest.approx(candidate(mesh, Projected())[:, :, INNER], abs=1e-14)
    ring = c1_ring(net[:, :, EDGE], (net[:, :, CROSS[0]], net[:, :, CROSS[1]]), net[:, :, INNER])
    assert ring.nets() == pytest.approx(net, abs=1e-15)


def test_neighbours_share_their_quartic_edges_bit_for_bit() -> None:
    mesh = torus(8, 5, 3)
    surface = Piper().fit(mesh)
    edges = surface.edges[surface.edges.interior & ~surface.edges.within_face]
    net = nets(surface).reshape(-1, 15, 3)
    left, right = net[edges.left.patch][:, EDGE], net[edges.right.patch][:, EDGE[::-1]]
    assert np.array_equal(left, right)
    # and these are no cubics any more
    assert np.abs(np.diff(left, 4, axis=1)).max() > 0.01


def test_edges_on_the_boundary_of_the_mesh_keep_the_candidate() -> None:
    mesh = ZOO["open mesh with a vertex of valence 12"]
    net = nets(Piper().fit(mesh))
    outer = np.roll(mesh.boundary_edges[mesh.face_edges], -1, axis=1)
    curves = elevate_curve(Projected().network(mesh).opposite_vertices())
    assert np.array_equal(net[outer][:, EDGE], curves[outer])
    assert net[outer][:, ROW] == pytest.approx(candidate(mesh, Projected())[outer][:, ROW], abs=1e-14)
    alone = ZOO["one face"]
    assert nets(Piper().fit(alone)) == pytest.approx(candidate(alone, Projected()), abs=1e-14)


def test_a_vertex_reaches_the_faces_beside_its_own_and_no_further() -> None:
    mesh = torus(8, 5, 3)
    points = np.array(mesh.points)
    points[7] += [0.01, -0.02, 0.015]
    before, after = (nets(Piper().fit(HermiteMesh(p, mesh.faces, mesh.normals))) for p in (mesh.points, points))
    changed = (before != after).any(axis=(1, 2, 3))
    own = (mesh.faces == 7).any(axis=1)
    pairs = mesh.edge_faces
    beside = np.unique(pairs[own[pairs].any(axis=1)])
    assert np.array_equal(np.flatnonzero(changed), beside)
    assert own.sum() < len(beside)


def test_turning_the_mesh_inside_out_or_renaming_its_vertices_keeps_the_surface() -> None:
    mesh = perturbed_icosahedron()
    one = Piper().fit(mesh)
    bary, faces = np.tile([0.2, 0.5, 0.3], (len(mesh.faces), 1)), np.arange(len(mesh.faces))
    expected = one.evaluate(faces, bary, 0).f
    assert Piper().fit(mesh.flipped()).evaluate(faces, bary[:, ::-1], 0).f == pytest.approx(expected, abs=1e-14)
    renamed = mesh.relabelled(np.random.default_rng(1).permutation(len(mesh.points)))
    assert Piper().fit(renamed).evaluate(faces, bary, 0).f == pytest.approx(expected, abs=1e-14)


def printed_ratio(mesh: HermiteMesh) -> float:
    """Least ratio of the singular values of the printed 3 x 5 system, over all edges."""
    e, f, g, h = (np.moveaxis(values, -1, 0) for values in end_values(*edges_of(mesh, candidate(mesh, Projected()))))
    none = np.zeros_like(e[0])
    rows = [
        [3 * e[0], 3 * g[0], none, 3 * h[0], none],
        [2 * (f[0] + e[1]), 2 * g[1], 2 * g[0], 2 * h[1], 2 * h[0]],
        [3 * f[1], none, 3 * g[1], none, 3 * h[1]],
    ]
    size = np.linalg.svd(np.moveaxis(np.array(rows), -1, 0), compute_uv=False)
    return float((size[:, 2] / size[:, 0]).min())


def test_fine_meshes_come_near_the_special_case_and_stay_smooth() -> None:
    """Flat data have constant e, f, g, h: the printed equations lose their rank as a surface flattens, ours do not."""
    assert printed_ratio(octahedron()) == pytest.approx(0.165, abs=5e-4)
    assert printed_ratio(torus(10, 5, 3)) == pytest.approx(0.0132, abs=5e-5)
    for height in (1e-1, 1e-2, 1e-3):
        mesh = graph(*fan(), height * GENERIC)
        assert printed_ratio(mesh) < 2e-4 * height**2
        surface = Piper().fit(mesh)
        assert largest_jump(surface) < 1e-11
        # the edges move in proportion to the height
        moved = norm(nets(surface)[:, :, 3] - candidate(mesh, Projected())[:, :, 3]).max()
        assert 1.9e-4 * height < moved < 2.1e-4 * height
        assert surface.notes == {}


def test_constant_factors_are_counted() -> None:
    mesh = ZOO["flat mesh"]
    assert Piper().fit(mesh).notes == {"edges with constant factors": int((~mesh.boundary_edges).sum())}
    assert Piper().fit(octahedron()).notes == {}


def test_the_notes_of_the_curves_are_passed_on() -> None:
    mesh = torus(10, 5, 3)
    assert Piper(Hermite()).fit(mesh).notes == Hermite().network(mesh).notes


def test_the_curvature_on_the_octahedron() -> None:
    """Ours; the thesis gives no number of this scheme. The least, slightly hyperbolic, is on the edges."""
    curvature = gauss(Piper().fit(octahedron()).batches[0].take(np.arange(3)).jets(lattice(3, 24)))
    assert (curvature.min(), curvature.max()) == pytest.approx((-0.0216, 3.4271), abs=1e-3)


def test_data_it_cannot_take_are_refused_with_a_sentence() -> None:
    mesh = octahedron()
    with pytest.raises(Refused, match="needs vertex normals"):
        Piper().fit(HermiteMesh(mesh.points, mesh.faces))
    with pytest.raises(Refused, match="takes meshes of triangles"):
        Piper().fit(torus(8, 5, 4))
    folded = mesh.points * np.where(np.arange(6) == 2, -1.0, 1.0)[:, None]
    with pytest.raises(Refused, match="folds over"):
        Piper().fit(HermiteMesh(mesh.points, mesh.faces, folded))
