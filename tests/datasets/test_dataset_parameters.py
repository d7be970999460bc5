"""Published meshes, phases, bad parameters and files."""

from pathlib import Path

import numpy as np
import pytest

from testbed import registry
from testbed.errors import MeshError, Refused, SpecError
from testbed.geometry.vectors import cross
from testbed_datasets.halving import MOST_FACES, halved, straight
from testbed_datasets.mesh_file import MeshFile
from testbed_datasets.torus import Torus


@pytest.mark.parametrize(
    ("spec", "level", "vertices", "faces"),
    [
        ("sphere", 0, 14, 24),
        ("torus", 0, 50, 100),
        ("octahedron", 0, 6, 8),
        ("octahedron", 1, 18, 32),
        ("icosahedron", 0, 12, 20),
        ("ellipsoid", 0, 6, 8),
        ("hyperboloid", 0, 18, 24),
        ("graph", 0, 20, 24),
        ("monkey-saddle", 0, 19, 24),
    ],
)
def test_counts(spec: str, level: int, vertices: int, faces: int) -> None:
    mesh = registry.dataset(spec).mesh(level)
    assert (len(mesh.points), len(mesh.faces)) == (vertices, faces)


def test_published_sphere_has_rings_at_thirty_degrees() -> None:
    latitude = np.degrees(np.arcsin(registry.dataset("sphere").mesh(0).points[:, 2]))
    assert np.allclose(np.sort(latitude), [-90.0, *6 * [-30.0], *6 * [30.0], 90.0])


def test_published_torus_has_a_row_on_the_outer_equator() -> None:
    points = Torus(phase=0.0).mesh(0).points
    equator = points[np.abs(points[:, 2]) < 1e-15]
    assert len(equator) == 10
    assert np.allclose(np.hypot(equator[:, 0], equator[:, 1]), 1.5)


def test_torus_rows_stay_off_the_top_circle_by_default_only() -> None:
    for level in range(5):
        rows = 72.0 / 2**level  # degrees

        def nearest(torus: Torus, level: int = level) -> float:
            points = torus.mesh(level).points
            tube = np.degrees(np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]) - 1.0))
            return float(np.abs(np.abs(tube) - 90.0).min())

        assert nearest(Torus()) > 0.099 * rows
        assert nearest(Torus(phase=0.0)) < 1e-9 or level < 2


@pytest.mark.parametrize(
    ("spec", "parameter"),
    [
        ("octahedron[radius=0]", "radius"),
        ("icosahedron[radius=-1]", "radius"),
        ("sphere[radius=-0.5]", "radius"),
        ("torus[minor=0]", "minor"),
        ("torus[minor=1]", "minor"),
        ("torus[major=0.4]", "minor"),
        ("torus[major=-2]", "major"),
        ("torus[phase=1]", "phase"),
        ("torus[phase=-0.1]", "phase"),
        ("ellipsoid[b=0]", "b"),
        ("hyperboloid[c=-1]", "c"),
        ("monkey-saddle[height=0]", "height"),
    ],
)
def test_bad_parameters_are_named(spec: str, parameter: str) -> None:
    with pytest.raises(SpecError, match=f"^parameter {parameter} of {spec.partition('[')[0]} cannot be "):
        registry.dataset(spec)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_parameters_are_finite(value: float) -> None:
    for name in ("major", "minor", "phase"):
        with pytest.raises(SpecError, match=name):
            Torus(**{name: value})


def test_halving_keeps_areas_orientation_and_places() -> None:
    points = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [5.0, 4.0, 0.0]])
    faces = np.array([[0, 1, 2], [2, 1, 3]])
    finer, children = halved(points, faces, 2, name="test", middle=straight)

    def areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
        a, b, c = np.moveaxis(points[faces], 1, 0)
        return 0.5 * cross(b - a, c - a)[:, 2]

    assert np.allclose(areas(finer, children).reshape(2, 16), areas(points, faces)[:, None] / 16.0, rtol=1e-14)
    centroids = finer[children].mean(axis=1).reshape(2, 16, 3).mean(axis=1)
    assert np.allclose(centroids, points[faces].mean(axis=1))
    assert len(finer) == len(np.unique(finer, axis=0))  # an edge's middle is one vertex, seen from both faces


def test_halving_stops_before_memory_does() -> None:
    with pytest.raises(Refused, match="take a level up to 9"):
        halved(np.eye(3), np.array([[0, 1, 2], [0, 2, 1]] * 5), 10, name="test", middle=straight)
    assert 10 * 4**9 <= MOST_FACES < 10 * 4**10


def test_a_mesh_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "part.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    dataset = registry.dataset(f"mesh:{path}")
    assert dataset == MeshFile(str(path))
    assert dataset.surface is None
    mesh = dataset.mesh(0)
    assert len(mesh.faces) == 4
    assert mesh.normals is not None
    assert mesh.second_forms is None
    with pytest.raises(Refused, match="level 0 only"):
        dataset.mesh(1)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"missing\.obj"):
        MeshFile(str(tmp_path / "missing.obj")).mesh(0)


def test_without_a_path_there_is_an_example_mesh() -> None:
    mesh = MeshFile().mesh(0)
    assert (len(mesh.points), len(mesh.faces), mesh.normals_from) == (162, 320, "estimated")
    assert not mesh.boundary_edges.any()
    assert str(MeshFile()) == "mesh"
    with pytest.raises(Refused, match="level 0 only"):
        MeshFile().mesh(1)
