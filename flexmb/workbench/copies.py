"""Edits that make new things from others: copy and repeat, join nodes, split an element, take a block apart."""

import functools
import re
from collections.abc import Callable
from typing import Any

from ..arguments import as_whole
from ..errors import printable
from .building import build
from .calls_of import Calls
from .content import Document, EditError, Report, checked_value
from .edits import LETTERS, insert
from .fields import calls
from .formulas import number_text
from .references import Names, call_of, dependent, following, referred, replaced, stage_of, with_references
from .values import plus, text_between, text_product

# A drawing needs no more copies at once.
MOST_COPIES = 1000


def copy(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "copy", "ids", "by": [texts], "count"?: 1}``: copies with their nodes, each moved further."""
    by, count = checked_value("", op["by"]), as_whole(op.get("count", 1))
    if not isinstance(by, list) or len(by) != document.dimension:
        raise EditError("", f"Give the displacement of copies as {document.dimension} numbers.")
    if count is None or not 1 <= count <= MOST_COPIES:
        given = printable(op.get("count"))
        raise EditError("", f"The number of copies is {given}. It must be from 1 to {MOST_COPIES}.")
    chosen, ids = selected(document, op["ids"]), []
    for k in range(1, count + 1):
        shifted = functools.partial(_shifted, [text_product(str(k), text) for text in by])
        document, new = cloned(document, chosen, shifted)
        ids += new
    return document, Report(ids, [], "copy")


def _shifted(distance: list[str], thing: dict[str, Any]) -> dict[str, Any]:
    return with_position(thing, lambda position: [plus(a, b) for a, b in zip(position, distance, strict=False)])


def with_position(thing: dict[str, Any], to: Callable[[list[str]], list[str]]) -> dict[str, Any]:
    """A thing with another position, if it is a node, or a block with a place."""
    call = call_of(thing)
    key = "position" if thing["call"] == "node" else "at" if call is not None and call.kind == "block" else ""
    position = thing["args"].get(key)
    return {**thing, "args": {**thing["args"], key: to(position)}} if isinstance(position, list) else thing


def selected(document: Document, ids: Any) -> list[dict[str, Any]]:
    """Things with some ids, with the nodes of elements and blocks among them, in the order of the document."""
    if not isinstance(ids, list | tuple) or not ids:
        raise EditError("", "Nothing is selected. Give a list of ids.")
    chosen = {document.thing(id)["id"] for id in ids}
    for id in list(chosen):
        call = call_of(document.by_id[id])
        if call is None or call.kind not in ("element", "block"):
            continue
        for address, other in referred(document.known, document.by_id[id]).items():
            if other is not None and address.partition("/")[0] in ("nodes", "base", "stage"):
                other_call = call_of(document.by_id[other])
                chosen |= {other} if other_call is not None and other_call.makes == "node" else set()
    shared = ("section", "material", "damping")
    selection = []
    for item in document.things:
        call = call_of(item)
        if item["id"] in chosen and call is not None and call.makes not in shared and item["call"] != "gravity":
            selection.append(item)
    if not selection:
        raise EditError("", "Sections, materials and gravity are shared. Select something else to copy.")
    return selection


def cloned(
    document: Document, chosen: list[dict[str, Any]], changed: Callable[[dict[str, Any]], dict[str, Any]]
) -> tuple[Document, list[str]]:
    """A document with copies of things at its end, which refer to each other like their originals."""
    known = document.known
    used_names = {space: set(names) for space, names in known.by_space.items()}
    used_names["node"] = used_names.get("node", set()) | set(known.made)
    pairs: dict[str, list[tuple[str, str]]] = {}
    for item in chosen:
        call, names = call_of(item), pairs.setdefault(item["id"], [])
        if call is not None and call.makes and item.get("name"):
            names.append((item["name"], _next_name(item["name"], used_names.setdefault(call.makes, set()))))
        stage = stage_of(item)
        if stage and known.made.get(stage) == item["id"] and not known.exactly(("node",), stage):
            names.append((stage, _next_name(stage, used_names["node"])))
    follows = following(pairs)
    new = []
    for id, item in enumerate(chosen, document.data["next"]):
        named = {"name": dict(pairs[item["id"]]).get(item["name"], item["name"])} if item.get("name") else {}
        args = with_references(changed(item), known, follows)["args"]
        new.append({"id": str(id), "call": item["call"], **named, "args": args})
    return insert(document, new), [item["id"] for item in new]


def _next_name(name: str, used_names: set[str]) -> str:
    """The next free letter or number after a name; it is taken from then on."""
    if name in LETTERS and (free := [letter for letter in LETTERS if letter not in used_names]):
        successor = next((letter for letter in free if letter > name), free[0])
    else:
        start, digits = re.fullmatch(r"(.*?)(\d{0,9})", name, re.DOTALL).groups()  # pyright: ignore
        start, number = (start, int(digits)) if digits else (f"{name} ", 1)
        while (successor := f"{start}{number + 1}") in used_names:
            number += 1
    used_names.add(successor)
    return successor


def join(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "join", "from": node, "into": node}``: one node takes the place of another; elements between them go."""
    known = document.known
    first, into = (_node(document, op[key]) for key in ("from", "into"))
    id = known.thing(("node",), first)
    if first == into:
        raise EditError("", f"Node '{printable(first)}' cannot be joined to itself.")
    made_by_block = id is not None and call_of(document.by_id[id]).makes != "node"  # pyright: ignore
    others = [item for item in document.things if made_by_block or item["id"] != id]
    follows = following({id: [(first, into)]} if id else {})
    items = [with_references(item, known, follows) for item in others]
    lost = set()
    for before, after in zip(others, items, strict=True):
        call = call_of(after)
        values = [after["args"].get(key) for key in ("nodes", "base", "stage")]
        names = [name for value in values for name in (value if isinstance(value, list) else [value])]
        ends = [name for name in names if name and isinstance(name, str)]
        twice = call is not None and call.kind in ("element", "block") and len(set(ends)) < len(ends)
        if after is not before and (twice or _is_repeated(after, items)):
            lost.add(after["id"])
    lost.update(dependent(Names(items), items, lost))
    also = [item["id"] for item in items if item["id"] in lost]
    remaining = [item for item in items if item["id"] not in lost]
    return document.with_things(remaining), Report([], also, f"join {first} into {into}")


