"""The results by place: the row of a cell, of an order, and which levels can be compared."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from testbed.harness.plan import Plan
from testbed.harness.results import Results

if TYPE_CHECKING:
    import pandas as pd

#: A row of a table of the results, by column; what is missing is None.
Row: TypeAlias = Mapping[str, Any]

#: Share of the largest number of cells that a level needs for a comparison.
NEARLY: Final = 0.9


@dataclass(frozen=True)
class Grid:
    """Results as rows by place.

    Parameters
    ----------
    plan
        The plan.
    columns
        Columns of the cells, in order.
    cells
        Rows of the cells by scheme, dataset and level.
    orders
        Rows of the orders by scheme, dataset and quantity.
    claims
        Rows of the verdicts, in order.
    """

    plan: Plan
    columns: tuple[str, ...]
    cells: Mapping[tuple[str, str, int], Row]
    orders: Mapping[tuple[str, str, str], Row]
    claims: tuple[Row, ...]

    @classmethod
    def of(cls, results: Results) -> "Grid":
        """Return the grid of results."""
        return cls(
            results.plan,
            tuple(results.cells.columns),
            {(row["scheme"], row["dataset"], row["level"]): row for row in _rows(results.cells)},
            {(row["scheme"], row["dataset"], row["quantity"]): row for row in _rows(results.orders)},
            tuple(_rows(results.claims)),
        )

    @property
    def schemes(self) -> tuple[str, ...]:
        """Texts of the schemes, in the plan's order."""
        return tuple(scheme.spec for scheme in self.plan.schemes)

    @property
    def datasets(self) -> tuple[str, ...]:
        """Texts of the datasets, in the plan's order."""
        return tuple(dataset.spec for dataset in self.plan.datasets)

    def planned(self, scheme: str, dataset: str) -> bool:
        """Whether a scheme is compared on a dataset at all: those of other faces are apart."""
        return (scheme, dataset) in self.plan.pairs

    def circles(self) -> tuple[tuple[tuple[int, ...], tuple[str, ...]], ...]:
        """Positions of schemes that are compared with each other and the datasets that is done on.

        Schemes of triangles and of quadrilaterals share no dataset; each is in one circle. The largest comes first.
        """
        found: list[tuple[set[int], set[str]]] = []
        for position, scheme in enumerate(self.schemes):
            own = {dataset for dataset in self.datasets if self.planned(scheme, dataset)}
            positions, datasets = {position}, own
            apart = []
            for others, theirs in found:
                if datasets & theirs:
                    positions, datasets = positions | others, datasets | theirs
                else:
                    apart.append((others, theirs))
            found = [*apart, (positions, datasets)]
        return tuple(
            (tuple(sorted(positions)), tuple(dataset for dataset in self.datasets if dataset in datasets))
            for positions, datasets in sorted(found, key=lambda circle: (-len(circle[0]), min(circle[0])))
        )

    def shape(self, dataset: str) -> str | None:
        """What kind of surface a dataset was sampled from, as far as it declares that."""
        return next(one.shape for one in self.plan.datasets if one.spec == dataset)

    def levels(self, dataset: str) -> tuple[int, ...]:
        """Levels planned on a dataset, coarsest first."""
        return tuple(sorted({cell.level for cell in self.plan.cells if cell.dataset == dataset}))

    def at(self, dataset: str, level: int) -> tuple[Row | None, ...]:
        """Rows of a dataset's level, one a scheme; None where there is no result yet."""
        return tuple(self.cells.get((scheme, dataset, level)) for scheme in self.schemes)

    def on(self, dataset: str) -> Iterable[Row]:
        """Rows of a dataset, by scheme and level."""
        keys = ((scheme, dataset, level) for scheme in self.schemes for level in self.levels(dataset))
        return [self.cells[key] for key in keys if key in self.cells]

    def ok(self, scheme: str, dataset: str) -> tuple[Row, ...]:
        """Rows of a scheme's cells on a dataset that are ok, coarsest first."""
        rows = (self.cells.get((scheme, dataset, level)) for level in self.levels(dataset))
        return tuple(row for row in rows if row is not None and row["status"] == "ok")

    def compared(self, dataset: str) -> int | None:
        """Return the level to compare schemes at; None if no cell is ok.

        It is the finest of those on which nearly as many cells are ok as on any: a scheme that takes special data only
        does not keep the others on a coarse level.
        """
        counts = {level: sum(is_ok(row) for row in self.at(dataset, level)) for level in self.levels(dataset)}
        most = max(counts.values(), default=0)
        return max(level for level, count in counts.items() if count >= NEARLY * most) if most else None


def is_ok(row: Row | None) -> bool:
    """Whether there is a result and it is ok."""
    return row is not None and row["status"] == "ok"


def _rows(table: "pd.DataFrame") -> list[dict[str, Any]]:
    """Return the rows of a table; NaN and NA become None, the one value that compares and formats safely."""
    absent = table.isna().to_numpy()
    names = [str(name) for name in table.columns]
    return [
        {name: None if gone else value for name, value, gone in zip(names, values, lacks, strict=True)}
        for values, lacks in zip(table.itertuples(index=False, name=None), absent, strict=True)
    ]
