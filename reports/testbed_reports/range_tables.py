"""Surfaces over data above a plane, measured: a row for each scheme on each set of the comparison."""

import csv
import dataclasses
import io
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from testbed.errors import MeshError, Refused
from testbed_reports.range_comparison import ComparedScheme, RangeSet, Uses

if TYPE_CHECKING:
    from testbed.geometry.exact import ExactSurface
    from testbed.geometry.surface import Surface

#: Seconds that the surfaces over one set may take.
LIMIT: Final = 900.0
Status: TypeAlias = Literal["ok", "refused", "failed"]
#: Points of each face at which a surface is compared with another over the same mesh: steps of a lattice.
STEPS: Final = 12
#: Below the plane by less than this is rounding: sizes are near one.
ROUNDING: Final = 1e-12
#: Angles in degrees up to which normals count as equal, rounding of jets where tangents are short.
SMOOTH_DEG: Final = 1e-6
#: The measures that are taken besides that of the plane, by name.
MEASURES: Final = ("continuity", "interpolation", "distance")


@dataclass(frozen=True)
class RangeRow:
    """A surface of the comparison; NaN where there is no such number.

    Parameters
    ----------
    dataset, level, plane
        The set, and its plane as (a b c d).
    label, scheme, uses, against
        The scheme.
    status, reason
        ``ok``, or ``refused`` or ``failed`` and why.
    faces, patches
        Of the mesh and of the surface.
    lowest, lowest_bound
        Least signed distance from the plane, as found, and a guaranteed lower bound of it.
    epsilon_deg, crease_deg
        Largest angle between normals across edges, and inside patches.
    gap_max, data_max
        Largest gap between patches; largest distance from a vertex.
    rms, distance_max
        Distance to the surface that the data are of, where that is known: root mean square, and largest.
    moved
        Largest distance, at equal parameters, from the surface without constraint or remedy, relative to the size.
    seconds
        To build it.
    branches, notes
        Which ways the construction took, and which fallbacks, counted.
    """

    dataset: str
    level: int
    plane: str
    label: str
    scheme: str
    uses: Uses
    against: str
    status: Status
    reason: str = ""
    faces: int = 0
    patches: int = 0
    lowest: float = math.nan
    lowest_bound: float = math.nan
    epsilon_deg: float = math.nan
    crease_deg: float = math.nan
    gap_max: float = math.nan
    data_max: float = math.nan
    rms: float = math.nan
    distance_max: float = math.nan
    moved: float = math.nan
    seconds: float = math.nan
    branches: str = ""
    notes: str = ""

    @property
    def place(self) -> str:
        """The set in words."""
        return str(RangeSet(self.dataset, self.level))

    @property
    def above(self) -> bool:
        """Whether nothing was found below the plane; NaN is below."""
        return self.status == "ok" and self.lowest >= -ROUNDING

    @property
    def guaranteed(self) -> bool:
        """Whether it is proved that nothing is below the plane."""
        return self.status == "ok" and self.lowest_bound >= -ROUNDING

    @property
    def smooth(self) -> bool:
        """Whether no normal jumps, across edges or inside patches."""
        return self.status == "ok" and self.epsilon_deg <= SMOOTH_DEG and self.crease_deg == 0.0


@dataclass(frozen=True)
class MeasuredSet:
    """What came of a set: its rows, and a PNG file's content, empty without a picture."""

    rows: tuple[RangeRow, ...]
    picture: bytes = b""


def measure_sets(
    sets: Sequence[RangeSet],
    schemes: Sequence[ComparedScheme],
    jobs: int | None = None,
    note: Callable[[int], None] = lambda _: None,
    *,
    pictures: bool = False,
) -> tuple[MeasuredSet, ...]:
    """Measure all sets, a set a task of worker processes, and return what came of each, in their order.

    Parameters
    ----------
    sets, schemes
        What to compare.
    jobs
        Worker processes; one a processor if None.
    note
        Called with the number of sets that are done.
    pictures
        Whether the surfaces are drawn.
    """
    from testbed.harness.run import processors
    from testbed.harness.workers import Died, Returned, TimedOut, Workers

    found: dict[int, MeasuredSet] = {}
    waiting = list(range(len(sets)))
    if not sets:
        return ()
    with Workers(min(jobs or processors(), len(sets)), LIMIT) as workers:
        while waiting or workers.tasks:
            while waiting and workers.free > 0:
                number = waiting.pop(0)
                workers.submit(number, measure_set, sets[number], tuple(schemes), pictures)
            for outcome in workers.wait(0.5):
                match outcome:
                    case Returned(task=number, value=value):
                        found[number] = value
                    case TimedOut(task=number):
                        found[number] = _failed(sets[number], schemes, f"the set takes more than {LIMIT:g} s")
                    case Died(task=number, reason=reason):
                        found[number] = _failed(sets[number], schemes, reason)
                note(len(found))
    return tuple(found[number] for number in range(len(sets)))


