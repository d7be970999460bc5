"""The PDF as a report, written where it is asked for."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from testbed.plugins.report import Report

if TYPE_CHECKING:
    from testbed.harness.results import Results

#: What the PDF is called in a results directory.
NAME: Final = "report.pdf"


@dataclass(frozen=True)
class PdfReport(Report):
    """``report.pdf``: the page's summary, pictures, tables and plots on paper, with every number in an appendix."""

    name = "pdf"
    title = "PDF"
    reference = "this testbed"
    on_request = True

    def write(self, directory: Path) -> tuple[Path, ...]:
        """Read the results in ``directory``, write ``report.pdf`` there, and return its path.

        Raises
        ------
        TestbedError
            The directory holds no results, or typst is not installed.
        """
        # pandas and matplotlib take their time, and the registry imports this module
        from testbed.harness.results import read_results

        path = directory / NAME
        content = made(read_results(directory))
        temporary = path.with_name(f".{NAME}.part")
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
        return (path,)


def made(results: "Results", jobs: int | None = None) -> bytes:
    """Return the PDF of results, finished or not; its surfaces are fitted again and drawn.

    Parameters
    ----------
    results
        The results.
    jobs
        Worker processes; one a processor if None. The bytes do not depend on it.
    """
    from testbed.harness.sources import Sources
    from testbed_reports.pdf.document import document
    from testbed_reports.pdf.figures import figures
    from testbed_reports.pdf.pool import Pool
    from testbed_reports.pdf.scheme_pages import descriptions
    from testbed_reports.pdf.typesetting import typeset
    from testbed_reports.view import view

    page, sources = view(results), Sources()
    with Pool(jobs) as pool:
        described = descriptions(results, sources)
        return typeset(document(results, page, figures(results, page, pool, sources), described), pool)
