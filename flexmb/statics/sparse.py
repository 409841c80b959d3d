"""Equilibrium of large mechanisms: all coordinates, one multiplier for each constraint, sparse factors.

Element matrices are computed by compiled code, added up and factored on the host. One turn of Newton's method is
written once; turns follow each other on the host where numbers are known, inside compiled code where they are traced:
there a call of the host answers the linear equations. Only what is compiled for the former is kept on disk.
"""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import is_concrete
from ..compilation.threads import one_thread
from ..errors import ModelError
from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..mechanics.blocks import kernel, scatter_vector
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.inertia import Felt, weight, work_of_weight
from ..mechanics.loads import LoadFactors, has_loads, lacks_potential, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import free_deformations, is_nonlinear, is_nonlinear_at_rest, stress_of_strain
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check
from .newton import AT_LOAD, SMALLEST_LOAD_STEP, near_enough, next_load_step, shorter_load_step
from .solve import CRITICAL, ROUND_OFF, held_values
from .sparse_structure import structure_of
from .tangent import elastic_stress, falls, pieces_at, unknowns


class Balanced(NamedTuple):
    """Equilibrium in all coordinates.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        multipliers: Stress resultants of the held deformations, (h,) [N, N m].
        iterations: Newton iterations.
        result: Code of RESULTS.
    """

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    iterations: Any = 0
    result: Any = 0


class _Iterate(NamedTuple):
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


class _Search(NamedTuple):
    """The search at a turn: where the last load step ended, and the iterate at the next; as with dense matrices."""

    done: _Iterate
    trial: _Iterate
    reached: Float[Array, ""]
    step: Float[Array, ""]
    first: Float[Array, ""]
    before: Float[Array, ""]
    soft: Float[Array, "n"]
    softness: Float[Array, ""]
    tries: Int[Array, ""]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    finished: Bool[Array, ""]


class _Equations(NamedTuple):
    """Linear equations of a turn.

    Attributes:
        stiff, rows: Element matrices, see :class:`flexmb.statics.tangent.Pieces`.
        right: What the equations lack, and the force that bends the softest motion, (n + h, 2).
    """

    stiff: list[Array]
    rows: list[Array]
    right: Float[Array, "m 2"]


def _load_of(target: LoadFactors, s: _Search) -> tuple[Array, LoadFactors]:
    load = jnp.minimum(s.reached + s.step, 1.0)
    return load, LoadFactors(*(load * jnp.asarray(factor, float) for factor in target))


def _strained(topology: Topology, parameters: Parameters, factors: LoadFactors, carried: Float[Array, "n_e"]):
    """Deformations of which the search carries those that make stress."""
    free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
    return carried if free is None else carried + free


def _along(size: int, places, matrices, v) -> Array:
    """Sum of element matrices times a vector of the whole."""
    pieces = [(r, jnp.einsum("eij,ej->ei", m, v[c])) for (r, c), m in zip(places, matrices, strict=True)]
    return scatter_vector(size, pieces)


