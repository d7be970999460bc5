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


def _sentences(
    grid: Grid,
    families: Mapping[str, Mapping[str, str]],
    base: str,
    curves: Sequence[str],
    places: Sequence[tuple[str, int]],
) -> list[str]:
    column = QUANTITIES[0][0]
    sentences = []
    for at in places:
        values = scheme_values(grid, families, base, at, column)
        if len(values) < 2:
            continue
        low, high = min(values, key=values.__getitem__), max(values, key=values.__getitem__)
        medians = {
            curve: statistics.median(ratios)
            for curve in curves
            if (ratios := curve_ratios(grid, families, base, curve, at, column))
        }
        where = f"{at[0]}, level {at[1]}"
        text = (
            f"{where}: on {base} curves the {counted(len(values), 'scheme')} lie within a factor of "
            f"{shorten(values[high] / values[low])} ({low} to {high})"
        )
        helping = sorted((ratio, curve) for curve, ratio in medians.items() if ratio < HELPS[0])
        if helping:
            named = [f"{curve} by {shorten(1.0 / ratio)}" for ratio, curve in helping[:3]]
            text += f"; the error falls with {listed(named)} on {counted(len(helping), 'curve')} of {len(medians)}"
        else:
            text += "; no other curve lowers it" if medians else ""
        sentences.append(text + ".")
    return sentences