def _failed(one: RangeSet, schemes: Iterable[ComparedScheme], reason: str) -> MeasuredSet:
    return MeasuredSet(
        tuple(dataclasses.replace(_row(one, scheme), status="failed", reason=reason) for scheme in schemes)
    )


def _row(one: RangeSet, scheme: ComparedScheme) -> RangeRow:
    """Return the row of a surface before it is measured."""
    text = scheme.scheme.replace("{plane}", one.plane_text)
    return RangeRow(
        one.dataset_text, one.level, one.plane_text, scheme.label, text, scheme.uses, scheme.against, status="ok"
    )


def measure_set(one: RangeSet, schemes: Sequence[ComparedScheme], pictures: bool = False) -> MeasuredSet:
    """Measure every scheme on a set, but for those that use normals where it has none; runs in a worker."""
    from testbed import registry

    dataset = registry.dataset(one.dataset_text)
    try:
        mesh = dataset.mesh(one.level)
    except (Refused, MeshError) as error:
        return _failed(one, schemes, str(error))
    surfaces: dict[str, Surface] = {}
    rows = []
    for compared in schemes:
        if compared.uses == "normals" and mesh.normals is None:
            continue
        row = dataclasses.replace(_row(one, compared), faces=len(mesh.faces))
        start = time.perf_counter()
        try:
            surface = registry.scheme(row.scheme).fit(mesh)
        except Refused as refusal:
            rows.append(dataclasses.replace(row, status="refused", reason=refusal.reason))
            continue
        taken = time.perf_counter() - start
        surfaces[compared.label] = surface
        values = _measured(surface, dataset.surface, one.plane_text)
        if compared.against in surfaces:
            values["moved"] = moved(surface, surfaces[compared.against])
        rows.append(dataclasses.replace(row, seconds=taken, **values))
    if not pictures or not surfaces:
        return MeasuredSet(tuple(rows))
    from testbed_reports.range_pictures import draw_set, views_of

    return MeasuredSet(tuple(rows), draw_set(views_of(rows, surfaces, dataset, one.level), one.plane, f"{one}"))


def _measured(surface: "Surface", exact: "ExactSurface | None", plane: str) -> dict[str, Any]:
    """Return the columns of a row that are measured on a surface."""
    from testbed import registry
    from testbed.measures.counts import listed
    from testbed.plugins.measure import Measure, measure_all
    from testbed.plugins.spec import parse
    from testbed_reports.range_creases import largest_crease

    texts = (f"plane-side[plane={plane}]", *MEASURES)
    found = measure_all([parse(text, Measure, registry.load()) for text in texts], surface, exact)  # type: ignore[type-abstract]  # the kind is abstract
    names = {
        "lowest": "plane_min",
        "lowest_bound": "plane_min_low",
        "epsilon_deg": "epsilon_deg",
        "gap_max": "gap_max",
        "data_max": "vertex_distance_max",
        "rms": "distance_rms",
        "distance_max": "distance_max",
    }
    return {
        **{name: float(found.get(column, math.nan)) for name, column in names.items()},
        "crease_deg": largest_crease(surface),
        "patches": surface.patch_count,
        "branches": listed(surface.branches),
        "notes": listed(surface.notes),
    }


def moved(surface: "Surface", other: "Surface") -> float:
    """Return the largest distance between surfaces over one mesh at equal parameters, relative to its size."""
    import numpy as np

    from testbed.geometry.domain import barycentric, lattice
    from testbed.geometry.vectors import norm

    mesh = surface.mesh
    at = lattice(mesh.sides, STEPS)
    places = np.tile(barycentric(at) if mesh.sides == 3 else at, (len(mesh.faces), 1))
    face = np.repeat(np.arange(len(mesh.faces)), len(at))
    apart = norm(surface.evaluate(face, places, 0).f - other.evaluate(face, places, 0).f)
    return float(apart.max() / norm(np.ptp(mesh.points, axis=0)))


def rows_as_csv(rows: Iterable[RangeRow]) -> str:
    """Return the rows as a CSV file's text; a number that is not there is empty."""
    stream = io.StringIO()
    names = [field.name for field in dataclasses.fields(RangeRow)]
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(names)
    for row in rows:
        values = (getattr(row, name) for name in names)
        writer.writerow(["" if isinstance(one, float) and math.isnan(one) else one for one in values])
    return stream.getvalue()


def write_rows(directory: Path, rows: Iterable[RangeRow]) -> Path:
    """Write ``ranges.csv`` and return its path."""
    from testbed.harness.journal import write_whole

    path = directory / "ranges.csv"
    write_whole(path, rows_as_csv(rows))
    return path
