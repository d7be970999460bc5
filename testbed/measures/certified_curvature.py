"""Guaranteed enclosures of the curvature extremes of surfaces of Bezier patches."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.curvature_bounds import TOLERANCE, Places, certifiable, numerator_size, surface_bounds
from testbed.geometry.surface import Surface
from testbed.measures.curvature import searched_extremes
from testbed.measures.extremum import Extremum
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Names of the extremes.
EXTREMES = ("gauss_min", "gauss_max", "mean_min", "mean_max")
_MEANINGS = (
    "smallest Gaussian curvature",
    "largest Gaussian curvature",
    "smallest mean curvature",
    "largest mean curvature",
)


@dataclass(frozen=True)
class CertifiedCurvature(Measure):
    """Two numbers that each curvature extreme of the whole surface lies between, rounding included.

    The searched extremes of the measure ``curvature`` are where the enclosures start: all that is left to do is to show
    that no patch exceeds them by more than the tolerance, and most patches are bounded once. Where the search missed an
    extremum, its value is outside of the enclosure. Where the parametrisation is singular, or cannot be told from a
    singular one, the outer numbers are infinite.

    Left out where a patch is neither polynomial nor rational, and on surfaces too large for ``coefficients``.

    Parameters
    ----------
    tolerance
        Gap between the two numbers that is aimed at, relative to the largest absolute curvature. The work has a bound,
        so that it may remain wider.
    coefficients
        Bernstein coefficients of the Gaussian curvature's numerators, in all patches together, up to which the
        enclosures are computed: 66 on a cubic triangle, 153 on a quartic one, 225 on a bicubic patch.
    budget, candidates
        Those of ``curvature``, so that its search is not done again.
    """

    tolerance: float = TOLERANCE
    coefficients: int = 200_000
    budget: int = 60_000
    candidates: int = 256

    name: ClassVar[str] = "certified-curvature"
    title: ClassVar[str] = "Certified curvature extremes"
    reference: ClassVar[str] = "Bernstein bounds with subdivision; Farin, Curves and Surfaces for CAGD"
    columns: ClassVar[tuple[Column, ...]] = tuple(
        Column(f"{name}_{end}", f"guaranteed {bound} bound of the {meaning} on polynomial patches", optional=True)
        for name, meaning in zip(EXTREMES, _MEANINGS, strict=True)
        for end, bound in (("low", "lower"), ("high", "upper"))
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none of them."""
        batches = survey.surface.batches
        if not all(certifiable(batch) for batch in batches):
            return {}
        if sum(numerator_size(batch) * len(batch) for batch in batches) > self.coefficients:
            return {}
        if not all(batch.finite.all() for batch in batches):
            return dict.fromkeys((column.name for column in self.columns), float("nan"))
        found = survey.shared(searched_extremes, self.budget, self.candidates)
        bounds = surface_bounds(batches, _places(survey.surface, found), tolerance=self.tolerance)
        result: dict[str, Value] = {}
        for name in EXTREMES:
            enclosure = getattr(bounds, name)
            result[f"{name}_low"], result[f"{name}_high"] = float(enclosure.low[0]), float(enclosure.high[0])
        return result


def _places(surface: Surface, found: Sequence[Extremum]) -> list[Places]:
    """Where extremes were found, for each part of the surface."""
    known = [one.within for one in found if one.within is not None]
    result = []
    for part in range(len(surface.parts)):
        of_part = [one for one in known if one.part == part]
        at = np.array([one.at for one in of_part], dtype=np.float64).reshape(-1, 2)
        result.append(Places(np.array([one.patch for one in of_part], dtype=np.int64), at))
    return result
