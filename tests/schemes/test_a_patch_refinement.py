"""Wedge test and local refinement of A-patch meshes: what crosses, what refinement keeps, what it parts or refuses."""

import numpy as np
import pytest
from hostile_meshes import mesh_data
from hypothesis import given, settings
from hypothesis import strategies as st
from spoked_meshes import lattice

from testbed import registry
from testbed.errors import MeshError, Refused
from testbed.geometry.domain import CORNERS, barycentric
from testbed.geometry.loop_normals import loop_limit_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Bool, Float, Int, cross, norm, unit
from testbed_schemes.butterfly import Butterfly
from testbed_schemes.mathematics.a_patch_refinement import (
    RefinedMesh,
    crossing_edges,
    divided_faces,
    edge_place,
    separated_hull,
    split_edges,
    wedge_angles,
)
from testbed_schemes.mathematics.a_patch_sides import hull


def apexes(mesh: HermiteMesh) -> Float:
    return hull(mesh, 0.05, 1e-12).apexes


def with_gradients(mesh: HermiteMesh, *, loop: bool = False) -> HermiteMesh:
    loop = loop or mesh.normals is None
    vectors = loop_limit_normals(mesh.points, mesh.faces) if loop else mesh.normals
    return HermiteMesh(mesh.points, mesh.faces, gradients=vectors)


def star(name: str, height: float) -> HermiteMesh:
    """A solid with a pyramid on each face."""
    mesh = registry.dataset(name).mesh(0)
    tip = len(mesh.points) + np.arange(len(mesh.faces))
    a, b, c = mesh.faces.T
    faces = np.concatenate([np.stack([x, y, tip], axis=-1) for x, y in ((a, b), (b, c), (c, a))])
    return HermiteMesh(np.concatenate([mesh.points, height * unit(mesh.corner_points().mean(axis=1))]), faces)


def hinge(turn: float) -> HermiteMesh:
    """Two faces at the edge of vertices 0 and 1; vertex 3 is turned from vertex 2 through their outer side."""
    points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.7, 1.0, 0.0], [1.1, np.cos(turn), np.sin(turn)]]
    return HermiteMesh(points, [[0, 1, 2], [1, 0, 3]])


def at_angles(above: list[float], below: list[float]) -> Float:
    """Apexes (2, 2, 3) at angles about the edge, over places of their own along it."""
    angle = np.array([above, below])
    return np.stack([np.broadcast_to([0.9, 1.2], (2, 2)), 0.4 * np.cos(angle), 0.4 * np.sin(angle)], axis=-1)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_wedge_angles_are_those_about_the_edge(seed: int) -> None:
    random = np.random.default_rng(seed)
    turn, angles = random.uniform(0.1, 6.0), random.uniform(0.05, 6.2, (2, 2))
    mesh = hinge(turn)
    found = wedge_angles(mesh, at_angles(angles[0].tolist(), angles[1].tolist()))
    edge = int(np.flatnonzero(~mesh.boundary_edges)[0])
    assert np.allclose(found[0, edge], [*angles[0], turn], atol=1e-12)
    assert np.allclose(found[1, edge], 2.0 * np.pi - np.array([*angles[1], turn]), atol=1e-12)
    assert np.isnan(found[:, mesh.boundary_edges]).all()


NAN = float("nan")


@pytest.mark.parametrize(
    ("turn", "above", "below", "crosses"),
    [
        (200, (60, 140), (NAN, NAN), False),
        (200, (140, 60), (NAN, NAN), True),  # apexes past each other
        (200, (10, 191), (NAN, NAN), True),  # the edge's tetrahedron turns inside out
        (40, (50, NAN), (NAN, NAN), True),  # through the other face
        (40, (NAN, -20), (NAN, NAN), True),
        (40, (30, NAN), (NAN, NAN), False),
        (40, (10, 20), (300, 200), False),
        (40, (10, 20), (200, 300), True),  # on the other side
        (300, (NAN, NAN), (350, 310), False),
        (300, (NAN, NAN), (290, NAN), True),
        (300, (NAN, NAN), (NAN, NAN), False),
    ],
)
def test_what_crosses(turn: float, above: tuple[float, float], below: tuple[float, float], crosses: bool) -> None:
    mesh = hinge(np.radians(turn))
    found = crossing_edges(mesh, at_angles(np.radians(above).tolist(), np.radians(below).tolist()))
    assert found.sum() == crosses
    assert not found[mesh.boundary_edges].any()


