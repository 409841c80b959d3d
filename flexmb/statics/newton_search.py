"""Newton's method for an equilibrium, with adaptive load steps: one loop for dense and for sparse matrices.

:func:`search_equilibrium` is the loop. :class:`MatrixForm` and :class:`Turn` are the interface of a form of matrices:
``solve`` has the dense form, ``sparse`` the sparse form. :class:`Newton` and :class:`LoadStep` decide which corrections
and steps are accepted.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..math.indices import accumulate, put
from ..math.linear import uneven
from ..mechanics.deformation import deformations, zero_strain
from ..mechanics.loads import LoadFactors, has_loads, is_idle, scaled_loads
from ..mechanics.stress_resultants import free_deformations, is_nonlinear_at_rest, thermal_deformations
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import CRITICAL_SHARE, LOOSE_TOLERANCE, SMALLEST_LOAD_STEP, STEP_TOLERANCE
from ..results import RESULTS

# Goals for the next load step: size of its first correction, as share of `largest`, and contraction of corrections.
FIRST_CORRECTION = 0.8
WANTED_CONTRACTION = 0.2

# A number on the host, or a traced one.
Number = float | Float[Array | np.ndarray, ""]


class Newton(NamedTuple):
    """Limits of corrections. Beyond them, the iteration has left the path and may find another branch.

    Attributes:
        largest: A larger correction is refused: angles could be counted into another turn.
        contraction: A correction above this share of the previous correction is refused too.
        round_off: Smaller corrections may shrink slowly, because of round-off of a nearly singular tangent.
        most: Largest number of corrections.

    Source:
        Deuflhard 2011, Newton Methods for Nonlinear Problems, section 5.1.
    """

    largest: float
    contraction: float
    round_off: float
    most: int

    def slow(self, size: Number, before: Number) -> Any:
        """Whether a correction is hardly smaller than the previous one, which is infinite for the first."""
        return size > self.contraction * before

    def astray(self, size: Number, before: Number, tries: Any) -> Any:
        """Whether a correction is refused, also if it is NaN."""
        slow = self.slow(size, before) & (size > self.round_off)
        return ~(size < self.largest) | slow | (tries >= self.most)


# At a given load.
AT_LOAD = Newton(largest=0.75, contraction=0.35, round_off=STEP_TOLERANCE**0.5, most=12)
# In a plane across an equilibrium path, where the load changes too.
ACROSS_PATH = Newton(largest=0.3, contraction=0.5, round_off=1e-7, most=10)


class LoadStep(NamedTuple):
    """Progress of load steps, and of Newton's method at the next one.

    Attributes:
        reached: Share of the load of the last equilibrium.
        step: Next increase of it.
        first: Size of the first correction.
        before: Size of the last; infinite without one.
        tries: Number of corrections so far.
    """

    reached: Float[Array, ""]
    step: Float[Array, ""]
    first: Float[Array, ""]
    before: Float[Array, ""]
    tries: Int[Array, ""]

    @property
    def load(self) -> Float[Array, ""]:
        """Share of the load that is tried."""
        return jnp.minimum(self.reached + self.step, 1.0)

    def astray(self, size: Number) -> Any:
        """Whether the next correction, of this size, is refused."""
        return AT_LOAD.astray(size, self.before, self.tries)

    def near_enough(self, size: Number) -> Any:
        """Whether the next correction, of this size, ends the iteration: at the whole load it must be small.

        The rest is estimated: after a contraction by theta, the next one is by theta^2 (Deuflhard 2011, section 2.1).
        """
        predicted = size * (size / self.before) ** 2
        return (size < STEP_TOLERANCE) | ((self.load < 1.0) & (predicted < LOOSE_TOLERANCE) & (self.tries > 0))

    def after(self, size: Number, done: Any, bad: Any) -> tuple["LoadStep", Any]:
        """State after a correction that is ``done`` or ``bad`` (refused), and whether load steps are too short."""
        first = jnp.where(self.tries == 0, size, self.first)
        # Factor of the step for a first correction of the wanted size.
        fitting = FIRST_CORRECTION * AT_LOAD.largest / first
        shorter = self.step * jnp.where((self.tries == 0) & (fitting > 0), jnp.clip(fitting, 0.02, 0.5), 0.25)
        contraction = size / self.before
        longer = self.step * jnp.clip(jnp.minimum(fitting, jnp.sqrt(WANTED_CONTRACTION / contraction)), 0.5, 4.0)
        following = LoadStep(
            reached=jnp.where(done, self.load, self.reached),
            step=jnp.where(bad, shorter, jnp.where(done, longer, self.step)),
            first=first,
            before=jnp.where(bad | done, jnp.inf, size),
            tries=jnp.where(bad | done, 0, self.tries + 1),
        )
        return following, bad & (shorter < SMALLEST_LOAD_STEP)


# Size to which corrections are shortened if nothing is elastic, as for a pendulum, and their largest number.
LOOSE_CORRECTION, MOST_LOOSE = 0.5, 30


class Iterate(NamedTuple):
    """State of Newton's method.

    Attributes:
        near: Deformations from which angles are counted.
        strained: Deformations minus stress-free ones, as iterated.
        multipliers: Stress resultants of the held deformations if they are unknowns; otherwise (0,).
    """

    x: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    strained: Float[Array, "n_e"]
    multipliers: Float[Array, "h"]


class Begin(NamedTuple):
    """Start of Newton's method: the undeformed mechanism, or an equilibrium under other loads.

    Attributes:
        at: The state.
        soft: Its softest motion, by the unknowns.
        factors: Load factors there.
    """

    at: Iterate
    soft: Float[Array, "n"]
    factors: LoadFactors


class Correction(NamedTuple):
    """Solution of the linear equations of a turn.

    Attributes:
        change: Change of the coordinates.
        softer: Next motion of the power method.
        multipliers: Multipliers after the change.
        failure: Code of RESULTS if the correction is refused in the end.
        estimated: Multipliers to repeat the turn with, zero for no repetition; None if that never occurs.
    """

    change: Float[Array, "n_x"]
    softer: Float[Array, "n"]
    multipliers: Float[Array, "h"]
    failure: Int[Array, ""]
    estimated: Float[Array, "h"] | None = None


class Turn(Protocol):
    """Equations of equilibrium, linearised at an iterate, for one turn of the loop; motions have the form's unknowns.

    Attributes:
        last: Parts of the last turn that are kept, a pytree of arrays.
        e: Deformations.
    """

    last: Any
    e: Any

    def deformed(self, change: Float[Array, "n_x"]) -> Float[Array, "n_e"]:
        """Change of the deformations with the coordinates, to first order."""
        ...

    def is_round_off(self, sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
        """Whether only round-off of the deformations is out of balance."""
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
        turn: Equations at an iterate: of topology, parameters, load factors, an iterate whose ``strained`` are
            deformations, and coordinates and deformations with the PRESCRIBED ones at their values.
        unknowns: Numbers of unknown motions and of unknown multipliers, of a topology.
        looks_at_end: Whether the equations are needed at the final state.
        knows_stress: Whether one correction, however small, gives the correct stress resultants.
    """

    turn: Callable[..., Turn]
    unknowns: Callable[[Topology], tuple[int, int]]
    looks_at_end: bool
    knows_stress: bool


