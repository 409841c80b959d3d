"""Dimensions that meet targets and limits."""

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np

from ..arguments import check_number, check_whole
from ..compilation.compile import jit
from ..display import Result, Summary
from ..errors import AnalysisError, clean
from ..progress import reporting
from ..results import RESULTS
from .curve import Curve
from .designs import checked_bounds, numbers
from .evaluate import (
    Answers,
    Build,
    Layout,
    build_once,
    check_dimensions,
    check_names,
    flat_function,
    layout_of,
    named_answers,
)
from .lockstep import in_lockstep
from .possible import refusal
from .problem import Problem, make_problem
from .search import Attempt, search
from .sensitivities import REVERSE_COST

# A dimension this near to a bound, as a share of the range, is at it.
AT_BOUND = 1e-6
# What stands beside dimensions and answers in a history.
RESERVED = ("objective", "violation")


@dataclasses.dataclass(frozen=True, repr=False)
class Tuned(Result):
    """A design that was found.

    Attributes:
        dimensions: By name [SI].
        answers: At these dimensions, by name [their units].
        start: Answers at the start, by name [their units].
        result: Code of RESULTS: successful, infeasible, not_optimal, or the failure of an analysis.
        reason: Why the search ended, in words.
        active: Dimensions at a bound and limits that are reached, in words.
        objective: What was minimised, relative to the start [-].
        violation: Largest violation of a limit or of an equality, relative to its value [-].
        history: Every evaluation of the run that led here: dimensions and answers by name, "objective" and
            "violation", each (evaluations, ...).
        runs: Objective and violation of every start, (starts, 2), NaN where the start itself failed.
        curves: Targets that are curves, by the names of their answers.
    """

    dimensions: dict[str, Any]
    answers: dict[str, Any]
    start: dict[str, Any]
    result: RESULTS
    reason: str
    active: tuple[str, ...]
    objective: float
    violation: float
    history: dict[str, np.ndarray]
    runs: np.ndarray
    curves: dict[str, Curve] = dataclasses.field(default_factory=dict)

    @property
    def evaluations(self) -> int:
        """Number of designs that the run computed."""
        return len(self.history["objective"])

    def summary(self) -> Summary:
        """Dimensions, and answers beside those at the start."""
        rows = {name: _text(value) for name, value in self.dimensions.items()}
        rows |= {n: f"{_text(value)} (start {_text(self.start[n])})" for n, value in self.answers.items()}
        title = f"Tuned, {self.result.name}: {self.reason} ({self.evaluations} evaluations)"
        return Summary(title, rows, "tuning")

    def __str__(self) -> str:
        lines = [f"{self.result.name}: {self.reason} ({self.evaluations} evaluations)"]
        lines += [f"  {name} = {_text(value)}" for name, value in self.dimensions.items()]
        for name, value in self.answers.items():
            lines.append(f"  {name}: {_text(value)} (start {_text(self.start[name])})")
        lines += [f"  {text}" for text in self.active]
        return "\n".join(lines)


def _text(value: Any) -> str:
    return np.array2string(np.asarray(value), threshold=8, formatter={"float_kind": "{:.7g}".format})


