"""Conditions that end a path: a displacement, a load factor, a number of critical points, or any answer of a state."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..arguments import check_number, check_whole, short_repr
from ..display import short, unit_of
from ..errors import heard
from ..linear.stress import left_out_of_stress
from ..model.model import Model
from ..questions.question import Asked, is_many, question_names

LOAD, STRESS, COUNT = "load_factor", "stress", "critical_points"


class Condition(NamedTuple):
    """A quantity whose value ends the walk, from either side.

    Attributes:
        name: Name; empty for the load factor at which a path ends by itself.
        target: The value.
        of: The quantity at a state.
        entry: Index of the coordinate whose displacement it is, or None.
        start: That coordinate in the undeformed mechanism.
        at_ends: Whether it is computed only at the ends of steps.
        unit: Its unit, or empty.
    """

    name: str
    target: float
    of: Callable[[Any], float]
    entry: int | None = None
    start: float = 0.0
    at_ends: bool = False
    unit: str = ""

    def excess(self, at: Any) -> float:
        """Quantity minus target."""
        return self.of(at) - self.target


class Last(NamedTuple):
    """Where a walk ends on a step: its place, the state, and the name of the condition."""

    length: float
    step: Any
    name: str


class Stops(NamedTuple):
    """Conditions of `stop`.

    Attributes:
        conditions: Values that end the path, including the load factor at which it ends by itself, without a name.
        most: Number of critical points that ends it, or None.
        end: Load factor that it never exceeds.
    """

    conditions: tuple[Condition, ...]
    most: int | None
    end: float


def stops_of(model: Model, stop: Mapping[str, Any] | None, state_at: Callable[[Any], Any]) -> Stops:
    """Conditions that end a path, from the user's `stop`; raise TypeError, ValueError or KeyError for a wrong one."""
    if stop is None:
        stop = {}
    if not isinstance(stop, Mapping) or not all(isinstance(name, str) for name in stop):
        raise TypeError(f'Argument `stop` must be values by name, such as {{"tip.y": -5e-3}}, not {short_repr(stop)}.')
    conditions, most = [], None
    for name, value in stop.items():
        subject = f'stop["{name}"]'
        if name == COUNT:
            most = check_whole(subject, value, 1)
            continue
        check_number(subject, value, above=0 if name == STRESS else None)
        target = float(value)
        if name == LOAD:
            conditions.append(Condition(name, target, lambda s: s.load))
        else:
            conditions.append(_displacement(model, name, target) or _question(model, name, target, state_at))
    end = max([1.0, *(c.target for c in conditions if c.name == LOAD)])
    if not any(c.name == LOAD and c.target == end for c in conditions):
        conditions.append(Condition("", end, lambda s: s.load))
    return Stops(tuple(conditions), most, end)


def _displacement(model: Model, name: str, target: float) -> Condition | None:
    kind, index = model.labels.place(name) or ("", 0)
    if kind != "x":
        return None
    start, unit = float(np.asarray(model.parameters.reference)[index]), unit_of(model.labels.x[index])
    return Condition(name, target, lambda s: float(s.point.x[index]) - start, index, start, unit=unit)


def _question(model: Model, name: str, target: float, state_at: Callable[[Any], Any]) -> Condition:
    asked = Asked(name)
    try:
        question = asked.question
    except KeyError:
        question = None
    if question is None or not question.name or question.only:
        of_node = [str(entry) for entry in model.labels.x if entry.of in (name, name.rpartition(".")[0])]
        hint = f"there is {', '.join(of_node)}" if of_node else "write node and component, such as tip.y"
        questions = ", ".join((LOAD, COUNT, *question_names()))
        raise KeyError(f"no coordinate '{name}' to stop at in this model: {hint}, or use {questions}")
    if question.name == STRESS:
        left_out_of_stress(model)

    def answer(step: Any) -> float:
        # No warning at every step of a stress above the strength.
        with heard():
            state = state_at(step)
            return float(np.max(asked.along(state).values if is_many(state) else asked(state)))

    return Condition(name, target, answer, at_ends=True, unit=asked.unit)


def unmet(stop: Mapping[str, Any], steps: list[Any], conditions: tuple[Condition, ...], found: int) -> str:
    """Message on how near a path came to each condition."""
    parts = []
    for condition in conditions:
        if condition.name:
            values = [condition.of(step) for step in steps]
            nearest = min(values, key=lambda a: abs(a - condition.target))
            unit = f" {condition.unit}".rstrip(" -")
            part = f"{condition.name} reached {short(nearest)}{unit}, not {short(condition.target)}{unit}"
            last = short(values[-1])
            parts.append(part if last == short(nearest) else f"{part}, and ended at {last}{unit}")
    if COUNT in stop:
        parts.append(f"{COUNT} are {found}, not {stop[COUNT]}")
    return (
        f"No condition of `stop` was met up to load factor {short(steps[-1].load)}: {'; '.join(parts)}. Larger loads"
        f" make the path longer, or a {LOAD} above 1 in `stop`."
    )
