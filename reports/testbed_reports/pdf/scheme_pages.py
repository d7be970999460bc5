"""The chapter of the schemes: construction, claims with verdicts, and numbers on every dataset."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from testbed import registry
from testbed.errors import TestbedError
from testbed.harness.plan import PlannedScheme
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.formatting import NOTHING, Entry
from testbed_reports.pdf import lettering, widths
from testbed_reports.pdf.blocks import (
    UPRIGHT,
    Block,
    Cell,
    Column,
    Facts,
    Folio,
    Heading,
    Link,
    Name,
    Paragraph,
    Picture,
    Pictures,
    Runs,
    Swatch,
    Table,
    runs,
    value,
)
from testbed_reports.pdf.figures import Figures, picture_file
from testbed_reports.pdf.grids import numbers
from testbed_reports.pdf.opening import dataset_label, mark, scheme_label
from testbed_reports.verdicts import Detail, Standing, rank
from testbed_reports.view import Page

#: Columns of a scheme's table: group and heading in the datasets' tables, and heading here.
SHOWN: Final = (
    ("distance", "max", "distance max"),
    ("distance", "order", "order"),
    ("", "normal error (°)", "normal error (°)"),
    ("Gaussian curvature", "min", "K min"),
    ("Gaussian curvature", "max", "K max"),
    ("error of Gaussian curvature", "rms", "K error rms"),
    ("", "normal jump ε (°)", "normal jump ε (°)"),
)
#: Pictures in a row, and all that are shown of a scheme.
IN_ROW: Final = 6
MOST_PICTURES: Final = 12
#: As many datasets are named, and reasons told, of a verdict; more are counted.
MOST_NAMED: Final = 4
MOST_REASONS: Final = 3


@dataclass(frozen=True)
class Description:
    """What a scheme says of itself; ``remark`` tells where that may not be what the results were computed with."""

    formula: str
    status: str
    failures: str
    remark: str


def descriptions(results: Results, sources: Sources) -> tuple[Description, ...]:
    """Return what the schemes of a plan say of themselves, as far as they are registered here."""
    return tuple(_description(one, sources) for one in results.plan.schemes)


def _description(planned: PlannedScheme, sources: Sources) -> Description:
    try:
        scheme = registry.scheme(planned.spec)
        same = sources.content(scheme) == planned.source
    except TestbedError as error:
        return Description("", "", "", f"Its formula cannot be told: {error}")
    remark = "" if same else "Its source has changed since the results were computed; the words are today's."
    return Description(scheme.formula, scheme.status, scheme.failures, remark)


def schemes(
    page: Page, described: Sequence[Description], planned: Sequence[PlannedScheme], drawn: Sequence[Figures]
) -> Iterator[Folio]:
    """Yield the pages of each scheme."""
    for standing, description, plan in zip(page.matrix.rows, described, planned, strict=True):
        chapter = () if standing.position else (Heading(1, runs("Schemes"), "schemes"),)
        yield Folio((*chapter, *_scheme(page, standing, description, plan, drawn)))


def _scheme(
    page: Page, standing: Standing, description: Description, plan: PlannedScheme, drawn: Sequence[Figures]
) -> Iterator[Block]:
    position = standing.position
    title = runs(Swatch(position), f" {standing.title} ", Name(standing.scheme))
    yield Heading(2, title, scheme_label(position))
    facts = [("Citation", runs(standing.reference))]
    for name, text in (
        ("Formula", description.formula),
        ("Status", description.status),
        ("Fails", description.failures),
        ("Boundary", plan.boundary),
        ("Claims", _claimed(plan)),
    ):
        if text:
            facts.append((name, runs(Name(text) if name == "Boundary" else text)))
    yield Facts(tuple(facts))
    if description.remark:
        yield Paragraph(runs(description.remark), small=True)
    yield from _pictures(page, standing, drawn)
    yield from _verdicts(page, standing)
    yield from _numbers(page, standing)


def _claimed(plan: PlannedScheme) -> str:
    parts = [f"continuity {plan.continuity}"]
    if plan.order is not None:
        parts.append(f"order {plan.order:g}")
    if plan.reproduces:
        parts.append(f"reproduces {', '.join(plan.reproduces)}")
    if plan.matches:
        parts.append(f"matches {', '.join(word.lower().replace('_', ' ') for word in plan.matches)}")
    return "; ".join(parts) + "."


def _pictures(page: Page, standing: Standing, drawn: Sequence[Figures]) -> Iterator[Block]:
    """Yield the shaded surfaces of a scheme on the first datasets."""
    found: list[tuple[Picture, float]] = []
    for number, (section, figures) in enumerate(zip(page.sections, drawn, strict=True)):
        for place, shot in enumerate(figures.strip.shots if figures.strip else ()):
            if shot.scheme == standing.scheme and shot.images and figures.strip:
                title = lettering.shortened(f"{section.dataset.spec}, level {figures.strip.level}", 44)
                found.append((Picture(title, picture_file(number, place, 0), ""), figures.strip.aspect))
    if found:
        shown = found[:MOST_PICTURES]
        more = f" The first {len(shown)} of {len(found)} datasets." if len(found) > len(shown) else ""
        yield Pictures(
            f"scheme-pictures-{standing.position}",
            runs("Surfaces of ", Name(standing.scheme), f" on the datasets, shaded.{more}"),
            tuple(picture for picture, _ in shown),
            IN_ROW,
            max(aspect for _, aspect in shown),
        )


def _verdicts(page: Page, standing: Standing) -> Iterator[Block]:
    groups: dict[tuple[str, str], list[Detail]] = {}
    for one in standing.details:
        groups.setdefault((one.claim, one.verdict), []).append(one)
    if not groups:
        yield Paragraph(runs("No verdict on its claims can be given yet."), small=True)
        return
    # claims of which the same is to be told share a row
    rows: dict[tuple[str, Cell | str, str, str], list[str]] = {}
    for (claim, verdict), some in sorted(groups.items(), key=lambda item: rank(item[0][1])):
        judged = {one.dataset for one in standing.details if one.claim == claim}
        told = (verdict, _datasets(page, some, len(judged)), _measured(some), _reasons(verdict, some))
        rows.setdefault(told, []).append(claim)
    columns = (Column(share=1.2), Column(width=66.0), Column(share=1.8), Column(share=1.0), Column(share=2.4))
    yield Table(
        f"claims-{standing.position}",
        runs("Claims of ", Name(standing.scheme), " with their verdicts, and the range of what was measured."),
        columns,
        (("claim", "verdict", "datasets", "measured", "reason"),),
        tuple(
            (", ".join(claims), Cell((mark(page, verdict),)), where, measured, reasons)
            for (verdict, where, measured, reasons), claims in rows.items()
        ),
        7.5,
    )


def _datasets(page: Page, some: Sequence[Detail], judged: int) -> str | Cell:
    """Return on which datasets a verdict was given; many are counted, if they are most: the others have rows."""
    named = [one.dataset for one in some if one.dataset]
    if not named:
        return NOTHING
    if len(named) > MOST_NAMED and 2 * len(named) > judged:
        return f"all {judged}" if len(named) == judged else f"{len(named)} of {judged}, all but those of other rows"
    number = {section.dataset.spec: place for place, section in enumerate(page.sections)}
    parts: Runs = ()
    for place, name in enumerate(named):
        link = Link(dataset_label(number[name]), name) if name in number else Name(name)
        parts = (*parts, *runs(*([", "] if place else []), link))
    return Cell(parts)


def _measured(some: Sequence[Detail]) -> str:
    found = [(float(one.measured.exact), one.measured.text) for one in some if _is_number(one.measured)]
    if not found:
        return next((one.measured.text for one in some), NOTHING)
    least, most = min(found)[1], max(found)[1]
    return lettering.number(least if least == most else f"{least} to {most}")


def _is_number(entry: Entry) -> bool:
    try:
        float(entry.exact)
    except ValueError:
        return False
    return True


def _reasons(verdict: str, some: Sequence[Detail]) -> str:
    if verdict == "met":
        return ""
    different: dict[str, str] = {}
    for one in some:
        if one.reason:
            different.setdefault(lettering.numberless(one.reason), one.reason)
    reasons = list(different.values())
    more = f"; and {len(reasons) - MOST_REASONS} more" if len(reasons) > MOST_REASONS else ""
    return "; ".join(reasons[:MOST_REASONS]) + more


def _numbers(page: Page, standing: Standing) -> Iterator[Block]:
    firsts, rows, troubles, names = [], [], [], []
    for number, section in enumerate(page.sections):
        row = (
            next((one for one in section.table.rows if one.position == standing.position), None)
            if section.table
            else None
        )
        if row is None or section.table is None:
            continue
        heads = _keys(section.table.groups, section.table.headings)
        entries: Mapping[tuple[str, str], Entry] = dict(zip(heads, row.entries, strict=False))
        firsts.append(Cell(runs(Link(dataset_label(number), section.dataset.spec))))
        names.append(section.dataset.spec)
        shown = (entries.get((group, heading), Entry(NOTHING)) for group, heading, _ in SHOWN)
        rows.append(() if row.trouble else (str(section.level), *(value(entry, place=False) for entry in shown)))
        troubles.append(row.trouble and f"{row.trouble.partition(': ')[0]}; the appendix has the reason")
    if not rows:
        return
    size = 7.5
    yield from numbers(
        f"numbers-{standing.position}",
        f"{standing.scheme} on each dataset, at the level where schemes are compared. Bold: best of all schemes there.",
        firsts,
        widths.of_names(names, size, swatch=False),
        ["level", *(shown for _, _, shown in SHOWN)],
        rows,
        UPRIGHT[0],
        size,
        first="dataset",
        troubles=troubles,
    )


def _keys(groups: Sequence[tuple[str, int]], headings: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Group and heading of each column."""
    over = [group for group, width in groups for _ in range(width)]
    return [(group, heading) for group, (heading, _) in zip(over, headings, strict=True)]
