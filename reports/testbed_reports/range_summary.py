"""What the comparison above planes says: a line of numbers for each scheme, and sentences."""

import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from testbed_reports.formatting import counted, listed, shorten
from testbed_reports.range_comparison import Uses
from testbed_reports.range_tables import SMOOTH_DEG, RangeRow

#: What stands before the sentences about schemes that take the points alone, and about those that use normals.
FROM: Final[dict[Uses, str]] = {"points": "From the points alone", "normals": "With the normals of the data"}


@dataclass(frozen=True)
class SchemeSummary:
    """A scheme over all sets; NaN where there is no such number.

    Parameters
    ----------
    label, uses
        The scheme.
    sets, refused, failed
        Sets that it was asked for, and those without a surface.
    above, guaranteed, smooth
        Surfaces of which nothing was found below the plane, of which that is proved, and without any jump of normals.
    lowest, epsilon_deg, crease_deg, data_max
        The worst of all surfaces.
    nearest, known
        Sets on which it is nearest to the truth (root mean square; those that read the same share the place), out of
        those with a known truth on which all schemes have a surface that take as much of the data and have any.
    factor
        Geometric mean of its root mean square distance over the least that any of these has, on the same sets.
    moved, most_moved
        Median and largest of how far constraint or remedy moved the surface.
    seconds
        Median.
    branches
        Ordinary ways and fallbacks of its constructions, counted over all sets.
    """

    label: str
    uses: Uses
    sets: int
    refused: int
    failed: int
    above: int
    guaranteed: int
    smooth: int
    lowest: float
    epsilon_deg: float
    crease_deg: float
    data_max: float
    nearest: int
    known: int
    factor: float
    moved: float
    most_moved: float
    seconds: float
    branches: tuple[tuple[str, int], ...]

    @property
    def built(self) -> int:
        """Sets with a surface."""
        return self.sets - self.refused - self.failed


def summaries(rows: Sequence[RangeRow]) -> tuple[SchemeSummary, ...]:
    """Return the schemes' summaries, in the order of the rows."""
    return tuple(_summary(label, rows) for label in dict.fromkeys(row.label for row in rows))


def _summary(label: str, rows: Sequence[RangeRow]) -> SchemeSummary:
    own = [row for row in rows if row.label == label]
    ok = [row for row in own if row.status == "ok"]
    rivals = [row for row in rows if row.uses == own[0].uses]
    known = [(row, least) for row in ok if not math.isnan(least := _least(row, rivals))]
    factors = [row.rms / least for row, least in known if least > 0.0]
    distances = [row.moved for row in ok if row.against and not math.isnan(row.moved)]
    counts: Counter[str] = Counter()
    for row in ok:
        for text in filter(None, (*row.branches.split("; "), *row.notes.split("; "))):
            number, _, kind = text.partition(" ")
            counts[kind] += int(number)
    return SchemeSummary(
        label,
        own[0].uses,
        len(own),
        sum(row.status == "refused" for row in own),
        sum(row.status == "failed" for row in own),
        sum(row.above for row in ok),
        sum(row.guaranteed for row in ok),
        sum(row.smooth for row in ok),
        -_largest(-row.lowest for row in ok),
        _largest(row.epsilon_deg for row in ok),
        _largest(row.crease_deg for row in ok),
        _largest(row.data_max for row in ok),
        sum(shorten(row.rms) == shorten(least) for row, least in known),
        len(known),
        statistics.geometric_mean(factors) if factors else math.nan,
        statistics.median(distances) if distances else math.nan,
        _largest(distances),
        statistics.median(row.seconds for row in ok) if ok else math.nan,
        tuple(sorted(counts.items())),
    )


def _least(row: RangeRow, rivals: Sequence[RangeRow]) -> float:
    """Return the least root mean square distance on the set of a row, NaN unless all have one that have any surface."""
    built = {one.label for one in rivals if one.status == "ok"}
    there = {one.label: one.rms for one in rivals if (one.place, one.plane) == (row.place, row.plane)}
    distances = [there.get(label, math.nan) for label in built]
    return math.nan if any(map(math.isnan, distances)) else min(distances, default=math.nan)


def _largest(values: Iterable[float]) -> float:
    """Return the largest value, NaN if there is a NaN or nothing."""
    found = list(values)
    return math.nan if not found or any(math.isnan(one) for one in found) else max(found)


def sentences(rows: Sequence[RangeRow]) -> tuple[str, ...]:
    """Return who stays positive, who stays smooth, who is nearer the truth, and what that moved, in words."""
    schemes = summaries(rows)
    result = [_positive(schemes), _smooth(schemes)]
    for uses, opening in FROM.items():
        own = [one for one in schemes if one.uses == uses and one.known]
        if own:
            result.append(_truth(opening, own))
    changed = [one for one in schemes if not math.isnan(one.moved)]
    if changed:
        told = (f"{one.label} by {_share(one.moved)} (at most {_share(one.most_moved)})" for one in changed)
        result.append(f"How far constraint or remedy moved the surface, median over the sets: {listed([*told])}.")
    return tuple(filter(None, result))


def _positive(schemes: Sequence[SchemeSummary]) -> str:
    parts = []
    for one in filter(lambda one: one.built, schemes):
        below = one.built - one.above
        if below:
            parts.append(f"{one.label} crosses the plane on {_of(below, one)}, down to {shorten(one.lowest)}")
        elif one.guaranteed == one.built:
            parts.append(f"{one.label} stays above on {_of(one.above, one)}, which is proved")
        else:
            proved = f"proved on {one.guaranteed}" if one.guaranteed else "not proved"
            parts.append(f"{one.label} was found below on none of {one.built}, {proved}")
    return f"Who stays above the plane: {'; '.join(parts)}."


def _of(count: int, one: SchemeSummary) -> str:
    without = f" ({counted(one.sets - one.built, 'set')} without a surface)" if one.built < one.sets else ""
    return f"{count} of {counted(one.built, 'set')}{without}"


def _smooth(schemes: Sequence[SchemeSummary]) -> str:
    built = [one for one in schemes if one.built]
    smooth = [one.label for one in built if one.smooth == one.built]
    parts = (
        [f"{listed(smooth)} on all sets (jumps up to {SMOOTH_DEG:g}° count as none)"]
        if smooth
        else ["nobody on all sets"]
    )

    def angle(one: SchemeSummary, get: Callable[[SchemeSummary], float], where: str) -> str:
        value = get(one)
        return "" if value <= SMOOTH_DEG else f"{shorten(value)}° {where}"

    for one in built:
        if one.smooth < one.built:
            jumps = (
                angle(one, lambda s: s.epsilon_deg, "across edges"),
                angle(one, lambda s: s.crease_deg, "inside patches"),
            )
            parts.append(f"{one.label} jumps by up to {listed([*filter(None, jumps)])}")
    return f"Who stays smooth: {'; '.join(parts)}."


def _truth(opening: str, schemes: Sequence[SchemeSummary]) -> str:
    order = sorted(schemes, key=lambda one: one.factor)
    told = (f"{one.label} {shorten(one.factor)} (nearest on {one.nearest})" for one in order)
    return (
        f"{opening}, who is nearer the truth (root mean square distance over the least on each set, geometric mean "
        f"over the {counted(order[0].known, 'set')} where it is known and all have a surface): {listed([*told])}."
    )


def _share(value: float) -> str:
    return f"{shorten(100.0 * value)} % of the size"
