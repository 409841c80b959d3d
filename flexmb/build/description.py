"""Contents of a Builder: nodes, elements, roles, loads and signals by name, and the look-up of names."""

from __future__ import annotations

import copy
import dataclasses
import difflib
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np

from ..arguments import check_numbers, is_concrete, short_repr
from ..elements import spatial
from ..elements.element import Element
from ..elements.nodes import ANGLE, ROTATION3, NodeKind
from ..errors import ModelError
from ..model.by_name import TURN_OF, TURNS, frame_of, turn_of, turned_by
from ..model.topology import Role
from ..numerical_limits import TEN_DIGITS
from .calls import MadeCall, records_call
from .given import check_closure, nonempty_arguments, number_in, number_in_element, numbers_freed

AXES = ("x", "y", "z")

# "node" or "element", its name, and the number of a coordinate or deformation from 1.
Key = tuple[str, str, int]


class NamedSignal(NamedTuple):
    """An input or output as it was named; see :class:`flexmb.model.model.Signal`."""

    name: str
    quantity: str
    key: Key
    axis: int | None = None
    local: bool = False
    parts: tuple["NamedSignal", ...] = ()
    weights: tuple[Any, ...] = ()


@dataclasses.dataclass
class Node:
    """A node: its kind, start coordinates and the role of each."""

    kind: NodeKind
    start: Any
    roles: list[Role]


@dataclasses.dataclass
class Member:
    """An element: its type, nodes, properties and the role of each deformation."""

    element: Element
    nodes: tuple[str, ...]
    properties: dict[str, Any]
    roles: list[Role]
    hidden: bool = False

    def nodes_of_kind(self, part: str) -> list[str]:
        """Nodes of a kind, such as "rotation", in order."""
        kinds = self.element.nodes.values()
        return [node for node, kind in zip(self.nodes, kinds, strict=True) if kind.part == part]

    def with_properties(self, **changed: Any) -> Member:
        """The element with other values of some properties."""
        return dataclasses.replace(self, properties={**self.properties, **changed})


