"""Gradients at the vertices: normals whose lengths matter."""

from pathlib import Path

import numpy as np
import pytest

import testbed
from testbed.errors import MeshError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, norm, unit

POINTS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
GRADIENTS = np.array([[2.0, 0.0, 0.1], [0.0, 3.0, 0.2], [0.3, 0.0, 4.0]])


def close(found: Float | None, expected: Float | None) -> None:
    assert found is not None
    assert expected is not None
    np.testing.assert_allclose(found, expected, rtol=1e-15, atol=1e-15)


def mesh() -> HermiteMesh:
    return HermiteMesh(POINTS, [[0, 1, 2]], gradients=GRADIENTS)


def test_gradients_give_the_normals_and_keep_their_lengths() -> None:
    np.testing.assert_array_equal(mesh().gradients, GRADIENTS)
    close(mesh().normals, unit(GRADIENTS))


def test_operations_carry_them() -> None:
    data = mesh()
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    close(data.transformed(turn, (1, 2, 3), 4.0).gradients, GRADIENTS @ turn.T / 4.0)
    np.testing.assert_array_equal(data.flipped().gradients, -GRADIENTS)
    order = np.array([2, 0, 1])
    np.testing.assert_array_equal(data.relabelled(order).gradients, GRADIENTS[order])
    np.testing.assert_array_equal(data.rotated_corners().gradients, GRADIENTS)
    assert data.without_normals().gradients is None
    assert data.with_estimated_normals().gradients is None


def test_files_keep_them(tmp_path: Path) -> None:
    stored = testbed.load_mesh(testbed.save_mesh(mesh(), tmp_path / "mesh.npz"))
    np.testing.assert_array_equal(stored.gradients, GRADIENTS)


@pytest.mark.parametrize(
    ("gradients", "sentence"),
    [
        (GRADIENTS[[1, 0, 2]], "the gradient at vertex 0 does not have the direction of the normal"),
        (np.where(np.eye(3) > 0, np.nan, GRADIENTS), "the gradients hold .* at vertex 0"),
        (GRADIENTS * [[1], [0], [1]], "the gradient at vertex 1 is zero"),
        (GRADIENTS[:2], "there are 2 gradients for 3 vertices"),
    ],
)
def test_bad_gradients_are_refused(gradients: np.ndarray, sentence: str) -> None:
    with pytest.raises(MeshError, match=sentence):
        HermiteMesh(POINTS, [[0, 1, 2]], unit(GRADIENTS), gradients=gradients)


@pytest.mark.parametrize("name", ["ellipsoid", "hyperboloid", "graph"])
def test_level_sets_sample_the_gradients_of_their_functions(name: str) -> None:
    sampled = testbed.dataset(name).mesh(1)
    assert sampled.gradients is not None
    assert np.ptp(norm(sampled.gradients)) > 0.1
    close(unit(sampled.gradients), sampled.normals)
