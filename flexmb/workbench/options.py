"""Options of analyses: fields of the page, missing parts of a document, and checks of the numbers and words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import printable
from ..spacar.arithmetic import arithmetic_result
from .building import free_names, numeric_values, positions
from .document import Document
from .references import call_of

# Number of nodes whose coordinates a list offers.
MOST_NODES = 100

Field = dict[str, Any]


def _number(name: str, unit: str, default: str, doc: str, **more: Any) -> Field:
    """A field for a number, hidden at first and empty for its default unless another is given."""
    return {"name": name, "kind": "number", "unit": unit, "default": default, "doc": doc, "optional": True} | more


def _choice(name: str, choices: list[str], doc: str, default: str = "", *, must: bool = False) -> Field:
    return {"name": name, "kind": "choice", "choices": choices, "default": default, "doc": doc, "optional": not must}


def _coordinate(document: Document, doc: str) -> Field:
    """A choice from the coordinates of nodes that are not fixed as a whole."""
    supports = [item["args"] for item in document.things if item["call"] == "fix"]
    fixed = {args.get("node") for args in supports if not str(args.get("components", "")).strip()}
    names = [name for name in positions(document) if name not in fixed]
    axes = ("x", "y", "phi") if document.dimension == 2 else ("x", "y", "z")
    coordinates = [f"{name}.{axis}" for name in names[:MOST_NODES] for axis in axes]
    return _choice("coordinate", coordinates, doc, must=True)


FIELDS: dict[str, Callable[[Document], list[Field]]] = {
    "times": lambda _: [
        _number("end", "s", "1", "Duration.", optional=False),
        _number("steps", "", "200", "Output times.", whole=True),
        _number("rtol", "-", "1e-5", "Relative tolerance of the integration."),
    ],
    "steps": lambda _: [_number("max_steps", "", "200", "Largest number of steps.", whole=True)],
    "frequencies": lambda _: [
        _number("low", "Hz", "", "Lowest frequency; follows from the poles by default."),
        _number("high", "Hz", "", "Highest frequency; follows from the poles by default."),
    ],
    "trajectory": lambda document: [
        _coordinate(document, "Prescribed coordinate; by default the only degree of freedom."),
        _number("by", "m, rad", "0.001", "Displacement from the present position.", optional=False),
        _number("duration", "s", "0.5", "Duration of the displacement.", optional=False),
        _choice("law", ["quintic", "septic", "scurve"], "Motion law.", "quintic"),
    ],
    "stroke": lambda document: [
        _coordinate(document, "Driven coordinate; by default the only input or degree of freedom."),
        _number("to", "m, rad", "0.001", "Stroke to each side.", optional=False),
        _number("steps", "", "4", "Number of strokes to each side.", whole=True),
        _choice("node", list(positions(document)), "Node for the support stiffness."),
    ],
    "names": lambda document: [
        _choice("name", free_names(document), "Dimension that varies.", must=True),
        _number("low", "", "", "First value; by default the lower bound, or half of the value."),
        _number("high", "", "", "Last value; by default the upper bound, or twice the value."),
        _number("points", "", "41", "Number of values.", whole=True),
    ],
}


def missing(need: str, document: Document) -> str | None:
    """What a document lacks for an analysis, and what to add; None if nothing."""
    calls = [call_of(item) for item in document.things]
    groups = {call.entry["group"] for call in calls if call}
    names = {call.name for call in calls if call}
    if need == "loads" and "load" not in groups and "prescribe" not in names:
        return "There is no load: add a force, a moment or gravity."
    if need == "cause" and "load" not in groups and not names & {"prescribe", "start"}:
        return "Nothing moves it: add a force, gravity or a start value, or prescribe a coordinate."
    if need == "signals":
        if not names & {"input", "actuator"}:
            return "There is no input: add one at the driven place."
        if not names & {"output", "sensor"}:
            return "There is no output: add one at the measured place."
    if need == "names" and not free_names(document):
        return "There is no name to vary: write a name, such as t, instead of a number."
    return None


def checked_options(analysis: Mapping[str, Any], options: Mapping[str, Any], document: Document) -> dict[str, Any]:
    """Options as numbers and words, with their defaults."""
    fields = {field["name"]: field for field in analysis["fields"]}
    for name in options:
        if name not in fields:
            listed = ", ".join(fields) or "none"
            raise ValueError(f"'{analysis['title']}' has no option '{printable(name)}'. There are: {listed}.")
    numbers, values = numeric_values(document), {}
    names = {n: numbers[f"names/{n}/value"] for n in document.names if f"names/{n}/value" in numbers}
    for name, field in fields.items():
        text = str(options.get(name) or field["default"]).strip()
        if not text:
            values[name] = None
        elif field["kind"] == "number":
            try:
                value = float(arithmetic_result(text, names))
            except ValueError as fault:
                raise ValueError(f"Option '{name}': '{printable(text)}' {fault}.") from None
            least = 1 if field.get("whole") else -np.inf
            if value < least or (field.get("whole") and value != int(value)):
                raise ValueError(f"Option '{name}' must be a whole number, 1 or more, not '{printable(text)}'.")
            if name in ("end", "duration", "rtol", "to") and not value > 0:
                raise ValueError(f"Option '{name}' must be positive, not '{printable(text)}'.")
            values[name] = int(value) if field.get("whole") else value
        elif text in field["choices"]:
            values[name] = text
        else:
            raise ValueError(f"Option '{name}' must be one of {', '.join(field['choices'])}, not '{printable(text)}'.")
    return values
