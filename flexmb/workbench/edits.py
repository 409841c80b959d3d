"""Edits of a document: add, set, name, rename, delete and order things; title and dimension."""

import difflib
from typing import Any

from ..arguments import short_repr
from ..build.given import name_text
from ..errors import ModelError, printable
from ..spacar.arithmetic import names_in, renamed
from .content import Document, EditError, Report, checked_name, checked_text, checked_value
from .fields import Call, calls
from .references import call_of, dependent, following, renamed_part, replaced, stage_of, with_references

NUMBERS = ("number", "vector", "weights")
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def add(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "add", "thing": {"call", "name"?, "args"}, "before"?: id}``: a thing, with a new name if needed."""
    proposal = op["thing"]
    if not isinstance(proposal, dict) or not isinstance(proposal.get("call"), str):
        raise EditError("", f"The thing is {short_repr(proposal)}. It needs a call and arguments.")
    call = calls().get(proposal["call"])
    if call is None:
        similar = difflib.get_close_matches(proposal["call"], calls(), 1)
        hint = f" Did you mean '{similar[0]}'?" if similar else ""
        raise EditError("", f"There is no call '{printable(proposal['call'])}'.{hint}")
    call_dimension = call.entry["dimension"]
    if call_dimension not in (None, document.dimension):
        raise EditError("", f"{call.name} is for mechanisms in {'the plane' if call_dimension == 2 else 'space'}.")
    id, args, name = str(document.data["next"]), proposal.get("args") or {}, proposal.get("name")
    if not isinstance(args, dict):
        raise EditError("", f"Arguments of {call.name} are given by name.")
    item: dict[str, Any] = {"id": id, "call": call.name}
    if name not in (None, ""):
        item["name"] = free_name(document, call, f"{id}/name", name)
    elif call.makes and call.entry["group"] != "signal":
        item["name"] = new_name(document, call)
    contents = {}
    for key, value in args.items():
        value = checked_value(f"{id}/{key}", value)
        _check_field(call, f"{id}/{key}", key)
        if value not in ("", []):
            contents[key] = value
    item["args"] = contents
    added = insert(document, [item], op.get("before"))
    return added, Report([id], [], f"add {item.get('name') or call.entry['title']}")


def insert(document: Document, things: list[dict[str, Any]], before: Any = None) -> Document:
    """A document with new things at its end or before another thing; their ids follow the ids so far."""
    place = len(document.things) if before is None else document.things.index(document.thing(before))
    things = [*document.things[:place], *things, *document.things[place:]]
    return document.with_things(things, next=document.data["next"] + len(things) - len(document.things))


def new_name(document: Document, call: Call) -> str:
    """A new name: a letter for a node, otherwise the default name with a number."""
    used_names = document.known.by_space.get(str(call.makes), {})
    if call.makes == "node":
        used_names = {**used_names, **document.known.made}
        if letter := next((letter for letter in LETTERS if letter not in used_names), None):
            return letter
    prefix = str(call.entry["name"])
    if prefix not in used_names and call.makes in ("section", "material", "damping", "block"):
        return prefix
    number = len(used_names) + 1
    while f"{prefix} {number}" in used_names:
        number += 1
    return f"{prefix} {number}"


def free_name(document: Document, call: Call, address: str, name: Any, but: str | None = None) -> str:
    """A name that a thing may have: it is a name, and no other thing has it."""
    if not call.makes:
        raise EditError(address, f"{call.entry['title'].capitalize()} takes no name.")
    subject = f"A {call.makes}" if call.makes[0] not in "aeiou" else f"An {call.makes}"
    try:
        name = name_text(subject, name)
    except ModelError as fault:
        raise EditError(address, str(fault)) from None
    if call.makes == "node" and name.endswith((".rotation", ".warping")):
        raise EditError(address, f"'{printable(name)}' is the name of a part of a node. Choose another ending.")
    checked_text(address, name)
    other = document.known.by_space.get(call.makes, {}).get(name)
    if other not in (None, but):
        raise EditError(address, f"{subject} '{printable(name)}' exists already. Give each a different name.")
    return name


def _check_field(call: Call, address: str, key: str) -> None:
    if key not in call.fields:
        known = ", ".join(call.fields) or "nothing"
        raise EditError(address, f"{call.name} takes no '{printable(key)}'. It takes: {known}.")


def set_(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "set", "address": "5/released", "to": text or list}``: a field; an empty text removes its content."""
    address, to = op["address"], op["to"]
    if not isinstance(address, str) or address.count("/") not in (1, 2, 3):
        raise EditError("", f"'{printable(address)}' is no address of a field. An address is such as '5/released'.")
    head, *path = address.split("/")
    if head == "names":
        return _set_name(document, address, path, to)
    item = document.thing(head)
    if path == ["name"]:
        return rename(document, {"id": head, "to": to})
    call = call_of(item)
    if call is not None:
        _check_field(call, address, path[0])
    value = checked_value(address, to, 3 - len(path))
    args = dict(item["args"])
    try:
        args[path[0]] = replaced(args.get(path[0]), path[1:], value)
    except KeyError:
        raise EditError(address, f"'{printable(address)}' is no address of a field. There is no list there.") from None
    if args[path[0]] in ("", []):
        del args[path[0]]
    if call is not None and call.kind == "block" and path == ["stage"] and isinstance(value, str):
        document = _with_stage(document, item, value)
    label = f"{item.get('name') or (call.entry['title'] if call else item['call'])}: {path[0].replace('_', ' ')}"
    return _with(document, {**item, "args": args}), Report([], [], label)


