"""Robustness of a design: yield, percentiles and worst cases over many made mechanisms; Pareto fronts of them."""

import dataclasses
from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..arguments import ByName, Count, WholeFromZero, check_number, check_whole, checked
from ..display import Result, Summary, short
from ..errors import AnalysisError, printable, warn
from ..results import ANSWERED, RESULTS
from .designs import MOST, Designs
from .evaluate import Answers, Build, named_answers
from .problem import limits_of
from .scatter import Scatter, nominal_values
from .sweep import sweep
from .swept import Front, Sweep
from .tune import tune
from .tuned import Tuned

# Percentiles of a summary, and random mechanisms by default.
SHOWN = (5.0, 50.0, 95.0)
SAMPLES = 100_000


class Estimate(NamedTuple):
    """An estimate from random made mechanisms.

    Attributes:
        value: Estimate.
        lower, upper: Confidence interval.
    """

    value: float
    lower: float
    upper: float

    def __str__(self) -> str:
        return f"{short(self.value)} ({short(self.lower)} to {short(self.upper)})"


@dataclasses.dataclass(frozen=True, repr=False)
class Robustness(Result):
    """Answers of many made mechanisms of the same design.

    Attributes:
        nominal: Answers of the nominal design, by name [their units].
        limits: Lower and upper limit by name, None for no limit.
        fraction: Yield: estimated share of mechanisms with answers within all limits [-].
        fractions: Estimate of the share of mechanisms within the limits of each answer, by name [-].
        samples: Sweep of the mechanisms.
        level: Level of the confidence intervals [-].
    """

    nominal: dict[str, np.ndarray]
    limits: dict[str, tuple[Any, Any]]
    fraction: Estimate
    fractions: dict[str, Estimate]
    samples: Sweep
    level: float

    def percentile(self, name: str, percent: float) -> Estimate:
        """Return a percentile of one number of an answer.

        Args:
            name: Name of an answer or of an entry, such as "frequencies[0]".
            percent: Share of mechanisms with a smaller or equal answer, 0 to 100 [%].

        Returns:
            Estimate [unit of the answer]. An end of its interval is infinite if it lies beyond all samples.

        Raises:
            KeyError: There is no such answer.
            ValueError: The answer has several numbers, or the percentage is not between 0 and 100.

        Source:
            Intervals by order statistics, for any distribution: Conover 1999, 3.2.
        """
        from scipy.stats import binom

        share = check_number("percent", percent, least=0, most=100) / 100
        values = np.sort(self._known(name))
        lower, upper = binom.ppf([(1 - self.level) / 2, (1 + self.level) / 2], len(values), share)
        ends = np.concatenate([[-np.inf], values, [np.inf]])
        low, high = ends[int(lower)], ends[min(int(upper) + 1, len(values) + 1)]
        # Beyond all samples, interpolation between the two outermost samples would leave the interval.
        return Estimate(float(np.clip(np.quantile(values, share), low, high)), float(low), float(high))

    def mean(self, name: str) -> Estimate:
        """Return the mean of one number of an answer.

        Args:
            name: Name as for :meth:`percentile`.
        """
        from scipy.stats import norm

        values = self._known(name)
        width = norm.ppf((1 + self.level) / 2) * np.std(values, ddof=1) / np.sqrt(len(values))
        return Estimate(float(np.mean(values)), float(np.mean(values) - width), float(np.mean(values) + width))

    def deviation(self, name: str) -> float:
        """Return the standard deviation of one number of an answer [its unit].

        Args:
            name: Name as for :meth:`percentile`.
        """
        return float(np.std(self._known(name), ddof=1))

    def worst(self, name: str) -> tuple[tuple[float, dict[str, Any]], tuple[float, dict[str, Any]]]:
        """Return the lowest and the highest value of the samples, each with the parameters of its mechanism.

        Args:
            name: Name as for :meth:`percentile`.
        """
        column = np.where(np.isin(self.samples.codes, ANSWERED), self.samples.column(name), np.nan)
        rows = int(np.nanargmin(column)), int(np.nanargmax(column))
        low, high = (
            (float(column[row]), {parameter: values[row] for parameter, values in self.samples.designs.items()})
            for row in rows
        )
        return low, high

    def _known(self, name: str) -> np.ndarray:
        return self.samples.column(name)[np.isin(self.samples.codes, ANSWERED)]

    def summary(self) -> Summary:
        """Return the yield and percentiles of each answer."""
        rows = {}
        if self.limits:
            rows["yield"] = _in_percent(self.fraction)
            rows |= {f"within limits of {name}": _in_percent(share) for name, share in self.fractions.items()}
        for name, values in self.samples.answers.items():
            if values.ndim == 1:
                parts = ", ".join(short(self.percentile(name, percent).value) for percent in SHOWN)
                nominal = short(float(self.nominal[name]))
                rows[name] = f"{parts} (percentiles 5, 50, 95), nominal {nominal}"
        return Summary(f"Robustness over {len(self.samples.codes)} mechanisms", rows, "sweep")


