"""A document built: its numbers evaluated, its calls made on a Builder, and what is wrong told at the field."""

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
from ..build.carry import carried
from ..build.properties import check_record
from ..elements import planar, spatial
from ..errors import clean
from ..model.model import Model
from .content import Document
from .edits import texts
from .fields import ENDS_IN_WORDS, Call
from .references import call_of, referred
from .values import evaluated
from .values import free_names as free_names
from .values import numbers_of as numbers_of
from .values import structure as structure

ROOMS = {"planar": planar, "spatial": spatial}
# Kinds of fields that hold a list.
LISTS = ("vector", "weights", "components", "deformations", "nodes", "sections")
# How messages of the Builder speak of what stands in fields of a kind.
SAID = {"deformations": "deformation", "components": "coordinate|deformation", "nodes": "node|joins|length"}
FLAGS = {"true": True, "false": False}


@dataclasses.dataclass(frozen=True)
class Built:
    """What has become of a document.

    Attributes:
        builder: With all that could be built.
        problems: What is wrong, {"address", "message"} each.
        skipped: Ids of things that are not in the builder: they have problems, or refer to such that have.
        made: Calls that each thing became, by its id.
        records: Sections, materials and dampings, by id.
        numbers: Values of the numeric fields, as they were used.
    """

    builder: Builder
    problems: list[dict[str, str]]
    skipped: list[str]
    made: dict[str, list[MadeCall]]
    records: dict[str, Any]
    numbers: dict[str, Any]

    def model(self, like: Model | None = None) -> Model:
        """The model of what could be built.

        Args:
            like: A model of the same structure with concrete numbers, whose degrees of freedom and clamps a build
                under a trace takes.

        Raises:
            ModelError: As of :meth:`flexmb.Builder.build`.
        """
        if like is None:
            return self.builder.build()
        with carried([like]):
            return self.builder.build()


class _Fault(Exception):
    """What is wrong with a field."""

    def __init__(self, address: str, message: str):
        super().__init__(message)
        self.address, self.message = address, message


# -- the mechanism -----------------------------------------------------------------------------------------------


def build(document: Document, numbers: Mapping[str, Any] | None = None) -> Built:
    """Make the calls of a document on a Builder; what is wrong is left out and told.

    Args:
        document: The document.
        numbers: Values of numeric fields by address, as :func:`numbers_of` gives them, which may be traced; those
            that are missing are evaluated.
    """
    found, faults = evaluated(document)
    if numbers is not None:
        return _Building(document, {**found, **numbers}, faults).done()
    if "built" not in document.kept:
        # Concrete also where this is asked within a function that is traced: it is kept.
        with jax.core.eval_context():
            document.kept["built"] = _Building(document, dict(found), faults).done()
    built = document.kept["built"]
    # What is done to the builder by one who asked is not seen by another.
    return dataclasses.replace(built, builder=built.builder.copy())


def positions(document: Document, built: Built | None = None) -> dict[str, list[float]]:
    """Where nodes are, [x, y] or [x, y, z] each, by name, also of what cannot be built; those of blocks if it is."""
    found, _ = evaluated(document)
    places: dict[str, list[float]] = {}
    for thing in document.things:
        if thing["call"] == "node" and thing.get("name"):
            own = [found.get(f"{thing['id']}/position/{k}") for k in range(document.dimension)]
            if len(thing["args"].get("position", ())) == document.dimension and None not in own:
                places[thing["name"]] = [float(one) for one in own if one is not None]
    for name, node in (built or build(document)).builder.nodes.items():
        if node.kind.part == "position" and is_concrete(node.start):
            places.setdefault(name, [float(one) for one in node.start])
    return places


