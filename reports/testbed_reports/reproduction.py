"""The page of a reproduction: what papers print next to what comes out here, figures beside the numbers they show."""

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

from testbed_reports.published import PublishedRow, remark, subject
from testbed_reports.published_table import NotRemade, published_table
from testbed_reports.redrawn import Redrawn

#: What the page is called.
NAME: Final = "index.html"
#: Classes of the marks of verdicts: those of the report's page, and one more.
MARKS: Final = {
    "agrees": "met",
    "differs": "differs",
    "data lost": "not-testable",
    "unexplained": "missed",
    "no value": "missed",
}
#: What the verdicts mean.
MEANINGS: Final = (
    ("agrees", "at the printed digits, or as exactly as the statement says"),
    ("differs", "and why is said below"),
    ("data lost", "another surface or mesh stands for the printed one"),
)
#: Figure numbers stand behind this word, before a page; sections, theorems and tables have numbers of their own.
_FIGURES: Final = re.compile(r"(?:figures?|pictures?) ([^;]*?)(?=, pages? |, from |;|$)")
_OTHERS: Final = re.compile(
    r"(?:sections?|theorems?|tables?|steps?|chapters?|pages?) [\d.]+(?:(?: and |, | to | or )[\d.]+)*"
)


@dataclass(frozen=True)
class Line:
    """A row of the table as the page shows it."""

    row: PublishedRow
    subject: str
    remark: str
    mark: str


@dataclass(frozen=True)
class Pair:
    """A picture, as base64, with the numbers that it shows."""

    picture: Redrawn
    image: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class PaperSection:
    """What the page tells of a paper."""

    name: str
    citation: str
    counts: tuple[tuple[str, int], ...]
    pairs: tuple[Pair, ...]
    others: tuple[Line, ...]
    absent: tuple[NotRemade, ...]


def figure_numbers(place: str) -> frozenset[str]:
    """Return the numbers of the figures that a place names.

    >>> sorted(figure_numbers("figures 2.20 center, page 46, and 3.6 left, page 62"))
    ['2.20', '3.6']
    >>> sorted(figure_numbers("theorem 4.2 and figure 13")), sorted(figure_numbers("section 3.3, page 53"))
    (['13'], [])
    >>> sorted(figure_numbers("figures 14 to 17"))
    ['14', '15', '16', '17']
    """
    if not re.search(r"\b(?:figure|picture)", place):
        return frozenset()
    rest = _OTHERS.sub("", place)
    found = set(re.findall(r"\d+(?:\.\d+)?", rest))
    for first, last in re.findall(r"(\d+) to (\d+)", rest):
        found |= {str(number) for number in range(int(first), int(last) + 1)}
    return frozenset(found)


def sections(
    rows: Sequence[PublishedRow], pictures: Sequence[Redrawn], paths: Sequence[Path], absent: Sequence[NotRemade]
) -> tuple[PaperSection, ...]:
    """Put the numbers of each paper beside the pictures that show them; a number stands at the first one."""
    papers = {row.paper for row in rows} | {one.paper for one in pictures} | {one.paper for one in absent}
    order = [name for name in published_table().citations if name in papers]
    return tuple(_section(name, rows, list(zip(pictures, paths, strict=True)), absent) for name in order)


def _section(
    paper: str,
    rows: Sequence[PublishedRow],
    drawn: Iterable[tuple[Redrawn, Path]],
    absent: Sequence[NotRemade],
) -> PaperSection:
    left = [row for row in rows if row.paper == paper]
    verdicts = [row.verdict for row in left]
    pairs = []
    for picture, path in drawn:
        if picture.paper == paper:
            shown = figure_numbers(picture.place)
            own = [row for row in left if figure_numbers(row.place) & shown]
            left = [row for row in left if row not in own]
            image = base64.b64encode(path.read_bytes()).decode("ascii")
            pairs.append(Pair(picture, image, tuple(map(_line, own))))
    counts = tuple((verdict, verdicts.count(verdict)) for verdict in MARKS if verdict in verdicts)
    return PaperSection(
        paper,
        published_table().citations[paper],
        counts,
        tuple(pairs),
        tuple(map(_line, left)),
        tuple(one for one in absent if one.paper == paper),
    )


def _line(row: PublishedRow) -> Line:
    return Line(row, subject(row), remark(row), MARKS[row.verdict])


def write_reproduction(
    directory: Path,
    rows: Sequence[PublishedRow],
    pictures: Sequence[Redrawn],
    paths: Sequence[Path],
    absent: Sequence[NotRemade],
) -> Path:
    """Write ``index.html`` into a directory, whole or not at all, and return its path.

    Parameters
    ----------
    directory
        The directory.
    rows
        The numbers.
    pictures, paths
        The pictures, and where they are.
    absent
        What is not made again.
    """
    from testbed.harness.journal import write_whole

    path = directory / NAME
    write_whole(path, render(sections(rows, pictures, paths, absent)))
    return path


def render(papers: Sequence[PaperSection]) -> str:
    """Return the page as HTML, a file that holds all it shows; whatever schemes and data are called is text in it."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    folder = files("testbed_reports")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(folder.joinpath("reproduction.html.j2").read_text("utf-8"))
    stylesheet = Markup(folder.joinpath("page.css").read_text("utf-8"))  # noqa: S704 - ours
    return template.render(stylesheet=stylesheet, papers=papers, meanings=MEANINGS, marks=MARKS)
