"""Text of others on its way to paper: what no font has is spelled out, and what is too long may break."""

import re
import unicodedata
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final

#: Where a line may break without a mark.
BREAK: Final = "\N{ZERO WIDTH SPACE}"
#: A run of characters without a place to break gets one after so many.
LONGEST: Final = 24
#: Characters of names after which a line may break.
_AFTER: Final = re.compile(r"([\[(,=;:/\\|&_])(?=[^\s])")
_NUMBER: Final = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")
#: Words of ASCII and numbers with their signs, which are nearly all that is printed.
_USUAL: Final = re.compile(r" ?[!-~−–]*(?: [!-~−–]+)* ?")
_WHITE: Final = re.compile(r"\s+")
#: A run without spaces, hyphens and breaks.
_RUN: Final = re.compile(rf"[^\s{BREAK}\N{{SOFT HYPHEN}}-]{{{LONGEST + 1},}}")


def fonts() -> Path:
    """Return the folder of the fonts that matplotlib brings; DejaVu Sans has the signs that typst's own lack."""
    import matplotlib as mpl

    return Path(mpl.get_data_path()) / "fonts" / "ttf"


@cache
def _known() -> frozenset[int]:
    """Characters that DejaVu Sans has."""
    from matplotlib.ft2font import FT2Font

    return frozenset(FT2Font(str(fonts() / "DejaVuSans.ttf")).get_charmap())


def printable(text: str) -> str:
    r"""Return a text with white space as single spaces, and as escapes what has no glyph or moves its neighbours.

    Those are control characters, marks that turn the direction of writing, combining marks that stack, halves of
    surrogate pairs, and characters that the fonts of the document lack.

    >>> printable("a\n b\u202e c\x00 \N{BELL}")
    'a b\\u202e c\\x00 \\U0001f514'
    """
    if _USUAL.fullmatch(text):
        return text
    return "".join(_shown(_WHITE.sub(" ", unicodedata.normalize("NFC", text))))


def _shown(text: str) -> Iterator[str]:
    known = _known()
    for letter in text:
        kept = letter in " \N{SOFT HYPHEN}" or (
            ord(letter) in known and unicodedata.category(letter)[0] not in "CM" and letter.isprintable()
        )
        yield letter if kept else _spelled(ord(letter))


def _spelled(code: int) -> str:
    """Return the escape of a character as Python writes it."""
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def prose(text: str) -> str:
    """Return a text that fits into any column: printable, with places to break in runs that are too long."""
    return _RUN.sub(_broken, printable(text))


def name(text: str) -> str:
    """Return the text of a plugin, a file or a command that may break after its brackets, commas and signs."""
    return _RUN.sub(_broken, _AFTER.sub(rf"\1{BREAK}", printable(text)))


def _broken(run: re.Match[str]) -> str:
    text = run[0]
    return BREAK.join(text[start : start + LONGEST // 2] for start in range(0, len(text), LONGEST // 2))


def number(text: str) -> str:
    """Return a number with true minus signs, which no line breaks after."""
    return text.replace("-", "\N{MINUS SIGN}")


def numberless(text: str) -> str:
    """Return what texts have in common that differ in their numbers only."""
    return _NUMBER.sub("0", text)


def shortened(text: str, length: int) -> str:
    """Return a text of at most a number of characters, its middle left out if it is longer."""
    if len(text) <= length:
        return text
    end = length // 3
    return f"{text[: length - end - 1].rstrip()}…{text[-end:].lstrip()}"
