"""Fits of many sets of values in one compiled program, by a damped Gauss-Newton method within bounds."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import OPTIONS, program_name, under_name, unguarded
from ..compilation.threads import cores, in_threads
from ..numerical_limits import SETTLED_COST, SETTLED_PARAMETERS
from .problem import FitProblem, robust, weighted_slopes

# With fewer sets, SciPy's searches end before the program is compiled.
FEW = 50
# Sets in one call of the program, on one core.
TOGETHER = 50
MOST_STEPS = 30
# Squares of damping over squares of scaled slopes: always, and after a step that increases the cost.
LEAST_DAMPING, FIRST_DAMPING = 1e-14, 1e-3
# Share of the cost, as SETTLED_COST, after a refused step.
REFUSED_COST = 1e-7


class EndsOfSearches(NamedTuple):
    """Ends of the searches of several sets of values.

    Attributes:
        units: Scaled parameters, (sets, n).
        squares: Sums of squared weighted differences, without robust loss, (sets,).
        roots: Matrices R with R^T R = J^T J, where J contains the weighted slopes, (sets, n, n).
        converged: Whether the search ended by its tolerances, (sets,).
    """

    units: np.ndarray
    squares: np.ndarray
    roots: np.ndarray
    converged: np.ndarray


@unguarded
def repeated(problem: FitProblem, unit: np.ndarray, sets: np.ndarray) -> EndsOfSearches:
    """Search from scaled parameters, (n,), for each set of measured values, (sets, m)."""
    if len(sets) < FEW:
        return _by_scipy(problem, unit, sets)
    ends = _compiled(problem, unit, sets)
    failed = np.flatnonzero(~ends.converged)
    if len(failed):
        again = _by_scipy(problem, unit, sets[failed])
        ends = EndsOfSearches(*(np.array(part) for part in ends))
        for part, other in zip(ends, again, strict=True):
            part[failed] = other
    return ends


def _by_scipy(problem: FitProblem, unit: np.ndarray, sets: np.ndarray) -> EndsOfSearches:
    solutions = [problem.solve(unit, values=values) for values in sets]
    squares, roots = [], []
    for solution, values in zip(solutions, sets, strict=True):
        rows, slopes, _ = problem.residuals(solution.unit, values)
        squares.append(np.sum(rows**2))
        roots.append(np.linalg.qr(weighted_slopes(rows, slopes, problem.loss), mode="r"))
    units, converged = np.array([end.unit for end in solutions]), np.array([end.converged for end in solutions])
    return EndsOfSearches(units, np.array(squares), np.array(roots), converged)


def _compiled(problem: FitProblem, unit: np.ndarray, sets: np.ndarray) -> EndsOfSearches:
    rows, slopes, _ = problem.residuals(unit, sets[0])
    # Rows of priors do not depend on the set.
    rows = np.tile(rows, (len(sets), 1))
    count_measured = sets.shape[1]
    rows[:, :count_measured] += problem.weighted((sets[0] - sets).T).T
    count = len(sets)
    places = [np.minimum(np.arange(first, first + TOGETHER), count - 1) for first in range(0, count, TOGETHER)]
    program = _program(problem)
    ends = in_threads(lambda place: program(sets[place], rows[place], slopes, unit), places, cores())
    return EndsOfSearches(
        *(np.concatenate([np.asarray(part) for part in parts])[:count] for parts in zip(*ends, strict=True))
    )


@functools.lru_cache(maxsize=4)
def _program(problem: FitProblem) -> Any:
    m, n = len(problem.measured), len(problem.first)
    k = m + len(problem.priors)
    shapes = (TOGETHER, m), (TOGETHER, k), (k, n), (n,)
    # Thousands of runs pay for a thorough compilation.
    function = under_name(_every(problem), program_name(repeated), OPTIONS["thorough"])
    return function.lower(*(jax.ShapeDtypeStruct(shape, float) for shape in shapes)).compile()


class _Point(NamedTuple):
    """A point of a search, the damping of the next step, and whether the last step was refused."""

    unit: Any
    rows: Any
    slopes: Any
    cost: Any
    damping: Any
    refused: Any
    steps: Any
    converged: Any


def _every(problem: FitProblem) -> Callable[..., Any]:
    """Return the function of sets of values, their weighted differences at the start, slopes there, and start."""
    evaluate, loss = problem.traced(), problem.loss

    def cost_of(rows: Float[Array, "m"]) -> Float[Array, ""]:
        return jnp.sum(robust(rows, loss)[0])

    def search(values: Float[Array, "m"], rows: Array, slopes: Float[Array, "m n"], unit: Float[Array, "n"]):
        def step(point: _Point) -> _Point:
            weights = jnp.sqrt(robust(point.rows, loss)[1])
            gradient = (point.slopes * weights[:, None]).T @ (point.rows * weights)
            # A parameter at a bound stays there if the cost falls outwards only.
            blocked = ((point.unit <= 0) & (gradient > 0)) | ((point.unit >= 1) & (gradient < 0))
            gradient = jnp.where(blocked, 0.0, gradient)
            root = jnp.linalg.qr(jnp.where(blocked[None], 0.0, point.slopes * weights[:, None]), mode="r")
            newton = _damped(root, gradient, LEAST_DAMPING)
            fall = -(2 * gradient @ newton + jnp.sum((root @ newton) ** 2))
            # Round-off of the cost may refuse a step without effect.
            least = jnp.where(point.refused, REFUSED_COST, SETTLED_COST)
            settled = (fall <= least * point.cost) | (jnp.max(jnp.abs(newton)) <= SETTLED_PARAMETERS)

            def moved(point: _Point) -> _Point:
                trial = jnp.clip(point.unit + _damped(root, gradient, point.damping), 0.0, 1.0)
                rows, slopes, good = evaluate(trial, values)
                cost = cost_of(rows)
                better = good & jnp.all(jnp.isfinite(slopes)) & (cost < point.cost)
                lower = jnp.where(point.damping > FIRST_DAMPING / 10, point.damping / 10, LEAST_DAMPING)
                higher = jnp.maximum(10 * point.damping, FIRST_DAMPING)
                return _Point(
                    jnp.where(better, trial, point.unit),
                    jnp.where(better, rows, point.rows),
                    jnp.where(better, slopes, point.slopes),
                    jnp.where(better, cost, point.cost),
                    jnp.where(better, lower, higher),
                    ~better,
                    point.steps + 1,
                    point.converged,
                )

            return jax.lax.cond(settled, lambda point: point._replace(converged=settled), moved, point)

        no = jnp.asarray(False)
        first = _Point(unit, rows, slopes, cost_of(rows), jnp.asarray(LEAST_DAMPING), no, jnp.asarray(0), no)
        end = jax.lax.while_loop(lambda point: ~point.converged & (point.steps < MOST_STEPS), step, first)
        weighted = end.slopes * jnp.sqrt(robust(end.rows, loss)[1])[:, None]
        return end.unit, jnp.sum(end.rows**2), jnp.linalg.qr(weighted, mode="r"), end.converged

    def every(sets: Float[Array, "sets m"], rows: Array, slopes: Float[Array, "m n"], unit: Float[Array, "n"]):
        return jax.lax.map(lambda pair: search(pair[0], pair[1], slopes, unit), (sets, rows))

    return every


def _damped(root: Float[Array, "n n"], gradient: Float[Array, "n"], damping: Any) -> Float[Array, "n"]:
    """Return the step -(R^T R + damping D^2)^-1 gradient, where D contains the norms of the columns of R."""
    sizes = jnp.linalg.norm(root, axis=0)
    sizes = jnp.where(sizes > 0, sizes, 1.0)
    stacked = jnp.concatenate([root / sizes[None], jnp.sqrt(damping) * jnp.eye(len(sizes))])
    triangle = jnp.linalg.qr(stacked, mode="r")
    inner = jax.scipy.linalg.solve_triangular(triangle, gradient / sizes, trans=1)
    return -jax.scipy.linalg.solve_triangular(triangle, inner) / sizes
