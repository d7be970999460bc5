"""Published schemes that are known and not built: a catalogue says why, and what comes nearest."""

import tomllib
from dataclasses import dataclass, fields

from testbed.errors import PluginError


@dataclass(frozen=True)
class NotBuilt:
    """A published scheme without a plugin.

    Parameters
    ----------
    name, title, reference
        As a plugin's.
    why
        Why it is not built: what the public sources lack, or which scheme it coincides with.
    nearest
        Names of the registered schemes that come nearest.
    """

    name: str
    title: str
    reference: str
    why: str
    nearest: tuple[str, ...]


def read_not_built(text: str, source: str) -> tuple[NotBuilt, ...]:
    """Return the entries of a TOML text: an array of tables ``scheme``, each with the fields of :class:`NotBuilt`.

    Raises
    ------
    PluginError
        It is not such a text; the message names the source and the entry.
    """
    names = {field.name for field in fields(NotBuilt)}
    try:
        entries = tomllib.loads(text).get("scheme", [])
    except tomllib.TOMLDecodeError as error:
        raise PluginError(f"{source} is not TOML: {error}") from error
    for number, entry in enumerate(entries):
        if not isinstance(entry, dict) or set(entry) != names:
            raise PluginError(f"{source}, scheme {number}: give {', '.join(sorted(names))} and nothing else")
    return tuple(NotBuilt(**{**entry, "nearest": tuple(entry["nearest"])}) for entry in entries)