class Scaling:
    """Dimensions between their bounds as numbers from 0 to 1, logarithmic or linear."""

    def __init__(self, layout: Layout, bounds: Mapping[str, Any], scales: Mapping[str, str]):
        """Check and keep the bounds.

        Args:
            bounds: Lower and upper value by name.
            scales: "log" or "linear" by name.

        Raises:
            ValueError: Names the dimension.
        """
        for what, given in (("Bounds", bounds), ("Scale", scales)):
            for name in given:
                if name not in layout.names:
                    listed = ", ".join(layout.names)
                    raise ValueError(f"{what} of '{clean(name)}': there is no such dimension ({listed}).")
        for name in layout.names:
            if name not in bounds:
                raise ValueError(f"Dimension '{name}' has no bounds: give lower and upper, or fix it in `build`.")
        pairs = {name: checked_bounds(name, bounds[name]) for name in layout.names}
        logarithmic = {}
        for name, (lower, _) in pairs.items():
            scale = scales.get(name, "log" if np.all(lower > 0) else "linear")
            if scale not in ("log", "linear"):
                raise ValueError(f"Scale of '{name}' must be 'log' or 'linear', but is {clean(repr(scale))}.")
            if scale == "log" and not np.all(lower > 0):
                raise ValueError(f"Scale of '{name}' cannot be 'log', since its lower bound {lower} is not positive.")
            logarithmic[name] = scale == "log"
        self.layout = layout
        self.lower = layout.join({name: lower for name, (lower, _) in pairs.items()})
        self.upper = layout.join({name: upper for name, (_, upper) in pairs.items()})
        self.log = layout.join(logarithmic) > 0

    def check_inside(self, flat: np.ndarray) -> None:
        """Refuse a start outside the bounds.

        Raises:
            ValueError: Names the dimension.
        """
        for name, value, lower, upper in zip(self.layout.labels, flat, self.lower, self.upper, strict=True):
            if not lower <= value <= upper:
                raise ValueError(f"Start {value:g} of '{name}' is outside its bounds, {lower:g} to {upper:g}.")

    def to_unit(self, flat: np.ndarray) -> np.ndarray:
        """Numbers from 0 to 1, (n,), for dimensions, (n,)."""
        linear = (flat - self.lower) / (self.upper - self.lower)
        safe = (np.where(self.log, a, e) for a, e in ((flat, 1.0), (self.lower, 1.0), (self.upper, np.e)))
        value, lower, upper = safe
        return np.clip(np.where(self.log, np.log(value / lower) / np.log(upper / lower), linear), 0.0, 1.0)

    def to_dimensions(self, unit: Any) -> Any:
        """Dimensions, (n,), for numbers from 0 to 1, (n,); also under a trace."""
        ratio = np.where(self.log, self.upper / np.where(self.log, self.lower, 1.0), 1.0)
        linear = self.lower + unit * (self.upper - self.lower)
        found = jnp.where(self.log, self.lower * jnp.exp(unit * np.log(ratio)), linear)
        return jnp.clip(found, self.lower, self.upper) if isinstance(unit, np.ndarray) else found


