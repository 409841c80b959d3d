"""Searches, also several at once: an augmented Lagrangian around a method that keeps bounds, or least squares."""

import dataclasses
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
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
Outcome = tuple[np.ndarray, str, RESULTS]

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
    return _TuningSearch(problem, kernel, of_unit, refused, optimizer, tolerance, budget, progress).attempt(start)


@dataclasses.dataclass
class _TuningSearch:
    """One search: answers and derivatives with a budget, a history, and a memory of the last design."""

    problem: TuningProblem
    kernel: Kernel
    of_unit: Callable[[Any], Any]
    refused: Callable[[np.ndarray], np.ndarray]
    optimizer: Any
    tolerance: float
    budget: int
    progress: Callable[[int, float, float], None] | None
    history: History = dataclasses.field(default_factory=list)
    count: int = 0
    failed: RESULTS = RESULTS.successful
    last: tuple[bytes, tuple] | None = None

    def evaluate(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
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
                self.note(unit.copy(), values)
            else:
                self.failed = RESULTS.not_finite if code == RESULTS.successful else RESULTS(code)
        values, slopes, code = self.last[1]
        return (values, slopes) if self.good(values, slopes, code) else None

    def note(self, unit: np.ndarray, values: np.ndarray) -> None:
        """Add a design to the history, and report it."""
        self.history.append((unit, values))
        if self.progress is not None:
            self.progress(self.count, float(self.problem.objective(values)), self.problem.violation(values))

    @staticmethod
    def good(values: np.ndarray, slopes: np.ndarray, code: int) -> bool:
        return code == RESULTS.successful and bool(np.all(np.isfinite(values)) and np.all(np.isfinite(slopes)))

    def best(self) -> np.ndarray:
        """Scaled dimensions of the best design so far, feasible ones first."""

        def rank(pair: tuple[np.ndarray, np.ndarray]):
            violation = self.problem.violation(pair[1])
            return (violation if violation > self.tolerance else 0.0, self.problem.objective(pair[1]))

        return min(self.history, key=rank)[0]

    def attempt(self, start: np.ndarray) -> Attempt:
        """Search from a start."""
        problem, optimizer = self.problem, self.optimizer
        if self.evaluate(start) is None:
            nothing = np.full(problem.weights.shape, np.nan)
            return Attempt(start, nothing, self.failed, "the start could not be computed", np.nan, np.nan, [])
        if not len(start):
            # There are choices only.
            end, reason, result = start, "no other dimension can vary", RESULTS.successful
            if problem.violation(self.history[-1][1]) > self.tolerance:
                result = RESULTS.infeasible
        elif _is_least_squares_solver(optimizer):
            if not problem.only_targets:
                raise ValueError("A least-squares solver of optimistix accepts targets only. Leave out the rest.")
            end, reason, result = self.by_optimistix(start)
        elif problem.only_targets and optimizer is None:
            end, reason, result = self.least_squares(start)
        else:
            end, reason, result = self.augmented(start, self.by_scipy if optimizer is None else self.by_optax())
        self.budget += 2
        evaluation = self.evaluate(end)
        if evaluation is None:
            end, result = self.best(), self.failed
            reason = "the search ended at a design that fails"
            evaluation = self.evaluate(end) or (self.history[-1][1], None)
        values, slopes = evaluation
        if result is RESULTS.successful and slopes is not None:
            result = self.met_or_why(np.clip(end, 0.0, 1.0), values, slopes)
        if not problem.only_targets and (missed := problem.missed(problem.targets(values), SOFT_TARGET_MET)):
            reason += f"; the other goals keep answers from their targets: {', '.join(missed)}"
        objective, violation = float(problem.objective(values)), problem.violation(values)
        return Attempt(end, values, result, reason, objective, violation, self.history)

    def met_or_why(self, unit: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> RESULTS:
        """Code of RESULTS at a stationary design: targets met, or why not; beside an objective they need not be met."""
        problem = self.problem
        residual = problem.targets(values)
        most = MISSED_BY_FIT if len(residual) > len(unit) else MISSED_TOLERANCES * self.tolerance
        if np.any(problem.weights) or np.max(np.abs(residual), initial=0.0) <= most:
            return RESULTS.successful
        slope = slopes.T @ (problem.targets.matrix.T @ residual)
        outwards = np.where(unit < AT_BOUND, slope, np.where(unit > 1 - AT_BOUND, -slope, 0.0))
        reached = np.any(problem.limits(values) > -MISSED_TOLERANCES * self.tolerance)
        blocked = np.any(outwards > STATIONARY) or reached
        return RESULTS.target_missed if blocked or problem.equal.names or not len(unit) else RESULTS.local_minimum

    def least_squares(self, start: np.ndarray) -> Outcome:
        """Search for targets alone by SciPy."""
        import scipy.optimize

        problem = self.problem
        count = len(problem.targets.names)

        def residual(unit: np.ndarray):
            evaluation = self.evaluate(unit)
            return np.full(count, np.nan) if evaluation is None else problem.targets(evaluation[0])

        def jacobian(unit: np.ndarray):
            evaluation = self.evaluate(unit)
            return np.full((count, len(unit)), np.nan) if evaluation is None else problem.targets.matrix @ evaluation[1]

        # The method starts inside the bounds.
        inside, tolerances = np.clip(start, 1e-6, 1 - 1e-6), {"ftol": 1e-15, "xtol": 1e-13, "gtol": 1e-13}
        options: Any = {"jac": jacobian, "bounds": (0.0, 1.0), "method": "trf", "x_scale": "jac", **tolerances}
        try:
            solution = scipy.optimize.least_squares(residual, inside, **options)
        except _Stop:
            return self.best(), "max_evaluations reached", RESULTS.not_optimal
        far = problem.missed(solution.fun)
        reason = "nearest to the targets: " + ", ".join(far) if far else "all targets are met"
        return solution.x, reason, RESULTS.successful if solution.status > 0 else RESULTS.not_optimal

    def by_optimistix(self, start: np.ndarray) -> Outcome:
        """Solve within the bounds by u = (1 + sin v)/2: the solvers of optimistix have no bounds."""
        import optimistix

        def residual(angle: Float[Array, "n"], _: Any):
            values, _ = self.of_unit((1 + jnp.sin(angle)) / 2)
            return self.problem.targets(values)

        def solve(angle: Float[Array, "n"]):
            options: Any = {"max_steps": self.budget, "throw": False}
            solution = optimistix.least_squares(residual, self.optimizer, angle, **options)
            return solution.value, solution.result == optimistix.RESULTS.successful

        # At a bound the sine is flat.
        angle, good = jit(solve)(np.arcsin(2 * np.clip(start, 1e-3, 1 - 1e-3) - 1))
        end = (1 + np.sin(np.asarray(angle))) / 2
        if bool(good):
            return end, "the solver of optimistix converged", RESULTS.successful
        return end, "the solver of optimistix did not converge", RESULTS.not_optimal

    def augmented(self, start: np.ndarray, inner: Callable[..., np.ndarray]) -> Outcome:
        """Rounds of a bounded minimisation, with better multipliers or a larger weight in each."""
        problem, tolerance = self.problem, self.tolerance
        multipliers = np.zeros(len(problem.equal.names)), np.zeros(len(problem.limits.names))
        constrained = bool(problem.equal.names or problem.limits.names)
        weight, stationarity, before = FIRST_WEIGHT, FIRST_STATIONARY if constrained else STATIONARY, np.inf
        unit, nearest = start, (np.inf, start)
        try:
            for _ in range(MAX_ROUNDS):
                last, unit = unit, inner(unit, multipliers, weight, stationarity)
                evaluation = self.evaluate(unit)
                if evaluation is None:
                    return self.best(), "the search ran into designs that fail", self.failed
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
            return self.best(), "max_evaluations reached", RESULTS.not_optimal
        if nearest[0] <= NEARLY_STATIONARY or not constrained:
            why = "no further descent was found: the objective may have a kink there, or no more accurate digits"
            if self.failed is not RESULTS.successful:
                why += f"; designs around it failed ({self.failed.name})"
            return nearest[1], why, RESULTS.successful if nearest[0] <= NEARLY_STATIONARY else RESULTS.not_optimal
        if all(problem.violation(values) > tolerance for _, values in self.history):
            return unit, "the limits cannot be kept", RESULTS.infeasible
        return self.best(), "the multipliers did not settle", RESULTS.not_optimal

    def by_scipy(
        self, unit: np.ndarray, multipliers: tuple[Any, Any], weight: float, stationarity: float
    ) -> np.ndarray:
        """Minimise the augmented Lagrangian by SciPy."""
        import scipy.optimize

        worst = 0.0

        def merit(u: np.ndarray):
            nonlocal worst
            evaluation = self.evaluate(u)
            if evaluation is None:
                # Worse than all known values: the line search steps back.
                return worst + 10 * (1 + abs(worst)), np.zeros_like(u)
            values, slopes = evaluation
            value = float(self.problem.lagrangian(values, multipliers, weight))
            worst = max(worst, value)
            return value, slopes.T @ self.problem.slope(values, multipliers, weight)

        options = {"ftol": 0.0, "gtol": stationarity, "maxiter": 10_000, "maxfun": 100_000, "maxcor": 20}
        limits = [(0.0, 1.0)] * len(unit)
        solution = scipy.optimize.minimize(merit, unit, jac=True, method="L-BFGS-B", bounds=limits, options=options)
        return np.clip(solution.x, 0.0, 1.0)

    def by_optax(self) -> Callable[..., np.ndarray]:
        """Return the function that minimises the augmented Lagrangian by an optimiser of optax."""
        import optax

        if not isinstance(self.optimizer, optax.GradientTransformation):
            text = printable(repr(self.optimizer))
            raise TypeError(
                f"Argument `optimizer` must be an optimiser of optax such as optax.adam(1e-2), but is {text}."
            )
        rule = optax.with_extra_args_support(self.optimizer)

        def step(unit: Any, state: Any, multipliers: Any, weight: Any):
            def merit(u: Float[Array, "n"]):
                values, code = self.of_unit(u)
                return self.problem.lagrangian(values, multipliers, weight), (values, code)

            (value, (values, code)), gradient = jax.value_and_grad(merit, has_aux=True)(unit)
            more: Any = {"value": value, "grad": gradient, "value_fn": lambda u: merit(u)[0]}
            change, state = rule.update(gradient, state, unit, **more)
            return jnp.clip(unit + change, 0.0, 1.0), state, values, gradient, code

        compiled = jit(step)

        def inner(unit: np.ndarray, multipliers: tuple[Any, Any], weight: float, stationarity: float) -> np.ndarray:
            state, at = rule.init(jnp.asarray(unit)), jnp.asarray(unit)
            while True:
                if self.count >= self.budget:
                    raise _Stop
                after, state, values, gradient, code = compiled(at, state, multipliers, weight)
                point, values, gradient = np.asarray(at), np.asarray(values), np.asarray(gradient)
                if self.refused(point[None])[0] or not self.good(values, gradient, int(code)):
                    return point
                self.count += 1
                self.note(point, values)
                if _projected(point, gradient) <= stationarity:
                    return point
                at = after

        return inner


def _is_least_squares_solver(optimizer: Any) -> bool:
    if optimizer is None:
        return False
    import optimistix

    return isinstance(optimizer, optimistix.AbstractLeastSquaresSolver)


def _projected(unit: np.ndarray, gradient: np.ndarray) -> float:
    """Largest entry of the derivative that does not push against a bound."""
    return float(np.max(np.abs(np.clip(unit - gradient, 0.0, 1.0) - unit), initial=0.0))


class _Meeting:
    """Searches wait here until each running one has a design to compute."""

    def __init__(self, kernel: Callable[[np.ndarray], tuple], size: int, count: int):
        self.kernel, self.size, self.under_way = kernel, size, count
        self.asked: dict[int, np.ndarray] = {}
        self.answered: dict[int, Any] = {}
        self.changed = threading.Condition()

    def compute(self, search: int, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """Answers of one design of a search."""
        with self.changed:
            self.asked[search] = np.array(unit, float)
            self._meet()
            self.changed.wait_for(lambda: search in self.answered)
            answer = self.answered.pop(search)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def leave(self) -> None:
        """End a search."""
        with self.changed:
            self.under_way -= 1
            self._meet()

    def _meet(self) -> None:
        if not self.asked or len(self.asked) < self.under_way:
            return
        searches = list(self.asked)
        rows = [self.asked[search] for search in searches]
        # A constant number of rows needs one compiled program.
        rows += [rows[-1]] * (self.size - len(rows))
        try:
            values, slopes, codes = self.kernel(np.array(rows))
            for row, search in enumerate(searches):
                self.answered[search] = values[row], slopes[row], int(codes[row])
        except BaseException as fault:
            self.answered |= dict.fromkeys(searches, fault)
        self.asked.clear()
        self.changed.notify_all()


def in_lockstep(
    search: Callable[[Kernel, Any], Any], starts: Sequence[Any], kernel: Callable[[np.ndarray], tuple], size: int
) -> list[Any]:
    """Results of a search from every start, some at a time, each as if it were alone."""
    results: list[Any] = []
    for first in range(0, len(starts), size):
        group = starts[first : first + size]
        meeting = _Meeting(kernel, size, len(group))

        def run(number: int, start: Any, meeting: _Meeting = meeting) -> Any:
            try:
                return search(lambda unit: meeting.compute(number, unit), start)
            finally:
                meeting.leave()

        with ThreadPoolExecutor(len(group)) as pool:
            results += list(pool.map(run, range(len(group)), group))
    return results
