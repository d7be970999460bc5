"""The grid of cells that a run computes: which, how large, what will be refused, and what each depends on."""

import dataclasses
import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeVar

from testbed import registry
from testbed.errors import SpecError
from testbed.harness import cell, sketches
from testbed.harness.selection import UNKNOWN, LeftOut, affordable, curve_of, family_of, on_curves
from testbed.harness.sources import Sources
from testbed.harness.workers import Died, Returned, TimedOut, Workers
from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.plugins.measure import Column, Measure
from testbed.plugins.scheme import Data, Scheme
from testbed.plugins.spec import parse

P = TypeVar("P", bound=Plugin)

#: Part of every key: raise it when cells are computed otherwise than before, and all are computed anew.
FORMAT: Final = 1
#: Seconds for a look at one dataset.
SKETCH_LIMIT: Final = 60.0


@dataclass(frozen=True)
class Cell:
    """A place in the grid.

    Parameters
    ----------
    scheme, dataset
        Canonical texts of the plugins.
    level
        Level of the dataset.
    faces
        Faces of the mesh, an estimate; None if the dataset could not be looked at.
    foreseen
        Why it will be refused, as far as that can be told without computing; else empty.
    key
        Hash of everything the result depends on.
    """

    scheme: str
    dataset: str
    level: int
    faces: int | None
    foreseen: str
    key: str

    def __str__(self) -> str:
        return f"{self.scheme} on {self.dataset}, level {self.level}"


@dataclass(frozen=True)
class PlannedScheme:
    """What a scheme declares, kept beside its results.

    Parameters
    ----------
    spec, title, reference
        Its text, and what it is called and where it was published.
    continuity, order, reproduces, matches
        Its claims, as texts (``G1``, ``spheres``, ``NORMALS``) and a number.
    source
        Hash of its source closure.
    boundary
        Text of the boundary curves it stands on, empty for its own.
    family
        Its text on its default boundary curves; empty where that is not known.
    """

    spec: str
    title: str
    reference: str
    continuity: str
    order: float | None
    reproduces: tuple[str, ...]
    matches: tuple[str, ...]
    source: str
    boundary: str = ""
    family: str = ""


@dataclass(frozen=True)
class PlannedDataset:
    """What a dataset declares, kept beside the results.

    Parameters
    ----------
    spec, title, reference
        Its text, and what it is called and where it comes from.
    closed
        Whether its meshes have no boundary; None if unknown.
    shape
        ``planes``, ``spheres``, ``quadrics`` if its exact surface is one, else None.
    source
        Hash of its source closure, and of the file it reads.
    """

    spec: str
    title: str
    reference: str
    closed: bool | None
    shape: str | None
    source: str


@dataclass(frozen=True)
class PlannedMeasure:
    """A measure with its columns and the hash of its source closure."""

    spec: str
    title: str
    columns: tuple[Column, ...]
    source: str


@dataclass(frozen=True)
class Plan:
    """A grid; build one with :func:`make_plan`.

    Parameters
    ----------
    cells
        All cells, by scheme, dataset and level in the order asked for. Schemes of triangles and datasets of
        quadrilaterals, or the other way round, have cells together only where both were named.
    schemes, datasets, measures
        What they are made of.
    left_out
        Levels left out to bound the work.
    """

    cells: tuple[Cell, ...]
    schemes: tuple[PlannedScheme, ...]
    datasets: tuple[PlannedDataset, ...]
    measures: tuple[PlannedMeasure, ...]
    left_out: tuple[LeftOut, ...] = ()

    @cached_property
    def pairs(self) -> frozenset[tuple[str, str]]:
        """Texts of the schemes and datasets that have cells together."""
        return frozenset((cell.scheme, cell.dataset) for cell in self.cells)

    @property
    def columns(self) -> tuple[Column, ...]:
        """The measured columns, in order."""
        return tuple(column for measure in self.measures for column in measure.columns)

    def task(self, one: Cell) -> cell.Task:
        """Return what a worker needs to compute a cell."""
        return cell.Task(
            one.scheme,
            one.dataset,
            one.level,
            tuple(measure.spec for measure in self.measures),
            next(scheme.source for scheme in self.schemes if scheme.spec == one.scheme),
            next(dataset.source for dataset in self.datasets if dataset.spec == one.dataset),
            tuple(measure.source for measure in self.measures),
        )

    def to_json(self) -> str:
        """Return the plan as text."""
        return json.dumps(dataclasses.asdict(self), indent=1)

    @classmethod
    def from_json(cls, text: str) -> "Plan":
        """Return the plan that :meth:`to_json` wrote; ValueError or TypeError for another text."""
        fields: dict[str, Any] = json.loads(text)
        return cls(
            tuple(Cell(**item) for item in fields["cells"]),
            tuple(
                PlannedScheme(**{**item, "reproduces": tuple(item["reproduces"]), "matches": tuple(item["matches"])})
                for item in fields["schemes"]
            ),
            tuple(PlannedDataset(**item) for item in fields["datasets"]),
            tuple(
                PlannedMeasure(**{**item, "columns": tuple(Column(**column) for column in item["columns"])})
                for item in fields["measures"]
            ),
            tuple(LeftOut(item["dataset"], tuple(item["levels"])) for item in fields["left_out"]),
        )


