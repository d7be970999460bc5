"""Polynomials from text: Python's parser and a whitelist. Nothing is executed, and limits come before the work."""

import ast
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Final, NoReturn

from testbed.errors import SpecError
from testbed_datasets.polynomial import Polynomial

VARIABLES: Final = ("x", "y", "z")
#: Longest text, deepest nesting, highest degree.
LONGEST, DEEPEST, HIGHEST = 2000, 50, 20
#: Largest number of bits in a numerator or denominator.
MOST_BITS: Final = 2048
#: Largest number of products of two terms while a polynomial is expanded: about a second.
MOST_PRODUCTS: Final = 300_000

_TOKEN: Final = re.compile(
    r"(?P<number>(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?)|(?P<name>\w+)|(?P<operator>\*\*|[-+*/^()])|(?P<space>\s+)"
    r"|(?P<other>.)",
    re.ASCII,
)
_WRITE: Final = "write a polynomial such as 4*x**2+2*y**2+z**2-4"


def parse_polynomial(text: str, what: str = "the polynomial") -> Polynomial:
    """Return the polynomial in x, y, z that a text stands for.

    Parameters
    ----------
    text
        Numbers, ``x``, ``y``, ``z``, ``+``, ``-``, ``*``, ``/`` by numbers, ``**`` or ``^`` with whole numbers, and
        parentheses. Decimal fractions are taken as written: ``0.1`` is a tenth.
    what
        What messages call it.

    Raises
    ------
    SpecError
        One sentence with the column: the text cannot be read, is too large, or is constant.
    """
    if not text.strip():
        raise SpecError(f"{what} is empty: {_WRITE}")
    if len(text) > LONGEST:
        raise SpecError(f"{what} has {len(text)} characters: write it with {LONGEST} at most")
    reader = _Reader(what, text)
    polynomial = reader.polynomial()
    if polynomial.degree == 0:
        value = dict(polynomial.terms).get((0, 0, 0), Fraction(0))
        raise SpecError(f"{what} is constant, {_short(value)} everywhere, and has no surface: use x, y or z")
    return polynomial


