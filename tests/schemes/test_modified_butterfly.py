"""The modified butterfly: its weights at irregular vertices and at boundaries, and the smoothness of its limit.

What it shares with the butterfly is tested with that.
"""

import numpy as np
import pytest
from spoked_meshes import lattice, turns_at_the_hub

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.triangulation import Triangulation
from testbed.geometry.vectors import norm
from testbed_schemes import modified_butterfly
from testbed_schemes.mathematics.triangle_subdivision import triangulation
from testbed_schemes.modified_butterfly import ModifiedButterfly


def test_the_rule_at_a_corner_is_linear_too() -> None:
    places, triangles = lattice(3, 3)
    faces = Triangulation(triangles, len(places))
    points = np.concatenate([places, places @ np.array([[0.7], [-0.4]])], axis=1)
    # the edge that cuts off the corner 0: between vertices 1 and 4, both with three faces
    edge = int(np.nonzero((faces.edges == [1, 4]).all(axis=1))[0][0])
    assert norm(modified_butterfly.edge_vertices(faces, points)[edge] - points[[1, 4]].mean(axis=0)) < 1e-14


@pytest.mark.parametrize("faces", range(2, 9))
def test_boundary_weights_sum_to_one_keep_planes_and_read_the_same_from_both_ends(faces: int) -> None:
    own, ring = modified_butterfly.boundary_weights(faces)
    angle = np.pi * np.arange(faces + 1) / faces
    inner = slice(1, faces)
    assert np.allclose((own + ring.sum(axis=1))[inner], 1.0, atol=1e-14)
    assert np.allclose((ring @ np.cos(angle))[inner], 0.5 * np.cos(angle[inner]), atol=1e-14)
    assert np.allclose((ring @ np.sin(angle))[inner], 0.5 * np.sin(angle[inner]), atol=1e-14)
    assert np.allclose(ring[inner], ring[::-1, ::-1][inner], atol=1e-14)


@pytest.mark.parametrize("valence", range(3, 13))
def test_inner_weights_sum_to_a_quarter_and_keep_planes(valence: int) -> None:
    weights = modified_butterfly.inner_weights(valence)
    turn = 2.0 * np.pi * np.arange(valence) / valence
    assert weights.sum() == pytest.approx(0.25, abs=1e-15)
    assert weights @ np.cos(turn) == pytest.approx(0.5, abs=1e-15)
    assert weights @ np.sin(turn) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("valence", [3, 4, 5, 7, 8, 12])
def test_the_limit_of_the_modified_butterfly_is_smooth_at_every_valence(valence: int) -> None:
    turns = turns_at_the_hub(ModifiedButterfly, valence)
    assert turns[-1] < 0.35 * turns[0]


def test_faces_back_to_back_are_refused_by_the_modified_butterfly() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    mesh = HermiteMesh(points, [[0, 1, 2], [0, 2, 1]])
    assert (triangulation(mesh).face_count == 2).all()
    with pytest.raises(Refused, match="vertex 0, where two faces lie back to back"):
        ModifiedButterfly().fit(mesh)
