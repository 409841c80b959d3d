"""The calls of a Builder as things of a document, with names, words and numbers instead of Python values."""

import dataclasses
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..build.calls import MadeCall
from ..build.description import Description
from ..build.properties import element_type
from ..build.step import body_of_step
from ..elements.element import Element
from ..elements.general import General
from ..errors import printable
from .fields import ENDS_IN_WORDS, Call, calls

# Entries of a symmetric matrix in the order of the Builder.
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


class NumberPlace(int):
    """Index of a number whose text is found later."""


class Calls:
    """The calls of one Builder.

    Attributes:
        things: Calls with their arguments; a :class:`NumberPlace` instead of each number.
        numbers: Numbers, traced if the Builder is traced.
        left_out: What a document cannot contain, in words.
    """

    def __init__(
        self,
        builder: Description,
        chosen_calls: Iterable[MadeCall] | None = None,
        name_of: Callable[[Any], str | None] = lambda record: None,
    ):
        """Convert some calls, or all; ``name_of(record)`` is the name of a section or material in the document."""
        self.builder, self._name_of = builder, name_of
        self.things: list[dict[str, Any]] = []
        self.numbers: list[Any] = []
        self.left_out: list[str] = []
        self._records: list[tuple[Any, str]] = []
        # Values of an element so far, by call, element and set of loads.
        self._rows: dict[tuple, dict[int, Any]] = {}
        self._elements = {call.function: call for call in calls().values() if call.kind == "element"}
        for call in builder.calls if chosen_calls is None else chosen_calls:
            bound = inspect.signature(getattr(builder, call.method)).bind(*call.positional, **call.keywords)
            (self._element if call.method == "add" else self._method)(call.method, dict(bound.arguments))

    def filled(self, texts: list[str]) -> list[dict[str, Any]]:
        """The things with a text instead of each number."""

        def filled(value: Any) -> Any:
            if isinstance(value, NumberPlace):
                return texts[value]
            if isinstance(value, list):
                return list(map(filled, value))
            return {key: filled(content) for key, content in value.items()} if isinstance(value, dict) else value

        return list(map(filled, self.things))

    def _add(self, call: str, args: dict[str, Any], name: Any = None) -> None:
        item: dict[str, Any] = {"call": call, "args": args}
        self.things.append(item if name is None else {**item, "name": str(name)})

    def _number(self, value: Any) -> NumberPlace:
        self.numbers.append(value)
        return NumberPlace(len(self.numbers) - 1)

    def _method(self, method: str, args: dict[str, Any]) -> None:
        call, name = calls()[method], args.pop("name", None)
        about = next((args[key] for key in ("node", "of", "element") if key in args), name)
        subject = f"{method} of '{printable(about)}'"
        if args.get("step") is not None:
            step, material, at = (args.pop(key, None) for key in ("step", "material", "at"))
            body = body_of_step(subject, step, material, at, self.builder.dimension or 2)
            args |= dict(zip(("mass", "center", "inertia"), body, strict=True))
        if method in ("prestress", "strain"):
            args["values"] = self._row(method, args)
        self._add(method, self._arguments(subject, call, args), name)

    def _row(self, method: str, args: dict[str, Any]) -> list[Any]:
        """Values of an element from its first deformation on, with the values of former calls."""
        element = self.builder.members[str(args["element"])].element
        named = {element.number_of(name) or 0: value for name, value in args.pop("named", {}).items()}
        row = self._rows.setdefault((method, str(args["element"]), bool(args.get("increment"))), {})
        row |= dict(enumerate(args.get("values", ()), 1)) | named
        return [row.get(number, 0.0) for number in range(1, max(row) + 1)]

    def _element(self, _: str, arguments: dict[str, Any]) -> None:
        element, name = element_type(arguments["element"]), arguments["name"]
        call = self._elements.get(element.usual)
        if call is None:
            what = f"its type '{printable(element.name)}' is a user-defined function"
            self.left_out.append(f"element '{printable(name)}': {what}")
            return
        member = self.builder.members[name]
        args: dict[str, Any] = {"nodes": shortest(element, [n for n in member.nodes if n != f"{name}.internal"])}
        options = {option: value for option, _, value in element.chosen}
        values = options | arguments.get("properties", {}) | {"released": arguments.get("released")}
        self._add(call.name, args | self._arguments(f"element '{printable(name)}'", call, values), name)

    def _arguments(self, subject: str, call: Call, values: Mapping[str, Any]) -> dict[str, Any]:
        """Arguments as contents of fields, without defaults."""
        contents: dict[str, Any] = {}
        for name, value in values.items():
            field = call.fields.get(name)
            if value is None or _is_default(value, _default(call, name)):
                continue
            if field is None:
                self.left_out.append(f"{subject}: {name} = {printable(value)}, for which there is no field")
            elif (content := self._value(f"{subject}: {name}", field, value)) not in (None, ""):
                contents[name] = content
        return contents

    def _value(self, subject: str, field: dict[str, Any], value: Any) -> Any:
        """Content of a field; None, and reported, if no field can contain the value."""
        kind = field["kind"]
        if kind in ("section", "material", "damping"):
            return self._record(subject, kind, value)
        if kind == "weights":
            return [[str(part), self._number(factor)] for part, factor in value.items()]
        if kind in ("components", "deformations"):
            several = [value] if isinstance(value, str) or np.ndim(value) == 0 else value
            return " ".join(map(str, several)) or ("none" if field["name"] == "released" else "")
        if kind in ("node", "of", "element"):
            return str(value)
        if set(field["choices"] or ()) == set(ENDS_IN_WORDS):
            flags = [value] * 2 if isinstance(value, bool) else value
            return next(word for word, pair in ENDS_IN_WORDS.items() if pair == tuple(map(bool, flags)))
        if isinstance(value, bool | np.bool_):
            return "true" if value else "false"
        if isinstance(value, str):
            return value
        if field["whole"] and isinstance(value, int):
            return str(value)
        if field["name"] == "inertia" and _depth(value) == 2:
            value = [value[i][j] for i, j in UPPER]
        if field["name"] == "clamp" and len(value) == 2 and all(entry is not None for entry in value):
            value = [number for root in value for number in root]
        if callable(value) or _depth(value) > 1 or (_depth(value) and any(entry is None for entry in value)):
            self.left_out.append(f"{subject} = {printable(value)}, which no field can contain")
            return None
        if _depth(value):
            return [self._number(value[i]) for i in range(len(value))]
        return [self._number(value)] if kind == "vector" else self._number(value)

    def _record(self, subject: str, kind: str, value: Any) -> str | None:
        """Name of a section, material or damping, which becomes a thing first."""
        known = next((name for record, name in self._records if record is value), None) or self._name_of(value)
        if known:
            return known
        constant = next((c for c in calls().values() if c.kind == "constant" and _same(c.function, value)), None)
        call = constant or calls().get(type(value).__name__)
        if call is None or (call.function is not type(value) and constant is None):
            why = "it varies along the element, by a function" if getattr(value, "varies", False) else "it is your own"
            self.left_out.append(f"{subject}: a document cannot contain this {type(value).__name__}, since {why}")
            return None
        fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)} if not constant else {}
        if isinstance(value, General):
            fields["stiffness"] = value.triangle()
        args = self._arguments(subject, call, fields)
        prefix, used_names = str(call.entry["name"] or kind), {name for _, name in self._records}
        numbered = (f"{prefix} {number}" for number in range(2, len(used_names) + 2))
        name = next(candidate for candidate in (prefix, *numbered) if candidate not in used_names)
        self._records.append((value, name))
        self._add(call.name, args, name)
        return name


