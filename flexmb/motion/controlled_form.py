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
from .protocol import MotionState, Tangent, WholeMotion, by_time


class Feedback(Record):
    """A continuous controller between outputs and inputs of a mechanism, in the order of their names in the builder.

    Attributes:
        output: ``u = output(t, z, y)``, (n_u,) [N, N m].
        rate: ``dz/dt = rate(t, z, y)``, (n_z,); None for a controller without states.
        start: States at the start, (n_z,).
        windup: Rate of the states per excess of the inputs over their limits, (n_z, n_u), or a Table of this rate over
            time. :func:`flexmb.control.saturated` uses it to stop integrators from winding up. None if nothing winds
            up.
        reads, drives: Names of the connected outputs and inputs; None or empty to connect all in order.
    """

    output: Callable[..., Any]
    rate: Callable[..., Any] | None = None
    start: Float[Array, "n_z"] | None = None
    windup: Any = None
    reads: tuple[str, ...] | None = static(default=None)
    drives: tuple[str, ...] | None = static(default=None)


class Constant(Record):
    """A function of time with a constant value."""

    value: Any

    def __call__(self, t: Float[Array, ""]):
        """The value."""
        return self.value


class PortPlaces(Record):
    """Indices of the forces and coordinates of all inputs and outputs.

    Attributes:
        forces: Index in x of each force, and its place among the inputs.
        stresses: Index in e of each stress resultant, and its place among the inputs.
        moments: First Euler parameter, place among the inputs, and global axis of each moment.
        local_moments: The same for axes that turn with the body.
        outputs: Index in x or e of each part of an output; of a rotation in space, its first Euler parameter.
        axes: Axis of each part that is a rotation in space.
        read: Weight of each part in each output; None if the outputs are the parts.
        mix: Weight of each input in each part of an input; None if the inputs are the parts.
        quantities: Quantity of each part of an output: "position", "velocity", "deformation", "deformation rate",
            "rotation", "angular velocity", "local rotation", "local angular velocity", or one of ``LATE``.
        inputs: Number of inputs, including inputs that move constrained coordinates. The latter have no effect here.
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
        """Parts of outputs that depend on accelerations and multipliers."""
        return tuple(i for i, quantity in enumerate(self.quantities) if quantity.removeprefix("local ") in LATE)

    @property
    def passes(self) -> bool:
        """Whether an output depends on an input at given accelerations, such as a measured stress resultant."""
        measures_force = any(quantity.removeprefix("local ") in FORCES for quantity in self.quantities)
        return measures_force and self.stresses.shape[1] > 0


FORCES = ("stress", "reaction", "moment")
# Quantities that depend on accelerations and multipliers, and therefore on the inputs at the same time.
LATE = ("acceleration", "angular acceleration", "deformation acceleration", *FORCES)
# Newton steps to inputs that depend on accelerations which they cause; exact after one for a linear controller.
CLOSING = 4


def driven_by_inputs(form: CoordinatesForm, places: PortPlaces, u: Float[Array, "n_u"]) -> CoordinatesForm:
    """Equations of a mechanism under given inputs."""
    if u.shape != (places.inputs,):
        raise ModelError(f"The controller returns shape {u.shape}, but the mechanism has {places.inputs} inputs.")
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

    The states of the controller are velocities of additional coordinates, which follow the coordinates of the
    mechanism. The rates of these states are accelerations. The same solvers then apply.

    Attributes:
        start: Nodal coordinates from which rotations in space are measured.
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
        """Number of coordinates that move, including the coordinates of the controller."""
        return self.form.size + self.states

    @property
    def unknowns(self) -> int:
        """Number of accelerations, rates of the controller, and multipliers."""
        return self.form.unknowns + self.states

    def regular(self, by_z: Float[Array, "r r"]):
        """Whether every motion of the mechanism carries mass."""
        n = self.form.size
        mechanism_rows = np.r_[:n, self.size : by_z.shape[0]]
        return self.form.regular(by_z[mechanism_rows[:, None], mechanism_rows])

    def _split(self, state: MotionState, z: Float[Array, "r"] | None = None) -> tuple[MotionState, Array, Any, Any]:
        """Mechanism's state, controller's states, mechanism's accelerations and multipliers, controller's rates."""
        n = self.form.size
        mechanism_state = MotionState(state.u[:n], state.w[:n], state.memory)
        if z is None:
            return mechanism_state, state.w[n:], None, None
        return mechanism_state, state.w[n:], jnp.concatenate([z[:n], z[self.size :]]), z[n : self.size]

    def _joined(self, mechanism: Float[Array, "r *k"], controller: Float[Array, "n_z *k"]):
        """Rows of the mechanism's coordinates, of the controller, of the constraints."""
        n = self.form.size
        return jnp.concatenate([mechanism[:n], controller, mechanism[n:]])

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates, with the controller at its start."""
        mechanism_state = self.form.state_of(x, xd, near)
        if not self.states:
            return mechanism_state
        start: Any = self.feedback.start
        u, w = jnp.concatenate([mechanism_state.u, jnp.zeros(self.states)]), jnp.concatenate([mechanism_state.w, start])
        return MotionState(u, w, mechanism_state.memory)

    def measured(
        self,
        t: Float[Array, ""],
        own: MotionState,
        z: Float[Array, "r"] | None = None,
        u: Float[Array, "n_u"] | None = None,
    ):
        """Return the outputs of the mechanism in state `own`; late outputs also need `z` and the inputs `u`."""
        parts = self._early(t, own)
        if self.places.late:
            parts = parts.at[np.array(self.places.late)].set(self._late(t, own, z, u))
        return parts if self.places.read is None else self.places.read @ parts

    def _late(self, t: Float[Array, ""], mechanism_state: MotionState, z: Any, u: Any):
        """Parts of outputs that depend on accelerations and multipliers."""
        kin, sigma, force, at = self._driven(u).forces(t, mechanism_state, z)
        # The rate of omega = 2 Lbar lambda_dot has no other term; a moment is Lbar f / 2.
        turned = {"angular acceleration": at.a, "moment": force / 4}
        moved = {"acceleration": at.a, "deformation acceleration": kin.edd, "stress": sigma, "reaction": force}
        return jnp.stack([self._part(i, at.x, moved, turned) for i in self.places.late])

    def _early(self, t: Float[Array, ""], mechanism_state: MotionState) -> Float[Array, "k"]:
        """Parts of outputs that depend on the state alone; zero for the others."""
        at = self.form.whole(t, mechanism_state.u, mechanism_state.w)
        top, parameters = self.form.topology, self.form.parameters
        e = ed = jnp.zeros(top.n_e)
        if any("deformation" in quantity for quantity in self.places.quantities):
            last_strain = self.form.near(mechanism_state.memory)
            e, ed = jax.jvp(lambda x: deformations(top, parameters, x, last_strain), (at.x,), (at.v,))
        moved = at.x - parameters.reference
        sources = {"position": moved, "velocity": at.v, "deformation": e, "deformation rate": ed}
        late, count = self.places.late, len(self.places.quantities)
        zero, turned = jnp.zeros(()), {"angular velocity": at.v}
        return jnp.array([zero if i in late else self._part(i, at.x, sources, turned) for i in range(count)], float)

    def _part(self, i: int, x: Float[Array, "n_x"], moved: dict[str, Array], turned: dict[str, Array]):
        """A part of an output, from quantities of coordinates and deformations, and of Euler parameters."""
        place, axis = self.places.outputs[i], self.places.axes[i]
        quantity = self.places.quantities[i].removeprefix("local ")
        if quantity in moved:
            return moved[quantity][place]
        euler, local = place + jnp.arange(4), quantity != self.places.quantities[i]
        if quantity == "rotation":
            reference = self.form.parameters.reference[euler]
            return rotation_measured(x[euler], self.start[euler], reference, axis, local)
        return rotation_row(x[euler], axis, local) @ turned[quantity][euler]

    def _rate(self, t: Float[Array, ""], states: Float[Array, "n_z"], y: Float[Array, "n_y"]):
        """Rates of the controller's states."""
        rate: Any = self.feedback.rate
        rates = jnp.atleast_1d(as_reals("The controller's rate", rate(t, states, y), ModelError))
        if rates.shape != states.shape:
            raise ModelError(f"The controller's rate returns shape {rates.shape}, but it has {states.shape[0]} states.")
        return rates

    def _driven(self, u: Float[Array, "n_u"]) -> CoordinatesForm:
        """Equations of the mechanism under given inputs."""
        return driven_by_inputs(self.form, self.places, u)

    def _inputs(self, t: Float[Array, ""], states: Float[Array, "n_z"], y: Float[Array, "n_y"]):
        """Inputs of the mechanism."""
        return jnp.atleast_1d(jnp.asarray(self.feedback.output(t, states, y), float))

    def _closed(
        self,
        t: Float[Array, ""],
        mechanism_state: MotionState,
        states: Float[Array, "n_z"],
        z: Float[Array, "r"] | None,
    ):
        """Return outputs and inputs at one time, solved together if they depend on each other."""
        if not self.places.late:
            y = self.measured(t, mechanism_state)
            return y, self._inputs(t, states, y)

        def seen(u: Float[Array, "n_u"]):
            accelerations = self._driven(u).acceleration(t, mechanism_state)[0] if z is None else z
            y = self.measured(t, mechanism_state, accelerations, u)
            return y, y

        # At given positions and velocities, outputs are linear in the inputs.
        none = jnp.zeros(self.places.inputs)
        if z is not None and not self.places.passes:
            return (y := seen(none)[0]), self._inputs(t, states, y)
        by_input, at_none = jax.jacfwd(seen, has_aux=True)(none)

        def closer(_: Array, u: Float[Array, "n_u"]):
            def excess_of(u: Float[Array, "n_u"]):
                excess = u - self._inputs(t, states, at_none + by_input @ u)
                return excess, excess

            slope, excess = jax.jacfwd(excess_of, has_aux=True)(u)
            return u - factorise(slope).solve(excess)

        u = jax.lax.fori_loop(0, CLOSING, closer, none)
        return at_none + by_input @ u, u

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Return the residual of the mechanism and of the controller."""
        mechanism_state, states, mechanism_z, rates = self._split(state, z)
        y, u = self._closed(t, mechanism_state, states, mechanism_z)
        mechanism = self._driven(u).residual(t, mechanism_state, mechanism_z)
        controller = jnp.asarray(rates) - self._rate(t, states, y) if self.states else rates
        return self._joined(mechanism, controller)

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Return the derivatives of the residual, by the chain rule through outputs and controller."""
        mechanism_state, states, mechanism_z, _ = self._split(state, z)
        n, k = self.form.size, self.states
        y, u = self._closed(t, mechanism_state, states, mechanism_z)
        at = self._driven(u).tangent(t, mechanism_state, mechanism_z)
        by_input = jax.jacfwd(lambda u: self._driven(u).residual(t, mechanism_state, mechanism_z))(u)
        y_by, u_by = self._closed_derivatives(t, mechanism_state, states, mechanism_z, y, u)
        controller = jnp.zeros((0, y_by.shape[1]))
        if k:
            by_states, by_y = jax.jacfwd(lambda z, y: self._rate(t, z, y), (0, 1))(states, y)
            controller = (-by_y @ y_by).at[:, 2 * n : 2 * n + k].add(-by_states)
        rows = self._joined(by_input @ u_by, controller)
        by_u, by_w, by_states, by_late = jnp.split(rows, [n, 2 * n, 2 * n + k], axis=1)
        none, mechanism_rows = jnp.zeros((k, n)), np.r_[:n, n + k : z.shape[0]]
        by_z = jnp.zeros((z.shape[0], z.shape[0])).at[n : n + k, n : n + k].set(jnp.eye(k))
        by_z = by_z.at[mechanism_rows[:, None], mechanism_rows].set(at.by_z)
        return Tangent(
            jnp.pad(by_u + self._joined(at.by_u, none), ((0, 0), (0, k))),
            jnp.concatenate([by_w + self._joined(at.by_w, none), by_states], axis=1),
            by_z.at[:, mechanism_rows].add(by_late) if self.places.late else by_z,
            by_time(self, t, state, z),
        )

    def _closed_derivatives(
        self,
        t: Float[Array, ""],
        mechanism_state: MotionState,
        states: Float[Array, "n_z"],
        z: Float[Array, "r"],
        y: Float[Array, "n_y"],
        u: Float[Array, "n_u"],
    ) -> tuple[Float[Array, "n_y k"], Float[Array, "n_u k"]]:
        """Return derivatives of outputs and inputs by positions, velocities, states, and accelerations if needed."""
        u_by_states, u_by_y = jax.jacfwd(lambda z, y: self._inputs(t, z, y), (0, 1))(states, y)
        y_by, by_input = self._measured_derivatives(t, mechanism_state, z, u)
        first = 2 * self.form.size
        u_by = (u_by_y @ y_by).at[:, first : first + self.states].set(u_by_states)
        if by_input is None:
            return y_by, u_by
        u_by = factorise(jnp.eye(self.places.inputs) - u_by_y @ by_input).solve(u_by)
        return y_by + by_input @ u_by, u_by

    def _measured_derivatives(
        self, t: Float[Array, ""], mechanism_state: MotionState, z: Any = None, u: Any = None
    ) -> tuple[Float[Array, "n_y k"], Float[Array, "n_y n_u"] | None]:
        """Return derivatives of outputs as :meth:`_closed_derivatives`, at given inputs, and by inputs if needed."""

        def early(position: Float[Array, "n"], velocity: Float[Array, "n"]):
            return self._early(t, mechanism_state._replace(u=position, w=velocity))

        # Reverse mode, since there are few outputs.
        by_state = jax.jacrev(early, (0, 1))(mechanism_state.u, mechanism_state.w)
        y_by, by_input = jnp.concatenate([*by_state, jnp.zeros((len(by_state[0]), self.states))], axis=1), None
        if self.places.late:

            def late(u: Float[Array, "n"], w: Float[Array, "n"], z: Float[Array, "r"], inputs: Float[Array, "n_u"]):
                return self._late(t, mechanism_state._replace(u=u, w=w), z, inputs)

            late_rows = np.array(self.places.late)
            *by_state, by_z, by_u = jax.jacfwd(late, (0, 1, 2, 3))(mechanism_state.u, mechanism_state.w, z, u)
            by_state = jnp.concatenate([*by_state, jnp.zeros((len(by_u), self.states)), by_z], axis=1)
            y_by = jnp.pad(y_by, ((0, 0), (0, len(z)))).at[late_rows].set(by_state)
            by_input = jnp.zeros((len(y_by), len(u))).at[late_rows].set(by_u)
        if self.places.read is not None:
            y_by, by_input = self.places.read @ y_by, None if by_input is None else self.places.read @ by_input
        return y_by, by_input

    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, rates of the controller and multipliers, and whether every motion carries mass."""
        mechanism_state, states, _, _ = self._split(state)
        y, u = self._closed(t, mechanism_state, states, None)
        z, regular = self._driven(u).acceleration(t, mechanism_state)
        return self._joined(z, self._rate(t, states, y) if self.states else jnp.zeros(0)), regular

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Return constrained deformations minus their prescribed values."""
        return self.form.gap(t, self._split(state)[0])

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Rate of the mechanism's memory."""
        mechanism_state, _, mechanism_z, _ = self._split(state, z)
        return self.form.rate_of_memory(t, mechanism_state, mechanism_z)

    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Return the state with the mechanism projected onto its constraints; the controller keeps its state."""
        n = self.form.size
        mechanism_state = self.form.settle(t, self._split(state)[0], None if mass is None else mass[:n, :n])
        return MotionState(
            jnp.concatenate([mechanism_state.u, state.u[n:]]),
            jnp.concatenate([mechanism_state.w, state.w[n:]]),
            mechanism_state.memory,
        )

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state, and the controller's inputs."""
        mechanism_state, z, _, _ = self._split(state)
        return self.form.whole_motion(t, mechanism_state)._replace(u=self._closed(t, mechanism_state, z, None)[1])
