"""Stress resultants: stiffness and damping of the elements, assembled; forces and moments in their sections."""

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


def section_resultants(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    sigma: Float[Array, "n_e"],
    places: Float[Array, "places"],
) -> list[Float[Array, "elements places 6"]]:
    """Forces and moments in the cross-sections of the elements, block by block.

    Args:
        topology: Structure.
        parameters: Numbers.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        sigma: Stress resultants, multipliers of FIXED deformations included, (n_e,) [N, N m].
        places: From 0 at the first end of an element to 1 at its last, (places,) [-].

    Returns:
        For each block with the companion ``resultants``, in order, (elements, places, 6) [N, N m].

    Source:
        Each element's resultants companion.
    """
    found = []
    for block, function, ref, properties in each_block(topology, parameters, "resultants"):

        def one(x, ref, own, sigma, place, function=function):
            return function(x, ref, own, sigma=sigma, place=place)

        everywhere = jax.vmap(jax.vmap(one, (None, None, None, None, 0)), (0, 0, 0, 0, None))
        found.append(everywhere(x[block.x], ref, properties, sigma[block.e], places))
    return found