def tune(
    build: Build,
    answers: Answers,
    dimensions: Mapping[str, Any],
    bounds: Mapping[str, Any],
    *,
    minimize: str | None = None,
    maximize: str | None = None,
    targets: Mapping[str, Any] | None = None,
    limits: Mapping[str, Any] | None = None,
    equal: Mapping[str, Any] | None = None,
    scales: Mapping[str, Literal["log", "linear"]] | None = None,
    optimizer: Any = None,
    starts: int = 1,
    together: int = 1,
    seed: int = 0,
    tolerance: float = 1e-6,
    max_evaluations: int = 1000,
    progress: Callable[[int, float, float], None] | bool = False,
    throw: bool = True,
) -> Tuned:
    """Find dimensions within bounds that meet targets and keep limits.

    Args:
        build: Function of the dimensions, by name, that returns a model. Degrees of freedom that it does not name are
            found once, at the start.
        answers: Functions of the model that return numbers: one, several, or a dictionary by name.
        dimensions: Where to start, numbers or arrays by name [SI].
        bounds: Lower and upper value of each by name [SI].
        minimize: Name of the answer that should be small.
        maximize: Name of the answer that should be large.
        targets: Values that answers should come near to, by name: least squares of the relative differences. A
            whole curve, such as the forces along a stroke, is a :class:`flexmb.design.Curve`, whose differences count
            relative to its largest value; ``fm.equilibria`` answers such a stroke at once.
        limits: Lower and upper value of answers by name, None for none.
        equal: Values that answers must have, by name.
        scales: "log" or "linear" by name; by default logarithmic where the lower bound is positive.
        optimizer: Any optimiser of optax, taken as it is, its steps projected onto the bounds; for targets alone also a
            least-squares solver of optimistix. By default scipy's L-BFGS-B, and its trust-region reflective method for
            targets alone, which hold bounds exactly.
        starts: Number of starts: the given one, and others spread over the bounds; the best design is returned.
        together: Starts that are searched from at the same time, their designs computed in one call by ``jax.vmap``:
            quicker for small models (large ones only on a GPU: many LAPACK calls at once may hang on a CPU).
        seed: Of their places.
        tolerance: Relative violation of an equality that is none. Limits are kept, from inside by as much.
        max_evaluations: Of the answers and their derivatives, for each start.
        progress: True for a line that shows them, or a function called with the number of evaluations, the objective
            and the violation.
        throw: Raise where no feasible or no optimal design is found; otherwise the code is in ``result``.

    Returns:
        Tuned with dimensions and answers by name.

    Raises:
        ValueError: Bounds that are empty, a start outside them, an unknown name, a dimension on which no answer that
            is asked depends, or answers that are not finite at the start.
        AnalysisError: infeasible, not_optimal, or an analysis fails; ``throw=False`` returns what was found.

    Source:
        Augmented Lagrangian within bounds: Conn, Gould, Toint 1991; Nocedal, Wright 2006, algorithm 17.4.
    """
    dimensions = {name: numbers(f"Dimension '{name}'", v) for name, v in dimensions.items()}
    functions, layout = named_answers(answers), layout_of(dimensions)
    check_dimensions(build, layout.names)
    check_names(layout.names, tuple(functions), RESERVED)
    scaling = Scaling(layout, bounds, scales or {})
    first = layout.join(dimensions)
    scaling.check_inside(first)
    starts, together = check_whole("starts", starts, 1), check_whole("together", together, 1)
    max_evaluations, seed = check_whole("max_evaluations", max_evaluations, 1), check_whole("seed", seed, 0)
    check_number("tolerance", tolerance, above=0)
    models = build_once(build, dimensions)
    function, of_answers = flat_function(build, functions, layout, models)
    of_designs = refusal(build, models, layout.split(first))

    def of_unit(unit):
        return function(scaling.to_dimensions(unit))

    def refused(units: np.ndarray) -> np.ndarray:
        return of_designs(layout.stacked(scaling.to_dimensions(units)))

    for name in (minimize, maximize):
        if name is not None and not isinstance(name, str):
            raise ValueError(f"Arguments `minimize` and `maximize` must be names of answers, not {clean(repr(name))}.")
    named = {name for name in (minimize, maximize, *(targets or {}), *(limits or {}), *(equal or {})) if name}
    asked = np.repeat([name in named for name in of_answers.names], of_answers.sizes)
    unit = scaling.to_unit(first)
    kernel = _Kernel(of_unit, refused, unit, np.flatnonzero(asked), len(asked))
    at_start = kernel(unit)
    _check_start(of_answers, at_start)
    problem = make_problem(
        of_answers,
        at_start[0],
        minimize=minimize,
        maximize=maximize,
        targets=targets or {},
        equal=equal or {},
        limits=limits or {},
        margin=tolerance,
    )
    _check_dependence(problem, layout.labels, kernel, unit, at_start[1], seed)
    units = [unit, *_other_starts(starts - 1, len(unit), seed)]
    with reporting(progress, "evaluations, objective, violation") as report:

        def from_start(kernel, unit):
            return search(
                problem, kernel, of_unit, refused, unit, optimizer, tolerance, max_evaluations, progress=report
            )

        size = min(together, starts)
        if size > 1:
            runs = in_lockstep(from_start, units, kernel.many, size)
        else:
            runs = [from_start(kernel, unit) for unit in units]
    best = min(runs, key=lambda run: (not run.answered, run.violation > 2 * tolerance and run.violation, run.objective))
    found = _found(best, runs, problem, scaling, of_answers, at_start[0], tolerance)
    found = dataclasses.replace(found, curves={n: t for n, t in (targets or {}).items() if isinstance(t, Curve)})
    if throw and found.result is not RESULTS.successful:
        raise AnalysisError(found.result.name, f"{found.result.message} {found.reason}\n{found}")
    return found


