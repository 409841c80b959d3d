"""What a loop over steps leaves behind, so that one can go back over it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .protocol import MotionState

# So many steps from the start are kept, and of those behind them as many again at equal distances, from which the
# others are taken anew: a motion of some hundred coordinates then takes some ten megabytes however long it is. Of many
# coordinates fewer are kept, some of these numbers, but no fewer than the last: what is between two of them takes room
# too.
KEPT, NUMBERS, FEWEST = 2048, 2**24, 300


class Span(NamedTuple):
    """Times of a motion.

    Attributes:
        t0: Begin [s].
        t1: End [s].
        times: At which it is given, (n_t,) [s].
        stops: To be stepped onto, (k,) [s], or None.
    """

    t0: Float[Array, ""]
    t1: Float[Array, ""]
    times: Float[Array, "n_t"]
    stops: Float[Array, "k"] | None


class Tape(NamedTuple):
    """Steps of a motion, where they began and ended.

    Attributes:
        ends: Their ends, (most + 1,) [s].
        states: States at their begins, of those that are kept; behind these a place for what is not, and room for
            those from one that is kept to the next.
        carried: What was carried over from the step before: accelerations and multipliers, or more.
        steps: Number of steps.
        last: What is carried over from the last step.
        saved: Number of rows that were saved.
        still: Which rows are the start itself, (n_t,).
    """

    ends: Float[Array, "most"]
    states: MotionState
    carried: Any
    steps: Int[Array, ""]
    last: Any = None
    saved: Int[Array, ""] | None = None
    still: Bool[Array, "n_t"] | None = None

    @property
    def apart(self) -> int:
        """Distance of those that are kept behind the first ones, in steps."""
        return _apart(self.ends.shape[0], self._kept)

    @property
    def _kept(self) -> int:
        """Number of steps from the start that are kept."""
        return _kept([rows.shape[1:] for rows in jax.tree.leaves((self.states, self.carried))])

    @property
    def room(self) -> int:
        """Where the room for those from one that is kept to the next begins."""
        return self.states.u.shape[0] - self.apart

    def last_kept(self, step: Int[Array, ""]) -> Int[Array, ""]:
        """The step itself if it is kept, or the last one before it that is."""
        behind = step - self._kept
        return step - jnp.where(behind < 0, 0, behind % self.apart)

    def place(self, step: Int[Array, ""]) -> Int[Array, ""]:
        """Where a step is to be found, once the room holds those from the last one that is kept."""
        behind = step - self._kept
        far, within = self._kept + behind // self.apart, behind % self.apart
        return jnp.where(behind < 0, step, jnp.where(within == 0, far, self.room + within))

    def with_step(self, end: Float[Array, ""], state: MotionState, carried: Any, taken: Bool[Array, ""]) -> Tape:
        """The tape with one more step, if it was taken.

        Args:
            end: Its end [s].
            state: State at its begin.
            carried: What was carried over to it.
            taken: Whether it was.
        """
        place, last = self.place(self.steps), self.ends.shape[0] - 1
        # What was not taken is overwritten by what is.
        place = jnp.where(place < self.room, place, self.room - 1)
        ends = self.ends.at[jnp.where(taken, self.steps, last)].set(end)
        return self.put(place, state, carried)._replace(ends=ends, steps=self.steps + taken.astype(jnp.int32))

    def put(self, place: Int[Array, ""], state: MotionState, carried: Any) -> Tape:
        """The tape with a state, and what belongs to it, at a place."""
        whole, one = (self.states, self.carried), (state, carried)
        states, all_carried = jax.tree.map(lambda rows, one: rows.at[place].set(one), whole, one)
        return self._replace(states=states, carried=all_carried)

    def at(self, place: Int[Array, ""]) -> tuple[MotionState, Any]:
        """State at a place, and what was carried over to it."""
        return jax.tree.map(lambda rows: rows[place], (self.states, self.carried))


def _kept(shapes: list[tuple[int, ...]]) -> int:
    numbers = sum(map(math.prod, shapes))
    return min(KEPT, max(FEWEST, NUMBERS // max(numbers, 1)))


def _apart(most: int, kept: int) -> int:
    return max(1, -(-(most - kept) // kept))


def blank_tape(most: int, state: MotionState, carried: Any) -> Tape:
    """A tape without steps.

    Args:
        most: Most steps.
        state: Like those that it is to hold.
        carried: Likewise.
    """
    # The first may be one of no length, that finds the accelerations; the last takes what is not wanted.
    ends, first = most + 2, _kept([one.shape for one in jax.tree.leaves((state, carried))])
    apart = _apart(ends, first)
    kept = min(ends, first) + (0 if ends <= first else -(-(ends - first) // apart)) + 1
    states, all_carried = jax.tree.map(lambda one: jnp.zeros((kept + apart, *one.shape)), (state, carried))
    return Tape(jnp.zeros(ends), states, all_carried, jnp.zeros((), jnp.int32))


def whole_loop(condition: Callable[[Any], Any], body: Callable[[Any], Any], start: Any) -> Any:
    """As ``jax.lax.while_loop``, but that of a batch no tape is copied in every turn.

    Of a batch JAX takes all to the turn of the last, and chooses after each turn between before and after, whole tapes
    too. Here all turns are taken, and what is done already is chosen here, tapes left out: these are to know themselves
    whether a turn counts.

    Args:
        condition: Whether to go on.
        body: A turn.
        start: A named tuple with ``tape``.
    """
    from equinox.internal import unvmap_any

    def turn(before: Any):
        going, after = condition(before), body(before)
        chosen = jax.tree.map(
            lambda a, b: jnp.where(going, a, b), after._replace(tape=None), before._replace(tape=None)
        )
        return chosen._replace(tape=after.tape)

    return jax.lax.while_loop(lambda at: unvmap_any(condition(at)), turn, start)
