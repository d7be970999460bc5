"""The plugin manager behind one typed facade.

A distribution takes part through the entry-point group ``testbed``: its entry point names a module with implementations
of the hooks in :class:`Hooks`, each returning where plugins of a kind are defined. The environment variable
``TESTBED_PLUGINS`` names further such modules, separated by commas, for plugins that are not installed.
"""

import dataclasses
import functools
import importlib
import importlib.metadata
import importlib.resources
import importlib.util
import inspect
import os
import pkgutil
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType, ModuleType
from typing import Final, TypeVar, cast

import pluggy

from testbed.errors import PluginError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.plugins.measure import Measure, Value, measure_all
from testbed.plugins.not_built import NotBuilt, read_not_built
from testbed.plugins.report import Report
from testbed.plugins.scheme import Scheme
from testbed.plugins.spec import parse

P = TypeVar("P", bound=Plugin)

GROUP: Final = "testbed"
VARIABLE: Final = "TESTBED_PLUGINS"

hookspec = pluggy.HookspecMarker(GROUP)
hookimpl = pluggy.HookimplMarker(GROUP)


class Hooks:
    """Hook specifications. Each returns modules (``"package.module"``) or single classes (``"package.module:Class"``).

    Of a module every concrete plugin class defined in it is taken; a module without any is fine (shared mathematics).
    Nothing is imported before it is needed, so return texts, and keep the hook module light.
    """

    @hookspec
    def testbed_schemes(self) -> Iterable[str]:
        """Return where interpolation schemes are defined."""
        raise AssertionError  # a specification is never called

    @hookspec
    def testbed_boundary_curves(self) -> Iterable[str]:
        """Return where boundary curve constructions are defined."""
        raise AssertionError

    @hookspec
    def testbed_datasets(self) -> Iterable[str]:
        """Return where datasets are defined."""
        raise AssertionError

    @hookspec
    def testbed_measures(self) -> Iterable[str]:
        """Return where measures are defined."""
        raise AssertionError

    @hookspec
    def testbed_reports(self) -> Iterable[str]:
        """Return where reports are defined."""
        raise AssertionError

    @hookspec
    def testbed_not_built(self) -> Iterable[str]:
        """Return files that tell of published schemes that are not built, as ``"package:file.toml"``."""
        raise AssertionError


#: kind -> (its hook, what a user calls it)
KINDS: Final[Mapping[type[Plugin], tuple[str, str]]] = MappingProxyType(
    {
        Scheme: ("testbed_schemes", "scheme"),
        BoundaryCurve: ("testbed_boundary_curves", "boundary curve"),
        Dataset: ("testbed_datasets", "dataset"),
        Measure: ("testbed_measures", "measure"),
        Report: ("testbed_reports", "report"),
    }
)


def modules_in(package: str) -> tuple[str, ...]:
    """Names of the modules directly in a package, sorted, without importing them."""
    spec = importlib.util.find_spec(package)
    paths = spec.submodule_search_locations if spec else None
    return tuple(sorted(f"{package}.{module.name}" for module in pkgutil.iter_modules(paths) if not module.ispkg))


@dataclass(frozen=True)
class Problem:
    """A plugin that could not be imported: it is listed, and skipped.

    Parameters
    ----------
    source
        The entry point, module or class.
    message
        The error's type and text.
    """

    source: str
    message: str


@dataclass(frozen=True)
class Registry:
    """Everything that is registered, sorted by name.

    Parameters
    ----------
    classes
        Kind to name to class.
    problems
        What could not be imported.
    not_built
        Published schemes that have no plugin, by name.
    """

    classes: Mapping[type[Plugin], Mapping[str, type[Plugin]]]
    problems: tuple[Problem, ...]
    not_built: tuple[NotBuilt, ...] = ()

    def catalogue(self, kind: type[P]) -> Mapping[str, type[P]]:
        """Return the plugins of a kind by name."""
        return cast("Mapping[str, type[P]]", self.classes[kind])

    def kind_name(self, kind: type[Plugin]) -> str:
        """Return what a user calls a kind."""
        return KINDS[kind][1]


@functools.cache
def load() -> Registry:
    """Find, import and check all plugins, once a process.

    Raises
    ------
    PluginError
        A misspelt hook, a hook with wrong arguments, a duplicate name, a plugin without a required declaration; the
        message names the plugin.
    """
    return build(_sources())


def build(sources: Iterable[tuple[str, ModuleType | Problem]]) -> Registry:
    """Return the registry of named hook modules (or what went wrong importing them)."""
    hooks = pluggy.PluginManager(GROUP)
    hooks.add_hookspecs(Hooks)
    problems = []
    for name, module in sources:
        if isinstance(module, Problem):
            problems.append(module)
            continue
        try:
            hooks.register(module, name=name)
            hooks.check_pending()
        except (pluggy.PluginValidationError, ValueError) as error:
            raise PluginError(
                f"plugin {name} ({module.__name__}) does not fit testbed.registry.Hooks: {' '.join(str(error).split())}"
            ) from error
    classes: dict[type[Plugin], Mapping[str, type[Plugin]]] = {}
    for kind, (hook, _) in KINDS.items():
        found: dict[str, type[Plugin]] = {}
        for implementation in hooks.hook.__dict__[hook].get_hookimpls():
            for place in implementation.function():
                for plugin in _classes_at(place, kind, problems):
                    _check(plugin, kind, implementation.plugin_name)
                    other = found.setdefault(plugin.name, plugin)
                    if other is not plugin:
                        raise PluginError(
                            f"two plugins are {KINDS[kind][1]} {plugin.name!r}, {_place(other)} and {_place(plugin)}: "
                            "rename one of them"
                        )
        classes[kind] = MappingProxyType(dict(sorted(found.items())))
    unbuilt = [
        entry
        for implementation in hooks.hook.testbed_not_built.get_hookimpls()
        for place in cast("Iterable[str]", implementation.function())
        for entry in _not_built_at(place)
    ]
    return Registry(MappingProxyType(classes), tuple(problems), tuple(sorted(unbuilt, key=lambda entry: entry.name)))


