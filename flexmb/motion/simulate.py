"""Nonlinear motion in time, integrated by diffrax."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypedDict, TypeVar, Unpack

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from ..arguments import as_floats, checked_times, computed, is_concrete, shown, undifferentiated
from ..compilation.compile import jit_beside_options, unguarded
from ..compilation.program import captured
from ..errors import AnalysisError, ModelError, warn
from ..linear.loose import without_mass
from ..mechanics.signals import terms_of
from ..mechanics.sparse_order import SparseOrder
from ..model.model import Model, as_model
from ..results import RESULTS, check, collect, or_nan
from ..statics.coarse import warn_of_coarse
from ..statics.configuration import Configuration, configuration
from ..statics.equilibrium import Equilibrium, warn_of_increment
from ..statics.strained import warn_of_needless_strain, warn_of_stressed_start
from .balance import at_start
from .controlled_form import Feedback
from .controllers import Sampled
from .drive import Driven
from .drives_by_name import Drives, driven_by, jump_times
from .events import as_it_is, check_at_start, conditions_of
from .form_choice import check_form, chosen_form
from .full_turns import warn_of_full_turns
from .integrate import Integrated, Problem, Reached, begin, integrate, integrate_sampled, soon_after
from .integrator import Integrator
from .loop import Loop, as_feedback, with_functions
from .motion import Motion
from .parts import integrate_in_parts, sampled_intervals
from .protocol import MotionState
from .start import Start, begins_still, driving, warn_of_found
from .sudden import sudden_changes

if TYPE_CHECKING:
    import diffrax

# A motion that gains or loses more energy than so many times its relative tolerance, without a cause, is warned of.
UNBALANCED = 100.0
# Smaller shares of the greatest energy are round-off. Four bars that pass their singular position at rtol 1e-11 end at
# 1.2e-9 (tests/motion/test_simulate.py), since their constraint forces are large there.
ENERGY_ROUND_OFF = 1e-8
# Quantities that move the mechanism: their rates must be finite too.
MOVED = ("x", "e")
# Results of a motion whose controller may have returned NaN or infinity.
CONTROLLER_MAY_FAIL = (RESULTS.step_too_small, RESULTS.step_too_large)
# Where a motion failed, functions of time are looked at in so many times.
LOOKED_AT = 101
# After such a share of its time a condition that is zero where a motion starts has left zero, or it stays there.
SOON = 1e-3

Group = TypeVar("Group", Drives, Loop, Integrator)


class Keywords(TypedDict, total=False):
    """Attributes of :class:`Drives`, :class:`Loop` and :class:`Integrator`, as keywords of :func:`simulate`."""

    loads: Mapping[str, Callable] | None
    motion: Mapping[str, Callable] | None
    inputs: Mapping[str, Callable] | None
    increment: Callable | None
    jumps: ArrayLike | None
    control: Any
    reference: Callable | None
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

    What drives the mechanism, what controls it and how it is integrated are said by keywords, or by records of them
    that serve several simulations::

        fm.simulate(model, times, loads={"tip.x": jnp.sin}, rtol=1e-8)

        fine = fm.motion.Integrator(rtol=1e-8, max_steps=10_000)
        fm.simulate(model, times, loads={"tip.x": jnp.sin}, integrator=fine)

    Functions of time, controllers and events are taken as they are when this is called, with the numbers that they
    refer to, of which the motion may be differentiated. They are compiled into the simulation; functions that differ in
    numbers alone share compiled code.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        times: Times at which to give the motion, ascending, the first is the start, (n_t,) [s].
        initial: Where it starts from: an equilibrium (at rest), a configuration, or the end of another motion. None:
            the start values of the builder, otherwise the undeformed mechanism at rest. Where what is driven begins
            elsewhere or with speed, degrees of freedom and their rates are as said here, and the rest follows.
        drives: Loads, inputs and prescribed motion as functions of time: loads, motion, inputs,
            increment, jumps.
        loop: Controller around the mechanism: control, reference.
        integrator: Equations, solver, tolerances and steps: form, rtol, atol, solver, controller, dt0, adjoint, event,
            max_steps.
        progress: True for a bar, or a function called with the number of parts done and of all. The time is then cut
            into some fifty parts, and an interruption from the keyboard ends the simulation with the times reached so
            far and ``result`` stopped.
        throw: Raise where the simulation fails; otherwise the code is in ``result``.
        keywords: Attributes of :class:`Drives`, :class:`Loop` and :class:`Integrator`, where they are explained; they
            go before those of a record.

    Returns:
        Motion.

    Raises:
        ValueError, TypeError: times not ascending, a tolerance or step that is none, a solver of fixed steps without
            ``dt0``, or ``progress`` under a trace.
        ModelError: Unknown name, what cannot be driven, a function that gives another number of numbers than it drives,
            an input that can move nothing, a mechanism that is held everywhere.
        AnalysisError: singular_mass, step_too_small, step_too_large, motion_unfinished or ran_away; out_of_reach where
            the mechanism cannot be assembled at what is driven in the beginning; not_finite, with the name and the
            time, where a function of time or a controller gives a number that is not finite.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given; what is driven begins elsewhere or
            with speed, and degrees of freedom, which keep their values then, were found, not named; it starts stressed
            by strain or imperfection, unasked.
        CoarseWarning: A beam is bent or twisted further than one beam is right for, or stretched by more than 1 %.
        FlexmbWarning: A controller acts on a mechanism of 60 coordinates or more, which takes long.
        FlexmbWarning: The energy changes by more than loads, dampers, controllers and prescribed motions explain, by
            over 100 ``rtol``, and over 1e-8, of the greatest kinetic plus elastic energy (``Motion.energy_error``).

    Source:
        THEORY.md 5 and 9.
    """
    as_model(model, "simulate")
    drives, loop, integrator = _records(drives, loop, integrator, keywords)
    if not isinstance(progress, bool) and not callable(progress):
        raise TypeError(f"Argument `progress` must be True, False or a function, not {shown(progress)}.")
    given_times = checked_times(times)
    times = jnp.asarray(given_times, float)
    top = model.topology
    if top.x.fixed.shape[0] + top.x.prescribed.shape[0] == top.n_x:
        raise ModelError("Nothing moves by itself: every coordinate of the mechanism is FIXED or PRESCRIBED. Free one.")
    if drives.increment is None:
        warn_of_increment(model, "simulate")
    driven = driven_by(model, drives)
    jumps = jump_times(drives, driven)
    given_solver = integrator.solver
    check_form(integrator, loop.control is not None)
    integrator = integrator.checked(jumps=jumps is not None)
    start = _initial(model, initial)
    if progress and not is_concrete((model, times, start, drives.loads)):
        raise ValueError("Argument `progress` needs concrete numbers: leave it out inside jax.jit, jax.grad, jax.vmap.")
    feedback = as_feedback(model, loop)
    problem, integrator = _problem(model, driven, feedback, jumps, integrator, times, start)
    if initial is None and is_concrete(times):
        problem = dataclasses.replace(problem, still=_stands_still(model, driven, start, times))
    if is_concrete(times):
        problem = dataclasses.replace(problem, stops=_stops(drives, loop, driven, feedback, times))
    if integrator.event is not None:
        event = _event_now(problem, integrator, integrator.event, times, start)
        integrator = dataclasses.replace(integrator, event=event)
    run = _integrated(problem, integrator, given_times, start, progress)
    stopped = progress and int(run.result) == RESULTS.stopped
    (x, xd, near, u), result = run.rows, run.result
    if stopped:
        times = times[: len(x)]
    elif progress:
        # What a failure leaves out.
        left = ((0, len(times) - len(x)), (0, 0))
        x, xd, near, u = (jnp.pad(column, left, constant_values=jnp.inf) for column in run.rows)
    order = problem.order
    if isinstance(order, SparseOrder) and order.places.too_large and is_concrete(result):
        result = jnp.full_like(result, RESULTS.out_of_memory)
    name = type(given_solver).__name__ if given_solver is not None else "Rodas5P"
    found = Motion(
        times,
        x,
        xd,
        near,
        u,
        run.steps,
        result,
        driven,
        model,
        str(integrator.form),
        name,
        run.last.before.balance.share,
    )
    if model.labels.found and driving(model.parameters, driven) and is_concrete((found, start)):
        warn_of_found(found, start)
    if throw and is_concrete(found.result) and int(found.result) not in (RESULTS.successful, RESULTS.stopped):
        known, begun, asked = undifferentiated((found, start, problem))
        if is_concrete((known, asked, begun, integrator)):
            _refuse_not_finite(known, drives, loop)
            if int(found.result) in CONTROLLER_MAY_FAIL:
                _refuse_controller(asked, integrator, given_times, begun, known)
    _tell(found, run.jumped, throw and not stopped)
    _warn_of_energy(found, integrator)
    warn_of_coarse(model, found.e)
    if feedback is not None:
        warn_of_full_turns(found, start.x)
    rows, numbers = {"x": found.x, "xd": found.xd, "u": found.u}, (model.parameters, driven, times)
    return dataclasses.replace(found, **or_nan(rows, found.result, throw, numbers))


