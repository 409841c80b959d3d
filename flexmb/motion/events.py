"""Events that end a motion: their conditions, and the search for events that begin and end within a step."""

from __future__ import annotations

import dataclasses
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
from ..numerical_limits import SHORTEST_STEP, TIME_ROUND_OFF
from .kinks import FINE_PARTS, along_step
from .protocol import MotionState

if TYPE_CHECKING:
    import diffrax


class EventCondition(Record):
    """Condition of an event, a function of time and state, as it was when the simulation was called."""

    function: Captured

    def __call__(self, t: Float[Array, ""], y: MotionState, args: Any, **more: Any):
        """Value of the condition, with the signature of diffrax."""
        return self.function(t, y)


class Passing(Record):
    """Finds steps with an event that is not seen at their ends, or with several events.

    Attributes:
        conditions: Conditions of time and state alone; others are evaluated where steps end.
        directions: Whether each counts when it rises (True), falls (False), or both (None).
        controls: Number of states of a controller, which are the last entries of the velocities.
    """

    conditions: tuple[EventCondition, ...]
    directions: tuple[bool | None, ...] = static()
    controls: int = static(default=0)

    def within(self, times: tuple[Any, Any], states: tuple[MotionState, MotionState], smallest: Any) -> Bool[Array, ""]:
        """Whether a step that can be shorter has such an event; `smallest` is the smallest step [s]."""
        times, states = jax.lax.stop_gradient((times, states))
        at = along_step(times, states, self.controls, FINE_PARTS)
        passed, count = jnp.array(False), 0
        for condition, direction in zip(self.conditions, self.directions, strict=True):
            # Sequential: a condition may call back to Python.
            values = jax.lax.map(lambda place, condition=condition: condition(place[0], place[1], None), at)
            times_met = jnp.sum(_comes(values[:-1], values[1:], direction))
            count += times_met
            passed |= (times_met > 0) & ~_comes(values[0], values[-1], direction)
        # Of several events in one step diffrax would take the first in its list, not in time.
        shorter = times[1] - times[0] > jnp.maximum(SHORTEST_STEP * smallest, TIME_ROUND_OFF * jnp.abs(times[1]))
        return (passed | (count > 1)) & shorter


def passing_of(event: diffrax.Event | None, controls: int) -> Passing | None:
    """Search for events within steps; None without a condition of time and state alone."""
    if event is None:
        return None
    watched = [pair for pair in _watched(event) if isinstance(pair[0], EventCondition)]
    conditions, ways = (tuple(part) for part in zip(*watched, strict=True)) if watched else ((), ())
    return Passing(conditions, ways, controls) if watched else None


def as_it_is(event: diffrax.Event, t: Float[Array, ""], like: MotionState) -> diffrax.Event:
    """Event whose conditions are captured now; conditions of more than time and state stay."""

    def captured_condition(condition: Callable[..., Any]):
        try:
            return EventCondition(captured(lambda t, y: condition(t, y, None), t, like))
        except (KeyError, TypeError):
            return condition

    return dataclasses.replace(event, cond_fn=jax.tree.map(captured_condition, event.cond_fn, is_leaf=callable))


def conditions_of(event: diffrax.Event) -> list[EventCondition]:
    """Conditions of an event that depend on time and state alone."""
    return [condition for condition, _ in _watched(event) if isinstance(condition, EventCondition)]


def check_at_start(event: diffrax.Event, values: Sequence[Any], soon: Sequence[Any], t: Any) -> None:
    """Raise ValueError for conditions that are NaN at the start, and warn of conditions that end it there."""
    ways = [way for condition, way in _watched(event) if isinstance(condition, EventCondition)]
    for value, later, way in zip(map(np.asarray, values), map(np.asarray, soon), ways, strict=True):
        if np.any(np.isnan(value)):
            raise ValueError(f"The condition of `event` is no number at the start, t = {short(t)} s, but {value}.")
        if value.dtype == bool and np.any(value):
            warn("The condition of `event` holds at the start. The motion ends there, before any later time.")
        elif value.dtype != bool and way is not False and np.any((value == 0) & (later > 0 if way else later != 0)):
            warn(
                "The condition of `event` is zero at the start and leaves zero at once. This ends the motion. Give"
                " `direction` to diffrax.Event (False ends the motion where the condition falls), or begin elsewhere."
            )


def _watched(event: diffrax.Event) -> list[tuple[Any, bool | None]]:
    """Conditions of an event, and the direction in which each counts."""
    conditions = jax.tree.leaves(event.cond_fn, is_leaf=callable)
    ways: list[Any] = jax.tree.leaves(event.direction, is_leaf=lambda way: way is None)
    return list(zip(conditions, ways, strict=True))


def _comes(before: Any, after: Any, way: bool | None) -> Bool[Array, "..."]:
    """Whether a condition is met between two places."""
    if before.dtype == bool:
        return after & ~before
    if way is None:
        return jnp.sign(before) != jnp.sign(after)
    return (before <= 0) & (after > 0) if way else (before > 0) & (after <= 0)