def overlap(one: Float, other: Float) -> bool:
    """Whether two tetrahedra (4, 3) that share their first two vertices overlap, by points near these."""
    weights = np.random.default_rng(0).dirichlet([1.0, 1.0, 0.05, 0.05], 4000)
    matrix = np.vstack([other.T, np.ones(4)])
    inside = np.linalg.solve(matrix, np.vstack([(weights @ one).T, np.ones(len(weights))]))
    return bool((inside > 1e-12).all(axis=0).any())


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_tetrahedra_overlap_exactly_where_they_are_said_to_cross(seed: int) -> None:
    random = np.random.default_rng(seed)
    mesh = hinge(random.uniform(0.3, 3.0))  # below pi, where the edge's tetrahedron cannot turn inside out
    corners = mesh.corner_points()
    normals = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    above = corners.mean(axis=1) + random.uniform(0.05, 1.5, (2, 1)) * normals
    tetrahedra = [np.vstack([mesh.points[[0, 1, third]], apex]) for third, apex in zip((2, 3), above, strict=True)]
    crosses = crossing_edges(mesh, np.stack([above, np.full((2, 3), np.nan)])).any()
    angles = wedge_angles(mesh, np.stack([above, np.full((2, 3), np.nan)]))[0]
    u_k, u_l, _ = angles[~mesh.boundary_edges][0]
    if abs(u_k - u_l) > 0.05:  # the sample is finite
        assert crosses == overlap(tetrahedra[0], tetrahedra[1])


@st.composite
def meshes_and_edges(draw: st.DrawFn) -> tuple[HermiteMesh, Bool]:
    mesh = HermiteMesh(**draw(mesh_data(quads=False)))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return mesh.without_second_forms(), random.random(len(mesh.edges)) < draw(st.sampled_from([0.05, 0.3, 0.7, 1.0]))


def valid(mesh: HermiteMesh) -> bool:
    triangles = Triangulation(mesh.faces, len(mesh.points))
    return not (~triangles.on_boundary & (triangles.face_count == 2)).any()


def divided(mesh: HermiteMesh, edges: Bool) -> tuple[Float, Int, Int, Float]:
    """The mesh with flat faces: vertices at the middles of edges, faces, parents and places."""
    middles = mesh.points[mesh.edges[edges]].mean(axis=1)
    points = np.concatenate([mesh.points, middles])
    ids = np.full(len(edges), -1)
    ids[edges] = len(mesh.points) + np.arange(edges.sum())
    return points, *divided_faces(points, mesh.faces, ids[mesh.face_edges])


@given(meshes_and_edges())
@settings(max_examples=60, deadline=None)
def test_divided_faces_conform_keep_orientation_and_fill_their_parents(data: tuple[HermiteMesh, Bool]) -> None:
    mesh, edges = data
    points, faces, parent, corners = divided(mesh, edges)
    finer = HermiteMesh(points, faces)  # an oriented manifold without hanging vertices, or MeshError
    split = edges[mesh.face_edges].sum(axis=1)
    assert np.array_equal(np.bincount(parent), 1 + split)
    assert finer.boundary_edges.sum() == (mesh.boundary_edges.astype(np.int64) * (1 + edges)).sum()
    characteristic = [len(one.points) - len(one.edges) + len(one.faces) for one in (mesh, finer)]
    assert characteristic[0] == characteristic[1]
    legs = corners[:, 1:] - corners[:, :1]
    areas = 0.5 * (legs[:, 0, 0] * legs[:, 1, 1] - legs[:, 0, 1] * legs[:, 1, 0])
    assert areas.min() > 0.0
    assert np.abs(np.bincount(parent, weights=areas) - 0.5).max() == 0.0
    found = np.einsum("fci,fid->fcd", barycentric(corners), mesh.corner_points()[parent])
    assert np.abs(found - points[faces]).max() < 1e-14 * np.abs(points).max()


@pytest.mark.parametrize("name", ["octahedron", "torus", "graph"])
def test_all_edges_split_are_a_step_of_the_butterfly(name: str) -> None:
    mesh = registry.dataset(name).mesh(0)
    refined = split_edges(mesh, np.ones(len(mesh.edges), dtype=np.bool_))
    (part,) = Butterfly(depth=1).fit(mesh).parts
    assert np.array_equal(refined.parent, part.faces)
    expected = {tuple(row) for row in np.sort(part.corner_ids, axis=1).tolist()}
    assert {tuple(row) for row in np.sort(refined.mesh.faces, axis=1).tolist()} == expected
    at = dict(zip(part.corner_ids.ravel().tolist(), part.batch.jets(CORNERS[3], 0).f.reshape(-1, 3), strict=True))
    assert max(norm(refined.mesh.points[vertex] - point) for vertex, point in at.items()) < 1e-15


