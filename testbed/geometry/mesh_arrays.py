"""Meshes with all their Hermite data as named arrays, in NumPy's NPZ files: no format of meshes has second forms."""

import zipfile
import zlib
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Final

import numpy as np

from testbed.errors import MeshError
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int

#: The suffix of such files.
SUFFIX: Final = ".npz"
#: Arrays at face centres, all or none of them.
CENTRES: Final = ("centre_points", "centre_normals", "centre_second_forms")


def mesh_arrays(mesh: HermiteMesh) -> dict[str, Float | Int]:
    """Return the data of a mesh by name: ``points``, ``faces`` and what else it has.

    ``normals``, ``second_forms`` and ``gradients`` at the vertices; ``corner_second_forms``, ``side_tangents`` and
    ``centre_points``, ``centre_normals``, ``centre_second_forms`` of the faces.
    """
    of_vertices = {"normals": mesh.normals, "second_forms": mesh.second_forms, "gradients": mesh.gradients}
    given = {name: array for name, array in of_vertices.items() if array is not None}
    return {"points": mesh.points, "faces": mesh.faces, **given, **mesh.face_data.arrays()}


def mesh_of_arrays(arrays: Mapping[str, Any]) -> HermiteMesh:
    """Return the mesh of named arrays; other names are passed over. MeshError says what is wrong."""
    missing = [name for name in ("points", "faces") if name not in arrays]
    if missing:
        raise MeshError(f"there is no array {' and no '.join(missing)}: store a mesh's points and faces by these names")
    of_centres = [name for name in CENTRES if name in arrays]
    if of_centres and len(of_centres) < len(CENTRES):
        raise MeshError(f"there is {of_centres[0]} alone: give {', '.join(CENTRES)}, or none of them")
    centres = Centres(*(arrays[name] for name in CENTRES)) if of_centres else None
    of_faces = FaceData(centres, arrays.get("corner_second_forms"), arrays.get("side_tangents"))
    of_vertices = [arrays.get(name) for name in ("normals", "second_forms")]
    return HermiteMesh(
        arrays["points"], arrays["faces"], *of_vertices, face_data=of_faces, gradients=arrays.get("gradients")
    )


def save_mesh(mesh: HermiteMesh, path: str | PathLike[str]) -> Path:
    """Write a mesh with all its data to an NPZ file, which :func:`testbed.load_mesh` reads.

    Raises
    ------
    MeshError
        The path has another suffix, or cannot be written; the message names it.
    """
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise MeshError(f"{path} does not end in {SUFFIX}, the format that holds all data of a mesh: name it so")
    try:
        with path.open("wb") as file:
            named: dict[str, Any] = {**mesh_arrays(mesh)}
            np.savez_compressed(file, **named)
    except OSError as error:
        raise MeshError(f"{path} cannot be written ({error.strerror}): choose another place") from error
    return path


def load_arrays(path: Path) -> HermiteMesh:
    """Return the mesh in an NPZ file; MeshError, naming the file, for anything else in it."""
    try:
        # opened here, as a reader that fails leaves its file open
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = dict(stored.items())
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise MeshError(
            f"{path} cannot be read as arrays of a mesh ({reason}): check that the file is complete"
        ) from error
    try:
        return mesh_of_arrays(arrays)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