def _not_built_at(place: str) -> tuple[NotBuilt, ...]:
    package, _, name = place.partition(":")
    return read_not_built(importlib.resources.files(package).joinpath(name).read_text("utf-8"), place)


def _sources() -> Iterable[tuple[str, ModuleType | Problem]]:
    points = sorted(importlib.metadata.entry_points(group=GROUP), key=lambda point: (point.name, point.value))
    for point in points:
        distribution = point.dist.name if point.dist else "?"
        yield _imported(f"{distribution}:{point.name}", point.value)
    for value in filter(None, (name.strip() for name in os.environ.get(VARIABLE, "").split(","))):
        yield _imported(f"{VARIABLE}:{value}", value)


def _imported(name: str, module: str) -> tuple[str, ModuleType | Problem]:
    try:
        return name, importlib.import_module(module)
    except Exception as error:  # noqa: BLE001 - whatever a plugin raises while it is imported is its own problem
        return name, Problem(f"{name} ({module})", f"{type(error).__name__}: {error}")


def _classes_at(place: str, kind: type[Plugin], problems: list[Problem]) -> list[type[Plugin]]:
    """Concrete plugin classes of a kind in a module, or the one class named; an import error becomes a problem."""
    module_name, _, class_name = place.partition(":")
    _, module = _imported(place, module_name)
    if isinstance(module, Problem):
        problems.append(Problem(place, module.message))
        return []
    if class_name:
        chosen = getattr(module, class_name, None)
        if not (isinstance(chosen, type) and issubclass(chosen, kind)):
            problems.append(Problem(place, f"the module defines no {KINDS[kind][1]} of that name"))
            return []
        return [chosen]
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, kind)
        and value.__module__ == module_name
        and not inspect.isabstract(value)
    ]


def _place(plugin: type[Plugin]) -> str:
    return f"{plugin.__module__}:{plugin.__qualname__}"


def _check(plugin: type[Plugin], kind: type[Plugin], source: str) -> None:
    """Raise PluginError unless the class is a plugin as the kind demands it."""
    where = f"{KINDS[kind][1]} {_place(plugin)} of plugin {source}"
    missing = [name for name in plugin.required if not hasattr(plugin, name)]
    if missing:
        raise PluginError(f"{where} does not declare {', '.join(missing)}: set them as class attributes")
    if inspect.isabstract(plugin):
        methods = ", ".join(sorted(plugin.__abstractmethods__))
        raise PluginError(f"{where} does not define {methods}: a plugin has to")
    if not isinstance(plugin.name, str) or not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", plugin.name):
        raise PluginError(f"{where} is called {plugin.name!r}: a name has lower case letters, digits and hyphens only")
    if "__dataclass_params__" not in vars(plugin) or not vars(plugin)["__dataclass_params__"].frozen:
        raise PluginError(f"{where} is no frozen dataclass: put @dataclass(frozen=True) above it")
    for field in dataclasses.fields(plugin):
        if field.default is dataclasses.MISSING:
            raise PluginError(f"{where} has a parameter {field.name} without a default: give it one")


def catalogue(kind: type[P]) -> Mapping[str, type[P]]:
    """Return the registered plugins of a kind (Scheme, BoundaryCurve, Dataset, Measure, Report) by name."""
    return load().catalogue(kind)


def scheme(spec: str) -> Scheme:
    """Return the scheme a text like ``shirman-sequin[boundary=hermite,alpha2=1.75]`` names; SpecError if none."""
    return parse(spec, Scheme, load())  # type: ignore[type-abstract]  # the kind itself is abstract, what comes is not


def boundary_curve(spec: str) -> BoundaryCurve:
    """Return the boundary curve construction that a text names; SpecError if none."""
    return parse(spec, BoundaryCurve, load())  # type: ignore[type-abstract]  # as above


def dataset(spec: str) -> Dataset:
    """Return the dataset that a text like ``torus[minor=0.4]`` or ``mesh:part.ply`` names; SpecError if none."""
    return parse(spec, Dataset, load())  # type: ignore[type-abstract]  # as above


def measures() -> tuple[Measure, ...]:
    """Return every registered measure with its default settings, sorted by name."""
    return tuple(measure() for measure in catalogue(Measure).values())  # type: ignore[type-abstract]  # as above


def reports() -> tuple[Report, ...]:
    """Return every registered report, sorted by name."""
    return tuple(report() for report in catalogue(Report).values())  # type: ignore[type-abstract]  # as above


def measure(surface: Surface, exact: ExactSurface | None = None) -> dict[str, Value]:
    """Return all columns of all registered measures for a surface, against the exact one where there is one."""
    return measure_all(measures(), surface, exact)
