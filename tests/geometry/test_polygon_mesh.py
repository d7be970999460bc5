"""Meshes of polygons: how corners hang together, what is refused, OBJ files."""

from pathlib import Path

import numpy as np
import pytest
from control_meshes import antiprism, cuboctahedron, grid

from testbed.errors import MeshError
from testbed.geometry.polygon_mesh import PolygonMesh, load_polygons

PENTAGON = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.0]])


@pytest.mark.parametrize("mesh", [antiprism(3), antiprism(7), cuboctahedron(), grid()])
def test_corners_hang_together(mesh: PolygonMesh) -> None:
    corners = np.arange(len(mesh.vertex))
    assert np.array_equal(mesh.previous[mesh.following], corners)
    assert np.array_equal(mesh.face[mesh.following], mesh.face)
    assert [mesh.vertex[mesh.face == face].tolist() for face in range(len(mesh.faces))] == list(map(list, mesh.faces))
    assert np.array_equal(mesh.sizes, [len(face) for face in mesh.faces])
    inner = mesh.twin >= 0
    assert np.array_equal(mesh.twin[mesh.twin[inner]], corners[inner])
    assert np.array_equal(mesh.vertex[mesh.twin[inner]], mesh.vertex[mesh.following[inner]])
    assert (mesh.valence[mesh.inside] == 4).all()
    assert mesh.inside.all() == inner.all()


def test_points_and_corners_cannot_be_changed() -> None:
    mesh = grid()
    for array in (mesh.points, mesh.vertex, mesh.twin):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("faces", "text"),
    [
        ([], "has no faces"),
        ([[0, 1, 2, 3], [1, 4]], "face 1 has 2 vertices"),
        ([[0, 1, 2, 3], [1, 5, 2]], "face 1 has vertex 5, but the vertices are 0 to 4"),
        ([[0, 1, 2, 3], [1, 4, 2, 4]], "face 1 has vertex 4 more than once"),
        ([[0, 1, 2, 3]], "vertex 4 is in no face"),
        ([[0, 1, 2, 3], [1, 2, 4]], "between vertices 1 and 2.*same direction"),
        ([[0, 1, 2, 3], [1, 4, 2], [2, 1, 3]], "between vertices 1 and 2, a side of faces 0, 1, 2, is not manifold"),
        ([[0, 1, 3], [1, 4, 2]], "vertex 1 is not manifold"),
    ],
)
def test_what_is_no_manifold_is_refused(faces: list[list[int]], text: str) -> None:
    with pytest.raises(MeshError, match=text) as caught:
        PolygonMesh(PENTAGON, faces)
    assert "\n" not in str(caught.value)


def test_a_file_is_read_with_its_polygons(tmp_path: Path) -> None:
    path = tmp_path / "mesh.obj"
    lines = ["# a square and a triangle", "o thing", *(f"v {x} {y} {z}" for x, y, z in PENTAGON), "vn 0 0 1"]
    path.write_text("\n".join([*lines, "f 1 2 3 4  # square", "f -4/1/1 -1//1 -3/7"]))
    mesh = load_polygons(path)
    assert np.array_equal(mesh.points, PENTAGON)
    assert mesh.faces == ((0, 1, 2, 3), (1, 4, 2))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0\n", "line 1 is no vertex or face"),
        ("v 0 0 0\nf 1 two 3\n", "line 2 is no vertex or face: 'f 1 two 3'"),
        ("v 0 0 0\n", "holds no faces"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "face 0 has vertex 3"),
        ("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "at vertex 2"),
    ],
)
def test_bad_files_are_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.obj"
    path.write_text(text)
    with pytest.raises(MeshError, match=message) as caught:
        load_polygons(path)
    assert str(caught.value).startswith(str(path))
    with pytest.raises(MeshError, match=r"missing\.obj cannot be read"):
        load_polygons(tmp_path / "missing.obj")
