"""Result of a fit: parameters, standard deviations, intervals, predictions and profile likelihood."""

import dataclasses
from collections.abc import Sequence
from functools import partial
from typing import Annotated, Any

import numpy as np

from ..arguments import Count, WholeFromZero, check_number, check_whole, checked
from ..design.designs import float_array
from ..design.evaluate import Answers, named_answers, refusal_of_designs
from ..display import Result, Summary
from ..errors import printable
from ..numerical_limits import OUTLIER, PART_IN_COMBINATION
from ..results import RESULTS
from .measurement import Measured, in_deviations, measurements
from .posterior import Posterior, sampled_posterior
from .problem import FitProblem, Undetermined, directions, prediction_of, weighted_slopes
from .repeated import repeated


@dataclasses.dataclass(frozen=True, repr=False)
class Fit(Result):
    """Fitted parameters of a mechanism.

    Attributes:
        parameters: Fitted parameters by name [SI].
        start: Parameters at the start of the search, by name [SI].
        deviation: Standard deviation of each parameter, by name [SI]; infinite if the data do not determine it.
        covariance: Covariance of the parameters in the order of ``labels``, (n, n) [SI]. It leaves out combinations
            that the data do not determine.
        labels: Names of all parameters, "height[3]" for an entry of an array.
        computed: Values of each measurement by the fitted model, by name.
        residuals: Computed minus measured values in standard deviations, decorrelated, by name [-].
        chi_squared: Sum of the squares of the residuals, and of the priors [-]; NaN if the scatter is not known.
        freedom: Number of values and priors minus number of determined parameters.
        probability: Probability that scatter alone causes a chi-squared at least as large [-]; NaN if the scatter is
            not known.
        noise: Factor of the standard deviations: 1, or the estimated standard deviation of the values if none was
            given.
        undetermined: Combinations of parameters that the data do not determine.
        active: Parameters at a bound.
        minima: Parameters and chi-squared of all different minima, the lowest minimum first.
        result: Code of RESULTS: successful, not_optimal, poor_fit, impossible_design.
        reason: The result in words.
        evaluations: Number of computed designs.
        data: The measurements.
        problem: Least-squares problem that computes predictions.
        unit: Parameters as numbers from 0 to 1 between their bounds, (n,).
    """

    parameters: dict[str, Any]
    start: dict[str, Any]
    deviation: dict[str, Any]
    covariance: np.ndarray
    labels: tuple[str, ...]
    computed: dict[str, np.ndarray]
    residuals: dict[str, np.ndarray]
    chi_squared: float
    freedom: int
    probability: float
    noise: float
    undetermined: tuple[Undetermined, ...]
    active: tuple[str, ...]
    minima: tuple[tuple[dict[str, Any], float], ...]
    result: RESULTS
    reason: str
    evaluations: int
    data: tuple[Measured, ...]
    problem: FitProblem
    unit: np.ndarray

    @property
    def model(self) -> Any:
        """The mechanism with the fitted parameters."""
        return self.problem.build(**self.parameters)[0]

    @property
    def correlation(self) -> np.ndarray:
        """Correlation of the parameters, (n, n) [-]; NaN for undetermined parameters."""
        sizes = np.sqrt(np.diag(self.covariance))
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.covariance / np.outer(sizes, sizes)

    @property
    def computed_deviation(self) -> dict[str, np.ndarray]:
        """Standard deviation of the computed values of each measurement due to the scatter of the data, by name."""
        spread = self._propagated(self.problem.function(self.unit)[1])
        return {item.name: spread[part] for item, part in zip(self.data, self.problem.parts, strict=True)}

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """Confidence interval of a parameter, lower and upper end [SI].

        The interval is symmetric; for a logarithmic scale, it is symmetric in the logarithm of the parameter. It uses
        the linearised model at the fit; :meth:`profile` does not.

        Args:
            name: Name of a parameter; "height[3]" for an entry of an array.
            level: Probability that the interval contains the true value [-].

        Returns:
            Lower and upper end. If the data do not determine the parameter, the ends are 0 or minus infinity, and
            infinity.

        Raises:
            KeyError: No such parameter.
            ValueError: The level is not between 0 and 1.
        """
        check_number("level", level, above=0, most=1)
        i = self._place(name)
        value = self.problem.layout.join(self.parameters)[i]
        width = self._quantile(level) * self.problem.layout.join(self.deviation)[i]
        if not self.problem.scaling.log[i]:
            return float(value - width), float(value + width)
        with np.errstate(over="ignore"):
            return float(value * np.exp(-width / value)), float(value * np.exp(width / value))

    def _place(self, name: str) -> int:
        if name not in self.labels:
            raise KeyError(f"There is no parameter '{printable(name)}': parameters are {', '.join(self.labels)}.")
        return self.labels.index(name)

    def _quantile(self, level: float) -> float:
        from scipy.stats import norm, t

        upper = (1 + level) / 2
        return float(norm.ppf(upper) if np.isfinite(self.chi_squared) else t.ppf(upper, max(self.freedom, 1)))

    def predict(self, answers: Answers) -> "dict[str, Prediction]":
        """Compute answers of the fitted mechanism, with standard deviations due to the scatter of the data.

        Args:
            answers: Functions of the model, or questions such as "frequency 4", as for ``fm.tune``.

        Returns:
            Prediction by name. The deviation is infinite if the answer depends on an undetermined combination of
            parameters.

        Raises:
            AnalysisError: An answer has no value or no finite derivative at the fitted parameters.

        Source:
            Linear propagation of the covariance by exact derivatives.
        """
        functions = named_answers(answers)
        of_models = {name: _of_model(function) for name, function in functions.items()}
        values, slopes, layout = self.problem.asked_at(self.unit, of_models)
        deviations = self._propagated(slopes)
        split = layout.split(values), layout.split(deviations)
        return {name: Prediction(split[0][name], split[1][name]) for name in functions}

    def _propagated(self, slopes: np.ndarray) -> np.ndarray:
        """Return standard deviations of answers, (m,), from their slopes by the scaled parameters, (m, n)."""
        finite, infinite = self._scaled_covariance()
        deviations = np.sqrt(np.einsum("ai,ij,aj->a", slopes, finite, slopes))
        sizes = np.linalg.norm(slopes, axis=1)
        depends = np.any(np.abs(slopes @ infinite) > 1e-6 * np.maximum(sizes, 1e-300)[:, None], axis=1)
        return np.where(depends, np.inf, deviations)

    def _scaled_covariance(self) -> tuple[np.ndarray, np.ndarray]:
        """Return :func:`scaled_covariance` at the fitted parameters."""
        rows, slopes, _ = self.problem.residuals(self.unit)
        return scaled_covariance(weighted_slopes(rows, slopes, self.problem.loss), self.noise)

    def profile(self, name: str, *, level: float = 0.95, points: int = 9) -> "ProfileLikelihood":
        """Compute the profile likelihood of a parameter: chi-squared at each value, with the other parameters fitted.

        Args:
            name: Name of a parameter.
            level: Level of the confidence interval [-].
            points: Number of values. They extend over twice the linearised interval, within the bounds.

        Returns:
            ProfileLikelihood, with an interval without linearisation.

        Raises:
            KeyError: No such parameter.

        Source:
            Venzon, Moolgavkar 1988. At the ends of the interval, the growth of chi-squared is the square of the
            quantile.
        """
        from scipy.optimize import brentq

        i, scaling = self._place(name), self.problem.scaling
        best = self.problem.solve(self.unit, fixed={i: float(self.unit[i])}).cost
        growth = self._quantile(level) ** 2 * self.noise**2
        change = self.problem.scaling.slopes(self.unit)[i]
        width = self._quantile(level) * self.problem.layout.join(self.deviation)[i] / change
        width = min(width, 1.0)
        starts: dict[float, np.ndarray] = {float(self.unit[i]): self.unit}

        def cost(place: float) -> float:
            nearest = min(starts, key=lambda known: abs(known - place))
            solution = self.problem.solve(starts[nearest], fixed={i: place})
            if np.isfinite(solution.cost):
                starts[place] = solution.unit
            return solution.cost

        def end(side: int) -> float:
            inner, outer = float(self.unit[i]), float(self.unit[i])
            bound = 0.0 if side < 0 else 1.0
            for _ in range(12):
                outer = float(np.clip(inner + side * 1.1 * width, 0.0, 1.0))
                if outer == inner or cost(outer) - best > growth:
                    break
                inner = outer
            if outer in (inner, bound) and cost(outer) - best <= growth:
                return -np.inf if side < 0 else np.inf
            root: Any = brentq(lambda place: cost(place) - best - growth, inner, outer, xtol=1e-3 * width)
            return root

        lower, upper = end(-1), end(1)
        first, last = (float(np.clip(self.unit[i] + side * 2 * width, 0.0, 1.0)) for side in (-1, 1))
        places = np.linspace(first, last, points)
        costs = np.array([cost(float(place)) for place in places])

        def value(place: float) -> float:
            unit = np.array(self.unit)
            unit[i] = np.clip(place, 0.0, 1.0)
            return float(scaling.to_dimensions(unit)[i]) if np.isfinite(place) else place

        values = np.array([value(place) for place in places])
        linear = ((places - self.unit[i]) * change / self.problem.layout.join(self.deviation)[i]) ** 2
        return ProfileLikelihood(
            name,
            values,
            (costs - best) / self.noise**2,
            (value(lower), value(upper)),
            level,
            self._quantile(level) ** 2,
            linear,
        )

    @checked
    def sample(
        self,
        count: Annotated[int, partial(check_whole, least=4)] = 1000,
        *,
        warmup: Count = 500,
        chains: Count = 2,
        seed: WholeFromZero = 0,
    ) -> Posterior:
        """Sample the posterior distribution of the parameters, which need not be normal.

        Without a prior, a parameter has a uniform density between its bounds, in its logarithm if its scale is
        logarithmic. An unknown standard deviation of the values has a prior density proportional to 1/deviation. flexmb
        integrates over this deviation.

        Args:
            count: Number of samples of each chain.
            warmup: Number of earlier samples of each chain, in which the sampler adapts its step size.
            chains: Number of chains, computed one after the other.
            seed: Seed of the random numbers.

        Returns:
            Posterior, with credible intervals and predictions.

        Raises:
            ImportError: numpyro is not installed (extra ``bayes``).
            ValueError: The fit has a robust loss, which corresponds to no distribution.

        Warns:
            FlexmbWarning: The samples do not represent the posterior: the sampler failed at a sample, the chains
                differ, or there are too few independent samples.

        Source:
            No-U-turn sampler: Hoffman, Gelman 2014 (numpyro).
        """
        if self.problem.loss != "linear":
            raise ValueError(f"The loss '{self.problem.loss}' corresponds to no distribution. Fit with loss='linear'.")
        return sampled_posterior(self, count, warmup, chains, seed)

    def next_measurement(
        self, candidates: Any, *, narrow: str | Sequence[str] | None = None
    ) -> "list[tuple[str, float]]":
        """Rank additional measurements by the reduction of the standard deviations.

        Args:
            candidates: Measurements as for :func:`flexmb.fit`, with expected standard deviations. flexmb ignores their
                values.
            narrow: Name or names of the parameters, or questions such as "frequency 4", whose standard deviations to
                reduce (A-optimal). By default flexmb reduces the volume of the confidence region of all parameters
                (D-optimal).

        Returns:
            Name of each candidate and the remaining fraction of the standard deviation [-], the best candidate first.
            For several numbers: root mean square of their fractions. For the volume: n-th root of its fraction.

        Raises:
            ValueError: The data do not determine a combination of parameters, or a candidate has no deviation.
            KeyError: No such parameter or question.

        Source:
            Sum of the Fisher information of independent measurements: Pukelsheim 2006.
        """
        if self.undetermined:
            raise ValueError(
                f"The data do not determine {self.undetermined[0]}: add a prior for it, then compare measurements."
            )
        items = measurements(candidates)
        for item in items:
            if item.scatter is None:
                raise ValueError(f"Candidate '{item.name}' has no deviation: give the expected standard deviation.")
        names = [narrow] if isinstance(narrow, str) else list(narrow or ())
        narrowed_slopes = [self._slopes_of(name) for name in names]
        _, slopes, layout = self.problem.asked_at(self.unit, {item.name: prediction_of(item) for item in items})
        ends = np.cumsum(layout.sizes)
        differences, present, _ = self.problem.residuals(self.unit)
        information = weighted_slopes(differences, present, self.problem.loss)
        information = information.T @ information / self.noise**2
        before = np.linalg.inv(information)
        shares = []
        for item, size, last in zip(items, layout.sizes, ends, strict=True):
            added = in_deviations(item, slopes[last - size : last])
            after = np.linalg.inv(information + added.T @ added)
            if narrowed_slopes:
                rows = np.concatenate(narrowed_slopes)
                ratio = np.sum((rows @ after) * rows, axis=1) / np.sum((rows @ before) * rows, axis=1)
                share = float(np.sqrt(np.mean(ratio)))
            else:
                share = float(np.exp((np.linalg.slogdet(after)[1] - np.linalg.slogdet(before)[1]) / (2 * len(after))))
            shares.append((item.name, share))
        return sorted(shares, key=lambda pair: pair[1])

    def _slopes_of(self, name: str) -> np.ndarray:
        """Return derivatives of a parameter or of the answer to a question by the scaled parameters, (m, n)."""
        if name in self.labels:
            return np.eye(len(self.labels))[[self._place(name)]]
        try:
            functions = {key: _of_model(function) for key, function in named_answers(name).items()}
            slopes = self.problem.asked_at(self.unit, functions)[1]
        except KeyError:
            known = ", ".join(self.labels)
            raise KeyError(f"There is no parameter or question '{printable(name)}': parameters are {known}.") from None
        if np.any(~np.any(slopes != 0, axis=1)):
            raise ValueError(f"'{printable(name)}' depends on no parameter.")
        return slopes

    def again(self, values: Any) -> "Refitted":
        """Fit other measured values of the same quantities. Each search starts from this fit.

        flexmb fits 50 sets and more in one compiled program on all cores.

        Args:
            values: Sets of values, (sets, m). A set has the values of all measurements, in the order of ``data``.

        Returns:
            Refitted, with the parameters of each set.

        Raises:
            ValueError: There is no set, a set has another number of values, or a value is not finite. A measurement is
                logarithmic: its values are logarithms of ratios to its own response.
        """
        if relative := [item.name for item in self.data if item.relative]:
            raise ValueError(
                f"Measurement '{relative[0]}' is logarithmic: flexmb compares logarithms of ratios to its response. Fit"
                " other responses by fm.fit, or leave out logarithmic=True."
            )
        sets = np.atleast_2d(float_array("Sets of values", values))
        if sets.ndim != 2 or not len(sets) or sets.shape[1] != len(self.problem.measured):
            raise ValueError(f"Give sets of {len(self.problem.measured)} values each, not an array of {sets.shape}.")
        if len(wrong := np.argwhere(~np.isfinite(sets))):
            row, place = wrong[0]
            raise ValueError(f"Value {place + 1} of set [{row}] is {sets[row, place]}. Leave this set out.")
        ends = repeated(self.problem, self.unit, sets)
        noise, squares = np.full(len(sets), self.noise), ends.squares
        if not np.isfinite(self.chi_squared):
            noise, squares = np.sqrt(squares / max(self.freedom, 1)), np.full(len(sets), np.nan)
        scaling, layout = self.problem.scaling, self.problem.layout
        deviations = [
            scaled_deviations(root, set_noise or np.finfo(float).tiny) * scaling.slopes(unit)
            for root, set_noise, unit in zip(ends.roots, noise, ends.units, strict=True)
        ]
        parameters = layout.stacked(scaling.to_dimensions(ends.units))
        # The traced build of the search cannot check numbers.
        refused = refusal_of_designs(self.problem.build, self.problem.models, layout.split(self.problem.first))(
            parameters
        )
        return Refitted(parameters, layout.stacked(deviations), squares, ends.converged & ~refused)

    def summary(self) -> Summary:
        """Return parameters with standard deviations, and chi-squared."""
        rows = {}
        flat, spread = self.problem.layout.join(self.parameters), self.problem.layout.join(self.deviation)
        for name, value, deviation in zip(self.labels, flat, spread, strict=True):
            scatter = f"± {deviation:.2g} (1 standard deviation)" if np.isfinite(deviation) else "not determined"
            rows[name] = f"{value:.6g} {scatter}"
        if np.isfinite(self.chi_squared):
            rows["chi-squared"] = f"{self.chi_squared:.4g} with {self.freedom} degrees of freedom"
        else:
            rows["deviation of the values"] = f"{self.noise:.3g}, from the misfit"
        for combination in self.undetermined:
            rows["not determined"] = "; ".join(filter(None, (rows.get("not determined"), str(combination))))
        if self.active:
            rows["at bounds"] = ", ".join(self.active)
        return Summary(f"Fit, {self.result.name}: {self.reason}", rows, "fit")

    def largest_residuals(self) -> list[tuple[str, int, float]]:
        """Return name, number (from 1) and difference of values beyond three deviations, the largest first."""
        outliers = [
            (name, int(i) + 1, float(rows[i]))
            for name, rows in self.residuals.items()
            for i in np.flatnonzero(np.abs(rows) > OUTLIER * self.noise)
        ]
        return sorted(outliers, key=lambda entry: -abs(entry[2]))


