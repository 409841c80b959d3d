"""The study beside a SPACAR input file, with values and bounds of the names in its braces."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

from ..design.study_file import LARGEST_FILE, parameters_in
from ..errors import ModelError, StudyError, printable
from ..files import read_whole
from .building import free_names, numeric_values
from .document import Document
from .formulas import number_text

# Number of studies in a folder that are considered.
MOST = 50
HEAD = re.compile(r"\s*\[+\s*(.*?)\s*\]+\s*(#.*)?")


def names_beside(path: Path) -> tuple[dict[str, tuple[float, ...]], list[str]]:
    """Values or (value, lowest, highest) of names from the study of a file, and notes about it.

    The study has the name of the file with .toml, or else it is another study in the folder with this model.
    """
    own_study = path.with_suffix(".toml")
    others = sorted(study for study in path.parent.glob("*.toml") if study != own_study)[:MOST]
    for study in [own_study, *others]:
        try:
            model, parameters, functions = parameters_in(study)
        except (OSError, StudyError):
            if study == own_study and own_study.is_file():
                raise
            continue
        if (path.parent / model).name != path.name or ":" in model.removesuffix(".dat"):
            continue
        note = f"{printable(study.name)} names Python functions, which the workbench never runs: "
        return parameters, [note + printable(", ".join(functions))] * bool(functions)
    return {}, []


def write_beside(document: Document, path: Path) -> str | None:
    """Text of the study of a file with the names, values and bounds of a document; all else in the study stays."""
    study = path.with_suffix(".toml")
    lines = _parameters(document)
    if not study.is_file():
        if not lines:
            return None
        start = ["# Values and bounds of the names in the file; flexmb sweep and flexmb tune take this study."]
        answers = ["[answers]", "f1 = { frequency = 1 }"]
        return "\n".join([*start, f"model = {json.dumps(path.name)}", "", *lines, "", *answers, ""])
    try:
        text = read_whole(study, LARGEST_FILE).decode("utf-8-sig")
        before = tomllib.loads(text)
    except ValueError as fault:
        raise ModelError(f"{printable(study.name)} beside the file is no study: {printable(fault)}") from None
    if (model := before.get("model")) != path.name:
        name, other = printable(study.name), printable(repr(model))
        raise ModelError(f"{name} beside the file is the study of another model, {other}. Choose another name.")
    written = _with_parameters(text, lines)
    after = tomllib.loads(written)
    other_tables = [{key: value for key, value in data.items() if key != "parameters"} for data in (before, after)]
    if other_tables[0] != other_tables[1]:
        raise ModelError(f"[parameters] of {printable(study.name)} cannot be replaced. Write it as one table.")
    return written


def _parameters(document: Document) -> list[str]:
    """Lines of [parameters]."""
    known: Any = numeric_values(document)
    lines = []
    for name in free_names(document):
        address = f"names/{name}"
        if f"{address}/value" not in known:
            continue
        value, low, high = (known.get(f"{address}/{key}") for key in ("value", "low", "high"))
        key = name if re.fullmatch("[A-Za-z0-9_]+", name) else json.dumps(name, ensure_ascii=False)
        entry_text = _number(value)
        if low is not None and high is not None and low < high:
            entry_text = f"{{ value = {entry_text}, lower = {_number(low)}, upper = {_number(high)} }}"
        lines.append(f"{key} = {entry_text}")
    return ["[parameters]", *lines] if lines else []


def _number(value: Any) -> str:
    text = number_text(float(value))
    return repr(float(value)) if text == "pi" else text


def _with_parameters(text: str, lines: list[str]) -> str:
    """The text of a study with other parameters."""
    other_lines: list[str] = []
    place, inside = None, False
    for line in text.splitlines():
        if head := HEAD.fullmatch(line):
            inside = head.group(1).partition(".")[0].strip() == "parameters"
            if inside and place is None:
                place = len(other_lines)
        if not inside:
            other_lines.append(line)
    if place is None:
        place = len(other_lines)
        lines = ["", *lines] if lines else []
    elif lines and place < len(other_lines):
        lines = [*lines, ""]
    return "\n".join([*other_lines[:place], *lines, *other_lines[place:]]) + "\n"
