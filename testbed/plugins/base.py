"""What every plugin kind shares: a frozen dataclass whose fields are its parameters and whose text is its identity."""

import dataclasses
import json
import math
import re
from abc import ABC
from pathlib import Path
from typing import Any, ClassVar

from testbed.errors import SpecError

#: Text that can stand unquoted as a parameter value: nothing that ends a value or looks like another type's text.
_BARE = re.compile(r"[A-Za-z_][\w./+-]*")


@dataclasses.dataclass(frozen=True)
class Plugin(ABC):
    """Base of the plugin kinds. Subclasses are frozen dataclasses; every field has a default.

    Attributes
    ----------
    name
        What the command line calls it: lower case letters, digits and hyphens.
    title
        What tables and captions call it; any text.
    reference
        Where it is published.
    positional
        The text field that ``name:TEXT`` sets, for instance a file's path; None where there is none.
    formula
        The construction in a line or two of plain text, for catalogues; empty where there is nothing to say.
    status
        How its formulas relate to the published ones: as printed, corrected, or a fill where the source is silent.
    failures
        Data on which it is known to fail, to be refused or to look bad.
    required
        Class attributes that every registered plugin of the kind has to declare.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    formula: ClassVar[str] = ""
    status: ClassVar[str] = ""
    failures: ClassVar[str] = ""
    positional: ClassVar[str | None] = None
    required: ClassVar[tuple[str, ...]] = ("name", "title", "reference")

    def __str__(self) -> str:
        """``name[field=value,...]`` with the fields that differ from their defaults; parses back to an equal plugin."""
        changed = {
            field.name: getattr(self, field.name)
            for field in dataclasses.fields(self)
            if getattr(self, field.name) != field.default
        }
        tail = f":{_format_tail(changed.pop(self.positional))}" if self.positional in changed else ""
        inner = ",".join(f"{name}={format_value(value)}" for name, value in changed.items())
        return self.name + (f"[{inner}]" if inner else "") + tail

    def files(self) -> tuple[Path, ...]:
        """Return the files that results depend on besides the plugin's source: a mesh that it reads, for instance."""
        return ()

    def nested(self) -> tuple["Plugin", ...]:
        """Return this plugin and those its fields hold, depth first."""
        inner = [getattr(self, field.name) for field in dataclasses.fields(self)]
        return (self, *(deeper for value in inner if isinstance(value, Plugin) for deeper in value.nested()))


def check_finite(plugin: Plugin, *names: str) -> None:
    """Raise SpecError for a parameter of a plugin that is infinite or not a number."""
    for name in names:
        if not math.isfinite(getattr(plugin, name)):
            raise SpecError(f"{plugin.name}: {name} must be finite, and here it is {getattr(plugin, name)}")


def _format_tail(text: str) -> str:
    """Text behind the colon that parses back to the same: as it is, in quotes only if it could be taken otherwise."""
    plain = text and text == text.strip() and not text.startswith('"') and text.isprintable()
    return text if plain else json.dumps(text)


def format_value(value: Any) -> str:
    """Text of a parameter value that parses back to the same value, to the last bit for floats."""
    if isinstance(value, tuple):
        return f"({' '.join(format_value(item) for item in value)})"
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, str):
        return value if _BARE.fullmatch(value) and value not in ("true", "false", "none") else json.dumps(value)
    return str(value) if isinstance(value, Plugin) else repr(value)
