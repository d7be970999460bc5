"""A mesh from a file: what users bring; no exact surface."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.dataset import Dataset

#: The mesh that comes with the package: a pebble of 162 vertices and 320 faces, without normals.
EXAMPLE: Final = Path(__file__).with_name("pebble.ply")


@dataclass(frozen=True)
class MeshFile(Dataset):
    """A mesh file, ``mesh:PATH``: level 0 only, no exact surface; second fundamental forms only from NPZ files.

    Parameters
    ----------
    path
        The file, in any format that ``testbed.load_mesh`` reads, as the mesh.npz that ``testbed approximate`` writes;
        relative to the current folder. Without one, a small
        example that comes with the package: a closed mesh of a pebble without symmetry, whose normals are estimated.
    """

    path: str = ""

    name = "mesh"
    title = "Mesh from a file"
    reference = "The file"
    positional: ClassVar[str | None] = "path"
    closed: ClassVar[bool | None] = None
    finest = 0

    def files(self) -> tuple[Path, ...]:
        """Return the mesh file."""
        return (Path(self.path) if self.path else EXAMPLE,)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the file's mesh.

        Raises
        ------
        Refused
            The level is not 0.
        MeshError
            The file cannot be read, or is no mesh that a surface can be built on.
        """
        from testbed.geometry.mesh_files import load_mesh  # brings trimesh: only where a file is read

        if level != 0:
            raise Refused(f"{self} has no level {level}: a mesh from a file has level 0 only")
        return load_mesh(self.files()[0])

    @property
    def surface(self) -> None:
        """None: what the file was sampled from is not known."""
        return
