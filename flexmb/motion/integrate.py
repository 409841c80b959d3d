"""Integration of equations of motion by diffrax: at once, between the samples of a controller, in parts to watch."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record, static
from ..math.derivative import Varied, jit_beside_reverse, refusing_derivatives, with_derivative
from ..mechanics.sparse_order import SparseOrder
from ..mechanics.tree import Tree
from ..model.model import Model
from ..model.topology import coordinate_scales
from ..numerical_limits import DRIVEN_START, SAME_TIME
from ..progress import reporting
from ..results import RESULTS
from .balance import Before
from .chain_form import chain_form
from .controlled_form import ControlledForm, Feedback
from .controllers import Sampled
from .coordinates_form import CoordinatesForm, coordinates_form
from .drive import Driven
from .integrator import Integrator
from .loop import controlled_form, under_inputs
from .protocol import Equations, MotionState, WholeMotion
from .reduced_form import ReducedForm, reduced_form
from .start import Start, driven_start, driving, is_determined
from .steps_again import Span, pulled_back
from .tree_form import TreeForm, tree_form

if TYPE_CHECKING:
    from .solve import Solved

# Larger chains and nets start by the least change: the other start needs dense matrices.
MANY = 3000
# Error of a second derivative in reverse.
ONCE = (
    "A motion can be differentiated once in reverse. For second derivatives use jax.jacfwd of jax.jacfwd with"
    " fm.simulate(.., adjoint=diffrax.ForwardMode())."
)
# Parts of a simulation that shows its progress: few, since the integration restarts in each.
PARTS = 50
# The first step is at most this fraction of the time, or of an interval between two samples.
FIRST, FIRST_OF_SAMPLE = 50.0, 4.0


class Problem(Record):
    """A mechanism, its functions of time, and the controller.

    Attributes:
        jumps: Ascending times to step onto.
        measured_from: Nodal coordinates from which rotations in space are measured.
        order: Order of the unknowns of a chain or a net.
        tree: Beams with computed last ends, for the form "tree".
        still: Whether everything that is driven starts at its place, at rest.
        stops: Times to step onto without a jump.
    """

    model: Model
    driven: tuple[Driven, ...]
    feedback: Feedback | Sampled | None
    jumps: Float[Array, "k"] | None
    measured_from: Float[Array, "n_x"] | None
    order: SparseOrder | None = None
    tree: Tree | None = None
    still: bool = static(default=False)
    stops: Float[Array, "k"] | None = None


class Reached(NamedTuple):
    """Where an integration continues.

    Attributes:
        state: State, or the start of the motion.
        memory: States of a sampled controller, and its last inputs.
        before: Values that control step sizes.
    """

    state: MotionState | Start
    memory: Any
    before: Before


class Integrated(NamedTuple):
    """Result of an integration.

    Attributes:
        rows: Motion at each time.
        steps: Number of time steps.
        result: Code of RESULTS.
        last: End, to continue from.
        jumped: Whether a force has jumped; known if a derivative needs it.
    """

    rows: WholeMotion
    steps: Int[Array, ""]
    result: Int[Array, ""]
    last: Reached
    jumped: Bool[Array, ""] | bool = False


def _by_options(integrator: Integrator) -> bool:
    """Whether diffrax differentiates by its adjoint."""
    options = (integrator.solver, integrator.controller, integrator.adjoint, integrator.event)
    return any(option is not None for option in options)


def _solved(
    equations: Equations,
    problem: Problem,
    integrator: Integrator,
    span: Span,
    start: MotionState,
    before: Before,
    derived: bool = False,
    known: tuple[Solved, Array] | None = None,
) -> Solved:
    """States at times."""
    import diffrax

    from .solve import solve

    parts = FIRST_OF_SAMPLE if isinstance(problem.feedback, Sampled) else FIRST
    if _by_options(integrator):
        adjoint = diffrax.RecursiveCheckpointAdjoint() if integrator.adjoint is None else integrator.adjoint
        return solve(equations, span, start, integrator, before, parts, adjoint=adjoint, every=True)[0]

    def plain(*arguments: Any):
        return known[0] if known is not None else _forward(*arguments, parts, every=derived)[0]

    def ahead(*arguments: Any):
        return known if known is not None else _forward(*arguments, parts, every=True, recorded=True)

    def back(varied: list[Varied], ends: Array, changes: Solved):
        derivatives = pulled_back(varied[:3], ends, changes.states)
        # Tolerances and values before the start only choose the steps, which are constant.
        none = [[jnp.zeros_like(number) for number in part.numbers] for part in varied[3:]]
        return refusing_derivatives((*derivatives, *none), ONCE)

    return with_derivative(plain, ahead, back, equations, span, start, integrator, before)


def _forward(*arguments: Any, **options: Any) -> Any:
    import diffrax

    from .solve import solve

    return solve(*arguments, adjoint=diffrax.ForwardMode(), **options)


def _equations(problem: Problem, form: str | None) -> CoordinatesForm | ReducedForm | ControlledForm | TreeForm:
    if problem.order is not None:
        # Its solver uses element matrices, no dense tangent.
        chain: Any = chain_form(problem.model, problem.driven, problem.order)
        return chain
    tree = problem.tree if form == "tree" else None
    with_elements = tree is None or tree.held_places.shape[0] > 0
    mechanism = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven, whole=with_elements)
    if form == "reduced":
        return reduced_form(mechanism)
    if tree is not None:
        return tree_form(mechanism, tree)
    if isinstance(problem.feedback, Feedback):
        return controlled_form(problem.model, mechanism, problem.measured_from, problem.feedback)
    return mechanism


def _started(
    equations: Equations, problem: Problem, t: Float[Array, ""], initial: Start | MotionState
) -> tuple[MotionState, Any]:
    """State at the start of a motion, and a code of RESULTS."""
    fine = jnp.asarray(RESULTS.successful, jnp.int32)
    if isinstance(initial, MotionState):
        return initial, fine
    start = equations.state_of(*initial)
    if problem.still or not driving(problem.model.parameters, problem.driven):
        return start, fine
    form = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven)
    # Driven coordinates move the others; if degrees of freedom do not determine them, by the least change.
    state = equations.settle(t, start)
    extent = jnp.max(coordinate_scales(form.topology, form.parameters), initial=1.0)
    reached = jnp.max(jnp.abs(equations.gap(t, state)), initial=0.0) <= DRIVEN_START * extent
    if is_determined(form) and (problem.order is None or form.topology.n_x <= MANY):
        placed_start, met = driven_start(form, t, initial)
        state = jax.tree.map(lambda a, b: jnp.where(met, a, b), equations.state_of(*placed_start), state)
        reached = reached | met
    return state, jnp.where(reached, fine, RESULTS.out_of_reach).astype(jnp.int32)


@jit_beside_options
def begin(problem: Problem, form: str, t: Float[Array, ""], given: Start) -> MotionState:
    """State at the start of a motion."""
    return _started(_equations(problem, form), problem, t, given)[0]


@jit_beside_options
def soon_after(problem: Problem, form: str, t: Float[Array, ""], given: Start, wait: Float[Array, ""]) -> MotionState:
    """State a time `wait` after the start, by rates and accelerations there."""
    equations = _equations(problem, form)
    state, _ = _started(equations, problem, t, given)
    faster = wait * equations.acceleration(t, state)[0][: state.u.shape[0]]
    return state._replace(u=state.u + wait * (state.w + faster / 2), w=state.w + faster)


def _either(function: Callable[..., Integrated], ahead: Callable[..., Any]) -> Callable[..., Integrated]:
    """Compiled function of a problem, an integrator and more, which diffrax or we differentiate."""
    asked, stepped = jit_beside_options(function), jit_beside_reverse(function, ahead, ONCE)

    def run(problem: Problem, integrator: Integrator, *more: Any) -> Integrated:
        return (asked if _by_options(integrator) else stepped)(problem, integrator, *more)

    return run


def _integrated(
    problem: Problem,
    integrator: Integrator,
    span: Float[Array, "2"],
    times: Float[Array, "n_t"],
    reached: Reached,
    known: tuple[Solved, Array] | None = None,
    recorded: bool = False,
) -> Any:
    """Result of an integration; if recorded, also the solution and the ends of its steps for a derivative."""
    equations = _equations(problem, integrator.form)
    start, begun = _started(equations, problem, span[0], reached.state)
    stretch = Span(span[0], span[1], times, problem.stops, problem.jumps)
    if recorded:
        pair: Any = _forward(equations, stretch, start, integrator, reached.before, FIRST, every=True, recorded=True)
        solved, known = pair[0], pair
    else:
        solved = _solved(equations, problem, integrator, stretch, start, reached.before, known=known)
    # Between steps the state is interpolated, off the constraints.
    rows: WholeMotion = jax.lax.map(lambda at: equations.whole_motion(at[0], equations.settle(*at)), (times, solved[0]))
    result = jnp.where(begun == RESULTS.successful, solved.result, begun)
    jumped = solved.jumped & (result == RESULTS.successful)
    last = Reached(_last(solved.states), reached.memory, Before(solved.moved, solved.balance))
    integrated = Integrated(rows, solved.steps, result, last, jumped)
    return (integrated, known) if recorded else integrated


def _recorded(*arguments: Any) -> tuple[Integrated, tuple[Solved, Array]]:
    return _integrated(*arguments, recorded=True)


# Motion over a span (2,) [s] from where it is reached, given at times.
integrate = _either(_integrated, _recorded)


def _last(states: MotionState) -> MotionState:
    return jax.tree.map(lambda rows: rows[-1], states)


class Intervals(NamedTuple):
    """Intervals between the samples of a controller.

    Attributes:
        times: Times wanted in each, padded with its end.
        interval, place: Interval of each time, and place in it.
    """

    begin: Float[Array, "k"]
    end: Float[Array, "k"]
    times: Float[Array, "k m"]
    interval: Int[Array, "n_t"]
    place: Int[Array, "n_t"]


def _integrated_sampled(
    problem: Problem,
    integrator: Integrator,
    grid: Intervals,
    times: Float[Array, "n_t"],
    reached: Reached,
    derived: bool = False,
    known: None = None,
) -> Integrated:
    sampled: Any = problem.feedback
    undriven = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven)
    sensors = controlled_form(problem.model, undriven, problem.measured_from)

    def interval(carry: tuple[Any, ...], at: tuple[Any, ...]):
        state, (memory, u), before = carry
        begin, end, interval_times = at
        # Inputs before a sample cause the accelerations there.
        z = under_inputs(problem.model, undriven, u).acceleration(begin, state)[0] if sensors.places.late else None
        u, memory = sampled.step(begin, memory, sensors.measured(begin, state, z, u))
        u = jnp.atleast_1d(jnp.asarray(u, float))
        equations = under_inputs(problem.model, undriven, u)
        span = Span(begin, end, interval_times, problem.stops, problem.jumps)
        solved = _solved(equations, problem, integrator, span, state, before, derived)
        before = Before(solved.moved, solved.balance)
        return Reached(_last(solved.states), (memory, u), before), (solved.states, u, *solved[2:5])

    first, begun = _started(undriven, problem, grid.begin[0], reached.state)
    start = reached._replace(state=first)
    rows_of: Any
    # A derivative repeats one interval at a time: all at once would fill the memory.
    last, rows_of = jax.lax.scan(jax.checkpoint(interval), start, grid[:3])
    states, u, steps, result, jumped = rows_of
    chosen = jax.tree.map(lambda rows: rows[grid.interval, grid.place], states)
    rows: WholeMotion = jax.lax.map(lambda at: undriven.whole_motion(at[0], undriven.settle(*at)), (times, chosen))
    # An event ends the motion without failure. Intervals after it start from no state and do not count.
    over = (result != RESULTS.successful) | ~jnp.all(jnp.isfinite(states.u[:, -1]), axis=1)
    result = jnp.where(jnp.any(over), result[jnp.argmax(over)], RESULTS.successful)
    result = jnp.where(begun == RESULTS.successful, result, begun)
    return Integrated(rows._replace(u=u[grid.interval]), jnp.sum(steps), result, last, jnp.any(jumped))


def _derived_sampled(*arguments: Any) -> tuple[Integrated, None]:
    # Steps of all intervals at once would fill the memory.
    return _integrated_sampled(*arguments, derived=True), None


# Motion under a controller that acts at equal intervals, given at times, from where it is reached.
integrate_sampled = _either(_integrated_sampled, _derived_sampled)


def sampled_intervals(times: np.ndarray, period: float, start: float, end: float) -> Intervals:
    """Intervals of a sampled controller from `start` to `end`, and the times in each; a sample begins its interval."""
    count = max(int(np.ceil((end - start) / period - SAME_TIME)), 1)
    starts = start + period * np.arange(count)
    ends = np.append(starts[1:], end)
    interval = np.clip(np.searchsorted(starts, times + SAME_TIME * period, side="right") - 1, 0, count - 1)
    place = np.arange(len(times)) - np.searchsorted(interval, interval)
    rows = np.repeat(ends[:, None], np.max(place) + 2, axis=1)
    rows[interval, place] = np.clip(times, starts[interval], ends[interval])
    return Intervals(*jax.device_put((starts, ends, rows, interval, place)))


def _bounds(times: np.ndarray, feedback: Feedback | Sampled | None, dt0: float) -> np.ndarray:
    """Ends of the parts, at whole samples or whole steps."""
    span = times[-1] - times[0]
    unit = feedback.period if isinstance(feedback, Sampled) else dt0 if dt0 > 0 else span / PARTS
    units = max(int(np.ceil(span / unit - SAME_TIME)), 1)
    least = -(-units // PARTS)
    # Parts of one size are compiled once: prefer a size without a shorter part at the end.
    size = next((n for n in range(least, 2 * least + 1) if units % n == 0), least)
    ends = times[0] + unit * np.arange(0, units, size)
    return np.append(ends, times[-1])


def integrate_in_parts(
    problem: Problem,
    integrator: Integrator,
    times: Float[Array, "n_t"],
    at: Reached,
    progress: Callable[[int, int], None] | bool,
) -> Integrated:
    """Motion in parts; after a keyboard interruption the motion so far.

    Returns:
        Integrated, with rows of the times reached; rows of a failed part may be not finite.
    """
    all_times, feedback, dt0 = np.asarray(times), problem.feedback, float(np.asarray(integrator.dt0))
    bounds = _bounds(all_times, feedback, dt0)
    part = np.clip(np.searchsorted(bounds, all_times, side="right") - 1, 0, len(bounds) - 2)
    width = int(np.max(np.bincount(part))) + 1
    at = at._replace(state=begin(problem, str(integrator.form), jnp.asarray(all_times[0]), at.state))
    rows: list[list[np.ndarray]] = []
    steps, result = 0, RESULTS.successful
    with reporting(progress, "simulating", len(bounds) - 1) as report:
        try:
            for i, (start, end) in enumerate(itertools.pairwise(bounds)):
                part_times = all_times[part == i]
                filled = np.append(part_times, np.full(width - len(part_times), end))
                if isinstance(feedback, Sampled):
                    grid = sampled_intervals(filled, feedback.period, start, end)
                    run = integrate_sampled(problem, integrator, grid, jnp.asarray(filled), at)
                else:
                    run = integrate(problem, integrator, jnp.asarray([start, end]), jnp.asarray(filled), at)
                rows.append([np.asarray(column)[: len(part_times)] for column in run.rows])
                steps, result, at = steps + int(run.steps), RESULTS(int(run.result)), run.last
                if report is not None:
                    report(i + 1, len(bounds) - 1)
                if result != RESULTS.successful or not np.all(np.isfinite(np.asarray(at.state[0]))):
                    break
                if not isinstance(feedback, Sampled) and dt0 == 0:
                    # The next part starts with the mean step of this one.
                    mean_step = jnp.asarray((end - start) / max(int(run.steps), 1))
                    integrator = dataclasses.replace(integrator, dt0=mean_step)
        except KeyboardInterrupt:
            result = RESULTS.stopped
    if not rows:
        top, inputs = problem.model.topology, 0 if feedback is None else len(problem.model.labels.inputs)
        rows.append([np.zeros((0, size)) for size in (top.n_x, top.n_x, top.n_e, inputs)])
    whole_motion = WholeMotion(*jax.device_put([np.concatenate(column) for column in zip(*rows, strict=True)]))
    return Integrated(whole_motion, jnp.asarray(steps), jnp.asarray(int(result)), at)
