"""The complex of a surface follows from its corner ids, and points given by mesh face find their patches."""

import re

import numpy as np
import pytest
from hostile_meshes import Data, bipyramid, cut, fan, mesh_data, quad_grid
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from testbed.errors import PluginError
from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.domain import CORNERS, barycentric, lattice
from testbed.geometry.edges import patch_edges
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.subdomains import from_face, to_face
from testbed.geometry.surface import Part, Surface
from testbed.geometry.vectors import Float

quick = settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
seeds = st.integers(0, 2**32 - 1)

#: Cubic multi-indices in the order of control points.
CUBIC = [(i, j, 3 - i - j) for i in (3, 2, 1, 0) for j in range(3 - i, -1, -1)]


def linear_surface(mesh: HermiteMesh) -> Surface:
    """The mesh itself, a patch a face."""
    corners = mesh.corner_points()
    if mesh.sides == 3:
        return Surface.over_faces(mesh, BezierTriangles(corners))
    return Surface.over_faces(mesh, BezierQuads(corners[:, [0, 3, 1, 2]].reshape(-1, 2, 2, 3)))


def split_linear_surface(mesh: HermiteMesh) -> Surface:
    """The mesh itself, three patches a face."""
    corners = mesh.corner_points()
    centre = corners.mean(axis=1)
    nets = [np.stack([corners[:, (i + 1) % 3], corners[:, (i + 2) % 3], centre], axis=1) for i in range(3)]
    return Surface.over_split_faces(mesh, BezierTriangles(np.stack(nets, axis=1).reshape(-1, 3, 3)))


def de_casteljau(net: dict[tuple[int, ...], Float], arguments: Float) -> Float:
    """Blossom of control points named by their multi-indices, at barycentric arguments (degree, 3)."""
    for b in arguments:
        degree = sum(next(iter(net))) - 1
        lower = [(i, j, degree - i - j) for i in range(degree + 1) for j in range(degree - i + 1)]
        net = {a: sum(b[k] * net[tuple(np.add(a, np.eye(3, dtype=int)[k]))] for k in range(3)) for a in lower}
    (value,) = net.values()
    return value


def split_cubics(mesh: HermiteMesh, nets: Float) -> Surface:
    """The cubics with control points ``nets`` (F, 10, 3), cut at the centres of faces by de Casteljau's algorithm."""
    pieces = []
    for net in nets:
        named: dict[tuple[int, ...], Float] = dict(zip(CUBIC, net, strict=True))
        for i in range(3):
            corners = np.stack([np.eye(3)[(i + 1) % 3], np.eye(3)[(i + 2) % 3], np.full(3, 1 / 3)])
            pieces.append([de_casteljau(named, np.repeat(corners, index, axis=0)) for index in CUBIC])
    return Surface.over_split_faces(mesh, BezierTriangles(np.array(pieces)))


@quick
@given(mesh_data())
def test_edges_of_a_patch_a_face_are_the_edges_of_the_mesh(data: Data) -> None:
    mesh = HermiteMesh(**data)
    edges = linear_surface(mesh).edges
    assert np.array_equal(np.sort(edges.ids, axis=1), mesh.edges)
    assert np.array_equal(edges.boundary, mesh.boundary_edges)
    inner = edges[edges.interior]
    assert np.array_equal(np.stack([inner.left.face, inner.right.face], axis=1), mesh.edge_faces[edges.interior])
    assert not edges.within_face.any()


@quick
@given(mesh_data(quads=False))
def test_split_faces_have_three_inner_edges_each(data: Data) -> None:
    mesh = HermiteMesh(**data)
    surface = split_linear_surface(mesh)
    edges = surface.edges
    assert len(edges) == len(mesh.edges) + 3 * len(mesh.faces)
    assert edges.boundary.sum() == mesh.boundary_edges.sum()
    assert edges.within_face.sum() == 3 * len(mesh.faces)
    vertices = len(mesh.points) + len(mesh.faces)
    assert vertices - len(edges) + surface.patch_count == len(mesh.points) - len(mesh.edges) + len(mesh.faces)


