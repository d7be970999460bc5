"""Built-in measures: numbers read off a surface."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_measures() -> Iterable[str]:
    """Return the modules of this package; each defines measures, or mathematics that measures share."""
    return modules_in(__name__)
