"""Which things of a document refer to which, by name, and how a name that changes is followed."""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..model.by_name import FRAME_OF, TURN_OF, TURNS
from .fields import Call, calls

# Parts of a node or an element with names of their own.
PARTS = (".rotation", ".warping", ".internal", *(f".{axis}" for axis in TURNS))
# Kinds of fields that contain names of things, and the namespaces of these names.
SPACES: dict[str, tuple[str, ...]] = {n: (n,) for n in ("node", "element", "section", "material", "damping")}
SPACES |= {"nodes": ("node",), "sections": ("section",), **dict.fromkeys(("of", "weights"), ("node", "element"))}


def call_of(thing: dict[str, Any]) -> Call | None:
    """What a thing calls; None if this version has no such call."""
    return calls().get(thing["call"])


def call_and_name(things: Mapping[str, dict[str, Any]], address: str) -> str:
    """Call and name of the thing at an address, or the address itself if no thing has it."""
    item = things.get(address.partition("/")[0])
    return address if item is None else f"{item['call']} {item.get('name') or ''}".strip()


def references(thing: dict[str, Any]) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """Names that a thing refers to: address within the thing, namespaces, and the name as written there."""
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
            names = [(k, name) for k, name in enumerate(value) if name and isinstance(name, str)]
            yield from ((f"{argument}/{k}", spaces, name) for k, name in names)
        elif value:
            yield argument, spaces, value


def stage_of(thing: dict[str, Any]) -> str | None:
    """Name of the node that a building block carries. The block makes this node if it does not exist."""
    call, stage = call_of(thing), thing["args"].get("stage")
    return stage if call is not None and call.kind == "block" and isinstance(stage, str) and stage else None


class Names:
    """Names of the things of a document, and the thing that each reference means.

    Attributes:
        by_space: Id of the thing with a name, by namespace and name.
        made: Id of the building block that makes a node as its stage, by the name of the node.
    """

    def __init__(self, items: list[dict[str, Any]]):
        self.by_space: dict[str, dict[str, str]] = {}
        self.made: dict[str, str] = {}
        for item in items:
            call = call_of(item)
            if call is None:
                continue
            if call.makes and item.get("name"):
                self.by_space.setdefault(call.makes, {}).setdefault(item["name"], item["id"])
            if stage := stage_of(item):
                self.made.setdefault(stage, item["id"])
        self._blocks = sorted(self.by_space.get("block", {}).items(), key=lambda pair: -len(pair[0]))

    def thing(self, spaces: tuple[str, ...], name: str) -> str | None:
        """Id of the thing that a name such as "A.rotation" or "pivot leaf 1" means; None if none or two match."""
        item_id = self.exactly(spaces, name)
        if item_id or not {"node", "element"} & set(spaces):
            return item_id
        if "node" in spaces and (item_id := self.made.get(name) or self.made.get(_without_part(name))):
            return item_id
        for start in (TURN_OF, FRAME_OF):
            if name.startswith(start) and (item_id := self.exactly(("node",), name.removeprefix(start))):
                return item_id
        return next((id for block, id in self._blocks if name.startswith(f"{block} ")), None)

    def first(self, spaces: tuple[str, ...], name: str) -> str | None:
        """The same in the first namespace with such a name: parts of sensors are nodes first."""
        return next((item_id for space in spaces if (item_id := self.thing((space,), name))), None)

    def exactly(self, spaces: tuple[str, ...], name: str) -> str | None:
        """The same for the name of a thing itself, or of its rotation, its warping or its coordinates."""
        for plain in dict.fromkeys((name, _without_part(name))):
            ids = {self.by_space.get(space, {}).get(plain) for space in spaces} - {None}
            if len(ids) == 1:
                return ids.pop()
        return None

    def unused(self, name: str) -> str:
        """A name of a section, with as many primes behind it as make it new."""
        while name in self.by_space.get("section", {}):
            name += "'"
        return name


