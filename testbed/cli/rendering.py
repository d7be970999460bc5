"""``render``: pictures of surfaces, or of boundary curves, side by side."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from testbed.errors import Refused, SpecError

if TYPE_CHECKING:
    from collections.abc import Sequence


def render(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="SCHEME...", help="Schemes, as name or name\\[field=value,...]; boundary curves with --curves."
        ),
    ],
    *,
    dataset: Annotated[str, typer.Option("-d", "--dataset", metavar="DATASET", help="The dataset.")],
    level: Annotated[int, typer.Option("--level", min=0, metavar="L", help="Level of the dataset.")] = 0,
    style: Annotated[
        str,
        typer.Option(
            "--style",
            metavar="STYLE",
            help="shaded, patches, gauss, mean, distance, isophotes, zebra, thesis or jump.",
        ),
    ] = "shaded",
    curves: Annotated[
        bool,
        typer.Option(
            "--curves", help="Draw boundary curves: combs of their curvature, inflections, dots at equal parameters."
        ),
    ] = False,
    view: Annotated[
        str | None, typer.Option("--view", metavar="AZIMUTH,ELEVATION", help="Where from, in degrees, z upwards.")
    ] = None,
    edges: Annotated[bool | None, typer.Option("--edges/--no-edges", help="Draw the edges of patches.")] = None,
    net: Annotated[bool, typer.Option("--net", help="Draw control nets, where they are not hidden.")] = False,
    extremes: Annotated[
        bool, typer.Option("--extremes", help="Mark the largest and the smallest curvature: gauss, mean, thesis.")
    ] = False,
    limit: Annotated[
        float | None,
        typer.Option(
            "--limit", help="Upper limit of the scale, of curves the curvature of a full tooth. Default: one for all."
        ),
    ] = None,
    size: Annotated[int, typer.Option("--size", min=64, max=4096, metavar="PIXELS", help="Side of a picture.")] = 480,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE", help="The PNG file.")] = Path("surface.png"),
) -> None:
    """Draw surfaces side by side, all from one side and with one scale of colours; with --curves boundary curves.

    Exit code 1 if one refuses the data; the others are drawn.
    """
    request = Request(tuple(names), dataset, level, style, view, edges, limit, size, output, net, extremes)
    raise typer.Exit(render_curves(request) if curves else render_command(request))


@dataclass(frozen=True)
class Request:
    """What is to be drawn.

    Parameters
    ----------
    names, dataset, level
        Which schemes, or boundary curves, on which data.
    style
        A colouring.
    view
        Azimuth and elevation, as ``-60,25``; None for the usual view.
    edges
        Whether edges of patches are drawn; None for where the style wants it.
    limit
        Upper limit of the scale; None for one that suits all pictures.
    size
        Pixels along a side of a picture.
    output
        The PNG file.
    net
        Whether control nets are drawn.
    extremes
        Whether the largest and the smallest curvature are marked.
    """

    names: tuple[str, ...]
    dataset: str
    level: int
    style: str
    view: str | None
    edges: bool | None
    limit: float | None
    size: int
    output: Path
    net: bool = False
    extremes: bool = False


def render_command(request: Request) -> int:
    """Draw the surfaces and print where the picture is.

    Returns
    -------
    code
        0, or 1 where a scheme refuses the data; the others are drawn.

    Raises
    ------
    TestbedError
        There is no such style or view, the plugins do not exist, or every scheme refuses the data.
    """
    from testbed import registry
    from testbed_reports.rendering.colouring import CURVED, EXACT, STYLES
    from testbed_reports.rendering.figure import Additions, Subject, caption, write_figure

    style = next((style for style in STYLES if style == request.style), None)
    if style is None:
        raise SpecError(f"there is no style {request.style!r}: take {', '.join(STYLES)}")
    if request.extremes and style not in CURVED:
        raise SpecError(f"--extremes marks curvatures, and {style} shows none: take --style {' or '.join(CURVED)}")
    view = _checked(request)
    dataset = registry.dataset(request.dataset)
    if style in EXACT and dataset.surface is None:
        raise SpecError(f"{dataset} has no exact surface to measure distances from: take another style or dataset")
    mesh, subjects, refusals = dataset.mesh(request.level), [], []
    for text in request.names:
        scheme = registry.scheme(text)
        try:
            subjects.append(Subject(str(scheme), scheme.fit(mesh), dataset.surface))
        except Refused as refusal:
            refusals.append(refusal)
    if not subjects:
        raise refusals[0]
    told = caption(style) + (" ▲ largest, ▼ smallest; hollow where hidden." if request.extremes else "")
    try:
        write_figure(
            request.output,
            subjects,
            style,
            size=request.size,
            view=view,
            limit=request.limit,
            title=f"{dataset}, level {request.level}. {told}",
            additions=Additions(request.edges, request.net, request.extremes),
        )
    except OSError as error:
        raise _unwritable(request, error) from error
    return _end(request, refusals)


def render_curves(request: Request) -> int:
    """Draw boundary curves with combs of their curvature and print where the picture is.

    Returns
    -------
    code
        0, or 1 where a construction refuses the data; the others are drawn.

    Raises
    ------
    TestbedError
        There is no such view, an option is about surfaces, the plugins do not exist, or every one refuses the data.
    """
    from testbed import registry
    from testbed_reports.rendering.curve_figure import CurveSubject, write_curve_figure

    for name, given in (
        ("--style", request.style != "shaded"),
        ("--edges", request.edges is not None),
        ("--net", request.net),
        ("--extremes", request.extremes),
    ):
        if given:
            raise SpecError(f"{name} is about surfaces: leave it out with --curves")
    view = _checked(request)
    dataset = registry.dataset(request.dataset)
    mesh, subjects, refusals = dataset.mesh(request.level), [], []
    for text in request.names:
        curve = registry.boundary_curve(text)
        try:
            subjects.append(CurveSubject(str(curve), curve.network(mesh)))
        except Refused as refusal:
            refusals.append(refusal)
    if not subjects:
        raise refusals[0]
    try:
        write_curve_figure(
            request.output,
            subjects,
            size=request.size,
            view=view,
            limit=request.limit,
            title=f"{dataset}, level {request.level}.",
        )
    except OSError as error:
        raise _unwritable(request, error) from error
    return _end(request, refusals)


def _checked(request: Request) -> tuple[float, float] | None:
    """Return the view; SpecError for a limit, a file or a view that is none."""
    if request.limit is not None and not request.limit > 0.0:
        raise SpecError(f"a scale cannot end at the limit {request.limit:g}: give a positive number")
    if request.output.suffix.lower() != ".png":
        raise SpecError(f"{request.output} does not end in .png, the format of pictures: name it so")
    if request.view is None:
        return None
    try:
        azimuth, elevation = (float(number) for number in request.view.split(","))
    except ValueError as error:
        raise SpecError(
            f"{request.view!r} is no view: give azimuth and elevation in degrees, as --view=-60,25"
        ) from error
    return azimuth, elevation


def _unwritable(request: Request, error: OSError) -> SpecError:
    return SpecError(f"{request.output} cannot be written ({error.strerror}): choose another place")


def _end(request: Request, refusals: "Sequence[Refused]") -> int:
    """Print where the picture is and what is not on it; return the exit code."""
    from rich import print as rich_print
    from rich.markup import escape

    for reason in map(str, refusals):
        rich_print(f"[yellow]not drawn:[/] {escape(reason)}")
    rich_print(escape(str(request.output)))
    return 1 if refusals else 0
