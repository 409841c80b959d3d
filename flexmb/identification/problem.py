"""Least-squares problem of a fit: weighted differences of computed and measured values, and their slopes."""

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from ..compilation.by_meaning import jit
from ..design.evaluate import Layout, build_once, flat_function, with_slopes
from ..design.problem import Scaling
from ..errors import AnalysisError
from ..numerical_limits import NEGLIGIBLE, PART_IN_COMBINATION, SETTLED_COST, SETTLED_PARAMETERS, UNDETERMINED_SHARE
from ..results import ANSWERED, RESULTS
from .measurement import Measured, in_deviations, predicted

# Outcomes with an answer and a derivative.
GOOD = (RESULTS.successful, RESULTS.unstable_state)


class Prior(NamedTuple):
    """Prior mean and standard deviation of a parameter [SI]."""

    mean: float
    deviation: float


class Solution(NamedTuple):
    """End of a search.

    Attributes:
        unit: Scaled parameters, (n,).
        cost: Sum of squared weighted differences, after the robust loss.
        evaluations: Number of computed designs.
        converged: Whether the search ended by its tolerances.
    """

    unit: np.ndarray
    cost: float
    evaluations: int
    converged: bool


class FitProblem:
    """Weighted differences of a fit as a function of scaled parameters, from 0 to 1 between their bounds."""

    def __init__(
        self,
        build: Callable[..., Any],
        taken: tuple[str, ...],
        items: list[Measured],
        scaling: Scaling,
        priors: Mapping[int, Prior],
        first: np.ndarray,
        loss: str,
        max_evaluations: int,
    ):
        """Build the model once, without compilation.

        Args:
            build: Function of the parameters ``taken`` that returns a model.
            taken: Names of the arguments of ``build``. Other parameters belong to measurements.
            items: Measurements.
            scaling: Scaling of the parameters to numbers from 0 to 1.
            priors: Priors by the index of the parameter.
            first: Start, (n,) [SI].
            loss: Loss of ``scipy.optimize.least_squares``.
            max_evaluations: Largest number of evaluations of each search.
        """
        self.items, self.scaling, self.priors, self.first = items, scaling, priors, first
        self.loss, self.max_evaluations = loss, max_evaluations

        @functools.wraps(build)
        def with_parameters(**parameters: Any) -> Any:
            return build(**{name: parameters[name] for name in taken}), parameters

        self.build = with_parameters
        self.models = build_once(with_parameters, self.layout.split(first))
        self.function, self.computed = self.function_of({item.name: prediction_of(item) for item in items})
        ends = np.cumsum(self.computed.sizes)
        self.parts = [slice(end - size, end) for end, size in zip(ends, self.computed.sizes, strict=True)]

    @property
    def layout(self) -> Layout:
        """Names and shapes of the parameters."""
        return self.scaling.layout

    def function_of(
        self, answers: Mapping[str, Callable[[Any], Any]]
    ) -> tuple[Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]], Layout]:
        """Return the compiled function from scaled parameters to answers, slopes and code, and the answers' layout."""
        function, layout = flat_function(self.build, answers, self.layout, self.models)

        def of_unit(unit: Float[jax.Array, "n"]):
            return function(self.scaling.to_dimensions(unit))

        compiled = jit(with_slopes(of_unit, sum(self.layout.sizes), sum(layout.sizes)))

        def call(unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
            slopes, (values, code) = compiled(jnp.asarray(unit))
            return np.asarray(values), np.asarray(slopes), int(code)

        return call, layout

    def traced(self) -> Callable[[Any, Any], tuple[Any, Any, Any]]:
        """Return the function, for a trace, from scaled parameters and measured values to the results of `residuals`.

        The last result is whether the design has an answer and a derivative.
        """
        answers = {item.name: prediction_of(item) for item in self.items}
        function, layout = flat_function(self.build, answers, self.layout, self.models)

        def rows_of(unit: Float[jax.Array, "n"], values: Float[jax.Array, "m"]):
            flat = self.scaling.to_dimensions(unit)
            computed, code = function(flat)
            priors = [jnp.ravel((flat[i] - prior.mean) / prior.deviation) for i, prior in self.priors.items()]
            return jnp.concatenate([self.weighted(computed - values), *priors]), code

        differentiated = with_slopes(rows_of, sum(self.layout.sizes), sum(layout.sizes))

        def evaluate(unit: Float[jax.Array, "n"], values: Float[jax.Array, "m"]):
            slopes, (rows, code) = differentiated(unit, values)
            return rows, slopes, jnp.any(code == jnp.array([int(result) for result in GOOD], code.dtype))

        return evaluate

    def asked_at(
        self, unit: np.ndarray, answers: Mapping[str, Callable[[Any], Any]]
    ) -> tuple[np.ndarray, np.ndarray, Layout]:
        """Return answers of (model, parameters), their slopes and their layout; AnalysisError if not finite."""
        call, layout = self.function_of(answers)
        values, slopes, code = call(unit)
        if code not in ANSWERED:
            raise AnalysisError(RESULTS(code).name, f"The fitted mechanism has no answer. {RESULTS(code).message}")
        for name, row in zip(layout.labels, slopes, strict=True):
            if not np.all(np.isfinite(row)):
                text = f"'{name}' has no finite derivative at the fitted parameters."
                raise AnalysisError(RESULTS.not_finite.name, text)
        return values, slopes, layout

    @property
    def measured(self) -> np.ndarray:
        """Values of all measurements, (m,)."""
        return np.concatenate([item.values for item in self.items])

    def weighted(self, differences: Any) -> Any:
        """Return differences (m, ...), which may be traced, in standard deviations."""
        rows = [in_deviations(item, differences[p]) for item, p in zip(self.items, self.parts, strict=True)]
        return (jnp if isinstance(differences, jax.Array) else np).concatenate(rows)

    def residuals(self, unit: np.ndarray, values: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, int]:
        """Return weighted differences, measurements before priors, their slopes, and a code of RESULTS."""
        computed, slopes, code = self.function(unit)
        measured = self.measured if values is None else values
        rows, slope_rows = [self.weighted(computed - measured)], [self.weighted(slopes)]
        if self.priors:
            flat, change = self.scaling.to_dimensions(unit), self.scaling.slopes(unit)
            for i, prior in self.priors.items():
                rows.append(np.array([(flat[i] - prior.mean) / prior.deviation]))
                slope_rows.append(np.eye(len(unit))[i : i + 1] * change[i] / prior.deviation)
        return np.concatenate(rows), np.concatenate(slope_rows), code

    def solve(
        self, start: np.ndarray, *, values: np.ndarray | None = None, fixed: Mapping[int, float] | None = None
    ) -> Solution:
        """Search from a start, with optional other measured values and fixed scaled parameters."""
        import scipy.optimize

        fixed = dict(fixed or {})
        free = np.array([i for i in range(len(start)) if i not in fixed], int)
        last: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
        count = 0

        def whole(part: np.ndarray) -> np.ndarray:
            unit = np.array(start, float)
            unit[list(fixed)] = list(fixed.values())
            unit[free] = part
            return unit

        def at(part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            nonlocal count
            key = part.tobytes()
            if key not in last:
                count += 1
                rows, slopes, code = self.residuals(whole(part), values)
                bad = code not in GOOD or not np.all(np.isfinite(slopes))
                last.clear()
                last[key] = (np.full_like(rows, np.nan) if bad else rows), slopes[:, free]
            return last[key]

        if not len(free):
            rows, _ = at(np.zeros(0))
            return Solution(whole(np.zeros(0)), float(np.sum(robust(rows, self.loss)[0])), 1, True)
        # SciPy needs a start inside the bounds.
        inside = np.clip(np.asarray(start, float)[free], 1e-6, 1 - 1e-6)
        if not np.all(np.isfinite(at(inside)[0])):
            return Solution(whole(inside), np.inf, 1, False)
        # Without deviations, rows are in SI units, and SciPy compares gradients with absolute numbers.
        known = self.items[0].scatter is not None
        size = 1.0 if known else float(np.sqrt(np.mean(at(inside)[0] ** 2))) or 1.0
        solution = scipy.optimize.least_squares(
            lambda part: at(part)[0] / size,
            inside,
            jac=lambda part: at(part)[1] / size,  # pyright: ignore[reportArgumentType]
            bounds=(0.0, 1.0),
            loss=self.loss,
            x_scale="jac",
            ftol=SETTLED_COST,
            xtol=SETTLED_PARAMETERS,
            gtol=SETTLED_PARAMETERS if known else None,  # pyright: ignore[reportArgumentType]
            max_nfev=self.max_evaluations,
        )
        return Solution(whole(solution.x), 2 * float(solution.cost) * size**2, count, solution.status > 0)


def prediction_of(item: Measured) -> Callable[[Any], Any]:
    """Return the answer of a measurement as a function of the pair (model, parameters)."""
    return lambda made: predicted(item, *made)


def robust(rows: Any, loss: str) -> tuple[Any, Any]:
    """Return the robust loss (as in SciPy) of each weighted difference, and its weight in the normal equations."""
    arrays = jnp if isinstance(rows, jax.Array) else np
    squares = rows**2
    if loss == "linear":
        return squares, arrays.ones_like(rows)
    if loss == "huber":
        inner = squares <= 1
        root = arrays.sqrt(arrays.maximum(squares, 1.0))
        return arrays.where(inner, squares, 2 * root - 1), arrays.where(inner, 1.0, 1 / root)
    if loss == "soft_l1":
        root = arrays.sqrt(1 + squares)
        return 2 * (root - 1), 1 / root
    return arrays.log1p(squares), 1 / (1 + squares)


def weighted_slopes(rows: np.ndarray, slopes: np.ndarray, loss: str) -> np.ndarray:
    """Return slopes of weighted differences, times the root of the weight of the robust loss."""
    return slopes * np.sqrt(robust(rows, loss)[1])[:, None]


@dataclasses.dataclass(frozen=True)
class Undetermined:
    """Parameters that may change together and hardly change the computed values.

    Attributes:
        names: Names of the k parameters.
        change: Change of each parameter, with the largest change equal to 1, (k,) [-]. Changes are relative to the
            parameter (logarithmic scale) or to the distance between its bounds (linear scale).
        determined: Determined products of powers of these parameters, in words; may be empty.
        deviation: Standard deviation along the change, as a share of the distance between the bounds [-]; infinite if
            the computed values do not change at all.
    """

    names: tuple[str, ...]
    change: np.ndarray
    determined: tuple[str, ...]
    deviation: float

    def __str__(self) -> str:
        if len(self.names) == 1:
            return f"'{self.names[0]}'"
        changes = ", ".join(f"{name} {100 * part:+.3g} %" for name, part in zip(self.names, self.change, strict=True))
        text = f"{' and '.join(self.names)} (together: {changes})"
        return text + (f", but {' and '.join(self.determined)}" if self.determined else "")


def directions(slopes: np.ndarray, noise: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return principal directions of weighted slopes: deviations, directions as columns, and which are undetermined."""
    n = slopes.shape[1]
    _, singular, rows = np.linalg.svd(slopes, full_matrices=True)
    singular = np.concatenate([singular, np.zeros(n - len(singular))])
    zero = singular <= NEGLIGIBLE * max(singular[0], np.finfo(float).tiny)
    with np.errstate(divide="ignore"):
        deviations = np.where(zero, np.inf, noise / np.where(zero, 1.0, singular))
    return deviations, rows.T, deviations > UNDETERMINED_SHARE


def combinations_of(
    problem: FitProblem, unit: np.ndarray, slopes: np.ndarray, noise: float
) -> tuple[Undetermined, ...]:
    """Return the combinations of parameters that the data do not determine."""
    deviations, columns, wide = directions(slopes, noise)
    scaling = problem.scaling
    relative = np.where(scaling.log, scaling.slopes(unit) / np.where(scaling.log, scaling.to_dimensions(unit), 1), 1.0)
    labels = problem.layout.labels
    return tuple(
        _combination(labels, columns[:, k] * relative, columns[:, k], scaling.log, float(deviations[k]))
        for k in np.flatnonzero(wide)
    )


def _combination(
    labels: Sequence[str], change: np.ndarray, column: np.ndarray, logarithmic: np.ndarray, deviation: float
) -> Undetermined:
    part = np.flatnonzero(np.abs(column) > PART_IN_COMBINATION)
    change = change[part] / change[part][np.argmax(np.abs(change[part]))]
    names = tuple(labels[int(i)] for i in part)
    determined: tuple[str, ...] = ()
    if len(part) > 1 and np.all(logarithmic[part]):
        # p_i p_0^e is constant for e = -change_i/change_0.
        first = int(np.argmax(np.abs(change)))
        determined = tuple(
            f"{names[i]} * {names[first]}^{-change[i] / change[first]:.3g} is determined"
            for i in range(len(names))
            if i != first
        )
    return Undetermined(names, change, determined, deviation)
