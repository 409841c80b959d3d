"""Builders, files, Models and functions that build, as documents of the workbench."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.errors
import numpy as np

from ..arguments import is_concrete, short_repr
from ..build.builder import Builder
from ..build.calls import replay
from ..build.carry import built, carried_choices, collected_models
from ..build.description import Description
from ..errors import ModelError, first_line, printable
from ..model.model import Model
from ..spacar.read import SpacarModel
from . import fields
from .calls_of import Calls, NumberPlace, shortest
from .content import FORMAT, Document
from .formulas import formulas, number_text
from .from_model import builder_of
from .references import Names, call_of, following, with_references

# Raised by a function that needs the values of its arguments.
NOT_FOLLOWED = (jax.errors.JAXTypeError, jax.errors.JAXIndexError, TypeError, ValueError, ModelError)


def document_of(source: Any, names: Mapping[str, Any] | None = None, *, title: str = "") -> tuple[Document, list[str]]:
    """A document that builds the same mechanism, and in words what it does not contain.

    Args:
        source: A Builder, a result of ``read_spacar``, a Model, or a function that returns one of these. The arguments
            of a function become names. Numbers that it computes from them by + - * / ** become arithmetic.
        names: Arguments of the function: numbers, or (value, lowest, highest). Only floats become names.
        title: Title of the document.
    """
    if not callable(source) or isinstance(source, Builder):
        if names:
            raise TypeError("Names need a function that builds a mechanism from them, such as edit(function, t=1e-3).")
        known = Calls(_builder_in(source))
        left_out = known.left_out + _changes_without_call(known.builder) + _settings_of(source)
        if isinstance(source, SpacarModel) and source.parameters:
            lost = f"names {printable(', '.join(source.parameters))} of {printable(source.name)}"
            left_out.append(f"{lost}, which became numbers: open the file itself to keep them")
        return _document(source, known, list(map(number_text, known.numbers)), {}, title), left_out
    entries = {name: _named(name, value) for name, value in (names or {}).items()}
    floats = {name: float(value[0]) for name, value in entries.items() if value is not None}
    other_arguments = {name: value for name, value in (names or {}).items() if entries[name] is None}
    with collected_models() as models, built() as builders:
        returned = source(**floats, **other_arguments)
    # Only the builder of a model knows what was named and what was found.
    at = next((i for i, model in enumerate(models) if model is returned and len(builders) == len(models)), None)
    known = Calls(_builder_in(returned) if at is None else builders[at])
    left_out = known.left_out + _changes_without_call(known.builder) + _settings_of(returned)
    fixed = "stays as it is: names are numbers with a decimal point"
    left_out += [f"argument {name} = {printable(short_repr(value))} {fixed}" for name, value in other_arguments.items()]
    traced = _traced(functools.partial(source, **other_arguments), floats, models, at)
    texts, lost = _texts(known, *traced, ", ".join(floats))
    return _document(returned, known, texts, entries, title or _title(source)), left_out + lost


def _texts(known: Calls, traced: list[str | None] | None, why: str, names: str) -> tuple[list[str], list[str]]:
    """Texts of all numbers, and what does not follow from names by arithmetic."""
    texts = list(map(number_text, known.numbers))
    if traced is None or len(traced) != len(texts):
        why = why or "what is built depends on their values"
        return texts, [f"how numbers follow from {names}: {why}"] if names else []
    lost = [i for i, text in enumerate(traced) if text is None]
    words = [f"how {place} follows from {names}: it is more than + - * / **" for place in _places(known, lost)]
    return [number if text is None else text for number, text in zip(texts, traced, strict=True)], words


def _named(name: str, value: Any) -> tuple[Any, ...] | None:
    """Value and bounds of a name; None if the value is no float."""
    if isinstance(value, float):
        return (value,)
    if isinstance(value, tuple | list) and len(value) == 3 and all(isinstance(number, int | float) for number in value):
        return tuple(value)
    return None


def _traced(
    function: Callable[..., Any], floats: dict[str, float], models: list[Model], which: int | None
) -> tuple[list[str | None] | None, str]:
    """Texts of the numbers that a function computes from names; None, and the reason, if it cannot be traced."""
    if not floats:
        return None, ""

    def numbers(traced_names: dict[str, Any]) -> list[Any]:
        with carried_choices(models), built() as builders:
            returned = function(**traced_names)
        return Calls(_builder_in(returned) if which is None else builders[which]).numbers

    try:
        traced_numbers, _ = formulas(numbers, floats)
    except NOT_FOLLOWED as fault:
        first = first_line(fault)
        return None, f"the function needs to know their values ({type(fault).__name__}: {printable(first[:200])})"
    return [entry.item().text for entry in traced_numbers], ""


def _builder_in(source: Any) -> Description:
    if isinstance(source, SpacarModel):
        return source.builder
    if isinstance(source, Description):
        return source
    if isinstance(source, Model):
        return builder_of(source)
    kinds = "a Builder, a result of read_spacar, a Model, or a function that returns one of these"
    raise TypeError(f"{short_repr(source)} is no mechanism. Give {kinds}.")


def _changes_without_call(builder: Description) -> list[str]:
    """Contents of a Builder that no call of it has made."""
    twin = Builder()
    twin.dimension = builder.dimension
    replay(builder.calls, twin)
    differences, replayed = [], _contents(twin)
    for part, contents in _contents(builder).items():
        same, word = replayed[part], part.removesuffix("s")
        differences += [f"{part} that was not made by a call of the Builder"] if contents.keys() != same.keys() else []
        changed = [printable(key) for key in contents if key in same and not _equal(contents[key], same[key])]
        differences += [f"changes of {word} '{name}' that were not made by calls of the Builder" for name in changed]
    return differences


def _contents(builder: Description) -> dict[str, dict[Any, Any]]:
    signals = [(side, signal) for side, several in builder.signals.items() for signal in several]
    return {
        "nodes": {name: (node.start, node.roles) for name, node in builder.nodes.items()},
        "elements": {name: (m.nodes, m.properties, m.roles) for name, m in builder.members.items()},
        "loads": builder.loads,
        "signals": {f"{side} {signal.name}": signal for side, signal in signals},
        "starts": {"all": (builder.dofs, builder.starts)},
    }


def _equal(tree: Any, other: Any) -> bool:
    """Whether two trees have equal entries; traced numbers count as equal."""
    leaves, structure = jax.tree.flatten(tree)
    others, other_structure = jax.tree.flatten(other)
    return structure == other_structure and all(
        a is b or not is_concrete((a, b)) or np.array_equal(a, b) for a, b in zip(leaves, others, strict=True)
    )


def _settings_of(source: Any) -> list[str]:
    """Lines of a file beside the mechanism."""
    if not isinstance(source, SpacarModel):
        return []
    keywords = [printable(name) for name in source.settings if not name.startswith(("INPUT", "STARTD"))]
    return [f"{name} of {printable(source.name)}: it belongs to an analysis or a drawing" for name in keywords]


def _title(source: Any) -> str:
    name = source.name.removesuffix(".dat") if isinstance(source, SpacarModel) else getattr(source, "__name__", "")
    return name if name.isprintable() and name and not name.startswith("<") else "mechanism"


def _document(
    source: Any, calls: Calls, texts: list[str], names: Mapping[str, tuple[Any, ...] | None], title: str
) -> Document:
    """The document of calls whose numbers have texts."""
    keys, things = ("value", "low", "high"), _once(calls.filled(texts))
    known = {name: entry for name, entry in names.items() if entry is not None}
    data: dict[str, Any] = {"format": FORMAT, "title": title or _title(source)}
    data["dimension"] = calls.builder.dimension or 2
    data["names"] = {n: dict(zip(keys, map(number_text, entry), strict=False)) for n, entry in known.items()}
    data["things"] = [{"id": str(i), **item} for i, item in enumerate(things, 1)]
    document = Document.from_data(data)
    return merged(document, source.text) if isinstance(source, SpacarModel) else document


def _once(items: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Things with each section, material and damping once, and numbered if there are several."""
    unique_items: list[dict[str, Any]] = []
    seen: dict[str, str] = {}
    called: dict[tuple[str, str], str] = {}
    count: dict[str, int] = {}
    known = fields.calls()
    for item in items:
        call = known[item["call"]]
        args = {
            key: called.get((str(call.fields[key]["kind"]), value), value) if isinstance(value, str) else value
            for key, value in item["args"].items()
        }
        if call.kind in ("record", "constant"):
            content = repr((item["call"], args))
            again = content in seen
            if not again:
                prefix = str(call.entry["name"])
                count[prefix] = count.get(prefix, 0) + 1
                seen[content] = prefix if count[prefix] == 1 else f"{prefix} {count[prefix]}"
            called[str(call.makes), item["name"]] = seen[content]
            if again:
                continue
            item = {**item, "name": seen[content]}
        unique_items.append({**item, "args": args})
    return unique_items


