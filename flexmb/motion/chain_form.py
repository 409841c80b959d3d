"""Equations of motion of long chains and nets: all nodal coordinates and multipliers, with matrices element by element.

No array is of the size of the mechanism squared. :mod:`flexmb.mechanics.levels` assembles and factorises chains,
:mod:`flexmb.mechanics.sparse_order` everything else.
"""

import dataclasses
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record
from ..math.indices import put
from ..mechanics.blocks import scatter_vector
from ..mechanics.levels import Levels, bordered, moving_blocks
from ..mechanics.sparse_order import SparseOrder, solution
from ..mechanics.stress_resultants import is_nonlinear, stiffness_pieces, strain_of
from ..model.model import Model
from ..model.topology import Topology
from ..numerical_limits import CHAIN_RESIDUAL, REDUNDANT_COMPLIANCE
from .coordinates_form import AllCoordinates, CoordinatesForm, coordinates_form
from .drive import MOMENTS, Driven
from .element_forces import (
    Kinematics,
    Moving,
    PreparedBlock,
    acting_forces,
    deformed_elements,
    derivatives_of_elements,
    strained,
)
from .protocol import MotionState, WholeMotion


def obstacle(topology: Topology, driven: tuple[Driven, ...]) -> str | None:
    """Sentence on the first property of a mechanism that this form does not cover, or None."""
    if is_nonlinear(topology):
        return "an element states an energy, a dissipation or a law of its own"
    if topology.counts_turns:
        return "an element counts the turns of an angle"
    for block in topology.blocks:
        if block.element.force is not None:
            return f"'{block.element.name}' is a load that follows the motion"
        if "deformation" not in block.companions and not {"stiffness", "damping"}.isdisjoint(block.companions):
            return f"stiffness and deformations of '{block.element.name}' are computed apart"
    if any(drive.quantity in MOMENTS for drive in driven):
        return "a moment in space depends on time"
    return None


class ElementTangent(NamedTuple):
    """:class:`.protocol.Tangent` element by element: coordinates of an element, then its held deformations."""

    order: Levels | SparseOrder
    by_z: tuple[Float[Array, "elements k k"], ...]
    by_w: tuple[Float[Array, "elements k k"], ...]
    by_u: tuple[Float[Array, "elements k k"], ...]
    by_t: Float[Array, "r"] | None
    held: int

    @property
    def mass(self) -> None:
        """None: no dense mass matrix is formed."""
        return None

    def solver(self, step: Any) -> Callable[[Float[Array, "r"]], Float[Array, "r"]]:
        """Function that solves with R_z + step R_w + step^2 R_u."""
        order: Any = self.order
        pieces = tuple(z + step * (w + step * u) for z, w, u in zip(self.by_z, self.by_w, self.by_u, strict=True))
        factors = order.factors(pieces)
        return lambda right: solution(order, factors, pieces, jnp.zeros_like(right), right)

    def product(self, w: Float[Array, "n"], u: Float[Array, "n"]) -> Float[Array, "r"]:
        """R_w w + R_u u, (n + m,)."""
        none = jnp.zeros(self.held)
        return self.order.product(self.by_w, jnp.append(w, none)) + self.order.product(self.by_u, jnp.append(u, none))


