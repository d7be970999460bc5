"""Meshes from files: in any format trimesh reads (PLY, OBJ, STL, OFF, GLB and others), and NPZ with all the data."""

from os import PathLike
from pathlib import Path
from typing import Any, Literal

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_arrays import SUFFIX, load_arrays
from testbed.geometry.mesh_checks import check_range
from testbed.geometry.vectors import Float, Int, angle_between, norm

#: Normals that a file gives at one position are averaged if all are within this angle of their mean, in degrees.
CREASE_DEG = 30.0


def load_mesh(path: str | PathLike[str], normals: Literal["auto", "file", "estimated"] = "auto") -> HermiteMesh:
    """Read a mesh from a file.

    An NPZ file (:func:`testbed.save_mesh`) holds named arrays: the mesh as it is, with second fundamental forms if they
    are there. What follows is about the other formats, which hold triangles.

    All meshes in the file are put together where the file's scene has them. Vertices at exactly the same position
    become one, the first: STL, and OBJ, GLB or PLY at seams of normals and textures, store them several times.
    Quadrilaterals and polygons are cut into triangles, by trimesh. Nothing else is changed: a face without area or a
    vertex without a face is an error, not mended. Normals are read from PLY, OBJ and GLB; trimesh skips those of OFF,
    and STL has none at vertices.

    Parameters
    ----------
    path
        The file; its suffix names the format.
    normals
        ``file``: those in the file, averaged where it has several at one position, which may differ from their mean by
        at most ``CREASE_DEG``. ``estimated``: means of the normals of the faces at a vertex, weighted with their angles
        there. ``auto``: those in the file if it has them and no crease, else estimated, at all vertices.

    Returns
    -------
    HermiteMesh
        Its ``normals_from`` says which normals it has, ``file`` or ``estimated``.

    Raises
    ------
    MeshError
        One sentence that names the file.
    """
    path = Path(path)
    if path.suffix.lower() == SUFFIX and path.is_file():
        stored = load_arrays(path)
        if normals == "estimated" or (normals == "auto" and stored.normals is None):
            return stored.with_estimated_normals()
        if stored.normals is None:
            raise MeshError(f"{path}: the file has no vertex normals: let them be estimated")
        return stored
    scene = read_scene(path)
    remark = ""
    try:
        points, faces, file_normals = whole(scene)
        position, vertex = merged(points)
        if len(position) < len(points):
            remark = " (vertices at the same position counted once)"
        return with_normals(points[position], vertex[faces], file_normals, vertex, normals)
    except MeshError as error:
        raise MeshError(f"{path}: {error}{remark}") from error


def with_normals(
    points: Float, faces: Int, file_normals: Float | None, vertex: Int, normals: Literal["auto", "file", "estimated"]
) -> HermiteMesh:
    """Return the mesh with the normals asked for; ``vertex`` (N,) says where each of the ``file_normals`` (N, 3) is."""
    if normals == "estimated" or (normals == "auto" and file_normals is None):
        return HermiteMesh(points, faces).with_estimated_normals()
    if file_normals is None:
        raise MeshError("the file has no vertex normals: let them be estimated")
    mean, angle_deg = mean_normals(file_normals, vertex, len(points))
    widest = int(np.argmax(angle_deg))
    if not angle_deg[widest] > CREASE_DEG:  # NaN normals too, which the mesh refuses
        return HermiteMesh(points, faces, mean, normals_from="file")
    if normals == "file":
        raise MeshError(
            f"the normals at vertex {widest} are up to {angle_deg[widest]:.3g} degrees from their mean, a crease: give "
            "one normal there, or let them be estimated"
        )
    return HermiteMesh(points, faces).with_estimated_normals()