def _records(
    drives: Drives | None, loop: Loop | None, integrator: Integrator | None, keywords: Mapping[str, Any]
) -> tuple[Drives, Loop, Integrator]:
    """Records of arguments with the keywords that belong to them."""
    given: dict[str, Any] = {**keywords}
    found = (
        _group("drives", drives, Drives, given),
        _group("loop", loop, Loop, given),
        _group("integrator", integrator, Integrator, given),
    )
    if given:
        known = ", ".join(Keywords.__annotations__)
        raise TypeError(
            f"fm.simulate has no keyword `{next(iter(given))}`. Beside its own arguments there are: {known}."
        )
    return found


def _problem(
    model: Model,
    driven: tuple[Driven, ...],
    feedback: Feedback | Sampled | None,
    jumps: Any,
    integrator: Integrator,
    times: Float[Array, "n_t"],
    start: Start,
) -> tuple[Problem, Integrator]:
    """What is integrated, and the integrator with the form that is taken."""
    form, order, tree = chosen_form(integrator, model, driven, feedback is not None, jumps, (times, start))
    integrator = dataclasses.replace(integrator, form=form)
    # No number of the program where no rotation in space is measured.
    rotations = feedback is not None and any(s.axis is not None for s in terms_of(model.labels.outputs))
    whence = start.x if rotations else None
    return Problem(model.without_names(), driven, feedback, jumps, whence, order, tree), integrator


