"""Polynomials from text: what it means, one sentence with the column for everything else, and nothing is executed."""

import ast
import builtins
import re
import time
from fractions import Fraction

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from testbed.errors import SpecError
from testbed_datasets.polynomial import Polynomial
from testbed_datasets.polynomial_text import HIGHEST, LONGEST, parse_polynomial

AT = (Fraction(3, 7), Fraction(-5, 2), Fraction(11, 3))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("4*x**2+2*y**2+z**2-4", "4*x**2+2*y**2+z**2-4"),
        ("4*x^2 + 2*y^2 + z^2 - 4", "4*x**2+2*y**2+z**2-4"),
        ("-x^2*y^3", "-(x**2)*y**3"),
        ("-(-x)--y", "x+y"),
        ("x/2/3-z/0.25", "x/6-4*z"),
        ("2*(x+y)^3*(z-1)", "2*(x+y)**3*(z-1)"),
        ("x^2^2", "x**4"),
        ("x^(1+1)*2^3", "8*x**2"),
        ("0.1*x+.5*y+2.*z+1e-2", "x/10+y/2+2*z+Fraction(1,100)"),
        ("x**0+y", "1+y"),
        ("007*x", "7*x"),
        ("x\n +\ty", "x+y"),
        ("x**2.0", "x**2"),
    ],
)
def test_text_means_what_it_says(text: str, value: str) -> None:
    x, y, z = AT
    expected = eval(value, {"x": x, "y": y, "z": z, "Fraction": Fraction})  # noqa: S307 - the test's own text
    assert parse_polynomial(text)(*AT) == expected


def test_decimal_fractions_are_taken_as_written() -> None:
    assert dict(parse_polynomial("0.1*x").terms) == {(1, 0, 0): Fraction(1, 10)}
    assert dict(parse_polynomial("1.23456789012345678901*x").terms)[1, 0, 0] == Fraction("1.23456789012345678901")


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("2x", 2, "put an operator between, as in 2*x"),
        ("x y", 3, "put an operator between"),
        ("2(x+1)", 2, "put an operator between"),
        ("x(2)", 2, "put an operator between"),
        ("(x)(y)", 4, "put an operator between"),
        ("x+w*y", 3, "'w' is not known: use x, y and z"),
        ("sin(x)", 1, "'sin' is not known"),
        ("x + ", 3, "a value is missing at the end"),
        ("x+*y", 3, "has no value before it"),
        ("x***2", 4, "has no value before it"),
        ("x//2", 3, "has no value before it"),
        ("(x+(y)", 1, "this parenthesis is not closed"),
        ("x+y)", 4, "this parenthesis was not opened"),
        ("()", 2, "has no value before it"),
        ("x%2", 2, "'%' has no meaning here"),
        ("x[0]", 2, "'[' has no meaning here"),
        ("x=1", 2, "'=' has no meaning here"),
        ("x;y", 2, "';' has no meaning here"),
        ("é+x", 1, "has no meaning here"),
        ("x**y", 4, "the exponent is a polynomial"),
        ("x**-1", 4, "the exponent is -1: give a whole number from 0 to 20"),
        ("x^1.5", 3, "the exponent is 1.5"),
        ("9**9**9*x", 4, "the exponent is 3.8742e+08"),
        ("x^21", 3, "the exponent is 21"),
        ("(x^7)^3", 7, "the degree reaches 21: 20 is the highest"),
        ("x^20*y", 6, "the degree reaches 21"),
        ("1/x", 3, "it is divided by a polynomial"),
        ("x/(y-y)", 4, "it is divided by zero"),
        ("1e400*x", 1, "beyond all floating point numbers"),
        ("1e-400*x", 1, "too small to be told from zero"),
        ("x+1e-999999999", 3, "too small to be told from zero"),
        ("((9^20)^20)^20*x", 13, "more than 2048 binary digits"),
        ("nan*x", 1, "'nan' is not known"),
        ("inf+x", 1, "'inf' is not known"),
        ("(" * 51 + "x" + ")" * 51, 51, "nested more than 50 deep"),
        ("-" * 60 + "x", 51, "nested more than 50 deep"),
        ("x==y", 2, "has no meaning here"),
        ("0x10*x", 2, "'x10' follows a value"),
        ("1j*x", 2, "'j' follows a value"),
        ("1_0*x", 2, "'_0' follows a value"),
    ],
)
def test_a_mistake_is_named_with_its_column(text: str, column: int, words: str) -> None:
    with pytest.raises(SpecError, match=f"^the polynomial cannot be read at column {column}: ") as caught:
        parse_polynomial(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("  \t", "is empty"),
        ("3", "is constant, 3 everywhere"),
        ("x-x", "is constant, 0 everywhere"),
        ("x^0", "is constant, 1 everywhere"),
        ("x+" * LONGEST + "x", f"write it with {LONGEST} at most"),
        ("(x+y+z+1)^10*(x-y+2*z+3)^9*(x+7)", ""),
        ("((x+y+z+1)^9*(x+y-z+2)^9)*(x+1)^2-((x+y+z+1)^9*(x+y-z+2)^9)*(x+2)^2-((x-y+z+1)^9*(2*x+y-z+2)^9)*(x+2)^2", ""),
    ],
)
def test_what_is_no_surface_or_too_large_is_refused(text: str, words: str) -> None:
    begin = time.perf_counter()
    try:
        parse_polynomial(text)
    except SpecError as error:
        assert words in str(error)  # noqa: PT017 - some of them are read, in bounded time
    else:
        assert not words
    assert time.perf_counter() - begin < 20.0


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "lambda: x",
        "(lambda x: x)(x)",
        "x.__class__",
        "x.__class__.__mro__",
        "().__class__",
        "[x for x in y]",
        "eval('x')",
        "exec('x')",
        "open('x')",
        "f'{x}'",
        "'x'",
        '"x"',
        "b'x'",
        "x if y else z",
        "x or y",
        "not x",
        "x := 1",
        "(x := 1)",
        "x < y",
        "x@y",
        "x and y",
        "*x",
        "**x",
        "...",
        "x,y",
        "{x}",
        "{**x}",
        "print(x)",
        "x\\\n+y",
        "x#y",
        "~x",
        "x<<2",
        "x|y",
        "x&y",
        "yield x",
        "await x",
        "True*x",
        "None",
        "x\x00",
    ],
)
def test_code_is_not_a_polynomial(text: str) -> None:
    with pytest.raises(SpecError):
        parse_polynomial(text)


