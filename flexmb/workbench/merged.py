"""The mechanism of a SPACAR file in the user's terms: names for numbers, and rotations as parts of positions."""

import re
from typing import Any

from .calls_of import shortest
from .content import Document
from .references import Names, call_of, renamed_part, with_references

# Comments with names in files of the writer.
LEGEND = re.compile(r"%\s(node|element|input|output) (\d{1,9}): (\S.*)", re.ASCII)
SIGNALS = {"input": ("input", "actuator"), "output": ("output", "sensor")}
# Components of positions, and of rotations in the plane, by their numbers.
LETTERS = {"position": {"1": "x", "2": "y", "3": "z"}, "rotation": {"1": "phi"}}

Things = list[dict[str, Any]]


def merged(document: Document, text: str) -> Document:
    """A document whose rotations and warpings are parts of positions.

    In a file positions and rotations have numbers of their own. A rotation that stands beside one position in all its
    elements becomes its part, such as "1.rotation", and so does a warping. A second rotation at a position stays.
    """
    things = _called(document.things, text)
    new = _parts_of_positions(things)
    names, nodes = Names(things), {thing["id"] for thing in things if thing["call"] in ("node", "rotation", "warping")}
    gone = {thing["id"] for thing in things if thing["call"] in ("rotation", "warping") and thing["name"] in new}

    def follows(id: str, name: str) -> str | None:
        return new.get(name) if id in nodes else None

    kept = [with_references(thing, names, follows) for thing in things if thing["id"] not in gone]
    rotations = {name.removesuffix(".rotation") for name in new.values() if name.endswith(".rotation")}
    held = {thing["args"]["node"] for thing in kept if thing["call"] == "fix" and "components" not in thing["args"]}
    parts = [_of_parts(thing, rotations, held, document.dimension) for thing in kept]
    return document.with_things([thing for thing in parts if thing is not None])


def _called(things: Things, text: str) -> Things:
    """Things with the names in the comments of a file."""
    comments: dict[str, dict[str, str]] = {}
    for line in text.splitlines():
        if match := LEGEND.fullmatch(line.strip()):
            kind, number, name = match.groups()
            comments.setdefault(kind, {})[number] = name.strip()
    makers = [(thing, call_of(thing)) for thing in things]
    new: dict[str, str] = {}
    for kind in ("node", "element"):
        there = {thing["name"]: thing["id"] for thing, call in makers if call is not None and call.makes == kind}
        names = {old: name for old, name in comments.get(kind, {}).items() if old in there and name.isprintable()}
        if len({names.get(old, old) for old in there}) == len(there):
            new |= {there[old]: name for old, name in names.items()}
    for side, calls in SIGNALS.items():
        signals = [thing for thing in things if thing["call"] in calls]
        names = [comments.get(side, {}).get(str(number), thing["name"]) for number, thing in enumerate(signals, 1)]
        if len(set(names)) == len(names):
            new |= {thing["id"]: name for thing, name in zip(signals, names, strict=True)}
    if not new:
        return things
    known, old = Names(things), {thing["id"]: thing.get("name") for thing in things}

    def follows(id: str, name: str) -> str | None:
        return renamed_part(name, str(old[id]), new[id]) if id in new else None

    followed = [with_references(thing, known, follows) for thing in things]
    return [{**thing, "name": new[thing["id"]]} if thing["id"] in new else thing for thing in followed]


def _parts_of_positions(things: Things) -> dict[str, str]:
    """New names of rotations and warpings that belong to one position, by their old names."""
    beside: dict[str, set[str]] = {}
    parts: dict[str, str] = {}
    for thing in things:
        call = call_of(thing)
        if call is None or call.kind != "element":
            continue
        kinds, position = [k.part for k in call.function.nodes.values() if k.part != "internal"], None
        for node, part in zip(thing["args"]["nodes"], kinds, strict=False):
            if part == "position":
                position = node
            elif position is not None:
                parts[node] = part
                beside.setdefault(node, set()).add(position)
    # A rotation with its own start stays. The warping of a rotation follows it without a name.
    named = {thing["name"] for thing in things if thing["call"] in ("node", "rotation", "warping")}
    turned = {thing["name"] for thing in things if thing["call"] == "rotation" and thing["args"]}
    found: dict[str, str] = {}
    for node, positions in beside.items():
        name = f"{next(iter(positions))}.{parts[node]}"
        if len(positions) == 1 and node not in turned and name not in (named | set(found.values())) - {node}:
            found[node] = name
    return found


def _of_parts(thing: dict[str, Any], rotations: set[str], held: set[str], dimension: int) -> dict[str, Any] | None:
    """A thing in terms of nodes with rotations; None for the support of a rotation that is fixed with its node."""
    args, call = dict(thing["args"]), call_of(thing)
    key = next((key for key in ("node", "of") if key in args and args.get("kind") != "element"), "")
    owner = args.get(key, "").removesuffix(".rotation")
    turns = bool(key) and owner in rotations and args[key] != owner
    if call is not None and call.kind == "element":
        args["nodes"] = shortest(call.function, args["nodes"])
    elif thing["call"] == "fix" and "components" not in args:
        if turns and owner in held:
            return None
        if turns or (owner in rotations and f"{owner}.rotation" not in held):
            args |= {"node": owner, "components": "rotation" if turns else "position"}
    elif turns and thing["call"] in ("moment", "inertia"):
        args["node"] = owner
    elif key and (turns or owner in rotations):
        letters = LETTERS["rotation" if turns else "position"] if dimension == 2 or not turns else {}
        for name in ("component", "components"):
            words = args.get(name, "").split()
            if words and all(word in letters for word in words):
                args |= {key: owner, name: " ".join(letters[word] for word in words)}
    return {**thing, "args": args}