@quick
@given(mesh_data(), st.booleans())
def test_each_side_of_each_patch_is_on_one_edge(data: Data, split: bool) -> None:
    mesh = HermiteMesh(**data)
    surface = split_linear_surface(mesh) if split and mesh.sides == 3 else linear_surface(mesh)
    (part,), edges = surface.parts, surface.edges
    inner = edges[edges.interior]
    seen = np.concatenate(
        [edges.left.patch * mesh.sides + edges.left.side, inner.right.patch * mesh.sides + inner.right.side]
    )
    assert np.array_equal(np.sort(seen), np.arange(part.corner_ids.size))
    for sides, ids in ((edges.left, edges.ids), (inner.right, inner.ids[:, ::-1])):
        assert np.array_equal(part.corner_ids[sides.patch, sides.side], ids[:, 0])
        assert np.array_equal(part.corner_ids[sides.patch, (sides.side + 1) % mesh.sides], ids[:, 1])
        assert np.array_equal(part.faces[sides.patch], sides.face)
    assert (inner.ids[:, 0] < inner.ids[:, 1]).all()
    outer = edges[edges.boundary].right
    assert (np.stack([outer.part, outer.patch, outer.side, outer.face]) == -1).all()


@quick
@given(mesh_data(), st.booleans(), st.booleans())
def test_both_sides_of_an_edge_meet_at_the_same_points(data: Data, split: bool, own: bool) -> None:
    mesh = HermiteMesh(**data)
    surface = split_linear_surface(mesh) if split and mesh.sides == 3 else linear_surface(mesh)
    edges = surface.edges[surface.edges.interior]
    t = np.array([0.0, 0.125, 0.7, 1.0])
    left, right = surface.edge_jets(edges, np.tile(t, (len(edges), 1)) if own else t, order=1)
    assert left.coefficients.shape == right.coefficients.shape == (3, len(edges), 4, 3)
    np.testing.assert_allclose(left.f, right.f, atol=1e-14)
    places = np.concatenate([mesh.points, mesh.corner_points().mean(axis=1)])[edges.ids]
    expected = places[:, :1] * (1 - t)[:, None] + places[:, 1:] * t[:, None]
    np.testing.assert_allclose(left.f, expected, atol=1e-14)


def test_sides_without_a_patch_have_no_points() -> None:
    surface = linear_surface(HermiteMesh(*fan(4)))
    left, right = surface.edge_jets(surface.edges, np.array([0.5]), order=0)
    assert np.isfinite(left.f).all()
    assert np.array_equal(np.isnan(right.f[:, 0, 0]), surface.edges.boundary)


def two_parts(mesh: HermiteMesh) -> Surface:
    """One patch on every other face, three on the rest."""
    even, odd = (np.arange(start, len(mesh.faces), 2) for start in (0, 1))
    whole, split = linear_surface(mesh).parts[0], split_linear_surface(mesh).parts[0]
    pieces = (3 * odd[:, None] + np.arange(3)).ravel()
    return Surface(
        mesh,
        tuple(
            Part(part.batch.take(chosen), part.corner_ids[chosen], part.faces[chosen], part.corners_in_face[chosen])
            for part, chosen in ((split, pieces), (whole, even))
        ),
    )


@quick
@given(mesh_data(quads=False), seeds)
def test_parts_are_joined(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    surface = two_parts(mesh)
    assert len(surface.edges) == len(mesh.edges) + 3 * (len(mesh.faces) // 2)
    assert surface.edges.boundary.sum() == mesh.boundary_edges.sum()
    inner = surface.edges[surface.edges.interior]
    left, right = surface.edge_jets(inner, np.linspace(0, 1, 3), order=0)
    np.testing.assert_allclose(left.f, right.f, atol=1e-14)
    face, bary = places(mesh, seed)
    at_mesh = linear_surface(mesh).evaluate(face, bary)
    np.testing.assert_allclose(surface.evaluate(face, bary).coefficients, at_mesh.coefficients, atol=1e-13)


def places(mesh: HermiteMesh, seed: int, count: int = 50) -> tuple[np.ndarray, Float]:
    random = np.random.default_rng(seed)
    face = random.integers(len(mesh.faces), size=count)
    return face, random.dirichlet(np.ones(3), count) if mesh.sides == 3 else random.random((count, 2))


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        (
            [[0, 1, 2], [1, 0, 3], [0, 1, 4]],
            "patch 0 of part 0 (mesh face 5), patch 1 of part 0 (mesh face 6), patch 2",
        ),
        ([[0, 1, 2], [0, 1, 3]], "on the edge from corner 0 to corner 1"),
    ],
)
def test_sides_that_do_not_fit_together_are_an_error(ids: list[list[int]], words: str) -> None:
    with pytest.raises(PluginError, match=re.escape(words)):
        patch_edges([np.array(ids)], [np.arange(5, 5 + len(ids))])


