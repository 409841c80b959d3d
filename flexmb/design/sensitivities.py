"""Sensitivities of answers to dimensions, and the effect of manufacturing tolerances."""

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any, Literal

import jax
import numpy as np
from jaxtyping import Array, Float

from ..arguments import ByName, WholeFromZero, check_choice, check_whole, checked
from ..compilation.by_meaning import jit
from ..compilation.compile import unguarded
from ..display import Column, Labelled, Quantities, Result, Summary, counted, largest, listed, short
from ..errors import AnalysisError, warn
from ..files import for_files
from ..numerical_limits import NOT_LINEAR, ZERO_SECOND_ORDER
from ..results import ANSWERED, NO_DERIVATIVE, RESULTS, check
from .designs import MOST, numbers
from .evaluate import Answers, Build, build_once, check_dimensions, flat_function, layout_of, named_answers
from .sweep import sweep
from .swept import Sweep

# A reverse pass costs about this many forward ones (benchmarks/first_impression.py: value and gradient against value).
REVERSE_COST = 2.0
# Number of dimensions whose second order is checked.
CHECKED = 20


@dataclasses.dataclass(frozen=True, repr=False)
class Sensitivities(Result):
    """First derivatives of answers by dimensions, and second ones if wanted.

    Attributes:
        answers: Name of each of the m answers, such as "stiffness[1]".
        dimensions: Name of each of the n dimensions.
        values: Answers, (m,) [their units].
        point: Dimensions, (n,) [SI].
        slopes: d answer/d dimension, (m, n) [their units].
        table: d ln(answer)/d ln(dimension), (m, n) [-]: percent of the answer for one percent of the dimension. Not
            finite if the answer is zero.
        curvatures: d2 answer/d dimension d dimension, (m, n, n) [their units], or None.
        mode: "forward" or "reverse".
        result: Code of RESULTS.
    """

    answers: tuple[str, ...]
    dimensions: tuple[str, ...]
    values: np.ndarray
    point: np.ndarray
    slopes: np.ndarray
    table: np.ndarray
    curvatures: np.ndarray | None
    mode: str
    result: RESULTS

    def to_pandas(self):
        """Return the table as a ``pandas.DataFrame`` with a row for each answer and a column for each dimension.

        Raises:
            ImportError: pandas is not installed.
        """
        return for_files("pandas").DataFrame(self.table, index=list(self.answers), columns=list(self.dimensions))

    def summary(self) -> Summary:
        """Return each answer with its change for a percent of the most effective dimension."""
        rows = {}
        for name, value, row in zip(self.answers, self.values, self.table, strict=True):
            rows[name] = f"{short(value)}, {largest(row, self.dimensions, '%', 'per % of')}"
        count, many = np.shape(self.table)
        title = f"Sensitivities of {counted(count, 'answer')} to {counted(many, 'dimension')}: {self.result.name}"
        return Summary(title, rows, "sensitivities")

    def __str__(self) -> str:
        width = max(12, *(len(name) + 2 for name in self.dimensions))
        first = max(len(name) for name in (*self.answers, "d ln/d ln"))
        lines = [f"{'d ln/d ln':<{first}}{'value':>14}" + "".join(f"{name:>{width}}" for name in self.dimensions)]
        for name, value, row in zip(self.answers, self.values, self.table, strict=True):
            lines.append(f"{name:<{first}}{value:>14.6g}" + "".join(f"{entry:>{width}.4f}" for entry in row))
        return "\n".join(lines)


@checked
@unguarded
def sensitivities(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    *,
    second_order: bool = False,
    mode: Literal["forward", "reverse"] | None = None,
    throw: bool = True,
) -> Sensitivities:
    """Derivatives of answers by the dimensions of a mechanism.

    Args:
        build: Function of the dimensions, by name, that returns a model. If no degrees of freedom are named, flexmb
            chooses them once, at these dimensions.
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one, several, or a
            dictionary by name.
        dimensions: Numbers or arrays by name, n in all [SI].
        second_order: Whether to compute second derivatives.
        mode: Mode of differentiation; by default the cheaper one.
        throw: Raise if an analysis fails; otherwise ``result`` contains the code.

    Returns:
        Sensitivities with ``table`` (m, n) [-] and ``slopes`` (m, n).

    Raises:
        ValueError: ``build`` does not accept a dimension, or lacks one.
        AnalysisError: An analysis fails, or the state is critical and has no derivative.

    Source:
        Implicit differentiation of the equilibrium and of the eigenvalues (:func:`flexmb.equilibrium`,
        :func:`flexmb.frequencies`); d ln a/d ln p = (p/a) da/dp.
    """
    return _sensitivities(build, answers, dimensions, second_order, mode, throw)[0]


