"""A plane: what every scheme ought to reproduce, and where distances and angles are rounding and nothing else."""

from dataclasses import dataclass

from testbed.geometry.charted import ChartedMesh
from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Shape
from testbed_datasets.graph import crooked_grid
from testbed_datasets.halving import halved, straight
from testbed_datasets.height_charts import charted_graph
from testbed_datasets.height_field import HeightField
from testbed_datasets.parameters import finite


@dataclass(frozen=True)
class Plane(Dataset):
    """Plane z = slope_x x + slope_y y over the square [-1, 1]^2, with the graph's mesh: 20 vertices, 24 faces.

    Normals equal everywhere, second forms zero: planar constructions of curves divide by nothing here.

    Parameters
    ----------
    slope_x, slope_y
        The plane's slopes.
    """

    slope_x: float = 0.3
    slope_y: float = -0.2

    name = "plane"
    title = "Plane"
    reference = "Not in the thesis: the simplest surface to reproduce"
    closed = False
    finest = 3
    shape = Shape.PLANES

    def __post_init__(self) -> None:
        finite(self.name, slope_x=self.slope_x, slope_y=self.slope_y)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the plane; Refused if there is none."""
        flat, faces = halved(*crooked_grid(), level, name=self.name, middle=straight)
        return self.surface.sample(self.surface.over(flat), faces)

    def charted(self) -> ChartedMesh:
        """Return level 0 in the chart (x, y): refined meshes keep the boundary, and patches follow it."""
        return charted_graph(self.surface, *crooked_grid())

    @property
    def surface(self) -> HeightField:
        """The whole plane, normals upward."""
        return HeightField(((0.0, self.slope_y), (self.slope_x,)))
