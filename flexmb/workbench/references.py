"""Which things of a document refer to which, by name, and how a name that changes is followed."""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..model.by_name import FRAME_OF, TURN_OF, TURNS
from .fields import Call, calls

# Parts of a node or an element that have a name of their own.
PARTS = (".rotation", ".warping", ".internal", *(f".{axis}" for axis in TURNS))
# Kinds of fields that hold names of things, and in which namespaces these are looked up.
SPACES = {
    "node": ("node",),
    "nodes": ("node",),
    "of": ("node", "element"),
    "element": ("element",),
    "section": ("section",),
    "sections": ("section",),
    "material": ("material",),
    "damping": ("damping",),
    "weights": ("node", "element"),
}


def call_of(thing: dict[str, Any]) -> Call | None:
    """What a thing calls; None where this version knows no such call."""
    return calls().get(thing["call"])


def called(things: Mapping[str, dict[str, Any]], address: str) -> str:
    """Call and name of the thing to which an address belongs; the address where there is none."""
    thing = things.get(address.partition("/")[0])
    return address if thing is None else f"{thing['call']} {thing.get('name') or ''}".strip()


def references(thing: dict[str, Any]) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Names that a thing refers to: address within the thing, namespaces, and the name as it is written there."""
    call = call_of(thing)
    for argument, value in thing["args"].items():
        field = call.fields.get(argument) if call else None
        if field is None or field["kind"] not in SPACES:
            continue
        spaces = SPACES[field["kind"]]
        if field["kind"] == "of" and thing["args"].get("kind") in spaces:
            spaces = (thing["args"]["kind"],)
        if field["kind"] == "weights":
            for k, pair in enumerate(value if isinstance(value, list) else []):
                if isinstance(pair, list) and pair and pair[0] and isinstance(pair[0], str):
                    yield f"{argument}/{k}/0", spaces, pair[0]
        elif isinstance(value, list):
            yield from (
                (f"{argument}/{k}", spaces, name) for k, name in enumerate(value) if name and isinstance(name, str)
            )
        elif value:
            yield argument, spaces, value


def stage_of(thing: dict[str, Any]) -> str | None:
    """Name of the node that a building block carries, and makes where it is not there."""
    call, stage = call_of(thing), thing["args"].get("stage")
    return stage if call is not None and call.kind == "block" and isinstance(stage, str) and stage else None


class Names:
    """Names of the things of a document, and which thing a reference means.

    Attributes:
        by_space: Of each namespace, the id of the thing that bears a name.
        made: Ids of the building blocks that make a node as their stage, by its name.
    """

    def __init__(self, things: list[dict[str, Any]]):
        self.by_space: dict[str, dict[str, str]] = {}
        self.made: dict[str, str] = {}
        for thing in things:
            call = call_of(thing)
            if call is None:
                continue
            if call.makes and thing.get("name"):
                self.by_space.setdefault(call.makes, {}).setdefault(thing["name"], thing["id"])
            if stage := stage_of(thing):
                self.made.setdefault(stage, thing["id"])
        self._blocks = sorted(self.by_space.get("block", {}).items(), key=lambda pair: -len(pair[0]))

    def thing(self, spaces: tuple[str, ...], name: str) -> str | None:
        """Id of the thing that a reference means; None where there is none, or two.

        Args:
            spaces: Namespaces in which it may be.
            name: As it is written, which may be that of a part, such as "A.rotation" or "pivot leaf 1".
        """
        found = self.exactly(spaces, name)
        if found or not {"node", "element"} & set(spaces):
            return found
        if found := self._stage(spaces, name):
            return found
        for start in (TURN_OF, FRAME_OF):
            if name.startswith(start) and (found := self.exactly(("node",), name.removeprefix(start))):
                return found
        return next((id for block, id in self._blocks if name.startswith(f"{block} ")), None)

    def first(self, spaces: tuple[str, ...], name: str) -> str | None:
        """The same where the first namespace counts in which there is such a name: parts of sensors are nodes first."""
        return next((found for space in spaces if (found := self.thing((space,), name))), None)

    def exactly(self, spaces: tuple[str, ...], name: str) -> str | None:
        """The same of a thing's own name, or that of its rotation, its warping or its coordinates."""
        for plain in dict.fromkeys((name, _without_part(name))):
            found = {self.by_space.get(space, {}).get(plain) for space in spaces} - {None}
            if len(found) == 1:
                return found.pop()
        return None

    def _stage(self, spaces: tuple[str, ...], name: str) -> str | None:
        return self.made.get(name) or self.made.get(_without_part(name)) if "node" in spaces else None


def _without_part(name: str) -> str:
    return next((name.removesuffix(part) for part in PARTS if name.endswith(part)), name)


def part_of(names: Names, said: str) -> tuple[str, str, str]:
    """A part of a sensor, such as "velocity A.x", taken apart: what stands before the name, the name, what follows."""
    of, point, component = said.rpartition(".")
    if not point:
        return "", said, ""
    words = of.split(" ")
    for count in range(len(words)):
        name = " ".join(words[count:])
        if names.first(("node", "element"), name):
            before = " ".join(words[:count])
            return before + " " if before else "", name, f".{component}"
    return "", of, f".{component}"


def referred(names: Names, thing: dict[str, Any]) -> dict[str, str | None]:
    """Id of what each reference of a thing means, by the address within the thing; None where nothing is."""
    found = {}
    for address, spaces, written in references(thing):
        name = part_of(names, written)[1] if address.startswith("weights/") else written
        field = address.partition("/")[0]
        known = (names.first if field == "weights" else names.thing)(spaces, name)
        if known == thing["id"] and field == "stage":
            # The node that a block makes itself.
            continue
        found[address] = known
    return found


def with_references(thing: dict[str, Any], names: Names, changed: Callable[[str, str], str | None]) -> dict[str, Any]:
    """A thing whose references are others.

    Args:
        thing: Not changed.
        names: Of the document.
        changed: ``f(id, name)``: the new name of what is referred to, from its id and the name in the reference; None
            to leave it.
    """
    args, own = thing["args"], {}
    for address, spaces, written in references(thing):
        weight = address.startswith("weights/")
        before, name, after = part_of(names, written) if weight else ("", written, "")
        known = (names.first if weight else names.thing)(spaces, name)
        new = changed(known, name) if known else None
        if new is not None and new != name:
            own[address] = f"{before}{new}{after}"
    for address, value in own.items():
        args = replaced(args, address.split("/"), value)
    return thing if args is thing["args"] else {**thing, "args": args}


def replaced(tree: Any, path: list[str], value: Any) -> Any:
    """A tree of dictionaries and lists with another value at a path; the rest is shared.

    Raises:
        KeyError: The path leads through what is neither.
    """
    if not path:
        return value
    head, *rest = path
    if isinstance(tree, dict):
        return {**tree, head: replaced(tree.get(head), rest, value)}
    if not re.fullmatch(r"\d{1,4}", head) or not (tree is None or isinstance(tree, list)):
        raise KeyError(head)
    own, k = list(tree or []), int(head)
    own += [""] * (k + 1 - len(own))
    own[k] = replaced(own[k] if rest and isinstance(own[k], list) else None if rest else own[k], rest, value)
    return own


def renamed_part(name: str, old: str, new: str) -> str:
    """A reference by the name of a thing, or of a part of it, after that has another name."""
    for start in (TURN_OF, FRAME_OF):
        if name.startswith(start) and _without_part(name.removeprefix(start)) == old:
            return start + new + name.removeprefix(start + old)
    if name == old or name.startswith((*(old + part for part in PARTS), f"{old} ")):
        return new + name[len(old) :]
    return name
