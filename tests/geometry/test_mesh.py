"""The tables of a mesh agree with each other; its methods are what they say, and their inverses bring it back."""

import pickle

import numpy as np
import pytest
from hostile_meshes import Data, bipyramid, cut, fan, mesh_data, quad_grid
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import testbed
from testbed.errors import MeshError
from testbed.geometry.mesh import HermiteMesh

quick = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
seeds = st.integers(0, 2**32 - 1)


def assert_same(mesh: HermiteMesh, other: HermiteMesh, tolerance: float = 0.0) -> None:
    assert np.array_equal(mesh.faces, other.faces)
    for name in ("points", "normals", "second_forms"):
        a, b = getattr(mesh, name), getattr(other, name)
        assert (a is None) == (b is None)
        if a is not None:
            np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * max(1.0, np.abs(b).max()))


@quick
@given(mesh_data())
def test_edges_are_the_sides_of_the_faces_each_once(data: Data) -> None:
    mesh = HermiteMesh(**data)
    expected = {tuple(sorted((f[s], f[s - 1]))) for f in mesh.faces.tolist() for s in range(mesh.sides)}
    assert [tuple(edge) for edge in mesh.edges.tolist()] == sorted(expected)


@quick
@given(mesh_data())
def test_face_edges_and_edge_faces_agree(data: Data) -> None:
    mesh = HermiteMesh(**data)
    for face, corners in enumerate(mesh.faces.tolist()):
        for side in range(mesh.sides):
            start, end = corners[side], corners[(side + 1) % mesh.sides]
            edge = mesh.face_edges[face, side]
            assert mesh.edges[edge].tolist() == sorted((start, end))
            assert mesh.face_edge_forward[face, side] == (start < end)
            assert mesh.edge_faces[edge, 0 if start < end else 1] == face
    assert (mesh.edge_faces >= 0).sum() == mesh.faces.size
    assert np.array_equal(mesh.boundary_edges, (mesh.edge_faces < 0).any(axis=1))


@quick
@given(mesh_data())
def test_valence_and_boundary_vertices(data: Data) -> None:
    mesh = HermiteMesh(**data)
    faces_at = np.bincount(mesh.faces.ravel())
    assert np.array_equal(mesh.valence, faces_at + mesh.boundary_vertices)
    assert mesh.valence.sum() == 2 * len(mesh.edges)
    assert mesh.boundary_vertices.sum() == mesh.boundary_edges.sum(), "the boundary is closed curves"


def test_euler_characteristics() -> None:
    for (points, faces), characteristic, boundary in [
        (bipyramid(5), 2, 0),
        (fan(7), 1, 7),
        (quad_grid(4, 3, closed=True), 0, 0),
        (quad_grid(4, 3, closed=False), 1, 14),
    ]:
        mesh = HermiteMesh(points, faces)
        assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == characteristic
        assert mesh.boundary_edges.sum() == boundary


@quick
@given(mesh_data(data=False), seeds, st.floats(-12, 12))
def test_transformed_and_back(data: Data, seed: int, exponent: float) -> None:
    random = np.random.default_rng(seed)
    mesh = HermiteMesh(**data)
    R, scale = Rotation.random(random_state=seed).as_matrix(), 10.0**exponent
    moved = mesh.transformed(R, scale * random.normal(size=3), scale)
    assert moved.h == pytest.approx(scale * mesh.h)
    back = moved.transformed(R.T, scale=1 / scale)
    assert_same(back.transformed(translation=mesh.points[0] - back.points[0]), mesh, 1e-13)


@quick
@given(mesh_data(), seeds)
def test_transformed_second_forms_are_those_of_the_transformed_surface(data: Data, seed: int) -> None:
    # heights over the tangent plane grow with the scale, as the directions do
    mesh = HermiteMesh(**data)
    R = Rotation.random(random_state=seed).as_matrix()
    u, v = np.random.default_rng(seed).normal(size=(2, *mesh.faces.shape, 3))
    moved = mesh.transformed(R, (1, 2, 3), 5.0)
    np.testing.assert_allclose(moved.second_form(5 * u @ R.T, 5 * v @ R.T), 5 * mesh.second_form(u, v), atol=1e-11)


