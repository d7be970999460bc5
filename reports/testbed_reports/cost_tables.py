"""Tables 5.2 and 5.3 of the thesis, storage and evaluation of S-patches and of cubic triangles, next to our counts."""

from dataclasses import dataclass
from decimal import Decimal

from testbed.errors import TestbedError
from testbed.geometry.costs import PatchCost, SurfaceCost, network_cost, shared_cubic_points
from testbed.geometry.network_charts import NetworkCharts
from testbed.geometry.spline_network import SplineNetwork
from testbed.plugins.dataset import Dataset
from testbed_reports.published import rounds_to
from testbed_reports.published_table import DerivedFigure, Source, published_table


@dataclass(frozen=True)
class CostRow:
    """A number of a cost table.

    Parameters
    ----------
    patches
        Which patches it is about.
    quantity
        What it is.
    measured
        Our count.
    printed
        As printed, ``1.1E+3`` for "about 1100"; empty where there is nothing printed.
    explanation
        Why ours is another number; empty where they agree.
    """

    patches: str
    quantity: str
    measured: float
    printed: str = ""
    explanation: str = ""

    @property
    def agrees(self) -> bool:
        """Whether ours rounds to the printed number."""
        return not self.printed or rounds_to(self.measured, self.printed)

    @property
    def printed_text(self) -> str:
        """The printed number as a reader has it."""
        return f"about {Decimal(self.printed):.0f}" if "E" in self.printed else self.printed


def network_of(dataset: Dataset) -> SplineNetwork:
    """Return the S-patches that a dataset is sampled from; TestbedError if it is not."""
    charted = dataset.charted()
    if charted is None or not isinstance(charted.charts, NetworkCharts):
        raise TestbedError(f"{dataset} is no network of S-patches: take branch, ring or network:PATH")
    return charted.charts.network


def cost_rows(dataset: Dataset, triangles: int | None = None) -> tuple[CostRow, ...]:
    """Count what the S-patches of a dataset cost, and what cubic triangles in their place do.

    Parameters
    ----------
    dataset
        A network of S-patches.
    triangles
        Cubic triangles of the approximation; by default as many as printed, or as the coarsest tessellation has.

    Raises
    ------
    TestbedError
        The dataset is no network of S-patches.
    """
    network, printed = network_of(dataset), printed_triangles(str(dataset))
    cost = network_cost(network)
    if triangles is None:
        triangles = cost.triangles if printed is None else printed
    numbers = {**_patches(cost), **_triangles(triangles, shared_cubic_points(network, triangles), cost)}
    figures = {} if triangles != printed else {(one.patches, one.column): one for one in _of(str(dataset), "cost")}
    return tuple(
        CostRow(*key, measured, figures[key].printed, figures[key].explanation)
        if key in figures
        else CostRow(*key, measured)
        for key, measured in numbers.items()
    )


def printed_triangles(dataset: str) -> int | None:
    """Return how many triangles the published approximation of a dataset has, or None if none is published."""
    return next((int(one.printed) for one in _of(dataset, "approximation") if one.column == "faces"), None)


def _of(dataset: str, source: Source) -> list[DerivedFigure]:
    return [one for one in published_table().derived if (one.dataset, one.source) == (dataset, source)]


def _patches(cost: SurfaceCost) -> dict[tuple[str, str], float]:
    numbers: dict[tuple[str, str], float] = {}
    for kind in cost.kinds:
        name = f"{kind.sides} sides, depth {kind.depth}"
        numbers |= {
            (name, "patches"): kind.patches,
            (name, "control points of one"): kind.points_per_patch,
            (name, "relative cost of a point"): kind.relative_cost,
        }
    return numbers | {
        ("S-patches", "control points"): cost.control_points,
        ("S-patches", "control points, shared"): cost.distinct_points,
        ("S-patches", "cost of the surface"): cost.evaluation,
    }


def _triangles(triangles: int, shared: int, cost: SurfaceCost) -> dict[tuple[str, str], float]:
    cubic = PatchCost(3, 3, triangles)
    name = "cubic triangles"
    return {
        (name, "patches"): triangles,
        (name, "control points of one"): cubic.points_per_patch,
        (name, "control points"): cubic.control_points,
        (name, "control points, shared"): shared,
        (name, "cost of the surface"): triangles * cubic.relative_cost,
        ("S-patches / cubic triangles", "cost"): cost.evaluation / triangles,
        ("cubic triangles / S-patches", "triangles"): triangles / cost.triangles,
    }