def test_new_vertices_inside_and_on_the_boundary_are_the_printed_ones() -> None:
    places, triangles = lattice(4, 4)
    points = np.column_stack([places, 0.1 * places[:, 0] ** 2 - 0.2 * places[:, 1] ** 3])
    mesh = HermiteMesh(points, triangles)
    printed: list[tuple[tuple[int, int], list[tuple[tuple[int, ...], float]]]] = [
        # inside: the ends, the third vertices of the two faces, the four wings
        ((7, 12), [((7, 12), 1 / 2), ((8, 11), 1 / 8), ((3, 6, 13, 16), -1 / 16)]),
        # along the boundary: four points
        ((5, 10), [((5, 10), 9 / 16), ((0, 15), -1 / 16)]),
    ]
    for ends, stencil in printed:
        edge = (mesh.edges == ends).all(axis=1)
        assert edge.sum() == 1
        expected = np.sum([weight * points[list(ids)].sum(axis=0) for ids, weight in stencil], axis=0)
        assert norm(split_edges(mesh, edge).mesh.points[-1] - expected) < 1e-15


def test_diagonals_are_the_shorter_ones_and_of_equal_ones_that_from_the_side_that_comes_first() -> None:
    long = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    even = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [2.0, 0.0, 0.0]])
    for corners, unsplit, diagonal in ((long, 0, (0, 4)), (long, 1, (2, 3)), (long, 2, (0, 4)), (even, 2, (2, 3))):
        points = np.concatenate([corners, 0.5 * (corners + np.roll(corners, -1, axis=0))])
        for turn in range(3):
            middles = np.array([[3, 4, 5]])
            middles[0, unsplit] = -1
            faces = np.roll([[0, 1, 2]], -turn, axis=1)
            found, _, _ = divided_faces(points, faces, np.roll(middles, -turn, axis=1))
            ahead = np.roll(found, -1, axis=1)
            sides = np.sort(np.stack([found.ravel(), ahead.ravel()], axis=-1), axis=1).tolist()
            assert sides.count(list(diagonal)) == 2


@given(meshes_and_edges(), st.booleans())
@settings(max_examples=40, deadline=None)
def test_old_vertices_stay_and_new_ones_have_loop_normals_of_mean_length(
    data: tuple[HermiteMesh, Bool], loop: bool
) -> None:
    mesh, edges = data
    assert mesh.normals is not None
    lengths = np.random.default_rng(1).uniform(0.5, 2.0, len(mesh.points))
    mesh = HermiteMesh(mesh.points, mesh.faces, mesh.normals, gradients=lengths[:, None] * mesh.normals)
    if not valid(mesh):
        with pytest.raises(MeshError, match="back to back"):
            split_edges(mesh, edges)
        return
    try:
        refined = split_edges(mesh, edges, loop=loop)
    except MeshError:
        return  # Loop's surface may have no normal
    finer, count = refined.mesh, len(mesh.points)
    assert finer.normals is not None
    assert finer.gradients is not None
    assert mesh.gradients is not None
    assert refined.splits == edges.sum() == len(finer.points) - count
    assert np.array_equal(finer.points[:count], mesh.points)
    limits = loop_limit_normals(finer.points, finer.faces)
    old = 0 if loop else count
    assert norm(finer.normals[old:] - limits[old:]).max(initial=0.0) < 1e-14
    if not loop:
        assert mesh.normals is not None
        assert np.array_equal(finer.normals[:count], mesh.normals)
        assert np.array_equal(finer.gradients[:count], mesh.gradients)
    assert np.allclose(norm(finer.gradients[:count]), lengths, rtol=1e-14)
    assert np.allclose(norm(finer.gradients[count:]), lengths[mesh.edges[edges]].mean(axis=1), rtol=1e-14)


def test_a_mesh_without_normals_stays_so() -> None:
    mesh = registry.dataset("graph").mesh(0).without_normals()
    edges = np.arange(len(mesh.edges)) % 3 == 0
    assert split_edges(mesh, edges).mesh.normals is None
    assert split_edges(mesh, edges, loop=True).mesh.normals is not None


