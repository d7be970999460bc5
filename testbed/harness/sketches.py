"""A look at a dataset or a scheme before a run: what planning needs to know, in a worker, as any plugin code."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from testbed import registry
from testbed.errors import MeshError, Refused
from testbed.geometry.face_data import Centres, FaceData
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float
from testbed.harness.cell import Stop, failing, line


@dataclass(frozen=True)
class Sketch:
    """What a dataset's meshes are like, as far as planning needs it.

    Parameters
    ----------
    problem
        Why there are no meshes, in one line; empty if there are.
    faces
        Faces by level: those of level 0 times four for each level, counted where the level is above the finest.
    sides
        Vertices of a face.
    data
        Names of the data: ``POINTS``, ``NORMALS``, ``SECOND_FORMS``, ``CENTRES``.
    absent
        Levels that the dataset says it does not have, with its reason.
    """

    problem: str = ""
    faces: Mapping[int, int] | None = None
    sides: int = 0
    data: tuple[str, ...] = ()
    absent: Mapping[int, str] | None = None


#: Up to this many faces a level above the finest is built to see whether it exists.
SKETCHED_FACES: Final = 50_000


def sketch(text: str, levels: tuple[int, ...]) -> Sketch:
    """Look at a dataset's coarsest mesh, and at levels beyond its finest; runs in a worker, as any plugin code."""
    try:
        with failing(f"dataset {text}"):
            dataset = registry.dataset(text)
            try:
                mesh = dataset.mesh(0)
            except MeshError as error:
                raise Refused(str(error)) from error
    except Stop as stop:
        return Sketch(stop.reason)
    faces = {level: len(mesh.faces) * 4**level for level in levels}
    absent = {}
    for level in levels:
        if level > dataset.finest and faces[level] <= SKETCHED_FACES:
            try:
                faces[level] = len(dataset.mesh(level).faces)
            except Refused as error:
                absent[level] = line(error)
            except Exception:  # noqa: BLE001, S112 - what else goes wrong is the cell's to tell
                continue
    return Sketch("", faces, mesh.sides, _data(mesh), absent)


def work(text: str) -> float | None:
    """Return what a face of a scheme costs, reckoned from its patches on a small mesh; None if it takes none of them.

    The meshes are an octahedron and a cube inscribed in the unit sphere, with exact data. Runs in a worker.
    """
    scheme = registry.scheme(text)
    for mesh in (_on_sphere(_OCTAHEDRON), _on_sphere(_CUBE)):
        try:
            surface = scheme.fit(mesh)
        except Exception:  # noqa: BLE001, S112 - a scheme that takes neither tells so in its cells
            continue
        return sum(len(batch) * batch.work for batch in surface.batches) / len(mesh.faces)
    return None


#: Vertices, up to their length, and faces.
_OCTAHEDRON: Final = (
    ((1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)),
    ((0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5)),
)
_CUBE: Final = (
    ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)),
    ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
)


def _on_sphere(solid: tuple[tuple[tuple[int, ...], ...], tuple[tuple[int, ...], ...]]) -> HermiteMesh:
    import numpy as np

    def on_sphere(places: Float) -> tuple[Float, Float, Float]:
        points = places / np.sqrt((places * places).sum(axis=1, keepdims=True))
        return points, points, np.eye(3) - points[:, :, None] * points[:, None, :]

    vertices, faces = np.array(solid[0], dtype=np.float64), np.array(solid[1])
    points, normals, forms = on_sphere(vertices)
    centres = Centres(*on_sphere(vertices[faces].mean(axis=1)))
    return HermiteMesh(points, faces, normals, forms, face_data=FaceData(centres))


def _data(mesh: HermiteMesh) -> tuple[str, ...]:
    given = {
        "POINTS": True,
        "NORMALS": mesh.normals is not None,
        "SECOND_FORMS": mesh.second_forms is not None,
        "CENTRES": mesh.face_data.centres is not None,
    }
    return tuple(name for name, there in given.items() if there)
