"""Measures: numbers read off a surface, each a column of the results."""

from abc import abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Concatenate, ParamSpec, TypeAlias, TypeVar, cast

from testbed.errors import PluginError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.plugins.base import Plugin

#: What a cell of the results may hold.
Value: TypeAlias = float | int | str

T = TypeVar("T")
Settings = ParamSpec("Settings")


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
    optional
        Whether it is left out for other reasons where the surface or its data have no such number.
    """

    name: str
    meaning: str
    converges: bool = False
    exact: bool = False
    optional: bool = False


class Survey:
    """A surface under measurement, and what its measures share.

    Sampling a surface costs more than reading a number off the samples, so measures ask for their samples through
    :meth:`shared`. A survey lives as long as one surface is measured.

    Parameters
    ----------
    surface
        The surface.
    exact
        The surface it approximates, or None.
    """

    def __init__(self, surface: Surface, exact: ExactSurface | None = None) -> None:
        self.surface = surface
        self.exact = exact
        self._computed: dict[tuple[Hashable, ...], Any] = {}

    def shared(
        self,
        compute: "Callable[Concatenate[Survey, Settings], T]",
        *settings: Settings.args,
        **named: Settings.kwargs,
    ) -> T:
        """Return ``compute(self, *settings)``, computed once for all measures that ask with equal settings.

        Parameters
        ----------
        compute
            A function without side effects of a survey and hashable settings; its result is not to be changed.
        """
        key = (compute, *settings, *sorted(named.items()))
        if key not in self._computed:
            self._computed[key] = compute(self, *settings, **named)
        return cast("T", self._computed[key])


@dataclass(frozen=True)
class Measure(Plugin):
    """A measure; a frozen dataclass whose fields are its settings (sample counts and the like).

    Attributes
    ----------
    columns
        What it returns a value for.
    """

    columns: ClassVar[tuple[Column, ...]]
    required: ClassVar[tuple[str, ...]] = (*Plugin.required, "columns")

    @abstractmethod
    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return a value for every column; columns that need the exact surface are left out where there is none.

        NaN in the surface gives NaN in the column: maxima and minima propagate it.
        """


def measure_all(measures: Sequence[Measure], surface: Surface, exact: ExactSurface | None) -> dict[str, Value]:
    """Return all columns of the measures, in the order they are declared in.

    Raises
    ------
    PluginError
        A measure returned other columns than it declares, or two measures declare the same one.
    """
    survey = Survey(surface, exact)
    result: dict[str, Value] = {}
    for one in measures:
        values = one.measure(survey)
        declared = [column.name for column in one.columns if exact is not None or not column.exact]
        optional = {column.name for column in one.columns if column.optional}
        if (set(values) ^ set(declared)) - (optional - set(values)):
            different = ", ".join(sorted(set(values) ^ set(declared)))
            raise PluginError(
                f"measure {one} declares other columns than it returns, {different}: declare and return the same ones"
            )
        repeated = [name for name in declared if name in result]
        if repeated:
            raise PluginError(
                f"measure {one} returns column {repeated[0]}, as another measure does: give it a name of its own"
            )
        result.update((name, values[name]) for name in declared if name in values)
    return result
