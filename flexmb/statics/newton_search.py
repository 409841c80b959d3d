"""Newton's method for an equilibrium, with load steps that adapt: one loop for dense and for sparse matrices."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..math.indices import accumulate, put
from ..math.linear import uneven
from ..mechanics.deformation import deformations, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, has_loads, is_idle, scaled_loads
from ..mechanics.stress_resultants import free_deformations, is_nonlinear_at_rest, thermal_deformations
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


class Iterate(NamedTuple):
    """State of Newton's method.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        near: Deformations that angles are counted from, (n_e,) [m, rad].
        strained: Deformations less those that are free of stress, as the iteration carries them, (n_e,) [m, rad].
        multipliers: Stress resultants of the held deformations where they are unknowns, (h,) [N, N m]; otherwise (0,).
    """

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    multipliers: Float[Array, "h"]


class Begin(NamedTuple):
    """Where Newton's method begins: the undeformed mechanism, or an equilibrium under other loads.

    Attributes:
        at: The state.
        soft: Motion in which it is softest, by the unknowns, (n,) [m, rad].
        factors: Load factors there.
    """

    at: Iterate
    soft: Float[Array, "n"]
    factors: LoadFactors


class Correction(NamedTuple):
    """Solution of the linear equations of a turn.

    Attributes:
        change: Of the coordinates, (n_x,) [m, rad, -].
        softer: Next motion of the power method, (n,).
        multipliers: After the change, (h,) [N, N m].
        failure: Code of RESULTS if the correction is refused in the end.
        estimated: Multipliers to repeat the turn with, zero where it need not be; None: it never need be.
    """

    change: Float[Array, "n_x"]
    softer: Float[Array, "n"]
    multipliers: Float[Array, "h"]
    failure: Int[Array, ""]
    estimated: Float[Array, "h"] | None = None


class Turn(Protocol):
    """Equations of equilibrium, linearised at an iterate; motions are by the unknowns of a form of matrices.

    Attributes:
        last: What is kept of the last turn, a pytree of arrays.
        e: Deformations, (n_e,) [m, rad].
    """

    last: Any
    e: Any

    def deformed(self, change: Float[Array, "n_x"]) -> Float[Array, "n_e"]:
        """Change of the deformations with the coordinates, to first order."""
        ...

    def is_round_off(self, sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
        """Whether nothing but round-off of the deformations is out of balance."""
        ...

    def stiffnesses(self) -> Float[Array, "n"]:
        """Diagonal of the structural stiffness."""
        ...

    def energy(self, motion: Float[Array, "n"]) -> Float[Array, ""]:
        """Twice the elastic energy of a motion."""
        ...

    def corrected(self, soft: Float[Array, "n"]) -> Correction:
        """Newton's correction, and a step of the power method from a motion."""
        ...


class MatrixForm(NamedTuple):
    """A form of matrices.

    Attributes:
        turn: The equations at an iterate: of topology, parameters, load factors, an iterate whose ``strained`` are
            deformations, and the coordinates and deformations with the PRESCRIBED ones at their values.
        unknowns: Numbers of unknown motions and of unknown multipliers, of a topology.
        looks_at_end: Whether the equations are wanted at the state that was found.
        knows_stress: Whether one correction, however small, has the stress resultants right.
    """

    turn: Callable[..., Turn]
    unknowns: Callable[[Topology], tuple[int, int]]
    looks_at_end: bool
    knows_stress: bool


class Searched(NamedTuple):
    """An equilibrium.

    Attributes:
        last: What the form keeps of the last turn.
        reached: State and load factors that the search reached.
        iterations: Newton iterations.
        result: Code of RESULTS.
    """

    last: Any
    reached: Begin
    iterations: Int[Array, ""]
    result: Int[Array, ""]


class _Search(NamedTuple):
    last: Any
    finishing: Bool[Array, ""]
    finished: Bool[Array, ""]
    done: Iterate
    trial: Iterate
    steps: LoadStep
    soft: Float[Array, "n"]
    softness: Float[Array, ""]
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


def undeformed(form: MatrixForm, topology: Topology, parameters: Parameters) -> Begin:
    """The beginning without loads."""
    none, zero = zero_near(topology), jnp.array(0.0)
    motions, multipliers = form.unknowns(topology)
    at = Iterate(jnp.asarray(parameters.reference, float), none, none, jnp.zeros(multipliers))
    return Begin(at, jnp.zeros(motions), LoadFactors(zero, zero))


def _between(begin: LoadFactors, target: LoadFactors, share: Float[Array, ""]) -> LoadFactors:
    """Load factors a share of the way; at the end exactly the target."""
    return LoadFactors(*((1 - share) * a + share * b for a, b in zip(begin, target, strict=True)))


def _of_unit_energy(turn: Turn, soft: Float[Array, "n"]) -> tuple[Array, Array]:
    """A motion of unit energy and its energy; where it has none, an uneven one, soft and stiff motions alike in it."""
    energy, diagonal = turn.energy(soft), turn.stiffnesses()
    kept = (energy > 0) & jnp.isfinite(energy)
    # No mode of a symmetric mechanism is orthogonal to it.
    even = uneven(soft.shape[0], 1, jnp) / jnp.sqrt(jnp.where(diagonal > 0, diagonal, 1.0))
    soft = jnp.where(kept, soft / jnp.sqrt(jnp.where(kept, energy, 1.0)), even)
    return soft, turn.energy(soft)


