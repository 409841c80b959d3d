"""Sensitivities of answers to dimensions, and what manufacturing tolerances make of them."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, Literal

import jax
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_by_name, check_whole, shown
from ..compilation.by_meaning import jit
from ..compilation.compile import unguarded
from ..display import Column, Labelled, Quantities, Result, Summary, counted, largest, listed, short
from ..errors import AnalysisError, clean, warn
from ..files import for_files
from ..results import ANSWERED, NO_DERIVATIVE, RESULTS, check
from .designs import MOST, numbers
from .evaluate import Answers, Build, build_once, check_dimensions, flat_function, layout_of, named_answers
from .sweep import sweep
from .swept import Sweep

# A reverse pass costs about this many forward ones (benchmarks/first_impression.py: value and gradient against value).
REVERSE_COST = 2.0
# The second order of a scatter counts beyond this share of the first, and beyond round-off of the answer; so many
# dimensions are looked at. Our choice.
NOT_LINEAR, ROUND_OFF, CHECKED = 0.2, 1e-9, 20


@dataclasses.dataclass(frozen=True, repr=False)
class Sensitivities(Result):
    """First derivatives of answers by dimensions, and second ones where asked for.

    Attributes:
        answers: Name of each of the m answers; "stiffness[1]" for one of several.
        dimensions: Name of each of the n dimensions.
        values: Answers, (m,) [their units].
        point: Dimensions, (n,) [SI].
        slopes: d answer/d dimension, (m, n) [their units].
        table: d ln(answer)/d ln(dimension), (m, n) [-]: percent of the answer for one percent of the dimension. Not
            finite where the answer is zero.
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
        """The table as a ``pandas.DataFrame``, answers down and dimensions across.

        Raises:
            ImportError: pandas is not installed.
        """
        return for_files("pandas").DataFrame(self.table, index=list(self.answers), columns=list(self.dimensions))

    def summary(self) -> Summary:
        """Each answer, and what a percent of the dimension that matters most makes of it."""
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


@unguarded
def sensitivities(
    build: Build,
    answers: Answers,
    dimensions: Mapping[str, Any],
    *,
    second_order: bool = False,
    mode: Literal["forward", "reverse"] | None = None,
    throw: bool = True,
) -> Sensitivities:
    """Derivatives of answers by the dimensions of a mechanism.

    Args:
        build: Function of the dimensions, by name, that returns a model. Degrees of freedom that it does not name are
            found once, at these dimensions.
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one, several, or a
            dictionary by name.
        dimensions: Numbers or arrays by name, n in all [SI].
        second_order: Whether second derivatives are wanted too.
        mode: Of differentiation; by default the cheaper.
        throw: Raise where an analysis fails; otherwise the code is in ``result``.

    Returns:
        Sensitivities with ``table`` (m, n) [-] and ``slopes`` (m, n).

    Raises:
        ValueError: A dimension that ``build`` does not take, or lacks.
        AnalysisError: An analysis fails, or the state is critical, where there is no derivative.

    Source:
        Implicit differentiation of the equilibrium and of the eigenvalues (:func:`flexmb.equilibrium`,
        :func:`flexmb.frequencies`); d ln a/d ln p = (p/a) da/dp.
    """
    return _sensitivities(build, answers, dimensions, second_order, mode, throw)[0]


