"""Integration in time by diffrax: of equations of motion, and from sample to sample of a controller."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record, static
from ..math.derivative import Varied, jit_beside_reverse, refusing_derivatives, with_derivative
from ..mechanics.extent import sizes_of
from ..mechanics.levels import Levels
from ..mechanics.sparse_order import SparseOrder
from ..mechanics.tree import Tree
from ..model.model import Model
from ..results import RESULTS
from .balance import Before, is_seen
from .chain_form import chain_form
from .chain_march import march_chain
from .chain_march_back import radau
from .controlled_form import ControlledForm, Feedback
from .controllers import Sampled
from .coordinates_form import CoordinatesForm, coordinates_form
from .drive import Driven
from .events import passing_of
from .integrator import Integrator
from .kinks import kinks_of
from .loop import controlled_form, measuring, under_inputs
from .march import Marched, march
from .march_back import march_back
from .protocol import Equations, MotionState, WholeMotion
from .reduced_form import ReducedForm, reduced_form
from .start import Start, driven_start, driving, is_determined
from .step_size import SMALLEST_STEP
from .tape import Span, Tape
from .tree_form import TreeForm, tree_form

# Where a mechanism is not where it is driven by more than this share of its extent, it cannot be assembled there.
MET = 1e-6
# Of more coordinates of a chain or a net, which dense matrices would bring there, it is the least change.
MANY = 3000
# What a derivative of a derivative in reverse is told.
ONCE = (
    "A motion is differentiated in reverse once. Second derivatives are found forward, by jax.jacfwd of jax.jacfwd with"
    " fm.simulate(.., adjoint=diffrax.ForwardMode())."
)
# The first step is at most one of so many parts of the time, or of an interval between two samples.
FIRST, FIRST_OF_SAMPLE = 50.0, 4.0


class Problem(Record):
    """What is integrated: a mechanism, what depends on time, and the controller around it.

    Attributes:
        model: Mechanism.
        driven: What depends on time.
        feedback: Controller, or None.
        jumps: Times to be stepped onto, ascending, (k,) [s], or None.
        measured_from: Nodal coordinates from which rotations in space are measured, (n_x,) [m, rad, -], or None.
        order: Of the unknowns of a chain or a net, or None.
        tree: Beams whose last ends are computed, for the form "tree".
        still: Whether what is driven begins where it was, at rest.
        stops: Times to be stepped onto where nothing jumps, (k,) [s], or None.
    """

    model: Model
    driven: tuple[Driven, ...]
    feedback: Feedback | Sampled | None
    jumps: Float[Array, "k"] | None
    measured_from: Float[Array, "n_x"] | None
    order: Levels | SparseOrder | None = None
    tree: Tree | None = None
    still: bool = static(default=False)
    stops: Float[Array, "k"] | None = None


class Reached(NamedTuple):
    """Where an integration goes on from.

    Attributes:
        state: State, or where the motion starts from.
        memory: State of a sampled controller and the inputs that it gave last, None without one.
        before: By which step sizes are controlled.
    """

    state: MotionState | Start
    memory: Any
    before: Before


class Integrated(NamedTuple):
    """What an integration found.

    Attributes:
        rows: The motion, a row for each of the times asked for.
        steps: Number of time steps.
        result: Code of RESULTS.
        last: Its end, to go on from.
        jumped: Whether a force has jumped, as far as that was looked at, as where a derivative is asked for.
    """

    rows: WholeMotion
    steps: Int[Array, ""]
    result: Int[Array, ""]
    last: Reached
    jumped: Bool[Array, ""] | bool = False


def _by_options(problem: Problem, integrator: Integrator) -> bool:
    """Whether diffrax's own loop is asked for, by a solver, an adjoint and the like, or by jumps."""
    own = (integrator.solver, integrator.controller, integrator.adjoint, integrator.event, problem.jumps)
    return any(one is not None for one in own)


