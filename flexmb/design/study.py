"""A design study in a TOML file: a model with named parameters, answers, and what is wanted of them."""

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..errors import ModelError, SpacarError, StudyError, first_line
from ..results import RESULTS
from .designs import MOST, Designs, grid, latin_hypercube, monte_carlo
from .evaluate import build_once, flat_function, layout_of
from .study_parts import UNTRACEABLE, RaisedError
from .sweep import sweep
from .swept import ROWS, Sweep
from .tune import tune
from .tuned import Tuned


@dataclasses.dataclass(frozen=True)
class Study:
    """What a file says.

    Attributes:
        name: Of the file.
        build: Function of the parameters that returns a model.
        answers: Functions of the model by name.
        values: Of the parameters with bounds, by name.
        bounds: Lower and upper value of each.
        scales: "log" or "linear" by name, where given; otherwise a sweep is linear, and a search as it sees fit.
        wanted: Targets, limits and equal, and the options of tune.
        plan: Options of sweep.
        choices: Values to choose from, by name.
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
        """What was read of the input file without effect, as far as it has been read."""
        return list(getattr(self.build, "warnings", ()))

    def tune(self, **options: Any) -> Tuned:
        """Run :func:`flexmb.tune` on it.

        Raises:
            StudyError: The file asks for what cannot be, with file and key.
            ModelError, AnalysisError: As :func:`flexmb.tune` raises.
        """
        wanted: Any = {"choices": self.choices, **self.wanted, **options}
        scales: Any = self.scales
        with self._named():
            try:
                bounds = {} if self.choices and not self.bounds else self._bounded()
                return tune(self.build, self.answers, self.values, bounds, scales=scales, **wanted)
            except UNTRACEABLE as fault:
                raise StudyError(f"{self.name}: {UNTRACED}: {first_line(fault)}") from fault

    def sweep(self, **options: Any) -> Sweep:
        """Run :func:`flexmb.sweep` on it, compiled where the model and the answers allow it.

        Raises:
            StudyError: The file asks for what cannot be, with file and key.
            ModelError: Not one design can be built.
        """
        if self.choices:
            raise StudyError(
                f"{self.name}: [choices]: a sweep makes none. Give one value of each under [parameters], or tune."
            )
        with self._named():
            designs = self.designs()
            if "chunk" in self.plan:
                options = {"chunk": self.plan["chunk"], **options}
            if "compiled" in options:
                return sweep(self.build, self.answers, designs, **options)
            # A checkpoint says whether its numbers were compiled, so that this must be known before.
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
            # The values that a search would start from need not be a design of the sweep.
            return True
        return True

    def designs(self) -> Designs:
        """The designs that [sweep] asks for; parameters without bounds keep their value.

        Along a parameter whose scale is "log" they are spaced, or drawn, evenly in its logarithm.

        Raises:
            StudyError: There is no parameter with bounds, or there are too many designs.
        """
        plan, bounds = self.plan, self._bounded()
        with self._named("[sweep]"):
            if plan.get("kind", "grid") == "grid":
                points = plan.get("points", 11)
                counts = {n: points[n] if isinstance(points, dict) else points for n in bounds}
                if math.prod(counts.values()) > MOST:
                    raise ValueError(f"points: there are {math.prod(counts.values()):.3g} designs, at most {MOST:g}.")
                spaced = {n: np.geomspace if self.scales.get(n) == "log" else np.linspace for n in bounds}
                return grid({n: spaced[n](*bounds[n], counts[n]) for n in bounds})
            make = {"latin-hypercube": latin_hypercube, "monte-carlo": monte_carlo}[plan["kind"]]
            evenly = {n: np.log(own) if self.scales.get(n) == "log" else own for n, own in bounds.items()}
            found = make(plan.get("samples", 100), evenly, seed=plan.get("seed", 0))
            for n in found.keys() & (n for n, scale in self.scales.items() if scale == "log"):
                found[n] = np.clip(np.exp(found[n]), *bounds[n])
            return found

    def _bounded(self) -> dict[str, tuple[float, float]]:
        if not self.bounds:
            raise StudyError(f"{self.name}: [parameters]: give at least one lower and upper.")
        return self.bounds

    @contextlib.contextmanager
    def _named(self, key: str = "") -> Iterator[None]:
        """Put the file's name before faults of what it asks for."""
        try:
            yield
        except (StudyError, SpacarError, ModelError):
            raise
        except ValueError as fault:
            raise StudyError(f"{self.name}: {key + ' ' if key else ''}{first_line(fault)}") from fault


UNTRACED = "tune needs derivatives, and the model or an answer cannot be traced by JAX"


def sweep_answer(study: Study, found: Sweep, version: str) -> dict[str, Any]:
    """Keys and values of a sweep for JSON."""
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
    """Keys and values of a tuned design for JSON."""
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
                "choices": one.choices,
                "status": one.result.name,
                "reason": one.reason,
                "objective": one.tuned and one.tuned.objective,
                "violation": one.tuned and one.tuned.violation,
                "parameters": one.tuned and one.tuned.dimensions,
            }
            for one in found.combinations
        ],
    }


def sweep_table(found: Sweep) -> str:
    """Table of a sweep for the terminal, of so many rows at most as tables have."""
    return found.table() + (", see --json or --save" if len(found.codes) > ROWS else "")