class Description:
    """Contents of a :class:`flexmb.Builder`, with the look-up of names.

    Attributes:
        nodes: Nodes by name, in order of addition; rotations are nodes of their own.
        members: Elements by name, in order of addition.
        dofs: Named degrees of freedom.
        loads: By set ("initial", "increment") and kind, numbers by key.
        signals: Inputs and outputs.
        starts: Start value and velocity of degrees of freedom.
        dimension: 2 in the plane, 3 in space, None before the first node.
        calls: Calls that made the contents, in order, with the name that :meth:`flexmb.Builder.add` returned.
    """

    def __init__(self):
        self.nodes: dict[str, Node] = {}
        self.members: dict[str, Member] = {}
        self.dofs: list[Key] = []
        self.loads: dict[str, dict[str, Any]] = {"initial": {}, "increment": {}}
        self.signals: dict[str, list[NamedSignal]] = {"input": [], "output": []}
        self.starts: dict[Key, tuple[Any, Any]] = {}
        self.dimension: int | None = None
        self.calls: list[MadeCall] = []
        self._clamped: set[str] = set()
        self._is_recording = False

    @records_call
    def release(self, element: str, *deformations: int | str, kind: str | None = None) -> None:
        """Release deformations of an element, or FIXED coordinates of a node.

        Released deformations may change: they become DEPENDENT.

        Args:
            element: Name of the element or of the node.
            deformations: Numbers from 1, or names; the name of a strain field releases all its coefficients. For a node
                its coordinates ("x", "phi"); in space "rx", "ry" or "rz", the angle about this global axis alone.
            kind: "node" or "element", if both have the name; by default the element.

        Raises:
            ModelError: The deformation or coordinate does not exist, is PRESCRIBED, or is a degree of freedom. A number
                names a deformation of the closure of a spectral beam: use its name.
        """
        entries, name = nonempty_arguments("release", element, deformations), str(element)
        self._check_kind(kind)
        if kind == "node" or (kind is None and name in self.nodes and name not in self.members):
            for key in [self._entry(name, component, "node") for component in entries]:
                self._release_support(key)
            return
        member = self._member(name)
        numbers = [
            n for deformation in entries for n in numbers_freed(name, member.element, len(member.roles), deformation)
        ]
        self._set_roles([("element", name, n) for n in numbers], Role.DEPENDENT)

    def _release_support(self, key: Key) -> None:
        """Let a coordinate change, or the angle of a rotation in space while its other angles stay FIXED."""
        if key[0] == "element":
            part = self._rotation_name(turned_by(key[1])[0])
            euler_keys = [("node", part, i) for i in range(1, ROTATION3.size + 1)]
            if all(self._role(entry) is Role.FIXED for entry in euler_keys):
                self._set_roles(euler_keys, Role.DEPENDENT)
                self._set_roles([turn for i in range(3) if (turn := turn_about(self, part, i)) != key], Role.FIXED)
            self._set_roles([key], Role.DEPENDENT)
            self._measure_third(part)
        self._set_roles([key], Role.DEPENDENT)

    def _measure_third(self, rotation: str) -> None:
        """Add the hinge about the third global axis to a rotation that is FIXED about both other ones."""
        free = [turn for axis in range(3) if self._role(turn := turn_about(self, rotation, axis)) is not Role.FIXED]
        if len(free) == 1:
            self._owner(free[0])

    @records_call
    def dof(self, of: str, *components: str | int, kind: str | None = None) -> None:
        """Name degrees of freedom: coordinates of a node or deformations of an element, in the order of q.

        Coordinates come before deformations in q, each in the order given.

        Args:
            of: Name of a node or an element.
            components: Coordinates ("x", "phi" or numbers) or deformations (names, or numbers from 1). In space
                also "rx", "ry" or "rz", the angle about this global axis. flexmb then adds a hinge, as for
                ``prescribe``. The degree of freedom is deformation 1 of this hinge.
            kind: "node" or "element", if both have the name.
        """
        keys: list[Key] = []
        for component in nonempty_arguments("dof", of, components):
            key = self._entry_to_free(of, component, kind)
            if key in keys or self._role(key) is Role.DOF:
                raise ModelError(f"'{of}.{component}' is named as a degree of freedom twice.")
            keys.append(key)
        self._set_roles(keys, Role.DOF)
        self.dofs += keys

    def with_dofs(self, labels: Sequence[str]) -> Self:
        """A builder with these degrees of freedom, in this order, which must include those named by :meth:`dof`.

        Args:
            labels: Names as in ``model.q_labels``, such as "top.x" and "hinge.e2".

        Raises:
            ModelError: A name of no coordinate or deformation, one that occurs twice or is left out.
        """
        if not isinstance(labels, list | tuple) or any(not isinstance(label, str) for label in labels):
            raise ModelError(
                "Argument `dofs` must be 'auto', 'named' or a list of names as model.q_labels gives them, such as"
                f" ['top.x', 'hinge.e2'], not {short_repr(labels)}."
            )
        twin, keys = self.copy(), dict[Key, None]()
        twin.calls = [call for call in self.calls if call.method != "dof"]
        for label in labels:
            owner, point, symbol = label.rpartition(".")
            if not point:
                raise ModelError(f"Argument `dofs`: {short_repr(label)} is no degree of freedom. Name it as 'top.x'.")
            if owner.startswith(TURN_OF) and owner not in twin.members and turned_by(owner)[1]:
                # This name makes the hinge about a global axis.
                owner, symbol = turned_by(owner)
            is_element = symbol[:1] == "e" and number_in(symbol[1:]) is not None
            is_element |= owner in twin.members and symbol in twin.members[owner].element.deformation_names.values()
            kind = "element" if is_element else "node"
            key = twin._entry_to_free(owner, symbol, kind)
            if key in keys:
                raise ModelError(f"Argument `dofs` has {short_repr(label)} twice.")
            keys[key] = None
            twin.calls.append(MadeCall("dof", (owner, symbol), {"kind": kind}))
        if left_out := [f"'{key[1]} {key[2]}'" for key in self.dofs if key not in keys]:
            raise ModelError(f"Argument `dofs` leaves out {', '.join(left_out)}, which dof() names.")
        twin.dofs = list(keys)
        twin._set_roles(twin.dofs, Role.DOF)
        return twin

    def copy(self) -> Self:
        """A builder with the same contents, to vary."""
        return copy.copy(self)

    def __copy__(self) -> Self:
        twin = object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin.nodes = {name: dataclasses.replace(node, roles=list(node.roles)) for name, node in self.nodes.items()}
        twin.members = {name: dataclasses.replace(m, roles=list(m.roles)) for name, m in self.members.items()}
        twin.dofs, twin._clamped, twin.starts = list(self.dofs), set(self._clamped), dict(self.starts)
        twin.calls = list(self.calls)
        twin.loads = {k: {n: dict(v) for n, v in sets.items()} for k, sets in self.loads.items()}
        twin.signals = {k: list(v) for k, v in self.signals.items()}
        return twin

    def _load(self, kind: str, increment: bool) -> dict:
        return self.loads["increment" if increment else "initial"].setdefault(kind, {})

    def _dimension_for(self, name: str) -> int:
        if self.dimension is None:
            raise ModelError(f"Node '{name}': add a node with a position first; it decides plane or space.")
        return self.dimension

    def _new_node(self, name: str, kind: NodeKind, start: list) -> None:
        if name in self.nodes:
            raise ModelError(f"Node '{name}' is defined twice. Give each node its own name.")
        if self.dimension is not None and kind.dimension != self.dimension:
            raise ModelError(
                f"Node '{name}' has {kind.size} coordinates, but the mechanism is"
                f" {'planar' if self.dimension == 2 else 'spatial'}."
            )
        if len(start) != kind.size:
            raise ModelError(
                f"Node '{name}' must have {kind.size} coordinate{'s' if kind.size > 1 else ''}, but has {len(start)}."
            )
        check_numbers(f"Node '{name}'", start, fault=ModelError)
        norm = np.linalg.norm(np.asarray(start, float)) if kind is ROTATION3 and is_concrete(start) else 1.0
        if abs(norm - 1) > TEN_DIGITS:
            raise ModelError(
                f"Euler parameters of node '{name}' must have norm 1, but {short_repr(tuple(start))} have {norm:.6g}."
            )
        self.dimension = kind.dimension
        role = Role.FIXED if name in self._clamped else Role.DEPENDENT
        self.nodes[name] = Node(kind, start, [role] * kind.size)

    def _free_name(self, before: str) -> str:
        """A name with a number that no element and no node has."""
        number = len(self.members) + 1
        while f"{before} {number}" in self.members or f"{before} {number}" in self.nodes:
            number += 1
        return f"{before} {number}"

    def _unknown_node(self, name: str, where: str) -> Any:
        similar = difflib.get_close_matches(name, self.nodes, 1)
        hint = f" Did you mean '{similar[0]}'?" if similar else " Add it with node() first."
        raise ModelError(f"No node {short_repr(name)} ({where}).{hint}")

    def _position(self, node: str) -> str:
        """Name of a node, checked to have a position."""
        node = str(node)
        if node not in self.nodes:
            self._unknown_node(node, "position")
        if (kind := self.nodes[node].kind).part != "position":
            way = ""
            if kind.part == "rotation":
                room = "planar" if kind.dimension == 2 else "spatial"
                way = f" Put a body on it by add({room}.body, 'position', '{node}', mass=.., center=.., inertia=..)."
            raise ModelError(f"Node '{node}' has no position: it is a {kind.part} node.{way}")
        return node

    def _kind_of(self, part: str) -> NodeKind:
        """Kind of a node, or of a rotation that does not exist yet."""
        return self.nodes[part].kind if part in self.nodes else ANGLE if self.dimension == 2 else ROTATION3

    def _rotation_name(self, node: str) -> str:
        """Name of a node's rotation, which may not exist yet."""
        if node in self.nodes and self.nodes[node].kind.part == "rotation":
            return node
        owner = node.removesuffix(".rotation")
        if f"{node}.rotation" not in self.nodes:
            if owner not in self.nodes:
                self._unknown_node(node, "rotation")
            self._position(owner)
        return f"{owner}.rotation"

    def _warping_name(self, node: str) -> str:
        """Name of the warping of a node or a rotation."""
        if node in self.nodes and self.nodes[node].kind.part == "warping":
            return node
        return f"{node.removesuffix('.rotation').removesuffix('.warping')}.warping"

    def _can_mean(self, node: str, kind: NodeKind) -> bool:
        """Whether a name can refer to a node of this kind: a position has a rotation, and a rotation has a warping."""
        if node in self.nodes:
            part = self.nodes[node].kind.part
        else:
            part = next((part for part in ("rotation", "warping") if node.endswith(f".{part}")), "")
        meant = {"position": ("position", "rotation", "warping"), "rotation": ("rotation", "warping")}
        return kind.part in meant.get(part, (part,))

    def _member(self, name: str) -> Member:
        name = str(name)
        if name not in self.members or self.members[name].hidden:
            similar = difflib.get_close_matches(name, [n for n, m in self.members.items() if not m.hidden], 1)
            raise ModelError(f"No element {short_repr(name)}." + (f" Did you mean '{similar[0]}'?" if similar else ""))
        return self.members[name]

    def _owner(self, key: Key) -> Node | Member:
        """Node or element of a coordinate or deformation; makes a missing rotation or its hinge."""
        kind, owner, _ = key
        if kind == "node" and owner not in self.nodes:
            self._new_node(owner, (node_kind := self._kind_of(owner)), list(node_kind.start))
        if kind == "element" and owner not in self.members:
            node, _, axis = owner.removeprefix(TURN_OF).rpartition(".")
            properties = {"axis": np.eye(3)[TURNS.index(axis)], "stiffness": None, "damping": None}
            self._new_turn(owner, self._rotation_name(node), properties)
        return (self.members if kind == "element" else self.nodes)[owner]

    def _coordinate(self, node: str, component: str | int) -> tuple[str, int]:
        """Node, or rotation that may not exist yet, and number of a coordinate given by letter or number."""
        part, number = node, number_in(component)
        letter = isinstance(component, str) and number is None
        if node not in self.nodes:
            if not node.endswith(".rotation"):
                self._unknown_node(node, f"coordinate {short_repr(component)}")
            part = self._rotation_name(node)
        elif letter and self.nodes[node].kind.part == "position" and component not in AXES:
            part = self._rotation_name(node)
        kind = self._kind_of(part)
        if letter:
            if component not in kind.components:
                node_kind = self._kind_of(node)
                turns = self._kind_of(self._rotation_name(node)).components if node_kind.part == "position" else ()
                names = ", ".join((*node_kind.components, *turns))
                more = " Name several nodes one after the other." if component in self.nodes else ""
                raise ModelError(f"Node '{node}' has no coordinate {short_repr(component)}. It has: {names}.{more}")
            return part, kind.components.index(str(component)) + 1
        if number is None or not 1 <= number <= kind.size:
            raise ModelError(f"Node '{part}' has coordinates 1 to {kind.size}, not {short_repr(component)}.")
        return part, number

    def _check_kind(self, kind: Any) -> None:
        if kind is not None and not (isinstance(kind, str) and kind in ("node", "element")):
            raise ModelError(f"Argument `kind` must be 'node' or 'element', not {short_repr(kind)}.")

    def _entry(self, owner: str, component: str | int, kind: str | None) -> Key:
        """Key of a coordinate or a deformation: kind and name of its owner, and its number."""
        self._check_kind(kind)
        owner = str(owner)
        is_element = owner in self.members and not self.members[owner].hidden
        if kind is None and is_element and owner in self.nodes:
            raise ModelError(
                f'\'{owner}\' is the name of a node and of an element: choose by kind="node" or kind="element".'
            )
        if kind == "element" or (kind is None and is_element):
            member = self._member(owner)
            return "element", owner, number_in_element(owner, member.element, len(member.roles), component)
        if self.dimension == 3 and isinstance(component, str) and component in TURNS:
            return turn_about(self, self._rotation_name(owner), TURNS.index(component))
        return "node", *self._coordinate(owner, component)

    def _new_turn(self, name: str, rotation: str, properties: dict[str, Any]) -> None:
        """Add a hinge that measures a rotation in space, from a frame that is FIXED."""
        frame = frame_of(rotation)
        if frame not in self.nodes:
            self._new_node(frame, ROTATION3, list(ROTATION3.start))
            self.nodes[frame].roles = [Role.FIXED] * ROTATION3.size
        elif not any(other.startswith(TURN_OF) and frame in member.nodes for other, member in self.members.items()):
            raise ModelError(f"Node '{frame}' exists already, but turning a rotation needs this name.")
        self._owner(("node", rotation, 1))
        self.members[name] = Member(spatial.hinge, (frame, rotation), properties, [Role.DEPENDENT] * 3)

    def _entry_to_free(self, owner: str, component: str | int, kind: str | None) -> Key:
        """As :meth:`_entry`, for a new role: a FIXED closure must be given by its name."""
        key = self._entry(owner, component, kind)
        if key[0] == "element" and key[1] in self.members and self._role(key) is Role.FIXED:
            check_closure(key[1], self.members[key[1]].element, key[2], component)
        return key

    def _role(self, key: Key) -> Role:
        """Role of a coordinate or deformation, also of a rotation that does not exist yet."""
        kind, owner, number = key
        if kind == "node" and owner not in self.nodes:
            return Role.FIXED if owner in self._clamped else Role.DEPENDENT
        if kind == "element" and owner not in self.members:
            # The same as the rotation, if that is held as a whole or driven.
            rotation = self._rotation_name(owner.removeprefix(TURN_OF).rpartition(".")[0])
            roles = {self._role(("node", rotation, i)) for i in range(1, 5)} - {Role.DEPENDENT}
            return next(iter(roles)) if len(roles) == 1 else Role.DEPENDENT
        return self._owner(key).roles[number - 1]

    def _set_roles(self, keys: list[Key], role: Role) -> None:
        """Set the role of all coordinates or deformations, or of none if one has another role."""
        for key in keys:
            kind, owner, number = key
            turn = kind == "element" and number == 1 and owner.startswith(TURN_OF)
            only = role is not Role.DEPENDENT and (kind == "node" or turn)
            present, free = self._role(key), (Role.DEPENDENT,) if only else (Role.FIXED, Role.DEPENDENT)
            if present is not role and present not in free:
                subject = f"{'Coordinate' if kind == 'node' else 'Deformation'} {number} of '{owner}'"
                subject = f"The rotation '{owner.removeprefix(TURN_OF)}'" if turn else subject
                raise ModelError(f"{subject} is {present.value} already and cannot be {role.value} too.")
        for key in keys:
            if self._role(key) is not role:
                self._owner(key).roles[key[2] - 1] = role


def turn_about(description: Description, rotation: str, axis: int) -> Key:
    """Angle of a rotation in space about a global axis, by the hinge that turns it, which may not exist yet."""
    usual = description.members.get(turn_of(rotation))
    if usual is not None and usual.roles[1] is Role.DEPENDENT and is_concrete(usual.properties["axis"]):
        along = np.asarray(usual.properties["axis"])
        if along[axis] > 0 and np.count_nonzero(along) == 1:
            return "element", turn_of(rotation), 1
    return "element", turn_of(rotation, TURNS[axis]), 1
