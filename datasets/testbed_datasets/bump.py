"""A plane with one narrow bump between the vertices of a coarse mesh: what samples miss and bounds do not."""

from dataclasses import dataclass

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.charted import ChartedMesh
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Bool, Float
from testbed.plugins.dataset import Dataset
from testbed_datasets.bumped_plane import BumpChart, BumpedPlane
from testbed_datasets.graph import crooked_grid
from testbed_datasets.halving import halved, straight
from testbed_datasets.parameters import finite, positive

#: Largest height over width^3, in proportion to which third derivatives are.
LARGEST = 1e100


@dataclass(frozen=True)
class Bump(Dataset):
    """Plane z = 0 over [-1, 1]^2 with a bump height (1 - r^2 / width^2)^4, r < width; the graph's mesh, 24 faces.

    With the defaults no vertex of levels 0 and 1 is on the bump, and no sample point that the distance measure takes on
    flat patches over faces or thirds of faces. So the data are those of a plane, schemes that reproduce planes miss the
    bump, and so does the measured distance; bounds of the distance do not. They are of the distance from the patches to
    the surface: under the top of a bump taller than it is wide its sides are nearer than the top.

    Parameters
    ----------
    height
        Height of the top, negative for a dent.
    width
        Radius of the bump's foot.
    x, y
        Place of the top, with the bump inside the square.
    """

    height: float = 0.03
    width: float = 0.009
    x: float = 0.262
    y: float = -0.34

    name = "bump"
    title = "Plane with a narrow bump"
    reference = "Not in the thesis, whose section 5.3 names features between the samples as an open problem"
    closed = False
    finest = 0
    compared = False

    def __post_init__(self) -> None:
        finite(self.name, height=self.height, x=self.x, y=self.y)
        positive(self.name, width=self.width)
        for name, value in (("x", self.x), ("y", self.y)):
            if abs(value) + self.width > 1.0:
                raise SpecError(
                    f"parameter {name} of bump cannot be {value}: the bump of width {self.width} has to be inside "
                    f"[-1, 1], give at most {1.0 - self.width:.6g} in modulus"
                )
        if not abs(self.height) <= LARGEST * self.width**3:
            raise SpecError(
                f"parameter width of bump cannot be {self.width}: with height {self.height} its derivatives would be "
                "beyond the range of floats, give more"
            )

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the plane; Refused if there is none."""
        plane, faces = halved(*crooked_grid(), level, name=self.name, middle=straight)
        surface = self.surface
        return surface.sample(surface.over(plane), faces)

    @property
    def surface(self) -> BumpedPlane:
        """The whole plane with its bump, normals upward."""
        return BumpedPlane(self.height, self.width, (self.x, self.y))

    def charted(self) -> ChartedMesh:
        """Return level 0 in the chart (x, y)."""
        plane, faces = crooked_grid()
        at = plane[faces]
        return ChartedMesh(BumpChart(self.surface), faces, np.zeros(len(faces), dtype=np.int64), at, on_border(at))


def on_border(at: Float) -> Bool:
    """(F, 3) true for sides of triangles (F, 3, 2) that lie on the border of the square [-1, 1]^2."""
    on_side = np.concatenate([at == 1.0, at == -1.0], axis=-1)
    border: Bool = np.asarray((on_side & np.roll(on_side, -1, axis=1)).any(axis=2))
    return border
