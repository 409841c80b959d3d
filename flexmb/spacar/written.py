"""Lines of a SPACAR input file to be written: their numbers, which may be traced, and their texts."""

import dataclasses
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..errors import ModelError, printable
from .lines import LARGEST, SMALLEST, known, within


@dataclasses.dataclass(frozen=True)
class WrittenLine:
    """One line of a file: keyword, and words, whole numbers and real numbers, which may be traced."""

    keyword: str
    values: tuple[Any, ...]


def line_text(line: WrittenLine | str) -> str:
    """One line as text, real numbers with all their digits."""
    if isinstance(line, str):
        return line
    text = " ".join([line.keyword, *(str(v) if isinstance(v, int | str) else repr(float(v)) for v in line.values)])
    for value in line.values:
        if not isinstance(value, int | str) and not within(value):
            size = f"0 or from {SMALLEST:g} to {LARGEST:g} in size"
            raise ModelError(f"'{printable(text)}' cannot be written to a SPACAR input file: numbers must be {size}.")
    return text


def line_of(keyword: str, *values: Any) -> WrittenLine:
    """A line of a keyword and what follows it."""
    return WrittenLine(keyword, values)


def flat_numbers(value: Any) -> list[Any]:
    """Numbers of a scalar, an array or a sequence, which may be traced."""
    if is_concrete(value):
        return np.ravel(np.asarray(value, float)).tolist()
    if isinstance(value, list | tuple):
        return [number for entry in value for number in flat_numbers(entry)]
    return [value] if np.ndim(value) == 0 else [value[i] for i in range(len(value))]


def number_for_line(value: Any) -> Any:
    """A number for a line."""
    return float(np.asarray(value)) if known(value) else value


def is_zero(value: Any) -> bool:
    """Whether a number is known to be zero."""
    return known(value) and value == 0


def trimmed(values: list[Any]) -> list[Any]:
    """Values without zeros at the end, except the first."""
    while len(values) > 1 and is_zero(values[-1]):
        values = values[:-1]
    return values
