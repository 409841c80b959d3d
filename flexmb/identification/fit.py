"""Fit of parameters of a mechanism to measurements, by least squares with exact derivatives."""

import inspect
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from ..arguments import ByName, Count, WholeFromZero, checked
from ..compilation.compile import unguarded
from ..design.designs import float_array
from ..design.evaluate import REFUSED, Build, Layout, check_answer_names, check_dimensions, layout_of
from ..design.problem import Scaling
from ..errors import AnalysisError, first_line, printable, warn
from ..numerical_limits import (
    AS_GOOD,
    EXACT_FIT,
    FEWEST_OF_SCATTER,
    IMPLAUSIBLE,
    SAME_MINIMUM,
    UNEVEN_SCATTER,
    UNTESTED,
)
from ..results import RESULTS
from .fitted import Fit, scaled_covariance, scaled_deviations
from .measurement import Measured, check_unit, measurements
from .problem import GOOD, FitProblem, Prior, Solution, combinations_of, weighted_slopes


@checked
@unguarded
def fit(
    build: Build,
    data: Measured | Sequence[Measured] | Mapping[str, Any],
    parameters: ByName,
    bounds: ByName,
    *,
    priors: ByName | None = None,
    scales: Mapping[str, Literal["log", "linear"]] | None = None,
    loss: Literal["linear", "huber", "soft_l1", "cauchy"] = "linear",
    starts: Count = 1,
    seed: WholeFromZero = 0,
    max_evaluations: Count = 200,
    throw: bool = True,
) -> Fit:
    """Fit parameters of a mechanism to measurements, with standard deviations of the parameters.

    Args:
        build: Function of the parameters, by name, that returns a model.
        data: Measurements from :func:`flexmb.measured`, :func:`flexmb.measured_modes` and
            :func:`flexmb.measured_response`. Or a dictionary of value and standard deviation by question, such as
            ``{"frequency 1": (41.2, 0.1)}``.
        parameters: Start values, numbers or arrays by name [SI]: the arguments of ``build``, and parameters of
            measurements such as the offset of a sensor.
        bounds: Lower and upper value of each parameter by name [SI].
        priors: Prior mean and standard deviation of parameters, by name [SI].
        scales: "log" or "linear" by name; by default logarithmic if the lower bound is positive.
        loss: "linear" for least squares. "huber", "soft_l1" or "cauchy" reduce the weight of values that differ by more
            than one standard deviation.
        starts: Number of starts: ``parameters``, and others spread over the bounds. The lowest minimum is returned.
        seed: Seed of the other starts.
        max_evaluations: Largest number of evaluations of the model and its derivatives, for each start.
        throw: Raise if the search does not converge; otherwise the code is in ``result``.

    Returns:
        Fit with parameters, standard deviations, confidence intervals, and undetermined combinations of parameters.

    Raises:
        ValueError: There are more parameters than values and priors. A name is unknown. Values probably have a wrong
            unit. No mode of the model matches a measured mode. No value depends on a parameter.
        AnalysisError: The start has no answer, no start converged (not_optimal), or no mechanism has the fitted
            parameters (impossible_design).

    Warns:
        FlexmbWarning: Chi-squared is too large for the given scatter (poor_fit). Differences scatter more where the
            answer is large (uneven scatter), so that intervals are too narrow. Other parameters fit equally well. A
            parameter is at a bound. The data do not determine a combination of parameters. No mode of the fitted model
            matches a measured mode. The fitted equilibrium is not stable.

    Source:
        Trust-region reflective least squares: Branch, Coleman, Li 1999 (SciPy). Covariance: inverse of J^T J, where J
        contains the derivatives of the differences over standard deviations.
    """
    items = measurements(data)
    values = {name: float_array(f"Parameter '{name}'", v) for name, v in parameters.items()}
    layout = layout_of(values)
    of_build = _build_arguments(build, items, layout.names)
    check_answer_names(layout.names, (), ())
    scaling = Scaling(layout, bounds, scales or {})
    first = layout.join(values)
    scaling.check_inside(first)
    known = _priors(priors or {}, layout)
    if items[0].scatter is None and (known or loss != "linear"):
        subject = "Priors weigh" if known else f"The loss '{loss}' weighs"
        raise ValueError(f"{subject} values by their deviations. Give measurement '{items[0].name}' a deviation.")
    count, unknowns = sum(len(item.values) for item in items) + len(known), len(first)
    if count < unknowns:
        raise ValueError(
            f"{unknowns} parameters cannot be fitted to {count} values and priors: measure more, add priors, or fix"
            " parameters in `build`."
        )
    problem = FitProblem(build, of_build, items, scaling, known, first, loss, max_evaluations)
    _check_start(problem)
    solutions = [problem.solve(unit) for unit in scaling.starts(first, starts, seed)]
    best = min(solutions, key=lambda one: (not one.converged, one.cost))
    fitted = _fit_of(problem, solutions, best, values)
    if throw and fitted.result in (RESULTS.not_optimal, RESULTS.impossible_design):
        raise AnalysisError(fitted.result.name, f"{fitted.result.message} {fitted.reason}\n{fitted}")
    _warn(fitted)
    return fitted


