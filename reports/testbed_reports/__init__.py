"""Built-in reports: from results to a page people read."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_reports() -> Iterable[str]:
    """Return the modules of this package, which define reports or what reports share, and that of the PDF."""
    return (*modules_in(__name__), f"{__name__}.pdf.report")
