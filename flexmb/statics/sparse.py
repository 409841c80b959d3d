"""Equilibrium of large mechanisms: all coordinates, one multiplier for each constraint, sparse factors.

The matrices are assembled and factored on the host; derivatives need only the work of stresses along given motions,
element by element, and solutions with the same factors.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.inertia import Felt, weight, work_of_weight
from ..mechanics.loads import LoadFactors, has_loads, lacks_potential, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import (
    free_deformations,
    is_nonlinear,
    stress_of_strain,
)
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .newton import AT_LOAD, SMALLEST_LOAD_STEP, near_enough, next_load_step, shorter_load_step
from .solve import held_values
from .tangent import assemble, elastic_stress, unknowns


class Balanced(NamedTuple):
    """Equilibrium in all coordinates.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        multipliers: Stress resultants of the held deformations, (h,) [N, N m].
        iterations: Newton iterations.
    """

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    iterations: Any = 0


@jit
def _held_and_free(topology: Topology, parameters: Parameters, factors: LoadFactors):
    """What is held, and the deformations at which elements are free of stress, (n_e,)."""
    free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
    return held_values(topology, parameters, factors), jnp.zeros(topology.n_e) if free is None else free


def second_variation(topology, parameters, factors, at: Balanced, near, motion) -> tuple[Array, Array, Array]:
    """How the energy changes to second order along a motion of the coordinates that move.

    Returns:
        Its elastic part and that of stress resultants and weight, () [N m]; rates of the held deformations, (h,).
    """
    free, _, held = unknowns(topology)
    phi = put(jnp.zeros(topology.n_x), free, motion)

    def rates(x):
        return jax.jvp(lambda x: deformations(topology, parameters, x, near), (x,), (phi,))

    (e, first), (_, second) = jax.jvp(rates, (at.x,), (phi,))
    sigma = put(elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    stress = put(stress_of_strain(topology, parameters, first), held, 0.0)
    geometric = sigma @ second
    gravity = scaled_loads(parameters, factors).gravity
    if gravity is not None:

        def slope(x):
            return jax.jvp(lambda x: work_of_weight(topology, parameters, x, gravity), (x,), (phi,))[1]

        geometric = geometric - jax.jvp(slope, (at.x,), (phi,))[1]
    return first @ stress, geometric, first[held]


def refuse_traced(*trees) -> None:
    """Raise where a number is traced."""
    if not is_concrete(trees):
        raise TypeError("The sparse path runs on the host: call it outside jax.jit and jax.vmap; jax.grad applies.")


@jax.custom_jvp
def balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium by Newton's method on coordinates and multipliers, see :func:`flexmb.mechanics.residual.iterate`."""
    refuse_traced(parameters, target)
    free, fast, held = (np.asarray(i) for i in unknowns(topology))
    if not has_loads(topology, parameters):
        return Balanced(parameters.reference, jnp.zeros(len(held)), jnp.zeros((), jnp.int32))
    sizes = np.asarray(sizes_of(topology, parameters))[free]
    start = np.asarray(parameters.reference), np.zeros(topology.n_e), np.zeros(len(held))
    reached, step, done, iterations, regular = 0.0, 1.0, start, 0, True
    while reached < 1.0:
        load = min(reached + step, 1.0)
        factors = LoadFactors(*(load * jnp.asarray(f, float) for f in target))
        wanted, free_of_stress = jax.tree.map(np.asarray, _held_and_free(topology, parameters, factors))
        wanted_x, wanted_e = wanted
        (x, strained, multipliers), before, first, contraction, solved = done, np.inf, np.inf, 0.0, False
        # Carried is what makes stress, as in the search with dense matrices.
        near = strained = strained + free_of_stress
        tries = 0
        for tries in range(AT_LOAD.most):
            iterations += 1
            sigma = np.array(elastic_stress(topology, parameters, factors, jnp.asarray(strained)))
            sigma[held] = multipliers
            at = assemble(topology, parameters, factors, x, near, sigma)
            shift = wanted_x[fast] - x[fast]
            right = np.concatenate([(at.force - at.jacobian.T @ at.sigma)[free], wanted_e[held] - at.e[held]])
            factored = at.factors()
            regular = factored.regular
            if not regular:
                break
            z = factored.solve(right - at.coupling @ shift)
            size = np.max(np.abs(z[: len(free)]) / sizes, initial=0.0)
            first = size if tries == 0 else first
            if AT_LOAD.astray(size, before, tries):
                break
            change = np.zeros(topology.n_x)
            change[free], change[fast] = z[: len(free)], shift
            x, multipliers, before, contraction = x + change, z[len(free) :], size, size / before
            near = strained = at.e + at.jacobian @ change
            if near_enough(size, load, tries):
                solved = True
                break
        # Of a first correction that ends the iteration, or of one that is zero, no contraction is known.
        with np.errstate(divide="ignore"):
            if solved:
                done = x, strained - free_of_stress, multipliers
                reached, step = load, next_load_step(step, first, contraction)
                continue
            step = shorter_load_step(step, first, tries)
        if step < SMALLEST_LOAD_STEP:
            why = RESULTS.not_converged if regular else RESULTS.singular_stiffness
            raise AnalysisError(why.name, why.message)
    return Balanced(jnp.asarray(done[0]), jnp.asarray(done[2]), jnp.asarray(iterations, jnp.int32))


