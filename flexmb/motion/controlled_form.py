"""A mechanism with a controller around it, as one system of equations of motion."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import as_reals
from ..compilation.record import Record, static
from ..errors import ModelError
from ..math.linear import factorise
from ..mechanics.deformation import deformations
from ..mechanics.signals import rotation_measured, rotation_row
from .coordinates_form import CoordinatesForm
from .drive import MOMENTS, Driven
from .element_forces import Moving, force_derivatives
from .protocol import MotionState, Tangent, WholeMotion


class Feedback(Record):
    """A controller: inputs of the mechanism from its outputs, in the order in which the builder named them.

    Attributes:
        output: ``u = output(t, z, y)``, (n_u,) [N, N m].
        rate: ``dz/dt = rate(t, z, y)``, (n_z,), or None for a controller without state.
        start: State at the start, (n_z,).
        windup: What an excess of the inputs over their limits does to the state where it is to follow within a second,
            (n_z, n_u), or that over time as a table: what :func:`flexmb.control.saturated` keeps integrators from
            winding up by. None where nothing winds up.
        reads, drives: Names of the mechanism's outputs and inputs that it is connected to, where not to all in order.
    """

    output: Callable[..., Any]
    rate: Callable[..., Any] | None = None
    start: Float[Array, "n_z"] | None = None
    windup: Any = None
    reads: tuple[str, ...] | None = static(default=None)
    drives: tuple[str, ...] | None = static(default=None)


class Constant(Record):
    """A number that does not depend on time.

    Attributes:
        value: The number or numbers.
    """

    value: Any

    def __call__(self, t: Float[Array, ""]):
        """The number, whatever the time."""
        return self.value


class PortPlaces(Record):
    """What each input acts on and what each output measures, as indices.

    Attributes:
        forces: Index in x of each input that is a force, and its place among the inputs, (2, k).
        stresses: The same for inputs that are stresses, index in e, (2, l).
        moments: Index in x of the first Euler parameter, place among the inputs, and axis, of each input that is a
            moment about a global axis, (3, m).
        local_moments: The same for axes that turn with the body, (3, n).
        outputs: Index in x or e of each part of an output; of a rotation in space, that of its first Euler parameter,
            (k,).
        axes: Axis of each part that is a rotation in space, (k,).
        read: Weight of each part in each output, (n_y, k); None where the outputs are the parts.
        mix: What each part of an input does by each input, (parts, n_u); None where the inputs are the parts.
        quantities: What each part of an output is: "position", "velocity", "deformation", "deformation rate", or for a
            rotation in space "rotation", "angular velocity", "local rotation", "local angular velocity"; or one of
            ``LATE``.
        inputs: Number of inputs, those that move what is held among them, which act here on nothing.
    """

    forces: Int[Array, "2 k"]
    stresses: Int[Array, "2 l"]
    moments: Int[Array, "3 m"]
    local_moments: Int[Array, "3 n"]
    outputs: Int[Array, "n_y"]
    axes: Int[Array, "n_y"]
    read: Float[Array, "n_y k"] | None
    mix: Float[Array, "parts n_u"] | None
    quantities: tuple[str, ...] = static()
    inputs: int = static()

    @property
    def late(self) -> tuple[int, ...]:
        """Parts of outputs that are known with the accelerations and multipliers only."""
        return tuple(i for i, quantity in enumerate(self.quantities) if quantity in LATE)

    @property
    def passes(self) -> bool:
        """Whether an output feels an input at given accelerations: a stress adds to those that are measured."""
        felt = any(quantity in FORCES for quantity in self.quantities)
        return felt and self.stresses.shape[1] > 0


ROTATIONS = ("rotation", "local rotation")
TURNING = ("angular velocity", "local angular velocity")
# What follows from accelerations and multipliers, the inputs of the same time in them.
LATE = (
    "acceleration",
    "angular acceleration",
    "local angular acceleration",
    "deformation acceleration",
    "stress",
    "reaction",
    "moment",
    "local moment",
)
FORCES = ("stress", "reaction", "moment", "local moment")
# Newton's steps to inputs that depend on accelerations which they cause; of a linear controller one is exact.
CLOSING = 4


def driven_by_inputs(form: CoordinatesForm, places: PortPlaces, u: Float[Array, "n_u"]) -> CoordinatesForm:
    """Equations of a mechanism under given inputs.

    Args:
        u: Inputs, (n_u,).
    """
    if u.shape != (places.inputs,):
        raise ModelError(f"The controller gives shape {u.shape}, but the mechanism has {places.inputs} inputs.")
    u = u if places.mix is None else places.mix @ u
    extra = []
    if places.forces.shape[1]:
        extra.append(Driven("force", places.forces[0], Constant(u[places.forces[1]])))
    if places.stresses.shape[1]:
        extra.append(Driven("stress", places.stresses[0], Constant(u[places.stresses[1]])))
    for kind, moments in zip(MOMENTS, (places.moments, places.local_moments), strict=True):
        for first, place, axis in moments.T:
            about = jnp.zeros(3).at[axis].set(u[place])
            extra.append(Driven(kind, first + jnp.arange(4), Constant(about)))
    return dataclasses.replace(form, driven=(*form.driven, *extra))


class ControlledForm(Record):
    """Equations of motion of a mechanism and a controller.

    The states of the controller are velocities of coordinates of their own, after those of the mechanism: their
    "accelerations" are the rates of the states, and so one solver serves both.

    Attributes:
        form: Equations of the mechanism.
        feedback: Controller.
        places: Inputs and outputs.
        start: Nodal coordinates from which rotations in space are measured, (n_x,) [m, rad, -].
    """

    form: CoordinatesForm
    feedback: Feedback
    places: PortPlaces
    start: Float[Array, "n_x"]

    @property
    def states(self) -> int:
        """Number of states of the controller."""
        return 0 if self.feedback.start is None else self.feedback.start.shape[0]

    @property
    def size(self) -> int:
        """Number of coordinates that move, those of the controller included."""
        return self.form.size + self.states

    @property
    def unknowns(self) -> int:
        """Number of accelerations, rates of the controller, and multipliers."""
        return self.form.unknowns + self.states

    def regular(self, by_z: Float[Array, "r r"]):
        """As the mechanism's."""
        n = self.form.size
        kept = np.r_[:n, self.size : by_z.shape[0]]
        return self.form.regular(by_z[kept[:, None], kept])

    def _split(self, state: MotionState, z: Float[Array, "r"] | None = None) -> tuple[MotionState, Array, Any, Any]:
        """State of the mechanism, of the controller, accelerations and multipliers of the mechanism, rates."""
        n = self.form.size
        own = MotionState(state.u[:n], state.w[:n], state.memory)
        if z is None:
            return own, state.w[n:], None, None
        return own, state.w[n:], jnp.concatenate([z[:n], z[self.size :]]), z[n : self.size]

    def _joined(self, mechanism: Float[Array, "r *k"], controller: Float[Array, "n_z *k"]):
        """Rows of the mechanism's coordinates, of the controller, of the constraints."""
        n = self.form.size
        return jnp.concatenate([mechanism[:n], controller, mechanism[n:]])

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates, with the controller at its start."""
        own = self.form.state_of(x, xd, near)
        if not self.states:
            return own
        start: Any = self.feedback.start
        u, w = jnp.concatenate([own.u, jnp.zeros(self.states)]), jnp.concatenate([own.w, start])
        return MotionState(u, w, own.memory)

    def measured(
        self,
        t: Float[Array, ""],
        own: MotionState,
        z: Float[Array, "r"] | None = None,
        u: Float[Array, "n_u"] | None = None,
    ):
        """Outputs of the mechanism, (n_y,).

        Args:
            t: Time [s].
            own: State of the mechanism.
            z: Its accelerations and multipliers, for outputs that follow from them.
            u: Inputs that caused them, (n_u,).
        """
        values = self._early(t, own)
        for i, value in zip(self.places.late, self._late(t, own, z, u) if self.places.late else (), strict=True):
            values[i] = value
        found = jnp.stack(values) if values else jnp.zeros(0)
        return found if self.places.read is None else self.places.read @ found

    def _late(self, t: Float[Array, ""], own: MotionState, z: Any, u: Any):
        """Parts of outputs that follow from accelerations and multipliers."""
        kin, sigma, force, at = self._driven(u).forces(t, own, z)
        sources = {"acceleration": at.a, "deformation acceleration": kin.edd, "stress": sigma, "reaction": force}
        values = []
        for i in self.places.late:
            quantity = self.places.quantities[i]
            if quantity in sources:
                values.append(sources[quantity][self.places.outputs[i]])
                continue
            turning, axis, local = self._turning(i)
            row = rotation_row(at.x[turning], axis, local)
            # omega = 2 Lbar lambda_dot, whose rate has no other term; a moment is Lbar f / 2.
            values.append(row @ at.a[turning] if "acceleration" in quantity else row @ force[turning] / 4)
        return jnp.stack(values)

    def _early(self, t: Float[Array, ""], own: MotionState) -> list[Any]:
        """Parts of outputs that follow from the state; zero for the others."""
        at = self.form.whole(t, own.u, own.w, jnp.zeros(self.form.size))
        top, parameters = self.form.topology, self.form.parameters
        e = ed = jnp.zeros(top.n_e)
        if any("deformation" in quantity for quantity in self.places.quantities):
            near = self.form.near(own.memory)
            e, ed = jax.jvp(lambda x: deformations(top, parameters, x, near), (at.x,), (at.v,))
        moved = at.x - parameters.reference
        sources = {"position": moved, "velocity": at.v, "deformation": e, "deformation rate": ed}
        values = []
        for i, quantity in enumerate(self.places.quantities):
            if quantity in LATE:
                values.append(jnp.zeros(()))
            elif quantity in sources:
                values.append(sources[quantity][self.places.outputs[i]])
            elif quantity in ROTATIONS:
                values.append(self._rotation(i, at.x)[0])
            else:
                turning, axis, local = self._turning(i)
                values.append(rotation_row(at.x[turning], axis, local) @ at.v[turning])
        return values

    def _turning(self, i: int):
        """Indices of the Euler parameters of an output that is a rotation, its axis, and whether that turns along."""
        own = self.places.outputs[i] + jnp.arange(4)
        return own, self.places.axes[i], self.places.quantities[i].startswith("local")

    def _rotation(self, i: int, x: Float[Array, "n_x"]):
        """Rotation that an output measures, and its derivative by the Euler parameters."""
        own, axis, local = self._turning(i)
        return rotation_measured(x[own], self.start[own], self.form.parameters.reference[own], axis, local)

    def _rate(self, t: Float[Array, ""], states: Float[Array, "n_z"], y: Float[Array, "n_y"]):
        """Rates of the controller's state, (n_z,)."""
        rate: Any = self.feedback.rate
        found = jnp.atleast_1d(as_reals("The controller's rate", rate(t, states, y), ModelError))
        if found.shape != states.shape:
            raise ModelError(f"The controller's rate gives shape {found.shape}, but it has {states.shape[0]} states.")
        return found

    def _driven(self, u: Float[Array, "n_u"]) -> CoordinatesForm:
        """Equations of the mechanism under given inputs."""
        return driven_by_inputs(self.form, self.places, u)

    def _inputs(self, t: Float[Array, ""], states: Float[Array, "n_z"], y: Float[Array, "n_y"]):
        """Inputs of the mechanism, (n_u,)."""
        return jnp.atleast_1d(jnp.asarray(self.feedback.output(t, states, y), float))

    def _closed(self, t: Float[Array, ""], own: MotionState, states: Float[Array, "n_z"], z: Float[Array, "r"] | None):
        """Outputs and inputs at one time; the inputs may depend on what they cause."""
        if not self.places.late:
            y = self.measured(t, own)
            return y, self._inputs(t, states, y)

        def seen(u: Float[Array, "n_u"]):
            found = self._driven(u).acceleration(t, own)[0] if z is None else z
            y = self.measured(t, own, found, u)
            return y, y

        # Outputs are linear in the inputs, at given positions and velocities.
        none = jnp.zeros(self.places.inputs)
        if z is not None and not self.places.passes:
            return (y := seen(none)[0]), self._inputs(t, states, y)
        by_input, at_none = jax.jacfwd(seen, has_aux=True)(none)

        def closer(_: Array, u: Float[Array, "n_u"]):
            def left(u: Float[Array, "n_u"]):
                found = u - self._inputs(t, states, at_none + by_input @ u)
                return found, found

            slope, excess = jax.jacfwd(left, has_aux=True)(u)
            return u - factorise(slope).solve(excess)

        u = jax.lax.fori_loop(0, CLOSING, closer, none)
        return at_none + by_input @ u, u

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Residual of the mechanism, and of the controller's rates."""
        own, states, own_z, rates = self._split(state, z)
        y, u = self._closed(t, own, states, own_z)
        mechanism = self._driven(u).residual(t, own, own_z)
        controller = rates
        if self.states:
            controller = jnp.asarray(rates) - self._rate(t, states, y)
        return self._joined(mechanism, controller)

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of the residual: those of the mechanism, and through its outputs and the controller.

        Source:
            Chain rule.
        """
        own, states, own_z, _ = self._split(state, z)
        n, k = self.form.size, self.states
        y, u = self._closed(t, own, states, own_z)
        at = self._driven(u).tangent(t, own, own_z)
        by_input = self._by_input(t, own, own_z, u)
        y_by, u_by = self._closed_derivatives(t, own, states, own_z, y, u)
        r_by_states, r_by_y = jnp.zeros((0, 0)), jnp.zeros((0, len(y)))
        if k:
            r_by_states, r_by_y = jax.jacfwd(lambda z, y: self._rate(t, z, y), (0, 1))(states, y)
        mechanism = [by_input @ of for of in u_by]
        controller = [-r_by_y @ of for of in y_by]
        none = jnp.zeros((at.by_u.shape[0], k))
        mechanism_u = jnp.concatenate([at.by_u + mechanism[0], none], axis=1)
        mechanism_w = jnp.concatenate([at.by_w + mechanism[1], mechanism[2]], axis=1)
        controller_u = jnp.concatenate([controller[0], jnp.zeros((k, k))], axis=1)
        controller_w = jnp.concatenate([controller[1], controller[2] - r_by_states], axis=1)
        by_z = jnp.zeros((z.shape[0], z.shape[0])).at[n : n + k, n : n + k].set(jnp.eye(k))
        kept = jnp.concatenate([jnp.arange(n), jnp.arange(n + k, z.shape[0])])
        if self.places.late:
            by_z = by_z.at[kept[:, None], kept].set(at.by_z + mechanism[3])
            by_z = by_z.at[(n + jnp.arange(k))[:, None], kept].set(controller[3])
        else:
            by_z = by_z.at[kept[:, None], kept].set(at.by_z)
        by_t = jax.jvp(lambda t: self.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
        return Tangent(self._joined(mechanism_u, controller_u), self._joined(mechanism_w, controller_w), by_z, by_t)

    def _closed_derivatives(
        self,
        t: Float[Array, ""],
        own: MotionState,
        states: Float[Array, "n_z"],
        z: Float[Array, "r"],
        y: Float[Array, "n_y"],
        u: Float[Array, "n_u"],
    ) -> tuple[list[Array], list[Array]]:
        """Derivatives of outputs and of inputs, by positions, velocities and the controller's states.

        Where outputs follow from accelerations, also by these; and inputs then depend on outputs that depend on them.
        """
        u_by_states, u_by_y = jax.jacfwd(lambda z, y: self._inputs(t, z, y), (0, 1))(states, y)
        by_u, by_w, by_z, by_input = self._measured_derivatives(t, own, z, u)
        y_by = [by_u, by_w, jnp.zeros((len(y), self.states)), *([] if by_z is None else [by_z])]
        u_by = [u_by_y @ of for of in y_by]
        u_by[2] = u_by_states
        if by_input is None:
            return y_by, u_by
        close = factorise(jnp.eye(self.places.inputs) - u_by_y @ by_input)
        u_by = [close.solve(of) if of.shape[1] else of for of in u_by]
        return [own + by_input @ of for own, of in zip(y_by, u_by, strict=True)], u_by

    def _by_input(self, t: Float[Array, ""], own: MotionState, own_z: Float[Array, "r"], u: Float[Array, "n_u"]):
        """Derivative of the mechanism's residual by its inputs, in which it is linear."""
        return jax.jacfwd(lambda u: self._driven(u).residual(t, own, own_z))(u)

    def _measured_derivatives(
        self,
        t: Float[Array, ""],
        own: MotionState,
        z: Float[Array, "r"] | None = None,
        u: Float[Array, "n_u"] | None = None,
    ):
        """Derivatives of the outputs by positions, velocities, and of late ones by accelerations and inputs."""
        by_u, by_w = self._early_derivatives(t, own)
        by_z = by_input = None
        if self.places.late:
            late = np.array(self.places.late)

            def found(u: Float[Array, "n"], w: Float[Array, "n"], z: Float[Array, "r"], inputs: Float[Array, "n_u"]):
                return self._late(t, own._replace(u=u, w=w), z, inputs)

            rows = jax.jacfwd(found, (0, 1, 2, 3))(own.u, own.w, z, u)
            none = [jnp.zeros((by_u.shape[0], row.shape[1])) for row in rows[2:]]
            by_u, by_w, by_z, by_input = (
                of.at[late].set(row) for of, row in zip((by_u, by_w, *none), rows, strict=True)
            )
        read = self.places.read
        return tuple(of if of is None or read is None else read @ of for of in (by_u, by_w, by_z, by_input))

    def _early_derivatives(self, t: Float[Array, ""], own: MotionState):
        """Derivatives of the parts of outputs that follow from the state, by positions and velocities."""
        top, form = self.form.topology, self.form
        at = form.whole(t, own.u, own.w, jnp.zeros(form.size))
        rows, zero = jnp.eye(top.n_x), jnp.zeros((1, top.n_x))
        by_x = None
        if any("deformation" in quantity for quantity in self.places.quantities):
            moving = Moving(at.x, at.v, jnp.zeros(top.n_x), form.near(own.memory))
            by_x = force_derivatives(form.elements, moving, None, lambda e, ed: e)
        found: tuple[list, list] = ([], [])
        for i, quantity in enumerate(self.places.quantities):
            j = self.places.outputs[i]
            if quantity in LATE:
                pair = (zero, zero)
            elif quantity in ROTATIONS:
                own_x, *_ = self._turning(i)
                pair = (zero.at[0, own_x].set(self._rotation(i, at.x)[1]), zero)
            elif quantity in TURNING:
                own_x, axis, local = self._turning(i)
                # The angular velocity 2 Lbar(lambda) lambda_dot is antisymmetric in the two.
                by_rate = zero.at[0, own_x].set(rotation_row(at.x[own_x], axis, local))
                pair = (zero.at[0, own_x].set(-rotation_row(at.v[own_x], axis, local)), by_rate)
            elif by_x is None or "deformation" not in quantity:
                row = rows[j][None]
                pair = (row, zero) if quantity == "position" else (zero, row)
            elif quantity == "deformation":
                pair = (by_x.e[j][None], zero)
            else:
                pair = (by_x.ed[j][None], by_x.e[j][None])
            for rows_of, row in zip(found, pair, strict=True):
                rows_of.append(row)
        return tuple((jnp.concatenate(r) if r else jnp.zeros((0, top.n_x)))[:, form.free] * form.sizes for r in found)

    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, rates of the controller and multipliers, and whether every motion carries mass."""
        own, states, _, _ = self._split(state)
        y, u = self._closed(t, own, states, None)
        z, regular = self._driven(u).acceleration(t, own)
        return self._joined(z, self._rate(t, states, y) if self.states else jnp.zeros(0)), regular

    def gap(self, t: Float[Array, ""], state: MotionState):
        """As the mechanism's."""
        return self.form.gap(t, self._split(state)[0])

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """As the mechanism's."""
        own, _, own_z, _ = self._split(state, z)
        return self.form.rate_of_memory(t, own, own_z)

    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """The mechanism brought back onto its constraints; the controller stays as it is."""
        n = self.form.size
        own = self.form.settle(t, self._split(state)[0], None if mass is None else mass[:n, :n])
        return MotionState(jnp.concatenate([own.u, state.u[n:]]), jnp.concatenate([own.w, state.w[n:]]), own.memory)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state, and the inputs that the controller gives."""
        own, z, _, _ = self._split(state)
        return self.form.whole_motion(t, own)._replace(u=self._closed(t, own, z, None)[1])
