"""The search: an augmented Lagrangian around a method that keeps bounds, or least squares."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.by_meaning import jit
from ..errors import printable
from ..numerical_limits import (
    AT_BOUND,
    FIRST_STATIONARY,
    MISSED_BY_FIT,
    MISSED_TOLERANCES,
    NEARLY_STATIONARY,
    SOFT_TARGET_MET,
    STATIONARY,
    VIOLATION_FALLS,
)
from ..results import RESULTS
from .problem import TuningProblem

Kernel = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, int]]
History = list[tuple[np.ndarray, np.ndarray]]

FIRST_WEIGHT, WEIGHT_GROWTH, LARGEST_WEIGHT = 10.0, 10.0, 1e8
MAX_ROUNDS = 40


@dataclasses.dataclass
class Attempt:
    """One search from one start.

    Attributes:
        unit: Scaled dimensions at the end, (n,).
        answers: Answers there, (m,).
        result: Code of RESULTS.
        reason: Reason of the end, in words.
        objective: Objective there.
        violation: Violation there of the limits tightened by the tolerance.
        history: Scaled dimensions and answers of every evaluation.
    """

    unit: np.ndarray
    answers: np.ndarray
    result: RESULTS
    reason: str
    objective: float
    violation: float
    history: History

    @property
    def answered(self) -> bool:
        """Whether the start has answers."""
        return bool(self.history)


class _Stop(Exception):
    """No evaluations are left."""


class _Evaluations:
    """Answers and derivatives, with a budget, a history, and a memory of the last design."""

    def __init__(self, problem: TuningProblem, kernel: Kernel, budget: int, progress: Callable[..., Any] | None):
        self.problem, self.kernel, self.budget, self.progress = problem, kernel, budget, progress
        self.history: History = []
        self.count = 0
        self.failed = RESULTS.successful
        self.last: tuple[bytes, tuple] | None = None

    def __call__(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Answers and derivatives, or None if the design fails."""
        unit = np.clip(np.asarray(unit, float), 0.0, 1.0)
        key = unit.tobytes()
        if self.last is None or self.last[0] != key:
            if self.count >= self.budget:
                raise _Stop
            self.count += 1
            self.last = key, self.kernel(unit)
            values, slopes, code = self.last[1]
            if self.good(values, slopes, code):
                self.history.append((unit.copy(), values))
                if self.progress is not None:
                    self.progress(self.count, float(self.problem.objective(values)), self.problem.violation(values))
            else:
                self.failed = RESULTS.not_finite if code == RESULTS.successful else RESULTS(code)
        values, slopes, code = self.last[1]
        return (values, slopes) if self.good(values, slopes, code) else None

    @staticmethod
    def good(values: np.ndarray, slopes: np.ndarray, code: int) -> bool:
        return code == RESULTS.successful and bool(np.all(np.isfinite(values)) and np.all(np.isfinite(slopes)))


def search_from(
    problem: TuningProblem,
    kernel: Kernel,
    of_unit: Callable[[Any], Any],
    refused: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    optimizer: Any,
    tolerance: float,
    budget: int,
    *,
    progress: Callable[[int, float, float], None] | None = None,
) -> Attempt:
    """Search from one start."""
    evaluate = _Evaluations(problem, kernel, budget, progress)
    if evaluate(start) is None:
        nothing = np.full(problem.weights.shape, np.nan)
        return Attempt(start, nothing, evaluate.failed, "the start could not be computed", np.nan, np.nan, [])
    if not len(start):
        # There are choices only.
        end, reason, result = start, "no other dimension can vary", RESULTS.successful
        if problem.violation(evaluate.history[-1][1]) > tolerance:
            result = RESULTS.infeasible
    elif _is_least_squares_solver(optimizer):
        if not problem.only_targets:
            raise ValueError("A least-squares solver of optimistix accepts targets only. Leave out the rest.")
        end, reason, result = _by_optimistix(problem, of_unit, start, optimizer, budget)
    elif problem.only_targets and optimizer is None:
        end, reason, result = _least_squares(problem, evaluate, start)
    else:
        inner = _by_scipy(evaluate) if optimizer is None else _by_optax(problem, evaluate, of_unit, refused, optimizer)
        end, reason, result = _augmented(problem, evaluate, start, inner, tolerance)
    evaluate.budget += 2
    evaluation = evaluate(end)
    if evaluation is None:
        end, result = _best(problem, evaluate.history, tolerance), evaluate.failed
        reason = "the search ended at a design that fails"
        evaluation = evaluate(end) or (evaluate.history[-1][1], None)
    values = evaluation[0]
    if result is RESULTS.successful and evaluation[1] is not None:
        result = _met_or_why(problem, np.clip(end, 0.0, 1.0), values, evaluation[1], tolerance)
    if not problem.only_targets and (missed := problem.missed(problem.targets(values), SOFT_TARGET_MET)):
        reason += f"; the other goals keep answers from their targets: {', '.join(missed)}"
    objective, violation = float(problem.objective(values)), problem.violation(values)
    return Attempt(end, values, result, reason, objective, violation, evaluate.history)


