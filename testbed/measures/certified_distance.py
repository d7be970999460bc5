"""Guaranteed bounds of the largest distance to the exact surface, which no feature between samples escapes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.level_bounds import EnclosedLevelSet
from testbed.geometry.vectors import Float, norm
from testbed.measures.face_distances import Aim, largest_distance, nets_of
from testbed.measures.feet import feet
from testbed.measures.sampling import sample
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Upper bounds below this times the size of the coordinates are rounding.
ROUNDING = 1e-12


@dataclass(frozen=True)
class CertifiedDistance(Measure):
    """Bounds of the largest distance of polynomial and rational patches to a level set, everywhere on the patches.

    Of the patches only those are looked at closely that may be farther away than the farthest sample. The columns are
    left out for other patches and exact surfaces, for surfaces of more than ``patches`` patches, which would take too
    long, and where bounds of ``pieces`` pieces leave a factor of more than ``widest`` between them.

    Parameters
    ----------
    budget
        Samples on the whole surface, about, those of the other measures; where the search starts.
    ratio
        The upper bound is brought down to 1 + ratio times the farthest sample's distance, if that is so.
    patches
        Most patches of a surface.
    pieces
        Most pieces of patches whose bounds are computed.
    widest
        Largest ratio of the bounds, unless both are rounding.
    """

    budget: int = 60_000
    ratio: float = 0.1
    patches: int = 400
    pieces: int = 2_000
    widest: float = 2.0

    name: ClassVar[str] = "certified-distance"
    title: ClassVar[str] = "Guaranteed bounds of the distance to the exact surface"
    reference: ClassVar[str] = "Mann 1992, section 5.3, names features between samples as open"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("distance_max_low", "guaranteed lower bound of the largest distance", exact=True, optional=True),
        Column("distance_max_high", "guaranteed upper bound of the largest distance", exact=True, optional=True),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none where there are no bounds."""
        surface, exact = survey.surface, survey.exact
        bounded = surface.patch_count <= self.patches and all(nets_of(batch) is not None for batch in surface.batches)
        if not isinstance(exact, EnclosedLevelSet) or not bounded:
            return {}
        low, high = largest_distance(surface, exact, Aim(0.0, self.ratio), self._farthest(survey), self.pieces)
        size = float(np.abs(surface.mesh.points).max(initial=0.0))
        if not (high <= self.widest * low or high <= ROUNDING * size):
            return {}
        return {"distance_max_low": low, "distance_max_high": high}

    def _farthest(self, survey: Survey) -> Float | None:
        """Farthest sample (3,), or None if no sample has a foot."""
        points, distances = [np.empty((0, 3))], [np.empty(0)]
        for one, foot in zip(survey.shared(sample, self.budget), survey.shared(feet, self.budget), strict=True):
            distance = norm(one.points - foot).ravel()
            if not len(distance):
                continue
            best = int(np.argmax(np.where(np.isnan(distance), -1.0, distance)))
            points.append(one.points.reshape(-1, 3)[best : best + 1])
            distances.append(distance[best : best + 1])
        every, far = np.concatenate(points), np.concatenate(distances)
        known = np.isfinite(far)
        return every[known][np.argmax(far[known])] if known.any() else None
