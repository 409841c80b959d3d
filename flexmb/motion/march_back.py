"""The way back over the steps of a motion: derivatives of what :func:`march` finds, in reverse mode.

Each step is a function of the state at its begin and of the numbers of the equations; the way back goes over the steps
from the last one, and takes the derivative of each where it was taken. The lengths of the steps are as they are: the
begin of a motion, and where it must stop, take the steps behind them along, up to its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from ..math.derivative import Varied
from .march import Marched
from .protocol import Equations, MotionState
from .stages import RODAS5P, between, step_taken
from .tape import Span, Tape, whole_loop


class _Back(NamedTuple):
    """State of the loop.

    Attributes:
        step: To go back over.
        ready: Number of steps of its group, of which one is kept, whose begins are known; without what is kept.
        row: Next row, from the last.
        end: Derivatives by the state at the end of the step, and by its accelerations and multipliers.
        numbers: Derivatives by the numbers of the equations that vary.
        span: Derivatives by the times, None where these do not vary.
        tape: Of the steps.
    """

    step: Int[Array, ""]
    ready: Int[Array, ""]
    row: Int[Array, ""]
    end: tuple[MotionState, Float[Array, "r"]]
    numbers: list[Array]
    span: Span | None
    tape: Tape


def march_back(
    equations: Varied, span: Varied, start: Varied, tape: Tape, changes: Marched
) -> tuple[list[Array], list[Array], list[Array]]:
    """Derivatives by numbers of the equations, by times and by the start of a motion.

    Args:
        equations: Equations of motion.
        span: Its :class:`Span`.
        start: State that it starts from.
        tape: Of its steps.
        changes: Derivatives by what was found; of these the states count.

    Returns:
        Derivatives by the numbers of each that vary.
    """
    own: Equations = equations.whole(equations.numbers)
    times: Span = span.whole(span.numbers)
    begin: MotionState = start.whole(start.numbers)
    n, linear = begin.u.shape[0], own.linear

    def stepped(numbers: list[Any], state: MotionState, z: Array, t0: Array, t1: Array, known: Any):
        """What a step leads to, the one of no length at the start, that finds z, as well."""
        of: Equations = equations.whole(numbers)
        taken = step_taken(of, RODAS5P, t0, t1 - t0, state, z, known)
        after = of.settle(t1, taken.end, taken.by_z[:n, :n])
        return jax.tree.map(lambda a, b: jnp.where(known, a, b), after, state), taken.z

    def over_rows(ends: tuple[Any, ...], row: Any, by: tuple[Any, ...]):
        """Derivatives of the rows in a step, from the last one, added to those by its ends."""

        def within(at: tuple[Any, Any]):
            return (at[0] >= 0) & (times.times[jnp.maximum(at[0], 0)] > ends[0][0])

        def added(at: tuple[Any, Any]):
            row, (by_ends, by_times) = at
            by_row = jax.tree.map(lambda rows: rows[row], changes.states)
            _, pull = jax.vjp(lambda ends, t: between(*ends, t), ends, times.times[row])
            of_ends, of_time = pull(by_row)
            by_ends = jax.tree.map(jnp.add, by_ends, of_ends)
            return row - 1, (by_ends, None if by_times is None else by_times.at[row].add(of_time))

        return jax.lax.while_loop(within, added, (row, by))

    def turn(m: _Back) -> _Back:
        tape = m.tape
        # Of a step that is not kept, those from the last one that is are taken first.
        first = m.step - (m.step - tape.kept) % tape.apart
        filling = (m.step >= tape.kept) & (first + m.ready < m.step)
        step = jnp.where(filling, first + m.ready, m.step)
        t0, t1 = jnp.where(step == 0, times.t0, tape.ends[jnp.maximum(step - 1, 0)]), tape.ends[step]
        known = (step > 0) if linear else True
        state, z = tape.at(tape.place(step))
        if m.span is None:
            (after, z1), pull = jax.vjp(
                lambda numbers, state, z: stepped(numbers, state, z, t0, t1, known), m_numbers, state, z
            )
        else:
            (after, z1), pull = jax.vjp(
                lambda numbers, state, z, t0, t1: stepped(numbers, state, z, t0, t1, known),
                m_numbers,
                state,
                z,
                t0,
                t1,
            )
        ends = (t0, t1), (state, after), (z[:n], z1[:n])
        by = jax.tree.map(jnp.zeros_like, ends), None if m.span is None else m.span.times
        row, (by_ends, by_times) = over_rows(ends, jnp.where(filling, -1, m.row), by)
        (by_t0, by_t1), (by_state, by_after), (by_a0, by_a1) = by_ends
        after_all = jax.tree.map(jnp.add, m.end[0], by_after)
        numbers, by_begin, by_z, *by_time = pull((after_all, m.end[1].at[:n].add(by_a1)))
        by_begin = jax.tree.map(jnp.add, by_begin, by_state)
        found = _Back(
            m.step - 1,
            jnp.where(m.step - 1 < first, 0, m.ready),
            row,
            (by_begin, by_z.at[:n].add(by_a0)),
            jax.tree.map(jnp.add, m.numbers, numbers),
            m.span,
            tape,
        )
        if m.span is not None and by_time:
            spread = m.span._replace(times=by_times)
            spread = _added(spread, times, t0, by_time[0] + by_t0)
            found = found._replace(span=_added(spread, times, t1, by_time[1] + by_t1))
        going = m.step >= 0
        # What was taken only to know where a later one begins.
        only = m._replace(ready=m.ready + 1)
        put = tape.put(jnp.where(filling & going, tape.place(step + 1), tape.room - 1), after, z1)
        chosen = jax.tree.map(
            lambda a, b: jnp.where(filling, a, b), only._replace(tape=None), found._replace(tape=None)
        )
        return chosen._replace(tape=put)

    m_numbers = equations.numbers
    nothing = jax.tree.map(jnp.zeros_like, (begin, tape.z[0]))
    none = None if not span.numbers else jax.tree.map(jnp.zeros_like, times)
    m = _Back(
        tape.count - 1,
        jnp.zeros((), jnp.int32),
        tape.saved - 1,
        nothing,
        jax.tree.map(jnp.zeros_like, m_numbers),
        none,
        tape,
    )
    m = whole_loop(lambda m: m.step >= 0, turn, m)
    by_start, by_z = m.end
    numbers = m.numbers
    if not linear:
        # Found before the first step.
        def found(numbers: list[Any], state: MotionState, t0: Array):
            return equations.whole(numbers).acceleration(t0, state)[0]

        _, pull = jax.vjp(found, m_numbers, begin, times.t0)
        more, by_state, by_t0 = pull(by_z)
        numbers = jax.tree.map(jnp.add, numbers, more)
        by_start = jax.tree.map(jnp.add, by_start, by_state)
        none = None if m.span is None else _added(m.span, times, times.t0, by_t0)
    else:
        none = m.span
    still = jax.tree.map(lambda rows: jnp.where(tape.still[:, None], rows, 0.0).sum(axis=0), changes.states)
    by_start = jax.tree.map(jnp.add, by_start, still)
    return numbers, _of(span, none), _of(start, by_start)


def _added(by: Span, times: Span, t: Array, change: Array) -> Span:
    """Derivatives by the times, with that by an end of a step: of what it is as far from as before.

    Args:
        by: Derivatives so far.
        times: The times.
        t: Begin or end of a step [s].
        change: Derivative by it.
    """
    of_end = t == times.t1
    by = by._replace(t1=by.t1 + jnp.where(of_end, change, 0.0))
    of_begin = ~of_end
    if times.stops is not None and by.stops is not None:
        passed = jnp.where(times.stops <= t, times.stops, -jnp.inf)
        last = jnp.argmax(passed)
        of_stop = of_begin & (passed[last] > times.t0)
        by = by._replace(stops=by.stops.at[last].add(jnp.where(of_stop, change, 0.0)))
        of_begin = of_begin & ~of_stop
    return by._replace(t0=by.t0 + jnp.where(of_begin, change, 0.0))


def _of(argument: Varied, by: Any) -> list[Array]:
    """Derivatives by the numbers that vary, of those by all of an argument."""
    if not argument.numbers:
        return []
    marked = argument.whole([_Mark() for _ in argument.numbers])
    whole: Sequence[Any] = jax.tree.leaves(marked)
    return [own for own, mark in zip(jax.tree.leaves(by), whole, strict=True) if isinstance(mark, _Mark)]


class _Mark:
    """Stands for a number that varies."""
