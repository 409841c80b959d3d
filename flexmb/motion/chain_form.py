"""Motion of long chains and of nets: all nodal coordinates and multipliers, with matrices element by element.

Nothing here is of the size of the mechanism squared: what element matrices are added up to, and how it is factored, is
left to :mod:`flexmb.mechanics.levels` for chains and to :mod:`flexmb.mechanics.sparse_order` for everything else.
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
from .coordinates_form import REDUNDANT, AllCoordinates, CoordinatesForm, coordinates_form
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
    """What of a mechanism the form of chains does not cover, as a sentence, or None."""
    if is_nonlinear(topology):
        return "an element states an energy, a dissipation or a law of its own"
    if topology.counts_turns:
        return "an element counts the turns of an angle"
    for block in topology.blocks:
        if block.element.force is not None:
            return f"'{block.element.name}' is a load that follows the motion"
        if "deformation" not in block.companions and not {"stiffness", "damping"}.isdisjoint(block.companions):
            return f"stiffness and deformations of '{block.element.name}' are computed apart"
    if any(one.quantity in MOMENTS for one in driven):
        return "a moment in space depends on time"
    return None


class ElementTangent(NamedTuple):
    """Derivatives of the residual, element by element, with the methods of :class:`.protocol.Tangent`.

    Coordinates of elements come before their held deformations.

    Attributes:
        order: Of the unknowns.
        by_z: Of each block, (elements, k, k).
        by_w: (elements, k, k).
        by_u: (elements, k, k).
        by_t: (n + m,), or None where no load depends on time.
        held: Number m of multipliers.
    """

    order: Levels | SparseOrder
    by_z: tuple[Float[Array, "elements k k"], ...]
    by_w: tuple[Float[Array, "elements k k"], ...]
    by_u: tuple[Float[Array, "elements k k"], ...]
    by_t: Float[Array, "r"] | None
    held: int

    @property
    def mass(self) -> None:
        """No dense mass matrix is formed."""
        return None

    def solver(self, step: Any) -> Callable[[Float[Array, "r"]], Float[Array, "r"]]:
        """Return the function that solves with R_z + step R_w + step^2 R_u, for a right-hand side (n + m,)."""
        every = zip(self.by_z, self.by_w, self.by_u, strict=True)
        order: Any = self.order
        pieces = tuple(z + step * (w + step * u) for z, w, u in every)
        factors = order.factors(pieces)
        return lambda right: solution(order, factors, pieces, jnp.zeros_like(right), right)

    def product(self, w: Float[Array, "n"], u: Float[Array, "n"]) -> Float[Array, "r"]:
        """Change R_w w + R_u u of the residual, (n + m,)."""
        every = ((self.by_w, w), (self.by_u, u))
        by_w, by_u = (self.order.product(of, jnp.append(moved, jnp.zeros(self.held))) for of, moved in every)
        return by_w + by_u


class ChainForm(Record):
    """Equations of motion of a chain, as :class:`flexmb.motion.coordinates_form.CoordinatesForm` has them.

    Attributes:
        form: The same equations; of it nothing is used that is of the size of the mechanism squared.
        order: Of the unknowns.
        stiffness: Of each block of elements that deforms, (elements, d, d), or None.
        damping: The same for the rates.
    """

    form: CoordinatesForm
    order: Levels | SparseOrder
    stiffness: tuple[Float[Array, "elements d d"] | None, ...]
    damping: tuple[Float[Array, "elements d d"] | None, ...]

    @property
    def states(self) -> int:
        """Number of states of a controller: none."""
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
        """Stress resultants as a function of deformations and rates, multipliers in place of held ones."""
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

    def _pulled(self, matrices: tuple[Array | None, ...], of: Float[Array, "n_e"]):
        every = zip(self.form.elements, matrices, strict=True)
        return [(b.e, jnp.sum(own * of[b.e][:, None, :], axis=2)) for b, own in every if own is not None]

    def elastic_stress(self, strain: Float[Array, "n_e"]):
        """Stress resultants of elements of constant stiffness, (n_e,) [N, N m], at strains (n_e,) [m, rad]."""
        return scatter_vector(strain.shape[0], self._pulled(self.stiffness, strain))

    def forces(
        self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]
    ) -> tuple[Kinematics, Float[Array, "n_e"], Float[Array, "n_x"], AllCoordinates]:
        """Kinematics, stress resultants, nodal forces out of balance, and the coordinates they belong to."""
        form, n = self.form, self.size
        at = form.whole(t, state.u, state.w, z[:n])
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        acting = acting_forces(form.elements, moving, form.falling, self.stress_of(t, z[n:]))
        return acting.kinematics, acting.sigma, acting.force - form.applied(t, at.x), at

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """Forces out of balance at the coordinates that move [N, N m], second rates of the held deformations.

        Source:
            THEORY.md 5 and 9 (b), eq. (9.1).
        """
        form = self.form
        kin, _, force, at = self.forces(t, state, z)
        return jnp.concatenate([force[form.free] * form.sizes, kin.edd[form.held] - at.edd])

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> ElementTangent:
        """Derivatives of the residual, element by element.

        Source:
            Derivative of :meth:`residual` (THEORY.md 6).
        """
        form, n = self.form, self.size
        at = form.whole(t, state.u, state.w, z[:n])
        moving = Moving(at.x, at.v, at.a, form.near(state.memory))
        stress = self.stress_of(t, z[n:])
        # Multipliers are unknowns of their own: what a held deformation's stiffness would add is left out.
        loose = put(jnp.ones(form.topology.n_e), form.held, 0.0)
        tangents = [
            tuple(
                None if of is None else of * loose[block.e][:, :, None]
                for of, block in zip(matrices, form.elements, strict=True)
            )
            for matrices in (self.stiffness, self.damping)
        ]
        found = derivatives_of_elements(form.elements, moving, form.falling, stress, *tangents)
        sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
        every = []
        for block, holds, own in zip(form.elements, self.order.holds, found, strict=True):
            size = sizes[block.x]
            both = size[:, :, None] * size[:, None, :]
            by_z, by_w, by_u = (both * of for of in (own.mass, own.by_v, own.by_x))
            if holds:
                rows: Any = (own.e, own.ed, own.edd)
                e, ed, edd = (of * size[:, None, :] for of in rows)
                by_z = bordered(by_z, e, e.mT, self._corner(block, e))
                by_w, by_u = bordered(by_w, 2 * ed), bordered(by_u, edd)
            every.append((by_z, by_w, by_u))
        by_t = None
        if form.driven:
            by_t = jax.jvp(lambda t: self.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
        by_z, by_w, by_u = (tuple(of) for of in zip(*every, strict=True))
        return ElementTangent(self.order, by_z, by_w, by_u, by_t, form.held.shape[0])

    def _corner(self, block: PreparedBlock, rows: Float[Array, "elements d c"]):
        """What keeps redundant constraints solvable; see :meth:`CoordinatesForm.system`."""
        mobility = put(jnp.zeros(self.form.topology.n_x), self.form.free, self.form.mobility)[block.x]
        return -REDUNDANT * jnp.eye(rows.shape[1]) * jnp.sum(rows**2 * mobility[:, None, :], axis=2)[:, :, None]

    @property
    def unknowns(self) -> int:
        """Number of accelerations and multipliers."""
        return self.form.unknowns

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations [1/s^2] and multipliers [N, N m], and whether every motion carries mass.

        Source:
            THEORY.md 9 (b), eq. (9.2).
        """
        z = jnp.zeros(self.size + self.form.held.shape[0])
        solve = self.tangent(t, state, z).solver(0.0)

        def corrected(z: Float[Array, "r"], _: None):
            left = self.residual(t, state, z)
            return z - solve(left), jnp.max(jnp.abs(left))

        # The second time removes what keeps redundant constraints solvable; what a singular system leaves is more.
        z, left = jax.lax.scan(corrected, z, None, length=3)
        return z, jnp.all(jnp.isfinite(z)) & (left[2] <= 1e-6 * left[0])

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]):
        """How the memory changes: no turns are counted."""
        return state.memory

    def gap(self, t: Float[Array, ""], state: MotionState):
        """Held deformations less what they are held at, (m,) [m, rad]."""
        return self.form.gap(t, state)

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Positions and velocities brought back onto the constraints, by the masses of the undeformed shape.

        Source:
            THEORY.md 9, eq. (9.3).
        """
        form, n = self.form, self.size
        if not form.held.shape[0]:
            return state
        sizes = put(jnp.ones(form.topology.n_x), form.free, form.sizes)
        masses = jnp.append(1 / form.mobility, jnp.zeros(form.held.shape[0]))

        def corrected(_: Array, moving: tuple[Array, Array]):
            at = form.whole(t, moving[0], moving[1], jnp.zeros(n))
            found = deformed_elements(form.elements, at.x, form.near(state.memory))
            pieces, rates = [], []
            for block, holds, own in zip(form.elements, self.order.holds, found, strict=True):
                k = block.x.shape[1]
                square = jnp.zeros((block.x.shape[0], k, k))
                if own is not None:
                    rates.append((block.e, jnp.sum(own[1] * at.v[block.x][:, None, :], axis=2)))
                if own is not None and holds:
                    rows = own[1] * sizes[block.x][:, None, :]
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
            return tuple(of - more for of, more in zip(moving, back, strict=True))

        # The second time removes what the first left, which is of second order.
        u, w = jax.lax.fori_loop(0, 2, corrected, (state.u, state.w))
        return MotionState(u, w, state.memory)


def chain_form(model: Model, driven: tuple[Driven, ...], order: Levels | SparseOrder) -> ChainForm:
    """Equations of motion of a chain.

    Args:
        order: Of its unknowns.

    Returns:
        ChainForm.
    """
    topology, parameters = model.topology, model.parameters
    # What is of the size of the mechanism squared is left out: a derivative would carry it along.
    form = dataclasses.replace(coordinates_form(topology, parameters, driven), S=jnp.zeros((0, 0)), S_d=None)

    def of_blocks(companion: str) -> tuple[Any, ...]:
        pieces = iter(stiffness_pieces(topology, parameters, companion))
        moving = {id(block) for block in moving_blocks(topology)}
        found = [next(pieces)[2] if companion in block.companions else None for block in topology.blocks]
        return tuple(own for own, block in zip(found, topology.blocks, strict=True) if id(block) in moving)

    return ChainForm(form, order, of_blocks("stiffness"), of_blocks("damping"))
