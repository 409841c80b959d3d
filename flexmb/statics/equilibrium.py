"""Static equilibrium: Newton's method on the constraint manifold, with load steps that adapt."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_flag, check_number, is_concrete
from ..compilation.compile import jit
from ..compilation.record import Record, static
from ..display import Result, Summary, largest
from ..errors import ModelError, warn
from ..math.derivative import jvp_of_varied
from ..math.indices import accumulate, put
from ..math.linear import diagonal_of, factorise
from ..mechanics.deformation import deformation_jacobian, deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.inertia import Felt
from ..mechanics.loads import LoadFactors, has_loads, load_factors, nodal_forces, scaled_loads
from ..mechanics.residual import State, iterate, linear_response, state
from ..mechanics.stress_resultants import element_stiffness, is_nonlinear, stress_resultants
from ..model.model import Labels, Model, as_determined, as_model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check

# A step this small beside the mechanism is taken and ends the iteration: the error left is its square.
STEP_TOLERANCE = 1e-9
# On the way, a load step ends sooner.
LOOSE_TOLERANCE = 0.02
# A Newton step larger than this (extents of the mechanism, radians) is refused and the load step shortened: beyond
# it angles could be counted into another turn and the iterate fall to another branch.
LARGEST_STEP = 0.75
# So is one that is not this much smaller than the one before it: Newton's method then left the neighbourhood of the
# path, and what it finds may be another branch (Deuflhard 2011, Newton Methods for Nonlinear Problems, section 5.1).
CONTRACTION = 0.35
MAX_ITERATIONS = 12
# Round-off of a deformation, beside what the whole mechanism's extent would make of it.
ROUND_OFF = 1e-13
# An equilibrium is critical where its stiffness K is, in some motion, below this share of the structural stiffness K0.
# At a limit point the share falls with the root of the distance: a change of the load by some 1e-9 of itself doubles
# the derivative there. At a bifurcation it is the distance itself. Free of units, and 1 without load however slender a
# leaf spring is.
CRITICAL = 1e-4
SMALLEST_LOAD_STEP = 1e-5


class Equilibrium(Result, Record):
    """Static equilibrium under constant loads.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        e: Deformations, (n_e,) [m, rad].
        sigma: Stress resultants; for FIXED deformations the multiplier, (n_e,) [N, N m].
        felt: Gravity, which acts along the elements.
        reactions: Force of the supports on the mechanism, dual to x, zero where nothing is held, (n_x,) [N, N m].
        iterations: Newton iterations of all load steps.
        result: Code of RESULTS; critical_state is no failure: the state is right, its derivative is not.
        labels: Names.
    """

    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    felt: Felt
    reactions: Float[Array, "n_x"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    labels: Labels = static()
    one_axis = "x"

    def summary(self) -> Summary:
        """Outcome, and the largest deformation, stress resultant and reaction with their names."""
        rows = {
            "result": RESULTS(int(self.result)).name,
            "iterations": str(int(self.iterations)),
            "largest deformation": largest(self.e, self.labels.e, "[m, rad]"),
            "largest stress resultant": largest(self.sigma, self.labels.e, "[N, N m]"),
            "largest reaction": largest(self.reactions, self.labels.x, "[N, N m]"),
        }
        return Summary(f"Equilibrium: {len(self.x)} coordinates, {len(self.e)} deformations", rows)

    def at(self, node: str) -> Float[Array, "n"]:
        """Coordinates of a node, or of its rotation as "name.rotation".

        Args:
            node: Name of the node.

        Raises:
            KeyError: No such node.
        """
        return self.x[self.labels.known(node)]


class _Solved(NamedTuple):
    at: State
    near: Float[Array, "n_e"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]


def held_values(topology: Topology, parameters: Parameters, factors: LoadFactors):
    """Coordinates and deformations with the PRESCRIBED ones at their values, the others as undeformed.

    Args:
        topology: Structure.
        parameters: Numbers.
        factors: Load factors.

    Returns:
        x, (n_x,) [m, rad, -], and e, (n_e,) [m, rad].
    """
    loads = scaled_loads(parameters, factors)
    x, e = parameters.reference, jnp.zeros(topology.n_e)
    if loads.x is not None:
        x = accumulate(x, topology.x.prescribed, loads.x)
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
    reached: Float[Array, ""]
    step: Float[Array, ""]
    first: Float[Array, ""]
    before: Float[Array, ""]
    soft: Float[Array, "n_q"]
    softness: Float[Array, ""]
    tries: Int[Array, ""]
    iterations: Int[Array, ""]
    result: Int[Array, ""]


def _uneven(k0: Float[Array, "n_q n_q"]) -> Float[Array, "n_q"]:
    """A motion to which no mode of a symmetric mechanism is orthogonal, its energy spread over soft and stiff ones."""
    diagonal = diagonal_of(k0)
    return jnp.cos(jnp.arange(1.0, k0.shape[0] + 1) ** 2) / jnp.sqrt(jnp.where(diagonal > 0, diagonal, 1.0))


def _search(topology: Topology, parameters: Parameters, target: LoadFactors) -> _Solved:
    """One loop whose every turn is one Newton iteration; load steps begin, grow and shrink inside it.

    Deformations and their stress are carried as numbers of their own, see ``iterate``. The last turn evaluates the
    state that was found and leaves it as it is: outside the loop its equations would be compiled once more.

    Beside the Newton iteration runs the power method for the largest 1/mu of K v = mu K0 v, one step a turn with the
    factors at hand: from below, whether the state is critical.
    """
    sizes = sizes_of(topology, parameters)
    tracks = any(block.element.tracks_angle for block in topology.blocks)
    loaded = has_loads(topology, parameters)

    def turn(s: _Search) -> _Search:
        going = ~s.finishing
        load = jnp.where(going, jnp.minimum(s.reached + s.step, 1.0), 1.0)
        factors = LoadFactors(load * target.initial, load * target.increment)
        wanted = held_values(topology, parameters, factors)
        at, onto, residual = iterate(topology, parameters, factors, s.trial, s.trial_near, s.trial_strained, wanted)
        k0 = at.K0
        energy = s.soft @ k0 @ s.soft
        kept = (energy > 0) & jnp.isfinite(energy)
        soft = jnp.where(kept, s.soft / jnp.sqrt(jnp.where(kept, energy, 1.0)), _uneven(k0))
        energy = soft @ k0 @ soft
        dq, softer = factorise(k0 + at.G0).solve(jnp.stack([-residual, k0 @ soft], axis=1)).T
        change = onto + at.transfer.DFx @ dq
        # Laws alone: where they pull nothing, no stiffness is asked for.
        still = jnp.array(False) if loaded else (s.iterations == 0) & _is_round_off(at, residual, sizes)
        change = jnp.where(still, 0.0, change)
        size = jnp.max(jnp.abs(change) / sizes)
        contraction = size / s.before
        first = jnp.where(s.tries == 0, size, s.first)
        astray = (contraction > CONTRACTION) & (size > STEP_TOLERANCE**0.5)
        bad = going & (~(size < LARGEST_STEP) | astray | (s.tries >= MAX_ITERATIONS))
        last = load >= 1.0
        near_enough = (size < STEP_TOLERANCE) | (~last & (size < LOOSE_TOLERANCE) & (s.tries > 0))
        done = going & near_enough & ~bad
        trial = s.trial + change
        # The turn of an angle follows the iterate, whose steps are below half a turn.
        near = deformations(topology, parameters, trial, at.e) if tracks else at.e
        strained = at.e + at.jacobian @ change
        fitting = 0.8 * LARGEST_STEP / first
        shorter = s.step * jnp.where((s.tries == 0) & (fitting > 0), jnp.clip(fitting, 0.02, 0.5), 0.25)
        longer = s.step * jnp.clip(jnp.minimum(fitting, jnp.sqrt(0.2 / contraction)), 0.5, 4.0)
        step = jnp.where(bad, shorter, jnp.where(done, longer, s.step))
        failed = bad & (shorter < SMALLEST_LOAD_STEP)
        # Zero where nothing is stiff without load: that alone is no critical state.
        softness = jnp.where(still, 0.0, jnp.sqrt(softer @ k0 @ softer / jnp.where(energy > 0, energy, 1.0)))
        singular = ~jnp.all(jnp.isfinite(change))
        why = jnp.where(
            ~at.transfer.regular,
            RESULTS.singular_configuration,
            jnp.where(singular, RESULTS.singular_stiffness, RESULTS.not_converged),
        )

        def choose(if_bad, if_done, otherwise):
            return jnp.where(bad, if_bad, jnp.where(done, if_done, otherwise))

        return _Search(
            at=at,
            finishing=failed | (done & last),
            finished=s.finishing,
            x=jnp.where(done, trial, s.x),
            near=jnp.where(done, near, s.near),
            trial=choose(s.x, trial, trial),
            trial_near=choose(s.near, near, near),
            strained=jnp.where(done, strained, s.strained),
            trial_strained=choose(s.strained, strained, strained),
            reached=jnp.where(done, load, s.reached),
            step=step,
            first=first,
            before=jnp.where(bad | done, jnp.inf, size),
            soft=softer,
            softness=jnp.where(going, softness, s.softness),
            tries=jnp.where(bad | done, 0, s.tries + 1),
            iterations=s.iterations + going.astype(jnp.int32),
            result=jnp.where(failed, why, s.result).astype(jnp.int32),
        )

    x0, near0 = parameters.reference, zero_near(topology)
    zero, no = jnp.zeros((), jnp.int32), jnp.array(False)
    nothing = jax.eval_shape(lambda x, near: state(topology, parameters, target, x, near), x0, near0)
    start = _Search(
        at=jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing),
        finishing=no,
        finished=no,
        x=x0,
        near=near0,
        trial=x0,
        trial_near=near0,
        strained=near0,
        trial_strained=near0,
        reached=jnp.array(0.0),
        step=jnp.array(1.0),
        first=jnp.array(1.0),
        before=jnp.array(jnp.inf),
        soft=jnp.zeros(topology.n_q),
        softness=jnp.array(0.0),
        tries=zero,
        iterations=zero,
        result=zero,
    )
    end = jax.lax.while_loop(lambda s: ~s.finished, turn, start)
    critical = (end.result == RESULTS.successful) & (end.softness > 1 / CRITICAL)
    result = jnp.where(critical, RESULTS.critical_state, end.result).astype(jnp.int32)
    return _Solved(end.at, end.near, end.iterations, result)


def _is_round_off(at: State, residual: Float[Array, "n_q"], sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
    """Whether nothing but round-off of the deformations is out of balance."""
    error = ROUND_OFF * jnp.abs(at.jacobian) @ sizes
    largest = jnp.abs(at.transfer.DFe).T @ (jnp.abs(at.S) @ error)
    return jnp.all(jnp.abs(residual) <= largest)


@jax.custom_jvp
def _solve(topology: Topology, parameters: Parameters, target: LoadFactors) -> _Solved:
    return _search(topology, parameters, target)


def change_of_equations(
    topology: Topology, at: State, near: Float[Array, "n_e"], primals: tuple, tangents: tuple
) -> tuple[Float[Array, "n_e"], Float[Array, "n_x"], Float[Array, "n_x"]]:
    """Change of the equilibrium equations with parameters and load factors, at constant x.

    Args:
        topology: Structure.
        at: State in equilibrium.
        near: Deformations at the last accepted state, (n_e,) [m, rad].
        primals: Parameters and load factors.
        tangents: Their changes; a leaf may be a ``SymbolicZero``.

    Returns:
        excess (n_e,) [m, rad], shift (n_x,) [m, rad, -] and imbalance (n_x,) [N, N m], as ``reduced_response`` takes
        them: the particular solution keeps the DOF deformations.

    Source:
        Implicit function theorem on FORMULATION.md 5.
    """

    def equations(parameters, target):
        e, jacobian = deformation_jacobian(topology, parameters, at.x, near)
        stiffness = element_stiffness(topology, parameters)
        sigma = stress_resultants(topology, parameters, scaled_loads(parameters, target), stiffness, e)
        fixed = jnp.concatenate([topology.e.fixed, topology.e.prescribed])
        sigma = put(sigma, fixed, at.sigma[fixed])
        wanted_x, wanted_e = held_values(topology, parameters, target)
        force = nodal_forces(topology, parameters, target, at.x)
        return jacobian.T @ sigma - force, e - wanted_e, wanted_x

    _, (imbalance, excess, wanted) = jvp_of_varied(equations, primals, tangents)
    held = jnp.concatenate([topology.x.fixed, topology.x.prescribed])
    shift = put(jnp.zeros(topology.n_x), held, wanted[held])
    return put(excess, topology.e.dof, 0.0) + at.jacobian @ shift, shift, imbalance


def _solve_jvp(primals, tangents):
    """The derivative of the equations at constant x, answered by the tangent."""
    topology, parameters, target = primals
    solved = _solve(topology, parameters, target)
    near = jax.lax.stop_gradient(solved.near)
    excess, shift, imbalance = change_of_equations(topology, solved.at, near, primals[1:], tangents[1:])
    dx, _ = linear_response(topology, solved.at, excess, shift, imbalance)

    def evaluated(parameters, target, x):
        return state(topology, parameters, target, x, near)

    _, changed = jvp_of_varied(evaluated, (parameters, target, solved.at.x), (*tangents[1:], dx))
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return solved, _Solved(changed, jnp.zeros_like(near), no_change, no_change)


_solve.defjvp(_solve_jvp, symbolic_zeros=True)


def solve_state(
    topology: Topology, parameters: Parameters, target: LoadFactors, tell_critical: bool = False
) -> tuple[State, Float[Array, "n_e"], Int[Array, ""], Int[Array, ""]]:
    """Equilibrium and everything of first order about it; differentiable. Part of the compiled kernels.

    Args:
        topology: Structure.
        parameters: Numbers.
        target: Load factors of the equilibrium.
        tell_critical: Whether a critical state is told; what is asked about the stiffness there has an answer.

    Returns:
        State, ``near``, code of RESULTS, and number of Newton iterations.
    """
    # What the laws of elements pull in the undeformed mechanism is known only as a number.
    if has_loads(topology, parameters) or is_nonlinear(topology):
        at, near, iterations, result = _solve(topology, parameters, target)
        if not tell_critical:
            result = jnp.where(result == RESULTS.critical_state, RESULTS.successful, result)
    else:
        near = zero_near(topology)
        at = state(topology, parameters, target, parameters.reference, near, loaded=False)
        result = iterations = jnp.zeros((), jnp.int32)
    found = (result == RESULTS.successful) | (result == RESULTS.critical_state)
    result = jnp.where(found & ~at.transfer.regular, RESULTS.singular_configuration, result)
    return at, near, result.astype(jnp.int32), iterations


def reactions_of(topology: Topology, at: State) -> Float[Array, "n_x"]:
    """Forces of the supports on the mechanism, at FIXED and PRESCRIBED coordinates, zero elsewhere.

    Args:
        topology: Structure.
        at: Equilibrium state.

    Returns:
        D_x^T sigma - f there, (n_x,) [N, N m].
    """
    held = jnp.concatenate([topology.x.fixed, topology.x.prescribed])
    return put(jnp.zeros(topology.n_x), held, (at.jacobian.T @ at.sigma - at.force)[held])


@jit
def _equilibrium(topology, parameters, target):
    at, _, result, iterations = solve_state(topology, parameters, target, tell_critical=True)
    return at.x, at.e, at.sigma, Felt(at.gravity), reactions_of(topology, at), iterations, result


def load_factors_of(model: Model, load_factor: float, increment: float | None, function: str) -> LoadFactors:
    """Load factors that a public function is asked for; it is said where incremental loads are left out unasked.

    Args:
        model: Mechanism.
        load_factor: Factor of the loads, () [-].
        increment: Factor of the incremental loads, () [-]; None: zero, with a warning where there are any.
        function: Name of the public function.

    Raises:
        TypeError, ValueError: A factor is no finite number, or there are no incremental loads to scale.
    """
    check_number("load_factor", load_factor)
    if increment is None:
        warn_of_increment(model, function)
        return load_factors(load_factor, 0.0)
    check_number("increment", increment)
    if model.parameters.increment is None and is_concrete(increment) and increment != 0:
        raise ModelError("The model has no incremental loads for `increment` to scale: give them increment=True.")
    return load_factors(load_factor, increment)


def warn_of_increment(model: Model, function: str) -> None:
    """Say that incremental loads are left out, but for models under a trace.

    Args:
        model: Mechanism.
        function: Name of the public function that is asked for.
    """
    if model.parameters.increment is not None and is_concrete(model):
        warn(
            f"fm.{function} leaves out the incremental loads of the model: it is asked about the state without them."
            " Give fm.linearize(model, increment=1.0), or increment=1.0 where it is an argument, for the state under"
            " all of them; increment=0.0 where none of them is meant."
        )


def equilibrium(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    sparse: bool = False,
    throw: bool = True,
) -> Equilibrium:
    """Static equilibrium under the constant loads.

    Newton's method on the configurations that the constraints allow, with the multipliers of the constraints
    estimated before the first step, so that a hanging body has its stiffness from the start.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        load_factor: Factor of the loads, () [-].
        increment: Factor of the incremental loads, () [-]; zero unless given.
        sparse: For thousands of elements: sparse factors in all coordinates, no degrees of freedom needed
            (``Builder.build(check=False)``). Dead loads, gravity and elements of constant stiffness only; outside
            ``jax.jit``; a failure raises; a critical state is not told.
        throw: Raise where the solve fails; otherwise the code is in ``result``. At a critical state it does not fail:
            look at ``result`` before using a derivative.

    Returns:
        Equilibrium with x (n_x,) [m, rad, -], e and sigma (n_e,) [m, rad; N, N m], reactions (n_x,) [N, N m].

    Raises:
        AnalysisError: singular_configuration, singular_stiffness or not_converged, with what to try.
        ValueError: A factor is not finite, or there are no incremental loads.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given.

    Source:
        FORMULATION.md 4, 5 and 7.
    """
    check_flag("sparse", sparse)
    (as_model if sparse else as_determined)(model, "equilibrium")
    target = load_factors_of(model, load_factor, increment, "equilibrium")
    if sparse:
        from .sparse import sparse_equilibrium

        return sparse_equilibrium(model, target)
    x, e, sigma, felt, reactions, iterations, result = _equilibrium(model.topology, model.parameters, target)
    solved = Equilibrium(x, e, sigma, felt, reactions, iterations, result, model.labels)
    check(solved.result, throw)
    return solved
