"""The PDF as a report, written where it is asked for."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

from testbed.plugins.report import Report

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
        # pandas, matplotlib and typst take their time, and the registry imports this module
        from testbed.harness.results import read_results
        from testbed_reports.pdf.document import document
        from testbed_reports.pdf.typesetting import typeset

        path = directory / NAME
        content = typeset(document(read_results(directory)))
        temporary = path.with_name(f".{NAME}.part")
        try:
            temporary.write_bytes(content)
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
        return (path,)
