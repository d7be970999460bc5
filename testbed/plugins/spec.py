"""The text form of plugins: ``name[field=value,...]``, nested where a field is itself a plugin, or ``name:TEXT``."""

import dataclasses
import difflib
import json
import math
import types
import typing
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal, Protocol, TypeVar, Union

from testbed.errors import SpecError
from testbed.plugins.base import Plugin

P = TypeVar("P", bound=Plugin)

_OPEN, _CLOSE = "[(", "])"


class Lookup(Protocol):
    """Where names are found: the plugins of a kind by name, and what the kind is called."""

    def catalogue(self, kind: type[P]) -> Mapping[str, type[P]]:
        """Return the registered plugins of a kind, by name."""
        ...

    def kind_name(self, kind: type[Plugin]) -> str:
        """Return what a user calls the kind, for instance ``scheme``."""
        ...


def parse(text: str, kind: type[P], lookup: Lookup) -> P:
    """Return the plugin that ``text`` names.

    Parameters
    ----------
    text
        ``name``, ``name[field=value,...]`` or, for a plugin with a positional field, ``name[...]:TEXT``. Values are
        numbers, ``true`` and ``false``, words, ``"quoted text"``, ``(1 2 3)`` for tuples, or plugins in the same form.
        TEXT is all that follows the colon, with any brackets and commas; quotes about all of it are taken away.
    kind
        The plugin kind expected.

    Raises
    ------
    SpecError
        One sentence that lists the valid names, fields or values, the nearest first.
    """
    name, fields, tail = _divide(text.strip())
    known = lookup.catalogue(kind)
    if name not in known:
        raise SpecError(f"no {lookup.kind_name(kind)} is called {name!r}: {choices(name, known)}")
    plugin = known[name]
    types_of = {field.name: typing.get_type_hints(plugin)[field.name] for field in dataclasses.fields(plugin)}
    values: dict[str, Any] = {}
    for item in fields:
        field, equals, value = (part.strip() for part in item.partition("="))
        if field not in types_of:
            if field == "boundary" and lookup.kind_name(kind) == "scheme":
                raise SpecError(f"{name} builds its own boundary curves and takes no others: leave out {field}")
            raise SpecError(f"{name} has no parameter {field!r}: {choices(field, types_of)}")
        if not equals or not value:
            raise SpecError(f"parameter {field} of {name} has no value: write {field}=VALUE")
        if field in values:
            raise SpecError(f"parameter {field} of {name} is given twice: give it once")
        values[field] = _value(value, types_of[field], f"parameter {field} of {name}", lookup)
    if tail is not None:
        if plugin.positional is None:
            raise SpecError(f"{name} takes no ':{tail}': write {name} or {name}[field=value]")
        if plugin.positional in values:
            raise SpecError(f"parameter {plugin.positional} of {name} is given twice: leave it out before the colon")
        values[plugin.positional] = _unquoted(tail, f"{name}:TEXT")
    return plugin(**values)


def _divide(text: str) -> tuple[str, list[str], str | None]:
    """Divide ``name[a=1,b=2]:TEXT`` into its name, its fields and the text behind the colon."""
    bracket, colon = text.find("["), text.find(":")
    if bracket < 0 or 0 <= colon < bracket:
        name, found, tail = text.partition(":")
        return name.strip(), [], tail if found else None
    depth, end = 0, -1
    for position, character, quoted in _characters(text):
        if quoted:
            continue
        depth += (character in _OPEN) - (character in _CLOSE)
        if depth == 0 and character in _CLOSE:
            end = position
            break
    rest = text[end + 1 :] if end >= 0 else ""
    if end < 0 or (rest and not rest.startswith(":")):
        raise SpecError(f"{text!r} cannot be read: write name[field=value,...] with every bracket closed")
    inside = text[bracket + 1 : end]
    return text[:bracket].strip(), list(split(inside, ",")), rest[1:] if rest else None


def _characters(text: str) -> Iterator[tuple[int, str, bool]]:
    """Position, character, and whether it belongs to a quoted text."""
    quoted = escaped = False
    for position, character in enumerate(text):
        if character == '"' and not escaped:
            quoted = not quoted
            yield position, character, True
            continue
        escaped = quoted and character == "\\" and not escaped
        yield position, character, quoted


def split(text: str, separator: str) -> Iterator[str]:
    """Pieces of ``text`` between separators that stand outside brackets and quotes; no empty pieces."""
    depth, start = 0, 0
    for position, character, quoted in _characters(text):
        if quoted:
            continue
        depth += (character in _OPEN) - (character in _CLOSE)
        if character == separator and depth == 0:
            if text[start:position].strip():
                yield text[start:position].strip()
            start = position + 1
    if text[start:].strip():
        yield text[start:].strip()


def _value(text: str, expected: Any, where: str, lookup: Lookup) -> Any:
    """Return the value of type ``expected`` that ``text`` stands for."""
    origin, arguments = typing.get_origin(expected), typing.get_args(expected)
    if origin in (Union, types.UnionType):
        return _first_of(text, arguments, where, lookup)
    if origin is Literal:
        word = _unquoted(text, where)
        chosen = [value for value in arguments if str(value) == word]
        if not chosen:
            raise SpecError(f"{where} cannot be {text!r}: {choices(word, map(str, arguments))}")
        return chosen[0]
    if origin is tuple:
        if not (text.startswith("(") and text.endswith(")")):
            raise SpecError(f"{where} cannot be {text!r}: write values between parentheses, as in (1.5 2)")
        items = [piece for part in split(text[1:-1], ",") for piece in split(part, " ")]
        if arguments[-1] is not Ellipsis and len(items) != len(arguments):
            raise SpecError(f"{where} takes {len(arguments)} values, and {text} has {len(items)}")
        kinds = [arguments[0]] * len(items) if arguments[-1] is Ellipsis else arguments
        return tuple(_value(item, one, where, lookup) for item, one in zip(items, kinds, strict=True))
    if isinstance(expected, type) and issubclass(expected, Plugin):
        return parse(text, expected, lookup)
    return _scalar(text, expected, where)


def _first_of(text: str, alternatives: tuple[Any, ...], where: str, lookup: Lookup) -> Any:
    """Return the value for the first alternative of a union type that the text fits."""
    complaints = []
    for alternative in alternatives:
        try:
            return _value(text, alternative, where, lookup)
        except SpecError as error:
            complaints.append(str(error))
    raise SpecError("; or ".join(complaints))


def _scalar(text: str, expected: Any, where: str) -> Any:
    if expected is type(None) and text == "none":
        return None
    if expected is bool and text in ("true", "false"):
        return text == "true"
    if expected is str:
        return _unquoted(text, where)
    if expected in (int, float):
        try:
            number = expected(text)
        except ValueError:
            number = math.nan
        if math.isfinite(number):
            return number
    names = {bool: "true or false", int: "a whole number", float: "a finite number", type(None): "none"}
    raise SpecError(f"{where} cannot be {text!r}: it takes {names.get(expected, expected)}")


def _unquoted(text: str, where: str) -> str:
    if not text.startswith('"'):
        return text
    try:
        return str(json.loads(text))
    except json.JSONDecodeError:
        raise SpecError(f"{where} has a quoted text that does not end: {text}") from None


def choices(word: str, known: Iterable[str]) -> str:
    """Return ``did you mean x? known are a, b, c``: the nearest first, then all."""
    names = sorted(known)
    near = difflib.get_close_matches(word, names, n=1)
    guess = f"did you mean {near[0]}? " if near else ""
    return f"{guess}known are {', '.join(names)}" if names else f"{guess}there are none"
