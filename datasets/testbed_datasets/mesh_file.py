"""A mesh from a file: what users bring; no exact surface."""

from dataclasses import dataclass
from typing import ClassVar

from testbed.errors import Refused
from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.dataset import Dataset


@dataclass(frozen=True)
class MeshFile(Dataset):
    """A mesh file, ``mesh:PATH``: level 0 only, no exact surface, no second fundamental forms.

    Parameters
    ----------
    path
        The file, in any format that ``testbed.load_mesh`` reads; relative to the current folder.
    """

    path: str = ""

    name = "mesh"
    title = "Mesh from a file"
    reference = "The file"
    positional: ClassVar[str | None] = "path"
    closed: ClassVar[bool | None] = None
    finest = 0

    def mesh(self, level: int) -> HermiteMesh:
        """Return the file's mesh.

        Raises
        ------
        Refused
            The level is not 0, or no file is named.
        MeshError
            The file cannot be read, or is no mesh that a surface can be built on.
        """
        from testbed.geometry.mesh_files import load_mesh  # brings trimesh: only where a file is read

        if not self.path:
            raise Refused("dataset mesh names no file: write mesh:PATH")
        if level != 0:
            raise Refused(f"{self} has no level {level}: a mesh from a file has level 0 only")
        return load_mesh(self.path)

    @property
    def surface(self) -> None:
        """None: what the file was sampled from is not known."""
        return
