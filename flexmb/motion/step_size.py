"""How long a step may be: what a displacement, an error and a tolerance are measured by."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .protocol import MotionState

# Displacement beyond which a tolerance grows no more (extents, radians).
LARGE = 0.5
# A motion that comes as far runs away: it would end in numbers that are not finite, after very many steps.
FAR = 1e8
# Smallest step, as share of the time.
SMALLEST_STEP = 1e-12
# A step is so much shorter than its error would allow; its length grows and shrinks by these factors at most.
SAFETY, SHRINK, GROW = 0.9, 0.2, 10.0
# Exponents of a step's error and of that of the step before, in the order of the method.
OF_ERROR, OF_BEFORE = 0.4, -0.1


def greatest(before: float | Float[Array, ""], state: MotionState):
    """Greatest displacement so far, at most what is large."""
    now = jnp.max(jnp.abs(jax.lax.stop_gradient(state.u)), initial=0.0)
    return jnp.where(jnp.isfinite(now), jnp.clip(now, before, LARGE), before)


def error_of(
    at: tuple[MotionState, MotionState],
    error: MotionState,
    h: Float[Array, ""],
    moved: Float[Array, ""],
    states: int,
    allowed: tuple,
) -> Float[Array, ""]:
    """Error of a step over the tolerance, as :class:`flexmb.motion.step_control.DisplacementController` measures it.

    Args:
        at: States at the begin of the step and at its end.
        error: Estimate of its error.
        h: Length of the step [s].
        moved: Greatest displacement so far.
        states: Number of states of a controller, the last of the velocities.
        allowed: Relative and absolute tolerance.
    """
    (before, after), (rtol, atol) = at, allowed
    n = error.u.shape[0] - states
    own = jnp.maximum(jnp.abs(error.u[:n]), h * jnp.abs(error.w[:n])) / (atol + rtol * moved)
    if states:
        w1 = jnp.where(jnp.any(jnp.isnan(after.w)), before.w, after.w)
        of_states = atol + rtol * jnp.maximum(jnp.abs(before.w), jnp.abs(w1))[n:]
        own = jnp.concatenate([own, jnp.abs(error.w[n:]) / of_states])
    worst = jnp.max(own, initial=0.0)
    return jnp.where(jnp.isfinite(worst), worst, jnp.inf)


def next_step(
    h: Float[Array, ""], error: Float[Array, ""], before: Float[Array, ""], order: int, keep: Bool[Array, ""]
):
    """Length of the next step, and what the one after it is to know of this one, by a PI controller.

    Args:
        h: Length of the step [s].
        error: Its error over the tolerance.
        before: One over that of the last step that was kept.
        order: Of the method.
        keep: Whether the step is kept.

    Source:
        Hairer, Norsett, Wanner (1993), Solving Ordinary Differential Equations I, section II.4, as diffrax has it.
    """
    inverse = 1 / error
    factor = SAFETY * inverse ** (OF_ERROR / order) * before ** (OF_BEFORE / order)
    factor = jnp.clip(factor, jnp.where(keep, 1.0, SHRINK), jnp.where(keep, GROW, SAFETY))
    plain = (inverse == 0) | jnp.isinf(inverse)
    return h * factor, jnp.where(keep, jnp.where(plain, 1.0, inverse), before)