def _stands_still(model: Model, driven: tuple[Driven, ...], start: Start, times: Float[Array, "n_t"]) -> bool:
    """Whether nothing is to be done at the start: where the mechanism is, every law begins, and at rest."""
    return start.x is model.parameters.reference and begins_still(model.parameters, driven, np.asarray(times)[0])


def _stops(
    drives: Drives,
    loop: Loop,
    driven: tuple[Driven, ...],
    feedback: Feedback | Sampled | None,
    times: Float[Array, "n_t"],
) -> Any:
    """Times at which functions of time change suddenly, (k,) [s], or None."""
    of_time = [one.value for one in driven]
    if loop.reference is not None and not isinstance(feedback, Sampled):
        of_time.append(captured(loop.reference, as_floats(0.0)))
    return sudden_changes(of_time, np.asarray(times)[[0, -1]], named=drives.jumps is not None)


def _integrated(problem: Problem, integrator: Integrator, wanted: Any, start: Start, progress: Any) -> Integrated:
    """The motion: in parts where its progress is told, between the samples of a controller, or in one go."""
    times = jnp.asarray(wanted, float)
    feedback = problem.feedback
    none = np.zeros(len(problem.model.labels.inputs))
    at = Reached(start, (feedback.start, none) if isinstance(feedback, Sampled) else None, at_start())
    if isinstance(feedback, Sampled) and isinstance(wanted, jax.core.Tracer):
        raise TypeError("A sampled controller needs concrete times: give them outside jax.jit and jax.grad.")
    with _naming_the_adjoint():
        if progress:
            return integrate_in_parts(problem, integrator, times, at, progress)
        if isinstance(feedback, Sampled):
            grid = sampled_intervals(wanted, feedback.period, wanted[0], wanted[-1])
            return integrate_sampled(problem, integrator, grid, times, at)
        # Picked on the host where that is possible: by JAX it takes eight small programs of their own.
        span = np.asarray(times)[[0, -1]] if is_concrete(times) else times[jnp.array([0, -1])]
        return integrate(problem, integrator, span, times, at)