@dataclass(frozen=True)
class _Reader:
    """Reads one text; columns in its messages count from 1.

    Parameters
    ----------
    what
        What messages call the text.
    text
        The text.
    """

    what: str
    text: str

    def fail(self, at: int, why: str) -> NoReturn:
        """Raise SpecError about the character at a position."""
        raise SpecError(f"{self.what} cannot be read at column {at + 1}: {why}")

    def polynomial(self) -> Polynomial:
        """Return the polynomial."""
        # Python's ^ binds less than its +: powers are ** for its parser; positions are those of the text
        source, places = "", {}
        for token, at in self._tokens():
            places[len(source)] = at
            source += token
        try:
            tree = ast.parse(source, mode="eval").body
        except (SyntaxError, ValueError, MemoryError, RecursionError):
            # with every value and parenthesis in its place only the parser's own limits are left
            self.fail(0, "too much is nested: write it with fewer signs, powers and parentheses")
        return self._built(tree, source, places)

    def _tokens(self) -> Iterator[tuple[str, int]]:
        """Tokens of the text and their positions; SpecError where an operator, a value or a parenthesis is missing."""
        after_value, signs, last = False, 0, 0
        opened: list[int] = []
        for match in _TOKEN.finditer(self.text.replace("\n", " ")):
            kind, word = match.lastgroup or "", match.group()
            if kind == "space":
                continue
            last = match.start()
            self._check_place(kind, word, last, after_value=after_value)
            opened += [last] if word == "(" else []
            if word == ")":
                if not opened:
                    self.fail(last, "this parenthesis was not opened: leave it out")
                opened.pop()
            signs = 0 if after_value or word not in ("+", "-") else signs + 1
            if len(opened) > DEEPEST or signs > DEEPEST:
                self.fail(last, f"it is nested more than {DEEPEST} deep: multiply some parentheses out")
            after_value = kind != "operator" or word == ")"
            yield "**" if word == "^" else re.sub(r"^0+(?=\d)", "", word), last
        if opened:
            self.fail(opened[-1], "this parenthesis is not closed: close it")
        if not after_value:
            self.fail(last, f"a value is missing at the end: {_WRITE}")

    def _check_place(self, kind: str, word: str, at: int, *, after_value: bool) -> None:
        """Check that a token is known and may stand where it does, after a value or not."""
        if kind == "other":
            self.fail(at, f"{word!r} has no meaning here: use numbers, x, y, z, + - * / ** and parentheses")
        if after_value and (kind != "operator" or word == "("):
            self.fail(at, f"{_cut(word)!r} follows a value: put an operator between, as in 2*x")
        if kind == "name" and word not in VARIABLES:
            self.fail(at, f"{_cut(word)!r} is not known: use x, y and z")
        if not after_value and kind == "operator" and word not in ("(", "+", "-"):
            self.fail(at, f"{word!r} has no value before it: {_WRITE}")
        if kind == "number":
            self._check_number(word, at)

    def _check_number(self, word: str, at: int) -> None:
        """Check that a number is finite, and not one whose exact value would fill the memory."""
        value = float(word)
        if not math.isfinite(value):
            self.fail(at, f"the number {_cut(word)} is beyond all floating point numbers: scale the polynomial")
        if value == 0.0 and re.search("[1-9]", re.split("[eE]", word)[0]):
            self.fail(at, f"the number {_cut(word)} is too small to be told from zero: scale the polynomial")

    def _built(self, tree: ast.expr, source: str, places: dict[int, int]) -> Polynomial:
        """Return the polynomial of a syntax tree; depth first without recursion, for sums nest to the left."""
        todo: list[tuple[ast.expr, bool]] = [(tree, False)]
        done: list[Polynomial] = []
        products = 0
        while todo:
            node, ready = todo.pop()
            at = places.get(node.col_offset, 0)
            match node:
                case ast.BinOp(left=left, right=right) if not ready:
                    todo += [(node, True), (right, False), (left, False)]
                case ast.UnaryOp(operand=operand) if not ready:
                    todo += [(node, True), (operand, False)]
                case ast.UnaryOp(op=ast.USub()):
                    done.append(-done.pop())
                case ast.UnaryOp(op=ast.UAdd()):
                    pass
                case ast.BinOp(op=operation, right=right):
                    by, value = done.pop(), done.pop()
                    at = places.get(right.col_offset, at)
                    products += self._work(operation, value, by, at)
                    if products > MOST_PRODUCTS:
                        self.fail(at, "it has too many terms when multiplied out: simplify it")
                    done.append(self._checked(self._operated(operation, value, by, at), at))
                case ast.Constant():
                    done.append(Polynomial.constant(Fraction(source[node.col_offset : node.end_col_offset])))
                case ast.Name(id=name):
                    done.append(Polynomial.variable(VARIABLES.index(name)))
                case _:
                    self.fail(at, f"this is no sum, product or power: {_WRITE}")
        return done.pop()

    def _work(self, operation: ast.operator, value: Polynomial, by: Polynomial, at: int) -> int:
        """Return an upper bound of the products of terms in an operation; SpecError if its degree is too high."""
        if isinstance(operation, ast.Mult):
            if value.degree + by.degree > HIGHEST:
                self.fail(at, f"the degree reaches {value.degree + by.degree}: {HIGHEST} is the highest")
            return len(value.terms) * len(by.terms)
        if isinstance(operation, ast.Pow):
            exponent = self._exponent(by, at)
            if value.degree * exponent > HIGHEST:
                self.fail(at, f"the degree reaches {value.degree * exponent}: {HIGHEST} is the highest")
            # the power before last has at most as many terms as there are products of that many terms
            terms = len(value.terms)
            return exponent * terms * math.comb(terms + max(exponent - 2, 0), max(exponent - 1, 0)) if terms else 0
        return len(value.terms) + len(by.terms)

    def _exponent(self, by: Polynomial, at: int) -> int:
        """Return a small whole number, given as a polynomial."""
        power = dict(by.terms).get((0, 0, 0), Fraction(0))
        if by.degree > 0 or power.denominator != 1 or not 0 <= power <= HIGHEST:
            shown = "a polynomial" if by.degree > 0 else _short(power)
            self.fail(at, f"the exponent is {shown}: give a whole number from 0 to {HIGHEST}")
        return int(power)

    def _operated(self, operation: ast.operator, value: Polynomial, by: Polynomial, at: int) -> Polynomial:
        """Return the result of an operation on two polynomials."""
        match operation:
            case ast.Add():
                return value + by
            case ast.Sub():
                return value + -by
            case ast.Mult():
                return value * by
            case ast.Div():
                if by.degree > 0:
                    self.fail(at, "it is divided by a polynomial: multiply by the denominator, only numbers divide")
                if not by.terms:
                    self.fail(at, "it is divided by zero: divide by another number")
                return value * Polynomial.constant(1 / by.terms[0][1])
        if not isinstance(operation, ast.Pow):
            self.fail(at, "this operation has no meaning here: use + - * / and **")
        result = Polynomial.constant(1)
        for _ in range(self._exponent(by, at)):
            result = self._checked(result * value, at)
        return result

    def _checked(self, polynomial: Polynomial, at: int) -> Polynomial:
        """Return the polynomial unless a coefficient has become too long."""
        if any(max(abs(value.numerator), value.denominator).bit_length() > MOST_BITS for _, value in polynomial.terms):
            self.fail(at, f"a coefficient has more than {MOST_BITS} binary digits here: use smaller numbers")
        return polynomial


def _cut(word: str) -> str:
    return word if len(word) <= 20 else f"{word[:17]}..."


def _short(value: Fraction) -> str:
    try:
        return f"{float(value):g}"
    except OverflowError:
        return "a number beyond all floating point numbers"
