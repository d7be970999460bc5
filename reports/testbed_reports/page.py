"""The page: one HTML file that holds everything it shows."""

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

from testbed.plugins.report import Report
from testbed_reports.view import Page

#: What the page is called in a results directory.
NAME: Final = "index.html"


@dataclass(frozen=True)
class HtmlPage(Report):
    """``index.html``: verdicts, orders, convergence plots and tables; opens without network and without scripts."""

    name = "page"
    title = "HTML page"
    reference = "this testbed"

    def write(self, directory: Path) -> tuple[Path, ...]:
        """Read the results in ``directory``, write ``index.html`` there, and return its path."""
        # pandas and matplotlib take their time, and the registry imports this module
        from testbed.harness.journal import write_whole
        from testbed.harness.results import read_results
        from testbed_reports.view import view

        path = directory / NAME
        write_whole(path, render(view(read_results(directory))))
        return (path,)


def render(page: Page) -> str:
    """Return the page as HTML; whatever plugins, files and meshes are called is text in it."""
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    from testbed_reports.plots import draw

    folder = files("testbed_reports")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = environment.from_string(folder.joinpath("page.html.j2").read_text("utf-8"))
    # the only markup that is not in the template: our own stylesheet, and drawings that hold no text of others
    stylesheet = Markup(folder.joinpath("page.css").read_text("utf-8"))  # noqa: S704 - ours
    plots = [
        [
            [Markup(svg) for svg in draw(drawing.panels, page.styles, f"plot-{number}-{group}")]  # noqa: S704 - our own labels
            for group, drawing in enumerate(section.drawings)
        ]
        for number, section in enumerate(page.sections)
    ]
    text = template.render(page=page, stylesheet=stylesheet, plots=plots)
    # half a surrogate pair, as in a file name that is not UTF-8, cannot be written
    return text.encode("utf-8", "backslashreplace").decode("utf-8")
