"""A plugin without a test, without documentation, or with an undocumented parameter fails here."""

import dataclasses
import inspect
import sys
from pathlib import Path

import pytest

from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.plugins.measure import Measure
from testbed.plugins.scheme import Scheme
from testbed.registry import KINDS, catalogue, load

TESTS = Path(__file__).parent
ALL = [plugin for kind in KINDS for plugin in load().classes[kind].values()]
every_plugin = pytest.mark.parametrize("plugin", ALL, ids=lambda plugin: plugin.name)


@every_plugin
def test_it_says_what_it_is_and_where_it_comes_from(plugin: type[Plugin]) -> None:
    assert plugin.__doc__
    assert sys.modules[plugin.__module__].__doc__
    assert plugin.title
    assert plugin.reference


@every_plugin
def test_every_parameter_is_documented(plugin: type[Plugin]) -> None:
    documented = inspect.cleandoc(plugin.__doc__ or "").splitlines()
    missing = [
        field.name
        for field in dataclasses.fields(plugin)
        if not any(field.name in line.replace(",", " ").split() for line in documented if not line.startswith(" "))
    ]
    assert not missing


@every_plugin
def test_the_default_is_a_plugin_that_parses_back(plugin: type[Plugin]) -> None:
    assert str(plugin()) == plugin.name
    assert hash(plugin()) == hash(plugin())


@pytest.mark.parametrize("name", catalogue(Scheme))  # type: ignore[type-abstract]
def test_every_scheme_has_a_test_file_of_its_own(name: str) -> None:
    module = sys.modules[catalogue(Scheme)[name].__module__]  # type: ignore[type-abstract]
    assert module.__file__ is not None
    assert (TESTS / "schemes" / f"test_{Path(module.__file__).stem}.py").exists()


@pytest.mark.parametrize(("kind", "folder"), [(BoundaryCurve, "schemes"), (Dataset, "datasets"), (Measure, "measures")])
def test_tests_run_over_the_registry_or_name_each(kind: type[Plugin], folder: str) -> None:
    text = "\n".join(path.read_text("utf-8") for path in sorted((TESTS / folder).glob("*.py")))
    named = [name for name, plugin in load().classes[kind].items() if plugin.__name__ in text or f'"{name}"' in text]
    assert f"catalogue({kind.__name__})" in text or set(named) == set(load().classes[kind])


@pytest.mark.parametrize("name", catalogue(Measure))  # type: ignore[type-abstract]
def test_every_column_has_a_meaning(name: str) -> None:
    for column in catalogue(Measure)[name].columns:  # type: ignore[type-abstract]
        assert len(column.meaning.split()) >= 2


@pytest.mark.parametrize("plugin", [*catalogue(Scheme).values(), *catalogue(BoundaryCurve).values()])  # type: ignore[type-abstract]
def test_it_tells_its_formula_its_status_and_where_it_fails(plugin: type[Plugin]) -> None:
    for text in (plugin.formula, plugin.status, plugin.failures):
        assert len(text.split()) >= 2
        assert text.endswith(".") or text == plugin.formula