class Arguments:
    """Arguments of calls from the texts of fields.

    Attributes:
        records: Sections, materials and dampings by the id of their thing.
        element: ``f(name)``: the element type of that name.
    """

    def __init__(
        self,
        document: Document,
        values: Mapping[str, Any],
        faults: Mapping[str, str],
        element: Callable[[str], Any] = lambda name: getattr(ROOMS[name.partition(".")[0]], name.partition(".")[2]),
    ):
        """Begin without records."""
        self.document, self.values, self.faults, self.element = document, values, faults, element
        self.concrete = evaluated(document)[0]
        self.records: dict[str, Any] = {}

    def of(self, call: Call, thing: dict[str, Any], tell: Callable[[str, str], None]) -> dict[str, Any]:
        """Values of the fields that are given; what has none is told."""
        found, given = {}, thing["args"]
        for key, value in given.items():
            field, address = call.fields.get(key), f"{thing['id']}/{key}"
            if field is None:
                tell(address, f"{call.name} takes no '{clean(key)}'. It takes: {', '.join(call.fields)}.")
                continue
            if value in ("", []):
                continue
            try:
                found[key] = self._argument(field, address, value)
            except _Fault as fault:
                tell(fault.address, fault.message)
        for key, field in call.fields.items():
            if not field["optional"] and given.get(key) in (None, "", []):
                tell(f"{thing['id']}/{key}", f"{call.entry['title'].capitalize()} needs {_article(field)}.")
        return found

    def _argument(self, field: dict[str, Any], address: str, value: Any) -> Any:
        kind = field["kind"]
        if not isinstance(value, str) and kind not in ("number", *LISTS):
            raise _Fault(address, f"One {kind} is wanted here, not a list.")
        if isinstance(value, list) and kind != "weights" and any(not isinstance(one, str) for one in value):
            raise _Fault(address, "A list of texts is wanted here, not one of lists.")
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
        """What one text means: a reference, a choice, a text."""
        kind = field["kind"]
        if kind in ("section", "material", "damping"):
            return self._record(kind, address, value)
        if kind == "flag":
            if value not in FLAGS:
                raise _Fault(address, f"This must be true or false, not '{clean(value)}'.")
            return FLAGS[value]
        if kind == "choice":
            if value not in field["choices"]:
                raise _Fault(address, f"This must be one of {', '.join(field['choices'])}, not '{clean(value)}'.")
            return {"clamped": ENDS_IN_WORDS.get, "element": self.element}.get(field["name"], str)(value)
        return value

    def _number(self, field: dict[str, Any], address: str, value: Any) -> Any:
        if isinstance(value, list):
            return [self._one(f"{address}/{k}") for k in range(len(value))]
        if not field["whole"]:
            return self._one(address)
        # It chooses code: it is never traced.
        self._one(address)
        number = self.concrete[address]
        if number != int(number):
            raise _Fault(address, f"This must be a whole number, not '{clean(value)}'.")
        return int(number)

    def _vector(self, field: dict[str, Any], address: str, value: Any) -> Any:
        count, alone = field["count"][str(self.document.dimension)], isinstance(value, str)
        if alone and count not in (None, 1):
            raise _Fault(address, f"This takes {count} numbers, not one.")
        if count == 0:
            raise _Fault(address, "This is for mechanisms in space.")
        if count is not None and not alone and len(value) != count:
            raise _Fault(address, f"This takes {count} number{'s' * (count > 1)}, not {len(value)}.")
        found = [self._one(address)] if alone else [self._one(f"{address}/{k}") for k in range(len(value))]
        is_one = (
            len(found) == 1 and (alone or count in (None, 1)) and field["name"] not in ("values", "start", "breaks")
        )
        return found[0] if is_one else tuple(found)

    def _weights(self, address: str, value: Any) -> dict[str, Any]:
        found = {}
        for k, pair in enumerate(value):
            if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[0], str):
                raise _Fault(f"{address}/{k}", "Each part has its name and its factor.")
            if pair[0] in found:
                raise _Fault(f"{address}/{k}/0", f"'{clean(pair[0])}' is there twice: give the sum of its factors.")
            found[pair[0]] = self._one(f"{address}/{k}/1")
        return found

    def _one(self, address: str) -> Any:
        if address in self.faults and address not in self.values:
            raise _Fault(address, self.faults[address])
        if address not in self.values:
            raise _Fault(address, "A number, a name or arithmetic is missing.")
        return self.values[address]

    def _record(self, kind: str, address: str, name: str) -> Any:
        id = self.document.known.thing((kind,), name)
        if id is None:
            known = ", ".join(map(clean, self.document.known.by_space.get(kind, {}))) or "none yet"
            raise _Fault(address, f"There is no {kind} '{clean(name)}'. There are: {known}.")
        return self.records[id]


def arranged(call: Call, name: str | None, args: Mapping[str, Any]) -> tuple[list[Any], dict[str, Any]]:
    """Arguments of a call by place and by name."""
    rest = dict(args)
    named = {"name": name} if call.makes and name else {}
    if call.kind in ("element", "block"):
        nodes = list(rest.pop("nodes")) if call.kind == "element" else []
        return nodes, named | rest if nodes else rest | named
    if call.kind in ("record", "constant"):
        return [], rest
    rest |= named
    by_place: list[Any] = []
    for key, parameter in list(inspect.signature(call.function).parameters.items())[1:]:
        if parameter.kind is parameter.VAR_POSITIONAL:
            by_place += rest.pop(key, ())
        elif key not in rest or parameter.kind is parameter.KEYWORD_ONLY:
            break
        else:
            by_place.append(rest.pop(key))
    return by_place, rest


