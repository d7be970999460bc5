"""Chords projected onto tangent planes: what they are parallel to, and that projected faces do not overlap."""

import numpy as np
import pytest

from testbed.conformance.meshes import cases, fan, graph, octahedron
from testbed.geometry.cone_axes import face_normals
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, cross, dot, norm
from testbed_schemes.mathematics.vertex_tangents import LEAST, project, projections

ZOO = [case.mesh for case in cases(3)]
UP = np.array([0.0, 0.0, 1.0])


def rough(seed: int) -> HermiteMesh:
    """Random heights, each vertex with the normal of a face at it: other faces are steep against that."""
    x, y, faces = fan()
    points = np.stack([x, y, np.random.default_rng(seed).uniform(0.0, 1.5, len(x))], axis=-1)
    of_faces, _ = face_normals(points, faces)
    normals = np.empty_like(points)
    normals[faces] = of_faces[:, None]
    return HermiteMesh(points, faces, normals)


STEEP = [rough(seed) for seed in range(5)]


def normals_of(mesh: HermiteMesh) -> Float:
    """Return the normals of a mesh that has them."""
    assert mesh.normals is not None
    return mesh.normals


def tangents(mesh: HermiteMesh, directions: Float) -> tuple[Float, Float]:
    """Tangents (F, 3, 3) at the corners of faces, to the next corner and to the previous one."""
    corners, normals, h = mesh.corner_points(), mesh.corner_normals(), directions[mesh.faces]
    onward, back = (project(np.roll(corners, shift, axis=1) - corners, normals, h) for shift in (-1, 1))
    return onward, back


def turning(mesh: HermiteMesh, directions: Float) -> Float:
    """(F, 3) how projected faces turn about the normals, relative to the squares of their sides."""
    onward, back = tangents(mesh, directions)
    return np.asarray(dot(cross(onward, back), mesh.corner_normals()) / (norm(onward) * norm(back)))


@pytest.mark.parametrize("mesh", [*ZOO, *STEEP])
@pytest.mark.parametrize("along", [None, UP])
def test_tangents_lie_in_the_tangent_planes_and_faces_do_not_overlap(mesh: HermiteMesh, along: Float | None) -> None:
    directions, _ = projections(mesh.points, mesh.faces, normals_of(mesh), along)
    for vectors in tangents(mesh, directions):
        assert np.abs(dot(vectors, mesh.corner_normals()) / norm(vectors)).max() < 1e-13
    assert turning(mesh, directions).min() > 0.0


def test_orthogonal_projection_as_printed_overlaps_on_steep_data() -> None:
    for mesh in STEEP:
        assert turning(mesh, normals_of(mesh)).min() < 0.0
        _, replaced = projections(mesh.points, mesh.faces, normals_of(mesh))
        assert 0 < replaced.sum() < 20


def test_the_normal_is_kept_where_all_faces_are_seen_from_it() -> None:
    for mesh in ZOO:
        directions, replaced = projections(mesh.points, mesh.faces, normals_of(mesh))
        assert np.array_equal(directions, normals_of(mesh))
        assert not replaced.any()


def test_projections_along_a_direction_keep_the_place_in_the_plane() -> None:
    mesh = graph(*fan())
    directions, replaced = projections(mesh.points, mesh.faces, normals_of(mesh), UP)
    assert not replaced.any()
    onward, _ = tangents(mesh, directions)
    chords = np.roll(mesh.corner_points(), -1, axis=1) - mesh.corner_points()
    assert onward[..., :2] == pytest.approx(chords[..., :2], abs=1e-15)


def test_a_direction_is_replaced_where_it_does_not_see_all_faces() -> None:
    mesh = octahedron()
    directions, replaced = projections(mesh.points, mesh.faces, normals_of(mesh), UP)
    assert replaced.tolist() == [True, True, True, True, False, False]
    assert np.array_equal(directions[:4], normals_of(mesh)[:4])
    assert np.abs(directions[4:]) == pytest.approx(np.stack([UP, UP]), abs=0.0)


def test_the_direction_itself_may_point_to_either_side() -> None:
    mesh = graph(*fan())
    up, down = (projections(mesh.points, mesh.faces, normals_of(mesh), sign * UP)[0] for sign in (1.0, -1.0))
    assert np.array_equal(up, -down)
    assert turning(mesh, down) == pytest.approx(turning(mesh, up), abs=1e-15)


def test_normals_that_are_turned_over_stay() -> None:
    """Faces overlap about no direction; that they turn the other way is for the scheme to tell."""
    mesh = octahedron()
    directions, replaced = projections(mesh.points, mesh.faces, -normals_of(mesh))
    assert np.array_equal(directions, -normals_of(mesh))
    assert replaced.all()


def test_directions_turn_with_the_data_where_they_are_replaced() -> None:
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    for mesh in STEEP:
        moved = mesh.transformed(turn, [0.3, 0.1, -0.2], 2.0)
        expected, _ = projections(mesh.points, mesh.faces, normals_of(mesh))
        found, replaced = projections(moved.points, moved.faces, normals_of(moved))
        assert found == pytest.approx(expected @ turn.T, abs=1e-12)
        assert replaced.any()


def test_replaced_directions_are_not_nearly_in_a_face() -> None:
    for mesh in STEEP:
        directions, replaced = projections(mesh.points, mesh.faces, normals_of(mesh))
        assert dot(directions, normals_of(mesh))[replaced].min() > LEAST  # with their own normals, too
