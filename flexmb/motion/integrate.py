"""Integration in time by diffrax: of equations of motion, and from sample to sample of a controller."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, NamedTuple

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
from .balance import Before
from .chain_form import chain_form
from .controlled_form import ControlledForm, Feedback
from .controllers import Sampled
from .coordinates_form import CoordinatesForm, coordinates_form
from .drive import Driven
from .integrator import Integrator
from .loop import controlled_form, measuring, under_inputs
from .protocol import Equations, MotionState, WholeMotion
from .reduced_form import ReducedForm, reduced_form
from .start import Start, driven_start, driving, is_determined
from .steps_again import Span, pulled_back
from .tree_form import TreeForm, tree_form

if TYPE_CHECKING:
    from .solve import Solved

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


def _by_options(integrator: Integrator, jumps: Any) -> bool:
    """Whether diffrax differentiates by its adjoint: with a solver, an adjoint and the like, or with jumps."""
    own = (integrator.solver, integrator.controller, integrator.adjoint, integrator.event, jumps)
    return any(one is not None for one in own)


def _solved(
    equations: Equations,
    problem: Problem,
    integrator: Integrator,
    times: tuple[Float[Array, ""], Float[Array, ""], Float[Array, "n_t"]],
    start: MotionState,
    before: Before,
    derived: bool = False,
    known: tuple[Solved, Array] | None = None,
) -> Solved:
    """States at times."""
    import diffrax

    from .solve import solve

    taken: Any = functools.partial(solve, adjoint=diffrax.ForwardMode())
    parts = FIRST_OF_SAMPLE if isinstance(problem.feedback, Sampled) else FIRST
    span = Span(*times, problem.stops, problem.jumps)
    if _by_options(integrator, problem.jumps):
        adjoint = diffrax.RecursiveCheckpointAdjoint() if integrator.adjoint is None else integrator.adjoint
        return solve(equations, span, start, integrator, before, parts, adjoint=adjoint, every=True)[0]

    def plain(*own: Any):
        return known[0] if known is not None else taken(*own, parts, every=derived)[0]

    def ahead(*own: Any):
        return known if known is not None else taken(*own, parts, every=True, recorded=True)

    def back(varied: list[Varied], ends: Array, changes: Solved):
        found = pulled_back(varied[:3], ends, changes.states)
        # The tolerances and what came before choose the steps, which are as they are.
        none = [[jnp.zeros_like(number) for number in part.numbers] for part in varied[3:]]
        return refusing_derivatives((*found, *none), ONCE)

    return with_derivative(plain, ahead, back, equations, span, start, integrator, before)


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
    return (_asked if _by_options(integrator, problem.jumps) else _stepped)(problem, integrator, span, times, given)


def _integrated(
    problem: Problem,
    integrator: Integrator,
    span: Float[Array, "2"],
    times: Float[Array, "n_t"],
    given: Reached,
    known: tuple[Solved, Array] | None = None,
) -> Integrated:
    equations = _equations(problem, integrator.form)
    start, begun = _started(equations, problem, span[0], given.state)
    found = _solved(equations, problem, integrator, (*span, times), start, given.before, known=known)
    return _whole(equations, times, found, begun, given)


def _whole(
    equations: Equations, times: Float[Array, "n_t"], found: Solved, begun: Int[Array, ""], given: Reached
) -> Integrated:
    """What a motion stands for."""
    # Between steps the state is interpolated, off the constraints.
    rows: WholeMotion = jax.lax.map(lambda at: equations.whole_motion(at[0], equations.settle(*at)), (times, found[0]))
    result = jnp.where(begun == RESULTS.successful, found.result, begun)
    jumped = found.jumped & (result == RESULTS.successful)
    last = Reached(_last(found.states), given.memory, Before(found.moved, found.balance))
    return Integrated(rows, found.steps, result, last, jumped)


def _recorded(
    problem: Problem, integrator: Integrator, span: Float[Array, "2"], times: Float[Array, "n_t"], given: Reached
) -> tuple[Integrated, tuple[Solved, Array]]:
    """As :func:`_integrated`, with what its derivative needs: what was found, and the ends of the steps."""
    import diffrax

    from .solve import solve

    equations = _equations(problem, integrator.form)
    start, begun = _started(equations, problem, span[0], given.state)
    own = Span(span[0], span[1], times, problem.stops)
    asked: Any = {"adjoint": diffrax.ForwardMode(), "every": True, "recorded": True}
    found, ends = solve(equations, own, start, integrator, given.before, FIRST, **asked)
    return _whole(equations, times, found, begun, given), (found, jnp.asarray(ends))


_asked = jit_beside_options(_integrated)
_stepped = jit_beside_reverse(_integrated, _recorded, ONCE)


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
        found = _solved(equations, problem, integrator, (begin, end, wanted), state, before, derived)
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
    # The steps of all intervals at once would fill the memory.
    return _integrated_sampled(*given, derived=True), None


_asked_sampled = jit_beside_options(_integrated_sampled)
_sampled = jit_beside_reverse(_integrated_sampled, _derived_sampled, ONCE)


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
    return (_asked_sampled if _by_options(integrator, problem.jumps) else _sampled)(
        problem, integrator, grid, times, given
    )
