"""What is compared above planes: schemes, and sets of data; ``ranges.toml``."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal, TypeAlias, get_args

from testbed.errors import TestbedError
from testbed.plugins.base import format_value

#: What a scheme takes from the data.
Uses: TypeAlias = Literal["points", "normals"]


@dataclass(frozen=True)
class ComparedScheme:
    """A scheme of the comparison.

    Parameters
    ----------
    label
        What tables call it.
    scheme
        Its text, with ``{plane}`` where the set's plane goes.
    uses
        What it takes from the data; schemes that use normals are left out where there are none.
    against
        Label of the scheme without constraint or remedy, or empty.
    """

    label: str
    scheme: str
    uses: Uses = "points"
    against: str = ""


@dataclass(frozen=True)
class RangeSet:
    """Data above a plane.

    Parameters
    ----------
    dataset, level
        Where the mesh is from; ``{plane}`` in the text stands for the plane.
    plane
        a, b, c, d of the plane a x + b y + c z + d = 0.
    """

    dataset: str
    level: int = 0
    plane: tuple[float, ...] = (0.0, 0.0, 1.0, 0.0)

    @property
    def plane_text(self) -> str:
        """The plane as schemes and measures take it, ``(a b c d)``, to the last bit."""
        return format_value(self.plane)

    @property
    def dataset_text(self) -> str:
        """Text of the dataset with the plane in its place."""
        return self.dataset.replace("{plane}", self.plane_text)

    def __str__(self) -> str:
        return self.dataset_text + (f", level {self.level}" if self.level else "")


@dataclass(frozen=True)
class Comparison:
    """What is compared: schemes and sets, in the file's order."""

    schemes: tuple[ComparedScheme, ...]
    sets: tuple[RangeSet, ...]


@cache
def comparison() -> Comparison:
    """Return the comparison of ``ranges.toml``; TestbedError for a row that is none, with its number."""
    return parse_comparison(files("testbed_reports").joinpath("ranges.toml").read_text("utf-8"))


def parse_comparison(text: str) -> Comparison:
    """Return the comparison that a text in the format of ``ranges.toml`` tells; TestbedError for a row that is none."""
    content = tomllib.loads(text)
    schemes = [_scheme(number, row) for number, row in enumerate(content.get("schemes", ()), start=1)]
    labels = [one.label for one in schemes]
    for number, one in enumerate(schemes, start=1):
        if labels.index(one.label) != number - 1:
            raise TestbedError(f"scheme {number} is called {one.label!r}, as another is: give it a label of its own")
        if one.against and one.against not in labels[: number - 1]:
            raise TestbedError(f"scheme {number} is compared against {one.against!r}: put that scheme before it")
    sets = [_set(number, row) for number, row in enumerate(content.get("sets", ()), start=1)]
    return Comparison(tuple(schemes), tuple(sets))


def _scheme(number: int, row: Mapping[str, Any]) -> ComparedScheme:
    try:
        found = ComparedScheme(**row)
    except TypeError as error:
        raise TestbedError(f"scheme {number} has other fields than it should: {error}") from error
    if found.uses not in get_args(Uses):
        raise TestbedError(f"scheme {number}: uses is {found.uses!r}: give points or normals")
    return found


def _set(number: int, row: Mapping[str, Any]) -> RangeSet:
    try:
        given: dict[str, Any] = {**row}
        if "plane" in row:
            given["plane"] = tuple(map(float, row["plane"]))
        found = RangeSet(**given)
    except TypeError as error:
        raise TestbedError(f"set {number} has other fields than it should: {error}") from error
    if len(found.plane) != 4 or not any(found.plane[:3]):
        raise TestbedError(f"set {number}: {found.plane} is no plane: give a, b, c, d with a normal (a, b, c)")
    return found