def _without_part(name: str) -> str:
    return next((name.removesuffix(part) for part in PARTS if name.endswith(part)), name)


def sensor_part(names: Names, text: str) -> tuple[str, str, str]:
    """A part of a sensor, such as "velocity A.x", as quantity, name and component."""
    prefix, point, component = text.rpartition(".")
    if not point:
        return "", text, ""
    words = prefix.split(" ")
    for count in range(len(words)):
        name = " ".join(words[count:])
        if names.first(("node", "element"), name):
            before = " ".join(words[:count])
            return before + " " if before else "", name, f".{component}"
    return "", prefix, f".{component}"


def dependent(names: Names, things: list[dict[str, Any]], gone: set[str]) -> list[str]:
    """Ids of the things that refer to things with some ids, directly or through others, in order."""
    needs = {item["id"]: set(referred(names, item).values()) for item in things}
    everything = set(gone)
    while along := {id for id, targets in needs.items() if id not in everything and targets & everything}:
        everything |= along
    return [item["id"] for item in things if item["id"] in everything - gone]


def _meant(names: Names, thing: dict[str, Any]) -> Iterator[tuple[str, tuple[str, str, str], str | None]]:
    """References of a thing: address within the thing, the name and the text before and after it, and its id."""
    for address, spaces, written in references(thing):
        is_weight = address.startswith("weights/")
        parts = sensor_part(names, written) if is_weight else ("", written, "")
        yield address, parts, (names.first if is_weight else names.thing)(spaces, parts[1])


def referred(names: Names, thing: dict[str, Any]) -> dict[str, str | None]:
    """Id of the thing that each reference means, by its address within the thing; None if no thing matches."""
    targets = {address: id for address, _, id in _meant(names, thing)}
    # A block makes its stage itself, unless the node exists.
    return {address: id for address, id in targets.items() if (address, id) != ("stage", thing["id"])}


def with_references(thing: dict[str, Any], names: Names, changed: Callable[[str, str], str | None]) -> dict[str, Any]:
    """A thing with other references: ``changed(id, name)`` returns the new name, or None to keep the old one."""
    args = thing["args"]
    for address, (before, name, after), id in _meant(names, thing):
        new = changed(id, name) if id else None
        if new is not None and new != name:
            args = replaced(args, address.split("/"), f"{before}{new}{after}")
    return thing if args is thing["args"] else {**thing, "args": args}


def following(pairs: dict[str, list[tuple[str, str]]]) -> Callable[[str, str], str | None]:
    """The function that renames references, from the pairs of old and new names of each id."""

    def follows(id: str, name: str) -> str | None:
        for old, new in sorted(pairs.get(id, ()), key=lambda pair: -len(pair[0])):
            if (other := renamed_part(name, old, new)) != name:
                return other
        return None

    return follows


def replaced(tree: Any, path: list[str], value: Any) -> Any:
    """A tree of dictionaries and lists with another value at a path; KeyError if the path passes something else."""
    if not path:
        return value
    head, *inner_path = path
    if isinstance(tree, dict):
        return {**tree, head: replaced(tree.get(head), inner_path, value)}
    if not re.fullmatch(r"\d{1,4}", head) or not (tree is None or isinstance(tree, list)):
        raise KeyError(head)
    entries, k = list(tree or []), int(head)
    entries += [""] * (k + 1 - len(entries))
    entries[k] = replaced(entries[k] if not inner_path or isinstance(entries[k], list) else None, inner_path, value)
    return entries


def renamed_part(name: str, old: str, new: str) -> str:
    """A reference to a renamed thing or to a part of it, with the new name."""
    for start in (TURN_OF, FRAME_OF):
        if name.startswith(start) and _without_part(name.removeprefix(start)) == old:
            return start + new + name.removeprefix(start + old)
    if name == old or name.startswith((*(old + part for part in PARTS), f"{old} ")):
        return new + name[len(old) :]
    return name
