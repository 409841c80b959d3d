"""The loop of Radau's method over the steps of a long chain: matrices are kept from step to step where they serve."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..results import RESULTS
from .balance import Before
from .chain_form import ChainForm
from .collocation import (
    MOST,
    Carried,
    StepMatrices,
    between_steps,
    carried_from,
    collocated,
    foretold,
    matrices_of_step,
    pieces_of_step,
)
from .march import Marched, code_of_step, ended, nothing_found, rows_reached, until_end, until_stop
from .protocol import MotionState
from .step_size import SMALLEST_STEP, error_of, greatest
from .tape import Span, Tape, blank_tape, whole_loop

# Derivatives are kept while Newton's method converges at such a rate, and factors where the step would change by a
# factor between these.
QUICK = 0.02
SAME = (1.0, 1.2)
# A step is so much shorter than its error would allow; it grows and shrinks by these factors at most, and by the last
# where Newton's method fails.
SAFETY, GROW, SHRINK, FAILED = 0.9, 8.0, 0.2, 0.5
# Order of the error estimate.
ORDER = 4


class _ChainMarch(NamedTuple):
    """State of the loop.

    Attributes:
        t: Begin of the next step [s].
        to: Its end [s].
        state: State at its begin.
        carried: From the last step.
        matrices: Last computed.
        length: Of the step they were factored for [s].
        anew: Whether derivatives are to be computed anew.
        before: Length [s] and error of the last step that was kept.
        refused: Whether the last step was refused.
        saved: Number of rows that are known.
        found: What has been found.
        tape: Of the steps that were kept, or None.
    """

    t: Float[Array, ""]
    to: Float[Array, ""]
    state: MotionState
    carried: Carried
    matrices: StepMatrices
    length: Float[Array, ""]
    anew: Bool[Array, ""]
    before: tuple[Float[Array, ""], Float[Array, ""]]
    refused: Bool[Array, ""]
    saved: Int[Array, ""]
    found: Marched
    tape: Tape | None


def march_chain(
    equations: ChainForm,
    span: Span,
    start: MotionState,
    before: Before,
    allowed: tuple[Float[Array, ""], Float[Array, ""]],
    first: Callable[[Float[Array, ""]], Float[Array, ""]],
    most: int,
    taped: bool = False,
) -> tuple[Marched, Tape | None]:
    """States of a chain at times, step by step; arguments and results as :func:`flexmb.motion.march.march` has them.

    Source:
        Hairer, Wanner (1996), Solving Ordinary Differential Equations II, section IV.8, with the step sizes after
        Gustafsson; errors as :func:`flexmb.motion.step_size.error_of` measures them.
    """
    t0, t1, times, stops = span
    n = start.u.shape[0]
    smallest = SMALLEST_STEP * (t1 - t0)

    def turn(m: _ChainMarch) -> _ChainMarch:
        h = m.to - m.t
        guess = foretold(m.carried, h)
        pieces, at = jax.lax.cond(
            m.anew,
            lambda: pieces_of_step(equations, m.t, h, m.state, guess),
            lambda: (m.matrices.pieces, m.matrices.at),
        )
        other_step = m.anew | (jnp.abs(h - m.length) > 1e-9 * h)
        matrices = jax.lax.cond(
            other_step,
            lambda: matrices_of_step(equations, pieces, h, at),
            lambda: StepMatrices(pieces, m.matrices.real, m.matrices.other, at),
        )
        taken = collocated(equations, m.t, h, m.state, m.carried, guess, matrices, allowed)
        after = taken.end
        moved = greatest(m.found.moved, after)
        error = jnp.maximum(error_of((m.state, after), taken.error, h, moved, 0, allowed), 1e-10)
        keep = error < 1
        # Shorter where Newton's method took many turns.
        safety = jnp.minimum(SAFETY, SAFETY * (1 + 2 * MOST) / (taken.turns + 2 * MOST))
        factor = safety * error ** (-1 / ORDER)
        h_before, before = m.before
        foreseen = SAFETY * h / h_before * (before / error**2) ** (1 / ORDER)
        factor = jnp.where(keep, jnp.minimum(factor, jnp.where(h_before > 0, foreseen, factor)), factor)
        factor = jnp.clip(factor, SHRINK, GROW)
        factor = jnp.where(taken.solved, factor, FAILED)
        factor = jnp.where(keep & m.refused, jnp.minimum(factor, 1.0), factor)
        quick = keep & (taken.carried.rate <= QUICK)
        same = quick & (factor >= SAME[0]) & (factor <= SAME[1])
        longer = jnp.where(same, h, h * factor)
        begin = jnp.where(keep, m.to, m.t)
        end = until_end(t1, keep, begin, begin + jnp.maximum(longer, smallest))
        end = until_stop(stops, begin, end)
        result = code_of_step(longer < smallest, keep, after)

        ends = (m.t, m.to), (m.state, after), (m.carried.z[:n], taken.carried.z[:n])
        k, states = rows_reached(times, m.to, keep, (m.saved, m.found.states), lambda t: between_steps(*ends, t))
        moved = jnp.where(keep, moved, m.found.moved)
        steps = m.found.steps + 1
        found = m.found._replace(states=states, moved=moved, steps=steps, result=result.astype(jnp.int32))
        state, carried = jax.tree.map(lambda a, b: jnp.where(keep, a, b), (after, taken.carried), (m.state, m.carried))
        carried = carried._replace(rate=taken.carried.rate)
        before = jax.tree.map(lambda a, b: jnp.where(keep, a, b), (h, jnp.maximum(error, 1e-2)), m.before)
        tape = m.tape
        if tape is not None:
            tape = tape.with_step(m.to, m.state, m.carried, unfinished(m) & keep)
        return _ChainMarch(begin, end, state, carried, matrices, h, ~quick, before, ~keep, k, found, tape)

    def unfinished(m: _ChainMarch):
        return (m.found.result == RESULTS.successful) & (m.t < t1) & (m.found.steps < most)

    none = jnp.zeros((), jnp.int32)
    z, regular = equations.acceleration(t0, start)
    result = jnp.where(regular, none, RESULTS.singular_mass).astype(jnp.int32)
    found = nothing_found(times, start, before)._replace(result=result)
    fast = jnp.max(jnp.abs(z[:n]), initial=1e-30)
    end = until_stop(stops, t0, jnp.minimum(t0 + jnp.maximum(first(fast), smallest), t1))
    shapes = jax.eval_shape(
        lambda h: matrices_of_step(equations, equations.pieces(t0, start, z), h, equations.form.parameters.reference),
        end,
    )
    matrices = jax.tree.map(lambda like: jnp.zeros(like.shape, like.dtype), shapes)
    yes, zero = jnp.array(True), jnp.zeros(())
    carried = carried_from(z)
    tape = blank_tape(most, start, carried) if taped else None
    m = _ChainMarch(t0, end, start, carried, matrices, zero, yes, (zero, jnp.ones(())), ~yes, none, found, tape)
    m = whole_loop(unfinished, turn, m) if taped else jax.lax.while_loop(unfinished, turn, m)
    found, still = ended(m.found, m.t, span, start)
    return found, None if m.tape is None else m.tape._replace(last=m.carried, saved=m.saved, still=still)
