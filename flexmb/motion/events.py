"""Events that end a motion: their conditions, and the steps within which one comes about and passes unseen."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..compilation.program import Captured, captured
from ..compilation.record import Record, static
from ..display import short
from ..errors import warn
from .kinks import FINE_PARTS, LEAST, ROUND_OFF, along_step
from .protocol import MotionState

if TYPE_CHECKING:
    import diffrax


class EventCondition(Record):
    """Condition of an event, as it was when the simulation was called.

    Attributes:
        function: Of time and state.
    """

    function: Captured

    def __call__(self, t: Float[Array, ""], y: MotionState, args: Any, **more: Any):
        """What diffrax watches, of the time and the state alone."""
        return self.function(t, y)


class Passing(Record):
    """Finds steps within which an event comes about without being seen at their ends, or events more than once.

    Attributes:
        conditions: Those of time and state alone; others are looked at where steps end.
        directions: Of each, whether it counts where it rises, where it falls (False), or both (None).
        controls: Number of states of a controller, the last of the velocities.
    """

    conditions: tuple[EventCondition, ...]
    directions: tuple[bool | None, ...] = static()
    controls: int = static(default=0)

    def within(self, times: tuple[Any, Any], states: tuple[MotionState, MotionState], smallest: Any) -> Bool[Array, ""]:
        """Whether there is such an event within a step that can be shorter.

        Args:
            times: Its begin and end [s].
            states: There.
            smallest: Smallest step [s].
        """
        times, states = jax.lax.stop_gradient((times, states))
        at = along_step(times, states, self.controls, FINE_PARTS)
        passed, count = jnp.array(False), 0
        for condition, direction in zip(self.conditions, self.directions, strict=True):
            # One place after the other: a condition may call back to Python.
            values = jax.lax.map(functools.partial(_at_place, condition), at)
            own = jnp.sum(_comes(values[:-1], values[1:], direction))
            count += own
            passed |= (own > 0) & ~_comes(values[0], values[-1], direction)
        # Of several within one step diffrax takes the first that it was given.
        shorter = times[1] - times[0] > jnp.maximum(LEAST * smallest, ROUND_OFF * jnp.abs(times[1]))
        return (passed | (count > 1)) & shorter


def passing_of(event: diffrax.Event | None, controls: int) -> Passing | None:
    """What finds events that come about within a step, None where no condition is of time and state alone.

    Args:
        event: Of diffrax, or None.
        controls: Number of states of a controller.
    """
    if event is None:
        return None
    own = [(one, way) for one, way in _watched(event) if isinstance(one, EventCondition)]
    return Passing(tuple(one for one, _ in own), tuple(way for _, way in own), controls) if own else None


def as_it_is(event: diffrax.Event, t: Float[Array, ""], like: MotionState) -> diffrax.Event:
    """An event whose conditions will not change; those that ask for more than time and state stay.

    Args:
        event: Of diffrax.
        t: A time [s].
        like: State, or its shapes.
    """

    def now(condition: Callable[..., Any]):
        try:
            return EventCondition(captured(lambda t, y: condition(t, y, None), t, like))
        except (KeyError, TypeError):
            return condition

    return dataclasses.replace(event, cond_fn=jax.tree.map(now, event.cond_fn, is_leaf=callable))


def conditions_of(event: diffrax.Event) -> list[EventCondition]:
    """Conditions of an event that are of time and state alone."""
    return [one for one, _ in _watched(event) if isinstance(one, EventCondition)]


def check_at_start(event: diffrax.Event, values: Sequence[Any], soon: Sequence[Any], t: Any) -> None:
    """Refuse conditions that are no numbers at the start, and warn of what ends the motion there.

    Args:
        event: Of diffrax.
        values: Of its conditions at the start.
        soon: A little later.
        t: The start [s].

    Raises:
        ValueError: A condition is not a number there.
    """
    ways = [way for one, way in _watched(event) if isinstance(one, EventCondition)]
    for value, later, way in zip(map(np.asarray, values), map(np.asarray, soon), ways, strict=True):
        if np.any(np.isnan(value)):
            raise ValueError(f"The condition of `event` is no number at the start, t = {short(t)} s, but {value}.")
        if value.dtype == bool and np.any(value):
            warn("The condition of `event` holds at the start, so that the motion ends there, before any later time.")
        elif value.dtype != bool and way is not False and np.any((value == 0) & (later > 0 if way else later != 0)):
            warn(
                "The condition of `event` is zero at the start and leaves it at once, which ends the motion. Say by"
                " `direction` of diffrax.Event whether it is to end where the condition falls (False), or begin"
                " elsewhere."
            )


def _watched(event: diffrax.Event) -> list[tuple[Any, bool | None]]:
    """Conditions of an event, and which way each of them counts."""
    conditions = jax.tree.leaves(event.cond_fn, is_leaf=callable)
    ways: list[Any] = jax.tree.leaves(event.direction, is_leaf=lambda one: one is None)
    return list(zip(conditions, ways, strict=True))


def _at_place(condition: EventCondition, place: tuple[Float[Array, ""], MotionState]) -> Any:
    return condition(*place, None)


def _comes(before: Any, after: Any, way: bool | None) -> Bool[Array, "..."]:
    """Whether a condition comes about from one place to another."""
    if before.dtype == bool:
        return after & ~before
    if way is None:
        return jnp.sign(before) != jnp.sign(after)
    return (before <= 0) & (after > 0) if way else (before > 0) & (after <= 0)
