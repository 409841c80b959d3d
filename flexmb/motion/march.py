"""The loop of the default solver over its steps, in fewer operations than the general one of diffrax.

What is found is the same. Derivatives are found on the way back, see :mod:`flexmb.motion.march_back`.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..math.indices import TRUSTED
from ..results import RESULTS
from .balance import Balance, Before, elastic_energy, gained_along, noise_of
from .kinks import Kinks, KinkSearch, search_of
from .protocol import Equations, MotionState
from .stages import RODAS5P, Taken, between, step_taken, z_within
from .step_size import FAR, SMALLEST_STEP, error_of, greatest, next_step
from .tape import Span, Tape, blank_tape, whole_loop

# A step that would end so close to the end, in round-off of the time, ends there.
CLOSE = 100


class Marched(NamedTuple):
    """Where steps have led.

    Attributes:
        states: At the times asked for, in rows; infinite where they were not reached.
        moved: Greatest displacement so far (extents, radians).
        steps: Number of steps.
        result: Code of RESULTS.
        jumped: Whether a force has jumped, as far as that was looked at.
        balance: Energy balance.
    """

    states: MotionState
    moved: Float[Array, ""]
    steps: Int[Array, ""]
    result: Int[Array, ""]
    jumped: Bool[Array, ""] | bool
    balance: Balance


class _March(NamedTuple):
    """State of the loop.

    Attributes:
        t: Begin of the next step [s].
        to: Its end [s].
        state: State at its begin.
        z: Accelerations and multipliers there, zero where they are not known.
        known: Whether they are.
        before: One over the error of the last step.
        saved: Number of rows that are known.
        found: What has been found.
        search: Search for a kink, or None.
        tape: Of the steps that were kept, or None.
    """

    t: Float[Array, ""]
    to: Float[Array, ""]
    state: MotionState
    z: Float[Array, "r"]
    known: Bool[Array, ""]
    before: Float[Array, ""]
    saved: Int[Array, ""]
    found: Marched
    search: KinkSearch | None
    tape: Tape | None


def until_stop(stops: Float[Array, "k"] | None, begin: Float[Array, ""], end: Float[Array, ""]) -> Float[Array, ""]:
    """End of a step, no later than the next time to be stepped onto.

    Args:
        stops: These times, or None, (k,) [s].
        begin: Begin of the step [s].
        end: Where it would end [s].
    """
    return end if stops is None else jnp.minimum(end, jnp.min(jnp.where(stops > begin, stops, jnp.inf)))


def until_end(
    t1: Float[Array, ""], kept: Bool[Array, ""], begin: Float[Array, ""], end: Float[Array, ""]
) -> Float[Array, ""]:
    """End of a step that goes no further than the span; after one that was refused, half the way to that end.

    Args:
        t1: End of the span [s].
        kept: Whether the step before was kept, or else refused.
        begin: Begin of the step [s].
        end: Where it would end [s].
    """
    close = t1 - CLOSE * jnp.finfo(float).eps * jnp.abs(t1)
    return jnp.where(end > close, jnp.where(kept, t1, begin + 0.5 * (t1 - begin)), end)


def code_of_step(small: Bool[Array, ""], kept: Bool[Array, ""], after: MotionState) -> Int[Array, ""]:
    """Code of RESULTS after a step: the next one is too small, or the state has run away."""
    away = kept & (jnp.max(jnp.abs(after.u), initial=0.0) > FAR)
    result = jnp.where(small, RESULTS.step_too_small, RESULTS.successful)
    return jnp.where(away, RESULTS.ran_away, result)


def nothing_found(times: Float[Array, "n_t"], start: MotionState, before: Before) -> Marched:
    """What is found before the first step."""
    rows = jax.tree.map(lambda one: jnp.full((len(times), *one.shape), jnp.inf), start)
    none = jnp.zeros((), jnp.int32)
    return Marched(rows, greatest(before.moved, start), none, none, jnp.array(False), before.balance)


def rows_reached(
    times: Float[Array, "n_t"],
    to: Float[Array, ""],
    kept: Bool[Array, ""],
    rows: tuple[Int[Array, ""], MotionState],
    within: Callable[[Float[Array, ""]], MotionState],
) -> tuple[Int[Array, ""], MotionState]:
    """Rows that are known after a step.

    Args:
        times: At which states are asked for [s].
        to: End of the step [s].
        kept: Whether it is kept.
        rows: Number of rows that were known before, and all rows.
        within: State at a time of the step.
    """
    count = len(times)

    def waits(rows: tuple[Array, MotionState]):
        at = times.at[jnp.minimum(rows[0], count - 1)].get(**TRUSTED)
        return kept & (rows[0] < count) & (at <= to)

    def saved(rows: tuple[Array, MotionState]):
        k, states = rows
        own, put = within(times.at[k].get(**TRUSTED)), jax.lax.dynamic_update_index_in_dim
        return k + 1, jax.tree.map(lambda all_, one: put(all_, one, k, 0), states, own)

    return jax.lax.while_loop(waits, saved, rows)


def ended(found: Marched, t: Float[Array, ""], span: Span, start: MotionState) -> tuple[Marched, Bool[Array, "n_t"]]:
    """What was found when the last step has led to ``t``, and which rows are the start itself."""
    result = found.result
    # Nothing moves where some motion has no mass.
    still = (result == RESULTS.singular_mass) | (span.times <= span.t0)
    states = jax.tree.map(lambda row, own: jnp.where(still[:, None], own, row), found.states, start)
    lost = ~jnp.all(jnp.isfinite(states.u))
    unfinished = (result == RESULTS.successful) & (t < span.t1)
    result = jnp.where(unfinished, RESULTS.motion_unfinished, result)
    result = jnp.where((result == RESULTS.successful) & lost, RESULTS.step_too_small, result)
    return found._replace(states=states, result=result.astype(jnp.int32)), still


def march(
    equations: Equations,
    span: Span,
    start: MotionState,
    before: Before,
    allowed: tuple[Float[Array, ""], Float[Array, ""]],
    first: Callable[[Float[Array, ""]], Float[Array, ""]],
    most: int,
    taped: bool = False,
    kinks: Kinks | None = None,
) -> tuple[Marched, Tape | None]:
    """States at times, step by step, and what the way back needs.

    Where the equations are linear in what begins unknown, a step of no length finds the accelerations and multipliers
    of the start: by the same code as all steps.

    Args:
        span: Begin and end, times at which to give them, and times to be stepped onto.
        start: State at the begin.
        before: What is known of the motion before.
        allowed: Relative and absolute tolerance.
        first: Length of the first step [s] by the greatest acceleration.
        most: Most steps.
        taped: Whether there is to be a way back.
        kinks: What finds kinks, where steps across them are to be short, or None.
    """
    t0, t1, times, stops = span
    n = start.u.shape[0]
    smallest = SMALLEST_STEP * (t1 - t0)

    def first_end(z: Float[Array, "r"]):
        fast = jnp.max(jnp.abs(z[: equations.size]), initial=1e-30)
        return jnp.minimum(t0 + jnp.maximum(first(fast), smallest), t1)

    def balanced(m: _March, taken: Taken, after: MotionState):
        times, states, mass = (m.t, m.to), (m.state, after), taken.by_z[:n, :n]
        h, rates, own = m.to - m.t, (m.z[:n], taken.z[:n]), slice(n - equations.states)

        def at(share: Float[Array, ""]):
            t = m.t + share * h
            state, rate = jax.jvp(lambda t: between(times, states, rates, t), (t,), (jnp.ones_like(t),))
            return t, state, jnp.append(rate.w, z_within((m.z, taken.z), taken.bows, share)[n:])

        energy = after.w[own] @ mass[own, own] @ after.w[own] / 2 + elastic_energy(equations, m.to, after)
        gained, noise = gained_along(equations, h, at), noise_of(mass, h, allowed[1])
        return m.found.balance.after(gained, energy, allowed[0], noise)

    def turn(m: _March) -> _March:
        h = m.to - m.t
        taken = step_taken(equations, RODAS5P, m.t, h, m.state, m.z, m.known if equations.linear else True)
        after = equations.settle(m.to, taken.end, taken.by_z[:n, :n])
        moved = greatest(m.found.moved, after)
        error = error_of((m.state, after), taken.error, h, moved, equations.states, allowed)
        gain, balance = balanced(m, taken, after)
        error = jnp.maximum(error, gain)
        keep = m.known & (error < 1)
        longer, before = next_step(h, error, m.before, RODAS5P.order, keep)
        end = jnp.where(keep, m.to, m.t) + jnp.maximum(longer, smallest)
        search = m.search
        if kinks is not None and search is not None:
            steps = (m.t, m.to), (m.state, after)
            refused, end, search = search.after(kinks, *steps, keep, end, smallest)
            keep, before = keep & ~refused, jnp.where(refused, m.before, before)
        begin = jnp.where(keep, m.to, m.t)
        end = until_end(t1, keep, begin, end)
        result = code_of_step(longer < smallest, keep, after)
        if equations.linear:
            regular = jax.lax.cond(m.known, lambda: jnp.array(True), lambda: equations.regular(taken.by_z))
            result = jnp.where(m.known, result, jnp.where(regular, RESULTS.successful, RESULTS.singular_mass))
            end = jnp.where(m.known, end, first_end(taken.z))
        end = until_stop(stops, begin, end)

        ends = (m.t, m.to), (m.state, after), (m.z[:n], taken.z[:n])
        k, states = rows_reached(times, m.to, keep, (m.saved, m.found.states), lambda t: between(*ends, t))
        found = Marched(
            states,
            jnp.where(keep, moved, m.found.moved),
            m.found.steps + m.known.astype(jnp.int32),
            result.astype(jnp.int32),
            m.found.jumped if search is None else search.jumped,
            jax.tree.map(lambda a, b: jnp.where(keep, a, b), balance, m.found.balance),
        )
        state = jax.tree.map(lambda a, b: jnp.where(keep, a, b), after, m.state)
        z = jnp.where(keep | ~m.known, taken.z, m.z)
        tape = m.tape
        if tape is not None:
            tape = tape.with_step(m.to, m.state, m.z, unfinished(m) & (keep | ~m.known))
        return _March(begin, end, state, z, jnp.array(True), before, k, found, search, tape)

    def unfinished(m: _March):
        return (m.found.result == RESULTS.successful) & (~m.known | (m.t < t1)) & (m.found.steps < most)

    none, known = jnp.zeros((), jnp.int32), jnp.array(not equations.linear)
    balance = before.balance.with_energy(elastic_energy(equations, t0, start))
    found = nothing_found(times, start, before._replace(balance=balance))
    if equations.linear:
        z, end = jnp.zeros(equations.unknowns), t0
    else:
        z, regular = equations.acceleration(t0, start)
        end = until_stop(stops, t0, first_end(z))
        found = found._replace(result=jnp.where(regular, none, RESULTS.singular_mass).astype(jnp.int32))
    search = None if kinks is None else search_of(kinks, t0, start)
    tape = blank_tape(most, start, z) if taped else None
    m = _March(t0, end, start, z, known, jnp.array(1.0), none, found, search, tape)
    if taped:
        m = whole_loop(unfinished, turn, m)
    else:
        m = jax.lax.while_loop(unfinished, turn, m)
    found, still = ended(m.found, m.t, span, start)
    return found, None if m.tape is None else m.tape._replace(last=m.z, saved=m.saved, still=still)
