"""What a document is made of, from the words to the figures; all text in it is text, and nothing of it markup."""

import dataclasses
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from testbed_reports.formatting import Entry
from testbed_reports.pdf import lettering

Align: TypeAlias = Literal["left", "right", "center"]


@dataclass(frozen=True)
class Text:
    """Words, slanted or not."""

    text: str
    slanted: bool = False


@dataclass(frozen=True)
class Strong:
    """Words that stand out."""

    text: str


@dataclass(frozen=True)
class Name:
    """What a plugin, a file or a column is called, or a command: to be read letter by letter."""

    text: str


@dataclass(frozen=True)
class Small:
    """Words of less weight, on a line of their own or not."""

    text: str
    apart: bool = False


@dataclass(frozen=True)
class Verdict:
    """A verdict, with its symbol; ``word`` is false where there is room for the symbol only."""

    symbol: str
    text: str
    word: bool = True


@dataclass(frozen=True)
class Swatch:
    """The line and marker of the scheme at a position of the plan."""

    position: int


@dataclass(frozen=True)
class Reference:
    """A table, figure or section by its number, ``text``, which :mod:`testbed_reports.pdf.numbering` fills in."""

    label: str
    text: str = ""


@dataclass(frozen=True)
class Link:
    """A name that leads to a section."""

    label: str
    text: str


@dataclass(frozen=True)
class Break:
    """The end of a line."""


Run: TypeAlias = Break | Text | Strong | Name | Small | Verdict | Swatch | Reference | Link
Runs: TypeAlias = tuple[Run, ...]


def runs(*parts: str | Run) -> Runs:
    """Return runs; plain strings become :class:`Text`."""
    return tuple(Text(part) if isinstance(part, str) else part for part in parts)


@dataclass(frozen=True)
class Cell:
    """A place in a table that holds more than a plain text.

    Parameters
    ----------
    runs
        What it says.
    span
        How many columns it covers.
    align
        None for as its column.
    """

    runs: Runs
    span: int = 1
    align: Align | None = None


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    align
        Where its texts stand.
    width
        In points; 0 for a share of what the others leave.
    share
        Its share of that.
    """

    align: Align = "left"
    width: float = 0.0
    share: float = 1.0


@dataclass(frozen=True)
class Heading:
    """A heading with its number; level 1 begins a chapter, level 3 has no number and does not stand in the contents."""

    level: int
    runs: Runs
    label: str = ""
    number: str = ""


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; small for remarks."""

    runs: Runs
    small: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list."""

    items: tuple[Runs, ...]


@dataclass(frozen=True)
class Facts:
    """Names with texts beside them."""

    items: tuple[tuple[str, Runs], ...]


@dataclass(frozen=True)
class Table:
    """A table; its head is repeated on every page.

    Parameters
    ----------
    label, number
        What references call it, and its number, ``Table 3``.
    caption
        Says what it shows without the text around it.
    columns
        Its columns; their widths fit into the page (:mod:`testbed_reports.pdf.widths`).
    head, rows
        Cells; a plain string is one of words or of a number.
    size
        Of the letters, in points.
    bands
        How many rows are set together, in order: rows of one line each, which cost a cell a column together. Empty for
        all rows by themselves.
    """

    label: str
    caption: Runs
    columns: tuple[Column, ...]
    head: tuple[tuple[str | Cell, ...], ...]
    rows: tuple[tuple[str | Cell, ...], ...]
    size: float = 8.0
    bands: tuple[int, ...] = ()
    number: str = ""


@dataclass(frozen=True)
class Picture:
    """A picture of a row, or where there is none why."""

    title: str
    file: str
    remark: str


@dataclass(frozen=True)
class Bar:
    """A colour bar: colours from its low to its high end, the numbers there, and what it shows."""

    colours: tuple[str, ...]
    low: str
    middle: str
    high: str
    label: str


@dataclass(frozen=True)
class Pictures:
    """A figure of pictures in rows.

    Parameters
    ----------
    label, number, caption
        As of a table.
    pictures, columns
        The pictures and how many stand in a row.
    aspect
        Height over width of a picture.
    bar
        The colour bar that they share, or None.
    """

    label: str
    caption: Runs
    pictures: tuple[Picture, ...]
    columns: int
    aspect: float
    bar: Bar | None = None
    number: str = ""


@dataclass(frozen=True)
class Plots:
    """A figure of plots with the key to their lines.

    Parameters
    ----------
    label, number, caption
        As of a table.
    files
        The plots.
    key
        Positions and texts of the schemes.
    alternative
        What they show, for who cannot see them.
    """

    label: str
    caption: Runs
    files: tuple[str, ...]
    key: tuple[tuple[int, str], ...]
    alternative: str
    number: str = ""


@dataclass(frozen=True)
class Quotation:
    """Lines that stand as they are: a formula in letters, a traceback."""

    lines: tuple[str, ...]


Block: TypeAlias = Heading | Paragraph | Bullets | Facts | Table | Pictures | Plots | Quotation


@dataclass(frozen=True)
class Folio:
    """Pages of one orientation, upright or lying, that begin with a heading."""

    blocks: tuple[Block, ...]
    lying: bool = False


#: Width and height in points of what a page holds, upright and lying: A4 without its margins.
UPRIGHT: Final = (493.0, 730.0)
LYING: Final = (740.0, 493.0)


#: Fields that hold no text of others: what the document calls its parts.
OURS: Final = frozenset({"label", "file", "files", "colours", "align", "number"})


def value(entry: Entry, *, place: bool = True) -> str | Cell:
    """Return the cell of an entry: a number with true minus signs, the best strong, its place below it."""
    text = lettering.number(entry.text) if entry.exact else entry.text
    below = (Small(entry.place, apart=True),) if place and entry.place else ()
    if not entry.best and not below:
        return text
    return Cell((Strong(text) if entry.best else Text(text), *below))


def encoded(one: Any) -> Any:
    """Return blocks as what JSON holds; every text in them is made fit for print here, and nowhere else."""
    if isinstance(one, Name | Link):
        return {**_fields(one), "kind": type(one).__name__, "text": lettering.name(one.text)}
    if isinstance(one, Quotation):
        return {"kind": "Quotation", "lines": [lettering.name(line) for line in one.lines]}
    if isinstance(one, Picture):
        return {**_fields(one), "title": lettering.name(one.title), "remark": lettering.prose(one.remark)}
    if isinstance(one, Plots):
        key = [[position, lettering.name(text)] for position, text in one.key]
        return {**_fields(one), "kind": "Plots", "key": key, "alternative": lettering.prose(one.alternative)}
    if isinstance(one, str):
        return lettering.prose(one)
    if isinstance(one, tuple | list):
        return [encoded(part) for part in one]
    if dataclasses.is_dataclass(one):
        return {**_fields(one), "kind": type(one).__name__}
    return one


def _fields(one: Any) -> dict[str, Any]:
    values = {field.name: getattr(one, field.name) for field in dataclasses.fields(one)}
    return {key: part if key in OURS else encoded(part) for key, part in values.items()}