def test_nothing_is_executed(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*arguments: object) -> None:
        raise AssertionError(arguments)

    parsed: list[str] = []
    parse = ast.parse

    def noted(source: str, *, mode: str) -> ast.AST:
        parsed.append(source)
        return parse(source, mode=mode)

    with monkeypatch.context() as patched:
        for name in ("eval", "exec"):
            patched.setattr(builtins, name, forbidden)
        patched.setattr(ast, "parse", noted)
        degree = parse_polynomial("4*x^2-1").degree
        with pytest.raises(SpecError):
            parse_polynomial("__import__('os')")
    assert degree == 2
    assert parsed == ["4*x**2-1"]  # what is not of the whitelist does not even reach Python's parser


readable = st.recursive(
    st.sampled_from(["x", "y", "z"]) | st.integers(0, 9).map(str) | st.sampled_from(["0.5", ".25", "1e-2"]),
    lambda inner: (
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda parts: f"({parts[0]}{parts[1]}{parts[2]})")
        | st.tuples(inner, st.integers(0, 3)).map(lambda parts: f"({parts[0]})**{parts[1]}")
        | st.tuples(inner, st.integers(1, 9)).map(lambda parts: f"({parts[0]})/{parts[1]}")
        | inner.map(lambda one: f"(-{one})")
    ),
    max_leaves=8,
)


@settings(max_examples=100, deadline=None)
@given(readable)
def test_readable_text_has_the_value_that_python_gives_it(text: str) -> None:
    numbers = re.sub(
        r"(?<![\w.])(\d*\.?\d+(?:e-?\d+)?)(?![\w.])", r"Fraction('\1')", re.sub(r"\*\*(\d)", r"**int(\1)", text)
    )
    numbers = re.sub(r"int\(Fraction\('(\d)'\)\)", r"\1", numbers)
    x, y, z = AT
    expected = eval(numbers, {"x": x, "y": y, "z": z, "Fraction": Fraction})  # noqa: S307 - generated above
    try:
        polynomial = parse_polynomial(text)
    except SpecError as error:
        assert re.search("constant|degree|exponent", str(error))  # noqa: PT017 - the only mistakes left
    else:
        assert isinstance(polynomial, Polynomial)
        assert polynomial(*AT) == expected


@settings(max_examples=300, deadline=None)
@given(st.text(st.sampled_from("xyz0123456789.+-*/^()eE _,[]'\"\\\n:=lambda"), max_size=40) | st.text(max_size=30))
@example("x" + "**1" * 600)
@example("1**" * 600 + "x")
@example("+".join("x" * 900))
@example("((((x+1)^2+y)^2+z)^2+x)^2")
@example("(" * 2000)
def test_any_text_is_a_polynomial_or_a_spec_error(text: str) -> None:
    try:
        polynomial = parse_polynomial(text)
    except SpecError as error:
        assert re.fullmatch("the polynomial .*", str(error))  # noqa: PT017 - in one line; either is right
    else:
        assert 1 <= polynomial.degree <= HIGHEST
