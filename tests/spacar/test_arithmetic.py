"""Arithmetic in braces: Python's values, one error for whatever is none."""

import math
import random
import time

import jax
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb.spacar.arithmetic import arithmetic_result

NUMBERS = {"a": 2.0, "b": -3.5, "Länge": 0.1}


@pytest.mark.parametrize(
    "text",
    [
        "1",
        "  1.5e-3 ",
        ".5+5.",
        "a*b",
        "-a**2",
        "2**-1",
        "2**-a**2",
        "a**2**0.5",
        "-a*b/-3+2",
        "1-2-3",
        "8/4/2",
        "((a+b)*(a-b))",
        "+-+a",
        "Länge*2",
        "pi/2",
        "1E5",
        "-(a+1)**2/4",
    ],
)
def test_values_are_those_of_python(text):
    names = {**NUMBERS, "pi": math.pi}
    assert arithmetic_result(text, NUMBERS) == eval(text.strip(), {"__builtins__": {}}, names)


@pytest.mark.parametrize("seed", range(200))
def test_random_ones_too(seed):
    draw = random.Random(seed)

    def some(depth):
        kind = draw.randrange(6 if depth else 2)
        if kind == 0:
            return repr(round(draw.uniform(0.1, 3), 2))
        if kind == 1:
            return draw.choice(list(NUMBERS))
        if kind == 2:
            return f"({some(depth - 1)})"
        if kind == 3:
            return draw.choice("+-") + some(depth - 1)
        if kind == 4:
            return some(depth - 1) + "**" + draw.choice(["2", "-1", "3"])
        return some(depth - 1) + draw.choice([" + ", "-", "*", "/ "]) + some(depth - 1)

    text = some(6)
    expected: object
    try:
        expected = eval(text, {"__builtins__": {}}, NUMBERS)
        assert isinstance(expected, float)
        assert math.isfinite(expected)
    except (ZeroDivisionError, OverflowError, AssertionError):
        with pytest.raises(ValueError, match="has no value"):
            arithmetic_result(text, NUMBERS)
    else:
        assert arithmetic_result(text, NUMBERS) == expected


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "missing at its end"),
        ("1+", "missing at its end"),
        ("(1", "not closed"),
        ("1)", "no opening"),
        ("()", "no arithmetic"),
        ("1 2", "see '2'"),
        ("2a", "may have numbers"),
        ("0x10", "may have numbers"),
        ("1_0", "may have numbers"),
        ("1e", "may have numbers"),
        ("1.2.3", "may have numbers"),
        ("٣", "may have numbers"),
        ("1j", "may have numbers"),
        ("True", "no parameter 'True'"),
        ("nan", "no parameter 'nan'"),
        ("a.real", "may have numbers"),
        ("a, b", "may have numbers"),
        ("a if b else 1", "no arithmetic"),
        ("a//b", "no arithmetic"),
        ("a%b", "may have numbers"),
        ("f(1)", "no parameter 'f'"),
        ("a(1)", "no arithmetic"),
        ("lambda: 1", "no parameter 'lambda'"),
        ("__import__('os')", "no parameter '__import__'"),
        ("a('os')", "no arithmetic"),
        ("9**9**9", "too large"),
        ("1e999", "too large"),
        ("1/1e999", "too large"),
        ("1e308*10", "too large"),
        ("1/(1e308*10)", "too large"),
        ("1/0", "division by zero"),
        ("0**-1", "division by zero"),
        ("(-1)**0.5", "must be a real number"),
        ("((-1)**0.5)**2", "must be a real number"),
        ("flag", "must be one number"),
        ("list", "must be one number"),
        ("word", "must be one number"),
        ("far", "not a number"),
        ("\x1b[31m", r"\\x1b"),
    ],
)
def test_what_has_no_value_says_why(text, words):
    others = {"flag": True, "list": np.ones(3), "word": "1", "far": np.nan}
    with pytest.raises(ValueError, match=words) as raised:
        arithmetic_result(text, {**NUMBERS, **others})
    assert str(raised.value).isprintable()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1" + "+1" * 2999, 3000),
        ("(" * 20_000 + "7" + ")" * 20_000, 7),
        ("-" * 20_000 + "7", 7),
        ("1**" * 9999 + "2", 1),
    ],
    ids=["sum", "parentheses", "signs", "powers"],
)
def test_length_and_depth_have_no_limit(text, value):
    assert arithmetic_result(text, {}) == value


@pytest.mark.slow
def test_what_is_huge_is_refused_at_once():
    for text in ("9**9**9**9", "(" * 10**6, "1" * 10**6, "x" * 10**6, "1 " * 10**6):
        begin = time.perf_counter()
        with pytest.raises(ValueError, match=r"no|too|may") as raised:
            arithmetic_result(text, {})
        assert time.perf_counter() - begin < 10  # seconds on any machine; some milliseconds on one that is free
        assert len(str(raised.value)) < 500


def test_numbers_may_be_traced():
    assert jax.grad(lambda a: arithmetic_result("a**3/2 + b", {"a": a, "b": 1.0}))(2.0) == approx(6.0)


@pytest.mark.slow
def test_a_file_names_the_line_and_says_no_more_than_a_line():
    text = "PLBEAM 1 1 2 3 4\nX 1 {" + "1+" * 10**5 + "} 0\nX 3 {t\x07} 0\nEND\nEND\n"
    with pytest.raises(fm.SpacarError) as raised:
        fm.read_spacar(text, numbers={"t": 1.0})
    lines = str(raised.value).splitlines()
    assert lines[0].startswith("text:2: X: node 1: '{1+1+")
    assert lines[1].startswith(r"text:3: X: node 3: '{t\x07}' may have")
    assert all(line.isprintable() and len(line) < 500 for line in lines)


def test_a_file_without_names_needs_no_numbers():
    text = "PLTRUSS 1 1 2\nX 2 1 0\nFIX 1\nFIX 2 2\nRLSE 1 1\nDYNX 2 1\nEND\nHALT\nESTIFF 1 {100 * pi}\nEND\nEND\n"
    found = fm.read_spacar(text)
    assert float(found.builder.members["1"].properties["section"].EA) == approx(100 * math.pi, rel=1e-15)
    assert found.parameters == ()
    with pytest.raises(fm.SpacarError, match=r"text:9: ESTIFF: .* there is no parameter 'k' .* by numbers=\{\.\.\} in"):
        fm.read_spacar(text.replace("pi", "k"))
    with pytest.raises(ValueError, match=r"'pi' is 3\.14159"):
        fm.read_spacar(text, numbers={"pi": 3.0})
