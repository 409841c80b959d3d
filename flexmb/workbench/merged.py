"""Nodes of a SPACAR input file as one thinks of them: a position with its rotation, instead of two numbers."""

from typing import Any

import numpy as np

from ..build.description import Description, NamedSignal


def merged(builder: Description) -> Description:
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
    renamed: dict[str, str] = {}
    for node, positions in beside.items():
        own = builder.nodes[node]
        usual = tuple(np.asarray(own.start, float)) == tuple(own.kind.start) if own.kind.part == "rotation" else True
        name = f"{next(iter(positions))}.{own.kind.part}"
        if len(positions) == 1 and usual and name not in builder.nodes and name not in renamed.values():
            renamed[node] = name
    return _renamed(builder, renamed)


def _renamed(builder: Description, renamed: dict[str, str]) -> Description:
    def of(node: str) -> str:
        return renamed.get(node, node)

    def key(entry: Any) -> Any:
        return ("node", of(entry[1]), entry[2]) if isinstance(entry, tuple) and entry[0] == "node" else entry

    def signal(own: NamedSignal) -> NamedSignal:
        return own._replace(key=key(own.key), parts=tuple(map(signal, own.parts)))

    twin = builder.copy()
    twin.nodes = {of(name): node for name, node in twin.nodes.items()}
    for member in twin.members.values():
        member.nodes = tuple(map(of, member.nodes))
    twin._clamped = set(map(of, twin._clamped))
    twin.dofs = list(map(key, twin.dofs))
    twin.starts = {key(entry): value for entry, value in twin.starts.items()}
    twin.loads = {
        which: {kind: {key(entry): value for entry, value in own.items()} for kind, own in sets.items()}
        for which, sets in twin.loads.items()
    }
    twin.signals = {side: list(map(signal, own)) for side, own in twin.signals.items()}
    return twin
