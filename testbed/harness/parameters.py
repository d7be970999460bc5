"""Parameters of a scheme that a study varies: their values as texts, and the scheme's text with them set."""

import dataclasses
import math
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Union

from testbed import registry
from testbed.errors import SpecError
from testbed.plugins.base import Plugin, format_value
from testbed.plugins.scheme import Scheme
from testbed.plugins.spec import choices, split

#: Digits to which values between two bounds are rounded, so that 0.9 + 9 x 0.02 is 1.08 and not its neighbour.
DIGITS: Final = 10
#: Values of one parameter at most.
MOST: Final = 1000


@dataclass(frozen=True)
class Axis:
    """A parameter and the values it takes in a sweep.

    Parameters
    ----------
    name
        The parameter; ``boundary.guard`` is ``guard`` of the plugin that the parameter ``boundary`` holds.
    texts
        Its values, as a spec has them; numbers ascend.
    numbers
        The same as numbers; None if one of them is none.
    """

    name: str
    texts: tuple[str, ...]
    numbers: tuple[float, ...] | None


@dataclass(frozen=True)
class Interval:
    """A real parameter and the bounds within which its best value is searched for."""

    name: str
    low: float
    high: float


def parse_axis(text: str, scheme: Scheme) -> Axis:
    """Return the values of ``name=low:high:count``, evenly spaced with both ends, or of ``name=a,b,c``.

    Raises
    ------
    SpecError
        The scheme has no such parameter, or the values cannot be read, or are none of its values.
    """
    name, values = _divide(text, "name=low:high:count or name=a,b,c")
    expected = parameter_type(scheme, name)
    whole, numeric = _takes(expected, int) and not _takes(expected, float), _takes(expected, int, float)
    ends = re.fullmatch(r"([^:\[\](),]*):([^:\[\](),]*):([^:\[\](),]*)", values)
    if ends is None:
        texts = tuple(split(values, ","))
    elif not numeric:
        raise SpecError(f"parameter {name} of {scheme.name} is no number: list its values, as in {name}=a,b")
    else:
        texts = _spaced(text, ends[1], ends[2], ends[3], whole=whole)
    if not texts:
        raise SpecError(f"--over {text!r} has no values: write {name}=low:high:count or {name}=a,b,c")
    # as the plugins read them: equal values become equal texts, and a wrong one is answered with what is valid
    plugins = [registry.scheme(with_values(scheme, {name: value})) for value in texts]
    found = [value_of(plugin, name) for plugin in plugins]
    repeated = [value for position, value in enumerate(found) if value in found[:position]]
    if repeated:
        raise SpecError(f"--over {text!r} has the value {format_value(repeated[0])} twice: give each value once")
    if len(found) > MOST:
        raise SpecError(f"--over {text!r} has {len(found)} values: {MOST} are the most")
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in found):
        found.sort()
        return Axis(name, tuple(map(format_value, found)), tuple(map(float, found)))
    return Axis(name, tuple(map(format_value, found)), None)


def parse_interval(text: str, scheme: Scheme) -> Interval:
    """Return the bounds of ``name=low:high``, or of ``name`` those that the scheme declares.

    Raises
    ------
    SpecError
        The scheme has no such parameter, it is not real, or the bounds are missing, no bounds, or no values of it.
    """
    name = text.partition("=")[0].strip()
    if not _takes(parameter_type(scheme, name), float):
        raise SpecError(f"parameter {name} of {scheme.name} is no real number: only real parameters are tuned")
    if "=" not in text:
        if name not in scheme.bounds:
            raise SpecError(f"{scheme.name} declares no bounds for {name}: write {name}=low:high")
        return Interval(name, *scheme.bounds[name])
    _, values = _divide(text, "name=low:high")
    low, colon, high = values.partition(":")
    bounds = tuple(_number(end) for end in (low, high)) if colon else ()
    if len(bounds) != 2 or not (math.isfinite(bounds[0]) and math.isfinite(bounds[1]) and bounds[0] < bounds[1]):
        raise SpecError(f"--over {text!r} has no bounds: write {name}=low:high with low below high")
    for end in bounds:
        registry.scheme(with_values(scheme, {name: repr(end)}))
    return Interval(name, *bounds)


