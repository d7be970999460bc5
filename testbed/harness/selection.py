"""What a run computes: schemes on other boundary curves, and the levels that a bounded amount of work allows.

A bounded plan has the same levels for all schemes, so that they are compared on equal terms: those of each dataset up
to the finest that fits. What fits is reckoned from declarations and from one small fit, not from a clock, so that the
same installation plans the same cells on every machine.
"""

import dataclasses
import typing
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Scheme

#: Faces that cost as much as what every cell costs: building the mesh, preparing the measures, storing the result.
OVERHEAD: Final = 1000.0
#: Work of a plain run. A face of one cubic triangle, fitted and measured, is 1 and takes some 30 microseconds where all
#: processors are busy, so that this takes two of them about two and a half minutes.
BUDGET: Final = 9.3e6
#: Work a face of a scheme that could not be looked at.
UNKNOWN: Final = 5.0


@dataclass(frozen=True)
class LeftOut:
    """Levels of a dataset that a bounded plan left out."""

    dataset: str
    levels: tuple[int, ...]


def cell_weight(faces: int | None) -> float:
    """Return the cost of a cell up to a factor of the scheme's: its faces, and what every cell costs."""
    return OVERHEAD + (faces or 0)


def affordable(
    faces: Mapping[str, Mapping[int, int]], works: Mapping[str, float], budget: float
) -> tuple[dict[str, tuple[int, ...]], tuple[LeftOut, ...]]:
    """Choose levels: the cheapest first, a level never without those below it, until the work is used up.

    Parameters
    ----------
    faces
        Faces by dataset and level.
    works
        Work a face of all schemes together, by dataset.
    budget
        Work that all cells together may take.

    Returns
    -------
    tuple
        The levels of each dataset in rising order, and what was left out, by dataset. A dataset too large at its
        coarsest has no level.
    """
    # small meshes of all datasets come before large ones of any
    wanted = sorted(
        (works[dataset] * cell_weight(count), dataset, level)
        for dataset, levels in faces.items()
        for level, count in levels.items()
    )
    chosen: dict[str, list[int]] = {dataset: [] for dataset in faces}
    full: set[str] = set()
    spent = 0.0
    for cost, dataset, level in wanted:
        if dataset not in full and spent + cost <= budget:
            chosen[dataset].append(level)
            spent += cost
        else:
            full.add(dataset)
    levels = {dataset: tuple(sorted(some)) for dataset, some in chosen.items()}
    left_out = [
        LeftOut(dataset, tuple(level for level in sorted(faces[dataset]) if level not in levels[dataset]))
        for dataset in faces
    ]
    return levels, tuple(one for one in left_out if one.levels)


def curve_field(scheme: type[Scheme]) -> str | None:
    """Return the field that holds a scheme's boundary curves, or None for a scheme that builds its own."""
    hints = typing.get_type_hints(scheme)
    return next((one.name for one in dataclasses.fields(scheme) if hints[one.name] is BoundaryCurve), None)


def curve_of(scheme: Scheme) -> str:
    """Return the text of a scheme's boundary curves, empty for a scheme that builds its own."""
    field = curve_field(type(scheme))
    return str(getattr(scheme, field)) if field else ""


def family_of(scheme: Scheme) -> str:
    """Return the text of a scheme on its default boundary curves, which is the same for all curves."""
    field = curve_field(type(scheme))
    if field is None:
        return str(scheme)
    default = next(one.default for one in dataclasses.fields(scheme) if one.name == field)
    return str(dataclasses.replace(scheme, **{field: default}))


def on_curves(schemes: Iterable[Scheme], curves: Iterable[BoundaryCurve]) -> list[Scheme]:
    """Return the schemes, each that takes a curve network followed by itself on the given boundary curves."""
    curves = tuple(curves)
    result: list[Scheme] = []
    for scheme in schemes:
        result.append(scheme)
        if field := curve_field(type(scheme)):
            result.extend(dataclasses.replace(scheme, **{field: curve}) for curve in curves)
    return result
