"""What differs between two rows of results, and whether that is better: it follows from the quantity alone.

Errors, gaps, normal jumps and counts of fallbacks are better the smaller they are, and so is the spread of the
curvature where the exact surface has constant curvature; values up to rounding are equal. Of all other numbers it is
told that they changed.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from testbed.harness.claims import CLOSED, CURVED, SMOOTH_DEG
from testbed.harness.comparable import Comparable, Key, Row, Value
from testbed.harness.results import END, enclosures

Kind: TypeAlias = Literal["regressed", "vanished", "changed", "improved", "appeared"]
What: TypeAlias = Literal["cell", "column", "order", "claim"]

#: Columns that are better the smaller they are, besides those declared to converge to zero.
_LESS: Final = re.compile(
    r"(distance|normal|gauss_error|mean_error|vertex_\w+|centre_\w+)_(max|rms)(_deg)?|epsilon(_exact)?_deg|gap_max"
    r"|curvature_jump_max|fallbacks|centres_missed|edges_above_\w+|plane_below|(gauss|mean)_spread"
)
#: Columns that are not compared: places of extremes, which jump between equal ones, and what a row begins with.
_PASSED_OVER: Final = re.compile(r"\w+_(face|bary|vertex)|scheme|dataset|level|status|reason")
#: Shapes of constant curvature.
_CONSTANT: Final = ("spheres", "planes")
#: Gaussian curvature times the square of the edge length, and mean curvature times it, up to which they are rounding.
_CURVATURE_ROUNDING: Final = 1e-10
#: Seconds up to which times are equal.
_SHORT: Final = 0.01


@dataclass(frozen=True)
class Difference:
    """Something that is not as it was.

    Parameters
    ----------
    what
        A cell's status or value, a column of all cells, an order of convergence, or the verdict on a claim.
    kind
        Whether it is better, worse, there at all.
    scheme, dataset
        Of what; empty for a column.
    level
        Of a cell; None for what belongs to all levels.
    quantity
        ``status``, a column, the quantity of an order, or the claim; empty for a cell as a whole.
    old, new
        The values; None where there is none.
    factor
        How many times as large the new value is as the old one, values up to rounding taken for rounding; NaN where
        that says nothing.
    reason
        Why a cell that is not ok has no values, or what a verdict rests on; empty if there is nothing to say.
    """

    what: What
    kind: Kind
    scheme: str
    dataset: str
    level: int | None
    quantity: str
    old: Value
    new: Value
    factor: float = math.nan
    reason: str = ""

    @property
    def place(self) -> tuple[str, str, str, int, str]:
        """What it is about, to group and to sort by: values of one cell have one place but for the last."""
        return self.what, self.scheme, self.dataset, -1 if self.level is None else self.level, self.quantity

    @property
    def severity(self) -> float:
        """How much it differs: infinite where that is no matter of degree."""
        if math.isnan(self.factor):
            return math.inf if self.kind in ("regressed", "vanished", "appeared") else 0.0
        return abs(math.log(self.factor)) if 0.0 < self.factor < math.inf else math.inf


@dataclass(frozen=True)
class ColumnComparison:
    """How the values of two tables are compared.

    Parameters
    ----------
    common, gone, fresh
        Columns that both tables have, that only the old one has, and only the new one.
    converging
        Columns that are declared to converge to zero.
    constant
        Datasets whose exact surfaces have constant curvature.
    tolerance
        Relative difference up to which values are equal.
    seconds
        The same for times; None where they are not compared.
    """

    common: tuple[str, ...]
    gone: tuple[str, ...]
    fresh: tuple[str, ...]
    converging: frozenset[str]
    constant: frozenset[str]
    tolerance: float
    seconds: float | None

    @classmethod
    def of(cls, old: Comparable, new: Comparable, tolerance: float, seconds: float | None) -> "ColumnComparison":
        """Return what suits two tables."""
        bounds = {name for pair in enclosures(old.columns + new.columns).values() for name in pair}

        def compared(name: str) -> bool:
            timed = name in END or name.endswith("_seconds")
            return not (_PASSED_OVER.fullmatch(name) or name in bounds or (timed and seconds is None))

        return cls(
            tuple(name for name in old.columns if name in new.columns and compared(name)),
            tuple(name for name in old.columns if name not in new.columns and compared(name)),
            tuple(name for name in new.columns if name not in old.columns and compared(name)),
            old.converging | new.converging,
            frozenset(name for name, shape in {**old.shapes, **new.shapes}.items() if shape in _CONSTANT),
            tolerance,
            seconds,
        )

    def differences(self) -> Iterator[Difference]:
        """Yield the columns that only one table has."""
        for name in self.gone:
            yield Difference("column", "vanished", "", "", None, name, None, None)
        for name in self.fresh:
            yield Difference("column", "appeared", "", "", None, name, None, None)

    def values(self, key: Key, old: Row, new: Row) -> Iterator[Difference]:
        """Yield the differences of two rows that are ok."""
        for name in self.common:
            yield from self._value(key, name, old.get(name), new.get(name), old, new)
        if key[1] in self.constant:
            for stem in ("gauss", "mean"):
                before, after = _spread(old, stem), _spread(new, stem)
                if before is not None and after is not None:
                    yield from self._value(key, f"{stem}_spread", before, after, old, new)

    def _value(self, key: Key, name: str, old: Value, new: Value, old_row: Row, new_row: Row) -> Iterator[Difference]:
        if old == new:
            return
        if old is None or new is None:
            yield Difference("cell", "appeared" if old is None else "vanished", *key, name, old, new)
            return
        if isinstance(old, str) or isinstance(new, str):
            yield Difference("cell", "changed", *key, name, old, new)
            return
        timed = name in END or name.endswith("_seconds")
        tolerance = self.tolerance if self.seconds is None or not timed else self.seconds
        floor = _SHORT if timed else max(_floor(name, row) for row in (old_row, new_row))
        if timed or name in self.converging or _LESS.fullmatch(name):
            factor = _factor(max(old, floor), max(new, floor))
            if not 1.0 / (1.0 + tolerance) <= factor <= 1.0 + tolerance:
                yield Difference("cell", "improved" if factor < 1.0 else "regressed", *key, name, old, new, factor)
        elif not is_near(old, new, tolerance, floor):
            yield Difference("cell", "changed", *key, name, old, new, _factor(old, new))


def is_near(old: float, new: float, tolerance: float, floor: float) -> bool:
    """Whether numbers differ by no more than a relative tolerance and a floor; infinity is near itself alone."""
    if math.isinf(old) or math.isinf(new):
        return old == new
    return abs(new - old) <= tolerance * max(abs(old), abs(new)) + floor


def _factor(old: float, new: float) -> float:
    """How many times as large the new value is; NaN where signs differ."""
    if old == new:
        return 1.0
    if old == 0.0:
        return math.inf if new > 0.0 else math.nan
    factor = new / old
    return factor if factor >= 0.0 else math.nan


def _spread(row: Row, stem: str) -> float | None:
    low, high = row.get(f"{stem}_min"), row.get(f"{stem}_max")
    return high - low if isinstance(low, float) and isinstance(high, float) else None


def _floor(name: str, row: Row) -> float:
    """Values up to this are rounding."""
    h, diameter = row.get("h"), row.get("diameter")
    if name == "curvature_jump_max":
        return CURVED
    if name.startswith("edges_above"):
        return 0.0
    if name.endswith("_deg"):
        return SMOOTH_DEG
    if name.startswith(("gauss", "mean")) or name.endswith("_form_max"):
        return _CURVATURE_ROUNDING / h ** (2 if name.startswith("gauss") else 1) if isinstance(h, float) and h else 0.0
    is_length = name.startswith(("distance", "gap", "vertex_distance", "centre_distance", "plane_min"))
    return CLOSED * diameter if is_length and isinstance(diameter, float) else 0.0