def _in_percent(share: Estimate) -> str:
    return f"{100 * share.value:.4g} % ({100 * share.lower:.4g} to {100 * share.upper:.4g} %)"


@checked
def robustness(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    scatter: Scatter,
    *,
    limits: ByName | None = None,
    samples: Annotated[int, partial(check_whole, least=2, most=MOST)] = SAMPLES,
    seed: WholeFromZero = 0,
    level: float = 0.95,
    chunk: Count = 1024,
    together: Count = 1,
    progress: Any = False,
) -> Robustness:
    """Compute yield, percentiles and worst cases of a design with scatter.

    Args:
        build: Function that returns a model. Its arguments are the dimensions and the parameters with scatter.
        answers: See :func:`flexmb.sweep`.
        dimensions: Nominal dimensions by name [SI].
        scatter: Scatter from :func:`flexmb.scatter`.
        limits: Lower and upper value by name of an answer, None for no limit. A mechanism outside a limit does not
            count as good in the yield.
        samples: Number of random mechanisms.
        seed: Seed of the random numbers.
        level: Level of the confidence intervals [-].
        chunk: See :func:`flexmb.sweep`.
        together: See :func:`flexmb.sweep`.
        progress: See :func:`flexmb.sweep`.

    Returns:
        Robustness. A mechanism without answers does not count as good in the yield. Percentiles leave it out.

    Raises:
        ValueError: A parameter has no nominal value. A limit belongs to no answer or is empty. The level is not between
            0 and 1. Fewer than two mechanisms have answers. Also the errors of :func:`flexmb.sweep`.

    Warns:
        FlexmbWarning: Some mechanisms or the nominal design have no answers.

    Source:
        Yield: exact binomial interval, Clopper, Pearson 1934.
    """
    check_number("level", level, above=0, most=1 - 1e-9)
    values = nominal_values(scatter, dimensions)
    names = list(named_answers(answers))
    for name in limits or {}:
        if name not in names:
            raise ValueError(f"Limits of '{printable(name)}': there is no such answer ({', '.join(names)}).")
    drawn = scatter.draw(samples, dimensions, seed)
    # The first design is the nominal one.
    every = {name: np.concatenate([value[None], drawn[name]]) for name, value in values.items()}
    results = sweep(build, answers, every, chunk=chunk, together=together, progress=progress)
    ran = results.selected(slice(1, None))
    answered = np.isin(ran.codes, ANSWERED)
    if np.sum(answered) < 2:
        raise ValueError(f"Fewer than two of {samples} mechanisms have answers: {ran.failures()}.")
    if results.codes[0] not in ANSWERED:
        warn(f"The nominal design has no answers ({RESULTS(int(results.codes[0])).name}).")
    if not np.all(answered):
        without = f"Of {samples} mechanisms {np.sum(~answered)} have no answers ({ran.failures()})."
        warn(f"{without} They do not count as good in the yield.")
    within_limits = {name: answered & _within(name, ran.answers[name], pair) for name, pair in (limits or {}).items()}
    good = np.logical_and.reduce(list(within_limits.values())) if within_limits else answered
    fractions = {name: _share(rows, level) for name, rows in within_limits.items()}
    nominal = {name: array[0] for name, array in results.answers.items()}
    return Robustness(nominal, dict(limits or {}), _share(good, level), fractions, ran, level)


