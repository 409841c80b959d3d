"""A design study in a TOML file: a model with named parameters, answers, and what is wanted of them."""

import dataclasses
import difflib
import importlib
import os
import sys
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..analysis.buckling import buckling_loads
from ..analysis.equilibrium import equilibrium
from ..analysis.modal import frequencies
from ..analysis.stress import stress
from ..io.spacar import read_spacar
from .designs import Designs, grid, latin_hypercube, monte_carlo
from .objectives import mass, stiffness
from .sweep import Sweep, sweep
from .tune import Tuned, tune


class StudyError(ValueError):
    """A study is described wrongly; the message names file and key."""


# What an answer may be, by the key that says so, and the other keys that it takes.
KINDS: dict[str, tuple[str, ...]] = {
    "frequency": (),
    "load_multiplier": (),
    "mass": (),
    "stiffness": ("axis",),
    "coordinate": ("component",),
    "stress": (),
}
TABLES = {
    "model": None,
    "release": None,
    "parameters": ("value", "lower", "upper", "scale"),
    "answers": None,
    "targets": None,
    "limits": ("lower", "upper"),
    "equal": None,
    "tune": ("minimize", "maximize", "starts", "seed", "tolerance", "max_evaluations"),
    "sweep": ("kind", "points", "samples", "seed", "chunk"),
}


@dataclasses.dataclass(frozen=True)
class Study:
    """What a file says.

    Attributes:
        name: Of the file.
        build: Function of the parameters that returns a model.
        answers: Functions of the model by name.
        values, bounds, scales: Of the parameters, by name.
        wanted: Targets, limits and equal, and the options of tune.
        plan: Options of sweep.
    """

    name: str
    build: Callable[..., Any]
    answers: dict[str, Callable[[Any], Any]]
    values: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    scales: dict[str, str]
    wanted: dict[str, Any]
    plan: dict[str, Any]

    def tune(self, **options: Any) -> Tuned:
        """Run :func:`flexmb.tune` on it.

        Args:
            options: Further arguments.
        """
        wanted: Any = {**self.wanted, **options}
        scales: Any = self.scales
        return tune(self.build, self.answers, self.values, self._bounded(), scales=scales, **wanted)

    def sweep(self, **options: Any) -> Sweep:
        """Run :func:`flexmb.sweep` on it, compiled where the model allows it.

        Args:
            options: Further arguments.
        """
        import jax

        designs = self.designs()
        try:
            return sweep(self.build, self.answers, designs, **options)
        except (jax.errors.ConcretizationTypeError, jax.errors.TracerArrayConversionError):
            return sweep(self.build, self.answers, designs, compiled=False, **options)

    def designs(self) -> Designs:
        """The designs that [sweep] asks for; parameters without bounds keep their value."""
        import numpy as np

        plan, bounds = self.plan, self._bounded()
        kind, seed = plan.get("kind", "grid"), int(plan.get("seed", 0))
        if kind == "grid":
            points = plan.get("points", 11)
            counts = {n: int(points[n] if isinstance(points, dict) else points) for n in bounds}
            return grid(**{n: np.linspace(*bounds[n], counts[n]) for n in bounds})
        makers = {"latin-hypercube": latin_hypercube, "monte-carlo": monte_carlo}
        if kind not in makers:
            raise StudyError(f"{self.name}: [sweep] kind must be grid, {' or '.join(makers)}, not '{kind}'.")
        spread: dict[str, Any] = dict(bounds)
        return makers[kind](int(plan.get("samples", 100)), seed=seed, **spread)

    def _bounded(self) -> dict[str, tuple[float, float]]:
        if not self.bounds:
            raise StudyError(f"{self.name}: [parameters]: give at least one lower and upper.")
        return self.bounds


def read_study(path: str | os.PathLike) -> Study:
    """Read a study.

    Args:
        path: Of a TOML file; the model and functions it names are looked for beside it.

    Raises:
        StudyError: The file is wrong, with file and key.
        OSError: It cannot be read.
    """
    path = Path(path)
    try:
        data = tomllib.loads(path.read_text())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as fault:
        raise StudyError(f"{path.name}: {fault}") from None
    _check_keys(path.name, data)
    parameters = {n: v if isinstance(v, dict) else {"value": v} for n, v in data.get("parameters", {}).items()}
    free = {}
    for name, given in parameters.items():
        for key in ("value", "lower", "upper"):
            if key in given and (isinstance(given[key], bool) or not isinstance(given[key], int | float)):
                raise StudyError(f"{path.name}: [parameters] {name}: {key} must be a number, not {given[key]!r}.")
        if "value" not in given or ("lower" in given) is not ("upper" in given):
            raise StudyError(f"{path.name}: [parameters] {name}: give value, or value with lower and upper.")
        if "lower" in given:
            free[name] = given
    fixed = {name: float(given["value"]) for name, given in parameters.items() if name not in free}
    limits = {name: (pair.get("lower"), pair.get("upper")) for name, pair in data.get("limits", {}).items()}
    wanted = {"targets": data.get("targets", {}), "limits": limits, "equal": data.get("equal", {})}
    return Study(
        path.name,
        _builder(path, data, fixed),
        {name: _answer(path, name, given) for name, given in data.get("answers", {}).items()},
        {name: float(given["value"]) for name, given in free.items()},
        {name: (float(given["lower"]), float(given["upper"])) for name, given in free.items()},
        {name: given["scale"] for name, given in free.items() if "scale" in given},
        {**wanted, **data.get("tune", {})},
        data.get("sweep", {}),
    )


