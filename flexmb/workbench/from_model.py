"""A model as calls of a Builder, with the degrees of freedom and releases that the Builder had found."""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterator
from typing import Any

import jax
import numpy as np

from ..arguments import is_concrete
from ..build.assemble import UNIT_NORM
from ..build.builder import Builder
from ..build.clamps import with_clamps
from ..build.description import Key, Member, NamedSignal, Node
from ..build.ends_in_line import with_steps
from ..build.given import released_in
from ..elements import planar, spatial
from ..elements.leaf import flags_and_distances
from ..elements.nodes import ANGLE, POINT2, POINT3, ROTATION3, SERIES2, SERIES3, WARPING, NodeKind
from ..elements.section import MaterialDamping, Section
from ..elements.sections import Rigidity
from ..errors import ModelError
from ..model.by_name import TURN_OF, TURNS, frame_of, tilted_by, turned_by
from ..model.model import Model, Signal
from ..model.topology import HELD, Role
from ..plot.sections import unstacked

# Methods that put an element without a name on a node, by its type.
HIDDEN = {"mass": "mass", "inertia": "inertia", "body": "body"}
HIDDEN |= {"follower_force": "force", "moment": "moment", "follower_moment": "moment"}
TYPES = {getattr(room, name): name for room in (planar, spatial) for name in HIDDEN if hasattr(room, name)}
# Default quantities of signals.
USUAL = {"input": ("force", "moment", "stress"), "output": ("position", "deformation")}


def builder_of(model: Model) -> Builder:
    """A Builder whose calls build a model with concrete numbers."""
    if not is_concrete(model) or np.ndim(model.parameters.reference) != 1:
        raise ModelError("The model is traced, or several models at once. Give one model with concrete numbers.")
    stated: set[str] = set()
    while more := (conversion := _Conversion(model, stated)).clamped_otherwise() - stated:
        stated |= more
    return conversion.builder