def parse_levels(text: str) -> tuple[int, ...]:
    """Return the levels of ``"2"`` or, the last included, of ``"0:4"``; SpecError for anything else."""
    match = re.fullmatch(r"\s*(\d{1,3})\s*(?::\s*(\d{1,3})\s*)?", text)
    if match is None:
        raise SpecError(f"levels {text!r} cannot be read: write one level as 2, or the first and the last as 0:4")
    first, last = int(match[1]), int(match[2] or match[1])
    if last < first:
        raise SpecError(f"levels {text!r} run backwards: write the coarsest first, {last}:{first}")
    return tuple(range(first, last + 1))


def make_plan(
    schemes: Sequence[str] | None = None,
    datasets: Sequence[str] | None = None,
    levels: str | None = None,
    measures: Sequence[str] | None = None,
    *,
    boundaries: Sequence[str] = (),
    budget: float | None = None,
) -> Plan:
    """Return the grid of schemes x datasets x levels.

    Parameters
    ----------
    schemes, datasets, measures
        Texts such as ``torus[minor=0.4]``; None for all that are registered, with their defaults, but for datasets that
        say not to compare schemes on them.
    levels
        ``"0:4"`` or ``"2"``; None for each dataset's own, 0 to its finest.
    boundaries
        Boundary curves on which the schemes that take a curve network are computed besides; ``all`` stands for all that
        are registered.
    budget
        Work that the cells may take together (:data:`~testbed.harness.selection.BUDGET` for a plain run): the finest
        levels that do not fit are left out. None for no bound.

    Raises
    ------
    SpecError
        A text names nothing registered, a file cannot be read, levels cannot be read, or the grid is empty.
    """
    chosen_levels = None if levels is None else parse_levels(levels)
    curves = [
        curve
        for text in boundaries
        for curve in _chosen(None if text == "all" else [text], BoundaryCurve)  # type: ignore[type-abstract]  # as below
    ]
    fitted = _unique(on_curves(_chosen(schemes, Scheme), curves))  # type: ignore[type-abstract]  # the kind is abstract
    sampled = _unique(_chosen(datasets, Dataset))
    measured = _unique(_chosen(measures, Measure))
    for what, found in (("scheme", fitted), ("dataset", sampled), ("measure", measured)):
        if not found:
            raise SpecError(f"there is no {what} to compute with: name one, or install a package that has some")
    sources = Sources()
    planned_schemes = tuple(_planned_scheme(one, sources) for one in fitted)
    planned_datasets = [_planned_dataset(one, sources) for one in sampled]
    planned_measures = tuple(PlannedMeasure(str(one), one.title, one.columns, sources.content(one)) for one in measured)
    by_dataset = [chosen_levels or tuple(range(one.finest + 1)) for one in sampled]
    looks = _looks([(sketches.sketch, str(one), its) for one, its in zip(sampled, by_dataset, strict=True)])
    named = schemes is not None and datasets is not None
    if not named:
        # what has no partner is no part of the grid
        paired = [any(_fits(one, sketch) for one in fitted) for sketch in looks]
        sampled, planned_datasets, by_dataset, looks = (
            [one for one, is_paired in zip(column, paired, strict=True) if is_paired]
            for column in (sampled, planned_datasets, by_dataset, looks)
        )
        fitted = [one for one in fitted if any(_fits(one, sketch) for sketch in looks)]
        if not fitted:
            raise SpecError("no dataset has faces of a kind that the schemes take: name other schemes or datasets")
        planned_schemes = tuple(one for one in planned_schemes if one.spec in {str(scheme) for scheme in fitted})
    left_out: tuple[LeftOut, ...] = ()
    if budget is not None:
        faces = {
            one.spec: {level: (sketch.faces or {}).get(level, 0) if sketch else 0 for level in its_levels}
            for one, its_levels, sketch in zip(planned_datasets, by_dataset, looks, strict=True)
        }
        works = [UNKNOWN if work is None else work for work in _looks([(sketches.work, str(one)) for one in fitted])]
        taken = {
            planned.spec: dataset.effort
            * sum(work for scheme, work in zip(fitted, works, strict=True) if named or _fits(scheme, sketch))
            for planned, dataset, sketch in zip(planned_datasets, sampled, looks, strict=True)
        }
        affordable_levels, left_out = affordable(faces, taken, budget)
        by_dataset = [affordable_levels[one.spec] for one in planned_datasets]
    cells = []
    for scheme, planned in zip(fitted, planned_schemes, strict=True):
        for dataset, its_levels, sketch in zip(planned_datasets, by_dataset, looks, strict=True):
            for level in its_levels if named or _fits(scheme, sketch) else ():
                faces_there = sketch.faces.get(level) if sketch and sketch.faces else None
                foreseen = _foreseen(scheme, level, sketch) if sketch else ""
                key = cell_key(planned, dataset, level, planned_measures)
                cells.append(Cell(planned.spec, dataset.spec, level, faces_there, foreseen, key))
    if not cells:
        raise SpecError("no cell fits into the work of a plain run: choose schemes, datasets or levels")
    # a dataset that is too large at its coarsest is named among what was left out
    computed = tuple(one for one, its_levels in zip(planned_datasets, by_dataset, strict=True) if its_levels)
    return Plan(tuple(cells), planned_schemes, computed, planned_measures, left_out)


