"""The calls that a Builder's contents were made by: what it holds, taken apart into things of a document."""

import dataclasses
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..build.description import Description, Key, Member, NamedSignal
from ..build.given import released_in
from ..elements import planar, spatial
from ..elements.element import ALL
from ..elements.nodes import ANGLE
from ..elements.section import MaterialDamping, Section
from ..errors import clean
from ..model.by_name import TURN_OF, TURNS, frame_of, turned_by
from ..model.roles import Role
from .fields import ENDS_IN_WORDS, Call, calls

# What elements without a name are, by their type, and the call that makes each.
HIDDEN = {"mass": "mass", "inertia": "inertia", "body": "body"}
HIDDEN |= {"follower_force": "force", "moment": "moment", "follower_moment": "moment"}
TYPES = {getattr(room, name): name for room in (planar, spatial) for name in HIDDEN if hasattr(room, name)}


class NumberPlace(int):
    """Stands for a number, whose text is found afterwards: its place among all numbers."""


class Calls:
    """The calls of one Builder, in an order in which each finds what it refers to.

    Attributes:
        things: Calls with their arguments; in place of each number its :class:`NumberPlace`.
        numbers: The numbers, traced where the Builder's are.
        left_out: What no call of a document can say.
    """

    def __init__(self, builder: Description):
        self.b = builder
        self.things: list[dict[str, Any]] = []
        self.numbers: list[Any] = []
        self.left_out: list[str] = []
        self._records: list[tuple[Any, str]] = []
        self._elements = {call.function: call for call in calls().values() if call.kind == "element"}
        self._turned = [name for name in builder.members if self._is_turn(name)]
        self._nodes()
        for name, member in builder.members.items():
            if not member.hidden and name not in self._turned:
                self._element(name, member)
        for name in builder.nodes:
            self._support(name)
        for member in builder.members.values():
            if member.hidden:
                self._lumped(member)
        for which, increment in (("initial", False), ("increment", True)):
            self._loads(builder.loads[which], increment)
        for side in ("input", "output"):
            for signal in builder.signals[side]:
                self._signal(side, signal)
        self._freedoms()
        for key, (value, velocity) in builder.starts.items():
            args = self._of(key) | {"component": self._component(key)}
            self._say("start", args | {"value": self._number(value), "velocity": self._number(velocity)})

    # -- texts ------------------------------------------------------------------------------------------------------

    def _say(self, call: str, args: dict[str, Any], name: str | None = None) -> None:
        thing: dict[str, Any] = {"call": call, "args": args}
        self.things.append(thing if name is None else {**thing, "name": name})

    def _number(self, value: Any) -> NumberPlace:
        self.numbers.append(value)
        return NumberPlace(len(self.numbers) - 1)

    def _vector(self, values: Any) -> list[NumberPlace]:
        return [self._number(values[i]) for i in range(len(values))]

    def _of(self, key: Key) -> dict[str, str]:
        """Whose coordinate or deformation it is; and whether a node's or an element's, where both are called so."""
        kind, of, _ = key
        if kind == "element" and of in self._turned:
            kind, of = "node", turned_by(of)[0]
        shown = of if kind == "element" else self._owner(of)
        known = {"node": self.b.nodes, "element": [n for n, m in self.b.members.items() if not m.hidden]}
        both = shown in known["node"] and shown in known["element"]
        return {"of": shown} | ({"kind": kind} if both else {})

    def _owner(self, node: str) -> str:
        """The node whose rotation this is, or the rotation itself where it has none."""
        owner = node.removesuffix(".rotation")
        return owner if owner != node and owner in self.b.nodes else node

    def _component(self, key: Key) -> str:
        kind, of, number = key
        if kind == "element" and of in self._turned:
            return turned_by(of)[1] or "rotation"
        if kind == "element":
            return _said(self.b.members[of], number)
        own = self.b.nodes.get(of)
        return str(number) if own is None or own.kind.part == "internal" else own.kind.components[number - 1]

    # -- nodes and elements -----------------------------------------------------------------------------------------

    def _nodes(self) -> None:
        turns = {frame_of(turned_by(name)[0]) for name in self._turned}
        for name, node in self.b.nodes.items():
            part, owner = node.kind.part, name.rpartition(".")[0]
            if part == "position":
                self._say("node", {"position": self._vector(node.start)}, name)
            elif part == "rotation" and name not in turns:
                usual = is_concrete(node.start) and tuple(np.asarray(node.start, float)) == tuple(node.kind.start)
                if not (owner in self.b.nodes and usual):
                    self._say("rotation", {} if usual else {"start": self._vector(node.start)}, name)
            elif part == "warping" and name == name.removesuffix(".warping"):
                self._say("warping", {}, name)

    def _element(self, name: str, member: Member) -> None:
        element = member.element
        call = self._elements.get(element.usual)
        if call is None:
            self.left_out.append(
                f"element '{clean(name)}': its type '{clean(element.name)}' is a function of your own, which a document"
                " cannot hold"
            )
            return
        args: dict[str, Any] = {"nodes": self._ends(member)}
        args |= self._fields(f"element '{clean(name)}'", call, member.properties | element.options, member)
        roles = [role for role in member.roles]
        chosen = {n for n, role in enumerate(roles, 1) if role in (Role.DOF, Role.PRESCRIBED)}
        free = {n for n, role in enumerate(roles, 1) if role is Role.DEPENDENT} - set(element.measured) - chosen
        usual = released_in(name, element.freed(member.properties), element, len(roles))
        if free != set(usual) - set(element.measured) - chosen:
            every = free == set(released_in(name, ALL, element, len(roles))) - set(element.measured) - chosen
            words = [_said(member, number) for number in sorted(free)]
            args["released"] = ALL if every and free else " ".join(words) or "none"
        self._say(call.name, args, name)

    def _ends(self, member: Member) -> list[str]:
        """One name for each end, where a node stands for its rotation and warping; else all of them."""
        kinds = [kind.part for kind in member.element.nodes.values()]
        named = [(node, part) for node, part in zip(member.nodes, kinds, strict=True) if part != "internal"]
        ends: list[tuple[str, set[str]]] = []
        for node, part in named:
            owner = node.removesuffix(f".{part}")
            if ends and ends[-1][0] == owner and part not in ends[-1][1]:
                ends[-1][1].add(part)
            else:
                ends.append((owner if owner in self.b.nodes else node, {part}))
        shown = [end for end, _ in ends]
        try:
            if self.b._resolve(member.element, "", shown)[: len(named)] == tuple(node for node, _ in named):  # type: ignore[attr-defined]
                return shown
        except ValueError:
            pass
        return [node for node, _ in named]

    def _fields(self, what: str, call: Call, values: dict[str, Any], member: Member | None = None) -> dict[str, Any]:
        """Arguments that fields hold; defaults are not said."""
        found: dict[str, Any] = {}
        for name, value in values.items():
            if value is None or (name == "damping" and member is not None and _by_material(member)):
                continue
            field = call.fields.get(name)
            if field is None:
                self.left_out.append(f"{what}: {name} = {clean(value)}, for which there is no field")
                continue
            if is_concrete(value) and not dataclasses.is_dataclass(value) and _is_default(value, _default(call, name)):
                continue
            said = self._value(f"{what}: {name}", field, value)
            if said is not None:
                found[name] = said
        return found

    def _value(self, what: str, field: dict[str, Any], value: Any) -> Any:
        """One argument; None, and told, where no field can hold it."""
        kind = field["kind"]
        if kind in ("section", "material", "damping"):
            return self._record(what, kind, value)
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, str):
            return value
        if set(field["choices"] or ()) == set(ENDS_IN_WORDS):
            flags = tuple(bool(flag) for flag in np.asarray(value, float))
            return next(word for word, pair in ENDS_IN_WORDS.items() if pair == flags)
        if field["whole"] and isinstance(value, int):
            return str(value)
        if callable(value) or np.ndim(value) > 1:
            self.left_out.append(f"{what} = {clean(value)}, which no field can hold")
            return None
        if kind == "vector":
            return [self._number(value)] if np.ndim(value) == 0 else self._vector(value)
        return self._number(value) if np.ndim(value) == 0 else self._vector(value)

    def _record(self, what: str, kind: str, value: Any) -> str | None:
        """Name of a section, material or damping, which is said before if it is not yet."""
        for known, name in self._records:
            if known is value:
                return name
        constant = next((c for c in calls().values() if c.kind == "constant" and _same(c.function, value)), None)
        call = constant or calls().get(type(value).__name__)
        if call is None or (call.function is not type(value) and constant is None):
            why = "it varies along the element, by a function" if getattr(value, "varies", False) else "it is your own"
            self.left_out.append(f"{what}: {type(value).__name__} cannot be held by a document, since {why}")
            return None
        own = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)} if not constant else {}
        args = self._fields(what, call, own)
        prefix = str(call.entry["name"] or kind)
        taken = {name for _, name in self._records}
        name, number = prefix, 1
        while name in taken:
            number += 1
            name = f"{prefix} {number}"
        self._records.append((value, name))
        self._say(call.name, args, name)
        return name

    # -- supports, masses and loads -----------------------------------------------------------------------------------

    def _support(self, name: str) -> None:
        node = self.b.nodes[name]
        held = [i for i, role in enumerate(node.roles, 1) if role is Role.FIXED]
        if name in {frame_of(turned_by(turn)[0]) for turn in self._turned}:
            return
        rotation, owner = f"{name}.rotation", self._owner(name)
        if owner != name and self._held_whole(owner):
            # With the node itself.
            if len(held) == len(node.roles):
                return
        if len(held) == len(node.roles):
            if node.kind.part == "position":
                whole = self._held_whole(rotation) if rotation in self.b.nodes else rotation in self.b._clamped
                self._say("fix", {"node": name} if whole else {"node": name, "components": "position"})
            else:
                self._say("fix", {"node": owner, "components": "rotation"} if owner != name else {"node": name})
        elif held:
            words = [self._component(("node", name, i)) for i in held]
            self._say("fix", {"node": owner, "components": " ".join(words)})
        for i, role in enumerate(node.roles, 1):
            if role is Role.PRESCRIBED:
                self._prescribed(("node", name, i))

    def _held_whole(self, name: str) -> bool:
        return name in self.b.nodes and all(role is Role.FIXED for role in self.b.nodes[name].roles)

    def _is_turn(self, name: str) -> bool:
        """Whether an element is the hinge by which a rotation in space is turned or held."""
        member, (node, axis) = self.b.members[name], turned_by(name)
        return (
            name.startswith(TURN_OF)
            and member.element.name == "hinge"
            and member.nodes[0] == frame_of(node)
            and (axis != "" or member.roles[0] is Role.PRESCRIBED)
        )

    def _prescribed(self, key: Key) -> None:
        """One call for each set of loads that has a value, one without where none has."""
        args: dict[str, Any] = self._of(key) | {"component": self._component(key)}
        if args["component"] == "rotation":
            member = self.b.members[key[1]]
            args["axis"] = self._vector(member.properties["axis"])
            if member.roles[1] is Role.FIXED:
                args["tilt"] = "fixed"
        sets = [(name, own.get("prescribed", {})) for name, own in self.b.loads.items()]
        values = [(name, given[key]) for name, given in sets if key in given]
        if values and values[0][0] == "increment" and len(values) == 1:
            self._say("prescribe", args | {"value": self._number(values[0][1]), "increment": "true"})
            return
        for name, value in values:
            more = {"increment": "true"} if name == "increment" else {}
            self._say("prescribe", args | {"value": self._number(value)} | more)
        if not values:
            self._say("prescribe", args)

    def _lumped(self, m: Member) -> None:
        """Masses, inertias, bodies and loads that elements without a name stand for."""
        kind, node, own = TYPES.get(m.element, m.element.name), self._owner(m.nodes[0]), m.properties
        if kind in ("mass", "inertia"):
            value = own[kind]
            self._say(kind, {"node": node, kind: self._number(value) if kind == "mass" else self._several(value)})
        elif kind == "body":
            args = {"node": node, "mass": self._number(own["mass"]), "center": self._vector(own["center"])}
            self._say("body", args | {"inertia": self._several(own["inertia"])})
        elif kind in HIDDEN:
            call = HIDDEN[kind]
            args = {"node": node, call: self._vector(own[call])}
            args |= {"increment": "true"} if own.get("incremental") else {}
            self._say(call, args | ({"follower": "true"} if kind.startswith("follower") else {}))
        else:
            self.left_out.append(f"what acts on node '{clean(node)}' as '{clean(kind)}', for which there is no call")

    def _several(self, value: Any) -> list[NumberPlace]:
        return [self._number(value)] if np.ndim(value) == 0 else self._vector(value)

    def _loads(self, loads: dict[str, Any], increment: bool) -> None:
        more = {"increment": "true"} if increment else {}
        for part, values in _rows(loads.get("force", {})).items():
            kind = self.b.nodes[part].kind
            if kind is ANGLE:
                self._say("moment", {"node": self._owner(part), "moment": [self._number(values[1])]} | more)
                continue
            count = max(values) if kind.part == "internal" else kind.size
            args = {"node": part, "force": [self._number(values.get(i, 0.0)) for i in range(1, count + 1)]}
            self._say("force", args | more)
        for call in ("prestress", "strain"):
            for element, values in _rows(loads.get(call, {})).items():
                row = [self._number(values.get(i, 0.0)) for i in range(1, max(values) + 1)]
                self._say(call, {"element": element, "values": row} | more)
        for (_, element, _), (first, last, *across) in loads.get("temperature", {}).items():
            args = {"element": element, "change": [self._number(first), self._number(last)]}
            self._say("temperature", args | {"gradient": self._vector(across)} | more)
        if "gravity" in loads:
            self._say("gravity", {"acceleration": self._vector(loads["gravity"]["all"])} | more)

    # -- freedoms and signals -----------------------------------------------------------------------------------------

    def _freedoms(self) -> None:
        for name, member in self.b.members.items():
            for i, role in enumerate(member.roles, 1):
                if role is Role.PRESCRIBED:
                    self._prescribed(("element", name, i))
                elif role is Role.FIXED and name in self._turned and i == 1:
                    node, axis = turned_by(name)
                    self._say("fix", {"node": node, "components": axis})
        runs: list[tuple[dict[str, str], list[str]]] = []
        for key in self.b.dofs:
            of, component = self._of(key), self._component(key)
            if runs and runs[-1][0] == of and component not in runs[-1][1]:
                runs[-1][1].append(component)
            else:
                runs.append((of, [component]))
        for of, components in runs:
            self._say("dof", of | {"components": " ".join(components)})

    def _signal(self, side: str, signal: NamedSignal) -> None:
        if signal.parts:
            pairs = zip(signal.parts, signal.weights, strict=True)
            weights = [[self._part(part), self._number(weight)] for part, weight in pairs]
            self._say("sensor" if side == "output" else "actuator", {"weights": weights}, signal.name)
            return
        component = self._component(signal.key) if signal.axis is None else TURNS[signal.axis]
        args = self._of(signal.key) | {"component": component}
        if signal.quantity not in ("force", "moment", "stress" if side == "input" else "position", "deformation"):
            args["quantity"] = signal.quantity
        self._say(side, args | ({"local": "true"} if signal.local else {}), signal.name)

    def _part(self, signal: NamedSignal) -> str:
        component = self._component(signal.key) if signal.axis is None else TURNS[signal.axis]
        return f"{signal.quantity} {self._of(signal.key)['of']}.{component}"


