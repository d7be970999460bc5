"""How far a surface keeps to the side of a plane that its data are on."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.plane_bounds import KINDS, lowest_distance, plane_length, signed_distances
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int
from testbed.measures.extremum import Extremum, maxima
from testbed.measures.sampling import sample
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Lengths that the normal of a plane may have.
LENGTHS = (1e-100, 1e100)
#: A point is below a plane if it is by more than this times the size of the coordinates.
ROUNDING = 1e-12


@dataclass(frozen=True)
class PlaneSide(Measure):
    """Smallest signed distance of the surface from a plane, where all vertices of the mesh are on its positive side.

    Where some vertex is below the plane the columns are left out: no surface through the data keeps to one side. The
    smallest distance is sampled and then driven to the minimum within the patch. The guaranteed bound is that of Bezier
    patches, and of patches whose points are convex combinations of points of such; left out for others.

    Parameters
    ----------
    plane
        a, b, c, d of the plane a x + b y + c z + d = 0; (a, b, c) points to the positive side.
    budget
        Samples on the whole surface, about, those of the other measures.
    candidates
        Patches in which the minimum is searched for, those with the lowest samples.
    """

    plane: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 0.0)
    budget: int = 60_000
    candidates: int = 16

    name: ClassVar[str] = "plane-side"
    title: ClassVar[str] = "Distance from a plane that the data are on one side of"
    reference: ClassVar[str] = "Si Ping 2015: range-restricted interpolation"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("plane_min", "smallest signed distance from the plane, negative below it", optional=True),
        Column("plane_min_face", "mesh face of the smallest distance from the plane", optional=True),
        Column("plane_min_bary", "place of the smallest distance from the plane in the face", optional=True),
        Column("plane_min_low", "guaranteed lower bound of the signed distance from the plane", optional=True),
        Column("plane_below", "share of the faces that reach below the plane", optional=True),
    )

    def __post_init__(self) -> None:
        length = plane_length(self.plane)
        if not (LENGTHS[0] < length < LENGTHS[1] and np.isfinite(self.plane[3] / length)):
            raise SpecError(
                f"parameter plane of plane-side cannot be {self.plane}: give a b c d of a x + b y + c z + d = 0, where "
                f"the normal (a b c) has a length between {LENGTHS[0]:g} and {LENGTHS[1]:g}"
            )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none where data are below the plane."""
        surface = survey.surface
        points = surface.mesh.points
        rounding = ROUNDING * float(np.abs(points).max(initial=0.0) + abs(self.plane[3]) / plane_length(self.plane))
        if not (signed_distances(self.plane, points) >= -rounding).all():
            return {}
        samples = survey.shared(sample, self.budget)
        depths = [-signed_distances(self.plane, one.points) for one in samples]
        deepest = self._deepest(surface, depths, [one.points_at.at for one in samples])
        result: dict[str, Value] = {
            # adding zero: a surface on the plane is at distance 0, not -0
            "plane_min": 0.0 - deepest.value,
            "plane_min_face": deepest.face,
            "plane_min_bary": deepest.bary(surface.mesh.sides),
        }
        components = [batch.convex_components for batch in surface.batches]
        if all(components) and all(isinstance(one, KINDS) for every in components for one in every):
            every = [one for of_batch in components for one in of_batch]
            result["plane_min_low"] = lowest_distance(every, self.plane, -deepest.value)
        result["plane_below"] = _share_below(surface, depths, deepest, rounding)
        return result

    def _deepest(self, surface: Surface, depths: list[Float], places: list[Float]) -> Extremum:
        """Return the largest depth, which is the smallest distance with its sign changed."""

        def quantities(part: int, patches: Int, at: Float) -> Float:
            points = surface.parts[part].batch.take(patches).jets(at, 0).f
            return -signed_distances(self.plane, points)[None]

        margins = [batch.corner_margin for batch in surface.batches]
        (deepest,) = maxima(surface, [one[None] for one in depths], places, quantities, margins, self.candidates)
        return deepest


def _share_below(surface: Surface, depths: list[Float], deepest: Extremum, rounding: float) -> float:
    """Share of the mesh faces with a sample, or the lowest point, below the plane; NaN if that is not known."""
    if np.isnan(deepest.value):
        return float("nan")
    below = [part.faces[(depth > rounding).any(axis=1)] for part, depth in zip(surface.parts, depths, strict=True)]
    if deepest.value > rounding:
        below.append(np.array([deepest.face]))
    return len(np.unique(np.concatenate(below))) / len(surface.mesh.faces)