def _chosen(specs: Sequence[str] | None, kind: type[P]) -> Iterable[P]:
    if specs is not None:
        return [parse(text, kind, registry.load()) for text in specs]
    found = [one() for one in registry.catalogue(kind).values()]
    return [one for one in found if not isinstance(one, Dataset) or one.compared]


def _unique(plugins: Iterable[Any]) -> list[Any]:
    return list({str(plugin): plugin for plugin in plugins}.values())


def _names(flags: Data) -> tuple[str, ...]:
    return tuple(str(flag.name) for flag in flags)


def _planned_scheme(scheme: Scheme, sources: Sources) -> PlannedScheme:
    return PlannedScheme(
        str(scheme),
        scheme.title,
        scheme.reference,
        scheme.continuity.value,
        scheme.order,
        tuple(shape.value for shape in scheme.reproduces),
        _names(scheme.matches),
        sources.content(scheme),
        curve_of(scheme),
        family_of(scheme),
    )


def _planned_dataset(dataset: Dataset, sources: Sources) -> PlannedDataset:
    return PlannedDataset(
        str(dataset),
        dataset.title,
        dataset.reference,
        dataset.closed,
        None if dataset.shape is None else dataset.shape.value,
        sources.content(dataset),
    )


def _looks(wanted: list[tuple[Any, ...]]) -> list[Any]:
    """Call functions in a worker process, where a plugin that hangs or dies does no harm; None where it did."""
    result: list[Any] = [None] * len(wanted)
    with Workers(1, SKETCH_LIMIT) as workers:
        for index, (look, *arguments) in enumerate(wanted):
            workers.submit(index, look, *arguments)
            while workers.tasks:
                for outcome in workers.wait(1.0):
                    match outcome:
                        case Returned(task, value):
                            result[task] = value
                        case TimedOut() | Died():
                            pass  # its cells will tell
    return result


def _fits(scheme: Scheme, sketch: sketches.Sketch | None) -> bool:
    """Whether a scheme takes the kind of faces a dataset has, or that is not known."""
    return sketch is None or bool(sketch.problem) or sketch.sides in scheme.domain


def _foreseen(scheme: Scheme, level: int, sketch: sketches.Sketch) -> str:
    """Return why a cell will be refused, as far as declarations and the coarsest mesh tell, or nothing."""
    if sketch.problem:
        return sketch.problem
    if sketch.absent and level in sketch.absent:
        return sketch.absent[level]
    if sketch.sides not in scheme.domain:
        return f"faces have {sketch.sides} sides, and the scheme takes {' or '.join(map(str, scheme.domain))}"
    needs = set(_names(scheme.needs))
    for one in scheme.nested():
        if isinstance(one, BoundaryCurve):
            needs |= set(_names(one.needs))
    lacking = [name.lower().replace("_", " ") for name in _names(~Data(0)) if name in needs - set(sketch.data)]
    return f"the mesh has no {' and no '.join(lacking)}" if lacking else ""


def cell_key(scheme: PlannedScheme, dataset: PlannedDataset, level: int, measures: Iterable[PlannedMeasure]) -> str:
    """Return the hash of all that a result depends on; library versions are recorded in run.json, not keyed."""
    content: Mapping[str, Any] = {
        "format": FORMAT,
        "scheme": (scheme.spec, scheme.source),
        "dataset": (dataset.spec, dataset.source),
        "level": level,
        "measures": [(measure.spec, measure.source) for measure in measures],
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
