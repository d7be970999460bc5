"""A coarse mesh of an algebraic surface: marching cubes, projection onto the surface, edges made even.

The grid stands about the part of the box of interest that the surface is in, so it does not matter how much larger the
box is. Where the box cuts the surface off, boundary vertices lie on its sides and on the surface, and slide along both.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from testbed.errors import Refused
from testbed.geometry.edges import HalfEdges
from testbed.geometry.vectors import Float, Int, angle_between, dot, norm
from testbed_datasets.algebraic_surface import AlgebraicSurface
from testbed_datasets.even_triangles import SurfaceMesh, evened
from testbed_datasets.halving import split_in_four

#: Space left about the surface in the grid, in cells.
MARGIN: Final = 0.1
#: No value on the grid is taken for less than this times its neighbours'.
SMALL: Final = 0.1
#: The topology is compared with that on a grid this much finer, of this many points at most.
FINER, MOST_POINTS = 4, 2_000_000
#: So many levels are checked: halving may make needles of good faces that are far from the surface.
CHECKED_LEVELS: Final = 3
#: Least cosine of the angle between a face and the surface's normals at its corners.
FACING: Final = 0.1
#: As many vertices of the finest of these are looked at about each sample, for one with a normal like the sample's, of
#: at least this cosine.
NEAR_VERTICES, ALIKE = 12, 0.3
#: Least angle of a face, in radians.
THINNEST: Final = 0.2


class TooCoarse(Refused):
    """A surface that a grid of so many cells does not show as it is; more cells may."""


@dataclass(frozen=True)
class Grid:
    """A grid of cells about a surface.

    Attributes
    ----------
    low, high
        (3,) corners.
    cells
        (3,) numbers of cells.
    """

    low: Float
    high: Float
    cells: Int

    @property
    def length(self) -> float:
        """The longest side of a cell."""
        return float(((self.high - self.low) / self.cells).max())

    def places(self, index: Float) -> Float:
        """Points (N, 3) at coordinates (N, 3) in cells; those on the sides of the grid exactly there."""
        ratio = index / self.cells
        inside: Float = self.low + ratio * (self.high - self.low)
        return np.where(ratio == 0.0, self.low, np.where(ratio == 1.0, self.high, inside))

    def finer(self, times: int) -> "Grid":
        """Return the same grid with more cells."""
        return Grid(self.low, self.high, self.cells * times)


def grid_about(surface: AlgebraicSurface, cells: int) -> Grid:
    """Return a grid with ``cells`` nearly cubic cells along the longest side of what bounds the surface in its box."""
    boxes = surface.boxes
    low, high = boxes.low.min(axis=0), boxes.high.max(axis=0)
    low, high = np.maximum(low, surface.low), np.minimum(high, surface.high)
    margin = MARGIN * (high - low).max() / cells
    low, high = np.maximum(low - margin, surface.low), np.minimum(high + margin, surface.high)
    side = (high - low).max() / cells
    return Grid(low, high, np.maximum(np.rint((high - low) / side), 1).astype(np.int64))


def marched(surface: AlgebraicSurface, grid: Grid) -> tuple[Float, Int]:
    """Vertices (V, 3) and faces (F, 3) of the surface by marching cubes on a grid, oriented along the gradient.

    Both are empty if the polynomial has one sign on the grid.
    """
    from scipy.ndimage import maximum_filter  # slow to import, as the next
    from skimage.measure import marching_cubes

    index = np.stack(np.meshgrid(*(np.arange(count + 1.0) for count in grid.cells), indexing="ij"), axis=-1)
    values = surface.evaluated.values(grid.places(index.reshape(-1, 3))).reshape(index.shape[:3])
    negative = values < 0.0
    if negative.all() or not negative.any():
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    # a surface through a point of the grid has vertices on several edges there: not in one place if no value is small
    # beside its neighbours' (vertices are projected onto the surface later)
    size = np.abs(values)
    size = np.maximum(size / size.max(), 1e-30)  # in single precision, as marching cubes has them
    size = np.maximum(size, SMALL * maximum_filter(size, 3))
    values = np.where(negative, -size, size)
    vertices, faces, _, _ = marching_cubes(  # type: ignore[no-untyped-call]  # the library has no types
        values, 0.0, gradient_direction="descent"
    )
    return grid.places(vertices.astype(np.float64)), faces.astype(np.int64)


def start_mesh(surface: AlgebraicSurface, cells: int, what: str) -> tuple[Float, Int]:
    """Return vertices (V, 3) and faces (F, 3) of a coarse mesh of the part of a regular surface in its box.

    Parameters
    ----------
    surface
        The surface.
    cells
        Cells of the grid along the longest side of what bounds the surface.
    what
        What messages call the surface.

    Raises
    ------
    Refused
        There is no surface in the box.
    TooCoarse
        It is too small, too thin or bent too much for the cells, or touches a side of the box.
    """
    box = f"from {place(np.array(surface.low))} to {place(np.array(surface.high))}"
    if not len(surface.boxes):
        raise Refused(f"{what} has no real point in the box {box}: take another box")
    grid = grid_about(surface, cells)
    points, faces = marched(surface, grid)
    if not len(faces):
        raise TooCoarse(f"{what} is too small in the box {box} for {cells} cells")
    _check_topology(surface, grid, faces, what)
    held = surface.on_sides(points)
    there = surface.projected(points, held)
    lost = ~(norm(there - points) <= grid.length * np.sqrt(3.0))
    if lost.any():
        reason = "is nearly parallel to a side of the box" if held[lost][0].any() else "is too thin for the cells"
        raise TooCoarse(f"{what} {reason} near {place(points[lost][0])}")
    mesh = evened(SurfaceMesh(there, faces, held, surface.projected, surface.normal), grid.length)
    points, faces = mesh.points, mesh.faces
    for level in range(CHECKED_LEVELS):
        if level:
            points, faces = refined(surface, points, faces)
        corners = points[faces]
        ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
        bad = ~((mesh.facing(corners) > FACING) & (angle_between(ahead, back).min(axis=1) > THINNEST))
        if bad.any():
            face = int(np.argmax(bad)) // 4**level  # the face of level 0 that it came from
            where = place(mesh.points[mesh.faces[face]].mean(axis=0))
            raise TooCoarse(f"{what} bends too much for {cells} cells, or along a side of the box, near {where}")
    _check_cover(surface, points, faces, f"{what} has a part that {cells} cells do not show")
    return mesh.points, mesh.faces


def _check_topology(surface: AlgebraicSurface, grid: Grid, faces: Int, what: str) -> None:
    """Refuse a surface whose pieces, holes or boundaries a finer grid shows to be others."""
    times = FINER
    while times > 1 and np.prod(grid.cells * times + 1.0) > MOST_POINTS:
        times -= 1
    _, finer = marched(surface, grid.finer(times))
    here, there = topology(faces), topology(finer)
    if here != there:
        cells = int(grid.cells.max())
        raise TooCoarse(
            f"{what} is too thin for {cells} cells, which show {_counted(here)}, where {cells * times} show "
            f"{_counted(there)}"
        )


def _check_cover(surface: AlgebraicSurface, points: Float, faces: Int, what: str) -> None:
    """Refuse a mesh that leaves some of the surface's samples in the box without vertices of like normals about them.

    A piece of the surface that the mesh does not show has samples, and as it is closed its normals point everywhere.
    """
    from scipy.spatial import KDTree  # slow to import

    samples = surface.samples
    samples = samples[((samples >= surface.low) & (samples <= surface.high)).all(axis=1)]
    sides = norm(points[faces] - points[np.roll(faces, 1, axis=1)])
    distances, ids = KDTree(points).query(samples, k=np.arange(1, 1 + min(NEAR_VERTICES, len(points))))
    alike = dot(surface.normal(points)[ids], surface.normal(samples)[:, None]) > ALIKE
    shown = (alike & (np.array(distances) <= sides.max() + surface.spacing)).any(axis=1)
    if not shown.all():
        raise TooCoarse(f"{what} near {place(samples[int(np.argmin(shown))])}")


def topology(faces: Int) -> tuple[int, int, int]:
    """Numbers of pieces and boundaries of a manifold mesh, and its Euler characteristic."""
    halves = HalfEdges.between(faces.ravel(), np.roll(faces, -1, axis=1).ravel())
    boundary = halves.ids[(halves.forward < 0) | (halves.backward < 0)]
    vertices = len(np.unique(faces))
    return _pieces(halves.ids), _pieces(boundary), vertices - len(halves.ids) + len(faces)


def _pieces(edges: Int) -> int:
    """Number of connected pieces that edges (E, 2) make."""
    from scipy.sparse import coo_array  # slow to import
    from scipy.sparse.csgraph import connected_components

    used, ids = np.unique(edges, return_inverse=True)
    start, end = ids.reshape(-1, 2).T
    graph = coo_array((np.ones(len(edges)), (start, end)), shape=(len(used), len(used)))
    return int(connected_components(graph, directed=False)[0]) if len(used) else 0


def _counted(numbers: tuple[int, int, int]) -> str:
    pieces, boundaries, characteristic = numbers
    return f"{pieces} pieces with {boundaries} boundaries and Euler characteristic {characteristic}"


def place(point: Float) -> str:
    """Text of a point (3,), six digits a coordinate; rounding beside the largest coordinate is zero."""
    rounded = np.where(np.abs(point) < 1e-9 * np.abs(point).max(initial=1e-300), 0.0, point)
    return f"({', '.join(f'{value:.6g}' for value in rounded)})"


def refined(surface: AlgebraicSurface, points: Float, faces: Int) -> tuple[Float, Int]:
    """Split every triangle of a mesh in four; vertices (V, 3), NaN where none was found, and faces (F, 3)."""
    edges, boundary, children = split_in_four(faces, len(points))
    middles = surface.middles(points[edges[:, 0]], points[edges[:, 1]], boundary)
    return np.concatenate([points, middles]), children
