import importlib
import pkgutil
import types

import pytest

import testbed


@pytest.mark.parametrize("name", testbed.__all__)
def test_public_names_are_no_modules_whatever_has_been_imported(name: str) -> None:
    # importing a submodule binds it to the package's attribute of that name, over a public function
    for module in pkgutil.iter_modules(testbed.__path__):
        importlib.import_module(f"testbed.{module.name}")
    public = getattr(testbed, name)
    assert callable(public)
    assert not isinstance(public, types.ModuleType)
    assert getattr(testbed, name) is public


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'schema'"):
        _ = testbed.schema
