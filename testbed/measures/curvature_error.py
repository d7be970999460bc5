"""How far the curvature is from the exact surface's, point by point."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.curvature import invariants
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.measures.extremum import Extremum
from testbed.measures.feet import exact_sum, feet
from testbed.measures.sampling import PatchSamples, chunks, sample
from testbed.plugins.measure import Column, Measure, Survey, Value


@dataclass(frozen=True)
class CurvatureError(Measure):
    """Deviation of the Gaussian and of the mean curvature from those of the exact surface at the feet of the samples.

    The largest deviation is that of the samples, not driven beyond them; the root mean square is weighted by area, with
    the quadrature rule that the distance is weighted with, and tells of the surface as a whole where the largest one
    tells of its worst spot. Blended patches are not looked at nearer to a corner than ``curvature_corner_margin``.

    Parameters
    ----------
    budget
        Samples on the whole surface, about; a patch has at least 22.
    """

    budget: int = 60_000

    name: ClassVar[str] = "curvature-error"
    title: ClassVar[str] = "Curvature against the exact surface"
    reference: ClassVar[str] = "this testbed"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("gauss_error_max", "largest error of the Gaussian curvature, sampled", converges=True, exact=True),
        Column("gauss_error_face", "mesh face of the largest error of the Gaussian curvature", exact=True),
        Column("gauss_error_bary", "place of the largest error of the Gaussian curvature in the face", exact=True),
        Column("gauss_error_rms", "root mean square of that error, weighted by area", converges=True, exact=True),
        Column("mean_error_max", "largest error of the mean curvature, sampled", converges=True, exact=True),
        Column("mean_error_face", "mesh face of the largest error of the mean curvature", exact=True),
        Column("mean_error_bary", "place of the largest error of the mean curvature in the face", exact=True),
        Column("mean_error_rms", "root mean square of that error, weighted by area", converges=True, exact=True),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns, or none where there is no exact surface."""
        if survey.exact is None:
            return {}
        exact, surface = survey.exact, survey.surface
        samples = survey.shared(sample, self.budget)
        errors = [
            _errors(exact, one, foot) for one, foot in zip(samples, survey.shared(feet, self.budget), strict=True)
        ]
        result: dict[str, Value] = {}
        for index, name in enumerate(("gauss", "mean")):
            largest = _largest(surface, samples, [error[index] for error in errors])
            squares, areas = [], []
            for one, error in zip(samples, errors, strict=True):
                # the points of the rule come first, and none is so near to a corner that it is not looked at
                weight = one.area * one.points_at.weights[: one.area.shape[1]]
                squares += np.sum(weight * error[index][:, : weight.shape[1]] ** 2, axis=1).tolist()
                areas += np.sum(weight, axis=1).tolist()
            area = exact_sum(areas)
            known = area > 0.0 and not np.isnan(largest.value)
            result |= {
                f"{name}_error_max": largest.value,
                f"{name}_error_face": largest.face,
                f"{name}_error_bary": largest.bary(surface.mesh.sides),
                f"{name}_error_rms": float(np.sqrt(exact_sum(squares) / area)) if known else float("nan"),
            }
        return result


def _errors(exact: ExactSurface, samples: PatchSamples, foot: Float) -> Float:
    """Deviations (2, P, C) of the Gaussian and mean curvature at the points where curvature is looked at."""
    curved = samples.points_at.curved
    result = np.empty((2, *samples.gauss.shape))
    for some in chunks(*foot.shape[:2]):
        at = foot[some][:, curved]
        known = np.isfinite(at).all(axis=-1)
        forms = np.full((*at.shape, 3), np.nan)
        forms[known] = exact.second_form(at[known])
        gauss, mean = invariants(forms)
        with np.errstate(invalid="ignore"):  # infinite curvature: NaN or infinity, either is told
            result[:, some] = np.abs([samples.gauss[some] - gauss, samples.mean[some] - mean])
    return result


def _largest(surface: Surface, samples: tuple[PatchSamples, ...], errors: list[Float]) -> Extremum:
    """Return the largest of the errors (P, C) of all parts; NaN outranks all, of equals the lowest face."""
    found: Extremum | None = None
    for part, (one, error) in enumerate(zip(samples, errors, strict=True)):
        if not error.size:
            continue
        peak = error.max(axis=1)
        level = np.nan if np.isnan(peak).any() else peak.max()
        faces = surface.parts[part].faces
        tied = np.flatnonzero(np.isnan(peak) if np.isnan(level) else peak == level)
        patch = tied[[np.argmin(faces[tied])]]
        place = one.points_at.at[one.points_at.curved][error[patch[0]].argmax()]
        face, at = surface.place(part, patch, place[None])
        here = Extremum(float(level), int(face[0]), at[0])
        if found is None or np.isnan(here.value) or here.value > found.value:
            found = here
    return found or Extremum(0.0, -1, np.full(2, np.nan))
