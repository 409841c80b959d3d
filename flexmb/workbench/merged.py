"""The mechanism of a SPACAR file as one thinks of it: names for numbers, and rotations that belong to positions."""

import re
from typing import Any

from .calls_of import shortest
from .content import Document
from .references import Names, call_of, renamed_part, with_references

# Comments by which the writer of files says what a number was called.
LEGEND = re.compile(r"%\s(node|element|input|output) (\d{1,9}): (\S.*)", re.ASCII)
SIGNALS = {"input": ("input", "actuator"), "output": ("output", "sensor")}
# Coordinates of positions, and of rotations in the plane, by their numbers.
LETTERS = {"position": {"1": "x", "2": "y", "3": "z"}, "rotation": {"1": "phi"}}

Things = list[dict[str, Any]]


def merged(document: Document, text: str) -> Document:
    """A document whose rotations are those of the positions that they stand beside in all their elements.

    A file numbers positions and rotations by themselves. A rotation beside one position alone becomes that of the
    position, as "1.rotation", and so does a warping. A second rotation at a position, as behind a hinge, stays.
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
    found = [_said(thing, rotations, held, document.dimension) for thing in kept]
    return document.with_things([thing for thing in found if thing is not None])


def _called(things: Things, text: str) -> Things:
    """Things with the names that the comments of a file tell."""
    told: dict[str, dict[str, str]] = {}
    for line in text.splitlines():
        if match := LEGEND.fullmatch(line.strip()):
            kind, number, name = match.groups()
            told.setdefault(kind, {})[number] = name.strip()
    makers = [(thing, call_of(thing)) for thing in things]
    new: dict[str, str] = {}
    for kind in ("node", "element"):
        there = {thing["name"]: thing["id"] for thing, call in makers if call is not None and call.makes == kind}
        own = {old: name for old, name in told.get(kind, {}).items() if old in there and name.isprintable()}
        if len({own.get(old, old) for old in there}) == len(there):
            new |= {there[old]: name for old, name in own.items()}
    for side, calls in SIGNALS.items():
        several = [thing for thing in things if thing["call"] in calls]
        own = [told.get(side, {}).get(str(number), thing["name"]) for number, thing in enumerate(several, 1)]
        if len(set(own)) == len(own):
            new |= {thing["id"]: name for thing, name in zip(several, own, strict=True)}
    if not new:
        return things
    names, old = Names(things), {thing["id"]: thing.get("name") for thing in things}

    def follows(id: str, name: str) -> str | None:
        return renamed_part(name, str(old[id]), new[id]) if id in new else None

    followed = [with_references(thing, names, follows) for thing in things]
    return [{**thing, "name": new[thing["id"]]} if thing["id"] in new else thing for thing in followed]


def _parts_of_positions(things: Things) -> dict[str, str]:
    """What rotations and warpings are called that belong to one position, by the names that they have."""
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
    # A rotation with a start of its own stays; the warping of a rotation follows it without a name.
    named = {thing["name"] for thing in things if thing["call"] in ("node", "rotation", "warping")}
    turned = {thing["name"] for thing in things if thing["call"] == "rotation" and thing["args"]}
    found: dict[str, str] = {}
    for node, positions in beside.items():
        name = f"{next(iter(positions))}.{parts[node]}"
        if len(positions) == 1 and node not in turned and name not in (named | set(found.values())) - {node}:
            found[node] = name
    return found


def _said(thing: dict[str, Any], rotations: set[str], held: set[str], dimension: int) -> dict[str, Any] | None:
    """A thing as one says it of nodes whose rotations belong to them; None of a rotation fixed with its node."""
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
