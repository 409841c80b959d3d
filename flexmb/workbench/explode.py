"""A building block taken apart: the nodes and elements that it makes, as things of their own."""

from typing import Any

import numpy as np

from ..build.description import Member
from ..elements import planar, spatial
from ..errors import clean
from ..model.roles import Role
from .building import Built, build
from .content import Document, EditError, Report
from .fields import ENDS_IN_WORDS, Call, calls
from .references import call_of, replaced


def explode(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "explode", "id"}``: a block becomes its nodes and elements, which keep their names.

    Their positions are numbers from then on; sections stay as they are named.
    """
    thing = document.thing(op["id"])
    call, id = call_of(thing), thing["id"]
    if call is None or call.kind != "block":
        raise EditError(id, f"'{clean(thing.get('name', thing['call']))}' is no building block.")
    built = build(document)
    if id not in built.made:
        told = next((p["message"] for p in built.problems if p["address"].startswith(f"{id}/")), "it cannot be built.")
        raise EditError(id, f"Block '{clean(thing['name'])}' cannot be taken apart: {told}")
    parts = _Parts(document, built, thing, call)
    new = [*parts.nodes(), *parts.elements()]
    place = document.things.index(thing)
    things = [*document.things[:place], *parts.sections, *new, *document.things[place + 1 :]]
    ids = [one["id"] for one in (*parts.sections, *new)]
    taken = document.known.by_space
    for one in new:
        space = "node" if one["call"] == "node" else "element"
        if one["name"] in taken.get(space, {}):
            raise EditError(id, f"There is {space} '{clean(one['name'])}' already: rename it first.")
    return document.with_things(things, next=parts.next), Report(ids, [], f"explode {thing['name']}")


class _Parts:
    """What a block has made, as things."""

    def __init__(self, document: Document, built: Built, block: dict[str, Any], call: Call):
        self.document, self.builder, self.block, self.call = document, built.builder, block, call
        self.made, self.records = built.made[block["id"]], built.records
        self.next = document.data["next"]
        self.sections: list[dict[str, Any]] = []
        self.known: dict[int, str] = {
            id(record): document.by_id[one]["name"]
            for one, record in built.records.items()
            if document.by_id[one]["call"] and call_of(document.by_id[one]).makes == "section"  # pyright: ignore
        }

    def _thing(self, call: str, name: str, args: dict[str, Any]) -> dict[str, Any]:
        self.next += 1
        return {"id": str(self.next - 1), "call": call, "name": name, "args": args}

    def nodes(self) -> list[dict[str, Any]]:
        """Nodes that have a position."""
        nodes = self.builder.nodes
        return [
            self._thing("node", name, {"position": _numbers(nodes[name].start)})
            for name in self.made["nodes"]
            if nodes[name].kind.part == "position"
        ]

    def elements(self) -> list[dict[str, Any]]:
        """Elements, with their options and their sections."""
        return [self._element(name, self.builder.members[name]) for name in self.made["elements"]]

    def _element(self, name: str, member: Member) -> dict[str, Any]:
        element = member.element
        nodes = [n for n in member.nodes if self.builder.nodes[n].kind.part in ("position", "rotation")]
        rooms = {"planar": planar, "spatial": spatial}
        found = [
            f"{room}.{one}"
            for room, module in rooms.items()
            for one in module.__all__
            if getattr(module, one) == element.usual and f"{room}.{one}" in calls()
        ]
        args: dict[str, Any] = {"nodes": _shortest(nodes)}
        for key, value in member.properties.items():
            if value is not None and key in calls()[found[0]].fields and key != "damping":
                args[key] = self._value(key, value)
        args |= {option: _written(value) for option, _, value in element.chosen}
        usual = element.freed(member.properties)
        free = [
            k + 1 for k, role in enumerate(member.roles) if role is not Role.FIXED and k + 1 not in element.measured
        ]
        if usual != "all" and sorted(usual) != free:
            args["released"] = " ".join(map(str, free)) or "none"
        return self._thing(found[0], name, args)

    def _value(self, key: str, value: Any) -> Any:
        if key == "section":
            return self._section(value)
        if key == "clamped":
            return next(word for word, ends in ENDS_IN_WORDS.items() if np.array_equal(value, np.array(ends, float)))
        return _numbers(value) if np.ndim(value) else _number(value)

    def _section(self, record: Any) -> str:
        """Name of a section: that of the block, that with shear, or the one that the block makes of its sizes."""
        if id(record) in self.known:
            return self.known[id(record)]
        given = self.block["args"].get("section")
        if given is not None:
            own = self.document.by_id[self.document.known.by_space["section"][given]]
            made = ("shear", own["call"], replaced(own["args"], ["shear"], "true"), f"{given} with shear")
        else:
            # A notch hinge states the sizes of its notch.
            fields = {field for field in calls()["notch_circular"].fields}
            args = {key: value for key, value in self.block["args"].items() if key in fields}
            made = ("notch", "notch_circular", args, f"{self.block['name']} notch")
        name = made[3]
        while name in self.document.known.by_space.get("section", {}):
            name += "'"
        if made[0] not in {one.get("why") for one in self._why}:
            self.sections.append(self._thing(made[1], name, made[2]))
            self._why.append({"why": made[0], "name": name})
        return next(one["name"] for one in self._why if one["why"] == made[0])

    @property
    def _why(self) -> list[dict[str, str]]:
        return self.__dict__.setdefault("_reasons", [])


def _shortest(nodes: list[str]) -> list[str]:
    """Nodes of an element without those that follow from the others: the rotation of the node before it."""
    plain = [node for k, node in enumerate(nodes) if not (k and node == f"{nodes[k - 1]}.rotation")]
    # The Builder takes one name an end, or one a parameter.
    ends = [node for node in plain if not node.endswith(".rotation")]
    return ends if len(ends) == len(plain) else nodes


def _number(value: Any) -> str:
    return repr(float(value) + 0.0)


def _numbers(values: Any) -> list[str]:
    return [_number(value) for value in values]


def _written(value: Any) -> str:
    return {True: "true", False: "false"}[value] if isinstance(value, bool) else str(value)


OPERATIONS = {"explode": explode}
