"""Plugins are found, checked and named: what breaks the rules is an error, what fails to import is listed."""

import sys
import types
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from testbed.errors import PluginError, SpecError
from testbed.plugins.dataset import Dataset
from testbed.plugins.not_built import read_not_built
from testbed.plugins.scheme import Scheme
from testbed.registry import KINDS, VARIABLE, Registry, build, hookimpl, load, modules_in, scheme

SCHEME = """
from dataclasses import dataclass
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface

{decorator}
class Toy(Scheme):
    {name}
    title = "Toy"
    reference = "nobody"
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order = None
    reproduces = ()
    {method}
"""
DECORATOR = "@dataclass(frozen=True)"
METHOD = "def construct(self, mesh: HermiteMesh) -> Surface: raise ValueError"


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Write a module with a scheme into an importable folder."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def write(
        module: str, name: str = 'name = "toy"', decorator: str = DECORATOR, method: str = METHOD, head: str = ""
    ) -> None:
        monkeypatch.delitem(sys.modules, module, raising=False)
        (tmp_path / f"{module}.py").write_text(head + SCHEME.format(name=name, decorator=decorator, method=method))

    return write


def plugin(*places: str) -> types.ModuleType:
    module = types.ModuleType("toy_hooks")

    def testbed_schemes() -> Iterable[str]:
        return places

    module.__dict__["testbed_schemes"] = hookimpl(testbed_schemes)
    return module


def built(*places: str) -> Registry:
    return build([("toy", plugin(*places))])


def test_everything_built_in_imports() -> None:
    assert load().problems == ()


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_plugins_sorted_by_name(kind: type) -> None:
    names = list(load().classes[kind])
    assert names
    assert names == sorted(names)


def test_a_scheme_is_found_by_its_module_and_by_its_class(toy: Callable[..., None]) -> None:
    toy("toy_one")
    assert list(built("toy_one").catalogue(Scheme)) == ["toy"]  # type: ignore[type-abstract]
    assert list(built("toy_one:Toy").catalogue(Scheme)) == ["toy"]  # type: ignore[type-abstract]
    assert not built("toy_one").catalogue(Dataset)  # type: ignore[type-abstract]


def test_a_module_that_fails_to_import_is_listed_with_its_error_and_the_rest_stays(toy: Callable[..., None]) -> None:
    toy("toy_good")
    toy("toy_bad", head="raise RuntimeError('no licence')\n")
    registry = built("toy_bad", "toy_good", "toy_absent")
    assert list(registry.catalogue(Scheme)) == ["toy"]  # type: ignore[type-abstract]
    listed = {problem.source: problem.message for problem in registry.problems}
    assert listed["toy_bad"] == "RuntimeError: no licence"
    assert "toy_absent" in listed["toy_absent"]


def test_two_schemes_of_one_name_are_an_error_that_names_both(toy: Callable[..., None]) -> None:
    toy("toy_first")
    toy("toy_second")
    with pytest.raises(PluginError, match=r"'toy'.*toy_first:Toy.*toy_second:Toy"):
        built("toy_first", "toy_second")


def test_the_same_class_twice_is_no_duplicate(toy: Callable[..., None]) -> None:
    toy("toy_twice")
    assert len(built("toy_twice", "toy_twice:Toy").catalogue(Scheme)) == 1  # type: ignore[type-abstract]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"name": ""}, r"does not declare name"),
        ({"name": 'name = "Toy 1"'}, r"lower case"),
        ({"decorator": ""}, r"no frozen dataclass"),
        (
            {"decorator": "@dataclass(frozen=True, init=True)", "name": 'name = "toy"; size: float'},
            r"size without a default",
        ),
    ],
)
def test_a_plugin_that_breaks_the_rules_is_an_error_that_names_it(
    toy: Callable[..., None], change: dict[str, str], words: str
) -> None:
    toy("toy_broken", **change)
    with pytest.raises((PluginError, TypeError), match=words) as caught:
        built("toy_broken:Toy")
    assert "toy_broken:Toy" in str(caught.value)


def test_a_named_class_that_is_abstract_is_an_error(toy: Callable[..., None]) -> None:
    toy("toy_abstract", method="pass")
    with pytest.raises(PluginError, match=r"toy_abstract:Toy.*does not define construct"):
        built("toy_abstract:Toy")


def test_a_misspelt_hook_is_an_error_that_names_the_plugin() -> None:
    module = types.ModuleType("toy_misspelt")
    module.__dict__["testbed_scheme"] = hookimpl(lambda: ())
    module.__dict__["testbed_scheme"].__name__ = "testbed_scheme"
    with pytest.raises(PluginError, match=r"toy_misspelt.*testbed_scheme"):
        build([("toy", module)])


def test_a_hook_with_a_wrong_argument_is_an_error_that_names_the_plugin() -> None:
    module = types.ModuleType("toy_argument")

    def testbed_schemes(surprise: str) -> Iterable[str]:
        return (surprise,)

    module.__dict__["testbed_schemes"] = hookimpl(testbed_schemes)
    with pytest.raises(PluginError, match=r"toy_argument.*surprise"):
        build([("toy", module)])


def test_plugins_named_in_the_environment_are_found(
    toy: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    toy("toy_environment")
    (tmp_path / "toy_environment_hooks.py").write_text(
        "from testbed.registry import hookimpl\n\n@hookimpl\ndef testbed_schemes(): return ['toy_environment']\n"
    )
    monkeypatch.setenv(VARIABLE, "toy_environment_hooks, toy_nowhere")
    load.cache_clear()
    try:
        assert str(scheme("toy")) == "toy"
        assert [problem.source for problem in load().problems] == [f"{VARIABLE}:toy_nowhere (toy_nowhere)"]
    finally:
        load.cache_clear()


def test_an_unknown_scheme_is_answered_with_the_nearest() -> None:
    with pytest.raises(SpecError, match=r"no scheme is called 'nielsen': did you mean nielson\?"):
        scheme("nielsen")


def test_modules_are_listed_without_being_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "toy_package").mkdir()
    (tmp_path / "toy_package" / "__init__.py").write_text("")
    (tmp_path / "toy_package" / "one.py").write_text("raise RuntimeError")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert modules_in("toy_package") == ("toy_package.one",)


def test_schemes_that_are_not_built_are_told_with_the_reason_and_what_comes_nearest() -> None:
    known = load()
    assert known.not_built
    for entry in known.not_built:
        assert entry.name not in known.classes[Scheme]
        assert entry.title
        assert entry.reference
        assert len(entry.why.split()) > 5
        assert set(entry.nearest) <= set(known.classes[Scheme])


@pytest.mark.parametrize("text", ["[[scheme]]\nname = 'a'", "scheme = 3 =", "[[scheme]]\nname = 'a'\nx = 2"])
def test_a_list_of_schemes_not_built_is_checked(text: str) -> None:
    with pytest.raises(PluginError, match="here"):
        read_not_built(text, "here")
