"""A design that a search found, and what became of every combination of choices."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from ..display import Result, Summary
from ..results import RESULTS
from .curve import Curve

# Bounds and limits that are reached: so many are printed.
SHOWN = 8


class Combination(NamedTuple):
    """One combination of choices.

    Attributes:
        choices: Values by name.
        labels: How they are written, by name.
        tuned: The best design with them; None where the search could not begin.
        result: Code of RESULTS: of the search, or of why it could not begin.
        reason: In words.
    """

    choices: dict[str, Any]
    labels: dict[str, str]
    tuned: "Tuned | None"
    result: RESULTS
    reason: str


@dataclasses.dataclass(frozen=True, repr=False)
class Tuned(Result):
    """A design that was found.

    Attributes:
        dimensions: By name [SI].
        answers: At these dimensions, by name [their units].
        start: Answers at the start, by name [their units].
        result: Code of RESULTS: successful, infeasible, not_optimal, the failure of an analysis; where targets are
            missed target_missed if a bound, a limit or an equality holds the design, and local_minimum if none does.
        reason: Why the search ended, in words.
        active: Dimensions at a bound and limits that are reached, in words.
        objective: What was minimised, relative to the start [-].
        violation: Largest violation of a limit or of an equality, relative to its value [-].
        history: Every evaluation of the run that led here: dimensions and answers by name, "objective" and
            "violation", each (evaluations, ...).
        runs: Objective and violation of every start, (starts, 2), NaN where the start itself failed.
        curves: Targets that are curves, by the names of their answers.
        choices: What was chosen, by name.
        combinations: Every combination of choices, as far as they were given, in their order.
    """

    dimensions: dict[str, Any]
    answers: dict[str, Any]
    start: dict[str, Any]
    result: RESULTS
    reason: str
    active: tuple[str, ...]
    objective: float
    violation: float
    history: dict[str, np.ndarray]
    runs: np.ndarray
    curves: dict[str, Curve] = dataclasses.field(default_factory=dict)
    choices: dict[str, Any] = dataclasses.field(default_factory=dict)
    combinations: "tuple[Combination, ...]" = ()

    @property
    def evaluations(self) -> int:
        """Number of designs that the run computed."""
        return len(self.history["objective"])

    def summary(self) -> Summary:
        """Dimensions, and answers beside those at the start."""
        rows = self._chosen() | {name: _text(value) for name, value in self.dimensions.items()}
        rows |= {n: f"{_text(value)} (start {_text(self.start[n])})" for n, value in self.answers.items()}
        title = f"Tuned, {self.result.name}: {self.reason} ({self.evaluations} evaluations)"
        return Summary(title, rows, "tuning")

    def __str__(self) -> str:
        lines = [f"{self.result.name}: {self.reason} ({self.evaluations} evaluations)"]
        lines += [f"  {name} = {label}" for name, label in self._chosen().items()]
        lines += [f"  {name} = {_text(value)}" for name, value in self.dimensions.items()]
        for name, value in self.answers.items():
            lines.append(f"  {name}: {_text(value)} (start {_text(self.start[name])})")
        lines += [f"  {text}" for text in self.active[:SHOWN]]
        if len(self.active) > SHOWN:
            lines.append(f"  ... and {len(self.active) - SHOWN} more, in `active`")
        if self.combinations:
            lines += ["all combinations, the one above with *:", self.table()]
        return "\n".join(lines)

    def _chosen(self) -> dict[str, str]:
        """Labels of what was chosen, by name."""
        return next((one.labels for one in self.combinations if one.choices is self.choices), {})

    def table(self) -> str:
        """Every combination of choices as text: objective, violation, what became of it, and its dimensions."""
        names = list(self.choices)
        widths = [max(len(text) for text in (name, *(one.labels[name] for one in self.combinations))) for name in names]
        heads = [f"{name:>{width}}" for name, width in zip(names, widths, strict=True)]
        lines = ["  ".join(["   ", *heads, " objective", " violation", "result"])]
        for one in self.combinations:
            cells = [f"{one.labels[name]:>{width}}" for name, width in zip(names, widths, strict=True)]
            found = one.tuned
            numbers = (found.objective, found.violation) if found else ("-", "-")
            cells += [f"{number if isinstance(number, str) else f'{number:.4g}':>10}" for number in numbers]
            own = [f"{name} = {_text(v)}" for name, v in found.dimensions.items()] if found else [one.reason]
            mark = "  *" if one.choices is self.choices else "   "
            lines.append("  ".join([mark, *cells, one.result.name + (": " if own else "") + ", ".join(own)]))
        return "\n".join(lines)


def _text(value: Any) -> str:
    return np.array2string(np.asarray(value), threshold=8, formatter={"float_kind": "{:.7g}".format})
