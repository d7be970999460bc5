"""``render``: pictures of surfaces, side by side."""

from dataclasses import dataclass
from pathlib import Path

from testbed import registry
from testbed.errors import SpecError


@dataclass(frozen=True)
class Request:
    """What is to be drawn.

    Parameters
    ----------
    schemes, dataset, level
        Whose surfaces.
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
    """

    schemes: tuple[str, ...]
    dataset: str
    level: int
    style: str
    view: str | None
    edges: bool | None
    limit: float | None
    size: int
    output: Path


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
    from rich import print as rich_print
    from rich.markup import escape

    from testbed.errors import Refused
    from testbed_reports.rendering.colouring import EXACT, STYLES
    from testbed_reports.rendering.figure import Subject, caption, write_figure

    style = next((style for style in STYLES if style == request.style), None)
    if style is None:
        raise SpecError(f"there is no style {request.style!r}: take {', '.join(STYLES)}")
    if request.limit is not None and not request.limit > 0.0:
        raise SpecError(f"a scale cannot end at the limit {request.limit:g}: give a positive number")
    if request.output.suffix.lower() != ".png":
        raise SpecError(f"{request.output} does not end in .png, the format of pictures: name it so")
    dataset = registry.dataset(request.dataset)
    if style in EXACT and dataset.surface is None:
        raise SpecError(f"{dataset} has no exact surface to measure distances from: take another style or dataset")
    view = None if request.view is None else _view(request.view)
    mesh, subjects, refusals = dataset.mesh(request.level), [], []
    for text in request.schemes:
        scheme = registry.scheme(text)
        try:
            subjects.append(Subject(str(scheme), scheme.fit(mesh), dataset.surface))
        except Refused as refusal:
            refusals.append(refusal)
    if not subjects:
        raise refusals[0]
    title = f"{dataset}, level {request.level}. {caption(style)}"
    try:
        write_figure(
            request.output,
            subjects,
            style,
            size=request.size,
            view=view,
            edges=request.edges,
            limit=request.limit,
            title=title,
        )
    except OSError as error:
        raise SpecError(f"{request.output} cannot be written ({error.strerror}): choose another place") from error
    for reason in map(str, refusals):
        rich_print(f"[yellow]not drawn:[/] {escape(reason)}")
    rich_print(escape(str(request.output)))
    return 1 if refusals else 0


def _view(text: str) -> tuple[float, float]:
    """Two angles in degrees from text."""
    try:
        azimuth, elevation = (float(number) for number in text.split(","))
    except ValueError as error:
        raise SpecError(f"{text!r} is no view: give azimuth and elevation in degrees, as --view=-60,25") from error
    return azimuth, elevation
