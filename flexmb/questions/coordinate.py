"""A coordinate of a node, "top.x" or "top.phi", and its change from the undeformed mechanism, "displacement top.x"."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ..display import unit_of
from ..math.derivative import root_or_zero
from ..model.by_name import TURNS
from ..model.model import Labels
from .question import ANGLES, Question, as_host_values, at_rest, model_of, node_and_component


def _coordinate(state: Any, text: str) -> Any:
    labels = state.labels
    names = [str(entry) for entry in labels.x]
    if text in names:
        return as_host_values(state, at_rest(state).x)[..., names.index(text)]
    node, _, component = text.rpartition(".")
    if labels.coordinates(node) and component.isdecimal():
        # Input files name components by numbers.
        places = labels.coordinates(node)
        if not 1 <= int(component) <= len(places):
            raise KeyError(f"component = {component}, but node '{node}' has coordinates 1 to {len(places)}")
        return as_host_values(state, at_rest(state).x)[..., places[int(component) - 1]]
    if component in ANGLES and labels.coordinates(node):
        return at_rest(state).rotation(node, component)
    candidates = [str(entry) for entry in labels.x if entry.of in (node, text)]
    if candidates:
        raise KeyError(f"no coordinate '{text}' in this model; there is {', '.join(candidates)}")
    nodes = ", ".join(dict.fromkeys(entry.of for entry in labels.x if entry.kind != "internal"))
    raise KeyError(f"there is no node '{node}'; there are {nodes}")


def _unit(text: str, labels: Labels | None) -> str:
    entries = [entry for entry in labels.x if str(entry) == text] if labels is not None else []
    return unit_of(entries[0]) if entries else "rad" if text.rpartition(".")[2] in ANGLES else "m"


def _displacement(state: Any, text: str) -> Any:
    if not text:
        return _largest_displacement(state)
    node, component = node_and_component(text)
    names = [str(entry) for entry in state.labels.x]
    if component in TURNS:
        return at_rest(state).rotation(node, component)
    entry = f"{node}.rotation.phi" if component == "phi" and f"{node}.rotation.phi" in names else text
    if entry not in names:
        # The error names the nodes and components.
        at_rest(state).position(node, component)
        raise KeyError(f"no coordinate '{text}' in this model")
    at = names.index(entry)
    return (
        as_host_values(state, at_rest(state).x)[..., at]
        - as_host_values(state, model_of(state).parameters.reference)[at]
    )


def _largest_displacement(state: Any) -> Any:
    nodes: dict[str, list[int]] = {}
    for i, entry in enumerate(state.labels.x):
        if entry.kind == "position":
            nodes.setdefault(entry.of, []).append(i)
    moved = (at_rest(state).x - model_of(state).parameters.reference)[..., np.array(list(nodes.values()))]
    return root_or_zero(jnp.max(jnp.sum(moved**2, axis=-1), axis=-1))


QUESTIONS = (
    Question("", ("node", "component"), _coordinate, _unit, kind="coordinate", of_many=True),
    Question(
        "displacement",
        ("node?", "axis"),
        _displacement,
        lambda text, labels: _unit(text, labels) if text else "m",
        "largest displacement",
        kind="coordinate",
        of_many=True,
        of_loads=True,
    ),
)
