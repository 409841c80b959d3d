"""Tolerances: scatter of answers due to scatter of dimensions, by first order, second order or samples."""

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any

import numpy as np

from ..arguments import WholeFromZero, check_by_name, check_whole, checked
from ..display import Column, Labelled, Quantities, Summary, counted, largest, listed, short
from ..errors import warn
from ..numerical_limits import NEGLIGIBLE, NOT_LINEAR
from ..results import ANSWERED
from .designs import MOST, float_array
from .evaluate import Answers, Build, Layout, layout_of
from .scatter import Scatter, moments, nominal_values
from .sensitivities import Sensitivities, derived
from .sweep import sweep
from .swept import Sweep

# Number of dimensions in the check of the second order.
CHECKED = 20
# Number of designs for the second-order answers, and for exact answers that give their error.
OF_SECOND_ORDER, CHECKED_DESIGNS = 100_000, 64
# Number of random designs that check the first order: two frequencies may cross by many dimensions together.
TOGETHER = 16


@dataclasses.dataclass(frozen=True, repr=False)
class Tolerances(Labelled):
    """Scatter of answers due to scatter of dimensions.

    Attributes:
        answers: Name of each of the m answers.
        dimensions: Name of each of the n dimensions.
        values: Answers at the nominal dimensions, (m,) [their units].
        deviations: First-order standard deviation of each answer, (m,) [its unit].
        shares: Share of each dimension in the variance, (m, n) [-]. The sum of a row is 1, or 0 without scatter.
            Shares of correlated dimensions include half their covariance, and may be negative.
        sampled_mean: Mean of the samples, (m,), or None.
        sampled_deviations: Standard deviation of the samples, (m,), or None.
        sampled_interval: Quantiles 0.025 and 0.975 of the samples, (m, 2), or None.
        samples: Sweep over the samples, or None.
        mean: Second-order mean of each answer, (m,) [its unit], or None without ``second_order``.
        second_order_deviations: Second-order standard deviation, (m,), or None.
        second_order_interval: Second-order quantiles 0.025 and 0.975, (m, 2), or None.
        error: Root mean square of the exact minus the second-order answers over 64 random designs, (m,), or None. It
            estimates a bound on the errors of ``mean`` and of ``second_order_deviations``.
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
    mean: np.ndarray | None = None
    second_order_deviations: np.ndarray | None = None
    second_order_interval: np.ndarray | None = None
    error: np.ndarray | None = None

    def quantities_by_name(self) -> Quantities:
        """Return values, deviations and shares by answer and dimension."""
        over = ("answer",)
        names = {"answer": self.answers, "dimension": self.dimensions}
        columns = {"value": Column(over, self.values), "deviation": Column(over, self.deviations)}
        columns["share"] = Column((*over, "dimension"), self.shares, "-")
        return Quantities(over, {name: Column((name,), np.array(entries)) for name, entries in names.items()}, columns)

    def summary(self) -> Summary:
        """Return each answer with its deviation and the dimension with the largest share."""
        rows = {}
        for name, value, deviation, row in zip(self.answers, self.values, self.deviations, self.shares, strict=True):
            rows[name] = f"{short(value)} ± {short(deviation)}, {largest(100 * row, self.dimensions, '%', 'from')}"
        if self.mean is not None and self.second_order_deviations is not None and self.error is not None:
            columns = zip(self.answers, self.mean, self.second_order_deviations, self.error, strict=True)
            for name, mean, deviation, error in columns:
                rows[name] += f"; second order {short(mean)} ± {short(deviation)}, error {short(error)}"
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
    deviations: Mapping[str, Any] | Scatter,
    *,
    second_order: bool = False,
    samples: Annotated[int, partial(check_whole, least=0, most=MOST)] = 0,
    seed: WholeFromZero = 0,
) -> Tolerances:
    """Compute the scatter of answers due to scatter of the dimensions.

    Args:
        build: See :func:`sensitivities`.
        answers: See :func:`sensitivities`.
        dimensions: Nominal dimensions by name [SI].
        deviations: Standard deviations by name of the dimension [SI], for independent normal distributions. Or a
            Scatter from :func:`flexmb.scatter`, which may include parameters beside the dimensions.
        second_order: Whether to compute mean, deviation and interval by second derivatives too, with their error.
        samples: Number of random designs whose answers are computed exactly; 0 for none.
        seed: Seed of the random numbers.

    Returns:
        Tolerances with deviations (m,) [units of the answers] and shares (m, n) [-]. Statistics of the samples leave
        out failed designs; ``samples`` has their codes.

    Raises:
        ValueError: A deviation is negative, not finite, or belongs to no dimension. A parameter has no nominal value.
            Fewer than two samples have answers.
        AnalysisError: As for :func:`sensitivities`.

    Warns:
        FlexmbWarning: The second order adds more than a fifth of an answer's deviation to its mean or deviation, for
            example near two coinciding frequencies. This check changes one dimension at a time by plus and minus one
            standard deviation, and computes the derivatives there; it covers the twenty dimensions with the largest
            shares. Sixteen random designs check all dimensions together. flexmb also warns if one of these
            designs, a sample, or a design that checks the second order has no answer.

    Source:
        First-order propagation of variance: (da/dp) C (da/dp)^T. Second order, H = d2a/dp2: a + (da/dp) d + d^T H d/2
        at random deviations d of the same scatter. Warning: for independent normal deviations, H adds the sum of
        H_ii s_i^2/2 to the mean and the sum of (H_ij s_i s_j)^2/2 to the variance. Samples: Monte Carlo.
    """
    joint, by_name = None, {}
    if isinstance(deviations, Scatter):
        dimensions, joint = nominal_values(deviations, dimensions), deviations
    else:
        by_name = check_by_name("deviations", deviations)
        for name, deviation in by_name.items():
            if name not in dimensions:
                raise ValueError(f"Deviation of '{name}': there is no such dimension ({', '.join(dimensions)}).")
            size = float_array(f"Deviation of '{name}'", deviation)
            if not np.all(size >= 0) or not np.all(np.isfinite(size)):
                raise ValueError(f"Deviation of '{name}' is {deviation}. It must be finite and not negative.")
    sensitivities, derivatives = derived(build, answers, dimensions, second_order, None, True)
    layout = layout_of(dimensions)
    if joint is None:
        spread = layout.join({name: by_name.get(name, 0.0) for name in layout.names})
        shift, covariance = np.zeros(len(spread)), np.diag(spread**2)
    else:
        shift, covariance = moments(joint, dimensions)
        spread = np.sqrt(np.diag(covariance))
    parts = sensitivities.slopes * (sensitivities.slopes @ covariance)
    total = parts.sum(axis=1)
    shares = parts / np.where(total > 0, total, 1.0)[:, None]
    scatter_of = Tolerances(
        sensitivities.answers, sensitivities.dimensions, sensitivities.values, np.sqrt(total), shares
    )

    def deviated(count: int, seed: int) -> np.ndarray:
        """Return random deviations from the nominal dimensions, (count, n)."""
        if joint is None:
            return spread * np.random.default_rng(seed).standard_normal((count, len(spread)))
        return _rows(joint.draw(count, dimensions, seed)) - sensitivities.point

    _warn_of_curvature(sensitivities, derivatives, spread, deviated(TOGETHER, seed + 2))
    if second_order:
        exact = partial(_exact, build, answers, layout, sensitivities.point)
        scatter_of = _with_second_order(scatter_of, sensitivities, shift, covariance, deviated, exact, seed)
    if not samples:
        return scatter_of
    ran, good = _exact(build, answers, layout, sensitivities.point, deviated(samples, seed))
    good = good[np.isin(ran.codes, ANSWERED)]
    if len(good) < 2:
        raise ValueError(f"Fewer than two of {samples} samples have answers: {ran.failures()}")
    if len(good) < samples:
        missing = samples - len(good)
        warn(f"Of {samples} samples {missing} have no answers ({ran.failures()}). The statistics leave them out.")
    return dataclasses.replace(
        scatter_of,
        sampled_mean=good.mean(axis=0),
        sampled_deviations=good.std(axis=0, ddof=1),
        sampled_interval=np.quantile(good, [0.025, 0.975], axis=0).T,
        samples=ran,
    )


def _rows(designs: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the dimensions of designs as rows, (designs, n)."""
    return np.concatenate([values.reshape(len(values), -1) for values in designs.values()], axis=1)