@dataclasses.dataclass(frozen=True)
class Prediction:
    """An answer of a fitted mechanism.

    Attributes:
        value: Value at the fitted parameters [unit of the answer].
        deviation: Standard deviation due to the scatter of the data, of the same shape [unit of the answer].
    """

    value: np.ndarray
    deviation: np.ndarray


@dataclasses.dataclass(frozen=True, repr=False)
class ProfileLikelihood(Result):
    """Profile likelihood of a parameter.

    Attributes:
        name: Name of the parameter.
        values: Values of the parameter, (points,) [SI].
        growth: Chi-squared minus its minimum at each value, with the other parameters fitted, (points,) [-].
        interval: Confidence interval [SI]. An end is infinite if the search reaches the bound first.
        level: Level of the interval [-].
        threshold: Growth at the ends of the interval [-].
        linear: Growth by the linearised model at each value, (points,) [-].
    """

    name: str
    values: np.ndarray
    growth: np.ndarray
    interval: tuple[float, float]
    level: float
    threshold: float
    linear: np.ndarray

    def summary(self) -> Summary:
        """Return the interval."""
        lower, upper = self.interval
        rows = {
            "interval": f"{lower:.6g} to {upper:.6g} ({self.level:.0%})",
            "values": f"{len(self.values)}, from {np.min(self.values):.6g} to {np.max(self.values):.6g}",
        }
        return Summary(f"Profile likelihood of {self.name}", rows, "profile")


