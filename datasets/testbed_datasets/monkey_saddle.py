"""The monkey saddle: a flat point, where the second fundamental form is zero, at a vertex."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.charted import ChartedMesh
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import halved, straight
from testbed_datasets.height_charts import charted_graph
from testbed_datasets.height_field import HeightField
from testbed_datasets.parameters import positive

#: Directions of the start fan's corners from the flat point, in degrees, and their distances: unequal, so that the
#: mesh shares no symmetry with the saddle.
DIRECTIONS = (8.0, 71.0, 125.0, 187.0, 253.0, 304.0)
DISTANCES = (1.0, 0.9, 0.96, 0.88, 1.0, 0.93)


@dataclass(frozen=True)
class MonkeySaddle(Dataset):
    """Monkey saddle z = height (x^3 - 3 x y^2) over a hexagon without symmetry: 19 vertices, 24 faces.

    Vertex 0 is the flat point at the origin: normal (0, 0, 1), W = 0. Everywhere else K < 0.

    Parameters
    ----------
    height
        Factor of the cubic.
    """

    height: float = 1.0

    name = "monkey-saddle"
    title = "Monkey saddle"
    reference = "Not in the thesis: the simplest surface with an isolated flat point of negative curvature around"
    closed = False
    finest = 4

    def __post_init__(self) -> None:
        positive(self.name, height=self.height)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the plane; Refused if there is none."""
        plane, faces = halved(*start_mesh(), level, name=self.name, middle=straight)
        surface = self.surface
        return surface.sample(surface.over(plane), faces)

    def charted(self) -> ChartedMesh:
        """Return level 0 in the chart (x, y): refined meshes keep the boundary, and patches follow it."""
        return charted_graph(self.surface, *start_mesh())

    @property
    def surface(self) -> HeightField:
        """The saddle over the whole plane, normals upward."""
        return HeightField(((0.0,), (0.0, 0.0, -3.0 * self.height), (0.0,), (self.height,)))


def start_mesh() -> tuple[Float, Int]:
    """Level 0 in the plane, (19, 2) and (24, 3): a fan of six triangles about the origin, halved once."""
    angle = np.radians(DIRECTIONS)
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * np.array(DISTANCES)[:, None]
    ring = 1 + np.arange(len(corners))
    fan = np.stack([np.zeros_like(ring), ring, np.roll(ring, -1)], axis=-1)
    return halved(np.concatenate([np.zeros((1, 2)), corners]), fan, 1, name="monkey-saddle", middle=straight)
