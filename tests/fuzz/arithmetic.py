"""Random arithmetic as it stands in braces: Python's value of it, or a refusal by name.

``cases(seed)`` yields texts without end, the same for the same seed; ``run(case)`` evaluates one and compares.
"""

import math
import random
import re
import warnings
from collections.abc import Iterator

from flexmb.spacar.arithmetic import arithmetic_result

NUMBERS = {"t": 0.5e-3, "w": 0.018, "E": 210e9, "minus": -2.0, "zero": 0.0, "Länge": 0.1, "far": 1e200}
WORDS = ("0", "1", "2", "3.5", ".5", "5.", "1e-3", "2E5", "1e308", "1e999", "1e-400", "007", "1" * 400, *NUMBERS, "pi")
ODD = (
    "0x10",
    "1_0",
    "True",
    "1j",
    "1e",
    "2t",
    "nan",
    "inf",
    "None",
    "x",
    "e",
    "t.real",
    "'t'",
    "٣",
    "t\x00",
    "{",
    "}",
    "#",
)
SIGNS = (
    "+",
    "-",
    "*",
    "/",
    "**",
    "//",
    "%",
    "^",
    "@",
    "&",
    "==",
    ",",
    " ",
    ":",
    "(",
    ")",
    "((",
    "))",
    "()",
    "\n",
    "\x1b",
)


def cases(seed: int) -> Iterator[str]:
    """Texts: of the grammar, and those with something else in them.

    Args:
        seed: Of the random numbers.
    """
    r = random.Random(seed)
    while True:
        text = _some(r, r.randrange(7))
        for _ in range(r.choice((0, 0, 1, 1, 2, 5))):
            at, other = r.randrange(len(text) + 1), r.choice((*WORDS, *ODD, *SIGNS))
            text = r.choice((text[:at] + other + text[at:], text[:at] + text[at + 1 :], text[:at], text + other + text))
        if r.random() < 0.01:
            text = r.choice(("(", "-", "1+", "t*", "2**", "(t+", " ")) * r.randrange(1, 3000) + text
        yield text


def _some(r: random.Random, depth: int) -> str:
    kind = r.randrange(6) if depth else 0
    if kind == 0:
        return r.choice(WORDS)
    if kind == 1:
        return f"({_some(r, depth - 1)})"
    if kind == 2:
        return r.choice("+-") + _some(r, depth - 1)
    if kind == 3:
        return _some(r, depth - 1) + "**" + r.choice(("2", "-1", "0.5", "-minus", "t"))
    return _some(r, depth - 1) + r.choice((" + ", "-", "*", "/ ")) + _some(r, depth - 1)


def run(case: str) -> str:
    """What happened: "value" or "refused".

    Args:
        case: Text.
    """
    try:
        value = arithmetic_result(case, NUMBERS)
    except ValueError as fault:
        text = str(fault)
        assert text.isprintable(), text
        assert len(text) < 500, len(text)
        if "has no value" in text:
            assert not math.isfinite(_of_python(case)), case
        return "refused"
    assert isinstance(value, float)
    assert math.isfinite(value)
    expected = _of_python(case)
    # Where Python itself gives up, there is nothing to compare with.
    assert value == expected or math.isnan(expected), (case, value, expected)
    return "value"


def _of_python(text: str) -> float:
    """Python's value, all numbers real; infinite where it or a part of it has none; NaN where Python is no judge."""
    if len(text) > 2000:
        return math.nan
    number = r"(?<![\w.])(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?![\w.])"
    plain = re.sub(number, lambda found: f"_({float(found[0])!r})", text.strip())
    names = {name: _Watched(value) for name, value in {**NUMBERS, "pi": math.pi}.items()}
    try:
        with warnings.catch_warnings():
            # What is wrong with it is not the question here.
            warnings.simplefilter("ignore")
            return float(eval(plain, {"__builtins__": {}, "inf": math.inf, "_": _Watched}, names))
    except (RecursionError, MemoryError):
        return math.nan
    except (ArithmeticError, SyntaxError, TypeError, NameError, AttributeError, ValueError, _NoValue):
        return math.inf


class _NoValue(Exception):
    """A part of it is not finite or not real."""


class _Watched(float):
    """A number that, as what follows from it, is finite and real."""

    def __new__(cls, value: float):
        if not math.isfinite(value):
            raise _NoValue
        return super().__new__(cls, value)


def _watch(name: str):
    plain = getattr(float, name)

    def operation(self, *other):
        value = plain(self, *other)
        if isinstance(value, complex):
            raise _NoValue
        return value if value is NotImplemented else _Watched(value)

    return operation


for _name in ("add", "sub", "mul", "truediv", "pow", "neg", "pos", "radd", "rsub", "rmul", "rtruediv", "rpow"):
    setattr(_Watched, f"__{_name}__", _watch(f"__{_name}__"))
