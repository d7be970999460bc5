"""What stands out, in words and in one small table, all of it computed from the results."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from testbed_reports.formatting import counted, listed, shorten
from testbed_reports.grid import Grid
from testbed_reports.tables import Quantity, score
from testbed_reports.verdicts import count

#: What a scheme can be best at: heading, its name in a sentence, the quantity.
CONTESTS: Final = (
    ("distance max", "the smallest distance to the exact surface", Quantity("distance_max", "", "", "least")),
    ("normal error max (°)", "the smallest normal error", Quantity("normal_max_deg", "", "", "least")),
    (
        "error of Gaussian curvature, rms",
        "the least error of the Gaussian curvature",
        Quantity("gauss_error_rms", "", "", "least"),
    ),
)
#: As many schemes, datasets or claims are named in a sentence; more are counted.
MOST_NAMED: Final = 3


@dataclass(frozen=True)
class Winner:
    """Who is best at something on a dataset.

    Parameters
    ----------
    schemes
        Positions and texts of the schemes whose values read the same.
    value, exact
        The value.
    ranked
        How many schemes could be ranked.
    """

    schemes: tuple[tuple[int, str], ...]
    value: str
    exact: str
    ranked: int

    @property
    def alike(self) -> bool:
        """Whether most schemes are as good, so that being among them does not stand out."""
        return 2 * len(self.schemes) > self.ranked


@dataclass(frozen=True)
class Contest:
    """A dataset with its winners, one for each of :data:`CONTESTS`; None where nothing can be ranked."""

    dataset: str
    number: int
    level: int
    winners: tuple[Winner | None, ...]


def contests(grid: Grid) -> tuple[Contest, ...]:
    """Return the winners on each dataset, at the level its schemes are compared at."""
    found = []
    for number, dataset in enumerate(grid.datasets):
        level = grid.compared(dataset)
        if level is not None:
            winners = tuple(_winner(grid, dataset, level, quantity) for _, _, quantity in CONTESTS)
            found.append(Contest(dataset, number, level, winners))
    return tuple(found)


def _winner(grid: Grid, dataset: str, level: int, quantity: Quantity) -> Winner | None:
    scores = [score(row, quantity, grid.shape(dataset)) for row in grid.at(dataset, level)]
    ranked = [(value, position) for position, value in enumerate(scores) if value is not None]
    if len(ranked) < 2:  # one alone wins nothing
        return None
    least = min(ranked)[0]
    same = tuple((place, grid.schemes[place]) for value, place in ranked if shorten(value) == shorten(least))
    return Winner(same, shorten(least), repr(least), len(ranked))


def sentences(grid: Grid, missing: int) -> tuple[str, ...]:
    """Return the summary.

    Parameters
    ----------
    grid
        The results.
    missing
        How many cells have no result yet.
    """
    return tuple(_sentences(grid, missing))


def _sentences(grid: Grid, missing: int) -> Iterator[str]:
    counts: dict[str, int] = dict.fromkeys(("ok", "refused", "failed"), 0)
    for row in grid.cells.values():
        counts[row["status"]] = counts.get(row["status"], 0) + 1
    numbers = ", ".join(f"{number or 'none'} {status}" for status, number in counts.items())
    schemes, datasets = counted(len(grid.schemes), "scheme"), counted(len(grid.datasets), "dataset")
    yield f"{schemes} on {datasets}, {counted(len(grid.plan.cells), 'cell')}: {numbers}."
    if missing:
        yield f"{counted(missing, 'cell')} {'has' if missing == 1 else 'have'} no result yet."
    yield from _victories(grid)
    if grid.claims:
        given = ", ".join(f"{number} {verdict}" for verdict, number in count(grid.claims))
        yield f"{counted(len(grid.claims), 'verdict')} on claims: {given}."
    missed: dict[tuple[str, str], list[str]] = {}
    for row in grid.claims:
        if row["verdict"] == "missed":
            missed.setdefault((row["scheme"], row["claim"]), []).append(row["dataset"])
    if missed:
        yield f"Missed: {_some([f'{who}, {what}, on {_on(on)}' for (who, what), on in missed.items()])}."


def _victories(grid: Grid) -> Iterator[str]:
    found = contests(grid)
    for number, (_, phrase, _) in enumerate(CONTESTS):
        held = [(one.dataset, winner) for one in found if (winner := one.winners[number]) is not None]
        by_scheme: dict[str, list[str]] = {}
        for dataset, winner in held:
            if winner is not None and not winner.alike:
                for _, scheme in winner.schemes:
                    by_scheme.setdefault(scheme, []).append(dataset)
        if by_scheme:
            ordered = sorted(by_scheme.items(), key=lambda item: (-len(item[1]), item[0]))
            parts = [f"{who} on {_on(won, len(held))}" for who, won in ordered]
            yield f"{phrase[0].upper()}{phrase[1:]}: {_some(parts)}."


def _some(parts: list[str]) -> str:
    rest = len(parts) - MOST_NAMED
    return "; ".join([*parts[:MOST_NAMED], *([f"and {rest} more"] if rest > 0 else [])])


def _on(datasets: list[str], total: int | None = None) -> str:
    if len(datasets) == total and total > 1:
        return f"all {total} datasets"
    if len(datasets) <= MOST_NAMED:
        return listed(datasets)
    return f"{len(datasets)} datasets" if total is None else f"{len(datasets)} of {total} datasets"
