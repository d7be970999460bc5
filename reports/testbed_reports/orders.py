"""Orders of convergence as they are shown."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from testbed_reports.formatting import NOTHING, Entry
from testbed_reports.grid import Grid


def order_entry(grid: Grid, scheme: str, dataset: str, quantity: str) -> Entry:
    """Return an order with its interval as an entry; where there is none, why."""
    row = grid.orders.get((scheme, dataset, quantity))
    if row is None:
        return Entry(NOTHING, "no measure gives this quantity")
    if row["order"] is None:
        return Entry(NOTHING, str(row["reason"]))
    order, low, high = float(row["order"]), float(row["low"]), float(row["high"])
    if math.isinf(order):
        return Entry("exact", "all errors are at the rounding floor")
    exact = f"{order!r}, from {low!r} to {high!r}, over levels {row['levels_used']}"
    return Entry(f"{order:.2f}", exact, place=f"[{low:.2f}, {high:.2f}]")


@dataclass(frozen=True)
class OrderRow:
    """An estimated order and what came of the claim."""

    position: int
    scheme: str
    quantity: str
    order: Entry
    levels_used: str
    claimed: Entry
    verdict: str
    reason: str


def every_order(grid: Grid, dataset: str) -> tuple[OrderRow, ...]:
    """Return all orders of a dataset."""
    return tuple(_orders(grid, dataset))


def _orders(grid: Grid, dataset: str) -> Iterator[OrderRow]:
    positions = {scheme: position for position, scheme in enumerate(grid.schemes)}
    for (scheme, on, quantity), row in grid.orders.items():
        if on == dataset:
            claimed = Entry(NOTHING) if row["claimed"] is None else Entry(f"{row['claimed']:g}")
            order = order_entry(grid, scheme, dataset, quantity)
            levels, why = str(row["levels_used"] or ""), str(row["reason"] or "")
            yield OrderRow(positions[scheme], scheme, quantity, order, levels, claimed, str(row["verdict"]), why)