def random_rotation(random: np.random.Generator) -> Float:
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turned: Float = turn * np.linalg.det(turn)
    return turned


@pytest.mark.parametrize("name", ["octahedron", "torus", "graph", "mesh"])
def test_motions_and_labels_do_not_matter(name: str) -> None:
    mesh = with_gradients(registry.dataset(name).mesh(0))
    random = np.random.default_rng(2)
    edges = random.random(len(mesh.edges)) < 0.4
    refined = split_edges(mesh, edges)
    turn = random_rotation(random)
    moved = split_edges(mesh.transformed(turn, (1.0, 2.0, -0.5), 3.0), edges)
    assert np.array_equal(moved.mesh.faces, refined.mesh.faces)
    expected = refined.mesh.transformed(turn, (1.0, 2.0, -0.5), 3.0)
    assert norm(moved.mesh.points - expected.points).max() < 1e-13
    assert moved.mesh.gradients is not None
    assert expected.gradients is not None
    assert norm(moved.mesh.gradients - expected.gradients).max() < 1e-12
    order = random.permutation(len(mesh.points))
    other = mesh.relabelled(order).rotated_corners(random.integers(3, size=len(mesh.faces)))
    same = {tuple(row): number for number, row in enumerate(np.sort(order[other.edges], axis=1).tolist())}
    chosen = np.zeros(len(edges), dtype=np.bool_)
    for row in mesh.edges[edges].tolist():
        chosen[same[tuple(row)]] = True
    relabelled = split_edges(other, chosen)
    assert np.array_equal(relabelled.parent, refined.parent)
    centres = [one.mesh.corner_points().mean(axis=1) for one in (refined, relabelled)]
    for parent in np.unique(refined.parent).tolist():
        one, two = (centre[refined.parent == parent] for centre in centres)
        assert norm(one[:, None] - two[None]).min(axis=1).max() < 1e-14


def test_planes_stay_planes() -> None:
    mesh = registry.dataset("graph").mesh(1)
    flat = HermiteMesh(mesh.points * [1.0, 1.0, 0.0], mesh.faces)
    edges = np.random.default_rng(6).random(len(mesh.edges)) < 0.4
    refined = split_edges(flat, edges, loop=True).mesh
    assert np.array_equal(refined.points[:, 2], np.zeros(len(refined.points)))
    assert refined.normals is not None
    assert norm(refined.normals - [0.0, 0.0, 1.0]).max() < 1e-14


@pytest.mark.parametrize("name", ["octahedron", "icosahedron", "sphere", "ellipsoid", "graph", "mesh"])
def test_meshes_whose_tetrahedra_are_apart_stay_as_they_are(name: str) -> None:
    mesh = with_gradients(registry.dataset(name).mesh(0))
    refined = separated_hull(mesh, apexes, 3)
    assert refined.mesh is mesh
    assert refined.splits == refined.beside == 0
    assert np.array_equal(refined.corners_in_parent, np.broadcast_to(CORNERS[3], (len(mesh.faces), 3, 2)))


def check_refinement(mesh: HermiteMesh, refined: RefinedMesh) -> None:
    assert not crossing_edges(refined.mesh, apexes(refined.mesh)).any()
    count = len(mesh.points)
    assert np.array_equal(refined.mesh.points[:count], mesh.points)
    assert len(refined.mesh.points) == count + refined.splits
    legs = refined.corners_in_parent[:, 1:] - refined.corners_in_parent[:, :1]
    areas = 0.5 * (legs[:, 0, 0] * legs[:, 1, 1] - legs[:, 0, 1] * legs[:, 1, 0])
    assert areas.min() > 0.0
    assert np.array_equal(np.bincount(refined.parent, weights=areas), np.full(len(mesh.faces), 0.5))
    # corners at mesh vertices are corners of the parent there
    face, corner = np.nonzero(refined.mesh.faces < count)
    bary = barycentric(refined.corners_in_parent[face, corner])
    own = mesh.faces[refined.parent[face], np.argmax(bary, axis=1)]
    assert (bary.max(axis=1) == 1.0).all()
    assert np.array_equal(own, refined.mesh.faces[face, corner])


