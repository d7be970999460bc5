"""Extremes of the Gaussian and of the mean curvature over a surface."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.curvature import analyse
from testbed.geometry.vectors import Float, Int
from testbed.measures.extremum import Extremum, maxima
from testbed.measures.sampling import sample, samples_per_patch
from testbed.plugins.measure import Column, Measure, Survey, Value


def _extreme_columns(name: str, meaning: str) -> tuple[Column, ...]:
    return (
        Column(name, f"{meaning}, per unit of length{' squared' if name.startswith('gauss') else ''}"),
        Column(f"{name}_face", f"mesh face of the {meaning}"),
        Column(f"{name}_bary", f"place of the {meaning} in the face"),
    )


@dataclass(frozen=True)
class CurvatureExtremes(Measure):
    """Largest and smallest Gaussian and mean curvature, sampled and then driven to the extremum within the patch.

    Blended patches have no curvature at their corners, only limits that depend on the direction: there the search keeps
    to ``curvature_corner_margin``, and a different margin may give a different extremum.

    Parameters
    ----------
    budget
        Samples on the whole surface, about; a patch has at least 22.
    candidates
        Patches in which each extremum is searched for, those with the most extreme samples.
    """

    budget: int = 60_000
    candidates: int = 256

    name: ClassVar[str] = "curvature"
    title: ClassVar[str] = "Curvature extremes"
    reference: ClassVar[str] = "Mann 1992, section 4.3"
    columns: ClassVar[tuple[Column, ...]] = (
        *_extreme_columns("gauss_min", "smallest Gaussian curvature"),
        *_extreme_columns("gauss_max", "largest Gaussian curvature"),
        *_extreme_columns("mean_min", "smallest mean curvature"),
        *_extreme_columns("mean_max", "largest mean curvature"),
        Column("curvature_corner_margin", "distance kept from patch corners, in barycentric coordinates; 0 for none"),
        Column("samples_per_patch", "samples of a patch, before the extremes are driven beyond them"),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        surface = survey.surface
        found = survey.shared(searched_extremes, self.budget, self.candidates)
        result: dict[str, Value] = {}
        for name, sign, extremum in zip(
            ("gauss_min", "gauss_max", "mean_min", "mean_max"), (-1, 1, -1, 1), found, strict=True
        ):
            # adding zero: the smallest curvature of a plane is 0, not -0
            result[name] = sign * extremum.value + 0.0
            result[f"{name}_face"] = extremum.face
            result[f"{name}_bary"] = extremum.bary(surface.mesh.sides)
        result["curvature_corner_margin"] = max(batch.corner_margin for batch in surface.batches)
        result["samples_per_patch"] = samples_per_patch(surface, self.budget)
        return result


def searched_extremes(survey: Survey, budget: int, candidates: int) -> tuple[Extremum, ...]:
    """Maxima of -K, K, -H and H over a surface; ask for them as ``survey.shared(searched_extremes, ...)``.

    See :class:`CurvatureExtremes` for the settings.
    """
    surface = survey.surface
    samples = survey.shared(sample, budget)
    margins = [batch.corner_margin for batch in surface.batches]
    places = [one.points_at.at[one.points_at.curved] for one in samples]
    sampled = [np.stack([-one.gauss, one.gauss, -one.mean, one.mean]) for one in samples]

    def quantities(part: int, patches: Int, at: Float) -> Float:
        analysis = analyse(surface.parts[part].batch.take(patches).jets(at, 2))
        return np.stack([-analysis.gauss, analysis.gauss, -analysis.mean, analysis.mean])

    return tuple(maxima(surface, sampled, places, quantities, margins, candidates))
