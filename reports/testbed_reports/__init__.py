"""Built-in reports: from results to a page people read."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_reports() -> Iterable[str]:
    """Return the modules of this package and of the PDF's; each defines a report, or what reports share."""
    return (*modules_in(__name__), *modules_in(f"{__name__}.pdf"))