class _Building:
    """One building of a document: each thing after those that it refers to."""

    def __init__(self, document: Document, values: dict, faults: dict[str, str]):
        self.document, self.values, self.faults = document, values, faults
        self.arguments = Arguments(document, values, faults)
        self.builder = Builder()
        self.problems: list[dict[str, str]] = []
        self.made: dict[str, list[MadeCall]] = {}
        self.records = self.arguments.records
        self.state: dict[str, str] = {}
        self.needs = {thing["id"]: referred(document.known, thing) for thing in document.things}

    def done(self) -> Built:
        used = {address for address, _ in texts(self.document)}
        for address, message in self.faults.items():
            if address in used and address.startswith("names/"):
                self._tell(address, message)
        for thing in self.document.things:
            self._visit(thing["id"])
        skipped = [thing["id"] for thing in self.document.things if self.state[thing["id"]] != "made"]
        places = {thing["id"]: k for k, thing in enumerate(self.document.things)}
        self.problems.sort(key=lambda one: places.get(one["address"].partition("/")[0], -1))
        return Built(self.builder, self.problems, skipped, self.made, self.records, self.values)

    def _tell(self, address: str, message: str) -> None:
        self.problems.append({"address": address, "message": message})

    def _visit(self, first: str) -> None:
        """Make a thing, after those that it needs; without recursion, since chains may be long."""
        waiting = [first]
        while waiting:
            id = waiting[-1]
            if self.state.get(id) in ("made", "left out"):
                waiting.pop()
                continue
            needs = [one for one in self.needs[id].values() if one is not None]
            first_visit = id not in self.state
            self.state[id] = "open"
            open_ = [one for one in needs if one not in self.state]
            if first_visit and open_:
                waiting += reversed(open_)
                continue
            waiting.pop()
            if any(self.state[one] == "left out" for one in needs):
                self.state[id] = "left out"
            else:
                self.state[id] = "made" if self._make(self.document.by_id[id]) else "left out"

    def _make(self, thing: dict[str, Any]) -> bool:
        """Make the call of a thing; whether that went well."""
        call, id = call_of(thing), thing["id"]
        if call is None:
            self._tell(id, f"'{clean(thing['call'])}' is no call of this version.")
            return False
        before = len(self.problems)
        args = self.arguments.of(call, thing, self._tell)
        if len(self.problems) > before:
            return False
        nodes, members, calls = map(len, (self.builder.nodes, self.builder.members, self.builder.calls))
        trial = self.builder.copy() if call.kind == "block" else self.builder
        try:
            self._call(trial, call, thing, args)
        except (ValueError, TypeError, ImportError, OSError, ArithmeticError) as fault:
            self._tell(self._address_of(call, thing, str(fault)), _sentence(fault))
            self._withdraw(nodes, members)
            return False
        self.builder = trial
        self.made[id] = self.builder.calls[calls:]
        return True

    def _withdraw(self, nodes: int, members: int) -> None:
        """Take back what a call that failed has added."""
        for kept, contents in ((nodes, self.builder.nodes), (members, self.builder.members)):
            for name in list(contents)[kept:]:
                del contents[name]

    def _call(self, builder: Builder, call: Call, thing: dict[str, Any], args: dict[str, Any]) -> None:
        name, id = thing.get("name"), thing["id"]
        by_place, by_name = arranged(call, name, args)
        if call.kind == "constant":
            self.records[id] = call.function
        elif call.kind == "record":
            made = call.function(**by_name)
            check_record(f"{call.makes} '{name}'", made)
            self.records[id] = made
        elif call.kind == "element":
            builder.add(call.function, *by_place, **by_name)
        elif call.kind == "block":
            call.function(builder, **by_name)
        else:
            getattr(builder, call.name)(*by_place, **by_name)

    def _address_of(self, call: Call, thing: dict[str, Any], message: str) -> str:
        """The field that a message of the Builder is about, as far as that can be told."""
        id = thing["id"]
        unknown = [address for address, of in self.needs[id].items() if of is None]
        if unknown:
            return f"{id}/{unknown[0]}"
        quoted = [key for key in call.fields if re.search(rf"['`\"]{key}['`\"]|\b{key} = |\b{key} must\b", message)]
        # Names of things say nothing of fields.
        plain = re.sub(r"'[^']*'", "", message)
        found = {
            key: re.search(rf"\b({SAID.get(field['kind'], '$')}|{key.rstrip('s')})", plain, re.IGNORECASE)
            for key, field in call.fields.items()
        }
        places = {key: match.start() for key, match in found.items() if match}
        words = sorted(places, key=lambda key: places[key])
        given = thing["args"]
        said = [key for key in quoted if key in given] or [key for key in words if key in given] or quoted
        return f"{id}/{said[0]}" if said else id


def _sentence(fault: Exception) -> str:
    return str(fault) or type(fault).__name__


def _article(field: dict[str, Any]) -> str:
    word = field["name"].replace("_", " ")
    return f"its {word}"


def _words(address: str, value: Any) -> list[str | int]:
    """Components, written with blanks or commas between them."""
    texts = value if isinstance(value, list) else re.split(r"[\s,]+", value)
    if any(not isinstance(text, str) for text in texts):
        raise _Fault(address, "Components are written one after the other, such as 'x y'.")
    return [int(text) if text.isascii() and text.isdecimal() else text for text in texts if text]
