"""Reader of the measurements of a study: inline numbers, CSV files and universal files."""

import contextlib
import csv
import dataclasses
import functools
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..control.frequency_response import FrequencyResponse, place_of_name
from ..control.universal_file import ENDINGS, TYPES
from ..design.study_parts import Called, NamedAnswer, function_of, message_of
from ..design.study_values import (
    Kind,
    as_flag,
    as_number,
    as_numbers,
    as_positive,
    as_table_of_columns,
    as_text,
    as_true,
    checked_table,
    whole_kind,
)
from ..errors import StudyError, first_line, printable
from ..files import read_whole
from ..questions.question import Asked
from .measurement import Measured, measured
from .mode_pairing import measured_modes
from .response_data import measured_response

# A table of a million rows is smaller.
LARGEST_TABLE = 64 * 2**20
SEPARATORS = ";\t,"
DECIMAL_COMMA = "Numbers need a decimal point: replace decimal commas."
# Units that a column must not name: pattern of these units, and the right unit.
OTHER_UNITS = {
    "phase": (r"\bdeg|°", "rad"),
    "magnitude": (r"\bdB\b", "SI units"),
    "hertz": (r"\brad\b|\b[kM]Hz\b", "Hz"),
}


def _texts(key: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list):
        return (as_text(key, value),)
    return tuple(as_text(key, entry) for entry in value)


def _true_or_numbers(key: str, value: Any) -> list[int] | None:
    """Return numbers of modes, or None for true."""
    if value is True:
        return None
    if not isinstance(value, list) or not value:
        raise StudyError(f"{key} must be true or a list of numbers of modes, but is {printable(repr(value))}.")
    return [whole_kind()(key, entry) for entry in value]


def _name_or_number(key: str, value: Any) -> str | float:
    return as_text(key, value) if isinstance(value, str) else as_number(key, value)


def _columns(key: str, value: Any) -> dict[str, str | int]:
    return {
        name: as_text(f"{key} {name}", column) if isinstance(column, str) else whole_kind()(f"{key} {name}", column)
        for name, column in as_table_of_columns(key, value).items()
    }


# Parts of a complex response: one of the pairs is given.
PARTS = (("real", "imaginary"), ("magnitude", "phase"))
# Kinds by key: keys of all measurements, keys of a file, and for each kind of measurement its keys and its columns.
EVERY: dict[str, Kind] = {"deviation": as_numbers, "relative_deviation": as_positive}
FILE: dict[str, Kind] = {"file": as_text, "columns": _columns}
KINDS: dict[str, tuple[dict[str, Kind], tuple[str, ...]]] = {
    "answer": (
        {"answer": _texts, "values": as_numbers, "covariance": as_numbers, "over": as_numbers, "label": as_text},
        ("values", "deviation", "over"),
    ),
    "modes": (
        {"modes": _true_or_numbers, "values": as_numbers, "shapes": as_numbers, "at": _texts, "among": whole_kind()},
        ("values", "deviation"),
    ),
    "response": (
        {
            "response": as_true, "hertz": as_numbers, "real": as_numbers, "imaginary": as_numbers,
            "magnitude": as_numbers, "phase": as_numbers, "output": as_text, "input": as_text,
            "loss_factor": _name_or_number, "gain": as_text, "delay": as_text, "logarithmic": as_flag,
        },
        ("hertz", "real", "imaginary", "magnitude", "phase", "deviation"),
    ),
}  # fmt: skip


def measurements_of(about: str, folder: Path, data: Mapping[str, Any]) -> list[Measured]:
    """Return the measurements of the table [data] of a study; a StudyError names the key."""
    return [
        _measurement(f"[data] {printable(name)}", about, folder, as_text("[data]", name), table)
        for name, table in data.items()
    ]


def _measurement(key: str, about: str, folder: Path, name: str, table: Any) -> Measured:
    kind = next((kind for kind in KINDS if isinstance(table, dict) and kind in table), None)
    if kind is None:
        raise StudyError(f"{key} must be a table with one of {', '.join(KINDS)}.")
    schema, columns = KINDS[kind]
    entry = checked_table(key, table, {**schema, **EVERY, **FILE})
    if "file" in entry:
        _fill(key, folder, entry, columns, from_universal=kind == "response")
    elif "columns" in entry:
        raise StudyError(f"{key}: columns belong to a file. Give file, or leave columns out.")
    with _naming_key(key):
        if kind == "response":
            return _response(key, name, entry)
        values = _needed(key, entry, "values")
        deviation = _deviation(key, entry, values)
        if kind == "modes":
            chosen = _given(entry, "shapes", "at", "among")
            return measured_modes(values, deviation, numbers_of_modes=entry["modes"], name=name, **chosen)
        chosen = _given(entry, "covariance", "over", "label")
        answer, called = _answer(key, about, folder, entry["answer"])
        measurement = measured(answer, values, deviation, name=name, **chosen)
        return measurement if called is None else dataclasses.replace(measurement, answer=called)


