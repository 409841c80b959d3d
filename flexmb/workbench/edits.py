"""Edits of a document: add, set, name, rename, delete and order things; title and dimension."""

import difflib
from typing import Any

from ..build.given import named
from ..errors import ModelError, clean
from ..spacar.arithmetic import names_in, renamed
from .content import Document, EditError, Report, checked_name, checked_text, checked_value
from .fields import Call, calls
from .references import call_of, referred, renamed_part, replaced, stage_of, with_references

# Kinds of fields that hold numbers.
NUMBERS = ("number", "vector", "weights")


def add(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "add", "thing": {"call", "name"?, "args"}, "before"?: id}``: a thing; unnamed ones get a name."""
    given = op["thing"]
    if not isinstance(given, dict) or not isinstance(given.get("call"), str):
        raise EditError("", "A thing that is added has a call and arguments.")
    call = calls().get(given["call"])
    if call is None:
        near = difflib.get_close_matches(given["call"], calls(), 1)
        hint = f" Did you mean '{near[0]}'?" if near else ""
        raise EditError("", f"There is no call '{clean(given['call'])}'.{hint}")
    wanted = call.entry["dimension"]
    if wanted not in (None, document.dimension):
        raise EditError("", f"{call.name} is for mechanisms in {'the plane' if wanted == 2 else 'space'}.")
    id = str(document.data["next"])
    args = given.get("args") or {}
    if not isinstance(args, dict):
        raise EditError("", f"Arguments of {call.name} are given by name.")
    thing: dict[str, Any] = {"id": id, "call": call.name}
    name = given.get("name")
    if name not in (None, ""):
        thing["name"] = free_name(document, call, f"{id}/name", name)
    elif call.makes and call.entry["group"] != "signal":
        thing["name"] = new_name(document, call)
    own = {}
    for key, value in args.items():
        value = checked_value(f"{id}/{key}", value)
        _check_field(call, f"{id}/{key}", key)
        if value not in ("", []):
            own[key] = value
    thing["args"] = own
    made = insert(document, [thing], op.get("before"))
    return made, Report([id], [], f"add {thing.get('name') or call.entry['title']}")


def insert(document: Document, things: list[dict[str, Any]], before: Any = None) -> Document:
    """A document with new things, at its end or before another thing; their ids are those that come next."""
    all = list(document.things)
    place = len(all) if before is None else all.index(document.thing(before))
    return document.with_things([*all[:place], *things, *all[place:]], next=document.data["next"] + len(things))


def new_name(document: Document, call: Call) -> str:
    """A name that no other thing has: nodes are A to Z, and all things the default name with a number."""
    taken = document.known.by_space.get(str(call.makes), {})
    if call.makes == "node":
        taken = {**taken, **document.known.made}
        if letter := next((one for one in "ABCDEFGHIJKLMNOPQRSTUVWXYZ" if one not in taken), None):
            return letter
    prefix = str(call.entry["name"])
    if prefix not in taken and call.makes in ("section", "material", "damping", "block"):
        return prefix
    number = len(taken) + 1
    while f"{prefix} {number}" in taken:
        number += 1
    return f"{prefix} {number}"


def free_name(document: Document, call: Call, address: str, name: Any, but: str | None = None) -> str:
    """A name that a thing may bear.

    Raises:
        EditError: It is no name, or another thing has it.
    """
    if not call.makes:
        raise EditError(address, f"{call.entry['title'].capitalize()} takes no name.")
    what = f"A {call.makes}" if call.makes[0] not in "aeiou" else f"An {call.makes}"
    try:
        name = named(what, name)
    except ModelError as fault:
        raise EditError(address, str(fault)) from None
    if call.makes == "node" and name.endswith((".rotation", ".warping")):
        raise EditError(address, f"'{clean(name)}' would be taken for a part of a node: it ends as such a part does.")
    checked_text(address, name)
    other = document.known.by_space.get(call.makes, {}).get(name)
    if other not in (None, but):
        raise EditError(address, f"There is {what.lower()} '{clean(name)}' already. Give each a name of its own.")
    return name


def _check_field(call: Call, address: str, key: str) -> None:
    if key not in call.fields:
        known = ", ".join(call.fields) or "nothing"
        raise EditError(address, f"{call.name} takes no '{clean(key)}'. It takes: {known}.")


def set_(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "set", "address": "5/released", "to": text or list}``: a field; an empty one is not given."""
    address, to = op["address"], op["to"]
    if not isinstance(address, str) or address.count("/") not in (1, 2, 3):
        raise EditError("", f"'{clean(address)}' is no address of a field, such as '5/released'.")
    head, *path = address.split("/")
    if head == "names":
        return _set_name(document, address, path, to)
    thing = document.thing(head)
    if path == ["name"]:
        return rename(document, {"id": head, "to": to})
    call = call_of(thing)
    if call is not None:
        _check_field(call, address, path[0])
    value = checked_value(address, to, 3 - len(path))
    own = dict(thing["args"])
    try:
        own[path[0]] = replaced(own.get(path[0]), path[1:], value)
    except KeyError:
        raise EditError(address, f"'{clean(address)}' is no address of a field: it holds no list there.") from None
    if own[path[0]] in ("", []):
        del own[path[0]]
    if call is not None and call.kind == "block" and path == ["stage"] and isinstance(value, str):
        document = _with_stage(document, thing, value)
    said = f"{thing.get('name') or (call.entry['title'] if call else thing['call'])}: {path[0].replace('_', ' ')}"
    return _with(document, {**thing, "args": own}), Report([], [], said)