def _tell(found: Motion, jumped: Any, throw: bool) -> None:
    """Raise where a motion failed, and warn of forces that jump while numbers are differentiated."""
    about = ""
    if throw and is_concrete(found.result) and int(found.result) == RESULTS.singular_mass:
        about = without_mass(found.model)
    check(found.result, throw, about)
    if throw and not is_concrete(found.x):
        # Numbers are differentiated or traced.
        if not is_concrete(jumped):
            collect(jnp.where(jumped, RESULTS.forces_jump, RESULTS.successful))
        elif jumped:
            warn(RESULTS.forces_jump.message)


def _warn_of_energy(found: Motion, integrator: Integrator) -> None:
    """Warn where energy came or went that no force explains."""
    if not is_concrete((found.energy_error, found.result, integrator.rtol)):
        return
    share, rtol = float(found.energy_error), float(np.asarray(integrator.rtol))
    if int(found.result) == RESULTS.successful and share > max(UNBALANCED * rtol, ENERGY_ROUND_OFF):
        warn(
            f"The motion gains or loses {100 * share:.2g} % of its greatest energy, and no load, damper, controller or"
            f" prescribed motion does that work. Displacements are within `rtol` = {rtol:.2g} of each step. Give a"
            " smaller `rtol`; if the energy still differs, a law or a controller may jump or depend on its own history."
        )


@contextlib.contextmanager
def _naming_the_adjoint() -> Iterator[None]:
    """Name the remedy where a motion is differentiated forward by what takes its derivatives in reverse."""
    try:
        yield
    except TypeError as fault:
        if "forward-mode autodiff" not in str(fault):
            raise
        raise TypeError(
            "A motion is differentiated in reverse, by jax.grad and jax.jacrev. Forward derivatives, by jax.jacfwd and"
            " jax.jvp, ask for fm.simulate(.., adjoint=diffrax.ForwardMode())."
        ) from fault


def _reached(found: Motion) -> np.ndarray:
    """Last time that a motion reached, of those asked for, and the next one, (2,) [s]."""
    times = np.asarray(found.t)
    last = max(int(np.sum(np.all(np.isfinite(np.asarray(found.x)), axis=1))) - 1, 0)
    return times[[last, min(last + 1, len(times) - 1)]]


