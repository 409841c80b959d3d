"""The TOML file of a design study: every key known and of its kind, or one error with file and key."""

import difflib
import errno
import math
import os
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import StudyError, clean
from ..files import read_whole
from .designs import MOST
from .evaluate import check_dimensions, check_names
from .study import Study
from .study_parts import KINDS, Called, FromFile, NamedAnswer, content_of, function_of

# Keys of the file, and of its tables where they are fixed.
TABLES: dict[str, tuple[str, ...] | None] = {
    "model": None,
    "release": None,
    "parameters": ("value", "lower", "upper", "scale"),
    "choices": None,
    "answers": None,
    "targets": None,
    "limits": ("lower", "upper"),
    "equal": None,
    "tune": ("minimize", "maximize", "starts", "seed", "tolerance", "max_evaluations"),
    "sweep": ("kind", "points", "samples", "seed", "chunk"),
}
DESIGNS = {"grid": ("points",), "latin-hypercube": ("samples", "seed"), "monte-carlo": ("samples", "seed")}
# A study of a thousand answers has 0.1 MiB.
LARGEST_FILE = 16 * 2**20
MOST_STARTS = 10_000


def read_study(path: str | os.PathLike) -> Study:
    """Read a study.

    Args:
        path: Of a TOML file; the model and functions it names are looked for beside it.

    Raises:
        StudyError: The file is wrong, with file and key.
        OSError: It cannot be read.
    """
    return _Reader(Path(path)).study()


def parameters_in(path: str | os.PathLike) -> tuple[str, dict[str, tuple[float, ...]], list[str]]:
    """What a study says of its parameters; its functions are neither looked for nor called.

    Args:
        path: Of a TOML file.

    Returns:
        The model as the study names it; value, or value and bounds, of each parameter, and of a choice the first; and
        the Python functions that the study names.

    Raises:
        StudyError: The file is wrong, with file and key.
        OSError: It cannot be read.
    """
    reader = _Reader(Path(path))
    model = reader.text("model", reader.data.get("model", ""))
    given = {} if not isinstance(reader.data.get("parameters", {}), dict) else reader.parameters()
    found = {name: tuple(own[key] for key in ("value", "lower", "upper") if key in own) for name, own in given.items()}
    choices = reader.data.get("choices", {})
    for name, values in choices.items() if isinstance(choices, dict) else ():
        first = values[0] if isinstance(values, list) and values else None
        if isinstance(first, int | float) and not isinstance(first, bool):
            found.setdefault(name, (float(first),))
    answers = reader.data.get("answers", {})
    named = [model, *(answers.values() if isinstance(answers, dict) else ())]
    functions = [one for one in named if isinstance(one, str) and ":" in one and not one.endswith(".dat")]
    return model, found, functions


