"""What a result depends on, as one hash: the source files of a plugin and of everything they import.

The closure of a plugin are the modules of its class and bases and of the plugins its fields hold, the packages around
them, and whatever these import statically, inside functions too, as long as it belongs to the kernel (``testbed``), to
a plugin package (``testbed_*``) or to the plugin's own package. What only finds, runs or presents plugins is left out,
and so are libraries: their versions stand in ``run.json``. Files that a plugin says it reads, as in ``mesh:PATH``,
count with their bytes. Imports by computed names are not seen.
"""

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Final

from testbed.errors import PluginError, SpecError
from testbed.plugins.base import Plugin

#: Modules, with all inside them, that cannot change a number.
PASSIVE: Final = (
    "testbed.registry",
    "testbed.plugins.spec",
    "testbed.plugins.report",
    "testbed.harness",
    "testbed.conformance",
    "testbed.cli",
)


class Sources:
    """Hashes of source closures; remembers files between questions, so make a new one to see later edits."""

    def __init__(self) -> None:
        self._hashes: dict[Path, str] = {}
        self._imports: dict[str, tuple[str, ...]] = {}

    def content(self, plugin: Plugin) -> str:
        """Return the hash of all that the plugin's results depend on, besides its parameters, in hexadecimal.

        Raises
        ------
        PluginError
            A class has no source file.
        SpecError
            A file that a parameter names cannot be read.
        """
        digest = hashlib.sha256()
        for name, path in sorted(self.files(plugin).items()):
            digest.update(f"{name} {self._hash(path)}\n".encode())
        for one in plugin.nested():
            for path in one.files():
                try:
                    if path.exists() and not path.is_file():  # reading a pipe would wait for ever
                        raise SpecError(f"{one} names {path}, which is not a file: give the path of a file")
                    digest.update(f"{one.name} {self._hash(path)}\n".encode())
                except OSError as error:
                    raise SpecError(
                        f"{one} names the file {path}, which cannot be read ({error.strerror}): check the path"
                    ) from error
        return digest.hexdigest()

    def files(self, plugin: Plugin) -> dict[str, Path]:
        """Return the closure: module names and their files."""
        classes = [base for one in plugin.nested() for base in type(one).__mro__ if issubclass(base, Plugin)]
        own = {base.__module__.partition(".")[0] for base in classes}
        pending = [base.__module__ for base in classes]
        found: dict[str, Path] = {}
        seen: set[str] = set()
        while pending:
            name = pending.pop()
            if name in seen or not _counts(name, own):
                continue
            seen.add(name)
            path = _file(name)
            if path is None:
                if any(base.__module__ == name for base in classes):
                    raise PluginError(f"{plugin} is defined in {name}, which has no source file: put it into a module")
                continue
            # the facade only passes names on: what stands behind it counts, its own text does not
            if name != "testbed":
                found[name] = path
            pending.extend(self._imported(name, path))
            pending.extend(package for package in _packages(name) if package != "testbed")
        return found

    def _hash(self, path: Path) -> str:
        if path not in self._hashes:
            self._hashes[path] = hashlib.sha256(path.read_bytes()).hexdigest()
        return self._hashes[path]

    def _imported(self, name: str, path: Path) -> tuple[str, ...]:
        if name not in self._imports:
            text = path.read_bytes() if path.suffix == ".py" else b""
            self._imports[name] = tuple(_imports(ast.parse(text, str(path)), name, path.name == "__init__.py"))
        return self._imports[name]


def _counts(name: str, own: set[str]) -> bool:
    top = name.partition(".")[0]
    if any(name == passive or name.startswith(f"{passive}.") for passive in PASSIVE):
        return False
    return top == "testbed" or top.startswith("testbed_") or top in own


def _packages(name: str) -> Iterator[str]:
    """Packages that importing a module runs first."""
    while "." in name:
        name = name.rpartition(".")[0]
        yield name


def _spec(name: str) -> ModuleSpec | None:
    """Where a module is, or None if there is no such module."""
    module = sys.modules.get(name)
    if module is not None and module.__spec__ is not None:
        return module.__spec__
    try:
        return importlib.util.find_spec(name)
    except (ImportError, AttributeError, ValueError):
        return None  # a name inside a module, or an optional import that is not installed


def _file(name: str) -> Path | None:
    spec = _spec(name)
    if spec is None or not spec.has_location or spec.origin is None:
        return None
    return Path(spec.origin)


def _imports(tree: ast.AST, name: str, is_package: bool) -> Iterator[str]:
    """Names that a module may import; ``from a import b`` gives a and a.b, whichever of them are modules."""
    package = name if is_package else name.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")
                base = ".".join([*parents[: len(parents) - node.level + 1], *([base] if base else [])])
            yield base
            yield from (f"{base}.{alias.name}" for alias in node.names if alias.name != "*")
