"""Heights over scattered sites: the data that range-restricted interpolation is for."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int
from testbed.plugins.dataset import Dataset
from testbed_datasets.halving import check_level, halved, split_in_four, straight
from testbed_datasets.parameters import finite, positive, within
from testbed_datasets.scattered_fields import BumpField, peak, rainfall, random_heights, rough_middles
from testbed_datasets.scattered_sites import even_sites, triangulated

#: Heights of the ground where none is given: a little above zero, and dry places have no rain.
GROUND = {"peak": 0.001, "rainfall": 0.0, "noise": 0.001}
#: Fewest and most sites.
SITES = (8, 100_000)


@dataclass(frozen=True)
class Scattered(Dataset):
    """Heights of a field, none below the ground, at random sites of the unit square and their Delaunay triangles.

    Smooth surfaces through such data swing below the ground where nothing holds them, and the ground is so low that
    this is below zero. A peak stands on flat ground. A rainfall is exactly zero between its showers, where its normals
    are those of the plane z = 0. Both are three times continuously differentiable and known everywhere; level 0 is what
    is scattered, and finer levels halve its edges in the plane. Random heights, most of them low, are of no surface,
    and finer levels add middles near the means of the ends.

    Parameters
    ----------
    field
        What the heights are of: one ``peak``, ``rainfall``, or independent random heights, ``noise``.
    points
        Sites of level 0.
    seed
        Of the sites and the field; each is another set of data.
    normals
        The field's ``exact`` normals, with second forms, normals ``estimated`` from the triangles about each vertex, or
        ``none``. Random heights have no exact ones.
    height
        Factor of the heights above the ground: height of the peak, and the largest that random heights may have. Beyond
        0.5 level 0 is too steep for exact normals: most schemes refuse faces that fold over.
    ground
        Height of the ground; none for 0.001, under rainfall 0.
    """

    field: Literal["peak", "rainfall", "noise"] = "peak"
    points: int = 34
    seed: int = 0
    normals: Literal["exact", "estimated", "none"] = "exact"
    height: float = 0.5
    ground: float | None = None

    name = "scattered"
    title = "Scattered heights"
    reference = "Not in the thesis: made for Si Ping 2015, whose data are lost; sites and fields are ours"
    closed = False
    finest = 3
    # steep and coarse on purpose: which scheme is best on smooth data is not seen here
    compared = False

    def __post_init__(self) -> None:
        within(self.name, points=(self.points, *SITES), seed=(self.seed, 0, 2**63))
        positive(self.name, height=self.height)
        if self.ground is not None:
            finite(self.name, ground=self.ground)
        if self.field == "noise" and self.normals == "exact":
            raise SpecError(
                "parameter normals of scattered cannot be exact with field=noise, whose heights are of no surface: "
                "give normals=estimated or normals=none"
            )

    @property
    def surface(self) -> BumpField | None:
        """The graph over the whole plane, normals upward; None of random heights."""
        if self.field == "noise":
            return None
        return (peak if self.field == "peak" else rainfall)(self.seed, self.height, self._ground)

    @property
    def _ground(self) -> float:
        return GROUND[self.field] if self.ground is None else self.ground

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level; Refused if there is none."""
        sites = even_sites(self.points, self.seed)
        faces = triangulated(sites)
        surface = self.surface
        if surface is None:
            points, faces = self._rough(sites, faces, level)
        else:
            plane, faces = halved(sites, faces, level, name=self.name, middle=straight)
            points = surface.over(plane)
            if self.normals == "exact":
                return surface.sample(points, faces)
        if self.normals == "none":
            return HermiteMesh(points, faces)
        from testbed.geometry.inverse_area_normals import inverse_area_normals

        return HermiteMesh(points, faces, inverse_area_normals(points, faces), normals_from="estimated")

    def _rough(self, sites: Float, faces: Int, level: int) -> tuple[Float, Int]:
        """Points (V, 3) and faces of random heights on a level."""
        check_level(level, len(faces), self.name)
        points = np.column_stack([sites, random_heights(self.seed, len(sites), self.height, self._ground)])
        for step in range(level):
            edges, _, faces = split_in_four(faces, len(points))
            middles = rough_middles(self.seed, step, points[edges[:, 0]], points[edges[:, 1]], self._ground)
            points = np.concatenate([points, middles])
        return points, faces
