"""Equations of motion in all nodal coordinates, with multipliers, and projection onto the constraints."""

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
from ..mechanics.inertia import uniform_motion
from ..mechanics.loads import LoadFactors, load_stiffness, nodal_forces, without_gravity
from ..mechanics.stress_resultants import (
    element_damping,
    element_stiffness,
    is_nonlinear,
    stress_resultants,
    stress_tangents,
    thermal_deformations,
)
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import REDUNDANT_COMPLIANCE
from ..statics.configuration import configured
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
    own_tangents,
    prepared_blocks,
    strained,
)
from .protocol import MotionState, Tangent, WholeMotion, by_time

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
            memory = self.strained(x, guess)
        moved = (x - self.parameters.reference)[self.free] / self.sizes
        return MotionState(moved, xd[self.free] / self.sizes, memory)

    def drive(self, t: Float[Array, ""]) -> Drive:
        """Loads and prescribed values at a time."""
        return drive_at(self.topology, self.parameters, self.driven, t)

    def whole(self, t: Float[Array, ""], u: Any = None, w: Any = None, a: Any = None) -> AllCoordinates:
        """All coordinates from displacements over their sizes, and their rates and second rates; None for zeros."""
        top = self.topology
        zero_x, zero_m = jnp.zeros(top.n_x), jnp.zeros(self.held.shape[0])

        def prescribed(t: Float[Array, ""]):
            drive = self.drive(t)
            x, e = self.parameters.reference, jnp.zeros(top.n_e)
            if drive.x is not None:
                x = accumulate(x, top.x.prescribed, drive.x)
            if drive.loads.temperature is not None:
                warm = thermal_deformations(top, self.parameters, drive.loads.temperature)
                e = put(e, top.e.fixed, warm[top.e.fixed])
            if drive.e is not None:
                e = put(e, top.e.prescribed, drive.e)
            return x, e[self.held]

        if not any(drive.quantity in ("x", "e", "increment", "temperature") for drive in self.driven):
            (x, e), (v, ed), (acc, edd) = prescribed(t), (zero_x, zero_m), (zero_x, zero_m)
        else:

            def first(t: Float[Array, ""]):
                return jax.jvp(prescribed, (t,), (jnp.ones_like(t),))

            ((x, e), (v, ed)), (_, (acc, edd)) = jax.jvp(first, (t,), (jnp.ones_like(t),))
        rates = [jnp.zeros(self.size) if rate is None else rate for rate in (u, w, a)]
        moved = self.sizes[:, None] * jnp.stack(rates, axis=1)
        # The compiler makes a loop of a scatter, but not of a gather.
        moved = jnp.concatenate([jnp.zeros((1, 3)), moved]).at[self.place].get(**TRUSTED)
        x, v, acc = (jnp.stack([x, v, acc], axis=1) + moved).T
        return AllCoordinates(x, v, acc, e, ed, edd)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        at, last_strain = self.whole(t, state.u, state.w), state.memory
        if not last_strain.shape[0]:
            last_strain = self.strained(at.x, zero_strain(self.topology))
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

    def strained(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
        """Deformations."""
        return strained(self.elements, x, near)

    def deformed(self, x: Float[Array, "n_x"], near: Float[Array, "n_e"]):
        """Deformations and their derivatives by the nodal coordinates."""
        return deformations_and_slopes(self.elements, x, near)

    def near(self, memory: Float[Array, "k"]) -> Float[Array, "n_e"]:
        """Deformations at the last accepted state; zero if no turns are counted."""
        return memory if memory.shape[0] else zero_strain(self.topology)

    def moving(
        self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]
    ) -> tuple[AllCoordinates, Moving, Callable[..., Any]]:
        """All coordinates, the same as a state of motion, and :meth:`stress_of`."""
        at = self.whole(t, state.u, state.w, z[: self.size])
        return at, Moving(at.x, at.v, at.a, self.near(state.memory)), self.stress_of(t, z[self.size :])

    def forces(
        self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]
    ) -> tuple[Kinematics, Float[Array, "n_e"], Float[Array, "n_x"], AllCoordinates]:
        """Kinematics, stress resultants, nodal forces out of balance, and all coordinates."""
        at, moving, stress = self.moving(t, state, z)
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
        at = self.whole(t, state.u, state.w)
        return self.strained(at.x, self.near(state.memory))[self.held] - at.e

    def scaled(self, matrix: Float[Array, "n_x n_x"]):
        """Rows and columns of the coordinates that move, times their sizes."""
        return matrix[self.free][:, self.free] * self.sizes[:, None] * self.sizes

    def rows_of(self, t: Float[Array, ""], u: Float[Array, "n"], jacobian: Float[Array, "n_e n_x"]):
        """Derivatives of the held deformations by what moves."""
        return self.columns(jacobian)

    def columns(self, matrix: Float[Array, "n_e n_x"]):
        """Rows of the held deformations, columns of the coordinates that move times their sizes."""
        return matrix[self.held][:, self.free] * self.sizes

    def system(self, mass: Float[Array, "n n"], rows: Float[Array, "m n"]):
        """Mass matrix with constraints, kept regular for redundant ones (THEORY.md 9 (b), eq. (9.2))."""
        corner = -REDUNDANT_COMPLIANCE * jnp.diag(rows**2 @ self.mobility)
        return jnp.block([[mass, rows.T], [rows, corner]]) if rows.shape[0] else mass

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of :meth:`residual`, element by element (THEORY.md 6)."""
        at, moving, stress = self.moving(t, state, z)

        def following(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            return own_tangents(self.elements, self.loose_tangents(t, e, ed))

        by_x = force_derivatives(self.elements, moving, self.falling, stress, following)
        loads = self.by_loads(t, at.x)
        k = by_x.by_x if loads is None else by_x.by_x - loads
        by_u = jnp.concatenate([self.scaled(k), self.columns(by_x.edd)])
        by_w = jnp.concatenate([self.scaled(by_x.by_v), 2 * self.columns(by_x.ed)])
        by_t = by_time(self, t, state, z) if self.driven else None
        return Tangent(by_u, by_w, self.system(self.scaled(by_x.mass), self.columns(by_x.e)), by_t)

    def by_loads(self, t: Float[Array, ""], x: Float[Array, "n_x"]):
        """Derivative of :meth:`applied` by the nodal coordinates; None if no load depends on them."""
        drive, top, parameters = self.drive(t), self.topology, self.parameters
        if parameters.increment is None and all(block.element.force is None for block in top.blocks):
            return drive.turning
        matrix = load_stiffness(top, parameters, LoadFactors(1.0, drive.increment), x)
        return matrix if drive.turning is None else matrix + drive.turning

    def unaccelerated(
        self, t: Float[Array, ""], state: MotionState
    ) -> tuple[Float[Array, "r"], Float[Array, "n n"], Float[Array, "m n"]]:
        """Residual at zero accelerations and multipliers, mass matrix, derivatives of the held deformations."""
        at, moving, stress = self.moving(t, state, jnp.zeros(self.unknowns))
        acting, jacobian, mass = acting_matrices(self.elements, moving, self.falling, stress)
        force = (acting.force - self.applied(t, at.x))[self.free] * self.sizes
        residual = jnp.concatenate([force, acting.kinematics.edd[self.held] - at.edd])
        return residual, self.scaled(mass), self.columns(jacobian)

    def regular(self, by_z: Float[Array, "r r"]):
        """Whether every motion that the constraints allow carries mass."""
        n = self.size
        mass, rows = by_z[:n, :n], by_z[n:, :n]
        heaviest = jnp.max(jnp.abs(mass), initial=0.0)
        return is_positive_definite(mass + heaviest * rows.T @ rows)

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, multipliers, and whether every motion carries mass (THEORY.md 9 (b), eq. (9.2))."""
        n = self.size
        residual, mass, rows = self.unaccelerated(t, state)
        matrix = self.system(mass, rows)
        factors = factorise(matrix)
        z = factors.solve(-residual)
        # The second step removes the error that the corner of redundant constraints causes in the others.
        left_side = jnp.concatenate([mass @ z[:n] + rows.T @ z[n:], rows @ z[:n]])
        return z - factors.solve(residual + left_side), self.regular(matrix)

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Rates of the deformations if turns are counted."""
        if not state.memory.shape[0]:
            return state.memory
        at = self.whole(t, state.u, state.w)
        return self.deformed(at.x, state.memory)[1] @ at.v

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """State brought back onto D = e and D_x v = e_dot (THEORY.md 9, eq. (9.3)), by a mass or the undeformed one."""
        u, w, memory = state
        n, last_strain = self.size, self.near(memory)
        if self.held.shape[0]:
            heavy = jnp.diag(1 / self.mobility) if mass is None else mass

            def corrected(_: Array, moving: tuple[Array, Array]):
                at = self.whole(t, *moving)
                e, jacobian = self.deformed(at.x, last_strain)
                missed = jnp.stack([e[self.held] - at.e, (jacobian @ at.v)[self.held] - at.ed], axis=1)
                right = jnp.concatenate([jnp.zeros((n, 2)), missed])
                rows = self.rows_of(t, moving[0], jacobian)
                change = factorise(self.system(heavy, rows)).solve(right)
                return moving[0] - change[:n, 0], moving[1] - change[:n, 1]

            # The second step removes the error of the first, which is of second order.
            u, w = jax.lax.fori_loop(0, 2, corrected, (u, w))
        if memory.shape[0]:
            memory = self.strained(self.whole(t, u).x, memory)
        return MotionState(u, w, memory)


def all_coordinates(equations: Any) -> CoordinatesForm | None:
    """Equations in all coordinates, also of other forms around such equations; None for anything else."""
    form = equations if isinstance(equations, CoordinatesForm) else getattr(equations, "form", None)
    return form if isinstance(form, CoordinatesForm) else None


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