def test_a_patch_too_few_is_an_error() -> None:
    mesh = HermiteMesh(*bipyramid(4))
    with pytest.raises(PluginError, match=r"corner_ids has shape \(8, 3\) for 7 patches of 3 sides: give \(7, 3\)"):
        Surface.over_faces(mesh, BezierTriangles(mesh.corner_points()[:7]))


def test_a_surface_without_patches_has_no_edges() -> None:
    surface = Surface(HermiteMesh(*fan(3)), ())
    assert len(surface.edges) == 0
    with pytest.raises(ValueError, match="face 1 of the mesh has no patch"):
        surface.evaluate(np.array([1]), np.array([[1.0, 0, 0]]))


@quick
@given(mesh_data(), seeds)
def test_a_patch_a_face_is_evaluated_as_it_is(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    surface = linear_surface(mesh)
    face, at = places(mesh, seed)
    jet = surface.evaluate(face, at)
    direct = surface.parts[0].batch.take(face).jets(at[:, None, -2:])
    assert np.array_equal(jet.coefficients, direct.coefficients[:, :, 0])
    corners = mesh.corner_points()[face]
    if mesh.sides == 3:
        np.testing.assert_allclose(jet.f, np.einsum("nk,nki->ni", at, corners), atol=1e-14)
        np.testing.assert_allclose(jet.fu, corners[:, 1] - corners[:, 0], atol=1e-14)
    else:
        np.testing.assert_allclose(jet.fuv, corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3], atol=1e-13)