class _Reader:
    """One file, and what its keys mean."""

    def __init__(self, path: Path):
        self.path, self.name = path, clean(path.name)
        try:
            content = read_whole(path, LARGEST_FILE)
        except OSError as fault:
            if fault.errno != errno.EFBIG:
                raise
            raise StudyError(f"{self.name}: the file has more than {LARGEST_FILE} bytes; a study is smaller.") from None
        try:
            self.data: dict[str, Any] = tomllib.loads(content.decode("utf-8-sig"))
        except (ValueError, RecursionError) as fault:
            raise StudyError(f"{self.name}: {clean(fault)}") from None

    def study(self) -> Study:
        self.check_keys()
        parameters = self.parameters()
        free = {name: given for name, given in parameters.items() if "lower" in given}
        fixed = tuple((name, given["value"]) for name, given in parameters.items() if name not in free)
        answers = {name: self.answer(name, given) for name, given in self.data["answers"].items()}
        choices = self.choices(tuple(parameters))
        try:
            check_names((*parameters, *choices), tuple(answers), ())
        except ValueError as fault:
            raise StudyError(f"{self.name}: [answers] {fault}") from None
        return Study(
            self.name,
            self.builder(fixed, (*free, *choices)),
            answers,
            {name: given["value"] for name, given in free.items()},
            {name: (given["lower"], given["upper"]) for name, given in free.items()},
            {name: given["scale"] for name, given in free.items() if "scale" in given},
            self.wanted(tuple(answers)),
            self.plan(tuple(free)),
            choices,
        )

    def fault(self, key: str, text: str) -> StudyError:
        return StudyError(f"{self.name}: {key}{text}")

    # -- tables ---------------------------------------------------------------------------------------------------

    def check_keys(self) -> None:
        for table, content in self.data.items():
            if table not in TABLES:
                near = difflib.get_close_matches(table, TABLES, 1) if len(table) < 100 else []
                hint = f" Did you mean '{near[0]}'?" if near else f" Known: {', '.join(TABLES)}."
                raise self.fault("", f"there is no key '{clean(table)}'.{hint}")
            if table in ("model", "release"):
                self.text(table, content)
            elif not isinstance(content, dict):
                raise self.fault(f"[{table}]", f" must be a table, but is {clean(repr(content))}.")
        for table in ("model", "answers"):
            if not self.data.get(table):
                raise self.fault("", f"'{table}' is missing or empty.")
        for table in ("tune", "sweep"):
            self.known(f"[{table}]", self.data.get(table, {}), TABLES[table] or ())

    def known(self, key: str, content: dict[str, Any], known: Iterable[str]) -> None:
        """Refuse keys that a table does not have."""
        for one in content:
            if one not in known:
                raise self.fault(key, f": there is no '{clean(one)}'. Known: {', '.join(known)}.")

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Value of each parameter, with bounds and scale where given."""
        found = {}
        for name, given in self.data.get("parameters", {}).items():
            key = f"[parameters] {clean(name)}"
            if not name.isidentifier() or name == "pi":
                raise self.fault(key, ": a parameter's name has letters, digits and _ alone, and is not pi.")
            given = given if isinstance(given, dict) else {"value": given}
            self.known(key, given, TABLES["parameters"] or ())
            own: dict[str, Any] = {n: self.number(f"{key}: {n}", v) for n, v in given.items() if n != "scale"}
            if "value" not in own or ("lower" in own) is not ("upper" in own):
                raise self.fault(key, ": give value, or value with lower and upper.")
            if "lower" in own and not own["lower"] < own["upper"]:
                raise self.fault(key, f": lower {own['lower']:g} is not below upper {own['upper']:g}.")
            if "scale" in given:
                own["scale"] = self.choice(f"{key}: scale", given["scale"], ("log", "linear"))
                if "lower" not in own:
                    raise self.fault(key, ": a scale belongs to a parameter with lower and upper.")
                if own["scale"] == "log" and not own["lower"] > 0:
                    raise self.fault(key, f": scale cannot be log, since lower {own['lower']:g} is not positive.")
            found[name] = own
        return found

    def choices(self, parameters: tuple[str, ...]) -> dict[str, list[Any]]:
        """Values to choose from, by name."""
        found = {}
        in_file = self.data["model"].endswith(".dat") or ":" not in self.data["model"]
        for name, given in self.data.get("choices", {}).items():
            key = f"[choices] {clean(name)}"
            if not name.isidentifier() or name == "pi":
                raise self.fault(key, ": a choice's name has letters, digits and _ alone, and is not pi.")
            if name in parameters:
                raise self.fault(key, ": it is a parameter too; leave one of them out.")
            if not isinstance(given, list) or not given:
                raise self.fault(key, f" must be a list of values, but is {clean(repr(given))}.")
            if in_file:
                given = [self.number(key, one) for one in given]
            elif not all(isinstance(one, bool | int | float | str) for one in given):
                raise self.fault(
                    key, f" must be a list of numbers, words, true and false, but is {clean(repr(given))}."
                )
            found[name] = given
        return found

    def builder(self, fixed: tuple[tuple[str, float], ...], free: tuple[str, ...]) -> Callable[..., Any]:
        """What builds the model."""
        text, release = self.data["model"], self.data.get("release")
        if ":" in text and not text.endswith(".dat"):
            if release is not None:
                raise self.fault("release", f" is for a model in a file; the function '{clean(text)}' releases itself.")
            function = function_of(f"{self.name}: model", self.path.parent, text)
            try:
                check_dimensions(function, tuple(name for name, _ in fixed) + free)
            except ValueError as fault:
                raise self.fault("[parameters]", f": {fault}") from None
            return Called(f"{self.name}: model", text, function, fixed)
        release = self.choice("release", "none" if release is None else release, ("none", "auto"))
        source = self.path.parent / text
        try:
            content = content_of(source)
        except (FileNotFoundError, NotADirectoryError):
            raise self.fault(
                "model", f": there is no file '{clean(source)}', and '{clean(text)}' is no module:function."
            ) from None
        except (OSError, ValueError) as fault:
            why = getattr(fault, "strerror", None) or fault
            raise self.fault("model", f": cannot read '{clean(source)}': {clean(why)}.") from None
        return FromFile(self.name, source, content, release, fixed, free)

    def answer(self, name: str, given: Any) -> Callable[[Any], Any]:
        """Function of the model that an entry of [answers] means."""
        key = f"[answers] {clean(name)}"
        if isinstance(given, str):
            function = function_of(f"{self.name}: {key}", self.path.parent, given)
            return Called(f"{self.name}: {key}", given, function, is_answer=True)
        kind = next((k for k in KINDS if isinstance(given, dict) and k in given), None)
        if kind is None:
            raise self.fault(key, f" must be 'module:function' or a table with one of {', '.join(KINDS)}.")
        strangers, missing = set(given) - {kind, *KINDS[kind]}, set(KINDS[kind]) - set(given)
        if strangers:
            raise self.fault(key, f": {kind} does not take {clean(', '.join(sorted(strangers)))}.")
        if missing:
            raise self.fault(key, f": {kind} needs {', '.join(sorted(missing))}.")
        value, more = given[kind], None
        if kind in ("frequency", "load_multiplier"):
            value = self.whole(f"{key}: {kind}", value)
        elif kind in ("mass", "stress", "utilisation"):
            if value is not True:
                raise self.fault(f"{key}: {kind}", f" must be true, but is {clean(repr(value))}: leave the answer out.")
        elif isinstance(value, bool) or not isinstance(value, str | int):
            raise self.fault(f"{key}: {kind}", f" must be the name of a node, but is {clean(repr(value))}.")
        if kind == "stiffness":
            more = self.text(f"{key}: axis", given["axis"])
        elif kind == "coordinate":
            more = self.whole(f"{key}: component", given["component"])
        return NamedAnswer(f"{self.name}: {key}", kind, value, more)

    def wanted(self, answers: tuple[str, ...]) -> dict[str, Any]:
        """Arguments of tune."""
        found: dict[str, Any] = {}
        for table in ("targets", "equal"):
            found[table] = {
                name: self.numbers(self.of_answer(table, name, answers), v)
                for name, v in self.data.get(table, {}).items()
            }
        found["limits"] = {}
        for name, given in self.data.get("limits", {}).items():
            key = self.of_answer("limits", name, answers)
            if not isinstance(given, dict) or not given:
                raise self.fault(key, " must be a table with lower, upper or both.")
            self.known(key, given, TABLES["limits"] or ())
            own = {n: self.numbers(f"{key}: {n}", v) for n, v in given.items()}
            found["limits"][name] = (own.get("lower"), own.get("upper"))
        for one, value in self.data.get("tune", {}).items():
            key = f"[tune] {one}"
            if one in ("minimize", "maximize"):
                if self.text(key, value) not in answers:
                    raise self.fault(f"{key}: ", _no_answer(value, answers))
            elif one == "tolerance":
                value = self.number(key, value)
                if value <= 0:
                    raise self.fault(key, f" must be positive, but is {value:g}.")
            else:
                least = 0 if one == "seed" else 1
                value = self.whole(key, value, least, MOST_STARTS if one == "starts" else math.inf)
            found[one] = value
        return found

    def of_answer(self, table: str, name: str, answers: tuple[str, ...]) -> str:
        """Key of an entry that an answer names."""
        if name not in answers:
            raise self.fault(f"[{table}]: ", _no_answer(name, answers))
        return f"[{table}] {clean(name)}"

    def plan(self, free: tuple[str, ...]) -> dict[str, Any]:
        """Options of the sweep."""
        given = dict(self.data.get("sweep", {}))
        kind = self.choice("[sweep] kind", given.get("kind", "grid"), tuple(DESIGNS))
        for one in given:
            if one not in ("kind", "chunk", *DESIGNS[kind]):
                raise self.fault(f"[sweep] {one}", f" has no meaning where kind is {kind}: give {DESIGNS[kind][0]}.")
            if one in ("samples", "seed", "chunk"):
                given[one] = self.whole(f"[sweep] {one}", given[one], 0 if one == "seed" else 1, MOST)
        points = given.get("points")
        if isinstance(points, dict):
            self.known("[sweep] points", points, free)
            if missing := [name for name in free if name not in points]:
                raise self.fault("[sweep] points", f": '{missing[0]}' is missing, a parameter with bounds.")
            given["points"] = {n: self.whole(f"[sweep] points: {n}", v, 1, MOST) for n, v in points.items()}
        elif points is not None:
            given["points"] = self.whole("[sweep] points", points, 1, MOST)
        return given

    # -- kinds of values --------------------------------------------------------------------------------------------

    def number(self, key: str, value: Any) -> float:
        """A finite number."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fault(key, f" must be a number, not {clean(repr(value))}.")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(key, f" must be a finite number, not {clean(repr(value))}.")
        return number

    def numbers(self, key: str, value: Any) -> Any:
        """A number, or lists of them."""
        if not isinstance(value, list):
            return self.number(key, value)
        entries = [self.numbers(key, one) for one in value]
        try:
            return np.array(entries, float)
        except ValueError:
            raise self.fault(key, " has lists of several lengths.") from None

    def whole(self, key: str, value: Any, least: int = 1, most: float = math.inf) -> int:
        """A whole number within limits."""
        if type(value) is not int or not least <= value <= most:
            to = f" to {most:g}" if most < math.inf else ""
            raise self.fault(key, f" must be a whole number from {least}{to}, but is {clean(repr(value))}.")
        return value

    def text(self, key: str, value: Any) -> str:
        """A printable text."""
        if not isinstance(value, str) or not value.isprintable():
            raise self.fault(key, f" must be a text of printable letters, but is {clean(repr(value))}.")
        return value

    def choice(self, key: str, value: Any, known: tuple[str, ...]) -> str:
        """One of some words."""
        if self.text(key, value) not in known:
            raise self.fault(key, f" must be {', '.join(known[:-1])} or {known[-1]}, not '{clean(value)}'.")
        return value


def _no_answer(name: str, answers: tuple[str, ...]) -> str:
    return f"There is no answer '{clean(name)}'. Answers are: {clean(', '.join(answers))}."
