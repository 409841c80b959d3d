"""Tuning: dimensions that meet targets and limits."""

import dataclasses
import functools
from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import ByName, Count, Positive, WholeFromZero, check_whole, checked
from ..compilation.by_meaning import jit
from ..compilation.compile import unguarded
from ..errors import AnalysisError, first_line, printable, warn
from ..progress import reporting
from ..results import RESULTS
from .designs import float_array
from .evaluate import (
    REFUSED,
    Answers,
    Build,
    Layout,
    build_once,
    check_answer_names,
    check_dimensions,
    flat_function,
    layout_of,
    named_answers,
    refusal_of_designs,
    with_slopes,
)
from .problem import Curve, Scaling, TuningProblem, asked_names, make_problem
from .scatter import Scatter, refuse_two_values
from .search import Attempt, Kernel, in_lockstep, search_from
from .statistics import SAMPLES, YIELD, SampledDesign, sampled_of
from .tuned import Combination, Options, Tuned, combinations, options_of

# Names in a history, beside the names of dimensions and answers.
RESERVED = ("objective", "violation")


@checked
@unguarded
def tune(
    build: Build,
    answers: Answers,
    dimensions: ByName,
    bounds: ByName,
    *,
    minimize: str | None = None,
    maximize: str | None = None,
    choices: ByName | None = None,
    targets: ByName | None = None,
    limits: ByName | None = None,
    equal: ByName | None = None,
    scales: Mapping[str, Literal["log", "linear"]] | None = None,
    scatter: Scatter | None = None,
    samples: Annotated[int, partial(check_whole, least=8)] = SAMPLES,
    acceptable: ByName | None = None,
    optimizer: Any = None,
    starts: Count = 1,
    together: Count = 1,
    seed: WholeFromZero = 0,
    tolerance: Positive = 1e-6,
    max_evaluations: Count = 1000,
    progress: Callable[[int, float, float], None] | bool = False,
    throw: bool = True,
) -> Tuned:
    """Find dimensions within bounds that meet targets and keep limits.

    Args:
        build: Function of the dimensions, by name, that returns a model, or a tuple of models for answers that need
            several mechanisms. If no degrees of freedom are named, flexmb chooses them once, at the start.
        answers: Functions of the model that return numbers, or questions such as "frequency 1": one answer, several
            answers, or a dictionary by name.
        dimensions: Start, numbers or arrays by name [SI].
        bounds: Lower and upper value of each dimension by name [SI].
        minimize: Name of the answer to minimise.
        maximize: Name of the answer to maximise.
        choices: Arguments of ``build`` with a few values each, by name: a list, or a dictionary of values by label.
            Values may be any Python values. They may change the structure of the model: whole numbers, materials,
            element types. ``tune`` searches every combination; each needs seconds to compile. It returns the best
            feasible design with a table of all combinations. With choices, ``dimensions`` may be empty.
        targets: Values to approach, by name of the answer: least squares of the relative differences. A target is
            missed if its relative difference exceeds 100 times ``tolerance``, or a tenth if there are more targets than
            dimensions. ``reason`` names missed targets. With `minimize` or `maximize`, the objective has two terms: the
            named answer divided by its value at the start, and half the sum of the squares. For a curve, such as forces
            over a stroke from ``fm.equilibria``, use :class:`flexmb.design.Curve`: its differences are relative to its
            largest value. If a target, limit or equality is zero, its difference is relative to the answer at the
            start. If that answer is also zero, the difference is relative to the change of the answer across the
            bounds. An objective has the same scale.
        limits: Lower and upper value of answers by name, None for no limit.
        equal: Values that answers must have, by name.
        scales: "log" or "linear" by name; by default logarithmic if the lower bound is positive.
        scatter: Scatter of the dimensions and of further arguments of ``build``, from :func:`flexmb.scatter`. With it,
            `minimize`, `maximize`, `targets`, `limits` and `equal` also accept statistics of made mechanisms: "mean
            mass", "deviation mass", "percentile 95 mass", and "yield", the share of ``acceptable`` mechanisms. The name
            of an answer is its nominal value.
        samples: Number of made mechanisms of each design. All designs have the same random numbers.
        acceptable: Lower and upper limit of answers that define the yield, by name, None for no limit. The search
            blurs these limits, so that the yield has a derivative. :func:`flexmb.design.robustness` computes the exact
            share.
        optimizer: Optimiser of optax, with its steps projected onto the bounds. For targets alone, also a least-squares
            solver of optimistix. Default: L-BFGS-B of scipy, or for targets alone its trust-region reflective method;
            both keep bounds exactly.
        starts: Number of starts: ``dimensions``, and further starts spread over the bounds. The best design is
            returned.
        together: Number of starts searched at the same time, with their designs in one call by ``jax.vmap``. This is
            faster for small models, and for large models on a GPU (many LAPACK calls at once may hang on a CPU).
        seed: Seed of the other starts.
        tolerance: Relative violation of an equality that flexmb accepts. The search aims at designs that are inside
            each limit by this margin.
        max_evaluations: Number of evaluations of answers and derivatives for each start.
        progress: True for a line on the terminal, or a function called with the number of evaluations, the objective
            and the violation.
        throw: Raise if no feasible or no optimal design is found or targets are missed; otherwise ``result`` contains
            the code.

    Returns:
        Tuned with dimensions and answers by name, and with ``choices`` and ``combinations`` if choices are given.
        Objectives of all combinations are relative to the same answers: at the start of the first combination that has
        answers.

    Raises:
        ValueError: A statistic needs ``scatter``, or "yield" needs ``acceptable``; or ``scatter`` or ``samples`` is
            given without any statistic. There are too many combinations.
            Bounds are empty, or the start is outside. A name is unknown. No wanted answer depends on a dimension.
            Answers are not finite at the start.
        AnalysisError: infeasible, not_optimal, target_missed, local_minimum, or an analysis fails.

    Warns:
        FlexmbWarning: The design is at an unstable equilibrium. Or the search left out designs with leaf springs that
            are clamped differently from the start.

    Source:
        Augmented Lagrangian within bounds: Conn, Gould, Toint 1991; Nocedal, Wright 2006, algorithm 17.4.
    """
    dimensions = {name: float_array(f"Dimension '{name}'", v) for name, v in dimensions.items()}
    functions, layout = named_answers(answers), layout_of(dimensions)
    options = options_of(choices or {}, layout.names)
    requirements = {"minimize": minimize, "maximize": maximize}
    requirements |= {"targets": targets or {}, "equal": equal or {}, "limits": limits or {}}
    asked = asked_names(requirements)
    sampled = sampled_of(scatter, samples, seed, asked, functions, layout.names, acceptable)
    if sampled is not None:
        refuse_two_values(sampled.scatter, dimensions)
    further = () if sampled is None else tuple(sampled.further(layout))
    if twice := [name for name in further if name in options]:
        raise ValueError(
            f"'{printable(twice[0])}' has choices and a nominal value. Scatter it about a dimension instead."
        )
    check_dimensions(build, (*layout.names, *further, *options))
    check_answer_names((*layout.names, *further, *options), tuple(functions), RESERVED)
    scaling = Scaling(layout, bounds, scales or {})
    first = layout.join(dimensions)
    scaling.check_inside(first)
    for name in (minimize, maximize):
        if name is not None and not isinstance(name, str):
            raise ValueError(
                f"Arguments `minimize` and `maximize` must be names of answers, not {printable(repr(name))}."
            )
    counts = starts, together, seed, tolerance, max_evaluations
    question = _Question(functions, scaling, first, requirements, optimizer, *counts, progress, sampled)
    if options:
        tuned = _best_combination(question, build, options)
    else:
        tuned, *_ = _searched(question, build)
    if throw and tuned.result is not RESULTS.successful:
        raise AnalysisError(tuned.result.name, f"{tuned.result.message} {tuned.reason}\n{tuned}")
    return tuned