def _places(calls: Calls, lost: list[int]) -> list[str]:
    """Places of numbers in words, each once."""
    lost_numbers = set(lost)

    def has(value: Any) -> bool:
        if isinstance(value, NumberPlace):
            return value in lost_numbers
        return isinstance(value, list) and any(map(has, value))

    places = [
        f"{argument} of {item['call']} '{printable(item.get('name') or item['args'].get('node', ''))}'"
        for item in calls.things
        for argument, value in item["args"].items()
        if has(value)
    ]
    return list(dict.fromkeys(places))


# Comments with names in files of the writer.
LEGEND = re.compile(r"%\s(node|element|input|output) (\d{1,9}): (\S.*)", re.ASCII)
SIGNALS = {"input": ("input", "actuator"), "output": ("output", "sensor")}
# Components of positions, and of rotations in the plane, by their numbers.
LETTERS = {"position": {"1": "x", "2": "y", "3": "z"}, "rotation": {"1": "phi"}}

Items = list[dict[str, Any]]


def merged(document: Document, text: str) -> Document:
    """A document whose rotations and warpings are parts of positions.

    In a file positions and rotations have numbers of their own. A rotation that stands beside one position in all its
    elements becomes its part, such as "1.rotation", and so does a warping. A second rotation at a position stays.
    """
    items = _called(document.things, text)
    new = _parts_of_positions(items)
    names, nodes = Names(items), {item["id"] for item in items if item["call"] in ("node", "rotation", "warping")}
    gone = {item["id"] for item in items if item["call"] in ("rotation", "warping") and item["name"] in new}

    def follows(id: str, name: str) -> str | None:
        return new.get(name) if id in nodes else None

    remaining = [with_references(item, names, follows) for item in items if item["id"] not in gone]
    rotations = {name.removesuffix(".rotation") for name in new.values() if name.endswith(".rotation")}
    supports = [item["args"] for item in remaining if item["call"] == "fix"]
    fixed_nodes = {args["node"] for args in supports if "components" not in args}
    parts = [_with_rotations(item, rotations, fixed_nodes, document.dimension) for item in remaining]
    return document.with_things([item for item in parts if item is not None])


