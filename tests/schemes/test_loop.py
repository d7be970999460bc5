"""Interpolating Loop surfaces: the limit of subdivision step by step, through the data, with tangent planes."""

import numpy as np
import pytest
from spoked_meshes import lattice, spokes

from testbed import registry
from testbed.errors import Refused
from testbed.geometry import curvature
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import CORNERS, barycentric
from testbed.geometry.loop_subdivision import (
    interpolating_vertices,
    limit_points,
    subdivided,
    weights,
)
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Part, Surface
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Float, angle_between, norm
from testbed_schemes.loop import Loop
from testbed_schemes.mathematics.box_spline import bezier_nets, patch_vertices, reflected
from testbed_schemes.mathematics.loop_corners import CornerKind, LoopCorners, functions
from testbed_schemes.mathematics.triangle_subdivision import refined_places, triangulation

MESHES = {
    **{name: registry.dataset(name).mesh(0) for name in ("octahedron", "icosahedron", "torus", "graph")},
    **{f"valence {count}": spokes(count, closed=True) for count in (3, 7, 8, 12)},
    **{f"{count} faces on the boundary": spokes(count, closed=False) for count in (2, 3, 4, 5)},
}
KINDS = [CornerKind(count) for count in (3, 4, 5, 7, 12)] + [
    CornerKind(count, place) for count in (2, 4, 5) for place in range(count)
]


def hub(surface: Surface) -> Part:
    """The patches at vertex 0, from there."""
    at_hub = [part for part in surface.parts if (part.corner_ids[:, 0] == 0).any()]
    part = at_hub[0]
    rows = np.flatnonzero(part.corner_ids[:, 0] == 0)
    return Part(part.batch.take(rows), part.corner_ids[rows], part.faces[rows], part.corners_in_face[rows])


@pytest.mark.parametrize("name", MESHES)
def test_the_surface_is_the_limit_of_subdivision_step_by_step(name: str) -> None:
    mesh = MESHES[name]
    faces = triangulation(mesh)
    points, places = interpolating_vertices(faces, mesh.points), np.broadcast_to(CORNERS[3], (len(mesh.faces), 3, 2))
    for _ in range(4):
        points, faces, places = subdivided(faces, points), faces.refined(), refined_places(places)
    origin = np.repeat(np.arange(len(mesh.faces)), 4**4)
    found = Loop().fit(mesh).evaluate(origin, barycentric(places[:, 0]), 0).f
    assert norm(found - limit_points(faces, points)[faces.faces[:, 0]]).max() < 4e-15 * np.abs(points).max()


@pytest.mark.parametrize("name", MESHES)
def test_it_passes_through_the_points_and_has_one_tangent_plane_along_every_edge(name: str) -> None:
    mesh = MESHES[name]
    surface = Loop().fit(mesh)
    for part in surface.parts:
        patch, corner = np.nonzero(part.corner_ids < len(mesh.points))
        found = part.batch.jets(CORNERS[3], 0).f[patch, corner]
        assert norm(found - mesh.points[part.corner_ids[patch, corner]]).max(initial=0.0) < 1e-14
    t = np.concatenate([[0.0, 1e-4, 1e-3], np.arange(1, 8) / 8, [1.0 - 1e-3, 1.0]])
    one, other = surface.edge_jets(surface.edges[surface.edges.interior], t, 1)
    assert norm(one.f - other.f).max() < 1e-14
    assert np.degrees(angle_between(one.normal, other.normal)).max() < 1e-9


def test_regular_patches_join_with_their_second_derivatives() -> None:
    surface = Loop().fit(registry.dataset("torus").mesh(0))
    assert len(surface.parts) == 1  # valence 6 everywhere
    one, other = surface.edge_jets(surface.edges, np.array([0.1, 0.5, 0.9]))
    jump = curvature.second_form_matrix(one) - curvature.second_form_matrix(other)
    assert np.abs(jump).max() < 1e-10


@pytest.mark.parametrize("count", [3, 4, 5, 7, 12])
def test_normals_tend_to_the_one_at_an_irregular_vertex_inside(count: int) -> None:
    batch = hub(Loop().fit(spokes(count, closed=True))).batch
    turns = turns_near_corner(batch)
    assert turns[0] > turns[1]
    assert turns[2] < 0.05


def turns_near_corner(batch: PatchBatch) -> list[float]:
    """Angles in degrees between the normal at corner 0 and normals nearer and nearer to it."""
    corner = batch.jets(np.zeros((1, 2)), 1).normal
    places = (2.0**-depth * np.array([[0.3, 0.5], [0.7, 0.1]]) for depth in (5, 15, 40))
    return [float(np.degrees(angle_between(batch.jets(at, 1).normal, corner)).max()) for at in places]


