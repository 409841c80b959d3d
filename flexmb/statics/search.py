"""Turns of Newton's method in all coordinates with one multiplier a constraint: equations, and what follows from them.

Sparse factors on the host (:mod:`.sparse`) solve the linear equations of a turn.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..math.element_matrices import ElementMatrices, Pieces
from ..math.indices import put
from ..math.linear import uneven
from ..mechanics.blocks import kernel, scatter_vector
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, has_loads, is_idle, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import free_deformations, is_nonlinear_at_rest
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .newton import LoadStep, first_load_step
from .solve import CRITICAL, ROUND_OFF, held_values
from .tangent import elastic_stress, element_matrices, unknowns


class Iterate(NamedTuple):
    """State of Newton's method.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations that angles are counted from, (n_e,) [m, rad].
        strained: Deformations less those that are free of stress, as the iteration carries them, (n_e,) [m, rad].
        multipliers: Stress resultants of the held deformations, (h,) [N, N m].
    """

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    multipliers: Float[Array, "h"]


class Search(NamedTuple):
    """The search at a turn: where the last load step ended, and the iterate at the next; as with dense matrices."""

    done: Iterate
    trial: Iterate
    steps: LoadStep
    soft: Float[Array, "n"]
    softness: Float[Array, ""]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    finished: Bool[Array, ""]


class LinearEquations(NamedTuple):
    """Linear equations of a turn.

    Attributes:
        elements: Element matrices, those by deformations left out.
        right: What the equations lack, and the force that bends the softest motion, (n + h, 2).
        e: Deformations, (n_e,) [m, rad].
    """

    elements: ElementMatrices
    right: Float[Array, "m 2"]
    e: Float[Array, "n_e"]


def _factors(target: LoadFactors, s: Search) -> LoadFactors:
    """Load factors that a turn is at."""
    return LoadFactors(*(s.steps.load * jnp.asarray(factor, float) for factor in target))


def _strained(topology: Topology, parameters: Parameters, factors: LoadFactors, carried: Float[Array, "n_e"]):
    """Deformations of which the search carries those that make stress."""
    free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
    return carried if free is None else carried + free


def along(size: int, pieces: Pieces, v: Float[Array, "n"]) -> Array:
    """Sum of element matrices times a vector of the whole."""
    return scatter_vector(size, [(r, jnp.einsum("eij,ej->ei", own, v[c])) for r, c, own in pieces])


@kernel
def linear_equations(topology: Topology, parameters: Parameters, target: LoadFactors, s: Search):
    """Linear equations of a turn, and whether nothing but round-off is out of balance."""
    free, fast, held = unknowns(topology)
    n_x, n_e = topology.n_x, topology.n_e
    factors = _factors(target, s)
    x, near, carried, multipliers = s.trial
    strained = _strained(topology, parameters, factors, carried)
    sigma = put(elastic_stress(topology, parameters, factors, strained), held, multipliers)
    found, e = element_matrices(topology, parameters, factors, x, near, sigma, strained)
    transposed = [(c, r, jnp.swapaxes(d, 1, 2)) for r, c, d in found.constraints]
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    shift = put(jnp.zeros(n_x), fast, wanted_x[fast] - x[fast])
    # The stress of x to first order from that of what is carried.
    stress = jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (e - strained,))
    pulled = along(n_x, transposed, put(stress[0] + stress[1], held, 0.0))
    lacking = nodal_forces(topology, parameters, factors, x) - pulled - along(n_x, found.stiffness, shift)
    excess = wanted_e - e - along(n_e, found.constraints, shift)
    diagonals = [(r, jnp.diagonal(own, axis1=1, axis2=2)) for r, _, own in found.structural]
    stiffness = scatter_vector(n_x, diagonals)
    # Its energy is spread over soft and stiff motions.
    begin = uneven(len(free), 1, jnp) * jnp.sqrt(jnp.abs(stiffness[free]))
    bending = along(n_x, found.structural, put(jnp.zeros(n_x), free, s.soft))[free]
    bending = jnp.where(jnp.any(s.soft != 0), bending, begin)
    none = jnp.zeros(len(held))
    right = jnp.stack([jnp.concatenate([lacking[free], excess[held]]), jnp.concatenate([bending, none])], axis=1)
    loaded, still = has_loads(topology, parameters), s.iterations == 0
    if loaded:
        still = still & is_idle(topology, parameters, target) & jnp.all(x == parameters.reference)
    if not loaded or is_nonlinear_at_rest(topology):
        # What round-off of the deformations pulls.
        sized = [(r, c, jnp.abs(d)) for r, c, d in found.constraints]
        error = ROUND_OFF * along(n_e, sized, found.sizes)
        largest = jnp.abs(jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (error,))[1])
        pulled = along(n_x, [(c, r, jnp.abs(d)) for c, r, d in transposed], largest)
        still = still & jnp.all(jnp.abs(lacking[free]) <= pulled[free])
    return LinearEquations(found._replace(elastic=[]), right, e), still


@kernel
def corrected(
    topology: Topology,
    parameters: Parameters,
    target: LoadFactors,
    s: Search,
    equations: LinearEquations,
    z: Float[Array, "k 2"],
    code: Int[Array, ""],
    still: Bool[Array, ""],
) -> Search:
    """The search after the solution of its linear equations."""
    free, fast, held = unknowns(topology)
    factors = _factors(target, s)
    x, _, carried, _ = s.trial
    wanted_x, _ = held_values(topology, parameters, factors)
    change = put(put(jnp.zeros(topology.n_x), free, z[: len(free), 0]), fast, wanted_x[fast] - x[fast])
    change = jnp.where(still, 0.0, change)
    size = jnp.max(jnp.abs(change) / sizes_of(topology, parameters), initial=0.0)
    bad = s.steps.astray(size)
    # Where nothing moves, the tangent of the first turn knows neither multipliers nor the stress of what is warmed.
    done = s.steps.near_enough(size) & (still | (s.steps.tries > 0)) & ~bad
    rows, e = equations.elements.constraints, equations.e
    rate = along(topology.n_e, rows, change)
    strained = _strained(topology, parameters, factors, carried)
    # The softest motion, by the power method for the largest 1/mu of K v = mu K0 v.
    softer = z[: len(free), 1]

    def energy(v: Float[Array, "n"]):
        moved = along(topology.n_e, rows, put(jnp.zeros(topology.n_x), free, v))
        moved = put(moved, held, 0.0)
        return moved @ jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (moved,))[1]

    new, old = jax.vmap(energy)(jnp.stack([softer, s.soft]))
    fine = jnp.isfinite(new) & (new > 0)
    both = fine & (old > 0)
    softness = jnp.where(still, 0.0, jnp.where(both, jnp.sqrt(new / jnp.where(both, old, 1.0)), s.softness))
    soft = jnp.where(fine, softer / jnp.sqrt(jnp.where(fine, new, 1.0)), 0.0)
    after = x + change
    carry = e + rate - strained + carried
    near = deformations(topology, parameters, after, e) if topology.counts_turns else e + rate
    trial = Iterate(after, near, carry, z[len(free) :, 0])
    trial = jax.tree.map(lambda a, b: jnp.where(still, b, a), trial, s.trial)
    steps, failed = s.steps.after(size, done, bad)
    why = jnp.where(code == RESULTS.successful, RESULTS.not_converged, code)
    finished = failed | (done & (s.steps.load >= 1.0))
    critical = finished & ~failed & (softness > 1 / CRITICAL)
    found = jnp.where(failed, why, jnp.where(critical, RESULTS.critical_state, RESULTS.successful))
    return Search(
        done=jax.tree.map(lambda a, b: jnp.where(done, a, b), trial, s.done),
        trial=jax.tree.map(lambda a, b: jnp.where(bad, b, a), trial, s.done),
        steps=steps,
        soft=soft,
        softness=softness,
        iterations=s.iterations + 1,
        result=found.astype(jnp.int32),
        finished=finished,
    )


def start(topology: Topology, parameters: Parameters) -> Search:
    """The undeformed mechanism."""
    free, _, held = unknowns(topology)
    none, zero = zero_near(topology), jnp.zeros((), jnp.int32)
    begin = Iterate(jnp.asarray(parameters.reference, float), none, none, jnp.zeros(len(held)))
    soft = jnp.zeros(len(free)), jnp.array(0.0)
    return Search(begin, begin, first_load_step(), *soft, zero, zero, jnp.array(False))