def free_parameters(scheme: Scheme) -> tuple[Interval, ...]:
    """Return the real parameters that the scheme declares bounds for, in the order of its fields; SpecError if none."""
    fields = [field.name for field in dataclasses.fields(scheme)]
    found = tuple(Interval(name, *scheme.bounds[name]) for name in fields if name in scheme.bounds)
    if not found:
        raise SpecError(f"{scheme.name} declares no bounds for its parameters: name one with --over name=low:high")
    return found


def with_values(plugin: Plugin, values: Mapping[str, str]) -> str:
    """Return the text of a plugin with parameters set to values that are given as texts.

    Parameters
    ----------
    plugin
        The plugin; its other parameters stay.
    values
        Texts by parameter; with a dot for a parameter of the plugin that a parameter holds.
    """
    fields = {
        field.name: format_value(getattr(plugin, field.name))
        for field in dataclasses.fields(plugin)
        if getattr(plugin, field.name) != field.default
    }
    inner: dict[str, dict[str, str]] = {}
    for name, text in values.items():
        head, dot, rest = name.partition(".")
        if dot:
            inner.setdefault(head, {})[rest] = text
        else:
            fields[head] = text
    for head, nested in inner.items():
        if head in values:
            raise SpecError(f"{head} and {head}.{next(iter(nested))} cannot be varied at once: choose one of them")
        fields[head] = with_values(getattr(plugin, head), nested)
    return f"{plugin.name}[{','.join(f'{name}={text}' for name, text in fields.items())}]"


def parameter_type(plugin: Plugin, name: str) -> Any:
    """Return the type of a parameter, one of a nested plugin with a dot; SpecError if there is none of that name."""
    head, dot, rest = name.partition(".")
    known = typing.get_type_hints(type(plugin))
    fields = {field.name: known[field.name] for field in dataclasses.fields(plugin)}
    if head not in fields:
        raise SpecError(f"{plugin.name} has no parameter {head!r}: {choices(head, fields)}")
    if not dot:
        return fields[head]
    inner = getattr(plugin, head)
    if not isinstance(inner, Plugin):
        raise SpecError(f"parameter {head} of {plugin.name} has no parameters of its own, and {name} asks for one")
    return parameter_type(inner, rest)


def value_of(plugin: Plugin, name: str) -> Any:
    """Return the value of a parameter, one of a nested plugin with a dot."""
    value: Any = plugin
    for part in name.split("."):
        value = getattr(value, part)
    return value


def _divide(text: str, form: str) -> tuple[str, str]:
    name, equals, values = (part.strip() for part in text.partition("="))
    if not (name and equals and values):
        raise SpecError(f"--over {text!r} cannot be read: write {form}")
    return name, values


def _takes(expected: Any, *kinds: type) -> bool:
    """Whether a parameter of a type can be of one of some kinds."""
    if typing.get_origin(expected) in (Union, types.UnionType):
        return any(_takes(one, *kinds) for one in typing.get_args(expected))
    return expected in kinds


def _spaced(text: str, low: str, high: str, count: str, *, whole: bool) -> tuple[str, ...]:
    first, last, steps = _number(low), _number(high), _number(count)
    if not (math.isfinite(first) and math.isfinite(last) and steps.is_integer()):
        raise SpecError(f"--over {text!r} cannot be read: low and high are numbers and count is a whole one")
    if not (2 <= steps <= MOST and first < last):
        raise SpecError(f"--over {text!r} is no range: low is below high, and count from 2 to {MOST}")
    values = [first + (last - first) * step / (steps - 1.0) for step in range(int(steps))]
    values = [first, *(float(f"{value:.{DIGITS}g}") for value in values[1:-1]), last]
    if whole and all(value.is_integer() for value in values):
        return tuple(str(int(value)) for value in values)
    return tuple(map(repr, values))


def _number(text: str) -> float:
    """Return the number that a text stands for; NaN if none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
