"""Checks of the values in the TOML file of a study, and of its scatter. An error names the key."""

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ..errors import StudyError, first_line, printable
from .evaluate import layout_of
from .scatter import Scatter, correlation_root, scatter
from .statistics import SAMPLES, YIELD, samples_for, statistic_of

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


def kind(expected: str, accepts: Callable[[Any], bool], convert: Callable[[Any], Any] = lambda value: value) -> Kind:
    """Return the kind of the values that a condition accepts."""

    def check(key: str, value: Any) -> Any:
        if not accepts(value):
            raise StudyError(f"{key} must be {expected}, but is {printable(repr(value))}.")
        return convert(value)

    return check


def whole_kind(least: int = 1, most: float = math.inf) -> Kind:
    """Return the kind of whole numbers in a range."""
    to = f" to {most:g}" if most < math.inf else ""
    return kind(f"a whole number from {least}{to}", lambda value: type(value) is int and least <= value <= most)


as_text = kind("a text of printable letters", lambda value: isinstance(value, str) and value.isprintable())
as_node = kind("the name of a node", lambda value: isinstance(value, str | int) and not isinstance(value, bool), str)
as_flag = kind("true or false", lambda value: isinstance(value, bool))
as_true = kind("true", lambda value: value is True)
as_table_of_columns = kind("a table of names of columns", lambda value: isinstance(value, dict))


def as_choice(*known: str) -> Kind:
    """Return the kind of texts from a list."""

    def check(key: str, value: Any) -> str:
        if as_text(key, value) not in known:
            raise StudyError(f"{key} must be {', '.join(known[:-1])} or {known[-1]}, not '{printable(value)}'.")
        return value

    return check


def as_pair(key: str, value: Any) -> tuple[float, float]:
    """Return a mean and a positive standard deviation."""
    if not isinstance(value, list) or len(value) != 2:
        raise StudyError(f"{key} must be a list of mean and standard deviation, but is {printable(repr(value))}.")
    return as_number(key, value[0]), as_positive(key, value[1])


def checked_table(key: str, content: dict[str, Any], schema: Mapping[str, Kind], between: str = ": ") -> dict[str, Any]:
    """Return the checked values of a table."""
    for name in content:
        if name not in schema:
            raise StudyError(f"{key}: there is no '{printable(name)}'. Known keys: {', '.join(schema)}.")
    return {name: schema[name](f"{key}{between}{name}", value) for name, value in content.items()}


@contextlib.contextmanager
def naming_key(key: str) -> Iterator[None]:
    """Turn a ValueError into a StudyError with its key."""
    try:
        yield
    except ValueError as fault:
        raise StudyError(f"{key}: {first_line(fault)}") from None


def as_spread(key: str, value: Any) -> Any:
    """Return a standard deviation, or a tuple of the name of a distribution and its numbers."""
    if not isinstance(value, list):
        return as_number(key, value)
    if not value:
        raise StudyError(f"{key} must be a standard deviation or a list such as ['uniform', 1e-5], but is empty.")
    return (as_text(key, value[0]), *(as_number(key, entry) for entry in value[1:]))


def as_percentiles(key: str, value: Any) -> list[float]:
    """Return percentages between 0 and 100."""
    numbers = [as_number(key, entry) for entry in value] if isinstance(value, list) else []
    if not numbers or not all(0 < number < 100 for number in numbers):
        raise StudyError(f"{key} must be a list of numbers between 0 and 100, but is {printable(repr(value))}.")
    return numbers


def scatter_of(
    given: Mapping[str, Any], correlated: Mapping[str, Any], values: Mapping[str, Any], free: Iterable[str]
) -> Scatter:
    """Return the scatter of the tables [scatter] and [correlation].

    Args:
        given: Table [scatter].
        correlated: Table [correlation].
        values: Nominal value of each parameter.
        free: Parameters with bounds, which are dimensions of the design.
    """
    spreads = {}
    for name, value in given.items():
        key = f"[scatter] {printable(name)}"
        if name not in values:
            raise StudyError(f"{key}: there is no such parameter ({printable(', '.join(values))}).")
        spreads[name] = as_spread(key, value)
        with naming_key(key):
            scatter({name: spreads[name]})
    pairs = {}
    for first, others in correlated.items():
        key = f"[correlation] {printable(first)}"
        if not isinstance(others, dict):
            raise StudyError(
                f"{key} must name a second parameter, such as t.w = 0.5, but is {printable(repr(others))}."
            )
        for second, value in others.items():
            pair, key = (first, second), f"[correlation] {printable(first)}.{printable(second)}"
            pairs[pair] = as_number(key, value)
            with naming_key(key):
                scatter(spreads, correlation=pairs)
    nominal = {name: values[name] for name in spreads if name not in free}
    made = scatter(spreads, correlation=pairs, nominal=nominal)
    with naming_key("[correlation]"):
        correlation_root(made, layout_of({name: values[name] for name in spreads}))
    return made


def check_statistic(key: str, name: str, answers: Iterable[str], tables: Mapping[str, Any]) -> bool:
    """Return whether a name is a statistic of made mechanisms; StudyError if its tables are missing."""
    named = dict.fromkeys(answers)
    with naming_key(key):
        asked = statistic_of(name, named)
    if (asked is None and name != YIELD) or name in named:
        return False
    for table in ("scatter", *(["acceptable"] if name == YIELD else [])):
        if not tables.get(table):
            raise StudyError(f"{key}: '{printable(name)}' is about made mechanisms. It needs [{table}].")
    if asked is not None and asked.kind == "percentile":
        check_samples(f"{key}: '{printable(name)}'", "tune", asked.percent, tables, SAMPLES)
    return True


def check_samples(what: str, table: str, percent: float, tables: Mapping[str, Any], default: int) -> None:
    """Refuse a percentile beyond the samples of a table."""
    samples, least = tables.get(table, {}).get("samples", default), samples_for(percent)
    if samples < least:
        raise StudyError(f"{what} lies beyond {samples} samples. Give [{table}] samples, {least} or more.")
