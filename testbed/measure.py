"""Measures: numbers read off a surface, each a column of the results."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.plugin import Plugin

#: What a cell of the results may hold.
Value: TypeAlias = float | int | str


@dataclass(frozen=True)
class Column:
    """A column of the results.

    Parameters
    ----------
    name
        Its name in results.csv; angles end in ``_deg``.
    meaning
        One line with the unit.
    converges
        Whether it goes to zero with the edge length, so that its order is estimated.
    exact
        Whether it needs the exact surface.
    """

    name: str
    meaning: str
    converges: bool = False
    exact: bool = False


@dataclass(frozen=True)
class Measure(Plugin):
    """A measure; a frozen dataclass whose fields are its settings (sample counts and the like)."""

    columns: ClassVar[tuple[Column, ...]]
    required: ClassVar[tuple[str, ...]] = (*Plugin.required, "columns")

    @abstractmethod
    def measure(self, surface: Surface, exact: ExactSurface | None) -> Mapping[str, Value]:
        """Return a value for every column; columns that need the exact surface are left out where there is none.

        NaN in the surface gives NaN in the column: maxima and minima propagate it.
        """
