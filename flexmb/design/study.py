"""A design study from a TOML file: model, parameters, answers, and options of sweep and tune."""

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..display import short
from ..errors import ModelError, SpacarError, StudyError
from ..results import RESULTS
from .designs import MOST, Designs, grid, latin_hypercube, monte_carlo
from .evaluate import Layout, build_once, flat_function, layout_of
from .problem import asked_names
from .robust import SHOWN, Robustness, robustness
from .scatter import Scatter
from .statistics import wanted_statistics
from .study_parts import UNTRACEABLE, RaisedError, naming_study
from .sweep import sweep
from .swept import ROWS, Sweep
from .tune import tune
from .tuned import Tuned


@dataclasses.dataclass(frozen=True)
class Study:
    """The contents of a study file.

    Attributes:
        name: Name of the file.
        build: Function of the parameters that returns a model.
        answers: Functions of the model by name.
        values: Values of the parameters with bounds, by name.
        bounds: Lower and upper value of these parameters, by name.
        scales: "log" or "linear" by name, if given. A sweep is linear by default.
        wanted: Targets, limits, equalities and options of tune.
        plan: Options of sweep.
        choices: List of values of each choice, by name.
        build_made: Function of the parameters with bounds and of all with scatter that returns a model.
        scatter: Scatter of made mechanisms, if given.
        acceptable: Lower and upper limit of answers of an acceptable mechanism, by name.
        robust: Options of robustness.
    """

    name: str
    build: Callable[..., Any]
    answers: dict[str, Callable[[Any], Any]]
    values: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    scales: dict[str, str]
    wanted: dict[str, Any]
    plan: dict[str, Any]
    choices: dict[str, list[Any]]
    build_made: Callable[..., Any]
    scatter: Scatter | None
    acceptable: dict[str, tuple[Any, Any]]
    robust: dict[str, Any]

    @property
    def warnings(self) -> list[str]:
        """Warnings that the reader of the input file has given."""
        builders = self.build, self.build_made
        return list(dict.fromkeys(text for builder in builders for text in getattr(builder, "warnings", ())))

    def tune(self, **options: Any) -> Tuned:
        """Run :func:`flexmb.tune`; a StudyError names the file."""
        arguments: Any = {"choices": self.choices, **self.wanted, **options}
        scales: Any = self.scales
        # A search for nominal values alone needs no made mechanisms.
        build = self.build
        statistics = any(wanted_statistics(asked_names(arguments), self.answers))
        if self.scatter is not None and (self.acceptable or statistics):
            build = self.build_made
            arguments = {"scatter": self.scatter, "acceptable": self.acceptable, **arguments}
        with naming_study(f"{self.name}: ", UNTRACED):
            bounds = {} if self.choices and not self.bounds else self._bounded()
            return tune(build, self.answers, self.values, bounds, scales=scales, **arguments)

    def sweep(self, **options: Any) -> Sweep:
        """Run :func:`flexmb.sweep`, compiled if JAX can trace the model and the answers."""
        if self.choices:
            raise StudyError(
                f"{self.name}: [choices]: a sweep has no choices. Give one value of each as a parameter, or use tune."
            )
        with naming_study(f"{self.name}: "):
            designs = self.designs()
            if "chunk" in self.plan:
                options = {"chunk": self.plan["chunk"], **options}
            if "compiled" in options:
                return sweep(self.build, self.answers, designs, **options)
            # A checkpoint depends on whether its numbers were compiled.
            if options.get("checkpoint") is not None and not self._is_traceable():
                return sweep(self.build, self.answers, designs, compiled=False, **options)
            try:
                return sweep(self.build, self.answers, designs, **options)
            except (RaisedError, *UNTRACEABLE):
                return sweep(self.build, self.answers, designs, compiled=False, **options)

    def robustness(self, **options: Any) -> Robustness:
        """Run :func:`flexmb.design.robustness` about the values of the parameters.

        Without [acceptable], mechanisms within [limits] are acceptable.
        """
        if self.scatter is None:
            raise StudyError(f"{self.name}: '[scatter]' is missing or empty.")
        if self.choices:
            raise StudyError(f"{self.name}: [choices]: robustness has none. Give one value of each as a parameter.")
        limits = self.acceptable or {n: pair for n, pair in self.wanted["limits"].items() if n in self.answers}
        settings = {name: value for name, value in self.robust.items() if name != "percentiles"}
        with naming_study(f"{self.name}: ", UNTRACED_MADE):
            return robustness(
                self.build_made, self.answers, self.values, self.scatter, limits=limits, **{**settings, **options}
            )

    def _is_traceable(self) -> bool:
        try:
            models = build_once(self.build, self.values)
            flat_function(self.build, self.answers, layout_of(self.values), models)
        except (RaisedError, *UNTRACEABLE):
            return False
        except (ModelError, SpacarError):
            # The start of a search need not be a design of the sweep.
            return True
        return True

    def designs(self) -> Designs:
        """Return the designs of [sweep], evenly spaced in the logarithm of parameters with scale "log"."""
        plan, bounds = self.plan, self._bounded()
        with naming_study(f"{self.name}: [sweep] "):
            if plan.get("kind", "grid") == "grid":
                points = plan.get("points", 11)
                counts = {n: points[n] if isinstance(points, dict) else points for n in bounds}
                if math.prod(counts.values()) > MOST:
                    raise ValueError(f"points: there are {math.prod(counts.values()):.3g} designs, at most {MOST:g}.")
                spaced = {n: np.geomspace if self.scales.get(n) == "log" else np.linspace for n in bounds}
                return grid({n: spaced[n](*bounds[n], counts[n]) for n in bounds})
            make = {"latin-hypercube": latin_hypercube, "monte-carlo": monte_carlo}[plan["kind"]]
            evenly = {n: np.log(ends) if self.scales.get(n) == "log" else ends for n, ends in bounds.items()}
            designs = make(plan.get("samples", 100), evenly, seed=plan.get("seed", 0))
            for n in designs.keys() & (n for n, scale in self.scales.items() if scale == "log"):
                designs[n] = np.clip(np.exp(designs[n]), *bounds[n])
            return designs

    def _bounded(self) -> dict[str, tuple[float, float]]:
        if not self.bounds:
            raise StudyError(f"{self.name}: [parameters]: give at least one lower and upper.")
        return self.bounds