def _sensitivities(
    build: Build, answers: Answers, dimensions: Mapping[str, Any], second_order: bool, mode: str | None, throw: bool
) -> tuple[Sensitivities, Callable[[np.ndarray], Any]]:
    """As :func:`sensitivities`, and the compiled function of (n,) that gives values, slopes, curvatures and code."""
    check_by_name("dimensions", dimensions)
    dimensions = {name: numbers(f"Dimension '{name}'", v) for name, v in dimensions.items()}
    functions, layout = named_answers(answers), layout_of(dimensions)
    check_dimensions(build, layout.names)
    function, rows = flat_function(build, functions, layout, build_once(build, dimensions))
    point, m = layout.join(dimensions), sum(rows.sizes)
    if mode is None:
        mode = "forward" if len(point) <= REVERSE_COST * m else "reverse"
    if mode not in ("forward", "reverse"):
        raise ValueError(f"Argument `mode` must be 'forward' or 'reverse', but is {clean(repr(mode))}.")
    derivatives = jit(_derivatives(function, mode, second_order))
    values, slopes, curvatures, code = derivatives(point)
    result = RESULTS(int(code))
    if result in (RESULTS.successful, RESULTS.unstable_state) and not np.all(np.isfinite(slopes)):
        result = RESULTS.not_finite
    if throw and result in NO_DERIVATIVE:
        # No failure where no derivative is asked for.
        raise AnalysisError(result.name, result.message)
    check(int(result), throw, "It is about the sensitivities of " + ", ".join(functions) + ".")
    if result is RESULTS.unstable_state:
        warn(f"{result.message} It is about the sensitivities of {', '.join(functions)}.")
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
    """Warn of answers whose scatter is not linear, from derivatives one deviation to both sides of each dimension."""
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
    wrong = np.flatnonzero(~(added <= np.maximum(NOT_LINEAR * deviations, ROUND_OFF * np.abs(found.values))))
    if len(wrong):
        names = [f"'{found.answers[i]}' (± {short(deviations[i])}, second order {short(added[i])})" for i in wrong]
        warn(
            f"The scatter of {listed(names)} is not linear in the dimensions, and its first-order deviation does not"
            " hold: within the tolerances two frequencies may nearly coincide, or a design has no answer. Ask for"
            " samples=1000, or take a smooth measure of both, such as fm.linear.smooth_minimum."
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
        sampled_mean: Mean of the samples, (m,), or None without samples.
        sampled_deviations: Standard deviation of the samples, (m,), or None.
        sampled_interval: Quantiles 0.025 and 0.975 of the samples, (m, 2), or None.
        samples: The sweep over them, or None.
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
        """Each answer with its deviation, and the dimension with the largest share in that."""
        rows = {}
        for name, value, deviation, row in zip(self.answers, self.values, self.deviations, self.shares, strict=True):
            rows[name] = f"{short(value)} ± {short(deviation)}, {largest(100 * row, self.dimensions, '%', 'from')}"
        count, many = np.shape(self.shares)
        return Summary(
            f"Tolerances of {counted(count, 'answer')} from {counted(many, 'dimension')}", rows, "sensitivities"
        )

    def __str__(self) -> str:
        first = max(len(name) for name in (*self.answers, "answer"))
        width = max(12, *(len(name) + 2 for name in self.dimensions))
        head = f"{'answer':<{first}}{'value':>14}{'deviation':>14}" + "".join(f"{n:>{width}}" for n in self.dimensions)
        lines = [head]
        for i, name in enumerate(self.answers):
            shares = "".join(f"{100 * s:>{width - 1}.1f}%" for s in self.shares[i])
            lines.append(f"{name:<{first}}{self.values[i]:>14.6g}{self.deviations[i]:>14.4g}{shares}")
        return "\n".join(lines)


def tolerances(
    build: Build,
    answers: Answers,
    dimensions: Mapping[str, Any],
    deviations: Mapping[str, Any],
    *,
    samples: int = 0,
    seed: int = 0,
) -> Tolerances:
    """Scatter of answers from independent, normally distributed deviations of the dimensions.

    Args:
        build: See :func:`sensitivities`.
        answers: See :func:`sensitivities`.
        dimensions: Nominal dimensions by name [SI].
        deviations: Standard deviation of those that scatter, by name [SI].
        samples: Number of random designs to compute besides; 0 for the first-order answer alone.
        seed: Of the random numbers.

    Returns:
        Tolerances with deviations (m,) [units of the answers] and shares (m, n) [-].

    Raises:
        ValueError: A deviation is negative or of no dimension.
        AnalysisError: As for :func:`sensitivities`; a sample that fails is left out of the statistics and has its code
            in ``samples``.

    Warns:
        FlexmbWarning: The first order does not hold: what the second order adds to the mean or to the deviation of an
            answer is more than a fifth of the deviation, as where two frequencies nearly coincide. It is seen one
            deviation to both sides, for the twenty dimensions with the largest shares.

    Source:
        First-order propagation of variance: sum of (da/dp s)^2. Second order, H = d2a/dp2 and independent normal
        deviations: it adds sum of H_ii s_i^2/2 to the mean, sum of (H_ij s_i s_j)^2/2 to the variance. Monte Carlo.
    """
    if not isinstance(deviations, Mapping):
        raise TypeError(
            f"Argument `deviations` must be a dictionary by name, as {{'t': 5e-6}}, not {shown(deviations)}."
        )
    for name, deviation in deviations.items():
        if name not in dimensions:
            raise ValueError(f"Deviation of '{name}': there is no such dimension ({', '.join(dimensions)}).")
        if not np.all((own := numbers(f"Deviation of '{name}'", deviation)) >= 0) or not np.all(np.isfinite(own)):
            raise ValueError(f"Deviation of '{name}' must not be negative, but finite; it is {deviation}.")
    samples = check_whole("samples", samples, 0, MOST)
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
    drawn = np.random.default_rng(check_whole("seed", seed, 0)).standard_normal((samples, len(spread)))
    ran = sweep(build, answers, layout.stacked(layout.join(dimensions) + spread * drawn))
    good = np.concatenate([v.reshape(samples, -1) for v in ran.answers.values()], axis=1)[np.isin(ran.codes, ANSWERED)]
    if len(good) < 2:
        raise ValueError(f"Fewer than two of {samples} samples could be computed: {ran.failures()}")
    return dataclasses.replace(
        first_order,
        sampled_mean=good.mean(axis=0),
        sampled_deviations=good.std(axis=0, ddof=1),
        sampled_interval=np.quantile(good, [0.025, 0.975], axis=0).T,
        samples=ran,
    )
