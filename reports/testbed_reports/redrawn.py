"""Pictures that papers print, drawn again with what is computed here; ``redrawn.toml`` holds what they show.

A later picture is a row more in that file. What a kind of picture draws is in ``redrawn_surfaces`` and
``redrawn_curves``.
"""

import dataclasses
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias, get_args

from testbed.errors import TestbedError
from testbed_reports.published_table import ALL, DataStatus, check_paper, published_table
from testbed_reports.rendering.colouring import STYLES, Style

#: Where the pictures are in a results directory.
FOLDER: Final = "figures"
#: Seconds that a picture may take.
LIMIT: Final = 900.0
#: What a picture shows: surfaces, or plane curves with plots of their curvature.
Kind: TypeAlias = Literal["surfaces", "curves"]
#: Which edges are drawn: as the style wants it, all, none, the mesh's, or these and lightly the others.
Edges: TypeAlias = Literal["", "all", "none", "mesh", "kinds"]


@dataclass(frozen=True)
class Shown:
    """A surface or a curve in a picture.

    Parameters
    ----------
    title
        What stands above it.
    scheme, dataset, level
        Texts of the plugins, and the level. Of a curve ``curve`` is the boundary curve in place of the scheme.
    style, view
        Colouring and side; left out: the picture's.
    epsilon, step
        The mesh is that of an adaptive approximation with this bound of the angle between normals, in degrees, after so
        many refinements; -1: when the bound is reached. 0 for a mesh of the dataset.
    colour
        ``levels``: patches coloured by the level of refinement of their faces; ``plain``: all light.
    plane
        a, b, c, d of a plane that is drawn too.
    faces
        Faces of the mesh whose patches are drawn; all if empty.
    edges
        Which edges are drawn; left out: as in the picture.
    highlight
        Edges, as pairs of vertices, that are drawn thick.
    remark
        What stands below it; left out: what the style says there.
    curve, arc, edge
        Of a curve: the boundary curve, over an arc of the unit circle of so many degrees or, with dataset and level, on
        an edge of the mesh.
    """

    title: str
    scheme: str = ""
    dataset: str = ""
    level: int = 0
    style: Style | Literal[""] = ""
    view: tuple[float, ...] = ()
    epsilon: float = 0.0
    step: int = -1
    colour: Literal["", "levels", "plain"] = ""
    plane: tuple[float, ...] = ()
    faces: tuple[int, ...] = ()
    edges: Edges = ""
    highlight: tuple[tuple[int, ...], ...] = ()
    remark: str = ""
    curve: str = ""
    arc: float = 0.0
    edge: tuple[int, ...] = ()


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
    data
        Where the data come from, as in the table of published figures.
    shows
        Its surfaces or curves, row by row.
    kind
        What these are.
    style, view
        The colouring, and azimuth and elevation in degrees.
    columns, size
        Pictures in a row, and pixels along a side of each.
    limit
        Upper limit of the scale; None for one that suits the picture.
    edges, net, extremes
        What else is drawn: edges of patches, control nets, marks of the extremes of curvature.
    remark
        What differs from the printed picture; may be empty.
    """

    paper: str
    place: str
    file: str
    title: str
    data: DataStatus
    shows: tuple[Shown, ...]
    kind: Kind = "surfaces"
    style: Style = "shaded"
    view: tuple[float, float] = (-60.0, 25.0)
    columns: int = 4
    size: int = 480
    limit: float | None = None
    edges: Edges = ""
    net: bool = False
    extremes: bool = False
    remark: str = ""

    @property
    def caption(self) -> str:
        """What the picture shows, where it is printed, and what differs."""
        return f"{self.title}. {self.paper}, {self.place}, drawn again. {self.remark}".strip()


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
        shows = tuple(_shown(one) for one in row["shows"])
        azimuth, elevation = row.get("view", (-60.0, 25.0))
        picture = Redrawn(**{**row, "shows": shows, "view": (float(azimuth), float(elevation))})
    except (KeyError, TypeError, ValueError) as error:
        raise TestbedError(f"picture {number} has other fields than it should: {error}") from error
    where = f"picture {number} ({picture.place})"
    checks = [
        ("paper", picture.paper, tuple(published_table().citations)),
        ("kind", picture.kind, get_args(Kind)),
        ("style", picture.style, STYLES),
        ("edges", picture.edges, get_args(Edges)),
        ("data", picture.data, get_args(DataStatus)),
    ]
    for one in picture.shows:
        checks += [
            ("style", one.style, ("", *STYLES)),
            ("colour", one.colour, ("", "levels", "plain")),
            ("edges", one.edges, get_args(Edges)),
        ]
    for name, value, known in checks:
        if value not in known:
            raise TestbedError(f"{where}: {name} is {value!r}: give one of {', '.join(filter(None, known))}")
    if not picture.shows:
        raise TestbedError(f"{where} shows nothing: give at least one surface or curve")
    for one in picture.shows:
        _check(one, picture.kind, where)
    return picture


def _shown(row: Mapping[str, Any]) -> Shown:
    given = dict(row)
    for name in ("view", "plane"):
        given[name] = tuple(map(float, row.get(name, ())))
    given["faces"], given["edge"] = tuple(row.get("faces", ())), tuple(row.get("edge", ()))
    given["highlight"] = tuple(tuple(pair) for pair in row.get("highlight", ()))
    return Shown(**given)


def _check(one: Shown, kind: Kind, where: str) -> None:
    """Raise TestbedError for a surface or curve that cannot be drawn."""
    name = f"{where}: {one.title!r}"
    if kind == "surfaces" and not (one.scheme and one.dataset):
        raise TestbedError(f"{name} is no surface: give scheme and dataset")
    if kind == "curves" and not (one.curve and (one.arc > 0.0) != (len(one.edge) == 2 and bool(one.dataset))):
        raise TestbedError(f"{name} is no curve: give curve, and either arc or dataset and edge")
    for field, value, lengths in (("view", one.view, (0, 2)), ("plane", one.plane, (0, 4))):
        if len(value) not in lengths:
            raise TestbedError(f"{name}: {field} has {len(value)} numbers: give {lengths[1]}")
    if any(len(pair) != 2 for pair in one.highlight):
        raise TestbedError(f"{name}: highlight holds pairs of vertices")
    if one.colour == "levels" and not one.epsilon > 0.0:
        raise TestbedError(f"{name} has no levels of refinement: give the epsilon of an approximation")


def pictures_of(paper: str) -> tuple[Redrawn, ...]:
    """Return the pictures of a paper, or of all for ``"all"``; SpecError if there is no such paper."""
    check_paper(paper)
    return tuple(one for one in redrawn_table() if paper in (ALL, one.paper))


def draw_again(
    directory: Path,
    pictures: Sequence[Redrawn],
    jobs: int | None = None,
    note: Callable[[Redrawn], None] | None = None,
) -> tuple[Path, ...]:
    """Write pictures into the folder ``figures`` of a directory and return their paths.

    Parameters
    ----------
    directory
        The results directory.
    pictures
        What to draw.
    jobs
        Worker processes; one a processor if None.
    note
        Called with each picture as it is done.

    Raises
    ------
    TestbedError
        A picture cannot be drawn; the message says which, and why.
    """
    from testbed.harness.run import processors
    from testbed.harness.workers import Died, Returned, TimedOut, Workers

    waiting = list(enumerate(pictures))
    found: dict[int, Path] = {}
    if not waiting:
        return ()
    with Workers(min(jobs or processors(), len(waiting)), LIMIT) as workers:
        while waiting or workers.tasks:
            while waiting and workers.free > 0:
                number, one = waiting.pop(0)
                workers.submit(number, attempt, directory / FOLDER / one.paper, one)
            for outcome in workers.wait(1.0):
                one = pictures[outcome.task]
                match outcome:
                    case Returned(value=(path, "")):
                        found[outcome.task] = path
                        if note:
                            note(one)
                    case Returned(value=(_, reason)) | Died(reason=reason):
                        raise TestbedError(f"the picture {one.file} of {one.paper} cannot be drawn: {reason}")
                    case TimedOut():
                        raise TestbedError(f"the picture {one.file} of {one.paper} takes more than {LIMIT:g} s")
    return tuple(found[number] for number in range(len(pictures)))


def attempt(folder: Path, picture: Redrawn) -> tuple[Path, str]:
    """Write one picture into a folder; return its path and, where it cannot be drawn, why. Runs in a worker."""
    from testbed_reports.redrawn_curves import draw_curves
    from testbed_reports.redrawn_surfaces import draw_surfaces

    path = folder / f"{picture.file}.png"
    try:
        (draw_surfaces if picture.kind == "surfaces" else draw_curves)(path, picture)
    except TestbedError as error:
        return path, str(error)
    return path, ""


def records(pictures: Sequence[Redrawn], paths: Sequence[Path]) -> list[dict[str, Any]]:
    """Return what pictures are, with their files, for machines."""
    return [{**dataclasses.asdict(one), "written": str(path)} for one, path in zip(pictures, paths, strict=True)]
