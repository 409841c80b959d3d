"""Checks of the values in the TOML file of a study. An error names the key."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import StudyError, printable

# A kind of values: a function of key and value. It returns the checked value, or raises a StudyError with the key.
Kind = Callable[[str, Any], Any]


def as_number(key: str, value: Any) -> float:
    """Return a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise StudyError(f"{key} must be a number, not {printable(repr(value))}.")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise StudyError(f"{key} must be a finite number, not {printable(repr(value))}.")
    return number


def as_positive(key: str, value: Any) -> float:
    """Return a positive number."""
    if as_number(key, value) <= 0:
        raise StudyError(f"{key} must be positive, but is {value:g}.")
    return float(value)


def as_share(key: str, value: Any) -> float:
    """Return a number between 0 and 1."""
    if not 0 < as_number(key, value) < 1:
        raise StudyError(f"{key} must be between 0 and 1, but is {value:g}.")
    return float(value)


def as_numbers(key: str, value: Any) -> Any:
    """Return a number, or nested lists of numbers as an array."""
    if not isinstance(value, list):
        return as_number(key, value)
    entries = [as_numbers(key, entry) for entry in value]
    try:
        return np.array(entries, float)
    except ValueError:
        raise StudyError(f"{key} has lists of different lengths.") from None


def whole_kind(least: int = 1, most: float = math.inf) -> Kind:
    """Return the kind of whole numbers in a range."""

    def check(key: str, value: Any) -> int:
        if type(value) is not int or not least <= value <= most:
            to = f" to {most:g}" if most < math.inf else ""
            raise StudyError(f"{key} must be a whole number from {least}{to}, but is {printable(repr(value))}.")
        return value

    return check


def as_text(key: str, value: Any) -> str:
    """Return a text of printable letters."""
    if not isinstance(value, str) or not value.isprintable():
        raise StudyError(f"{key} must be a text of printable letters, but is {printable(repr(value))}.")
    return value


def as_choice(*known: str) -> Kind:
    """Return the kind of texts from a list."""

    def check(key: str, value: Any) -> str:
        if as_text(key, value) not in known:
            raise StudyError(f"{key} must be {', '.join(known[:-1])} or {known[-1]}, not '{printable(value)}'.")
        return value

    return check


def as_node(key: str, value: Any) -> str:
    """Return the name of a node as a text."""
    if isinstance(value, bool) or not isinstance(value, str | int):
        raise StudyError(f"{key} must be the name of a node, but is {printable(repr(value))}.")
    return str(value)


def as_pair(key: str, value: Any) -> tuple[float, float]:
    """Return a mean and a positive standard deviation."""
    if not isinstance(value, list) or len(value) != 2:
        raise StudyError(f"{key} must be a list of mean and standard deviation, but is {printable(repr(value))}.")
    return as_number(key, value[0]), as_positive(key, value[1])


def as_flag(key: str, value: Any) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise StudyError(f"{key} must be true or false, but is {printable(repr(value))}.")
    return value


def checked_table(key: str, content: dict[str, Any], schema: Mapping[str, Kind], between: str = ": ") -> dict[str, Any]:
    """Return the checked values of a table."""
    for name in content:
        if name not in schema:
            raise StudyError(f"{key}: there is no '{printable(name)}'. Known keys: {', '.join(schema)}.")
    return {name: schema[name](f"{key}{between}{name}", value) for name, value in content.items()}
