"""Tangent of the equations in all coordinates and one multiplier a constraint, sparse: its pattern, found once.

Element matrices are multiplied element by element where they are computed, so that the host only adds up.
"""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..math.indices import accumulate
from ..math.sparse import SparseFactors
from ..mechanics.blocks import scatter_vector
from ..mechanics.deformation import curvature_pieces, jacobian_pieces
from ..mechanics.inertia import mass_pieces, weight_pieces
from ..mechanics.loads import LoadFactors, load_pieces, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import (
    is_nonlinear,
    nonlinear_stress,
    nonlinear_tangent_pieces,
    stiffness_pieces,
    strain_of,
    stress_of_strain,
)
from ..model.parameters import Parameters
from ..model.topology import Topology
from .sparse_structure import Structure, structure_of


def unknowns(topology: Topology) -> tuple[Array, Array, Array]:
    """Coordinates that move, coordinates that do not, and deformations that are held."""
    return jnp.sort(topology.x.free), topology.x.held, topology.e.held


@jit
def elastic_stress(topology: Topology, parameters: Parameters, factors: LoadFactors, e: Float[Array, "n_e"]):
    """Stress resultants of the elements at rest, without the multipliers of held deformations."""
    loads = scaled_loads(parameters, factors)
    strain = strain_of(topology, parameters, loads, e)
    sigma = stress_of_strain(topology, parameters, strain)
    if is_nonlinear(topology):
        sigma = sigma + nonlinear_stress(topology, parameters, strain, jnp.zeros_like(strain))
    return sigma if loads.prestress is None else sigma + loads.prestress


def stiffness_rows(topology: Topology, parameters: Parameters, strain: Float[Array, "n_e"]):
    """Rows of the elements' tangent stiffnesses, those of held deformations zero, (n_e, widest).

    Those of a block are ``rows[block.e]``, up to the number of its deformations. Elements whose companions lie in
    another block than their deformation are found by the numbers of their deformations, which are in the same order
    there.
    """
    widest = max([b.e.shape[1] for b in topology.blocks], default=0)
    keep = jnp.ones(topology.n_e).at[topology.e.held].set(0.0)
    rows = jnp.zeros((topology.n_e, widest))
    pieces = stiffness_pieces(topology, parameters)
    if is_nonlinear(topology):
        pieces = [*pieces, *nonlinear_tangent_pieces(topology, parameters, strain, jnp.zeros_like(strain))[1]]
    for at, columns, matrices in pieces:
        matrices = matrices * keep[at][:, :, None] * keep[columns][:, None, :]
        rows = accumulate(rows, at, jnp.pad(matrices, ((0, 0), (0, 0), (0, widest - matrices.shape[2]))))
    return rows


class Pieces(NamedTuple):
    """Element matrices of the equations at a state, in the order in which :class:`Structure` places them.

    Attributes:
        rows: D of each block that deforms, (elements, k, c).
        elastic: D^T S D of each, (elements, c, c).
        geometric: Curvature of each under its stress resultants, (elements, c, c).
        loads: Less the derivative of weight and of load elements, block by block, (elements, c, c).
        masses: Of each block with inertia, (elements, c, c), or None.
        own: S of each block that deforms, zero for held deformations, (elements, k, k).
    """

    rows: list[Array]
    elastic: list[Array]
    geometric: list[Array]
    loads: list[Array]
    masses: list[Array] | None
    own: list[Array]

    @property
    def stiff(self) -> list[Array]:
        """All of the stiffness."""
        return [a + b for a, b in zip(self.elastic, self.geometric, strict=True)] + self.loads


def pieces_at(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
    strained: Float[Array, "n_e"] | None = None,
    mass: bool = False,
):
    """Element matrices at a state, where they stand in x, and its deformations.

    Args:
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        sigma: Stress resultants, multipliers included, (n_e,) [N, N m].
        strained: Deformations at which the elements' stiffness is taken, (n_e,) [m, rad]; None: those of x.
        mass: Whether masses are asked for.

    Returns:
        :class:`Pieces`; row and column indices of D, and those of the stiffness; e, (n_e,).
    """
    values, jacobian = jacobian_pieces(topology, parameters, x, near)
    e = scatter_vector(topology.n_e, values)
    loads = scaled_loads(parameters, factors)
    strain = strain_of(topology, parameters, loads, e if strained is None else strained)
    stiffness = stiffness_rows(topology, parameters, strain)
    curved = curvature_pieces(topology, parameters, x, near, sigma)
    own = [stiffness[at][:, :, : at.shape[1]] for at, *_ in jacobian]
    elastic = [jnp.einsum("eki,ekl,elj->eij", d, s, d) for (*_, d), s in zip(jacobian, own, strict=True)]
    pulling = [] if loads.gravity is None else weight_pieces(topology, parameters, x, loads.gravity)
    pulling = [*pulling, *load_pieces(topology, parameters, factors, x)]
    masses = [m for _, _, m in mass_pieces(topology, parameters, x)] if mass else None
    rows, geometric, loads_own = ([own for *_, own in of] for of in (jacobian, curved, pulling))
    found = Pieces(rows, elastic, geometric, [-matrices for matrices in loads_own], masses, own)
    return found, [(r, c) for r, c, _ in jacobian], [(r, c) for r, c, _ in (*curved, *pulling)], e


