"""What an analysis is told beside the document: fields of the page, what is missing, and the numbers in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import clean
from ..spacar.arithmetic import value_of
from .building import free_names, numbers_of, positions
from .document import Document
from .references import call_of

# Nodes whose coordinates are offered in a list.
MOST_NODES = 100

Field = dict[str, Any]


def _number(name: str, unit: str, default: str, doc: str, **more: Any) -> Field:
    """A field for a number; one that is not optional is seen at once, and has its default where nothing is written."""
    return {"name": name, "kind": "number", "unit": unit, "default": default, "doc": doc, "optional": True} | more


def _choice(name: str, choices: list[str], doc: str, default: str = "", optional: bool = True) -> Field:
    return {"name": name, "kind": "choice", "choices": choices, "default": default, "doc": doc, "optional": optional}


def _nodes(document: Document) -> list[str]:
    """Nodes with a position, those that building blocks make after those that are drawn."""
    return list(positions(document))


def _coordinates(document: Document) -> list[str]:
    """Coordinates of nodes that are not fixed altogether."""
    fixed = {
        thing["args"].get("node")
        for thing in document.things
        if thing["call"] == "fix" and not str(thing["args"].get("components", "")).strip()
    }
    names = [name for name in _nodes(document) if name not in fixed]
    axes = ("x", "y", "phi") if document.dimension == 2 else ("x", "y", "z")
    return [f"{name}.{axis}" for name in names[:MOST_NODES] for axis in axes]


FIELDS: dict[str, Callable[[Document], list[Field]]] = {
    "times": lambda _: [
        _number("end", "s", "1", "How long.", optional=False),
        _number("steps", "", "200", "Output times.", whole=True),
        _number("rtol", "-", "1e-5", "Relative tolerance of the integration."),
    ],
    "steps": lambda _: [_number("max_steps", "", "200", "Steps at most.", whole=True)],
    "frequencies": lambda _: [
        _number("low", "Hz", "", "Lowest frequency; by the poles unless given."),
        _number("high", "Hz", "", "Highest frequency; by the poles unless given."),
    ],
    "trajectory": lambda document: [
        _choice(
            "coordinate", _coordinates(document), "What is led; the one degree of freedom unless given.", optional=False
        ),
        _number("by", "m, rad", "0.001", "How far it goes from where it is.", optional=False),
        _number("duration", "s", "0.5", "In what time.", optional=False),
        _choice("law", ["quintic", "septic", "scurve"], "How it speeds up and slows down.", "quintic"),
    ],
    "stroke": lambda document: [
        _choice(
            "coordinate",
            _coordinates(document),
            "What is driven; an input or the one degree of freedom unless given.",
            optional=False,
        ),
        _number("to", "m, rad", "0.001", "How far, to both sides.", optional=False),
        _number("steps", "", "4", "Strokes to each side.", whole=True),
        _choice("node", _nodes(document), "Whose stiffness is told."),
    ],
    "names": lambda document: [
        _choice("name", free_names(document), "Which dimension varies.", optional=False),
        _number("low", "", "", "From; its lower bound, or a half of it, unless given."),
        _number("high", "", "", "To; its upper bound, or twice it, unless given."),
        _number("points", "", "41", "How many values.", whole=True),
    ],
}


def missing(need: str, document: Document) -> str | None:
    """What a document has too little of, and what to add."""
    calls = [call_of(thing) for thing in document.things]
    groups = {call.entry["group"] for call in calls if call}
    names = {call.name for call in calls if call}
    if need == "loads" and "load" not in groups and "prescribe" not in names:
        return "There is no load: add a force, a moment or gravity."
    if need == "cause" and "load" not in groups and not names & {"prescribe", "start"}:
        return "Nothing sets it in motion: add a force, gravity or a start value, or prescribe a coordinate."
    if need == "signals":
        for words, what in (
            (("input", "actuator"), "no input: add one at what drives it"),
            (("output", "sensor"), "no output: add one at what is measured"),
        ):
            if not names & set(words):
                return f"There is {what}."
    if need == "names" and not free_names(document):
        return "There is no name to vary: write a name, such as t, where a number stands."
    return None


def checked(own: Mapping[str, Any], options: Mapping[str, Any], document: Document) -> dict[str, Any]:
    """Options as numbers and words, with their defaults."""
    fields = {field["name"]: field for field in own["fields"]}
    for name in options:
        if name not in fields:
            listed = ", ".join(fields) or "none"
            raise ValueError(f"There is no option '{clean(name)}' of '{own['title']}'. There are: {listed}.")
    numbers, found = numbers_of(document), {}
    names = {n: numbers[f"names/{n}/value"] for n in document.names if f"names/{n}/value" in numbers}
    for name, field in fields.items():
        text = str(options.get(name) or field["default"]).strip()
        if not text:
            found[name] = None
        elif field["kind"] == "number":
            try:
                value = float(value_of(text, names))
            except ValueError as fault:
                raise ValueError(f"Option '{name}': '{clean(text)}' {fault}.") from None
            least = 1 if field.get("whole") else -np.inf
            if value < least or (field.get("whole") and value != int(value)):
                raise ValueError(f"Option '{name}' must be a whole number, 1 or more, not '{clean(text)}'.")
            if name in ("end", "duration", "rtol", "to") and not value > 0:
                raise ValueError(f"Option '{name}' must be positive, not '{clean(text)}'.")
            found[name] = int(value) if field.get("whole") else value
        elif text in field["choices"]:
            found[name] = text
        else:
            raise ValueError(f"Option '{name}' must be one of {', '.join(field['choices'])}, not '{clean(text)}'.")
    return found
