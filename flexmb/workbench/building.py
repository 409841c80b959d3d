"""A document built: its numbers evaluated, its calls made on a Builder, and faults reported at their fields."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Callable, Mapping
from typing import Any

import jax.core

from ..arguments import is_concrete
from ..build.builder import Builder
from ..build.calls import MadeCall
from ..build.carry import carried_choices
from ..build.properties import check_record
from ..elements import planar, spatial
from ..errors import ModelError, printable
from ..model.model import Model
from .content import Document, EditError
from .edits import texts
from .fields import ENDS_IN_WORDS, Call
from .references import call_of, referred
from .values import evaluated
from .values import free_names as free_names
from .values import numeric_values as numeric_values
from .values import structure as structure

ROOMS = {"planar": planar, "spatial": spatial}
# Kinds of fields that contain a list.
LISTS = ("vector", "weights", "components", "deformations", "nodes", "sections")
# Words of the Builder's messages for contents of fields of a kind.
FIELD_WORDS = {"deformations": "deformation", "components": "coordinate|deformation", "nodes": "node|joins|length"}
FLAGS = {"true": True, "false": False}


@dataclasses.dataclass(frozen=True)
class Built:
    """A built document.

    Attributes:
        builder: Builder with everything that could be built.
        problems: Faults, {"address", "message"} each.
        skipped: Ids of things that are not in the builder: they have problems, or refer to things with problems.
        made: Calls of each thing, by its id.
        records: Sections, materials and dampings, by id.
        numbers: Values of the numeric fields.
    """

    builder: Builder
    problems: list[dict[str, str]]
    skipped: list[str]
    made: dict[str, list[MadeCall]]
    records: dict[str, Any]
    numbers: dict[str, Any]

    def model(self, like: Model | None = None) -> Model:
        """The model of what could be built, in a trace with degrees of freedom and clamps of the model ``like``."""
        if like is None:
            return self.builder.build()
        with carried_choices([like]):
            return self.builder.build()


def build(document: Document, numbers: Mapping[str, Any] | None = None) -> Built:
    """Make the calls of a document on a Builder, with other values by address if given, which may be traced."""
    values, faults = evaluated(document)
    if numbers is not None:
        return _Building(document, {**values, **numbers}, faults).done()
    if "built" not in document.kept:
        # Concrete also within a trace, since it is kept.
        with jax.core.eval_context():
            document.kept["built"] = _Building(document, dict(values), faults).done()
    built = document.kept["built"]
    # Callers may change their copy of the builder.
    return dataclasses.replace(built, builder=built.builder.copy())


def built_whole(document: Document) -> Built:
    """The built document; ModelError if it has problems."""
    built = build(document)
    if built.problems:
        raise ModelError(f"The mechanism is not complete: {built.problems[0]['message']}")
    return built


def positions(document: Document, built: Built | None = None) -> dict[str, list[float]]:
    """Positions of nodes by name, [x, y] or [x, y, z]; also of nodes that cannot be built."""
    values, _ = evaluated(document)
    places: dict[str, list[float]] = {}
    for item in document.things:
        if item["call"] == "node" and item.get("name"):
            position = [values.get(f"{item['id']}/position/{k}") for k in range(document.dimension)]
            if len(item["args"].get("position", ())) == document.dimension and None not in position:
                places[item["name"]] = [float(value) for value in position if value is not None]
    for name, node in (built or build(document)).builder.nodes.items():
        if node.kind.part == "position" and is_concrete(node.start):
            places.setdefault(name, [float(value) for value in node.start])
    return places


class Arguments:
    """Arguments of calls from the texts of fields; ``element(name)`` is the element type with a name."""

    def __init__(
        self,
        document: Document,
        values: Mapping[str, Any],
        faults: Mapping[str, str],
        element: Callable[[str], Any] = lambda name: getattr(ROOMS[name.partition(".")[0]], name.partition(".")[2]),
    ):
        """Begin without records: sections, materials and dampings by the id of their thing."""
        self.document, self.values, self.faults, self.element = document, values, faults, element
        self.concrete = evaluated(document)[0]
        self.records: dict[str, Any] = {}

    def of(self, call: Call, thing: dict[str, Any], tell: Callable[[str, str], None]) -> dict[str, Any]:
        """Values of the fields that are given; faults go to ``tell(address, message)``."""
        values, args = {}, thing["args"]
        for key, value in args.items():
            field, address = call.fields.get(key), f"{thing['id']}/{key}"
            if field is None:
                tell(address, f"{call.name} takes no '{printable(key)}'. It takes: {', '.join(call.fields)}.")
                continue
            if value in ("", []):
                continue
            try:
                values[key] = self._argument(field, address, value)
            except EditError as fault:
                tell(fault.address, fault.message)
        for key, field in call.fields.items():
            if not field["optional"] and args.get(key) in (None, "", []):
                title, word = call.entry["title"].capitalize(), field["name"].replace("_", " ")
                tell(f"{thing['id']}/{key}", f"{title} needs its {word}.")
        return values

    def _argument(self, field: dict[str, Any], address: str, value: Any) -> Any:
        kind = field["kind"]
        if not isinstance(value, str) and kind not in ("number", *LISTS):
            raise EditError(address, f"This is a list. Give one {kind}.")
        if isinstance(value, list) and kind != "weights" and any(not isinstance(text, str) for text in value):
            raise EditError(address, "This is a list of lists. Give a list of texts.")
        if kind == "number":
            return self._number(field, address, value)
        if kind == "vector":
            return self._vector(field, address, value)
        if kind == "weights":
            return self._weights(address, value)
        if kind in ("components", "deformations"):
            words = _words(address, value)
            if field["name"] == "released":
                return words[0] if words == ["all"] else () if words == ["none"] else tuple(words)
            return words[0] if field["name"] == "component" and len(words) == 1 else tuple(words)
        if kind == "nodes":
            return (value,) if isinstance(value, str) else tuple(value)
        if kind == "sections":
            names = [value] if isinstance(value, str) else value
            return tuple(self._record("section", f"{address}/{k}", name) for k, name in enumerate(names))
        return self._word(field, address, str(value))

    def _word(self, field: dict[str, Any], address: str, value: str) -> Any:
        """Meaning of one text: a reference, a choice, a text."""
        kind = field["kind"]
        if kind in ("section", "material", "damping"):
            return self._record(kind, address, value)
        if kind == "flag":
            if value not in FLAGS:
                raise EditError(address, f"This must be true or false, not '{printable(value)}'.")
            return FLAGS[value]
        if kind == "choice":
            if value not in field["choices"]:
                choices = ", ".join(field["choices"])
                raise EditError(address, f"This must be one of {choices}, not '{printable(value)}'.")
            return {"clamped": ENDS_IN_WORDS.get, "element": self.element}.get(field["name"], str)(value)
        return value

    def _number(self, field: dict[str, Any], address: str, value: Any) -> Any:
        if isinstance(value, list):
            return [self._value_at(f"{address}/{k}") for k in range(len(value))]
        if not field["whole"]:
            return self._value_at(address)
        # It chooses code and is never traced.
        self._value_at(address)
        number = self.concrete[address]
        if number != int(number):
            raise EditError(address, f"This must be a whole number, not '{printable(value)}'.")
        return int(number)

    def _vector(self, field: dict[str, Any], address: str, value: Any) -> Any:
        count, alone = field["count"][str(self.document.dimension)], isinstance(value, str)
        if alone and count not in (None, 1):
            raise EditError(address, f"This takes {count} numbers, not one.")
        if count == 0:
            raise EditError(address, "This is for mechanisms in space.")
        if count is not None and not alone and len(value) != count:
            raise EditError(address, f"This takes {count} number{'s' * (count > 1)}, not {len(value)}.")
        numbers = [self._value_at(address)] if alone else [self._value_at(f"{address}/{k}") for k in range(len(value))]
        is_one = len(numbers) == 1 and (alone or count in (None, 1))
        return numbers[0] if is_one and field["name"] not in ("values", "start", "breaks") else tuple(numbers)

    def _weights(self, address: str, value: Any) -> dict[str, Any]:
        weights = {}
        for k, pair in enumerate(value):
            if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[0], str):
                raise EditError(f"{address}/{k}", "Each part needs a name and a factor.")
            if pair[0] in weights:
                message = f"'{printable(pair[0])}' is given twice: give the sum of its factors."
                raise EditError(f"{address}/{k}/0", message)
            weights[pair[0]] = self._value_at(f"{address}/{k}/1")
        return weights

    def _value_at(self, address: str) -> Any:
        if address in self.faults and address not in self.values:
            raise EditError(address, self.faults[address])
        if address not in self.values:
            raise EditError(address, "A number, a name or arithmetic is missing.")
        return self.values[address]

    def _record(self, kind: str, address: str, name: str) -> Any:
        id = self.document.known.thing((kind,), name)
        if id is None:
            known = ", ".join(map(printable, self.document.known.by_space.get(kind, {}))) or "none yet"
            raise EditError(address, f"There is no {kind} '{printable(name)}'. There are: {known}.")
        return self.records[id]


def call_arguments(call: Call, name: str | None, args: Mapping[str, Any]) -> tuple[list[Any], dict[str, Any]]:
    """Positional and keyword arguments of a call."""
    remaining = dict(args)
    named = {"name": name} if call.makes and name else {}
    if call.kind in ("element", "block"):
        nodes = list(remaining.pop("nodes")) if call.kind == "element" else []
        return nodes, named | remaining if nodes else remaining | named
    if call.kind in ("record", "constant"):
        return [], remaining
    remaining |= named
    by_place: list[Any] = []
    for key, parameter in list(inspect.signature(call.function).parameters.items())[1:]:
        if parameter.kind is parameter.VAR_POSITIONAL:
            by_place += remaining.pop(key, ())
        elif key not in remaining or parameter.kind is parameter.KEYWORD_ONLY:
            break
        else:
            by_place.append(remaining.pop(key))
    return by_place, remaining


class _Building:
    """One building of a document: each thing after the things that it refers to."""

    def __init__(self, document: Document, values: dict, faults: dict[str, str]):
        self.document, self.values, self.faults = document, values, faults
        self.arguments = Arguments(document, values, faults)
        self.builder = Builder()
        self.problems: list[dict[str, str]] = []
        self.made: dict[str, list[MadeCall]] = {}
        self.records = self.arguments.records
        # Each visited thing: "open", "made" or "left out".
        self.state: dict[str, str] = {}
        self.needs = {item["id"]: referred(document.known, item) for item in document.things}

    def done(self) -> Built:
        used = {address for address, _ in texts(self.document)}
        for address, message in self.faults.items():
            if address in used and address.startswith("names/"):
                self._tell(address, message)
        for item in self.document.things:
            self._visit(item["id"])
        skipped = [item["id"] for item in self.document.things if self.state[item["id"]] != "made"]
        places = {item["id"]: k for k, item in enumerate(self.document.things)}
        self.problems.sort(key=lambda problem: places.get(problem["address"].partition("/")[0], -1))
        return Built(self.builder, self.problems, skipped, self.made, self.records, self.values)

    def _tell(self, address: str, message: str) -> None:
        self.problems.append({"address": address, "message": message})

    def _visit(self, first: str) -> None:
        """Make a thing after the things that it needs, without recursion: chains may be long."""
        waiting = [first]
        while waiting:
            id = waiting[-1]
            if self.state.get(id) in ("made", "left out"):
                waiting.pop()
                continue
            needs = [other for other in self.needs[id].values() if other is not None]
            first_visit = id not in self.state
            self.state[id] = "open"
            open_ = [other for other in needs if other not in self.state]
            if first_visit and open_:
                waiting += reversed(open_)
                continue
            waiting.pop()
            whole = all(self.state[other] != "left out" for other in needs)
            self.state[id] = "made" if whole and self._make(self.document.by_id[id]) else "left out"

    def _make(self, item: dict[str, Any]) -> bool:
        """Make the call of a thing; False if it fails."""
        call, id = call_of(item), item["id"]
        if call is None:
            self._tell(id, f"This version has no call '{printable(item['call'])}'.")
            return False
        before = len(self.problems)
        args = self.arguments.of(call, item, self._tell)
        if len(self.problems) > before:
            return False
        nodes, members, calls = map(len, (self.builder.nodes, self.builder.members, self.builder.calls))
        trial = self.builder.copy() if call.kind == "block" else self.builder
        try:
            self._call(trial, call, item, args)
        except (ValueError, TypeError, ImportError, OSError, ArithmeticError) as fault:
            self._tell(self._address_of(call, item, str(fault)), str(fault) or type(fault).__name__)
            # Take back what the call has added so far.
            for n_before, contents in ((nodes, self.builder.nodes), (members, self.builder.members)):
                for name in list(contents)[n_before:]:
                    del contents[name]
            return False
        self.builder = trial
        self.made[id] = self.builder.calls[calls:]
        return True

    def _call(self, builder: Builder, call: Call, item: dict[str, Any], args: dict[str, Any]) -> None:
        name, id = item.get("name"), item["id"]
        by_place, by_name = call_arguments(call, name, args)
        if call.kind == "constant":
            self.records[id] = call.function
        elif call.kind == "record":
            record = call.function(**by_name)
            check_record(f"{call.makes} '{name}'", record)
            self.records[id] = record
        elif call.kind == "element":
            builder.add(call.function, *by_place, **by_name)
        elif call.kind == "block":
            call.function(builder, **by_name)
        else:
            getattr(builder, call.name)(*by_place, **by_name)

    def _address_of(self, call: Call, item: dict[str, Any], message: str) -> str:
        """Address of the field that a message of the Builder is likely about."""
        id = item["id"]
        unknown = [address for address, target_id in self.needs[id].items() if target_id is None]
        if unknown:
            return f"{id}/{unknown[0]}"
        quoted = [key for key in call.fields if re.search(rf"['`\"]{key}['`\"]|\b{key} = |\b{key} must\b", message)]
        # Names of things are no names of fields.
        plain = re.sub(r"'[^']*'", "", message)
        places = {}
        for key, field in call.fields.items():
            words = f"{FIELD_WORDS.get(field['kind'], '$')}|{key.rstrip('s')}"
            if match := re.search(rf"\b({words})", plain, re.IGNORECASE):
                places[key] = match.start()
        args, mentioned = item["args"], sorted(places, key=lambda key: places[key])
        candidates = [key for key in quoted if key in args] or [key for key in mentioned if key in args] or quoted
        return f"{id}/{candidates[0]}" if candidates else id


def _words(address: str, value: Any) -> list[str | int]:
    """Components, separated by blanks or commas."""
    texts = value if isinstance(value, list) else re.split(r"[\s,]+", value)
    if any(not isinstance(text, str) for text in texts):
        raise EditError(address, "This is a list of lists. Write components one after the other, such as 'x y'.")
    return [int(text) if text.isascii() and text.isdecimal() else text for text in texts if text]
