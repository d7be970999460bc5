"""Distance and normal deviation from the exact surface, by projection onto it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.exact import ExactSurface
from testbed.geometry.vectors import Float, Int, angle_between, norm
from testbed.measures.extremum import maxima
from testbed.measures.feet import exact_sum, feet, projected
from testbed.measures.sampling import chunks, sample
from testbed.plugins.measure import Column, Measure, Survey, Value


@dataclass(frozen=True)
class Distance(Measure):
    """How far the surface is from the exact one, and how much its normals differ from those at the feet.

    One-sided: from points of the surface to the exact surface. The maxima are driven beyond the samples; the root mean
    square is weighted by area, with a quadrature rule that is the same at every level.

    Parameters
    ----------
    budget
        Samples on the whole surface, about; a patch has at least 22.
    candidates
        Patches in which each maximum is searched for, those with the largest samples.
    """

    budget: int = 60_000
    candidates: int = 256

    name: ClassVar[str] = "distance"
    title: ClassVar[str] = "Distance to the exact surface"
    reference: ClassVar[str] = "Mann 1992, section 3.4"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("distance_max", "largest distance to the exact surface", converges=True, exact=True),
        Column("distance_max_face", "mesh face of the largest distance", exact=True),
        Column("distance_max_bary", "place of the largest distance in the face", exact=True),
        Column("distance_rms", "root mean square of the distance, weighted by area", converges=True, exact=True),
        Column("normal_max_deg", "largest angle to the exact surface's normal, degrees", converges=True, exact=True),
        Column("normal_max_face", "mesh face of the largest angle", exact=True),
        Column("normal_max_bary", "place of the largest angle in the face", exact=True),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none where there is no exact surface."""
        if survey.exact is None:
            return {}
        surface, exact = survey.surface, survey.exact
        samples = survey.shared(sample, self.budget)
        sampled = [
            _sampled_deviations(exact, foot, one.points, one.normals)
            for one, foot in zip(samples, survey.shared(feet, self.budget), strict=True)
        ]

        def quantities(part: int, patches: Int, at: Float) -> Float:
            jet = surface.parts[part].batch.take(patches).jets(at, 1)
            return deviations(exact, jet.f, jet.normal)

        places = [one.points_at.at for one in samples]
        # samples at the corners are exact; between them and the margin, normals of blended patches lose digits
        margins = [batch.corner_margin for batch in surface.batches]
        distance, turn = maxima(surface, sampled, places, quantities, margins, self.candidates)
        squares, areas = [], []
        for one, values in zip(samples, sampled, strict=True):
            rule = one.area.shape[1]
            weight = one.area * one.points_at.weights[:rule]
            squares += np.sum(weight * values[0][:, :rule] ** 2, axis=1).tolist()
            areas += np.sum(weight, axis=1).tolist()
        area = exact_sum(areas)
        # a distance that is not known makes the mean unknown, also where the rule has no point
        known = area > 0.0 and not np.isnan(distance.value)
        sides = surface.mesh.sides
        return {
            "distance_max": distance.value,
            "distance_max_face": distance.face,
            "distance_max_bary": distance.bary(sides),
            "distance_rms": float(np.sqrt(exact_sum(squares) / area)) if known else float("nan"),
            "normal_max_deg": float(np.degrees(turn.value)),
            "normal_max_face": turn.face,
            "normal_max_bary": turn.bary(sides),
        }


def deviations(exact: ExactSurface, points: Float, normals: Float) -> Float:
    """Distances and normal angles (2, ...) in radians of points (..., 3) with unit normals (..., 3)."""
    return _from_feet(exact, projected(exact, points), points, normals)


def _from_feet(exact: ExactSurface, foot: Float, points: Float, normals: Float) -> Float:
    """Distances from the feet (..., 3), and angles to the normals there, (2, ...)."""
    normal = np.full((foot.size // 3, 3), np.nan)
    found = np.isfinite(foot).all(axis=-1).ravel()
    normal[found] = exact.normal(foot.reshape(-1, 3)[found])
    return np.stack([norm(points - foot), angle_between(normals, normal.reshape(points.shape))])


def _sampled_deviations(exact: ExactSurface, foot: Float, points: Float, normals: Float) -> Float:
    result = np.empty((2, *points.shape[:2]))
    for some in chunks(*points.shape[:2]):
        result[:, some] = _from_feet(exact, foot[some], points[some], normals[some])
    return result