@dataclasses.dataclass(frozen=True)
class Refitted:
    """Fits of several sets of values.

    Attributes:
        parameters: Parameters by name, (sets, ...) [SI].
        deviation: Standard deviations by name, (sets, ...) [SI]; infinite if the data do not determine a parameter.
        chi_squared: Chi-squared of each set, (sets,) [-]; NaN if the scatter is not known.
        converged: Whether each search ended by its tolerances, at parameters of a possible mechanism, (sets,).
    """

    parameters: dict[str, np.ndarray]
    deviation: dict[str, np.ndarray]
    chi_squared: np.ndarray
    converged: np.ndarray


def scaled_covariance(slopes: np.ndarray, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the covariance of scaled parameters in determined directions, (n, n), and other directions as columns."""
    deviations, columns, wide = directions(slopes, noise)
    root = columns[:, ~wide] * deviations[~wide]
    return root @ root.T, columns[:, wide]


def scaled_deviations(slopes: np.ndarray, noise: float) -> np.ndarray:
    """Return standard deviations of scaled parameters, (n,), infinite for undetermined parameters."""
    finite, infinite = scaled_covariance(slopes, noise)
    undetermined = np.any(np.abs(infinite) > PART_IN_COMBINATION, axis=1)
    return np.where(undetermined, np.inf, np.sqrt(np.diag(finite)))


def _of_model(function: Any) -> Any:
    return lambda made: function(made[0])
