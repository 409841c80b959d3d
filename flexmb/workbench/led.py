"""A coordinate that is led along a trajectory, driven by the inputs of a document and watched by its outputs."""

from __future__ import annotations

from typing import Any

from ..build.builder import Builder
from ..errors import ModelError, clean
from ..model.by_name import TURNS
from ..spacar.reading import Channel, Leg
from ..spacar.trajectories import NOMINAL, REFERENCES
from .asked import Request


def trajectory(asked: Request) -> dict[str, Any]:
    """What a file would say of a coordinate that is led, driven by the inputs and watched by the outputs there are."""
    builder, options = asked.builder, asked.options
    name = options["coordinate"] or _one_coordinate(builder)
    node, _, axis = name.rpartition(".")
    of, component = (f"{node}.rotation", 1) if axis == "phi" else (node, "xyz".index(axis) + 1)
    if of not in builder.nodes:
        raise ModelError(f"'{clean(name)}' does not turn: no element asks for the rotation of '{clean(node)}'.")
    key = ("node", of, component)
    if not builder.dofs and builder.nodes[of].roles[component - 1].name == "DEPENDENT":
        builder.dof(node, axis)
    own: Any = builder.nodes[of]
    start = float(own.start[component - 1])
    # Files have numbers for names.
    at: Any = of
    leg = Leg(at, key[2], 0.0, options["duration"], start + options["by"], options["law"], 1)
    settings: dict[str, Any] = {"TRAJX": [leg]}
    for i, signal in enumerate(builder.signals["input"], 1):
        keyword = NOMINAL[0] if signal.key[0] == "node" else NOMINAL[1]
        settings.setdefault(keyword, []).append(_channel(i, signal))
    words = {quantity: keyword for keyword, quantity in REFERENCES.items()}
    for i, signal in enumerate(builder.signals["output"], 1):
        if signal.quantity in words:
            settings.setdefault(words[signal.quantity], []).append(_channel(i, signal))
    if not builder.signals["input"] and builder.nodes[of].roles[component - 1].name == "DOF":
        raise ModelError(f"Nothing drives '{clean(name)}' along its trajectory: add an input there, or prescribe it.")
    return settings


def _channel(number: int, signal: Any) -> Channel:
    component = signal.key[2] if signal.axis is None else TURNS[signal.axis]
    return Channel(number, signal.key[1], component, 1)


def _one_coordinate(builder: Builder) -> str:
    if len(builder.dofs) == 1 and builder.dofs[0][0] == "node":
        _, of, component = builder.dofs[0]
        return f"{of.removesuffix('.rotation')}.{'phi' if of.endswith('.rotation') else 'xyz'[component - 1]}"
    raise ModelError("Say which coordinate is led: choose it above, or name one degree of freedom.")
