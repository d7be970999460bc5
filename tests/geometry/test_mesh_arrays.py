"""Meshes in NPZ files come back bit for bit, with all their data; other arrays are refused with the file's name."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_face_data import full_mesh

import testbed
from testbed.errors import MeshError
from testbed.geometry.mesh_arrays import mesh_arrays, mesh_of_arrays


def test_a_mesh_comes_back_bit_for_bit_with_all_its_data(tmp_path: Path) -> None:
    mesh = full_mesh()
    path = testbed.save_mesh(mesh, tmp_path / "whole.npz")
    read = mesh_arrays(testbed.load_mesh(path))
    assert list(read) == list(mesh_arrays(mesh))
    assert len(read) == 9
    for name, array in mesh_arrays(mesh).items():
        assert np.array_equal(read[name], array, equal_nan=name == "side_tangents")


def test_a_mesh_of_quadrilaterals_and_bare_points_too(tmp_path: Path) -> None:
    quads = testbed.HermiteMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]], [[0, 1, 2, 3]])
    path = testbed.save_mesh(quads, tmp_path / "bare.npz")
    read = testbed.load_mesh(path)
    assert read.sides == 4
    assert read.normals_from == "estimated"
    with pytest.raises(MeshError, match=r"bare\.npz.*no vertex normals"):
        testbed.load_mesh(path, normals="file")


def test_it_is_a_dataset_that_schemes_with_second_forms_take(tmp_path: Path) -> None:
    mesh = testbed.dataset("octahedron").mesh(0)
    path = testbed.save_mesh(mesh, tmp_path / "octahedron.npz")
    again = testbed.dataset(f"mesh:{path}").mesh(0)
    scheme, at = testbed.scheme("cubic-interpolant"), np.array([[0.2, 0.3]])
    for one, other in zip(scheme.fit(again).batches, scheme.fit(mesh).batches, strict=True):
        assert np.array_equal(one.jets(at).coefficients, other.jets(at).coefficients)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": None}, "no array points"),
        ({"centre_normals": None}, "centre_points alone"),
        ({"faces": np.array([[0, 1, 9]])}, "9"),
        ({"points": np.full((5, 3), np.nan)}, "nan"),
        ({"points": np.array(["a"])}, "points"),
    ],
)
def test_other_arrays_are_refused_with_the_name_of_the_file(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    arrays = {**mesh_arrays(full_mesh()), **change}
    path = tmp_path / "wrong.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(MeshError, match=rf"wrong\.npz: .*{message}") as caught:
        testbed.load_mesh(path)
    assert "\n" not in str(caught.value)


def test_files_that_are_no_arrays_are_refused(tmp_path: Path) -> None:
    broken = tmp_path / "broken.npz"
    testbed.save_mesh(full_mesh(), broken)
    whole = broken.read_bytes()
    single = io.BytesIO()
    np.save(single, np.eye(3))
    for content in (b"", b"PK not really", whole[: len(whole) // 2], single.getvalue()):
        broken.write_bytes(content)
        with pytest.raises(MeshError, match=r"broken\.npz cannot be read"):
            testbed.load_mesh(broken)
    np.savez(broken, points=np.array([{}], dtype=object), faces=np.array([[0, 1, 2]]))  # a pickle is never opened
    with pytest.raises(MeshError, match=r"broken\.npz cannot be read"):
        testbed.load_mesh(broken)
    with pytest.raises(MeshError, match="does not exist"):
        testbed.load_mesh(tmp_path / "absent.npz")


def test_another_suffix_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"does not end in \.npz"):
        testbed.save_mesh(full_mesh(), tmp_path / "mesh.ply")
    with pytest.raises(MeshError, match="cannot be written"):
        testbed.save_mesh(full_mesh(), tmp_path / "nowhere" / "mesh.npz")


def test_arrays_of_other_names_are_passed_over() -> None:
    assert mesh_of_arrays({**mesh_arrays(full_mesh()), "face_levels": np.zeros(4)}).face_data.centres is not None