@settings(max_examples=10, deadline=None)
@given(mesh_data(quads=False), seeds)
def test_derivatives_on_split_faces_are_those_of_the_face(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    nets = np.random.default_rng(seed).normal(size=(len(mesh.faces), 10, 3))
    whole, split = Surface.over_faces(mesh, BezierTriangles(nets)), split_cubics(mesh, nets)
    face, bary = places(mesh, seed)
    # corners, mesh edges, inner edges and the centre too
    special = np.array(
        [[1, 0, 0], [0, 1, 0], [0.25, 0.75, 0], [0.5, 0.25, 0.25], [0.2, 0.2, 0.6], [1 / 3, 1 / 3, 1 / 3]]
    )
    face, bary = np.append(face, np.zeros(len(special), dtype=int)), np.concatenate([bary, special])
    for order, rows in ((0, 1), (1, 3), (2, 6)):
        one, three = whole.evaluate(face, bary, order), split.evaluate(face, bary, order)
        assert one.coefficients.shape == three.coefficients.shape == (rows, len(face), 3)
        np.testing.assert_allclose(three.coefficients, one.coefficients, atol=2e-12)


def test_a_point_on_an_inner_edge_is_evaluated_alike_in_any_company() -> None:
    mesh = HermiteMesh(*bipyramid(5))
    nets = np.random.default_rng(0).normal(size=(3 * len(mesh.faces), 10, 3))  # patches that do not even meet
    surface = Surface.over_split_faces(mesh, BezierTriangles(nets))
    inner = np.linspace(1 / 3, 1, 40)
    bary = np.stack([inner, (1 - inner) / 2, (1 - inner) / 2], axis=-1)
    face = np.arange(40) % len(mesh.faces)
    together = surface.evaluate(face, bary).coefficients
    order = np.random.default_rng(1).permutation(40)
    assert np.array_equal(surface.evaluate(face[order], bary[order]).coefficients, together[:, order])
    for row in range(0, 40, 7):
        assert np.array_equal(surface.evaluate(face[[row]], bary[[row]]).coefficients[:, 0], together[:, row])


def test_more_points_than_a_chunk() -> None:
    mesh = HermiteMesh(*bipyramid(5))
    face, bary = places(mesh, 0, 40000)
    values = split_linear_surface(mesh).evaluate(face, bary, 0).f
    np.testing.assert_allclose(values, np.einsum("nk,nki->ni", bary, mesh.corner_points()[face]), atol=1e-14)


def in_three_quads(mesh: HermiteMesh) -> Surface:
    """The triangles of a mesh, each of three quadrilateral patches that meet in its centre."""
    middle = np.array([[0.5, 0], [0.5, 0.5], [0, 0.5]])
    corners = np.stack([np.stack([CORNERS[3][i], middle[i], [1 / 3, 1 / 3], middle[i - 1]]) for i in range(3)])
    faces = np.repeat(np.arange(len(mesh.faces)), 3)
    in_face = np.tile(corners, (len(mesh.faces), 1, 1))
    points = np.einsum("pck,pki->pci", barycentric(in_face), mesh.corner_points()[faces])
    vertex = len(mesh.points)
    ids = [
        [face[i], vertex + edges[i], vertex + len(mesh.edges) + f, vertex + edges[i - 1]]
        for f, (face, edges) in enumerate(zip(mesh.faces, mesh.face_edges, strict=True))
        for i in range(3)
    ]
    nets = points[:, [0, 3, 1, 2]].reshape(-1, 2, 2, 3)
    return Surface(mesh, (Part(BezierQuads(nets), np.array(ids), faces, in_face),))


@quick
@given(mesh_data(quads=False), seeds)
def test_bilinear_patches_in_triangles_have_the_derivatives_of_the_face(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    surface = in_three_quads(mesh)
    assert len(surface.edges) == 2 * len(mesh.edges) + 3 * len(mesh.faces)
    face, bary = places(mesh, seed)
    expected = linear_surface(mesh).evaluate(face, bary).coefficients
    np.testing.assert_allclose(surface.evaluate(face, bary).coefficients, expected, atol=1e-11)


@quick
@given(mesh_data(quads=False), seeds)
def test_place_is_where_the_point_is(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    for surface in (linear_surface(mesh), split_linear_surface(mesh), in_three_quads(mesh)):
        (part,) = surface.parts
        random = np.random.default_rng(seed)
        patches = random.integers(len(part.batch), size=20)
        at = lattice(part.batch.sides, 4)[random.integers(15, size=(20, 2))]
        face, in_face = surface.place(0, patches, at)
        assert in_face.shape == (20, 2, 2)
        assert np.array_equal(face, part.faces[patches])
        for sample in range(2):
            points = part.batch.take(patches).jets(at[:, sample, None], 0).f[:, 0]
            there = np.einsum("nk,nki->ni", barycentric(in_face[:, sample]), mesh.corner_points()[face])
            np.testing.assert_allclose(points, there, atol=1e-14)
            assert np.array_equal(surface.place(0, patches, at[:, sample])[1], in_face[:, sample])


@quick
@given(seeds)
def test_from_face_inverts_to_face(seed: int) -> None:
    random = np.random.default_rng(seed)
    triangle = random.normal(size=(30, 3, 2))
    convex = CORNERS[4] + random.uniform(-0.2, 0.2, size=(30, 4, 2))
    for corners in (triangle, convex):
        at = random.dirichlet(np.ones(3), 30)[:, :2]
        scale = np.abs(np.linalg.inv(triangle[:, 1:] - triangle[:, :1])).max() if corners is triangle else 1.0
        np.testing.assert_allclose(from_face(corners, to_face(corners, at)), at, atol=1e-14 * max(1.0, scale) * 10)


@pytest.mark.parametrize(
    ("face", "bary", "words"),
    [
        ([8], [[1, 0, 0]], "there is no face 8: the mesh has faces 0 to 7"),
        ([0, -1], [[1, 0, 0], [1, 0, 0]], "there is no face -1"),
        ([0.0], [[1, 0, 0]], "face holds float64"),
        ([0, 1], [[1, 0, 0]], "bary has shape (1, 3): give (2, 3) barycentric coordinates"),
        ([0], [[1, 0]], "bary has shape (1, 2): give (1, 3)"),
        ([0, 0], [[1, 0, 0], [0.5, 0.6, 0]], "row 1 of bary, [0.5, 0.6, 0.0], is not a place in face 0"),
        ([3], [[1.1, -0.1, 0]], "is not a place in face 3"),
        ([3], [[np.nan, 0, 0]], "is not a place in face 3"),
        ([3], [[0, np.nan, 1]], "is not a place in face 3"),
    ],
)
def test_places_that_do_not_exist_are_named(face: list[int], bary: list[list[float]], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        linear_surface(HermiteMesh(*bipyramid(4))).evaluate(np.array(face), np.array(bary))


def test_places_in_quadrilaterals_are_checked() -> None:
    surface = linear_surface(HermiteMesh(*quad_grid(3, 3, closed=True)))
    with pytest.raises(ValueError, match=r"give parameters between 0 and 1"):
        surface.evaluate(np.array([0]), np.array([[0.5, 1.1]]))


def test_the_table_of_many_patches_is_quick() -> None:
    points, faces = quad_grid(100, 100, closed=True)
    mesh = HermiteMesh(points, cut(faces))
    edges = split_linear_surface(mesh).edges
    assert len(edges) == len(mesh.edges) + 3 * len(mesh.faces)
    assert edges.interior.all()
