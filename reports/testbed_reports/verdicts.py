"""The verdicts on claims, drawn together over the datasets."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from testbed_reports.formatting import NOTHING, Entry, entry
from testbed_reports.grid import Grid, Row

#: Verdicts from worst to best, the ones that no measurement stands behind last.
RANKED: Final = ("missed", "met", "exceeded", "not testable", "not claimed")
#: What tells verdicts apart besides their words and colours.
SYMBOLS: Final[Mapping[str, str]] = {
    "missed": "✗",
    "met": "✓",
    "exceeded": "▲",
    "not testable": "?",
    "not claimed": NOTHING,
}
LEGEND: Final = (
    ("met", "measured as claimed"),
    ("exceeded", "better than claimed, or true without being claimed"),
    ("missed", "measured, and not as claimed"),
    ("not testable", "no measurement decides it; the reason says why"),
)


@dataclass(frozen=True)
class Judgement:
    """A verdict with what it holds for.

    Parameters
    ----------
    verdict
        ``met``, ``missed``, ``exceeded``, ``not testable``.
    claims
        The claims of one kind, without their kind: ``spheres``, ``planes``.
    datasets
        Where; empty if the claim was tested on none.
    everywhere
        Whether these are all datasets that the claims were judged on, and more than one.
    """

    verdict: str
    claims: tuple[str, ...]
    datasets: tuple[str, ...]
    everywhere: bool = False


@dataclass(frozen=True)
class Standing:
    """A scheme in the matrix of verdicts.

    Parameters
    ----------
    position, scheme, title, reference
        Which it is.
    cells
        For each kind of claim the judgements, worst first; none where the scheme claims nothing of the kind.
    counts
        Verdicts with their numbers, worst first.
    details
        Every verdict.
    """

    position: int
    scheme: str
    title: str
    reference: str
    cells: tuple[tuple[Judgement, ...], ...]
    counts: tuple[tuple[str, int], ...]
    details: tuple["Detail", ...]


@dataclass(frozen=True)
class Detail:
    """A verdict on one dataset, with the number that decided it."""

    claim: str
    dataset: str
    verdict: str
    measured: Entry
    reason: str


@dataclass(frozen=True)
class Matrix:
    """Schemes against kinds of claims."""

    kinds: tuple[str, ...]
    rows: tuple[Standing, ...]


def matrix(grid: Grid) -> Matrix:
    """Return the matrix of verdicts of a grid."""
    kinds = tuple(dict.fromkeys(_kind(row)[0] for row in grid.claims))
    standings = []
    for position, scheme in enumerate(grid.plan.schemes):
        own = [row for row in grid.claims if row["scheme"] == scheme.spec]
        cells = tuple(judgements(row for row in own if _kind(row)[0] == kind) for kind in kinds)
        details = tuple(
            Detail(row["claim"], row["dataset"], row["verdict"], entry(row["measured"]), row["reason"]) for row in own
        )
        standings.append(Standing(position, scheme.spec, scheme.title, scheme.reference, cells, count(own), details))
    return Matrix(kinds, tuple(standings))


def judgements(rows: Iterable[Row]) -> tuple[Judgement, ...]:
    """Draw verdicts of one kind together: those on the same datasets and of the same sort become one, worst first."""
    by_claim: dict[str, dict[str, list[str]]] = {}
    for row in rows:
        by_claim.setdefault(_kind(row)[1], {}).setdefault(row["verdict"], []).append(row["dataset"])
    groups: dict[tuple[str, tuple[str, ...], bool], list[str]] = {}
    for claim, verdicts in by_claim.items():
        for verdict, datasets in verdicts.items():
            named = tuple(filter(None, datasets))
            groups.setdefault((verdict, named, len(verdicts) == 1 and len(named) > 1), []).append(claim)
    found = [
        Judgement(verdict, tuple(claims), datasets, everywhere)
        for (verdict, datasets, everywhere), claims in groups.items()
    ]
    return tuple(sorted(found, key=lambda one: rank(one.verdict)))


def count(rows: Iterable[Row]) -> tuple[tuple[str, int], ...]:
    """Return how often each verdict was given, worst first."""
    numbers: dict[str, int] = {}
    for row in rows:
        numbers[row["verdict"]] = numbers.get(row["verdict"], 0) + 1
    return tuple(sorted(numbers.items(), key=lambda pair: rank(pair[0])))


def rank(verdict: str) -> int:
    """Return the place of a verdict among :data:`RANKED`; one that is not known comes last."""
    return RANKED.index(verdict) if verdict in RANKED else len(RANKED)


def _kind(row: Row) -> tuple[str, str]:
    """Return what a claim is about, and the claim: ``reproduces``, ``spheres``."""
    kind, _, claim = str(row["claim"]).partition(" ")
    return kind, claim
