"""A design study from a TOML file: model, parameters, answers, and options of sweep and tune."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import ModelError, SpacarError, StudyError
from ..results import RESULTS
from .designs import MOST, Designs, grid, latin_hypercube, monte_carlo
from .evaluate import build_once, flat_function, layout_of
from .study_parts import UNTRACEABLE, RaisedError, naming
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
    """

    name: str
    build: Callable[..., Any]
    answers: dict[str, Callable[[Any], Any]]
    values: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    scales: dict[str, str]
    wanted: dict[str, Any]
    plan: dict[str, Any]
    choices: dict[str, list[Any]] = dataclasses.field(default_factory=dict)

    @property
    def warnings(self) -> list[str]:
        """Warnings that the reader of the input file has given."""
        return list(getattr(self.build, "warnings", ()))

    def tune(self, **options: Any) -> Tuned:
        """Run :func:`flexmb.tune`; a StudyError names the file."""
        wanted: Any = {"choices": self.choices, **self.wanted, **options}
        scales: Any = self.scales
        with naming(f"{self.name}: ", UNTRACED):
            bounds = {} if self.choices and not self.bounds else self._bounded()
            return tune(self.build, self.answers, self.values, bounds, scales=scales, **wanted)

    def sweep(self, **options: Any) -> Sweep:
        """Run :func:`flexmb.sweep`, compiled if JAX can trace the model and the answers."""
        if self.choices:
            raise StudyError(
                f"{self.name}: [choices]: a sweep has no choices. Give one value of each as a parameter, or use tune."
            )
        with naming(f"{self.name}: "):
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
        with naming(f"{self.name}: [sweep] "):
            if plan.get("kind", "grid") == "grid":
                points = plan.get("points", 11)
                counts = {n: points[n] if isinstance(points, dict) else points for n in bounds}
                if math.prod(counts.values()) > MOST:
                    raise ValueError(f"points: there are {math.prod(counts.values()):.3g} designs, at most {MOST:g}.")
                spaced = {n: np.geomspace if self.scales.get(n) == "log" else np.linspace for n in bounds}
                return grid({n: spaced[n](*bounds[n], counts[n]) for n in bounds})
            make = {"latin-hypercube": latin_hypercube, "monte-carlo": monte_carlo}[plan["kind"]]
            evenly = {n: np.log(ends) if self.scales.get(n) == "log" else ends for n, ends in bounds.items()}
            found = make(plan.get("samples", 100), evenly, seed=plan.get("seed", 0))
            for n in found.keys() & (n for n, scale in self.scales.items() if scale == "log"):
                found[n] = np.clip(np.exp(found[n]), *bounds[n])
            return found

    def _bounded(self) -> dict[str, tuple[float, float]]:
        if not self.bounds:
            raise StudyError(f"{self.name}: [parameters]: give at least one lower and upper.")
        return self.bounds


UNTRACED = "tune needs derivatives, and the model or an answer cannot be traced by JAX"


def sweep_answer(study: Study, found: Sweep, version: str) -> dict[str, Any]:
    """Return a sweep as data for JSON."""
    failed = sum(found.failures().values())
    return {
        "study": study.name,
        "flexmb": version,
        "status": "ok" if failed < len(found.codes) else "failed",
        "message": ", ".join(f"{n} designs: {name}" for name, n in found.failures().items()),
        "warnings": study.warnings,
        "axes": found.axes,
        "parameters": dict(found.designs),
        "answers": found.answers,
        "results": [RESULTS(int(code)).name for code in found.codes],
    }


def tune_answer(study: Study, found: Tuned, version: str) -> dict[str, Any]:
    """Return a tuned design as data for JSON."""
    good = found.result.name == "successful"
    return {
        "study": study.name,
        "flexmb": version,
        "status": "ok" if good else found.result.name,
        "message": "" if good else found.result.message,
        "warnings": study.warnings,
        "reason": found.reason,
        "choices": found.choices,
        "parameters": found.dimensions,
        "answers": found.answers,
        "start": found.start,
        "active": list(found.active),
        "objective": found.objective,
        "violation": found.violation,
        "evaluations": found.evaluations,
        "history": found.history,
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


def sweep_table(found: Sweep) -> str:
    """Return the table of a sweep for the terminal."""
    return found.table() + (", see --json or --save" if len(found.codes) > ROWS else "")