@jit
def _pieces(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
    *,
    mass: bool = False,
):
    """Element matrices for the host, with nodal forces and the stress that deformations have there."""
    found, _, _, e = pieces_at(topology, parameters, factors, x, near, sigma, mass=mass)
    force = nodal_forces(topology, parameters, factors, x)
    stress = elastic_stress(topology, parameters, factors, e).at[topology.e.held].set(0.0)
    return found, e, stress, force


class Assembled:
    """Tangent of the equilibrium, and what belongs to it; each matrix is put together when first asked for.

    Attributes:
        structure: Patterns of the matrices.
        e: Deformations, (n_e,) [m, rad].
        sigma: Stress resultants without the multipliers, (n_e,) [N, N m].
        force: Nodal forces of the loads, (n_x,) [N, N m].
    """

    def __init__(self, structure: Structure, pieces: Pieces, e: Any, sigma: Any, force: Any):
        self.structure = structure
        self._pieces: Pieces = jax.tree.map(np.asarray, pieces)
        self.e, self.sigma, self.force = (np.asarray(v) for v in (e, sigma, force))

    @functools.cached_property
    def tangent(self) -> Any:
        """Derivative by the coordinates that move and the multipliers."""
        return self.structure.bordered(self._pieces.stiff, self._pieces.rows)

    @functools.cached_property
    def structural(self) -> Any:
        """The same without stress resultants and loads."""
        none = [np.zeros_like(load) for load in self._pieces.loads]
        return self.structure.bordered([*self._pieces.elastic, *none], self._pieces.rows)

    def factors(self) -> SparseFactors:
        """Factors of the tangent, in an order of elimination that is found once for the mechanism."""
        return self.structure.tangent.factors(self.tangent)

    @functools.cached_property
    def coupling(self) -> Any:
        """Derivative by the coordinates that do not move."""
        return self.structure.coupling.matrix([*self._pieces.stiff, *self._pieces.rows])

    @functools.cached_property
    def geometric(self) -> Any:
        """Part of the tangent that stress resultants and loads have, of the coordinates that move."""
        return self.structure.stiff.matrix([*self._pieces.geometric, *self._pieces.loads])

    def between(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Stiffness between motions of the coordinates that move, (n, k) and (n, m), little spoilt by round-off."""
        elastic = self.structure.elastic_between(self._pieces.rows, self._pieces.own, left, right)
        return elastic + left.T @ (self.geometric @ right)

    def forces(self, motions: np.ndarray) -> np.ndarray:
        """Forces of the stiffness on motions of the coordinates that move, (n, k), as little spoilt."""
        elastic = self.structure.elastic_forces(self._pieces.rows, self._pieces.own, motions)
        return elastic + self.geometric @ motions

    @functools.cached_property
    def mass(self) -> Any:
        """Mass of the coordinates that move, or None."""
        return None if self._pieces.masses is None else self.structure.mass.matrix(self._pieces.masses)

    @functools.cached_property
    def jacobian(self) -> Any:
        """D_x, (n_e, n_x)."""
        return self.structure.jacobian.matrix(self._pieces.rows)


def falls(parameters: Parameters) -> bool:
    """Whether there is gravity, known before tracing: weight takes part in the tangent."""
    return parameters.loads.gravity is not None or (
        parameters.increment is not None and parameters.increment.gravity is not None
    )


def assemble(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array | np.ndarray, "n_x"],
    near: Float[Array | np.ndarray, "n_e"],
    sigma: Float[Array | np.ndarray, "n_e"],
    mass: bool = False,
) -> Assembled:
    """Tangent of the equilibrium at a state with stress resultants ``sigma``, on the host; with its mass if asked."""
    found = _pieces(topology, parameters, factors, *(jnp.asarray(v) for v in (x, near, sigma)), mass=mass)
    return Assembled(structure_of(topology, falls(parameters)), *found)
