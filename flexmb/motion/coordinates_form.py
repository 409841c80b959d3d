"""Equations of motion in all nodal coordinates, with multipliers, and projection onto the constraints."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record
from ..math.indices import TRUSTED, accumulate, put
from ..math.linear import factorise, is_positive_definite
from ..mechanics.deformation import zero_strain
from ..mechanics.extent import coordinate_scales
from ..mechanics.inertia import mass_matrix, uniform_motion
from ..mechanics.loads import LoadFactors, load_stiffness, nodal_forces, without_gravity
from ..mechanics.stress_resultants import (
    element_damping,
    element_stiffness,
    is_nonlinear,
    stress_resultants,
    stress_tangents,
    thermal_deformations,
)
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..numerical_limits import REDUNDANT_COMPLIANCE
from ..statics.configuration import configured
from .discrete_forces import momenta_of_inertia, rates_of_inertia, step_forces
from .drive import Drive, Driven, drive_at
from .element_forces import (
    Kinematics,
    Moving,
    PreparedBlock,
    acting_forces,
    acting_matrices,
    deformations_and_slopes,
    force_derivatives,
    heaviness,
    prepared_blocks,
    strained,
)
from .protocol import InertiaRates, MotionState, Tangent, WholeMotion, by_time

# Newton steps from a configuration one time step away: quadratic convergence leaves round-off.
CORRECTIONS = 3


class AllCoordinates(NamedTuple):
    """All coordinates with their rates, and wanted values and rates of the held deformations."""

    x: Float[Array, "n_x"]
    v: Float[Array, "n_x"]
    a: Float[Array, "n_x"]
    e: Float[Array, "held"]
    ed: Float[Array, "held"]
    edd: Float[Array, "held"]


class CoordinatesForm(Record):
    """Equations of motion in the coordinates that move, with a multiplier for each held deformation.

    Attributes:
        parameters: Numbers, without gravity.
        elements: Elements that deform or carry mass.
        S, S_d: Constant stiffness and damping of the elements.
        falling: Nodal acceleration of free fall [m/s^2].
        free: Indices of the coordinates that move, DEPENDENT and DOF.
        place: Number of each coordinate among these, from 1; 0 for the others.
        sizes: Sizes that make displacements pure numbers: the mechanism's extent, or 1 for rotations.
        held: Indices of the held deformations, FIXED and PRESCRIBED.
        held_place: Number of each deformation among the multipliers, from 1; 0 for the others.
        mobility: Inverse masses of the coordinates that move, by which drift is shared among them.
        driven: What depends on time.
    """

    topology: Topology
    parameters: Parameters
    elements: tuple[PreparedBlock, ...]
    S: Float[Array, "n_e n_e"]
    S_d: Float[Array, "n_e n_e"] | None
    gravity: Float[Array, "axes"] | None
    falling: Float[Array, "n_x"] | None
    free: Array
    place: Int[Array, "n_x"]
    sizes: Float[Array, "n"]
    held: Array
    held_place: Int[Array, "n_e"]
    mobility: Float[Array, "n"]
    driven: tuple[Driven, ...]

    @property
    def states(self) -> int:
        """Number of states of a controller."""
        return 0

    @property
    def size(self) -> int:
        """Number of coordinates that move."""
        return self.free.shape[0]

    @property
    def unknowns(self) -> int:
        """Number of accelerations and multipliers."""
        return self.size + self.held.shape[0]

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates; the memory stores all deformations if an element counts turns."""
        memory = jnp.zeros(0)
        if self.topology.counts_turns:
            guess = zero_strain(self.topology) if near is None else near
            memory = strained(self.elements, x, guess)
        moved = (x - self.parameters.reference)[self.free] / self.sizes
        return MotionState(moved, xd[self.free] / self.sizes, memory)

    def drive(self, t: Float[Array, ""]) -> Drive:
        """Loads and prescribed values at a time."""
        return drive_at(self.topology, self.parameters, self.driven, t)

    def whole(
        self, t: Float[Array, ""], u: Float[Array, "n"], w: Float[Array, "n"], a: Float[Array, "n"]
    ) -> AllCoordinates:
        """All coordinates from displacements over their sizes, and their first and second rates."""
        top = self.topology
        zero_x, zero_m = jnp.zeros(top.n_x), jnp.zeros(self.held.shape[0])

        def prescribed(t: Float[Array, ""]):
            drive = self.drive(t)
            x, e = self.parameters.reference, zero_m
            if drive.x is not None:
                x = accumulate(x, top.x.prescribed, drive.x)
            fixed = top.e.fixed
            if drive.e is not None:
                e = jnp.concatenate([e[: fixed.shape[0]], drive.e])
            if drive.loads.temperature is not None:
                warm = thermal_deformations(top, self.parameters, drive.loads.temperature)[fixed]
                e = jnp.concatenate([warm, e[fixed.shape[0] :]])
            return x, e

        if not any(drive.quantity in ("x", "e", "increment", "temperature") for drive in self.driven):
            (x, e), (v, ed), (acc, edd) = prescribed(t), (zero_x, zero_m), (zero_x, zero_m)
        else:

            def first(t: Float[Array, ""]):
                return jax.jvp(prescribed, (t,), (jnp.ones_like(t),))

            ((x, e), (v, ed)), (_, (acc, edd)) = jax.jvp(first, (t,), (jnp.ones_like(t),))
        moved = self.sizes[:, None] * jnp.stack([u, w, a], axis=1)
        # The compiler makes a loop of a scatter, but not of a gather.
        moved = jnp.concatenate([jnp.zeros((1, 3)), moved]).at[self.place].get(**TRUSTED)
        x, v, acc = (jnp.stack([x, v, acc], axis=1) + moved).T
        return AllCoordinates(x, v, acc, e, ed, edd)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        last_strain = state.memory
        if not last_strain.shape[0]:
            last_strain = strained(self.elements, at.x, zero_strain(self.topology))
        return WholeMotion(at.x, at.v, last_strain, jnp.zeros(0))

    def placed(
        self,
        given: AllCoordinates,
        q: Float[Array, "n_q"],
        x: Float[Array, "n_x"],
        near: Float[Array, "n_e"],
        corrections: int = CORRECTIONS,
    ) -> tuple[Float[Array, "n_x"], Float[Array, "n_e"]]:
        """All coordinates and deformations at degrees of freedom q, by Newton's method from the guess x, near."""
        values = given.x, put(jnp.zeros(self.topology.n_e), self.held, given.e)

        def closer(_: Array, at: tuple[Array, Array]):
            return configured(self.topology, self.parameters, values, q, *at)

        return jax.lax.fori_loop(0, corrections, closer, (x, near))

    def stress_of(self, t: Float[Array, ""], multipliers: Float[Array, "m"]):
        """Stress resultants as a function of deformations and rates, with multipliers at held deformations."""
        drive = self.drive(t)

        def stress(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            sigma = stress_resultants(self.topology, self.parameters, drive.loads, self.S, e, ed)
            if self.S_d is not None:
                sigma = sigma + self.S_d @ ed
            if drive.stress is not None:
                sigma = sigma + drive.stress
            # The compiler makes a loop of a scatter, but not of a gather.
            reactions = jnp.concatenate([jnp.zeros(1), multipliers]).at[self.held_place].get(**TRUSTED)
            return jnp.where(self.held_place > 0, reactions, sigma)

        return stress

    def elastic_stress(self, strain: Float[Array, "n_e"]):
        """Stress resultants of elements of constant stiffness."""
        return self.S @ strain

    def tangents(self, t: Float[Array, ""], e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
        """Derivatives of the stress resultants by deformations and their rates; the latter may be None."""
        return stress_tangents(self.topology, self.parameters, self.drive(t).loads, self.S, self.S_d, e, ed)

    def loose_tangents(self, t: Float[Array, ""], e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
        """:meth:`tangents`, zero for held deformations, whose multipliers are unknowns."""
        is_constrained = (self.held_place > 0)[:, None]
        return [
            None if matrix is None else jnp.where(is_constrained, 0.0, matrix) for matrix in self.tangents(t, e, ed)
        ]

    def tangents_at(
        self, t: Float[Array, ""], x: Float[Array, "n_x"], v: Float[Array, "n_x"], near: Float[Array, "n_e"]
    ):
        """:meth:`tangents` at a state of motion, with zeros in place of None."""
        stiffness, damping = self.S, self.S_d
        if is_nonlinear(self.topology):
            e, jacobian = deformations_and_slopes(self.elements, x, near)
            stiffness, damping = self.tangents(t, e, jacobian @ v)
        return stiffness, jnp.zeros_like(stiffness) if damping is None else damping

    def near(self, memory: Float[Array, "k"]) -> Float[Array, "n_e"]:
        """Deformations at the last accepted state; zero if no turns are counted."""
        return memory if memory.shape[0] else zero_strain(self.topology)

    def forces(
        self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]
    ) -> tuple[Kinematics, Float[Array, "n_e"], Float[Array, "n_x"], AllCoordinates]:
        """Kinematics, stress resultants, nodal forces out of balance, and all coordinates."""
        n = self.size
        at = self.whole(t, state.u, state.w, z[:n])
        stress = self.stress_of(t, z[n:])
        moving = Moving(at.x, at.v, at.a, self.near(state.memory))
        acting = acting_forces(self.elements, moving, self.falling, stress)
        return acting.kinematics, acting.sigma, acting.force - self.applied(t, at.x), at

    def applied(self, t: Float[Array, ""], x: Float[Array, "n_x"]):
        """Nodal forces of all loads except gravity."""
        drive = self.drive(t)
        force = nodal_forces(self.topology, self.parameters, LoadFactors(1.0, drive.increment), x)
        if drive.force is not None:
            force = force + drive.force
        return force if drive.turning is None else force + drive.turning @ x

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance and second rates of the held deformations (THEORY.md 5 and 9 (b), eq. (9.1))."""
        kin, _, force, at = self.forces(t, state, z)
        return jnp.concatenate([force[self.free] * self.sizes, kin.edd[self.held] - at.edd])

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Held deformations minus their wanted values."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        return strained(self.elements, at.x, self.near(state.memory))[self.held] - at.e

    def scaled(self, matrix: Float[Array, "n_x n_x"]):
        """Rows and columns of the coordinates that move, times their sizes."""
        return matrix[self.free][:, self.free] * self.sizes[:, None] * self.sizes

    def columns(self, matrix: Float[Array, "n_e n_x"]):
        """Rows of the held deformations, columns of the coordinates that move times their sizes."""
        return matrix[self.held][:, self.free] * self.sizes

    def system(self, mass: Float[Array, "n n"], rows: Float[Array, "m n"]):
        """:func:`constrained_mass` with the mobility of the mechanism."""
        return constrained_mass(mass, rows, self.mobility)

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of :meth:`residual`, element by element (THEORY.md 6)."""
        n = self.size
        top, parameters = self.topology, self.parameters
        at = self.whole(t, state.u, state.w, z[:n])
        moving = Moving(at.x, at.v, at.a, self.near(state.memory))
        stress = self.stress_of(t, z[n:])
        following = functools.partial(self.loose_tangents, t)
        by_x = force_derivatives(self.elements, moving, self.falling, stress, following)
        drive = self.drive(t)
        k = by_x.by_x - load_stiffness(top, parameters, LoadFactors(1.0, drive.increment), at.x)
        if drive.turning is not None:
            k = k - drive.turning
        by_u = jnp.concatenate([self.scaled(k), self.columns(by_x.edd)])
        by_w = jnp.concatenate([self.scaled(by_x.by_v), 2 * self.columns(by_x.ed)])
        by_t = by_time(self, t, state, z) if self.driven else None
        return Tangent(by_u, by_w, self.system(self.scaled(by_x.mass), self.columns(by_x.e)), by_t)

    def regular(self, by_z: Float[Array, "r r"]):
        """Whether every motion that the constraints allow carries mass."""
        n = self.size
        mass, rows = by_z[:n, :n], by_z[n:, :n]
        heaviest = jnp.max(jnp.abs(mass), initial=0.0)
        return is_positive_definite(mass + heaviest * rows.T @ rows)

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, multipliers, and whether every motion carries mass (THEORY.md 9 (b), eq. (9.2))."""
        n, none = self.size, jnp.zeros(self.held.shape[0])
        at = self.whole(t, state.u, state.w, jnp.zeros(n))
        moving = Moving(at.x, at.v, at.a, self.near(state.memory))
        acting, jacobian, mass = acting_matrices(self.elements, moving, self.falling, self.stress_of(t, none))
        scaled, rows = self.scaled(mass), self.columns(jacobian)
        force = (acting.force - self.applied(t, at.x))[self.free] * self.sizes
        residual = jnp.concatenate([force, acting.kinematics.edd[self.held] - at.edd])
        z, matrix = solved_twice(scaled, rows, self.mobility, residual)
        return z, self.regular(matrix)

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Rates of the deformations if turns are counted."""
        if not state.memory.shape[0]:
            return state.memory
        at = self.whole(t, state.u, state.w, z[: self.size])
        return deformations_and_slopes(self.elements, at.x, state.memory)[1] @ at.v

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """State brought back onto D = e and D_x v = e_dot (THEORY.md 9, eq. (9.3)), by a mass or the undeformed one."""
        u, w = state.u, state.w
        last_strain = self.near(state.memory)
        zero = jnp.zeros_like(u)
        if self.held.shape[0]:

            def excess(u: Float[Array, "n"], w: Float[Array, "n"]):
                at = self.whole(t, u, w, zero)
                e, jacobian = deformations_and_slopes(self.elements, at.x, last_strain)
                of_both = jnp.stack([e[self.held] - at.e, (jacobian @ at.v)[self.held] - at.ed], axis=1)
                return of_both, self.columns(jacobian)

            u, w = onto_constraints(u, w, excess, mass, self.mobility)
        memory = state.memory
        if memory.shape[0]:
            memory = strained(self.elements, self.whole(t, u, w, zero).x, memory)
        return MotionState(u, w, memory)

    def inertia_rates(self, t: Float[Array, ""], state: MotionState) -> InertiaRates:
        """Rates of the inertia vectors s(x), of each block of elements."""
        at = self.whole(t, state.u, state.w, jnp.zeros(self.size))
        return rates_of_inertia(self.elements, at.x, at.v, self.near(state.memory))

    def forces_over_step(
        self,
        times: tuple[Any, Any],
        states: tuple[MotionState, MotionState],
        rates: InertiaRates,
        multipliers: Float[Array, "m"],
    ) -> tuple[Float[Array, "n"], InertiaRates]:
        """Mean forces out of balance over a step, and the rates of the inertia vectors s(x) at its end."""
        (t0, t1), zero = times, jnp.zeros(self.size)
        begin, end = (self.whole(t, at.u, zero, zero).x for t, at in zip(times, states, strict=True))
        middle, last_strain = (t0 + t1) / 2, self.near(states[0].memory)
        stress = self.stress_of(middle, multipliers)
        sizes = put(jnp.ones(self.topology.n_x), self.free, self.sizes)
        force, after = step_forces(
            self.elements, (begin, end), t1 - t0, rates, self.falling, last_strain, sizes, stress
        )
        force = force - self.applied(middle, (begin + end) / 2)
        return force[self.free] * self.sizes, after

    def velocities_of(self, t: Float[Array, ""], state: MotionState, rates: InertiaRates) -> Float[Array, "n"]:
        """Allowed velocities closest to given rates of the inertia vectors, in the norm of the kinetic energy."""
        n, last_strain = self.size, self.near(state.memory)
        at = self.whole(t, state.u, jnp.zeros(n), jnp.zeros(n))
        _, jacobian = deformations_and_slopes(self.elements, at.x, last_strain)
        # The rates include driven coordinates, which are known.
        driven = rates_of_inertia(self.elements, at.x, at.v, last_strain)
        undriven = jax.tree.map(lambda rate, known: rate - known, rates, driven)
        momentum = momenta_of_inertia(self.elements, at.x, last_strain, undriven)[self.free] * self.sizes
        mass = self.scaled(mass_matrix(self.topology, self.parameters, at.x))
        right = jnp.concatenate([momentum, at.ed - (jacobian @ at.v)[self.held]])
        return factorise(self.system(mass, self.columns(jacobian))).solve(right)[:n]


def constrained_mass(mass: Float[Array, "n n"], rows: Float[Array, "m n"], mobility: Float[Array, "n"]):
    """Mass matrix with constraints, kept regular for redundant ones (THEORY.md 9 (b), eq. (9.2))."""
    corner = -REDUNDANT_COMPLIANCE * jnp.diag(rows**2 @ mobility)
    return jnp.block([[mass, rows.T], [rows, corner]]) if rows.shape[0] else mass


def solved_twice(
    mass: Float[Array, "n n"], rows: Float[Array, "m n"], mobility: Float[Array, "n"], residual: Float[Array, "r"]
) -> tuple[Float[Array, "r"], Float[Array, "r r"]]:
    """Accelerations and multipliers for a residual at zero ones, and the matrix of :func:`constrained_mass`."""
    n, matrix = mass.shape[0], constrained_mass(mass, rows, mobility)
    factors = factorise(matrix)
    z = factors.solve(-residual)
    # The second step removes the error that the corner of redundant constraints causes in the others.
    left_side = jnp.concatenate([mass @ z[:n] + rows.T @ z[n:], rows @ z[:n]])
    return z - factors.solve(residual + left_side), matrix


def onto_constraints(
    u: Float[Array, "n"],
    w: Float[Array, "n"],
    excess: Callable[[Array, Array], tuple[Float[Array, "m 2"], Float[Array, "m n"]]],
    mass: Float[Array, "n n"] | None,
    mobility: Float[Array, "n"],
) -> tuple[Float[Array, "n"], Float[Array, "n"]]:
    """Positions and velocities that satisfy the constraints, by the least change in the norm of the mass.

    `excess` returns the errors of held deformations and rates, and their derivatives.
    """
    n, heavy = len(u), jnp.diag(1 / mobility) if mass is None else mass

    def corrected(_: Array, moving: tuple[Array, Array]):
        missed, rows = excess(*moving)
        right = jnp.concatenate([jnp.zeros((n, 2)), missed])
        change = factorise(constrained_mass(heavy, rows, mobility)).solve(right)
        return moving[0] - change[:n, 0], moving[1] - change[:n, 1]

    # The second step removes the error of the first, which is of second order.
    return jax.lax.fori_loop(0, 2, corrected, (u, w))


def numbers_among(size: int, chosen: Array) -> Int[Array, "size"]:
    """Number of each of many things among the chosen ones, from 1; 0 for the others."""
    return put(jnp.zeros(size, int), chosen, jnp.arange(1, chosen.shape[0] + 1))


def coordinates_form(
    topology: Topology, parameters: Parameters, driven: tuple[Driven, ...] = (), *, whole: bool = True
) -> CoordinatesForm:
    """Equations of motion of a model in all its coordinates; unless `whole`, without elements and mobility."""
    gravity = parameters.loads.gravity
    damped = any("damping" in block.companions for block in topology.blocks)
    free = topology.x.free
    elements, mass = (), jnp.ones(free.shape[0])
    if whole:
        elements = prepared_blocks(topology, parameters)
        mass = heaviness(elements, parameters.reference, zero_strain(topology))[free]
    sizes = jax.lax.stop_gradient(coordinate_scales(topology, parameters))[free]
    mass = jax.lax.stop_gradient(mass) * sizes**2
    return CoordinatesForm(
        topology,
        without_gravity(parameters),
        elements,
        element_stiffness(topology, parameters),
        element_damping(topology, parameters) if damped else None,
        gravity,
        None if gravity is None else uniform_motion(topology, gravity),
        free,
        numbers_among(topology.n_x, free),
        sizes,
        topology.e.held,
        numbers_among(topology.n_e, topology.e.held),
        1.0 / jnp.where(mass > 0, mass, jnp.max(mass)),
        driven,
    )
