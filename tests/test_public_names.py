import importlib
import types

import pytest

import testbed


@pytest.mark.parametrize("name", testbed.__all__)
def test_public_names_are_no_modules_whatever_has_been_imported(name: str) -> None:
    first = getattr(testbed, name)
    for module in ("scheme", "dataset", "measure", "boundary", "registry"):
        importlib.import_module(f"testbed.{module}")
    assert getattr(testbed, name) is first
    assert not isinstance(first, types.ModuleType)
    assert callable(first)


def test_submodules_keep_their_contents() -> None:
    from testbed.plugins.measure import Measure
    from testbed.plugins.scheme import Scheme

    assert Scheme.__module__ == "testbed.scheme"
    assert Measure.__module__ == "testbed.measure"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'schema'"):
        _ = testbed.schema
