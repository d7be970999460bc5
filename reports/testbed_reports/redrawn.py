"""Pictures that papers print, drawn again with what is computed here; ``redrawn.toml`` holds what they show.

A later picture is a row more in that file.
"""

import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Final, get_args

from testbed import registry
from testbed.errors import TestbedError
from testbed_reports.published_table import ALL, DataStatus, check_paper, published_table
from testbed_reports.rendering.colouring import STYLES, Style
from testbed_reports.rendering.figure import Additions, Subject, write_figure

#: Where the pictures are in a results directory.
FOLDER: Final = "figures"


@dataclass(frozen=True)
class Shown:
    """A surface in a picture.

    Parameters
    ----------
    title
        What stands above it.
    scheme, dataset, level
        Texts of the plugins, and the level.
    """

    title: str
    scheme: str
    dataset: str
    level: int


@dataclass(frozen=True)
class Redrawn:
    """A picture that is drawn again.

    Parameters
    ----------
    paper, place
        Where it is printed.
    file
        Name of its file, without the suffix.
    title
        What it shows.
    style
        The colouring.
    view
        Azimuth and elevation in degrees.
    data
        Where the data come from, as in the table of published figures.
    shows
        Its surfaces.
    limit
        Upper limit of the scale; None for one that suits the picture.
    edges
        Whether edges of patches are drawn; None for as the style wants it.
    remark
        What differs from the printed picture; may be empty.
    """

    paper: str
    place: str
    file: str
    title: str
    style: Style
    view: tuple[float, float]
    data: DataStatus
    shows: tuple[Shown, ...]
    limit: float | None = None
    edges: bool | None = None
    remark: str = ""


@cache
def redrawn_table() -> tuple[Redrawn, ...]:
    """Return the pictures of ``redrawn.toml``, in its order.

    Raises
    ------
    TestbedError
        A row of the file is no picture; the message names the row.
    """
    return parse_redrawn(files("testbed_reports").joinpath("redrawn.toml").read_text("utf-8"))


def parse_redrawn(text: str) -> tuple[Redrawn, ...]:
    """Return the pictures of a table in the format of ``redrawn.toml``; TestbedError for a row that is none."""
    pictures = tuple(_picture(number, row) for number, row in enumerate(tomllib.loads(text)["pictures"], start=1))
    names = [(one.paper, one.file) for one in pictures]
    for name in names:
        if names.count(name) > 1:
            raise TestbedError(f"two pictures of {name[0]} are called {name[1]}: give each a file of its own")
    return pictures


def _picture(number: int, row: Mapping[str, Any]) -> Redrawn:
    try:
        shows = tuple(Shown(**one) for one in row["shows"])
        azimuth, elevation = row["view"]
        picture = Redrawn(**{**row, "shows": shows, "view": (float(azimuth), float(elevation))})
    except (KeyError, TypeError, ValueError) as error:
        raise TestbedError(f"picture {number} has other fields than it should: {error}") from error
    where = f"picture {number} ({picture.place})"
    for name, value, known in (
        ("paper", picture.paper, tuple(published_table().citations)),
        ("style", picture.style, STYLES),
        ("data", picture.data, get_args(DataStatus)),
    ):
        if value not in known:
            raise TestbedError(f"{where}: {name} is {value!r}: give one of {', '.join(known)}")
    if not picture.shows:
        raise TestbedError(f"{where} shows nothing: give at least one surface")
    return picture


def pictures_of(paper: str) -> tuple[Redrawn, ...]:
    """Return the pictures of a paper, or of all for ``"all"``; SpecError if there is no such paper."""
    check_paper(paper)
    return tuple(one for one in redrawn_table() if paper in (ALL, one.paper))


def draw_again(directory: Path, pictures: Sequence[Redrawn], size: int = 480) -> tuple[Path, ...]:
    """Write pictures into the folder ``figures`` of a directory and return their paths.

    Raises
    ------
    Refused
        A scheme does not take the data of a picture.
    """
    return tuple(_draw(directory / FOLDER / one.paper, one, size) for one in pictures)


def _draw(folder: Path, picture: Redrawn, size: int) -> Path:
    subjects = []
    for one in picture.shows:
        dataset = registry.dataset(one.dataset)
        surface = registry.scheme(one.scheme).fit(dataset.mesh(one.level))
        subjects.append(Subject(one.title, surface, dataset.surface))
    return write_figure(
        folder / f"{picture.file}.png",
        subjects,
        picture.style,
        size=size,
        view=picture.view,
        limit=picture.limit,
        additions=Additions(edges=picture.edges),
        title=f"{picture.title}. {picture.paper}, {picture.place}, drawn again. {picture.remark}".strip(),
    )


def records(pictures: Sequence[Redrawn], paths: Sequence[Path]) -> list[dict[str, Any]]:
    """Return what pictures are, with their files, for machines."""
    return [{**dataclasses.asdict(one), "written": str(path)} for one, path in zip(pictures, paths, strict=True)]
