"""Tables 5.2 and 5.3 of the thesis, storage and evaluation of S-patches and of cubic triangles, next to our counts."""

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from types import MappingProxyType
from typing import Final

from testbed.errors import TestbedError
from testbed.geometry.costs import PatchCost, SurfaceCost, network_cost, shared_cubic_points
from testbed.geometry.network_charts import NetworkCharts
from testbed.geometry.spline_network import SplineNetwork
from testbed.plugins.dataset import Dataset
from testbed_reports.published import rounds_to

#: Why a number here is another than the printed one.
STEPS: Final = (
    "a triangle of degree 6 has 28 control points; 56 is the number of combinations in a de Casteljau evaluation"
)
TOTAL: Final = "the printed sum takes 56 control points for each of the four triangles, which have 28"
RATIO: Final = "4.2 is the value of the branch; the table's own numbers give 1379 / 462"


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


@dataclass(frozen=True)
class PrintedTable:
    """What the thesis prints about a surface.

    Parameters
    ----------
    triangles
        Cubic triangles of its approximation.
    numbers
        Printed numbers by patches and quantity.
    explanations
        Explanations by the same, where the printed number is not ours.
    """

    triangles: int
    numbers: Mapping[tuple[str, str], str]
    explanations: Mapping[tuple[str, str], str]


BRANCH: Final = PrintedTable(
    238,
    MappingProxyType(
        {
            ("4 sides, depth 3", "patches"): "20",
            ("4 sides, depth 3", "control points of one"): "20",
            ("4 sides, depth 3", "relative cost of a point"): "2",
            ("5 sides, depth 6", "patches"): "4",
            ("5 sides, depth 6", "control points of one"): "210",
            ("5 sides, depth 6", "relative cost of a point"): "42",
            ("S-patches", "control points"): "1240",
            ("S-patches", "control points, shared"): "1.0E+3",
            ("S-patches", "cost of the surface"): "1000",
            ("cubic triangles", "control points of one"): "10",
            ("cubic triangles", "control points"): "2380",
            ("cubic triangles", "control points, shared"): "1.1E+3",
            ("cubic triangles", "cost of the surface"): "238",
            ("S-patches / cubic triangles", "cost"): "4.2",
            ("cubic triangles / S-patches", "triangles"): "2.4",
        }
    ),
    MappingProxyType({}),
)
RING: Final = PrintedTable(
    462,
    MappingProxyType(
        {
            ("3 sides, depth 6", "patches"): "4",
            ("3 sides, depth 6", "control points of one"): "56",
            ("3 sides, depth 6", "relative cost of a point"): "5.6",
            ("4 sides, depth 3", "patches"): "31",
            ("4 sides, depth 3", "control points of one"): "20",
            ("4 sides, depth 3", "relative cost of a point"): "2",
            ("6 sides, depth 6", "patches"): "2",
            ("6 sides, depth 6", "control points of one"): "462",
            ("6 sides, depth 6", "relative cost of a point"): "92",
            ("S-patches", "control points"): "1768",
            ("S-patches", "cost of the surface"): "1379",
            ("cubic triangles", "control points of one"): "10",
            ("cubic triangles", "control points"): "4620",
            ("cubic triangles", "cost of the surface"): "462",
            ("S-patches / cubic triangles", "cost"): "4.2",
            ("cubic triangles / S-patches", "triangles"): "3",
        }
    ),
    MappingProxyType(
        {
            ("3 sides, depth 6", "control points of one"): STEPS,
            ("S-patches", "control points"): TOTAL,
            ("S-patches / cubic triangles", "cost"): RATIO,
        }
    ),
)
#: By the dataset's name; nothing else is printed.
PRINTED: Final[Mapping[str, PrintedTable]] = MappingProxyType({"branch": BRANCH, "ring": RING})


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
    network = network_of(dataset)
    cost, printed = network_cost(network), PRINTED.get(str(dataset))
    if triangles is None:
        triangles = cost.triangles if printed is None else printed.triangles
    elif printed is not None and triangles != printed.triangles:
        printed = None  # another approximation than the printed one
    numbers = {**_patches(cost), **_triangles(triangles, shared_cubic_points(network, triangles), cost)}
    table = printed or PrintedTable(triangles, {}, {})
    return tuple(
        CostRow(*key, measured, table.numbers.get(key, ""), table.explanations.get(key, ""))
        for key, measured in numbers.items()
    )


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
