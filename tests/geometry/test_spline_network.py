"""Generalised B-spline networks: the B-spline on regular grids, one tangent plane everywhere, what is refused."""

from functools import cache
from math import comb
from pathlib import Path

import numpy as np
import pytest
from control_meshes import antiprism, cuboctahedron, grid

import testbed_datasets
from testbed.errors import MeshError
from testbed.geometry.charted import triangle_fan
from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.jets import Jet
from testbed.geometry.network_charts import NetworkCharts, charted_network
from testbed.geometry.polygon_mesh import PolygonMesh, load_polygons
from testbed.geometry.simplex_bernstein import simplex_multi_indices, simplex_places
from testbed.geometry.spline_network import SplineNetwork, harmonic_weights, spline_network
from testbed.geometry.vectors import Float, Int, angle_between, norm

DATA = Path(next(iter(testbed_datasets.__path__)))
#: Interior edges between patches of each.
EDGES = {"branch": 44, "ring": 74, "octahedron": 12, "cuboctahedron": 24, "5": 20, "6": 24, "7": 28, "8": 32}
every_network = pytest.mark.parametrize("name", list(EDGES))


@cache
def network(name: str) -> SplineNetwork:
    if name in ("branch", "ring"):
        return spline_network(load_polygons(DATA / f"{name}.obj"))
    named = {"octahedron": antiprism(3), "cuboctahedron": cuboctahedron()}
    return spline_network(named[name] if name in named else antiprism(int(name)))


def inner_edges(name: str) -> tuple[Int, Int, Int]:
    """Patches on both sides of the edges between patches, and the corners of the mesh that these sides leave."""
    net = network(name)
    patch = np.full(len(net.mesh.faces), -1)
    patch[net.faces] = np.arange(len(net))
    corner = np.arange(len(net.mesh.face))
    twin = net.mesh.twin
    one = np.flatnonzero((twin > corner) & (patch[net.mesh.face] >= 0))
    one = one[patch[net.mesh.face[twin[one]]] >= 0]
    return patch[net.mesh.face[one]], patch[net.mesh.face[twin[one]]], one


def side_jets(name: str, patch: Int, corner: Int, t: Float, order: int = 2) -> Jet:
    """Jets (rows, E, S, 3) along sides that leave corners, in the direction of the side."""
    net = network(name)
    charts = NetworkCharts(net)
    side = corner - net.mesh.first_corner[net.mesh.face[corner]]
    at = []
    for one, s in zip(patch.tolist(), side.tolist(), strict=True):
        polygon = charts.polygon(one)
        at.append((1.0 - t)[:, None] * polygon[s] + t[:, None] * polygon[(s + 1) % len(polygon)])
    flat = charts.jets(np.repeat(patch, len(t)), np.concatenate(at), order).coefficients
    return Jet(flat.reshape(len(flat), len(patch), len(t), 3))


@every_network
def test_neighbours_meet_with_one_tangent_plane(name: str) -> None:
    t = np.linspace(0.0, 1.0, 25)
    one, other, corner = inner_edges(name)
    assert len(one) == EDGES[name]
    left = side_jets(name, one, corner, t, 1)
    right = side_jets(name, other, network(name).mesh.twin[corner], 1.0 - t, 1)
    assert norm(left.f - right.f).max() < 1e-13
    assert np.degrees(angle_between(left.normal, right.normal).max()) < 1e-10


@every_network
def test_normals_point_outward(name: str) -> None:
    # seen from a point of the control mesh's face beside: its corners run counterclockwise about the normal
    net = network(name)
    centres = np.zeros((len(net), 2))
    normal = NetworkCharts(net).jets(np.arange(len(net)), centres, 1).normal
    for patch, face in enumerate(net.faces):
        corners = net.mesh.points[list(net.mesh.faces[face])]
        area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        assert normal[patch] @ area > 0.8 * np.linalg.norm(area)


@pytest.mark.parametrize("name", ["branch", "ring"])
def test_second_forms_agree_at_vertices_of_quadrilaterals_and_nearly_at_others(name: str) -> None:
    net = network(name)
    mesh = charted_network(net)
    ids, chart = mesh.faces.ravel(), np.repeat(mesh.chart, 3)
    W = second_form_matrix(mesh.jets()).reshape(-1, 3, 3)
    scale = np.abs(W).max()
    regular, others = 0.0, 0.0
    for vertex in range(int(mesh.faces[:, :2].max()) + 1):
        at = ids == vertex
        spread = float(np.ptp(W[at], axis=0).max())
        if (net.sides[chart[at]] == 4).all():
            regular = max(regular, spread)
        else:
            others = max(others, spread)
    assert regular < 1e-13 * scale
    assert 0.01 * scale < others < 0.2 * scale