def _solved(
    equations: Equations,
    problem: Problem,
    integrator: Integrator,
    t0: Float[Array, ""],
    t1: Float[Array, ""],
    times: Float[Array, "n_t"],
    start: MotionState,
    before: Before,
    derived: bool = False,
    taped: bool = False,
    known: tuple[Marched, Tape] | None = None,
) -> tuple[Marched, Tape | None]:
    """States at times between t0 and t1, what else is found on the way, and a tape where one is asked for.

    Args:
        derived: Whether it is asked for beside a derivative, so that steps across kinks are short.
        taped: Whether the way back is another program, which needs the tape.
        known: What this one found, there.
    """
    parts = FIRST_OF_SAMPLE if isinstance(problem.feedback, Sampled) else FIRST
    if _by_options(problem, integrator):
        onto = problem.jumps, problem.stops
        return _by_diffrax(parts, equations, integrator, onto, t0, t1, times, start, before), None

    def given(*own: Any) -> Any:
        equations, span, start, integrator, before = own

        def first(fast: Float[Array, ""]):
            return _first_step(integrator, fast, span.t1 - span.t0, parts, False)

        allowed = (integrator.rtol, integrator.atol)
        return equations, span, start, before, allowed, first, integrator.max_steps

    own: tuple[Any, ...] = equations, Span(t0, t1, times, problem.stops), start, integrator, before

    def marched(*own: Any, taped: bool, derived: bool):
        if problem.order is not None:
            return march_chain(*given(*own), taped=taped)
        return march(*given(*own), taped=taped, kinks=kinks_of(own[0], derived))

    def ahead(*own: Any):
        return marched(*own, taped=True, derived=True) if known is None else known

    if taped:
        return ahead(*own)

    def plain(*own: Any):
        return (marched(*own, taped=False, derived=derived) if known is None else known)[0]

    def back(parts: list[Varied], tape: Tape, changes: Marched):
        equations, span, start, *rest = parts
        if problem.order is None:
            found = march_back(equations, span, start, tape, changes)
        else:
            by: Integrator = rest[0].whole(rest[0].numbers)
            found = march_back(equations, span, start, tape, changes, radau((by.rtol, by.atol)))
        # The tolerances and what came before choose the steps, which are as they are.
        none = [[jnp.zeros_like(number) for number in part.numbers] for part in rest]
        return refusing_derivatives((*found, *none), ONCE)

    return with_derivative(plain, ahead, back, *own), None


def _by_diffrax(
    parts: float,
    equations: Equations,
    integrator: Integrator,
    onto: tuple[Array | None, Array | None],
    t0: Float[Array, ""],
    t1: Float[Array, ""],
    times: Float[Array, "n_t"],
    start: MotionState,
    before: Before,
) -> Marched:
    """States at times, by any solver; the first step is so small a part of the time at most."""
    import diffrax

    from .collocation import carried_from
    from .radau import Radau
    from .rosenbrock import Rosenbrock
    from .step_control import DisplacementController
    from .term import MotionTerm

    solver, controller = _solver_and_steps(equations, integrator, onto, t1 - t0, before)
    adjoint = diffrax.RecursiveCheckpointAdjoint() if integrator.adjoint is None else integrator.adjoint
    equal = isinstance(controller, diffrax.ConstantStepSize)
    z0, regular = equations.acceleration(t0, start)
    # Nothing is integrated where some motion has no mass.
    t1, times = jnp.where(regular, t1, t0), jnp.where(regular, times, t0)
    fast = jax.lax.stop_gradient(jnp.max(jnp.abs(z0[: equations.size]), initial=1e-30))
    dt0 = _first_step(integrator, fast, t1 - t0, parts, equal)
    solution = diffrax.diffeqsolve(
        MotionTerm(equations),
        solver,
        t0,
        t1,
        dt0,
        start,
        saveat=diffrax.SaveAt(ts=times, controller_state=True),
        stepsize_controller=controller,
        adjoint=adjoint,
        event=integrator.event,
        max_steps=integrator.max_steps,
        solver_state=carried_from(z0) if isinstance(solver, Radau) else z0 if isinstance(solver, Rosenbrock) else None,
        throw=False,
    )
    states: Any = solution.ys
    if integrator.event is not None:
        # What ends at once has its start all the same.
        states = jax.tree.map(lambda row, own: jnp.where((times <= t0)[:, None], own, row), states, start)
    result = _code(solution, equal, integrator.event)
    result = jnp.where(regular, result, RESULTS.singular_mass).astype(jnp.int32)
    state: Any = solution.controller_state
    if isinstance(controller, diffrax.ClipStepSizeController):
        controller, state = controller.controller, state.inner_state
    jumped = jnp.zeros((), bool)
    if isinstance(controller, DisplacementController):
        _, before, search = state
        jumped = search.jumped
    steps = solution.stats["num_steps"].astype(jnp.int32)
    return Marched(states, before.moved, steps, result, jumped, before.balance)


