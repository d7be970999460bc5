"""What matters more, the scheme or its boundary curves: errors of the same scheme on different curves, and the reverse.

Mann's survey of 1992 found that all schemes with continuous tangent planes share the same defects, and that better
boundary curves help on spheres and not on the torus. A run with ``-b`` has what it takes to test that: each scheme on
several curves. Only schemes that claim at least tangent plane continuity take part.
"""

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from testbed_reports.formatting import Entry, counted, listed, shorten
from testbed_reports.grid import Grid, is_ok

#: What is compared, and what it is called.
QUANTITIES: Final = (
    ("gauss_error_rms", "error of the Gaussian curvature, root mean square"),
    ("gauss_error_max", "largest error of the Gaussian curvature"),
    ("distance_max", "largest distance"),
)
#: A median factor below the first helps, above the second harms.
HELPS: Final = (0.8, 1.25)


@dataclass(frozen=True)
class Effect:
    """A row of a table of effects: a curve or a scheme, and an entry for each place."""

    name: str
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Comparison:
    """The effects on one quantity.

    Parameters
    ----------
    quantity
        What it is called.
    curves
        For each other curve the median, over the schemes, of the error on it over that on the usual curve.
    schemes
        For each scheme its error on the usual curve over the median of all schemes there.
    """

    quantity: str
    curves: tuple[Effect, ...]
    schemes: tuple[Effect, ...]


@dataclass(frozen=True)
class Findings:
    """What the scheme does and what the curves do.

    Parameters
    ----------
    base
        The usual curve, the default of most schemes.
    places
        Datasets and levels.
    comparisons
        One a quantity.
    sentences
        The conclusion in words.
    """

    base: str
    places: tuple[tuple[str, int], ...]
    comparisons: tuple[Comparison, ...]
    sentences: tuple[str, ...]


def findings(grid: Grid) -> Findings | None:
    """Return the findings of a run, or None if it has no two schemes on two curves each."""
    variants = _variants(grid)
    usual = Counter(
        scheme.boundary
        for scheme in grid.plan.schemes
        if scheme.boundary and scheme.family == scheme.spec and scheme.family in variants
    )
    if not usual:
        return None
    base = min(usual, key=lambda curve: (-usual[curve], curve))
    families = {family: curves for family, curves in variants.items() if base in curves and len(curves) > 1}
    places = [
        (dataset, level)
        for dataset in grid.datasets
        if grid.shape(dataset) != "planes"
        for level in sorted({min(grid.levels(dataset), default=0), grid.compared(dataset) or 0})
        if any(
            is_ok(row) and row is not None and row.get(QUANTITIES[0][0]) is not None for row in grid.at(dataset, level)
        )
    ]
    if len(families) < 2 or not places:
        return None
    curves = sorted({curve for known in families.values() for curve in known} - {base})
    comparisons = []
    for column, phrase in QUANTITIES:
        if column in grid.columns:
            by_curve = [
                Effect(curve, tuple(_curve_entry(grid, families, base, curve, at, column) for at in places))
                for curve in curves
            ]
            by_scheme = [
                Effect(family, tuple(_scheme_entry(grid, families, base, family, at, column) for at in places))
                for family in families
            ]
            comparisons.append(Comparison(phrase, tuple(by_curve), tuple(by_scheme)))
    return Findings(base, tuple(places), tuple(comparisons), tuple(_sentences(grid, families, base, curves, places)))


def _variants(grid: Grid) -> dict[str, dict[str, str]]:
    """Texts of the schemes with continuous tangent planes, by family and curve."""
    result: dict[str, dict[str, str]] = {}
    for scheme in grid.plan.schemes:
        if scheme.boundary and scheme.continuity != "C0":
            result.setdefault(scheme.family, {})[scheme.boundary] = scheme.spec
    return result


def _value(grid: Grid, scheme: str, at: tuple[str, int], column: str) -> float | None:
    row = grid.cells.get((scheme, *at))
    value = row.get(column) if row is not None and is_ok(row) else None
    return float(value) if value is not None and float(value) > 0.0 else None


def curve_ratios(
    grid: Grid, families: Mapping[str, Mapping[str, str]], base: str, curve: str, at: tuple[str, int], column: str
) -> list[float]:
    """Return for each scheme that has both its error on a curve over that on the usual curve, in rising order."""
    ratios = []
    for curves in families.values():
        if curve in curves:
            here, usual = _value(grid, curves[curve], at, column), _value(grid, curves[base], at, column)
            if here is not None and usual is not None:
                ratios.append(here / usual)
    return sorted(ratios)


def scheme_values(
    grid: Grid, families: Mapping[str, Mapping[str, str]], base: str, at: tuple[str, int], column: str
) -> dict[str, float]:
    """Return the errors of the schemes on the usual curve."""
    found = {family: _value(grid, curves[base], at, column) for family, curves in families.items()}
    return {family: value for family, value in found.items() if value is not None}