def _within(name: str, values: np.ndarray, pair: Any) -> np.ndarray:
    """Return whether all entries of an answer are within its limits, (designs,)."""
    lower, upper = limits_of(name, values.shape[1:], pair)
    rows = values.reshape(len(values), -1)
    fine = np.ones(rows.shape, bool)
    if lower is not None:
        fine &= rows >= np.broadcast_to(lower, values.shape[1:]).ravel()
    if upper is not None:
        fine &= rows <= np.broadcast_to(upper, values.shape[1:]).ravel()
    return np.all(fine, axis=1)


def _share(good: np.ndarray, level: float) -> Estimate:
    from scipy.stats import binomtest

    count, total = int(np.sum(good)), len(good)
    interval = binomtest(count, total).proportion_ci(level, method="exact")
    return Estimate(count / total, float(interval.low), float(interval.high))


@checked
def robust_front(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    bounds: ByName,
    *,
    minimize: str,
    against: str,
    points: Annotated[int, partial(check_whole, least=2)] = 8,
    limits: Mapping[str, Any] | None = None,
    **options: Any,
) -> Front:
    """Compute the Pareto front of two criteria by searches with derivatives.

    Each end of the front minimises one criterion. Each point between the ends minimises the first criterion with an
    upper limit on the second criterion. These limits are evenly spaced.

    Args:
        build: See :func:`flexmb.tune`.
        answers: See :func:`flexmb.tune`.
        dimensions: Dimensions at the start, by name [SI].
        bounds: Lower and upper value by name [SI].
        minimize: First criterion: name of an answer, or a statistic such as "percentile 95 mass".
        against: Second criterion, minimised too. To maximise an answer, add an answer that returns its negative.
        points: Number of points, including both ends.
        limits: Limits of other answers and statistics.
        options: Other arguments of :func:`flexmb.tune`, such as ``scatter``, ``samples`` and ``starts``.

    Returns:
        Front. Its sweep has all answers and statistics of the successful searches.

    Raises:
        ValueError: The criteria are equal, a criterion has a limit, or ``choices`` are given. Also the errors of
            :func:`flexmb.tune`.
        AnalysisError: The search for an end of the front fails.

    Warns:
        FlexmbWarning: Searches for points between the ends fail. The front leaves these points out.

    Source:
        Epsilon-constraint method: Haimes, Lasdon, Wismer 1971.
    """
    if options.get("choices"):
        raise ValueError("A front has no `choices`: make one for each combination.")
    if minimize == against:
        raise ValueError(f"The front needs two different criteria, not '{printable(minimize)}' twice.")
    for name in (minimize, against):
        if name in (limits or {}):
            raise ValueError(f"'{printable(name)}' is a criterion of the front and has a limit. Leave one of them out.")
    all_limits: dict[str, Any] = {minimize: (None, np.inf), against: (None, np.inf), **(limits or {})}

    def searched(criterion: str, start: Mapping[str, Any], **more: Any) -> Tuned:
        search_limits = {**all_limits, **more}
        return tune(build, answers, start, bounds, minimize=criterion, limits=search_limits, throw=False, **options)

    ends = [searched(criterion, dimensions) for criterion in (minimize, against)]
    for criterion, end in zip((minimize, against), ends, strict=True):
        if end.result is not RESULTS.successful:
            raise AnalysisError(end.result.name, f"The least '{criterion}' was not found. {end.reason}")
    optima, missed = [ends[0]], 0
    for level in np.linspace(ends[0].answers[against], ends[1].answers[against], points)[1:-1]:
        optimum = searched(minimize, optima[-1].dimensions, **{against: (None, float(level))})
        if optimum.result is RESULTS.successful:
            optima.append(optimum)
        else:
            missed += 1
    if missed:
        warn(f"Of {points} points of the front {missed} were not found and are left out. Give more `starts`.")
    optima.append(ends[1])
    designs = Designs(
        {name: np.stack([np.asarray(optimum.dimensions[name]) for optimum in optima]) for name in dimensions}
    )
    values = {name: np.stack([np.asarray(optimum.answers[name]) for optimum in optima]) for name in optima[0].answers}
    results = Sweep(designs, values, np.zeros(len(optima), np.int32), {})
    return results.pareto(minimize=[minimize, against])
