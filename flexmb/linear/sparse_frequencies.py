"""Lowest frequencies of large mechanisms about their equilibrium, by sparse factors, and their derivatives."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.inertia import kinetic_energy
from ..mechanics.loads import LoadFactors
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..statics.sparse import (
    Balanced,
    balanced,
    refuse_traced,
    refuse_what_is_not_sparse,
    second_variation,
)
from ..statics.tangent import assemble, elastic_stress, unknowns
from .spectrum import Lowest, lowest_of_sparse


@jax.custom_jvp
def _eigenvalues(
    topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced, count: Array
) -> Float[Array, "k"]:
    refuse_traced(parameters, factors, at)
    return jnp.asarray(_at_balance(topology, parameters, factors, at, count).values)


def _at_balance(topology, parameters, factors, at: Balanced, count) -> Lowest:
    near = deformations(topology, parameters, at.x, zero_near(topology))
    held = unknowns(topology)[2]
    sigma = put(elastic_stress(topology, parameters, factors, near), held, at.multipliers)
    found = assemble(topology, parameters, factors, at.x, near, sigma, mass=True)
    return lowest_of_sparse(found.tangent, found.mass, count.shape[0])


@jit
def _rayleigh(topology, parameters, factors, at: Balanced, near, motion, multipliers, value) -> Float[Array, ""]:
    """Second variation of the Lagrangian along a mode, whose derivative is that of the eigenvalue."""
    elastic, geometric, rates = second_variation(topology, parameters, factors, at, near, motion)
    phi = put(jnp.zeros(topology.n_x), unknowns(topology)[0], motion)
    kinetic = kinetic_energy(topology, parameters, at.x, phi)
    return elastic + geometric + 2 * multipliers @ rates - 2 * value * kinetic


@_eigenvalues.defjvp
def _eigenvalues_jvp(primals, tangents):
    topology, parameters, factors, at, count = primals
    found = _at_balance(topology, parameters, factors, at, count)
    near = deformations(topology, parameters, at.x, zero_near(topology))

    def all_modes(parameters, factors, at):
        return jnp.stack(
            [
                _rayleigh(topology, parameters, factors, at, near, *(jnp.asarray(v) for v in mode))
                for mode in zip(found.motions.T, found.multipliers.T, found.values, strict=True)
            ]
        )

    _, change = jvp_of_varied(all_modes, primals[1:4], tangents[1:4])
    return jnp.asarray(found.values), change


@one_thread()
def sparse_eigenvalues(model: Model, target: LoadFactors, count: int) -> Float[Array, "k"]:
    """Lowest eigenvalues about the equilibrium by sparse factors, (count,) [rad^2/s^2].

    Args:
        model: As for :func:`sparse_equilibrium`.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`, or too large a count.
        AnalysisError: singular_stiffness or not_converged.

    Source:
        Shift-inverted Lanczos method of ARPACK; THEORY.md 6 with multipliers in place of degrees of freedom.
    """
    refuse_what_is_not_sparse(model.topology)
    at = balanced(model.topology, model.parameters, target)
    # The number is handed on as a shape, which stays known.
    return _eigenvalues(model.topology, model.parameters, target, at, jnp.zeros(count))
