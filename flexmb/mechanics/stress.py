"""Stress resultants from deformations: assembled stiffness and damping of the elements."""

import jax
from jaxtyping import Array, Float

from ..math.compile import traced_once
from ..model.parameters import Loads, Parameters
from ..model.topology import Topology
from .blocks import each_block, scatter_matrix


def _assemble(topology: Topology, parameters: Parameters, companion: str) -> Float[Array, "n_e n_e"]:
    pieces = []
    for block, function, ref, properties in each_block(topology, parameters, companion):
        pieces.append((block.e, block.e, jax.vmap(function)(parameters.reference[block.x], ref, properties)))
    return scatter_matrix((topology.n_e, topology.n_e), pieces)


@traced_once
def element_stiffness(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Stiffness S between deformations and stress resultants, block diagonal.

    Args:
        topology: Structure.
        parameters: Numbers.

    Returns:
        S, (n_e, n_e) [N/m, N m/rad].

    Source:
        Each element's stiffness companion.
    """
    return _assemble(topology, parameters, "stiffness")


@traced_once
def element_damping(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Damping S_d between deformation rates and stress resultants, block diagonal.

    Args:
        topology: Structure.
        parameters: Numbers.

    Returns:
        S_d, (n_e, n_e) [N s/m, N m s/rad].

    Source:
        Each element's damping companion.
    """
    return _assemble(topology, parameters, "damping")


def stress_resultants(
    parameters: Parameters, loads: Loads, stiffness: Float[Array, "n_e n_e"], e: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Stress resultants of the elastic elements, sigma = S (e - strain) + prestress.

    Args:
        parameters: Numbers.
        loads: Loads, of which the prestress is used.
        stiffness: S, (n_e, n_e) [N/m, N m/rad].
        e: Deformations, (n_e,) [m, rad].

    Returns:
        sigma, (n_e,) [N, N m].

    Source:
        FORMULATION.md 5.
    """
    sigma = stiffness @ (e if parameters.strain is None else e - parameters.strain)
    return sigma if loads.prestress is None else sigma + loads.prestress