def _met_or_why(
    problem: TuningProblem, unit: np.ndarray, values: np.ndarray, slopes: np.ndarray, tolerance: float
) -> RESULTS:
    """Whether targets are met at a stationary design, or else what holds it; beside an objective they are wishes."""
    residual = problem.targets(values)
    most = MISSED_BY_FIT if len(residual) > len(unit) else MISSED_TOLERANCES * tolerance
    if np.any(problem.weights) or np.max(np.abs(residual), initial=0.0) <= most:
        return RESULTS.successful
    slope = slopes.T @ (problem.targets.matrix.T @ residual)
    outwards = np.where(unit < AT_BOUND, slope, np.where(unit > 1 - AT_BOUND, -slope, 0.0))
    blocked = np.any(outwards > STATIONARY) or np.any(problem.limits(values) > -MISSED_TOLERANCES * tolerance)
    return RESULTS.target_missed if blocked or problem.equal.names or not len(unit) else RESULTS.local_minimum


def _is_least_squares_solver(optimizer: Any) -> bool:
    if optimizer is None:
        return False
    import optimistix

    return isinstance(optimizer, optimistix.AbstractLeastSquaresSolver)


Outcome = tuple[np.ndarray, str, RESULTS]


def _best(problem: TuningProblem, history: History, tolerance: float) -> np.ndarray:
    """Scaled dimensions of the best design so far, feasible ones first."""

    def rank(pair: tuple[np.ndarray, np.ndarray]):
        violation = problem.violation(pair[1])
        return (violation if violation > tolerance else 0.0, problem.objective(pair[1]))

    return min(history, key=rank)[0]


def _least_squares(problem: TuningProblem, evaluate: _Evaluations, start: np.ndarray) -> Outcome:
    import scipy.optimize

    count = len(problem.targets.names)

    def residual(unit: np.ndarray):
        evaluation = evaluate(unit)
        return np.full(count, np.nan) if evaluation is None else problem.targets(evaluation[0])

    def jacobian(unit: np.ndarray):
        evaluation = evaluate(unit)
        return np.full((count, len(unit)), np.nan) if evaluation is None else problem.targets.matrix @ evaluation[1]

    # The method starts inside the bounds.
    inside = np.clip(start, 1e-6, 1 - 1e-6)
    try:
        solution = scipy.optimize.least_squares(
            residual,
            inside,
            jac=jacobian,  # pyright: ignore[reportArgumentType]
            bounds=(0.0, 1.0),
            method="trf",
            ftol=1e-15,
            xtol=1e-13,
            gtol=1e-13,
            x_scale="jac",
        )
    except _Stop:
        return _best(problem, evaluate.history, 0.0), "max_evaluations reached", RESULTS.not_optimal
    far = problem.missed(solution.fun)
    reason = "nearest to the targets: " + ", ".join(far) if far else "all targets are met"
    return solution.x, reason, RESULTS.successful if solution.status > 0 else RESULTS.not_optimal


def _by_optimistix(
    problem: TuningProblem, of_unit: Callable[..., Any], start: np.ndarray, solver: Any, budget: int
) -> Outcome:
    """Solve within the bounds by u = (1 + sin v)/2: the solvers of optimistix have no bounds."""
    import optimistix

    def residual(angle: Float[Array, "n"], _: Any):
        values, _ = of_unit((1 + jnp.sin(angle)) / 2)
        return problem.targets(values)

    def solve(angle: Float[Array, "n"]):
        solution = optimistix.least_squares(residual, solver, angle, max_steps=budget, throw=False)
        return solution.value, solution.result == optimistix.RESULTS.successful

    # At a bound the sine is flat.
    angle, good = jit(solve)(np.arcsin(2 * np.clip(start, 1e-3, 1 - 1e-3) - 1))
    end = (1 + np.sin(np.asarray(angle))) / 2
    if bool(good):
        return end, "the solver of optimistix converged", RESULTS.successful
    return end, "the solver of optimistix did not converge", RESULTS.not_optimal


def _projected(unit: np.ndarray, gradient: np.ndarray) -> float:
    """Largest entry of the derivative that does not push against a bound."""
    return float(np.max(np.abs(np.clip(unit - gradient, 0.0, 1.0) - unit), initial=0.0))


