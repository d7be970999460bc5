"""A cell's key follows the content it depends on: its scheme's files and what they import, and nothing else."""

import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from toy_plugins import File, Grid, Needy, Toy

from testbed import registry
from testbed.errors import TestbedError
from testbed.harness.plan import make_plan
from testbed.harness.run import run
from testbed.harness.sources import Sources

SCHEME = """
from dataclasses import dataclass
from toy_plugins import Toy
{imports}

@dataclass(frozen=True)
class {name}(Toy):
    name = "{lower}"

    def construct(self, mesh):
        {inside}
        return super().construct(mesh)
"""
FILES = {
    "__init__.py": """
        from testbed.registry import hookimpl, modules_in

        @hookimpl
        def testbed_schemes():
            return [f"{__name__}.one", f"{__name__}.two", f"{__name__}.three"]
    """,
    "one.py": SCHEME.format(name="One", lower="one", imports="from edited_toys.shared import FACTOR", inside="pass"),
    "two.py": SCHEME.format(name="Two", lower="two", imports="", inside="from . import deep"),
    "three.py": SCHEME.format(name="Three", lower="three", imports="import numpy", inside="pass"),
    "shared.py": "FACTOR = 1\n",
    "deep/__init__.py": "from ..deeper import VALUE\n",
    "deeper.py": "VALUE = 1\n",
    "unused.py": "VALUE = 1\n",
}

Edit = Callable[[str, str], None]


@pytest.fixture
def edit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Edit]:
    """Write the package ``edited_toys``; return a function that adds text to one of its files."""
    package = tmp_path / "edited_toys"
    for name, text in FILES.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(textwrap.dedent(text))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv(registry.VARIABLE, "toy_plugins,edited_toys")
    registry.load.cache_clear()

    def add(name: str, text: str) -> None:
        with (package / name).open("a") as file:
            file.write(text)

    yield add
    for name in [name for name in sys.modules if name.partition(".")[0] == "edited_toys"]:
        del sys.modules[name]


def contents() -> dict[str, str]:
    sources = Sources()
    return {name: sources.content(registry.scheme(name)) for name in ("one", "two", "three")}


@pytest.mark.parametrize(
    ("file", "changed"),
    [
        ("one.py", {"one"}),
        ("three.py", {"three"}),
        ("shared.py", {"one"}),
        ("deep/__init__.py", {"two"}),
        ("deeper.py", {"two"}),
        ("unused.py", set()),
        ("__init__.py", {"one", "two", "three"}),
    ],
)
def test_an_edit_changes_exactly_what_imports_the_file(edit: Edit, file: str, changed: set[str]) -> None:
    before = contents()
    edit(file, "# an edit\n")
    after = contents()
    assert {name for name in before if before[name] != after[name]} == changed


def test_a_changed_source_recomputes_exactly_its_cells(edit: Edit, tmp_path: Path) -> None:
    def total() -> tuple[int, int]:
        plan = make_plan(["one", "two", "three"], ["grid"], "0:1", ["sums"])
        summary = run(plan, tmp_path / "out", jobs=2)
        assert summary.counts == {"ok": 6}
        return summary.computed, summary.reused

    assert total() == (6, 0)
    assert total() == (0, 6)
    edit("shared.py", "FACTOR = 2\n")
    assert total() == (2, 4)


def test_a_source_that_changes_during_a_run_gives_no_results_under_the_old_key(edit: Edit, tmp_path: Path) -> None:
    plan = make_plan(["one", "two"], ["grid"], "0:1", ["sums"])
    edit("one.py", "# an edit\n")
    with pytest.raises(TestbedError, match=r"source of one changed .* 2 of 4 cells are not computed"):
        run(plan, tmp_path / "out", jobs=1)
    again = run(make_plan(["one", "two"], ["grid"], "0:1", ["sums"]), tmp_path / "out", jobs=1)
    assert (again.computed, again.reused) == (2, 2)


def test_the_kernel_counts_and_the_harness_does_not() -> None:
    files = Sources().files(Toy())
    assert {"toy_plugins", "testbed.plugins.scheme", "testbed.geometry.bezier", "testbed.geometry.mesh"} <= files.keys()
    passive = ("testbed.harness", "testbed.registry", "testbed.cli", "testbed.plugins.report")
    assert not [name for name in files if name.startswith(passive)]


def test_nested_plugins_count() -> None:
    boundary = registry.boundary_curve("hermite")
    nested = registry.scheme("shirman-sequin[boundary=hermite]")
    files = Sources().files(nested)
    assert type(boundary).__module__ in files
    assert type(boundary).__module__ not in Sources().files(registry.scheme("flat"))


def test_a_schemes_module_is_not_in_another_schemes_closure() -> None:
    sources = Sources()
    modules = {name: type(registry.scheme(name)).__module__ for name in ("flat", "nielson", "cubic-interpolant")}
    for name in modules:
        assert set(modules.values()) & sources.files(registry.scheme(name)).keys() == {modules[name]}


def test_parameters_are_not_content_but_files_are(tmp_path: Path) -> None:
    assert Sources().content(Toy()) == Sources().content(Toy(tag=1)) == Sources().content(Needy())
    file = tmp_path / "mesh.ply"
    file.write_text("a")
    first = Sources().content(File(path=str(file)))
    file.write_text("b")
    assert len({first, Sources().content(File(path=str(file))), Sources().content(Grid())}) == 3
