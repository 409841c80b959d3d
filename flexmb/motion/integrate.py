"""Integration in time by diffrax: of equations of motion, and from sample to sample of a controller."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.compile import jit_beside_options
from ..model.model import Model
from ..results import RESULTS
from .coordinates_form import coordinates_form
from .loop import Sampled, controlled_form, measuring, under_inputs
from .protocol import MotionState
from .reduced_form import reduced_form

SMALLEST_STEP = 1e-12


class Run(NamedTuple):
    """What an integration found, at the times asked for.

    Attributes:
        x: Nodal coordinates, (n_t, n_x) [m, rad, -].
        xd: Their velocities, (n_t, n_x) [1/s].
        near: Deformations, (n_t, n_e) [m, rad].
        u: Inputs of a controller, (n_t, n_u) [N, N m].
        steps: Number of time steps.
        result: Code of RESULTS.
        last: State at the end, and what a sampled controller remembers, to go on from.
        moved: Greatest displacement so far (extents, radians), if step sizes go by it.
    """

    x: Float[Array, "n_t n_x"]
    xd: Float[Array, "n_t n_x"]
    near: Float[Array, "n_t n_e"]
    u: Float[Array, "n_t n_u"]
    steps: Int[Array, ""]
    result: Int[Array, ""]
    last: tuple[MotionState, Any]
    moved: Float[Array, ""]


class Start(NamedTuple):
    """Where a motion starts from.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        xd: Their velocities, (n_x,).
        near: Deformations, (n_e,), from which turns are counted on; None: from the undeformed mechanism.
    """

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    near: Any = None


def _solved(form: Any, settings: dict[str, Any], t0, t1, times, start, z0, regular):
    """States at times between t0 and t1, greatest displacement, number of steps, and code of the result."""
    import diffrax

    from .projected import Projected
    from .rosenbrock import Rodas5P, Rosenbrock
    from .step_control import DisplacementController
    from .term import MotionTerm

    rtol, atol = settings["rtol"], settings["atol"]
    controller, jumps = settings["controller"], settings["jumps"]
    solver = Rodas5P(jumps=jumps is not None) if settings["solver"] is None else settings["solver"]
    adjoint = diffrax.RecursiveCheckpointAdjoint() if settings["adjoint"] is None else settings["adjoint"]
    adapts = isinstance(solver.solver if isinstance(solver, Projected) else solver, diffrax.AbstractAdaptiveSolver)
    if controller is None and not adapts:
        controller = diffrax.ConstantStepSize()
    elif controller is None:
        controller = DisplacementController(
            rtol=rtol,
            atol=atol,
            pcoeff=0.1,
            icoeff=0.3,
            dtmin=SMALLEST_STEP * (t1 - t0),
            force_dtmin=False,
            moved=settings["moved"],
            states=form.states,
        )
    if isinstance(solver, Projected):
        solver = solver.with_tolerances(controller)
    failed = RESULTS.step_too_large if isinstance(controller, diffrax.ConstantStepSize) else RESULTS.step_too_small
    if jumps is not None and isinstance(controller, diffrax.AbstractAdaptiveStepSizeController):
        controller = diffrax.ClipStepSizeController(controller, jump_ts=jumps)
    # Nothing is integrated where some motion has no mass.
    t1, times = jnp.where(regular, t1, t0), jnp.where(regular, times, t0)
    # Over the first step acceleration moves the mechanism by some ten tolerances, unless a step is given.
    fast = jax.lax.stop_gradient(jnp.max(jnp.abs(z0[: form.size]), initial=1e-30))
    guess = jnp.fmin(jnp.sqrt(20 * (rtol + atol) / fast), (t1 - t0) / settings["first"])
    dt0 = jnp.where(settings["dt0"] > 0, settings["dt0"], guess)
    if isinstance(controller, diffrax.ConstantStepSize):
        # A whole number of steps is not to become one more by round-off.
        steps = jnp.round((t1 - t0) / dt0)
        dt0 = jnp.where(jnp.abs((t1 - t0) / dt0 - steps) < 1e-9 * steps, (t1 - t0) / steps, dt0)
    solution = diffrax.diffeqsolve(
        MotionTerm(form),
        solver,
        t0,
        t1,
        dt0,
        start,
        saveat=diffrax.SaveAt(ts=times, controller_state=True),
        stepsize_controller=controller,
        adjoint=adjoint,
        event=settings["event"],
        max_steps=settings["max_steps"],
        solver_state=z0 if isinstance(solver, Rosenbrock) else None,
        throw=False,
    )
    states: Any = solution.ys
    ok = diffrax.RESULTS
    result = jnp.where(solution.result == ok.successful, RESULTS.successful, failed)
    result = jnp.where(solution.result == ok.max_steps_reached, RESULTS.motion_unfinished, result)
    if settings["event"] is not None:
        result = jnp.where(solution.result == ok.event_occurred, RESULTS.successful, result)
    else:
        wrong = (result == RESULTS.successful) & ~jnp.all(jnp.isfinite(states.u))
        result = jnp.where(wrong, failed, result)
    result = jnp.where(regular, result, RESULTS.singular_mass).astype(jnp.int32)
    state: Any = solution.controller_state
    if isinstance(controller, diffrax.ClipStepSizeController):
        controller, state = controller.controller, state.inner_state
    moved = state[1] if isinstance(controller, DisplacementController) else settings["moved"]
    return states, moved, solution.stats["num_steps"], result


def _form(model: Model, driven, settings) -> Any:
    form: Any = coordinates_form(model.topology, model.parameters, driven)
    if settings["form"] == "reduced":
        form = reduced_form(form)
    feedback = settings["feedback"]
    if feedback is None or isinstance(feedback, Sampled):
        return form
    return controlled_form(model, form, feedback, settings["start"])


def _start(form: Any, driven, t, given: Start | MotionState) -> MotionState:
    if isinstance(given, MotionState):
        return given
    start = form.state_of(*given)
    if any(one.quantity in ("x", "e") for one in driven):
        # What is driven may have speed from the start, and take the rest along.
        start = form.settle(t, start)
    return start


@jit_beside_options
def begin(model: Model, driven, t, given: Start, settings: dict[str, Any]) -> tuple[MotionState, Any]:
    """State that a motion starts from, and what a sampled controller remembers then.

    Args:
        model: Mechanism.
        driven: What depends on time.
        t: Time [s].
        given: Where it starts from.
        settings: Of :func:`flexmb.simulate`.
    """
    feedback = settings["feedback"]
    memory = feedback.start if isinstance(feedback, Sampled) else None
    return _start(_form(model, driven, settings), driven, t, given), memory


@jit_beside_options
def integrate(
    model: Model, driven, span, times, given: tuple[Start | MotionState, Any], settings: dict[str, Any]
) -> Run:
    """Motion from one time to another.

    Args:
        model: Mechanism.
        driven: What depends on time.
        span: Start and end, (2,) [s].
        times: Times at which to give it, (n_t,) [s].
        given: Where it starts from.
        settings: Of :func:`flexmb.simulate`.
    """
    form = _form(model, driven, settings)
    start = _start(form, driven, span[0], given[0])
    z0, regular = form.begin(span[0], start)
    states, moved, steps, result = _solved(form, settings, span[0], span[1], times, start, z0, regular)

    def whole(at):
        # Between steps the state is interpolated, off the constraints.
        state = form.settle(*at)
        inputs = form.inputs(at[0], state) if settings["feedback"] is not None else jnp.zeros(0)
        return *form.whole_motion(at[0], state), inputs

    x, xd, near, u = jax.lax.map(whole, (times, states))
    return Run(x, xd, near, u, steps, result, (_last(states), None), moved)


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


@jit_beside_options
def integrate_sampled(
    model: Model, driven, grid: Intervals, times, given: tuple[Start | MotionState, Any], settings: dict[str, Any]
) -> Run:
    """Motion under a controller that acts at equal intervals, one after the other.

    Args:
        model: Mechanism.
        driven: What depends on time.
        grid: The intervals and the times in them.
        times: Times at which to give it, (n_t,) [s].
        given: Where it starts from.
        settings: Of :func:`flexmb.simulate`.
    """
    sampled: Sampled = settings["feedback"]
    undriven = _form(model, driven, settings)
    sensors = measuring(model, undriven, settings["start"])

    def interval(carry, at):
        state, memory, moved = carry
        begin, end, wanted = at
        u, memory = sampled.step(begin, memory, sensors.measured(begin, state))
        u = jnp.atleast_1d(jnp.asarray(u, float))
        form = under_inputs(model, undriven, u)
        z0, regular = form.begin(begin, state)
        before = settings | {"moved": moved}
        states, moved, steps, result = _solved(form, before, begin, end, wanted, state, z0, regular)
        return (_last(states), memory, moved), (states, u, steps, result)

    start = _start(undriven, driven, grid.begin[0], given[0]), given[1], settings["moved"]
    (state, memory, moved), (states, u, steps, result) = jax.lax.scan(interval, start, grid[:3])
    chosen = jax.tree.map(lambda rows: rows[grid.interval, grid.place], states)
    x, xd, near = jax.lax.map(lambda at: undriven.whole_motion(at[0], undriven.settle(*at)), (times, chosen))
    return Run(x, xd, near, u[grid.interval], jnp.sum(steps), jnp.max(result), (state, memory), moved)