def _augmented(
    problem: TuningProblem, evaluate: _Evaluations, start: np.ndarray, inner: Callable[..., Any], tolerance: float
) -> Outcome:
    """Rounds of a bounded minimisation, with better multipliers or a larger weight in each."""
    multipliers = np.zeros(len(problem.equal.names)), np.zeros(len(problem.limits.names))
    constrained = bool(problem.equal.names or problem.limits.names)
    weight, stationarity, before, unit = FIRST_WEIGHT, FIRST_STATIONARY if constrained else STATIONARY, np.inf, start
    nearest = np.inf, unit
    try:
        for _ in range(MAX_ROUNDS):
            last, unit = unit, inner(unit, multipliers, weight, stationarity)
            evaluation = evaluate(unit)
            if evaluation is None:
                end = _best(problem, evaluate.history, tolerance)
                return end, "the search ran into designs that fail", evaluate.failed
            values, slopes = evaluation
            violation = problem.violation(values)
            gradient_size = _projected(unit, slopes.T @ problem.slope(values, multipliers, weight))
            # A limit that is not reached has no multiplier at the optimum.
            updated = problem.updated(values, multipliers, weight)
            slack = np.max(np.abs(updated[1] * problem.limits(values)), initial=0.0)
            if violation <= tolerance and slack <= 10 * tolerance:
                if gradient_size <= 10 * STATIONARY:
                    return unit, "the conditions of an optimum hold", RESULTS.successful
                nearest = min(nearest, (gradient_size, unit), key=lambda pair: pair[0])
            # Multipliers do not help where round-off of the answers hides the descent.
            stuck = violation <= tolerance and gradient_size > stationarity and np.array_equal(unit, last)
            if stuck or not constrained:
                break
            if violation > max(VIOLATION_FALLS * before, tolerance) and weight < LARGEST_WEIGHT:
                weight *= WEIGHT_GROWTH
            multipliers, before, stationarity = updated, violation, max(0.1 * stationarity, STATIONARY)
    except _Stop:
        return _best(problem, evaluate.history, tolerance), "max_evaluations reached", RESULTS.not_optimal
    if nearest[0] <= NEARLY_STATIONARY or not constrained:
        why = "no further descent was found: the objective may have a kink there, or no more accurate digits"
        if evaluate.failed is not RESULTS.successful:
            why += f"; designs around it failed ({evaluate.failed.name})"
        return nearest[1], why, RESULTS.successful if nearest[0] <= NEARLY_STATIONARY else RESULTS.not_optimal
    end = _best(problem, evaluate.history, tolerance)
    if all(problem.violation(values) > tolerance for _, values in evaluate.history):
        return unit, "the limits cannot be kept", RESULTS.infeasible
    return end, "the multipliers did not settle", RESULTS.not_optimal


def _by_scipy(evaluate: _Evaluations):
    import scipy.optimize

    problem = evaluate.problem

    def inner(unit: np.ndarray, multipliers: tuple[Any, Any], weight: float, stationarity: float):
        known = [0.0]

        def merit(u: np.ndarray):
            evaluation = evaluate(u)
            if evaluation is None:
                # Worse than all known values: the line search steps back.
                return known[0] + 10 * (1 + abs(known[0])), np.zeros_like(u)
            values, slopes = evaluation
            value = float(problem.lagrangian(values, multipliers, weight))
            known[0] = max(known[0], value)
            return value, slopes.T @ problem.slope(values, multipliers, weight)

        options = {"ftol": 0.0, "gtol": stationarity, "maxiter": 10_000, "maxfun": 100_000, "maxcor": 20}
        limits = [(0.0, 1.0)] * len(unit)
        solution = scipy.optimize.minimize(merit, unit, jac=True, method="L-BFGS-B", bounds=limits, options=options)
        return np.clip(solution.x, 0.0, 1.0)

    return inner


def _by_optax(
    problem: TuningProblem, evaluate: _Evaluations, of_unit: Callable[..., Any], refused: Any, optimizer: Any
):
    import optax

    if not isinstance(optimizer, optax.GradientTransformation):
        text = printable(repr(optimizer))
        raise TypeError(f"Argument `optimizer` must be an optimiser of optax such as optax.adam(1e-2), but is {text}.")
    rule = optax.with_extra_args_support(optimizer)

    def step(unit: Any, state: Any, multipliers: Any, weight: Any):
        def merit(u: Float[Array, "n"]):
            values, code = of_unit(u)
            return problem.lagrangian(values, multipliers, weight), (values, code)

        (value, (values, code)), gradient = jax.value_and_grad(merit, has_aux=True)(unit)
        change, state = rule.update(gradient, state, unit, value=value, grad=gradient, value_fn=lambda u: merit(u)[0])
        return jnp.clip(unit + change, 0.0, 1.0), state, values, gradient, code

    compiled = jit(step)

    def inner(unit: np.ndarray, multipliers: tuple[Any, Any], weight: float, stationarity: float):
        state, at = rule.init(jnp.asarray(unit)), jnp.asarray(unit)
        while True:
            if evaluate.count >= evaluate.budget:
                raise _Stop
            after, state, values, gradient, code = compiled(at, state, multipliers, weight)
            point, gradient = np.asarray(at), np.asarray(gradient)
            if refused(point[None])[0] or not evaluate.good(values, gradient, int(code)):
                return point
            evaluate.count += 1
            evaluate.history.append((point, np.asarray(values)))
            if evaluate.progress is not None:
                values = np.asarray(values)
                evaluate.progress(evaluate.count, float(problem.objective(values)), problem.violation(values))
            if _projected(point, gradient) <= stationarity:
                return point
            at = after

    return inner
