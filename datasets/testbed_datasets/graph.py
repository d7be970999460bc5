"""The graph of a generic polynomial: an open surface with no symmetry, on which orders of convergence are honest."""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.charted import ChartedMesh
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import halved, straight
from testbed_datasets.height_charts import charted_graph
from testbed_datasets.height_field import HeightField
from testbed_datasets.parameters import finite

#: Coefficients of the generic part: row i, column j belongs to x^i y^j; all monomials of degree 1 to 6.
GENERIC = (
    (0.0, -0.05, 0.04, 0.05, -0.014, 0.013, 0.004),
    (0.08, -0.065, 0.045, -0.033, 0.013, -0.008),
    (-0.03, 0.04, 0.02, -0.013, 0.005),
    (-0.04, 0.02, -0.011, 0.005),
    (0.016, -0.008, 0.005),
    (0.01, 0.007),
    (-0.005,),
)
#: Cells of level 0 along x and y.
COLUMNS, ROWS = 4, 3


@dataclass(frozen=True)
class Graph(Dataset):
    """Graph z = bowl (x^2 + y^2)/2 + height p(x, y) over the square [-1, 1]^2, p of degree 6: 20 vertices, 24 faces.

    No symmetry in the polynomial, and none in the triangulation: a grid whose vertices are moved, those of the
    boundary along it, with diagonals both ways, halved in the plane. The default is convex (Gaussian curvature 0.027
    to 1.06 over the square), as spheres and ellipsoids are, without their symmetry, which flatters some schemes by one
    order of convergence. ``graph[height=3,bowl=0]`` has both signs of curvature (-1.3 to 0.36), so some edges run
    along directions of zero normal curvature, where geometric Hermite curves may be missing.

    Parameters
    ----------
    height
        Factor of the generic part.
    bowl
        Curvature of the paraboloid added to it; 0 leaves the generic part alone.
    """

    height: float = 1.0
    bowl: float = 1.0

    name = "graph"
    title = "Graph of a generic polynomial"
    reference = "Not in the thesis: a generic surface of this testbed"
    closed = False
    finest = 4

    def __post_init__(self) -> None:
        finite(self.name, height=self.height, bowl=self.bowl)

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the plane; Refused if there is none."""
        plane, faces = halved(*crooked_grid(), level, name=self.name, middle=straight)
        surface = self.surface
        return surface.sample(surface.over(plane), faces)

    def charted(self) -> ChartedMesh:
        """Return level 0 in the chart (x, y): refined meshes keep the boundary, and patches follow it."""
        return charted_graph(self.surface, *crooked_grid())

    @property
    def surface(self) -> HeightField:
        """The graph over the whole plane, normals upward."""
        rows = [[self.height * coefficient for coefficient in row] for row in GENERIC]
        rows[2][0] += 0.5 * self.bowl
        rows[0][2] += 0.5 * self.bowl
        return HeightField(tuple(tuple(row) for row in rows))


def crooked_grid() -> tuple[Float, Int]:
    """Level 0 over [-1, 1]^2: vertices (20, 2) and faces (24, 3), counterclockwise."""
    plane, cells = crooked_quads()
    here, right, across, up = cells.T
    # the shorter diagonal of each cell
    rising = np.hypot(*(plane[here] - plane[across]).T) <= np.hypot(*(plane[right] - plane[up]).T)
    apex, base = np.where(rising, across, up), np.where(rising, here, right)
    return plane, np.concatenate([np.stack([here, right, apex], axis=-1), np.stack([base, across, up], axis=-1)])


def crooked_quads(amount: float = 1.0) -> tuple[Float, Int]:
    """Cells of level 0 over [-1, 1]^2: vertices (20, 2), moved by an amount, and faces (12, 4), counterclockwise."""
    column, row = (index.ravel() for index in np.meshgrid(np.arange(COLUMNS + 1), np.arange(ROWS + 1), indexing="ij"))
    # multiples of two irrational numbers, reduced: evenly spread offsets without a pattern, no random generator
    along = np.arange(len(column)) + 1.0
    offset = np.stack([np.mod(along * 0.7548776662466927, 1.0), np.mod(along * 0.5698402909980532, 1.0)], axis=-1) - 0.5
    inside = np.stack([(column > 0) & (column < COLUMNS), (row > 0) & (row < ROWS)], axis=-1)
    cells = np.array([COLUMNS, ROWS])
    moved = np.stack([column, row], axis=-1) + amount * 0.36 * np.where(inside, offset, 0.0)
    plane = moved * (2.0 / cells) - 1.0
    column, row = (index.ravel() for index in np.meshgrid(np.arange(COLUMNS), np.arange(ROWS), indexing="ij"))
    here = column * (ROWS + 1) + row
    right = here + ROWS + 1
    return plane, np.stack([here, right, right + 1, here + 1], axis=-1)
