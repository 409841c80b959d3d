"""Nonlinear motion in time, integrated by diffrax."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float, Int

from ..arguments import check_choice, check_number, check_numbers, check_whole, is_concrete, shown
from ..compilation.compile import jit_beside_options
from ..compilation.program import Captured, captured
from ..compilation.record import Record, static
from ..display import Result, States, Summary, course, short
from ..errors import ModelError
from ..linear.loose import without_mass
from ..math.indices import put
from ..mechanics.inertia import mass_matrix, work_of_weight
from ..mechanics.stress_resultants import is_nonlinear, nonlinear_energy, strain_of
from ..model.model import Labels, Model, as_model
from ..results import RESULTS, check
from ..statics.configuration import Configuration, configuration
from ..statics.equilibrium import Equilibrium, warn_of_increment
from .coordinates_form import coordinates_form
from .drive import Driven, Table
from .integrate import Start, begin, integrate, integrate_sampled
from .loop import Sampled, as_feedback, under_inputs
from .parts import integrate_in_parts, sampled_intervals

if TYPE_CHECKING:
    import diffrax

# Absolute tolerance of a position, as share of the mechanism's extent, and of a rotation: above round-off.
ABSOLUTE = 1e-13


class Motion(Result, Record):
    """Motion of a mechanism at the times asked for.

    Attributes:
        t: Times, (n_t,) [s].
        x: Nodal coordinates, (n_t, n_x) [m, rad, -].
        xd: Their velocities, (n_t, n_x) [1/s].
        near: Deformations, (n_t, n_e) [m, rad]; angles are counted past full turns.
        u: Inputs that a controller gave, (n_t, n_u), (n_t, 0) without one [N, N m].
        steps: Number of time steps taken, refused ones included.
        result: Code of RESULTS.
        driven: What depended on time.
        model: Mechanism.
        form: Form of the equations that was integrated.
        solver: Name of the solver.
    """

    t: Float[Array, "n_t"]
    x: Float[Array, "n_t n_x"]
    xd: Float[Array, "n_t n_x"]
    near: Float[Array, "n_t n_e"]
    u: Float[Array, "n_t n_u"]
    steps: Int[Array, ""]
    result: Int[Array, ""]
    driven: tuple[Driven, ...]
    model: Model
    form: str = static()
    solver: str = static()
    one_axis = "t"

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    def at(self, node: str) -> Float[Array, "n_t n"]:
        """Coordinates of a node, or of its rotation as "name.rotation", at every time.

        Args:
            node: Name of the node.

        Raises:
            KeyError: No such node.
        """
        return self.x[:, self.labels.known(node)]

    def velocity(self, node: str) -> Float[Array, "n_t n"]:
        """Velocities of a node's coordinates at every time.

        Args:
            node: Name of the node.

        Raises:
            KeyError: No such node.
        """
        return self.xd[:, self.labels.known(node)]

    def until(self, count: int) -> Motion:
        """The first of the times only.

        Args:
            count: How many, from 0 to all.

        Raises:
            ValueError: There are not so many.
        """
        if not 0 <= check_whole("count", count) <= self.t.shape[0]:
            raise ValueError(f"Argument `count` must be 0 to {self.t.shape[0]}, the number of times, but is {count}.")
        parts = {name: getattr(self, name)[:count] for name in ("t", "x", "xd", "near", "u")}
        return dataclasses.replace(self, **parts)

    def observe(self) -> Observed:
        """Everything else about the motion: accelerations, deformations, stresses, reactions, energies, power.

        Returns:
            Observed.
        """
        model = self.model
        return _observe(model.without_names(), self.driven, self.t, self.x, self.xd, self.near, self.u)

    def states(self) -> States:
        """The states, over time."""
        return States(self.model, self.x, "motion", self.t, "time [s]")

    def summary(self) -> Summary:
        """Outcome, times and how they were computed."""
        t = np.asarray(self.t)
        rows = {
            "result": RESULTS(int(self.result)).name,
            "time": f"{short(t[0])} to {short(t[-1])} s, {len(t)} times" if len(t) else "none",
            "steps": str(int(self.steps)),
            "solver": f"{self.solver}, {self.form}",
        }
        return Summary(f"Motion: {course(self.states())}", rows, "history")


class Observed(Result, Record):
    """Quantities that follow from positions and velocities, at every time.

    Attributes:
        xdd: Accelerations, (n_t, n_x) [1/s^2].
        e: Deformations, (n_t, n_e) [m, rad].
        ed: Their rates, (n_t, n_e) [m/s, rad/s].
        sigma: Stress resultants, multipliers included, (n_t, n_e) [N, N m].
        reactions: Forces of the supports on the mechanism, (n_t, n_x) [N, N m].
        kinetic: Kinetic energy, (n_t,) [J].
        elastic: Elastic energy, (n_t,) [J].
        potential: Energy of constant forces and gravity, zero in the undeformed mechanism, (n_t,) [J].
        power: Power of all other loads and of prescribed motion, less what dampers and laws take, (n_t,) [W].
    """

    xdd: Float[Array, "n_t n_x"]
    e: Float[Array, "n_t n_e"]
    ed: Float[Array, "n_t n_e"]
    sigma: Float[Array, "n_t n_e"]
    reactions: Float[Array, "n_t n_x"]
    kinetic: Float[Array, "n_t"]
    elastic: Float[Array, "n_t"]
    potential: Float[Array, "n_t"]
    power: Float[Array, "n_t"]

    @property
    def energy(self) -> Float[Array, "n_t"]:
        """Whole energy, (n_t,) [J]; its rate is ``power``."""
        return self.kinetic + self.elastic + self.potential


@jit_beside_options
def _observe(model, driven, t, x, xd, near, u):
    topology, parameters = model.topology, model.parameters
    undriven: Any = coordinates_form(topology, parameters, driven)
    gravity = parameters.loads.gravity

    def one(at):
        t, x, xd, near, u = at
        form = under_inputs(model, undriven, u)
        state = form.state_of(x, xd, near)
        z = form.acceleration(t, state)
        kin, sigma, force, whole = form.forces(t, state, z)
        mass = mass_matrix(topology, parameters, whole.x)
        drive = form.drive(t)
        moving = whole.x - parameters.reference
        constant = parameters.loads.force
        potential = jnp.array(0.0) if constant is None else -constant @ moving
        if gravity is not None:
            potential = potential - work_of_weight(topology, parameters, whole.x, gravity)
        stored = strain_of(parameters, kin.e)
        # Stress that comes of stored energy, and that energy.
        conservative, elastic = form.S @ stored, 0.5 * stored @ form.S @ stored
        if is_nonlinear(topology):
            energy, stress = jax.value_and_grad(lambda e: nonlinear_energy(topology, parameters, e))(stored)
            conservative, elastic = conservative + stress, elastic + energy
        if drive.loads.prestress is not None:
            conservative, elastic = conservative + drive.loads.prestress, elastic + drive.loads.prestress @ stored
        # All forces but inertia, springs, constant forces and gravity.
        other = form.applied(t, whole.x) - (0.0 if constant is None else constant)
        held = put(put(jnp.zeros(topology.n_x), topology.x.fixed, 1.0), topology.x.prescribed, 1.0)
        reactions = jnp.where(held == 1.0, force, 0.0)
        power = (other + reactions) @ whole.v - (sigma - conservative) @ kin.ed
        kinetic = 0.5 * whole.v @ mass @ whole.v
        return Observed(whole.a, kin.e, kin.ed, sigma, reactions, kinetic, elastic, potential, power)

    return jax.lax.map(one, (t, x, xd, near, u))


def simulate(
    model: Model,
    times: ArrayLike,
    *,
    initial: Equilibrium | Configuration | Motion | None = None,
    loads: Mapping[str, Callable] | None = None,
    motion: Mapping[str, Callable] | None = None,
    increment: Callable | None = None,
    control: Any = None,
    reference: Callable | None = None,
    jumps: Float[Array, "k"] | None = None,
    form: Literal["coordinates", "reduced"] = "coordinates",
    rtol: float = 1e-5,
    atol: float | None = None,
    solver: diffrax.AbstractSolver | None = None,
    controller: diffrax.AbstractStepSizeController | None = None,
    dt0: float | None = None,
    adjoint: diffrax.AbstractAdjoint | None = None,
    event: diffrax.Event | None = None,
    max_steps: int = 200_000,
    progress: Callable[[int, int], None] | bool = False,
    throw: bool = True,
) -> Motion:
    """Integrate the nonlinear equations of motion.

    Functions of time, controllers and events are taken as they are when this is called, with the numbers that they
    refer to, of which the motion may be differentiated. They are compiled into the simulation; functions that differ in
    numbers alone share compiled code.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        times: Times at which to give the motion, ascending, the first is the start, (n_t,) [s].
        initial: Where it starts from: an equilibrium (at rest), a configuration, or the end of another motion. None:
            the start values of the builder, otherwise the undeformed mechanism at rest.
        loads: Loads as functions of time, by name: a coordinate "tip.x" or a deformation "leaf.e2" (a stress that is
            added) with a number, a node "tip" with its force components [N], a rotation in space "tip.rotation" with
            the moment about global axes [N m]. A :class:`Table` is a piecewise linear function.
        motion: Values of PRESCRIBED coordinates (from their start), rotations and deformations as functions of time, by
            name such as "tip.x", "tip.rotation" or "leaf.e1", twice differentiable.
        increment: Factor of the incremental loads as function of time; zero unless given.
        control: Controller from the model's outputs y to its inputs u: a ``control.StateSpace``, continuous or sampled
            (with dt, its output held from sample to sample), a function ``u = control(t, y)``, a :class:`Feedback`, or
            a :class:`Sampled`.
        reference: Wanted outputs as function of time; the controller then sees reference - y. Without it, y.
        jumps: Times at which loads jump or bend, to be stepped onto, (k,) [s]; those of tables are known.
        form: "coordinates": all nodal coordinates, with a multiplier for each constraint, brought back onto the
            constraints after every step; no choice of degrees of freedom can fail on the way. "reduced": the degrees of
            freedom, from which the rest follows in every evaluation; fewer unknowns, but it fails at a dead point.
        rtol: Largest error of a displacement in one step, over the greatest displacement so far, or over half the
            mechanism's extent (half a radian) where that is less. What comes together over a motion is of the same size
            where it is damped or short, and more where it is neither (``benchmarks/stability.py``). Small deformations
            beside a large motion want a smaller one.
        atol: Part of that error which is allowed of a mechanism that has not moved, as share of its extent, and in
            radians; 1e-13 unless given.
        solver: Solver of diffrax, or one of ours: ``Rodas5P()``, for stiff motion, unless given; of fixed steps
            ``GeneralizedAlpha()`` and ``EnergyKeeping()``.
        controller: Step size controller of diffrax, in place of the one of rtol and atol, or of fixed steps.
        dt0: First step, or the step of a solver of fixed steps [s].
        adjoint: How diffrax differentiates; reverse mode unless given, ``diffrax.ForwardMode()`` for forward mode.
        event: Event of diffrax that ends the motion; later times are then given as not finite.
        max_steps: Most steps to take, with ``progress`` in each part.
        progress: True for a bar, or a function called with the number of parts done and of all. The time is then cut
            into some fifty parts, and an interruption from the keyboard ends the simulation with the times reached so
            far and ``result`` stopped.
        throw: Raise where the simulation fails; otherwise the code is in ``result``.

    Returns:
        Motion.

    Raises:
        ValueError, TypeError: times not ascending, a tolerance or step that is none, a solver of fixed steps without
            ``dt0``, or ``progress`` under a trace.
        ModelError: Unknown name, what cannot be driven, a function that gives another number of numbers than it drives,
            an input that can move nothing.
        AnalysisError: singular_mass, step_too_small, step_too_large or motion_unfinished.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given.

    Source:
        FORMULATION.md 5 and 9.
    """
    as_model(model, "simulate")
    check_choice("form", form, ("coordinates", "reduced"))
    if control is not None and form == "reduced":
        raise ValueError('A controller needs form="coordinates".')
    if reference is not None and control is None:
        raise ValueError("Argument `reference` is what a controller follows: give `control` too.")
    for name, number, bound in (("rtol", rtol, {"above": 0}), ("atol", atol, {"least": 0}), ("dt0", dt0, {"above": 0})):
        if number is not None:
            check_number(name, number, **bound)
    max_steps = check_whole("max_steps", max_steps, 1)
    if not isinstance(progress, bool) and not callable(progress):
        raise TypeError(f"Argument `progress` must be True, False or a function, not {shown(progress)}.")
    times = _checked_times(times)
    if increment is None:
        warn_of_increment(model, "simulate")
    loads, motion = {} if loads is None else loads, {} if motion is None else motion
    driven = driven_by(model, loads, motion, increment)
    kinks = [jnp.asarray(one.value.times, float) for one in driven if isinstance(one.value, Table)]
    if jumps is not None:
        check_numbers("Argument `jumps`", jumps)
        if np.ndim(jumps) != 1:
            raise ValueError(f"Argument `jumps` must be a list of times, not {shown(jumps)}.")
        kinks.append(jnp.asarray(jumps, float))
    start = _initial(model, initial)
    if progress and any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves((model, times, start, loads))):
        raise ValueError("Argument `progress` needs concrete numbers: leave it out inside jax.jit, jax.grad, jax.vmap.")
    name = "Rodas5P" if solver is None else type(solver).__name__
    _check_kinds(solver=solver, controller=controller, adjoint=adjoint, event=event)
    if solver is not None:
        solver = _checked_solver(solver, controller, form == "coordinates" and control is None, dt0, bool(kinks))
    settings = {
        "form": form,
        "feedback": None if control is None else as_feedback(model, control, reference),
        "rtol": jnp.asarray(rtol, float),
        "atol": jnp.asarray(ABSOLUTE if atol is None else atol, float),
        "moved": jnp.array(0.0),
        "controller": controller,
        "jumps": jnp.sort(jnp.concatenate(kinks)) if kinks else None,
        "solver": solver,
        "dt0": jnp.asarray(0.0 if dt0 is None else dt0, float),
        "adjoint": adjoint,
        "event": None,
        "max_steps": max_steps,
        "first": 50.0,
        # Where rotations in space are measured from; no number of the program where none is.
        "start": start.x if control is not None and any(s.axis is not None for s in model.labels.outputs) else None,
    }
    feedback = settings["feedback"]
    if event is not None:
        settings |= {"event": _event_now(event, model, driven, times[0], start, settings)}
    if isinstance(feedback, Sampled):
        settings |= {"first": 4.0}
    nameless = model.without_names()
    if progress:
        run = integrate_in_parts(nameless, driven, times, start, settings, progress)
    elif isinstance(feedback, Sampled):
        if isinstance(times, jax.core.Tracer):
            raise TypeError("A sampled controller needs concrete times: give them outside jax.jit and jax.grad.")
        wanted = np.asarray(times)
        grid = sampled_intervals(wanted, feedback.period, wanted[0], wanted[-1])
        run = integrate_sampled(nameless, driven, grid, times, (start, feedback.start), settings)
    else:
        run = integrate(nameless, driven, times[jnp.array([0, -1])], times, (start, None), settings)
    # What a failure or a stop leaves out.
    reached, stopped = run.x.shape[0], progress and int(run.result) == RESULTS.stopped
    columns = [run.x, run.xd, run.near, run.u]
    if stopped:
        times = times[:reached]
    elif progress:
        columns = [jnp.pad(c, ((0, len(times) - reached), (0, 0)), constant_values=jnp.inf) for c in columns]
    x, xd, near, u = columns
    found = Motion(times, x, xd, near, u, run.steps, run.result, driven, model, form, name)
    failing = throw and not stopped and is_concrete(found.result) and int(found.result) == RESULTS.singular_mass
    check(found.result, throw and not stopped, without_mass(model) if failing else "")
    return found


class Condition(Record):
    """Condition of an event, as it was when the simulation was called.

    Attributes:
        function: Of time and state.
    """

    function: Captured

    def __call__(self, t, y, args, **more):
        """What diffrax watches.

        Args:
            t: Time [s].
            y: State.
            args: Not used.
            more: Not used.
        """
        return self.function(t, y)


def _event_now(event, model: Model, driven, t, start: Start, settings: dict[str, Any]):
    """An event of diffrax whose conditions will not change; those that ask for more than time and state stay."""
    like = jax.eval_shape(lambda given: begin(model, driven, t, given, settings)[0], start)

    def now(condition):
        try:
            return Condition(captured(lambda t, y: condition(t, y, None), t, like))
        except (KeyError, TypeError):
            return condition

    return dataclasses.replace(event, cond_fn=jax.tree.map(now, event.cond_fn, is_leaf=callable))


def _check_kinds(**given: Any) -> None:
    """Refuse what is no object of diffrax where one is asked for, such as its class or its name."""
    if all(value is None for value in given.values()):
        return
    import diffrax

    kinds = {
        "solver": (diffrax.AbstractSolver, "a solver, such as Rodas5P() or diffrax.Dopri8()"),
        "controller": (diffrax.AbstractStepSizeController, "a step size controller of diffrax"),
        "adjoint": (diffrax.AbstractAdjoint, "an adjoint of diffrax"),
        "event": (diffrax.Event, "an Event of diffrax"),
    }
    for name, value in given.items():
        kind, wanted = kinds[name]
        if value is not None and not isinstance(value, kind):
            raise TypeError(f"Argument `{name}` must be {wanted}, not {shown(value)}.")


def _checked_solver(solver, controller, plain: bool, dt0, jumps: bool):
    """A solver that was given, with its steps brought back onto the constraints."""
    import diffrax

    from .energy_keeping import EnergyKeeping
    from .projected import Projected
    from .solver import MotionSolver

    if isinstance(solver, EnergyKeeping) and not plain:
        raise ValueError('EnergyKeeping() needs form="coordinates" and no controller: take GeneralizedAlpha().')
    if not isinstance(solver, diffrax.AbstractAdaptiveSolver) and controller is None:
        name = type(solver).__name__
        if dt0 is None:
            raise ValueError(f"{name} takes steps of one size: say which with `dt0`.")
        if jumps:
            raise ValueError(f"{name} would step over the jumps of the loads: give `controller=diffrax.StepTo(..)`.")
    return solver if isinstance(solver, MotionSolver | Projected) else Projected(solver)


def _checked_times(times):
    check_numbers("Argument `times`", times)
    times = jnp.asarray(times, float)
    if times.ndim != 1 or times.shape[0] < 2:
        raise ValueError(f"Argument `times` must be at least two times, the first of them the start, not {times}.")
    if not isinstance(times, jax.core.Tracer) and not bool(np.all(np.diff(np.asarray(times)) > 0)):
        raise ValueError("Argument `times` must be ascending, without a time twice.")
    return times


def _initial(model: Model, initial):
    if initial is None:
        if model.parameters.start is None and model.parameters.loads.x is None and model.parameters.loads.e is None:
            return Start(model.parameters.reference, jnp.zeros(model.topology.n_x))
        initial = configuration(model)
    if not isinstance(initial, Equilibrium | Configuration | Motion):
        raise TypeError(
            f"Argument `initial` must be an Equilibrium, a Configuration or a Motion, not {shown(initial)}."
        )
    if initial.labels.x != model.labels.x:
        raise ModelError("Argument `initial` is a state of another model: its nodes are not those of this one.")
    if isinstance(initial, Motion):
        if is_concrete(initial.x) and not np.all(np.isfinite(np.asarray(initial.x[-1]))):
            raise ModelError("Argument `initial` is a motion that did not reach its end: give motion.until(count).")
        return Start(initial.x[-1], initial.xd[-1], initial.near[-1])
    if is_concrete(initial.result):
        check(initial.result, True)
    rest = jnp.zeros(model.topology.n_x)
    return Start(initial.x, initial.xd if isinstance(initial, Configuration) else rest)


def driven_by(model: Model, loads: Mapping, motion: Mapping, increment) -> tuple[Driven, ...]:
    """Functions of time with the indices of what they drive.

    Args:
        model: Mechanism.
        loads: See :func:`simulate`.
        motion: See :func:`simulate`.
        increment: See :func:`simulate`.

    Raises:
        ModelError: Unknown name, or what cannot be driven.
    """
    labels, topology = model.labels, model.topology
    for argument, given in (("loads", loads), ("motion", motion)):
        if not isinstance(given, Mapping):
            raise ModelError(f"Argument `{argument}` must be a dictionary of names and functions, not {shown(given)}.")
    x_names = {str(entry): i for i, entry in enumerate(labels.x)}
    e_names = {str(entry): i for i, entry in enumerate(labels.e) if entry.kind == "deformation"}
    found = []
    driven_names: dict[tuple[str, int], str] = {}
    for name, value in loads.items():
        nodes, what = labels.coordinates(name), f"Load '{name}'"
        if name in x_names:
            found.append(Driven("force", jnp.array([x_names[name]]), _function(what, value, 1)))
        elif name in e_names:
            found.append(Driven("stress", jnp.array([e_names[name]]), _function(what, value, 1)))
        elif nodes:
            turned = labels.dimension == 3 and labels.x[nodes[0]].kind == "rotation"
            value = _function(what, value, 3 if turned else len(nodes))
            found.append(Driven("moment" if turned else "force", jnp.array(nodes), value))
        else:
            raise ModelError(
                f"Load '{name}' names no coordinate, deformation or node. There are: {_some(x_names, e_names)}."
            )
    for name, value in motion.items():
        meant = _rotation_prescribed(labels, name)
        for names, roles, quantity in ((x_names, topology.x, "x"), (e_names, topology.e, "e")):
            if meant not in names:
                continue
            order = np.asarray(roles.prescribed).tolist()
            if names[meant] not in order:
                raise ModelError(f"Motion '{name}' is not PRESCRIBED: say prescribe() of it in the builder.")
            if isinstance(value, Table):
                raise ModelError(f"Motion '{name}' is a table, whose velocity jumps. Give a smooth function of time.")
            value = _function(f"Motion '{name}'", value, 1)
            first = driven_names.setdefault((quantity, names[meant]), name)
            if first != name:
                raise ModelError(f"Motions '{first}' and '{name}' drive the same coordinate: give one of them.")
            found.append(Driven(quantity, jnp.array([order.index(names[meant])]), value))
            break
        else:
            if labels.coordinates(name) and labels.x[labels.coordinates(name)[0]].kind == "rotation":
                node = name.removesuffix(".rotation")
                raise ModelError(
                    f"Motion '{name}' is not PRESCRIBED: say prescribe('{node}', \"rotation\", axis=..) of it in the"
                    " builder."
                )
            raise ModelError(
                f"Motion '{name}' names no coordinate or deformation. There are: {_some(x_names, e_names)}."
            )
    if increment is not None:
        own = model.parameters.increment
        if own is None:
            raise ModelError("The model has no incremental loads for `increment` to scale: give them increment=True.")
        if own.gravity is not None:
            raise ModelError("Gravity among the incremental loads does not change with time. Make it a constant load.")
        found.append(Driven("increment", jnp.zeros(0, int), _function("Argument `increment`", increment, 1)))
    return tuple(found)


def _rotation_prescribed(labels: Labels, name: str) -> str:
    """Name of what is prescribed in place of a rotation: its angle in the plane, that of a hinge in space."""
    indices = labels.coordinates(name)
    if not indices or labels.x[indices[0]].kind != "rotation":
        return name
    if labels.dimension == 2:
        return f"{name}.{labels.x[indices[0]].symbol}"
    return f"turn of {name.removesuffix('.rotation')}.e1"


def _function(what: str, value: Any, size: int) -> Captured | Table:
    """A function of time as it is now, which gives as many numbers as are driven.

    Raises:
        ModelError: It is no function, or gives another number of them.
    """
    if not callable(value):
        raise ModelError(f"{what} must be a function of time, such as lambda t: 3.0, not {shown(value)}.")
    if isinstance(value, Table):
        _check_table(what, value)
        taken, shape = value, np.shape(value.values)[1:]
    else:
        time = jax.ShapeDtypeStruct((), float)
        try:
            taken = captured(lambda t: jnp.asarray(value(t), float), time)
        except Exception as fault:
            first = (str(fault).strip().splitlines() or [type(fault).__name__])[0]
            raise ModelError(f"{what} cannot be computed as a function of time, by jax.numpy: {first}") from fault
        shape = jax.eval_shape(taken, time).shape
    if shape != (size,) and not (size == 1 and shape == ()):
        wanted = "one number" if size == 1 else f"{size} numbers, one for each component"
        raise ModelError(f"{what} must give {wanted}, but gives shape {shape}.")
    return taken


def _check_table(what: str, table: Table) -> None:
    if not is_concrete(table):
        return
    times, values = np.asarray(table.times), np.asarray(table.values)
    if times.ndim != 1 or len(times) < 2 or not np.all(np.isfinite(times)) or not np.all(np.diff(times) > 0):
        raise ModelError(f"{what}: the times of a table must be finite and ascending, two at least.")
    if values.ndim < 1 or len(values) != len(times):
        raise ModelError(f"{what}: a table needs as many values as times, {len(times)}, not {np.shape(values)[:1]}.")
    if not np.all(np.isfinite(values)):
        raise ModelError(f"{what}: the values of a table must be finite.")


def _some(*groups) -> str:
    names = [name for group in groups for name in group]
    return ", ".join(names[:12]) + (", ..." if len(names) > 12 else "")