def shortest(element: Element, nodes: list[str]) -> list[str]:
    """One name for each end of an element if its rotations and warpings follow from it; otherwise all names."""
    kinds = [kind.part for kind in element.nodes.values() if kind.part != "internal"]
    ends: list[tuple[str, set[str]]] = []
    for node, part in zip(nodes, kinds, strict=len(nodes) == len(kinds)):
        owner = node.removesuffix(f".{part}")
        if ends and ends[-1][0] == owner and part not in ends[-1][1]:
            ends[-1][1].add(part)
        elif ends and part not in ends[-1][1]:
            # The Builder would take the end before for this part too.
            return nodes
        else:
            ends.append((owner, {part}))
    return [owner for owner, _ in ends]


def _depth(value: Any) -> int:
    """Number of axes of nested sequences, whose numbers may be traced."""
    return 1 + _depth(value[0]) if isinstance(value, list | tuple) and value else np.ndim(value)


def _same(known: Any, value: Any) -> bool:
    """Whether a material is a constant of the package."""
    if known is value or type(known) is not type(value) or not is_concrete(value):
        return known is value
    return all(getattr(known, field.name) == getattr(value, field.name) for field in dataclasses.fields(known))


def _default(call: Call, name: str) -> Any:
    """Default of an argument."""
    if call.kind == "element":
        parameter = call.function.properties.get(name)
        return call.function.options.get(name) if parameter is None else parameter.default
    return getattr(inspect.signature(call.function).parameters.get(name), "default", None)


def _is_default(value: Any, default: Any) -> bool:
    if not is_concrete(value) or dataclasses.is_dataclass(value) or callable(value):
        return False
    if isinstance(value, str | bool) or isinstance(default, str | bool):
        return type(value) is type(default) and value == default
    try:
        return default is not None and np.array_equal(np.asarray(value, float), np.asarray(default, float))
    except (TypeError, ValueError):
        return False
