"""Where a path is to end: at a displacement, a load factor, a number of critical points, or any answer of a state."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..arguments import check_number, check_whole, shown
from ..display import short, unit_of
from ..errors import heard
from ..linear.stress import left_out_of_stress
from ..model.model import Model
from ..questions.question import Asked, is_many, names_of

LOAD, STRESS, COUNT = "load_factor", "stress", "critical_points"


class Condition(NamedTuple):
    """A quantity whose value ends the walk, from whichever side it comes there.

    Attributes:
        name: By which it is known; empty for the load factor at which a path ends by itself.
        target: The value.
        of: The quantity at a state.
        entry: Index of the coordinate that it is the displacement of; None where it is none.
        start: That coordinate in the undeformed mechanism.
        at_ends: Whether it is computed at the ends of steps alone, where nothing is known of it in between.
        unit: Its unit; empty where it has none.
    """

    name: str
    target: float
    of: Callable[[Any], float]
    entry: int | None = None
    start: float = 0.0
    at_ends: bool = False
    unit: str = ""

    def excess(self, at: Any) -> float:
        """By how much the quantity is above its target."""
        return self.of(at) - self.target


class Last(NamedTuple):
    """Where a walk ends on a step.

    Attributes:
        length: Place on the step.
        step: State there.
        name: Of the condition that is met there.
    """

    length: float
    step: Any
    name: str


class Stops(NamedTuple):
    """What `stop` asks for.

    Attributes:
        conditions: Values that end the path, the load factor at which it ends by itself among them, without a name.
        most: Number of critical points that ends it, or None.
        end: Load factor beyond which it never goes, () [-].
    """

    conditions: tuple[Condition, ...]
    most: int | None
    end: float


def stops_of(model: Model, stop: Mapping[str, Any] | None, state_at: Callable[[Any], Any]) -> Stops:
    """Conditions that end a path, from what the user gives.

    Raises:
        TypeError: It is no mapping, or a value is no number.
        ValueError: A value is out of its range; the stress is not below it where the path begins.
        KeyError: A name is neither a coordinate nor a question of a state.
    """
    if stop is None:
        stop = {}
    if not isinstance(stop, Mapping) or not all(isinstance(name, str) for name in stop):
        raise TypeError(f'Argument `stop` must be values by name, such as {{"tip.y": -5e-3}}, not {shown(stop)}.')
    conditions, most = [], None
    for name, value in stop.items():
        what = f'stop["{name}"]'
        if name == COUNT:
            most = check_whole(what, value, 1)
            continue
        check_number(what, value, above=0 if name == STRESS else None)
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
        own = [str(entry) for entry in model.labels.x if entry.of in (name, name.rpartition(".")[0])]
        there = f"there is {', '.join(own)}" if own else "write node and component, such as tip.y"
        questions = ", ".join((LOAD, COUNT, *names_of()))
        raise KeyError(f"no coordinate '{name}' to stop at in this model: {there}, or ask for {questions}")
    if question.name == STRESS:
        left_out_of_stress(model)

    def answer(step: Any) -> float:
        # That a stress is above the material's strength is not said at every step.
        with heard():
            state = state_at(step)
            return float(np.max(asked.along(state).values if is_many(state) else asked(state)))

    return Condition(name, target, answer, at_ends=True, unit=asked.unit)


def unmet(stop: Mapping[str, Any], steps: list[Any], conditions: tuple[Condition, ...], found: int) -> str:
    """How near a path that ended by itself came to each condition."""
    parts = []
    for condition in conditions:
        if condition.name:
            nearest = min((condition.of(step) for step in steps), key=lambda a: abs(a - condition.target))
            unit = f" {condition.unit}".rstrip(" -")
            parts.append(f"{condition.name} came to {short(nearest)}{unit}, not to {short(condition.target)}{unit}")
    if COUNT in stop:
        parts.append(f"{COUNT} are {found}, not {stop[COUNT]}")
    return (
        f"No condition of `stop` was met up to load factor {short(steps[-1].load)}: {'; '.join(parts)}. Larger loads"
        f" make the path longer, or a {LOAD} above 1 in `stop`."
    )