@kernel
def _equations(topology: Topology, parameters: Parameters, target: LoadFactors, s: _Search):
    """Linear equations of a turn, and whether nothing but round-off is out of balance."""
    free, fast, held = unknowns(topology)
    n_x, n_e = topology.n_x, topology.n_e
    _, factors = _load_of(target, s)
    x, near, carried, multipliers = s.trial
    strained = _strained(topology, parameters, factors, carried)
    sigma = put(elastic_stress(topology, parameters, factors, strained), held, multipliers)
    found, of_rows, of_stiff, e = pieces_at(topology, parameters, factors, x, near, sigma, strained)
    transposed = [(c, r) for r, c in of_rows], [jnp.swapaxes(d, 1, 2) for d in found.rows]
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    shift = put(jnp.zeros(n_x), fast, wanted_x[fast] - x[fast])
    # The stress of x to first order from that of what is carried.
    stress = jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (e - strained,))
    pulled = _along(n_x, *transposed, put(stress[0] + stress[1], held, 0.0))
    lacking = nodal_forces(topology, parameters, factors, x) - pulled - _along(n_x, of_stiff, found.stiff, shift)
    excess = wanted_e - e - _along(n_e, of_rows, found.rows, shift)
    stretching = of_stiff[: len(found.elastic)]
    diagonals = [jnp.diagonal(m, axis1=1, axis2=2) for m in found.elastic]
    stiffness = scatter_vector(n_x, [(r, d) for (r, _), d in zip(stretching, diagonals, strict=True)])
    # A motion to which no mode of a symmetric mechanism is orthogonal, its energy spread over soft and stiff ones.
    uneven = jnp.cos(jnp.arange(1.0, len(free) + 1) ** 2) * jnp.sqrt(jnp.abs(stiffness[free]))
    bending = _along(n_x, stretching, found.elastic, put(jnp.zeros(n_x), free, s.soft))[free]
    bending = jnp.where(jnp.any(s.soft != 0), bending, uneven)
    none = jnp.zeros(len(held))
    right = jnp.stack([jnp.concatenate([lacking[free], excess[held]]), jnp.concatenate([bending, none])], axis=1)
    still = jnp.array(False)
    if not has_loads(topology, parameters):
        # What round-off of the deformations pulls.
        error = ROUND_OFF * _along(n_e, of_rows, [jnp.abs(d) for d in found.rows], sizes_of(topology, parameters))
        largest = jnp.abs(jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (error,))[1])
        pulled = _along(n_x, transposed[0], [jnp.abs(d) for d in transposed[1]], largest)
        still = (s.iterations == 0) & jnp.all(jnp.abs(lacking[free]) <= pulled[free])
    return _Equations(found.stiff, found.rows, right), still


def _answer(topology: Topology, stiff: Any, rows: Any, right: Any, *, falls: bool, transposed: bool = False):
    """Solution of the linear equations on the host, and what they are: a code of RESULTS; NumPy and SciPy alone."""
    structure = structure_of(topology, falls)
    factors = structure.tangent.factors(structure.bordered(stiff, rows))
    if factors.regular:
        return factors.solve(right, transposed), np.array(RESULTS.successful, np.int32)
    if factors.too_large:
        why = RESULTS.out_of_memory
    else:
        why = RESULTS.singular_stiffness if structure.independent(rows) else RESULTS.singular_configuration
    return np.full(np.shape(right), np.nan), np.array(why, np.int32)


def _traced_answer(topology: Topology, stiff, rows, right, *, falls: bool, transposed: bool = False):
    """The same inside compiled code."""
    shapes = jax.ShapeDtypeStruct(right.shape, right.dtype), jax.ShapeDtypeStruct((), np.int32)
    call = functools.partial(_answer, falls=falls, transposed=transposed)
    return jax.pure_callback(call, shapes, topology, stiff, rows, right, vmap_method="sequential")


