"""The offset of a bicubic B-spline surface of nine patches, which the thesis approximates by adaptive refinement."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.charted import ChartedMesh
from testbed.geometry.charted_surface import ChartedSurface
from testbed.geometry.curvature import principal
from testbed.geometry.jets import Jet
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import as_float, norm
from testbed.plugins.dataset import Dataset
from testbed_datasets.bicubic_spline import BicubicSpline
from testbed_datasets.halving import check_level
from testbed_datasets.height_charts import boundary_sides
from testbed_datasets.offset_charts import OffsetSpline
from testbed_datasets.parameters import finite
from testbed_datasets.principal_bounds import Peak, bounded_extremes, highest_place

#: Heights of the control points, ten times, over the points (i, j) of a grid; rows belong to i.
HEIGHTS = (
    (0, 4, 6, 4, 0, -6),
    (3, 9, 14, 10, 2, -5),
    (4, 14, 24, 14, 0, -8),
    (2, 9, 13, 2, -9, -12),
    (-2, 2, 1, -9, -16, -11),
    (-8, -4, -4, -9, -10, -6),
)
#: The base surface: knots 0, 0, 0, 0, 1, 2, 3, 3, 3, 3 both ways.
BASE = BicubicSpline(
    tuple(tuple((float(i), float(j), ten_z / 10.0) for j, ten_z in enumerate(row)) for i, row in enumerate(HEIGHTS))
)
#: Distances between these are regular without a search; the focal distances are a little beyond.
CERTAINLY_REGULAR = (-0.6, 0.9)
#: Most cells of level 0 along a side.
MOST_CELLS = 64
#: Lattice steps of the exact surface's samples from the middle of the chart to its sides.
STEPS = 24


@dataclass(frozen=True)
class Offset(Dataset):
    """Offset S + distance N of a bicubic B-spline surface of 3 x 3 patches, open: 16 vertices, 18 faces.

    The thesis's control points and start mesh are lost; these are this testbed's. By default an edge runs along every
    knot, so that each face lies in one patch, inside which the surface is smooth; across the knots the offset has
    continuous curvature and no more. With ``cells=1`` the mesh begins with two triangles and does not follow the knots.
    New vertices are the middles of edges in the parameters; patches follow the boundary.

    Parameters
    ----------
    distance
        Distance along the normals, which point upward, from -0.6406 to 0.9262: the base's principal curvatures,
        positive where it bends away from its normal, go from -1.07962 to 1.56093. -0.4 is another distance of interest.
    cells
        Squares along each side of level 0, of two triangles each; multiples of 3 follow the knots.
    """

    distance: float = 0.35
    cells: int = 3

    name = "offset"
    title = "Offset of a bicubic B-spline surface"
    reference = "Mann 1992, section 5.4.2, figure 5.8 (page 96); its control points and start mesh are lost"
    closed = False
    finest = 4
    effort = 5.0

    def __post_init__(self) -> None:
        finite(self.name, distance=self.distance)
        if not 1 <= self.cells <= MOST_CELLS:
            raise SpecError(
                f"parameter cells of {self.name} cannot be {self.cells}: give a number from 1 to {MOST_CELLS}"
            )
        if not CERTAINLY_REGULAR[0] <= self.distance <= CERTAINLY_REGULAR[1]:
            check_focal_distance(self.name, BASE, self.distance)

    def charted(self) -> ChartedMesh:
        """Return level 0: squares of the parameters, each divided by its shorter diagonal in space."""
        corners = np.arange(self.cells + 1)
        column, row = (index.ravel() for index in np.meshgrid(corners, corners, indexing="ij"))
        at = as_float(np.stack([column, row], axis=-1) * (BASE.cells / self.cells))
        column, row = (index.ravel() for index in np.meshgrid(corners[:-1], corners[:-1], indexing="ij"))
        here = column * (self.cells + 1) + row
        right, up, across = here + self.cells + 1, here + 1, here + self.cells + 2
        charts = self.surface.charts
        points = charts.jets(np.zeros(len(at), dtype=np.int64), at, 0).f
        rising = norm(points[across] - points[here]) <= norm(points[up] - points[right])
        lower = np.stack([here, right, np.where(rising, across, up)], axis=-1)
        upper = np.stack([np.where(rising, here, right), across, up], axis=-1)
        faces = np.stack([lower, upper], axis=1).reshape(-1, 3)
        chart = np.zeros(len(faces), dtype=np.int64)
        return ChartedMesh(charts, faces, chart, at[faces], boundary_sides(faces))

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the parameters; Refused if there is none."""
        check_level(level=level, faces=2 * self.cells**2, name=self.name)
        return self.charted().halved(level).sampled()

    @property
    def surface(self) -> ChartedSurface:
        """The offset, normals upward; it goes on a little beyond the mesh."""
        return ChartedSurface(OffsetSpline(BASE, self.distance), STEPS)


@dataclass(frozen=True)
class PrincipalRange:
    """The principal curvatures of a surface: extremes with their places, and bounds that none of them is beyond.

    Parameters
    ----------
    lowest, highest
        Extremes that were found.
    low, high
        Guaranteed bounds, about 1e-5 beyond, relatively.
    """

    lowest: Peak
    highest: Peak
    low: float
    high: float


@lru_cache(maxsize=8)
def principal_range(spline: BicubicSpline) -> PrincipalRange:
    """Search a spline surface for its extreme principal curvatures, and make sure that there are none beyond."""
    top = highest_place(lambda at: principal(Jet(spline.jet(at, 2)))[0], spline.cells)
    bottom = highest_place(lambda at: -principal(Jet(spline.jet(at, 2)))[1], spline.cells)
    low, high = bounded_extremes(spline.patches().reshape(-1, 4, 4, 3), -bottom.value, top.value)
    return PrincipalRange(Peak(-bottom.value, bottom.at), top, low, high)


def check_focal_distance(name: str, spline: BicubicSpline, distance: float) -> None:
    """Check that the offset of a spline surface is regular everywhere, with certainty.

    Raises
    ------
    SpecError
        It is not, or may not be; the message names the patch and the parameters in it.
    """
    extremes = principal_range(spline)
    bound, peak = (extremes.low, extremes.lowest) if distance > 0.0 else (extremes.high, extremes.highest)
    if 1.0 + distance * bound > 0.0:
        return
    patch = [min(int(t), spline.cells - 1) for t in peak.at]
    u, v = (t - cell for t, cell in zip(peak.at, patch, strict=True))
    # rounded towards zero, so that they are allowed
    lowest = "-infinity" if extremes.high <= 0.0 else f"{math.ceil(-1e4 / extremes.high) / 1e4:.4f}"
    highest = "infinity" if extremes.low >= 0.0 else f"{math.floor(-1e4 / extremes.low) / 1e4:.4f}"
    raise SpecError(
        f"parameter distance of {name} cannot be {distance}: in patch ({patch[0]}, {patch[1]}) at (u, v) = "
        f"({u:.4f}, {v:.4f}) the surface has the principal curvature {peak.value:.5f} and its offset folds over, "
        f"give a distance from {lowest} to {highest}"
    )