def test_a_regular_grid_gives_the_uniform_b_spline() -> None:
    # the patch between p_ij is sum B_k(u) B_l(v) p_{i+k,j+l}, with the uniform cubic B-splines
    net = spline_network(grid(5, 4))
    assert len(net) == 3 * 2
    part = net.parts[0]
    assert (part.sides, part.depth) == (4, 3)
    s = np.linspace(0.0, 1.0, 6)
    spline = np.stack([(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]) / 6.0
    u, v = (index.ravel() for index in np.meshgrid(s, s, indexing="ij"))
    at = (
        part.corners[0]
        + u[:, None] * (part.corners[1] - part.corners[0])
        + v[:, None] * (part.corners[3] - part.corners[0])
    )
    patches = part.jets(at, 0).f.reshape(-1, len(s), len(s), 3)
    points = net.mesh.points.reshape(6, 5, 3)
    for patch, (i, j) in enumerate((i, j) for i in range(3) for j in range(2)):
        exact = np.einsum("ku,lv,klx->uvx", spline, spline, points[i : i + 4, j : j + 4])
        assert np.abs(patches[patch] - exact).max() < 1e-15 * 10


def test_the_counts_are_the_published_ones() -> None:
    counts = {name: [(p.sides, p.depth, len(p)) for p in network(name).parts] for name in ("branch", "ring")}
    assert counts == {"branch": [(4, 3, 20), (5, 6, 4)], "ring": [(3, 6, 4), (4, 3, 31), (6, 6, 2)]}


@every_network
def test_boundaries_are_cubics_and_panels_affine(name: str) -> None:
    # the control points (5 - j) e_i + j e_{i+1} + e_k are an affine image of the polygon
    for part in network(name).parts:
        if part.sides == 4:
            continue
        unit, corners = np.eye(part.sides, dtype=np.int64), part.corners
        for i in range(part.sides):
            following = unit[(i + 1) % part.sides]
            places = simplex_places(np.array([(6 - j) * unit[i] + j * following for j in range(7)]))
            differences = part.control_points[:, places]
            for _ in range(4):
                differences = np.diff(differences, axis=1)
            assert np.abs(differences).max() < 1e-13
            for j in range(6):
                panel = part.control_points[:, simplex_places((5 - j) * unit[i] + j * following + unit)]
                frame = np.column_stack([corners, np.ones(part.sides)])
                fitted = frame @ (np.linalg.pinv(frame) @ panel)
                assert np.abs(panel - fitted).max() < 2e-14


def test_labels_without_neighbours_are_means_of_those_beside_them() -> None:
    # the two of a hexagon each of their six neighbours, none of which is unknown
    unknown, weights = harmonic_weights(6)
    labels = simplex_multi_indices(6, 3)
    assert labels[unknown].tolist() == [[1, 0, 1, 0, 1, 0], [0, 1, 0, 1, 0, 1]]
    assert np.sort(weights, axis=1)[:, -6:] == pytest.approx(1.0 / 6.0)
    assert np.count_nonzero(weights, axis=1).tolist() == [6, 6]
    for sides in (3, 4, 5):
        assert len(harmonic_weights(sides)[0]) == 0
    # of n corners, three no two of which are neighbours
    for sides in (7, 8, 12):
        places, weights = harmonic_weights(sides)
        assert len(places) == sides * comb(sides - 4, 2) // 3
        assert weights.sum(axis=1) == pytest.approx(1.0)
        assert weights.min() >= 0.0


def test_moved_and_scaled_control_meshes_give_moved_and_scaled_patches() -> None:
    mesh, net = cuboctahedron(), network("cuboctahedron")
    moved = spline_network(PolygonMesh(2.0 * mesh.points + [1.0, 2.0, 3.0], mesh.faces))
    for part, image in zip(net.parts, moved.parts, strict=True):
        assert np.abs(image.control_points - 2.0 * part.control_points - [1.0, 2.0, 3.0]).max() < 1e-14


def test_faces_may_start_at_another_corner() -> None:
    mesh, net = antiprism(5), network("5")
    turned = spline_network(PolygonMesh(mesh.points, [face[2:] + face[:2] for face in mesh.faces]))
    charts, others = NetworkCharts(net), NetworkCharts(turned)
    pentagons = net.parts.index(next(part for part in net.parts if part.sides == 5))
    (patch,) = np.nonzero(net.part == pentagons)
    at = 0.3 * charts.polygon(int(patch[0]))
    one = charts.jets(np.repeat(patch[:1], 5), np.roll(at, -2, axis=0), 0).f
    assert np.abs(others.jets(np.repeat(patch[:1], 5), at, 0).f - one).max() < 1e-15


def test_control_meshes_that_carry_no_network_are_refused() -> None:
    cube = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    cases = [
        (PolygonMesh(cube, faces), "3 edges meet at vertex 0"),
        (grid(2, 2), "no patch is left: add a ring of faces"),
        (antiprism(13), "has 13 corners"),
    ]
    for mesh, text in cases:
        with pytest.raises(MeshError, match=text) as caught:
            spline_network(mesh)
        assert "\n" not in str(caught.value)


@every_network
def test_charted_triangles_cover_the_patches_once(name: str) -> None:
    net = network(name)
    mesh = charted_network(net)
    assert len(mesh.faces) == np.where(net.sides == 3, 1, net.sides).sum()
    assert np.array_equal(np.bincount(mesh.chart), np.where(net.sides == 3, 1, net.sides))
    for chart in range(len(net)):
        polygon = mesh.charts.polygon(chart)
        expected = polygon[None] if len(polygon) == 3 else triangle_fan(polygon)[0]
        assert np.array_equal(mesh.at[mesh.chart == chart], expected)
    # followed sides: those of the patches, each of which is there
    assert mesh.followed.sum() == net.sides.sum()
    assert np.array_equal(np.unique(mesh.faces), np.arange(mesh.vertices))


@every_network
def test_charted_meshes_follow_the_edges_of_patches(name: str) -> None:
    for level in (0, 1):
        mesh = charted_network(network(name)).halved(level).sampled()
        tangents = mesh.face_data.side_tangents
        assert tangents is not None
        assert mesh.boundary_edges.any() == (name == "branch")
        # both charts at an edge have the same curve: its tangents, and its normal curvature, agree
        edge_ends: dict[tuple[int, int], Float] = {}
        count = 0
        for face, side in np.argwhere(~np.isnan(tangents).any(axis=(2, 3))).tolist():
            i, j = int(mesh.faces[face, side]), int(mesh.faces[face, (side + 1) % 3])
            edge_ends[i, j] = tangents[face, side]
            if (j, i) in edge_ends:
                count += 1
                assert np.abs(edge_ends[j, i][::-1] + tangents[face, side]).max() < 1e-12
        assert count == EDGES[name] * 2**level


@pytest.mark.parametrize("name", ["branch", "ring"])
def test_normal_curvature_along_shared_edges_agrees(name: str) -> None:
    mesh = charted_network(network(name)).halved(1).sampled()
    tangents, forms = mesh.face_data.side_tangents, mesh.face_data.corner_second_forms
    assert tangents is not None
    assert forms is not None
    curvature: dict[tuple[int, int], Float] = {}
    worst = 0.0
    for face, side in np.argwhere(~np.isnan(tangents).any(axis=(2, 3))).tolist():
        ends = [side, (side + 1) % 3]
        t, W = tangents[face, side], forms[face, ends]
        k = np.einsum("ei,eij,ej->e", t, W, t)
        i, j = mesh.faces[face, ends].tolist()
        curvature[i, j] = k
        if (j, i) in curvature:
            worst = max(worst, float(np.abs(curvature[j, i][::-1] - k).max()))
    assert worst < 1e-11 * np.abs(forms).max()


def test_charts_are_equal_by_their_control_meshes() -> None:
    one, other = (NetworkCharts(spline_network(antiprism(5))) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    assert one != NetworkCharts(network("6"))
    assert one != "charts"


def test_no_bit_depends_on_what_charts_are_evaluated_together() -> None:
    charts = NetworkCharts(network("ring"))
    random = np.random.default_rng(1)
    chart, at = random.integers(len(charts), size=300), random.uniform(-0.3, 0.3, (300, 2))
    jets = charts.jets(chart, at).coefficients
    some = random.permutation(300)[:17]
    assert np.array_equal(charts.jets(chart[some], at[some]).coefficients, jets[:, some])
    assert charts.jets(chart[:0], at[:0], 1).coefficients.shape == (3, 0, 3)