class _Kernel:
    """Answers (m,), derivatives of the asked ones by the scaled dimensions (m, n), and the code, as numpy arrays."""

    def __init__(self, of_unit, refused, start: np.ndarray, asked: np.ndarray, m: int):
        differentiate: Any = jax.jacfwd if len(start) <= REVERSE_COST * len(asked) else jax.jacrev

        def twice(unit):
            values, code = of_unit(unit)
            return values[asked], (values, code)

        self.asked, self.start, self.refused, self.m = asked, start, refused, m
        function = differentiate(twice, has_aux=True)
        self.one, self.several = jit(function), jit(jax.vmap(function))

    def __call__(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        (values,), (slopes,), (code,) = self._of(unit[None], lambda units: jax.tree.map(_first, self.one(units[0])))
        return values, slopes, int(code)

    def many(self, units: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same of several designs, (designs, n), in one call."""
        return self._of(units, self.several)

    def _of(self, units: np.ndarray, call) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        refused = self.refused(units)
        # The start, which can be built, stands in for a design that cannot: numbers without sense may take long.
        own, (values, codes) = call(jnp.asarray(np.where(refused[:, None], self.start, units)))
        values, codes = np.array(values), np.where(refused, RESULTS.impossible_design, codes)
        slopes = np.zeros((*values.shape, units.shape[1]))
        slopes[:, self.asked] = own
        values[refused], slopes[refused] = np.nan, np.nan
        return values, slopes, codes


def _first(array: Any) -> Any:
    return array[None]


def _check_start(of_answers: Layout, at_start: Any) -> None:
    values, slopes, code = at_start
    if code != RESULTS.successful:
        raise ValueError(f"The start has no answer ({RESULTS(code).name}): {RESULTS(code).message}")
    for name, value, row in zip(of_answers.labels, values, slopes, strict=True):
        if not np.isfinite(value):
            raise ValueError(f"Answer '{name}' is {value} at the start. Start elsewhere, or ask for something finite.")
        if not np.all(np.isfinite(row)):
            raise ValueError(f"Answer '{name}' has no finite derivative at the start. Start elsewhere.")


def _check_dependence(problem: Problem, labels: list[str], kernel, unit, slopes: np.ndarray, seed: int) -> None:
    """Refuse dimensions that nothing depends on; looked at twice, since a symmetric start may be stationary."""
    asked = np.abs(problem.weights) > 0
    for rows in (problem.targets, problem.equal, problem.limits):
        asked |= np.any(rows.matrix != 0, axis=0)
    ignored = ~np.any(slopes[asked] != 0, axis=0)
    if np.any(ignored):
        aside = np.clip(unit + 0.05 * np.random.default_rng(seed).uniform(-1, 1, len(unit)), 0.01, 0.99)
        ignored &= ~np.any(kernel(aside)[1][asked] != 0, axis=0)
    if np.any(ignored):
        names = ", ".join(f"'{label}'" for label, i in zip(labels, ignored, strict=True) if i)
        raise ValueError(f"Nothing that is asked depends on dimension {names}. Fix it in `build`, or ask for more.")


def _other_starts(count: int, n: int, seed: int) -> list[np.ndarray]:
    if count < 1:
        return []
    from scipy.stats import qmc

    return list(qmc.LatinHypercube(n, rng=np.random.default_rng(seed)).random(count))


def _found(
    best: Attempt,
    runs: list[Attempt],
    problem: Problem,
    scaling: Scaling,
    of_answers: Layout,
    start: np.ndarray,
    tolerance: float,
) -> Tuned:
    layout, flat = scaling.layout, np.asarray(scaling.to_dimensions(best.unit))
    active = []
    for name, u, lower, upper in zip(layout.labels, best.unit, scaling.lower, scaling.upper, strict=True):
        if min(u, 1 - u) < AT_BOUND:
            active.append(f"{name} is at its {'lower' if u < 0.5 else 'upper'} bound {lower if u < 0.5 else upper:g}")
    if best.answered:
        reached = np.abs(problem.limits(best.answers)) < 100 * tolerance
        active += [f"{n} is reached" for n, r in zip(problem.limits.names, reached, strict=True) if r]
    result, reason = best.result, best.reason
    if result in (RESULTS.infeasible, RESULTS.not_optimal) and (bad := problem.violated(best.answers, 2 * tolerance)):
        result, reason = RESULTS.infeasible, f"Violated: {', '.join(bad)}."
    rows = np.array([np.asarray(scaling.to_dimensions(u)) for u, _ in best.history])
    values = np.array([a for _, a in best.history])
    history = {
        **{name: np.moveaxis(v, -1, 0) for name, v in layout.split(rows.T).items()},
        **{name: np.moveaxis(v, -1, 0) for name, v in of_answers.split(values.T).items()},
        "objective": np.array([problem.objective(a) for a in values]),
        "violation": np.array([problem.violation(a) for a in values]),
    }

    def plain(named: dict[str, np.ndarray]) -> dict[str, Any]:
        return {name: float(v) if v.ndim == 0 else v for name, v in named.items()}

    return Tuned(
        plain(layout.split(flat)),
        plain(of_answers.split(best.answers)),
        plain(of_answers.split(start)),
        result,
        reason,
        tuple(active),
        best.objective,
        max(best.violation - tolerance, 0.0),
        history,
        np.array([[run.objective, run.violation] for run in runs]),
    )
