"""Inverse dynamics: inputs that drive a mechanism along a trajectory while its flexible deformations stay constant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Bool, Float, Int

from ..arguments import checked_times, computed, is_concrete, short_repr
from ..compilation.compile import jit, jit_beside_options
from ..compilation.record import Record, static
from ..display import Column, Labelled, Quantities, States, Summary, among, listed, short, span
from ..errors import AnalysisError, ModelError
from ..math.derivative import DIFFERENTIATED
from ..math.indices import accumulate, put
from ..math.linear import factorise
from ..math.rotation import rotation_since
from ..mechanics.deformation import Transfer, correction, deformations, transfer, zero_strain
from ..mechanics.signals import DEFORMATION_ORDERS, ORDERS, rotation_row
from ..model.by_name import turn_of
from ..model.model import Model, Signal, as_determined, as_known_model
from ..model.topology import coordinate_scales
from ..motion.coordinates_form import CoordinatesForm, coordinates_form
from ..motion.drive import Driven, Table
from ..motion.drives_by_name import Drives, driven_by, warn_of_left_out
from ..motion.element_forces import Moving, deformations_and_slopes
from ..motion.full_turns import warn_of_full_turns
from ..motion.loop import under_inputs
from ..motion.motion import Motion
from ..motion.moving_matrices import dynamic_balance, state_at_rates
from ..numerical_limits import MISSED_CONFIGURATION
from ..results import RESULTS, check, or_nan, outcome_text
from ..statics.coarse import warn_of_needless_strain
from .about_motion import loads_of_freedoms, outputs_of
from .laws import Law, as_law, rates, sampled

# Largest change of wanted quantities between two solutions, as a share of the mechanism's extent or in radians.
STEP = 0.1
# Most steps of Newton's method in each solution, and the relative change at which they end.
CORRECTIONS, SETTLED = 12, 1e-13
# Most steps of that size between two times, and from the undeformed mechanism to its start values; longer ways are not
# followed.
MOST_STEPS = 100_000


class Quantity(Record):
    """A quantity of the configuration: a coordinate from its start, a deformation, or a rotation about an axis.

    Attributes:
        quantity: "x", "e", "rotation" or "local rotation".
        index: Index in x or e; for a rotation in space, the index of its first Euler parameter.
        axis: Axis of a rotation in space.
    """

    quantity: str = static()
    index: Int[Array | np.ndarray, ""]
    axis: Int[Array | np.ndarray, ""]


class FollowedQuantity(Record):
    """A quantity that follows a law of time."""

    place: Quantity
    law: Callable[..., Any]


class Nominal(Labelled, Record):
    """A motion along a trajectory, with the inputs that drive the mechanism.

    The motion is a motion of the flexible model. Therefore the linearised equations
    ``nominal.motion.linearizations()`` include vibrations about this motion.

    Attributes:
        motion: The motion under the inputs and the holding forces, of the same type as from :func:`flexmb.simulate`.
        u0: Nominal inputs, in the order of the builder, (n_t, n_u) [N, N m].
        y0: Outputs, in the order of the builder, (n_t, n_y).
        f0: Holding force of each degree of freedom, in addition to the inputs, (n_t, n_q) [N, N m]. It is zero for
            driven degrees of freedom.
        result: Code of RESULTS at each time, (n_t,).
    """

    motion: Motion
    u0: Float[Array, "n_t n_u"]
    y0: Float[Array, "n_t n_y"]
    f0: Float[Array, "n_t n_q"]
    result: Int[Array, "n_t"]
    one_axis = "result"

    @property
    def t(self) -> Float[Array, "n_t"]:
        """Times, (n_t,) [s]."""
        return self.motion.t

    @property
    def inputs(self) -> dict[str, Law]:
        """Return the nominal inputs as functions of time, by name."""
        return self._laws(self.motion.labels.inputs, self.u0)

    @property
    def outputs(self) -> dict[str, Law]:
        """Return the outputs along the trajectory as functions of time, by name."""
        return self._laws(self.motion.labels.outputs, self.y0)

    def _laws(self, signals: tuple[Signal, ...], values: Any) -> dict[str, Law]:
        degree = min(5, (len(self.t) - 2) // 2 * 2 + 1)
        if degree < 3:
            raise ValueError("Functions of time need at least four times.")
        return {signal.name: sampled(self.t, values[:, i], degree=degree) for i, signal in enumerate(signals)}

    def states(self) -> States:
        """The states over time."""
        return self.motion.states()

    def quantities_by_name(self) -> Quantities:
        """Inputs, outputs and holding forces by time."""
        labels = self.motion.labels
        along, columns = {"time": Column(("time",), self.t, "s")}, {}
        for name, signals, values in (("input", labels.inputs, self.u0), ("output", labels.outputs, self.y0)):
            along[name] = Column((name,), np.array([signal.name for signal in signals]))
            units = np.array([signal.port(labels).unit for signal in signals])
            columns[f"nominal_{name}"] = Column(("time", name), values, units)
        along["freedom"] = Column(("freedom",), np.array(self.motion.model.q_labels))
        columns["holding_force"] = Column(("time", "freedom"), self.f0)
        return Quantities(("time",), along, columns)

    def summary(self) -> Summary:
        """Return the outcome, and the range of each input and output."""
        rows = {"result": outcome_text(np.max(np.asarray(self.result))), "times": str(len(self.t))}
        labels = self.motion.labels
        for word, signals, values in (("input", labels.inputs, self.u0), ("output", labels.outputs, self.y0)):
            for i, signal in enumerate(signals):
                rows[f"{word} {signal.name}"] = span(values[:, i], "")
        largest_forces = np.max(np.abs(np.asarray(self.f0)), axis=0, initial=0.0)
        names = [
            f"{name} {short(f)}" for name, f in zip(self.motion.model.q_labels, largest_forces, strict=True) if f > 0
        ]
        if names:
            rows["largest forces that hold"] = listed(names)
        return Summary("Nominal motion along a trajectory", rows)


def inverse_dynamics(
    model: Model,
    trajectory: Mapping[str, Callable],
    times: ArrayLike,
    *,
    driven: Sequence[str] | None = None,
    inputs: Sequence[str] | None = None,
    throw: bool = True,
) -> Nominal:
    """Return the inputs that drive a mechanism along a trajectory with constant flexible deformations: SPACAR's mode 2.

    A trajectory consists of laws for degrees of freedom, PRESCRIBED coordinates and deformations, other coordinates or
    outputs. Values count from the undeformed mechanism. If a law belongs to another coordinate or an output, the driven
    degrees of freedom follow from kinematics, on the branch of the start values. Degrees of freedom that are not
    driven, such as deformations of flexible parts, keep their start values (zero by default).

    The inputs satisfy the equations of motion along driven degrees of freedom,
    ``B0 u0 = M0 qdd + h - DFx^T f + DFe^T sigma``. Along the other degrees of freedom, the same equations give the
    holding force ``f0``. The force that moves a PRESCRIBED coordinate is a reaction of the result's ``motion``; the
    force that moves a PRESCRIBED deformation is one of its stress resultants.

    Args:
        model: Mechanism with named inputs; differentiable in ``model.parameters``.
        trajectory: Laws by name: a coordinate "stage.x", a rotation "arm.phi" or "arm.rz", a deformation "hinge.e1", or
            an output. A law is a twice differentiable function of time, such as :func:`flexmb.trajectory.quintic`.
            Results are differentiable in its numbers.
        times: Ascending times of the results, (n_t,) [s]. Between two times flexmb moves the wanted quantities on a
            straight line. If a quantity leaves its value and returns to it between two times, flexmb does not notice.
        driven: Names of the degrees of freedom that follow laws of other coordinates and outputs, as many as laws.
            None: the degrees of freedom without stiffness, if there are as many of them as such laws; otherwise all
            degrees of freedom without a law of their own, if there are as many of these.
        inputs: Names of the driving inputs, one for each driven degree of freedom; other inputs are zero. None: all
            inputs.
        throw: Raise if there is no such motion; otherwise the code is in ``result``.

    Returns:
        Nominal.

    Raises:
        ValueError, TypeError: Times do not ascend, a law is not a function of time, or ``jax.jit`` traces the model.
        ModelError: A name is unknown; the number of inputs or of driven degrees of freedom does not fit; nothing moves
            a quantity.
        AnalysisError: outside_workspace (also if the way between two times is too long) or singular_plant, with the
            first time at which it occurs.

    Warns:
        FlexmbWarning: The model has incremental loads, which are left out.

    Source:
        THEORY.md 14, eq. (14.13) to (14.15).
    """
    as_determined(model, "trajectory.inverse_dynamics")
    times = jnp.asarray(checked_times(times), float)
    if not isinstance(trajectory, Mapping) or not trajectory:
        raise ModelError(f"Argument `trajectory` must be a dictionary of names and laws, not {short_repr(trajectory)}.")
    targets, prescribed = _sorted(model, trajectory)
    moved = _driven_freedoms(model, targets, driven)
    acting = _acting_inputs(model, inputs, len(moved))
    _check_inputs(model)
    laws = driven_by(model, Drives(motion=prescribed)) if prescribed else ()
    warn_of_left_out(model, laws, "trajectory.inverse_dynamics")
    names = list(targets)
    solution = _nominal(
        model.without_names(), laws, tuple(targets[n] for n in names), tuple(moved), tuple(acting), times
    )
    if throw and is_concrete(solution):
        laws_by_name = {**{name: target.law for name, target in targets.items()}, **prescribed}
        _explain(model, names, laws_by_name, solution, np.asarray(times))
    check(solution.result, throw)
    solution = or_nan(solution, solution.result, throw)
    if is_concrete((model, solution)):
        _warn_of_needless_strain(model, np.asarray(solution.near), np.asarray(times))
    count = len(times)
    loads = _as_loads(model, times, solution.u0, solution.f0)
    none, no_steps = jax.device_put((np.zeros((count, 0)), np.zeros((), np.int32)))
    worst = computed(lambda xp, result: xp.max(result), solution.result)
    state = solution.x, solution.xd, solution.near
    run = worst, (*laws, *loads), model, "coordinates", "inverse dynamics"
    motion = Motion(times, *state, none, no_steps, *run)
    y0 = solution.y0
    if _are_of_the_motion(model.labels.outputs):
        warn_of_full_turns(motion, model.parameters.reference)
    else:
        y0 = outputs_of(motion)
        if is_concrete(y0) and not np.all(np.isfinite(np.asarray(y0)[np.asarray(solution.result) == 0])):
            raise AnalysisError(
                "singular_mass",
                "An output that needs forces or combines others is not determined: a coordinate carries no mass. Give"
                " the coordinate mass, or leave the output out.",
            )
    return Nominal(motion, solution.u0, y0, solution.f0, solution.result)


def _warn_of_needless_strain(model: Model, e: Float[np.ndarray, "n_t n_e"], times: Float[np.ndarray, "n_t"]) -> None:
    """Warn if held deformations stretch others, at the time of the largest deformation."""
    sizes = np.max(np.abs(e), axis=1, initial=0.0)
    if np.all(np.isfinite(sizes)):
        farthest = int(np.argmax(sizes))
        remedy = (
            "A nominal motion keeps all deformations without a law constant. Name no coefficients of spectral beams as"
            " degrees of freedom: the ones that build() finds leave the beams free to bend. Or use cubic beams"
            " (planar.beam, spatial.beam), released in bending only."
        )
        warn_of_needless_strain(model, e[farthest], f"At t = {short(times[farthest])} s", remedy)


class _AtTimes(NamedTuple):
    """Results of the kernel at every time; ``moves`` is how far driven freedoms move each wanted quantity."""

    x: Any
    xd: Any
    near: Any
    u0: Any
    y0: Any
    f0: Any
    result: Any
    moves: Any


def quantity_place(model: Model, name: str) -> Quantity | None:
    """Place of a named quantity: "stage.x", "arm.phi", "arm.rz", "hinge.e1" or an output; None for an unknown name.

    Raises ModelError: The name is an output that measures a rate.
    """
    labels = model.labels
    if (place := labels.place(name)) is not None:
        return Quantity(place[0], np.array(place[1]), np.array(0))
    if (turned := labels.rotation_of(name)) is not None:
        return Quantity("rotation", np.array(turned[0][0]), np.array(turned[1]))
    for signal in labels.outputs:
        if signal.name == name:
            if signal.quantity not in ("position", "deformation"):
                raise ModelError(
                    f"Trajectory '{name}': the output is a {signal.quantity}. Give the law of an output that is a"
                    " position or a deformation."
                )
            return _place_of_signal(signal)
    return None


def _place_of_signal(signal: Signal) -> Quantity:
    """Place of the quantity whose value or rate an output measures."""
    index, axis = np.array(signal.index), np.array(signal.axis or 0)
    if signal.axis is not None:
        return Quantity("local rotation" if signal.local else "rotation", index, axis)
    return Quantity("e" if signal.quantity in DEFORMATION_ORDERS else "x", index, axis)


def _sorted(
    model: Model, trajectory: Mapping[str, Callable]
) -> tuple[dict[str, FollowedQuantity], dict[str, Callable]]:
    """Laws of free quantities, and laws of PRESCRIBED ones."""
    top = as_known_model(model, "trajectory.inverse_dynamics", numbers=False).topology
    sets, e_names = {"x": top.x, "e": top.e}, [str(entry) for entry in model.labels.e]
    targets, prescribed = {}, {}
    for name, law in trajectory.items():
        law = as_law(f"Trajectory '{name}'", law)
        turn = f"{turn_of(str(name))}.e1"
        place = quantity_place(model, name)
        if turn in e_names and e_names.index(turn) in np.asarray(top.e.prescribed):
            prescribed[name] = law
        elif place is None:
            known = [*model.q_labels, *(signal.name for signal in model.labels.outputs)]
            raise ModelError(
                f"Trajectory '{name}' names no coordinate, deformation or output. There are, among others,"
                f" {among(known, name)}."
            )
        elif place.quantity in sets and place.index in np.asarray(sets[place.quantity].prescribed):
            labels = model.labels.x if place.quantity == "x" else model.labels.e
            prescribed[str(labels[int(place.index)])] = law
        elif place.quantity in sets and place.index in np.asarray(sets[place.quantity].fixed):
            raise ModelError(f"Trajectory '{name}' belongs to a FIXED coordinate or deformation, which cannot move.")
        else:
            targets[name] = FollowedQuantity(place, law)
    return targets, prescribed


def _driven_freedoms(model: Model, targets: dict[str, FollowedQuantity], driven: Sequence[str] | None) -> list[int]:
    """Driven degrees of freedom as indices in q: driven by the trajectory, and driven by other laws."""
    top, names = model.topology, model.q_labels
    x_dof, e_dof = np.asarray(top.x.dof).tolist(), np.asarray(top.e.dof).tolist()
    target_freedoms, followed = [], []
    for name, target in targets.items():
        index = int(target.place.index)
        if target.place.quantity == "x" and index in x_dof:
            target_freedoms.append(x_dof.index(index))
        elif target.place.quantity == "e" and index in e_dof:
            target_freedoms.append(len(x_dof) + e_dof.index(index))
        else:
            followed.append(name)
    if len(set(target_freedoms)) < len(target_freedoms):
        raise ModelError("Two laws of `trajectory` belong to the same degree of freedom: leave one out.")
    if driven is not None:
        as_written = {name.replace(".rotation.", "."): name for name in names}
        written = driven if isinstance(driven, str) else [as_written.get(name, name) for name in driven]
        chosen = _numbers_of("driven", "degrees of freedom", written, names)
        chosen = target_freedoms + [i for i in chosen if i not in target_freedoms]
        if len(chosen) != len(targets):
            raise ModelError(
                f"Argument `driven`: there are {len(targets)} laws, of {among(targets)}, but {len(chosen)} degrees of"
                " freedom are driven. There must be as many."
            )
        return chosen
    remaining = [i for i in range(top.n_q) if i not in target_freedoms]
    # Stiffness does not matter if all remaining freedoms follow.
    stiff = _stiff(model) if followed and len(followed) != len(remaining) else set()
    soft = [i for i in remaining if i < len(x_dof) or e_dof[i - len(x_dof)] not in stiff]
    for chosen in ([] if not followed else soft, remaining):
        if len(chosen) == len(followed):
            return target_freedoms + chosen
    if not followed:
        return target_freedoms
    raise ModelError(
        f"Trajectory of {among(followed)}: {len(followed)} degrees of freedom must be driven to follow it, of"
        f" {among([names[i] for i in remaining]) if remaining else 'none that are left'}. Name them by `driven`."
    )


def _stiff(model: Model) -> set[int]:
    """Indices of deformations with stiffness."""
    from ..mechanics.stress_resultants import element_stiffness

    stiffness = jax.lax.stop_gradient(element_stiffness(model.topology, model.parameters))
    if not is_concrete(stiffness):
        raise ModelError("Under a trace, name the degrees of freedom that are driven: argument `driven`.")
    return set(np.flatnonzero(np.diagonal(np.asarray(stiffness)) != 0).tolist())


def _acting_inputs(model: Model, inputs: Sequence[str] | None, count: int) -> list[int]:
    """Inputs to be computed, one for each driven degree of freedom."""
    names = [signal.name for signal in model.labels.inputs]
    if inputs is None:
        chosen = [i for i, signal in enumerate(model.labels.inputs) if signal.quantity not in ORDERS]
    else:
        chosen = _numbers_of("inputs", "inputs", inputs, names)
        if len(set(inputs)) < len(inputs):
            raise ModelError(f"Argument `inputs` names an input twice: {among(inputs)}.")
    if inputs is None and not count:
        # PRESCRIBED motions need no input.
        return []
    if len(chosen) != count:
        has = f"there are {among([names[i] for i in chosen])}" if chosen else "there is none"
        raise ModelError(
            f"{count} degrees of freedom are driven and need as many inputs, but {has}. Name inputs by input() in the"
            " builder, and select the driving inputs by `inputs`."
        )
    return chosen


def _numbers_of(argument: str, what: str, chosen: Sequence[str], names: list[str]) -> list[int]:
    """Places of chosen names; raise ModelError for another name or no list."""
    unknown = [chosen] if isinstance(chosen, str) else [name for name in chosen if name not in names]
    if unknown:
        known = among(names, unknown[0])
        raise ModelError(f"Argument `{argument}` must be a list of {what}, {known}; not {unknown[0]!r}.")
    return [names.index(name) for name in chosen]


def _are_of_the_motion(outputs: Sequence[Signal]) -> bool:
    """Whether no output needs forces, or combines others."""
    return all(signal.quantity in (*ORDERS, *DEFORMATION_ORDERS) for signal in outputs)


def _check_inputs(model: Model) -> None:
    """Refuse inputs that move held things, whose laws belong into the trajectory."""
    for signal in model.labels.inputs:
        if any(part.order is not None for part in signal.terms):
            raise ModelError(
                f"Input '{signal.name}' moves a FIXED or PRESCRIBED coordinate, but inverse dynamics computes forces,"
                " moments and stresses. Leave it out, call prescribe() for the coordinate, and give its law in the"
                " trajectory."
            )


def _explain(model: Model, names: list[str], laws: dict[str, Callable], solution: _AtTimes, times: np.ndarray) -> None:
    """Raise with the first failing time, and with the quantity that nothing moves or that goes too far."""
    codes = np.asarray(solution.result)
    if not np.any(codes):
        return
    first = int(np.flatnonzero(codes)[0])
    moves = np.asarray(solution.moves)[first]
    still = [name for name, part in zip(names, moves, strict=True) if part == 0]
    if still:
        raise ModelError(f"Trajectory of {among(still)}: no driven degree of freedom moves it.")
    sizes, most = np.asarray(coordinate_scales(model.topology, model.parameters)), MOST_STEPS * STEP
    for name, law in laws.items():
        current, before = (np.asarray(rates(law, jnp.asarray(times[i]))) for i in (first, max(first - 1, 0)))
        if not np.all(np.isfinite(current)):
            raise ModelError(
                f"Trajectory '{name}': its law, or a derivative of it, is not finite at {short(times[first])} s."
            )
        place = quantity_place(model, name)
        size = sizes[place.index] if place is not None and place.quantity == "x" else 1.0
        if abs(current[0] - (before[0] if first else 0.0)) > most * size:
            since = f"between t = {short(times[first - 1])} and" if first else "from the undeformed mechanism to t ="
            raise AnalysisError(
                RESULTS.outside_workspace.name,
                f"Trajectory '{name}' goes too far {since} {short(times[first])} s: the limit is {most:g} rad,"
                f" {most / (2 * np.pi):.0f} turns, or {most:g} times the size of the mechanism. Give more times, or"
                " begin nearer.",
            )
    check(codes[first], True, f"This happens at {short(times[first])} s.")


def _measured(
    form: CoordinatesForm, places: Sequence[Quantity], x: Float[Array, "n_x"], near: Float[Array, "n_e"]
) -> Float[Array, "k"]:
    """Quantities of a configuration, counted from the undeformed mechanism."""
    top, parameters = form.topology, form.parameters
    e = deformations(top, parameters, x, near) if any(p.quantity == "e" for p in places) else near
    values = []
    for place in places:
        if place.quantity == "x":
            values.append(x[place.index] - parameters.reference[place.index])
        elif place.quantity == "e":
            values.append(e[place.index])
        else:
            rotation_indices = place.index + jnp.arange(4)
            local = place.quantity == "local rotation"
            values.append(
                rotation_since(parameters.reference[rotation_indices], x[rotation_indices], local)[place.axis]
            )
    return jnp.stack(values) if values else jnp.zeros(0)


class _At(NamedTuple):
    """Degrees of freedom, nodal coordinates and deformations."""

    q: Any
    x: Any
    near: Any


class _Corrected(NamedTuple):
    """A state after a step of Newton's method, the step, and derivatives of wanted by driven quantities."""

    at: _At
    change: Any
    rows: Any
    regular: Any