@contextlib.contextmanager
def _naming_key(key: str) -> Iterator[None]:
    """Turn errors of a measurement into a StudyError with its key."""
    try:
        yield
    except StudyError:
        raise
    except (ValueError, TypeError, KeyError) as fault:
        raise StudyError(f"{key}: {printable(message_of(fault))}") from fault


def _given(entry: Mapping[str, Any], *options: str) -> dict[str, Any]:
    return {option: entry[option] for option in options if option in entry}


def _needed(key: str, entry: Mapping[str, Any], name: str) -> Any:
    if name not in entry:
        header = printable(", ".join(entry.get("header", ())))
        header = f" The columns of the file are: {header}." if header else ""
        raise StudyError(f"{key}: give {name}, or a file with this column.{header}")
    return np.asarray(entry[name], float)


def _deviation(key: str, entry: Mapping[str, Any], values: np.ndarray) -> Any:
    if "relative_deviation" not in entry:
        return entry.get("deviation")
    if "deviation" in entry:
        raise StudyError(f"{key} has deviation and relative_deviation: give one.")
    return entry["relative_deviation"] * np.abs(values)


def _answer(key: str, about: str, folder: Path, texts: tuple[str, ...]) -> tuple[Any, Callable[..., Any] | None]:
    """Return the answer for `measured`, and the function with errors that name the key, or None."""
    if len(texts) == 1 and ":" in texts[0]:
        function = function_of(f"{key}: answer", folder, texts[0])
        return function, Called(f"{about}: {key}", texts[0], function, is_answer=True)
    for text in texts:
        with _naming_key(f"{key}: answer"):
            if not Asked(text).question.differentiable:
                raise StudyError(f"{key}: '{printable(text)}' has no derivatives, which a fit needs.")
    if len(texts) == 1:
        return texts[0], NamedAnswer(f"{about}: {key}", Asked(texts[0]))
    return list(texts), None


def _response(key: str, name: str, entry: dict[str, Any]) -> Measured:
    hertz = _needed(key, entry, "hertz")
    if "magnitude" in entry or "phase" in entry:
        if "real" in entry or "imaginary" in entry:
            raise StudyError(f"{key} has real and imaginary parts, and magnitude and phase: give one pair.")
        size, angle = (_needed(key, entry, part) for part in ("magnitude", "phase"))
        if np.any(size < 0):
            raise StudyError(
                f"{key}: a magnitude is {np.min(size):g}, but cannot be negative. Convert levels in dB to magnitudes."
            )
        if np.any(np.abs(angle) > 4 * np.pi):
            raise StudyError(
                f"{key}: a phase is {angle[np.argmax(np.abs(angle))]:g}, more than two turns. Phases are in radians:"
                " convert degrees, or subtract whole turns."
            )
        values = size * np.exp(1j * angle)
    else:
        real, imaginary = (_needed(key, entry, part) for part in ("real", "imaginary"))
        values = real + 1j * imaginary
    chosen = _given(entry, "output", "input", "loss_factor", "gain", "delay", "logarithmic")
    measurement = measured_response(hertz, values, _deviation(key, entry, values), name=name, **chosen)
    if "ports" not in entry:
        return measurement
    return dataclasses.replace(measurement, check=functools.partial(_check_quantities, name, entry))


def _check_quantities(name: str, entry: Mapping[str, Any], model: Any) -> None:
    """Refuse a response whose quantities or directions are not those of the output and the input of the model."""
    reversed_signals = []
    for kind, port, signals in zip(
        ("output", "input"), entry["ports"], (model.labels.outputs, model.labels.inputs), strict=True
    ):
        signal = signals[place_of_name(kind, [signal.name for signal in signals], entry.get(kind))]
        quantity = signal.quantity
        if port.quantity in TYPES and quantity in TYPES and TYPES[port.quantity] != TYPES[quantity]:
            raise ValueError(
                f"Measurement '{name}' has the {port.quantity} of an {kind}, but the {kind} of the model is of the"
                f" quantity {quantity}. Name an {kind} of the model that is measured."
            )
        # A sensor or an actuator may have the sign of the file.
        if port.axis.startswith("-") and not signal.parts:
            reversed_signals.append((kind, port.axis, "sensor" if kind == "output" else "actuator"))
    # A gain may have a negative sign.
    if len(reversed_signals) == 1 and "gain" not in entry:
        ((kind, axis, combined),) = reversed_signals
        raise ValueError(
            f"Measurement '{name}' has an {kind} along {axis}; the {kind} of the model is along the positive axis."
            f" Give the measurement a `gain` with negative bounds, or add a {combined} with the weight -1 to the model."
        )


