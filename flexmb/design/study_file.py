"""Reader of the TOML file of a study: it checks every key, and an error names file and key."""

import contextlib
import difflib
import errno
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import StudyError, clean
from ..files import read_whole
from ..questions.question import Asked, Question, questions
from .designs import MOST
from .evaluate import check_dimensions, check_names
from .robust import SAMPLES
from .scatter import Scatter
from .statistics import YIELD
from .study import Study
from .study_parts import Called, FromFile, NamedAnswer, content_of, function_of
from .study_scatter import as_percentiles, check_samples, check_statistic, scatter_of
from .study_values import (
    Kind,
    as_choice,
    as_node,
    as_number,
    as_numbers,
    as_pair,
    as_positive,
    as_share,
    as_text,
    as_whole,
    checked_table,
)

# A study with a thousand answers has 0.1 MiB.
LARGEST_FILE = 16 * 2**20
MOST_STARTS = 10_000

# The schema: kinds by key. None marks a table whose keys the user chooses.
PARAMETER: dict[str, Kind] = {
    "value": as_number,
    "lower": as_number,
    "upper": as_number,
    "scale": as_choice("log", "linear"),
    "prior": as_pair,
}
LIMIT: dict[str, Kind] = {"lower": as_numbers, "upper": as_numbers}
TUNE: dict[str, Kind] = {
    "minimize": as_text,
    "maximize": as_text,
    "starts": as_whole(1, MOST_STARTS),
    "seed": as_whole(0),
    "tolerance": as_positive,
    "max_evaluations": as_whole(),
    "samples": as_whole(8, MOST),
}
DESIGNS = {"grid": ("points",), "latin-hypercube": ("samples", "seed"), "monte-carlo": ("samples", "seed")}
SWEEP: dict[str, Kind] = {
    "kind": as_choice(*DESIGNS),
    "points": lambda key, value: value if isinstance(value, dict) else as_whole(1, MOST)(key, value),
    "samples": as_whole(1, MOST),
    "seed": as_whole(0, MOST),
    "chunk": as_whole(1, MOST),
}
ROBUSTNESS: dict[str, Kind] = {
    "samples": as_whole(2, MOST),
    "seed": as_whole(0),
    "level": as_share,
    "chunk": as_whole(1, MOST),
    "percentiles": as_percentiles,
}
FIT: dict[str, Kind] = {
    "loss": as_choice("linear", "huber", "soft_l1", "cauchy"),
    "starts": as_whole(1, MOST_STARTS),
    "seed": as_whole(0),
    "max_evaluations": as_whole(),
    "level": as_positive,
}
TABLES = {
    "model": as_text,
    "release": as_text,
    "parameters": None,
    "choices": None,
    "answers": None,
    "targets": None,
    "limits": None,
    "equal": None,
    "tune": TUNE,
    "sweep": SWEEP,
    "scatter": None,
    "correlation": None,
    "acceptable": None,
    "robustness": ROBUSTNESS,
    "data": None,
    "fit": FIT,
}
# Kinds of the arguments of a question.
PARTS: dict[str, Kind] = {
    "number": as_whole(),
    "component": as_whole(),
    "node": as_node,
    "element": as_text,
    "axis": as_text,
}


def kinds() -> dict[str, Question]:
    """Return the questions that a study may ask, by their key in a table."""
    asked = {q.name.replace(" ", "_") or "coordinate": q for q in questions().values() if q.differentiable}
    return {**asked, "load_multiplier": asked["multiplier"]}


def read_study(path: str | os.PathLike) -> Study:
    """Read a design study; a StudyError names file and key."""
    return StudyReader(Path(path)).study()


def parameters_in(path: str | os.PathLike) -> tuple[str, dict[str, tuple[float, ...]], list[str]]:
    """Return model, parameters and functions of a study without calling any function."""
    reader = StudyReader(Path(path))
    with reader.named():
        model = as_text("model", reader.data.get("model", ""))
        given = {} if not isinstance(reader.data.get("parameters", {}), dict) else reader.parameters()
    found = {name: tuple(own[key] for key in ("value", "lower", "upper") if key in own) for name, own in given.items()}
    choices = reader.data.get("choices", {})
    for name, values in choices.items() if isinstance(choices, dict) else ():
        first = values[0] if isinstance(values, list) and values else None
        if isinstance(first, int | float) and not isinstance(first, bool):
            found.setdefault(name, (float(first),))
    answers = reader.data.get("answers", {})
    named = [model, *(answers.values() if isinstance(answers, dict) else ())]
    functions = [text for text in named if isinstance(text, str) and ":" in text and not text.endswith(".dat")]
    return model, found, functions


