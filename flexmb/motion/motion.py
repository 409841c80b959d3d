"""Result of a simulation: positions and velocities at the given times, and quantities that follow from them."""

from __future__ import annotations

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_number, check_whole, computed, is_concrete
from ..compilation.compile import jit_beside_options
from ..compilation.record import Record, static
from ..display import (
    Labelled,
    Result,
    States,
    Summary,
    course,
    largest,
    listed,
    short,
    span,
    unit_of_force,
    unit_of_rate,
)
from ..errors import ModelError
from ..linear.linearize import Linearization, Stressed
from ..math.indices import put
from ..mechanics.inertia import InertialLoad, kinetic_energy, work_of_weight
from ..mechanics.sparse_order import SparseOrder, order_of
from ..mechanics.stress_resultants import free_deformations, is_nonlinear, nonlinear_energy, strain_of
from ..model.by_name import ByName
from ..model.model import Labels, Model
from ..numerical_limits import SAME_TIME
from ..questions.question import Along
from ..results import outcome_text
from .chain_form import chain_form
from .coordinates_form import coordinates_form
from .drive import Driven
from .element_forces import Moving
from .loop import under_inputs
from .moving_matrices import moving_matrices


class Motion(ByName, Along, Labelled, Record):
    """Motion of a mechanism at the given times.

    Accelerations, stress resultants and forces are not stored: :meth:`observe` computes them for each question. To
    compute them only once, call ``seen = motion.observe()`` and ask ``seen``.

    Attributes:
        t: Times, (n_t,) [s].
        x: Nodal coordinates, (n_t, n_x) [m, rad, -].
        xd: Their velocities, (n_t, n_x) [1/s].
        near: Deformations, (n_t, n_e) [m, rad]; angles are counted past full turns.
        u: Inputs from a controller, (n_t, n_u), (n_t, 0) without a controller [N, N m].
        steps: Number of time steps, including rejected steps.
        result: Code of RESULTS.
        driven: Functions of time of the simulation.
        model: Mechanism.
        form: Form of the equations.
        solver: Name of the solver.
        energy_error: Greatest energy gained or lost without work by a force, divided by the greatest kinetic plus
            elastic energy, () [-]. NaN if not computed: for ``form="chain"``, fixed steps, your own ``controller``, or
            zero energy. With a ``solver`` other than ``Rodas5P()``, flexmb computes it only if elements have laws and
            there is neither a prescribed motion nor a controller.
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
    energy_error: Float[Array, ""] | float = np.nan
    one_axis = "t"

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    @property
    def e(self) -> Float[Array, "n_t n_e"]:
        """Deformations, (n_t, n_e) [m, rad]."""
        return self.near

    @property
    def xdd(self) -> Float[Array, "n_t n_x"]:
        """Accelerations by :meth:`observe`, (n_t, n_x) [1/s^2]."""
        return self.observe().xdd

    @property
    def sigma(self) -> Float[Array, "n_t n_e"]:
        """Stress resultants by :meth:`observe`, (n_t, n_e) [N, N m]."""
        return self.observe().sigma

    @property
    def reactions(self) -> Float[Array, "n_t n_x"]:
        """Forces of the supports by :meth:`observe`, (n_t, n_x) [N, N m]."""
        return self.observe().reactions

    @property
    def external(self) -> Float[Array, "n_t n_x"]:
        """Forces from outside by :meth:`observe`, (n_t, n_x) [N, N m]."""
        return self.observe().external

    def until(self, count: int) -> Motion:
        """Return the part of the motion up to one of its times.

        Args:
            count: Number of times of this part.

        Raises:
            ValueError: There are fewer times.
        """
        if not 0 <= check_whole("count", count) <= self.t.shape[0]:
            raise ValueError(f"Argument `count` must be 0 to {self.t.shape[0]}, the number of times, but is {count}.")
        parts = {name: getattr(self, name)[:count] for name in ("t", "x", "xd", "near", "u")}
        return dataclasses.replace(self, **parts)

    def observe(self) -> Observed:
        """Return accelerations, deformations, stress resultants, reactions, energies and power."""
        model = self.model
        order = order_of(model.topology) if self.form == "chain" else None
        rows = (self.t, self.x, self.xd, self.near, self.u)
        observed = _observe(model.without_names(), self.driven, *rows, order)
        return dataclasses.replace(observed, labels=model.labels)

    def linearizations(self) -> Linearization:
        """Return the linearised equations at all times; see :func:`flexmb.motion.linearize_motion`."""
        return self._linearized_at(slice(None))

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization:
        """Return the linearised equations at one time.

        Args:
            step: Number of the time, from 0; by default the last.
            time: The time [s], instead of ``step``.

        Raises:
            IndexError: There are fewer times.
            ValueError: `time` is none of the times, or both are given.
        """
        number = self.number_of(step, time)
        return self._linearized_at(slice(number, number + 1)).at_time(0)

    def number_of(self, step: int | None = None, time: float | None = None) -> int:
        """Return the number of a state, from 0.

        Args:
            step: The number, negative from the end; by default the last.
            time: Time of the state [s], instead of ``step``.

        Raises:
            IndexError: There are fewer times.
            ValueError: `time` is none of the times, or both are given.
        """
        times = np.asarray(self.t)
        if time is not None:
            check_number("time", time)
            if step is not None:
                raise ValueError("Arguments `step` and `time` both choose a state. Give one of them.")
            nearest = np.argsort(np.abs(times - time), kind="stable")[:2]
            if len(nearest) and abs(times[nearest[0]] - time) <= SAME_TIME * np.max(np.abs(times)):
                return int(nearest[0])
            raise ValueError(
                f"Argument `time` must be one of the {len(times)} times of the motion, but is {short(time)} s. The"
                f" nearest are {listed(np.sort(times[nearest]), 's')}. Simulate with that time among them."
            )
        count, chosen = len(times), -1 if step is None else check_whole("step", step)
        if not -count <= chosen < count:
            raise IndexError(f"There are {count} times, numbered from 0. Number {chosen} is none of them.")
        return chosen % count

    def stressed(self) -> Stressed:
        """Return the data from which stress at all times is computed.

        Raises:
            ModelError: The motion did not reach its end.
        """
        self._refuse_not_reached(slice(None))
        seen, gravity = self.observe(), self.model.parameters.loads.gravity
        count = self.t.shape[0]
        free_fall = None if gravity is None else jnp.broadcast_to(gravity, (count, *gravity.shape))
        return Stressed(seen.x, seen.sigma, InertialLoad(free_fall, seen.xd, seen.xdd), self.near)

    def _refuse_not_reached(self, which: slice) -> None:
        """Refuse times that the motion did not reach, because an event or a failure ended it."""
        if is_concrete((self.t, self.x)):
            reached = np.all(np.isfinite(np.asarray(self.x)), axis=1)
            missing, count = np.arange(len(reached))[which][~reached[which]], int(np.sum(reached))
            if len(missing):
                raise ModelError(
                    f"The motion did not reach t = {short(np.asarray(self.t)[missing[0]])} s. It has {count} of"
                    f" {len(reached)} states. Choose one of these, or give motion.until({count})."
                )

    def _linearized_at(self, which: slice) -> Linearization:
        self._refuse_not_reached(which)
        model, rows = self.model, (part[which] for part in (self.t, self.x, self.xd, self.near, self.u))
        return Linearization(_along(model.without_names(), self.driven, *rows), model)

    def states(self) -> States:
        """Return the states over time."""
        return States(self.model, self.x, "motion", self.t, "time [s]")

    def summary(self) -> Summary:
        """Return outcome, times and solver."""
        t = np.asarray(self.t)
        rows = {
            "result": outcome_text(self.result),
            "time": f"{short(t[0])} to {short(t[-1])} s, {len(t)} times" if len(t) else "none",
            "steps": str(int(self.steps)),
            "solver": f"{self.solver}, {self.form}",
        }
        return Summary(f"Motion: {course(self.states())}", rows, "history")


class Observed(ByName, Result, Record):
    """Quantities that follow from a motion, at all times. Methods by name are the same as for Motion.

    Attributes:
        x: Nodal coordinates, (n_t, n_x) [m, rad, -].
        xd: Their velocities, (n_t, n_x) [1/s].
        xdd: Accelerations, (n_t, n_x) [1/s^2].
        e: Deformations, (n_t, n_e) [m, rad].
        ed: Their rates, (n_t, n_e) [m/s, rad/s].
        sigma: Stress resultants, including multipliers, (n_t, n_e) [N, N m].
        reactions: Forces of the supports on the mechanism, (n_t, n_x) [N, N m].
        external: Loads except weight, plus reactions, (n_t, n_x) [N, N m].
        kinetic: Kinetic energy, (n_t,) [J].
        elastic: Elastic energy, (n_t,) [J].
        potential: Energy of constant forces and gravity, zero in the undeformed mechanism, (n_t,) [J].
        power: Power of all other loads, of prescribed motion, thermal expansion and scaled prestress, minus the power
            of dampers and laws, (n_t,) [W].
        labels: Names.
    """

    x: Float[Array, "n_t n_x"]
    xd: Float[Array, "n_t n_x"]
    xdd: Float[Array, "n_t n_x"]
    e: Float[Array, "n_t n_e"]
    ed: Float[Array, "n_t n_e"]
    sigma: Float[Array, "n_t n_e"]
    reactions: Float[Array, "n_t n_x"]
    external: Float[Array, "n_t n_x"]
    kinetic: Float[Array, "n_t"]
    elastic: Float[Array, "n_t"]
    potential: Float[Array, "n_t"]
    power: Float[Array, "n_t"]
    labels: Labels = static()
    one_axis = "kinetic"

    def summary(self) -> Summary:
        """Return extremes over time with their names, and the energies."""
        entries = self.labels.x
        rows = {"times": str(len(self.kinetic))}
        for name, values, names, unit in (
            ("largest velocity", self.xd, entries, unit_of_rate),
            ("largest acceleration", self.xdd, entries, lambda entry: f"{unit_of_rate(entry)}²"),
            ("largest reaction", self.reactions, entries, unit_of_force),
            ("largest stress resultant", self.sigma, self.labels.e, "[N, N m]"),
        ):
            extreme = np.asarray(values)
            if len(extreme):
                extreme = np.take_along_axis(extreme, np.argmax(np.abs(extreme), axis=0)[None], axis=0)[0]
            rows[name] = largest(extreme, names, unit)
        for name in ("kinetic", "elastic", "potential"):
            rows[f"{name} energy"] = span(getattr(self, name), "J")
        return Summary("Observed: quantities that follow from a motion", rows)

    @property
    def energy(self) -> Float[Array, "n_t"]:
        """Total energy, (n_t,) [J]; its rate is ``power``."""
        return computed(lambda _, *parts: sum(parts), self.kinetic, self.elastic, self.potential)


@jit_beside_options
def _along(
    model: Model,
    driven: tuple[Driven, ...],
    t: Float[Array, "n_t"],
    x: Float[Array, "n_t n_x"],
    xd: Float[Array, "n_t n_x"],
    near: Float[Array, "n_t n_e"],
    u: Float[Array, "n_t n_u"],
):
    """Linearised equations at every time, under the inputs at that time."""
    without_inputs = coordinates_form(model.topology, model.parameters, driven)

    def at_one_time(at: tuple[Array, ...]):
        t, x, xd, last_strain, u = at
        form = under_inputs(model, without_inputs, u)
        state = form.state_of(x, xd, last_strain)
        z, _ = form.acceleration(t, state)
        coordinates = form.whole(t, state.u, state.w, z[: form.size])
        return moving_matrices(form, t, Moving(coordinates.x, coordinates.v, coordinates.a, last_strain))[0]

    return jax.lax.map(at_one_time, (t, x, xd, near, u))


@jit_beside_options
def _observe(
    model: Model,
    driven: tuple[Driven, ...],
    t: Float[Array, "n_t"],
    x: Float[Array, "n_t n_x"],
    xd: Float[Array, "n_t n_x"],
    near: Float[Array, "n_t n_e"],
    u: Float[Array, "n_t n_u"],
    order: SparseOrder | None,
):
    topology, parameters = model.topology, model.parameters
    undriven = coordinates_form(topology, parameters, driven)
    chain = None if order is None else chain_form(model, driven, order)
    gravity = parameters.loads.gravity

    def at_one_time(at: tuple[Array, ...]):
        t, x, xd, last_strain, u = at
        form = under_inputs(model, undriven, u)
        state = form.state_of(x, xd, last_strain)
        balance = form if chain is None else chain
        z, _ = balance.acceleration(t, state)
        kin, sigma, force, coordinates = balance.forces(t, state, z)
        drive = form.drive(t)
        moving = coordinates.x - parameters.reference
        constant = parameters.loads.force
        potential = jnp.array(0.0) if constant is None else -constant @ moving
        if gravity is not None:
            potential = potential - work_of_weight(topology, parameters, coordinates.x, gravity)
        stored = strain_of(topology, parameters, drive.loads, kin.e)
        # Stress from stored energy, and this energy.
        conservative = (undriven if chain is None else chain).elastic_stress(stored)
        elastic = 0.5 * stored @ conservative
        if is_nonlinear(topology):
            energy, stress = jax.value_and_grad(lambda e: nonlinear_energy(topology, parameters, e))(stored)
            conservative, elastic = conservative + stress, elastic + energy
        if drive.loads.prestress is not None:
            conservative, elastic = conservative + drive.loads.prestress, elastic + drive.loads.prestress @ stored
        # All forces except inertia, springs, constant forces and gravity.
        applied = form.applied(t, coordinates.x)
        other = applied - (0.0 if constant is None else constant)
        is_constrained = put(put(jnp.zeros(topology.n_x), topology.x.fixed, 1.0), topology.x.prescribed, 1.0)
        reactions = jnp.where(is_constrained == 1.0, force, 0.0)
        power = (other + reactions) @ coordinates.v - (sigma - conservative) @ kin.ed
        if drive.loads.temperature is not None:
            # A change of temperature does the work of the stress.
            def free(t: Float[Array, ""]):
                return free_deformations(topology, parameters, form.drive(t).loads)

            power = power - conservative @ jax.jvp(free, (t,), (jnp.ones_like(t),))[1]
        if drive.loads.prestress is not None and any(drive.quantity == "increment" for drive in driven):
            # Stress that grows in a strained element stores energy without motion.
            grown = jax.jvp(lambda t: form.drive(t).loads.prestress, (t,), (jnp.ones_like(t),))[1]
            power = power + grown @ stored
        kinetic = kinetic_energy(topology, parameters, coordinates.x, coordinates.v)
        seen = coordinates.x, coordinates.v, coordinates.a, kin.e, kin.ed, sigma, reactions, applied + reactions
        return Observed(*seen, kinetic, elastic, potential, power, model.labels)

    return jax.lax.map(at_one_time, (t, x, xd, near, u))
