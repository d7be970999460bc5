"""Built-in reports: from results to a page people read."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_reports() -> Iterable[str]:
    """Return the modules of this package; each defines a report, or what reports share."""
    return modules_in(__name__)
