"""A tuned design, the combinations of choices, and the result of each combination."""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..display import Result, Summary
from ..errors import printable
from ..results import RESULTS
from .problem import Curve

# Number of reached bounds and limits that are printed.
SHOWN = 8


class Combination(NamedTuple):
    """One combination of choices.

    Attributes:
        choices: Values by name.
        labels: Labels of the chosen values, by name.
        tuned: Best design with these choices; None if the search could not begin.
        result: Code of RESULTS of the search, or of the analysis that failed at the start.
        reason: Reason in words.
    """

    choices: dict[str, Any]
    labels: dict[str, str]
    tuned: "Tuned | None"
    result: RESULTS
    reason: str


@dataclasses.dataclass(frozen=True, repr=False)
class Tuned(Result):
    """A tuned design.

    Attributes:
        dimensions: Dimensions by name [SI].
        answers: Answers at these dimensions, by name [their units].
        start: Answers at the start, by name [their units].
        result: Code of RESULTS: successful, infeasible, not_optimal, or the failure of an analysis. For missed targets:
            target_missed if a bound, a limit or an equality is active, otherwise local_minimum.
        reason: Reason why the search ended, in words.
        active: Dimensions at a bound and reached limits, in words.
        objective: Objective, relative to the start [-].
        violation: Largest violation of a limit or of an equality, relative to its value [-].
        history: Every evaluation of the best run: dimensions and answers by name, "objective" and "violation", each
            (evaluations, ...).
        runs: Objective and violation of every start, (starts, 2), NaN if the start failed.
        curves: Targets that are curves, by the names of their answers.
        choices: Chosen values, by name.
        combinations: Every combination of choices, in order; empty without choices.
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
        """Return dimensions, and answers beside the answers at the start."""
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
        """Labels of the chosen values, by name."""
        return next((c.labels for c in self.combinations if c.choices is self.choices), {})

    def table(self) -> str:
        """Return every combination of choices as text: objective, violation, result and dimensions."""
        names = list(self.choices)
        widths = [max(len(text) for text in (name, *(c.labels[name] for c in self.combinations))) for name in names]
        heads = [f"{name:>{width}}" for name, width in zip(names, widths, strict=True)]
        lines = ["  ".join(["   ", *heads, " objective", " violation", "result"])]
        for combination in self.combinations:
            cells = [f"{combination.labels[name]:>{width}}" for name, width in zip(names, widths, strict=True)]
            tuned, reason = combination.tuned, [combination.reason]
            numbers = [f"{n:.4g}" for n in (tuned.objective, tuned.violation)] if tuned else ["-", "-"]
            cells += [f"{number:>10}" for number in numbers]
            parts = [f"{name} = {_text(v)}" for name, v in tuned.dimensions.items()] if tuned else reason
            mark = "  *" if combination.choices is self.choices else "   "
            result = combination.result.name + (": " if parts else "") + ", ".join(parts)
            lines.append("  ".join([mark, *cells, result]))
        return "\n".join(lines)


def _text(value: Any) -> str:
    return np.array2string(np.asarray(value), threshold=8, formatter={"float_kind": "{:.7g}".format})


# Compiling a combination takes seconds.
MOST = 100
# Longest text of a label.
LONGEST_LABEL = 24

Options = dict[str, dict[str, Any]]


def options_of(choices: Mapping[str, Any], dimensions: Sequence[str]) -> Options:
    """Values by label, by the name of the choice."""
    options: Options = {}
    for name, values in choices.items():
        if name in dimensions:
            raise ValueError(f"'{printable(name)}' is a choice and a dimension. Give it once.")
        if isinstance(values, str) or not isinstance(values, Mapping | Sequence | np.ndarray):
            raise ValueError(
                f"Choice '{printable(name)}' must be a list of values, or a dictionary of values by label, not"
                f" {_label(values)}."
            )
        if not len(values):
            raise ValueError(f"Choice '{printable(name)}' has no values. Give at least one.")
        options[name] = (
            {printable(k): v for k, v in values.items()} if isinstance(values, Mapping) else _labelled(name, values)
        )
    count = math.prod(len(values) for values in options.values())
    if count > MOST:
        listed = ", ".join(f"{printable(name)} {len(values)}" for name, values in options.items())
        raise ValueError(
            f"There are {count} combinations of choices ({listed}), but at most {MOST} are allowed, since each is"
            " compiled separately. Give fewer values, or search one choice after the other."
        )
    return options


def _labelled(name: str, values: Any) -> dict[str, Any]:
    """Values by their printed text if it is short and unique, otherwise by their number."""
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    labels = [_label(value) for value in listed]
    plain = len(set(labels)) == len(labels) and all(len(label) <= LONGEST_LABEL for label in labels)
    return dict(zip(labels if plain else [f"{name}[{i}]" for i in range(len(listed))], listed, strict=True))


def _label(value: Any) -> str:
    return printable(getattr(value, "__name__", None) or (value if isinstance(value, str) else repr(value)))


def combinations(options: Options) -> list[tuple[dict[str, Any], dict[str, str]]]:
    """Every combination of values by name, with its labels by name, the last choice running fastest."""
    pairs = []
    for labels in itertools.product(*options.values()):
        named = dict(zip(options, labels, strict=True))
        pairs.append(({name: options[name][label] for name, label in named.items()}, named))
    return pairs