class _Conversion:
    """The conversion of one model to calls, which state clamps of leaf springs where build() would find others."""

    def __init__(self, model: Model, stated: Container[str]):
        self.stated = stated
        self.labels, self.topology, self.parameters = model.labels, model.topology, model.parameters
        self.builder = Builder()
        self.builder.dimension = self.labels.dimension
        sets = (False, self.parameters.loads), (True, self.parameters.increment)
        self.load_sets = [(increment, loads) for increment, loads in sets if loads is not None]
        x_roles, self.e_roles = model.roles()
        self.nodes = dict(self._nodes(x_roles))
        self.members = self._members()
        self.turns = [name for name, member in self.members.items() if self._is_turn(name, member)]
        self.frames = {frame_of(turned_by(name)[0]) for name in self.turns}
        self._add_nodes()
        for name, member in self.members.items():
            if not member.hidden and name not in self.turns:
                self._add(name, member)
        self._fix()
        for member in self.members.values():
            if member.hidden:
                self._put(member)
        self._prescribe()
        for increment, loads in self.load_sets:
            self._load(loads, {"increment": True} if increment else {})
        if self.parameters.strain is not None:
            for name, row in self._rows(self.parameters.strain, self.labels.e):
                self.builder.strain(name, *row)
        dofs: list[Key] = [self._key("node", i) for i in np.asarray(self.topology.x.dof).tolist()]
        dofs += [self._key("element", i) for i in np.asarray(self.topology.e.dof).tolist()]
        # Components of one node or element in a row are one call.
        for (owner, kind), run in itertools.groupby(
            map(self._component, dofs), key=lambda part: (part[0], tuple(part[2].items()))
        ):
            self.builder.dof(owner, *(component for _, component, _ in run), **dict(kind))
        if self.parameters.start is not None:
            for key, *pair in zip(dofs, *(np.asarray(part).tolist() for part in self.parameters.start), strict=True):
                owner, component, kind = self._component(key)
                if any(pair):
                    self.builder.start(owner, component, *pair, **kind)
        for k, (side, signals) in enumerate((("input", self.labels.inputs), ("output", self.labels.outputs))):
            weights = itertools.repeat(1.0)
            if self.parameters.weights is not None:
                weights = iter(np.asarray(self.parameters.weights[k]).tolist())
            for signal in signals:
                self._name_signal(side, signal, [next(weights) for _ in signal.terms])

    def _nodes(self, roles: list[Role]) -> Iterator[tuple[str, Node]]:
        reference, powers, first = np.asarray(self.parameters.reference), np.asarray(self.topology.powers), 0
        for name, entries in itertools.groupby(self.labels.x, key=lambda entry: entry.of):
            entries = list(entries)
            last = first + len(entries)
            kind = self._kind(entries[0].kind, tuple(powers[first:last].tolist()))
            yield name, Node(kind, reference[first:last].tolist(), roles[first:last])
            first = last

    def _kind(self, part: str, powers: tuple[int, ...]) -> NodeKind:
        plane = self.labels.dimension == 2
        if part == "internal":
            return (SERIES2 if plane else SERIES3).sized(len(powers), powers)
        kinds = {"position": (POINT2, POINT3), "rotation": (ANGLE, ROTATION3), "warping": (WARPING, WARPING)}
        return kinds[part][not plane]

    def _members(self) -> dict[str, Member]:
        # Elements without deformations have no such labels. Two on one node differ by their order.
        element_names: dict[tuple, list[str]] = {}
        for name, kind, nodes in self.labels.elements:
            element_names.setdefault((kind, nodes), []).append(name)
        members: dict[str, Member] = {}
        for block, stacked in zip(self.topology.blocks, self.parameters.properties, strict=True):
            if block.element.deformation is UNIT_NORM.deformation:
                continue
            sections = unstacked(stacked["section"]) if isinstance(stacked.get("section"), tuple) else None
            for i in range(block.x.shape[0]):
                row, e = np.asarray(block.x[i]).tolist(), np.asarray(block.e[i]).tolist()
                nodes = tuple(self.labels.x[row[first]].of for first in (0, *block.splits))
                named = element_names.get((block.element.name, nodes), [])
                name = self.labels.e[e[0]].of if e else named.pop(0) if named else ""
                properties = _element_properties(stacked, sections, i) | dict(block.options)
                if name in members:
                    known = members[name].properties
                    members[name].properties = known | {k: v for k, v in properties.items() if known.get(k) is None}
                    continue
                roles = [self.e_roles[k] for k in e]
                key = name or f"{block.element.name} {nodes[0]} {len(members)}"
                members[key] = Member(block.element, nodes, properties, roles, hidden=not name)
        order = [name for name, *_ in self.labels.elements]
        return dict(sorted(members.items(), key=lambda pair: order.index(pair[0]) if pair[0] in order else len(order)))

    def _is_turn(self, name: str, member: Member) -> bool:
        """Whether an element is the hinge that turns or holds a rotation in space."""
        node, axis = turned_by(name)
        of_frame = member.element.name == "hinge" and member.nodes[0] == frame_of(node)
        return name.startswith(TURN_OF) and of_frame and (axis != "" or member.roles[0] is Role.PRESCRIBED)

    def clamped_otherwise(self) -> set[str]:
        """Names of the leaf springs whose ends the calls would clamp otherwise than the model does."""
        leaves = {name: member for name, member in self.members.items() if "clamped" in member.properties}
        try:
            other = with_steps(with_clamps(self.builder, None), self.builder)
        except ModelError:
            # What would decide is stated nowhere, or what is stated already does not suffice.
            return set(leaves)

        def differs(name: str, member: Member) -> bool:
            warpings = member.nodes_of_kind("warping")
            held = [
                [builder_nodes[n].roles[0] in HELD for n in warpings] for builder_nodes in (other.nodes, self.nodes)
            ]
            same = np.array_equal(other.members[name].properties["clamped"], member.properties["clamped"])
            return not same or held[0] != held[1]

        return {name for name, member in leaves.items() if differs(name, member)}

    def _key(self, kind: str, index: int) -> Key:
        entry = (self.labels.x if kind == "node" else self.labels.e)[index]
        return kind, entry.of, entry.component

    def _owner(self, node: str) -> str:
        """The node of a rotation, or the rotation itself if it has none."""
        owner = node.removesuffix(".rotation")
        return owner if owner in self.nodes else node

    def _component(self, key: Key) -> tuple[str, str, dict[str, str]]:
        """Node or element of a coordinate or deformation, its component, and ``kind`` if the name is ambiguous."""
        kind, owner, number = key
        if kind == "element" and owner in self.turns:
            owner, axis = turned_by(owner)
            kind, component = "node", axis or "rotation"
        elif kind == "element":
            element = self.members[owner].element
            component = element.deformation_names.get(number, "") if number in element.closure else ""
        else:
            kind_of = self.nodes[owner].kind
            component = "" if kind_of.part == "internal" else kind_of.components[number - 1]
            owner = self._owner(owner)
        ambiguous = owner in self.nodes and owner in self.members
        return owner, component or str(number), {"kind": kind} if ambiguous else {}

    def _add_nodes(self) -> None:
        for name, node in self.nodes.items():
            part, owned = node.kind.part, name.rpartition(".")[0] in self.nodes
            usual = tuple(node.start) == tuple(node.kind.start or ())
            if part == "position":
                self.builder.node(name, node.start)
            elif part == "rotation" and name not in self.frames and not (owned and usual):
                self.builder.rotation(name, *([] if usual else [node.start]))
            elif part == "warping" and not name.endswith(".warping"):
                self.builder.warping(name)

    def _add(self, name: str, member: Member) -> None:
        element, roles = member.element, member.roles
        properties = {key: value for key, value in member.properties.items() if value is not None}
        section, damping = properties.get("section"), properties.get("damping")
        if isinstance(damping, MaterialDamping) and isinstance(section, Section) and section.states("damping"):
            # The section's material has this damping.
            del properties["damping"]
        if "clamped" in properties and name in self.stated:
            flags, beyond = flags_and_distances(np.asarray(properties["clamped"]))
            properties["clamped"] = tuple((np.where(beyond > 0, 0.0, flags) == 1).tolist())
        else:
            properties.pop("clamped", None)
        chosen = {n for n, role in enumerate(roles, 1) if role in (Role.DOF, Role.PRESCRIBED)}
        free = {n for n, role in enumerate(roles, 1) if role is Role.DEPENDENT} - {*element.measured}
        usual = released_in(name, element.freed(member.properties), element, len(roles))
        if free != {*usual} - {*element.measured} - chosen:
            names = element.deformation_names
            properties["released"] = [names[n] if n in element.closure and n in names else n for n in sorted(free)]
        nodes = [node for node in member.nodes if self.nodes[node].kind.part != "internal"]
        self.builder.add(element, *nodes, name=name, **properties)

    def _fix(self) -> None:
        """Fix nodes as a whole with their rotations, then single components."""
        fully_fixed = {name for name, node in self.nodes.items() if all(role is Role.FIXED for role in node.roles)}
        for name, node in self.nodes.items():
            part, rotation = node.kind.part, f"{name}.rotation"
            fixed = [i for i, role in enumerate(node.roles, 1) if role is Role.FIXED]
            fixed_with_owner = self._owner(name) != name and {name, self._owner(name)} <= fully_fixed
            if not fixed or name in self.frames or fixed_with_owner:
                continue
            if name not in fully_fixed or part == "warping":
                entries = [self._component(("node", name, i)) for i in fixed]
                self.builder.fix(entries[0][0], *(component for _, component, _ in entries))
            elif part == "position" and rotation in self.nodes and rotation not in fully_fixed:
                self.builder.fix(name, "position")
            else:
                self.builder.fix(self._owner(name), *(["rotation"] if self._owner(name) != name else []))
        for name in self.turns:
            node, axis = turned_by(name)
            first, *tilts = self.members[name].roles
            fixed = [axis] if first is Role.FIXED else []
            if axis and tilts == [Role.FIXED] * 2:
                fixed += tilted_by(name)
            if fixed:
                self.builder.fix(node, *fixed)

    def _put(self, member: Member) -> None:
        """Put a mass, an inertia, a body or a load on its node."""
        kind = TYPES.get(member.element, "")
        if not kind:
            raise ModelError(f"A Builder has no call for '{member.element.name}' on node '{member.nodes[0]}'.")
        properties = {key: value for key, value in member.properties.items() if value is not None}
        flags = {"increment": True} if properties.pop("incremental", False) else {}
        flags |= {"follower": True} if kind.startswith("follower") else {}
        if kind != HIDDEN[kind]:
            properties = {HIDDEN[kind]: properties.pop(HIDDEN[kind])}
        getattr(self.builder, HIDDEN[kind])(self._owner(member.nodes[0]), **properties, **flags)

    def _prescribe(self) -> None:
        for kind, roles, field in (("node", self.topology.x, "x"), ("element", self.topology.e, "e")):
            for k, index in enumerate(np.asarray(roles.prescribed).tolist()):
                key = self._key(kind, index)
                owner, component, kind_of = self._component(key)
                more: dict[str, Any] = dict(kind_of)
                if component == "rotation":
                    hinge = self.members[key[1]]
                    tilt = {"tilt": "fixed"} if hinge.roles[1] is Role.FIXED else {}
                    more |= {"axis": hinge.properties["axis"]} | tilt
                arrays = [(i, getattr(loads, field)) for i, loads in self.load_sets]
                values = [(i, float(array[k])) for i, array in arrays if array is not None]
                for increment, value in values or [(False, 0.0)]:
                    self.builder.prescribe(owner, component, value, increment=increment, **more)

    def _rows(self, values: Any, labels: Any) -> Iterator[tuple[str, list[float]]]:
        """Nonzero values of each node or element, up to the last one."""
        array = np.asarray(values).tolist()
        for name, entries in itertools.groupby(range(len(array)), key=lambda i: labels[i].of):
            row = [array[i] for i in entries]
            while row and row[-1] == 0:
                row.pop()
            if row:
                yield name, row

    def _load(self, loads: Any, more: dict[str, bool]) -> None:
        if loads.force is not None:
            for name, row in self._rows(loads.force, self.labels.x):
                kind = self.nodes[name].kind
                if kind is ANGLE:
                    self.builder.moment(self._owner(name), row[0], **more)
                else:
                    missing = 0 if kind.part == "internal" else kind.size - len(row)
                    self.builder.force(name, [*row, *[0.0] * missing], **more)
        if loads.prestress is not None:
            for name, row in self._rows(loads.prestress, self.labels.e):
                self.builder.prestress(name, *row, **more)
        if loads.temperature is not None:
            for name in self.labels.warm:
                first, last, *across = np.asarray(loads.temperature[int(self.labels.deformations(name, 1))]).tolist()
                gradient = {"gradient": across} if any(across) else {}
                self.builder.temperature(name, first if first == last else [first, last], **gradient, **more)
        if loads.gravity is not None:
            self.builder.gravity(np.asarray(loads.gravity).tolist(), **more)

    def _name_signal(self, side: str, signal: Signal, weights: list[float]) -> None:
        if signal.parts:
            parts = [f"{part.quantity} {'.'.join(self._of(part)[:2])}" for part in signal.parts]
            pairs = dict(zip(parts, weights, strict=True))
            (self.builder.sensor if side == "output" else self.builder.actuator)(signal.name, pairs)
            return
        owner, component, kind = self._of(signal)
        quantity = "" if signal.quantity in USUAL[side] else signal.quantity
        entry = None if signal.of_element or signal.axis is not None else self.labels.x[signal.index]
        if entry is not None and self.nodes[entry.of].kind is ROTATION3:
            # The methods of a Builder accept no signal of an Euler parameter.
            key = self._key("node", signal.index)
            self.builder.signals[side].append(NamedSignal(signal.name, signal.quantity, key))
            return
        getattr(self.builder, side)(owner, component, quantity, name=signal.name, local=signal.local, **kind)

    def _of(self, signal: Signal) -> tuple[str, str, dict[str, str]]:
        """Like :meth:`_component` for a signal, which may be about an axis."""
        owner, component, kind = self._component(self._key("element" if signal.of_element else "node", signal.index))
        return owner, component if signal.axis is None else TURNS[signal.axis], kind


def _element_properties(stacked: dict[str, Any], sections: list[Section] | None, i: int) -> dict[str, Any]:
    """Properties of element i of a block, whose sections are of several kinds where they are listed."""
    properties = {}
    for name, value in stacked.items():
        if name == "section" and sections is not None:
            section = jax.tree.map(_plain, sections[i])
            # Zeros stand for an element without section beside others with one.
            properties[name] = section if not isinstance(section, Rigidity) or any(jax.tree.leaves(section)) else None
        else:
            properties[name] = jax.tree.map(lambda leaf: _plain(leaf[i]), value)
    return properties


def _plain(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else np.asarray(value)