def _with_stage(document: Document, block: dict[str, Any], new: str) -> Document:
    """A document in which references follow the new name of a block's node; references to drawn nodes stay."""
    known, old = document.known, stage_of(block)
    used_names = {**known.by_space.get("node", {}), **known.made}
    if not old or not new or known.thing(("node",), old) != block["id"] or new in used_names:
        return document

    def follows(id: str, name: str) -> str | None:
        return renamed_part(name, old, new) if id == block["id"] and not name.startswith(f"{old} ") else None

    return document.with_things([with_references(item, known, follows) for item in document.things])


def _with(document: Document, item: dict[str, Any]) -> Document:
    """A document in which another thing has the id of this one."""
    return document.with_things([item if other["id"] == item["id"] else other for other in document.things])


def _set_name(document: Document, address: str, path: list[str], to: Any) -> tuple[Document, Report]:
    if len(path) != 2 or path[1] not in ("value", "low", "high"):
        raise EditError(address, f"'{printable(address)}' is no address. A name has value, low and high.")
    if path[0] not in document.names:
        raise EditError(address, f"There is no name '{printable(path[0])}'.")
    entry = {**document.names[path[0]], path[1]: checked_text(address, to)}
    given = {key: text for key, text in entry.items() if key != path[1] or text}
    return name_(document, {"name": path[0], "to": given})


def name_(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "name", "name": "t", "to": {"value", "low"?, "high"?} or None}``: a name set, or removed if unused."""
    name, to = op["name"], op["to"]
    if to is None:
        if name not in document.names:
            raise EditError(f"names/{printable(name)}", f"There is no name '{printable(name)}'.")
        if used := [address for address, text in texts(document) if name in names_in(text)]:
            raise EditError(f"names/{name}", f"Name '{name}' is used: {', '.join(used[:3])}. Replace it there first.")
        remaining = {key: value for key, value in document.names.items() if key != name}
        return document.with_things(document.things, names=remaining), Report([], [], f"delete name {name}")
    entry = checked_name(name, to)
    if not entry["value"].strip():
        raise EditError(f"names/{name}/value", f"Name '{name}' has no value. Give it a number or arithmetic.")
    label = f"{'set' if name in document.names else 'name'} {name}"
    return document.with_things(document.things, names={**document.names, name: entry}), Report([], [], label)


def texts(document: Document) -> list[tuple[str, str]]:
    """All texts that may contain arithmetic, with their addresses."""
    of_names = [(f"names/{name}/{key}", text) for name, entry in document.names.items() for key, text in entry.items()]
    return of_names + [(f"{item['id']}/{path}", text) for item in document.things for path, text in numbers(item)]


def numbers(thing: dict[str, Any]) -> list[tuple[str, str]]:
    """Texts of a thing that are numbers, with their addresses within the thing."""
    call, number_texts = call_of(thing), []
    for key, value in thing["args"].items():
        field = call.fields.get(key) if call else None
        if field is None or field["kind"] not in NUMBERS:
            continue
        if isinstance(value, str):
            number_texts += [(key, value)] if value else []
            continue
        for k, content in enumerate(value):
            weight = field["kind"] == "weights" and isinstance(content, list) and len(content) == 2
            path, text = (f"{key}/{k}/1", content[1]) if weight else (f"{key}/{k}", content)
            number_texts += [(path, text)] if isinstance(text, str) and weight == (field["kind"] == "weights") else []
    return number_texts


def rename(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "rename", "id" or "name", "to"}``: another name for a thing or a number; references follow."""
    to = op["to"]
    if "name" in op:
        return _rename_number(document, op["name"], to)
    item = document.thing(op["id"])
    call, old, id = call_of(item), item.get("name"), item["id"]
    if call is None:
        raise EditError(f"{id}/name", f"This version has no call '{printable(item['call'])}'.")
    if to in (None, "") and call.entry["group"] == "signal":
        unnamed = {key: value for key, value in item.items() if key != "name"}
        return _with(document, unnamed), Report([], [], f"rename {old}")
    new = free_name(document, call, f"{id}/name", to, but=id)
    known = document.known
    if call.makes == "node" and new in known.made:
        raise EditError(f"{id}/name", f"Node '{printable(new)}' exists already. Give each a different name.")
    follows = following({id: [(old, new)]} if old is not None else {})
    # Renamed before its references, so that a block's names of its own parts follow too.
    another = {"id": id, "call": item["call"], "name": new, "args": item["args"]}
    items = [with_references(another if other is item else other, known, follows) for other in document.things]
    return document.with_things(items), Report([], [], f"rename {old or call.entry['title']} to {new}")