class ChainForm(Record):
    """Equations of motion of a chain, with the methods of :class:`CoordinatesForm`."""

    form: CoordinatesForm
    order: Levels | SparseOrder
    stiffness: tuple[Float[Array, "elements d d"] | None, ...]
    damping: tuple[Float[Array, "elements d d"] | None, ...]

    @property
    def states(self) -> int:
        """Number of states of a controller."""
        return 0

    @property
    def size(self) -> int:
        """Number of coordinates that move."""
        return self.form.size

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates."""
        return self.form.state_of(x, xd, near)

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        return self.form.whole_motion(t, state)

    def stress_of(self, t: Float[Array, ""], multipliers: Float[Array, "m"]):
        """Stress resultants as a function of deformations and rates, with multipliers at held deformations."""
        form = self.form
        drive = form.drive(t)

        def stress(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            strain = strain_of(form.topology, form.parameters, drive.loads, e)
            pieces = self._pulled(self.stiffness, strain) + self._pulled(self.damping, ed)
            sigma = scatter_vector(e.shape[0], pieces)
            for more in (drive.loads.prestress, drive.stress):
                sigma = sigma if more is None else sigma + more
            return put(sigma, form.held, multipliers)

        return stress

    def _pulled(self, matrices: tuple[Array | None, ...], rates: Float[Array, "n_e"]):
        blocks = zip(self.form.elements, matrices, strict=True)
        return [(b.e, jnp.sum(matrix * rates[b.e][:, None, :], axis=2)) for b, matrix in blocks if matrix is not None]

    def elastic_stress(self, strain: Float[Array, "n_e"]):
        """Stress resultants of elements of constant stiffness."""
        return scatter_vector(strain.shape[0], self._pulled(self.stiffness, strain))

    def forces(
        self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]
    ) -> tuple[Kinematics, Float[Array, "n_e"], Float[Array, "n_x"], AllCoordinates]:
        """Kinematics, stress resultants, nodal forces out of balance, and all coordinates."""
        form, n = self.form, self.size
        at = form.whole(t, state.u, state.w, z[:n])
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        acting = acting_forces(form.elements, moving, form.falling, self.stress_of(t, z[n:]))
        return acting.kinematics, acting.sigma, acting.force - form.applied(t, at.x), at

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance and second rates of the held deformations (THEORY.md 5 and 9 (b), eq. (9.1))."""
        form = self.form
        kin, _, force, at = self.forces(t, state, z)
        return jnp.concatenate([force[form.free] * form.sizes, kin.edd[form.held] - at.edd])

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> ElementTangent:
        """Derivatives of :meth:`residual` (THEORY.md 6)."""
        form, n = self.form, self.size
        at = form.whole(t, state.u, state.w, z[:n])
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        stress = self.stress_of(t, z[n:])
        # Multipliers are unknowns: the stiffness of held deformations must not act.
        loose = put(jnp.ones(form.topology.n_e), form.held, 0.0)
        tangents = [
            tuple(
                None if matrix is None else matrix * loose[block.e][:, :, None]
                for matrix, block in zip(matrices, form.elements, strict=True)
            )
            for matrices in (self.stiffness, self.damping)
        ]
        derivatives = derivatives_of_elements(form.elements, moving, form.falling, stress, *tangents)
        sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
        tangent_pieces = []
        for block, holds, derivative in zip(form.elements, self.order.holds, derivatives, strict=True):
            size = sizes[block.x]
            both = size[:, :, None] * size[:, None, :]
            by_z, by_w, by_u = (both * matrix for matrix in (derivative.mass, derivative.by_v, derivative.by_x))
            if holds:
                rows: Any = (derivative.e, derivative.ed, derivative.edd)
                e, ed, edd = (row * size[:, None, :] for row in rows)
                by_z = bordered(by_z, e, e.mT, self._corner(block, e))
                by_w, by_u = bordered(by_w, 2 * ed), bordered(by_u, edd)
            tangent_pieces.append((by_z, by_w, by_u))
        by_t = None
        if form.driven:
            by_t = jax.jvp(lambda t: self.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
        by_z, by_w, by_u = (tuple(pieces) for pieces in zip(*tangent_pieces, strict=True))
        return ElementTangent(self.order, by_z, by_w, by_u, by_t, form.held.shape[0])

    def _corner(self, block: PreparedBlock, rows: Float[Array, "elements d c"]):
        """Corner that keeps redundant constraints solvable, as in :func:`.coordinates_form.bordered`."""
        mobility = put(jnp.zeros(self.form.topology.n_x), self.form.free, self.form.mobility)[block.x]
        return (
            -REDUNDANT_COMPLIANCE * jnp.eye(rows.shape[1]) * jnp.sum(rows**2 * mobility[:, None, :], axis=2)[:, :, None]
        )

    @property
    def unknowns(self) -> int:
        """Number of accelerations and multipliers."""
        return self.form.unknowns

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, multipliers, and whether every motion carries mass (THEORY.md 9 (b), eq. (9.2))."""
        z = jnp.zeros(self.size + self.form.held.shape[0])
        solve = self.tangent(t, state, z).solver(0.0)

        def corrected(z: Float[Array, "r"], _: None):
            left = self.residual(t, state, z)
            return z - solve(left), jnp.max(jnp.abs(left))

        # The second step removes the effect of the corner on redundant constraints; a singular system leaves more.
        z, left = jax.lax.scan(corrected, z, None, length=3)
        return z, jnp.all(jnp.isfinite(z)) & (left[2] <= CHAIN_RESIDUAL * left[0])

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """The memory itself: no turns are counted."""
        return state.memory

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Held deformations minus their wanted values."""
        return self.form.gap(t, state)

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """State brought back onto the constraints, by the masses of the undeformed shape (THEORY.md 9, eq. (9.3))."""
        form, n = self.form, self.size
        if not form.held.shape[0]:
            return state
        sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
        masses = jnp.append(1 / form.mobility, jnp.zeros(form.held.shape[0]))

        def corrected(_: Array, moving: tuple[Array, Array]):
            at = form.whole(t, moving[0], moving[1], jnp.zeros(n))
            deformed_blocks = deformed_elements(form.elements, at.x, form.near(state.memory))
            pieces, rates = [], []
            for block, holds, deformed in zip(form.elements, self.order.holds, deformed_blocks, strict=True):
                k = block.x.shape[1]
                square = jnp.zeros((block.x.shape[0], k, k))
                if deformed is not None:
                    rates.append((block.e, jnp.sum(deformed[1] * at.v[block.x][:, None, :], axis=2)))
                    if holds:
                        rows = deformed[1] * sizes[block.x][:, None, :]
                        square = bordered(square, rows, rows.mT, self._corner(block, rows))
                pieces.append(square)
            e = strained(form.elements, at.x, form.near(state.memory))
            ed = scatter_vector(e.shape[0], rates)
            order: Any = self.order
            pieces = tuple(pieces)
            factors = order.factors(pieces, masses)
            back = [
                solution(order, factors, pieces, masses, jnp.append(jnp.zeros(n), excess))[:n]
                for excess in (e[form.held] - at.e, ed[form.held] - at.ed)
            ]
            return moving[0] - back[0], moving[1] - back[1]

        # The second step removes the error of the first, which is of second order.
        u, w = jax.lax.fori_loop(0, 2, corrected, (state.u, state.w))
        return MotionState(u, w, state.memory)


def chain_form(model: Model, driven: tuple[Driven, ...], order: Levels | SparseOrder) -> ChainForm:
    """Equations of motion of a chain; `order` orders its unknowns."""
    topology, parameters = model.topology, model.parameters
    # A derivative would carry dense matrices along.
    form = dataclasses.replace(coordinates_form(topology, parameters, driven), S=jnp.zeros((0, 0)), S_d=None)

    def of_blocks(companion: str) -> tuple[Any, ...]:
        pieces = iter(stiffness_pieces(topology, parameters, companion))
        moving = {id(block) for block in moving_blocks(topology)}
        matrices = [next(pieces)[2] if companion in block.companions else None for block in topology.blocks]
        return tuple(matrix for matrix, block in zip(matrices, topology.blocks, strict=True) if id(block) in moving)

    return ChainForm(form, order, of_blocks("stiffness"), of_blocks("damping"))