@pytest.mark.parametrize("matrix", [np.diag([1, 1, -1]), 2 * np.eye(3), np.zeros((3, 3)), np.eye(2)])
def test_what_is_no_rotation_is_refused(matrix: np.ndarray) -> None:
    with pytest.raises(ValueError, match="is not a rotation matrix"):
        HermiteMesh(*fan(3)).transformed(matrix)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_what_is_no_scale_is_refused(scale: float) -> None:
    with pytest.raises(ValueError, match="is not a positive number"):
        HermiteMesh(*fan(3)).transformed(scale=scale)


@quick
@given(mesh_data(data=False), seeds)
def test_relabelled_and_back(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    order = np.random.default_rng(seed).permutation(len(mesh.points))
    other = mesh.relabelled(order)
    assert np.array_equal(other.corner_points(), mesh.corner_points())
    assert_same(other.relabelled(np.argsort(order)), mesh)


@quick
@given(mesh_data(data=False), seeds)
def test_faces_in_another_order_and_back(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    order = np.random.default_rng(seed).permutation(len(mesh.faces))
    assert_same(mesh.with_face_order(order).with_face_order(np.argsort(order)), mesh)


def test_what_is_no_permutation_is_refused() -> None:
    mesh = HermiteMesh(*fan(3))
    with pytest.raises(ValueError, match="not a permutation of 0 to 3"):
        mesh.relabelled(np.array([0, 1, 1, 3]))
    with pytest.raises(ValueError, match="not a permutation of 0 to 2"):
        mesh.with_face_order(np.array([0, 1]))


@quick
@given(mesh_data(data=False), seeds)
def test_rotated_corners_and_back(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    assert np.array_equal(mesh.rotated_corners().faces[:, 0], mesh.faces[:, 1])
    shift = np.random.default_rng(seed).integers(0, mesh.sides, size=len(mesh.faces))
    assert_same(mesh.rotated_corners(shift).rotated_corners(-shift), mesh)


@quick
@given(mesh_data(data=False))
def test_flipped_twice_is_the_mesh(data: Data) -> None:
    mesh = HermiteMesh(**data)
    flipped = mesh.flipped()
    assert np.array_equal(flipped.edge_faces, mesh.edge_faces[:, ::-1])
    if mesh.second_forms is not None:
        assert mesh.normals is not None
        assert flipped.normals is not None
        assert np.array_equal(flipped.normals, -mesh.normals)
    assert_same(flipped.flipped(), mesh)


def test_data_can_be_left_out() -> None:
    points, faces = bipyramid(4)
    mesh = HermiteMesh(points, faces, points, np.eye(3) - points[:, :, None] * points[:, None, :])
    assert mesh.without_second_forms().second_forms is None
    assert_same(mesh.without_second_forms(), HermiteMesh(points, faces, points))
    assert_same(mesh.without_normals(), HermiteMesh(points, faces))
    assert mesh.without_normals().normals_from is None


@quick
@given(mesh_data(), seeds)
def test_a_submesh_has_the_chosen_faces(data: Data, seed: int) -> None:
    mesh = HermiteMesh(**data)
    face = int(np.random.default_rng(seed).integers(len(mesh.faces)))
    neighbours = np.unique(mesh.edge_faces[mesh.face_edges[face]])
    chosen = np.append(face, neighbours[(neighbours >= 0) & (neighbours != face)])
    part = mesh.submesh(chosen)
    assert np.array_equal(part.corner_points(), mesh.corner_points()[chosen])
    assert np.array_equal(part.corner_normals(), mesh.corner_normals()[chosen])
    assert len(part.points) == len(np.unique(mesh.faces[chosen]))
    assert_same(mesh.submesh(np.arange(len(mesh.faces))), mesh)


def test_a_submesh_that_hangs_together_in_a_vertex_is_refused() -> None:
    with pytest.raises(MeshError, match="is not manifold"):
        HermiteMesh(*bipyramid(8)).submesh(np.array([0, 4]))


@quick
@given(mesh_data())
def test_a_mesh_keeps_nothing_of_its_arguments_and_cannot_be_changed(data: Data) -> None:
    mesh = HermiteMesh(**data)
    before = HermiteMesh(**data)
    for name in ("points", "faces", "normals", "second_forms"):
        data[name][...] = 0
        with pytest.raises(ValueError, match="read-only"):
            getattr(mesh, name)[0] = 1
        with pytest.raises(AttributeError, match="immutable"):
            setattr(mesh, name, None)
    for table in (mesh.edges, mesh.face_edges, mesh.face_edge_forward, mesh.edge_faces):
        assert not table.flags.writeable
    assert_same(mesh, before)


def test_a_pickled_mesh_is_the_mesh() -> None:
    points, faces = bipyramid(4)
    mesh = HermiteMesh(points, faces, points, normals_from="file")
    copy = pickle.loads(pickle.dumps(mesh))  # noqa: S301 - our own
    assert_same(copy, mesh)
    assert copy.normals_from == "file"
    assert np.array_equal(copy.edges, mesh.edges)
    assert not copy.points.flags.writeable
    assert repr(copy) == "<HermiteMesh: 6 vertices, 8 triangles, points and normals>"


def test_estimated_normals_are_weighted_with_angles() -> None:
    # a box corner: three right angles, however its faces are cut, and however large they are
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [0, 2, 3], [0, 0, 3], [1, 0, 3.0]])
    faces = cut(np.array([[0, 3, 2, 1], [0, 5, 4, 3], [0, 1, 6, 5]]))
    for mesh in (HermiteMesh(points, faces), HermiteMesh(points, faces).flipped()):
        estimated = mesh.with_estimated_normals()
        assert estimated.normals_from == "estimated"
        assert estimated.normals is not None
        sign = -1 if mesh.faces[0, 0] == 0 else 1
        np.testing.assert_allclose(estimated.normals[0], sign * np.full(3, 3**-0.5), atol=1e-15)


@pytest.mark.parametrize("quads", [True, False])
def test_estimated_normals_converge_to_those_of_the_torus(quads: bool) -> None:
    errors = []
    for n in (12, 24, 48):
        points, faces = quad_grid(n, n, closed=True)
        mesh = HermiteMesh(points, faces if quads else cut(faces)).with_estimated_normals()
        ring = points * [1, 1, 0]
        exact = (points - 2 * ring / np.linalg.norm(ring, axis=1, keepdims=True)) / 0.7
        assert mesh.normals is not None
        errors.append(min(np.linalg.norm(mesh.normals - sign * exact, axis=1).max() for sign in (1, -1)))
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


def test_normals_that_cancel_are_not_estimated() -> None:
    mesh = HermiteMesh(np.eye(3), [[0, 1, 2], [0, 2, 1]])
    with pytest.raises(MeshError, match="no normal can be estimated at vertex 0"):
        mesh.with_estimated_normals()


def test_missing_data_are_said() -> None:
    mesh = HermiteMesh(*fan(3))
    with pytest.raises(ValueError, match="has no normals"):
        mesh.corner_normals()
    with pytest.raises(ValueError, match="has no second fundamental forms"):
        mesh.second_form(np.zeros((3, 3, 3)), np.zeros((3, 3, 3)))


@quick
@given(mesh_data())
def test_edge_data_are_the_data_at_the_ends(data: Data) -> None:
    mesh = testbed.HermiteMesh(**data)
    assume(mesh.normals is not None)
    ends = mesh.edge_data
    assert ends.n1 is not None
    assert ends.W0 is not None
    assert np.array_equal(ends.p0, data["points"][mesh.edges[:, 0]])
    assert np.array_equal(ends.n1, data["normals"][mesh.edges[:, 1]])
    assert np.array_equal(ends.W0, data["second_forms"][mesh.edges[:, 0]])
    assert mesh.h == pytest.approx(np.linalg.norm(ends.p1 - ends.p0, axis=1).max())
