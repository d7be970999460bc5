"""One-to-four refinement of meshes: places of the pieces, and sizes."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused
from testbed.geometry.domain import CORNERS
from testbed.geometry.subdomains import to_face
from testbed_schemes.butterfly import Butterfly
from testbed_schemes.mathematics.triangle_subdivision import check_size, refined_places, triangulation


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