class StudyReader:
    """Reader of one file."""

    def __init__(self, path: Path):
        self.path, self.name = path, clean(path.name)
        try:
            content = read_whole(path, LARGEST_FILE)
        except OSError as fault:
            if fault.errno != errno.EFBIG:
                raise
            raise StudyError(f"{self.name}: the file is too large. A study has at most {LARGEST_FILE} bytes.") from None
        try:
            self.data: dict[str, Any] = tomllib.loads(content.decode("utf-8-sig"))
        except (ValueError, RecursionError) as fault:
            raise StudyError(f"{self.name}: {clean(fault)}") from None

    @contextlib.contextmanager
    def named(self) -> Iterator[None]:
        """Put the name of the file before messages about its keys."""
        try:
            yield
        except StudyError as fault:
            raise StudyError(f"{self.name}: {fault}") from fault.__cause__

    def study(self) -> Study:
        """Return the study of a sweep or a search."""
        with self.named():
            self.check_tables("model", "answers")
            parameters = self.parameters()
            free = {name: given for name, given in parameters.items() if "lower" in given}
            fixed = tuple((name, given["value"]) for name, given in parameters.items() if name not in free)
            answers = {name: self.answer(name, given) for name, given in self.data["answers"].items()}
            choices = self.choices(tuple(parameters))
            taken = (YIELD,) if self.data.get("acceptable") else ()
            try:
                check_names((*parameters, *choices), tuple(answers), taken)
            except ValueError as fault:
                raise StudyError(f"[answers] {fault}") from None
            values = {name: given["value"] for name, given in parameters.items()}
            made = self.scatter(values, tuple(free), choices)
            scattered = () if made is None else tuple(made.nominal)
            rest = tuple(pair for pair in fixed if pair[0] not in scattered)
            build = self.builder(fixed, (*free, *choices))
            return Study(
                self.name,
                build,
                answers,
                {name: given["value"] for name, given in free.items()},
                {name: (given["lower"], given["upper"]) for name, given in free.items()},
                {name: given["scale"] for name, given in free.items() if "scale" in given},
                self.wanted(tuple(answers)),
                self.plan(tuple(free)),
                choices,
                build if made is None else self.builder(rest, (*free, *scattered, *choices)),
                made,
                self.limits("acceptable", tuple(answers)),
                self.data.get("robustness", {}),
            )

    def check_tables(self, *needed: str) -> None:
        """Check the kinds of all tables, and that no needed table is missing or empty."""
        for table, content in self.data.items():
            if table not in TABLES:
                near = difflib.get_close_matches(table, TABLES, 1) if len(table) < 100 else []
                hint = f" Did you mean '{near[0]}'?" if near else f" Known: {', '.join(TABLES)}."
                raise StudyError(f"there is no key '{clean(table)}'.{hint}")
            schema = TABLES[table]
            if callable(schema):
                schema(table, content)
            elif not isinstance(content, dict):
                raise StudyError(f"[{table}] must be a table, but is {clean(repr(content))}.")
            elif schema:
                checked_table(f"[{table}]", content, schema, " ")
        for table in needed:
            if not self.data.get(table):
                raise StudyError(f"'{table}' is missing or empty.")

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return the value of each parameter, with its bounds, scale and prior if given."""
        found = {}
        for name, given in self.data.get("parameters", {}).items():
            key = _key_of_name("parameters", name, "parameter")
            entry = checked_table(key, given if isinstance(given, dict) else {"value": given}, PARAMETER)
            if "value" not in entry or ("lower" in entry) is not ("upper" in entry):
                raise StudyError(f"{key}: give value, or value with lower and upper.")
            if "lower" in entry and not entry["lower"] < entry["upper"]:
                raise StudyError(f"{key}: lower {entry['lower']:g} is not below upper {entry['upper']:g}.")
            for option in ("scale", "prior"):
                if option in entry and "lower" not in entry:
                    raise StudyError(f"{key}: a {option} needs lower and upper.")
            if entry.get("scale") == "log" and not entry["lower"] > 0:
                raise StudyError(f"{key}: scale cannot be log, since lower {entry['lower']:g} is not positive.")
            found[name] = entry
        return found

    def choices(self, parameters: tuple[str, ...]) -> dict[str, list[Any]]:
        """Return the values of each choice by name."""
        found = {}
        for name, given in self.data.get("choices", {}).items():
            key = _key_of_name("choices", name, "choice")
            if name in parameters:
                raise StudyError(f"{key}: it is a parameter too. Leave one of them out.")
            if not isinstance(given, list) or not given:
                raise StudyError(f"{key} must be a list of values, but is {clean(repr(given))}.")
            if not _is_function(self.data["model"]):
                given = [as_number(key, value) for value in given]
            elif not all(isinstance(value, bool | int | float | str) for value in given):
                what = "a list of numbers, words, true and false"
                raise StudyError(f"{key} must be {what}, but is {clean(repr(given))}.")
            found[name] = given
        return found

    def scatter(self, values: dict[str, float], free: tuple[str, ...], choices: Mapping[str, Any]) -> Scatter | None:
        """Return the scatter of made mechanisms; None without [scatter]."""
        given = self.data.get("scatter", {})
        if not given:
            for table in ("correlation", "acceptable", "robustness"):
                if table in self.data:
                    raise StudyError(f"[{table}] is about made mechanisms. It needs [scatter].")
            return None
        for name in given:
            if name in choices:
                raise StudyError(f"[scatter] {clean(name)}: a choice has no scatter. Give one value as a parameter.")
        for percent in self.data.get("robustness", {}).get("percentiles", ()):
            check_samples(f"[robustness] percentiles: {percent:g} %", "robustness", percent, self.data, SAMPLES)
        return scatter_of(given, self.data.get("correlation", {}), values, free)

    def builder(self, fixed: tuple[tuple[str, float], ...], free: tuple[str, ...]) -> Callable[..., Any]:
        """Return the function from the free parameters to the model."""
        text, release, folder = self.data["model"], self.data.get("release"), self.path.parent
        about = f"{self.name}: model"
        if _is_function(text):
            if release is not None:
                raise StudyError(
                    f"release is for a model in a file. Release inside the function '{clean(text)}' instead."
                )
            function = function_of("model", folder, text)
            try:
                check_dimensions(function, tuple(name for name, _ in fixed) + free)
            except ValueError as fault:
                raise StudyError(f"[parameters]: {fault}") from None
            return Called(about, text, function, fixed)
        release = as_choice("none", "auto")("release", "none" if release is None else release)
        source = folder / text
        try:
            content = content_of(source)
        except (FileNotFoundError, NotADirectoryError):
            what = f"there is no file '{clean(source)}', and '{clean(text)}' is no module:function"
            raise StudyError(f"model: {what}.") from None
        except (OSError, ValueError) as fault:
            why = getattr(fault, "strerror", None) or fault
            raise StudyError(f"model: cannot read '{clean(source)}': {clean(why)}.") from None
        return FromFile(self.name, source, content, release, fixed, free)

    def answer(self, name: str, given: Any) -> Callable[[Any], Any]:
        """Return the function of the model for an entry of [answers]."""
        key = f"[answers] {clean(name)}"
        about = f"{self.name}: {key}"
        if isinstance(given, str) and ":" in given:
            return Called(about, given, function_of(key, self.path.parent, given), is_answer=True)
        if isinstance(given, str):
            with contextlib.suppress(KeyError):
                if Asked(given).question.differentiable:
                    return NamedAnswer(about, Asked(given))
            what = f"module:function, such as 'own:stage' beside the study, or a question ({', '.join(kinds())})"
            raise StudyError(f"{key} must be {what}, not '{clean(given)}'.")
        kind = next((k for k in kinds() if isinstance(given, dict) and k in given), None)
        if kind is None:
            raise StudyError(f"{key} must be 'module:function' or a table with one of {', '.join(kinds())}.")
        return NamedAnswer(about, Asked(_text_of_question(key, kind, given)))

    def wanted(self, answers: tuple[str, ...]) -> dict[str, Any]:
        """Return the arguments of tune."""
        found: dict[str, Any] = {}
        for table in ("targets", "equal"):
            found[table] = {}
            for name, value in self.data.get(table, {}).items():
                self._check_wanted(f"[{table}]", name, answers)
                found[table][name] = as_numbers(f"[{table}] {clean(name)}", value)
        found["limits"] = self.limits("limits", answers)
        options = self.data.get("tune", {})
        for sense in ("minimize", "maximize"):
            if sense in options:
                self._check_wanted(f"[tune] {sense}", options[sense], answers)
        if "samples" in options and not self.data.get("scatter"):
            raise StudyError("[tune] samples is about made mechanisms. It needs [scatter].")
        return {**found, **options}

    def limits(self, table: str, answers: tuple[str, ...]) -> dict[str, tuple[Any, Any]]:
        """Return the lower and upper limits of a table; statistics have limits too, but are not acceptable or not."""
        found = {}
        for name, given in self.data.get(table, {}).items():
            key = f"[{table}] {clean(name)}"
            if table == "limits":
                self._check_wanted("[limits]", name, answers)
            else:
                _check_answer(f"[{table}]", name, answers)
            if not isinstance(given, dict) or not given:
                raise StudyError(f"{key} must be a table with lower, upper or both.")
            pair = checked_table(key, given, LIMIT)
            lower, upper = found[name] = pair.get("lower"), pair.get("upper")
            if lower is not None and upper is not None and not _below(lower, upper):
                raise StudyError(f"{key}: lower {clean(lower)} is not below upper {clean(upper)}.")
        return found

    def _check_wanted(self, key: str, name: str, answers: tuple[str, ...]) -> None:
        """Refuse a name that is neither an answer nor a statistic of made mechanisms."""
        if not check_statistic(key, name, answers, self.data):
            _check_answer(key, name, answers)

    def plan(self, free: tuple[str, ...]) -> dict[str, Any]:
        """Return the options of the sweep."""
        given = dict(self.data.get("sweep", {}))
        kind = given.get("kind", "grid")
        for option in given:
            if option not in ("kind", "chunk", *DESIGNS[kind]):
                raise StudyError(f"[sweep] {option} has no meaning if kind is {kind}. Give {DESIGNS[kind][0]}.")
        if isinstance(points := given.get("points"), dict):
            checked_table("[sweep] points", points, dict.fromkeys(free, as_whole(1, MOST)))
            if missing := [name for name in free if name not in points]:
                raise StudyError(
                    f"[sweep] points: '{missing[0]}' is missing. Every parameter with bounds needs points."
                )
        return given


def _is_function(model: str) -> bool:
    """Return whether the model of a study is a function."""
    return ":" in model and not model.endswith(".dat")


def _key_of_name(table: str, name: str, what: str) -> str:
    key = f"[{table}] {clean(name)}"
    if not name.isidentifier() or name == "pi":
        raise StudyError(f"{key}: a {what}'s name has letters, digits and _ alone, and is not pi.")
    return key


def _below(lower: Any, upper: Any) -> bool:
    """Return whether numbers or arrays are below others; arrays of different lengths are not."""
    try:
        return bool(np.all(np.less(lower, upper)))
    except ValueError:
        return False


def _check_answer(key: str, name: str, answers: tuple[str, ...]) -> None:
    if name not in answers:
        known = clean(", ".join(answers))
        raise StudyError(f"{key}: There is no answer '{clean(name)}'. Answers are: {known}.")


def _text_of_question(key: str, kind: str, given: Mapping[str, Any]) -> str:
    """Return the text of a question in a table: { stiffness = "top", axis = "y" } is "stiffness top.y"."""
    question, value = kinds()[kind], given[kind]
    takes = question.takes
    if takes and takes[0].endswith("?") and isinstance(value, bool):
        takes = ()
    if not takes and value is not True:
        raise StudyError(f"{key}: {kind} must be true, but is {clean(repr(value))}. Leave the answer out.")
    names = [kind, *takes[1:]]
    if strangers := sorted(set(given) - set(names)):
        raise StudyError(f"{key}: {kind} does not take {clean(', '.join(strangers))}.")
    if missing := sorted(set(names) - set(given)):
        raise StudyError(f"{key}: {kind} needs {', '.join(missing)}.")
    parts = zip(names, takes, strict=False)
    rest = [PARTS[part.removesuffix("?")](f"{key}: {name}", given[name]) for name, part in parts]
    return f"{question.name} {'.'.join(map(str, rest))}".strip()