def search(form: MatrixForm, topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin) -> Searched:
    """Equilibrium by one loop whose every turn is one Newton iteration; load steps begin, grow and shrink inside it.

    Deformations and their stress are carried as numbers of their own, see ``iterate``; where elements are free of
    stress at others than zero, what is carried is the difference: a leaf spring that is warmed would otherwise begin
    with the stress of one between rigid walls, beyond buckling. Where the equations are wanted at the end, the last
    turn evaluates them and leaves the state as it is: outside the loop they would be compiled once more.

    Beside the Newton iteration runs the power method for the largest 1/mu of K v = mu K0 v, one step a turn with the
    factors at hand: from below, whether the state is critical.
    """
    sizes = sizes_of(topology, parameters)
    loaded = has_loads(topology, parameters)
    idle, laws = is_idle(topology, parameters, target), is_nonlinear_at_rest(topology)
    # What is moved goes by steps, of which a pendulum's fall has no need.
    moved = topology.x.prescribed.shape[0] + topology.e.prescribed.shape[0] > 0
    falls = form.unknowns(topology)[0] > 0 and not moved and parameters.loads.temperature is None

    def equations(trial: Iterate, load: Float[Array, ""]):
        factors = _between(begin.factors, target, load)
        wanted = held_values(topology, parameters, factors)
        free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
        strained = trial.strained if free is None else trial.strained + free
        return form.turn(topology, parameters, factors, trial._replace(strained=strained), wanted), free

    def turn(s: _Search) -> _Search:
        going, steps, (x, *_) = ~s.finishing, s.steps, s.trial
        load = jnp.where(going, steps.load, 1.0)
        at, free = equations(s.trial, load)
        soft, energy = _of_unit_energy(at, s.soft)
        found = at.corrected(soft)
        # Undeformed, where loads are zero and laws pull nothing, no stiffness is asked for.
        still = s.iterations == 0
        if loaded:
            still = still & idle & jnp.all(x == parameters.reference)
        if not loaded or laws:
            still = still & at.is_round_off(sizes)
        change = jnp.where(still, 0.0, found.change)
        size = jnp.max(jnp.abs(change) / sizes, initial=0.0)
        bad = going & steps.astray(size)
        if falls:
            # Where nothing is elastic a smaller load makes no smaller correction. Tried once, at the whole load.
            loose = ~jnp.any(at.stiffnesses() > 0) & jnp.isfinite(size) & (steps.tries < MOST_LOOSE)
            loose = loose & (steps.reached == 0) & (steps.step == 1)
            change = jnp.where(loose & (size > LOOSE_CORRECTION), change * (LOOSE_CORRECTION / size), change)
            bad = bad & ~loose
        enough = steps.near_enough(size)
        if not form.knows_stress:
            # The tangent of the first turn knows neither multipliers nor the stress of what is warmed.
            enough = enough & (still | (steps.tries > 0))
        done = going & enough & ~bad
        trial = x + change
        strained = at.e + at.deformed(change)
        # The turn of an angle follows the iterate, whose steps are below half a turn.
        near = deformations(topology, parameters, trial, at.e) if topology.counts_turns else strained
        multipliers = jnp.where(still, s.trial.multipliers, found.multipliers)
        after = Iterate(trial, near, strained if free is None else strained - free, multipliers)
        following, failed = steps.after(size, done, bad)
        ends = failed | (done & (load >= 1.0))
        # Zero where nothing is stiff without load: that alone is no critical state.
        softness = jnp.sqrt(at.energy(found.softer) / jnp.where(energy > 0, energy, 1.0))
        softness = jnp.where(still, 0.0, softness)
        new = _Search(
            last=at.last,
            finishing=ends,
            finished=s.finishing if form.looks_at_end else ends,
            done=jax.tree.map(lambda a, b: jnp.where(done, a, b), after, s.done),
            trial=jax.tree.map(lambda a, b: jnp.where(bad, b, a), after, s.done),
            steps=following,
            soft=found.softer,
            softness=jnp.where(going, softness, s.softness),
            iterations=s.iterations + going.astype(jnp.int32),
            result=jnp.where(failed, found.failure, s.result).astype(jnp.int32),
        )
        if found.estimated is None:
            return new
        again = s._replace(last=at.last, trial=s.trial._replace(multipliers=found.estimated))
        repeats = jnp.any(found.estimated != 0)
        return jax.tree.map(lambda a, b: jnp.where(repeats, a, b), again, new)

    zero, no = jnp.zeros((), jnp.int32), jnp.array(False)
    nothing = jax.eval_shape(lambda trial: equations(trial, jnp.array(1.0))[0].last, begin.at)
    nothing = jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing)
    start = _Search(nothing, no, no, begin.at, begin.at, first_load_step(), begin.soft, jnp.array(0.0), zero, zero)
    end = jax.lax.while_loop(lambda s: ~s.finished, turn, start)
    successful = end.result == RESULTS.successful
    critical = successful & (end.softness > 1 / CRITICAL)
    result = jnp.where(critical, RESULTS.critical_state, end.result).astype(jnp.int32)
    share = jnp.where(successful, 1.0, end.steps.reached)
    reached = Begin(end.done, end.soft, _between(begin.factors, target, share))
    return Searched(end.last, reached, end.iterations, result)
