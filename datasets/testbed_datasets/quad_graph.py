"""The graph of a generic polynomial in quadrilaterals, with samples at the centres of the faces."""

from dataclasses import dataclass

from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.dataset import Dataset
from testbed_datasets.graph import Graph, crooked_quads
from testbed_datasets.halving import straight
from testbed_datasets.height_field import HeightField
from testbed_datasets.parameters import finite, within
from testbed_datasets.quad_halving import halved_quads, quad_centres


@dataclass(frozen=True)
class QuadGraph(Dataset):
    """Graph z = bowl (x^2 + y^2)/2 + height p(x, y) over the square [-1, 1]^2: 20 vertices, 12 quadrilaterals.

    The surface of ``graph``, on its grid without diagonals, halved bilinearly in the plane; neither surface nor mesh
    has a symmetry. Convex by default; ``quad-graph[height=3,bowl=0]`` has both signs of curvature.

    Parameters
    ----------
    height
        Factor of the generic part.
    bowl
        Curvature of the paraboloid added to it; 0 leaves the generic part alone.
    crooked
        How far the grid's vertices are moved; 0 leaves rectangles.
    """

    height: float = 1.0
    bowl: float = 1.0
    crooked: float = 1.0

    name = "quad-graph"
    title = "Graph in quadrilaterals"
    reference = "Not in the thesis: a generic surface of this testbed"
    closed = False
    finest = 5

    def __post_init__(self) -> None:
        finite(self.name, height=self.height, bowl=self.bowl)
        within(self.name, crooked=(self.crooked, 0.0, 1.5))

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the plane; Refused if there is none."""
        plane, faces = halved_quads(*crooked_quads(self.crooked), level, name=self.name, middle=straight)
        surface = self.surface
        return surface.sample(surface.over(plane), faces, surface.over(quad_centres(plane, faces, straight)))

    @property
    def surface(self) -> HeightField:
        """The graph over the whole plane, normals upward."""
        return Graph(self.height, self.bowl).surface