def _rename_number(document: Document, old: Any, new: Any) -> tuple[Document, Report]:
    if old not in document.names:
        raise EditError(f"names/{printable(old)}", f"There is no name '{printable(old)}'.")
    if new in document.names and new != old:
        raise EditError(f"names/{old}", f"Name '{new}' exists already. Give each number a different name.")
    names = {}
    for name, entry in document.names.items():
        follows = {key: renamed(text, old, str(new)) for key, text in entry.items()}
        key = new if name == old else name
        names[key] = checked_name(key, follows)
    items = []
    for item in document.things:
        args = item["args"]
        for path, text in numbers(item):
            if (other := renamed(text, old, new)) != text:
                args = replaced(args, path.split("/"), other)
        items.append(item if args is item["args"] else {**item, "args": args})
    return document.with_things(items, names=names), Report([], [], f"rename {old} to {new}")


def delete(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "delete", "ids": [..]}``: deletes things and everything that refers to them."""
    ids = op["ids"]
    if not isinstance(ids, list | tuple):
        raise EditError("", f"The ids are {short_repr(ids)}. They must be a list.")
    chosen = {document.thing(id)["id"] for id in ids}
    also = dependent(document.known, document.things, chosen)
    remaining = [item for item in document.things if item["id"] not in chosen.union(also)]
    names = [document.thing(id).get("name") or document.thing(id)["call"] for id in ids]
    return document.with_things(remaining), Report([], also, f"delete {', '.join(names[:3])}{' ..' * (len(names) > 3)}")


def order(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "order", "id", "before": id or None}``: moves a thing before another, or to the end."""
    item = document.thing(op["id"])
    others = [other for other in document.things if other is not item]
    before = op.get("before")
    if before == item["id"]:
        return document, Report([], [], "order")
    place = len(others) if before is None else others.index(document.thing(before))
    return document.with_things([*others[:place], item, *others[place:]]), Report([], [], "order")


def title(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "title", "to"}``: another title."""
    return document.with_things(document.things, title=checked_text("title", op["to"])), Report([], [], "title")


def dimension(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "dimension", "to": 2 or 3}``: plane or space, if the document has no nodes yet."""
    to = op["to"]
    if to not in (2, 3) or isinstance(to, bool | float):
        raise EditError("dimension", f"The dimension is {short_repr(to)}. It must be 2 or 3.")
    calls_made = map(call_of, document.things)
    if to != document.dimension and any(call is None or call.kind not in ("record", "constant") for call in calls_made):
        raise EditError("dimension", "Nodes are drawn already. Delete them before you change between plane and space.")
    return document.with_things(document.things, dimension=int(to)), Report([], [], "plane" if to == 2 else "space")


OPERATIONS = {
    "add": add,
    "set": set_,
    "name": name_,
    "rename": rename,
    "delete": delete,
    "order": order,
    "title": title,
    "dimension": dimension,
}
