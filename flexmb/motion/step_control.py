"""Step size control by the displacements of a motion."""

from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import optimistix as optx

from ..numerical_limits import LARGE_DISPLACEMENT, RAN_AWAY
from .balance import Balance, Before, StepError, at_start, elastic_energy, gained_between, kinetic_from_residual
from .events import Passing
from .kinks import Kinks, search_of
from .protocol import MotionState


def greatest(before: Any, state: MotionState):
    """Greatest displacement so far, at most ``LARGE_DISPLACEMENT``."""
    largest = jnp.max(jnp.abs(jax.lax.stop_gradient(state.u)), initial=0.0)
    return jnp.where(jnp.isfinite(largest), jnp.clip(largest, before, LARGE_DISPLACEMENT), before)


class DisplacementController(diffrax.PIDController):
    """A PID controller whose tolerance is a share of the greatest displacement so far, the same for all displacements.

    A displacement that is small for a moment does not cause smaller steps. The error of a velocity counts by its effect
    on a position within the step, so that stiff vibrations count by their displacement. Beyond half the mechanism's
    extent, or half a radian (an Euler parameter is half an angle), the tolerance stays constant. The error of each
    state of a controller is relative to this state. The norm is the maximum, so that the number of displacements has no
    effect.

    The controller stops a motion that runs away. It refuses and halves a step across a kink, and a step that would miss
    an event.

    Attributes:
        norm: Norm of the errors over their tolerances.
        before: Values before the start.
        states: Number of states of a controller, the last of the velocities.
        kinks: Search for kinks within a step, or None.
        passing: Search for events within a step, or None.
        equations: Equations whose energy balance can refuse a step, or None.

    Source:
        Hairer, Norsett, Wanner (1993), Solving Ordinary Differential Equations I, section II.4; measures derived here.
    """

    norm: Callable[[Any], Any] = optx.max_norm
    before: Before = eqx.field(default_factory=at_start)
    states: int = eqx.field(static=True, default=0)
    kinks: Kinks | None = None
    passing: Passing | None = None
    equations: Any = None

    def init(self, terms: Any, t0: Any, t1: Any, y0: MotionState, *args: Any, **named: Any) -> Any:
        """End of the first step, and the state of the controller."""
        first: Any = super().init(terms, t0, t1, y0, *args, **named)
        moved, balance = greatest(self.before.moved, y0), self.before.balance
        if self.equations is not None:
            equations, t, state = jax.lax.stop_gradient((self.equations, t0, y0))
            balance = balance.with_energy(
                elastic_energy(equations, t, state) + kinetic_from_residual(equations, t, state)
            )
        return first[0], (first[1], Before(moved, balance), search_of(self.kinks, t0, y0))

    def adapt_step_size(
        self,
        t0: Any,
        t1: Any,
        y0: MotionState,
        y1_candidate: MotionState,
        args: Any,
        y_error: Any,
        error_order: Any,
        controller_state: Any,
    ) -> Any:
        """Whether to keep a step, and the next step."""
        before_step, (moved, balance), search = controller_state
        gain: Any = 0.0
        after_step = balance
        if isinstance(y_error, StepError):
            gain, after_step = self._balanced_by(balance, y_error, t1 - t0)
            y_error = y_error.state
        after = greatest(moved, y1_candidate)
        n = y0.u.shape[0]
        mechanism = jnp.arange(n) < n - self.states
        error_u = jnp.where(mechanism, jnp.maximum(jnp.abs(y_error.u), (t1 - t0) * jnp.abs(y_error.w)), 0.0)
        error_w = jnp.where(mechanism, 0.0, y_error.w)
        # An infinite error for NaN, so that the step is refused and shortened.
        error_u, error_w = (jnp.where(jnp.isfinite(error), error, jnp.inf) for error in (error_u, error_w))
        measured = MotionState(error_u, error_w, jnp.zeros_like(y_error.memory))
        begin, end = (MotionState(jnp.broadcast_to(after, (n,)), y.w, y.memory) for y in (y0, y1_candidate))
        # Energy gained counts as an error, over the allowed one.
        begin, end = (begin, after), (end, after)
        measured = measured, gain * (self.atol + self.rtol * after)
        # Derivatives treat step sizes as constants; only the begin of the first step moves the steps. If a jump cuts a
        # step short, proportional step sizes would multiply the change of all later steps, and their errors.
        fixed = jax.lax.stop_gradient((t0, t1))
        keep, next_t0, next_t1, made_jump, state, result = super().adapt_step_size(
            *fixed, begin, end, args, measured, error_order, before_step
        )
        next_t0 = next_t0 + jnp.where(keep, t1 - fixed[1], t0 - fixed[0])
        times, states, least = (t0, t1), (y0, y1_candidate), 0.0 if self.dtmin is None else self.dtmin
        refused = jnp.array(False)
        if self.passing is not None:
            refused = keep & self.passing.within(times, states, least)
            next_t1 = jnp.where(refused, t0 + 0.5 * (t1 - t0), next_t1)
        if self.kinks is not None:
            kinked, next_t1, search = search.after(self.kinks, times, states, keep & ~refused, next_t1, least)
            refused = refused | kinked
        if self.equations is not None:
            over, after_step = self._balanced(balance, times, states)
            unbalanced = keep & ~refused & (over >= 1)
            next_t1 = jnp.where(unbalanced, t0 + 0.5 * (t1 - t0), next_t1)
            small = unbalanced & (0.5 * (t1 - t0) < least)
            result = diffrax.RESULTS.where(small, diffrax.RESULTS.dt_min_reached, result)
            refused = refused | unbalanced
        if any(check is not None for check in (self.passing, self.kinks, self.equations)):
            keep, next_t0 = keep & ~refused, jnp.where(refused, t0, next_t0)
            state = jax.tree.map(lambda a, b: jnp.where(refused, a, b), before_step, state)
        # diffrax has no code for this.
        away = keep & (jnp.max(jnp.abs(y1_candidate.u), initial=0.0) > RAN_AWAY)
        result = diffrax.RESULTS.where(away, diffrax.RESULTS.internal_error, result)
        balance = jax.tree.map(lambda a, b: jnp.where(keep, a, b), after_step, balance)
        before = Before(jnp.where(keep, after, moved), balance)
        return keep, next_t0, next_t1, made_jump, (state, before, search), result

    def _balanced_by(self, balance: Balance, error: StepError, h: Any):
        """:meth:`_balanced`, from the solver's energies along the step."""
        balance, error, h = jax.lax.stop_gradient((balance, error, h))
        noise = error.inertia * (self.atol / jnp.where(h == 0, 1.0, h)) ** 2
        return balance.after(error.gained, error.energy, self.rtol, noise)

    def _balanced(self, balance: Balance, times: tuple[Any, Any], states: tuple[MotionState, MotionState]):
        """Energy gained in a step over the allowed one, and the balance after it."""
        equations, balance, times, states = jax.lax.stop_gradient((self.equations, balance, times, states))
        energy = elastic_energy(equations, times[1], states[1]) + kinetic_from_residual(equations, times[1], states[1])
        noise = kinetic_from_residual(equations, times[1], states[1]._replace(w=jnp.full_like(states[1].w, self.atol)))
        noise = noise / jnp.where(times[1] == times[0], 1.0, times[1] - times[0]) ** 2
        return balance.after(gained_between(equations, times, states), energy, self.rtol, noise)