@pytest.mark.parametrize(
    ("name", "loop", "beside"),
    [("hyperboloid", False, False), ("branch", False, False), ("jug", False, False), ("torus", True, True)],
)
def test_coarse_meshes_whose_tetrahedra_cross_are_parted(name: str, loop: bool, beside: bool) -> None:
    mesh = with_gradients(registry.dataset(name).mesh(1 if name == "jug" else 0), loop=loop)
    crossing = crossing_edges(mesh, apexes(mesh))
    assert crossing.any()
    refined = separated_hull(mesh, apexes, 3, loop=loop)
    assert refined.splits >= crossing.sum()
    assert (refined.beside > 0) == beside
    check_refinement(mesh, refined)


@pytest.mark.parametrize(("name", "height", "levels"), [("octahedron", 1.2, 1), ("icosahedron", 1.5, 2)])
def test_stars_are_parted_with_loop_normals(name: str, height: float, levels: int) -> None:
    mesh = with_gradients(star(name, height))
    corners = mesh.corner_points()
    facets = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    turns = np.degrees(np.arccos((facets[mesh.edge_faces[:, 0]] * facets[mesh.edge_faces[:, 1]]).sum(axis=1)))
    assert turns.max() > 90.0
    check_refinement(mesh, separated_hull(mesh, apexes, levels, loop=True))
    with pytest.raises(Refused, match="cross"):
        separated_hull(mesh, apexes, levels - 1, loop=True)


def test_what_refinement_does_not_part_is_refused_with_the_edge() -> None:
    mesh = with_gradients(registry.dataset("ring").mesh(0))
    with pytest.raises(Refused, match=r"at the edge between vertices 2 and 3 cross \(35 such edges\).*mesh of step 3"):
        separated_hull(mesh, apexes, 3)
    with pytest.raises(Refused, match=r"between vertices 2 and 3 cross .* it is not allowed"):
        separated_hull(mesh, apexes, 0)


def test_refined_meshes_without_tetrahedra_are_refused_in_words_about_the_mesh() -> None:
    mesh = with_gradients(registry.dataset("hyperboloid").mesh(0))

    def only_on_it(one: HermiteMesh) -> Float:
        if one is not mesh:
            raise Refused("vertex 1234 of a mesh that nobody knows")
        return apexes(one)

    with pytest.raises(
        Refused, match=r"between vertices 1 and 4 .* no tetrahedra stand on the mesh of step 1"
    ) as caught:
        separated_hull(mesh, only_on_it, 3)
    assert "1234" not in str(caught.value)

    def none_at_all(_: HermiteMesh) -> Float:
        raise Refused("no tetrahedra here")

    with pytest.raises(Refused, match="no tetrahedra here"):
        separated_hull(mesh, none_at_all, 3)


def test_places_of_edges_are_told_in_the_words_of_the_mesh() -> None:
    mesh = registry.dataset("octahedron").mesh(0)
    edges = (mesh.edges == [0, 1]).all(axis=1)
    refined = RefinedMesh.unrefined(mesh).followed_by(split_edges(mesh, edges))
    told = {tuple(ends): edge_place(mesh.faces, refined, row) for row, ends in enumerate(refined.mesh.edges.tolist())}
    assert told[(0, 2)] == "the edge between vertices 0 and 2"
    assert told[(0, 6)] == told[(1, 6)] == "a piece of the edge between vertices 0 and 1"
    assert told[(2, 6)] == "an edge inside face 0, of vertices 0, 1 and 2"


def test_two_refinements_are_one() -> None:
    mesh = registry.dataset("graph").mesh(0).without_normals()
    random = np.random.default_rng(5)
    once = split_edges(mesh, random.random(len(mesh.edges)) < 0.4)
    twice = split_edges(once.mesh, random.random(len(once.mesh.edges)) < 0.4)
    both = once.followed_by(twice)
    assert both.splits == once.splits + twice.splits
    bary = barycentric(both.corners_in_parent)
    # places are those of flat faces
    flat = np.einsum("fci,fid->fcd", bary, mesh.corner_points()[both.parent])
    within = np.einsum("fci,fid->fcd", barycentric(once.corners_in_parent), mesh.corner_points()[once.parent])
    expected = np.einsum("fci,fid->fcd", barycentric(twice.corners_in_parent), within[twice.parent])
    assert np.abs(flat - expected).max() < 1e-15


def test_two_faces_back_to_back_cannot_be_split() -> None:
    mesh = HermiteMesh([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0, 1, 2], [0, 2, 1]])
    with pytest.raises(MeshError, match="no edge can be split at vertex 0"):
        split_edges(mesh, np.ones(3, dtype=np.bool_))
