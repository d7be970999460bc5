"""The pictures and plots of all datasets, drawn in worker processes; whichever draws them, the bytes are the same."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from testbed.errors import TestbedError
from testbed.harness.results import Results
from testbed.harness.sources import Sources
from testbed_reports.pdf.pool import Lost, Pool
from testbed_reports.pdf.strips import Strip, strip
from testbed_reports.styles import Style
from testbed_reports.view import Drawing, Page


@dataclass(frozen=True)
class Figures:
    """What is drawn of a dataset.

    Parameters
    ----------
    strip
        The pictures of its surfaces, or None.
    plots
        SVG files: for each drawing its panels.
    reason
        Why there are no pictures although there should be; empty where there are.
    """

    strip: Strip | None
    plots: tuple[tuple[str, ...], ...]
    reason: str = ""


def figures(results: Results, page: Page, pool: Pool, sources: Sources | None = None) -> tuple[Figures, ...]:
    """Return the figures of each dataset.

    Parameters
    ----------
    results, page
        Results, and the page made of them.
    pool
        Where they are drawn.
    sources
        Hashes of sources, if some are known already.
    """
    tasks = [(results, section.dataset.spec, section.drawings, page.styles, sources) for section in page.sections]
    found = pool.map(drawn, tasks)
    return tuple(
        Figures(None, _plots(task[2], task[3]), one.reason) if isinstance(one, Lost) else one
        for one, task in zip(found, tasks, strict=True)
    )


def drawn(
    results: Results, dataset: str, drawings: Sequence[Drawing], styles: Sequence[Style], sources: Sources | None
) -> Figures:
    """Draw the figures of a dataset; runs in a worker."""
    plots = _plots(drawings, styles)
    try:
        return Figures(strip(results, dataset, sources), plots)
    except TestbedError as error:
        return Figures(None, plots, str(error))


def _plots(drawings: Sequence[Drawing], styles: Sequence[Style]) -> tuple[tuple[str, ...], ...]:
    from testbed_reports.plots import draw

    return tuple(
        tuple(map(standing_alone, draw(drawing.panels, styles, f"plot-{number}")))
        for number, drawing in enumerate(drawings)
    )


def standing_alone(svg: str) -> str:
    """Return an ``<svg>`` element of a page as a file of its own."""
    return svg.replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)


def swatch(style: Style) -> str:
    """Return the SVG file of a scheme's line and marker."""
    line = f'<path d="M0,6H24" stroke="{style.colour}" stroke-width="1.8"/>'
    marker = f'<path transform="translate(12 6) scale(4.2)" d="{style.outline}" fill="{style.colour}"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 12">{line}{marker}</svg>'


def files(page: Page, drawn: Sequence[Figures]) -> Mapping[str, bytes]:
    """Return all files that the document shows, by name."""
    found = {swatch_file(position): swatch(style).encode() for position, style in enumerate(page.styles)}
    for number, one in enumerate(drawn):
        for group, plots in enumerate(one.plots):
            found |= {plot_file(number, group, panel): svg.encode() for panel, svg in enumerate(plots)}
        for place, shot in enumerate(one.strip.shots if one.strip else ()):
            found |= {picture_file(number, place, style): image for style, image in enumerate(shot.images)}
    return found


def swatch_file(position: int) -> str:
    """Name of the file with the line and marker of a scheme."""
    return f"swatch-{position}.svg"


def plot_file(dataset: int, group: int, panel: int) -> str:
    """Name of the file of a plot."""
    return f"plot-{dataset}-{group}-{panel}.svg"


def picture_file(dataset: int, place: int, style: int) -> str:
    """Name of the file of a picture."""
    return f"picture-{dataset}-{place}-{style}.jpg"
