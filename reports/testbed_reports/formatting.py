"""Numbers as a reader wants them: three significant digits to look at, every digit to point at."""

import math
from dataclasses import dataclass
from numbers import Integral
from typing import Any, Final

#: What stands where there is no number.
NOTHING: Final = "–"


@dataclass(frozen=True)
class Entry:
    """What a place in a table shows.

    Parameters
    ----------
    text
        What is read.
    exact
        The number to the last bit, or another remark to point at; empty for none.
    best
        Whether it is the best of its column.
    place
        Where the number was found, or of what it is made; empty if that is not known.
    """

    text: str
    exact: str = ""
    best: bool = False
    place: str = ""


def shorten(value: float) -> str:
    """Return a number to three significant digits, as a decimal where that stays short.

    >>> [shorten(value) for value in (0.0, 0.5, 999.9, 123.0, -0.00123456, 1e-9)]
    ['0', '0.500', '1.00e3', '123', '-0.00123', '1.00e-9']
    """
    if not math.isfinite(value):
        return {"inf": "∞", "-inf": "-∞"}.get(str(value), "NaN")
    if value == 0.0:
        return "0"
    mantissa, _, power = f"{value:.2e}".partition("e")
    exponent = int(power)
    return f"{value:.{2 - exponent}f}" if -3 <= exponent <= 2 else f"{mantissa}e{exponent}"


def entry(value: Any, place: str = "", *, percent: bool = False) -> Entry:
    """Return the entry of a value: integers and texts as they are, other numbers shortened, None as a dash.

    Parameters
    ----------
    value
        A number, a text or None.
    place
        See :class:`Entry`.
    percent
        The number is a share, shown in percent; ``exact`` keeps the share.
    """
    if value is None or value == "":
        return Entry(NOTHING, place=place)
    if isinstance(value, str | Integral):
        return Entry(str(value), place=place)
    number = float(value)
    return Entry(shorten(100.0 * number if percent else number), repr(number), place=place)


def seconds(value: float) -> str:
    """Return a duration in words."""
    minutes, rest = divmod(round(value), 60)
    return f"{minutes} min {rest} s" if minutes else f"{shorten(value)} s"


def listed(words: "list[str] | tuple[str, ...]") -> str:
    """Return words joined as in a sentence: ``a, b and c``."""
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def counted(count: int, noun: str) -> str:
    """Return a count with its noun: ``1 cell``, ``3 cells``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
