"""The study beside a SPACAR input file, where the names in its braces have their values and bounds."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

from ..design.study_file import LARGEST_FILE, parameters_in
from ..errors import ModelError, StudyError, clean
from ..files import read_whole
from .building import free_names, numbers_of
from .document import Document
from .formulas import text_of

# So many studies in a folder are looked at.
MOST = 50
HEAD = re.compile(r"\s*\[+\s*(.*?)\s*\]+\s*(#.*)?")


def names_beside(path: Path) -> tuple[dict[str, tuple[float, ...]], list[str]]:
    """Values of names, or values and bounds, as the study of a file has them; and what there is to know of it.

    The study has the name of the file with .toml, or else it is another one in the folder that names the file as its
    model.

    Raises:
        StudyError: The study of that name is wrong.
    """
    own = path.with_suffix(".toml")
    others = sorted(one for one in path.parent.glob("*.toml") if one != own)[:MOST]
    for study in [own, *others]:
        try:
            model, found, functions = parameters_in(study)
        except (OSError, StudyError):
            if study == own and own.is_file():
                raise
            continue
        if (path.parent / model).name != path.name or ":" in model.removesuffix(".dat"):
            continue
        notes = [f"{clean(study.name)} names Python functions, which are not run here: {clean(', '.join(functions))}"]
        return found, notes * bool(functions)
    return {}, []


def write_beside(document: Document, path: Path) -> str | None:
    """Text of the study of a file: names with their values and bounds. All else in a study that is there stays.

    Raises:
        ModelError: The study there is of another model, or cannot be changed.
    """
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
        raise ModelError(f"{clean(study.name)} beside the file is no study: {clean(fault)}") from None
    if before.get("model") != path.name:
        raise ModelError(
            f"{clean(study.name)} beside the file is the study of another model, {clean(repr(before.get('model')))}:"
            " save under another name."
        )
    written = _with_parameters(text, lines)
    after = tomllib.loads(written)
    rest = [{key: value for key, value in data.items() if key != "parameters"} for data in (before, after)]
    if rest[0] != rest[1]:
        raise ModelError(f"[parameters] of {clean(study.name)} are written in a way that cannot be changed here.")
    return written


def _parameters(document: Document) -> list[str]:
    """Lines of [parameters]."""
    known: Any = numbers_of(document)
    lines = []
    for name in free_names(document):
        address = f"names/{name}"
        if f"{address}/value" not in known:
            continue
        value, low, high = (known.get(f"{address}/{key}") for key in ("value", "low", "high"))
        key = name if re.fullmatch("[A-Za-z0-9_]+", name) else json.dumps(name, ensure_ascii=False)
        shown = _number(value)
        if low is not None and high is not None and low < high:
            shown = f"{{ value = {shown}, lower = {_number(low)}, upper = {_number(high)} }}"
        lines.append(f"{key} = {shown}")
    return ["[parameters]", *lines] if lines else []


def _number(value: Any) -> str:
    text = text_of(float(value))
    return repr(float(value)) if text == "pi" else text


def _with_parameters(text: str, lines: list[str]) -> str:
    """The text of a study with another table of parameters."""
    kept: list[str] = []
    place, inside = None, False
    for line in text.splitlines():
        if head := HEAD.fullmatch(line):
            inside = head.group(1).partition(".")[0].strip() == "parameters"
            if inside and place is None:
                place = len(kept)
        if not inside:
            kept.append(line)
    if place is None:
        place = len(kept)
        lines = ["", *lines] if lines else []
    elif lines and place < len(kept):
        lines = [*lines, ""]
    return "\n".join([*kept[:place], *lines, *kept[place:]]) + "\n"
