"""The table of published figures: what papers print, where, and what measures the same here; ``published.toml``.

A later figure is a row more in that file. The measured side is never written down.
"""

import dataclasses
import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Final, Literal, TypeAlias, get_args

from testbed.errors import SpecError, TestbedError

#: In place of a paper: all of them.
ALL: Final = "all"

#: Where the data come from: see the head of ``published.toml``.
DataStatus: TypeAlias = Literal["given", "reconstructed", "lost", "general"]
#: What a derived figure is read off.
Source: TypeAlias = Literal["approximation", "cost", "surface", "construction"]


@dataclass(frozen=True)
class Figure:
    """A printed number and how it is measured here.

    Parameters
    ----------
    paper, place, quantity
        Where it is printed and what it is.
    scheme, dataset
        Texts of the plugins.
    column
        Column of the results.
    printed
        As printed, a decimal number; its last digit says how far it can be compared.
    data
        Where the data come from.
    level
        Level of the dataset; None for the order of convergence of ``column`` over all its levels.
    explanation
        Why ours is another number; empty where they agree.
    within
        How far ours may be off where the source states the number in words, as of a surface that is "recovered"; None
        for half a unit of the last printed digit.
    """

    paper: str
    place: str
    quantity: str
    scheme: str
    dataset: str
    column: str
    printed: str
    data: DataStatus
    level: int | None = None
    explanation: str = ""
    within: float | None = None


@dataclass(frozen=True)
class DerivedFigure:
    """A printed number, or several, that no cell of a run holds.

    Parameters
    ----------
    paper, place, quantity, data, explanation, within
        As in :class:`Figure`.
    printed
        As there; several numbers, as of control points, with blanks between them.
    source
        ``approximation``: a column of the last step of its history; ``cost``: a row of the costs of a network;
        ``surface``: one of the ways that the construction of a surface took, counted; ``construction``: one of
        :data:`testbed_reports.constructions.CONSTRUCTIONS`.
    dataset
        Text of the dataset; of a construction what it is about, in words.
    column
        Column of the history (:class:`testbed.approximation.history.Step`), the quantity of the cost row, a name in the
        surface's ``branches``, or the name of the construction.
    scheme, epsilon
        Of an approximation: the scheme and the bound of the angle between normals, in degrees, at ten samples of an
        edge, triangles split by the thesis's templates. Of a surface, on level 0 of its dataset: the scheme.
    patches
        Of a cost: which patches it is about.
    """

    paper: str
    place: str
    quantity: str
    source: Source
    dataset: str
    column: str
    printed: str
    data: DataStatus
    scheme: str = ""
    epsilon: float = 0.0
    patches: str = ""
    explanation: str = ""
    within: float | None = None

    @property
    def level(self) -> str:
        """What stands for a level in the table: the bound of an approximation."""
        return (
            f"epsilon {self.epsilon:g}°" if self.source == "approximation" else "0" if self.source == "surface" else ""
        )


@dataclass(frozen=True)
class NotRemade:
    """What a paper prints that is not made here again.

    Parameters
    ----------
    paper, place
        Where it is printed.
    what
        What it is.
    reason
        Why not.
    """

    paper: str
    place: str
    what: str
    reason: str


@dataclass(frozen=True)
class PublishedTable:
    """All published figures.

    Parameters
    ----------
    citations
        Paper to citation.
    figures
        The figures that cells of a run hold, in the file's order.
    derived
        Those that no cell holds, likewise.
    not_remade
        What is not made again, likewise.
    """

    citations: Mapping[str, str]
    figures: tuple[Figure, ...]
    derived: tuple[DerivedFigure, ...] = ()
    not_remade: tuple[NotRemade, ...] = ()


@cache
def published_table() -> PublishedTable:
    """Return the published figures of ``published.toml``.

    Raises
    ------
    TestbedError
        A row of the file is not a figure; the message names the row.
    """
    return parse_table(files("testbed_reports").joinpath("published.toml").read_text("utf-8"))


def parse_table(text: str) -> PublishedTable:
    """Return the figures of a table in the format of ``published.toml``; TestbedError for a row that is none."""
    content = tomllib.loads(text)
    citations = {name: str(paper["citation"]) for name, paper in content["papers"].items()}
    figures = tuple(_figure(number, row, citations) for number, row in enumerate(content["figures"], start=1))
    derived = tuple(_derived(number, row, citations) for number, row in enumerate(content.get("derived", ()), start=1))
    absent = tuple(_absent(number, row, citations) for number, row in enumerate(content.get("not_remade", ()), start=1))
    return PublishedTable(MappingProxyType(citations), figures, derived, absent)