def _solver_and_steps(
    equations: Equations,
    integrator: Integrator,
    onto: tuple[Array | None, Array | None],
    span: Float[Array, ""],
    before: Before,
) -> tuple[Any, Any]:
    """Solver and step size control of diffrax, as they are given, or as they are chosen here."""
    import diffrax

    from .projected import Projected
    from .radau import Radau
    from .rosenbrock import Rodas5P
    from .step_control import DisplacementController

    controller, (jumps, stops) = integrator.controller, onto
    solver = Rodas5P(jumps=jumps is not None) if integrator.solver is None else integrator.solver
    if integrator.form == "chain":
        solver = Radau(integrator.rtol, integrator.atol, jumps is not None)
    adapts = isinstance(solver.solver if isinstance(solver, Projected) else solver, diffrax.AbstractAdaptiveSolver)
    if controller is None and not adapts:
        controller = diffrax.ConstantStepSize()
    elif controller is None:
        controller = DisplacementController(
            rtol=integrator.rtol,
            atol=integrator.atol,
            pcoeff=0.1,
            icoeff=0.3,
            dtmin=SMALLEST_STEP * span,
            force_dtmin=False,
            before=before,
            states=equations.states,
            equations=equations if is_seen(equations) else None,
            kinks=kinks_of(equations),
            passing=passing_of(integrator.event, equations.states),
        )
    if isinstance(solver, Projected):
        solver = solver.with_tolerances(controller)
    if any(one is not None for one in onto) and isinstance(controller, diffrax.AbstractAdaptiveStepSizeController):
        controller = diffrax.ClipStepSizeController(controller, step_ts=stops, jump_ts=jumps)
    return solver, controller


def _code(solution: Any, equal: bool, event: Any) -> Int[Array, ""]:
    """Code of RESULTS of a solution of diffrax.

    Args:
        equal: Whether steps are of equal size.
        event: What may end it, or None.
    """
    import diffrax

    found, codes = solution.result, diffrax.RESULTS
    failed = RESULTS.step_too_large if equal else RESULTS.step_too_small
    result = jnp.where(found == codes.successful, RESULTS.successful, failed)
    result = jnp.where(found == codes.max_steps_reached, RESULTS.motion_unfinished, result)
    result = jnp.where(found == codes.internal_error, RESULTS.ran_away, result)
    if event is not None:
        ends = found == codes.event_occurred
        lost = functools.reduce(jnp.logical_or, jax.tree.leaves(solution.event_mask)) & ~ends
        return jnp.where(ends, RESULTS.successful, jnp.where(lost, RESULTS.event_not_found, result))
    wrong = (result == RESULTS.successful) & ~jnp.all(jnp.isfinite(solution.ys.u))
    return jnp.where(wrong, failed, result)


def _first_step(integrator: Integrator, fast: Float[Array, ""], span: Float[Array, ""], parts: float, equal: bool):
    """First step: as given, or such that the greatest acceleration moves the mechanism by some ten tolerances."""
    given = jnp.asarray(integrator.dt0)
    guess = jnp.fmin(jnp.sqrt(20 * (integrator.rtol + integrator.atol) / fast), span / parts)
    first = jnp.where(given > 0, given, guess)
    if not equal:
        return first
    # A whole number of equal steps is not to become one more by round-off.
    steps = jnp.round(span / first)
    return jnp.where(jnp.abs(span / first - steps) < 1e-9 * steps, span / steps, first)


