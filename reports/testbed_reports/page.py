"""The page: one HTML file that holds everything it shows."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from testbed.plugins.report import Report
from testbed_reports.view import Page

if TYPE_CHECKING:
    from markupsafe import Markup

    from testbed_reports.viewer.model import Scene

#: What the page is called in a results directory.
NAME: Final = "index.html"


@dataclass(frozen=True)
class HtmlPage(Report):
    """``index.html``: verdicts, orders, plots, tables, and the surfaces themselves to be turned and coloured.

    One file that loads nothing. Without scripts or WebGL it is all there but the turning: pictures stand in its place.
    """

    name = "page"
    title = "HTML page"
    reference = "this testbed"

    def write(self, directory: Path) -> tuple[Path, ...]:
        """Read the results in ``directory``, write ``index.html`` there, and return its path."""
        # pandas and matplotlib take their time, and the registry imports this module
        from testbed.harness.journal import write_whole
        from testbed.harness.results import read_results
        from testbed_reports.view import view
        from testbed_reports.viewer.scenes import scenes

        path = directory / NAME
        results = read_results(directory)
        write_whole(path, render(view(results), scenes(results)))
        return (path,)


def render(page: Page, scenes: Sequence["Scene"] = ()) -> str:
    """Return the page as HTML; whatever plugins, files and meshes are called is text in it.

    Parameters
    ----------
    page
        What it says.
    scenes
        The surfaces of each of its sections, or none.
    """
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    from testbed_reports.plots import draw
    from testbed_reports.viewer import markup
    from testbed_reports.viewer.model import BUDGET

    folder = files("testbed_reports")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(folder.joinpath("page.html.j2").read_text("utf-8"))
    # the only markup that is not in the template: our own stylesheet and script, drawings that hold no text of others,
    # and data in which no character is markup
    stylesheet = Markup(folder.joinpath("page.css").read_text("utf-8") + markup.stylesheet())  # noqa: S704 - ours
    script = markup.script()
    plots = [
        [
            [Markup(svg) for svg in draw(drawing.panels, page.styles, f"plot-{number}-{group}")]  # noqa: S704 - our own labels
            for group, drawing in enumerate(section.drawings)
        ]
        for number, section in enumerate(page.sections)
    ]
    text = template.render(
        page=page,
        stylesheet=stylesheet,
        plots=plots,
        scenes=scenes,
        budget=BUDGET,
        script=Markup(script),  # noqa: S704 - ours
        digest=markup.digest(script),
        numbers={section.dataset.spec: number for number, section in enumerate(page.sections)},
        legends=[markup.legend(scene) for scene in scenes],
        run_data=_data(markup.run_data(page)),
        viewer_data=_data(markup.settings()) if scenes else "",
        scene_data=[_data(markup.scene_data(scene, number)) for number, scene in enumerate(scenes)],
    )
    # half a surrogate pair, as in a file name that is not UTF-8, cannot be written
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _data(value: Any) -> "Markup":
    """Return a value as JSON that is no markup."""
    from markupsafe import Markup

    from testbed_reports.viewer.markup import embedded

    return Markup(embedded(value))  # noqa: S704 - holds neither < nor > nor &