def _refuse_not_finite(found: Motion, drives: Drives, loop: Loop) -> None:
    """Refuse numbers of the model, and functions of time, that are not finite: a motion that failed met them."""
    model = found.model
    for path, leaf in jax.tree_util.tree_leaves_with_path(model.parameters):
        if not np.all(np.isfinite(np.asarray(leaf))):
            where = jax.tree_util.keystr(path)
            raise AnalysisError("not_finite", f"A number of the model is not finite: model.parameters{where}.")
    signals = [s.name for s in model.labels.inputs for _ in s.terms if s.name in (drives.inputs or {})]
    names = [f"Load '{name}'" for name in drives.loads or {}] + [f"Motion '{name}'" for name in drives.motion or {}]
    names += [f"Input '{name}'" for name in signals] + ["Argument `increment`"]
    laws = [(what, one.value, one.quantity in MOVED) for what, one in zip(names, found.driven, strict=False)]
    if loop.reference is not None:
        laws.append(("Argument `reference`", loop.reference, False))
    times, (last, following) = np.asarray(found.t), _reached(found)
    failed = np.linspace(last, following, LOOKED_AT)
    looked_at = np.unique(np.concatenate([times, np.linspace(times[0], times[-1], LOOKED_AT), failed]))
    for what, law, moves in laws:
        for t in looked_at:
            if not np.all(np.isfinite(np.asarray(law(jnp.asarray(t))))):
                raise AnalysisError(
                    "not_finite", f"{what} is not finite at t = {t:.6g} s: let it give finite numbers at all times."
                )
        # What moves by a law has its rates, too.
        for t in failed if moves else ():
            if not all(np.all(np.isfinite(np.asarray(rate))) for rate in _rates(law, t)):
                raise AnalysisError(
                    "not_finite",
                    f"{what} has a velocity or an acceleration that is not finite at t = {t:.6g} s: let it be smooth,"
                    " as by fm.trajectory.quintic.",
                )


def _rates(law: Callable, t: float) -> tuple[Any, Any]:
    """First and second derivative of a function of time."""

    def rate(t: Float[Array, ""]):
        return jax.jvp(law, (t,), (jnp.ones_like(t),))[1]

    return jax.jvp(rate, (jnp.asarray(t),), (jnp.ones(()),))


