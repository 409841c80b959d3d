"""Comparison of two models: their difference relative to the scatter of measurements."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arguments import as_reals, check_number
from ..display import Result, Summary, short
from ..errors import ModelError, printable
from ..model.model import Model
from ..numerical_limits import HIDDEN
from .measurement import Measured, check_unit, in_deviations, measured, measurements, predicted


@dataclasses.dataclass(frozen=True, repr=False)
class Comparison(Result):
    """Answers of two models, and their difference in standard deviations of the data.

    Attributes:
        first, second: Answers of the two models, by name of the measurement [unit of the measurement].
        difference: Answer of the first model minus answer of the second model, by name [unit of the measurement].
        in_deviations: Differences in standard deviations, decorrelated, by name [-].
        distance: Root of the sum of the squares of ``in_deviations`` [-].
        correct: Probability that the likelihood of the data is larger for the true model than for the other model [-].
        told_apart: Whether ``correct`` exceeds ``level``.
        chi_squared: Chi-squared of each model; NaN if the data have no values.
        probability: Probability that scatter alone causes a chi-squared at least as large, for each model [-]; NaN if
            the data have no values.
        count: Number of values.
        freedoms: Number of degrees of freedom of each mechanism, not of chi-squared.
        level: Probability above which the data distinguish the models [-].
    """

    first: dict[str, np.ndarray]
    second: dict[str, np.ndarray]
    difference: dict[str, np.ndarray]
    in_deviations: dict[str, np.ndarray]
    distance: float
    correct: float
    told_apart: bool
    chi_squared: tuple[float, float]
    probability: tuple[float, float]
    count: int
    freedoms: tuple[int, int]
    level: float

    @property
    def worst(self) -> tuple[str, float]:
        """Measurement with the largest difference, and this difference in standard deviations [-]."""
        sizes = {name: float(np.max(np.abs(rows))) for name, rows in self.in_deviations.items()}
        name = max(sizes, key=lambda key: sizes[key])
        return name, sizes[name]

    @property
    def reason(self) -> str:
        """The result in words."""
        a, b = self.freedoms
        smaller = "" if a == b else f" The model of {min(a, b)} degrees of freedom is enough."
        if not self.told_apart:
            hidden = self.worst[1] <= HIDDEN
            means = "less than half of their scatter" if hidden else "less than their scatter can show"
            return f"The data do not tell the models apart: the models differ by {means}.{smaller}"
        if np.any(np.isnan(self.chi_squared)):
            return "Such data tell the models apart."
        order = ("first", "second") if self.chi_squared[0] < self.chi_squared[1] else ("second", "first")
        return f"The data tell the models apart. The {order[0]} model fits better than the {order[1]}."

    def summary(self) -> Summary:
        """Return the difference of each measurement in standard deviations, and the result."""
        rows = {}
        for name, rows_of in self.in_deviations.items():
            at = int(np.argmax(np.abs(rows_of)))
            value = short(float(self.difference[name].ravel()[at]))
            rows[name] = f"{rows_of[at]:+.3g} deviations" + (f" ({value})" if len(rows_of) == 1 else " at most")
        rows["told apart"] = f"with a probability of {self.correct:.3g}"
        if not np.any(np.isnan(self.chi_squared)):
            a, b = self.chi_squared
            rows["chi-squared"] = f"{a:.4g} and {b:.4g} of {self.count} values"
        return Summary(self.reason, rows)


def compare(
    model_a: Model,
    model_b: Model,
    data: Measured | Sequence[Measured] | Mapping[str, Any],
    *,
    parameters: Mapping[str, Any] | None = None,
    level: float = 0.95,
) -> Comparison:
    """Compare the difference of two models with the scatter of measurements.

    If the data do not distinguish a fine model and a coarse model, the coarse model is sufficient.

    Args:
        model_a: Mechanism, such as the fine model.
        model_b: Mechanism, such as the coarse model.
        data: Measurements as for :func:`flexmb.fit`. Or, before a measurement, expected standard deviations by
            question, such as ``{"frequency 1": 0.1}``.
        parameters: Values of the parameters of measurements by name, such as the gain of a sensor.
        level: Probability above which the data distinguish the models [-].

    Returns:
        Comparison, with ``told_apart`` and ``reason``. It keeps the parameters of both models; a fit of parameters
        could reduce the difference.

    Raises:
        ModelError: An argument is no model.
        ValueError: A measurement has no deviation. A parameter has no value. The number of values or their unit is
            wrong. An answer is complex or not finite. The level is not between 0.5 and 1.

    Source:
        Likelihood ratio of two simple hypotheses with equal covariance (Neyman, Pearson 1933). It selects the true
        hypothesis with probability Phi(d/2) at a distance d in standard deviations (Mahalanobis 1936).
    """
    from scipy.stats import chi2, norm

    check_number("level", level, least=0.5, most=1 - 1e-12)
    for name, model in (("model_a", model_a), ("model_b", model_b)):
        if not isinstance(model, Model):
            raise ModelError(f"Argument `{name}` must be a Model, not {type(model).__name__}.")
    items, has_values = _items(data)
    for item in items:
        if item.scatter is None:
            raise ValueError(f"Measurement '{item.name}' has no deviation. A comparison of models needs it.")
        for name in item.parameters:
            if name not in (parameters or {}):
                raise ValueError(f"Measurement '{item.name}' takes the parameter '{printable(name)}': give its value.")

    def answer(item: Measured, model: Model) -> np.ndarray:
        return np.asarray(as_reals(f"Measurement '{item.name}'", predicted(item, model, parameters or {})))

    computed = [{item.name: answer(item, model) for item in items} for model in (model_a, model_b)]
    for answers, model in zip(computed, (model_a, model_b), strict=True):
        for item in items:
            if not np.all(np.isfinite(answers[item.name])):
                raise ValueError(f"Measurement '{item.name}' has no finite value in one of the models.")
            if has_values:
                check_unit(item, answers[item.name])
            if item.check is not None:
                item.check(model)
    first, second = computed
    difference = {item.name: _between(item, first[item.name], second[item.name]) for item in items}
    weighted = {item.name: in_deviations(item, difference[item.name]) for item in items}
    distance = float(np.sqrt(sum(np.sum(rows**2) for rows in weighted.values())))
    count = sum(len(rows) for rows in weighted.values())
    misfits = [
        sum(float(np.sum(in_deviations(item, answers[item.name] - item.values) ** 2)) for item in items)
        for answers in computed
    ]
    square = (misfits[0], misfits[1]) if has_values else (np.nan, np.nan)
    correct = float(norm.cdf(distance / 2))
    return Comparison(
        first,
        second,
        difference,
        weighted,
        distance,
        correct,
        correct > level,
        square,
        (float(chi2.sf(square[0], count)), float(chi2.sf(square[1], count))),
        count,
        (model_a.topology.n_q, model_b.topology.n_q),
        level,
    )


def _between(item: Measured, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Difference of two answers; of phases within half a turn."""
    difference = first - second
    if item.relative:
        phases = difference[len(difference) // 2 :]
        phases -= 2 * np.pi * np.round(phases / (2 * np.pi))
    return difference


def _items(data: Any) -> tuple[list[Measured], bool]:
    """Return measurements, and whether they have values: deviations by question have none."""
    if isinstance(data, Mapping) and data and all(isinstance(entry, int | float) for entry in data.values()):
        return [measured(name, 0.0, deviation) for name, deviation in data.items()], False
    return measurements(data), True