# Coordinates and held deformations; wanted values; degrees of freedom from the undeformed mechanism.
_Goal = tuple[tuple[Any, Any], Any, Any]


class _Follower(NamedTuple):
    """A mechanism that follows laws: equations, laws, numbers of the driven freedoms, and sizes of the coordinates."""

    form: CoordinatesForm
    wanted: tuple[FollowedQuantity, ...]
    moved: tuple[int, ...]
    sizes: Float[Array, "n_x"]

    @property
    def driven(self) -> Int[Array, "k"]:
        return jnp.array(self.moved, int)

    def measured(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]) -> Float[Array, "k"]:
        """Wanted quantities of a configuration."""
        return _measured(self.form, [target.place for target in self.wanted], x, near)

    def rows(self, tangent: Transfer, x: Float[Array, "n_x"], near: Float[Array, "n_e"]) -> tuple[Array, Array]:
        """Derivatives of wanted quantities by the coordinates, and by driven quantities."""
        by_x = jax.jacfwd(lambda x: self.measured(x, near))(x)
        return by_x, by_x @ tangent.DFx[:, self.driven]

    def goal(self, t: Float[Array, ""]) -> _Goal:
        """Everything that is given at a time."""
        form, start = self.form, self.form.parameters.start
        prescribed = form.whole(t)
        values = [jnp.asarray(target.law(t), float) for target in self.wanted]
        q = jnp.zeros(form.topology.n_q) if start is None else jnp.asarray(start[0])
        return (prescribed.x, prescribed.e), jnp.stack(values) if values else jnp.zeros(0), q

    def distance(self, a: _Goal, b: _Goal) -> Float[Array, ""]:
        """Largest change between two goals, as a share of the mechanism's extent or in radians."""
        (x, e), target, q = jax.tree.map(lambda a, b: b - a, a, b)
        places = [item.place for item in self.wanted]
        of_target = [self.sizes[p.index] if p.quantity == "x" else jnp.array(1.0) for p in places]
        parts = (x / self.sizes, e, target / (jnp.stack(of_target) if places else 1.0), q)
        return jnp.max(jnp.abs(jnp.concatenate(parts)), initial=0.0)

    def closer(self, goal: _Goal, at: _At) -> _Corrected:
        """One step of Newton's method towards wanted values, THEORY.md 14, eq. (14.13)."""
        form, moved, driven = self.form, self.moved, self.driven
        top, n = form.topology, form.topology.x.dof.shape[0]
        (held_x, held_e), target, held_q = goal
        q = put(held_q, driven, at.q[driven]) if moved else held_q
        x_wanted = put(held_x, top.x.dof, form.parameters.reference[top.x.dof] + q[:n])
        e_wanted = put(put(jnp.zeros(top.n_e), form.held, held_e), top.e.dof, q[n:])
        e, jacobian = deformations_and_slopes(form.elements, at.x, at.near)
        tangent = transfer(top, jacobian)
        shift = put(jnp.zeros(top.n_x), top.x.given, (x_wanted - at.x)[top.x.given])
        change = correction(top, tangent, e - e_wanted + jacobian @ shift, shift)
        rows, dq = jnp.zeros((0, 0)), jnp.zeros(0)
        regular = tangent.regular
        if moved:
            by_x, rows = self.rows(tangent, at.x, at.near)
            factors = factorise(rows)
            dq = factors.solve(target - self.measured(at.x, at.near) - by_x @ change)
            change = change + tangent.DFx[:, driven] @ dq
            regular = regular & factors.regular()
        at = _At(accumulate(q, driven, dq) if moved else q, at.x + change, e)
        return _Corrected(at, change, rows, regular)

    def settled(self, goal: _Goal, at: _At) -> _At:
        """Newton's method until nothing changes."""

        def more(loop: tuple[Any, ...]):
            i, _, change = loop
            return (i < CORRECTIONS) & (change > SETTLED)

        def step(loop: tuple[Any, ...]):
            i, at, _ = loop
            iteration = self.closer(goal, at)
            return i + 1, iteration.at, jnp.max(jnp.abs(iteration.change / self.sizes), initial=0.0)

        return jax.lax.while_loop(more, step, (0, at, jnp.array(jnp.inf)))[1]

    def walked(self, goals: tuple[_Goal, _Goal], at: _At) -> _At:
        """State at a goal, reached from another in steps that Newton's method can follow; NaN for too many steps."""
        count = jnp.ceil(self.distance(*goals) / STEP)
        within = count <= MOST_STEPS
        count = jnp.where(within, jnp.maximum(count, 1), 0).astype(jnp.int32)

        def step(i: Array, at: _At):
            share = (i + 1).astype(float) / count.astype(float)
            return self.settled(jax.tree.map(lambda a, b: a + share * (b - a), *goals), at)

        at = jax.lax.fori_loop(0, count, step, at)
        return at._replace(x=jnp.where(within, at.x, jnp.nan))

    def configurations(self, times: Float[Array, "n_t"]) -> _At:
        """States at the times, followed from the undeformed mechanism, without derivatives."""
        form, targets, sizes, times = jax.lax.stop_gradient((self.form, self.wanted, self.sizes, times))
        follower = _Follower(form, targets, self.moved, sizes)
        top, parameters = form.topology, form.parameters

        def follow(carry: tuple[_Goal, _At], t: Float[Array, ""]):
            before, at = carry
            goal = follower.goal(t)
            at = follower.walked((before, goal), at)
            return (goal, at), at

        origin = _At(jnp.zeros(top.n_q), parameters.reference, zero_strain(top))
        prescribed, q = (parameters.reference, jnp.zeros(form.held.shape[0])), jnp.zeros(top.n_q)
        if self.moved and parameters.start is not None:
            # Start values select the branch, such as the side to which an elbow is bent.
            still = _Follower(form, (), (), sizes)
            begin = still.goal(times[0])
            origin = still.walked(((prescribed, jnp.zeros(0), q), begin), origin)
            prescribed, _, q = begin
        initial_goal = prescribed, follower.measured(origin.x, origin.near), q
        _, walked = jax.lax.scan(follow, (initial_goal, origin), times)
        return jax.lax.stop_gradient(walked)

    def moving(self, rows: Float[Array, "k k"], tangent: Transfer, t: Float[Array, ""], at: _At) -> Moving:
        """Velocities and accelerations along the trajectory, THEORY.md 14, eq. (14.14)."""
        form, x, last_strain, none = self.form, at.x, at.near, jnp.zeros(self.form.topology.n_q)
        if not self.wanted:
            return state_at_rates(form, t, x, none, none, last_strain)
        _, first, second = jax.tree.map(
            lambda *parts: jnp.stack(parts), *[rates(target.law, t) for target in self.wanted]
        )
        factors = factorise(rows)

        def rate(x: Float[Array, "n_x"], v: Float[Array, "n_x"]):
            return jax.jvp(lambda x: self.measured(x, last_strain), (x,), (v,))[1]

        state = state_at_rates(form, t, x, none, none, last_strain)
        qd = put(none, self.driven, factors.solve(first - rate(x, state.v)))
        state = state_at_rates(form, t, x, qd, none, last_strain)
        reached = jax.jvp(rate, (x, state.v), (state.v, state.a))[1]
        qdd = put(none, self.driven, factors.solve(second - reached))
        return state._replace(a=state.a + tangent.DFx @ qdd)