def _refuse_controller(problem: Problem, integrator: Integrator, wanted: Any, start: Start, found: Motion) -> None:
    """Refuse a controller that returned NaN or infinity: the motion that failed is computed once more."""
    feedback: Any = problem.feedback
    seen: list[tuple[Any, ...]] = []
    if feedback is None:
        return

    def note(t: np.ndarray, y: np.ndarray, given: tuple[Any, Any], failed: np.ndarray) -> None:
        if failed:
            seen.append((float(t), np.asarray(y), *map(np.asarray, given)))

    def watched(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"], u: Any, rate: Any):
        own, (u, rate) = _flat((t, z, y)), map(_flat, (u, rate))
        failed = jnp.all(jnp.isfinite(own)) & ~jnp.all(jnp.isfinite(jnp.append(u, rate)))
        jax.debug.callback(note, t, y, (u, rate), failed)

    def step(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        u, following = feedback.step(t, z, y)
        watched(t, z, y, u, following)
        return u, following

    def output(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        u = feedback.output(t, z, y)
        watched(t, z, y, u, () if feedback.rate is None else feedback.rate(t, z, y))
        return u

    watching = with_functions(feedback, len(found.model.labels.outputs), step=step, output=output)
    _integrated(dataclasses.replace(problem, feedback=watching), integrator, wanted, start, False)
    jax.effects_barrier()
    if not isinstance(feedback, Sampled):
        # A refused step, taken again with a smaller size, is no failure.
        seen = [one for one in seen if one[0] >= _reached(found)[0]]
    if not seen:
        return
    t, y, u, _ = min(seen, key=lambda one: one[0])
    inputs = [s.name for s in found.model.labels.inputs]
    wrong = [name for name, value in zip(inputs, u, strict=False) if not np.isfinite(value)]
    what = f"for the input '{wrong[0]}'" if wrong else "for its own state"
    outputs = ", ".join(f"{s.name} = {v:.6g}" for s, v in zip(found.model.labels.outputs, y, strict=False))
    raise AnalysisError(
        "not_finite",
        f"The controller gives a number that is not finite {what} at t = {t:.6g} s, where the outputs are {outputs}:"
        " let it give finite numbers for all outputs and times.",
    )


def _flat(given: Any) -> Float[Array, "k"]:
    """All numbers of a pytree in a row."""
    return jnp.concatenate([jnp.zeros(0), *(jnp.ravel(jnp.asarray(leaf, float)) for leaf in jax.tree.leaves(given))])


def _group(name: str, group: Group | None, kind: type[Group], keywords: dict[str, Any]) -> Group:
    """A record of arguments with the keywords that belong to it, which are taken out; None stands for not given."""
    if group is not None and not isinstance(group, kind):
        raise TypeError(f"Argument `{name}` must be fm.{kind.__name__}(..), not {shown(group)}.")
    own = {field.name: keywords.pop(field.name, None) for field in dataclasses.fields(kind)}
    own = {name: value for name, value in own.items() if value is not None}
    return dataclasses.replace(kind() if group is None else group, **own)


def _event_now(problem: Problem, integrator: Integrator, event: Any, times: Float[Array, "n_t"], start: Start):
    """An event of diffrax whose conditions will not change, checked at the start as far as numbers are known."""
    t, form = times[0], str(integrator.form)
    like = jax.eval_shape(lambda given: begin(problem, form, t, given), start)
    event = as_it_is(event, t, like)
    conditions = conditions_of(event)
    if conditions and is_concrete((problem, times, start, conditions)):
        values = later = _values(conditions, t, begin(problem, form, t, start))
        if any(value.dtype != bool and np.any(np.asarray(value) == 0) for value in values):
            wait = SOON * (times[-1] - t)
            later = _values(conditions, t + wait, soon_after(problem, form, t, start, wait))
        check_at_start(event, values, later, t)
    return event


@jit_beside_options
def _values(conditions: list[Any], t: Float[Array, ""], state: MotionState) -> list[Any]:
    """Values of conditions at a state."""
    return [jnp.asarray(of(t, state, None)) for of in conditions]


def _initial(model: Model, initial: Any):
    if initial is None:
        loads = model.parameters.loads
        if model.parameters.start is None:
            warn_of_stressed_start(
                model,
                "Begin from the shape without loads, initial=fm.equilibrium(model, load_factor=0.0), with"
                " increment=0.0 where there are incremental loads; or give initial=fm.configuration(model) where that"
                " start is meant.",
            )
        if model.parameters.start is None and _is_zero(loads.x) and _is_zero(loads.e) and loads.temperature is None:
            return Start(model.parameters.reference, as_floats(np.zeros(model.topology.n_x)))
        initial = configuration(model)
        if model.parameters.start is not None and is_concrete((model, initial)):
            remedy = (
                "Begin from an equilibrium, initial=fm.equilibrium(..) of the model with b.prescribe(..) in place of"
                " b.start(..), or give these start values too."
            )
            warn_of_needless_strain(model, np.asarray(initial.e), "At the start", remedy)
    if not isinstance(initial, Equilibrium | Configuration | Motion):
        raise TypeError(
            f"Argument `initial` must be an Equilibrium, a Configuration or a Motion, not {shown(initial)}."
        )
    if initial.labels.x != model.labels.x:
        raise ModelError("Argument `initial` is a state of another model: its nodes are not those of this one.")
    if isinstance(initial, Motion):
        if is_concrete(initial.x) and not np.all(np.isfinite(np.asarray(initial.x)[-1])):
            raise ModelError("Argument `initial` is a motion that did not reach its end: give motion.until(count).")
        return Start(initial.x[-1], initial.xd[-1], _counted(model, initial, initial.near[-1]))
    if is_concrete(initial.result):
        check(initial.result, True)
    rest = as_floats(np.zeros(model.topology.n_x))
    rates = initial.xd if isinstance(initial, Configuration) else rest
    return Start(initial.x, rates, _counted(model, initial, initial.e))


def _is_zero(given: Any) -> bool:
    """Whether what is prescribed is known to be where it is undeformed."""
    return given is None or (is_concrete(given) and not np.any(np.asarray(given)))


def _counted(model: Model, initial: Any, e: Float[Array, "n"]) -> Float[Array, "n_e"]:
    """Deformations from which turns are counted on, by their names; zero of elements that were not there."""
    known = {(one.of, one.component): i for i, one in enumerate(initial.labels.e)}
    places = [known.get((one.of, one.component), len(known)) for one in model.labels.e]
    if places == list(range(len(known))):
        return e
    return computed(lambda xp, e: xp.append(e, 0.0)[np.array(places, int)], e)