class _Question(NamedTuple):
    """Checked arguments of :func:`tune`."""

    functions: dict[str, Callable[[Any], Any]]
    scaling: Scaling
    first: np.ndarray
    wanted: dict[str, Any]
    optimizer: Any
    starts: int
    together: int
    seed: int
    tolerance: float
    max_evaluations: int
    progress: Any
    sampled: SampledDesign | None


class _StartError(ValueError):
    """The start has no answer."""

    def __init__(self, message: str, result: RESULTS):
        super().__init__(message)
        self.result = result


def _best_combination(question: _Question, build: Build, options: Options) -> Tuned:
    """Return the best design of all combinations, with the result of each combination."""
    tried: list[Combination] = []
    faults: list[Exception] = []
    dependence, reference = [], None
    for values, labels in combinations(options):
        try:
            tuned, ignored, sizes = _searched(question, functools.partial(build, **values), reference, alone=False)
        except (*REFUSED, _StartError) as fault:
            faults.append(fault)
            why = fault.result if isinstance(fault, _StartError) else RESULTS.impossible_design
            tried.append(Combination(values, labels, None, why, printable(first_line(fault))))
            continue
        reference = sizes if reference is None else reference
        dependence.append(ignored)
        tried.append(Combination(values, labels, tuned, tuned.result, tuned.reason))
    if not dependence:
        raise faults[0]
    # Answers may depend on a dimension in some combinations only, such as a gap between two leaf springs.
    _refuse_ignored(question.scaling.layout.labels, np.all(dependence, axis=0))

    def rank(combination: Combination) -> tuple:
        if (tuned := combination.tuned) is None:
            return np.inf, np.inf
        return tuned.violation > question.tolerance and tuned.violation, tuned.objective

    best = min(tried, key=rank)
    assert best.tuned is not None
    return dataclasses.replace(best.tuned, choices=best.choices, combinations=tuple(tried))