def _build_arguments(build: Build, items: list[Measured], names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the arguments of ``build``; other parameters belong to measurements."""
    of_data = {name for item in items for name in item.parameters}
    missing = [(item.name, name) for item in items for name in item.parameters if name not in names]
    if missing:
        raise ValueError(f"Measurement '{missing[0][0]}' takes the parameter '{missing[0][1]}', which has no start.")
    accepted = set()
    if callable(build):
        try:
            accepted = set(inspect.signature(build).parameters)
        except (TypeError, ValueError):
            accepted = set(names) - of_data
    arguments = tuple(name for name in names if name not in of_data or name in accepted)
    # All parameters may belong to measurements, such as the gain of a sensor.
    check_dimensions(build, arguments, least=0 if names else 1)
    return arguments


def _priors(priors: Mapping[str, Any], layout: Layout) -> dict[int, Prior]:
    by_index = {}
    for name, pair in priors.items():
        if name not in layout.names and name not in layout.labels:
            raise ValueError(f"Prior of '{printable(name)}': there is no such parameter ({', '.join(layout.names)}).")
        try:
            mean, deviation = (float_array(f"Prior of '{name}'", part) for part in pair)
        except (TypeError, ValueError):
            raise ValueError(
                f"The prior of '{printable(name)}' must be a pair of mean and standard deviation."
            ) from None
        places = [i for i, label in enumerate(layout.labels) if label == name or label.startswith(f"{name}[")]
        means, deviations = (np.broadcast_to(part, (len(places),)) for part in (mean, deviation))
        if not (np.all(np.isfinite(means)) and np.all(np.isfinite(deviations) & (deviations > 0))):
            raise ValueError(f"The prior of '{printable(name)}' must be finite, with a positive standard deviation.")
        if twice := [layout.labels[i] for i in places if i in by_index]:
            raise ValueError(f"Parameter '{printable(twice[0])}' has two priors. Give one.")
        by_index |= {i: Prior(float(m), float(d)) for i, m, d in zip(places, means, deviations, strict=True)}
    return dict(sorted(by_index.items()))


def _check_start(problem: FitProblem) -> None:
    """Raise for a start without answers, values with a wrong unit, and parameters without effect."""
    unit = problem.scaling.to_unit(problem.first)
    computed, slopes, code = problem.function(unit)
    if code in GOOD and any(item.check is not None for item in problem.items):
        model, _ = problem.build(**problem.layout.split(problem.first))
        for item in problem.items:
            if item.check is not None:
                item.check(model)
    for item, part in zip(problem.items, problem.parts, strict=True):
        if np.all(np.isfinite(computed[part])):
            check_unit(item, computed[part])
    if code not in GOOD:
        raise AnalysisError(RESULTS(code).name, f"The start has no answer. {RESULTS(code).message}")
    if not (np.all(np.isfinite(computed)) and np.all(np.isfinite(slopes))):
        pairs = zip(problem.items, problem.parts, strict=True)
        bad = [item.name for item, part in pairs if not np.all(np.isfinite(slopes[part]))]
        text = f"Measurement '{bad[0]}' has no finite value or derivative at the start. Start elsewhere."
        raise AnalysisError(RESULTS.not_finite.name, text)
    ignored = ~np.any(slopes != 0, axis=0)
    ignored[list(problem.priors)] = False
    if np.any(ignored):
        labels = [f"'{problem.layout.labels[i]}'" for i in np.flatnonzero(ignored)]
        raise ValueError(f"No measured value depends on parameter {', '.join(labels)}. Fix it in `build`.")


def _fit_of(problem: FitProblem, solutions: list[Solution], best: Solution, start: dict[str, Any]) -> Fit:
    from scipy.stats import chi2

    unit, layout, scaling = best.unit, problem.layout, problem.scaling
    rows, slopes, _ = problem.residuals(unit)
    slopes = weighted_slopes(rows, slopes, problem.loss)
    known = all(item.scatter is not None for item in problem.items)
    noise = 1.0 if known else float(np.sqrt(np.sum(rows**2) / max(len(rows) - len(unit), 1)))
    positive_noise = noise or np.finfo(float).tiny
    undetermined = combinations_of(problem, unit, slopes, positive_noise)
    freedom = len(rows) - len(unit) + len(undetermined)
    finite, _ = scaled_covariance(slopes, positive_noise)
    change = scaling.slopes(unit)
    deviations = scaled_deviations(slopes, positive_noise) * change
    flat = scaling.to_dimensions(unit)
    square = float(np.sum(rows**2)) if known else np.nan
    probability = float(chi2.sf(square, freedom)) if known and freedom > 0 else np.nan
    differs = problem.weighted(problem.function(unit)[0] - problem.measured)
    minima = _minima(problem, solutions)
    result, reason = _outcome(best, (square, freedom, probability), minima, len(solutions))
    if result in (RESULTS.poor_fit, RESULTS.not_optimal):
        reason = "; ".join([reason, *dict.fromkeys(item.advice for item in problem.items if item.advice)])
    try:
        problem.build(**layout.split(flat))
    except REFUSED as fault:
        # The traced build of the search cannot check numbers.
        result, reason = RESULTS.impossible_design, first_line(fault)
    return Fit(
        layout.split(flat),
        start,
        layout.split(deviations),
        finite * np.outer(change, change),
        tuple(layout.labels),
        {item.name: problem.function(unit)[0][p] for item, p in zip(problem.items, problem.parts, strict=True)},
        {item.name: differs[p] for item, p in zip(problem.items, problem.parts, strict=True)},
        square,
        freedom,
        probability,
        noise,
        undetermined,
        tuple(scaling.at_bounds(unit)),
        minima,
        result,
        reason,
        sum(solution.evaluations for solution in solutions),
        tuple(problem.items),
        problem,
        unit,
    )


def _minima(problem: FitProblem, solutions: list[Solution]) -> tuple[tuple[dict[str, Any], float], ...]:
    """Return minima at different parameters, the lowest minimum first."""
    minima: list[Solution] = []
    for candidate in sorted(solutions, key=lambda solution: solution.cost):
        if candidate.converged and not any(
            np.max(np.abs(candidate.unit - other.unit)) <= SAME_MINIMUM for other in minima
        ):
            minima.append(candidate)
    return tuple(
        (problem.layout.split(problem.scaling.to_dimensions(candidate.unit)), candidate.cost) for candidate in minima
    )


def _outcome(
    best: Solution, chi_squared: tuple[float, int, float], minima: Sequence[Any], starts: int
) -> tuple[RESULTS, str]:
    square, freedom, probability = chi_squared
    if not best.converged:
        return RESULTS.not_optimal, "the search did not converge from any start"
    others = f"; {len(minima)} different minima from {starts} starts" if len(minima) > 1 else ""
    if probability < IMPLAUSIBLE:
        why = "another start may fit better (starts)" if starts == 1 else f"the best of {starts} starts"
        chance = f"scatter alone causes such a chi-squared with a probability of {probability:.1g}"
        return RESULTS.poor_fit, f"{chance}; {why}"
    if freedom < 1:
        return RESULTS.successful, "there are as many values as parameters, so the data do not test the model" + others
    if not np.isfinite(probability):
        return RESULTS.successful, "least squares converged" + others
    if _chance_of_less(square, freedom) < IMPLAUSIBLE:
        text = "the values scatter less than their deviations (a model computed them, or the intervals are too wide)"
        return RESULTS.successful, text + others
    return RESULTS.successful, "the model agrees with the values within their scatter" + others


def _chance_of_less(square: float, freedom: int) -> float:
    """Return the probability that scatter alone causes a chi-squared at most as large."""
    from scipy.stats import chi2

    return float(chi2.cdf(square, freedom))


def _warn(fitted: Fit) -> None:
    if fitted.result is RESULTS.impossible_design:
        return
    others = [values for values, cost in fitted.minima[1:] if cost - fitted.minima[0][1] < AS_GOOD * fitted.noise**2]
    if others and not fitted.undetermined:
        listed = "; ".join(", ".join(f"{name} = {value}" for name, value in values.items()) for values in others[:3])
        warn(f"Other parameters fit equally well: {listed}. Measure another quantity, or narrow the bounds.")
    if fitted.problem.function(fitted.unit)[2] == RESULTS.unstable_state:
        warn("The fitted equilibrium is not stable: its stiffness is negative in some motion.")
    for item in fitted.data:
        try:
            if item.check is not None:
                item.check(fitted.model)
        except ValueError as fault:
            warn(f"At the fitted parameters: {fault}")
    if fitted.result is RESULTS.poor_fit:
        far = [f"{name} {number} ({size:+.1f})" for name, number, size in fitted.largest_residuals()[:4]]
        named = f" Furthest, in standard deviations: {', '.join(far)}." if far else ""
        warn(f"The model does not fit the data: {fitted.reason}.{named} The intervals hold for a model that fits.")
    elif fitted.result is RESULTS.successful and not _chance_of_less(fitted.chi_squared, fitted.freedom) < IMPLAUSIBLE:
        warn_of_uneven_scatter(fitted)
    if fitted.active:
        warn(f"The fit is at a bound: {', '.join(fitted.active)}. The standard deviations neglect the bound.")
    if fitted.undetermined:
        texts = "; ".join(str(combination) for combination in fitted.undetermined)
        warn(f"The data do not determine {texts}. Measure another quantity, add a prior, or fix a parameter.")


def warn_of_uneven_scatter(fitted: Fit) -> None:
    """Warn of each measurement whose differences depend on the size of the answer."""
    rows, slopes, _ = fitted.problem.residuals(fitted.unit)
    basis, _ = np.linalg.qr(weighted_slopes(rows, slopes, fitted.problem.loss))
    # A value with a large effect on the fit differs less from the fitted model.
    remaining = 1 - np.sum(basis**2, axis=1)
    for item, part in zip(fitted.data, fitted.problem.parts, strict=True):
        if item.scatter is not None and item.scatter.ndim > 1:
            continue
        sizes = item.sizes(fitted.computed[item.name])
        ratio = ratio_of_scatter(rows[part], remaining[part], sizes)
        known = item.scatter is not None
        exact = not known and fitted.noise <= EXACT_FIT * (1.0 if item.relative else np.max(sizes))
        if ratio is not None and not exact:
            warn(_description(item, ratio, known))


def _description(item: Measured, ratio: float, known: bool) -> str:
    grows = ratio > 1
    subject = f"The differences of measurement '{item.name}' scatter {max(ratio, 1 / ratio):.2g} times as much where"
    subject += f" the answer is {'large as where it is small' if grows else 'small as where it is large'}"
    unit = "deviations" if known else "one common deviation"
    cause = f"{subject}, but the fit weighs them by {unit}. The intervals are {'too narrow' if grows else 'wrong'}."
    if item.relative:
        return f"{cause} Give deviations that describe the scatter, or omit logarithmic=True."
    by_logarithms = ", or logarithmic=True" if item.advice and not known else ""
    return (
        f"{cause} Give deviations that {'grow' if grows else 'fall'} with the answer"
        f"{f' (a relative deviation){by_logarithms}' if grows else ''}. Or the model is wrong there."
    )


def ratio_of_scatter(differences: np.ndarray, remaining: np.ndarray, sizes: np.ndarray) -> float | None:
    """Return the scatter at the largest quarter of the sizes over the scatter at the smallest quarter.

    Args:
        differences: Weighted differences, (m,).
        remaining: Share of the variance of each value that remains in its difference from a fitted model, (m,).
        sizes: Sizes of the answers, (m,).

    Returns:
        The ratio, or None if scatter of equal deviations explains it.

    Source:
        Rank correlation of absolute differences and sizes, which outliers hardly change: Spearman 1904.
    """
    from scipy.stats import spearmanr

    tested = remaining > UNTESTED
    differences, remaining, sizes = differences[tested], remaining[tested], sizes[tested]
    if len(sizes) < FEWEST_OF_SCATTER or np.ptp(sizes) == 0 or np.ptp(np.abs(differences)) == 0:
        return None
    test: Any = spearmanr(np.abs(differences) / np.sqrt(remaining), sizes)
    order, quarter = np.argsort(sizes, kind="stable"), len(sizes) // 4
    small, large = order[:quarter], order[-quarter:]
    scatter = [np.sqrt(np.sum(differences[at] ** 2) / np.sum(remaining[at])) for at in (large, small)]
    ratio = float(scatter[0] / max(scatter[1], np.finfo(float).tiny))
    if test.pvalue >= IMPLAUSIBLE or max(ratio, 1 / max(ratio, np.finfo(float).tiny)) <= UNEVEN_SCATTER:
        return None
    return ratio if (ratio > 1) == (test.statistic > 0) else None