def _sensitivities(
    build: Build, answers: Answers, dimensions: Mapping[str, Any], second_order: bool, mode: str | None, throw: bool
) -> tuple[Sensitivities, Callable[[np.ndarray], Any]]:
    """Sensitivities, and the compiled function from (n,) to values, slopes, curvatures and code."""
    dimensions = {name: numbers(f"Dimension '{name}'", v) for name, v in dimensions.items()}
    functions, layout = named_answers(answers), layout_of(dimensions)
    check_dimensions(build, layout.names)
    function, rows = flat_function(build, functions, layout, build_once(build, dimensions))
    point, m = layout.join(dimensions), sum(rows.sizes)
    if mode is None:
        mode = "forward" if len(point) <= REVERSE_COST * m else "reverse"
    check_choice("mode", mode, ("forward", "reverse"))
    derivatives = jit(_derivatives(function, mode, second_order))
    values, slopes, curvatures, code = derivatives(point)
    result = RESULTS(int(code))
    if result in (RESULTS.successful, RESULTS.unstable_state) and not np.all(np.isfinite(slopes)):
        result = RESULTS.not_finite
    if throw and result in NO_DERIVATIVE:
        # Without derivatives this code is no failure.
        raise AnalysisError(result.name, result.message)
    subject = f"It concerns the sensitivities of {', '.join(functions)}."
    check(int(result), throw, subject)
    if result is RESULTS.unstable_state:
        warn(f"{result.message} {subject}")
    values, slopes = np.asarray(values), np.asarray(slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        table = slopes * point / values[:, None]
    second = np.asarray(curvatures) if second_order else None
    labels = tuple(rows.labels), tuple(layout.labels)
    return Sensitivities(*labels, values, point, slopes, table, second, mode, result), derivatives


def _derivatives(function: Callable[..., Any], mode: str, second_order: bool):
    differentiate: Any = jax.jacfwd if mode == "forward" else jax.jacrev

    def twice(flat: Float[Array, "n"]):
        value, code = function(flat)
        return value, (value, code)

    def once(flat: Float[Array, "n"]):
        slopes, (value, code) = differentiate(twice, has_aux=True)(flat)
        return slopes, (value, slopes, code)

    def everything(flat: Float[Array, "n"]):
        if not second_order:
            slopes, (value, code) = differentiate(twice, has_aux=True)(flat)
            return value, slopes, None, code
        curvatures, (value, slopes, code) = jax.jacfwd(once, has_aux=True)(flat)
        return value, slopes, curvatures, code

    return everything


def _warn_of_curvature(found: Sensitivities, derivatives: Callable[[np.ndarray], Any], spread: np.ndarray) -> None:
    """Warn of answers with a nonlinear scatter, by derivatives one deviation to both sides of each dimension."""
    linear = np.abs(found.slopes * spread)
    shares = np.max(linear / np.maximum(np.max(linear, axis=1, keepdims=True), np.finfo(float).tiny), axis=0)
    checked = [i for i in np.argsort(-shares, kind="stable")[:CHECKED] if spread[i] > 0]
    bent: Any = np.zeros((len(checked), *linear.shape))  # H_ij s_i s_j of each answer
    for row, i in zip(bent, checked, strict=True):
        aside = spread * (np.arange(len(spread)) == i)
        (_, up, _, first), (_, down, _, last) = derivatives(found.point + aside), derivatives(found.point - aside)
        known = first in ANSWERED and last in ANSWERED
        row[:] = (np.asarray(up) - np.asarray(down)) * spread / 2 if known else np.nan
    mean = np.abs(sum((row[:, i] for row, i in zip(bent, checked, strict=True)), np.zeros(len(linear)))) / 2
    added = np.maximum(mean, np.sqrt(np.sum(bent**2, axis=(0, 2)) / 2))
    deviations = np.sqrt(np.sum(linear**2, axis=1))
    limit = np.maximum(NOT_LINEAR * deviations, ZERO_SECOND_ORDER * np.abs(found.values))
    wrong = np.flatnonzero(~(added <= limit))
    if len(wrong):
        names = [f"'{found.answers[i]}' (± {short(deviations[i])}, second order {short(added[i])})" for i in wrong]
        warn(
            f"The scatter of {listed(names)} is not linear in the dimensions. Its first-order deviation is wrong:"
            " within the tolerances two frequencies nearly coincide, or a design has no answer. Set samples=1000, or"
            " ask for a smooth measure of both, such as fm.linear.smooth_minimum."
        )


@dataclasses.dataclass(frozen=True, repr=False)
class Tolerances(Labelled):
    """Scatter of answers from the scatter of dimensions.

    Attributes:
        answers: Name of each of the m answers.
        dimensions: Name of each of the n dimensions.
        values: Answers at the nominal dimensions, (m,) [their units].
        deviations: First-order standard deviation of each answer, (m,) [its unit].
        shares: Share of each dimension in the variance, (m, n) [-]; the sum of a row is one.
        sampled_mean: Mean of the samples, (m,), or None.
        sampled_deviations: Standard deviation of the samples, (m,), or None.
        sampled_interval: Quantiles 0.025 and 0.975 of the samples, (m, 2), or None.
        samples: Sweep over the samples, or None.
    """

    answers: tuple[str, ...]
    dimensions: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    shares: np.ndarray
    sampled_mean: np.ndarray | None = None
    sampled_deviations: np.ndarray | None = None
    sampled_interval: np.ndarray | None = None
    samples: Sweep | None = None

    def quantities_by_name(self) -> Quantities:
        """Values, deviations and shares by answer and dimension."""
        over = ("answer",)
        names = {"answer": self.answers, "dimension": self.dimensions}
        found = {"value": Column(over, self.values), "deviation": Column(over, self.deviations)}
        found["share"] = Column((*over, "dimension"), self.shares, "-")
        return Quantities(over, {name: Column((name,), np.array(own)) for name, own in names.items()}, found)

    def summary(self) -> Summary:
        """Return each answer with its deviation, and the dimension with the largest share in it."""
        rows = {}
        for name, value, deviation, row in zip(self.answers, self.values, self.deviations, self.shares, strict=True):
            rows[name] = f"{short(value)} ± {short(deviation)}, {largest(100 * row, self.dimensions, '%', 'from')}"
        count, many = np.shape(self.shares)
        title = f"Tolerances of {counted(count, 'answer')} from {counted(many, 'dimension')}"
        return Summary(title, rows, "sensitivities")

    def __str__(self) -> str:
        first = max(len(name) for name in (*self.answers, "answer"))
        width = max(12, *(len(name) + 2 for name in self.dimensions))
        head = f"{'answer':<{first}}{'value':>14}{'deviation':>14}" + "".join(f"{n:>{width}}" for n in self.dimensions)
        lines = [head]
        for i, name in enumerate(self.answers):
            shares = "".join(f"{100 * s:>{width - 1}.1f}%" for s in self.shares[i])
            lines.append(f"{name:<{first}}{self.values[i]:>14.6g}{self.deviations[i]:>14.4g}{shares}")
        return "\n".join(lines)


@checked
def tolerances(
    build: Build,
    answers: Answers,
    dimensions: Mapping[str, Any],
    deviations: ByName,
    *,
    samples: Annotated[int, partial(check_whole, least=0, most=MOST)] = 0,
    seed: WholeFromZero = 0,
) -> Tolerances:
    """Scatter of answers from independent, normally distributed deviations of the dimensions.

    Args:
        build: See :func:`sensitivities`.
        answers: See :func:`sensitivities`.
        dimensions: Nominal dimensions by name [SI].
        deviations: Standard deviations of dimensions, by name [SI].
        samples: Number of random designs to compute too; 0 for the first-order answer only.
        seed: Seed of the random numbers.

    Returns:
        Tolerances with deviations (m,) [units of the answers] and shares (m, n) [-].

    Raises:
        ValueError: A deviation is negative or belongs to no dimension.
        AnalysisError: As for :func:`sensitivities`. Statistics leave out failed samples; ``samples`` has their codes.

    Warns:
        FlexmbWarning: The second order adds more than a fifth of an answer's deviation to its mean or its deviation,
            for example where two frequencies nearly coincide. flexmb computes it from designs at plus and minus one
            deviation of the twenty dimensions with the largest shares.

    Source:
        First-order propagation of variance: sum of (da/dp s)^2. Second order, H = d2a/dp2 and independent normal
        deviations: it adds sum of H_ii s_i^2/2 to the mean, sum of (H_ij s_i s_j)^2/2 to the variance. Monte Carlo.
    """
    for name, deviation in deviations.items():
        if name not in dimensions:
            raise ValueError(f"Deviation of '{name}': there is no such dimension ({', '.join(dimensions)}).")
        size = numbers(f"Deviation of '{name}'", deviation)
        if not np.all(size >= 0) or not np.all(np.isfinite(size)):
            raise ValueError(f"Deviation of '{name}' is {deviation}. It must be finite and not negative.")
    found, derivatives = _sensitivities(build, answers, dimensions, False, None, True)
    layout = layout_of(dimensions)
    spread = layout.join({name: deviations.get(name, 0.0) for name in layout.names})
    variances = (found.slopes * spread) ** 2
    total = variances.sum(axis=1)
    shares = variances / np.where(total > 0, total, 1.0)[:, None]
    _warn_of_curvature(found, derivatives, spread)
    first_order = Tolerances(found.answers, found.dimensions, found.values, np.sqrt(total), shares)
    if not samples:
        return first_order
    drawn = np.random.default_rng(seed).standard_normal((samples, len(spread)))
    ran = sweep(build, answers, layout.stacked(layout.join(dimensions) + spread * drawn))
    good = np.concatenate([v.reshape(samples, -1) for v in ran.answers.values()], axis=1)[np.isin(ran.codes, ANSWERED)]
    if len(good) < 2:
        raise ValueError(f"Fewer than two of {samples} samples have answers: {ran.failures()}")
    return dataclasses.replace(
        first_order,
        sampled_mean=good.mean(axis=0),
        sampled_deviations=good.std(axis=0, ddof=1),
        sampled_interval=np.quantile(good, [0.025, 0.975], axis=0).T,
        samples=ran,
    )