@jit
def _residual(topology: Topology, parameters: Parameters, factors: LoadFactors, near, at: Balanced):
    """Forces out of balance at the coordinates that move, and excess of the held deformations."""
    free, fast, held = unknowns(topology)
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    x = put(at.x, fast, wanted_x[fast])
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    sigma = put(elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, x)
    return jnp.concatenate([force[free], (e - wanted_e)[held]])


@balanced.defjvp
def _balance_jvp(primals, tangents):
    topology, parameters, factors = primals
    solved = balanced(topology, parameters, factors)
    near = deformations(topology, parameters, solved.x, zero_near(topology))
    free, fast, held = unknowns(topology)

    def equations(parameters, factors):
        return _residual(topology, parameters, factors, near, solved)

    _, change = jvp_of_varied(equations, primals[1:], tangents[1:])
    _, moved = jvp_of_varied(lambda *numbers: held_values(topology, *numbers)[0][fast], primals[1:], tangents[1:])
    sigma = put(elastic_stress(topology, parameters, factors, near), held, solved.multipliers)
    factored = assemble(topology, parameters, factors, solved.x, near, sigma).factors()

    def matvec(z):
        def along(x, multipliers):
            return _residual(topology, parameters, factors, near, Balanced(x, multipliers))

        direction = put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), z[free.shape[0] :]
        return jax.jvp(along, solved[:2], direction)[1]

    def solve(_, right):
        shape = jax.ShapeDtypeStruct(right.shape, right.dtype)
        return jax.pure_callback(factored.solve, shape, right, vmap_method="sequential")

    z = jax.lax.custom_linear_solve(matvec, -change, solve, symmetric=True)
    dx = put(put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), fast, moved)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return solved, Balanced(dx, z[free.shape[0] :], no_change)


def refuse_what_is_not_sparse(topology: Topology) -> None:
    """Raise where the sparse path has no equations.

    Raises:
        ModelError: Loads that follow a body, moments about fixed axes, or elements with a law or an energy.
    """
    if lacks_potential(topology) or is_nonlinear(topology):
        raise ModelError(
            "The sparse path takes dead loads, gravity and elements of constant stiffness: no moments about fixed axes"
            " in space, loads that follow a body, laws or energies. Leave `sparse` out."
        )


@one_thread()
def sparse_equilibrium(topology: Topology, parameters: Parameters, target: LoadFactors) -> tuple[Any, ...]:
    """Static equilibrium by sparse factors.

    Args:
        topology: Structure, which needs no degrees of freedom (``Builder.build(check=False)``).

    Returns:
        What an :class:`flexmb.statics.Equilibrium` holds, but for the names: x, e, sigma, felt, reactions, external,
        iterations, result.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`.
        AnalysisError: singular_stiffness or not_converged.
    """
    refuse_what_is_not_sparse(topology)
    at = balanced(topology, parameters, target)
    return *_quantities(topology, parameters, target, at), at.iterations, jnp.zeros((), jnp.int32)


@jit
def _quantities(topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced):
    """Coordinates, deformations, stress resultants, what mass feels, reactions and external forces."""
    _, fast, held = unknowns(topology)
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, zero_near(topology)), at.x)
    sigma = put(elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, at.x)
    gravity = scaled_loads(parameters, factors).gravity
    reactions = put(jnp.zeros(topology.n_x), fast, force[fast])
    external = nodal_forces(topology, parameters, factors, at.x) + reactions
    if gravity is not None:
        external = external - weight(topology, parameters, at.x, gravity)
    return at.x, e, sigma, Felt(gravity), reactions, external
