"""The jug: a closed nested mesh of genus 1 that crosses nothing, with flat, egg-shaped and saddle-shaped parts."""

from itertools import pairwise

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.loop_subdivision import limit_points, subdivided
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import Bool, Float, angle_between, cross, dot, norm, unit
from testbed_datasets.jug import Jug, control_mesh

LEVELS = [Jug().mesh(level) for level in range(4)]


def facet_normals(mesh: HermiteMesh) -> Float:
    corners = mesh.corner_points()
    return unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


@pytest.mark.parametrize("level", range(4))
def test_it_is_closed_and_has_one_handle(level: int) -> None:
    mesh = LEVELS[level]
    assert len(mesh.faces) == 280 * 4**level
    assert not mesh.boundary_edges.any()
    assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == 0
    corners = mesh.corner_points()
    assert dot(corners[:, 0], cross(corners[:, 1], corners[:, 2])).sum() / 6.0 > 3.5  # faces outwards


def test_levels_are_nested_and_normals_stay() -> None:
    for coarse, fine in pairwise(LEVELS):
        count = len(coarse.points)
        assert norm(fine.points[:count] - coarse.points).max() < 1e-14
        assert coarse.normals is not None
        assert fine.normals is not None
        assert norm(fine.normals[:count] - coarse.normals).max() < 1e-13
        assert coarse.h / fine.h == pytest.approx(1.9, abs=0.1)


def test_vertices_are_limits_of_subdivision() -> None:
    points, faces = control_mesh()
    triangles = Triangulation(faces, len(points))
    for _ in range(4):
        points, triangles = subdivided(triangles, points), triangles.refined()
    # a vertex tends to its limit as 4^-k
    away = norm(points[: len(LEVELS[0].points)] - LEVELS[0].points).max()
    assert 1e-5 < away < 2e-3
    assert norm(limit_points(triangles, points)[: len(LEVELS[0].points)] - LEVELS[0].points).max() < 1e-14


def test_normals_are_those_that_facets_tend_to() -> None:
    angles = []
    for mesh in LEVELS:
        assert mesh.normals is not None
        angles.append(angle_between(facet_normals(mesh)[:, None], mesh.normals[mesh.faces]).max())
    assert np.degrees(angles[0]) < 82.0  # on the outer side of every face
    for coarse, fine in pairwise(angles):
        assert fine < 0.8 * coarse


def test_it_has_flat_faces_convex_edges_and_others() -> None:
    mesh = LEVELS[2]
    assert mesh.normals is not None
    start, end = mesh.edges.T
    along = mesh.points[end] - mesh.points[start]
    rises = np.stack([dot(along, mesh.normals[end]), -dot(along, mesh.normals[start])]) / norm(along)
    flat: Bool = np.all(np.abs(rises) < 1e-12, axis=0)
    bottom = mesh.faces[np.all(flat[mesh.face_edges], axis=1)]
    assert len(bottom) == 9 * 16  # the bottom's middle, in its plane exactly
    assert np.array_equal(np.unique(mesh.points[bottom][..., 2]), [0.0])
    convex: Bool = np.all(rises > 1e-9, axis=0)
    concave: Bool = np.all(rises < -1e-9, axis=0)
    assert min(convex.sum(), concave.sum()) > 1000
    saddles = np.any(convex[mesh.face_edges], axis=1) & np.any(concave[mesh.face_edges], axis=1)
    assert saddles.sum() > 500


def test_triangles_are_uneven_and_none_is_a_sliver() -> None:
    for mesh in LEVELS:
        corners = mesh.corner_points()
        angles = np.degrees(angle_between(np.roll(corners, -1, 1) - corners, np.roll(corners, 1, 1) - corners))
        assert 13.0 < angles.min() < 20.0
        assert mesh.h / norm(corners[:, 1] - corners[:, 0]).min() > 3.0
        assert np.unique(mesh.valence).tolist() == [5, 6, 7, 8, 9]


@pytest.mark.parametrize("level", [0, 1])
def test_it_does_not_cross_itself(level: int) -> None:
    mesh = LEVELS[level]
    a, b, c = np.moveaxis(mesh.corner_points(), 1, 0)
    for chunk in np.array_split(mesh.edges, 8):
        p, q = mesh.points[chunk[:, 0]][:, None], mesh.points[chunk[:, 1]][:, None]
        beside = (chunk[:, None, :, None] == mesh.faces[None, :, None, :]).any(axis=(2, 3))
        ends = [np.sign(dot(x - a, cross(b - a, c - a))) for x in (p, q)]
        turns = [np.sign(dot(q - p, cross(u - p, v - p))) for u, v in ((a, b), (b, c), (c, a))]
        through = (ends[0] != ends[1]) & (turns[0] == turns[1]) & (turns[1] == turns[2])
        assert not (through & ~beside).any()


def test_it_is_the_same_every_time_and_has_no_exact_surface() -> None:
    jug = registry.dataset("jug")
    again = jug.mesh(1)
    assert np.array_equal(again.points, LEVELS[1].points)
    assert np.array_equal(again.faces, LEVELS[1].faces)
    assert again.second_forms is None
    assert jug.surface is None


@pytest.mark.parametrize("level", [-1, 12])
def test_levels_that_do_not_exist_are_refused_by_the_jug(level: int) -> None:
    with pytest.raises(Refused, match=f"{level}"):
        Jug().mesh(level)
