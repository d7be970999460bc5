"""Files of all formats give the mesh that was written; what is wrong with a file is said in one sentence."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hostile_meshes import cut, quad_grid

import testbed
from testbed.errors import MeshError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_files import load_mesh
from testbed.geometry.vectors import Float, Int

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TILTED = "vn 0 0 1\nvn 0.6 0 0.8\n"


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def ply(vertices: list[str], faces: list[str], normals: bool = False) -> str:
    columns = ["x", "y", "z", *(["nx", "ny", "nz"] if normals else [])]
    head = [
        "ply",
        "format ascii 1.0",
        f"element vertex {len(vertices)}",
        *(f"property float {name}" for name in columns),
    ]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join([*head, *vertices, *faces]) + "\n"


def torus() -> tuple[Any, Any, Float]:
    """A torus without normals, and one with normals that are not those that would be estimated."""
    points, faces = quad_grid(7, 6, closed=True)
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    bare, solid = (trimesh.Trimesh(points, cut(faces), vertex_normals=n, process=False) for n in (None, normals))
    return bare, solid, normals


def matched(mesh: HermiteMesh, points: Float) -> Int:
    """For each of the points, the vertex of the mesh that is there."""
    distance = np.linalg.norm(mesh.points[None] - points[:, None], axis=-1)
    vertex: Int = distance.argmin(axis=1)
    assert distance.min(axis=1).max() < 1e-6
    assert len(np.unique(vertex)) == len(points) == len(mesh.points)
    return vertex


@pytest.mark.parametrize("name", ["t.ply", "t.obj", "t.stl", "t.off", "t.glb", "t.STL"])
def test_meshes_of_all_formats_come_back_whole(tmp_path: Path, name: str) -> None:
    solid, _, _ = torus()
    solid.export(tmp_path / name, file_type=name[-3:].lower())
    mesh = testbed.load_mesh(str(tmp_path / name))
    vertex = matched(mesh, solid.vertices)
    assert {tuple(sorted(f)) for f in mesh.faces.tolist()} == {tuple(sorted(f)) for f in vertex[solid.faces].tolist()}
    assert not mesh.boundary_edges.any()
    assert mesh.normals_from == "estimated"
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals[vertex], solid.vertex_normals, atol=0.2)


@pytest.mark.parametrize("name", ["t.ply", "t.obj", "t.glb"])
def test_normals_in_the_file_are_kept(tmp_path: Path, name: str) -> None:
    _, solid, normals = torus()
    solid.export(tmp_path / name, **{"vertex_normal" if name == "t.ply" else "include_normals": True})
    mesh = load_mesh(tmp_path / name)
    assert mesh.normals_from == "file"
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals[matched(mesh, solid.vertices)], normals, atol=1e-6)
    estimated = load_mesh(tmp_path / name, normals="estimated")
    assert estimated.normals_from == "estimated"
    assert estimated.normals is not None
    assert np.abs(estimated.normals - mesh.normals).max() > 0.5


def test_a_file_without_merged_vertices_keeps_their_order(tmp_path: Path) -> None:
    path = written(tmp_path, "a.ply", ply(["0 0 -0.0", "1 0 0", "0 1 0.125"], ["3 2 0 1"]))
    mesh = load_mesh(path)
    assert mesh.points.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0.125]]
    assert mesh.faces.tolist() == [[2, 0, 1]]


@pytest.mark.parametrize("name", ["q.obj", "q.ply", "q.off"])
def test_quadrilaterals_become_triangles(tmp_path: Path, name: str) -> None:
    corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"]
    text = {
        "q.obj": SQUARE + "f 1 2 3 4\n",
        "q.ply": ply(corners, ["4 0 1 2 3"]),
        "q.off": "\n".join(["OFF", "4 1 0", *corners, "4 0 1 2 3"]) + "\n",
    }
    mesh = load_mesh(written(tmp_path, name, text[name]))
    assert mesh.faces.shape == (2, 3)
    assert mesh.normals is not None
    assert mesh.normals.tolist() == [[0, 0, 1]] * 4


def test_vertices_split_by_texture_are_one(tmp_path: Path) -> None:
    texture = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n"
    mesh = load_mesh(written(tmp_path, "t.obj", SQUARE + texture + "f 1/1 2/2 3/3\nf 1/5 3/5 4/4\n"))
    assert len(mesh.points) == 4
    assert len(mesh.edges) == 5


def test_normals_at_one_position_are_averaged(tmp_path: Path) -> None:
    mild = "vn 0 0.1 1\nvn 0 -0.1 1\n"
    mesh = load_mesh(written(tmp_path, "n.obj", SQUARE + mild + "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n"))
    assert mesh.normals_from == "file"
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals[np.array([0, 2])], [[0, 0, 1], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(mesh.normals[1], np.array([0, 0.1, 1]) / np.hypot(0.1, 1), atol=1e-9)


def test_normals_across_a_crease_are_not_averaged(tmp_path: Path) -> None:
    crease = "vn 0 1 0\nvn 0 0 1\n"
    path = written(tmp_path, "n.obj", SQUARE + crease + "f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n")
    mesh = load_mesh(path)
    assert mesh.normals_from == "estimated"
    assert mesh.normals is not None
    np.testing.assert_allclose(mesh.normals, [[0, 0, 1]] * 4, atol=1e-15)
    with pytest.raises(
        MeshError, match=r"n\.obj: the normals at vertex 0 are up to 45 degrees from their mean, a crease"
    ):
        load_mesh(path, normals="file")


def test_asking_for_normals_that_a_file_does_not_have_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "a.obj", SQUARE + "f 1 2 3\nf 1 3 4\n")
    with pytest.raises(MeshError, match=r"a\.obj: the file has no vertex normals"):
        load_mesh(path, normals="file")


def test_a_scene_is_put_together_with_its_transforms(tmp_path: Path) -> None:
    _, solid, _ = torus()
    scene: Any = trimesh.Scene()
    scene.add_geometry(solid, transform=np.diag([1.0, 2.0, 0.5, 1.0]))
    mirrored = np.diag([-1.0, 1.0, 1.0, 1.0])
    mirrored[0, 3] = 10
    scene.add_geometry(solid, transform=mirrored)
    scene.export(tmp_path / "s.glb", include_normals=True)
    mesh = load_mesh(tmp_path / "s.glb")
    count = len(solid.vertices)
    assert len(mesh.points) == 2 * count
    matched(mesh, np.concatenate([solid.vertices * [1, 2, 0.5], [10, 0, 0] + solid.vertices * [-1, 1, 1]]))
    stretched, mirror = mesh.points[:, 0] < 5, mesh.points[:, 0] > 5
    assert mesh.normals is not None
    # the gradients of |x|^2 before the stretch, of |x|^2 before the mirror
    inward = mesh.points[stretched] / np.array([1, 2, 0.5]) ** 2
    expected = inward / np.linalg.norm(inward, axis=1, keepdims=True)
    np.testing.assert_allclose(mesh.normals[stretched], expected, atol=1e-6)
    outward = mesh.points[mirror] - [10, 0, 0]
    expected = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    np.testing.assert_allclose(mesh.normals[mirror], expected, atol=1e-6)
    volumes = [
        np.linalg.det(mesh.corner_points()[(mirror if side else stretched)[mesh.faces[:, 0]]]).sum() for side in (0, 1)
    ]
    assert volumes[0] * volumes[1] > 0, "mirrored faces run the other way, so that the outside stays outside"


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("index.ply", ply(["0 0 0", "1 0 0", "0 1 0"], ["3 0 1 7"]), "face 0 has vertex 7"),
        ("index.ply", ply(["0 0 0", "1 0 0", "0 1 0"], ["3 0 1 -1"]), "face 0 has vertex -1"),
        ("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "cannot be read as a mesh"),
        ("nan.ply", ply(["0 0 0", "nan 0 0", "0 1 0"], ["3 0 1 2"]), "at vertex 1"),
        ("nan.ply", ply(["0 0 0 0 0 1", "1 0 0 0 0 nan", "0 1 0 0 0 1"], ["3 0 1 2"], normals=True), "normals hold"),
        (
            "zero.ply",
            ply(["0 0 0 0 0 1", "1 0 0 0 0 0", "0 1 0 0 0 1"], ["3 0 1 2"], normals=True),
            "at vertex 1 is zero",
        ),
        (
            "flat.ply",
            ply(["0 0 0", "1 0 0", "0 1 0", "2 0 0"], ["3 0 1 2", "3 0 3 1"]),
            "face 1 (vertices 0, 3, 1) is degen",
        ),
        ("stray.ply", ply(["0 0 0", "1 0 0", "0 1 0", "2 0 0"], ["3 0 1 2"]), "vertex 3 is in no face"),
        ("twin.ply", ply(["0 0 0", "1 0 0", "0 1 0", "0 0 0"], ["3 0 1 3"]), "position counted once"),
        ("points.ply", ply(["0 0 0", "1 0 0", "0 1 0"], []), "holds no faces"),
        ("points.xyz", "0 0 0\n1 1 1\n", "holds no faces"),
        ("empty.obj", "# nothing\n", "holds no faces"),
        ("empty.stl", "", "holds no faces"),
        ("text.ply", "no ply", "cannot be read as a mesh"),
        ("cut.off", "OFF\n3 1 0\n0 0 0\n", "cannot be read as a mesh"),
        ("cut.glb", "glTF", "cannot be read as a mesh"),
        ("part.step", "", "has no suffix of a mesh format: use one of"),
        ("part", "", "has no suffix of a mesh format: use one of"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_sentence(tmp_path: Path, name: str, text: str, words: str) -> None:
    path = written(tmp_path, name, text)
    with pytest.raises(MeshError) as caught:
        load_mesh(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert words in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["t.ply", "t.stl", "t.glb"])
def test_a_binary_file_that_breaks_off_is_refused(tmp_path: Path, name: str) -> None:
    torus()[0].export(tmp_path / name)
    content = (tmp_path / name).read_bytes()
    for share in (0.0, 0.02, 0.3, 0.9, 0.999):
        (tmp_path / name).write_bytes(content[: int(share * len(content))])
        with pytest.raises(MeshError, match="check that the file is complete"):
            load_mesh(tmp_path / name)


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"none\.ply does not exist"):
        load_mesh(tmp_path / "none.ply")
    with pytest.raises(MeshError, match="is not a file"):
        load_mesh(tmp_path)