def _exact(
    build: Build, answers: Answers, layout: Layout, point: np.ndarray, deviated: np.ndarray
) -> tuple[Sweep, np.ndarray]:
    """Return the answers of designs with given deviations: as a sweep, and as rows, (designs, m)."""
    ran = sweep(build, answers, layout.stacked(point + deviated))
    return ran, np.concatenate([v.reshape(len(deviated), -1) for v in ran.answers.values()], axis=1)


def _with_second_order(
    first_order: Tolerances,
    sensitivities: Sensitivities,
    shift: np.ndarray,
    covariance: np.ndarray,
    deviated: Callable[[int, int], np.ndarray],
    exact: Callable[[np.ndarray], tuple[Sweep, np.ndarray]],
    seed: int,
) -> Tolerances:
    """Add second-order mean, deviation, interval and error to the first order."""
    curvatures = np.asarray(sensitivities.curvatures)

    def quadratic(rows: np.ndarray) -> np.ndarray:
        bent = np.stack([np.sum((rows @ curvature) * rows, axis=1) for curvature in curvatures], axis=1)
        return sensitivities.values + rows @ sensitivities.slopes.T + bent / 2

    second = covariance + np.outer(shift, shift)
    mean = sensitivities.values + sensitivities.slopes @ shift + np.einsum("mij,ij->m", curvatures, second) / 2
    many = quadratic(deviated(OF_SECOND_ORDER, seed))
    some = deviated(CHECKED_DESIGNS, seed + 1)
    ran, rows = exact(some)
    good = np.isin(ran.codes, ANSWERED)
    if not np.all(good):
        warn(f"Of {len(good)} designs that check the second order {np.sum(~good)} have no answer: {ran.failures()}.")
    difference = (rows - quadratic(some))[good]
    return dataclasses.replace(
        first_order,
        mean=mean,
        second_order_deviations=many.std(axis=0),
        second_order_interval=np.quantile(many, [0.025, 0.975], axis=0).T,
        error=np.sqrt(np.mean(difference**2, axis=0)) if np.any(good) else np.full(len(mean), np.nan),
    )


