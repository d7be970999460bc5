"""Built-in interpolation schemes and boundary curves: one module a scheme, one module a curve construction."""

from collections.abc import Iterable

from testbed.registry import hookimpl, modules_in


@hookimpl
def testbed_schemes() -> Iterable[str]:
    """Return the modules of this package; each defines a scheme, or mathematics that schemes share."""
    return modules_in(__name__)


@hookimpl
def testbed_boundary_curves() -> Iterable[str]:
    """Return the modules that define boundary curve constructions."""
    return modules_in(f"{__name__}.boundary_curves")


@hookimpl
def testbed_not_built() -> Iterable[str]:
    """Return the list of published schemes that are not built."""
    return [f"{__name__}:not_built.toml"]