class Searched(NamedTuple):
    """An equilibrium: parts of the last turn, state and load factors reached, iterations, code of RESULTS."""

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


def prescribed_values(topology: Topology, parameters: Parameters, factors: LoadFactors):
    """Coordinates and deformations with the PRESCRIBED ones at their values, others as undeformed.

    FIXED deformations have their thermal values, since a rigid element expands too.
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


def unloaded_start(form: MatrixForm, topology: Topology, parameters: Parameters) -> Begin:
    """Start without loads."""
    none, zero = zero_strain(topology), jnp.array(0.0)
    motions, multipliers = form.unknowns(topology)
    at = Iterate(jnp.asarray(parameters.reference, float), none, none, jnp.zeros(multipliers))
    return Begin(at, jnp.zeros(motions), LoadFactors(zero, zero))


def _between(begin: LoadFactors, target: LoadFactors, share: Float[Array, ""]) -> LoadFactors:
    """Load factors a share of the way; at the end exactly the target."""
    return LoadFactors(*((1 - share) * a + share * b for a, b in zip(begin, target, strict=True)))


def _unit_energy_motion(turn: Turn, soft: Float[Array, "n"]) -> tuple[Array, Array]:
    """A motion of unit energy and its energy; for one without energy an uneven one instead."""
    energy, diagonal = turn.energy(soft), turn.stiffnesses()
    positive = (energy > 0) & jnp.isfinite(energy)
    # No mode of a symmetric mechanism is orthogonal to it.
    even = uneven(soft.shape[0], 1, jnp) / jnp.sqrt(jnp.where(diagonal > 0, diagonal, 1.0))
    soft = jnp.where(positive, soft / jnp.sqrt(jnp.where(positive, energy, 1.0)), even)
    return soft, turn.energy(soft)


class _EquilibriumSearch(NamedTuple):
    """The equations of a search for an equilibrium, and one turn of its loop.

    Attributes:
        sizes: Of the coordinates, for scaling.
        idle: Whether all loads and initial strains are zero.
    """

    form: MatrixForm
    topology: Topology
    parameters: Parameters
    target: LoadFactors
    begin: Begin
    sizes: Float[Array, "n_x"]
    idle: Bool[Array, ""] | bool

    def equations(self, trial: Iterate, load: Float[Array, ""]) -> tuple[Turn, Any]:
        """Equations at a trial state and a share of the load, and stress-free deformations there or None."""
        topology, parameters = self.topology, self.parameters
        factors = _between(self.begin.factors, self.target, load)
        prescribed = prescribed_values(topology, parameters, factors)
        free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
        strained = trial.strained if free is None else trial.strained + free
        return self.form.turn(topology, parameters, factors, trial._replace(strained=strained), prescribed), free

    def needs_no_stiffness(self, s: _Search, at: Turn) -> Bool[Array, ""]:
        """Whether the mechanism is undeformed, without loads and without the pull of laws."""
        loaded, still = has_loads(self.topology, self.parameters), s.iterations == 0
        if loaded:
            still = still & self.idle & jnp.all(s.trial.x == self.parameters.reference)
        if not loaded or is_nonlinear_at_rest(self.topology):
            still = still & at.is_round_off(self.sizes)
        return still

    def falls(self) -> bool:
        """Whether nothing may be elastic, as for a pendulum. Prescribed motion needs load steps; a fall does not."""
        prescribed = self.topology.x.prescribed.shape[0] + self.topology.e.prescribed.shape[0]
        unknown_motions, _ = self.form.unknowns(self.topology)
        return unknown_motions > 0 and not prescribed and self.parameters.loads.temperature is None

    def after_change(self, at: Turn, change: Float[Array, "n_x"], trial: Iterate, free: Any) -> Iterate:
        """The iterate after a change of the coordinates of a trial state, with the multipliers of the trial state."""
        x, strained = trial.x + change, at.e + at.deformed(change)
        # The turn of an angle follows the iterate, whose steps are below half a turn.
        counts = self.topology.counts_turns
        last_strain = deformations(self.topology, self.parameters, x, at.e) if counts else strained
        return Iterate(x, last_strain, strained if free is None else strained - free, trial.multipliers)

    def turn(self, s: _Search) -> _Search:
        """State of the loop after one Newton iteration, or after a look at the final state."""
        going, steps = ~s.finishing, s.steps
        load = jnp.where(going, steps.load, 1.0)
        at, free = self.equations(s.trial, load)
        soft, energy = _unit_energy_motion(at, s.soft)
        correction = at.corrected(soft)
        still = self.needs_no_stiffness(s, at)
        change = jnp.where(still, 0.0, correction.change)
        size = jnp.max(jnp.abs(change) / self.sizes, initial=0.0)
        refused = going & steps.astray(size)
        if self.falls():
            # If nothing is elastic, a smaller load makes no smaller correction. Tried once, at the whole load.
            loose = ~jnp.any(at.stiffnesses() > 0) & jnp.isfinite(size) & (steps.tries < MOST_LOOSE)
            loose = loose & (steps.reached == 0) & (steps.step == 1)
            change = jnp.where(loose & (size > LOOSE_CORRECTION), change * (LOOSE_CORRECTION / size), change)
            refused = refused & ~loose
        enough = steps.near_enough(size)
        if not self.form.knows_stress:
            # The first tangent has neither multipliers nor the stress of warmed elements.
            enough = enough & (still | (steps.tries > 0))
        accepted = going & enough & ~refused
        after = self.after_change(at, change, s.trial, free)
        after = after._replace(multipliers=jnp.where(still, s.trial.multipliers, correction.multipliers))
        following, failed = steps.after(size, accepted, refused)
        ends = failed | (accepted & (load >= 1.0))
        # Zero if nothing is stiff without load: that alone is no critical state.
        softness = jnp.sqrt(at.energy(correction.softer) / jnp.where(energy > 0, energy, 1.0))
        softness = jnp.where(still, 0.0, softness)
        new = _Search(
            last=at.last,
            finishing=ends,
            finished=s.finishing if self.form.looks_at_end else ends,
            done=_where(accepted, after, s.done),
            trial=_where(refused, s.done, after),
            steps=following,
            soft=correction.softer,
            softness=jnp.where(going, softness, s.softness),
            iterations=s.iterations + going.astype(jnp.int32),
            result=jnp.where(failed, correction.failure, s.result).astype(jnp.int32),
        )
        if correction.estimated is None:
            return new
        again = s._replace(last=at.last, trial=s.trial._replace(multipliers=correction.estimated))
        return _where(jnp.any(correction.estimated != 0), again, new)


def _where(condition: Bool[Array, ""], one: Any, other: Any) -> Any:
    """One of two pytrees, by a traced condition."""
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), one, other)


def search_equilibrium(
    form: MatrixForm, topology: Topology, parameters: Parameters, target: LoadFactors, begin: Begin
) -> Searched:
    """Equilibrium by one loop whose turns are Newton iterations, with load steps that begin, grow and shrink inside it.

    Deformations are iterated as separate numbers, see ``iterate``. If elements have stress-free deformations, the
    iteration uses the deformations minus these. Otherwise a warmed leaf spring would start beyond buckling, with the
    stress of a leaf spring between rigid walls. If the equations are needed at the end, the last turn evaluates them
    without a change of state. Outside the loop they would be compiled again.

    The power method for the largest 1/mu of K v = mu K0 v makes one step per turn with the factors at hand. It shows,
    from below, whether the state is critical.
    """
    sizes, idle = coordinate_scales(topology, parameters), is_idle(topology, parameters, target)
    search = _EquilibriumSearch(form, topology, parameters, target, begin, sizes, idle)
    zero, one, none, no = jnp.array(0.0), jnp.array(1.0), jnp.zeros((), jnp.int32), jnp.array(False)
    nothing = jax.eval_shape(lambda trial: search.equations(trial, one)[0].last, begin.at)
    nothing = jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), nothing)
    # The whole load in one step.
    first = LoadStep(reached=zero, step=one, first=one, before=jnp.array(jnp.inf), tries=none)
    start = _Search(nothing, no, no, begin.at, begin.at, first, begin.soft, zero, none, none)
    end = jax.lax.while_loop(lambda s: ~s.finished, search.turn, start)
    successful = end.result == RESULTS.successful
    critical = successful & (end.softness > 1 / CRITICAL_SHARE)
    result = jnp.where(critical, RESULTS.critical_state, end.result).astype(jnp.int32)
    share = jnp.where(successful, 1.0, end.steps.reached)
    reached = Begin(end.done, end.soft, _between(begin.factors, target, share))
    return Searched(end.last, reached, end.iterations, result)
