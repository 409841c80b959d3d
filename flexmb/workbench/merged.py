"""Nodes and elements of a SPACAR input file as one thinks of them: named, and rotations belong to positions."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..build.builder import Builder
from ..build.description import NamedSignal


def merged(builder: Builder) -> Builder:
    """A builder whose rotations are those of the positions that they stand beside in all their elements.

    A file numbers positions and rotations by themselves. What stands beside one position alone becomes its rotation,
    "1.rotation", and its warping likewise; a second rotation at a position, as behind a hinge, stays by itself.

    Args:
        builder: Not changed.
    """
    beside: dict[str, set[str]] = {}
    for member in builder.members.values():
        position = None
        for node in member.nodes:
            part = builder.nodes[node].kind.part
            if part == "position":
                position = node
            elif part in ("rotation", "warping") and position is not None:
                beside.setdefault(node, set()).add(position)
    new: dict[str, str] = {}
    for node, positions in beside.items():
        own = builder.nodes[node]
        usual = tuple(np.asarray(own.start, float)) == tuple(own.kind.start)
        name = f"{next(iter(positions))}.{own.kind.part}"
        # An element that warps looks for the warping of its node by that of the rotation.
        if len(positions) == 1 and usual and name not in builder.nodes and name not in new.values():
            new[node] = name
    return _renamed(builder, lambda node: new.get(node, node), lambda element: element)


def apart(builder: Builder) -> Builder:
    """A builder in which the rotation of node 1 is node 2 again where no other is: the opposite of :func:`merged`.

    Args:
        builder: Not changed.
    """
    new: dict[str, str] = {}
    for name in builder.nodes:
        owner, _, part = name.rpartition(".")
        if part == "rotation" and owner in builder.nodes and owner.isascii() and owner.isdecimal():
            number = str(int(owner) + 1)
            if number not in builder.nodes and number not in new.values():
                new |= {name: number, f"{owner}.warping": f"{number}.warping"}
    return _renamed(builder, lambda node: new.get(node, node), lambda element: element)


def called(builder: Builder, legend: dict[str, dict[str, str]]) -> Builder:
    """A builder of a file whose numbers have the names that its comments tell.

    Args:
        builder: Not changed.
        legend: Names of each "node", "element", "input" and "output", by number.
    """
    nodes = _fitting(legend.get("node", {}), list(builder.nodes))
    elements = _fitting(legend.get("element", {}), list(builder.members))

    def of_node(node: str) -> str:
        if node in nodes:
            return nodes[node]
        owner, _, part = node.rpartition(".")
        if part == "warping" and owner in nodes:
            return f"{nodes[owner].removesuffix('.rotation')}.{part}"
        return f"{elements[owner]}.{part}" if part == "internal" and owner in elements else node

    twin = _renamed(builder, of_node, lambda element: elements.get(element, element))
    for side in ("input", "output"):
        given = legend.get(side, {})
        names = [given.get(str(i), signal.name) for i, signal in enumerate(twin.signals[side], 1)]
        if len(set(names)) == len(names):
            twin.signals[side] = [s._replace(name=name) for s, name in zip(twin.signals[side], names, strict=True)]
    return twin


def _fitting(names: dict[str, str], there: list[str]) -> dict[str, str]:
    """Names of what is there, if no two are called alike."""
    own = {number: name for number, name in names.items() if number in there and name.isprintable()}
    after = [own.get(name, name) for name in there]
    return own if len(set(after)) == len(after) else {}


def _renamed(builder: Builder, of_node: Callable[[str], str], of_element: Callable[[str], str]) -> Builder:
    def key(entry: Any) -> Any:
        if not isinstance(entry, tuple):
            return entry
        kind, of, number = entry
        return kind, of_node(of) if kind == "node" else of_element(of), number

    def signal(own: NamedSignal) -> NamedSignal:
        return own._replace(key=key(own.key), parts=tuple(map(signal, own.parts)))

    twin = builder.copy()
    twin.nodes = {of_node(name): node for name, node in twin.nodes.items()}
    twin.members = {of_element(name): member for name, member in twin.members.items()}
    for member in twin.members.values():
        member.nodes = tuple(map(of_node, member.nodes))
    twin._clamped = set(map(of_node, twin._clamped))
    twin.dofs = list(map(key, twin.dofs))
    twin.starts = {key(entry): value for entry, value in twin.starts.items()}
    twin.loads = {
        which: {kind: {key(entry): value for entry, value in own.items()} for kind, own in sets.items()}
        for which, sets in twin.loads.items()
    }
    twin.signals = {side: list(map(signal, own)) for side, own in twin.signals.items()}
    return twin