@kernel
def _turn(topology: Topology, parameters: Parameters, target: LoadFactors, s: _Search, z, code, still) -> _Search:
    """The search after the solution of its linear equations."""
    free, fast, held = unknowns(topology)
    load, factors = _load_of(target, s)
    x, near, carried, _ = s.trial
    wanted_x, _ = held_values(topology, parameters, factors)
    change = put(put(jnp.zeros(topology.n_x), free, z[: len(free), 0]), fast, wanted_x[fast] - x[fast])
    change = jnp.where(still, 0.0, change)
    size = jnp.max(jnp.abs(change) / sizes_of(topology, parameters), initial=0.0)
    first = jnp.where(s.tries == 0, size, s.first)
    bad = AT_LOAD.astray(size, s.before, s.tries)
    done = near_enough(size, load, s.tries) & ~bad
    e, rate = jax.jvp(lambda x: deformations(topology, parameters, x, near), (x,), (change,))
    strained = _strained(topology, parameters, factors, carried)
    # The softest motion, by the power method for the largest 1/mu of K v = mu K0 v.
    softer = z[: len(free), 1]

    def energy(v):
        def stressed(x):
            return deformations(topology, parameters, x, near)

        moved = put(jax.jvp(stressed, (x,), (put(jnp.zeros(topology.n_x), free, v),))[1], held, 0.0)
        return moved @ jax.jvp(lambda e: elastic_stress(topology, parameters, factors, e), (strained,), (moved,))[1]

    new, old = energy(softer), energy(s.soft)
    fine = jnp.isfinite(new) & (new > 0)
    known = fine & (old > 0)
    softness = jnp.where(still, 0.0, jnp.where(known, jnp.sqrt(new / jnp.where(known, old, 1.0)), s.softness))
    soft = jnp.where(fine, softer / jnp.sqrt(jnp.where(fine, new, 1.0)), 0.0)
    after = x + change
    carry = e + rate - strained + carried
    near = deformations(topology, parameters, after, e) if topology.counts_turns else e + rate
    trial = _Iterate(after, near, carry, z[len(free) :, 0])
    trial = jax.tree.map(lambda a, b: jnp.where(still, b, a), trial, s.trial)
    shorter = shorter_load_step(s.step, first, s.tries)
    longer = next_load_step(s.step, first, size / s.before)
    failed = bad & (shorter < SMALLEST_LOAD_STEP)
    why = jnp.where(code == RESULTS.successful, RESULTS.not_converged, code)
    reached = jnp.where(done, load, s.reached)
    finished = failed | (done & (load >= 1.0))
    critical = finished & ~failed & (softness > 1 / CRITICAL)
    found = jnp.where(failed, why, jnp.where(critical, RESULTS.critical_state, RESULTS.successful))
    return _Search(
        done=jax.tree.map(lambda a, b: jnp.where(done, a, b), trial, s.done),
        trial=jax.tree.map(lambda a, b: jnp.where(bad, b, a), trial, s.done),
        reached=reached,
        step=jnp.where(bad, shorter, jnp.where(done, longer, s.step)),
        first=first,
        before=jnp.where(bad | done, jnp.inf, size),
        soft=soft,
        softness=softness,
        tries=jnp.where(bad | done, 0, s.tries + 1),
        iterations=s.iterations + 1,
        result=found.astype(jnp.int32),
        finished=finished,
    )


def _start(topology: Topology, parameters: Parameters) -> _Search:
    """The undeformed mechanism."""
    free, _, held = unknowns(topology)
    none, zero = zero_near(topology), jnp.zeros((), jnp.int32)
    begin = _Iterate(jnp.asarray(parameters.reference, float), none, none, jnp.zeros(len(held)))
    reached, step, first, before = (jnp.array(v) for v in (0.0, 1.0, 1.0, jnp.inf))
    soft = jnp.zeros(len(free)), jnp.array(0.0)
    return _Search(begin, begin, reached, step, first, before, *soft, zero, zero, zero, jnp.array(False))