UNTRACED_MADE = "robustness compiles, and the model or an answer cannot be traced by JAX"
UNTRACED = "tune needs derivatives, and the model or an answer cannot be traced by JAX"


def answer_head(study: Any, version: str, result: RESULTS = RESULTS.successful, message: str = "") -> dict[str, Any]:
    """Return the first keys of an answer for JSON; the result of a failed search gives status and message."""
    status = "ok"
    if result != RESULTS.successful:
        status, message = result.name, result.message
    return {"study": study.name, "flexmb": version, "status": status, "message": message, "warnings": study.warnings}


def fields_of(found: Any, names: str) -> dict[str, Any]:
    """Return attributes of a result under their names."""
    return {name: getattr(found, name) for name in names.split()}


def sweep_answer(study: Study, found: Sweep, version: str) -> dict[str, Any]:
    """Return a sweep as data for JSON."""
    failures = found.failures()
    failed = sum(failures.values())
    message = ", ".join(f"{n} designs: {name}" for name, n in failures.items())
    return {
        **answer_head(study, version, message=message),
        "status": "ok" if failed < len(found.codes) else "failed",
        "axes": found.axes,
        "parameters": dict(found.designs),
        "answers": found.answers,
        "results": [RESULTS(int(code)).name for code in found.codes],
    }


def tune_answer(study: Study, found: Tuned, version: str) -> dict[str, Any]:
    """Return a tuned design as data for JSON."""
    return {
        **answer_head(study, version, found.result),
        **fields_of(found, "reason choices"),
        "parameters": found.dimensions,
        **fields_of(found, "answers start"),
        "active": list(found.active),
        **fields_of(found, "objective violation evaluations history"),
        "combinations": [
            {
                "choices": combination.choices,
                "status": combination.result.name,
                "reason": combination.reason,
                "objective": combination.tuned and combination.tuned.objective,
                "violation": combination.tuned and combination.tuned.violation,
                "parameters": combination.tuned and combination.tuned.dimensions,
            }
            for combination in found.combinations
        ],
    }


def robustness_answer(study: Study, found: Robustness, version: str) -> dict[str, Any]:
    """Return yield, percentiles and worst cases as data for JSON."""
    message = ", ".join(f"{n} mechanisms: {name}" for name, n in found.samples.failures().items())
    percents = study.robust.get("percentiles", SHOWN)
    answers = {}
    for name, nominal in found.nominal.items():
        layout = Layout((name,), (np.shape(nominal),))
        for label, value in zip(layout.labels, np.ravel(nominal), strict=True):
            low, high = found.worst(label)
            answers[label] = {
                "nominal": value,
                "mean": found.mean(label)._asdict(),
                "deviation": found.deviation(label),
                "percentiles": {f"{percent:g}": found.percentile(label, percent)._asdict() for percent in percents},
                "lowest": {"value": low[0], "parameters": low[1]},
                "highest": {"value": high[0], "parameters": high[1]},
            }
    return {
        **answer_head(study, version, message=message),
        "parameters": {**study.values, **(study.scatter.nominal if study.scatter else {})},
        "samples": len(found.samples.codes),
        "level": found.level,
        "limits": {name: list(pair) for name, pair in found.limits.items()},
        "yield": found.fraction._asdict() if found.limits else None,
        "yields": {name: share._asdict() for name, share in found.fractions.items()},
        "answers": answers,
    }


def robustness_table(found: Robustness, data: Mapping[str, Any]) -> str:
    """Return yield, and nominal value, deviation and percentiles of each answer, for the terminal."""
    lines = [found.summary().title]
    lines += [f"  {name}: {text}" for name, text in found.summary().rows.items() if name not in found.nominal]
    for label, entry in data["answers"].items():
        shares = ", ".join(
            f"{percent} % below {short(percentile['value'])}" for percent, percentile in entry["percentiles"].items()
        )
        lines.append(f"  {label}: {shares} (nominal {short(entry['nominal'])}, deviation {short(entry['deviation'])})")
    return "\n".join(lines)


def sweep_table(found: Sweep) -> str:
    """Return the table of a sweep for the terminal."""
    return found.table() + (", see --json or --save" if len(found.codes) > ROWS else "")