def _fill(key: str, folder: Path, entry: dict[str, Any], columns: tuple[str, ...], *, from_universal: bool) -> None:
    """Add the columns of a file to an entry."""
    path = folder / entry["file"]
    if path.suffix.lower() in ENDINGS:
        if not from_universal:
            raise StudyError(f"{key}: a universal file has frequency responses. Give response = true.")
        by_name = _universal(key, path, entry)
    else:
        by_name = _table(key, path, entry, columns)
    for name, values in by_name.items():
        if name in entry:
            raise StudyError(f"{key}: {name} is given, and '{printable(path.name)}' has it too. Leave one out.")
        entry[name] = values


def _universal(key: str, path: Path, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return frequencies, response and ports of a universal file, data set 58."""
    if "columns" in entry:
        raise StudyError(f"{key}: a universal file has no columns. Leave columns out.")
    with _naming_key(f"{key}: file"), _readable(key, path):
        try:
            responses = FrequencyResponse.load(path)
        except ValueError as fault:
            raise ValueError(first_line(fault).replace(printable(path), printable(path.name))) from fault
        several = len(responses.outputs) * len(responses.inputs) > 1
        names = (entry.get("output"), entry.get("input")) if several else (None, None)
        response: Any = np.asarray(responses.of(*names))
        i, j = place_of_name("output", responses.outputs, names[0]), place_of_name("input", responses.inputs, names[1])
    ports = responses.output_ports[i], responses.input_ports[j]
    return {"hertz": np.asarray(responses.hertz), "real": response.real, "imaginary": response.imag, "ports": ports}


@contextlib.contextmanager
def _readable(key: str, path: Path) -> Iterator[None]:
    """Turn errors of an unreadable file or a missing library into a StudyError with the key."""
    try:
        yield
    except OSError as fault:
        why = fault.strerror or first_line(fault)
        raise StudyError(f"{key}: cannot read '{printable(path)}': {printable(why)}.") from None
    except ImportError as fault:
        raise StudyError(f"{key}: {first_line(fault)}") from None


def _table(key: str, path: Path, entry: dict[str, Any], columns: tuple[str, ...]) -> dict[str, Any]:
    """Return columns of a CSV file by name or number, others by the names of the quantities; and its header."""
    chosen: dict[str, str | int] = entry.get("columns", {})
    if strangers := [name for name in chosen if name not in columns]:
        raise StudyError(f"{key}: there is no '{printable(strangers[0])}' in columns. Known: {', '.join(columns)}.")
    with _readable(key, path):
        content = read_whole(path, LARGEST_TABLE)
    subject = f"{key}: '{printable(path.name)}'"
    try:
        text = content.decode()
    except ValueError:
        raise StudyError(f"{subject} is no text in UTF-8.") from None
    cells = cells_of(subject, text)
    header = cells[0][1]
    chosen = {**_response_by_name(subject, header, entry, chosen), **chosen} if "real" in columns else chosen
    if chosen:
        # Numbers in the study, and the other pair of parts, leave out what the file may have beside.
        given = {*entry, *("deviation" for name in ("relative_deviation", "covariance") if name in entry)}
        for pair, other in (PARTS, PARTS[::-1]):
            if any(part in chosen or part in entry for part in pair):
                given |= {*other}
        columns = tuple(name for name in columns if name not in given)
    return {**_columns_of(subject, cells, chosen, columns), "header": [] if all(map(_is_number, header)) else header}


def _response_by_name(
    subject: str, header: list[str], entry: Mapping[str, Any], chosen: Mapping[str, Any]
) -> dict[str, str | int]:
    """Return the columns "real OUTPUT by INPUT" and "imaginary .." of the output and the input of a measurement."""
    pairs = [name.removeprefix("real ") for name in header if name.startswith("real ") and " by " in name]
    if not pairs or any(part in place for pair in PARTS for part in pair for place in (chosen, entry, header)):
        return {}
    output, source = entry.get("output"), entry.get("input")
    start, end = "" if output is None else f"{output} by ", "" if source is None else f" by {source}"
    fitting = [pair for pair in pairs if pair.startswith(start) and pair.endswith(end)]
    if len(fitting) != 1:
        raise StudyError(
            f"{subject} has the responses {printable(', '.join(pairs))}. Choose one by output and input, or by columns."
        )
    return {"real": f"real {fitting[0]}", "imaginary": f"imaginary {fitting[0]}"}


def cells_of(what: str, text: str) -> list[tuple[int, list[str]]]:
    """Return number and cells of each line of a CSV text; StudyError if there is none."""
    lines = text.removeprefix("\ufeff").splitlines()
    rows = [(i, line) for i, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if not rows:
        raise StudyError(f"{what} is empty.")
    separator = next((letter for letter in SEPARATORS if letter in rows[0][1]), ",")
    return [
        (i, [cell.strip() for cell in next(csv.reader(io.StringIO(line), delimiter=separator))]) for i, line in rows
    ]


def _columns_of(
    subject: str, cells: list[tuple[int, list[str]]], chosen: Mapping[str, str | int], columns: tuple[str, ...]
) -> dict[str, np.ndarray]:
    are_numbers = [_is_number(cell) for cell in cells[0][1]]
    by_number = bool(chosen) and all(isinstance(column, int) for column in chosen.values())
    # Columns by number need no header: a row with some numbers is data, of which a cell may be missing.
    header = [] if (any(are_numbers) if by_number else all(are_numbers)) else cells.pop(0)[1]
    if not cells:
        raise StudyError(f"{subject} has no line of numbers.")
    selected = {name: name for name in columns if name in header} | dict(chosen)
    if not selected:
        named = f" Its columns are: {printable(', '.join(header))}." if header else ""
        name = f"Name columns, such as {{ {columns[0]} = 2 }}."
        raise StudyError(f"{subject} has no column {' or '.join(columns)}.{named} {name}")
    for name, column in selected.items():
        pattern, unit = OTHER_UNITS.get(name, ("$^", ""))
        if isinstance(column, str) and re.search(pattern, column):
            raise StudyError(f"{subject}: column '{printable(column)}' has another unit. Convert {name} to {unit}.")
    places = {name: _place(subject, header, column) for name, column in selected.items()}
    if not by_number:
        _check_lengths(subject, header, cells)
    return {name: np.array([_cell(subject, i, row, place, name) for i, row in cells]) for name, place in places.items()}


def measured_table(name: str, text: str, answers: Callable[[list[str]], Callable[..., Any]]) -> Measured:
    """Return the measurement of a CSV text: columns of a response, or answer, value and deviation in each line.

    Args:
        name: Name of the file, for messages.
        text: Content of the file.
        answers: Function of questions that returns the function of the model with their answers.
    """
    subject = f"'{printable(name)}'"
    cells = cells_of(subject, text)
    if "answer" not in cells[0][1]:
        columns = KINDS["response"][1]
        if "hertz" not in cells[0][1]:
            raise StudyError(f"{subject} has no column answer or hertz. Its first line must name its columns.")
        with _naming_key(subject):
            return _response(subject, name, _columns_of(subject, cells, {}, columns))
    place, chosen = cells[0][1].index("answer"), {"value": "value", "deviation": "deviation"}
    columns = _columns_of(subject, cells, chosen, tuple(chosen))
    if short := [i for i, row in cells if place >= len(row)]:
        raise StudyError(f"{subject}, line {short[0]}: there is no column {place + 1} for answer.")
    with _naming_key(subject):
        texts = [row[place] for _, row in cells]
        return measured(answers(texts), columns["value"], columns["deviation"], name=name)


def _check_lengths(what: str, header: list[str], rows: list[tuple[int, list[str]]]) -> None:
    """Refuse lines with more cells than names: decimal commas would shift the columns."""
    for i, row in rows:
        if any(row[len(header) :]):
            raise StudyError(f"{what}, line {i} has {len(row)} cells for {len(header)} columns. {DECIMAL_COMMA}")


def _place(subject: str, header: list[str], column: str | int) -> int:
    if isinstance(column, int):
        return column - 1
    if header.count(column) != 1:
        many = "several columns" if column in header else "no column"
        raise StudyError(
            f"{subject} has {many} '{printable(column)}'. Its columns are:"
            f" {printable(', '.join(header)) or 'not named'}."
        )
    return header.index(column)


def _cell(subject: str, line: int, row: list[str], place: int, name: str) -> float:
    if place >= len(row):
        raise StudyError(f"{subject}, line {line}: there is no column {place + 1} for {name}.")
    text = row[place]
    if not _is_number(text) or not math.isfinite(float(text)):
        description = f"is '{printable(text)}'" if text else "is empty"
        advice = DECIMAL_COMMA if _is_number(text.replace(",", ".", 1)) and "," in text else "Leave the line out."
        raise StudyError(f"{subject}, line {line}: {name} {description}, which is no finite number. {advice}")
    return float(text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