def _equations(problem: Problem, form: str | None) -> CoordinatesForm | ReducedForm | ControlledForm | TreeForm:
    if problem.order is not None:
        # Its solver asks for element matrices in place of a dense tangent.
        chain: Any = chain_form(problem.model, problem.driven, problem.order)
        return chain
    mechanism = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven)
    if form == "reduced":
        return reduced_form(mechanism)
    if form == "tree" and problem.tree is not None:
        return tree_form(mechanism, problem.tree)
    if isinstance(problem.feedback, Feedback):
        return controlled_form(problem.model, mechanism, problem.feedback, problem.measured_from)
    return mechanism


def _started(
    equations: Equations, problem: Problem, t: Float[Array, ""], given: Start | MotionState
) -> tuple[MotionState, Any]:
    """State that a motion starts from, and a code of RESULTS."""
    fine = jnp.asarray(RESULTS.successful, jnp.int32)
    if isinstance(given, MotionState):
        return given, fine
    start = equations.state_of(*given)
    if problem.still or not driving(problem.model.parameters, problem.driven):
        return start, fine
    form = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven)
    # What is driven takes the rest along; where degrees of freedom do not say how, by the least change.
    state = equations.settle(t, start)
    extent = jnp.max(sizes_of(form.topology, form.parameters), initial=1.0)
    there = jnp.max(jnp.abs(equations.gap(t, state)), initial=0.0) <= MET * extent
    if is_determined(form) and (problem.order is None or form.topology.n_x <= MANY):
        found, met = driven_start(form, t, given)
        state = jax.tree.map(lambda a, b: jnp.where(met, a, b), equations.state_of(*found), state)
        there = there | met
    return state, jnp.where(there, fine, RESULTS.out_of_reach).astype(jnp.int32)


@jit_beside_options
def begin(problem: Problem, form: str, t: Float[Array, ""], given: Start) -> MotionState:
    """State that a motion starts from.

    Args:
        given: Where it starts from.
    """
    return _started(_equations(problem, form), problem, t, given)[0]


@jit_beside_options
def soon_after(problem: Problem, form: str, t: Float[Array, ""], given: Start, wait: Float[Array, ""]) -> MotionState:
    """State a little after the start of a motion, by its rates and accelerations.

    Args:
        given: Where it starts from.
        wait: How much later [s].
    """
    equations = _equations(problem, form)
    state, _ = _started(equations, problem, t, given)
    faster = wait * equations.acceleration(t, state)[0][: state.u.shape[0]]
    return state._replace(u=state.u + wait * (state.w + faster / 2), w=state.w + faster)


def integrate(
    problem: Problem, integrator: Integrator, span: Any, times: Float[Array, "n_t"], given: Reached
) -> Integrated:
    """Motion from one time to another, compiled.

    Args:
        integrator: How, as checked.
        span: Start and end, (2,) [s].
        times: Times at which to give it, (n_t,) [s].
        given: Where it goes on from.
    """
    return (_asked if _by_options(problem, integrator) else _marched)(problem, integrator, span, times, given)


def _integrated(
    problem: Problem,
    integrator: Integrator,
    span: Float[Array, "2"],
    times: Float[Array, "n_t"],
    given: Reached,
    known: tuple[Marched, Tape] | None = None,
) -> Integrated:
    return _with_tape(problem, integrator, span, times, given, False, known)[0]


