"""What every plugin kind shares: a frozen dataclass whose fields are its parameters and whose text is its identity."""

import dataclasses
from typing import Any, ClassVar


@dataclasses.dataclass(frozen=True)
class Plugin:
    """Base of the plugin kinds. Subclasses are frozen dataclasses; every field has a default.

    Attributes
    ----------
    name
        What the command line calls it, lower case with hyphens.
    title
        What tables and captions call it.
    reference
        Where it is published.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    reference: ClassVar[str]
    #: class attributes that every registered plugin of the kind has to declare
    required: ClassVar[tuple[str, ...]] = ("name", "title", "reference")

    def __str__(self) -> str:
        """``name[field=value,...]`` with the fields that differ from their defaults, in the order of declaration."""
        changed = [
            f"{field.name}={format_value(getattr(self, field.name))}"
            for field in dataclasses.fields(self)
            if getattr(self, field.name) != field.default
        ]
        return f"{self.name}[{','.join(changed)}]" if changed else self.name

    def nested(self) -> tuple["Plugin", ...]:
        """Plugins held by the fields, this one first, depth first."""
        inner = [getattr(self, field.name) for field in dataclasses.fields(self)]
        return (self, *(deeper for value in inner if isinstance(value, Plugin) for deeper in value.nested()))


def format_value(value: Any) -> str:
    """Text of a parameter value that parses back to the same value, to the last bit for floats."""
    if isinstance(value, tuple):
        return f"({' '.join(format_value(item) for item in value)})"
    if isinstance(value, bool):
        return str(value).lower()
    return str(value) if isinstance(value, Plugin | str) else repr(value)