@pytest.mark.parametrize("count", [2, 4, 5])
def test_normals_tend_to_the_one_at_an_irregular_vertex_of_the_boundary(count: int) -> None:
    surface = Loop().fit(spokes(count, closed=False))
    at_hub = [part for part in surface.parts if (part.corner_ids[:, 0] == 0).any()]
    assert len(at_hub) == count
    for part in at_hub:
        turns = turns_near_corner(part.batch.take(np.flatnonzero(part.corner_ids[:, 0] == 0)))
        assert turns[0] > turns[1]
        assert turns[2] < 0.05


@pytest.mark.parametrize(("count", "grows"), [(3, True), (4, False), (5, False), (7, True), (12, True)])
def test_the_curvature_is_unbounded_at_some_valences(count: int, grows: bool) -> None:
    batch = hub(Loop().fit(spokes(count, closed=True))).batch
    far, near = (np.abs(curvature.gauss(batch.jets(2.0**-depth * np.array([[0.3, 0.5]])))).max() for depth in (5, 20))
    assert (near > 10.0 * far) == grows


def test_the_control_vertices_of_the_octahedron() -> None:
    # by hand: 3 / (8 beta) = 96 / 31 at valence 4; a vertex at r has the limit (96 / 31) r / (96 / 31 + 4) = 1
    mesh = registry.dataset("octahedron").mesh(0)
    control = interpolating_vertices(triangulation(mesh), mesh.points)
    assert norm(control) == pytest.approx(1.0 + 4.0 * 31.0 / 96.0, rel=1e-14)


@pytest.mark.parametrize("count", [*range(3, 30), 100, 1000])
def test_the_system_is_positive_definite_at_every_valence(count: int) -> None:
    assert 0.375 / weights(np.array(count)) > 0.5 * count


@pytest.mark.parametrize("name", MESHES)
def test_the_system_is_solved_and_well_conditioned(name: str) -> None:
    mesh = MESHES[name]
    faces = triangulation(mesh)
    control = interpolating_vertices(faces, mesh.points)
    assert norm(limit_points(faces, control) - mesh.points).max() < 1e-14
    inside = np.flatnonzero(~faces.on_boundary)
    if len(inside):
        matrix = np.stack([_limit_of_unit(faces, vertex)[inside] for vertex in inside.tolist()], axis=1)
        assert np.linalg.cond(matrix) < 30.0


def _limit_of_unit(faces: Triangulation, vertex: int) -> Float:
    points = np.zeros((faces.vertices, 3))
    points[vertex, 0] = 1.0
    return limit_points(faces, points)[:, 0]


def test_flat_data_stay_flat() -> None:
    mesh = spokes(5, closed=True)
    flat = HermiteMesh(mesh.points * [1.0, 1.0, 0.0] + [0.0, 0.0, 2.0], mesh.faces)
    for part in Loop().fit(flat).parts:
        assert np.abs(part.batch.jets(np.array([[0.3, 0.2], [0.1, 0.8]]), 0).f[..., 2] - 2.0).max() < 1e-14


def test_one_face_is_itself() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.2, 1.0, 0.1]])
    surface = Loop().fit(HermiteMesh(points, [[0, 1, 2]]))
    bary = np.array([[0.2, 0.3, 0.5], [0.7, 0.2, 0.1]])
    assert norm(surface.evaluate(np.zeros(2, dtype=np.int64), bary, 0).f - bary @ points).max() < 1e-15