def _curve_entry(
    grid: Grid, families: Mapping[str, Mapping[str, str]], base: str, curve: str, at: tuple[str, int], column: str
) -> Entry:
    ratios = curve_ratios(grid, families, base, curve, at, column)
    if not ratios:
        return Entry("–", "no scheme has a surface on both curves")
    middle = statistics.median(ratios)
    span = f"[{shorten(ratios[0])}, {shorten(ratios[-1])}]"
    return Entry(shorten(middle), f"{middle!r}, median of {counted(len(ratios), 'scheme')}", middle < HELPS[0], span)


def _scheme_entry(
    grid: Grid, families: Mapping[str, Mapping[str, str]], base: str, family: str, at: tuple[str, int], column: str
) -> Entry:
    values = scheme_values(grid, families, base, at, column)
    if family not in values:
        return Entry("–", "no surface")
    ratio = values[family] / statistics.median(values.values())
    return Entry(shorten(ratio), repr(ratio), ratio < HELPS[0])


@dataclass(frozen=True)
class _Place:
    """What was found at a place: the schemes' errors on the usual curve, and the medians of the other curves."""

    at: tuple[str, int]
    values: Mapping[str, float]
    medians: Mapping[str, float]

    @property
    def factor(self) -> float:
        """Largest of the schemes' errors on the usual curve over the least."""
        return max(self.values.values()) / min(self.values.values())

    @property
    def gain(self) -> float:
        """Factor by which the best of the other curves lowers the error."""
        return 1.0 / min(self.medians.values())


def _sentences(
    grid: Grid,
    families: Mapping[str, Mapping[str, str]],
    base: str,
    curves: Sequence[str],
    places: Sequence[tuple[str, int]],
) -> list[str]:
    """Return a conclusion for each quantity, and what was found about the first at each place."""
    conclusions: list[str] = []
    details: list[str] = []
    for column, phrase in QUANTITIES:
        if column in grid.columns:
            found = _found(grid, families, base, curves, places, column)
            conclusions += _conclusion(grid, base, found, phrase)
            details = details or [_sentence(base, one) for one in found]
    return [*conclusions, *details]


def _found(
    grid: Grid,
    families: Mapping[str, Mapping[str, str]],
    base: str,
    curves: Sequence[str],
    places: Sequence[tuple[str, int]],
    column: str,
) -> list[_Place]:
    found = []
    for at in places:
        medians = {
            curve: statistics.median(ratios)
            for curve in curves
            if (ratios := curve_ratios(grid, families, base, curve, at, column))
        }
        one = _Place(at, scheme_values(grid, families, base, at, column), medians)
        if len(one.values) > 1 and one.medians:
            found.append(one)
    return found


def _sentence(base: str, one: _Place) -> str:
    low, high = min(one.values, key=one.values.__getitem__), max(one.values, key=one.values.__getitem__)
    helping = sorted((ratio, curve) for curve, ratio in one.medians.items() if ratio < HELPS[0])
    named = [f"{curve} by {shorten(1.0 / ratio)}" for ratio, curve in helping[:3]]
    curves = (
        f"the error falls with {listed(named)}, {counted(len(helping), 'curve')} of {len(one.medians)} lower it"
        if helping
        else f"none of {counted(len(one.medians), 'other curve')} lowers it by a fifth"
    )
    return (
        f"{one.at[0]}, level {one.at[1]}: on {base} curves the {counted(len(one.values), 'scheme')} lie within a "
        f"factor of {shorten(one.factor)} ({low} to {high}); {curves}."
    )


def _conclusion(grid: Grid, base: str, found: Sequence[_Place], phrase: str) -> list[str]:
    """Return how far schemes differ and where curves help; of curvature, whether the survey's finding holds."""
    if not found:
        return []
    factors = sorted(one.factor for one in found)
    told = (
        f"{phrase[0].upper()}{phrase[1:]}: on {base} curves the schemes differ by factors of {shorten(factors[0])} to "
        f"{shorten(factors[-1])}."
    )
    helped = {one.at[0] for one in found if one.gain > 1.0 / HELPS[0]}
    datasets = list(dict.fromkeys(one.at[0] for one in found))
    with_help, without = [d for d in datasets if d in helped], [d for d in datasets if d not in helped]
    gains = sorted(one.gain for one in found if one.gain > 1.0 / HELPS[0])
    parts = []
    if with_help:
        parts.append(
            f"help on {listed(with_help)}, the best of them by factors of {shorten(gains[0])} to {shorten(gains[-1])}"
        )
    if without:
        parts.append(f"do not on {listed(without)}")
    told += f" Other curves {', and '.join(parts)}."
    spheres = {dataset for dataset in datasets if grid.shape(dataset) == "spheres"}
    if phrase == QUANTITIES[0][1] and spheres and len(spheres) < len(datasets):
        told += (
            " The survey's finding, that better boundary curves help on spheres and not on other surfaces, "
            f"{'holds' if helped == spheres else 'does not hold'} here."
        )
    return [told]