@jax.custom_jvp
def _balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium by Newton's method on coordinates and multipliers, see :func:`flexmb.mechanics.residual.iterate`.

    Its derivative is one solution with factors of the tangent at the state.
    """
    s = _start(topology, parameters)
    if not (has_loads(topology, parameters) or is_nonlinear_at_rest(topology)):
        return Balanced(s.done.x, s.done.multipliers, s.iterations, s.result)
    answer = functools.partial(_answer, falls=falls(parameters))
    if is_concrete((topology, parameters, target)):
        while not s.finished:
            linear, still = _equations(topology, parameters, target, s)
            on_host = jax.tree.map(np.asarray, (topology, *linear))
            s = _turn(topology, parameters, target, s, *answer(*on_host), still)
    else:
        answer = functools.partial(_traced_answer, falls=falls(parameters))

        def turn(s: _Search) -> _Search:
            linear, still = _equations(topology, parameters, target, s)
            return _turn(topology, parameters, target, s, *answer(topology, *linear), still)

        s = jax.lax.while_loop(lambda s: ~s.finished, turn, s)
    return Balanced(s.done.x, s.done.multipliers, s.iterations, s.result)


@kernel
def _residual(topology: Topology, parameters: Parameters, factors: LoadFactors, near, at: Balanced):
    """Forces out of balance at the coordinates that move, and excess of the held deformations."""
    free, fast, held = unknowns(topology)
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    x = put(at.x, fast, wanted_x[fast])
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    sigma = put(elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, x)
    return jnp.concatenate([force[free], (e - wanted_e)[held]])


@kernel
def _tangent(topology: Topology, parameters: Parameters, factors: LoadFactors, near, at: Balanced):
    """Element matrices of the tangent at a state, and where they stand in x."""
    sigma = put(elastic_stress(topology, parameters, factors, near), unknowns(topology)[2], at.multipliers)
    found, of_rows, of_stiff, _ = pieces_at(topology, parameters, factors, at.x, near, sigma, near)
    return found.stiff, found.rows, of_stiff, of_rows


@_balanced.defjvp
def _balance_jvp(primals, tangents):
    topology, parameters, factors = primals
    solved = _balanced(topology, parameters, factors)
    near = deformations(topology, parameters, solved.x, zero_near(topology))
    free, fast, held = unknowns(topology)

    def equations(parameters, factors):
        return _residual(topology, parameters, factors, near, solved)

    _, change = jvp_of_varied(equations, primals[1:], tangents[1:])
    _, moved = jvp_of_varied(lambda *numbers: held_values(topology, *numbers)[0][fast], primals[1:], tangents[1:])
    stiff, rows, of_stiff, of_rows = _tangent(topology, parameters, factors, near, solved)
    n = free.shape[0]

    def matvec(z):
        # As products of element matrices: JAX traces and transposes them for each derivative.
        motion, multipliers = put(jnp.zeros(topology.n_x), free, z[:n]), put(jnp.zeros(topology.n_e), held, z[n:])
        transposed = [(c, r) for r, c in of_rows], [jnp.swapaxes(d, 1, 2) for d in rows]
        pulled = _along(topology.n_x, of_stiff, stiff, motion) + _along(topology.n_x, *transposed, multipliers)
        return jnp.concatenate([pulled[free], _along(topology.n_e, of_rows, rows, motion)[held]])

    def solve(transposed: bool):
        how = functools.partial(_traced_answer, falls=falls(parameters), transposed=transposed)
        return lambda _, right: how(topology, *jax.lax.stop_gradient((stiff, rows)), right)[0]

    z = jax.lax.custom_linear_solve(matvec, -change, solve(False), solve(True))
    dx = put(put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), fast, moved)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return solved, Balanced(dx, z[free.shape[0] :], no_change, no_change)


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


def balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium, differentiable; a critical one is as good as others.

    Raises:
        AnalysisError: singular_configuration, singular_stiffness or not_converged, where numbers are known.
    """
    found = _balanced(topology, parameters, target)
    check(found.result, True)
    return found


def refuse_what_is_not_sparse(topology: Topology) -> None:
    """Raise where analyses of vibration, buckling and paths by sparse factors have no equations.

    Raises:
        ModelError: Loads that follow a body, moments about fixed axes, or elements with a law or an energy.
    """
    if lacks_potential(topology) or is_nonlinear(topology):
        raise ModelError(
            "The sparse path takes dead loads, gravity and elements of constant stiffness: no moments about fixed axes"
            " in space, loads that follow a body, laws or energies. Leave `sparse` out."
        )


def refuse_traced(*trees) -> None:
    """Raise where a number is traced."""
    if not is_concrete(trees):
        raise TypeError("The sparse path runs on the host: call it outside jax.jit and jax.vmap; jax.grad applies.")


@one_thread()
def sparse_equilibrium(topology: Topology, parameters: Parameters, target: LoadFactors) -> tuple[Any, ...]:
    """Static equilibrium by sparse factors.

    Args:
        topology: Structure, which needs no degrees of freedom (``Builder.build(check=False)``).

    Returns:
        What an :class:`flexmb.statics.Equilibrium` holds, but for the names: x, e, sigma, felt, reactions, external,
        iterations, result.
    """
    at = _balanced(topology, parameters, target)
    return *_quantities(topology, parameters, target, at), at.iterations, at.result


@kernel
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