def _with_stage(document: Document, block: dict[str, Any], new: str) -> Document:
    """A document in which references to the node that a block makes follow its name; those to drawn nodes stay."""
    known, old = document.known, stage_of(block)
    taken = {**known.by_space.get("node", {}), **known.made}
    if not old or not new or known.thing(("node",), old) != block["id"] or new in taken:
        return document

    def follows(id: str, name: str) -> str | None:
        return renamed_part(name, old, new) if id == block["id"] and not name.startswith(f"{old} ") else None

    return document.with_things([with_references(thing, known, follows) for thing in document.things])


def _with(document: Document, *things: dict[str, Any]) -> Document:
    """A document in which things are others of the same ids."""
    new = {thing["id"]: thing for thing in things}
    return document.with_things([new.get(thing["id"], thing) for thing in document.things])


def _set_name(document: Document, address: str, path: list[str], to: Any) -> tuple[Document, Report]:
    if len(path) != 2 or path[1] not in ("value", "low", "high"):
        raise EditError(address, f"'{clean(address)}' is no address: a name has value, low and high.")
    own = document.names.get(path[0])
    if own is None:
        raise EditError(address, f"There is no name '{clean(path[0])}'.")
    text = checked_text(address, to)
    kept = {key: value for key, value in own.items() if key != path[1] or text}
    return name_(document, {"name": path[0], "to": {**kept, **({path[1]: text} if text else {})}})


def name_(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "name", "name": "t", "to": {"value", "low"?, "high"?} or None}``: a name of a number, made or changed.

    What is used cannot go.
    """
    name, to = op["name"], op["to"]
    if to is None:
        if name not in document.names:
            raise EditError(f"names/{clean(name)}", f"There is no name '{clean(name)}'.")
        if used := [address for address, text in texts(document) if name in names_in(text)]:
            raise EditError(f"names/{name}", f"Name '{name}' is used: {', '.join(used[:3])}. Replace it there first.")
        kept = {key: value for key, value in document.names.items() if key != name}
        return document.with_things(document.things, names=kept), Report([], [], f"delete name {name}")
    own = checked_name(name, to)
    if not own["value"].strip():
        raise EditError(f"names/{name}/value", f"Name '{name}' needs a value.")
    new = name not in document.names
    names = {**document.names, name: own}
    return document.with_things(document.things, names=names), Report([], [], f"{'name' if new else 'set'} {name}")


def texts(document: Document) -> list[tuple[str, str]]:
    """All texts that may be arithmetic, by their addresses."""
    found = [(f"names/{name}/{key}", text) for name, own in document.names.items() for key, text in own.items()]
    for thing in document.things:
        found += [(f"{thing['id']}/{path}", text) for path, text in numbers(thing)]
    return found


def numbers(thing: dict[str, Any]) -> list[tuple[str, str]]:
    """Texts of a thing that are numbers, by the address within the thing."""
    call, found = call_of(thing), []
    for key, value in thing["args"].items():
        field = call.fields.get(key) if call else None
        if field is None or field["kind"] not in NUMBERS:
            continue
        if isinstance(value, str):
            found += [(key, value)] if value else []
            continue
        for k, one in enumerate(value):
            weight = field["kind"] == "weights" and isinstance(one, list) and len(one) == 2
            path, one = (f"{key}/{k}/1", one[1]) if weight else (f"{key}/{k}", one)
            found += [(path, one)] if isinstance(one, str) and weight == (field["kind"] == "weights") else []
    return found


def rename(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "rename", "id" or "name", "to"}``: a thing or a name of a number; what refers to it follows."""
    to = op["to"]
    if "name" in op:
        return _rename_number(document, op["name"], to)
    thing = document.thing(op["id"])
    call, old, id = call_of(thing), thing.get("name"), thing["id"]
    if call is None:
        raise EditError(f"{id}/name", f"'{clean(thing['call'])}' is no call of this version.")
    if to in (None, "") and call.entry["group"] == "signal":
        kept = {key: value for key, value in thing.items() if key != "name"}
        return _with(document, kept), Report([], [], f"rename {old}")
    new = free_name(document, call, f"{id}/name", to, but=id)
    known = document.known
    if call.makes == "node" and new in known.made:
        raise EditError(f"{id}/name", f"There is a node '{clean(new)}' already. Give each a name of its own.")
    renamed_ = []
    for other in document.things:
        if other["id"] == id:
            # Its own last, so that a block's names of its own parts follow too.
            other = _named(other, new)
        if old is not None:
            other = with_references(other, known, lambda of, name: renamed_part(name, old, new) if of == id else None)
        renamed_.append(other)
    return document.with_things(renamed_), Report([], [], f"rename {old or call.entry['title']} to {new}")


