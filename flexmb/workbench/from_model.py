"""A model taken apart into the contents of a Builder, with the degrees of freedom and releases that were found."""

from __future__ import annotations

import itertools
from typing import Any

import jax
import numpy as np

from ..arguments import is_concrete
from ..build.assemble import UNIT_NORM
from ..build.builder import Builder
from ..build.description import Key, Member, NamedSignal, Node
from ..elements.nodes import ANGLE, POINT2, POINT3, ROTATION3, SERIES2, SERIES3, WARPING, NodeKind
from ..elements.sections import Rigidity
from ..errors import ModelError
from ..model.model import Model, Signal
from ..model.parameters import Loads
from ..model.topology import Block


def builder_of(model: Model) -> Builder:
    """Contents of a Builder that builds a model, with its numbers as they are.

    Args:
        model: Concrete.

    Raises:
        ModelError: It is traced, or batched.
    """
    if not is_concrete(model) or np.ndim(model.parameters.reference) != 1:
        raise ModelError("One model with numbers of its own is wanted, not one that is traced or many at once.")
    return _Contents(model).found


class _Contents:
    """One model taken apart."""

    def __init__(self, model: Model):
        self.model, self.found = model, Builder()
        self.labels, self.topology, self.parameters = model.labels, model.topology, model.parameters
        self.found.dimension = self.labels.dimension
        x_roles, self.e_roles = model.roles()
        reference, first = np.asarray(self.parameters.reference), 0
        for name, entries in itertools.groupby(self.labels.x, key=lambda entry: entry.of):
            own = list(entries)
            last = first + len(own)
            kind = self._kind(own[0].kind, tuple(np.asarray(self.topology.powers)[first:last].tolist()))
            self.found.nodes[name] = Node(kind, reference[first:last].tolist(), x_roles[first:last])
            first = last
        self._members()
        x, e = self.labels.x, self.labels.e
        dofs: list[Key] = [("node", x[i].of, x[i].component) for i in np.asarray(self.topology.x.dof).tolist()]
        dofs += [("element", e[i].of, e[i].component) for i in np.asarray(self.topology.e.dof).tolist()]
        self.found.dofs = dofs
        self._loads("initial", self.parameters.loads)
        if self.parameters.increment is not None:
            self._loads("increment", self.parameters.increment)
        if self.parameters.strain is not None:
            self.found.loads["initial"]["strain"] = self._entries(self.parameters.strain, "element")
        if self.parameters.start is not None:
            pairs = np.stack([np.asarray(one) for one in self.parameters.start], 1).tolist()
            self.found.starts = {key: tuple(pair) for key, pair in zip(dofs, pairs, strict=True) if any(pair)}
        for k, (side, signals) in enumerate((("input", self.labels.inputs), ("output", self.labels.outputs))):
            weights = None if self.parameters.weights is None else iter(np.asarray(self.parameters.weights[k]).tolist())
            self.found.signals[side] = [self._signal(signal, weights) for signal in signals]

    def _kind(self, part: str, powers: tuple[int, ...]) -> NodeKind:
        plane = self.labels.dimension == 2
        if part == "internal":
            return (SERIES2 if plane else SERIES3).sized(len(powers), powers)
        return {
            "position": POINT2 if plane else POINT3,
            "rotation": ANGLE if plane else ROTATION3,
            "warping": WARPING,
        }[part]

    def _members(self) -> None:
        shown = {(kind, nodes): name for name, kind, nodes in reversed(self.labels.elements)}
        found: dict[str, Member] = {}
        for block, stacked in zip(self.topology.blocks, self.parameters.properties, strict=True):
            if block.element.deformation is UNIT_NORM.deformation:
                continue
            for i in range(block.x.shape[0]):
                nodes = self._nodes(block, i)
                e = np.asarray(block.e[i]).tolist()
                name = self.labels.e[e[0]].of if e else shown.get((block.element.name, nodes), "")
                hidden = not name
                name = name or f"{block.element.name} {nodes[0]} {len(found)}"
                properties = _of_one(stacked, i) | dict(block.options)
                if name in found:
                    known = found[name].properties
                    found[name].properties = known | {k: v for k, v in properties.items() if known.get(k) is None}
                    continue
                whole = dict.fromkeys(block.element.properties) | properties
                found[name] = Member(block.element, nodes, whole, [self.e_roles[k] for k in e], hidden=hidden)
        order = [name for name, *_ in self.labels.elements]
        self.found.members = {
            name: found[name] for name in sorted(found, key=lambda n: order.index(n) if n in order else len(order))
        }

    def _nodes(self, block: Block, i: int) -> tuple[str, ...]:
        firsts = [0, *block.splits]
        row = np.asarray(block.x[i]).tolist()
        return tuple(self.labels.x[row[first]].of for first in firsts)

    def _entries(self, values: Any, kind: str) -> dict[Key, Any]:
        """What is not zero, by name."""
        labels, array = self.labels.x if kind == "node" else self.labels.e, np.asarray(values)
        return {(kind, labels[i].of, labels[i].component): float(array[i]) for i in np.flatnonzero(array).tolist()}

    def _loads(self, which: str, loads: Loads) -> None:
        own: dict[str, Any] = {}
        if loads.force is not None:
            own["force"] = self._entries(loads.force, "node")
        if loads.prestress is not None:
            own["prestress"] = self._entries(loads.prestress, "element")
        if loads.gravity is not None:
            own["gravity"] = {"all": np.asarray(loads.gravity).tolist()}
        prescribed = {}
        for kind, roles, labels, values in (
            ("node", self.topology.x, self.labels.x, loads.x),
            ("element", self.topology.e, self.labels.e, loads.e),
        ):
            if values is not None:
                pairs = zip(np.asarray(roles.prescribed).tolist(), np.asarray(values).tolist(), strict=True)
                prescribed |= {(kind, labels[i].of, labels[i].component): value for i, value in pairs}
        if prescribed:
            own["prescribed"] = prescribed
        if loads.temperature is not None:
            rows = {name: int(self.labels.deformations(name, 1)) for name in self.labels.warm}
            own["temperature"] = {
                ("element", name, 1): np.asarray(loads.temperature[i]).tolist() for name, i in rows.items()
            }
        self.found.loads[which] = own

    def _signal(self, signal: Signal, weights: Any) -> NamedSignal:
        if signal.parts:
            parts = tuple(self._signal(part, None) for part in signal.parts)
            factors = tuple(next(weights) for _ in parts)
            return NamedSignal(signal.name, signal.quantity, parts[0].key, parts=parts, weights=factors)
        if weights is not None:
            next(weights)
        kind, labels = ("element", self.labels.e) if signal.of_element else ("node", self.labels.x)
        entry = labels[signal.index]
        return NamedSignal(signal.name, signal.quantity, (kind, entry.of, entry.component), signal.axis, signal.local)


def _of_one(stacked: dict[str, Any], i: int) -> dict[str, Any]:
    """Properties of one element of a block."""
    found = {}
    for name, value in stacked.items():
        if name == "section" and isinstance(value, tuple):
            sizes = [len(jax.tree.leaves(stack)[0]) for stack in value]
            k, own = next((k, i - sum(sizes[:k])) for k in range(len(sizes)) if i < sum(sizes[: k + 1]))
            found[name] = jax.tree.map(lambda leaf, own=own: _plain(leaf[own]), value[k])
            # An element without section, beside others that have one.
            if isinstance(found[name], Rigidity) and not any(jax.tree.leaves(found[name])):
                found[name] = None
        else:
            found[name] = jax.tree.map(lambda leaf: _plain(leaf[i]), value)
    return found


def _plain(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else np.asarray(value)