def _called(items: Items, text: str) -> Items:
    """Things with the names in the comments of a file."""
    comments: dict[str, dict[str, str]] = {}
    for line in text.splitlines():
        if match := LEGEND.fullmatch(line.strip()):
            kind, number, name = match.groups()
            comments.setdefault(kind, {})[number] = name.strip()
    pairs = [(item, call_of(item)) for item in items]
    new: dict[str, str] = {}
    for kind in ("node", "element"):
        ids_by_name = {item["name"]: item["id"] for item, call in pairs if call is not None and call.makes == kind}
        names = {old: name for old, name in comments.get(kind, {}).items() if old in ids_by_name and name.isprintable()}
        if len({names.get(old, old) for old in ids_by_name}) == len(ids_by_name):
            new |= {ids_by_name[old]: name for old, name in names.items()}
    for side, calls in SIGNALS.items():
        signals = [item for item in items if item["call"] in calls]
        names = [comments.get(side, {}).get(str(number), item["name"]) for number, item in enumerate(signals, 1)]
        if len(set(names)) == len(names):
            new |= {item["id"]: name for item, name in zip(signals, names, strict=True)}
    if not new:
        return items
    follows = following({item["id"]: [(item["name"], new[item["id"]])] for item in items if item["id"] in new})
    known = Names(items)
    followed = [with_references(item, known, follows) for item in items]
    return [{**item, "name": new[item["id"]]} if item["id"] in new else item for item in followed]


def _parts_of_positions(items: Items) -> dict[str, str]:
    """New names of rotations and warpings that belong to one position, by their old names."""
    beside: dict[str, set[str]] = {}
    parts: dict[str, str] = {}
    for item in items:
        call = call_of(item)
        if call is None or call.kind != "element":
            continue
        kinds, position = [k.part for k in call.function.nodes.values() if k.part != "internal"], None
        for node, part in zip(item["args"]["nodes"], kinds, strict=False):
            if part == "position":
                position = node
            elif position is not None:
                parts[node] = part
                beside.setdefault(node, set()).add(position)
    # A rotation with its own start stays. The warping of a rotation follows it without a name.
    named = {item["name"] for item in items if item["call"] in ("node", "rotation", "warping")}
    turned = {item["name"] for item in items if item["call"] == "rotation" and item["args"]}
    new_names: dict[str, str] = {}
    for node, positions in beside.items():
        name = f"{next(iter(positions))}.{parts[node]}"
        if len(positions) == 1 and node not in turned and name not in (named | set(new_names.values())) - {node}:
            new_names[node] = name
    return new_names


def _with_rotations(
    item: dict[str, Any], rotations: set[str], fixed_nodes: set[str], dimension: int
) -> dict[str, Any] | None:
    """A thing in terms of nodes with rotations; None for the support of a rotation that is fixed with its node."""
    args, call = dict(item["args"]), call_of(item)
    key = next((key for key in ("node", "of") if key in args and args.get("kind") != "element"), "")
    owner = args.get(key, "").removesuffix(".rotation")
    turns = bool(key) and owner in rotations and args[key] != owner
    if call is not None and call.kind == "element":
        args["nodes"] = shortest(call.function, args["nodes"])
    elif item["call"] == "fix" and "components" not in args:
        if turns and owner in fixed_nodes:
            return None
        if turns or (owner in rotations and f"{owner}.rotation" not in fixed_nodes):
            args |= {"node": owner, "components": "rotation" if turns else "position"}
    elif turns and item["call"] in ("moment", "inertia"):
        args["node"] = owner
    elif key and (turns or owner in rotations):
        letters = LETTERS["rotation" if turns else "position"] if dimension == 2 or not turns else {}
        for name in ("component", "components"):
            words = args.get(name, "").split()
            if words and all(word in letters for word in words):
                args |= {key: owner, name: " ".join(letters[word] for word in words)}
    return {**item, "args": args}
