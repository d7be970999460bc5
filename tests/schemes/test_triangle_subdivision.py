"""One-to-four refinement: incidence, rings, places of the pieces."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.domain import CORNERS
from testbed.geometry.subdomains import to_face
from testbed_schemes.butterfly import Butterfly
from testbed_schemes.mathematics.triangle_subdivision import (
    Triangulation,
    check_size,
    following,
    preceding,
    refined_places,
    triangulation,
)

MESHES = ["octahedron", "torus", "graph", "monkey-saddle"]


def faces_of(name: str) -> Triangulation:
    return triangulation(registry.dataset(name).mesh(0))


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


def test_places_are_where_the_corners_are() -> None:
    mesh = registry.dataset("graph").mesh(0)
    faces, points = triangulation(mesh), mesh.points
    places = np.broadcast_to(CORNERS[3], (len(mesh.faces), 3, 2))
    for _ in range(2):
        points = np.concatenate([points, points[faces.edges].mean(axis=1)])
        faces, places = faces.refined(), refined_places(places)
    origin = np.repeat(np.arange(len(mesh.faces)), 16)
    barycentric = np.concatenate([1.0 - places.sum(axis=-1, keepdims=True), places], axis=-1)
    expected = np.einsum("fci,fid->fcd", barycentric, mesh.corner_points()[origin])
    assert np.abs(points[faces.faces] - expected).max() < 1e-15
    assert np.allclose(to_face(places, np.full((len(places), 2), 1.0 / 3.0)), places.mean(axis=1))


def test_too_many_pieces_are_refused_with_both_numbers() -> None:
    check_size(Butterfly(), 100, 3, 6400)
    with pytest.raises(Refused, match="makes 6400 triangles of a mesh of 100, more than the 6399"):
        check_size(Butterfly(), 100, 3, 6399)