def _with_tape(
    problem: Problem,
    integrator: Integrator,
    span: Float[Array, "2"],
    times: Float[Array, "n_t"],
    given: Reached,
    taped: bool = True,
    known: tuple[Marched, Tape] | None = None,
) -> tuple[Integrated, tuple[Marched, Tape | None]]:
    equations = _equations(problem, integrator.form)
    start, begun = _started(equations, problem, span[0], given.state)
    asked: dict[str, Any] = {"derived": taped, "taped": taped, "known": known}
    found, tape = _solved(equations, problem, integrator, span[0], span[1], times, start, given.before, **asked)
    states, moved, steps, result, jumped, balance = found
    # Between steps the state is interpolated, off the constraints.
    rows: WholeMotion = jax.lax.map(lambda at: equations.whole_motion(at[0], equations.settle(*at)), (times, states))
    result = jnp.where(begun == RESULTS.successful, result, begun)
    jumped = jumped & (result == RESULTS.successful)
    last = Reached(_last(states), given.memory, Before(moved, balance))
    return Integrated(rows, steps, result, last, jumped), (found, tape)


_asked = jit_beside_options(_integrated)
_marched = jit_beside_reverse(_integrated, _with_tape)


def _last(states: MotionState) -> MotionState:
    return jax.tree.map(lambda rows: rows[-1], states)


class Intervals(NamedTuple):
    """Intervals between the samples of a controller.

    Attributes:
        begin: (k,) [s].
        end: (k,) [s].
        times: Times asked for in each, filled up with its end, (k, m + 1) [s].
        interval: Interval of each time, (n_t,).
        place: Its place in the interval, (n_t,).
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
    given: Reached,
    derived: bool = False,
    known: None = None,
) -> Integrated:
    sampled: Any = problem.feedback
    undriven = coordinates_form(problem.model.topology, problem.model.parameters, problem.driven)
    sensors = measuring(problem.model, undriven, problem.measured_from)

    def interval(carry: tuple[Any, ...], at: tuple[Any, ...]):
        state, (memory, u), before = carry
        begin, end, wanted = at
        # Accelerations at a sample are those that the inputs before it cause.
        z = under_inputs(problem.model, undriven, u).acceleration(begin, state)[0] if sensors.places.late else None
        u, memory = sampled.step(begin, memory, sensors.measured(begin, state, z, u))
        u = jnp.atleast_1d(jnp.asarray(u, float))
        equations = under_inputs(problem.model, undriven, u)
        found = _solved(equations, problem, integrator, begin, end, wanted, state, before, derived)[0]
        before = Before(found.moved, found.balance)
        return Reached(_last(found.states), (memory, u), before), (found.states, u, *found[2:5])

    first, begun = _started(undriven, problem, grid.begin[0], given.state)
    start = given._replace(state=first)
    found: Any
    # A derivative takes one interval at a time anew: all at once would fill the memory.
    last, found = jax.lax.scan(jax.checkpoint(interval), start, grid[:3])
    states, u, steps, result, jumped = found
    chosen = jax.tree.map(lambda rows: rows[grid.interval, grid.place], states)
    rows: WholeMotion = jax.lax.map(lambda at: undriven.whole_motion(at[0], undriven.settle(*at)), (times, chosen))
    # An event ends the motion without a failure; what comes after its interval, from no state, is none of it.
    over = (result != RESULTS.successful) | ~jnp.all(jnp.isfinite(states.u[:, -1]), axis=1)
    result = jnp.where(jnp.any(over), result[jnp.argmax(over)], RESULTS.successful)
    result = jnp.where(begun == RESULTS.successful, result, begun)
    return Integrated(rows._replace(u=u[grid.interval]), jnp.sum(steps), result, last, jnp.any(jumped))


def _derived_sampled(*given: Any) -> tuple[Integrated, None]:
    # Tapes of all intervals at once would fill the memory.
    return _integrated_sampled(*given, derived=True), None


_asked_sampled = jit_beside_options(_integrated_sampled)
_sampled = jit_beside_reverse(_integrated_sampled, _derived_sampled)


def integrate_sampled(
    problem: Problem, integrator: Integrator, grid: Intervals, times: Float[Array, "n_t"], given: Reached
) -> Integrated:
    """Motion under a controller that acts at equal intervals, one after the other, compiled.

    Args:
        integrator: How, as checked.
        grid: The intervals and the times in them.
        times: Times at which to give it, (n_t,) [s].
        given: Where it goes on from.
    """
    return (_asked_sampled if _by_options(problem, integrator) else _sampled)(problem, integrator, grid, times, given)
