"""Equations of motion of long chains and nets: all nodal coordinates and multipliers, with matrices element by element.

No array is of the size of the mechanism squared. :mod:`flexmb.mechanics.sparse_order` assembles and factorises.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..math.indices import put, scatter_vector
from ..mechanics.sparse_order import SparseOrder, moving_blocks, solution
from ..mechanics.stress_resultants import is_nonlinear, stiffness_pieces, strain_of
from ..model.model import Model
from ..model.topology import Topology
from ..numerical_limits import CHAIN_RESIDUAL, REDUNDANT_COMPLIANCE
from .coordinates_form import CoordinatesForm, coordinates_form
from .drive import MOMENTS, Driven
from .element_forces import PreparedBlock, deformed_elements, element_derivatives, strained
from .protocol import MotionState, by_time


def obstacle(topology: Topology, driven: tuple[Driven, ...]) -> str | None:
    """Return a sentence on the first property of a mechanism that excludes this form, or None."""
    if is_nonlinear(topology):
        return "an element has its own energy, dissipation or law"
    if topology.counts_turns:
        return "an element counts the turns of an angle"
    for block in topology.blocks:
        if block.element.force is not None:
            return f"'{block.element.name}' is a load that follows the motion"
        if "deformation" not in block.companions and not {"stiffness", "damping"}.isdisjoint(block.companions):
            return f"stiffness and deformations of '{block.element.name}' are computed separately"
    if any(drive.quantity in MOMENTS for drive in driven):
        return "a moment in space depends on time"
    return None


class ElementTangent(NamedTuple):
    """:class:`.protocol.Tangent` by element matrices: coordinates of an element, then its constrained deformations.

    `still` is zero for each multiplier.
    """

    order: SparseOrder
    by_z: tuple[Float[Array, "elements k k"], ...]
    by_w: tuple[Float[Array, "elements k k"], ...]
    by_u: tuple[Float[Array, "elements k k"], ...]
    by_t: Float[Array, "r"] | None
    still: Float[Array, "m"]

    @property
    def mass(self) -> None:
        """None: no dense mass matrix is formed."""
        return None

    def solver(self, step: Any) -> Callable[[Float[Array, "r"]], Float[Array, "r"]]:
        """Function that solves with R_z + step R_w + step^2 R_u."""
        element_matrices = tuple(
            z + step * (w + step * u) for z, w, u in zip(self.by_z, self.by_w, self.by_u, strict=True)
        )
        return lambda right: solution(self.order, element_matrices, jnp.zeros_like(right), right)

    def product(self, w: Float[Array, "n"], u: Float[Array, "n"]) -> Float[Array, "r"]:
        """R_w w + R_u u, (n + m,)."""
        w, u = jnp.append(w, self.still), jnp.append(u, self.still)
        return self.order.product(self.by_w, w) + self.order.product(self.by_u, u)


class ChainForm(CoordinatesForm):
    """Equations of motion in all nodal coordinates, with matrices element by element.

    Attributes:
        order: Order of the unknowns.
        stiffness, damping: Constant matrices of the elements of each block, or None.
    """

    order: SparseOrder
    stiffness: tuple[Float[Array, "elements d d"] | None, ...]
    damping: tuple[Float[Array, "elements d d"] | None, ...]

    def stress_of(self, t: Float[Array, ""], multipliers: Float[Array, "m"]):
        """Return stress resultants by deformations and rates, with multipliers at constrained deformations."""
        drive = self.drive(t)

        def stress(e: Float[Array, "n_e"], ed: Float[Array, "n_e"]):
            strain = strain_of(self.topology, self.parameters, drive.loads, e)
            element_stresses = self._pulled(self.stiffness, strain) + self._pulled(self.damping, ed)
            sigma = scatter_vector(e.shape[0], element_stresses)
            for more in (drive.loads.prestress, drive.stress):
                sigma = sigma if more is None else sigma + more
            return put(sigma, self.held, multipliers)

        return stress

    def _pulled(self, matrices: tuple[Array | None, ...], rates: Float[Array, "n_e"]):
        blocks = zip(self.elements, matrices, strict=True)
        return [(b.e, jnp.sum(matrix * rates[b.e][:, None, :], axis=2)) for b, matrix in blocks if matrix is not None]

    def elastic_stress(self, strain: Float[Array, "n_e"]):
        """Stress resultants of elements of constant stiffness."""
        return scatter_vector(strain.shape[0], self._pulled(self.stiffness, strain))

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Any:
        """Derivatives of :meth:`residual` (THEORY.md 6)."""
        _, moving, stress = self.moving(t, state, z)
        # Multipliers are unknowns: the stiffness of held deformations must not act.
        loose = put(jnp.ones(self.topology.n_e), self.held, 0.0)
        tangents = [
            [None if matrix is None else matrix * loose[block.e][:, :, None] for matrix in matrices]
            for block, *matrices in zip(self.elements, self.stiffness, self.damping, strict=True)
        ]
        _, derivatives = element_derivatives(self.elements, moving, self.falling, stress, lambda *_: tangents)
        sizes = put(jnp.ones(self.topology.n_x), self.free, self.sizes)
        tangent_pieces = []
        for holds, (block, derivative) in zip(self.order.holds, derivatives, strict=True):
            size = sizes[block.x]
            size_products = size[:, :, None] * size[:, None, :]
            by_z, by_w, by_u = (
                size_products * matrix for matrix in (derivative.mass, derivative.by_v, derivative.by_x)
            )
            if holds:
                e, ed, edd = (row * size[:, None, :] for row in derivative[:3])
                by_z = _bordered(by_z, e, e.mT, self._corner(block, e))
                by_w, by_u = _bordered(by_w, 2 * ed), _bordered(by_u, edd)
            tangent_pieces.append((by_z, by_w, by_u))
        by_t = by_time(self, t, state, z) if self.driven else None
        by_z, by_w, by_u = (tuple(element_matrices) for element_matrices in zip(*tangent_pieces, strict=True))
        return ElementTangent(self.order, by_z, by_w, by_u, by_t, jnp.zeros(self.held.shape))

    def _corner(self, block: PreparedBlock, rows: Float[Array, "elements d c"]):
        """Return the corner for redundant constraints, as in :meth:`CoordinatesForm.system`."""
        mobility = put(jnp.zeros(self.topology.n_x), self.free, self.mobility)[block.x]
        return (
            -REDUNDANT_COMPLIANCE * jnp.eye(rows.shape[1]) * jnp.sum(rows**2 * mobility[:, None, :], axis=2)[:, :, None]
        )

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Accelerations, multipliers, and whether every motion carries mass (THEORY.md 9 (b), eq. (9.2))."""
        z = jnp.zeros(self.unknowns)
        solve = self.tangent(t, state, z).solver(0.0)

        def corrected(z: Float[Array, "r"], _: None):
            residual = self.residual(t, state, z)
            return z - solve(residual), jnp.max(jnp.abs(residual))

        # The second step removes the effect of the corner on redundant constraints; a singular system leaves more.
        z, residual_sizes = jax.lax.scan(corrected, z, None, length=3)
        return z, jnp.all(jnp.isfinite(z)) & (residual_sizes[2] <= CHAIN_RESIDUAL * residual_sizes[0])

    @jit_beside_options
    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Return the state projected onto the constraints by the initial masses (THEORY.md 9, eq. (9.3))."""
        n = self.size
        if not self.held.shape[0]:
            return state
        sizes = put(jnp.ones(self.topology.n_x), self.free, self.sizes)
        masses = jnp.append(1 / self.mobility, jnp.zeros(self.held.shape[0]))

        def corrected(_: Array, moving: tuple[Array, Array]):
            at = self.whole(t, *moving)
            deformed_blocks = deformed_elements(self.elements, at.x, self.near(state.memory))
            element_matrices, rates = [], []
            for block, holds, deformed in zip(self.elements, self.order.holds, deformed_blocks, strict=True):
                k = block.x.shape[1]
                square = jnp.zeros((block.x.shape[0], k, k))
                if deformed is not None:
                    rates.append((block.e, jnp.sum(deformed[1] * at.v[block.x][:, None, :], axis=2)))
                    if holds:
                        rows = deformed[1] * sizes[block.x][:, None, :]
                        square = _bordered(square, rows, rows.mT, self._corner(block, rows))
                element_matrices.append(square)
            e = strained(self.elements, at.x, self.near(state.memory))
            ed = scatter_vector(e.shape[0], rates)
            back = [
                solution(self.order, tuple(element_matrices), masses, jnp.append(jnp.zeros(n), excess))[:n]
                for excess in (e[self.held] - at.e, ed[self.held] - at.ed)
            ]
            return moving[0] - back[0], moving[1] - back[1]

        # The second step removes the error of the first, which is of second order.
        u, w = jax.lax.fori_loop(0, 2, corrected, (state.u, state.w))
        return MotionState(u, w, state.memory)


def chain_form(model: Model, driven: tuple[Driven, ...], order: SparseOrder) -> ChainForm:
    """Return the equations of motion of a chain; `order` is the order of its unknowns."""
    topology, parameters = model.topology, model.parameters
    form = coordinates_form(topology, parameters, driven)

    def of_blocks(companion: str) -> tuple[Any, ...]:
        element_matrices = iter(stiffness_pieces(topology, parameters, companion))
        moving = {id(block) for block in moving_blocks(topology)}
        matrices = [next(element_matrices)[2] if companion in block.companions else None for block in topology.blocks]
        return tuple(matrix for matrix, block in zip(matrices, topology.blocks, strict=True) if id(block) in moving)

    # A derivative would carry dense matrices along.
    fields: dict[str, Any] = {**vars(form), "S": jnp.zeros((0, 0)), "S_d": None}
    return ChainForm(**fields, order=order, stiffness=of_blocks("stiffness"), damping=of_blocks("damping"))


def _bordered(
    square: Float[Array, "elements c c"],
    rows: Float[Array, "elements d c"],
    columns: Float[Array, "elements c d"] | None = None,
    corner: Float[Array, "elements d d"] | None = None,
) -> Float[Array, "elements k k"]:
    """Return element matrices bordered by rows, columns (or zeros) and a corner (or zeros)."""
    count, d, _ = rows.shape
    columns = jnp.zeros_like(rows.mT) if columns is None else columns
    corner = jnp.zeros((count, d, d)) if corner is None else corner
    upper, lower = (jnp.concatenate(pair, axis=2) for pair in ((square, columns), (rows, corner)))
    return jnp.concatenate([upper, lower], axis=1)
