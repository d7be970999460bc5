"""Built-in datasets: one module a surface."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_datasets() -> Iterable[str]:
    """Return the modules of this package; each defines datasets, or geometry that datasets share."""
    return modules_in(__name__)