def _absent(number: int, row: Mapping[str, Any], citations: Mapping[str, str]) -> NotRemade:
    try:
        one = NotRemade(**row)
    except TypeError as error:
        raise TestbedError(f"row {number} of what is not remade has other fields than it should: {error}") from error
    if one.paper not in citations:
        raise TestbedError(
            f"row {number} of what is not remade ({one.place}): there is no paper {one.paper!r}: name one of "
            f"{', '.join(citations)}"
        )
    if not one.reason:
        raise TestbedError(f"row {number} of what is not remade ({one.place}) has no reason: give one")
    return one


def _derived(number: int, row: Mapping[str, Any], citations: Mapping[str, str]) -> DerivedFigure:
    try:
        figure = DerivedFigure(**row)
    except TypeError as error:
        raise TestbedError(f"derived figure {number} has other fields than it should: {error}") from error
    where = f"derived figure {number} ({figure.place})"
    if figure.source not in get_args(Source):
        raise TestbedError(f"{where}: source is {figure.source!r}: give one of {', '.join(get_args(Source))}")
    if figure.source == "approximation" and not (figure.scheme and figure.epsilon > 0.0):
        raise TestbedError(f"{where}: an approximation needs a scheme and a positive epsilon")
    if figure.source == "cost" and not figure.patches:
        raise TestbedError(f"{where}: a cost needs patches that it is about")
    if figure.source == "surface" and not figure.scheme:
        raise TestbedError(f"{where}: a surface needs a scheme")
    _check(figure, where, citations)
    return figure


def _figure(number: int, row: Mapping[str, Any], citations: Mapping[str, str]) -> Figure:
    try:
        figure = Figure(**row)
    except TypeError as error:
        raise TestbedError(f"published figure {number} has other fields than it should: {error}") from error
    where = f"published figure {number} ({figure.place})"
    for field in dataclasses.fields(Figure):
        value = getattr(figure, field.name)
        expected = {"level": int, "within": float}.get(field.name, str)
        if not (isinstance(value, expected) or (field.name in ("level", "within") and value is None)):
            raise TestbedError(f"{where}: {field.name} is {value!r}, and should be a {expected.__name__}")
    _check(figure, where, citations)
    return figure


def _check(figure: Figure | DerivedFigure, where: str, citations: Mapping[str, str]) -> None:
    """Raise TestbedError for a figure of no paper, of no kind of data, or without a number."""
    if figure.paper not in citations:
        raise TestbedError(f"{where}: there is no paper {figure.paper!r}: name one of {', '.join(citations)}")
    if figure.data not in get_args(DataStatus):
        raise TestbedError(f"{where}: data cannot be {figure.data!r}: give one of {', '.join(get_args(DataStatus))}")
    numbers = figure.printed.split()
    try:
        finite = bool(numbers) and all(Decimal(number).is_finite() for number in numbers)
    except ArithmeticError:
        finite = False
    if not finite or (len(numbers) > 1 and isinstance(figure, Figure)):
        raise TestbedError(f"{where}: printed is {figure.printed!r}: give a decimal number in figures")
    if figure.within is not None and not figure.within >= 0.0:
        raise TestbedError(f"{where}: within is {figure.within}: give how far ours may be off, 0 or more")


def figures_of(paper: str) -> tuple[Figure, ...]:
    """Return the figures of a paper that cells hold, or of all for ``"all"``.

    Raises
    ------
    SpecError
        There is no such paper; the message tells the nearest.
    """
    table = published_table()
    check_paper(paper)
    return tuple(figure for figure in table.figures if paper in (ALL, figure.paper))


def not_remade_of(paper: str) -> tuple[NotRemade, ...]:
    """Return what is not made again of a paper, or of all; SpecError as :func:`figures_of`."""
    check_paper(paper)
    return tuple(one for one in published_table().not_remade if paper in (ALL, one.paper))


def derived_of(paper: str) -> tuple[DerivedFigure, ...]:
    """Return the figures of approximations and costs of a paper, or of all; SpecError as :func:`figures_of`."""
    check_paper(paper)
    return tuple(figure for figure in published_table().derived if paper in (ALL, figure.paper))


def check_paper(paper: str) -> None:
    """Raise SpecError for an unknown paper, with the nearest."""
    table = published_table()
    if paper != ALL and paper not in table.citations:
        near = difflib.get_close_matches(paper, [*table.citations, ALL], n=1)
        guess = f"did you mean {near[0]}? " if near else ""
        raise SpecError(f"there are no figures of a paper {paper!r}: {guess}papers are {', '.join(table.citations)}")
