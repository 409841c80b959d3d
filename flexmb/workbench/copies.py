"""Edits that make new things of old ones: copy and repeat, join two nodes, split an element."""

import re
from collections.abc import Callable
from typing import Any

from ..arguments import as_whole
from ..errors import clean
from .building import build
from .content import Document, EditError, Report, checked_value
from .edits import insert
from .references import Names, call_of, referred, renamed_part, replaced, stage_of, with_references
from .sums import between, plus, times

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
# More copies than this at once are no drawing.
MOST_COPIES = 1000


def copy(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "copy", "ids", "by": [texts], "count"?: 1}``: copies, each moved on by so much.

    Elements and blocks take their nodes along; sections and materials are shared. What acts on the whole mechanism is
    not copied.
    """
    by, count = checked_value("", op["by"]), as_whole(op.get("count", 1))
    if not isinstance(by, list) or len(by) != document.dimension:
        raise EditError("", f"Copies are moved by {document.dimension} numbers.")
    if count is None or not 1 <= count <= MOST_COPIES:
        raise EditError("", f"The number of copies is from 1 to {MOST_COPIES}, not {clean(op.get('count'))}.")
    chosen, ids = selected(document, op["ids"]), []
    for k in range(1, count + 1):
        own = [times(str(k), one) for one in by]
        document, new = cloned(document, chosen, lambda thing, own=own: moved(thing, lambda at: _moved_by(at, own)))
        ids += new
    return document, Report(ids, [], "copy")


def _moved_by(position: list[str], by: list[str]) -> list[str]:
    return [plus(a, b) for a, b in zip(position, by, strict=False)]


def moved(thing: dict[str, Any], to: Callable[[list[str]], list[str]]) -> dict[str, Any]:
    """A thing whose position is another, if it has one: that of a node, or that of a block where it is given."""
    call = call_of(thing)
    key = "position" if thing["call"] == "node" else "at" if call is not None and call.kind == "block" else None
    own = thing["args"].get(key) if key else None
    if not isinstance(own, list):
        return thing
    return {**thing, "args": {**thing["args"], key: to(own)}}


def selected(document: Document, ids: Any) -> list[dict[str, Any]]:
    """Things with these ids, and the nodes that elements and blocks among them join, in the order of the document."""
    if not isinstance(ids, list | tuple) or not ids:
        raise EditError("", "Say which things: ids is a list that is not empty.")
    chosen = {document.thing(id)["id"] for id in ids}
    for id in list(chosen):
        call = call_of(document.by_id[id])
        if call is None or call.kind not in ("element", "block"):
            continue
        for address, other in referred(document.known, document.by_id[id]).items():
            if other is not None and address.partition("/")[0] in ("nodes", "base", "stage"):
                of = call_of(document.by_id[other])
                chosen |= {other} if of is not None and of.makes == "node" else set()
    shared = ("section", "material", "damping")
    found = []
    for thing in document.things:
        call = call_of(thing)
        if thing["id"] in chosen and call is not None and call.makes not in shared and thing["call"] != "gravity":
            found.append(thing)
    if not found:
        raise EditError("", "Nothing of this can be copied: sections, materials and gravity are shared.")
    return found


def cloned(
    document: Document,
    chosen: list[dict[str, Any]],
    changed: Callable[[dict[str, Any]], dict[str, Any]],
    shared: dict[str, str] | None = None,
) -> tuple[Document, list[str]]:
    """A document with copies of things at its end, which refer to each other as their originals do."""
    known, shared = document.known, shared or {}
    taken = {space: set(names) for space, names in known.by_space.items()}
    taken["node"] = taken.get("node", set()) | set(known.made)
    pairs: dict[str, list[tuple[str, str]]] = {}
    for one, other in shared.items():
        pairs[one] = [(document.by_id[one]["name"], document.by_id[other]["name"])]
    for thing in chosen:
        call = call_of(thing)
        if thing["id"] in shared or call is None:
            continue
        own = pairs.setdefault(thing["id"], [])
        if call.makes and thing.get("name"):
            own.append((thing["name"], _next_name(thing["name"], taken.setdefault(call.makes, set()))))
        stage = stage_of(thing)
        if stage and known.made.get(stage) == thing["id"] and not known.exactly(("node",), stage):
            own.append((stage, _next_name(stage, taken["node"])))
    follows = following(pairs)
    new, number = [], document.data["next"]
    for thing in chosen:
        if thing["id"] in shared:
            continue
        made = with_references(changed(thing), known, follows)
        names = dict(pairs[thing["id"]])
        own = {"id": str(number), "call": thing["call"]}
        if thing.get("name"):
            own["name"] = names.get(thing["name"], thing["name"])
        new.append({**own, "args": made["args"]})
        number += 1
    return insert(document, new), [thing["id"] for thing in new]


def following(pairs: dict[str, list[tuple[str, str]]]) -> Callable[[str, str], str | None]:
    """How references follow names that change: of each id, what was called so and is called otherwise."""

    def follows(id: str, name: str) -> str | None:
        for old, new in sorted(pairs.get(id, ()), key=lambda pair: -len(pair[0])):
            if (other := renamed_part(name, old, new)) != name:
                return other
        return None

    return follows


def _next_name(name: str, taken: set[str]) -> str:
    """A name after another one, which is then taken: the next letter or number that is free."""
    if name in LETTERS and (free := [one for one in LETTERS if one not in taken]):
        found = next((one for one in free if one > name), free[0])
    else:
        start, digits = re.fullmatch(r"(.*?)(\d{0,9})", name, re.DOTALL).groups()  # pyright: ignore
        start, number = (start, int(digits)) if digits else (f"{name} ", 1)
        while (found := f"{start}{number + 1}") in taken:
            number += 1
    taken.add(found)
    return found


def join(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "join", "from": node, "into": node}``: what one node has goes to the other, and the node goes.

    Elements between the two go too, and what refers to these.
    """
    known = document.known
    first, into = (_node(document, op[key]) for key in ("from", "into"))
    id = known.thing(("node",), first)
    if first == into:
        raise EditError("", f"Node '{clean(first)}' cannot be joined to itself.")
    made_by_block = id is not None and call_of(document.by_id[id]).makes != "node"  # pyright: ignore
    things = []
    for thing in document.things:
        if thing["id"] == id and not made_by_block:
            continue
        things.append(
            with_references(thing, known, lambda of, name: renamed_part(name, first, into) if of == id else None)
        )
    also, lost = [], set()
    for before, after in zip([t for t in document.things if made_by_block or t["id"] != id], things, strict=True):
        call = call_of(after)
        ends = [one for key in ("nodes", "base", "stage") for one in _texts_of(after["args"].get(key))]
        twice = call is not None and call.kind in ("element", "block") and len(set(ends)) < len(ends)
        if after is not before and (twice or _is_there(after, things)):
            lost.add(after["id"])
    names = Names(things)
    needs = {thing["id"]: set(referred(names, thing).values()) for thing in things}
    while along := [one for one, of in needs.items() if one not in lost and of & lost]:
        lost |= set(along)
    also = [thing["id"] for thing in things if thing["id"] in lost]
    kept = [thing for thing in things if thing["id"] not in lost]
    return document.with_things(kept), Report([], also, f"join {first} into {into}")