def _inputs_needed(
    residual: Callable, needed: Float[Array, "n_q"], n_u: int, driven: Int[Array, "k"], acting: tuple[int, ...]
) -> tuple[Float[Array, "n_u"], Float[Array, "n_q"], Bool[Array, ""]]:
    """Driving inputs, holding forces, and whether these inputs can drive."""
    if not acting:
        return jnp.zeros(n_u), needed, jnp.array(True)
    chosen = jnp.array(acting, int)
    b0 = -jax.jacfwd(residual)(jnp.zeros(n_u))
    input_matrix = b0[driven][:, chosen]
    largest = jnp.maximum(jnp.max(jnp.abs(input_matrix)), 1e-300)
    factors = factorise(input_matrix / largest)
    u0 = jnp.zeros(n_u).at[chosen].set(factors.solve(needed[driven]) / largest)
    return u0, put(needed - b0 @ u0, driven, 0.0), factors.regular() & jnp.all(jnp.isfinite(u0))


@jit_beside_options
def _nominal(
    model: Model,
    laws: tuple[Driven, ...],
    wanted: tuple[FollowedQuantity, ...],
    moved: tuple[int, ...],
    acting: tuple[int, ...],
    times: Float[Array, "n_t"],
) -> _AtTimes:
    top, labels = model.topology, model.labels
    form, sizes = coordinates_form(top, model.parameters, laws), coordinate_scales(top, model.parameters)
    follower = _Follower(form, wanted, moved, sizes)
    seen = labels.outputs if _are_of_the_motion(labels.outputs) else ()

    def at_one_time(row: tuple[Array, _At]):
        t, at = row
        goal = follower.goal(t)

        def differentiated(at: _At, _: None):
            iteration = follower.closer(goal, at)
            return iteration.at, iteration

        every = jax.lax.scan(differentiated, at, None, DIFFERENTIATED)[1]
        iteration = jax.tree.map(lambda rows: rows[-1], every)
        x = iteration.at.x
        last_strain, jacobian = deformations_and_slopes(form.elements, x, at.near)
        tangent = transfer(top, jacobian)
        # Derivatives of wanted by driven quantities at this place, so that derivatives pass through the place.
        rows = follower.rows(tangent, x, last_strain)[1] if moved else iteration.rows
        moving = follower.moving(rows, tangent, t, iteration.at._replace(near=last_strain))

        def residual(u: Float[Array, "n_u"]):
            return dynamic_balance(under_inputs(model, form, u), t, moving).residual

        needed = residual(jnp.zeros(len(labels.inputs)))
        u0, f0, plant = _inputs_needed(residual, needed, len(labels.inputs), follower.driven, acting)
        outputs = [_output(form, signal, moving) for signal in seen]
        y0 = jnp.stack(outputs) if outputs else jnp.zeros(0)
        missed = jnp.max(jnp.abs(iteration.change / sizes), initial=0.0)
        fine = jnp.isfinite(missed) & (missed < MISSED_CONFIGURATION) & iteration.regular & tangent.regular
        fine = fine & jnp.all(jnp.isfinite(needed))
        result = jnp.where(plant, RESULTS.successful, RESULTS.singular_plant)
        result = jnp.where(fine, result, RESULTS.outside_workspace).astype(jnp.int32)
        moves = jnp.max(jnp.abs(iteration.rows), axis=1, initial=0.0)
        return _AtTimes(x, moving.v, last_strain, u0, y0, f0, result, moves)

    return jax.lax.map(at_one_time, (times, follower.configurations(times)))