def read_scene(path: Path) -> list[tuple[Float, Any]]:
    """Return the trimesh meshes with faces in a file, and the matrices (4, 4) that put them in place."""
    import trimesh  # heavy

    if not path.exists():
        raise MeshError(f"{path} does not exist: check the path of the mesh file")
    if not path.is_file():
        raise MeshError(f"{path} is not a file: give the path of a mesh file")
    formats = sorted({*trimesh.available_formats(), SUFFIX[1:]})
    if not path.name.lower().endswith(tuple(f".{name}" for name in formats)):
        raise MeshError(f"{path} has no suffix of a mesh format: use one of {', '.join(formats)}")
    try:
        scene = trimesh.load_scene(str(path), process=False)
        placed = [(scene.graph[node][0], scene.geometry[scene.graph[node][1]]) for node in scene.graph.nodes_geometry]
        meshes = [item for item in placed if isinstance(item[1], trimesh.Trimesh) and len(item[1].faces)]
    except ImportError as error:
        raise MeshError(
            f"{path} cannot be read as a mesh: check that the file is complete, or install {error.name}, which "
            "trimesh asks for"
        ) from error
    except Exception as error:  # the readers raise whatever they stumble on
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise MeshError(f"{path} cannot be read as a mesh ({reason}): check that the file is complete") from error
    if not meshes:
        raise MeshError(
            f"{path} holds no faces: check that the file is complete, with a mesh and not points or curves only"
        )
    return meshes


def whole(scene: list[tuple[Float, Any]]) -> tuple[Float, Int, Float | None]:
    """Return the points (V, 3), triangles (F, 3) and, if all meshes have them, normals (V, 3) of a scene."""
    meshes = [placed_mesh(np.asarray(matrix), mesh) for matrix, mesh in scene]
    first_vertex = np.cumsum([0] + [len(mesh[0]) for mesh in meshes])
    points = np.concatenate([mesh[0] for mesh in meshes])
    faces = np.concatenate([mesh[1] + start for mesh, start in zip(meshes, first_vertex, strict=False)])
    normals = [mesh[2] for mesh in meshes if mesh[2] is not None]
    return points, faces, np.concatenate(normals) if len(normals) == len(meshes) else None


def placed_mesh(matrix: Float, mesh: Any) -> tuple[Float, Int, Float | None]:
    """Return points, faces and normals, if the file has them, of a trimesh mesh moved by a (4, 4) matrix."""
    points = np.array(mesh.vertices, dtype=np.float64)
    faces = np.array(mesh.faces, dtype=np.int64)
    check_range(faces, len(points))
    # mesh.vertex_normals computes normals where the file has none; those of the file stand in the cache after loading
    normals = np.array(mesh.vertex_normals, dtype=np.float64) if "vertex_normals" in mesh._cache else None
    if not np.array_equal(matrix, np.eye(4)):
        linear = matrix[:3, :3]
        points = points @ linear.T + matrix[:3, 3]
        if np.linalg.det(linear) < 0:
            faces = faces[:, ::-1]
        if normals is not None:
            normals = normals @ np.linalg.inv(linear)  # as rows: the inverse transpose
    return points, faces, normals


def merged(points: Float) -> tuple[Int, Int]:
    """Return the first vertex at each position, in the order of the file, and the position of each vertex (V,)."""
    _, index, inverse = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # -0 becomes 0
    order = np.argsort(index)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return index[order], rank[inverse.ravel()]


def mean_normals(normals: Float, position: Int, count: int) -> tuple[Float, Float]:
    """Return the mean of the normals at each position, (P, 3), and the largest angle of one to it in degrees, (P,).

    A single normal is its own mean. Zero or NaN normals make a mean that a mesh refuses.
    """
    with np.errstate(invalid="ignore"):  # NaN and infinite normals stay visible as NaN
        length = norm(normals)[:, None]
        directions = np.divide(normals, length, out=np.zeros_like(normals), where=length != 0)
        sums = [np.bincount(position, weights=directions[:, axis], minlength=count) for axis in range(3)]
        total: Float = np.stack(sums, axis=-1).astype(np.float64, copy=False)
        alone = np.bincount(position, minlength=count)[position] == 1
        total[position[alone]] = normals[alone]
        angle = np.zeros(count)
        np.maximum.at(angle, position, np.degrees(angle_between(directions, total[position])))
    return total, angle
