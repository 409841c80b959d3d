"""Reader of the TOML file of a study: it checks every key, and an error names file and key."""

import contextlib
import difflib
import errno
import hashlib
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import StudyError, printable
from ..files import read_whole
from ..questions.question import Asked, Question, questions
from .designs import MOST
from .evaluate import check_answer_names, check_dimensions
from .robust import SAMPLES
from .scatter import Scatter
from .statistics import YIELD
from .study import Study
from .study_parts import Called, FromFile, NamedAnswer, function_of
from .study_values import (
    Kind,
    as_choice,
    as_node,
    as_number,
    as_numbers,
    as_pair,
    as_percentiles,
    as_positive,
    as_share,
    as_text,
    check_samples,
    check_statistic,
    checked_table,
    naming_key,
    scatter_of,
    whole_kind,
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
    "starts": whole_kind(1, MOST_STARTS),
    "seed": whole_kind(0),
    "tolerance": as_positive,
    "max_evaluations": whole_kind(),
    "samples": whole_kind(8, MOST),
}
DESIGNS = {"grid": ("points",), "latin-hypercube": ("samples", "seed"), "monte-carlo": ("samples", "seed")}
SWEEP: dict[str, Kind] = {
    "kind": as_choice(*DESIGNS),
    "points": lambda key, value: value if isinstance(value, dict) else whole_kind(1, MOST)(key, value),
    "samples": whole_kind(1, MOST),
    "seed": whole_kind(0, MOST),
    "chunk": whole_kind(1, MOST),
}
ROBUSTNESS: dict[str, Kind] = {
    "samples": whole_kind(2, MOST),
    "seed": whole_kind(0),
    "level": as_share,
    "chunk": whole_kind(1, MOST),
    "percentiles": as_percentiles,
}
FIT: dict[str, Kind] = {
    "loss": as_choice("linear", "huber", "soft_l1", "cauchy"),
    "starts": whole_kind(1, MOST_STARTS),
    "seed": whole_kind(0),
    "max_evaluations": whole_kind(),
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
    "number": whole_kind(),
    "component": whole_kind(),
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
        entries = {} if not isinstance(reader.data.get("parameters", {}), dict) else reader.parameters()
    bounded_values = {
        name: tuple(entry[key] for key in ("value", "lower", "upper") if key in entry)
        for name, entry in entries.items()
    }
    choices = reader.data.get("choices", {})
    for name, values in choices.items() if isinstance(choices, dict) else ():
        first = values[0] if isinstance(values, list) and values else None
        if isinstance(first, int | float) and not isinstance(first, bool):
            bounded_values.setdefault(name, (float(first),))
    answers = reader.data.get("answers", {})
    named = [model, *(answers.values() if isinstance(answers, dict) else ())]
    functions = [text for text in named if isinstance(text, str) and is_function(text)]
    return model, bounded_values, functions


class StudyReader:
    """Reader of one file."""

    def __init__(self, path: Path):
        self.path, self.name = path, printable(path.name)
        try:
            content = read_whole(path, LARGEST_FILE)
        except OSError as fault:
            if fault.errno != errno.EFBIG:
                raise
            raise StudyError(f"{self.name}: the file is too large. A study has at most {LARGEST_FILE} bytes.") from None
        try:
            self.data: dict[str, Any] = tomllib.loads(content.decode("utf-8-sig"))
        except (ValueError, RecursionError) as fault:
            raise StudyError(f"{self.name}: {printable(fault)}") from None

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
            start, bounds, scales, _, fixed_values = self.searched(parameters)
            free, fixed = tuple(start), tuple(fixed_values.items())
            answers = {name: self.answer(name, entry) for name, entry in self.data["answers"].items()}
            choices = self.choices(tuple(parameters))
            taken = (YIELD,) if self.data.get("acceptable") else ()
            try:
                check_answer_names((*parameters, *choices), tuple(answers), taken)
            except ValueError as fault:
                raise StudyError(f"[answers] {fault}") from None
            values = {name: entry["value"] for name, entry in parameters.items()}
            scatter = self.scatter(values, free, choices)
            scattered = () if scatter is None else tuple(scatter.nominal)
            unscattered = tuple(pair for pair in fixed if pair[0] not in scattered)
            build = self.builder(fixed, (*free, *choices))
            return Study(
                self.name,
                build,
                answers,
                start,
                bounds,
                scales,
                self.wanted(tuple(answers)),
                self.plan(free),
                choices,
                build if scatter is None else self.builder(unscattered, (*free, *scattered, *choices)),
                scatter,
                self.limits("acceptable", tuple(answers)),
                self.data.get("robustness", {}),
            )

    def check_tables(self, *needed: str) -> None:
        """Check the kinds of all tables, and that no needed table is missing or empty."""
        for table, content in self.data.items():
            if table not in TABLES:
                similar = difflib.get_close_matches(table, TABLES, 1) if len(table) < 100 else []
                hint = f" Did you mean '{similar[0]}'?" if similar else f" Known: {', '.join(TABLES)}."
                raise StudyError(f"there is no key '{printable(table)}'.{hint}")
            schema = TABLES[table]
            if callable(schema):
                schema(table, content)
            elif not isinstance(content, dict):
                raise StudyError(f"[{table}] must be a table, but is {printable(repr(content))}.")
            elif schema:
                checked_table(f"[{table}]", content, schema, " ")
        for table in needed:
            if not self.data.get(table):
                raise StudyError(f"'{table}' is missing or empty.")

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return the value of each parameter, with its bounds, scale and prior if given."""
        entries = {}
        for name, value in self.data.get("parameters", {}).items():
            key = _key_of_name("parameters", name, "parameter")
            entry = checked_table(key, value if isinstance(value, dict) else {"value": value}, PARAMETER)
            if "value" not in entry or ("lower" in entry) is not ("upper" in entry):
                raise StudyError(f"{key}: give value, or value with lower and upper.")
            if "lower" in entry and not entry["lower"] < entry["upper"]:
                raise StudyError(f"{key}: lower {entry['lower']:g} is not below upper {entry['upper']:g}.")
            for option in ("scale", "prior"):
                if option in entry and "lower" not in entry:
                    raise StudyError(f"{key}: a {option} needs lower and upper.")
            if entry.get("scale") == "log" and not entry["lower"] > 0:
                raise StudyError(f"{key}: scale cannot be log, since lower {entry['lower']:g} is not positive.")
            entries[name] = entry
        return entries

    @staticmethod
    def searched(parameters: Mapping[str, Mapping[str, Any]]) -> tuple[dict[str, Any], ...]:
        """Return start, bounds, scale and prior of the parameters with bounds, and the values of the others."""
        free = {name: entry for name, entry in parameters.items() if "lower" in entry}
        start = {name: entry["value"] for name, entry in free.items()}
        bounds = {name: (entry["lower"], entry["upper"]) for name, entry in free.items()}
        scales, priors = ({n: e[key] for n, e in free.items() if key in e} for key in ("scale", "prior"))
        return start, bounds, scales, priors, {n: e["value"] for n, e in parameters.items() if n not in free}

    def choices(self, parameters: tuple[str, ...]) -> dict[str, list[Any]]:
        """Return the values of each choice by name."""
        choices = {}
        for name, values in self.data.get("choices", {}).items():
            key = _key_of_name("choices", name, "choice")
            if name in parameters:
                raise StudyError(f"{key}: it is a parameter too. Leave one of them out.")
            if not isinstance(values, list) or not values:
                raise StudyError(f"{key} must be a list of values, but is {printable(repr(values))}.")
            if not is_function(self.data["model"]):
                values = [as_number(key, value) for value in values]
            elif not all(isinstance(value, bool | int | float | str) for value in values):
                expected = "a list of numbers, words, true and false"
                raise StudyError(f"{key} must be {expected}, but is {printable(repr(values))}.")
            choices[name] = values
        return choices

    def scatter(self, values: dict[str, float], free: tuple[str, ...], choices: Mapping[str, Any]) -> Scatter | None:
        """Return the scatter of made mechanisms; None without [scatter]."""
        distributions = self.data.get("scatter", {})
        if not distributions:
            for table in ("correlation", "acceptable", "robustness"):
                if table in self.data:
                    raise StudyError(f"[{table}] is about made mechanisms. It needs [scatter].")
            return None
        for name in distributions:
            if name in choices:
                raise StudyError(
                    f"[scatter] {printable(name)}: a choice has no scatter. Give one value as a parameter."
                )
        for percent in self.data.get("robustness", {}).get("percentiles", ()):
            check_samples(f"[robustness] percentiles: {percent:g} %", "robustness", percent, self.data, SAMPLES)
        return scatter_of(distributions, self.data.get("correlation", {}), values, free)

    def builder(self, fixed: tuple[tuple[str, float], ...], free: tuple[str, ...]) -> Callable[..., Any]:
        """Return the function from the free parameters to the model."""
        text, release, folder = self.data["model"], self.data.get("release"), self.path.parent
        about = f"{self.name}: model"
        if is_function(text):
            if release is not None:
                raise StudyError(
                    f"release is for a model in a file. Release inside the function '{printable(text)}' instead."
                )
            function = function_of("model", folder, text)
            with naming_key("[parameters]"):
                check_dimensions(function, tuple(name for name, _ in fixed) + free)
            return Called(about, text, function, fixed)
        release = as_choice("none", "auto")("release", "none" if release is None else release)
        source = folder / text
        try:
            content = hashlib.sha256(read_whole(source)).hexdigest()
        except (FileNotFoundError, NotADirectoryError):
            problem = f"there is no file '{printable(source)}', and '{printable(text)}' is no module:function"
            raise StudyError(f"model: {problem}.") from None
        except (OSError, ValueError) as fault:
            why = getattr(fault, "strerror", None) or fault
            raise StudyError(f"model: cannot read '{printable(source)}': {printable(why)}.") from None
        return FromFile(self.name, source, content, release, fixed, free)

    def answer(self, name: str, given: Any) -> Callable[[Any], Any]:
        """Return the function of the model for an entry of [answers]."""
        key = f"[answers] {printable(name)}"
        about = f"{self.name}: {key}"
        if isinstance(given, str) and ":" in given:
            return Called(about, given, function_of(key, self.path.parent, given), is_answer=True)
        if isinstance(given, str):
            with contextlib.suppress(KeyError):
                if Asked(given).question.differentiable:
                    return NamedAnswer(about, Asked(given))
            expected = f"module:function, such as 'own:stage' beside the study, or a question ({', '.join(kinds())})"
            raise StudyError(f"{key} must be {expected}, not '{printable(given)}'.")
        kind = next((k for k in kinds() if isinstance(given, dict) and k in given), None)
        if kind is None:
            raise StudyError(f"{key} must be 'module:function' or a table with one of {', '.join(kinds())}.")
        return NamedAnswer(about, Asked(_text_of_question(key, kind, given)))

    def wanted(self, answers: tuple[str, ...]) -> dict[str, Any]:
        """Return the arguments of tune."""
        arguments: dict[str, Any] = {}
        for table in ("targets", "equal"):
            arguments[table] = {}
            for name, value in self.data.get(table, {}).items():
                self._check_wanted(f"[{table}]", name, answers)
                arguments[table][name] = as_numbers(f"[{table}] {printable(name)}", value)
        arguments["limits"] = self.limits("limits", answers)
        options = self.data.get("tune", {})
        for sense in ("minimize", "maximize"):
            if sense in options:
                self._check_wanted(f"[tune] {sense}", options[sense], answers)
        if "samples" in options and not self.data.get("scatter"):
            raise StudyError("[tune] samples is about made mechanisms. It needs [scatter].")
        return {**arguments, **options}

    def limits(self, table: str, answers: tuple[str, ...]) -> dict[str, tuple[Any, Any]]:
        """Return the lower and upper limits of a table; statistics have limits too, but are not acceptable or not."""
        limits = {}
        for name, entry in self.data.get(table, {}).items():
            key = f"[{table}] {printable(name)}"
            if table == "limits":
                self._check_wanted("[limits]", name, answers)
            else:
                _check_answer(f"[{table}]", name, answers)
            if not isinstance(entry, dict) or not entry:
                raise StudyError(f"{key} must be a table with lower, upper or both.")
            pair = checked_table(key, entry, LIMIT)
            lower, upper = limits[name] = pair.get("lower"), pair.get("upper")
            if lower is not None and upper is not None and not _below(lower, upper):
                raise StudyError(f"{key}: lower {printable(lower)} is not below upper {printable(upper)}.")
        return limits

    def _check_wanted(self, key: str, name: str, answers: tuple[str, ...]) -> None:
        """Refuse a name that is neither an answer nor a statistic of made mechanisms."""
        if not check_statistic(key, name, answers, self.data):
            _check_answer(key, name, answers)

    def plan(self, free: tuple[str, ...]) -> dict[str, Any]:
        """Return the options of the sweep."""
        options = dict(self.data.get("sweep", {}))
        kind = options.get("kind", "grid")
        for option in options:
            if option not in ("kind", "chunk", *DESIGNS[kind]):
                raise StudyError(f"[sweep] {option} has no meaning if kind is {kind}. Give {DESIGNS[kind][0]}.")
        if isinstance(points := options.get("points"), dict):
            checked_table("[sweep] points", points, dict.fromkeys(free, whole_kind(1, MOST)))
            if missing := [name for name in free if name not in points]:
                raise StudyError(
                    f"[sweep] points: '{missing[0]}' is missing. Every parameter with bounds needs points."
                )
        return options


def is_function(model: str) -> bool:
    """Return whether the model of a study is a function."""
    return ":" in model and not model.endswith(".dat")


def _key_of_name(table: str, name: str, kind: str) -> str:
    key = f"[{table}] {printable(name)}"
    if not name.isidentifier() or name == "pi":
        raise StudyError(f"{key}: a {kind}'s name has letters, digits and _ alone, and is not pi.")
    return key


def _below(lower: Any, upper: Any) -> bool:
    """Return whether numbers or arrays are below others; arrays of different lengths are not."""
    try:
        return bool(np.all(np.less(lower, upper)))
    except ValueError:
        return False


def _check_answer(key: str, name: str, answers: tuple[str, ...]) -> None:
    if name not in answers:
        known = printable(", ".join(answers))
        raise StudyError(f"{key}: There is no answer '{printable(name)}'. Answers are: {known}.")


def _text_of_question(key: str, kind: str, entry: Mapping[str, Any]) -> str:
    """Return the text of a question in a table: { stiffness = "top", axis = "y" } is "stiffness top.y"."""
    question, value = kinds()[kind], entry[kind]
    takes = question.takes
    if takes and takes[0].endswith("?") and isinstance(value, bool):
        takes = ()
    if not takes and value is not True:
        raise StudyError(f"{key}: {kind} must be true, but is {printable(repr(value))}. Leave the answer out.")
    names = [kind, *takes[1:]]
    if strangers := sorted(set(entry) - set(names)):
        raise StudyError(f"{key}: {kind} does not take {printable(', '.join(strangers))}.")
    if missing := sorted(set(names) - set(entry)):
        raise StudyError(f"{key}: {kind} needs {', '.join(missing)}.")
    parts = zip(names, takes, strict=False)
    arguments = [PARTS[part.removesuffix("?")](f"{key}: {name}", entry[name]) for name, part in parts]
    return f"{question.name} {'.'.join(map(str, arguments))}".strip()