def _named(thing: dict[str, Any], name: str) -> dict[str, Any]:
    return {"id": thing["id"], "call": thing["call"], "name": name, "args": thing["args"]}


def _rename_number(document: Document, old: Any, new: Any) -> tuple[Document, Report]:
    if old not in document.names:
        raise EditError(f"names/{clean(old)}", f"There is no name '{clean(old)}'.")
    if new in document.names and new != old:
        raise EditError(f"names/{old}", f"There is a name '{new}' already. Give each number a name of its own.")
    names = {}
    for name, own in document.names.items():
        follows = {key: renamed(text, old, str(new)) for key, text in own.items()}
        key = new if name == old else name
        names[key] = checked_name(key, follows)
    things = []
    for thing in document.things:
        args = thing["args"]
        for path, text in numbers(thing):
            if (other := renamed(text, old, new)) != text:
                args = replaced(args, path.split("/"), other)
        things.append(thing if args is thing["args"] else {**thing, "args": args})
    return document.with_things(things, names=names), Report([], [], f"rename {old} to {new}")


def delete(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "delete", "ids": [..]}``: things, and what refers to them."""
    ids = op["ids"]
    if not isinstance(ids, list | tuple):
        raise EditError("", "What is deleted is a list of ids.")
    gone = {document.thing(id)["id"] for id in ids}
    also: list[str] = []
    needs = {thing["id"]: set(referred(document.known, thing).values()) for thing in document.things}
    while along := [id for id, of in needs.items() if id not in gone and of & gone]:
        gone |= set(along)
        also += along
    kept = [thing for thing in document.things if thing["id"] not in gone]
    names = [document.thing(id).get("name") or document.thing(id)["call"] for id in ids]
    also = [thing["id"] for thing in document.things if thing["id"] in also]
    return document.with_things(kept), Report([], also, f"delete {', '.join(names[:3])}{' ..' * (len(names) > 3)}")


def order(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "order", "id", "before": id or None}``: a thing to another place in the list."""
    thing = document.thing(op["id"])
    rest = [other for other in document.things if other is not thing]
    before = op.get("before")
    if before == thing["id"]:
        return document, Report([], [], "order")
    place = len(rest) if before is None else rest.index(document.thing(before))
    return document.with_things([*rest[:place], thing, *rest[place:]]), Report([], [], "order")


def title(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "title", "to"}``: what the document is called."""
    return document.with_things(document.things, title=checked_text("title", op["to"])), Report([], [], "title")


def dimension(document: Document, op: dict[str, Any]) -> tuple[Document, Report]:
    """``{"op": "dimension", "to": 2 or 3}``: plane or space, of a document without nodes."""
    to = op["to"]
    if to not in (2, 3) or isinstance(to, bool | float):
        raise EditError("dimension", f"A document is of dimension 2 or 3, not {clean(to)}.")
    bound = [thing for thing in document.things if not _in_any_dimension(thing)]
    if to != document.dimension and bound:
        raise EditError("dimension", "Plane or space may change only while nothing is drawn: delete the nodes first.")
    return document.with_things(document.things, dimension=int(to)), Report([], [], "plane" if to == 2 else "space")


def _in_any_dimension(thing: dict[str, Any]) -> bool:
    call = call_of(thing)
    return call is not None and call.kind in ("record", "constant")


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
