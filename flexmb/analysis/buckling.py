"""Linear buckling: load multipliers about the loaded state, sign kept."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..math.compile import jit
from ..math.linear import factorise, is_positive_definite, pencil
from ..math.record import Record
from ..mechanics.deformation import deformation_curvature
from ..mechanics.loads import LoadFactors, lacks_potential, load_stiffness, nodal_forces
from ..mechanics.residual import State, linear_response
from ..mechanics.transfer import multipliers
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check
from .equilibrium import held_values, solve_state
from .linearize import Linearization, linearize

# Multipliers beyond this many times the smallest are called unbounded: the load does not act in that motion.
UNBOUNDED = 1e9
# Eigenvalues whose imaginary part is below this share are real.
REAL = 1e-8


class Buckling(Record):
    """Load multipliers and buckling modes, by magnitude.

    Attributes:
        multipliers: Lambda of det(K0 + N0 + lambda G0) = 0, sign kept, (n,) [-].
        shapes: Buckling modes in the coordinates, the largest entry of each 1, (n_x, n).
        lin: Linearization about the state that the multipliers refer to.
    """

    multipliers: Float[Array, "n"]
    shapes: Float[Array, "n_x n"]
    lin: Linearization

    def _repr_html_(self) -> str | None:
        """Table and picture in a notebook."""
        from ..viewer.notebook import card

        return card(self)


def geometric_stiffness_of_increment(
    topology: Topology, parameters: Parameters, at: State, near: Float[Array, "n_e"]
) -> Float[Array, "n_q n_q"]:
    """Stiffness of the stresses that the incremental loads add, to first order, at the preloaded geometry.

    Args:
        topology: Structure.
        parameters: Numbers.
        at: Preloaded state.
        near: Deformations there, (n_e,) [m, rad].

    Returns:
        (n_q, n_q) [N/m, N m/rad].
    """
    no_preload = LoadFactors(0.0, 1.0)
    unloaded = dataclasses.replace(parameters, strain=None)
    force = nodal_forces(topology, parameters, no_preload, at.x)
    increment = parameters.increment
    wanted_x, wanted_e = held_values(topology, unloaded, no_preload)
    shift = wanted_x - parameters.reference
    extra = jnp.zeros(topology.n_e) if increment is None or increment.prestress is None else increment.prestress
    excess = at.jacobian @ shift - wanted_e
    dx, _ = linear_response(topology, at, excess, shift, at.jacobian.T @ extra - force)
    elastic = at.S @ (at.jacobian @ dx) + extra
    sigma = multipliers(topology, at.transfer, at.jacobian, elastic, force)
    curvature = deformation_curvature(topology, parameters, at.x, near, sigma)
    curvature = curvature - load_stiffness(topology, parameters, no_preload, at.x)
    return at.transfer.DFx.T @ curvature @ at.transfer.DFx


def _stiffnesses(topology: Topology, parameters: Parameters):
    """Stiffness that stays and stiffness that is scaled, DFx, and the code of the equilibrium."""
    at, near, result, _ = solve_state(topology, parameters, LoadFactors(1.0, 0.0))
    if parameters.increment is None:
        return at.K0, at.G0, at.transfer.DFx, result
    scaled = geometric_stiffness_of_increment(topology, parameters, at, near)
    return at.K0 + at.G0, scaled, at.transfer.DFx, result


def _inverse_multipliers(topology: Topology, k, g):
    """Values 1/lambda by descending magnitude, and vectors; those of a complex pair are zero."""
    if lacks_potential(topology):
        values, vectors = jnp.linalg.eig(factorise(k).solve(-g))
        real = jnp.abs(values.imag) <= REAL * jnp.abs(values)
        values, vectors = jnp.where(real, values.real, 0.0), vectors.real
    else:
        values, vectors = pencil(-(g + g.T) / 2, (k + k.T) / 2)
    order = jnp.argsort(-jnp.abs(jax.lax.stop_gradient(values)))
    return values[order], vectors[:, order]


@jit
def multipliers_of(k: Float[Array, "n n"], g: Float[Array, "n n"]) -> Float[Array, "n"]:
    """Real load multipliers by magnitude, of a stiffness that stays and one that is scaled.

    Args:
        k: Stiffness that stays, regular, (n, n).
        g: Stiffness that is scaled, (n, n).

    Returns:
        Lambda of det(k + lambda g) = 0, infinite where the load does not act or only in complex pairs, (n,) [-].

    Source:
        Tutorial WA 1239 (2012), eq. (A.2), solved for 1/lambda.
    """
    inverse = jnp.linalg.eigvals(factorise(k).solve(-g))
    real = jnp.isfinite(inverse.real) & (jnp.abs(inverse.imag) <= REAL * jnp.abs(inverse))
    inverse = jnp.where(real, inverse.real, 0.0)
    bounded = (jnp.abs(inverse) > jnp.max(jnp.abs(inverse), initial=0.0) / UNBOUNDED) & (inverse != 0)
    found = jnp.where(bounded, 1 / jnp.where(bounded, inverse, 1.0), jnp.inf)
    return found[jnp.argsort(jnp.abs(found))]


@jit
def _buckling(topology: Topology, parameters: Parameters):
    k, g, dfx, result = _stiffnesses(topology, parameters)
    inverse, vectors = _inverse_multipliers(topology, k, g)
    largest = jnp.max(jnp.abs(inverse), initial=0.0)
    bounded = (jnp.abs(inverse) > largest / UNBOUNDED) & (inverse != 0)
    multiplier = jnp.where(bounded, 1 / jnp.where(bounded, inverse, 1.0), jnp.inf)
    stable = is_positive_definite((k + k.T) / 2)
    result = jnp.where((result == RESULTS.successful) & ~stable, RESULTS.unstable, result)
    return multiplier, dfx @ vectors, result


def buckling_loads(model: Model, *, throw: bool = True) -> Float[Array, "n_q"]:
    """Load multipliers of linear buckling.

    Args:
        model: Mechanism with loads; differentiable in ``model.parameters``. With incremental loads, those are scaled
            and the others are a constant preload; otherwise all loads are scaled.
        throw: Raise where the equilibrium fails or is unstable.

    Returns:
        (n_q,) [-], by magnitude, sign kept, infinite where the load does not act.

    Raises:
        AnalysisError: The equilibrium was not found, or its stiffness is not positive definite.

    Source:
        det(K0 + N0 + lambda G0) = 0, tutorial WA 1239 (2012), eq. (A.2).
    """
    multiplier, _, result = _buckling(model.topology, model.parameters)
    check(result, throw)
    return multiplier


def buckling(model: Model, *, throw: bool = True) -> Buckling:
    """Load multipliers and modes of linear buckling.

    Args:
        model: Mechanism with loads; see :func:`buckling_loads`.
        throw: Raise where the equilibrium fails or is unstable.

    Returns:
        Buckling with multipliers (n,) [-] and shapes (n_x, n); unbounded ones are left out.

    Raises:
        AnalysisError: See :func:`buckling_loads`.

    Source:
        See :func:`buckling_loads`.
    """
    multiplier, shapes, result = _buckling(model.topology, model.parameters)
    check(result, throw)
    bounded = int(np.sum(np.isfinite(multiplier)))
    shapes = np.asarray(shapes[:, :bounded])
    largest = shapes[np.argmax(np.abs(shapes), axis=0), np.arange(bounded)]
    return Buckling(multiplier[:bounded], jnp.asarray(shapes / largest), linearize(model, throw=throw))
