"""Quadrilateral datasets: halving, samples at centres, parameters."""

import numpy as np
import pytest

from testbed import registry
from testbed.errors import Refused, SpecError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, cross, norm
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import MOST_FACES, straight
from testbed_datasets.quad_halving import halved_quads, quad_centres

QUADS = sorted(name for name in registry.catalogue(Dataset) if name.startswith("quad-"))  # type: ignore[type-abstract]
every_quad_dataset = pytest.mark.parametrize(
    "spec", [*QUADS, "quad-torus[twist=1]", "quad-torus[twist=-2]", "quad-sphere[crooked=0]", "quad-graph[crooked=1.5]"]
)


@every_quad_dataset
def test_faces_are_quadrilaterals_with_samples_at_their_centres(spec: str) -> None:
    dataset = registry.dataset(spec)
    for level in (0, 2):
        mesh = dataset.mesh(level)
        centres = mesh.face_data.centres
        assert mesh.sides == 4
        assert centres is not None
        assert dataset.surface is not None
        assert norm(dataset.surface.closest(centres.points) - centres.points).max() < 1e-14
        assert np.array_equal(dataset.surface.normal(centres.points), centres.normals)


@every_quad_dataset
def test_the_centres_of_a_level_are_vertices_of_the_next(spec: str) -> None:
    coarse, fine = (registry.dataset(spec).mesh(level) for level in (1, 2))
    assert coarse.face_data.centres is not None
    new = fine.points[len(coarse.points) + len(coarse.edges) :]
    assert norm(new - coarse.face_data.centres.points).max() < 1e-14
    # child 4 f + c starts at corner c and has the centre opposite
    assert np.array_equal(fine.faces[:, 0].reshape(-1, 4), coarse.faces)
    assert (fine.faces[:, 2].reshape(-1, 4) == fine.faces[:, 2].reshape(-1, 4)[:, :1]).all()


def test_halving_keeps_areas_orientation_and_places() -> None:
    points = np.array(
        [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [5.0, 4.0, 0.0], [1.0, 3.0, 0.0], [7.0, 1.0, 0.0], [8.0, 5.0, 0.0]]
    )
    faces = np.array([[0, 1, 2, 3], [1, 4, 5, 2]])
    finer, children = halved_quads(points, faces, 3, name="test", middle=straight)

    def areas(mesh: HermiteMesh) -> Float:
        a, b, c, d = np.moveaxis(mesh.corner_points(), 1, 0)
        return np.asarray(0.5 * cross(c - a, d - b)[:, 2])

    assert areas(HermiteMesh(finer, children)).min() > 0.0
    assert np.allclose(
        areas(HermiteMesh(finer, children)).reshape(2, 64).sum(axis=1), areas(HermiteMesh(points, faces))
    )
    assert len(finer) == len(np.unique(finer.round(12), axis=0))
    assert np.allclose(quad_centres(points, faces, straight), points[faces].mean(axis=1))


def test_halving_stops_before_memory_does() -> None:
    faces = np.array([[0, 1, 2, 3]] * 10)
    with pytest.raises(Refused, match="take a level up to 9"):
        halved_quads(np.eye(4), faces, 10, name="test", middle=straight)
    assert 10 * 4**9 <= MOST_FACES < 10 * 4**10


@pytest.mark.parametrize(
    ("spec", "vertices", "faces"), [("quad-torus", 50, 50), ("quad-sphere", 20, 12), ("quad-graph", 20, 12)]
)
def test_counts(spec: str, vertices: int, faces: int) -> None:
    mesh = registry.dataset(spec).mesh(0)
    assert (len(mesh.points), len(mesh.faces)) == (vertices, faces)


@pytest.mark.parametrize("twist", [0, 1, -2, 3])
def test_a_twisted_torus_is_one_closed_surface(twist: int) -> None:
    mesh = registry.dataset(f"quad-torus[twist={twist}]").mesh(1)
    assert not mesh.boundary_edges.any()
    assert (mesh.valence == 4).all()
    assert len(mesh.points) - len(mesh.edges) + len(mesh.faces) == 0


def test_symmetric_faces_are_mirror_images_and_twisted_ones_are_not() -> None:
    for twist, same in ((0, True), (1, False)):
        corners = registry.dataset(f"quad-torus[twist={twist}]").mesh(0).corner_points()
        diagonals = norm(corners[:, 2] - corners[:, 0]), norm(corners[:, 3] - corners[:, 1])
        assert np.allclose(*diagonals) == same


@pytest.mark.parametrize(
    ("spec", "parameter"),
    [
        ("quad-torus[minor=1]", "minor"),
        ("quad-torus[major=-1]", "major"),
        ("quad-torus[phase=1]", "phase"),
        ("quad-torus[twist=4]", "twist"),
        ("quad-sphere[radius=0]", "radius"),
        ("quad-sphere[crooked=-1]", "crooked"),
        ("quad-graph[crooked=2]", "crooked"),
    ],
)
def test_bad_parameters_are_named(spec: str, parameter: str) -> None:
    with pytest.raises(SpecError, match=f"^parameter {parameter} of {spec.partition('[')[0]} cannot be "):
        registry.dataset(spec)
