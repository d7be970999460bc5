"""Triangulations: incidence, rings, one-to-four refinement."""

import numpy as np
import pytest

from testbed import registry
from testbed.geometry.triangulation import Triangulation, following, preceding

MESHES = ["octahedron", "torus", "graph", "monkey-saddle"]


def faces_of(name: str) -> Triangulation:
    mesh = registry.dataset(name).mesh(0)
    return Triangulation(mesh.faces, len(mesh.points))


@pytest.mark.parametrize("name", MESHES)
def test_twins_run_the_other_way_and_turning_there_and_back_returns(name: str) -> None:
    faces = faces_of(name)
    half_edge = np.arange(faces.faces.size)
    inner = faces.twin >= 0
    twin = faces.twin[inner]
    assert (faces.twin[twin] == half_edge[inner]).all()
    assert (faces.start[twin] == faces.end[inner]).all()
    assert (following(preceding(half_edge)) == half_edge).all()
    assert (faces.apex == faces.end[following(half_edge)]).all()
    turned = faces.counterclockwise(half_edge)
    assert (faces.clockwise(turned[turned >= 0]) == half_edge[turned >= 0]).all()
    assert (faces.start[turned[turned >= 0]] == faces.start[turned >= 0]).all()


@pytest.mark.parametrize("name", MESHES)
def test_rings_hold_every_neighbour_once(name: str) -> None:
    faces = faces_of(name)
    for bounded in (False, True):
        for count in np.unique(faces.face_count[faces.on_boundary == bounded]).tolist():
            (vertices,) = np.nonzero((faces.on_boundary == bounded) & (faces.face_count == count))
            ring = faces.ring(faces.outgoing[vertices], count + bounded)
            for vertex, neighbours in zip(vertices.tolist(), ring.tolist(), strict=True):
                beside = faces.edges[(faces.edges == vertex).any(axis=1)]
                assert sorted(neighbours) == sorted(beside[beside != vertex].tolist())


@pytest.mark.parametrize("name", MESHES)
def test_a_step_keeps_the_manifold_and_makes_regular_vertices(name: str) -> None:
    faces = faces_of(name)
    finer = faces.refined()
    assert len(finer.faces) == 4 * len(faces.faces)
    assert finer.vertices == faces.vertices + len(faces.edges)
    assert (finer.face_count[: faces.vertices] == faces.face_count).all()
    assert (finer.on_boundary[: faces.vertices] == faces.on_boundary).all()
    new = np.arange(faces.vertices, finer.vertices)
    assert (finer.face_count[new] == np.where(finer.on_boundary[new], 3, 6)).all()
    assert finer.on_boundary.sum() == 2 * faces.on_boundary.sum()