def _output(form: CoordinatesForm, signal: Signal, moving: Moving) -> Float[Array, ""]:
    """Value of an output at a state of motion."""
    x, v, a, last_strain = moving
    place = _place_of_signal(signal)
    order = {**ORDERS, **DEFORMATION_ORDERS}[signal.quantity]
    if signal.axis is not None and order:
        rotation_indices = signal.index + jnp.arange(4)
        return rotation_row(x[rotation_indices], signal.axis, signal.local) @ (v, a)[order - 1][rotation_indices]

    def value(x: Float[Array, "n_x"]):
        return _measured(form, [place], x, last_strain)[0]

    def rate(x: Float[Array, "n_x"], v: Float[Array, "n_x"]):
        return jax.jvp(value, (x,), (v,))[1]

    return (lambda: value(x), lambda: rate(x, v), lambda: jax.jvp(rate, (x, v), (v, a))[1])[order]()


def _as_loads(
    model: Model, times: Float[Array, "n_t"], u0: Float[Array, "n_t n_u"], f0: Float[Array, "n_t n_q"]
) -> tuple[Driven, ...]:
    """Inputs and holding forces as loads over time, exact at the times."""
    loads = []
    if model.labels.inputs:
        constant: Any = _driven_by_inputs(model.without_names(), u0)
        # Loads act at the same places at all times.
        for load in constant:
            loads.append(Driven(load.quantity, computed(lambda _, at: at[0], load.at), Table(times, load.value.value)))
    return (*loads, *loads_of_freedoms(model.topology, times, f0))


@jit
def _driven_by_inputs(model: Model, u0: Float[Array, "n_t n_u"]) -> tuple[Driven, ...]:
    """Loads of the inputs at all times, in one program."""
    plain = coordinates_form(model.topology, model.parameters)
    return jax.vmap(lambda u: under_inputs(model, plain, u).driven)(u0)