def _is_repeated(item: dict[str, Any], items: list[dict[str, Any]]) -> bool:
    """Whether another thing makes the same call, which may be made only once."""
    same = [other for other in items if (other["call"], other["args"]) == (item["call"], item["args"])]
    return item["call"] in ("dof", "fix") and len(same) > 1


def _node(document: Document, reference: Any) -> str:
    """Name of a node, from its name or its id."""
    if isinstance(reference, str) and document.known.thing(("node",), reference):
        return reference
    item = document.by_id.get(reference) if isinstance(reference, str) else None
    if item is not None and item["call"] in ("node", "rotation", "warping"):
        return item["name"]
    raise EditError("", f"There is no node '{printable(reference)}'.")


def split_element(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "split", "element", "at": "0.5"}``: an element becomes two, with a node between them."""
    item = _element(document, op["element"])
    id, name = item["id"], printable(item["name"])
    place = checked_value("", op.get("at", "0.5"))
    nodes = item["args"].get("nodes")
    positions = {n: t["args"].get("position") for t in document.things if t["call"] == "node" and (n := t.get("name"))}
    if not isinstance(nodes, list) or len(nodes) != 2 or any(node not in positions for node in nodes):
        raise EditError(f"{id}/nodes", f"'{name}' cannot be split: its ends are not two drawn nodes.")
    if "curvature" in item["args"]:
        raise EditError(f"{id}/curvature", f"'{name}' cannot be split: it is an arc.")
    if at := next((key for key in ("skew", "clamp") if key in item["args"]), None):
        raise EditError(f"{id}/{at}", f"'{name}' cannot be split: its ends are cut at an angle or elastic.")
    record = build(document).records.get(document.known.thing(("section",), item["args"].get("section", "")) or "")
    if record is not None and record.varies:
        raise EditError(f"{id}/section", f"'{name}' cannot be split: its section varies along it.")
    about = [other for other in document.things if id in referred(document.known, other).values()]
    for other in about:
        # Deformations of the whole have no counterpart in the halves.
        if other["call"] not in ("temperature", "release"):
            message = f"'{name}' cannot be split: '{printable(other['call'])}' belongs to the whole. Delete it first."
            raise EditError(other["id"], message)
    number = document.data["next"]
    used_names = {space: set(names) for space, names in document.known.by_space.items()}
    middle = _next_name(nodes[0], used_names.get("node", set()) | set(document.known.made))
    second = _next_name(item["name"], used_names.get("element", set()))
    ends = [positions[node] or [] for node in nodes]
    at = [text_between(a, b, place) for a, b in zip(*ends, strict=False)]
    new = [
        {"id": str(number), "call": "node", "name": middle, "args": {"position": at}},
        {**item, "args": {**item["args"], "nodes": [nodes[0], middle]}},
        {**item, "id": str(number + 1), "name": second, "args": {**item["args"], "nodes": [middle, nodes[1]]}},
    ]
    items: list[dict[str, Any]] = []
    ids = [str(number), str(number + 1)]
    for other in document.things:
        if other is item:
            items += new
        elif other not in about:
            items.append(other)
        else:
            first, last = _halved(other, place)
            items += [first, {**last, "id": str(number + len(ids)), "args": {**last["args"], "element": second}}]
            ids.append(str(number + len(ids)))
    return document.with_things(items, next=number + len(ids)), Report(ids, [], f"split {item['name']}")


def _halved(item: dict[str, Any], place: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """A thing about an element as two things about its halves, with their parts of a varying temperature."""
    change = item["args"].get("change")
    if not isinstance(change, list) or len(change) != 2:
        return item, item
    middle = text_between(change[0], change[1], place)
    first, last = ([change[0], middle], [middle, change[1]])
    return tuple({**item, "args": replaced(item["args"], ["change"], half)} for half in (first, last))  # pyright: ignore


def _element(document: Document, reference: Any) -> dict[str, Any]:
    """The element with an id or a name."""
    item = document.by_id.get(reference) if isinstance(reference, str) else None
    if item is None and isinstance(reference, str):
        item = document.by_id.get(document.known.by_space.get("element", {}).get(reference, ""))
    if item is None or (call := call_of(item)) is None or call.kind != "element":
        raise EditError("", f"There is no element '{printable(reference)}'.")
    return item


def explode(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "explode", "id"}``: nodes and elements of a block become things, with the same names."""
    item = document.thing(op["id"])
    call, id = call_of(item), item["id"]
    if call is None or call.kind != "block":
        raise EditError(id, f"'{printable(item.get('name', item['call']))}' is no building block.")
    built = build(document)
    if id not in built.made:
        why = next((p["message"] for p in built.problems if p["address"].startswith(f"{id}/")), "it cannot be built.")
        raise EditError(id, f"Block '{printable(item['name'])}' cannot be taken apart: {why}")
    records = [(record, document.by_id[record_id]["name"]) for record_id, record in built.records.items()]
    sections: list[dict[str, Any]] = []

    def name_of(record: Any) -> str:
        """Name of a section in the document, or of the section that the block makes of its arguments."""
        known = next((name for other, name in records if other is record), None)
        if known is None and not sections:
            sections.append(_section(document, item))
        return known or sections[0]["name"]

    parts = Calls(built.builder, built.made[id], name_of)
    new = [*sections, *parts.filled(list(map(number_text, parts.numbers)))]
    for part in new[len(sections) :]:
        space = "node" if part["call"] == "node" else "element"
        if part["name"] in document.known.by_space.get(space, {}):
            raise EditError(id, f"There is {space} '{printable(part['name'])}' already. Rename it first.")
    first, place = document.data["next"], document.things.index(item)
    new = [{"id": str(first + k), **part} for k, part in enumerate(new)]
    items = [*document.things[:place], *new, *document.things[place + 1 :]]
    report = Report([part["id"] for part in new], [], f"explode {item['name']}")
    return document.with_things(items, next=first + len(new)), report


def _section(document: Document, block: dict[str, Any]) -> dict[str, Any]:
    """The section that a block makes: its section with shear, or the notch of its sizes."""
    if name := block["args"].get("section"):
        section = document.by_id[document.known.by_space["section"][name]]
        call, args, name = section["call"], replaced(section["args"], ["shear"], "true"), f"{name} with shear"
    else:
        # With an element of its own a hinge is a plain beam.
        call = "notch_circular" if block["args"].get("element") else "hinge_circular"
        args = {key: value for key, value in block["args"].items() if key in calls()[call].fields}
        name = f"{block['name']} notch"
    return {"call": call, "name": document.known.unused(name), "args": args}


OPERATIONS = {"copy": copy, "join": join, "split": split_element, "explode": explode}