def test_crowded_boundaries_and_faces_back_to_back_are_refused() -> None:
    with pytest.raises(Refused, match="at most 5 faces at a vertex of the boundary, and 6 meet at vertex 0"):
        Loop().fit(spokes(6, closed=False))
    with pytest.raises(Refused, match="at most 1000 faces at a vertex inside, and 1001 meet at vertex 0"):
        Loop().fit(spokes(1001, closed=True, rings=1))
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    with pytest.raises(Refused, match="two faces lie back to back"):
        Loop().fit(HermiteMesh(points, [[0, 1, 2], [0, 2, 1]]))


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_limit_and_tangents_are_left_eigenvectors(kind: CornerKind) -> None:
    faces, patch = kind.neighbourhood()
    count = faces.vertices
    matrix = subdivided(faces, np.eye(count))[kind.vertices(faces.refined(), np.array([12 * patch]))[0]]
    assert kind.vertices(faces, np.array([3 * patch]))[0].tolist() == list(range(count))
    assert np.allclose(kind.limit(count) @ matrix, kind.limit(count), atol=1e-15)
    assert kind.limit(count).sum() == pytest.approx(1.0, abs=1e-15)
    tangents = kind.tangents(count)
    assert np.abs(tangents.sum(axis=1)).max() < 1e-14
    once = tangents @ matrix
    if kind.inside:
        assert np.abs(once - kind.eigenvalue * tangents).max() < 1e-15
    else:  # sums of one eigenvector along the boundary, of 1/2, and one across
        twice = once @ matrix
        assert np.abs(twice - (0.5 + kind.across) * once + 0.5 * kind.across * tangents).max() < 1e-15
    size = np.sort(np.abs(np.linalg.eigvals(matrix)))[::-1]
    assert size[0] == pytest.approx(1.0, abs=1e-12)
    assert size[1] == pytest.approx(kind.eigenvalue, abs=1e-7)
    assert size[2] == pytest.approx(kind.eigenvalue if kind.inside else min(0.5, kind.across), abs=1e-7)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_the_functions_sum_to_one_and_are_continuous_between_pieces(kind: CornerKind) -> None:
    at = np.array([[0.3, 0.2], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.25, 0.25], [1e-9, 2e-9], [0.0, 0.0]])
    jets = functions(kind, at, 2)
    assert np.allclose(jets[0].sum(axis=-1), 1.0, atol=1e-13)
    assert np.abs(jets[1:3].sum(axis=-1)).max() < 1e-11
    step = 2.0**-40
    for border in ([0.5, 0.2], [0.2, 0.5], [0.3, 0.2], [0.125, 0.125], [0.25, 0.1]):
        here, there = functions(kind, np.array([border, np.add(border, step)]), 2).transpose(1, 0, 2)
        assert np.abs(here[0] - there[0]).max() < 1e-10
        assert np.abs(here[1:3] - there[1:3]).max() < 1e-9
        assert np.abs(here[3:] - there[3:]).max() < 1e-7


def test_a_regular_corner_evaluated_as_irregular_is_the_box_spline() -> None:
    places, triangles = lattice(6, 6)
    faces = Triangulation(triangles, len(places))
    points = np.random.default_rng(4).normal(size=(len(places), 3))
    half_edge = np.flatnonzero(~faces.on_boundary[faces.faces].any(axis=1))[[7]] * 3
    kind = CornerKind(6)
    assert np.array_equal(kind.vertices(faces, half_edge), patch_vertices(faces, half_edge))
    control = points[patch_vertices(faces, half_edge)]
    at = np.array([[0.3, 0.2], [0.01, 0.02], [0.6, 0.4], [1e-6, 3e-6]])
    stam = LoopCorners(kind, control).jets(at).coefficients
    bezier = BezierTriangles(bezier_nets(control)).jets(at).coefficients
    assert np.abs(stam - bezier).max() < 1e-9


def test_bezier_points_from_the_box_spline_are_those_of_subdivision() -> None:
    places, triangles = lattice(8, 8)
    faces, points = Triangulation(triangles, len(places)), np.random.default_rng(5).normal(size=(len(places), 3))
    (face,) = np.flatnonzero(~faces.on_boundary[faces.faces].any(axis=1))[[20]]
    net = bezier_nets(points[patch_vertices(faces, np.array([3 * face]))])
    corners = np.broadcast_to(CORNERS[3], (len(triangles), 3, 2))
    for _ in range(2):
        points, faces, corners = subdivided(faces, points), faces.refined(), refined_places(corners)
    pieces = slice(16 * face, 16 * face + 16)
    found = BezierTriangles(net).jets(corners[pieces, 0], 0).f[0]
    assert norm(found - limit_points(faces, points)[faces.faces[pieces, 0]]).max() < 1e-14


@pytest.mark.parametrize("name", ["graph", "3 faces on the boundary"])
def test_reflections_stay_reflections(name: str) -> None:
    faces = triangulation(MESHES[name])
    points = np.random.default_rng(6).normal(size=(faces.vertices, 3))
    whole, extended = reflected(faces, points)
    regular = np.flatnonzero(faces.on_boundary & np.isin(faces.face_count, (1, 3)))
    assert (whole.face_count[regular] == 6).all()
    # a step of the extended mesh moves and divides the boundary as its own rules do
    moved, expected = subdivided(whole, extended), subdivided(faces, points)
    assert norm(moved[regular] - expected[regular]).max() < 1e-14
    (boundary,) = np.nonzero(faces.twin < 0)
    edge = faces.edge[boundary]
    assert norm(moved[whole.vertices + whole.edge[boundary]] - expected[faces.vertices + edge]).max() < 1e-14


def test_a_patch_has_the_same_bits_alone_and_among_others() -> None:
    surface = Loop().fit(spokes(7, closed=True))
    batch = hub(surface).batch
    at = np.random.default_rng(8).dirichlet(np.ones(3), (len(batch), 5))[..., 1:]
    every = batch.jets(at).coefficients
    alone = np.concatenate([batch.take(np.array([i])).jets(at[[i]]).coefficients for i in range(len(batch))], axis=1)
    assert np.array_equal(every, alone)
    shared = batch.jets(at[0]).coefficients
    assert np.allclose(shared[:, 0], every[:, 0], atol=1e-12)
