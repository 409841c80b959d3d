"""Arithmetic of numbers and named parameters, as in the braces of an input file."""

import math
import operator
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import jax.core
import numpy as np

from ..errors import printable

_NUMBER = r"(?P<number>([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?)(?![\w.])"
_TOKEN = re.compile(rf"[ \t]*(?:{_NUMBER}|(?P<name>[^\W\d]\w*)|(?P<sign>\*\*|[-+*/()]))")

_PLAIN = re.compile(rf"[ \t]*[-+]?[ \t]*{_NUMBER}[ \t]*")


class _Operation(NamedTuple):
    """The rank of a sign (higher ranks run first), its number of operands, and its function."""

    rank: int
    operands: int
    function: Callable[..., Any]


# As in Python: -a**b is -(a**b), and a**b**c is a**(b**c).
_BINARY = {
    "+": _Operation(1, 2, operator.add),
    "-": _Operation(1, 2, operator.sub),
    "*": _Operation(2, 2, operator.mul),
    "/": _Operation(2, 2, operator.truediv),
    "**": _Operation(4, 2, operator.pow),
}
_UNARY = {"+": _Operation(3, 1, operator.pos), "-": _Operation(3, 1, operator.neg)}
_OPEN = _Operation(0, 0, operator.pos)


def arithmetic_result(text: str, numbers: Mapping[str, Any]) -> Any:
    """Value of arithmetic with + - * / ** and parentheses, () real, by numbers by name, which may be traced.

    One pass without recursion: neither length nor depth has a limit. The message of a ValueError is the rest of a
    sentence about the text.
    """
    values: list[Any] = []
    waiting: list[_Operation] = []
    place, end, expects_value = 0, len(text.rstrip(" \t")), True
    while place < end:
        match = _TOKEN.match(text, place)
        if match is None:
            raise ValueError(
                f"may have numbers, parameters, pi, + - * / ** and parentheses only: {_remainder(text, place)}"
            )
        sign = match["sign"]
        # Before a value: a number, a name, "(" or a sign. After a value: an operation or ")".
        if expects_value and (match["number"] or match["name"]):
            name = match["name"]
            values.append(_value_of_name(name, numbers) if name else _finite(float(match["number"])))
            expects_value = False
        elif expects_value and sign == "(":
            waiting.append(_OPEN)
        elif expects_value and sign in _UNARY:
            waiting.append(_UNARY[sign])
        elif not expects_value and sign == ")":
            _finish(values, waiting, 1)
            if not waiting:
                raise ValueError("is no arithmetic: a closing parenthesis has no opening one")
            waiting.pop()
        elif not expects_value and sign in _BINARY:
            operation = _BINARY[sign]
            _finish(values, waiting, operation.rank + (sign == "**"))
            waiting.append(operation)
            expects_value = True
        else:
            raise ValueError(f"is no arithmetic of numbers and parameters: {_remainder(text, place)}")
        place = match.end()
    if expects_value:
        raise ValueError("is no arithmetic of numbers and parameters: something is missing at its end")
    _finish(values, waiting, 1)
    if waiting:
        raise ValueError("is no arithmetic: a parenthesis is not closed")
    return values[0]


def is_number_text(text: str) -> bool:
    """Whether a text is one number, with or without a sign."""
    return _PLAIN.fullmatch(text) is not None


def names_in(text: str) -> list[str]:
    """Names in arithmetic, in order, up to the first fault; pi is among them."""
    return [text[start:end] for start, end in _names(text)]


def renamed(text: str, old: str, new: str) -> str:
    """Arithmetic with another name in place of one; all else stays."""
    for start, end in reversed(_names(text)):
        if text[start:end] == old:
            text = text[:start] + new + text[end:]
    return text


def _names(text: str) -> list[tuple[int, int]]:
    spans, place = [], 0
    while match := _TOKEN.match(text, place):
        if match["name"]:
            spans.append(match.span("name"))
        place = match.end()
    return spans


def _remainder(text: str, place: int) -> str:
    return f"see '{printable(text[place:].strip())}'"


def _finish(values: list[Any], waiting: list[_Operation], rank: int) -> None:
    """Do waiting operations, back to one of a lower rank or a parenthesis."""
    while waiting and waiting[-1].rank >= rank:
        operation = waiting.pop()
        operands = values[-operation.operands :]
        del values[-operation.operands :]
        try:
            value = operation.function(*operands)
        except (ZeroDivisionError, OverflowError) as fault:
            why = "a division by zero" if isinstance(fault, ZeroDivisionError) else "a number too large"
            raise ValueError(f"has no value: {why}") from None
        if isinstance(value, complex):
            raise ValueError("has no value: it must be a real number, not a root of a negative one")
        values.append(_finite(value))


def _finite(value: Any) -> Any:
    """A number that is finite or traced."""
    if not isinstance(value, jax.core.Tracer) and not math.isfinite(value):
        raise ValueError("has no value: a number in it is too large or not a number")
    return value


def _value_of_name(name: str, numbers: Mapping[str, Any]) -> Any:
    if name not in numbers:
        if name == "pi":
            return math.pi
        known = ", ".join(numbers) or "none is given"
        name, known = printable(name), printable(known)
        raise ValueError(
            f"asks for '{name}', but there is no parameter '{name}' ({known}); it is given by numbers={{..}} in Python,"
            f" by --set {name}=NUMBER on the command line"
        )
    value = numbers[name]
    if isinstance(value, bool | np.bool_ | str) or np.shape(value) != ():
        raise ValueError(f"asks for '{printable(name)}', which must be one number, but is {printable(repr(value))}")
    # Division by a NumPy zero would only warn.
    return value if isinstance(value, jax.core.Tracer) else _finite(float(value))
