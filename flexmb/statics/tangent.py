"""Tangent of the equations in all coordinates and one multiplier per constraint, element by element.

Element matrices are multiplied where they are computed, so that the host only adds up.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import computed
from ..compilation.compile import jit
from ..math.by_deformations import deformations_of_motions, energies_between, forces_of, motions_from_free
from ..math.element_matrices import AssembledEquations, BlockMatrices, ElementMatrices, by_coordinates
from ..math.indices import accumulate, put, scatter_vector
from ..math.sparse import SparseFactors
from ..mechanics.deformation import curvature_pieces, jacobian_pieces
from ..mechanics.inertia import weight_pieces
from ..mechanics.loads import LoadFactors, load_pieces, scaled_loads
from ..mechanics.stress_resultants import (
    is_nonlinear,
    nonlinear_stress,
    nonlinear_tangent_pieces,
    stiffness_pieces,
    strain_of,
    stress_of_strain,
)
from ..model.topology import Parameters, Topology, coordinate_scales


def unknowns(topology: Topology) -> tuple[Array, Array, Array]:
    """Coordinates that move, coordinates that do not, and held deformations."""
    return computed(lambda xp, free: xp.sort(free), topology.x.free), topology.x.held, topology.e.held


@jit
def elastic_stress(topology: Topology, parameters: Parameters, factors: LoadFactors, e: Float[Array, "n_e"]):
    """Stress resultants of the elements at rest, without the multipliers of held deformations."""
    loads = scaled_loads(parameters, factors)
    strain = strain_of(topology, parameters, loads, e)
    sigma = stress_of_strain(topology, parameters, strain)
    if is_nonlinear(topology):
        sigma = sigma + nonlinear_stress(topology, parameters, strain, jnp.zeros_like(strain))
    return sigma if loads.prestress is None else sigma + loads.prestress


def by_deformations(
    topology: Topology,
    parameters: Parameters,
    strain: Float[Array, "n_e"],
    constraints: BlockMatrices,
    companion: str = "stiffness",
) -> BlockMatrices:
    """Stiffness or damping of elements at rest by their deformations, zero for held ones, whose stress is a multiplier.

    Companions in another block than the deformation are found by the numbers of the deformations, in the same order.
    Returns pieces for each block that deforms, none without the companion.
    """
    block_matrices = stiffness_pieces(topology, parameters, companion)
    if is_nonlinear(topology):
        _, *tangents = nonlinear_tangent_pieces(topology, parameters, strain, jnp.zeros_like(strain))
        block_matrices = [*block_matrices, *tangents[companion == "damping"]]
    if not block_matrices:
        return []
    widest = max(at.shape[1] for at, *_ in constraints)
    unconstrained = put(jnp.ones(topology.n_e), topology.e.held, 0.0)
    rows = jnp.zeros((topology.n_e, widest))
    for at, by, matrices in block_matrices:
        matrices = unconstrained[at][:, :, None] * matrices * unconstrained[by][:, None, :]
        rows = accumulate(rows, at, jnp.pad(matrices, ((0, 0), (0, 0), (0, widest - matrices.shape[2]))))
    return [(at, at, rows[at][:, :, : at.shape[1]]) for at, *_ in constraints]


def element_matrices(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
    strained: Float[Array, "n_e"] | None = None,
) -> tuple[ElementMatrices, Float[Array, "n_e"]]:
    """Element matrices at a state, without damping and mass, and its deformations.

    The elements' stiffness is that at ``strained``; None: at the deformations of x. ``sigma`` includes multipliers.
    """
    values, constraints = jacobian_pieces(topology, parameters, x, near)
    e = scatter_vector(topology.n_e, values)
    loads = scaled_loads(parameters, factors)
    strain = strain_of(topology, parameters, loads, e if strained is None else strained)
    elastic = by_deformations(topology, parameters, strain, constraints)
    pulling = [] if loads.gravity is None else weight_pieces(topology, parameters, x, loads.gravity)
    pulling = [*pulling, *load_pieces(topology, parameters, factors, x)]
    curved = curvature_pieces(topology, parameters, x, near, sigma)
    free, _, constrained = unknowns(topology)
    elements = ElementMatrices(
        structural=by_coordinates(constraints, elastic),
        curved=[*curved, *((rows, columns, -matrices) for rows, columns, matrices in pulling)],
        damping=[],
        mass=[],
        loss=[],
        constraints=constraints,
        elastic=elastic,
        viscous=[],
        lossy=[],
        free=free,
        held=constrained,
        sizes=coordinate_scales(topology, parameters),
        kept=put(jnp.ones(topology.n_e), constrained, 0.0),
    )
    return elements, e


at_state = jit(element_matrices)


class Assembled:
    """Tangent of the equilibrium, on the host."""

    def __init__(self, elements: ElementMatrices):
        self.whole = AssembledEquations(elements)
        self.tangent = self.whole.at()

    def factors(self) -> SparseFactors:
        """Factors of the tangent, in an order of elimination that is found once for the mechanism."""
        return self.whole.factors(self.tangent)

    def deformed(self, motion: np.ndarray) -> np.ndarray:
        """Deformations of a motion of all coordinates, (n_e,)."""
        return deformations_of_motions(self.whole.elements, motion[:, None])[:, 0]

    def between(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Stiffness between motions of the coordinates that move, (n, k) and (n, m), with little round-off."""
        elements = self.whole.elements
        moved = (motions_from_free(elements, motions) for motions in (left, right))
        return energies_between(elements, *moved) + left.T @ (self.whole.curved @ right)

    def forces(self, motions: np.ndarray) -> np.ndarray:
        """Forces of the stiffness on motions of the coordinates that move, (n, k), with little round-off."""
        elements = self.whole.elements
        return forces_of(elements, motions_from_free(elements, motions), 0.0)[: self.whole.n]
