"""What parameter studies look for: a column of the results, or a number derived from columns, to be made small."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from testbed import registry
from testbed.errors import MeshError, Refused, SpecError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float
from testbed.plugins.measure import Column
from testbed.plugins.spec import choices

#: Points about at which the curvatures of an exact surface are looked at.
EXACT_SAMPLES: Final = 20_000

#: Smallest and largest Gaussian and mean curvature of the exact surface, under the names of the measured columns.
Extremes: TypeAlias = Mapping[str, float]
Row: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Objective:
    """A number that says how good a surface is; the smaller, the better, unless it is to be maximised.

    Parameters
    ----------
    name
        What the command line and the tables call it.
    meaning
        One line.
    columns
        The measured columns it is computed from.
    exact
        Whether it compares with the curvatures of the exact surface.
    of
        Computes it from the columns and from the exact extremes, which are empty unless ``exact``.
    """

    name: str
    meaning: str
    columns: tuple[str, ...]
    exact: bool
    of: Callable[[Row, Extremes], float]

    def value(self, row: Row, exact: Extremes) -> float:
        """Return the objective of a row of results; NaN where it has none."""
        values = [row.get(name) for name in self.columns]
        if any(isinstance(value, str) for value in values):
            raise SpecError(f"{self.name} is a text, not a number: choose another quantity")
        if any(value is None for value in values):
            return math.nan
        return float(self.of(row, exact))


def _gap(quantity: str) -> Callable[[Row, Extremes], float]:
    """Largest distance of an extreme of a curvature from the exact surface's; NaN propagates."""

    def of(row: Row, exact: Extremes) -> float:
        ends = (f"{quantity}_min", f"{quantity}_max")
        return float(np.max([abs(row[end] - exact[end]) for end in ends]))

    return of


def _ratio(row: Row, exact: Extremes) -> float:
    del exact
    return float(row["gauss_max"] / row["gauss_min"]) if row["gauss_min"] > 0.0 else math.nan


_GAUSS: Final = ("gauss_min", "gauss_max")
_MEAN: Final = ("mean_min", "mean_max")

#: What is derived from the columns.
DERIVED: Final = (
    Objective(
        "gauss_spread",
        "gauss_max - gauss_min",
        _GAUSS,
        exact=False,
        of=lambda row, _: row["gauss_max"] - row["gauss_min"],
    ),
    Objective(
        "mean_spread", "mean_max - mean_min", _MEAN, exact=False, of=lambda row, _: row["mean_max"] - row["mean_min"]
    ),
    Objective("gauss_ratio", "gauss_max / gauss_min where both are positive", _GAUSS, exact=False, of=_ratio),
    Objective(
        "gauss_error",
        "larger distance of gauss_min, gauss_max from the exact surface's",
        _GAUSS,
        exact=True,
        of=_gap("gauss"),
    ),
    Objective(
        "mean_error",
        "larger distance of mean_min, mean_max from the exact surface's",
        _MEAN,
        exact=True,
        of=_gap("mean"),
    ),
)


def objective(name: str) -> Objective:
    """Return a derived quantity, or a measured column as it is; SpecError for any other name."""
    derived = {one.name: one for one in DERIVED}
    if name in derived:
        return derived[name]
    columns = _columns()
    if name not in columns:
        raise SpecError(f"no quantity is called {name!r}: {choices(name, [*derived, *columns])}")
    return Objective(name, columns[name].meaning, (name,), exact=False, of=lambda row, _: row[name])


def measures_for(objectives: Sequence[Objective]) -> list[str]:
    """Return the texts of the registered measures that objectives need."""
    wanted = {name for one in objectives for name in one.columns}
    return [str(one) for one in registry.measures() if wanted & {column.name for column in one.columns}]


def exact_extremes(dataset: str, level: int, objectives: Sequence[Objective]) -> Extremes:
    """Return the curvature extremes of a dataset's exact surface, or nothing if no objective compares with them.

    Raises
    ------
    SpecError
        An objective needs the exact surface, and the dataset has none.
    """
    needing = [one.name for one in objectives if one.exact or any(_columns()[name].exact for name in one.columns)]
    if not needing:
        return {}
    found = registry.dataset(dataset)
    if found.surface is None:
        raise SpecError(
            f"{needing[0]} compares with the exact surface, and {dataset} has none: choose another quantity"
        )
    if not any(one.exact for one in objectives):
        return {}
    try:
        return curvature_extremes(found.surface, found.mesh(level))
    except (Refused, MeshError) as error:
        raise SpecError(f"{dataset} has no level {level} to compare with: {error}") from error


def curvature_extremes(exact: ExactSurface, mesh: HermiteMesh) -> Extremes:
    """Return the extremes of the exact curvatures over the part that a mesh covers.

    They are taken at the feet of a grid of points on the mesh faces, about :data:`EXACT_SAMPLES` in all, so that on a
    surface of varying curvature they are inner bounds, with errors of the second order in the spacing.
    """
    steps = max(2, math.ceil(math.sqrt(2.0 * EXACT_SAMPLES / len(mesh.faces))))
    shares = _shares(mesh.sides, min(steps, 200))
    points = np.einsum("sc,fcx->fsx", shares, mesh.points[mesh.faces]).reshape(-1, 3)
    W = exact.second_form(exact.closest(points))
    trace = np.einsum("nii->n", W)
    mean, gauss = 0.5 * trace, 0.5 * (trace**2 - np.einsum("nij,nji->n", W, W))
    return {
        "gauss_min": float(np.min(gauss)),
        "gauss_max": float(np.max(gauss)),
        "mean_min": float(np.min(mean)),
        "mean_max": float(np.max(mean)),
    }


def _shares(sides: int, steps: int) -> Float:
    """Return the shares of a face's corners at a grid of points, (S, sides): barycentric, or bilinear."""
    u, v = (grid.ravel() / steps for grid in np.mgrid[: steps + 1, : steps + 1])
    if sides == 3:
        inside = u + v <= 1.0 + 0.5 / steps
        u, v = u[inside], v[inside]
        return np.stack([1.0 - u - v, u, v], axis=-1)
    return np.stack([(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v], axis=-1)


def _columns() -> dict[str, Column]:
    """Return the columns of the registered measures by name."""
    return {column.name: column for measure in registry.measures() for column in measure.columns}