class _Kernel:
    """Answers, (m,), derivatives of the wanted answers by the scaled dimensions, (m, n), and the code.

    Unstable states have answers; ``unstable`` contains their designs. Designs with other clamps than the start have no
    answers; ``left_out`` is True after such a design.
    """

    def __init__(
        self, of_unit: Callable[..., Any], refused: Callable[..., Any], start: np.ndarray, asked: np.ndarray, m: int
    ):
        def wanted(unit: Float[Array, "n"]):
            values, code = of_unit(unit)
            return values[asked], (values, code)

        self.asked, self.start, self.of_unit, self.refused, self.m = asked, start, of_unit, refused, m
        self.unstable: set[bytes] = set()
        self.left_out = False
        function = with_slopes(wanted, len(start), len(asked))
        self.one, self.several = jit(function), jit(jax.vmap(function))

    def __call__(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        def one(units: Any) -> Any:
            return jax.tree.map(lambda array: array[None], self.one(units[0]))

        (values,), (slopes,), (code,) = self._of(unit[None], one)
        return values, slopes, int(code)

    def many(self, units: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the same for several designs, (designs, n), in one call."""
        return self._of(units, self.several)

    def _of(self, units: np.ndarray, call: Callable[..., Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        refused = self.refused(units)
        # The start replaces designs that cannot be built, since their analysis could be slow.
        asked_slopes, (_, (values, codes)) = call(jnp.asarray(np.where(refused[:, None], self.start, units)))
        values, codes = np.array(values), np.where(refused, RESULTS.impossible_design, codes)
        self.left_out |= bool(np.any(codes == RESULTS.other_clamps))
        unstable = codes == RESULTS.unstable_state
        self.unstable |= {unit.tobytes() for unit in units[unstable]}
        codes = np.where(unstable, RESULTS.successful, codes)
        slopes = np.zeros((*values.shape, units.shape[1]))
        slopes[:, self.asked] = asked_slopes
        values[refused], slopes[refused] = np.nan, np.nan
        return values, slopes, codes


def _searched(
    question: _Question, build: Build, reference: np.ndarray | None = None, *, alone: bool = True
) -> tuple[Tuned, np.ndarray, np.ndarray]:
    """Return the best design of all starts, whether each dimension has no effect, and the sizes of the answers."""
    q = question
    kernel, of_answers = _kernel_of(q, build)
    at_start = kernel(kernel.start)
    note = "" if q.sampled is None else " Every made mechanism needs one: narrow `scatter`."
    _check_start(of_answers, at_start, note)
    if reference is not None and reference.shape != at_start[0].shape:
        raise ValueError("Answers have different shapes in different combinations of choices. Make them the same.")
    # An answer that is zero at the start is scaled by its change across the bounds: 1 m may be far too large.
    own = np.where(at_start[0] != 0, at_start[0], np.max(np.abs(at_start[1]), axis=1, initial=0.0))
    sizes = own if reference is None else reference
    problem = make_problem(of_answers, sizes, margin=q.tolerance, **q.wanted)
    ignored = _ignored(problem, kernel, at_start[1], q.seed)
    if alone:
        _refuse_ignored(q.scaling.layout.labels, ignored, _flat_yield(of_answers, at_start, kernel.asked))
    runs = _attempts(q, problem, kernel)
    limit = 2 * q.tolerance
    best = min(runs, key=lambda run: (not run.answered, run.violation > limit and run.violation, run.objective))
    tuned = _tuned_of(q, best, runs, problem, of_answers, at_start[0])
    _tell(kernel, best)
    curves = {name: target for name, target in q.wanted["targets"].items() if isinstance(target, Curve)}
    return dataclasses.replace(tuned, curves=curves), ignored, sizes


def _kernel_of(q: _Question, build: Build) -> tuple[_Kernel, Layout]:
    """Return the kernel of a question, and the layout of its answers."""
    scaling, layout = q.scaling, q.scaling.layout
    first, full_layout, to_rows = layout.split(q.first), layout, lambda flat: flat[None]
    if q.sampled is not None:
        first |= q.sampled.further(layout)
        full_layout, to_rows = q.sampled.made(layout)
    models = build_once(build, first)
    of_flat = flat_function if q.sampled is None else q.sampled.function
    function, of_answers = of_flat(build, q.functions, layout, models)
    of_designs = refusal_of_designs(build, models, first) if full_layout.names else None

    def of_unit(unit: Float[Array, "n"]):
        return function(scaling.to_dimensions(unit))

    def refused(units: np.ndarray) -> np.ndarray:
        if of_designs is None:
            return np.zeros(len(units), bool)
        # A design of which one made mechanism cannot be built has no statistics.
        rows = np.stack([to_rows(scaling.to_dimensions(unit)) for unit in units])
        return np.any(of_designs(full_layout.stacked(rows.reshape(-1, rows.shape[-1]))).reshape(len(units), -1), axis=1)

    named = asked_names(q.wanted)
    asked = np.repeat([name in named for name in of_answers.names], of_answers.sizes)
    kernel = _Kernel(of_unit, refused, scaling.to_unit(q.first), np.flatnonzero(asked), len(asked))
    return kernel, of_answers


def _attempts(q: _Question, problem: TuningProblem, kernel: _Kernel) -> list[Attempt]:
    """Search from all starts, one after the other or several at a time."""
    units = q.scaling.starts(q.first, q.starts, q.seed)
    with reporting(q.progress, "evaluations, objective, violation") as report:

        def from_start(compute: Kernel, unit: np.ndarray):
            how = q.optimizer, q.tolerance, q.max_evaluations
            return search_from(problem, compute, kernel.of_unit, kernel.refused, unit, *how, progress=report)

        size = min(q.together, q.starts)
        if size > 1:
            return in_lockstep(from_start, units, kernel.many, size)
        return [from_start(kernel, unit) for unit in units]


def _tell(kernel: _Kernel, best: Attempt) -> None:
    """Warn of designs that were left out, and of an unstable best design."""
    if kernel.left_out:
        warn(
            "The search left out designs whose leaf springs are clamped differently from the start: a neighbouring part"
            " passed three times the thickness, or a fold passed 5 degrees. Start on the other side to search there, or"
            " set `clamped`."
        )
    if best.unit.tobytes() in kernel.unstable:
        warn(
            "The design is at an equilibrium that is not stable: its stiffness is negative in some motion. Exclude such"
            " designs by a limit on fm.buckling_loads(model)[0] or on a frequency, which is negative there."
        )


def _check_start(of_answers: Layout, at_start: Any, note: str) -> None:
    values, slopes, code = at_start
    if code != RESULTS.successful:
        text = f"The start has no answer ({RESULTS(code).name}): {RESULTS(code).message}{note}"
        raise _StartError(text, RESULTS(code))
    for name, value, row in zip(of_answers.labels, values, slopes, strict=True):
        if not np.isfinite(value):
            text = f"Answer '{name}' is {value} at the start. Start elsewhere, or use an answer that is finite."
            raise _StartError(text, RESULTS.not_finite)
        if not np.all(np.isfinite(row)):
            text = f"Answer '{name}' has no finite derivative at the start. Start elsewhere."
            raise _StartError(text, RESULTS.not_finite)


def _ignored(problem: TuningProblem, kernel: _Kernel, slopes: np.ndarray, seed: int) -> np.ndarray:
    """Return for each dimension whether no answer depends on it, (n,), at the start and at points beside it."""
    asked = np.abs(problem.weights) > 0
    for rows in (problem.targets, problem.equal, problem.limits):
        asked |= np.any(rows.matrix != 0, axis=0)
    ignored = ~np.any(slopes[asked] != 0, axis=0)
    if np.any(ignored):
        unit = kernel.start
        aside = np.clip(unit + 0.05 * np.random.default_rng(seed).uniform(-1, 1, len(unit)), 0.01, 0.99)
        ignored &= ~np.any(kernel(aside)[1][asked] != 0, axis=0)
    return ignored


def _flat_yield(of_answers: Layout, at_start: Any, asked: np.ndarray) -> str:
    """Return advice if small changes of the dimensions do not change a wanted yield; otherwise an empty text."""
    values, slopes, _ = at_start
    place = of_answers.labels.index(YIELD) if YIELD in of_answers.labels else -1
    if place not in asked or np.any(slopes[place] != 0):
        return ""
    return f"The yield is {values[place]:g} near the start. Start where only some made mechanisms are acceptable."


def _refuse_ignored(labels: list[str], ignored: np.ndarray, advice: str = "") -> None:
    if np.any(ignored):
        names = ", ".join(f"'{label}'" for label, i in zip(labels, ignored, strict=True) if i)
        advice = advice or "Fix it in `build`, or add an answer that depends on it."
        raise ValueError(f"No wanted answer depends on dimension {names}. {advice}")


def _tuned_of(
    q: _Question, best: Attempt, runs: list[Attempt], problem: TuningProblem, of_answers: Layout, start: np.ndarray
) -> Tuned:
    scaling, layout, active = q.scaling, q.scaling.layout, q.scaling.at_bounds(best.unit)
    if best.answered:
        reached = np.abs(problem.limits(best.answers)) < 100 * q.tolerance
        active += [f"{n} is reached" for n, r in zip(problem.limits.names, reached, strict=True) if r]
    result, reason = best.result, best.reason
    if result in (RESULTS.infeasible, RESULTS.not_optimal) and (bad := problem.violated(best.answers, 2 * q.tolerance)):
        result, reason = RESULTS.infeasible, f"Violated: {', '.join(bad)}."
    rows = np.array([np.asarray(scaling.to_dimensions(u)) for u, _ in best.history])
    values = np.array([a for _, a in best.history])
    history = {
        **layout.stacked(rows),
        **of_answers.stacked(values),
        "objective": np.array([problem.objective(a) for a in values]),
        "violation": np.array([problem.violation(a) for a in values]),
    }

    def plain(named: dict[str, np.ndarray]) -> dict[str, Any]:
        return {name: float(v) if v.ndim == 0 else v for name, v in named.items()}

    return Tuned(
        plain(layout.split(np.asarray(scaling.to_dimensions(best.unit)))),
        plain(of_answers.split(best.answers)),
        plain(of_answers.split(start)),
        result,
        reason,
        tuple(active),
        best.objective,
        max(best.violation - q.tolerance, 0.0),
        history,
        np.array([[run.objective, run.violation] for run in runs]),
    )
