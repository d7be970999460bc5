"""One cell of the grid: a mesh, a surface, its measures; computed in a worker process, from texts to plain values."""

import functools
import time
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from math import hypot, isnan
from typing import Any, Final, Literal, TypeAlias

from testbed import registry
from testbed.errors import MeshError, Refused, TestbedError
from testbed.harness.sources import Sources
from testbed.plugins.base import Plugin
from testbed.plugins.dataset import Dataset
from testbed.plugins.measure import Measure, Value, measure_all
from testbed.plugins.scheme import Scheme
from testbed.plugins.spec import parse

Status: TypeAlias = Literal["ok", "refused", "failed", "timeout"]

#: What is kept of a traceback, in characters.
TRACEBACK_KEPT: Final = 16000


@dataclass(frozen=True)
class Task:
    """A cell to compute.

    Parameters
    ----------
    scheme, dataset
        Texts of the plugins.
    level
        Level of the dataset.
    measures
        Texts of the measures.
    scheme_source, dataset_source, measure_sources
        The source hash each text stood for when the run was planned.
    """

    scheme: str
    dataset: str
    level: int
    measures: tuple[str, ...]
    scheme_source: str
    dataset_source: str
    measure_sources: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What came of a cell.

    Parameters
    ----------
    status
        ``ok``, ``refused``, ``failed`` or ``timeout``.
    reason
        One line; empty if ok.
    traceback
        For failures, where in the code; else empty.
    faces, patches, h, diameter
        Faces of the mesh, patches of the surface, the longest edge, and the diagonal of the box around the mesh; None
        if it did not come so far.
    values
        The measured columns; empty unless ok.
    fit_seconds, measure_seconds
        Time to build the surface from the mesh, and to measure it.
    retry
        Whether the outcome may be the machine's, so that another run tries again.
    """

    status: Status
    reason: str = ""
    traceback: str = ""
    faces: int | None = None
    patches: int | None = None
    h: float | None = None
    diameter: float | None = None
    values: Mapping[str, Value] | None = None
    fit_seconds: float | None = None
    measure_seconds: float | None = None
    retry: bool = False


@dataclass(frozen=True)
class SourceChanged:
    """The worker's source of a plugin is not the one that the run was planned with."""

    plugin: str


class Stop(Exception):
    """Ends the computation of a cell with a status."""

    def __init__(self, status: Status, reason: str, trace: str = "", retry: bool = False) -> None:
        super().__init__(reason)
        self.status, self.reason, self.trace, self.retry = status, reason, trace, retry


def compute(task: Task) -> Outcome | SourceChanged:
    """Compute a cell; whatever a plugin raises becomes a status with a reason."""
    known: dict[str, Any] = {"values": {}}
    try:
        with failing("plugins"):
            scheme, dataset = registry.scheme(task.scheme), registry.dataset(task.dataset)
            measures = tuple(_measure(text) for text in task.measures)
        changed = _changed(task, (scheme, dataset, *measures))
        if changed:
            return changed
        values = _compute(scheme, dataset, task.level, measures, known)
    except Stop as stop:
        return Outcome(stop.status, stop.reason, stop.trace, retry=stop.retry, **known)
    return Outcome("ok", **{**known, "values": values})


def _compute(
    scheme: Scheme, dataset: Dataset, level: int, measures: tuple[Measure, ...], known: dict[str, Any]
) -> dict[str, Value]:
    """Return the measured columns; what is known about the cell even if it fails later goes to ``known``."""
    with failing(f"dataset {dataset}"):
        try:
            mesh = dataset.mesh(level)
        except MeshError as error:
            raise Refused(str(error)) from error
        exact = dataset.surface
        box = mesh.points.max(axis=0) - mesh.points.min(axis=0)
        known.update(faces=len(mesh.faces), h=mesh.h, diameter=hypot(*box.tolist()))
    with failing(f"scheme {scheme}"):
        start = time.perf_counter()
        surface = scheme.fit(mesh)
        known.update(fit_seconds=time.perf_counter() - start, patches=surface.patch_count)
    with failing("measures"):
        start = time.perf_counter()
        measured = measure_all(measures, surface, exact)
        known.update(measure_seconds=time.perf_counter() - start)
        values = {name: _plain(name, value) for name, value in measured.items()}
    undefined = [name for name, value in values.items() if isinstance(value, float) and isnan(value)]
    if undefined:
        raise Stop("failed", f"NaN in {', '.join(undefined)}")
    return values


@contextmanager
def failing(stage: str) -> Iterator[None]:
    """Turn what is raised inside into a status, with the stage in the reason."""
    try:
        yield
    except Refused as error:
        raise Stop("refused", line(error)) from error
    except MemoryError as error:
        raise Stop("failed", f"{stage}: out of memory", _trace(), retry=True) from error
    except BaseException as error:  # a plugin may raise SystemExit, too, and that costs its cell only
        text = line(error) if isinstance(error, TestbedError) else f"{type(error).__name__}: {line(error)}"
        raise Stop("failed", f"{stage}: {text}", _trace()) from error


def line(error: BaseException) -> str:
    """Text of an error on one line."""
    try:
        return " ".join(str(error).split())
    except Exception:  # noqa: BLE001 - a plugin's exception may fail to say what it is
        return "no message"


def _trace() -> str:
    return traceback.format_exc()[-TRACEBACK_KEPT:]


def _plain(name: str, value: Any) -> Value:
    """Return a measured value as a Python number or text."""
    value = value.item() if hasattr(value, "item") and getattr(value, "size", 0) == 1 else value
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, int | float | str):
        return value
    raise TypeError(f"column {name} is a {type(value).__name__}: a measure returns numbers and texts")


def _measure(text: str) -> Measure:
    return parse(text, Measure, registry.load())  # type: ignore[type-abstract]  # the kind is abstract, not what comes


def _changed(task: Task, plugins: tuple[Plugin, ...]) -> SourceChanged | None:
    """Compare the sources that this process runs with those the run was planned with."""
    planned = (task.scheme_source, task.dataset_source, *task.measure_sources)
    for plugin, source in zip(plugins, planned, strict=True):
        if _source(plugin) != source:
            return SourceChanged(str(plugin))
    return None


@functools.cache
def _sources() -> Sources:
    return Sources()


@functools.cache
def _source(plugin: Plugin) -> str:
    """Return a plugin's source hash, taken once a process, as the source is loaded once."""
    return _sources().content(plugin)