def _warn_of_curvature(
    sensitivities: Sensitivities, derivatives: Callable[[np.ndarray], Any], spread: np.ndarray, drawn: np.ndarray
) -> None:
    """Warn of answers with a nonlinear scatter.

    It computes derivatives one deviation to both sides of the dimensions, and the answers of designs with random
    deviations ``drawn``, (designs, n).
    """
    linear = np.abs(sensitivities.slopes * spread)
    shares = np.max(linear / np.maximum(np.max(linear, axis=1, keepdims=True), np.finfo(float).tiny), axis=0)
    checked = [i for i in np.argsort(-shares, kind="stable")[:CHECKED] if spread[i] > 0]
    bent: Any = np.zeros((len(checked), *linear.shape))  # H_ij s_i s_j of each answer
    for row, i in zip(bent, checked, strict=True):
        aside = spread * (np.arange(len(spread)) == i)
        (_, up, _, first), (_, down, _, last) = (
            derivatives(sensitivities.point + aside),
            derivatives(sensitivities.point - aside),
        )
        known = first in ANSWERED and last in ANSWERED
        row[:] = (np.asarray(up) - np.asarray(down)) * spread / 2 if known else np.nan
    mean = np.abs(sum((row[:, i] for row, i in zip(bent, checked, strict=True)), np.zeros(len(linear)))) / 2
    added = np.maximum(mean, np.sqrt(np.sum(bent**2, axis=(0, 2)) / 2))
    if len(checked) > 1:
        answers = [(row, derivatives(sensitivities.point + row)) for row in drawn]
        errors = [
            np.asarray(values) - sensitivities.values - sensitivities.slopes @ row
            for row, (values, _, _, code) in answers
            if code in ANSWERED
        ]
        if len(errors) < len(drawn):
            warn(
                f"Of {len(drawn)} random designs within the tolerances {len(drawn) - len(errors)} have no answer."
                " Deviations leave out such designs. Narrow the tolerances, or count such designs by samples=1000."
            )
        if errors:
            added = np.maximum(added, np.maximum(np.abs(np.mean(errors, axis=0)), np.std(errors, axis=0)))
    deviations = np.sqrt(np.sum(linear**2, axis=1))
    limit = np.maximum(NOT_LINEAR * deviations, NEGLIGIBLE * np.abs(sensitivities.values))
    wrong = np.flatnonzero(~(added <= limit))
    if len(wrong):
        names = [
            f"'{sensitivities.answers[i]}' (± {short(deviations[i])}, second order {short(added[i])})" for i in wrong
        ]
        warn(
            f"The scatter of {listed(names)} is not linear in the dimensions. Its first-order deviation is wrong:"
            " within the tolerances two frequencies nearly coincide, or a design has no answer. Set samples=1000, or"
            " use a smooth measure of both, such as fm.linear.smooth_minimum."
        )
