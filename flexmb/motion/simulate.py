"""Nonlinear motion in time, integrated by diffrax."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import (
    as_floats,
    checked_times,
    computed,
    differs_beyond_round_off,
    is_concrete,
    short_repr,
    undifferentiated,
)
from ..compilation.compile import jit_beside_options, unguarded
from ..compilation.program import captured
from ..errors import AnalysisError, ModelError, warn
from ..linear.loose import without_mass
from ..mechanics.signals import terms_of
from ..model.model import Model, as_model
from ..numerical_limits import ENERGY_OF_MOTION, ENERGY_ROUND_OFF, SOON_AFTER_START
from ..results import RESULTS, check, collect, or_nan
from ..statics.coarse import warn_of_coarse, warn_of_needless_strain, warn_of_stressed_start
from ..statics.configuration import Configuration, start_of
from ..statics.equilibrium import Equilibrium
from .balance import at_start
from .controlled_form import Feedback
from .controllers import Sampled
from .drive import Driven
from .drives_by_name import Drives, driven_by, jump_times, warn_of_left_out
from .events import as_it_is, check_at_start, conditions_of
from .full_turns import warn_of_full_turns
from .integrate import (
    Integrated,
    Problem,
    Reached,
    begin,
    integrate,
    integrate_in_parts,
    integrate_sampled,
    sampled_intervals,
    soon_after,
)
from .integrator import Integrator, check_form, chosen_form
from .loop import Loop, as_feedback, with_functions, with_reference_as_function
from .motion import Motion
from .protocol import MotionState
from .start import Start, begins_still, driving, warn_of_start
from .sudden import sudden_changes

if TYPE_CHECKING:
    import diffrax

# Quantities that move the mechanism; their rates must be finite too.
MOVED = ("x", "e")
# Results of a motion whose controller may have returned NaN or infinity.
CONTROLLER_MAY_FAIL = (RESULTS.step_too_small, RESULTS.step_too_large)
# Number of times at which functions of time are checked after a failure.
LOOKED_AT = 101


class Keywords(TypedDict, total=False):
    """Attributes of :class:`Drives`, :class:`Loop` and :class:`Integrator`, as keywords of :func:`simulate`."""

    loads: Mapping[str, Callable] | None
    motion: Mapping[str, Callable] | None
    inputs: Mapping[str, Callable] | None
    increment: Callable | None
    jumps: ArrayLike | None
    control: Any
    reference: Callable | ArrayLike | None
    sign: Literal[1, -1] | None
    form: Literal["coordinates", "reduced", "chain", "tree"] | None
    rtol: float
    atol: float | None
    solver: diffrax.AbstractSolver | None
    controller: diffrax.AbstractStepSizeController | None
    dt0: float | None
    adjoint: diffrax.AbstractAdjoint | None
    event: diffrax.Event | None
    max_steps: int


@unguarded
def simulate(
    model: Model,
    times: ArrayLike,
    *,
    initial: Equilibrium | Configuration | Motion | None = None,
    drives: Drives | None = None,
    loop: Loop | None = None,
    integrator: Integrator | None = None,
    progress: Callable[[int, int], None] | bool = False,
    throw: bool = True,
    **keywords: Unpack[Keywords],
) -> Motion:
    """Integrate the nonlinear equations of motion.

    Give drives, controller and integration options as keywords, or as records that several simulations can share::

        fm.simulate(model, times, loads={"tip.x": jnp.sin}, rtol=1e-8)

        fine = fm.motion.Integrator(rtol=1e-8, max_steps=10_000)
        fm.simulate(model, times, loads={"tip.x": jnp.sin}, integrator=fine)

    flexmb captures functions of time, controllers and events at the call, with the numbers that they refer to. The
    motion is differentiable by these numbers. Functions that differ only in numbers share compiled code.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        times: Ascending times of the result, (n_t,) [s]; the first is the start.
        initial: Start: an equilibrium (at rest), a configuration, or the end of another motion. None: the start values
            of the builder, or the undeformed mechanism at rest. flexmb refuses a start of a mechanism with other
            undeformed positions, but does not see positions that ``jax.jit`` or ``jax.vmap`` traces. If driven
            coordinates start at other positions or with a velocity, the degrees of freedom and their rates keep their
            values of this start. The other coordinates follow.
        drives: Loads, inputs and prescribed motion as functions of time: loads, motion, inputs, increment, jumps.
        loop: Controller around the mechanism: control, reference, sign. Without a reference and a sign, a controller
            reads y: a linear system then is positive feedback, of which flexmb warns.
        integrator: Equations, solver, tolerances and steps: form, rtol, atol, solver, controller, dt0, adjoint, event,
            max_steps.
        progress: True for a progress bar, or a function of the number of parts done and of all parts. flexmb cuts the
            time into about fifty parts. A keyboard interruption ends the simulation. The motion then contains the times
            reached, and ``result`` is stopped.
        throw: Raise if the simulation fails; otherwise the code is in ``result``.
        keywords: Attributes of :class:`Drives`, :class:`Loop` and :class:`Integrator`; they override
            the attributes of a record.

    Returns:
        Motion.

    Raises:
        ValueError, TypeError: Times do not ascend, a tolerance or step is wrong, a solver with fixed steps has no
            ``dt0``, or ``progress`` is used under a trace.
        ModelError: A name is unknown, a quantity cannot be driven, a function returns the wrong number of numbers, an
            input moves nothing, or no coordinate is free.
        AnalysisError: singular_mass, step_too_small, step_too_large, motion_unfinished or ran_away; out_of_reach: the
            mechanism cannot be assembled at the first values that drive it; not_finite: a function of time or a
            controller returns a number that is not finite; the message contains its name and the time.

    Warns:
        FlexmbWarning: A linear system as controller has neither ``reference`` nor ``sign``.
        FlexmbWarning: There are incremental loads without ``increment`` that ``motion`` does not replace; the start
            depends on degrees of freedom that flexmb chose; a strain or an imperfection causes stress at the start; a
            controller acts on a mechanism of 60 coordinates or more, or goes on from a controlled motion with its
            states at zero.
        FlexmbWarning: The energy changes without work by loads, dampers, controllers or prescribed motions. The change
            divided by the greatest kinetic plus elastic energy (``Motion.energy_error``) exceeds 100 ``rtol`` and 1e-8.
        CoarseWarning: A beam is bent or twisted too far for the accuracy of one beam, or stretched by more than 1 %.

    Source:
        THEORY.md 5 and 9.
    """
    as_model(model, "simulate")
    drives, loop, integrator = _records(drives, loop, integrator, keywords)
    loop = with_reference_as_function(loop)
    if not isinstance(progress, bool) and not callable(progress):
        raise TypeError(f"Argument `progress` must be True, False or a function, not {short_repr(progress)}.")
    given_times = checked_times(times)
    times = jnp.asarray(given_times, float)
    top = model.topology
    if top.x.fixed.shape[0] + top.x.prescribed.shape[0] == top.n_x:
        raise ModelError("Nothing moves by itself: every coordinate of the mechanism is FIXED or PRESCRIBED. Free one.")
    driven = driven_by(model, drives)
    if drives.increment is None:
        warn_of_left_out(model, driven, "simulate")
    jumps = jump_times(drives, driven)
    given_solver = integrator.solver
    check_form(integrator, loop.control is not None)
    integrator = integrator.checked(jumps=jumps is not None)
    start = _initial(model, initial)
    if progress and not is_concrete((model, times, start, drives.loads)):
        raise ValueError("Argument `progress` needs concrete numbers. Leave it out inside jax.jit, jax.grad, jax.vmap.")
    feedback = as_feedback(model, loop)
    _warn_of_fresh_controller(initial, feedback)
    form, order, tree = chosen_form(integrator, model, driven, feedback is not None, jumps, (times, start))
    integrator = dataclasses.replace(integrator, form=form)
    # None without a measured rotation in space, so that the compiled program stays the same.
    rotations = feedback is not None and any(s.axis is not None for s in terms_of(model.labels.outputs))
    problem = Problem(model.without_names(), driven, feedback, jumps, start.x if rotations else None, order, tree)
    if is_concrete(times):
        still = initial is None and start.x is model.parameters.reference
        still = still and begins_still(model.parameters, driven, np.asarray(times)[0])
        stops = _stops(drives, loop, driven, feedback, times)
        problem = dataclasses.replace(problem, still=still, stops=stops)
    if integrator.event is not None:
        event = _event_now(problem, integrator, integrator.event, times, start)
        integrator = dataclasses.replace(integrator, event=event)
    run = _integrated(problem, integrator, given_times, start, progress)
    stopped = progress and int(run.result) == RESULTS.stopped
    motion = _motion_of(model, problem, integrator, given_solver, times, run)
    if model.labels.found and driving(model.parameters, driven) and is_concrete((motion, start)):
        warn_of_start(motion, start)
    if throw and is_concrete(motion.result) and int(motion.result) not in (RESULTS.successful, RESULTS.stopped):
        # A function of time or a controller may have made the integration fail.
        known, begun, known_problem = undifferentiated((motion, start, problem))
        if is_concrete((known, begun, known_problem, integrator)):
            _refuse_not_finite(known, drives, loop)
            if int(known.result) in CONTROLLER_MAY_FAIL:
                _refuse_controller(known_problem, integrator, given_times, begun, known)
    _check_motion(motion, run.jumped, throw and not stopped, loop)
    _warn_of_energy(motion, integrator)
    warn_of_coarse(model, motion.e)
    if feedback is not None:
        warn_of_full_turns(motion, start.x)
    rows, numbers = {"x": motion.x, "xd": motion.xd, "u": motion.u}, (model.parameters, driven, times)
    return dataclasses.replace(motion, **or_nan(rows, motion.result, throw, numbers))


def _motion_of(
    model: Model, problem: Problem, integrator: Integrator, solver: Any, times: Float[Array, "n_t"], run: Integrated
) -> Motion:
    """Motion at the times of the run that were reached; infinite afterwards."""
    (x, xd, last_strain, u), result = run.rows, run.result
    missing = len(times) - len(x)
    if missing and int(result) == RESULTS.stopped:
        times = times[: len(x)]
    elif missing:
        x, xd, last_strain, u = (
            jnp.pad(column, ((0, missing), (0, 0)), constant_values=jnp.inf) for column in run.rows
        )
    order = problem.order
    if order is not None and order.places.too_large and is_concrete(result):
        result = jnp.full_like(result, RESULTS.out_of_memory)
    rows, form = (times, x, xd, last_strain, u, run.steps, result), str(integrator.form)
    name = "Rodas5P" if solver is None else type(solver).__name__
    return Motion(*rows, problem.driven, model, form, name, run.last.before.balance.share)


def _records(
    drives: Drives | None, loop: Loop | None, integrator: Integrator | None, keywords: Mapping[str, Any]
) -> tuple[Drives, Loop, Integrator]:
    """Records of arguments with the keywords that belong to them; None means not given."""
    remaining: dict[str, Any] = {**keywords}
    records: list[Any] = []
    for name, group, kind in (("drives", drives, Drives), ("loop", loop, Loop), ("integrator", integrator, Integrator)):
        if group is not None and not isinstance(group, kind):
            raise TypeError(f"Argument `{name}` must be fm.{kind.__name__}(..), not {short_repr(group)}.")
        options = {field.name: remaining.pop(field.name, None) for field in dataclasses.fields(kind)}
        options = {name: value for name, value in options.items() if value is not None}
        records.append(dataclasses.replace(kind() if group is None else group, **options))
    if remaining:
        known = ", ".join(Keywords.__annotations__)
        raise TypeError(f"fm.simulate has no keyword `{next(iter(remaining))}`. Further keywords are: {known}.")
    return records[0], records[1], records[2]


def _stops(
    drives: Drives,
    loop: Loop,
    driven: tuple[Driven, ...],
    feedback: Feedback | Sampled | None,
    times: Float[Array, "n_t"],
) -> Any:
    """Times at which functions of time change suddenly."""
    of_time = [drive.value for drive in driven]
    if loop.reference is not None and not isinstance(feedback, Sampled):
        reference: Any = loop.reference
        of_time.append(captured(reference, as_floats(0.0)))
    return sudden_changes(of_time, np.asarray(times)[[0, -1]], named=drives.jumps is not None)


def _integrated(
    problem: Problem, integrator: Integrator, requested_times: Any, start: Start, progress: Any
) -> Integrated:
    """The motion: in parts to show progress, between samples of a controller, or at once."""
    times = jnp.asarray(requested_times, float)
    feedback = problem.feedback
    none = np.zeros(len(problem.model.labels.inputs))
    at = Reached(start, (feedback.start, none) if isinstance(feedback, Sampled) else None, at_start())
    if isinstance(feedback, Sampled) and isinstance(requested_times, jax.core.Tracer):
        raise TypeError("A sampled controller needs concrete times. Give them outside jax.jit and jax.grad.")
    with _naming_the_adjoint():
        if progress:
            return integrate_in_parts(problem, integrator, times, at, progress)
        if isinstance(feedback, Sampled):
            grid = sampled_intervals(requested_times, feedback.period, requested_times[0], requested_times[-1])
            return integrate_sampled(problem, integrator, grid, times, at)
        # Selected on the host: JAX would compile eight small programs.
        span = np.asarray(times)[[0, -1]] if is_concrete(times) else times[jnp.array([0, -1])]
        return integrate(problem, integrator, span, times, at)


def _check_motion(motion: Motion, jumped: Any, throw: bool, loop: Loop) -> None:
    """Raise for a failed motion, and warn of forces that jump under differentiation."""
    about = ""
    if throw and is_concrete(motion.result) and int(motion.result) == RESULTS.singular_mass:
        about = without_mass(motion.model)
    if throw and loop.control is not None and is_concrete(motion.result) and int(motion.result) == RESULTS.ran_away:
        reads = "reference - y" if loop.reference is not None else "-y" if loop.sign == -1 else "y"
        about = f"This controller reads {reads}: its loop is closed_loop(model, controller, sign={loop.sign or 1})."
    check(motion.result, throw, about)
    if throw and not is_concrete(motion.x):
        # Numbers are differentiated or traced.
        if not is_concrete(jumped):
            collect(jnp.where(jumped, RESULTS.forces_jump, RESULTS.successful))
        elif jumped:
            warn(RESULTS.forces_jump.message)


def _warn_of_energy(motion: Motion, integrator: Integrator) -> None:
    """Warn of energy that no force explains."""
    if not is_concrete((motion.energy_error, motion.result, integrator.rtol)):
        return
    share, rtol = float(motion.energy_error), float(np.asarray(integrator.rtol))
    if int(motion.result) == RESULTS.successful and share > max(ENERGY_OF_MOTION * rtol, ENERGY_ROUND_OFF):
        warn(
            f"The motion gains or loses {100 * share:.2g} % of its greatest energy without work by a load, damper,"
            f" controller or prescribed motion. Displacements are within `rtol` = {rtol:.2g} in each step. Give a"
            " smaller `rtol`. If the energy still differs, a law or a controller may jump or depend on its own history."
        )


@contextlib.contextmanager
def _naming_the_adjoint() -> Iterator[None]:
    """Name the remedy if a motion that is differentiated in reverse is differentiated forward."""
    try:
        yield
    except TypeError as fault:
        if "forward-mode autodiff" not in str(fault):
            raise
        raise TypeError(
            "A motion is differentiated in reverse, by jax.grad and jax.jacrev. For forward derivatives, by jax.jacfwd"
            " and jax.jvp, use fm.simulate(.., adjoint=diffrax.ForwardMode())."
        ) from fault


def _reached(motion: Motion) -> np.ndarray:
    """Last time that a motion reached, and the next time [s]."""
    times = np.asarray(motion.t)
    last = max(int(np.sum(np.all(np.isfinite(np.asarray(motion.x)), axis=1))) - 1, 0)
    return times[[last, min(last + 1, len(times) - 1)]]


def _refuse_not_finite(motion: Motion, drives: Drives, loop: Loop) -> None:
    """Refuse numbers of the model and functions of time that are not finite, after a failed motion."""
    model = motion.model
    for path, leaf in jax.tree_util.tree_leaves_with_path(model.parameters):
        if not np.all(np.isfinite(np.asarray(leaf))):
            where = jax.tree_util.keystr(path)
            raise AnalysisError("not_finite", f"A number of the model is not finite: model.parameters{where}.")
    signals = [s.name for s in model.labels.inputs for _ in s.terms if s.name in (drives.inputs or {})]
    names = [f"Load '{name}'" for name in drives.loads or {}] + [f"Motion '{name}'" for name in drives.motion or {}]
    names += [f"Input '{name}'" for name in signals] + ["Argument `increment`"]
    laws: list[tuple[str, Any, bool]] = [
        (subject, drive.value, drive.quantity in MOVED) for subject, drive in zip(names, motion.driven, strict=False)
    ]
    if loop.reference is not None:
        laws.append(("Argument `reference`", loop.reference, False))
    times, (last, following) = np.asarray(motion.t), _reached(motion)
    failed = np.linspace(last, following, LOOKED_AT)
    looked_at = np.unique(np.concatenate([times, np.linspace(times[0], times[-1], LOOKED_AT), failed]))
    for subject, law, moves in laws:
        for t in looked_at:
            if not np.all(np.isfinite(np.asarray(law(jnp.asarray(t))))):
                raise AnalysisError(
                    "not_finite", f"{subject} is not finite at t = {t:.6g} s. It must be finite at all times."
                )
        # The rates of a prescribed motion must be finite too.
        for t in failed if moves else ():
            if not all(np.all(np.isfinite(np.asarray(rate))) for rate in _rates(law, t)):
                raise AnalysisError(
                    "not_finite",
                    f"{subject} has a velocity or an acceleration that is not finite at t = {t:.6g} s. Use a smooth"
                    " function, such as fm.trajectory.quintic.",
                )


def _rates(law: Callable, t: float) -> tuple[Any, Any]:
    """First and second derivative of a function of time."""

    def rate(t: Float[Array, ""]):
        return jax.jvp(law, (t,), (jnp.ones_like(t),))[1]

    return jax.jvp(rate, (jnp.asarray(t),), (jnp.ones(()),))


def _refuse_controller(
    problem: Problem, integrator: Integrator, requested_times: Any, start: Start, motion: Motion
) -> None:
    """Refuse a controller that returned NaN or infinity, by computing the failed motion again."""
    feedback: Any = problem.feedback
    seen: list[tuple[Any, ...]] = []
    if feedback is None:
        return

    def note(t: np.ndarray, y: np.ndarray, results: tuple[Any, Any], failed: np.ndarray) -> None:
        if failed:
            seen.append((float(t), np.asarray(y), *map(np.asarray, results)))

    def watched(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"], u: Any, rate: Any):
        arguments, (u, rate) = _flat((t, z, y)), map(_flat, (u, rate))
        failed = jnp.all(jnp.isfinite(arguments)) & ~jnp.all(jnp.isfinite(jnp.append(u, rate)))
        jax.debug.callback(note, t, y, (u, rate), failed)

    def step(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        u, following = feedback.step(t, z, y)
        watched(t, z, y, u, following)
        return u, following

    def output(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        u = feedback.output(t, z, y)
        watched(t, z, y, u, () if feedback.rate is None else feedback.rate(t, z, y))
        return u

    watching = with_functions(feedback, len(motion.model.labels.outputs), step=step, output=output)
    _integrated(dataclasses.replace(problem, feedback=watching), integrator, requested_times, start, False)
    jax.effects_barrier()
    if not isinstance(feedback, Sampled):
        # A refused step that is repeated with a smaller size is no failure.
        seen = [call for call in seen if call[0] >= _reached(motion)[0]]
    if not seen:
        return
    t, y, u, _ = min(seen, key=lambda call: call[0])
    inputs = [s.name for s in motion.model.labels.inputs]
    wrong = [name for name, value in zip(inputs, u, strict=False) if not np.isfinite(value)]
    where = f"for the input '{wrong[0]}'" if wrong else "for its own state"
    outputs = ", ".join(f"{s.name} = {v:.6g}" for s, v in zip(motion.model.labels.outputs, y, strict=False))
    raise AnalysisError(
        "not_finite",
        f"The controller returns a number that is not finite {where} at t = {t:.6g} s. The outputs there are {outputs}."
        " A controller must return finite numbers for all outputs and times.",
    )


def _flat(tree: Any) -> Float[Array, "k"]:
    """All numbers of a pytree in a row."""
    return jnp.concatenate([jnp.zeros(0), *(jnp.ravel(jnp.asarray(leaf, float)) for leaf in jax.tree.leaves(tree))])


def _event_now(problem: Problem, integrator: Integrator, event: Any, times: Float[Array, "n_t"], start: Start):
    """Event with captured conditions, checked at the start if numbers are known."""
    t, form = times[0], str(integrator.form)
    like = jax.eval_shape(lambda initial: begin(problem, form, t, initial), start)
    event = as_it_is(event, t, like)
    conditions = conditions_of(event)
    if conditions and is_concrete((problem, times, start, conditions)):
        values = later = _values(conditions, t, begin(problem, form, t, start))
        if any(value.dtype != bool and np.any(np.asarray(value) == 0) for value in values):
            wait = SOON_AFTER_START * (times[-1] - t)
            later = _values(conditions, t + wait, soon_after(problem, form, t, start, wait))
        check_at_start(event, values, later, t)
    return event


@jit_beside_options
def _values(conditions: list[Any], t: Float[Array, ""], state: MotionState) -> list[Any]:
    """Values of conditions at a state."""
    return [jnp.asarray(condition(t, state, None)) for condition in conditions]


def _initial(model: Model, initial: Any):
    if initial is None:
        loads = model.parameters.loads
        if model.parameters.start is None:
            warn_of_stressed_start(
                model,
                "Begin from the shape without loads, initial=fm.equilibrium(model, load_factor=0.0), with"
                " increment=0.0 if there are incremental loads. Give initial=fm.configuration(model) if this"
                " start is intended.",
            )
        if model.parameters.start is None and _is_zero(loads.x) and _is_zero(loads.e) and loads.temperature is None:
            return Start(model.parameters.reference, as_floats(np.zeros(model.topology.n_x)))
        initial = start_of(model)
        if model.parameters.start is not None and is_concrete((model, initial)):
            remedy = (
                "Begin from an equilibrium: initial=fm.equilibrium(..) of the model with b.prescribe(..) in place of"
                " b.start(..). Or give these start values too."
            )
            warn_of_needless_strain(model, np.asarray(initial.e), "At the start", remedy)
    if not isinstance(initial, Equilibrium | Configuration | Motion):
        raise TypeError(
            f"Argument `initial` must be an Equilibrium, a Configuration or a Motion, not {short_repr(initial)}."
        )
    if initial.labels.x != model.labels.x:
        raise ModelError(
            "Argument `initial` is a state of another model: its nodes differ from the nodes of this model."
        )
    of_state = getattr(initial, "model", None) or getattr(initial, "asked_of", None)
    _check_same_undeformed(model, of_state)
    if isinstance(initial, Motion):
        if is_concrete(initial.x) and not np.all(np.isfinite(np.asarray(initial.x)[-1])):
            raise ModelError("Argument `initial` is a motion that did not reach its end. Give motion.until(count).")
        return Start(initial.x[-1], initial.xd[-1], _counted(model, initial, initial.near[-1]))
    if is_concrete(initial.result):
        check(initial.result, True)
    zero_rates = as_floats(np.zeros(model.topology.n_x))
    rates = initial.xd if isinstance(initial, Configuration) else zero_rates
    return Start(initial.x, rates, _counted(model, initial, initial.e))


def _warn_of_fresh_controller(initial: Any, feedback: Feedback | Sampled | None) -> None:
    """Warn of a controlled motion that goes on with the states of its controller at zero."""
    if feedback is None or not isinstance(initial, Motion) or not initial.u.shape[1]:
        return
    states = jax.tree.leaves(feedback.start)
    if sum(np.size(state) for state in states) and is_concrete(states) and not any(map(np.any, states)):
        warn(
            "The motion goes on from a controlled motion, but the states of the controller, such as its integrals,"
            " begin at zero: a Motion does not store them. Simulate the whole time in one call, or give the controller"
            " its states as `start`."
        )


def _check_same_undeformed(model: Model, of_state: Model | None) -> None:
    """Raise ModelError for a start of a mechanism with other undeformed positions or rotations, as far as known.

    Sections, loads and elements may change at a start, as when a latch opens.
    """
    if of_state is None:
        return
    if np.any(differs := differs_beyond_round_off(of_state.parameters.reference, model.parameters.reference)):
        raise ModelError(
            "Argument `initial` is a state of a mechanism with other undeformed positions: it differs in"
            f" {model.labels.x[int(np.argmax(differs))]}. Give a state of this model."
        )


def _is_zero(value: Any) -> bool:
    """Whether prescribed values are known to be zero."""
    return value is None or (is_concrete(value) and not np.any(np.asarray(value)))


def _counted(model: Model, initial: Any, e: Float[Array, "n"]) -> Float[Array, "n_e"]:
    """Deformations from which turns are counted, by name; zero for elements that the start lacks."""
    known = {(entry.of, entry.component): i for i, entry in enumerate(initial.labels.e)}
    places = [known.get((entry.of, entry.component), len(known)) for entry in model.labels.e]
    if places == list(range(len(known))):
        return e
    return computed(lambda xp, e: xp.append(e, 0.0)[np.array(places, int)], e)
