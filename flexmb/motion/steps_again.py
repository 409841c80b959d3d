"""Reverse derivatives of a motion: its steps are repeated, and each is differentiated.

Lengths of steps have no derivatives. A change of the first time, or of a time to step onto, moves all later steps.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..compilation.compile import traced_once
from ..math.derivative import Varied
from ..numerical_limits import JUST_BEHIND
from .protocol import MotionState, Tangent
from .stages import StepBegin, not_after, rosenbrock_step, state_within_step, step_pulled_back

# Steps that are stored at once, some ten megabytes. For more coordinates fewer steps, with this number of numbers
# together, but at least the last number of steps.
STORED, NUMBERS, FEWEST = 2048, 2**21, 100


class Span(NamedTuple):
    """Times of a motion [s].

    Attributes:
        t0, t1: Begin and end.
        times: Times of the result.
        stops: Times to step onto.
        jumps: Times to step onto at which accelerations are computed anew.
    """

    t0: Float[Array, ""]
    t1: Float[Array, ""]
    times: Float[Array, "n_t"]
    stops: Float[Array, "k"] | None = None
    jumps: Float[Array, "k"] | None = None


class _Back(NamedTuple):
    """Derivatives during the reverse pass.

    Attributes:
        step: Next step, from the end.
        row: Last row before its end.
        end: By the state at the end of the step, and by accelerations and multipliers there.
        numbers: By the varied numbers of the equations.
        edges: By the begins and ends of all steps, and by the times of the rows, or None.
    """

    step: Int[Array, ""]
    row: Int[Array, ""]
    end: tuple[MotionState, Array]
    numbers: list[Any]
    edges: tuple[Array, Array] | None


def pulled_back(parts: list[Varied], ends: Float[Array, "most"], changes: MotionState) -> list[list[Any]]:
    """Derivatives by the varied numbers of equations, :class:`Span` and start (`parts`); NaN by states not reached.

    Steps run forward from the start, and every n-th state is stored. From the last stored state on, all states are
    stored, and the reverse pass goes over these steps, then over the earlier steps (THEORY.md 10, eq. (10.5)). `ends`
    are the ends of the kept steps, `changes` derivatives by the states in rows.
    """
    _, timed, start = (part.whole(part.numbers) for part in parts)
    numbers = parts[0].numbers
    edges, ends_of_steps = _edges(timed, timed, ends)
    count, most = jnp.sum(jnp.isfinite(edges)) - 1, edges.shape[0] - 2
    varied = bool(parts[1].numbers)

    equations = parts[0].whole(numbers)
    z = jnp.zeros(equations.unknowns)

    def last_time(step: Array) -> Array | None:
        return None if timed.jumps is None else ends_of_steps[step]

    @traced_once
    def taken(step: Array, state: MotionState, z: Array):
        h = edges[step + 1] - edges[step]
        return rosenbrock_step(equations, edges[step], h, state, z, last_time(step))

    outcome = jax.eval_shape(taken, count, start, z)
    # Matrices element by element, and large ones, are too many to store: these steps are taken once more.
    of_step = sum(leaf.size for leaf in jax.tree.leaves(outcome))
    stores = isinstance(outcome.tangent, Tangent) and of_step * FEWEST <= NUMBERS
    record = (start, z), (outcome if stores else None)
    size = sum(leaf.size for leaf in jax.tree.leaves(record))
    room = min(most, max(FEWEST, min(STORED, NUMBERS // max(size, 1))))
    stored, sparse = _rows(room, record), _put(_rows(most // room + 2, (start, z)), 0, (start, z))

    def forward(m: tuple[Any, ...]):
        step, at, stored, sparse = m
        # States that are not stored go to the last place.
        place = jnp.where(step % room == 0, step // room, -1)
        outcome = taken(step, *at)
        stored, sparse = _put(stored, step % room, (at, outcome if stores else None)), _put(sparse, place, at)
        return step + 1, (equations.settle(ends_of_steps[step], outcome.end, outcome.mass), outcome.z), stored, sparse

    def backward(stored: Any, m: _Back):
        t0, t1 = edges[m.step], edges[m.step + 1]
        (state, z), outcome = jax.tree.map(lambda rows: rows[m.step % room], stored)
        outcome = outcome if stores else taken(m.step, state, z)

        def settled(numbers: list[Any], t1: Array, end: MotionState):
            return parts[0].whole(numbers).settle(not_after(t1, ends_of_steps[m.step]), end, outcome.mass)

        after, pull = jax.vjp(settled, numbers, t1, outcome.end)
        step_ends = (t0, t1), (state, after), (z, outcome.z)
        by_times = None if m.edges is None else m.edges[1]
        row, (by_whole, by_times) = _over_rows(timed.times, changes, step_ends, m.row, by_times)
        by_span, (by_begin, by_end), (by_z, by_z1) = by_whole
        by_after, by_z1 = jax.tree.map(jnp.add, m.end, (by_end, by_z1))
        by_numbers, by_t1, by_outcome = pull(by_after)
        begin = StepBegin(numbers, t0, t1 - t0, state, z)
        record = outcome.tangent, outcome.increments
        of = step_pulled_back(parts[0].whole, begin, *record, by_outcome, by_z1, last_time(m.step))
        of_span = of.t - of.h, by_t1 + of.h
        by_edges = None
        if m.edges is not None and by_times is not None:
            pair = jnp.stack([of_edge + by_edge for of_edge, by_edge in zip(of_span, by_span, strict=True)])
            pair = pair + jax.lax.dynamic_slice(m.edges[0], (m.step,), (2,))
            by_edges = jax.lax.dynamic_update_slice(m.edges[0], pair, (m.step,)), by_times
        by_start = jax.tree.map(jnp.add, (of.state, of.z), (by_begin, by_z))
        by_numbers = jax.tree.map(lambda *parts: sum(parts), m.numbers, of.numbers, by_numbers)
        return _Back(m.step - 1, row, by_start, by_numbers, by_edges)

    def part(m: tuple[Any, ...]):
        limit, stored, sparse, back = m
        first = (limit - 1) // room * room
        # First run over all steps, to store states.
        whence = jnp.where(limit == count, 0, first)
        at = jax.tree.map(lambda rows: rows[whence // room], sparse)
        steps = whence, at, stored, sparse
        _, _, stored, sparse = jax.lax.while_loop(lambda m: m[0] < limit, forward, steps)
        back = jax.lax.while_loop(lambda m: m.step >= first, functools.partial(backward, stored), back)
        return first, stored, sparse, back

    last = edges[count]
    missed = (timed.times > last)[:, None]
    saved = jnp.sum(timed.times <= last) - 1
    nothing = jax.tree.map(jnp.zeros_like, ((start, z), numbers))
    none = (jnp.zeros_like(edges), jnp.zeros_like(timed.times)) if varied else None
    m = count, stored, sparse, _Back(count - 1, saved, nothing[0], nothing[1], none)
    *_, back = jax.lax.while_loop(lambda m: m[0] > 0, part, m)
    by_state, by_numbers = back.end[0], back.numbers
    still = (timed.times <= timed.t0)[:, None]
    of_still = jax.tree.map(lambda rows: jnp.sum(jnp.where(still, rows, 0.0), axis=0), changes)
    by_state = jax.tree.map(jnp.add, by_state, of_still)
    derivatives = [by_numbers, [], _by(parts[2].whole, parts[2].numbers, by_state)]
    if back.edges is not None:

        def known(numbers: list[Any]):
            span: Span = parts[1].whole(numbers)
            return _edges(timed, span, ends)[0], span.times

        derivatives[1] = _by(known, parts[1].numbers, back.edges)
    lost = functools.reduce(jnp.logical_or, [jnp.any((rows != 0) & missed) for rows in changes])
    return jax.tree.map(lambda leaf: jnp.where(lost, jnp.nan, leaf), derivatives)


def _edges(
    known: Span, span: Span, ends: Float[Array, "most"]
) -> tuple[Float[Array, "edges"], Float[Array, "edges-1"]]:
    """Begins and ends of all steps in one row, infinite beyond the last, and the last time of the loads of each step.

    At the start and after each jump, a step of zero length computes accelerations and multipliers. diffrax goes on at
    the next number after a jump. There the step before the jump ends, but its loads are those before the jump.
    """
    moved = _moved_along(ends, known, span)
    if known.jumps is None:
        edges = jnp.concatenate([span.t0[None], span.t0[None], moved])
        return edges, edges[1:]
    at, met = _behind(known.jumps, ends)
    more = jnp.zeros(ends.size, int).at[jnp.where(met, at, ends.size)].add(1, mode="drop")
    places = 2 + jnp.arange(ends.size) + jnp.cumsum(more) - more
    edges = jnp.full(2 + ends.size + at.size, jnp.inf).at[:2].set(span.t0).at[places].set(moved)
    of_jumps = jnp.where(met, places[at], edges.size)
    edges = edges.at[of_jumps + 1].set(moved[at], mode="drop")
    before = known.jumps - jnp.maximum(np.finfo(float).eps * jnp.abs(known.jumps), np.finfo(float).tiny)
    # The first of two equal edges ends the step before the jump.
    return edges, jax.lax.stop_gradient(edges[1:]).at[of_jumps - 1].set(before, mode="drop")


def _behind(jumps: Float[Array, "k"], ends: Float[Array, "most"]) -> tuple[Int[Array, "k"], Bool[Array, "k"]]:
    """For each jump, the place of the end of a step just behind it, and whether there is one."""
    at = jnp.minimum(jnp.searchsorted(ends, jumps, side="right"), ends.size - 1)
    met = ends[at] - jumps <= JUST_BEHIND * jnp.abs(jumps) + np.finfo(float).tiny
    # Each place once.
    return at, met & jnp.append(True, jnp.diff(at) > 0)


def _by(function: Callable[..., Any], numbers: list[Any], changes: Any) -> list[Any]:
    return jax.vjp(function, numbers)[1](changes)[0]


def _rows(count: int, like: Any) -> Any:
    return jax.tree.map(lambda leaf: jnp.zeros((count, *leaf.shape), leaf.dtype), like)


def _put(rows: Any, place: Any, at: Any) -> Any:
    return jax.tree.map(lambda rows, leaf: rows.at[place].set(leaf), rows, at)


def _over_rows(times: Array, changes: MotionState, step_ends: Any, row: Any, by_times: Array | None):
    """Derivatives of the rows within a step, from the last, by states at its ends and by their times."""

    def state(step_ends: Any, t: Float[Array, ""]):
        n = step_ends[1][0].u.shape[0]
        return state_within_step(step_ends[0], step_ends[1], tuple(z[:n] for z in step_ends[2]), t)

    def within(at: tuple[Any, Any]):
        return (at[0] >= 0) & (times[jnp.maximum(at[0], 0)] > step_ends[0][0])

    def added(at: tuple[Any, Any]):
        row, (by_whole, by_times) = at
        by_ends, by_time = jax.vjp(state, step_ends, times[row])[1](jax.tree.map(lambda rows: rows[row], changes))
        by_times = None if by_times is None else by_times.at[row].add(by_time)
        return row - 1, (jax.tree.map(jnp.add, by_whole, by_ends), by_times)

    return jax.lax.while_loop(within, added, (row, (jax.tree.map(jnp.zeros_like, step_ends), by_times)))


def _moved_along(ends: Float[Array, "most"], known: Span, span: Span) -> Float[Array, "most"]:
    """Ends of steps, moved with the begin, the last stop before them, a jump there, or the end of a motion."""
    along = ends + (span.t0 - known.t0)
    if span.stops is not None and known.stops is not None:
        for stop, was in zip(span.stops, known.stops, strict=True):
            along = jnp.where((ends >= was) & (was > known.t0), ends + (stop - was), along)
    if span.jumps is not None and known.jumps is not None:
        # Later steps stay: derivatives by their lengths would sum up their errors.
        at, met = _behind(known.jumps, ends)
        along = along.at[jnp.where(met, at, ends.size)].set(ends[at] + (span.jumps - known.jumps), mode="drop")
    return jnp.where(ends == known.t1, span.t1, along)