def _check_keys(name: str, data: Mapping[str, Any]) -> None:
    for table, content in data.items():
        if table not in TABLES:
            near = difflib.get_close_matches(table, TABLES, 1)
            hint = f" Did you mean '{near[0]}'?" if near else f" Known: {', '.join(TABLES)}."
            raise StudyError(f"{name}: there is no key '{table}'.{hint}")
        if table not in ("model", "release") and not isinstance(content, dict):
            raise StudyError(f"{name}: [{table}] must be a table, but is {content!r}.")
        known = TABLES[table]
        rows = content.items() if table in ("parameters", "limits") else [(table, content)]
        for row, inner in rows if known else ():
            if table == "parameters" and not isinstance(inner, dict):
                continue
            if not isinstance(inner, dict):
                raise StudyError(f"{name}: [{table}] {row} must be a table with {', '.join(known or ())}.")
            for key in inner:
                if key not in (known or ()):
                    raise StudyError(f"{name}: [{table}] {row}: there is no '{key}'. Known: {', '.join(known or ())}.")
    for table in ("model", "answers"):
        if not data.get(table):
            raise StudyError(f"{name}: '{table}' is missing.")


def _builder(path: Path, data: Mapping[str, Any], fixed: dict[str, float]) -> Callable[..., Any]:
    model, release = str(data["model"]), data.get("release", "none")
    if ":" in model and not model.endswith(".dat"):
        function = _function(path, "model", model)
        return lambda **free: function(**fixed, **free)
    source = path.parent / model
    if not source.is_file():
        raise StudyError(f"{path.name}: model: there is no file '{source}', and '{model}' is no module:function.")
    if release not in ("none", "auto"):
        raise StudyError(f"{path.name}: release must be none or auto, not {release!r}.")
    return lambda **free: read_spacar(source, numbers={**fixed, **free}).builder.build(release=release)


def _function(path: Path, key: str, text: str) -> Callable[..., Any]:
    """A function named as module:function, the module beside the file or installed."""
    module, _, name = text.partition(":")
    folder = str(path.parent.resolve())
    sys.path.insert(0, folder)
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as fault:
        raise StudyError(f"{path.name}: {key}: cannot take '{text}': {fault}") from None
    finally:
        sys.path.remove(folder)
    return found


def _answer(path: Path, name: str, given: Any) -> Callable[[Any], Any]:
    """Function of the model that an entry of [answers] means."""
    about = f"{path.name}: [answers] {name}"
    if isinstance(given, str) and ":" in given:
        return _function(path, f"[answers] {name}", given)
    kind = next((k for k in KINDS if isinstance(given, dict) and k in given), None)
    if kind is None:
        raise StudyError(f"{about} must be 'module:function' or a table with one of {', '.join(KINDS)}.")
    strangers = set(given) - {kind, *KINDS[kind]}
    missing = set(KINDS[kind]) - set(given)
    if strangers or missing:
        wrong = f"does not take {', '.join(sorted(strangers))}" if strangers else f"needs {', '.join(sorted(missing))}"
        raise StudyError(f"{about}: {kind} {wrong}.")
    entry: Any = given
    value: Any = entry[kind]
    if kind in ("frequency", "load_multiplier") and not (type(value) is int and value >= 1):
        raise StudyError(f"{about}: {kind} must be a whole number from 1, but is {value!r}.")
    return {
        "frequency": lambda model: frequencies(model)[value - 1],
        "load_multiplier": lambda model: buckling_loads(model)[value - 1],
        "mass": mass,
        "stiffness": lambda model: stiffness(model, str(value), entry["axis"]),
        "coordinate": lambda model: equilibrium(model).at(str(value))[int(entry["component"]) - 1],
        "stress": lambda model: stress(model).maximum,
    }[kind]


def sweep_answer(study: Study, found: Sweep, version: str) -> dict[str, Any]:
    """Keys and values of a sweep for JSON.

    Args:
        study: The study.
        found: Its sweep.
        version: Of the program.
    """
    from ..results import RESULTS

    failed = sum(found.failures().values())
    return {
        "study": study.name,
        "flexmb": version,
        "status": "ok" if failed < len(found.codes) else "failed",
        "message": ", ".join(f"{n} designs: {name}" for name, n in found.failures().items()),
        "axes": found.axes,
        "parameters": dict(found.designs),
        "answers": found.answers,
        "results": [RESULTS(int(code)).name for code in found.codes],
    }


def tune_answer(study: Study, found: Tuned, version: str) -> dict[str, Any]:
    """Keys and values of a tuned design for JSON.

    Args:
        study: The study.
        found: Its design.
        version: Of the program.
    """
    good = found.result.name == "successful"
    return {
        "study": study.name,
        "flexmb": version,
        "status": "ok" if good else found.result.name,
        "message": "" if good else found.result.message,
        "reason": found.reason,
        "parameters": found.dimensions,
        "answers": found.answers,
        "start": found.start,
        "active": list(found.active),
        "objective": found.objective,
        "violation": found.violation,
        "evaluations": found.evaluations,
        "history": found.history,
    }


def sweep_table(found: Sweep, shown: int = 20) -> str:
    """Table of a sweep for the terminal.

    Args:
        found: The sweep.
        shown: Rows at most.
    """
    from ..results import RESULTS

    names = [*found.designs, *(name for name, v in found.answers.items() if v.ndim == 1)]
    lines = ["".join(f"{name:>16}" for name in names) + "  result"]
    columns = [{**found.designs, **found.answers}[name] for name in names]
    for i, code in enumerate(found.codes[:shown]):
        lines.append("".join(f"{column[i]:>16.7g}" for column in columns) + f"  {RESULTS(int(code)).name}")
    if len(found.codes) > shown:
        lines.append(f"... {len(found.codes) - shown} more designs, see --json or --save")
    return "\n".join(lines)
