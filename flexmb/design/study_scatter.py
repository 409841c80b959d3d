"""Reader of the scatter of a study: distributions, correlations, acceptable answers, and options of robustness."""

from collections.abc import Iterable, Mapping
from typing import Any

from ..errors import StudyError, first_line, printable
from .evaluate import layout_of
from .scatter import Scatter, correlation_root, scatter
from .statistics import SAMPLES, YIELD, samples_for, statistic_of
from .study_values import as_number, as_text


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
        try:
            scatter({name: spreads[name]})
        except ValueError as fault:
            raise StudyError(f"{key}: {first_line(fault)}") from None
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
            try:
                scatter(spreads, correlation=pairs)
            except ValueError as fault:
                raise StudyError(f"{key}: {first_line(fault)}") from None
    nominal = {name: values[name] for name in spreads if name not in free}
    made = scatter(spreads, correlation=pairs, nominal=nominal)
    try:
        correlation_root(made, layout_of({name: values[name] for name in spreads}))
    except ValueError as fault:
        raise StudyError(f"[correlation]: {first_line(fault)}") from None
    return made


def check_statistic(key: str, name: str, answers: Iterable[str], tables: Mapping[str, Any]) -> bool:
    """Return whether a name is a statistic of made mechanisms; StudyError if its tables are missing."""
    named = dict.fromkeys(answers)
    try:
        asked = statistic_of(name, named)
    except ValueError as fault:
        raise StudyError(f"{key}: {first_line(fault)}") from None
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
