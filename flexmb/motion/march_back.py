"""The way back over the steps of a motion: derivatives of what :func:`march` finds, in reverse mode.

Each step is a function of the state at its begin and of the numbers of the equations; the way back goes over the steps
from the last one, and takes the derivative of each where it was taken. The lengths of the steps are as they are: the
begin of a motion, and where it must stop, take the steps behind them along, up to its end.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..math.derivative import Varied
from .march import Marched
from .protocol import Equations, MotionState
from .stages import RODAS5P, between, step_taken
from .tape import Span, Tape, whole_loop


class Method(NamedTuple):
    """How the steps of a solver are taken anew.

    Attributes:
        step: Of the equations, begin and end of a step, the state at its begin, what was carried over to it, whether
            that was known, and what was carried over from it, as far as it is known: the state at its end, and what is
            carried over from it.
        between: State within a step, of the times, states and accelerations at both ends, at a time.
        z: Accelerations and multipliers, of what is carried over.
        carried: What is carried over to the first step, of these.
        still: Whether a step of no length at the start finds them.
    """

    step: Callable[..., tuple[MotionState, Any]]
    between: Callable[..., MotionState]
    z: Callable[[Any], Float[Array, "r"]]
    carried: Callable[[Float[Array, "r"]], Any]
    still: bool


def rodas(still: bool) -> Method:
    """How steps of the default solver are taken anew.

    Args:
        still: Whether a step of no length at the start finds its accelerations and multipliers.
    """

    def step(of: Equations, times: tuple[Array, Array], state: MotionState, z: Array, known: Any, _: Any):
        n, (t0, t1) = state.u.shape[0], times
        taken = step_taken(of, RODAS5P, t0, t1 - t0, state, z, known)
        after = of.settle(t1, taken.end, taken.by_z[:n, :n])
        return jax.tree.map(lambda a, b: jnp.where(known, a, b), after, state), taken.z

    return Method(step, between, lambda z: z, lambda z: z, still)


class _Back(NamedTuple):
    """State of the loop.

    Attributes:
        step: To go back over.
        ready: Number of steps behind the last one that is kept, up to this one, whose begins are known.
        row: Next row, from the last.
        end: Derivatives by the state at the end of the step, and by what is carried over from it.
        after: What is carried over from it, or zeros where that is not known.
        at: State at the begin of the step that is taken next, and what was carried over to it. It is read where the
            tape was written last: what is read before it is written would be copied as a whole.
        numbers: Derivatives by the numbers of the equations that vary.
        span: Derivatives by the times, None where these do not vary.
        tape: Of the steps.
    """

    step: Int[Array, ""]
    ready: Int[Array, ""]
    row: Int[Array, ""]
    end: tuple[MotionState, Any]
    after: Any
    at: tuple[MotionState, Any]
    numbers: list[Any]
    span: Span | None
    tape: Tape | None


class _WayBack(NamedTuple):
    """What the way back goes over.

    Attributes:
        equations: Equations of motion.
        method: How its steps are taken anew.
        times: Times of the motion.
        rows: Derivatives by its states.
    """

    equations: Varied
    method: Method
    times: Span
    rows: MotionState

    def between(self, ends: Any, t: Float[Array, ""]) -> MotionState:
        """State within a step, of the times, states and what is carried over at both ends."""
        times, states, carried = ends
        n = states[0].u.shape[0]
        begin, end = (self.method.z(one)[:n] for one in carried)
        return self.method.between(times, states, (begin, end), t)

    def over_rows(self, ends: Any, row: Any, by: tuple[Any, ...]):
        """Derivatives by the rows in a step, from the last one, added to those by its ends and by their times."""
        every = self.times.times

        def within(at: tuple[Any, Any]):
            return (at[0] >= 0) & (every[jnp.maximum(at[0], 0)] > ends[0][0])

        def added(at: tuple[Any, Any]):
            row, (by_ends, by_times) = at
            _, pull = jax.vjp(self.between, ends, every[row])
            of_ends, of_time = pull(jax.tree.map(lambda rows: rows[row], self.rows))
            by_ends = jax.tree.map(jnp.add, by_ends, of_ends)
            return row - 1, (by_ends, None if by_times is None else by_times.at[row].add(of_time))

        return jax.lax.while_loop(within, added, (row, by))

    def turn(self, m: _Back) -> _Back:
        """Back over one step, or on from one that is kept to where the step begins."""
        tape: Any = m.tape
        step, filling = _taken_next(m, tape)
        t0, t1 = jnp.where(step == 0, self.times.t0, tape.ends[jnp.maximum(step - 1, 0)]), tape.ends[step]
        known = (step > 0) if self.method.still else True
        state, carried = m.at
        near = jax.tree.map(lambda one: jnp.where(filling, 0.0, one), m.after)

        def stepped(numbers: list[Any], state: MotionState, carried: Any, *times: Array):
            return self.method.step(self.equations.whole(numbers), times or (t0, t1), state, carried, known, near)

        varied = () if m.span is None else (t0, t1)
        (after, carried_on), pull = jax.vjp(stepped, self.equations.numbers, state, carried, *varied)
        ends = (t0, t1), (state, after), (carried, carried_on)
        by = jax.tree.map(jnp.zeros_like, ends), None if m.span is None else m.span.times
        row, (by_ends, by_rows) = self.over_rows(ends, jnp.where(filling, -1, m.row), by)
        (by_t0, by_t1), (by_state, by_after), (by_carried, by_carried_on) = by_ends
        # Where it goes on nothing is asked, and equations are solved at once.
        asked = jax.tree.map(lambda one: jnp.where(filling, 0.0, one), m.end)
        numbers, by_begin, by_last, *by_times = pull(jax.tree.map(jnp.add, asked, (by_after, by_carried_on)))
        span = m.span
        if span is not None:
            span = _added(span._replace(times=by_rows), self.times, t0, by_times[0] + by_t0)
            span = _added(span, self.times, t1, by_times[1] + by_t1)
        back = _Back(
            m.step - 1,
            jnp.where(m.step - 1 < tape.last_kept(m.step), 0, m.ready),
            row,
            jax.tree.map(jnp.add, (by_begin, by_last), (by_state, by_carried)),
            carried,
            m.at,
            jax.tree.map(jnp.add, m.numbers, numbers),
            span,
            None,
        )
        on = m._replace(ready=m.ready + 1, tape=None)
        chosen = jax.tree.map(lambda a, b: jnp.where(filling, a, b), on, back)
        place = jnp.where(filling & (m.step >= 0), tape.place(step + 1), tape.room - 1)
        return _about_to(chosen, tape.put(place, after, carried_on))


def _taken_next(m: _Back, tape: Tape) -> tuple[Int[Array, ""], Bool[Array, ""]]:
    """Step that is taken next, and whether on from one that is kept, or else back."""
    first = tape.last_kept(m.step)
    filling = first + m.ready < m.step
    return jnp.where(filling, first + m.ready, m.step), filling


def _about_to(m: _Back, tape: Tape) -> _Back:
    """The state of the loop with the begin of the step that is taken next."""
    return m._replace(tape=tape, at=tape.at(tape.place(_taken_next(m, tape)[0])))


def march_back(
    equations: Varied, span: Varied, start: Varied, tape: Tape, changes: Marched, method: Method | None = None
) -> tuple[list[Any], list[Any], list[Any]]:
    """Derivatives by numbers of the equations, by times and by the start of a motion.

    Args:
        equations: Equations of motion.
        span: Its :class:`Span`.
        start: State that it starts from.
        tape: Of its steps.
        changes: Derivatives by what was found; of these the states count.
        method: How steps are taken anew; None: as those of the default solver.

    Returns:
        Derivatives by the numbers of each that vary; NaN where a state is asked about that was not reached.

    Source:
        THEORY.md 10, eq. (10.5).
    """
    own: Equations = equations.whole(equations.numbers)
    times: Span = span.whole(span.numbers)
    begin: MotionState = start.whole(start.numbers)
    saved: Any = tape.saved
    method = rodas(own.linear) if method is None else method
    nothing, none = jax.tree.map(jnp.zeros_like, (tape.at(jnp.zeros((), jnp.int32)), equations.numbers))
    by_span = jax.tree.map(jnp.zeros_like, times) if span.numbers else None
    ready = jnp.zeros((), jnp.int32)
    m = _Back(tape.steps - 1, ready, saved - 1, nothing, tape.last, nothing, none, by_span, None)
    m = _about_to(m, tape._replace(last=None))
    m = whole_loop(lambda m: m.step >= 0, _WayBack(equations, method, times, changes.states).turn, m)
    (by_start, by_carried), numbers, by_span = m.end, m.numbers, m.span
    if not method.still:
        # Found before the first step.
        def found(numbers: list[Any], state: MotionState, t0: Array):
            of: Equations = equations.whole(numbers)
            return method.carried(of.acceleration(t0, state)[0])

        _, pull = jax.vjp(found, equations.numbers, begin, times.t0)
        *more, by_t0 = pull(by_carried)
        numbers, by_start = jax.tree.map(jnp.add, (numbers, by_start), tuple(more))
        by_span = None if by_span is None else by_span._replace(t0=by_span.t0 + by_t0)
    still: Any = tape.still
    of_still = jax.tree.map(lambda rows: jnp.where(still[:, None], rows, 0.0).sum(axis=0), changes.states)
    by_start = jax.tree.map(jnp.add, by_start, of_still)
    return _unless_missed((numbers, _of(span, by_span), _of(start, by_start)), tape, changes.states)


def _unless_missed(derivatives: Any, tape: Tape, asked: MotionState) -> Any:
    """Derivatives, NaN where they are asked for by states that the motion did not reach.

    Args:
        derivatives: Pytree of numbers.
        tape: Of its steps.
        asked: Derivatives by the states, in rows.
    """
    saved, still = jnp.asarray(tape.saved), jnp.asarray(tape.still)
    missed = (jnp.arange(asked.u.shape[0], dtype=saved.dtype) >= saved) & ~still
    lost = functools.reduce(jnp.logical_or, [jnp.any((rows != 0) & missed[:, None]) for rows in asked])
    return jax.tree.map(lambda one: jnp.where(lost, jnp.nan, one), derivatives)


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
    return [own for own, varies in zip(jax.tree.leaves(by), argument.varies, strict=True) if varies]