def _texts_of(value: Any) -> list[str]:
    return [one for one in (value if isinstance(value, list) else [value]) if one and isinstance(one, str)]


def _is_there(thing: dict[str, Any], things: list[dict[str, Any]]) -> bool:
    """Whether another thing names or holds the same already, which may be done only once."""
    if thing["call"] not in ("dof", "fix"):
        return False
    return any(one is not thing and (one["call"], one["args"]) == (thing["call"], thing["args"]) for one in things)


def _node(document: Document, given: Any) -> str:
    """Name of a node that is given by its name or its id."""
    if isinstance(given, str) and document.known.thing(("node",), given):
        return given
    thing = document.by_id.get(given) if isinstance(given, str) else None
    if thing is not None and thing["call"] in ("node", "rotation", "warping"):
        return thing["name"]
    raise EditError("", f"There is no node '{clean(given)}'.")


def split(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "split", "element", "at": "0.5"}``: an element becomes two, with a node between them.

    The first keeps its name. What is said of the deformations of the element has no counterpart, and must go first;
    its temperature and what it releases hold for both.
    """
    thing = _element(document, op["element"])
    id = thing["id"]
    place = checked_value("", op.get("at", "0.5"))
    nodes = thing["args"].get("nodes")
    positions = {n: t["args"].get("position") for t in document.things if t["call"] == "node" and (n := t.get("name"))}
    if not isinstance(nodes, list) or len(nodes) != 2 or any(node not in positions for node in nodes):
        raise EditError(
            f"{id}/nodes", f"'{clean(thing['name'])}' cannot be split: only between two drawn nodes it can."
        )
    if "curvature" in thing["args"]:
        raise EditError(f"{id}/curvature", f"'{clean(thing['name'])}' is an arc, and cannot be split.")
    record = build(document).records.get(document.known.thing(("section",), thing["args"].get("section", "")) or "")
    if record is not None and record.varies:
        raise EditError(
            f"{id}/section", f"The section of '{clean(thing['name'])}' varies along it: it cannot be split."
        )
    own = [one for one in document.things if id in referred(document.known, one).values()]
    for one in own:
        if one["call"] not in ("temperature", "release"):
            raise EditError(
                one["id"], f"'{clean(one['call'])}' is of the whole '{clean(thing['name'])}': delete it first."
            )
    number = document.data["next"]
    taken = {space: set(names) for space, names in document.known.by_space.items()}
    middle = _next_name(nodes[0], taken.get("node", set()) | set(document.known.made))
    second = _next_name(thing["name"], taken.get("element", set()))
    ends = [positions[node] or [] for node in nodes]
    at = [between(a, b, place) for a, b in zip(*ends, strict=False)]
    new = [
        {"id": str(number), "call": "node", "name": middle, "args": {"position": at}},
        {**thing, "args": {**thing["args"], "nodes": [nodes[0], middle]}},
        {
            "id": str(number + 1),
            "call": thing["call"],
            "name": second,
            "args": {**thing["args"], "nodes": [middle, nodes[1]]},
        },
    ]
    things: list[dict[str, Any]] = []
    ids = [str(number), str(number + 1)]
    for one in document.things:
        if one is thing:
            things += new
            continue
        if one not in own:
            things.append(one)
            continue
        first, last = _of_halves(one, place)
        things += [first, {**last, "id": str(number + len(ids)), "args": {**last["args"], "element": second}}]
        ids.append(str(number + len(ids)))
    return document.with_things(things, next=number + len(ids)), Report(ids, [], f"split {thing['name']}")


def _of_halves(thing: dict[str, Any], place: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """What is said of an element as it is said of its two parts: a temperature that differs between its ends."""
    change = thing["args"].get("change")
    if not isinstance(change, list) or len(change) != 2:
        return thing, thing
    middle = between(change[0], change[1], place)

    def with_change(own: list[str]) -> dict[str, Any]:
        return {**thing, "args": replaced(thing["args"], ["change"], own)}

    return with_change([change[0], middle]), with_change([middle, change[1]])


def _element(document: Document, given: Any) -> dict[str, Any]:
    """An element that is given by its id or its name."""
    thing = document.by_id.get(given) if isinstance(given, str) else None
    if thing is None and isinstance(given, str):
        thing = document.by_id.get(document.known.by_space.get("element", {}).get(given, ""))
    if thing is None or (call := call_of(thing)) is None or call.kind != "element":
        raise EditError("", f"There is no element '{clean(given)}'.")
    return thing


OPERATIONS = {"copy": copy, "join": join, "split": split}