def _rows(entries: dict[Key, Any]) -> dict[str, dict[int, Any]]:
    """Values by owner and number."""
    rows: dict[str, dict[int, Any]] = {}
    for (_, of, number), value in entries.items():
        rows.setdefault(of, {})[number] = value
    return rows


def _said(member: Member, number: int) -> str:
    """A deformation by its number; of a closure by its name, without which it cannot be freed."""
    element = member.element
    return element.deformation_names.get(number, str(number)) if number in element.closure else str(number)


def _same(known: Any, value: Any) -> bool:
    """Whether a material is one of those that the package holds."""
    if known is value or type(known) is not type(value) or not is_concrete(value):
        return known is value
    return all(getattr(known, field.name) == getattr(value, field.name) for field in dataclasses.fields(known))


def _by_material(member: Member) -> bool:
    """Whether an element is damped by its material alone, which its section says."""
    section, damping = member.properties.get("section"), member.properties.get("damping")
    return isinstance(damping, MaterialDamping) and isinstance(section, Section) and section.states("damping")


def _default(call: Call, name: str) -> Any:
    """What a call takes where an argument is not given."""
    if call.kind == "element":
        parameter = call.function.properties.get(name)
        return call.function.options.get(name) if parameter is None else parameter.default
    field = next((f for f in dataclasses.fields(call.function) if f.name == name), None)
    return None if field is None else field.default


def _is_default(value: Any, default: Any) -> bool:
    if isinstance(value, str | bool) or isinstance(default, str | bool):
        return type(value) is type(default) and value == default
    try:
        return default is not None and np.array_equal(np.asarray(value, float), np.asarray(default, float))
    except (TypeError, ValueError):
        return False
