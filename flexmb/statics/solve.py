"""Solution of the static equations: Newton's method on the constraint manifold, with load steps that adapt."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..math.derivative import jvp_of_varied
from ..math.indices import accumulate, put
from ..math.linear import diagonal_of, factorise, uneven
from ..mechanics.deformation import deformation_jacobian, deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.inertia import weight
from ..mechanics.loads import LoadFactors, has_loads, is_idle, nodal_forces, scaled_loads
from ..mechanics.residual import State, iterate, linear_response, state
from ..mechanics.stress_resultants import (
    element_stiffness,
    free_deformations,
    is_nonlinear_at_rest,
    stress_resultants,
    thermal_deformations,
)
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .newton import LoadStep, first_load_step

# Round-off of a deformation, beside what the whole mechanism's extent would make of it.
ROUND_OFF = 1e-13
# An equilibrium is critical where its stiffness K is, in some motion, below this share of the structural stiffness K0.
# At a limit point the share falls with the root of the distance: a change of the load by some 1e-9 of itself doubles
# the derivative there. At a bifurcation it is the distance itself. Free of units, and 1 without load however slender a
# leaf spring is.
CRITICAL = 1e-4
# Where nothing is elastic, as of a pendulum, corrections are shortened to this size, and there are so many at most.
LOOSE_CORRECTION, MOST_LOOSE = 0.5, 30


class Begin(NamedTuple):
    """Where Newton's method begins: the undeformed mechanism, or an equilibrium under other loads.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations there, (n_e,) [m, rad].
        strained: Deformations less those that are free of stress, as the iteration carries them, (n_e,) [m, rad].
        soft: Motion in which the state is softest, (n_q,) [m, rad].
        factors: Load factors there.
    """

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    soft: Float[Array, "n_q"]
    factors: LoadFactors


class _Solved(NamedTuple):
    at: State
    near: Float[Array, "n_e"]
    reached: Begin
    iterations: Int[Array, ""]
    result: Int[Array, ""]


def held_values(topology: Topology, parameters: Parameters, factors: LoadFactors):
    """Coordinates and deformations with the PRESCRIBED ones at their values, the others as undeformed.

    FIXED deformations are those of temperature: a rigid element expands.

    Returns:
        x, (n_x,) [m, rad, -], and e, (n_e,) [m, rad].
    """
    loads = scaled_loads(parameters, factors)
    x, e = parameters.reference, jnp.zeros(topology.n_e)
    if loads.x is not None:
        x = accumulate(x, topology.x.prescribed, loads.x)
    if loads.temperature is not None:
        fixed = topology.e.fixed
        e = put(e, fixed, thermal_deformations(topology, parameters, loads.temperature)[fixed])
    if loads.e is not None:
        e = put(e, topology.e.prescribed, loads.e)
    return x, e


class _Search(NamedTuple):
    at: State
    finishing: Bool[Array, ""]
    finished: Bool[Array, ""]
    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    trial: Float[Array, "n_x"]
    trial_near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    trial_strained: Float[Array, "n_e"]
    steps: LoadStep
    soft: Float[Array, "n_q"]
    softness: Float[Array, ""]
    iterations: Int[Array, ""]
    result: Int[Array, ""]


def _uneven(k0: Float[Array, "n_q n_q"]) -> Float[Array, "n_q"]:
    """A motion to which no mode of a symmetric mechanism is orthogonal, its energy spread over soft and stiff ones."""
    diagonal = diagonal_of(k0)
    return uneven(k0.shape[0], 1, jnp) / jnp.sqrt(jnp.where(diagonal > 0, diagonal, 1.0))


def _of_unit_energy(soft: Float[Array, "n_q"], k0: Float[Array, "n_q n_q"]) -> tuple[Array, Array]:
    """A motion of unit energy, uneven where one has none, and the energy that it has by the same stiffness."""
    energy = soft @ k0 @ soft
    kept = (energy > 0) & jnp.isfinite(energy)
    soft = jnp.where(kept, soft / jnp.sqrt(jnp.where(kept, energy, 1.0)), _uneven(k0))
    return soft, soft @ k0 @ soft


def undeformed(topology: Topology, parameters: Parameters) -> Begin:
    """The beginning without loads."""
    none, zero = zero_near(topology), jnp.array(0.0)
    return Begin(parameters.reference, none, none, jnp.zeros(topology.n_q), LoadFactors(zero, zero))


def _search(topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin) -> _Solved:
    """Equilibrium by one loop whose every turn is one Newton iteration; load steps begin, grow and shrink inside it.

    Deformations and their stress are carried as numbers of their own, see ``iterate``; where elements are free of
    stress at others than zero, what is carried is the difference: a leaf spring that is warmed would otherwise begin
    with the stress of one between rigid walls, beyond buckling. The last turn evaluates the state that was found and
    leaves it as it is: outside the loop its equations would be compiled once more.

    Beside the Newton iteration runs the power method for the largest 1/mu of K v = mu K0 v, one step a turn with the
    factors at hand: from below, whether the state is critical.
    """
    sizes = sizes_of(topology, parameters)
    tracks = topology.counts_turns
    loaded = has_loads(topology, parameters)
    idle, laws = is_idle(topology, parameters, target), is_nonlinear_at_rest(topology)
    # What is moved goes by steps, of which a pendulum's fall has no need.
    moved = topology.x.prescribed.shape[0] + topology.e.prescribed.shape[0] > 0
    falls = topology.n_q > 0 and not moved and parameters.loads.temperature is None

    def turn(s: _Search) -> _Search:
        going, steps = ~s.finishing, s.steps
        load = jnp.where(going, steps.load, 1.0)
        # At the end exactly the target.
        factors = LoadFactors(*((1 - load) * a + load * b for a, b in zip(begin.factors, target, strict=True)))
        wanted = held_values(topology, parameters, factors)
        free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
        strained = s.trial_strained if free is None else s.trial_strained + free
        at, onto, residual = iterate(topology, parameters, factors, s.trial, s.trial_near, strained, wanted)
        k0 = at.K0
        soft, energy = _of_unit_energy(s.soft, k0)
        dq, softer = factorise(k0 + at.G0).solve(jnp.stack([-residual, k0 @ soft], axis=1)).T
        change = onto + at.transfer.DFx @ dq
        # Undeformed, where loads are zero and laws pull nothing, no stiffness is asked for.
        still = s.iterations == 0
        if loaded:
            still = still & idle & jnp.all(s.trial == parameters.reference)
        if not loaded or laws:
            still = still & _is_round_off(at, residual, sizes)
        change = jnp.where(still, 0.0, change)
        size = jnp.max(jnp.abs(change) / sizes)
        bad = going & steps.astray(size)
        if falls:
            # Where nothing is elastic a smaller load makes no smaller correction. Tried once, at the whole load.
            loose = ~jnp.any(diagonal_of(k0) > 0) & jnp.isfinite(size) & (steps.tries < MOST_LOOSE)
            loose = loose & (steps.reached == 0) & (steps.step == 1)
            change = jnp.where(loose & (size > LOOSE_CORRECTION), change * (LOOSE_CORRECTION / size), change)
            bad = bad & ~loose
        done = going & steps.near_enough(size) & ~bad
        trial = s.trial + change
        # The turn of an angle follows the iterate, whose steps are below half a turn.
        near = deformations(topology, parameters, trial, at.e) if tracks else at.e
        strained = at.e + at.jacobian @ change
        strained = strained if free is None else strained - free
        following, failed = steps.after(size, done, bad)
        # Zero where nothing is stiff without load: that alone is no critical state.
        softness = jnp.where(still, 0.0, jnp.sqrt(softer @ k0 @ softer / jnp.where(energy > 0, energy, 1.0)))

        def choose(if_bad: Array, if_done: Array, otherwise: Array):
            return jnp.where(bad, if_bad, jnp.where(done, if_done, otherwise))

        return _Search(
            at=at,
            finishing=failed | (done & (load >= 1.0)),
            finished=s.finishing,
            x=jnp.where(done, trial, s.x),
            near=jnp.where(done, near, s.near),
            trial=choose(s.x, trial, trial),
            trial_near=choose(s.near, near, near),
            strained=jnp.where(done, strained, s.strained),
            trial_strained=choose(s.strained, strained, strained),
            steps=following,
            soft=softer,
            softness=jnp.where(going, softness, s.softness),
            iterations=s.iterations + going.astype(jnp.int32),
            result=jnp.where(failed, _why(at, change), s.result).astype(jnp.int32),
        )

    start = _start(topology, parameters, target, begin)
    end = jax.lax.while_loop(lambda s: ~s.finished, turn, start)
    critical = (end.result == RESULTS.successful) & (end.softness > 1 / CRITICAL)
    result = jnp.where(critical, RESULTS.critical_state, end.result).astype(jnp.int32)
    share = jnp.where(end.result == RESULTS.successful, 1.0, end.steps.reached)
    factors = LoadFactors(*((1 - share) * a + share * b for a, b in zip(begin.factors, target, strict=True)))
    reached = Begin(end.x, end.near, end.strained, end.soft, factors)
    return _Solved(end.at, end.near, reached, end.iterations, result)


def _start(topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin) -> _Search:
    """The search before its first turn."""
    x0, near0 = begin.x, begin.near
    zero, no = jnp.zeros((), jnp.int32), jnp.array(False)
    nothing = jax.eval_shape(lambda x, near: state(topology, parameters, target, x, near), x0, near0)
    return _Search(
        at=jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing),
        finishing=no,
        finished=no,
        x=x0,
        near=near0,
        trial=x0,
        trial_near=near0,
        strained=begin.strained,
        trial_strained=begin.strained,
        steps=first_load_step(),
        soft=begin.soft,
        softness=jnp.array(0.0),
        iterations=zero,
        result=zero,
    )


def _why(at: State, change: Float[Array, "n_x"]) -> Int[Array, ""]:
    """Code of a search that failed."""
    singular = ~jnp.all(jnp.isfinite(change))
    why = jnp.where(singular, RESULTS.singular_stiffness, RESULTS.not_converged)
    return jnp.where(at.transfer.regular, why, RESULTS.singular_configuration)


def _is_round_off(at: State, residual: Float[Array, "n_q"], sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
    """Whether nothing but round-off of the deformations is out of balance."""
    error = ROUND_OFF * jnp.abs(at.jacobian) @ sizes
    largest = jnp.abs(at.transfer.DFe).T @ (jnp.abs(at.S) @ error)
    return jnp.all(jnp.abs(residual) <= largest)


@jax.custom_jvp
def _solve(topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin) -> _Solved:
    return _search(topology, parameters, target, begin)


def change_of_equations(
    topology: Topology, at: State, near: Float[Array, "n_e"], primals: tuple, tangents: tuple
) -> tuple[Float[Array, "n_e"], Float[Array, "n_x"], Float[Array, "n_x"]]:
    """Change of the equilibrium equations with parameters and load factors, at constant x.

    Args:
        at: State in equilibrium.
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        primals: Parameters and load factors.
        tangents: Their changes; a leaf may be a ``SymbolicZero``.

    Returns:
        excess (n_e,) [m, rad], shift (n_x,) [m, rad, -] and imbalance (n_x,) [N, N m], as ``reduced_response`` takes
        them: the particular solution keeps the DOF deformations.

    Source:
        Implicit function theorem on THEORY.md 5, eq. (5.1); THEORY.md 10, eq. (10.1).
    """

    def equations(parameters: Parameters, target: LoadFactors):
        e, jacobian = deformation_jacobian(topology, parameters, at.x, near)
        stiffness = element_stiffness(topology, parameters)
        sigma = stress_resultants(topology, parameters, scaled_loads(parameters, target), stiffness, e)
        held = topology.e.held
        sigma = put(sigma, held, at.sigma[held])
        wanted_x, wanted_e = held_values(topology, parameters, target)
        force = nodal_forces(topology, parameters, target, at.x)
        return jacobian.T @ sigma - force, e - wanted_e, wanted_x

    _, (imbalance, excess, wanted) = jvp_of_varied(equations, primals, tangents)
    held = topology.x.held
    shift = put(jnp.zeros(topology.n_x), held, wanted[held])
    return put(excess, topology.e.dof, 0.0) + at.jacobian @ shift, shift, imbalance


def _solve_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """The derivative of the equations at constant x, answered by the tangent; where the search began has no part."""
    topology, parameters, target, begin = primals
    solved = _solve(topology, parameters, target, begin)
    near = jax.lax.stop_gradient(solved.near)
    excess, shift, imbalance = change_of_equations(topology, solved.at, near, primals[1:3], tangents[1:3])
    dx, _ = linear_response(topology, solved.at, excess, shift, imbalance)

    def evaluated(parameters: Parameters, target: LoadFactors, x: Float[Array, "n_x"]):
        return state(topology, parameters, target, x, near)

    _, changed = jvp_of_varied(evaluated, (parameters, target, solved.at.x), (*tangents[1:3], dx))
    no_change: Any = np.zeros((), jax.dtypes.float0)
    still = jax.tree.map(jnp.zeros_like, solved.reached)
    return solved, _Solved(changed, jnp.zeros_like(near), still, no_change, no_change)


_solve.defjvp(_solve_jvp, symbolic_zeros=True)


def solve_state(
    topology: Topology, parameters: Parameters, target: LoadFactors, tell_critical: bool = False
) -> tuple[State, Float[Array, "n_e"], Int[Array, ""], Int[Array, ""], LoadFactors]:
    """Equilibrium and everything of first order about it; differentiable. Part of the compiled kernels.

    Args:
        target: Load factors of the equilibrium.
        tell_critical: Whether the code says that a state is critical. It is right all the same, and what is asked about
            its stiffness has an answer.

    Returns:
        State, ``near``, code of RESULTS, number of Newton iterations, and the load factors that load steps reached.
    """
    # What the laws of elements pull in the undeformed mechanism is known only as a number.
    if has_loads(topology, parameters) or is_nonlinear_at_rest(topology):
        begin = undeformed(topology, parameters)
        at, near, result, iterations, reached = solve_onward(topology, parameters, target, begin)
        if not tell_critical:
            result = jnp.where(result == RESULTS.critical_state, RESULTS.successful, result)
        return at, near, result, iterations, reached.factors
    near, zero = zero_near(topology), jnp.zeros((), jnp.int32)
    at = state(topology, parameters, target, parameters.reference, near, loaded=False)
    return at, near, _of_regular(at, zero), zero, target


def solve_onward(
    topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin
) -> tuple[State, Float[Array, "n_e"], Int[Array, ""], Int[Array, ""], Begin]:
    """Equilibrium from a known one, with loads between them; differentiable. Part of the compiled kernels.

    Args:
        target: Load factors of the equilibrium.
        begin: Where the search begins; derivatives do not pass through it.

    Returns:
        State, ``near``, code of RESULTS, critical_state among them, number of Newton iterations, and what the next
        equilibrium may begin from.
    """
    at, near, reached, iterations, result = _solve(topology, parameters, target, begin)
    return at, near, _of_regular(at, result), iterations, jax.lax.stop_gradient(reached)


def _of_regular(at: State, result: Int[Array, ""]) -> Int[Array, ""]:
    found = (result == RESULTS.successful) | (result == RESULTS.critical_state)
    return jnp.where(found & ~at.transfer.regular, RESULTS.singular_configuration, result).astype(jnp.int32)


def reactions_of(topology: Topology, at: State) -> Float[Array, "n_x"]:
    """Forces of the supports on the mechanism, at FIXED and PRESCRIBED coordinates, zero elsewhere.

    Returns:
        D_x^T sigma - f there, (n_x,) [N, N m].
    """
    held = topology.x.held
    return put(jnp.zeros(topology.n_x), held, (at.jacobian.T @ at.sigma - at.force)[held])


def external_of(topology: Topology, parameters: Parameters, at: State) -> Float[Array, "n_x"]:
    """Forces that act on the mechanism from outside: loads but weight, and reactions.

    Returns:
        D_x^T sigma less weight, at coordinates that move the load itself, which that balances, (n_x,) [N, N m].
    """
    loads = at.force if at.gravity is None else at.force - weight(topology, parameters, at.x, at.gravity)
    return loads + reactions_of(topology, at)
