"""What the READMEs say holds: names, code, and that everything registered is documented."""

import re
from pathlib import Path

import numpy as np
import pytest

import testbed
from testbed.plugins.base import Plugin
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.dataset import Dataset
from testbed.plugins.scheme import Scheme
from testbed.registry import catalogue

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text("utf-8")


@pytest.mark.parametrize("kind", [Scheme, BoundaryCurve, Dataset])
def test_everything_registered_is_in_the_readme(kind: type[Plugin]) -> None:
    missing = [name for name in catalogue(kind) if f"`{name}`" not in README and f"`{name}:PATH`" not in README]
    assert not missing


def test_the_readme_claims_what_the_schemes_claim() -> None:
    for name, kind in catalogue(Scheme).items():  # type: ignore[type-abstract]
        scheme = kind()
        row = next(line for line in README.splitlines() if line.startswith(f"| `{name}` |"))
        claim = row.split("|")[2]
        assert scheme.continuity.value in claim
        order = re.search(r"order (\d+)", claim)
        assert (float(order[1]) if order else None) == scheme.order


def test_the_two_commands_stand_in_the_readme_as_ci_runs_them() -> None:
    assert "python3 -m venv .venv && .venv/bin/pip install -e . && .venv/bin/testbed run " in README
    assert "python3 -m venv .venv && .venv/bin/pip install -e '.[test]' && .venv/bin/pytest " in README


def test_the_python_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "part.ply").write_bytes((ROOT / "datasets/testbed_datasets/pebble.ply").read_bytes())
    monkeypatch.chdir(tmp_path)
    code = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert code is not None
    found: dict[str, object] = {}
    exec(code[1], found)  # noqa: S102 - our own README
    assert isinstance(found["surface"], testbed.Surface)
    row = found["row"]
    assert isinstance(row, dict)
    assert np.isfinite(row["distance_max"])


@pytest.mark.parametrize("folder", ["schemes", "datasets", "reports"])
def test_every_plugin_folder_says_how_to_add_one(folder: str) -> None:
    assert "## Add" in (ROOT / folder / "README.md").read_text("utf-8")
