"""The comparison above planes as a page: one HTML file that holds everything it shows."""

import base64
import math
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

from testbed_reports.formatting import Entry, entry
from testbed_reports.range_summary import SchemeSummary, sentences, summaries
from testbed_reports.range_tables import SMOOTH_DEG, MeasuredSet, RangeRow

#: What the page is called.
NAME: Final = "ranges.html"
#: Headings of the schemes' numbers over all sets, and of a surface's.
HEADINGS: Final = (
    *("surfaces", "sets", "above", "proved", "smooth", "lowest", "edges °", "patches °", "data"),
    *("rms factor", "nearest", "known", "moved", "at most", "seconds"),
)
COLUMNS: Final = (
    *("lowest", "guaranteed", "edges °", "patches °", "gap", "data", "rms", "largest", "moved", "patches", "seconds"),
)


@dataclass(frozen=True)
class SchemeLine:
    """A scheme over all sets as the page shows it."""

    label: str
    uses: str
    entries: tuple[Entry, ...]
    branches: str


@dataclass(frozen=True)
class SurfaceLine:
    """A surface as the page shows it."""

    label: str
    status: str
    entries: tuple[Entry, ...]
    remark: str


@dataclass(frozen=True)
class SetSection:
    """A set as the page shows it; the picture is base64, or empty."""

    place: str
    plane: str
    faces: int
    rows: tuple[SurfaceLine, ...]
    picture: str


def write_page(directory: Path, found: Sequence[MeasuredSet]) -> Path:
    """Write ``ranges.html`` and return its path."""
    from testbed.harness.journal import write_whole

    path = directory / NAME
    write_whole(path, render(found))
    return path


def render(found: Sequence[MeasuredSet]) -> str:
    """Return the page as HTML; whatever schemes and data are called is text in it."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    folder = files("testbed_reports")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(folder.joinpath("ranges.html.j2").read_text("utf-8"))
    stylesheet = Markup(folder.joinpath("page.css").read_text("utf-8"))  # noqa: S704 - ours
    rows = [row for one in found for row in one.rows]
    return template.render(
        stylesheet=stylesheet,
        sentences=sentences(rows),
        smooth=f"{SMOOTH_DEG:g}",
        headings=HEADINGS,
        columns=COLUMNS,
        schemes=[_scheme(one) for one in summaries(rows)],
        texts=tuple({row.label: row.scheme.replace(row.plane, "PLANE") for row in rows}.items()),
        sets=[_set(one) for one in found if one.rows],
    )


def _scheme(one: SchemeSummary) -> SchemeLine:
    values = (
        *(one.built, one.sets, one.above, one.guaranteed, one.smooth),
        *(one.lowest, one.epsilon_deg, one.crease_deg, one.data_max, one.factor),
        *(one.nearest if one.known else None, one.known, one.moved, one.most_moved, one.seconds),
    )
    counts = ", ".join(f"{count} {kind}" for kind, count in one.branches)
    return SchemeLine(one.label, one.uses, tuple(map(_entry, values)), counts)


def _set(one: MeasuredSet) -> SetSection:
    first = one.rows[0]
    picture = base64.b64encode(one.picture).decode("ascii")
    return SetSection(first.place, first.plane, first.faces, tuple(map(_surface, one.rows)), picture)


def _surface(row: RangeRow) -> SurfaceLine:
    values = (
        *(row.lowest, row.lowest_bound, row.epsilon_deg, row.crease_deg, row.gap_max, row.data_max),
        *(row.rms, row.distance_max, row.moved, row.patches, row.seconds),
    )
    ways = "; ".join(filter(None, (row.branches, row.notes)))
    return SurfaceLine(row.label, row.status, tuple(map(_entry, values)), ways if row.status == "ok" else row.reason)


def _entry(value: float | None) -> Entry:
    """Return the entry of a number; a dash for none, also where it is NaN because there is no such number."""
    return entry(None if value is None or math.isnan(value) else value)
